//! Two gaps in series on one joint: the coupling (motor against screw) and the nut (screw against carriage), after Gantry (2015).
//!
//! One file a step:
//! - `columns`: what drives a joint and what measures it; the gaps between two of its columns.
//! - [`strokes`]: strokes of the command, and how far each row is into its own.
//! - [`tracker`]: the carriage of each prismatic joint from a tracker in an unknown frame, where no separate sensor measures it.
//! - [`mod@reach`]: from which way into a stroke on every gap before a sensor is surely closed; strokes that are too short.
//! - [`flanks`]: both flanks of one gap: slope `m`, `c_r`, `c_l` of equation 2, with intervals from the strokes.
//! - [`start`]: on which side the log began (Figure 4).
//! - [`loops`]: deviation over position, for pictures, by the catalogue's play operator.
//! - [`series`]: what is found of one joint.
//! - [`document`], [`display`]: the result as a document and as a table.
//!
//! Coupling and nut are separated where a sensor stands between them (`screw_<joint>`). Without it there is one play, whose
//! `c_l` and `c_r` are the sums of both (two plays in series are the play of the summed gaps), and only that is reported.
//! Where the input is the command (no encoder) or the output a tracker, a lag between them is fitted too.
//!
//! Separate left and right: `c_l` and `c_r` refer to the zero of the columns. Where `c_l <= 0 <= c_r` and their middle differs
//! from 0 by more than its uncertainty, the offsets of a compensator are `c_r` up and `-c_l` down; else, and always with a tracker,
//! whose zero is free, the total is split evenly.
//!
//! Files beside:
//! - `notes`: what a reader of the figures should know

mod columns;
#[cfg(feature = "cli")]
pub(crate) mod display;
pub mod document;
pub mod flanks;
pub(crate) mod loops;
mod notes;
pub(crate) mod reach;
pub mod series;
pub mod start;
pub(crate) mod strokes;
pub(crate) mod tracker;

use crate::error::{Error, Place, Result};
use crate::gaps::note::screw::{Remark, Sensor};
use crate::gaps::{Gaps, JointGap, Note, Sides};
use crate::log::Log;
use crate::numerics::robust::spread;
use crate::robot::{Joint, Robot};
use columns::Columns;
use flanks::{Flanks, Pair, fit};
pub use series::{Output, OutputPositions, Series, TrainGap};
use start::Start;
use std::collections::BTreeMap;
use strokes::Strokes;

/// A sensor that moves by this part of its joint's way, or less, stands still.
const STILL: f64 = 1e-3;
/// Rounds of tracker directions and gaps, alternately: each takes their error down by gap over stroke.
const ROUNDS: usize = 3;

/// What was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// Half gaps of the joints, for a compensator.
    pub gaps: Gaps,
    /// What was found of each joint that was measured on its train.
    pub series: Vec<Series>,
}

/// Finds the gaps of `only` (an axis), or of every joint that moves.
pub fn identify(robot: &Robot, logs: &[Log], only: Option<usize>) -> Result<Found> {
    let mut gaps = Gaps::new(robot, logs);
    gaps.notes.extend(robot.by_joints_alone().map(Note::JointsAlone));
    let mut found: BTreeMap<usize, Series> = BTreeMap::new();
    for (k, log) in logs.iter().enumerate() {
        let axes: Vec<usize> = log.moving_axes().into_iter().filter(|a| only.is_none_or(|o| o == *a)).collect();
        for series in of_log(robot, log, k, &axes, &mut gaps.notes)? {
            match found.get(&series.axis) {
                Some(known) if !better(&series, known) => {
                    let better = logs[known.log].name.clone();
                    gaps.notes.push(note(robot, series.axis, Remark::LogNotUsed { log: log.name.clone(), better }));
                }
                _ => {
                    found.insert(series.axis, series);
                }
            }
        }
    }
    if found.is_empty() {
        let what = only.map_or("no joint".to_string(), |a| robot.axis(a).name.clone());
        return Err(Error::bad(
            Place::file(logs.first().map_or("", |l| l.name.as_str())),
            format!("{what} that moves, with a sensor behind its motor"),
            "strokes up and down of a joint, with `screw_<joint>`, `meas_<joint>` or a tracker's coordinates",
        ));
    }
    for series in found.values() {
        gaps.joints.extend(joint(series));
        if series.both.is_none() && series.coupling.is_some() {
            gaps.notes.push(note(robot, series.axis, Remark::CouplingAlone));
        }
    }
    Ok(Found { gaps, series: found.into_values().collect() })
}

fn note(robot: &Robot, axis: usize, remark: Remark) -> Note {
    Note::Screw { joint: robot.axis(axis).name.clone(), remark }
}

/// More gaps, or the same known better.
fn better(a: &Series, b: &Series) -> bool {
    let worth = |s: &Series| {
        let known = [&s.coupling, &s.nut, &s.both].iter().filter(|g| g.is_some()).count();
        let width =
            s.both.as_ref().or(s.coupling.as_ref()).map_or(f64::INFINITY, |g| g.total.ci95[1] - g.total.ci95[0]);
        (known, -width)
    };
    worth(a) > worth(b)
}

/// The joints of one log.
fn of_log(robot: &Robot, log: &Log, number: usize, axes: &[usize], notes: &mut Vec<Note>) -> Result<Vec<Series>> {
    let measured = log.meas.iter().chain(&log.screw).any(Option::is_some);
    if !measured && tracker::coordinates(log).is_empty() {
        return Err(Error::bad(
            Place::line(&log.name, 1),
            "no measurement column",
            "`screw_<joint>`, `meas_<joint>`, or one or more of `x_mm,y_mm,z_mm`",
        ));
    }
    // all joints' motion is needed to read one of them from a tracker
    let mut motion = log.cmd.clone();
    let mut series = Vec::new();
    let rounds = if tracker::coordinates(log).is_empty() { 1 } else { ROUNDS };
    for round in 0..rounds {
        let last = round + 1 == rounds;
        let outputs = tracker::positions(robot, log, &motion);
        let all = log.moving_axes();
        for &axis in if last { axes } else { &all[..] } {
            let mut of_round = Vec::new();
            let one = of_joint(robot, log, number, axis, &outputs[axis], &mut of_round)?;
            if let Some(both) = one.as_ref().and_then(|s| s.both.as_ref()) {
                motion[axis] = loops::carriage(log, axis, both);
            }
            if last {
                notes.extend(of_round.into_iter().map(|remark| note(robot, axis, remark)));
                series.extend(one);
            }
        }
    }
    Ok(series)
}

/// One joint of one log; `None` where nothing after its motor is measured.
fn of_joint(
    robot: &Robot,
    log: &Log,
    number: usize,
    axis: usize,
    tracked: &OutputPositions,
    remarks: &mut Vec<Remark>,
) -> Result<Option<Series>> {
    let joint = robot.axis(axis);
    let Some(columns) = Columns::of(robot, log, axis, tracked, remarks) else { return Ok(None) };
    columns.check_encoder()?;
    let mut series = Series {
        axis,
        log: number,
        encoder: columns.has_encoder(),
        output: columns.output.map(|o| o.1),
        coupling: None,
        nut: None,
        both: None,
        start: Start::Unknown,
        at_least: None,
        loops: Vec::new(),
    };
    let mut from = None;
    if let Some(screw) = columns.screw
        && let Some(way) = columns.reach(Sensor::Screw, screw, &mut series, remarks)?
    {
        from = Some(way);
        series.coupling = columns.coupling(screw, way, remarks)?;
    }
    if let Some(output) = columns.output
        && let Some(way) = columns.reach(Sensor::Carriage, output.0, &mut series, remarks)?
    {
        from = Some(way);
        (series.both, series.nut) = columns.carriage(output, way, remarks);
    }
    let carriage = columns.output.map(|o| o.0);
    let whole = series.both.as_ref().map(|b| (b, carriage.unwrap_or(&columns.command)));
    let read = whole.or(series.coupling.as_ref().zip(columns.screw));
    if let (Some((flanks, sensor)), Some(from)) = (read, from) {
        series.start = start::of(&columns.strokes, columns.input(), sensor, flanks, from);
        remarks.push(Remark::Begins { start: series.start, kind: joint.kind, from });
    }
    let gaps = [&series.coupling, &series.nut, &series.both];
    series.loops = loops::of(log, axis, columns.input(), columns.screw, carriage, gaps);
    remarks.extend(notes::of_series(&series, joint));
    Ok(Some(series))
}

/// The slope is surely none of the joint's scale.
fn off_scale(flanks: &Flanks) -> bool {
    [1.0 - notes::LEAD, 1.0 + notes::LEAD].iter().all(|edge| flanks.slope.excludes(*edge))
        && (flanks.slope.value - 1.0).abs() > notes::LEAD
}

/// Refuses an encoder or screw that stands still, or that moves by another scale than its joint.
fn same_scale(
    log: &Log,
    joint: &Joint,
    what: &str,
    command: &[Option<f64>],
    sensor: &[Option<f64>],
    strokes: &Strokes,
) -> Result<()> {
    if span(sensor) <= STILL * span(command) {
        let text = format!("`{what}_{}` stands still while {} moves", joint.name, joint.name);
        return Err(Error::bad(
            Place::file(&log.name),
            text,
            "the joint's own sensor and a live one, or no such column",
        ));
    }
    let far = 0.5 * strokes.longest();
    let pair = Pair { t_s: &log.t_s, input: command, output: sensor, strokes, from: far, with_lag: false };
    let Ok(found) = fit(&pair) else { return Ok(()) };
    // a lag behind a short stroke looks like a scale, and the scale of all rows does not
    let along = regression(command, sensor);
    if !off_scale(&found) || along.is_some_and(|m| (m - 1.0).abs() <= notes::LEAD) {
        return Ok(());
    }
    let text = format!("`{what}_{}` moves by {:.5} per command", joint.name, found.slope.value);
    Err(Error::bad(Place::file(&log.name), text, notes::SCALE))
}

/// Slope of a sensor over the command by least squares over all rows; `None` where the command does not move.
fn regression(command: &[Option<f64>], sensor: &[Option<f64>]) -> Option<f64> {
    let rows: Vec<(f64, f64)> = command.iter().zip(sensor).filter_map(|(c, s)| Some(((*c)?, (*s)?))).collect();
    let n = rows.len().max(1) as f64;
    let (c, s) = rows.iter().fold((0.0, 0.0), |(c, s), row| (c + row.0 / n, s + row.1 / n));
    let (along, square) =
        rows.iter().fold((0.0, 0.0), |(a, q), row| (a + (row.0 - c) * (row.1 - s), q + (row.0 - c).powi(2)));
    (square > 0.0).then(|| along / square)
}

/// Range of the readings.
fn span(readings: &[Option<f64>]) -> f64 {
    spread(readings.iter().flatten().copied())
}

/// Offsets of both directions, where they differ by more than is known of them.
pub fn sides(series: &Series) -> Option<Sides> {
    let both = series.both.as_ref().filter(|b| series.shares_zero(TrainGap::Both, b))?;
    let differ = both.middle.excludes(0.0) && both.c_r.value >= 0.0 && both.c_l.value <= 0.0;
    differ.then(|| Sides {
        positive: both.c_r.value,
        positive_ci95: both.c_r.ci95,
        negative: -both.c_l.value,
        negative_ci95: [-both.c_l.ci95[1], -both.c_l.ci95[0]],
    })
}

/// What a compensator needs: the sum of both gaps.
fn joint(series: &Series) -> Option<JointGap> {
    let both = series.both.as_ref()?;
    let half = both.total.ci95.map(|v| 0.5 * v);
    Some(JointGap {
        axis: series.axis,
        half_gap: 0.5 * both.total.value,
        ci95: half,
        // a negative one is no gap: a note says what is wrong with it
        significant: half[0] > 0.0,
        sides: sides(series),
        schedule: None,
        varies_p_value: None,
        stiction: None,
        stiction_p_value: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_of_all_rows_is_that_of_the_joint_although_a_sensor_lags_and_another_scale_shows() {
        // strokes of 40 mm at 20 mm/s with stops, a row each 40 ms; the sensor follows by a first-order lag of 20 ms
        let (mut command, mut sensor) = (Vec::new(), Vec::new());
        let (mut at, mut follows) = (0.0_f64, 0.0);
        for k in 0..2000 {
            let phase = k % 150;
            at += match phase {
                0..50 => 8e-4,
                75..125 => -8e-4,
                _ => 0.0,
            };
            follows += (at - follows) * (1.0 - (-0.04_f64 / 0.02).exp());
            command.push(Some(at));
            sensor.push(Some(follows));
        }
        let of = |scale: f64| -> Vec<Option<f64>> { sensor.iter().map(|s| s.map(|s: f64| scale * s)).collect() };
        assert!((regression(&command, &of(1.0)).unwrap() - 1.0).abs() < 0.01);
        assert!((regression(&command, &of(1.2)).unwrap() - 1.2).abs() < 0.012);
        assert_eq!(regression(&[Some(1.0), Some(1.0)], &[Some(1.0), Some(2.0)]), None);
    }
}
