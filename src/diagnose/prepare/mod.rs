//! From model and logs to a [`Problem`]: groups of observations, frames, and samples that cannot be trusted.
//!
//! Frames: given by the model, or registered robustly on the path that the known model predicts; they stay free then.
//! Outliers: a single sample that disagrees with its two neighbours on either side by more than six standard deviations
//! of such disagreements is left out, but not beside a reversal, where spikes are what is looked for. Settled poses have
//! no neighbours: [`poses_without_outliers`] looks at what a fit leaves.
//!
//! Files beside:
//! - `orientation`: how the probe that measures the orientation sits on the tool
//! - `thin`: long logs: means over runs of rows, and the commands within a run for what remembers the way
//! - `sensors`: which channel drives the gears: the commands, or the encoders on the motors

mod orientation;
pub(crate) mod sensors;
mod thin;

use crate::diagnose::noise;
use crate::diagnose::note::{Note, OfInstrument};
use crate::diagnose::problem::fine::Fine;
use crate::diagnose::problem::forward::{Hypothesis, LogData, Problem, State};
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::diagnose::problem::orientation::{Orientation, points_m};
use crate::diagnose::problem::reading::Reading;
use crate::effects::{Inputs, without_columns};
use crate::error::{Error, Place, Result};
use crate::log::{Log, registration};
use crate::machine::CommandTrajectory;
use crate::machine::measurement::Instrument;
use crate::model::Model;
use crate::numerics::robust::{MEDIAN_DISTANCE, SIGMA_PER_MAD, median, median_of};
use nalgebra::{Isometry3, Rotation3, Vector3};
use std::sync::{Arc, OnceLock};

/// Disagreement with the neighbours, in standard deviations, beyond which a sample is an outlier.
const GROSS: f64 = 6.0;
/// Distance within which a sample counts as noise, in standard deviations of a coordinate.
const NEAR: f64 = 4.5;
/// The same beside a reversal, where a spike may stand.
const GROSS_AT_REVERSAL: f64 = 60.0;
/// Samples on either side of a reversal that count as beside it.
const BESIDE: usize = 3;
/// Pairs used for the first registration.
const PAIRS: usize = 3000;

/// Puts a problem together; the hypothesis holds the model's known effects.
pub fn problem(model: &Model, logs: &[Log]) -> Result<(Problem, Hypothesis)> {
    problem_of(model, logs, thin::whole)
}

/// The same with every log thinned to `most_rows`.
pub fn problem_of_at_most(model: &Model, logs: &[Log], most_rows: usize) -> Result<(Problem, Hypothesis)> {
    problem_of(model, logs, |model, log| (thin::to_at_most(model, log, most_rows), None))
}

fn problem_of(
    model: &Model,
    logs: &[Log],
    thinned: impl Fn(&Model, &Log) -> (Log, Option<Fine>),
) -> Result<(Problem, Hypothesis)> {
    let mut notes: Vec<Note> = model.robot.by_joints_alone().map(Note::JointsAlone).into_iter().collect();
    let sits = orientation::probe(model, logs, &mut notes);
    let log_data = |log: &Log| {
        let (log, fine) = thinned(model, log);
        log_data(model, log, fine, sits.as_ref())
    };
    let logs = logs.iter().map(log_data).collect::<Result<Vec<LogData>>>()?;
    let drives: Vec<&dyn Inputs> = logs.iter().map(|l| &l.trajectory as &dyn Inputs).collect();
    notes.extend(without_columns(&model.effects, &model.robot, &drives).into_iter().map(Note::Idle));
    let mut robot = model.robot.clone();
    if let Some(sits) = &sits {
        robot.reflectors_m = points_m(&robot, sits);
    }
    let mut problem = Problem {
        robot,
        initial_gap_side: model.initial_gap_side.clone(),
        logs,
        groups: Vec::new(),
        n: 0,
        frames_free: model.registration.is_none(),
        points_free: false,
        notes,
        determined: OnceLock::new(),
    };
    if !problem.logs.iter().any(LogData::is_tracked) {
        problem.frames_free = false;
    }
    problem.points_free = problem.frames_free && problem.is_settled();
    group(&mut problem);
    let points = problem.logs.iter().any(LogData::is_tracked);
    if problem.n == 0 && !encoders(&problem) {
        let name = logs_named(&problem);
        return Err(Error::bad(
            Place::file(name),
            "no measured column",
            "x_mm, y_mm, z_mm, or r_mm, r_um, dial_um, or meas_<joint>, or enc_<joint> beside the commands",
        ));
    }
    let mut h = Hypothesis {
        effects: model.effects.clone(),
        frames: vec![model.registration.unwrap_or_else(Isometry3::identity)],
        points_m: if points { vec![Vector3::zeros(); problem.robot.reflectors_m.len()] } else { Vec::new() },
        zeros: zeros(&problem),
    };
    if problem.frames_free {
        h.frames[0] = register(&problem, &h, None)?;
        separate_frames(&mut problem, &mut h);
    }
    choose_sensors(&mut problem, &mut h)?;
    Ok((problem, h))
}

/// A log as the problem holds it, before sensors and frames are chosen.
fn log_data(model: &Model, log: Log, fine: Option<Fine>, sits: Option<&Rotation3<f64>>) -> Result<LogData> {
    Ok(LogData {
        trajectory: match &fine {
            Some(fine) => fine.marked_as_means(CommandTrajectory::of_log(&model.robot, &log)),
            None => CommandTrajectory::of_log(&model.robot, &log),
        },
        commands: None,
        fine,
        driven: Vec::new(),
        motors: Vec::new(),
        frame: 0,
        block: 1,
        left_out: Vec::new(),
        reading: Reading::of(&model.robot, &log)?.map(Arc::new),
        orientation: sits.and_then(|sits| Orientation::of(&model.robot, &log, sits)).map(Arc::new),
        jacobian: OnceLock::new(),
        tilts: OnceLock::new(),
        log,
    })
}

/// Which encoders drive the model and which sensors are measurements; the frame again where encoders drive.
fn choose_sensors(problem: &mut Problem, h: &mut Hypothesis) -> Result<()> {
    sensors::choose(problem, h);
    group(problem);
    if problem.n == 0 {
        let notes: Vec<String> = problem.notes.iter().map(Note::to_string).collect();
        return Err(Error::bad(
            Place::file(logs_named(problem)),
            format!("encoders alone, and {}", notes.join("; ")),
            "x_mm, y_mm, z_mm, or r_mm, r_um, dial_um, or meas_<joint>",
        ));
    }
    h.zeros = zeros(problem);
    if problem.frames_free && h.frames.len() == 1 && problem.logs.iter().any(|l| l.driven.contains(&true)) {
        h.frames[0] = register(problem, h, None)?;
    }
    if problem.groups.iter().any(|g| matches!(g.sensor, Sensor::Joint(_))) {
        problem.notes.push(Note::SensorZeros);
    }
    for log in &problem.logs {
        let Some(reading) = &log.reading else { continue };
        let (log, instrument) = (log.log.name.clone(), estimated_of(reading.instrument()));
        problem.notes.push(Note::SingleReadings { log, instrument });
    }
    Ok(())
}

/// What is estimated of an instrument with one reading a row.
fn estimated_of(instrument: &Instrument) -> OfInstrument {
    match instrument {
        Instrument::Distance { centre_m } => OfInstrument::Ballbar { centre_m: (*centre_m).into() },
        _ => OfInstrument::Dial,
    }
}

fn encoders(problem: &Problem) -> bool {
    problem.logs.iter().any(|l| l.log.enc.iter().any(Option::is_some))
}

/// A zero for every joint sensor of every log, and the own quantities of ballbars and dials.
fn zeros(problem: &Problem) -> Vec<f64> {
    vec![0.0; problem.groups.iter().map(|g| problem.unknowns(g)).sum()]
}

fn logs_named(problem: &Problem) -> String {
    problem.logs.iter().map(|l| l.log.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Lays the groups out anew, without the samples that are left out.
pub fn group(problem: &mut Problem) {
    let mut groups = Vec::new();
    let mut offset = 0;
    for (l, log) in problem.logs.iter().enumerate() {
        let mut add = |sensor: Sensor, rows: Vec<u32>| {
            if !rows.is_empty() {
                let g = Group::new(l, sensor, rows, log.block, offset, log.log.poses);
                offset = g.range().end;
                groups.push(g);
            }
        };
        let rows = |there: &dyn Fn(usize) -> bool| (0..log.log.len()).filter(|&r| there(r)).map(|r| r as u32).collect();
        for k in 0..log.reflectors() {
            add(Sensor::Reflector(k), rows(&|r| log.measured(k, r).is_some()));
        }
        if let Some(turned) = &log.orientation {
            let at = Sensor::Orientation.left_out_as().unwrap_or(0);
            add(Sensor::Orientation, rows(&|r| turned.is_there(r) && !log.is_left_out(at, r)));
        }
        if let Some(reading) = &log.reading {
            add(Sensor::Reading, rows(&|r| reading.is_there(r) && !log.is_left_out(0, r)));
        }
        for (a, column) in log.log.enc.iter().enumerate() {
            if let (Some(c), true) = (column, log.motors.get(a).copied().unwrap_or(false)) {
                add(Sensor::Motor(a), rows(&|r| c[r].is_some()));
            }
        }
        for (a, column) in log.log.meas.iter().enumerate() {
            if let Some(c) = column {
                add(Sensor::Joint(a), rows(&|r| c[r].is_some()));
            }
        }
    }
    problem.groups = groups;
    problem.n = offset;
}

/// Frames of two logs whose points they set this far apart are those of two stations of the tracker, m; effects of a machine
/// that is worth a diagnosis stay below it.
const STATIONS_APART_M: f64 = 0.02;
/// And this many times farther than each frame misses its own points.
const STATIONS_CLEAR: f64 = 20.0;

/// Gives every log its own frame, where the tracker was moved between them.
fn separate_frames(problem: &mut Problem, h: &mut Hypothesis) {
    let measured: Vec<usize> = (0..problem.logs.len()).filter(|&l| problem.logs[l].is_tracked()).collect();
    if measured.len() < 2 {
        return;
    }
    let own: Option<Vec<Isometry3<f64>>> = measured.iter().map(|&l| register(problem, h, Some(l)).ok()).collect();
    let Some(own) = own else { return };
    let state = problem.evaluate(h);
    // rms over the points of a log: between two frames, and what the log's own one misses
    let apart = |l: usize, a: &Isometry3<f64>, b: Option<&Isometry3<f64>>| {
        let squares = problem.logs[l].log.tcp_m.iter().enumerate().filter_map(|(r, p)| {
            let here = a.inverse_transform_point(&(*p)?.into()).coords;
            let there = b.map_or(state.logs[l].points_m[0][r], |b| {
                b.inverse_transform_point(&p.unwrap_or_default().into()).coords
            });
            Some((here - there).norm_squared())
        });
        let (n, sum) = squares.fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v));
        (sum / f64::max(n, 1.0)).sqrt()
    };
    let moved = measured.iter().zip(&own).skip(1).any(|(&l, frame)| {
        let by = apart(l, frame, Some(&own[0]));
        by > STATIONS_APART_M && by > STATIONS_CLEAR * apart(l, frame, None).max(apart(measured[0], &own[0], None))
    });
    if moved {
        let shared = h.frames[0];
        h.frames = vec![shared; problem.logs.len()];
        for (&l, frame) in measured.iter().zip(own) {
            h.frames[l] = frame;
        }
        for (l, log) in problem.logs.iter_mut().enumerate() {
            log.frame = l;
        }
        problem.notes.push(Note::OwnFrames);
    }
}

/// The frame that fits all logs, or one of them.
fn register(problem: &Problem, h: &Hypothesis, only: Option<usize>) -> Result<Isometry3<f64>> {
    let state = problem.evaluate(h);
    let mut pairs = Vec::new();
    for g in problem.groups.iter().filter(|g| only.is_none_or(|l| g.log == l)) {
        if let Sensor::Reflector(k) = g.sensor {
            let log = &problem.logs[g.log];
            let thin = (g.rows.len() * problem.groups.len() / PAIRS).max(1);
            for &r in g.rows.iter().step_by(thin) {
                if let Some(m) = log.measured(k, r as usize) {
                    pairs.push(registration::Pair { base_m: state.logs[g.log].points_m[k][r as usize], tracker_m: m });
                }
            }
        }
    }
    Ok(registration::register_line(&pairs)?.found.frame)
}

/// Value of a sample of a sensor that measures a point, whole or in part; of a single reading in the first coordinate.
fn value_of(group: &Group, values: &[f64], b: usize) -> Vector3<f64> {
    let n = group.len();
    match group.dims {
        3 => Vector3::new(values[b], values[n + b], values[2 * n + b]),
        _ => Vector3::new(values[b], 0.0, 0.0),
    }
}

/// Finds samples that disagree with their neighbours and leaves them out; says how many.
pub fn drop_spikes(problem: &mut Problem, state: &State) -> usize {
    let mut found: Vec<(usize, usize, usize)> = Vec::new();
    for g in &problem.groups {
        let Some(k) = g.sensor.left_out_as() else { continue };
        let log = &problem.logs[g.log];
        if log.log.poses || g.rows.len() < 8 || log.block > 1 {
            continue;
        }
        let n = g.len();
        let values = &state.residual[g.range()];
        let point = |b: usize| value_of(g, values, b);
        // a sample against the median of its neighbours, coordinate by coordinate
        let off = |b: usize| -> f64 {
            let near: Vec<usize> = (b.saturating_sub(2)..(b + 3).min(n)).filter(|&i| i != b).collect();
            let c = |k: usize| {
                let mut v: Vec<f64> = near.iter().map(|&i| point(i)[k]).collect();
                median_of(&mut v).unwrap_or(0.0)
            };
            (point(b) - Vector3::new(c(0), c(1), c(2))).norm()
        };
        let all: Vec<f64> = (0..n).map(off).collect();
        let scale = SIGMA_PER_MAD * median(&all).max(noise::LEAST_POINT_SIGMA);
        let mut beside = vec![false; log.log.len()];
        for axis in 0..problem.robot.dof() {
            for (t_s, _, _) in log.trajectory.turns(axis) {
                let row = log.trajectory.t_s().partition_point(|t| *t < t_s);
                let range = row.saturating_sub(BESIDE)..(row + BESIDE + 1).min(beside.len());
                beside[range].fill(true);
            }
        }
        for b in 0..n {
            let row = g.middle(b);
            let gross = if beside[row] { GROSS_AT_REVERSAL } else { GROSS };
            let largest = (b.saturating_sub(1)..(b + 2).min(n)).all(|i| all[i] <= all[b]);
            if all[b] > gross * scale && largest {
                found.push((g.log, k, row));
            }
        }
    }
    leave_out(problem, &found);
    found.len()
}

/// Finds single samples that stand out of a residual freed of all structure and leaves them out; says how many. Their
/// neighbours lie within the noise: what decays after a reversal lasts longer than a sample.
pub fn drop_single(problem: &mut Problem, freed: &[f64]) -> usize {
    let mut found = Vec::new();
    for g in &problem.groups {
        let Some(k) = g.sensor.left_out_as() else { continue };
        let log = &problem.logs[g.log];
        if log.log.poses || g.rows.len() < 8 || log.block > 1 {
            continue;
        }
        let n = g.len();
        let v = &freed[g.range()];
        let size: Vec<f64> = (0..n).map(|b| value_of(g, v, b).norm()).collect();
        let per_sigma = if g.dims == 3 { 1.0 / MEDIAN_DISTANCE } else { SIGMA_PER_MAD };
        let sigma = (per_sigma * median(&size)).max(noise::LEAST_POINT_SIGMA);
        for b in 0..n {
            let near = |i: usize| size.get(i).is_none_or(|s| *s < NEAR * sigma);
            let alone = (b == 0 || near(b - 1)) && near(b + 1);
            if size[b] > GROSS * sigma && alone {
                found.push((g.log, k, g.middle(b)));
            }
        }
    }
    leave_out(problem, &found);
    found.len()
}

fn leave_out(problem: &mut Problem, found: &[(usize, usize, usize)]) {
    for &(l, k, row) in found {
        let log = &mut problem.logs[l];
        let (reflectors, rows) = (log.reflectors(), log.log.len());
        log.left_out.resize(reflectors, Vec::new());
        log.left_out[k].resize(rows, false);
        log.left_out[k][row] = true;
    }
    if !found.is_empty() {
        group(problem);
    }
}

/// Leaves out all reflectors of poses `(log, row)`.
pub fn leave_poses_out(problem: &mut Problem, poses: &[(usize, usize)]) {
    let found: Vec<(usize, usize, usize)> =
        poses.iter().flat_map(|&(l, row)| (0..problem.logs[l].reflectors()).map(move |k| (l, k, row))).collect();
    leave_out(problem, &found);
}

/// Finds settled poses that a fit leaves far off and leaves them out; says how many.
pub fn poses_without_outliers(problem: &mut Problem, state: &State) -> usize {
    let mut found = Vec::new();
    for g in &problem.groups {
        let Some(k) = g.sensor.left_out_as().filter(|_| g.dims == 3) else { continue };
        if !problem.logs[g.log].log.poses || g.len() < 12 {
            continue;
        }
        let n = g.len();
        let values = &state.residual[g.range()];
        let size: Vec<f64> = (0..n).map(|b| Vector3::new(values[b], values[n + b], values[2 * n + b]).norm()).collect();
        let typical = median(&size);
        for (b, s) in size.iter().enumerate() {
            if *s > 5.0 * typical {
                found.push((g.log, k, g.middle(b)));
            }
        }
    }
    leave_out(problem, &found);
    found.len()
}
