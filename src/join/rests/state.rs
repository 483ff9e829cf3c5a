//! What the fit estimates, the prediction of one reading with its derivatives, and the priors.

use super::play::{Play, Stand};
use crate::join::fit::Estimated;
use crate::join::frame::Frame;
use crate::join::placement::{COMMON, NO_GAP, Placement, Row, of_gaps};
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Prior of the friction that fades after a reversal, rad or m, for each pace of fading; the paces, s. Sums of them follow other paces.
pub const FRICTION: f64 = 2e-4;
/// The same of a fit without friction.
pub const NO_FRICTION: f64 = 1e-9;
const FADES_S: [f64; 3] = [0.5, 2.0, 8.0];
/// Prior of the drift. Quartz keeps time within 100 ppm, and a computer that follows a time server may be pulled by 500 ppm.
const DRIFT: f64 = 300e-6;
/// Rounds after which steps are taken in part.
const STEADY: usize = 10;

/// What is estimated.
pub struct State {
    placement: Placement,
    zero: Vec<f64>,
    gap: Vec<f64>,
    /// Where a joint stands in its gap before its first contact, from its first command.
    begin: Vec<f64>,
    /// What it lags behind its gap after a reversal, by how fast that fades.
    friction: Vec<[f64; FADES_S.len()]>,
    /// Standard deviation of its prior, rad or m.
    friction_prior: f64,
}

/// What a joint has lost.
struct Lost {
    /// Off its command, rad or m.
    lost: f64,
    /// -1 after a positive movement, 1 after a negative one, 0 before the first contact.
    side: f64,
    /// Shares of the friction that fades.
    fading: [f64; FADES_S.len()],
    /// It crosses its gap, is held by friction, or has not moved yet.
    stands: bool,
}

impl State {
    /// At the start: the frame as it is, the rest at zero. `friction_prior`: standard deviation of the prior of friction, rad or m.
    pub fn begin(frame: Frame, n: usize, start_s: f64, friction_prior: f64) -> Self {
        Self {
            placement: Placement::begin(&frame, start_s),
            zero: vec![0.0; n],
            gap: vec![0.0; n],
            begin: vec![0.0; n],
            friction: vec![[0.0; FADES_S.len()]; n],
            friction_prior,
        }
    }

    /// What a joint has lost at a command, at the controller's time `u`.
    fn lost(&self, axis: usize, play: &Play, stand: Stand, command: f64, u: f64) -> Lost {
        let gap = self.gap[axis];
        let side = -f64::from(stand.side);
        let by_gap = match stand.side {
            0 => play.first() + self.begin[axis] - command,
            _ if gap > NO_GAP => stand.at - command,
            _ => side * gap,
        };
        let left = FADES_S.map(|decay_s| (-(u - stand.since_s) / decay_s).exp());
        let friction: f64 = left.iter().zip(&self.friction[axis]).map(|(left, f)| left * f).sum();
        // friction holds the joint until its drive has moved as far, and never pulls it back
        let moved = (stand.at - stand.from).abs();
        let held = stand.side != 0 && moved < friction;
        let fading = if held { [0.0; FADES_S.len()] } else { left.map(|left| side * left) };
        let stands = held || stand.side == 0 || (stand.at - command).abs() < gap - NO_GAP;
        Lost { lost: by_gap + side * friction.min(moved), side, fading, stands }
    }
}

impl Estimated for State {
    type Play = Play;
    const BY_PRIORS: bool = true;

    fn clock(&self) -> [f64; 3] {
        self.placement.clock()
    }

    /// Sides of a gap that flip at single rows throw the estimate to and fro: later rounds take less of a step.
    fn share(round: usize) -> f64 {
        (STEADY as f64 / round.max(STEADY) as f64).powi(2)
    }

    fn plays(&self, commands: &Series) -> Vec<Play> {
        let of = |(axis, (gap, begin)): (usize, (&f64, &f64))| Play::of(commands, axis, gap.max(NO_GAP), *begin);
        self.gap.iter().zip(&self.begin).enumerate().map(of).collect()
    }

    fn row(&self, robot: &Robot, commands: &Series, plays: &[Play], t: f64, at: &Vector3<f64>) -> Option<Row> {
        let n = commands.channels();
        let (mut q, mut rate) = (vec![0.0; n], vec![0.0; n]);
        let u = self.placement.controller_s(t);
        if !commands.at(u, &mut q, &mut rate) {
            return None;
        }
        let mut joints = Vec::with_capacity(n);
        for axis in 0..n {
            let joint = self.lost(axis, &plays[axis], plays[axis].at(commands, axis, u)?, q[axis], u);
            if joint.stands {
                rate[axis] = 0.0;
            }
            q[axis] += self.zero[axis] + joint.lost;
            joints.push(joint);
        }
        let (mut row, levers) = self.placement.row(robot, &q, &rate, t, at);
        let columns = &mut row.columns;
        columns.extend_from_slice(&levers);
        columns.extend(levers.iter().zip(&joints).map(|(c, j)| c * j.side));
        columns.extend(levers.iter().zip(&joints).map(|(c, j)| if j.side == 0.0 { *c } else { Vector3::zeros() }));
        columns.extend(levers.iter().zip(&joints).flat_map(|(c, j)| j.fading.map(|share| c * share)));
        Some(row)
    }

    fn moved(&mut self, step: &[f64]) {
        let n = self.zero.len();
        self.placement.moved(step);
        for axis in 0..n {
            self.zero[axis] += step[COMMON + axis];
            self.gap[axis] += step[COMMON + n + axis];
            self.begin[axis] += step[COMMON + 2 * n + axis];
            for (k, friction) in self.friction[axis].iter_mut().enumerate() {
                *friction += step[COMMON + (3 * n + axis * FADES_S.len()) + k];
            }
        }
    }

    fn priors(&self) -> Vec<(f64, f64)> {
        let drift = (self.placement.drift, DRIFT.powi(-2));
        let friction = self.friction.iter().flatten().map(|v| (*v, self.friction_prior.powi(-2)));
        let mut all = self.placement.priors(drift, &self.zero, &self.gap);
        all.extend(of_gaps(&self.begin).chain(friction));
        all
    }
}
