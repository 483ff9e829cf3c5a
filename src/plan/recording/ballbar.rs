//! Circles about the centre of a double ballbar, at the bar's length: what such an instrument can follow.
//!
//! The TCP stays on the sphere of the bar's length about the centre and keeps its orientation: the whole circle in the horizontal plane,
//! and arcs in two vertical planes, through the zenith or, where a joint ends there, through the nadir, as far as the arm reaches, each
//! both ways round. From one to the next the TCP moves on the sphere as well, so that the bar stays in its seats. (ISO 230-4 has the
//! circle; its mounting leaves 220 degrees upright.)
//!
//! Method: start directions and orientations are tried in a fixed order; the joints of a pose follow by the inverse, and a way counts where
//! they are within their ranges and change little from step to step. Of the first few ways that can be moved the one is taken that
//! determines most joints, and those best.

use super::motions::Rows;
use super::note::{Note, Reason};
use super::options::Options;
use super::posture;
use super::precision::{self, Precision};
use crate::error::{Error, Result};
use crate::identify::scalar::largest_determined_sigma;
use crate::plan::path::{Envelope, rounded};
use crate::robot::arm::Arm;
use crate::robot::{InverseOptions, Pose, Robot, Target};
use nalgebra::{Rotation3, Unit, Vector3};
use std::f64::consts::{PI, TAU};

/// Turns of the whole circle each way.
const TURNS: f64 = 2.0;
/// Ends of the arcs in vertical planes, the first that can be reached: over the zenith, deg; each is tried through the nadir, too.
const ARCS_DEG: [[f64; 2]; 8] =
    [[200.0, -20.0], [180.0, 0.0], [150.0, 0.0], [120.0, 0.0], [90.0, 0.0], [60.0, 0.0], [30.0, -30.0], [30.0, 0.0]];
/// The same where not even the circle can be reached whole: swings in the horizontal plane, deg.
const SWINGS_DEG: [f64; 4] = [360.0, 270.0, 180.0, 90.0];
/// Start directions and orientations that are tried, and ways that are compared.
const STARTS: usize = 12;
const ORIENTATIONS: usize = 40;
const COMPARED: usize = 6;
/// Step of the first look along a way, rad, and the largest change of a joint over it that is no jump, rad or m.
const STEP: f64 = PI / 36.0;
const JUMP: [f64; 2] = [0.35, 0.2];
/// Part of a joint's range that is kept free at either end where that is possible, and of its largest speed and acceleration that is used.
const MARGIN: f64 = 0.02;
/// Part of a joint's range by which the inverse may miss its end.
const ROUNDING: f64 = 1e-9;
const SHARE: f64 = 0.5;
/// Acceleration of the TCP: the working speed in this time, s.
const SPEED_UP_S: f64 = 0.5;
/// Digits of a program below which a joint stands still.
const HELD: f64 = 2e-6;

/// A plan: pose at the start, rows, what every joint's gap will be known to, words.
pub struct Circles {
    pub pose: Vec<f64>,
    pub rows: Rows,
    pub precision: Vec<Precision>,
    pub notes: Vec<Note>,
}

/// An arc on the sphere: it turns about `axis` by `angle`, rad.
#[derive(Debug, Clone, Copy)]
struct Arc {
    axis: Unit<Vector3<f64>>,
    angle: f64,
}

/// A start and what follows it.
#[derive(Debug, Clone)]
struct Way {
    start: Vector3<f64>,
    arcs: Vec<Arc>,
    orientation: Rotation3<f64>,
    q: Vec<f64>,
    notes: Vec<Note>,
}

/// What moves: the arm, the bar.
struct Bar<'a> {
    robot: &'a Robot,
    arm: Option<Arm>,
    centre_m: Vector3<f64>,
    length_m: f64,
    /// Part of a joint's range that is kept free at either end.
    margin: f64,
}

/// Plans circles about `centre_m` with a bar of `length_m`.
///
/// # Errors
/// Where no arc about that centre can be reached.
pub fn plan(robot: &Robot, centre_m: Vector3<f64>, length_m: f64, options: &Options) -> Result<Circles> {
    let mut bar = Bar { robot, arm: Arm::of(robot), centre_m, length_m, margin: MARGIN };
    let mut best = bar.best(options);
    if best.as_ref().is_none_or(|b| b.told < robot.dof()) {
        // what keeps off the ends of the ranges tells less than all: up to the ends
        bar.margin = 0.0;
        best = match (best, bar.best(options)) {
            (Some(free), Some(whole)) if whole.told <= free.told => Some(free),
            (free, whole) => whole.or(free),
        };
    }
    let mut found = best.map(|b| b.circles).ok_or_else(|| bar.out_of_reach())?;
    let notes = [bar.at_ends(&found.rows), Some(excited(robot, &found.precision)), not_told(robot, &found.precision)];
    found.notes.extend(notes.into_iter().flatten());
    Ok(found)
}

/// A way that can be moved, and what it determines.
struct Found {
    /// Joints whose gaps it tells.
    told: usize,
    /// Sum of the logarithms of their standard deviations.
    cost: f64,
    circles: Circles,
}

/// Which joints the circles reverse, how often, and whose gaps they tell.
fn excited(robot: &Robot, precision: &[Precision]) -> Note {
    let name = |p: &Precision| robot.axis(p.axis).name.clone();
    let reversing = precision.iter().filter(|p| p.reversals > 0);
    let reversals: Vec<(String, usize)> = reversing.map(|p| (name(p), p.reversals)).collect();
    if reversals.is_empty() {
        return Note::NoReversal;
    }
    Note::Reverses { reversals, told: precision.iter().filter(|p| p.sigma.is_some()).map(name).collect() }
}

/// Joints whose gaps the circles do not tell.
fn not_told(robot: &Robot, precision: &[Precision]) -> Option<Note> {
    let unknown = precision.iter().filter(|p| p.sigma.is_none());
    let joints: Vec<String> = unknown.map(|p| robot.axis(p.axis).name.clone()).collect();
    (!joints.is_empty()).then_some(Note::NotTold { joints })
}

/// A joint whose gap `identify` would not give is not determined.
fn honest(robot: &Robot, p: &mut Precision) {
    let joint = robot.axis(p.axis);
    let limit = largest_determined_sigma(joint.kind);
    if let Some(sigma) = p.sigma.filter(|s| *s > limit) {
        p.sigma = None;
        p.reason = Some(Reason::AsOthers { kind: joint.kind, sigma });
    }
}

impl Bar<'_> {
    /// The way that determines most joints, and those best, of the first that can be moved.
    fn best(&self, options: &Options) -> Option<Found> {
        let mut best: Option<Found> = None;
        for way in self.ways(options).into_iter().take(COMPARED) {
            let Some(rows) = self.timed(&way, options) else { continue };
            let mut precision = precision::of_motion(self.robot, &rows, options);
            precision.iter_mut().for_each(|p| honest(self.robot, p));
            let told = precision.iter().filter(|p| p.sigma.is_some()).count();
            let cost: f64 = precision.iter().filter_map(|p| p.sigma).map(f64::ln).sum();
            if best.as_ref().is_none_or(|b| told > b.told || (told == b.told && cost < b.cost)) {
                let circles = Circles { pose: rows[0].1.clone(), rows, precision, notes: way.notes.clone() };
                best = Some(Found { told, cost, circles });
            }
        }
        best
    }

    /// Joints that come near the ends of their ranges.
    fn at_ends(&self, rows: &Rows) -> Option<Note> {
        let near = |axis: &usize| {
            self.robot.axis(*axis).limits.is_some_and(|[lo, hi]| {
                let keep = MARGIN * (hi - lo) * (1.0 - ROUNDING);
                rows.iter().any(|r| r.1[*axis] < lo + keep || r.1[*axis] > hi - keep)
            })
        };
        let joints: Vec<String> =
            (0..self.robot.dof()).filter(near).map(|axis| self.robot.axis(axis).name.clone()).collect();
        (!joints.is_empty()).then_some(Note::NearEnds { joints, margin: MARGIN })
    }

    fn out_of_reach(&self) -> Error {
        let c = self.centre_m * 1e3;
        let found = format!(
            "a bar of {:.0} mm about {:.0}, {:.0}, {:.0} mm, on no arc of which the arm stays within its ranges",
            self.length_m * 1e3,
            c.x,
            c.y,
            c.z
        );
        Error::setting("ballbar", found, "a centre whose circle the arm reaches, a shorter bar, or another pose")
            .mended_by(&["bar_mm", "pose"])
    }

    /// Ways that can be moved, in the order in which they were tried.
    fn ways(&self, options: &Options) -> Vec<Way> {
        let seeds = match &options.pose {
            Some(pose) => vec![pose.clone()],
            None => posture::candidates(self.robot, ORIENTATIONS),
        };
        let mut out: Vec<Way> = Vec::new();
        for seed in &seeds {
            let orientation = self.robot.forward(seed).rotation;
            for k in 0..STARTS {
                let azimuth = TAU * k as f64 / STARTS as f64;
                let start = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
                let ways = self.starts(&start, &orientation, seed).into_iter();
                out.extend(ways.filter_map(|q| self.way(start, azimuth, orientation, q)));
                if out.len() >= 4 * COMPARED {
                    break;
                }
            }
            if out.len() >= 4 * COMPARED {
                break;
            }
        }
        // those that reach farthest first; among equals the order of trial
        let length = |w: &Way| w.arcs.iter().map(|a| a.angle.abs()).sum::<f64>();
        out.sort_by(|a, b| length(b).total_cmp(&length(a)));
        out
    }

    /// Joints at the start of a way.
    fn starts(&self, start: &Vector3<f64>, orientation: &Rotation3<f64>, seed: &[f64]) -> Vec<Vec<f64>> {
        let pose = self.pose(start, orientation);
        match &self.arm {
            Some(arm) => {
                let all = arm.solutions(self.robot, &pose, seed);
                all.into_iter().filter(|q| self.inside(q)).collect()
            }
            None => self.joints(&pose, seed).filter(|q| self.inside(q)).into_iter().collect(),
        }
    }

    fn pose(&self, direction: &Vector3<f64>, orientation: &Rotation3<f64>) -> Pose {
        Pose { position: self.centre_m + direction * self.length_m, rotation: *orientation }
    }

    /// Joints of a pose near others.
    fn joints(&self, pose: &Pose, near: &[f64]) -> Option<Vec<f64>> {
        if let Some(arm) = &self.arm {
            return arm.nearest(self.robot, pose, near);
        }
        let target = match self.robot.dof() {
            0..=5 => Target::Position(pose.position),
            _ => Target::Pose(*pose),
        };
        let found = self.robot.inverse(&target, near, &InverseOptions::default());
        found.converged().then_some(found.q)
    }

    fn inside(&self, q: &[f64]) -> bool {
        self.robot.axis_joints().zip(q).all(|(j, v)| {
            j.limits.is_none_or(|[lo, hi]| {
                let keep = (self.margin - ROUNDING) * (hi - lo);
                *v >= lo + keep && *v <= hi - keep
            })
        })
    }

    /// The joints at the end of an arc; `None` where the arm cannot follow.
    fn along(&self, from: &Vector3<f64>, arc: &Arc, orientation: &Rotation3<f64>, q: &[f64]) -> Option<Vec<f64>> {
        let steps = (arc.angle.abs() / STEP).ceil().max(1.0) as usize;
        let mut q = q.to_vec();
        for i in 1..=steps {
            let direction = turned(from, arc, i as f64 / steps as f64);
            let next = self.joints(&self.pose(&direction, orientation), &q)?;
            let jumps =
                self.robot.axis_joints().zip(next.iter().zip(&q)).any(|(j, (a, b))| (a - b).abs() > j.kind.pick(JUMP));
            if jumps || !self.inside(&next) {
                return None;
            }
            q = next;
        }
        Some(q)
    }

    /// All arcs that can be moved from a start.
    fn way(&self, start: Vector3<f64>, azimuth: f64, orientation: Rotation3<f64>, q: Vec<f64>) -> Option<Way> {
        let up = Unit::new_unchecked(Vector3::z());
        let swing = SWINGS_DEG.into_iter().find(|deg| {
            let arc = Arc { axis: up, angle: deg.to_radians() };
            let end = self.along(&start, &arc, &orientation, &q);
            // after a whole turn the arm stands where it began
            end.is_some_and(|end| *deg < 360.0 || end.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-4))
        })?;
        let degrees = azimuth.to_degrees();
        let mut way = Way { start, arcs: Vec::new(), orientation, q, notes: Vec::new() };
        let turns = if swing == 360.0 { TURNS } else { 1.0 };
        let angle = swing.to_radians() * turns;
        let times = if swing == 360.0 { 1 } else { 2 };
        for _ in 0..times {
            way.arcs.extend([angle, -angle].map(|angle| Arc { axis: up, angle }));
        }
        let start_m = self.pose(&start, &orientation).position.into();
        way.notes.push(match swing == 360.0 {
            true => Note::Circle { radius_m: self.length_m, turns: TURNS, start_m },
            false => Note::Swing { swing_deg: swing, start_m },
        });
        let first = way.q.clone();
        self.upright(&mut way, start, first, degrees);
        // the second vertical plane, a quarter of the circle further
        let quarter = Arc { axis: up, angle: 0.5 * PI };
        if swing >= 90.0
            && let Some(there) = self.along(&start, &quarter, &orientation, &way.q)
        {
            let before = way.arcs.len();
            way.arcs.push(quarter);
            if self.upright(&mut way, turned(&start, &quarter, 1.0), there, degrees + 90.0) {
                way.arcs.push(Arc { angle: -quarter.angle, ..quarter });
            } else {
                way.arcs.truncate(before);
            }
        }
        Some(way)
    }

    /// Adds arcs in the vertical plane through a horizontal direction; `false` where none can be reached.
    fn upright(&self, way: &mut Way, from: Vector3<f64>, q: Vec<f64>, azimuth_deg: f64) -> bool {
        let axis = Unit::new_normalize(from.cross(&Vector3::z()));
        let arc = |deg: f64| Arc { axis, angle: deg.to_radians() };
        let reached = |deg: f64| deg == 0.0 || self.along(&from, &arc(deg), &way.orientation, &q).is_some();
        let through_either = ARCS_DEG.into_iter().flat_map(|[end, start]| [[end, start], [-end, -start]]);
        let Some([high, low]) = through_either.into_iter().find(|ends| ends.iter().all(|deg| reached(*deg))) else {
            way.notes.push(Note::NotUpright { azimuth_deg });
            return false;
        };
        way.arcs.extend([high, low - high, high - low, -high].map(arc));
        way.notes.push(Note::Upright { azimuth_deg, ends_deg: [low, high] });
        true
    }

    /// Rows of a way, as often as the time allows, slower where a joint could not keep up; `None` where it cannot be followed closely.
    fn timed(&self, way: &Way, options: &Options) -> Option<Rows> {
        let envelope = Envelope::new(self.robot, &super::envelope_options(way.q.clone(), options.duration_s, options));
        let mut speed = options.speed_m_s;
        for _ in 0..8 {
            let rows = self.rows(way, speed, &envelope)?;
            let over = self.over(&rows, envelope.step_s);
            if over <= 1.0 {
                let once = rows.len() as f64 * envelope.step_s;
                let times = ((options.duration_s / once).floor() as usize).max(1);
                let mut all = rows.clone();
                for _ in 1..times {
                    all.extend(rows.iter().skip(1).cloned());
                }
                return Some(all.into_iter().enumerate().map(|(i, q)| (i as f64 * envelope.step_s, q)).collect());
            }
            speed /= 1.05 * over;
        }
        None
    }

    /// Joint vectors an interval apart, at rest at the ends of every arc.
    fn rows(&self, way: &Way, speed_m_s: f64, envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
        let mut rows = vec![way.q.clone()];
        let (mut from, mut q) = (way.start, way.q.clone());
        for arc in &way.arcs {
            let length = arc.angle.abs() * self.length_m;
            let up_s = SPEED_UP_S.min((length * SPEED_UP_S / speed_m_s).sqrt());
            let top = speed_m_s * up_s / SPEED_UP_S;
            let whole_s = length / top + up_s;
            let n = (whole_s / envelope.step_s).ceil().max(2.0);
            for i in 1..=n as usize {
                let share = travelled(whole_s * i as f64 / n, up_s, whole_s) * top / length;
                let direction = turned(&from, arc, share.min(1.0));
                q = self.joints(&self.pose(&direction, &way.orientation), &q)?;
                rows.push(q.clone());
            }
            from = turned(&from, arc, 1.0);
        }
        self.hold(&mut rows);
        (0..rows[0].len()).all(|a| (rows[rows.len() - 1][a] - rows[0][a]).abs() < 1e-6).then(|| {
            let first = rows[0].clone();
            if let Some(last) = rows.last_mut() {
                *last = first;
            }
            rows
        })
    }

    /// Rounds to the digits of a program; a joint that changes by less than two of them stands still.
    fn hold(&self, rows: &mut [Vec<f64>]) {
        for axis in 0..self.robot.dof() {
            let kind = self.robot.axis(axis).kind;
            let mut held = f64::INFINITY;
            for row in rows.iter_mut() {
                if (row[axis] - held).abs() > HELD * kind.si_per_user_unit() {
                    held = rounded(kind, row[axis]);
                    if let Some([lo, hi]) = self.robot.axis(axis).limits {
                        held = held.max(lo).min(hi);
                    }
                }
                row[axis] = held;
            }
        }
    }

    /// By how much the speed of the TCP is too large for the joints.
    fn over(&self, rows: &[Vec<f64>], step_s: f64) -> f64 {
        let mut most: f64 = 0.0;
        for (axis, joint) in self.robot.axis_joints().enumerate() {
            if let Some(limit) = joint.max_speed {
                let fastest = rows.windows(2).map(|w| (w[1][axis] - w[0][axis]).abs()).fold(0.0, f64::max) / step_s;
                most = most.max(fastest / (SHARE * limit));
            }
            if let Some(limit) = joint.max_accel {
                let change = |w: &[Vec<f64>]| (w[2][axis] - 2.0 * w[1][axis] + w[0][axis]).abs();
                let hardest = rows.windows(3).map(change).fold(0.0, f64::max) / (step_s * step_s);
                most = most.max((hardest / (SHARE * limit)).sqrt());
            }
        }
        most
    }
}

/// A direction some share along an arc.
fn turned(from: &Vector3<f64>, arc: &Arc, share: f64) -> Vector3<f64> {
    Rotation3::from_axis_angle(&arc.axis, arc.angle * share) * from
}

/// Way at top speed 1 after `t` of a trapezoid that lasts `whole`, with `up` to speed up and to slow down.
fn travelled(t: f64, up: f64, whole: f64) -> f64 {
    if t < up {
        0.5 * t * t / up
    } else if t > whole - up {
        whole - up - 0.5 * (whole - t).powi(2) / up
    } else {
        t - 0.5 * up
    }
}
