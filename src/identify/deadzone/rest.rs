//! Algorithm 1 of Cursi (2022) against noise: where the tip is stationary although the motor moves.
//!
//! As printed, a deadzone begins at the first row at which the tip is slower than a threshold while the motor is not, and
//! ends at the first row at which it is faster ([`super::printed`]). One noisy row ends it too early and begins the next:
//! noise shatters a deadzone into many. Here the same question is asked once per stroke (from one turn of the motor to the
//! next) and of a place instead of a speed: has the tip left the place at which it stopped? A deadzone
//! - begins at a turn of the motor at which the tip was moving: the joint then stands at the edge of its gap;
//! - goes on through further turns while the tip stays within the rest radius of where it stopped;
//! - ends in the stroke in which the tip leaves: after the last row within the radius. Leaving on the side from which
//!   it came says nothing of the size; a motor that goes a little beyond its turn makes a new one.
//!
//! One stroke holds one deadzone at most, whatever the noise. The rest radius is five standard deviations of the noise; a
//! stroke that ends between one and two radii away is not decided and sizes nothing, nor does the turn after it.
//!
//! What is found is where to look; the size comes from [`super::edge`].

use super::motion::Stretch;
use nalgebra::Vector3;

/// Rest radius in standard deviations of one coordinate.
pub const RADIUS: f64 = 5.0;
/// Smallest rest radius: a log's last digits, m.
pub const LEAST_RADIUS_M: f64 = 1e-6;
/// Rows after a turn that give the place of the tip there.
const BESIDE: usize = 2;
/// The tip must go so many radii beyond its rest for the branch after it to be read.
const READABLE: f64 = 4.0;

/// A deadzone that was crossed: the motor turned at `turn` and left the deadzone in stroke `stroke`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Turn at which the tip stopped, by its number in the stretch.
    pub turn: usize,
    /// Stroke in which the tip left; stroke `k` lies before turn `k`.
    pub stroke: usize,
    /// Travel of the motor from the turn to the last row within the radius, and to the next row: brackets the edge.
    pub travel: [f64; 2],
    /// Row of the stretch from which on the joint was engaged in the stroke before the turn.
    pub engaged_from: usize,
    /// Row from which on the tip was seen to move again.
    pub left_at: usize,
}

/// What became of every turn.
#[derive(Debug, Clone, Default)]
pub struct Rests {
    pub crossed: Vec<Rest>,
    /// Turns after which the deadzone was not crossed before the motor went back the way it came.
    pub not_crossed: usize,
    /// Turns after which the tip moved too little to be read.
    pub too_short: usize,
    /// Turns without enough rows of the tracker.
    pub unseen: usize,
}

impl Rests {
    /// Turns at which the tip rested already: small strokes inside the gap.
    pub fn inside(&self, turns: usize) -> usize {
        turns.saturating_sub(self.crossed.len() + self.not_crossed + self.too_short + self.unseen)
    }
}

/// Reads a stretch with a rest radius in m.
pub fn find(s: &Stretch, radius_m: f64) -> Rests {
    let mut out = Rests::default();
    // turn at which the tip stopped at the edge of the gap, and the row from which its stroke was engaged
    let mut edge: Option<(usize, usize)> = None;
    // where the tip is stationary, and whether it has not yet followed a turn
    let mut rest = beside(s, s.stroke_s(0)[0]);
    for k in 0..=s.turns.len() {
        let [from_s, to_s] = s.stroke_s(k);
        let dir = if k == 0 { s.turns.first().map_or(0.0, |t| -t.dir) } else { s.turns[k - 1].dir };
        let (Some(start), Some(end)) = (rest, beside(s, to_s)) else {
            out.unseen += usize::from(edge.is_some());
            (edge, rest) = (None, beside(s, to_s));
            continue;
        };
        let away = (end - start).norm();
        let rows = s.rows(from_s, to_s);
        if away <= radius_m {
            // it is still stationary; a motor that went beyond its turn has taken the joint along, however little
            if let (Some((turn, _)), Some(here)) = (edge, s.turns.get(k))
                && s.turns[turn].dir * (here.p - s.turns[turn].p) < 0.0
            {
                let beyond = |i: &usize| s.turns[turn].dir * (s.p[*i] - s.turns[turn].p) < 0.0;
                (edge, rest) = (Some((k, rows.clone().find(beyond).unwrap_or(rows.end))), Some(end));
            }
            continue;
        }
        // the last row within the radius, and the next one seen
        let seen = |i: usize| s.tip[i].map(|p| (p - start).norm());
        let last_in = rows.clone().rev().find(|&i| seen(i).is_some_and(|d| d <= radius_m));
        let left_at = last_in.map_or(rows.start, |i| i + 1);
        let left_at = (left_at..rows.end).find(|&i| seen(i).is_some()).unwrap_or(left_at);
        let decided = away > 2.0 * radius_m;
        if let Some((turn, engaged_from)) = edge.take() {
            let at = s.turns[turn];
            if !decided {
                out.too_short += 1;
            } else if dir != at.dir {
                out.not_crossed += 1;
            } else if away < READABLE * radius_m {
                out.too_short += 1;
            } else {
                let travel = |i: usize| at.dir * (s.p[i.min(s.p.len() - 1)] - at.p);
                let last_in = last_in.map_or(0.0, travel).max(0.0);
                let travel = [last_in, travel(left_at).max(last_in)];
                out.crossed.push(Rest { turn, stroke: k, travel, engaged_from, left_at });
            }
        }
        if k < s.turns.len() {
            if decided {
                edge = Some((k, left_at));
            }
            rest = Some(end);
        }
    }
    out.not_crossed += usize::from(edge.is_some());
    out
}

/// Place at which the tip stopped: the mean of the first rows after a turn, where it is stationary if there is a gap at all; at
/// the end of a log, of the last rows.
fn beside(s: &Stretch, t_s: f64) -> Option<Vector3<f64>> {
    let at = s.t_s.partition_point(|t| *t < t_s);
    let after = s.tip.iter().skip(at).take(2 * BESIDE).flatten().take(BESIDE);
    let mut near: Vec<Vector3<f64>> = after.copied().collect();
    if near.is_empty() {
        near.extend(s.tip[..at].iter().rev().take(2 * BESIDE).flatten().take(BESIDE));
    }
    (!near.is_empty()).then(|| near.iter().sum::<Vector3<f64>>() / near.len() as f64)
}
