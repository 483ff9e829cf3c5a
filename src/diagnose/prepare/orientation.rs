//! How the probe that measures the orientation sits on the tool: the mean over the rows of a log.
//!
//! Assumptions: one probe for all logs, which does not move on the tool; logs in which it sits otherwise tell no orientation. Logs with
//! further reflectors have their orientation already.

use crate::diagnose::note::Note;
use crate::log::Log;
use crate::log::registration::{Pair, register_line};
use crate::model::Model;
use crate::numerics::robust::median;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Rows of a log that tell how the probe sits.
const ROWS: usize = 2000;

/// Deviation of a log from one way to sit, median over its rows, rad, above which its orientations are not those of the tool.
const MOST_RAD: f64 = 0.1;

/// Logs that differ by more than this, rad, are not of one probe that sat alike: errors of a robot turn its tool by less.
const MOST_APART_RAD: f64 = 2e-3;

/// How the probe sits on the tool; `None` where no log has an orientation beside its points, where there are further reflectors, or
/// where the orientations cannot be those of the tool. Notes what a reader should know.
pub(super) fn probe(model: &Model, logs: &[Log], notes: &mut Vec<Note>) -> Option<Rotation3<f64>> {
    if logs.iter().any(|l| !l.reflectors_m.is_empty()) {
        return None;
    }
    let found = logs.iter().find_map(|log| probe_of(model, log))?;
    let worst = logs.iter().filter_map(|log| apart(model, log, &found)).fold(0.0, f64::max);
    if worst > MOST_RAD {
        notes.push(Note::OrientationContradicts { by_rad: worst });
        return None;
    }
    let means: Vec<(&Log, Rotation3<f64>)> = logs.iter().filter_map(|log| Some((log, probe_of(model, log)?))).collect();
    let from_first = |(log, sits): &(&Log, Rotation3<f64>)| (log.name.clone(), angle(sits, &found));
    let moved = means.iter().map(from_first).max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((log, by_rad)) = moved.filter(|(_, angle)| *angle > MOST_APART_RAD) {
        notes.push(Note::ProbeMoved { log, by_rad });
        return None;
    }
    notes.push(Note::OrientationUsed);
    Some(found)
}

/// How the probe sits by each of some rows of a log, in the log's own frame.
fn by_rows(model: &Model, log: &Log) -> Option<Vec<Rotation3<f64>>> {
    let measured = |row: usize| -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
        Some((log.tcp_m.get(row).copied().flatten()?, log.instruments.orientation.get(row).copied().flatten()?))
    };
    let all: Vec<usize> = (0..log.len()).filter(|&row| measured(row).is_some()).collect();
    let rows = || all.iter().copied().step_by(all.len().div_ceil(ROWS).max(1));
    let pair = |row| Some(Pair { base_m: model.robot.tcp_m(&log.command(row)), tracker_m: measured(row)?.0 });
    let own = || Some(register_line(&rows().filter_map(pair).collect::<Vec<_>>()).ok()?.found.frame);
    let frame: Isometry3<f64> = model.registration.or_else(own)?;
    Some(rows().filter_map(|row| Some(sits(model, log, &frame, row, measured(row)?.1))).collect())
}

fn probe_of(model: &Model, log: &Log) -> Option<Rotation3<f64>> {
    mean(by_rows(model, log)?.into_iter())
}

/// How far the rows of a log are from this way to sit, rad.
fn apart(model: &Model, log: &Log, found: &Rotation3<f64>) -> Option<f64> {
    let angles: Vec<f64> = by_rows(model, log)?.iter().map(|s| angle(s, found)).collect();
    (!angles.is_empty()).then(|| median(&angles))
}

/// Angle between two rotations, rad. That of a matrix is not a number where rounding puts its trace above 3.
fn angle(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    UnitQuaternion::from_rotation_matrix(&a.rotation_to(b)).angle()
}

/// How the probe sits on the tool by one row.
fn sits(model: &Model, log: &Log, frame: &Isometry3<f64>, row: usize, turned: UnitQuaternion<f64>) -> Rotation3<f64> {
    let tool = model.robot.forward(&log.command(row)).rotation;
    tool.inverse() * (frame.rotation.inverse() * turned).to_rotation_matrix()
}

/// The rotation nearest to the mean of some (Markley, Cheng, Crassidis, Oshman 2007).
fn mean(all: impl Iterator<Item = Rotation3<f64>>) -> Option<Rotation3<f64>> {
    let sum: Matrix3<f64> = all.map(Rotation3::into_inner).sum();
    let parts = sum.svd(true, true);
    if parts.singular_values.max() == 0.0 {
        return None;
    }
    let (u, v) = (parts.u?, parts.v_t?);
    let side = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v).determinant().signum()));
    Some(Rotation3::from_matrix_unchecked(u * side * v))
}

/// The orientation of each run of rows: at the commands of its middle, with the mean of how the probe sits over the run.
pub(super) fn thinned(
    model: &Model,
    log: &Log,
    frame: &Isometry3<f64>,
    runs: &[std::ops::Range<usize>],
) -> Vec<Option<UnitQuaternion<f64>>> {
    let of_run = |run: &std::ops::Range<usize>| {
        let rows = run.clone().filter_map(|row| {
            let turned = log.instruments.orientation.get(row).copied().flatten()?;
            Some(sits(model, log, frame, row, turned))
        });
        let probe = mean(rows)?;
        let tool = model.robot.forward(&log.command((run.start + run.end) / 2)).rotation;
        Some(frame.rotation * UnitQuaternion::from_rotation_matrix(&(tool * probe)))
    };
    if log.instruments.orientation.is_empty() { Vec::new() } else { runs.iter().map(of_run).collect() }
}
