//! Strokes of one joint: from turning point to turning point of its command, and how far each row is into its stroke.
//!
//! A command that was measured rather than commanded carries noise; a movement of fewer than [`NOISE`] of its standard deviations
//! (from third differences, which a smooth motion leaves near zero) is no reversal.

use crate::effects::Track;
use crate::log::Log;
use crate::machine::parts::slopes;
use crate::machine::trajectory::NO_MOVEMENT;
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use crate::robot::Robot;

/// Standard deviations of a noisy command that are no movement: more than noise reaches over a long log.
const NOISE: f64 = 10.0;
/// Variance of a third difference over that of a sample: 1 + 9 + 9 + 1.
const THIRD: f64 = 20.0;

/// What the command of an axis does, row by row; rad or m.
#[derive(Debug, Clone)]
pub struct Strokes {
    /// Stroke of each row, counted from 0 (the movement before the first reversal).
    pub stroke: Vec<usize>,
    /// Direction of each stroke; 0: the joint never moves.
    pub dir: Vec<i8>,
    /// Way of each stroke.
    pub length: Vec<f64>,
    /// Way since the stroke began.
    pub travel: Vec<f64>,
    /// Speed, per s; 0 for settled poses.
    pub speed: Vec<f64>,
}

impl Strokes {
    pub fn of(log: &Log, robot: &Robot, axis: usize) -> Self {
        let p = &log.cmd[axis];
        let third: Vec<f64> = p.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
        let sigma = median(&third) * SIGMA_PER_MAD / THIRD.sqrt();
        let quiet = (NO_MOVEMENT * robot.axis(axis).kind.si_per_user_unit()).max(NOISE * sigma);
        let track = Track::new(&log.t_s, p, quiet);
        let mut found = Self {
            stroke: vec![0; p.len()],
            dir: vec![track.dir.iter().copied().find(|d| *d != 0).unwrap_or(0)],
            length: Vec::new(),
            travel: vec![0.0; p.len()],
            speed: if log.poses { vec![0.0; p.len()] } else { slopes(&log.t_s, p) },
        };
        let (mut from, mut begins) = (0usize, p.first().copied().unwrap_or(0.0));
        let ends = track.turns.iter().map(|t| (t.index + 1, t.p, t.dir)).chain([(p.len(), f64::NAN, 0)]);
        for (k, (to, turn, dir)) in ends.enumerate() {
            let mut length = 0.0f64;
            for (i, at) in p.iter().enumerate().take(to).skip(from) {
                found.stroke[i] = k;
                found.travel[i] = (at - begins).abs();
                length = length.max(found.travel[i]);
            }
            found.length.push(length);
            if dir != 0 {
                found.dir.push(dir);
                (from, begins) = (to, turn);
            }
        }
        found
    }

    /// Longest stroke.
    pub fn longest(&self) -> f64 {
        self.length.iter().copied().fold(0.0, f64::max)
    }

    pub fn direction(&self, row: usize) -> i8 {
        self.dir[self.stroke[row]]
    }
}
