//! Stretches of a log in which one joint moves alone, with its turning points.
//!
//! Method: row by row, the joint that moves owns the stretch; another one's movement ends it. Turning points are those of
//! [`Track`]; where one lies between two rows it is estimated ([`turns::between_rows`]). A movement up to the dead band is
//! noise of the command: 1.5 last digits of its column, or five times the scatter that its third differences show (an
//! encoder instead of a command), whichever is larger.
//!
//! Assumption: a command that is sampled often enough that a stroke has several rows.

use crate::effects::Track;
use crate::log::Log;
use crate::machine::turns;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Last digits of a column up to which a movement is rounding.
const DIGITS: f64 = 1.5;
/// Standard deviations of a noisy command up to which a movement is noise.
const NOISY: f64 = 5.0;
/// Distance of a gross error of the tracker, in standard deviations of one coordinate: a normal sample loses 1 row of 1e6.
const GROSS: f64 = 8.0;
/// Root of the sum of the squared weights of a third difference (1, -3, 3, -1).
const THIRD: f64 = 4.472_135_955;
/// Decimals of a command column whose number is not known.
const DECIMALS: u8 = 6;

/// A turning point: the joint leaves `p` at `t_s` in direction `dir`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    pub t_s: f64,
    pub p: f64,
    pub dir: f64,
}

/// One joint moving alone; values are s, rad or m, and m.
#[derive(Debug, Clone)]
pub struct Stretch {
    pub log: usize,
    pub axis: usize,
    /// First row in the log.
    pub first: usize,
    pub t_s: Vec<f64>,
    pub p: Vec<f64>,
    pub tip: Vec<Option<Vector3<f64>>>,
    pub turns: Vec<Turning>,
    /// Command of all axes at the first row: the pose at which the others are stationary.
    pub pose: Vec<f64>,
}

impl Stretch {
    /// Rows after `from` up to `to` in time, both included.
    pub fn rows(&self, from_s: f64, to_s: f64) -> std::ops::Range<usize> {
        self.t_s.partition_point(|t| *t < from_s)..self.t_s.partition_point(|t| *t <= to_s)
    }

    /// Rows without gross errors of the tracker, and how many those were: a row is one where it lies farther from the median
    /// of its neighbours (two on either side, coordinate by coordinate) than [`GROSS`] standard deviations and the way between them.
    /// A motion that goes one way is its own median; so it loses nothing.
    pub fn without_outliers(&self, noise_m: f64) -> (Self, usize) {
        let mut clean = self.clone();
        let mut dropped = 0;
        for (i, tip) in self.tip.iter().enumerate() {
            let Some(p) = tip else { continue };
            let around = i.saturating_sub(2)..(i + 3).min(self.tip.len());
            let near: Vec<Vector3<f64>> = around.filter(|&k| k != i).filter_map(|k| self.tip[k]).collect();
            if near.len() < 3 {
                continue;
            }
            let (mut middle, mut way) = (Vector3::zeros(), Vector3::zeros());
            for c in 0..3 {
                let mut values: Vec<f64> = near.iter().map(|v| v[c]).collect();
                middle[c] = median_of(&mut values).unwrap_or(0.0);
                // of the inner two: a second glitch among four neighbours does not hide the first
                way[c] = values[values.len() - 2] - values[1];
            }
            if (p - middle).norm() > GROSS * noise_m + 2.0 * way.norm() {
                clean.tip[i] = None;
                dropped += 1;
            }
        }
        (clean, dropped)
    }

    /// Times at which strokes begin and end: the start, the turns, the end.
    pub fn stroke_s(&self, k: usize) -> [f64; 2] {
        let turn = |i: usize| self.turns.get(i).map(|t| t.t_s);
        let first = self.t_s.first().copied().unwrap_or(0.0);
        let last = self.t_s.last().copied().unwrap_or(0.0);
        [if k == 0 { first } else { turn(k - 1).unwrap_or(last) }, turn(k).unwrap_or(last)]
    }
}

/// What a log holds for this job.
#[derive(Debug, Clone, Default)]
pub struct Motions {
    pub stretches: Vec<Stretch>,
    /// Rows at which two or more joints moved.
    pub together: usize,
    /// Rows at which some joint moved.
    pub moving: usize,
    /// Axes that moved together, in the robot's order.
    pub mixed: Vec<usize>,
}

/// Movement that is noise of a command column, rad or m.
pub fn deadband(log: &Log, robot: &Robot, axis: usize, chosen: Option<f64>) -> f64 {
    if let Some(v) = chosen {
        return v;
    }
    let decimals = log.cmd_decimals.get(axis).copied().unwrap_or(DECIMALS);
    let digits = DIGITS * 10f64.powi(-i32::from(decimals)) * robot.axis(axis).kind.si_per_user_unit();
    // rows at rest would hide the scatter of those that move
    let c = &log.cmd[axis];
    let mut third: Vec<f64> =
        c.windows(4).filter(|w| w[0] != w[3]).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
    let scatter = SIGMA_PER_MAD * median_of(&mut third).unwrap_or(0.0) / THIRD;
    digits.max(NOISY * scatter)
}

/// Stretches of one log. `deadband` has one value per axis, rad or m.
pub fn stretches(log: &Log, index: usize, deadband: &[f64]) -> Motions {
    let n = log.len();
    let axes = log.cmd.len();
    let mut out = Motions::default();
    let mut mixed = vec![false; axes];
    // where each axis was last seen to have moved: a slow joint moves by less than the dead band from row to row
    let mut stood: Vec<f64> = log.command(0);
    let (mut owner, mut first): (Option<usize>, usize) = (None, 0);
    let mut close = |owner: Option<usize>, first: usize, last: usize| {
        if let Some(axis) = owner
            && last > first + 4
            && !log.tcp_m.is_empty()
        {
            out.stretches.push(stretch(log, index, axis, first..last + 1, deadband[axis]));
        }
    };
    let (mut together, mut moving) = (0, 0);
    let mut still = 0;
    for i in 1..n {
        let moved: Vec<usize> = (0..axes).filter(|&a| (log.cmd[a][i] - stood[a]).abs() > deadband[a]).collect();
        for &a in &moved {
            stood[a] = log.cmd[a][i];
        }
        moving += usize::from(!moved.is_empty());
        match moved.as_slice() {
            [] => continue,
            [one] if owner == Some(*one) => still = i,
            [one] => {
                close(owner, first, still.max(first));
                // the rows at rest before the first movement belong to it
                (owner, first) = (Some(*one), if owner.is_none() { first } else { still });
                still = i;
            }
            several => {
                together += 1;
                several.iter().for_each(|&a| mixed[a] = true);
                close(owner, first, still);
                (owner, first) = (None, i);
                still = i;
            }
        }
    }
    close(owner, first, n.saturating_sub(1));
    (out.together, out.moving) = (together, moving);
    out.mixed = (0..axes).filter(|&a| mixed[a]).collect();
    out
}

fn stretch(log: &Log, index: usize, axis: usize, rows: std::ops::Range<usize>, deadband: f64) -> Stretch {
    let t_s = log.t_s[rows.clone()].to_vec();
    let p = log.cmd[axis][rows.clone()].to_vec();
    let between = turns::between_rows(&t_s, &p, deadband);
    let turns = Track::new(&t_s, &p, deadband)
        .turns
        .iter()
        .map(|t| {
            let near = between.iter().find(|b| b.0 == t.index || b.0 + 1 == t.index);
            let (t_s, p) = near.map_or((t.t_s, t.p), |b| (b.1, b.2));
            Turning { t_s, p, dir: f64::from(t.dir) }
        })
        .collect();
    Stretch {
        log: index,
        axis,
        first: rows.start,
        tip: log.tcp_m[rows.clone()].to_vec(),
        pose: log.command(rows.start),
        t_s,
        p,
        turns,
    }
}
