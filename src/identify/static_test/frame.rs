//! The tracker's frame, each joint's deviation from its command, and half their difference.
//!
//! Method: registration on the means of both approaches of each setting (the gap moves the two points of a pair
//! symmetrically, so the mean lies on the nominal place up to the square of the gap). Deviation of the tested joint: the
//! projection of the measured point's error onto the joint's column of the Jacobian, iterated (Gauss-Newton in one unknown);
//! several reflectors count together. Where the log holds `meas_<joint>`, deviation is `meas - cmd` and no frame is needed.
//!
//! Fails with an error where commands do not explain the points at all: wrong units, joint order or robot file.

use super::readings::{Pair, Readings};
use super::summary::{HalfGap, Table};
use crate::error::{Error, Place, Result};
use crate::gaps::Registered;
use crate::log::Log;
use crate::log::dwells::Dwell;
use crate::log::registration::{self, Registration};
use crate::robot::{Chain, JointKind, Robot};
use crate::stats::robust::{median, point_mean};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::BTreeMap;

/// A residual above this share of the points' own spread is no calibration error: the inputs do not belong together.
const MISFIT: f64 = 0.1;
/// A joint that moves the TCP by less than this (m per rad, or m per m) cannot be tested through it.
const LEAST_LEVER: f64 = 1e-3;
/// Rounding in the last digit of a tracker's file (0.1 um): repeats cannot agree better, m.
const ROUNDING_M: f64 = 5e-8;
/// Rounding of an angle measured behind the gear (0.000001 deg), rad.
const ROUNDING_RAD: f64 = 1e-8;
/// A step of the one-joint inverse below this (rad or m) ends it.
const SETTLED: f64 = 1e-9;
const ITERATIONS: usize = 20;

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
    pub notes: Vec<String>,
}

/// Finds the frame; `None` where every pair was measured behind its gear.
pub fn find(robot: &Robot, logs: &[Log], readings: &Readings, given: Option<Isometry3<f64>>) -> Result<Option<Frame>> {
    let through_tcp: Vec<&Pair> = readings.pairs.iter().filter(|p| measured(readings, p).is_none()).collect();
    if through_tcp.is_empty() {
        return Ok(None);
    }
    let chains = chains(robot, logs);
    let mut settings: BTreeMap<usize, Vec<&Pair>> = BTreeMap::new();
    for &pair in &through_tcp {
        settings.entry(pair.setting).or_default().push(pair);
    }
    let mut points = Vec::new();
    for pairs in settings.values() {
        for (k, chain) in chains.iter().enumerate() {
            let (mut base, mut seen) = (Vec::new(), Vec::new());
            for p in pairs {
                let (up, down) = both(readings, p);
                if let (Some(a), Some(b)) = (point(up, k), point(down, k)) {
                    base.push(0.5 * (chain.position(&up.command) + chain.position(&down.command)));
                    seen.push(0.5 * (a + b));
                }
            }
            // over the cycles, without gross errors: a bumped reflector in one of them does not turn the frame
            if let (Some(b), Some(s)) = (point_mean(&base, ROUNDING_M), point_mean(&seen, ROUNDING_M)) {
                points.push(registration::Pair { base_m: b.mean, tracker_m: s.mean });
            }
        }
    }
    let log = logs.first().map_or("", |l| l.name.as_str());
    let mut notes = Vec::new();
    let mut frame = match given {
        Some(frame) => {
            let sum: f64 = points.iter().map(|p| off(p, &frame).norm_squared()).sum();
            let rms_m = (sum / (3.0 * points.len().max(1) as f64)).sqrt();
            let found = Registered { frame, rms_m, samples: points.len(), sigma_m: [0.0; 3], sigma_rad: [0.0; 3] };
            Frame { found, points: points.len(), dropped: 0, points_rms_m: rms_m, given: true, notes: Vec::new() }
        }
        None => {
            let Registration { found, dropped, open_axis } = registration::register_line(&points).map_err(|e| {
                let found = match e {
                    Error::BadInput(b) => b.found,
                    other => other.to_string(),
                };
                Error::bad(
                    Place::file(log),
                    format!("{found} reached from both sides"),
                    "three or more places that differ, so that the tracker's frame can be found; or a model with a `registration`",
                )
            })?;
            if open_axis.is_some() {
                let prismatic = through_tcp.iter().all(|p| robot.axis(p.axis).kind == JointKind::Prismatic);
                if !prismatic {
                    return Err(Error::bad(
                        Place::file(log),
                        "measured points on one line",
                        "points off that line too: they leave the frame open about it; or a model with a `registration`",
                    ));
                }
                notes.push("the measured points lie on one line: the frame is open about it (rank 5 of 6); motion along the line does not depend on that".into());
            }
            if !dropped.is_empty() {
                let (off, all) = (dropped.len(), points.len());
                notes.push(format!(
                    "{off} of {all} points disagree with the rest and were left out of the registration"
                ));
            }
            let rms_m = found.rms_m;
            let used = points.len() - dropped.len();
            Frame { found, points: used, dropped: dropped.len(), points_rms_m: rms_m, given: false, notes: Vec::new() }
        }
    };
    frame.notes = notes;
    refuse_misfit(log, &points, &frame)?;
    rms_of_samples(readings, &through_tcp, &chains, &mut frame);
    Ok(Some(frame))
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
    let typical = crate::stats::robust::median_of(&mut errors).unwrap_or(0.0);
    if typical <= MISFIT * spread {
        return Ok(());
    }
    Err(Error::bad(
        Place::file(log),
        format!(
            "points {:.3} mm off (median per coordinate) where they spread by {:.3} mm",
            typical * 1e3,
            spread * 1e3
        ),
        if frame.given {
            "a registration, robot file and logs that belong together"
        } else {
            "commands that explain the measured points: check units (deg, mm), order and sense of the joints, the robot file, and that the tracker stood still over all logs"
        },
    ))
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

/// TCP and the further reflectors that both robot file and logs know.
fn chains(robot: &Robot, logs: &[Log]) -> Vec<Chain> {
    let further = logs.iter().map(|l| l.reflectors_m.len()).max().unwrap_or(0);
    std::iter::once(robot.chain().clone())
        .chain(robot.reflectors_m.iter().take(further).map(|p| robot.chain_to(p)))
        .collect()
}

fn both<'a>(readings: &'a Readings, pair: &Pair) -> (&'a Dwell, &'a Dwell) {
    let found = &readings.dwells[pair.log];
    (&found[pair.up], &found[pair.down])
}

fn point(dwell: &Dwell, k: usize) -> Option<Vector3<f64>> {
    dwell.points.get(k)?.map(|p| p.mean)
}

/// Deviations of both dwells where the joint was measured behind its gear.
fn measured(readings: &Readings, pair: &Pair) -> Option<(f64, f64)> {
    let (up, down) = both(readings, pair);
    let of = |d: &Dwell| Some(d.meas.get(pair.axis).copied()?? - d.command[pair.axis]);
    Some((of(up)?, of(down)?))
}

/// Deviation of one joint in one dwell.
struct Deviation {
    value: f64,
    /// m per rad, or m per m.
    lever: f64,
    samples: usize,
    sum_squares_m2: f64,
    /// Variance of the mean of the dwell, as a joint value.
    variance: f64,
}

/// How far joint `axis` stands from its command, by the reflectors of `mask`.
fn deviation(
    chains: &[Chain],
    inverse: &Isometry3<f64>,
    dwell: &Dwell,
    axis: usize,
    mask: &[bool],
) -> Option<Deviation> {
    let mut q = dwell.command.clone();
    let mut columns = vec![Vector3::zeros(); q.len()];
    let used = |k: usize| mask[k].then(|| dwell.points.get(k).copied().flatten()).flatten();
    let (mut value, mut lever2) = (0.0, 0.0);
    for _ in 0..ITERATIONS {
        let (mut along, mut count) = (0.0, 0usize);
        lever2 = 0.0;
        for (k, chain) in chains.iter().enumerate() {
            let Some(p) = used(k) else { continue };
            let error = (inverse * Point3::from(p.mean)).coords - chain.position_and_jacobian(&q, &mut columns);
            along += error.dot(&columns[axis]);
            lever2 += columns[axis].norm_squared();
            count += 1;
        }
        if count == 0 || lever2 / (count as f64) < LEAST_LEVER.powi(2) {
            return None;
        }
        let step = along / lever2;
        value += step;
        q[axis] += step;
        if step.abs() < SETTLED {
            break;
        }
    }
    let (mut sum, mut samples, mut scatter) = (0.0, 0usize, 0.0);
    for (k, chain) in chains.iter().enumerate() {
        let Some(p) = used(k) else { continue };
        let error = (inverse * Point3::from(p.mean)).coords - chain.position(&q);
        sum += p.sum_squares + p.used as f64 * error.norm_squared();
        samples += p.used;
        scatter += p.sum_squares;
    }
    let reflectors = mask.iter().filter(|&&m| m).count().max(1) as f64;
    let (n, dof) = (samples as f64 / reflectors, 3.0 * (samples as f64 - reflectors));
    let variance = if dof > 0.0 { scatter / dof / n / lever2 } else { 0.0 };
    let lever = (lever2 / reflectors).sqrt();
    Some(Deviation { value, lever, samples, sum_squares_m2: sum, variance })
}

/// Half gaps of every pair, as one table per joint; pairs that cannot be read are noted.
pub fn half_gaps(robot: &Robot, logs: &[Log], readings: &mut Readings, frame: Option<&Frame>) -> Vec<Table> {
    let chains = chains(robot, logs);
    let inverse = frame.map(|f| f.found.frame.inverse());
    let mut tables = Vec::new();
    for axis in 0..robot.dof() {
        let joint = robot.axis(axis);
        let mut places: BTreeMap<usize, (Vec<f64>, Vec<HalfGap>)> = BTreeMap::new();
        let (mut lost, mut blind, mut measured_pairs) = (0usize, 0usize, 0usize);
        let (mut levers, mut strokes) = (Vec::new(), f64::INFINITY);
        for p in readings.pairs.iter().filter(|p| p.axis == axis) {
            let (up, down) = both(readings, p);
            let read = if let Some((a, b)) = measured(readings, p) {
                measured_pairs += 1;
                Some((a, b, 0.0))
            } else {
                let mask: Vec<bool> =
                    (0..chains.len()).map(|k| point(up, k).is_some() && point(down, k).is_some()).collect();
                if mask.iter().any(|&m| m) {
                    let of = |d| deviation(&chains, inverse.as_ref()?, d, axis, &mask);
                    let read = of(up).zip(of(down));
                    blind += usize::from(read.is_none());
                    read.map(|(a, b)| {
                        levers.push(a.lever);
                        (a.value, b.value, 0.25 * (a.variance + b.variance))
                    })
                } else {
                    lost += 1;
                    None
                }
            };
            let Some((going_up, going_down, variance)) = read else { continue };
            strokes = [up, down].iter().filter_map(|d| d.approach).map(|a| a.stroke).fold(strokes, f64::min);
            let (at, values) = places.entry(p.place).or_default();
            at.extend([up.command[axis], down.command[axis]]);
            // reached going up the joint stands half a gap below its command, going down half a gap above
            values.push(HalfGap { value: 0.5 * (going_down - going_up), variance_in_dwell: variance });
        }
        if lost > 0 {
            readings.notes.push(format!("{}: pairs left out, without the tracker: {lost}", joint.name));
        }
        if blind > 0 {
            readings.notes.push(format!(
                "{}: pairs left out, as the joint moves the TCP by less than {} mm per radian there: {blind}",
                joint.name,
                LEAST_LEVER * 1e3
            ));
        }
        if places.is_empty() {
            continue;
        }
        let measured = levers.is_empty() && measured_pairs > 0;
        let rounding = if measured {
            if joint.kind == JointKind::Revolute { ROUNDING_RAD } else { ROUNDING_M }
        } else {
            ROUNDING_M / median(&levers).max(LEAST_LEVER)
        };
        tables.push(Table {
            axis,
            places: places
                .into_values()
                .map(|(at, values)| (at.iter().sum::<f64>() / at.len() as f64, values))
                .collect(),
            rounding,
            least_stroke: strokes,
            unpaired: readings.unpaired[axis],
            measured,
        });
    }
    tables
}
