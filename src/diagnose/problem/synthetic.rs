//! A problem made of commands alone: what would be measured is what a hypothesis predicts, without noise.
//!
//! For planning: before an experiment is run, the same engine that will diagnose its log tells what the log could say.
//! [`problem`] prepares the commands once; [`measure`] fills in the measurements of any truth, so that the residual of that
//! truth is zero and the cost of a refitted alternative is the non-centrality of the comparison.
//!
//! Assumptions: no outliers, no lost rows; the frame of the model, or the base frame where it is to be estimated.

use crate::diagnose::problem::forward::{Hypothesis, LogData, Problem};
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::log::Log;
use crate::machine::CommandTrajectory;
use crate::model::Model;
use nalgebra::{Isometry3, Vector3};
use std::sync::OnceLock;

/// Rows beyond which a log is averaged over blocks, as it is for a diagnosis.
const MOST_ROWS: usize = 12_000;

/// Commands of one run of a program.
#[derive(Debug, Clone)]
pub struct Run {
    /// Times of the rows, s, strictly rising.
    pub t_s: Vec<f64>,
    /// `cmd[axis][row]`, rad or m.
    pub cmd: Vec<Vec<f64>>,
    /// Carried at the flange; `None`: the log has no such column.
    pub payload_kg: Option<f64>,
}

/// What is measured besides the TCP.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Channels {
    /// The base is measured: the frame is known, whatever the model says.
    pub frame: bool,
    /// The further reflectors of the robot file.
    pub reflectors: bool,
    /// The motor side of every joint.
    pub motors: bool,
    /// Every joint after its gear.
    pub joints: bool,
}

/// A problem over runs, with the hypothesis of the model's known effects; measurements are zero until [`measure`].
pub fn problem(model: &Model, runs: Vec<Run>, channels: Channels) -> (Problem, Hypothesis) {
    let robot = &model.robot;
    let logs: Vec<LogData> = runs
        .into_iter()
        .enumerate()
        .map(|(k, run)| {
            let log = log_of(run, k, robot.reflectors_m.len(), channels);
            let block = log.len().div_ceil(MOST_ROWS).max(1);
            LogData {
                trajectory: CommandTrajectory::of_log(robot, &log),
                commands: None,
                fine: None,
                driven: Vec::new(),
                motors: vec![channels.motors; robot.dof()],
                frame: 0,
                block,
                left_out: Vec::new(),
                reading: None,
                orientation: None,
                jacobian: OnceLock::new(),
                tilts: OnceLock::new(),
                log,
            }
        })
        .collect();
    let mut groups: Vec<Group> = Vec::new();
    let mut offset = 0;
    for (l, log) in logs.iter().enumerate() {
        let axes = 0..robot.dof();
        let mut sensors: Vec<Sensor> = (0..log.reflectors()).map(Sensor::Reflector).collect();
        if channels.motors {
            sensors.extend(axes.clone().map(Sensor::Motor));
        }
        if channels.joints {
            sensors.extend(axes.map(Sensor::Joint));
        }
        for sensor in sensors {
            let rows = (0..log.log.len() as u32).collect();
            let group = Group::new(l, sensor, rows, log.block, offset, false);
            offset = group.range().end;
            groups.push(group);
        }
    }
    let problem = Problem {
        robot: robot.clone(),
        initial_gap_side: model.initial_gap_side.clone(),
        logs,
        groups,
        n: offset,
        frames_free: model.registration.is_none() && !channels.frame,
        points_free: false,
        notes: Vec::new(),
        determined: OnceLock::new(),
    };
    // what only joints measure has its own zero
    let zeros = vec![0.0; problem.groups.iter().filter(|g| g.dims == 1).count()];
    let points_m = vec![Vector3::zeros(); robot.reflectors_m.len()];
    let frames = vec![model.registration.unwrap_or_else(Isometry3::identity)];
    (problem, Hypothesis { effects: model.effects.clone(), frames, points_m, zeros })
}

fn log_of(run: Run, number: usize, reflectors: usize, channels: Channels) -> Log {
    let (rows, dof) = (run.t_s.len(), run.cmd.len());
    let sensed = |there: bool| -> Vec<Option<Vec<Option<f64>>>> {
        (0..dof).map(|_| there.then(|| vec![Some(0.0); rows])).collect()
    };
    Log {
        name: format!("planned run {}", number + 1),
        sha256: String::new(),
        line: (0..rows as u32).map(|r| r + 2).collect(),
        t_s: run.t_s,
        poses: false,
        cmd_decimals: vec![6; dof],
        cmd: run.cmd,
        tcp_m: vec![Some(Vector3::zeros()); rows],
        reflectors_m: vec![vec![Some(Vector3::zeros()); rows]; if channels.reflectors { reflectors } else { 0 }],
        lone_m: [const { None }; 3],
        enc: sensed(channels.motors),
        screw: vec![None; dof],
        meas: sensed(channels.joints),
        trigger: None,
        cycle: None,
        speed_m_s: None,
        payload_kg: run.payload_kg.map(|p| vec![Some(p); rows]),
        temp_c: None,
        instruments: crate::log::Instruments::default(),
    }
}

/// Fills every measurement with what `truth` predicts.
pub fn measure(problem: &mut Problem, truth: &Hypothesis) {
    let state = problem.evaluate(truth);
    for (log, s) in problem.logs.iter_mut().zip(state.logs) {
        let frame = truth.frames[log.frame];
        let seen = |points: &[Vector3<f64>]| -> Vec<Option<Vector3<f64>>> {
            points.iter().map(|p| Some(frame.transform_point(&(*p).into()).coords)).collect()
        };
        for (k, points) in s.points_m.iter().enumerate() {
            match k {
                0 => log.log.tcp_m = seen(points),
                _ => log.log.reflectors_m[k - 1] = seen(points),
            }
        }
        let sensors = log.log.enc.iter_mut().zip(s.servo.iter());
        for (column, values) in sensors.chain(log.log.meas.iter_mut().zip(s.joint.iter().map(AsRef::as_ref))) {
            if column.is_some() {
                *column = Some(values.iter().copied().map(Some).collect());
            }
        }
    }
}

#[cfg(test)]
pub(in crate::diagnose) mod tests {
    use super::*;
    use crate::effects::{Backlash, Effect, EffectInstance};
    use crate::robot::Robot;

    /// Three axes on a closed path; the hypothesis has a gap on two of them, as has the machine that was measured, which has
    /// a third one.
    pub(in crate::diagnose) fn closed_path_with_gaps() -> (Problem, Hypothesis) {
        let robot = Robot::load(std::path::Path::new("configs/gantry-xyz-ballscrew.yaml")).unwrap();
        let t_s: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.05).collect();
        let cmd = (0..3).map(|a| t_s.iter().map(|t| 0.05 * (t * (0.5 + 0.2 * f64::from(a))).sin()).collect()).collect();
        let run = Run { t_s, cmd, payload_kg: None };
        let (mut problem, mut h) = problem(&Model::ideal(robot), vec![run], Channels::default());
        let gap = |axis: usize, size: f64| EffectInstance::on_axis(axis, Effect::new(Backlash::constant(size)));
        h.effects.extend([gap(0, 3e-5), gap(1, 2e-5)]);
        let mut truth = h.clone();
        truth.effects.push(gap(2, 4e-5));
        measure(&mut problem, &truth);
        (problem, h)
    }

    #[test]
    fn the_truth_leaves_nothing_and_the_known_model_leaves_the_effect() {
        let robot = Robot::load(std::path::Path::new("configs/gantry-xyz-ballscrew.yaml")).unwrap();
        let model = Model::ideal(robot);
        let t_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.04).collect();
        let cmd = (0..3).map(|a| t_s.iter().map(|t| 0.05 * (t * (0.5 + 0.2 * f64::from(a))).sin()).collect()).collect();
        let channels = Channels { motors: true, joints: true, ..Channels::default() };
        let (mut problem, start) = problem(&model, vec![Run { t_s, cmd, payload_kg: None }], channels);
        let mut truth = start.clone();
        truth.effects.push(EffectInstance::on_axis(1, Effect::new(Backlash::constant(2e-5))));
        measure(&mut problem, &truth);
        let most = |h: &Hypothesis| problem.evaluate(h).residual.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(most(&truth) < 1e-12, "{}", most(&truth));
        assert!((most(&start) - 2e-5).abs() < 1e-9, "{}", most(&start));
    }
}
