//! The tracker's frame, from the means of both approaches of each setting.
//!
//! Method: the gap moves the two points of a pair to either side of the nominal place, so their mean lies on it up to the square
//! of the gap; where the gap is large ([`LARGE_RAD`]) the frame is found again with the points where that gap puts them.
//! The single measurements' residual, with each dwell's own deviation taken out, is the tracker's noise.
//!
//! Fails with an error where commands do not explain the points at all: wrong units, joint order or robot file.

use super::deviation::{ROUNDING_M, both, chains, deviation, half_gap, measured, point};
use super::readings::{Pair, Readings};
use crate::error::{Error, Place, Result};
use crate::gaps::note::static_test::Note;
use crate::gaps::{Distrust, Registered};
use crate::log::Log;
use crate::log::dwells::Dwell;
use crate::log::plausibility::CALIBRATION_M;
use crate::log::registration::{self, Registration};
use crate::numerics::robust::point_mean;
use crate::robot::{Chain, JointKind, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::BTreeMap;

/// A residual above this share of the points' own spread is no calibration error: the inputs do not belong together.
const MISFIT: f64 = 0.1;
/// A half gap above this (rad) bends its pair's mean off the nominal place by 5e-7 of the lever, or more.
const LARGE_RAD: f64 = 1e-3;
/// Rounds of frame and gap, alternately: each takes the error of the gap down by the square of the gap.
const ROUNDS: usize = 4;

/// The tracker's frame and how it was found.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Residual and samples are those of the single measurements in the dwells, with each dwell's deviation taken out.
    pub found: Registered,
    /// Points (mean of both approaches) that were used, and those left out as gross errors.
    pub points: usize,
    pub dropped: usize,
    /// Residual of those points per coordinate, m: geometry errors of the robot show here.
    pub points_rms_m: f64,
    /// Taken from a model, not estimated.
    pub given: bool,
    pub notes: Vec<Note>,
    /// Why the robot file may be another arm's.
    pub distrust: Option<Distrust>,
}

/// Finds the frame; `None` where every pair was measured after its gear.
pub fn find(robot: &Robot, logs: &[Log], readings: &Readings, given: Option<Isometry3<f64>>) -> Result<Option<Frame>> {
    let seen = |p: &&Pair| measured(readings, p).is_none() && !logs[p.log].tcp_m.is_empty();
    let through_tcp: Vec<&Pair> = readings.pairs.iter().filter(seen).collect();
    if through_tcp.is_empty() {
        return Ok(None);
    }
    let chains = chains(robot, logs);
    let log = logs.first().map_or("", |l| l.name.as_str());
    let mut points = points(readings, &through_tcp, &chains, |_| 0.0);
    let mut frame = match given {
        Some(frame) => taken(&points, frame),
        None => {
            let only_prismatic = through_tcp.iter().all(|p| robot.axis(p.axis).kind == JointKind::Prismatic);
            let mut found = register(log, &points, only_prismatic)?;
            for _ in 0..ROUNDS {
                // the middle of two places on an arc lies inside it: let the points stand where the gap puts them
                let inverse = found.found.frame.inverse();
                let half = |p: &Pair| half_gap(&chains, &inverse, readings, p).map_or(0.0, |h| h.value);
                if !through_tcp
                    .iter()
                    .any(|p| robot.axis(p.axis).kind == JointKind::Revolute && half(p).abs() > LARGE_RAD)
                {
                    break;
                }
                points = self::points(readings, &through_tcp, &chains, half);
                found = register(log, &points, only_prismatic)?;
            }
            found
        }
    };
    refuse_misfit(log, &points, &frame)?;
    frame.distrust = another_arm(&points, &frame.found.frame);
    rms_of_samples(readings, &through_tcp, &chains, &mut frame);
    Ok(Some(frame))
}

/// Mean of both approaches of each setting and reflector, over its cycles, with the tested joint `half` on either side.
fn points(
    readings: &Readings,
    pairs: &[&Pair],
    chains: &[Chain],
    half: impl Fn(&Pair) -> f64,
) -> Vec<registration::Pair> {
    let mut settings: BTreeMap<usize, Vec<&Pair>> = BTreeMap::new();
    for &pair in pairs {
        settings.entry(pair.setting).or_default().push(pair);
    }
    let mut points = Vec::new();
    for pairs in settings.values() {
        for (k, chain) in chains.iter().enumerate() {
            let (mut base, mut seen) = (Vec::new(), Vec::new());
            for p in pairs {
                let (up, down) = both(readings, p);
                if let (Some(a), Some(b)) = (point(up, k), point(down, k)) {
                    let gap = half(p);
                    let stands = |d: &Dwell, off: f64| {
                        let mut q = d.command.clone();
                        q[p.axis] += off;
                        chain.position(&q)
                    };
                    base.push(0.5 * (stands(up, -gap) + stands(down, gap)));
                    seen.push(0.5 * (a + b));
                }
            }
            // without gross errors: a bumped reflector in one cycle does not turn the frame
            if let (Some(b), Some(s)) = (point_mean(&base, ROUNDING_M), point_mean(&seen, ROUNDING_M)) {
                points.push(registration::Pair { base_m: b.mean, tracker_m: s.mean });
            }
        }
    }
    points
}

/// A frame that is known.
fn taken(points: &[registration::Pair], frame: Isometry3<f64>) -> Frame {
    let sum: f64 = points.iter().map(|p| off(p, &frame).norm_squared()).sum();
    let rms_m = (sum / (3.0 * points.len().max(1) as f64)).sqrt();
    let found = Registered { frame, rms_m, samples: points.len(), sigma_m: [0.0; 3], sigma_rad: [0.0; 3] };
    Frame {
        found,
        points: points.len(),
        dropped: 0,
        points_rms_m: rms_m,
        given: true,
        notes: Vec::new(),
        distrust: None,
    }
}

/// A frame from the points; a line of points is enough for prismatic joints along it.
fn register(log: &str, points: &[registration::Pair], only_prismatic: bool) -> Result<Frame> {
    let Registration { found, dropped, open_axis } = registration::register_line(points).map_err(|e| {
        let found = match e {
            Error::BadInput(b) => b.found,
            other => other.to_string(),
        };
        Error::bad(
            Place::file(log),
            format!("{found} reached from both sides"),
            "three or more different positions, which determine the tracker's frame; or a model with a `registration`",
        )
    })?;
    let mut notes = Vec::new();
    if open_axis.is_some() {
        if !only_prismatic {
            return Err(Error::bad(
                Place::file(log),
                "measured points on one line",
                "points that do not lie on one line (a line does not determine the rotation of the frame about it); or a model with a `registration`",
            ));
        }
        notes.push(Note::OnOneLine);
    }
    if !dropped.is_empty() {
        notes.push(Note::PointsLeftOut { dropped: dropped.len(), points: points.len() });
    }
    let (points_rms_m, used) = (found.rms_m, points.len() - dropped.len());
    Ok(Frame { found, points: used, dropped: dropped.len(), points_rms_m, given: false, notes, distrust: None })
}

/// Error of a point in the tracker frame, m.
fn off(pair: &registration::Pair, frame: &Isometry3<f64>) -> Vector3<f64> {
    (frame * Point3::from(pair.base_m)).coords - pair.tracker_m
}

fn refuse_misfit(log: &str, points: &[registration::Pair], frame: &Frame) -> Result<()> {
    let n = points.len().max(1) as f64;
    let centre = points.iter().map(|p| p.tracker_m).sum::<Vector3<f64>>() / n;
    let spread = (points.iter().map(|p| (p.tracker_m - centre).norm_squared()).sum::<f64>() / (3.0 * n)).sqrt();
    // gross errors that were left out are no misfit, unless they are many
    let mut errors: Vec<f64> = points.iter().map(|p| off(p, &frame.found.frame).norm() / 3f64.sqrt()).collect();
    let typical = crate::numerics::robust::median_of(&mut errors).unwrap_or(0.0);
    if typical <= MISFIT * spread {
        return Ok(());
    }
    Err(Error::bad(
        Place::file(log),
        format!(
            "points that deviate by {:.3} mm (median per coordinate) and spread by {:.3} mm",
            typical * 1e3,
            spread * 1e3
        ),
        if frame.given {
            "a registration, robot file and logs that belong together"
        } else {
            "commands that explain the measured points: check the units (deg, mm), the order and direction of the joints, the robot file, and that the tracker did not move between the logs"
        },
    ))
}

/// Points that stand further from the robot file's places than an arm's own errors put them.
fn another_arm(points: &[registration::Pair], frame: &Isometry3<f64>) -> Option<Distrust> {
    let mut errors: Vec<f64> = points.iter().map(|p| off(p, frame).norm()).collect();
    errors.sort_by(f64::total_cmp);
    let misfit_m = *errors.get(errors.len() * 9 / 10)?;
    let largest_m = *errors.last()?;
    let distrust = Distrust::FarFromRobotFile { misfit_mm: misfit_m * 1e3, largest_mm: largest_m * 1e3 };
    (misfit_m > CALIBRATION_M).then_some(distrust)
}

/// Residual of the single measurements, with the deviation of each dwell taken out.
fn rms_of_samples(readings: &Readings, pairs: &[&Pair], chains: &[Chain], frame: &mut Frame) {
    let inverse = frame.found.frame.inverse();
    let (mut sum, mut samples) = (0.0, 0usize);
    for p in pairs {
        let (up, down) = both(readings, p);
        for d in [up, down] {
            let mask: Vec<bool> = (0..chains.len()).map(|k| point(d, k).is_some()).collect();
            if let Some(found) = deviation(chains, &inverse, d, p.axis, &mask) {
                sum += found.sum_squares_m2;
                samples += found.samples;
            }
        }
    }
    if samples > 0 {
        frame.found.rms_m = (sum / (3.0 * samples as f64)).sqrt();
        frame.found.samples = samples;
    }
}
