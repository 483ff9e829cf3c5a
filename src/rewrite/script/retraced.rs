//! A program that was rewritten, known by its Cartesian targets and by its straight ways: for a file whose note is not beside it.
//!
//! Method: the offsets of each target's joints are taken off again, by the directions in which they come to it. Where the program was
//! rewritten with this compensator, three things come back that it had before, and that it does not have as it is written:
//!
//! - *Ways.* A point that a rewrite puts after a reversal lies on the straight way between its neighbours; at the TCP also where the
//!   targets are joint values.
//! - *Numbers that are the same.* Neighbours in a plane, or with one orientation, have that number again.
//! - *Round numbers*, as in [`crate::rewrite::rewritten`].
//!
//! A program as it was loses what it has of these. As a control the offsets are also added once more: what comes back that way came
//! by chance. Nothing comes back where every number of the original has all of its digits and no point was added; nor after another
//! compensator.

use super::bands::LEVER_M;
use super::fading::ByClock;
use super::poses::{Place, Tooled, own_numbers};
use super::run::{Role, Run};
use crate::compensator::Compensator;
use crate::program::script::pose::{PoseForm, Quantity};
use crate::program::script::{Goal, PathKind, Script, StepKind};
use crate::rewrite::offset::Offset;
use crate::rewrite::rewritten::decimals;
use crate::robot::Robot;
use nalgebra::DVector;
use std::sync::Arc;

/// Share of a half gap by which an axis has to move for a direction.
const MOVES: f64 = 0.5;
/// A number is the same again within so many last digits, and another as it is written from so many on.
const SAME: f64 = 1.6;
const OTHER: f64 = 3.0;
/// A point lies on a way within so many last digits, and off it from so many times that on; and up to this share of the way.
const ON_WAY: f64 = 2.0;
const OFF_WAY: f64 = 3.0;
const FARTHEST: f64 = 0.95;
/// Where friction fades, a point may miss the way by this share of what it stood off it; and the offset there in settled ones.
const FADING: f64 = 0.1;
const FRESH: [f64; 2] = [0.5, 3.0];
/// Fewest points on ways, numbers that are the same again, and numbers that become rounder; and shares of those that could.
const LEAST_WAYS: usize = 3;
const LEAST_SAME: usize = 5;
const LEAST_ROUND: usize = 12;
const SHARE_SAME: f64 = 0.6;
const SHARE_ROUND: f64 = 0.7;
/// So many times as often as by chance.
const CHANCE: usize = 4;

/// Whether the Cartesian targets and straight ways of a script look rewritten.
pub fn looks_rewritten(script: &Script, runs: &[Run], robot: &Robot, by_clock: &ByClock) -> bool {
    let mut found = Found::default();
    // without a Cartesian target or a straight way nothing of it can come back
    for run in runs.iter().filter(|run| !(run.places.is_empty() && run.lines.is_empty())) {
        found.add(&points(script, run, robot, by_clock.on(run)));
    }
    found.is_rewritten()
}

/// What comes back, and what came back by chance.
#[derive(Debug, Default)]
struct Found {
    ways: [usize; 2],
    same: [usize; 2],
    /// Numbers that could be the same again, and those that are the same as they are written and would not be.
    near: usize,
    kept: usize,
    rounder: [usize; 2],
    numbers: usize,
}

/// A goal of a run, as written and with the offsets taken off and added once more.
struct Point<'a> {
    q: Vec<f64>,
    other: [Vec<f64>; 2],
    /// With all offsets as large again at axes that turn here, where friction fades.
    fresh: Option<Vec<f64>>,
    directions: Vec<i8>,
    path: PathKind,
    pose: Option<Pose<'a>>,
    /// Robot with the tool whose TCP goes there, and how far apart the last digits of its target put points on the way.
    tcp: Option<(&'a Arc<Tooled>, f64)>,
}

struct Pose<'a> {
    place: &'a Place,
    form: PoseForm,
    digits: Vec<f64>,
    numbers: Vec<f64>,
    other: [Vec<f64>; 2],
}

impl Pose<'_> {
    /// How far apart last digits put points of a way: of the TCP, m, or of the joints with [`LEVER_M`].
    fn digit(&self, path: PathKind) -> f64 {
        let most = |quantity: Quantity| {
            let digits = self.digits.iter().enumerate().filter(|(k, _)| self.form.quantity(*k) == quantity);
            digits.map(|d| *d.1).fold(0.0, f64::max)
        };
        let length = most(Quantity::Length);
        match path {
            PathKind::Joint => length + LEVER_M * most(Quantity::Angle).max(2.0 * most(Quantity::Ratio)),
            _ => length,
        }
    }
}

/// How far from each other two points are at the TCP, m, whose joints differ by a last digit: by half of it on either side.
fn rounding_m(robot: &Robot, q: &[f64], digits: Vec<f64>) -> f64 {
    let here = robot.tcp_m(q);
    let by = |(axis, digit): (usize, &f64)| {
        let mut there = q.to_vec();
        *there.get_mut(axis)? += 0.5 * digit;
        Some((robot.tcp_m(&there) - here).norm_squared())
    };
    digits.iter().enumerate().filter_map(by).sum::<f64>().sqrt()
}

/// Offsets of the axes of a compensator.
struct Offsets {
    of: Vec<Option<Offset>>,
}

impl Offsets {
    fn new(compensator: &Compensator, axes: usize) -> Self {
        let mut of: Vec<Option<Offset>> = (0..axes).map(|_| None).collect();
        for joint in &compensator.joints {
            if let Some(place) = of.get_mut(joint.axis) {
                *place = Some(Offset::new(joint));
            }
        }
        Self { of }
    }

    fn fades(&self, axis: usize) -> bool {
        self.of[axis].as_ref().is_some_and(|o| o.friction().is_some())
    }

    /// Joints less `times` their offsets; `gears` are what turns.
    fn less(&self, robot: &Robot, gears: &[f64], directions: &[i8], times: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let mut q = gears.to_vec();
        for (axis, offset) in self.of.iter().enumerate() {
            if let (Some(offset), true) = (offset, directions[axis] != 0) {
                let dir = directions[axis];
                q[axis] -= times(axis) * f64::from(dir) * offset.gap(dir, gears[axis]);
            }
        }
        robot.from_gears(&mut q);
        q
    }
}

/// The goals of a run.
fn points<'a>(script: &'a Script, run: &'a Run, robot: &Robot, compensator: &Compensator) -> Vec<Point<'a>> {
    let axes = robot.dof();
    let offsets = Offsets::new(compensator, axes);
    let mut directions = vec![0i8; axes];
    let mut last: Option<Vec<f64>> = None;
    let mut out = Vec::new();
    // points that are to be added before a target are none of the program
    for vertex in run.vertices.iter().filter(|v| v.role != Role::Approach) {
        let mut gears = vertex.q.to_vec();
        robot.to_gears(&mut gears);
        let before = directions.clone();
        if let Some(last) = &last {
            for (axis, offset) in offsets.of.iter().enumerate() {
                let least = offset.as_ref().map_or(0.0, |o| MOVES * o.largest_gap());
                let by = gears[axis] - last[axis];
                if by.abs() > least {
                    directions[axis] = by.signum() as i8;
                }
            }
        }
        last = Some(gears.clone());
        let StepKind::Move(step) = &script.steps[vertex.step].kind else { continue };
        if vertex.role != Role::Goal || vertex.again {
            continue;
        }
        let other = [1.0, -1.0].map(|sign| offsets.less(robot, &gears, &directions, &|_| sign));
        let turned = |axis: usize| before[axis] * directions[axis] < 0;
        let fades = (0..axes).any(|a| turned(a) && offsets.fades(a));
        let twice = |axis: usize| if turned(axis) { 2.0 } else { 1.0 };
        let pose = match &step.goal {
            Goal::Pose(goal) => run.places.get(&vertex.step).and_then(|place| {
                let (form, numbers) = own_numbers(script, goal)?;
                let target = script.targets.get(goal.target?)?;
                let digits = target.values.iter().take(form.count()).map(|v| v.map_or(0.0, |v| v.digit)).collect();
                let [less, more] = [&other[0], &other[1]].map(|q| {
                    let mut all = place.shifted(goal, form, &numbers, &vertex.q, q)?;
                    all.truncate(form.count());
                    Some(all)
                });
                let other = [less?, more?];
                let numbers = numbers.get(..form.count())?.to_vec();
                Some(Pose { place, form, digits, numbers, other })
            }),
            _ => None,
        };
        let tcp = match &pose {
            Some(pose) => Some((&pose.place.tooled, pose.digit(step.path))),
            None => run.line(vertex.step).and_then(|line| {
                let Goal::Joints(target) = step.goal else { return None };
                let digits = script.targets.get(target)?.values.iter().map(|v| v.map_or(0.0, |v| v.digit)).collect();
                Some((line.tooled(), rounding_m(&line.tooled().robot, &vertex.q, digits)))
            }),
        };
        out.push(Point {
            q: vertex.q.to_vec(),
            tcp,
            fresh: fades.then(|| offsets.less(robot, &gears, &directions, &twice)),
            other,
            directions: directions.clone(),
            path: step.path,
            pose,
        });
    }
    out
}

impl Found {
    fn add(&mut self, points: &[Point]) {
        for three in points.windows(3) {
            self.way(three);
        }
        for two in points.windows(2) {
            self.same(&two[0], &two[1]);
        }
        for pose in points.iter().filter_map(|p| p.pose.as_ref()) {
            self.round(pose);
        }
    }

    fn is_rewritten(&self) -> bool {
        let share = |part: usize, whole: usize, share: f64| part as f64 >= share * whole as f64;
        let by_chance = |found: [usize; 2]| found[0] < CHANCE * found[1];
        let ways = self.ways[0] >= LEAST_WAYS && !by_chance(self.ways);
        let same = self.same[0] >= LEAST_SAME
            && self.same[0] >= CHANCE * self.kept
            && share(self.same[0], self.near, SHARE_SAME)
            && !by_chance(self.same);
        let round = self.rounder[0] >= LEAST_ROUND
            && share(self.rounder[0], self.numbers, SHARE_ROUND)
            && !by_chance(self.rounder);
        ways || same || round
    }

    /// Does the second of three points lie on the way of the others?
    fn way(&mut self, three: &[Point]) {
        let [a, b, c] = three else { return };
        let (Some((tooled, own)), Some((tool_after, after))) = (b.tcp, c.tcp) else { return };
        if b.path != c.path || b.path == PathKind::Curve || !Arc::ptr_eq(tooled, tool_after) {
            return;
        }
        let at = |q: &[f64]| match b.path {
            PathKind::Joint => DVector::from_iterator(q.len(), q.iter().map(|v| v * LEVER_M)),
            _ => DVector::from_column_slice(tooled.robot.tcp_m(q).as_slice()),
        };
        let on_way = ON_WAY * own.max(after);
        let Some(written) = off(&at(&a.q), &at(&b.q), &at(&c.q)).map(|o| o.norm()) else { return };
        if written <= OFF_WAY * on_way {
            return;
        }
        for (k, count) in self.ways.iter_mut().enumerate() {
            let (from, to) = (at(&a.other[k]), at(&c.other[k]));
            let Some(here) = off(&from, &at(&b.other[k]), &to) else { continue };
            let left = match b.fresh.as_ref().filter(|_| k == 0).and_then(|f| off(&from, &at(f), &to)) {
                // the offset of an axis that has just turned is not known: as large as brings the point nearest to the way
                Some(fresh) => {
                    let by = fresh - &here;
                    let share = -here.dot(&by) / by.norm_squared().max(f64::MIN_POSITIVE);
                    (here + by * share.clamp(FRESH[0] - 1.0, FRESH[1] - 1.0)).norm() - FADING * written
                }
                None => here.norm(),
            };
            *count += usize::from(left <= on_way);
        }
    }

    /// Which numbers of two neighbours are the same again?
    fn same(&mut self, a: &Point, b: &Point) {
        let (Some(p), Some(q)) = (&a.pose, &b.pose) else { return };
        if a.directions == b.directions || p.form != q.form || p.place.frame != q.place.frame {
            return;
        }
        for k in 0..p.numbers.len().min(q.numbers.len()) {
            let digit = p.digits[k].max(q.digits[k]);
            let apart = |x: &[f64], y: &[f64]| (x[k] - y[k]).abs() / digit;
            let written = apart(&p.numbers, &q.numbers);
            let other = [0, 1].map(|n| apart(&p.other[n], &q.other[n]));
            // offsets that are alike at both change nothing
            if (written - other[0]).abs() < OTHER && written > OTHER {
                continue;
            }
            if written < 0.1 {
                self.kept += usize::from(other[0] > OTHER);
            } else if written > OTHER
                && written < 2.0 * (apart(&p.numbers, &p.other[0]) + apart(&q.numbers, &q.other[0]))
            {
                self.near += 1;
                for (count, apart) in self.same.iter_mut().zip(other) {
                    *count += usize::from(apart <= SAME);
                }
            }
        }
    }

    /// Which numbers of a target become rounder?
    fn round(&mut self, pose: &Pose) {
        for k in 0..pose.numbers.len() {
            let (digit, unit) = (pose.digits[k], pose.form.unit(k));
            let own = decimals(pose.numbers[k], digit, unit);
            if own == 0 || (pose.numbers[k] - pose.other[0][k]).abs() < OTHER * digit {
                continue;
            }
            self.numbers += 1;
            for (count, other) in self.rounder.iter_mut().zip(&pose.other) {
                *count += usize::from(decimals(other[k], digit, unit) < own);
            }
        }
    }
}

/// From the straight way between two points to a third on it; `None`: it lies beside neither.
fn off(from: &DVector<f64>, here: &DVector<f64>, to: &DVector<f64>) -> Option<DVector<f64>> {
    let (way, by) = (to - from, here - from);
    let share = by.dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE);
    (share > 0.0 && share < FARTHEST).then(|| by - way * share)
}
