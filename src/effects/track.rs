//! A joint's command over time, with its direction and its turning points.
//!
//! A direction is the sign of the last movement; a pause keeps it (Zhang (2023), note 2 of equation 16). A turn stands where
//! the command leaves its extreme: the last sample of a pause on the extreme, since the reversal begins when the joint
//! moves again. A movement of at most `deadband` against the direction is number noise and no reversal.
//!
//! It carries what else effects look at: which samples are rows of a log (others are turning points put between them),
//! how the command runs between samples, the commanded TCP speed, the length of one turn of the joint.

use crate::numerics::reversal::{Movement, ReversalDetector};
use std::borrow::Cow;

/// A reversal: the joint leaves `p` at `t_s` in direction `dir`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Sample at which the command still stands on its extreme.
    pub index: usize,
    /// Time of the reversal, s.
    pub t_s: f64,
    /// Command at the extreme, rad or m.
    pub p: f64,
    /// New direction, +1 or -1.
    pub dir: i8,
}

/// How the command runs between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// A smooth motion of which rows are known.
    Smooth,
    /// Straight: a program, of which every corner is a sample.
    Straight,
    /// Settled poses: the robot stands still at each, and what fades in time has faded.
    Settled,
}

/// Command of one joint, sampled: times in s, positions in rad or m.
#[derive(Debug, Clone)]
pub struct Track<'a> {
    /// Time of each sample, s.
    pub t_s: &'a [f64],
    /// Command at each sample, rad or m.
    pub p: &'a [f64],
    /// Direction of the movement that arrives at each sample: -1, +1, or 0 before the first movement.
    pub dir: Cow<'a, [i8]>,
    /// Reversals in order. The first movement is no reversal.
    pub turns: Cow<'a, [Turn]>,
    /// +1 or -1: the joint was brought to its start in that direction; 0: the play stands in the middle of its gap.
    pub initial_gap_side: i8,
    /// How the command runs between samples.
    pub between: Between,
    /// Samples that are rows, rising from the first sample; the others are estimates between them. `None`: all.
    pub rows: Option<&'a [u32]>,
    /// Commanded TCP speed at each sample, m/s; empty: at rest.
    pub tcp_speed_m_s: &'a [f64],
    /// Torque of gravity about the joint at each sample, Nm (N); empty: none is known.
    pub load: &'a [f64],
    /// The cubics of the command between its rows ([`super::servo_lag::cubics`]), where they have been computed; else empty.
    pub cubics: &'a [[f64; 3]],
    /// One turn of the joint: 2 pi rad, or the lead of a screw in m.
    pub rev: f64,
}

impl<'a> Track<'a> {
    /// Finds directions and turning points. `t_s` and `p` have one length.
    pub fn new(t_s: &'a [f64], p: &'a [f64], deadband: f64) -> Self {
        let n = p.len();
        let mut dir = vec![0i8; n];
        let mut turns = Vec::new();
        let mut detector = ReversalDetector::new(deadband, 0);
        for (i, &position) in p.iter().enumerate() {
            match detector.take(i, position) {
                Movement::Rest => {}
                Movement::Start { since } => dir[since + 1..=i].fill(detector.direction()),
                Movement::Same | Movement::Within => dir[i] = detector.direction(),
                Movement::Reversed { at, extreme } => {
                    turns.push(Turn { index: at, t_s: t_s[at], p: extreme, dir: detector.direction() });
                    dir[at + 1..=i].fill(detector.direction());
                }
            }
        }
        Self::known(t_s, p, dir, turns)
    }

    /// A track whose directions and turning points are known.
    pub fn known(
        t_s: &'a [f64],
        p: &'a [f64],
        dir: impl Into<Cow<'a, [i8]>>,
        turns: impl Into<Cow<'a, [Turn]>>,
    ) -> Self {
        Self {
            t_s,
            p,
            dir: dir.into(),
            turns: turns.into(),
            initial_gap_side: 0,
            between: Between::Smooth,
            rows: None,
            tcp_speed_m_s: &[],
            load: &[],
            cubics: &[],
            rev: std::f64::consts::TAU,
        }
    }

    /// The same track with the play at one side of its gap at the start.
    pub fn with_initial_gap_side(mut self, initial_gap_side: i8) -> Self {
        self.initial_gap_side = initial_gap_side.signum();
        self
    }

    /// Speed of the command at a sample, rad/s or m/s: the slope of the parabola through it and its neighbours.
    pub fn speed_at(&self, sample: usize) -> f64 {
        let step = |i: usize| {
            let seconds = self.t_s[i + 1] - self.t_s[i];
            if seconds > 0.0 { (self.p[i + 1] - self.p[i]) / seconds } else { 0.0 }
        };
        let seconds = |i: usize| self.t_s[i + 1] - self.t_s[i];
        // at an end, the parabola through the three samples there
        let end = |near: usize, next: usize| {
            let both = seconds(near) + seconds(next);
            let bend = if both > 0.0 { (step(next) - step(near)) * seconds(near) / both } else { 0.0 };
            step(near) - bend
        };
        match (sample, self.len()) {
            (_, 0 | 1) => 0.0,
            (_, 2) => step(0),
            (0, _) => end(0, 1),
            (last, n) if last + 1 == n => end(n - 2, n - 3),
            (i, _) => {
                let (h0, h1) = (self.t_s[i] - self.t_s[i - 1], self.t_s[i + 1] - self.t_s[i]);
                if h0 + h1 > 0.0 { (step(i - 1) * h1 + step(i) * h0) / (h0 + h1) } else { 0.0 }
            }
        }
    }

    /// Torque of gravity at a sample; 0 where none is known.
    pub fn load_at(&self, sample: usize) -> f64 {
        self.load.get(sample).copied().unwrap_or(0.0)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.p.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.p.is_empty()
    }

    /// Walks the samples after each turn: `(turn, range of samples after it up to the next turn)`.
    pub fn strokes(&self) -> impl Iterator<Item = (&Turn, std::ops::Range<usize>)> {
        self.turns.iter().enumerate().map(|(k, t)| {
            let end = self.turns.get(k + 1).map_or(self.len(), |n| n.index + 1);
            (t, t.index + 1..end)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(n: usize) -> Vec<f64> {
        (0..n).map(|i| i as f64).collect()
    }

    #[test]
    fn a_pause_keeps_the_direction_and_the_turn_is_where_the_pause_ends() {
        let p = [0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0];
        let t = times(p.len());
        let track = Track::new(&t, &p, 0.0);
        assert_eq!(track.dir[..], [0, 1, 1, 1, 1, -1, -1]);
        assert_eq!(track.turns[..], [Turn { index: 4, t_s: 4.0, p: 2.0, dir: -1 }]);
    }

    #[test]
    fn number_noise_within_the_deadband_is_no_reversal() {
        let p = [0.0, 1.0, 0.9999, 1.0, 2.0, 1.9999, 1.0];
        let t = times(p.len());
        let track = Track::new(&t, &p, 0.001);
        assert_eq!(track.turns.len(), 1);
        assert_eq!((track.turns[0].index, track.turns[0].p), (4, 2.0));
        assert_eq!(track.dir[..], [0, 1, 1, 1, 1, -1, -1]);
    }

    #[test]
    fn the_first_movement_is_no_reversal() {
        let p = [0.0, 0.0, -1.0, -2.0];
        let t = times(4);
        let track = Track::new(&t, &p, 0.0);
        assert!(track.turns.is_empty());
        assert_eq!(track.dir[..], [0, 0, -1, -1]);
    }
}
