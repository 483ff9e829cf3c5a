//! Half gaps from one reading a row: a double ballbar, a draw wire, a dial gauge along a path (ISO 230-4 for the ballbar's circle), or
//! from sensors of joints.
//!
//! Method: Gauss-Newton on all logs at once. What is fitted: the half gap of every joint that reverses, a fading spike after its
//! reversals and a lag of every joint that moves, a zero offset of every joint, and what the instrument does not know of itself
//! (centre and length of a ballbar, zero and tilt of a dial; [`crate::machine::measurement`]). Gaps are free; the rest has weak
//! priors ([`design`]), so that a single reading a row is enough. Residuals are whitened by an autoregressive model of first order
//! that is estimated from them ([`solve`]). `setup` holds the instrument as the user gives it, and refuses readings that no robot makes.
//!
//! A single reading does not see every joint. One whose standard deviation is too large for a gap of the usual size is listed as
//! not determined, with the reason, and gets no gap.
//!
//! Assumptions: constant gaps; geometry errors as zero offsets and what an autoregressive noise takes up.

mod centre;
pub(crate) mod design;
pub(crate) mod setup;
pub(crate) mod solve;

use crate::error::{Error, Place, Result, counted};
use crate::gaps::note::scalar::Note;
use crate::gaps::{self, Gaps, JointGap};
use crate::identify::gears::geared;
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::numerics::student;
use crate::robot::{JointKind, Robot};
pub(crate) use design::prior_unit;
use design::{Kind, Track};
pub(crate) use setup::refuse_still;
pub use setup::{LEAST_ROWS, Setup, instrument, plausible};

/// A half gap is determined where its standard deviation is below this: deg, mm.
const DETERMINED: [f64; 2] = [0.003, 0.01];

/// Standard deviation of a half gap, rad or m, above which it is not determined.
pub(crate) fn largest_determined_sigma(kind: JointKind) -> f64 {
    kind.pick(DETERMINED) * kind.si_per_user_unit()
}

/// Standard deviation of a half gap, rad or m, from which a reading does not see the joint at all.
const UNSEEN: f64 = 0.1;

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
    let joints = reversing.iter().filter_map(|&axis| joint_gap(robot, &fit, axis, &mut notes)).collect();
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

/// The gap of an axis with its interval; `None`, with a note, where the readings do not determine it.
fn joint_gap(robot: &Robot, fit: &solve::Fit, axis: usize, notes: &mut Vec<gaps::Note>) -> Option<JointGap> {
    let k = fit.layout.place(Kind::Gap, axis)?;
    let joint = robot.axis(axis);
    let (value, sigma) = (fit.values[k], fit.covariance[(k, k)].max(0.0).sqrt());
    if sigma > UNSEEN {
        notes.push(Note::NotSeen { joint: joint.name.clone() }.into());
        return None;
    }
    if sigma > largest_determined_sigma(joint.kind) {
        notes.push(Note::NotDetermined { joint: joint.name.clone(), kind: joint.kind, sigma }.into());
        return None;
    }
    let factor = student::factor(0.95, fit.dof.max(1.0));
    let half = factor * sigma + fit.unsettled.as_ref().map_or(0.0, |moved| moved[k]);
    if value + half < 0.0 {
        notes.push(Note::BelowZero { joint: joint.name.clone(), kind: joint.kind, half_gap: value }.into());
    }
    Some(JointGap {
        axis,
        half_gap: value,
        ci95: [value - half, value + half],
        significant: value - half > 0.0,
        sides: None,
        schedule: None,
        varies_p_value: None,
        stiction: None,
        stiction_p_value: None,
    })
}
