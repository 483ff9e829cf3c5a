//! Units, signs and order of columns that cannot be right, found where no offset of the clocks brings both paths together.
//!
//! Times first: where one recording lasts far longer than the other, its times are read as milliseconds and as microseconds on trial.
//!
//! Method: the faults that a log is checked for ([`crate::log::plausibility`]) are put right one at a time, and the best offset
//! is sought again. A fault is reported where it explains the misfit to a seventh or less, as there, and leaves little of the path. This
//! costs some seconds, so it is done only where the paths disagree.
//!
//! Fails: two faults at once are not found; the recordings then show no motion in common.

use super::search::{self, Seen};
use crate::error::{Error, Place, Result};
use crate::log::faults::Fault;
use crate::log::plausibility::EXPLAINED;
use crate::log::recording::Recording;
use crate::numerics::parallel::of_each;
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Misfit over the size of the path below which there is nothing to explain: starts are found to a millisecond, and a tracker's
/// reflector may stand elsewhere than the robot file says.
const AGREE: f64 = 0.01;

/// A fault that leaves more than this share of the path's size explains nothing: points in micrometres shrink any path to one, and what
/// is left is then the computed path itself.
const LEFT: f64 = 0.08;
/// Durations this far apart are no two recordings of one motion: one is read in another unit.
const DURATIONS: f64 = 30.0;
/// Nobody records longer than this, s: of two durations, the one above it is wrong.
const LONGEST_S: f64 = 7200.0;

/// What the two recordings hold.
pub(super) struct Recorded<'a> {
    pub controller: &'a Recording,
    pub tracker: &'a Recording,
    /// Times of the controller, s, and joint positions, per axis.
    pub t_s: &'a [f64],
    pub positions: &'a [Vec<f64>],
    /// Movement up to which a channel stands still.
    pub still: &'a [f64],
}

/// Refuses recordings that show one motion only where a fault is put right. `misfit`: at the best offset, as recorded, over the
/// size of the path.
pub(super) fn refuse(
    robot: &Robot,
    recorded: &Recorded,
    seen: &Seen,
    within: Option<[f64; 2]>,
    misfit: f64,
) -> Result<()> {
    if misfit.is_finite() && misfit < AGREE {
        return Ok(());
    }
    let faults = Fault::all(robot, recorded.positions);
    let without = |fault: Fault| Some((fault, misfit_without(fault, robot, recorded, seen, within)?));
    let tried: Vec<(Fault, f64)> = of_each(faults, without).into_iter().flatten().collect();
    let least = tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
    let alike: Vec<&(Fault, f64)> = tried.iter().filter(|t| t.1 <= 1.5 * least).take(3).collect();
    let Some(first) = alike.first().filter(|_| least <= LEFT && least <= EXPLAINED * misfit) else { return Ok(()) };
    let file = if first.0.is_of_commands() { recorded.controller } else { recorded.tracker };
    if file.is_si && first.0.is_thousandfold() {
        let found = "x, y and z of messages whose points are in metres, a thousand times too large".to_string();
        let expected = "metres; a column map with `x: {to: x_mm, unit: mm}`, the same for y and z, reads millimetres";
        return Err(Error::bad(Place::file(&file.name), found, expected));
    }
    let words: Vec<String> = alike.iter().map(|t| t.0.named(robot).to_string()).collect();
    let found = format!(
        "a motion that both recordings show only if {} ({} instead of {} of the path's size is left)",
        words.join("; or if "),
        percent(least),
        percent(misfit)
    );
    let mended = first.0.mended(robot).map_or(String::new(), |entry| {
        format!(" (correct it in the file, or with the entry of a column map whose `to` is the same: `{entry}`)")
    });
    Err(Error::bad(
        Place::file(&file.name),
        found,
        format!("the path computed with the robot file from the commands{mended}"),
    ))
}

/// Refuses recordings of which one lasts a thousand times or a million times as long as the other, and that show one motion where its
/// times are divided by that.
pub(super) fn refuse_times(robot: &Robot, recorded: &Recorded, seen: &Seen) -> Result<()> {
    let lasts = |t: &[f64]| t.last().copied().unwrap_or(0.0) - t.first().copied().unwrap_or(0.0);
    let (ours, theirs) = (lasts(recorded.t_s), lasts(seen.t_s));
    let longer = ours.max(theirs);
    if longer <= DURATIONS * ours.min(theirs) {
        return Ok(());
    }
    let misfit = |factor: f64| {
        let scaled = |t: &[f64], mine: bool| t.iter().map(|t| if mine { t / factor } else { *t }).collect::<Vec<_>>();
        let series = Series::new(scaled(recorded.t_s, ours == longer), recorded.positions.to_vec(), recorded.still);
        let t_s = scaled(seen.t_s, ours != longer);
        search::start(robot, &series, &Seen { t_s: &t_s, at_m: seen.at_m }, None).map(|f| f.misfit)
    };
    let units = [(1e3, "milliseconds"), (1e6, "microseconds")];
    let Some((factor, unit)) = units.into_iter().find(|(f, _)| misfit(*f).is_some_and(|m| m <= LEFT)) else {
        return Ok(());
    };
    let (mut long, mut short) = (recorded.controller, recorded.tracker);
    if ours != longer {
        std::mem::swap(&mut long, &mut short);
    }
    let (wrong, said) = if longer > LONGEST_S {
        (long, format!("the times here are in {unit} and are read as seconds"))
    } else {
        (short, format!("the times here are in seconds and are read as {unit}"))
    };
    let found = format!(
        "times of another unit: {} lasts {longer:.0} s and {} {} s, and both show one motion only if the first is divided by {factor:.0}",
        long.name,
        short.name,
        brief(ours.min(theirs)),
    );
    Err(Error::bad(
        Place::file(&wrong.name),
        found,
        format!("times in seconds; {said}: correct `unit` of the time in the column map"),
    ))
}

/// A duration with three digits.
fn brief(seconds: f64) -> String {
    if seconds >= 10.0 { format!("{seconds:.0}") } else { format!("{seconds:.3}") }
}

/// Misfit at the best offset with a fault put right.
fn misfit_without(
    fault: Fault,
    robot: &Robot,
    recorded: &Recorded,
    seen: &Seen,
    within: Option<[f64; 2]>,
) -> Option<f64> {
    if !fault.is_of_commands() {
        let series = Series::new(recorded.t_s.to_vec(), recorded.positions.to_vec(), recorded.still);
        let at_m: Vec<Vector3<f64>> = seen.at_m.iter().map(|p| fault.put_point_right(*p)).collect();
        return search::start(robot, &series, &Seen { t_s: seen.t_s, at_m: &at_m }, within).map(|f| f.misfit);
    }
    let mut positions = recorded.positions.to_vec();
    let mut q = vec![0.0; positions.len()];
    for i in 0..recorded.t_s.len() {
        for (v, p) in q.iter_mut().zip(&positions) {
            *v = p[i];
        }
        fault.put_right(robot, &mut q);
        for (v, p) in q.iter().zip(&mut positions) {
            p[i] = *v;
        }
    }
    let series = Series::new(recorded.t_s.to_vec(), positions, recorded.still);
    search::start(robot, &series, seen, within).map(|f| f.misfit)
}

/// A share of the path's size, for messages.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p < 1.0 => format!("{p:.2} %"),
        p if p < 1000.0 => format!("{p:.0} %"),
        _ => "more than 1000 %".into(),
    }
}
