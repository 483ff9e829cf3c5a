//! Ways between targets: a straight TCP path or an arc followed for its joints, and where joints turn on it.
//!
//! Method: the inverse next to the joints before, along poses between start and end (position straight or on the arc through three
//! points, rotation by the shortest turn): in closed form where the arm has one, else damped. It follows the branch on which the robot
//! stands. Where a pose is not reached within [`REACHED_M`] and [`REACHED_RAD`], or the joints leap, nothing is claimed.

use super::poses::Tooled;
use super::turns::{Row, in_order, turning_shares, turns_at_ends};
use crate::numerics::reversal::ReversalDetector;
use crate::program::script::Way;
use crate::robot::arm::{Form, isometry, pose_of};
use crate::robot::{InverseOptions, Pose, Target};
use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A pose counts as reached within these.
const REACHED_M: f64 = 1e-7;
const REACHED_RAD: f64 = 1e-6;
/// Parts of a way at least, and the TCP way and the turn that one part covers at most; beyond [`PARTS`] parts the way alone.
const LEAST_PARTS: usize = 4;
const SHORT_M: f64 = 0.006;
const SHORT_RAD: f64 = 0.05;
const PARTS: usize = 16;
const PART_M: f64 = 0.02;
const MOST_PARTS: usize = 512;
/// Turning points closer than this share of a way are one.
const APART: f64 = 2e-3;
/// A joint that moves further than this in one part has changed its branch, rad or m.
const LEAP: f64 = 0.5;

/// How often a part of a way is halved where joints leap.
const BISECTED: usize = 6;

/// Joints at the end of the way from `from` to a pose of the world: straight, or the arc through `via`; `turned`: the orientation
/// counts.
pub fn follow(
    tooled: &Arc<Tooled>,
    from: &[f64],
    end: &Isometry3<f64>,
    turned: bool,
    via: Option<Vector3<f64>>,
) -> Option<Vec<f64>> {
    let track = Track::between(isometry(&tooled.robot.forward(from)), *end, via)?;
    along(tooled, &track, turned, from)?.pop()
}

/// The same on a straight way on which external axes move, to `external`: they go as the TCP does, by the same share of their ways.
pub fn follow_carried(tooled: &Arc<Tooled>, from: &[f64], end: &Isometry3<f64>, external: &[f64]) -> Option<Vec<f64>> {
    let track = Track::between(isometry(&tooled.robot.forward(from)), *end, None)?;
    along(tooled, &track.carried(from, external), true, from)?.pop()
}

/// Where the TCP goes.
#[derive(Debug, Clone)]
struct Track {
    start: Isometry3<f64>,
    end: Isometry3<f64>,
    arc: Option<Circle>,
    /// External axes at the start and at the end; none where no axes carry the arm.
    external: [Vec<f64>; 2],
}

/// The part of a circle from a start on.
#[derive(Debug, Clone)]
struct Circle {
    centre: Vector3<f64>,
    normal: Unit<Vector3<f64>>,
    /// From the centre to the start.
    from: Vector3<f64>,
    /// rad, above 0.
    angle: f64,
    /// Share of the angle at which the second point stands.
    via: f64,
}

/// Of an arc through three points those in the middle of both parts; `None`: the three lie on a line.
pub fn middles([a, b, c]: [&Vector3<f64>; 3]) -> Option<[Vector3<f64>; 2]> {
    let circle = Circle::through(a, b, c)?;
    Some([circle.at(0.5 * circle.via), circle.at(0.5 * (1.0 + circle.via))])
}

/// How far the arc through three points leaves that through three others at most, m; `None`: they lie on a line.
pub fn leaves(own: [&Vector3<f64>; 3], other: [&Vector3<f64>; 3]) -> Option<f64> {
    let [own, other] = [own, other].map(|[a, b, c]| Circle::through(a, b, c));
    Some(own?.left_by(&other?))
}

/// Three points lie on a line where the sine of their angle is less.
const STRAIGHT: f64 = 1e-6;
/// Points nearer to each other are one, m: no digit of a program tells them apart, and no controller takes an arc through them.
const ONE_POINT: f64 = 1e-6;

impl Circle {
    /// From `a` over `b` to `c`; `None`: they lie on a line, or two of them are one.
    fn through(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Option<Self> {
        let (u, v) = (b - a, c - a);
        let w = u.cross(&v);
        if u.norm().min(v.norm()).min((c - b).norm()) < ONE_POINT || w.norm() <= STRAIGHT * u.norm() * v.norm() {
            return None;
        }
        let centre = a + (w.cross(&u) * v.norm_squared() + v.cross(&w) * u.norm_squared()) / (2.0 * w.norm_squared());
        let normal = Unit::new_normalize(w);
        let (from, to) = (a - centre, c - centre);
        let angle_of = |to: &Vector3<f64>| normal.dot(&from.cross(to)).atan2(from.dot(to)).rem_euclid(TAU);
        let angle = angle_of(&to);
        Some(Self { centre, normal, from, angle, via: angle_of(&(b - centre)) / angle })
    }

    fn at(&self, share: f64) -> Vector3<f64> {
        self.centre + UnitQuaternion::from_axis_angle(&self.normal, share * self.angle) * self.from
    }

    /// How far another arc leaves this one at most, m; one that goes round the other way leaves it altogether.
    fn left_by(&self, other: &Self) -> f64 {
        if self.normal.dot(&other.normal) <= 0.0 {
            return f64::INFINITY;
        }
        const SAMPLES: u32 = 48;
        let at = |k: u32| self.off(&other.at(f64::from(k) / f64::from(SAMPLES)));
        (0..=SAMPLES).map(at).fold(0.0, f64::max)
    }

    /// Distance of a point from the arc, m.
    fn off(&self, p: &Vector3<f64>) -> f64 {
        let to = p - self.centre;
        let share = self.normal.dot(&self.from.cross(&to)).atan2(self.from.dot(&to)).rem_euclid(TAU) / self.angle;
        let ends = || (p - self.at(0.0)).norm().min((p - self.at(1.0)).norm());
        if share <= 1.0 { (p - self.at(share)).norm() } else { ends() }
    }
}

impl Track {
    /// `None`: no arc goes through the three points.
    fn between(start: Isometry3<f64>, end: Isometry3<f64>, via: Option<Vector3<f64>>) -> Option<Self> {
        let arc = match via {
            Some(via) => Some(Circle::through(&start.translation.vector, &via, &end.translation.vector)?),
            None => None,
        };
        Some(Self { start, end, arc, external: Default::default() })
    }

    /// The same while the first axes go from where they stand at joints `from` to `external`.
    fn carried(mut self, from: &[f64], external: &[f64]) -> Self {
        self.external = [from.iter().take(external.len()).copied().collect(), external.to_vec()];
        self
    }

    /// External axes at a share of the way.
    fn external(&self, share: f64) -> Vec<f64> {
        let [from, to] = &self.external;
        from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
    }

    fn length_m(&self) -> f64 {
        let chord = (self.end.translation.vector - self.start.translation.vector).norm();
        self.arc.as_ref().map_or(chord, |c| c.from.norm() * c.angle)
    }

    /// Parts in which it is followed.
    fn parts(&self) -> usize {
        let turn = self.start.rotation.angle_to(&self.end.rotation) + self.arc.as_ref().map_or(0.0, |c| c.angle);
        let of = |whole: f64, part: f64| (whole / part).ceil() as usize;
        let fine = of(self.length_m(), SHORT_M).max(of(turn, SHORT_RAD)).clamp(LEAST_PARTS, PARTS);
        fine.max(of(self.length_m(), PART_M).min(MOST_PARTS))
    }

    fn pose(&self, share: f64) -> Pose {
        let turn = self.start.rotation.try_slerp(&self.end.rotation, share, 1e-12).unwrap_or(self.end.rotation);
        let position = match &self.arc {
            Some(c) => c.at(share),
            None => self.start.translation.vector.lerp(&self.end.translation.vector, share),
        };
        Pose { position, rotation: turn.to_rotation_matrix() }
    }
}

/// Orientations at the ends of an arc that differ by less are the same, rad.
pub(super) const SAME_TURN: f64 = 2e-4;
/// Arcs of more are not split, rad: which way round an orientation goes there differs by controller and setting.
const WIDEST: f64 = 3.1;

/// A TCP path, and joints along it as first guesses.
#[derive(Debug, Clone)]
pub struct Line {
    tooled: Arc<Tooled>,
    track: Track,
    /// Position and orientation count; else the position alone.
    pose: bool,
    samples: Vec<Vec<f64>>,
}

impl Line {
    /// The path between two joint vectors, both ends included: straight, or the arc through `via`; `None` where it cannot be
    /// followed.
    pub fn between(tooled: &Arc<Tooled>, from: &[f64], to: &[f64], via: Option<Vector3<f64>>) -> Option<Self> {
        let robot = &tooled.robot;
        let mut track = Track::between(isometry(&robot.forward(from)), isometry(&robot.forward(to)), via)?;
        if let Some(carried) = &tooled.carried {
            track = track.carried(from, to.get(..carried.count)?);
        }
        let pose = robot.dof() >= 6;
        let mut samples = along(tooled, &track, pose, from)?;
        // the branch must be the one on which the target stands
        let last = samples.last_mut()?;
        let off = last.iter().zip(to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if off > 1e-4 {
            return None;
        }
        last.clear();
        last.extend_from_slice(to);
        Some(Self { tooled: tooled.clone(), track, pose, samples })
    }

    /// Joints at a share of the path, solved there: between the samples a line through joints is none of the TCP.
    pub fn at(&self, share: f64) -> Option<Vec<f64>> {
        let guess = at_share(&self.samples, share)?;
        if share <= 0.0 || share >= 1.0 {
            return Some(guess);
        }
        solved(&self.tooled, &self.track, self.pose, share, &guess)
    }

    /// Length of the TCP's way, m.
    pub fn length_m(&self) -> f64 {
        self.track.length_m()
    }

    /// The robot with the tool whose TCP goes on it.
    pub fn tooled(&self) -> &Arc<Tooled> {
        &self.tooled
    }

    /// Parts of equal length between which joints may go straight so that the TCP leaves the path by about `within_m` at most.
    ///
    /// The middle of a chord leaves a path by the square of the chord's length; it is measured over every two parts of the samples.
    pub fn parts_within(&self, within_m: f64) -> usize {
        const MOST: f64 = 8192.0;
        let robot = &self.tooled.robot;
        let off_m = |w: &[Vec<f64>]| {
            let middle: Vec<f64> = w[0].iter().zip(&w[2]).map(|(a, b)| 0.5 * (a + b)).collect();
            (robot.tcp_m(&middle) - robot.tcp_m(&w[1])).norm()
        };
        let most_m = self.samples.windows(3).map(off_m).fold(0.0, f64::max);
        let parts = 0.5 * (self.samples.len() as f64 - 1.0) * (most_m / within_m).sqrt();
        parts.ceil().clamp(1.0, MOST) as usize
    }

    /// Radius, m, and angle, rad, of an arc that may be split: a controller keeps the orientation on the whole of it, whatever frame
    /// it interpolates it in. `None`: the path is straight, or its orientation on the way is not certain.
    pub fn arc(&self) -> Option<[f64; 2]> {
        let circle = self.track.arc.as_ref()?;
        let turn = self.track.start.rotation.angle_to(&self.track.end.rotation);
        (self.pose && turn < SAME_TURN && circle.angle < WIDEST).then(|| [circle.from.norm(), circle.angle])
    }

    /// Of an arc the share at which the point on its way stands.
    pub fn via_share(&self) -> Option<f64> {
        self.track.arc.as_ref().map(|c| c.via)
    }

    /// The TCP at joints, m.
    pub fn tcp_m(&self, q: &[f64]) -> Vector3<f64> {
        self.tooled.robot.tcp_m(q)
    }

    /// How far an arc through three points leaves this one at most, m; `None`: none goes through them, or this is none.
    pub fn leaves(&self, points: [&Vector3<f64>; 3]) -> Option<f64> {
        Some(self.track.arc.as_ref()?.left_by(&Circle::through(points[0], points[1], points[2])?))
    }

    /// Directions in which what the gears turn comes to the end, after the last turn by more than `deadband` (rad or m); 0: it does not
    /// move.
    pub fn arrivals(&self, deadband: &[f64]) -> Vec<i8> {
        let mut found: Vec<ReversalDetector> = deadband.iter().map(|band| ReversalDetector::new(*band, 0)).collect();
        for (row, (_, gears)) in self.gears().into_iter().enumerate() {
            for (detector, position) in found.iter_mut().zip(gears) {
                detector.take(row, position);
            }
        }
        found.iter().map(ReversalDetector::direction).collect()
    }

    /// Shares at which joints turn by more than `deadband` (per axis, rad or m), and the joints there. Turns closer than
    /// [`APART`] are one.
    pub fn turning_points(&self, deadband: &[f64]) -> Vec<Way> {
        let mut shares = turning_shares(&self.gears(), deadband);
        shares.sort_by(f64::total_cmp);
        shares.dedup_by(|b, a| *b - *a < APART);
        shares.into_iter().filter_map(|share| Some(Way { share, q: self.at(share)? })).collect()
    }

    /// What the gears turn at the samples, by their shares of the way, and where one turns within the first or the last part: between two
    /// other samples the one after shows it, at the ends of the way nothing does.
    fn gears(&self) -> Vec<Row> {
        let of = |share: f64, q: &[f64]| {
            let mut gears = q.to_vec();
            self.tooled.robot.to_gears(&mut gears);
            (share, gears)
        };
        let parts = (self.samples.len() - 1).max(1) as f64;
        let mut rows: Vec<Row> = self.samples.iter().enumerate().map(|(k, q)| of(k as f64 / parts, q)).collect();
        let turns = turns_at_ends(&rows);
        rows.extend(turns.into_iter().filter_map(|share| Some(of(share, &self.at(share)?))));
        in_order(rows)
    }
}

fn along(tooled: &Tooled, track: &Track, pose: bool, from: &[f64]) -> Option<Vec<Vec<f64>>> {
    let parts = track.parts();
    let mut line = vec![from.to_vec()];
    for k in 1..=parts {
        let share = |k: usize| k as f64 / parts as f64;
        let next = advanced(tooled, track, pose, [share(k - 1), share(k)], line.last()?, BISECTED)?;
        line.push(next);
    }
    Some(line)
}

/// Joints at the end of a part of the way, from those at its start: over its middle where they leap, as wrists do near their
/// singularity.
fn advanced(
    tooled: &Tooled,
    track: &Track,
    pose: bool,
    [from, to]: [f64; 2],
    q: &[f64],
    depth: usize,
) -> Option<Vec<f64>> {
    if let Some(next) = solved(tooled, track, pose, to, q) {
        return Some(next);
    }
    let middle = 0.5 * (from + to);
    let half = |part, q: &[f64]| advanced(tooled, track, pose, part, q, depth - 1);
    (depth > 0).then(|| half([middle, to], &half([from, middle], q)?)).flatten()
}

/// Joints at a share of the way between two poses, from a guess near them.
fn solved(tooled: &Tooled, track: &Track, pose: bool, share: f64, guess: &[f64]) -> Option<Vec<f64>> {
    let wanted = track.pose(share);
    if let Some(carried) = &tooled.carried {
        let mut q = track.external(share);
        let base = carried.base(&tooled.robot, &q);
        let wanted = pose_of(&(base.inverse() * isometry(&wanted)));
        let guess = carried.of_arm(guess);
        let arm = carried.arm.nearest(&carried.robot, &wanted, guess)?;
        q.extend(&arm);
        return (pose && arm.iter().zip(guess).all(|(a, b)| (a - b).abs() <= LEAP)).then_some(q);
    }
    let leaps = |q: &[f64]| q.iter().zip(guess).any(|(a, b)| (a - b).abs() > LEAP);
    if let Some(arm) = tooled.arm.as_ref().filter(|a| pose && a.form() != Form::General) {
        return arm.nearest(&tooled.robot, &wanted, guess).filter(|q| !leaps(q));
    }
    let options = InverseOptions {
        target_error_m: REACHED_M * 1e-4,
        target_error_rad: REACHED_RAD * 1e-4,
        ..InverseOptions::default()
    };
    let target = if pose { Target::Pose(wanted) } else { Target::Position(wanted.position) };
    let found = tooled.robot.inverse(&target, guess, &options);
    (found.error_m <= REACHED_M && found.error_rad <= REACHED_RAD && !leaps(&found.q)).then_some(found.q)
}

/// Joints at a share of a sampled way, linear between its samples.
fn at_share(line: &[Vec<f64>], share: f64) -> Option<Vec<f64>> {
    let last = line.len().checked_sub(1)?;
    let at = (share.clamp(0.0, 1.0) * last as f64).min(last as f64);
    let low = (at.floor() as usize).min(last.saturating_sub(1));
    let s = at - low as f64;
    let (a, b) = (line.get(low)?, line.get((low + 1).min(last))?);
    Some(a.iter().zip(b).map(|(x, y)| x + s * (y - x)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_goes_through_its_three_points_the_way_round_that_they_say() {
        let at = |deg: f64| Vector3::new(1.0 + 0.2 * deg.to_radians().cos(), 0.2 * deg.to_radians().sin(), 0.3);
        for [via, end] in [[60.0, 90.0], [200.0, 300.0], [-20.0, -170.0], [-200.0, -300.0]] {
            let pose = |deg: f64| Isometry3::from_parts(at(deg).into(), UnitQuaternion::identity());
            let track = Track::between(pose(0.0), pose(end), Some(at(via))).unwrap();
            assert!((track.length_m() - 0.2 * end.abs().to_radians()).abs() < 1e-12, "{via} {end}");
            for share in [0.0, via / end, 0.5, 1.0] {
                assert!((track.pose(share).position - at(share * end)).norm() < 1e-12, "{via} {end} {share}");
            }
            let circle = track.arc.unwrap();
            assert!((circle.via - via / end).abs() < 1e-9);
            for (share, off) in [(0.3, 0.01), (0.9, -0.02)] {
                let outside = circle.centre + (circle.at(share) - circle.centre) * (1.0 + off / 0.2);
                assert!((circle.off(&outside) - f64::abs(off)).abs() < 1e-12);
            }
            let gap = 0.5 * (360.0 - end.abs()).min(20.0);
            let beyond = at(end + gap * end.signum());
            assert!((circle.off(&beyond) - (beyond - at(end)).norm()).abs() < 1e-12, "{via} {end}");
        }
        let on_line = |x: f64| Vector3::new(x, 0.0, 0.0);
        assert!(Circle::through(&on_line(0.0), &on_line(1.0), &on_line(2.0)).is_none());
        // two of them are one, but for what a solver leaves
        let [a, b] = [Vector3::new(0.4, 0.1, 0.2), Vector3::new(0.3, 0.3, 0.1)];
        let beside = |p: &Vector3<f64>| p + Vector3::new(1e-9, -2e-9, 3e-9);
        for [start, via, end] in [[a, beside(&a), b], [a, b, beside(&b)], [a, b, beside(&a)]] {
            assert!(Circle::through(&start, &via, &end).is_none());
        }
    }
}
