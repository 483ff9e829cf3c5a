//! What may be missing: every effect of the catalogue on every target, with the shapes of its nonlinear parameters.
//!
//! A [`Candidate`] is one effect on one target with its shape (decay, presliding, time constant) held: its sensitivities are
//! linear in what is left, so that all candidates can be compared by linear algebra; a refit frees the shape later. Each effect's
//! file says what is tried of it; here the logs are surveyed for it and the sensitivities are computed.
//! Ripple and vibration have a frequency instead of a list of shapes: [`crate::diagnose::candidates::spectrum`] finds it; a step of the
//! tracker has a time: [`crate::diagnose::candidates::steps`].
//!
//! Files beside:
//! - `basis`: groups of basis functions, of which the test without the catalogue is made
//! - `cache`: screening many times from much the same place: whitened sensitivities of the candidates, kept from one screening
//!   to the next
//! - `held`: functions over the measured torque of joints that are held, for the test without the catalogue
//! - `screen`: screening: what each candidate would explain of the whitened residual beyond the present effects and the frames
//! - `spectral`: candidates whose frequency or time is found in what is left
//! - `steps`: steps of the tracker's frame, where the level of what is left jumps
//! - `structure`: is there structure in the residual that no effect was asked for? A test without the catalogue

pub(crate) mod basis;
pub(crate) mod cache;
pub(crate) mod held;
pub(crate) mod screen;
pub(crate) mod sensitivities;
mod spectral;
pub(crate) mod spectrum;
pub(crate) mod steps;
pub(crate) mod structure;

use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::effects::candidate::AxisSurvey;
use crate::effects::{Family, Inputs, Survey, catalogue};
use crate::numerics::robust::{largest_size, range};

pub use crate::effects::Candidate;
pub use spectral::fading;

impl Candidate {
    /// Sensitivities, one per coefficient.
    pub fn columns(&self, problem: &Problem, h: &Hypothesis, state: &State) -> Vec<Vec<f64>> {
        let base = self.base.as_ref().map(|b| problem.difference(h, state, &[], b, 1.0));
        self.trial
            .iter()
            .enumerate()
            .map(|(k, (to, scale))| {
                let mut column = problem.difference(h, state, &[], to, *scale);
                if let Some(base) = &base {
                    for (c, b) in column.iter_mut().zip(base) {
                        *c -= b / scale;
                    }
                }
                if let Some(&log) = self.acts_in.get(k) {
                    problem.groups.iter().filter(|g| g.log != log).for_each(|g| column[g.range()].fill(0.0));
                }
                column
            })
            .collect()
    }
}

/// Is an effect one of the geometry?
pub(in crate::diagnose) fn is_geometry(effect: &str) -> bool {
    catalogue::find(effect).is_some_and(|e| e.family == Family::Geometry)
}

/// All candidates but ripple and vibration, in the order of the catalogue.
pub fn all(problem: &Problem) -> Vec<Candidate> {
    let survey = survey(problem);
    let mut list = Vec::new();
    for info in catalogue::ALL {
        (info.candidates)(&survey, &mut list);
    }
    list
}

/// What is tried besides, where many effects are fitted together: forms with more freedom and rarer effects.
pub fn further(problem: &Problem) -> Vec<Candidate> {
    let survey = survey(problem);
    let mut list = Vec::new();
    for info in catalogue::ALL {
        (info.special.further)(&survey, &mut list);
    }
    list
}

/// Forms of more freedom and rarer effects of one joint, as they are tried where its plain ones leave something.
pub fn wider(problem: &Problem, axis: usize) -> Vec<Candidate> {
    let survey = Survey { only: Some(axis), ..survey(problem) };
    let mut list = Vec::new();
    for info in catalogue::ALL {
        (info.special.further)(&survey, &mut list);
    }
    list.retain(|c| c.axis() == Some(axis));
    list
}

/// What the logs hold, as effects need it to say what may be tried.
pub fn survey(problem: &Problem) -> Survey<'_> {
    let axis = |axis: usize| AxisSurvey {
        travel: problem.logs.iter().map(|l| l.log.travel(axis)).fold(0.0, f64::max),
        range: range(problem.logs.iter().flat_map(|l| l.trajectory.command(axis).iter().copied())),
        loaded: problem.logs.iter().any(|l| l.trajectory.gravity_torque(axis).iter().any(|t| *t != 0.0)),
        load: largest_size(problem.logs.iter().flat_map(|l| l.trajectory.gravity_torque(axis).iter().copied())),
        pressed: problem
            .logs
            .iter()
            .filter_map(|l| l.trajectory.process_torque(axis))
            .any(|t| t.iter().any(|t| *t != 0.0)),
        fastest: largest_size(problem.motions().flat_map(|l| Inputs::speed(&l.trajectory, axis).iter().copied())),
        torque_measured: problem.logs.iter().any(|l| l.trajectory.measured_torque(axis).is_some()),
        torque: problem
            .logs
            .iter()
            .flat_map(|l| l.trajectory.measured_torque(axis).unwrap_or(l.trajectory.gravity_torque(axis)).iter())
            .fold([0.0, 0.0], |[a, b], t| [a.min(*t), b.max(*t)]),
    };
    let fastest = problem.logs.iter().flat_map(|l| l.trajectory.tcp_speed_m_s().iter().copied()).fold(0.0, f64::max);
    Survey {
        robot: &problem.robot,
        axes: (0..problem.robot.dof()).map(axis).collect(),
        clock: clock(problem),
        fastest_m_s: fastest.max(1e-6),
        points: problem.logs.iter().any(|l| l.reflectors() > 0),
        tracker: problem.logs.iter().any(|l| l.is_tracked()),
        frame_known: !problem.frames_free,
        motion: !problem.is_settled(),
        temperature: problem.logs.iter().any(|l| l.trajectory.temp_c().is_some()),
        only: None,
    }
}

/// Length of the shortest sample interval and of the longest log, s; `None` for poses alone.
pub fn clock(problem: &Problem) -> Option<(f64, f64)> {
    let (mut step, mut length) = (f64::INFINITY, 0.0_f64);
    for l in problem.motions().filter(|l| l.trajectory.rows() > 1) {
        let t = l.trajectory.t_s();
        let span = t[t.len() - 1] - t[0];
        step = step.min(span / (t.len() - 1) as f64);
        length = length.max(span);
    }
    (length > 0.0).then_some((step, length))
}

pub use crate::effects::vibration::swing as vibration;
