//! Measurements that were recorded by another clock than the commands: the shift in time with which they fit best.

use super::Log;
use crate::error::{Error, Place, Result};
use crate::robot::Robot;

/// Clocks that are further apart are no lag of a drive or a sensor, s.
pub(super) const APART_S: f64 = 0.5;
/// Shifts from here on are not known well: a test that goes to the same places again fits at several, s.
const ROUGH_S: f64 = 10.0;
/// Steps of each grid to either side.
const STEPS: i32 = 100;
/// Longest shifts of the grids: as a share of the log, and in s. Recordings may be started one after the other by hand.
const GRIDS: [(f64, f64); 2] = [(0.1, 10.0), (0.4, 600.0)];
/// Share of the misfit that a shift leaves where it explains the rest.
const LEFT: f64 = 0.2;
/// Rows of a column that are compared at most, and the fewest that say something.
const ROWS: usize = 1000;
const FEWEST: usize = 50;

/// The shift in s with which `left`, the misfit at a shift, is least, and that misfit: a fine grid of short shifts, a coarse one of long
/// shifts, then halving. `whole_s`: the length of the log.
pub(crate) fn best(whole_s: f64, mut left: impl FnMut(f64) -> f64) -> (f64, f64) {
    let mut best = (0.0, left(0.0));
    let mut step = 0.0;
    for (share, longest_s) in GRIDS {
        let own = (share * whole_s).min(longest_s) / f64::from(STEPS);
        for k in (-STEPS..=STEPS).map(f64::from) {
            let m = left(k * own);
            if m < best.1 {
                (best, step) = ((k * own, m), own);
            }
        }
    }
    for _ in 0..12 {
        step *= 0.5;
        let centre = best.0;
        for shift in [centre - step, centre + step] {
            let m = left(shift);
            if m < best.1 {
                best = (shift, m);
            }
        }
    }
    best
}

/// A column of values by time at a time `t` between its rows.
pub(crate) fn at(t_s: &[f64], column: &[f64], t: f64) -> Option<f64> {
    let k = t_s.partition_point(|v| *v <= t).clamp(1, t_s.len().checked_sub(1).filter(|n| *n > 0)?);
    let w = ((t - t_s[k - 1]) / (t_s[k] - t_s[k - 1])).clamp(0.0, 1.0);
    Some(column.get(k - 1)? + w * (column.get(k)? - column.get(k - 1)?))
}

/// A measurement by another clock, in words; refused.
pub(super) fn refused(log: &Log, what: &str, shift_s: f64) -> Error {
    let by = match shift_s.abs() >= ROUGH_S {
        true => "that fit the commands only with a shift of ten seconds or more".to_string(),
        false => format!("about {:.2} s {} the commands", shift_s.abs(), side(shift_s)),
    };
    Error::bad(Place::file(&log.name), format!("{what} {by}"), "one clock for commands and measurement")
}

/// On which side of the commands a measurement lies that fits with this shift.
fn side(shift_s: f64) -> &'static str {
    if shift_s > 0.0 { "ahead of" } else { "behind" }
}

/// Refuses sensors of joints (`meas_`) that follow the commands of another time.
///
/// # Errors
/// A sensor that fits with a shift of more than [`APART_S`], and not without.
pub(super) fn sensors(log: &Log, robot: &Robot) -> Result<()> {
    let (Some(first), Some(last)) = (log.t_s.first(), log.t_s.last()) else { return Ok(()) };
    if log.poses {
        return Ok(());
    }
    for (axis, column) in log.meas.iter().enumerate() {
        let (Some(column), Some(command)) = (column, log.cmd.get(axis)) else { continue };
        let seen: Vec<(f64, f64)> = log.t_s.iter().zip(column).filter_map(|(t, v)| Some((*t, (*v)?))).collect();
        if seen.len() < FEWEST || log.travel(axis) <= 0.0 {
            continue;
        }
        let thin = seen.len().div_ceil(ROWS);
        // of the differences the scatter alone: an offset of the sensor is none of its clock
        let left_of = |sign: f64, shift: f64| {
            let off: Vec<f64> = seen
                .iter()
                .step_by(thin)
                .filter_map(|(t, v)| Some(v - sign * at(&log.t_s, command, t + shift)?))
                .collect();
            let mean = off.iter().sum::<f64>() / off.len().max(1) as f64;
            off.iter().map(|v| (v - mean).powi(2)).sum::<f64>().sqrt()
        };
        let as_read = left_of(1.0, 0.0);
        // a sensor of the wrong sign: half a period of a test would explain it, too
        if left_of(-1.0, 0.0) <= LEFT * as_read {
            continue;
        }
        let (shift_s, misfit) = best(last - first, |shift| left_of(1.0, shift));
        if shift_s.abs() > APART_S && misfit <= LEFT * as_read {
            let joint = robot.axis(axis);
            return Err(refused(log, &format!("values of `meas_{}_{}`", joint.name, joint.kind.unit()), shift_s));
        }
    }
    Ok(())
}
