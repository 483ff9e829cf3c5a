//! The instrument of single readings as it is set up, and whether its readings can be those of a robot.

use super::centre::centre;
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::numerics::robust::{lower_quantile, range, spread};
use crate::robot::Robot;
use nalgebra::{Unit, Vector3};

/// Rows from which something can be determined.
pub const LEAST_ROWS: usize = 50;
/// Change of readings (m) below which they are in a larger unit, as no robot moves so well: along a direction, and from a centre that is
/// set up by hand.
const LEAST_SPAN_M: [f64; 2] = [1e-6, 5e-6];
/// A centre is another one where the nominal distance from it changes by this (m), and by so many times what the readings do.
const FAR_M: f64 = 5e-3;
const FAR_TIMES: f64 = 5.0;

/// What the user knows of the instrument; world frame, m.
#[derive(Debug, Clone, Copy, Default)]
pub struct Setup {
    /// Centre of the ballbar; else it is estimated.
    pub centre_m: Option<Vector3<f64>>,
    /// Direction of the dial.
    pub direction: Option<Unit<Vector3<f64>>>,
}

impl Setup {
    /// What the user said of the instrument of a log.
    pub fn of(log: &Log) -> Self {
        Self { centre_m: log.instruments.centre_m, direction: log.instruments.direction }
    }
}

/// The instrument of a log.
///
/// # Errors
/// Where the log has no such reading, or the direction of a dial is not known.
pub fn instrument(robot: &Robot, log: &Log, setup: &Setup) -> Result<Instrument> {
    let i = &log.instruments;
    if i.distance_m.is_some() || i.distance_off_m.is_some() {
        let centre_m = setup.centre_m.unwrap_or_else(|| centre(robot, log));
        return Ok(Instrument::Distance { centre_m });
    }
    if i.dial_m.is_some() {
        let expected = "the direction in which `dial_um` increases, in the robot's world frame";
        return match setup.direction {
            Some(along) => Ok(Instrument::Direction { along }),
            None => {
                let e = Error::bad(Place::line(&log.name, 1), "`dial_um` without its direction", expected);
                Err(e.mended_by(&["direction"]))
            }
        };
    }
    let expected = "`r_mm` or `r_um` of a ballbar, `dial_um`, or sensors of joints (`meas_<joint>`); `identify` without a subcommand \
                    takes logs of a tracker beside them";
    Err(Error::bad(Place::line(&log.name, 1), "no reading of a distance, along a direction or of a joint", expected))
}

/// Refuses readings that no robot gives: in another unit, or about another place.
///
/// # Errors
/// Bad input, with what mends it.
pub fn plausible(robot: &Robot, log: &Log, setup: &Setup) -> Result<()> {
    let i = &log.instruments;
    let span = |values: &[f64]| lower_quantile(values, 0.95) - lower_quantile(values, 0.05);
    let column = i.scalar().unwrap_or_default();
    let (rows, readings): (Vec<usize>, Vec<f64>) =
        column.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?))).unzip();
    let read = span(&readings);
    let unit = refuse_larger_unit(log, read)?;
    let each = (rows.len() / 1000).max(1);
    let points: Vec<Vector3<f64>> = rows.iter().step_by(each).map(|i| robot.tcp_m(&log.command(*i))).collect();
    refuse_more_than_moves(log, setup, read, &points, unit)?;
    if i.distance_m.is_some() {
        return Ok(());
    }
    let Some(centre) = setup.centre_m.filter(|_| log.instruments.distance_off_m.is_some()) else { return Ok(()) };
    let nominal = span(&points.iter().map(|p| (p - centre).norm()).collect::<Vec<_>>());
    if nominal > FAR_M + FAR_TIMES * read {
        let found = format!(
            "readings that change by {:.0} um on a path whose distance from the centre changes by {:.1} mm",
            read * 1e6,
            nominal * 1e3
        );
        let expected = "the centre of the ballbar in mm, in the robot's world frame";
        return Err(Error::bad(Place::file(&log.name), found, expected).mended_by(&["centre"]));
    }
    Ok(())
}

/// Refuses readings that change by less (`read`, m) than any robot's do; the unit in which they are expected.
fn refuse_larger_unit(log: &Log, read: f64) -> Result<&'static str> {
    let (unit, least) = match (&log.instruments.distance_m, &log.instruments.distance_off_m) {
        (Some(_), _) => ("millimetres in `r_mm`", LEAST_SPAN_M[0]),
        (None, Some(_)) => ("micrometres in `r_um`", LEAST_SPAN_M[1]),
        _ => ("micrometres in `dial_um`", LEAST_SPAN_M[0]),
    };
    if read < least {
        let found = format!("readings that change by {:.3} um", read * 1e6);
        let expected = format!("{unit}, from a moving robot (these may be in a larger unit)");
        return Err(Error::bad(Place::file(&log.name), found, expected));
    }
    Ok(unit)
}

/// Refuses readings of a test with dwells whose largest difference is smaller than any robot's.
///
/// # Errors
/// Bad input, where they seem to be in a larger unit.
pub(crate) fn refuse_still(log: &Log) -> Result<()> {
    let readings = || log.instruments.scalar().unwrap_or_default().iter().flatten().copied();
    let [lo, hi] = range(readings());
    if readings().count() > 1 { refuse_larger_unit(log, hi - lo).map(|_| ()) } else { Ok(()) }
}

/// Refuses readings that change by far more than the TCP moves: in all, or along the direction of a dial.
fn refuse_more_than_moves(log: &Log, setup: &Setup, read: f64, points: &[Vector3<f64>], unit: &str) -> Result<()> {
    let extent = |along: &Vector3<f64>| spread(points.iter().map(|p| along.dot(p)));
    let all = (0..3).map(|k| extent(&Vector3::ith(k, 1.0)).powi(2)).sum::<f64>().sqrt();
    let dial =
        setup.direction.filter(|_| log.instruments.distance_m.is_none() && log.instruments.distance_off_m.is_none());
    let refused = |moves: f64, where_to: &str, expected: String| {
        let found = format!(
            "readings that change by {:.1} mm on a path that moves the TCP by {:.1} mm{where_to}",
            read * 1e3,
            moves * 1e3
        );
        Error::bad(Place::file(&log.name), found, expected)
    };
    if read > all + FAR_M {
        return Err(refused(all, "", format!("{unit} (these may be in a smaller unit)")));
    }
    if let Some(along) = dial
        && read > FAR_TIMES * extent(along.as_ref()) + FAR_M
    {
        let expected = "the direction in which `dial_um` increases, in the robot's world frame".to_string();
        return Err(refused(extent(along.as_ref()), " along the dial", expected).mended_by(&["direction"]));
    }
    Ok(())
}
