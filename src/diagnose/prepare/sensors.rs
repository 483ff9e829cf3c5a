//! Which channel drives the gears: the commands, or the encoders on the motors.
//!
//! An encoder splits the gap: what the servo makes of the command stands between the two, gear, links and geometry after
//! it. It is used where it leaves less of the measurement than the command does, after the zero of each joint sensor or,
//! for points, after frame and linear geometry; where it leaves more, it contradicts the measurement: said, and not used.
//!
//! The servo stage is diagnosed from encoder against command where the encoder follows. Where it leads (a controller with
//! feed-forward logs its references after its own filters), no servo effect describes it: said, with the rms.
//!
//! Assumptions: an encoder's zero is its own (one free number per column and log); the noise of an encoder is small against a gap: its
//! movements within five standard deviations of its noise are none. The noise is that of fourth differences, which a
//! smooth motion does not have.

use crate::diagnose::candidates;
use crate::diagnose::note::{Lead, Note};
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::problem::normal::{orthonormal, project_off};
use crate::machine::{self, CommandTrajectory};
use crate::numerics::robust::{SIGMA_PER_MAD, median};

/// Better by this factor counts as better.
const CLEARLY: f64 = 0.98;
/// Share of the variance of encoder minus command that a lead over the command explains, from which on it leads.
const LEADS: f64 = 0.1;
/// Movements within this many standard deviations of an encoder's noise are none.
const QUIET: f64 = 5.0;
/// Share of rows that a column must have.
const FILLED: f64 = 0.9;

/// Chooses what drives the gears of every log, and which motors show the servo. The groups are laid out anew by the caller.
pub fn choose(problem: &mut Problem, h: &Hypothesis) {
    let columns: Vec<Vec<Option<Vec<f64>>>> =
        problem.logs.iter().map(|l| (0..l.trajectory.dof()).map(|a| filled(l, a)).collect()).collect();
    if columns.iter().flatten().all(Option::is_none) {
        return;
    }
    let state = problem.evaluate(h);
    let mut notes = Vec::new();
    for (l, enc) in columns.iter().enumerate() {
        if enc.iter().all(Option::is_none) {
            continue;
        }
        let before = notes.len();
        let driven = if problem.logs[l].is_tracked() {
            by_points(problem, h, &state.residual, l, enc, &mut notes)
        } else {
            by_joints(problem, &state.residual, l, enc, &mut notes)
        };
        let contradicted = notes.len() > before;
        let motors = if contradicted { vec![false; enc.len()] } else { followed(problem, l, enc, &mut notes) };
        take_encoders(problem, l, enc, driven, motors);
    }
    problem.notes.extend(notes);
}

/// An encoder column with its few gaps filled: the command plus what the encoder last differed from it.
fn filled(log: &crate::diagnose::problem::forward::LogData, axis: usize) -> Option<Vec<f64>> {
    let column = log.log.enc.get(axis)?.as_ref()?;
    let there = column.iter().flatten().count();
    if (there as f64) < FILLED * column.len() as f64 {
        return None;
    }
    let first = column.iter().zip(&log.log.cmd[axis]).find_map(|(e, c)| e.map(|e| e - c))?;
    let mut last = first;
    Some(
        column
            .iter()
            .zip(&log.log.cmd[axis])
            .map(|(e, c)| {
                last = e.map_or(last, |e| e - c);
                c + last
            })
            .collect(),
    )
}

/// rms about the mean.
fn scatter(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Joint sensors decide axis by axis; axes without one follow the majority of the others.
fn by_joints(
    problem: &Problem,
    residual: &[f64],
    l: usize,
    enc: &[Option<Vec<f64>>],
    notes: &mut Vec<Note>,
) -> Vec<bool> {
    let log = &problem.logs[l];
    let mut found: Vec<Option<bool>> = vec![None; enc.len()];
    for g in problem.groups_of(l) {
        let Sensor::Joint(a) = g.sensor else { continue };
        let Some(column) = &enc[a] else { continue };
        let by_command = &residual[g.range()];
        let mut change = vec![0.0; problem.n];
        g.add_numbers(&mut change, |r| log.log.cmd[a][r] - column[r]);
        let by_encoder: Vec<f64> = by_command.iter().zip(&change[g.range()]).map(|(r, c)| r + c).collect();
        let (c, e) = (scatter(by_command), scatter(&by_encoder));
        found[a] = Some(e < CLEARLY * c);
        if e > c / CLEARLY {
            notes.push(Note::EncoderAgainstSensor {
                log: log.log.name.clone(),
                joint: problem.robot.axis(a).name.clone(),
                kind: problem.robot.axis(a).kind,
                encoder: e,
                command: c,
            });
        }
    }
    let yes = found.iter().filter(|f| **f == Some(true)).count();
    let most = 2 * yes > found.iter().flatten().count();
    found.iter().zip(enc).map(|(f, e)| e.is_some() && f.unwrap_or(most)).collect()
}

/// Points decide for all axes together.
fn by_points(
    problem: &Problem,
    h: &Hypothesis,
    residual: &[f64],
    l: usize,
    enc: &[Option<Vec<f64>>],
    notes: &mut Vec<Note>,
) -> Vec<bool> {
    let log = &problem.logs[l];
    let state = problem.evaluate(h);
    let mut columns = problem.nuisance_columns(h, &state);
    for c in candidates::all(problem).iter().filter(|c| candidates::is_geometry(c.effect)) {
        columns.extend(c.columns(problem, h, &state));
    }
    let only = |v: &mut Vec<f64>| {
        for g in problem.groups.iter().filter(|g| g.log != l || !matches!(g.sensor, Sensor::Reflector(_))) {
            v[g.range()].fill(0.0);
        }
    };
    columns.iter_mut().for_each(only);
    let basis = orthonormal(columns);
    let mut change = vec![0.0; problem.n];
    for (a, column) in enc.iter().enumerate() {
        if let Some(column) = column {
            problem.add_joint_change(&state, l, a, &|r| column[r] - log.log.cmd[a][r], None, &mut change);
        }
    }
    let typical = |mut v: Vec<f64>| {
        only(&mut v);
        project_off(&basis, &mut v);
        let sizes: Vec<f64> = problem
            .groups_of(l)
            .filter(|g| matches!(g.sensor, Sensor::Reflector(_)))
            .flat_map(|g| v[g.range()].iter().map(|x| x.abs()))
            .collect();
        SIGMA_PER_MAD * median(&sizes)
    };
    let by_command = typical(residual.to_vec());
    let by_encoder = typical(residual.iter().zip(&change).map(|(r, c)| r - c).collect());
    if by_encoder > by_command / CLEARLY {
        notes.push(Note::EncodersAgainstPoints {
            log: log.log.name.clone(),
            encoder_m: by_encoder,
            command_m: by_command,
            settled: log.log.poses,
        });
    }
    enc.iter().map(|e| e.is_some() && by_encoder < CLEARLY * by_command).collect()
}

/// Axes whose encoder follows the command as a servo does: not one of them leads.
fn followed(problem: &Problem, l: usize, enc: &[Option<Vec<f64>>], notes: &mut Vec<Note>) -> Vec<bool> {
    let log = &problem.logs[l];
    let mut motors = vec![false; enc.len()];
    if log.log.poses {
        return motors;
    }
    let mut leads: Vec<Lead> = Vec::new();
    for (a, column) in enc.iter().enumerate() {
        let Some(column) = column else { continue };
        let cmd = &log.log.cmd[a];
        let speed = machine::slopes(&log.log.t_s, cmd);
        let off: Vec<f64> = column.iter().zip(cmd).map(|(e, c)| e - c).collect();
        let n = off.len() as f64;
        let mean = off.iter().sum::<f64>() / n;
        let centred: Vec<f64> = off.iter().map(|v| v - mean).collect();
        let slope = dot(&centred, &speed) / dot(&speed, &speed).max(1e-300);
        let share = slope * slope * dot(&speed, &speed) / dot(&centred, &centred).max(1e-300);
        motors[a] = true;
        if slope > 0.0 && share > LEADS && scatter(&off) > QUIET * noise_of(column) {
            let joint = problem.robot.axis(a);
            leads.push(Lead { joint: joint.name.clone(), kind: joint.kind, by_s: slope, rms: scatter(&off) });
        }
    }
    if leads.is_empty() {
        return motors;
    }
    notes.push(Note::EncodersLead { log: log.log.name.clone(), leads });
    vec![false; enc.len()]
}

/// Standard deviation of the noise of a column: from fourth differences, which a smooth motion does not have.
fn noise_of(column: &[f64]) -> f64 {
    let fourth: Vec<f64> =
        column.windows(5).map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()).collect();
    SIGMA_PER_MAD * median(&fourth) / 70f64.sqrt()
}

fn take_encoders(problem: &mut Problem, l: usize, enc: &[Option<Vec<f64>>], driven: Vec<bool>, motors: Vec<bool>) {
    let robot = problem.robot.clone();
    let log = &mut problem.logs[l];
    log.motors = motors;
    if !driven.contains(&true) {
        return;
    }
    let input: Vec<Vec<f64>> = enc
        .iter()
        .zip(&driven)
        .zip(&log.log.cmd)
        .map(|((e, d), c)| e.as_ref().filter(|_| *d).unwrap_or(c).clone())
        .collect();
    let quiet: Vec<f64> = input.iter().zip(&driven).map(|(c, d)| if *d { QUIET * noise_of(c) } else { 0.0 }).collect();
    let trajectory = CommandTrajectory::of_log_by(&robot, &log.log, input, &quiet);
    log.commands = Some(std::mem::replace(&mut log.trajectory, trajectory));
    log.driven = driven;
    log.jacobian = std::sync::OnceLock::new();
}
