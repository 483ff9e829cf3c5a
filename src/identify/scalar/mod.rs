//! Half gaps from one reading a row: a double ballbar, a draw wire, a dial gauge along a path (ISO 230-4 for the ballbar's circle), or
//! from sensors of joints.
//!
//! Method: Gauss-Newton on all logs at once. What is fitted: the half gap of every joint that reverses, a fading spike after its
//! reversals and a lag of every joint that moves, a zero offset of every joint, and what the instrument does not know of itself
//! (centre and length of a ballbar, zero and tilt of a dial; [`crate::machine::measurement`]). Gaps are free; the rest has weak
//! priors ([`design`]), so that a single reading a row is enough. Residuals are whitened by an autoregressive model of first order
//! that is estimated from them ([`solve`]).
//!
//! A single reading does not see every joint. One whose standard deviation is too large for a gap of the usual size is listed as
//! not determined, with the reason, and gets no gap.
//!
//! Assumptions: constant gaps; geometry errors as zero offsets and what an autoregressive noise takes up.

pub(crate) mod design;
pub(crate) mod solve;

use crate::error::{Error, Place, Result, counted};
use crate::gaps::note::scalar::Note;
use crate::gaps::{self, Gaps, JointGap};
use crate::identify::gears::geared;
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::numerics::robust::lower_quantile;
use crate::numerics::student;
use crate::robot::{JointKind, Robot};
use design::{Kind, Track};
use nalgebra::{Unit, Vector3};

/// A half gap is determined where its standard deviation is below this: deg, mm.
pub const DETERMINED: [f64; 2] = [0.003, 0.01];
/// Standard deviation of a half gap, rad or m, from which a reading does not see the joint at all.
const UNSEEN: f64 = 0.1;
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

/// The result, and what was fitted beside the gaps.
#[derive(Debug, Clone)]
pub struct ScalarFound {
    /// Half gaps of the joints, for a compensator.
    pub gaps: Gaps,
    /// The instruments of the logs, centres as estimated.
    pub instruments: Vec<Instrument>,
    /// Standard deviation of a reading, m, and its autocorrelation from row to row.
    pub sigma_m: f64,
    /// Autocorrelation of the readings' noise from row to row.
    pub correlation: f64,
}

/// The instrument of a log.
///
/// # Errors
/// Where the log has no such reading, or the direction of a dial is not known.
pub fn instrument(robot: &Robot, log: &Log, setup: &Setup) -> Result<Instrument> {
    let i = &log.instruments;
    if i.distance_m.is_some() || i.distance_off_m.is_some() {
        let centre_m = setup.centre_m.unwrap_or_else(|| design::centre(robot, log));
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

/// The readings of a log along its path: one track for a ballbar or a dial, one for the sensor of each joint that moves.
fn tracks_of(robot: &Robot, log: &Log, setup: &Setup) -> Result<Vec<Track>> {
    let moves = |a: &usize| log.meas.get(*a).is_some_and(Option::is_some) && log.travel(*a) > 0.0;
    let sensed: Vec<usize> = (0..robot.dof()).filter(moves).collect();
    let single = log.instruments.has_scalar() || sensed.is_empty();
    let instruments = match single {
        true => vec![instrument(robot, log, setup)?],
        false => sensed.into_iter().map(|axis| Instrument::Joint { axis }).collect(),
    };
    instruments.into_iter().map(|i| track(robot, log, setup, i)).collect()
}

/// What one instrument read along the path of a log.
fn track(robot: &Robot, log: &Log, setup: &Setup, instrument: Instrument) -> Result<Track> {
    if log.poses {
        let expected = "a log of a motion, with `t_s` (use `identify static` for settled poses)";
        return Err(Error::bad(Place::line(&log.name, 1), "no `t_s`", expected));
    }
    let track = Track::new(robot, log, instrument, setup.centre_m.is_none());
    if track.rows.len() < LEAST_ROWS {
        let found = format!("{} with a reading", counted(track.rows.len(), "row"));
        return Err(Error::bad(Place::file(&log.name), found, format!("{LEAST_ROWS} or more")));
    }
    Ok(track)
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
    let (lo, hi) = readings().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if readings().count() > 1 { refuse_larger_unit(log, hi - lo).map(|_| ()) } else { Ok(()) }
}

/// Refuses readings that change by far more than the TCP moves: in all, or along the direction of a dial.
fn refuse_more_than_moves(log: &Log, setup: &Setup, read: f64, points: &[Vector3<f64>], unit: &str) -> Result<()> {
    let extent = |along: &Vector3<f64>| {
        let ends = points
            .iter()
            .map(|p| along.dot(p))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)]);
        (ends[1] - ends[0]).max(0.0)
    };
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

/// Finds half gaps from logs of single readings.
///
/// # Errors
/// Where a log has no reading, no time or too few rows, or no joint reverses.
pub fn identify(robot: &Robot, logs: &[Log], setup: &Setup) -> Result<ScalarFound> {
    let by_gears = geared(robot, logs);
    let mut found = of_axes(&by_gears.robot, &by_gears.logs, setup)?;
    found.gaps.robot_sha256 = robot.fingerprint();
    found.gaps.notes.extend(by_gears.notes);
    Ok(found)
}

/// The same where every gear turns by its own axis.
fn of_axes(robot: &Robot, logs: &[Log], setup: &Setup) -> Result<ScalarFound> {
    let (mut tracks, mut of_log) = (Vec::new(), Vec::new());
    for (l, log) in logs.iter().enumerate() {
        let own = tracks_of(robot, log, setup)?;
        of_log.extend(std::iter::repeat_n(l, own.len()));
        tracks.extend(own);
    }
    let reversing: Vec<usize> = (0..robot.dof()).filter(|a| tracks.iter().any(|t| t.reverses(*a))).collect();
    if let (true, Some(log)) = (reversing.is_empty(), logs.first()) {
        let expected = "a path on which a joint reverses at least once";
        return Err(Error::bad(Place::file(&log.name), "no joint that reverses", expected));
    }
    let fit = solve::fit(robot, &mut tracks, &reversing).ok_or_else(|| {
        let name = logs.first().map_or("", |l| l.name.as_str());
        Error::bad(Place::file(name), "readings that do not determine any gap", "a longer path")
    })?;
    for log in logs.iter().filter(|l| l.instruments.has_scalar()) {
        plausible(robot, log, setup)?;
    }
    let mut notes: Vec<gaps::Note> = Vec::new();
    if fit.unsettled.is_some() {
        notes.push(Note::NotSettled.into());
    }
    let mut joints = Vec::new();
    let factor = student::factor(0.95, fit.dof.max(1.0));
    for &axis in &reversing {
        let Some(k) = fit.layout.place(Kind::Gap, axis) else { continue };
        let joint = robot.axis(axis);
        let (value, sigma) = (fit.values[k], fit.covariance[(k, k)].max(0.0).sqrt());
        let half = factor * sigma + fit.unsettled.as_ref().map_or(0.0, |moved| moved[k]);
        let limit = DETERMINED[usize::from(joint.kind == JointKind::Prismatic)] * joint.kind.si_per_user_unit();
        if sigma > limit {
            if sigma > UNSEEN {
                notes.push(Note::NotSeen { joint: joint.name.clone() }.into());
                continue;
            }
            notes.push(Note::NotDetermined { joint: joint.name.clone(), kind: joint.kind, sigma }.into());
            continue;
        }
        if value + half < 0.0 {
            notes.push(Note::BelowZero { joint: joint.name.clone(), kind: joint.kind, half_gap: value }.into());
        }
        joints.push(JointGap {
            axis,
            half_gap: value,
            ci95: [value - half, value + half],
            significant: value - half > 0.0,
            sides: None,
            schedule: None,
            varies_p_value: None,
            stiction: None,
            stiction_p_value: None,
        });
    }
    for (log, track) in of_log.iter().map(|l| &logs[*l]).zip(&tracks) {
        if let (Instrument::Distance { centre_m: c }, true) = (track.instrument, setup.centre_m.is_none()) {
            notes.push(gaps::Note::BallbarCentre { log: log.name.clone(), centre_m: c.into() });
        }
    }
    let gaps = Gaps { joints, notes, ..Gaps::new(robot, logs) };
    Ok(ScalarFound {
        gaps,
        instruments: tracks.iter().map(|t| t.instrument).collect(),
        sigma_m: fit.sigma_m,
        correlation: fit.correlation,
    })
}
