//! Cartesian targets as joints, and joints with their offsets as Cartesian targets.
//!
//! A target `P` in frame `F` for tool `T` puts the flange where `flange * T = F * P`. [`Poses`] looks frames and tools up by the
//! controller's names, and counts the moves that wait for one that is not known. [`Place::joints`] solves a target for the
//! joints that its configuration names, or for those next to the joints before. [`Place::shifted`] writes joints with an offset
//! as a pose: `P * (arm(q)^-1 * arm(q + offset))`, so that only differences of the nominal arm count and a target whose joints
//! do not change keeps its numbers.
//!
//! Nothing is claimed where several solutions are as good, where the solution next to the joints before and the one that a
//! configuration names differ, or where the target lies outside of the joint limits.

use super::configuration::{allows, allows_axis, misfit, prefers};
use super::run::{Role, Run};
use super::way;
use crate::program::script::pose::{Configuration, Frame, PoseForm, PoseGoal, Quantity, Solution};
use crate::program::script::{Edits, Goal, Move, PathKind, Script, StepKind};
use crate::robot::arm::{self, Arm};
use crate::robot::frames::{Frames, Missing};
use crate::robot::{JointKind, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Slack of the borders of a configuration, rad: programs are rounded.
const SLACK: f64 = 2e-3;
/// How far joints with their offset must keep clear of the borders of their configuration, rad: the digits that are written.
const CLEAR: f64 = 2e-5;
/// Joints beyond a limit by less stand on it, rad or m.
const ON_LIMIT: f64 = 1e-6;
/// Solutions whose distances differ by less are as near, rad.
const AS_NEAR: f64 = 0.02;
/// Joints that a program names for a solution are no further from it, rad.
const BESIDE: f64 = 0.5;
/// Joints closer than this are the same solution, rad.
const SAME: f64 = 1e-5;
/// A sign of a configuration whose measure is less is none (m, sines, and the determinant of a Jacobian in m).
const ON_BORDER: f64 = 1e-6;
/// Half a last digit of a pose may move a joint by so much at most, rad.
const LOST_RAD: f64 = 1e-3;

/// A robot with one of its tools, ready for the inverse.
#[derive(Debug)]
pub struct Tooled {
    pub robot: Robot,
    pub arm: Option<Arm>,
}

impl Tooled {
    pub fn new(robot: &Robot, tool: Isometry3<f64>) -> Self {
        let robot = robot.with_geometry(robot.joints.clone(), tool);
        let arm = Arm::of(&robot);
        Self { robot, arm }
    }
}

/// Frame and tool of one target.
#[derive(Debug, Clone)]
pub struct Place {
    pub tooled: Arc<Tooled>,
    pub frame: Isometry3<f64>,
    /// Joints in whose configuration the arm works.
    posture: Option<Arc<[f64]>>,
}

/// Frames, tools and robots for the targets of a program.
#[derive(Debug)]
pub struct Poses {
    robot: Robot,
    frames: Frames,
    by_tool: BTreeMap<String, Arc<Tooled>>,
    pub missing: Missing,
    /// Joints in whose configuration the arm works where nothing else tells, rad or m; `None`: nobody says.
    pub posture: Option<Arc<[f64]>>,
}

impl Poses {
    pub fn new(robot: &Robot, frames: &Frames) -> Self {
        let frames = robot.frames.with(frames);
        let si =
            |given: &Vec<f64>| robot.axis_joints().zip(given).map(|(j, v)| v * j.kind.si_per_user_unit()).collect();
        let posture = frames.posture_deg.as_ref().map(si);
        Self { robot: robot.clone(), frames, by_tool: BTreeMap::new(), missing: Missing::default(), posture }
    }

    /// Frame and tool of a target.
    ///
    /// # Errors
    /// What is not known, in words.
    pub fn place(&mut self, goal: &PoseGoal) -> Result<Place, String> {
        if let Some(why) = goal.unknown() {
            return Err(format!("a Cartesian target whose frame or tool cannot be told: {why}"));
        }
        let (mut frames, mut tools) = (Vec::new(), Vec::new());
        let (base, known) = (self.robot.base, &self.frames);
        let frame = resolved(&goal.frame, base, &|name| known.frame(name).copied(), &mut frames);
        let tool = resolved(&goal.tool, base, &|name| known.tool(name).copied(), &mut tools);
        let mut why = Vec::new();
        for (what, names, missing) in
            [("frame", frames, &mut self.missing.frames), ("tool", tools, &mut self.missing.tools)]
        {
            for name in names {
                why.push(format!("{what} `{name}`"));
                *missing.entry(name).or_default() += 1;
            }
        }
        let (Some(frame), Some(tool)) = (frame, tool) else {
            return Err(match why.is_empty() {
                true => "a Cartesian target of which it is not certain which frame or tool is in force".into(),
                false => format!("a Cartesian target whose {} nobody gives (--list-frames)", why.join(" and ")),
            });
        };
        let key = format!("{:?} {:?}", tool.translation.vector, tool.rotation.coords);
        let robot = &self.robot;
        let tooled = self.by_tool.entry(key).or_insert_with(|| Arc::new(Tooled::new(robot, tool))).clone();
        Ok(Place { tooled, frame, posture: self.posture.clone() })
    }
}

/// A frame by what is known of it; names that nobody gives are added to `missing`. Of several the one that all are.
fn resolved(
    frame: &Frame,
    base: Isometry3<f64>,
    known: &dyn Fn(&str) -> Option<Isometry3<f64>>,
    missing: &mut Vec<String>,
) -> Option<Isometry3<f64>> {
    match frame {
        Frame::Given(frame) => Some(*frame),
        Frame::Base => Some(base),
        Frame::Null => Some(Isometry3::identity()),
        Frame::Unknown(_) => None,
        Frame::Named(name) => known(name).or_else(|| {
            missing.push(name.clone());
            None
        }),
        Frame::Any(all) => {
            let all: Vec<Option<Isometry3<f64>>> = all.iter().map(|f| resolved(f, base, known, missing)).collect();
            let first = (*all.first()?)?;
            all.iter().all(|f| *f == Some(first)).then_some(first)
        }
    }
}

impl Place {
    /// The target in the world of the robot.
    fn world(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Option<Isometry3<f64>> {
        let rotation = match (goal.rotation, from) {
            (Some(rotation), _) => self.frame.rotation * rotation,
            (None, Some(from)) => arm::isometry(&self.tooled.robot.forward(from)).rotation,
            (None, None) => return None,
        };
        Some(Isometry3::from_parts((self.frame * Point3::from(goal.position_m)).into(), rotation))
    }

    /// The point on the way of an arc in the world, m.
    pub fn via(&self, goal: &PoseGoal) -> Option<Vector3<f64>> {
        goal.via_m.map(|at| (self.frame * Point3::from(at)).coords)
    }

    /// Joints of a target, from the joints before where they are known. `hint`: joints at another place of the program, which tell
    /// in which of its configurations the arm works where nothing else does.
    ///
    /// # Errors
    /// Why they cannot be told.
    pub fn joints(
        &self,
        goal: &PoseGoal,
        from: Option<&[f64]>,
        path: PathKind,
        hint: Option<&[f64]>,
    ) -> Result<Vec<f64>, &'static str> {
        let robot = &self.tooled.robot;
        let end = self.world(goal, from).ok_or(NO_START)?;
        let via = self.via(goal);
        let Some(arm) = &self.tooled.arm else {
            let from = from.ok_or(NO_START)?;
            return way::follow(&self.tooled, from, &end, goal.rotation.is_some(), via).ok_or(way::NOT_REACHED);
        };
        let follows = path == PathKind::Linear || path == PathKind::Curve && via.is_some();
        let ordered = matches!(goal.solution, Solution::Near(_)) && goal.binding;
        if let (Some(from), true, false) = (from, follows, ordered) {
            let q = way::follow(&self.tooled, from, &end, true, via).ok_or(way::NOT_REACHED)?;
            let fits = match &goal.solution {
                Solution::Configured(c) if goal.binding => allows(c, arm, &q, SLACK),
                _ => true,
            };
            within(robot, &q)?;
            return if fits { Ok(q) } else { Err(OTHER_ARM) };
        }
        self.chosen(arm, goal, from, &end, hint)
    }

    /// Of all joints that reach a pose the ones that are meant.
    fn chosen(
        &self,
        arm: &Arm,
        goal: &PoseGoal,
        from: Option<&[f64]>,
        end: &Isometry3<f64>,
        hint: Option<&[f64]>,
    ) -> Result<Vec<f64>, &'static str> {
        let robot = &self.tooled.robot;
        let zero = vec![0.0; robot.dof()];
        let configuration = match &goal.solution {
            // what only tells how a point was taught counts where nothing else does
            Solution::Configured(c) if goal.binding || from.is_none() => Some(c),
            _ => None,
        };
        let near = match &goal.solution {
            Solution::Near(near) if near.len() == zero.len() && (goal.binding || from.is_none()) => {
                Some(near.as_slice())
            }
            _ => from,
        };
        let hint = hint.filter(|h| near.is_none() && h.len() == zero.len());
        let all = arm.solutions(robot, &arm::pose_of(end), near.unwrap_or(&zero));
        if all.is_empty() {
            return Err(way::NOT_REACHED);
        }
        let beside = near.or(hint).unwrap_or(&zero);
        let any: Vec<Vec<f64>> = all.iter().filter_map(|q| turned(robot, q, beside, &|_, _| true)).collect();
        if any.is_empty() {
            return Err(OUTSIDE);
        }
        let mut candidates = match configuration {
            None => any.clone(),
            Some(c) => {
                let may = |axis: usize, v: f64| allows_axis(c, axis, v, SLACK);
                let turned = all.iter().filter_map(|q| turned(robot, q, beside, &may));
                turned.filter(|q| allows(c, arm, q, SLACK)).collect()
            }
        };
        if let Some(c) = configuration
            && candidates.iter().any(|q| prefers(c, arm, q))
        {
            candidates.retain(|q| prefers(c, arm, q));
        }
        if candidates.is_empty() && goal.binding {
            return Err("a Cartesian target that no joints with its configuration reach");
        }
        if near.is_none() {
            return match (configuration, candidates.len()) {
                (Some(_), 1) => Ok(candidates.swap_remove(0)),
                (Some(c), 0) => self.by_hint(&any, hint, end).or_else(|| fitting(c, arm, &any)).ok_or(NO_START),
                (Some(_), _) => self.by_hint(&candidates, hint, end).ok_or(SEVERAL),
                (None, _) => {
                    let found = self.by_hint(&any, hint, end);
                    found.or_else(|| self.by_posture(arm, &all)).ok_or(NO_START)
                }
            };
        }
        let (mut best, first, second) = nearest(&candidates, beside);
        if second - first < AS_NEAR {
            // how the point was taught decides between solutions as near
            best = taught(goal, arm, &candidates, beside, first)
                .ok_or("a Cartesian target that two arm configurations reach from as near")?;
        }
        let q = candidates.swap_remove(best);
        if matches!(goal.solution, Solution::Near(_)) && !goal.binding && first > BESIDE {
            return Err("a Cartesian target without a solution next to the joints that the program names");
        }
        if first > nearest(&any, beside).1 + SAME { Err(OTHER_ARM) } else { Ok(q) }
    }

    /// Of the solutions the one in the arm configuration of `hint`: the nearest by far, or that at which a straight way from the
    /// hint ends.
    fn by_hint(&self, solutions: &[Vec<f64>], hint: Option<&[f64]>, end: &Isometry3<f64>) -> Option<Vec<f64>> {
        let hint = hint?;
        let (best, first, second) = nearest(solutions, hint);
        let q = solutions.get(best)?;
        let reached = way::follow(&self.tooled, hint, end, true, None);
        let agrees = reached.as_ref().is_none_or(|r| distance(r, q) < AS_NEAR);
        (agrees && second - first >= AS_NEAR && (reached.is_some() || first < BESIDE)).then(|| q.clone())
    }

    /// The one solution in the configuration of the posture that the user gives, in the turns next to it.
    fn by_posture(&self, arm: &Arm, all: &[Vec<f64>]) -> Option<Vec<f64>> {
        let robot = &self.tooled.robot;
        let posture = self.posture.as_deref()?;
        let class = class_of(robot, arm, posture)?;
        let mut found = all.iter().filter(|q| class_of(robot, arm, q) == Some(class));
        let one = turned(robot, found.next()?, posture, &|_, _| true)?;
        found.all(|q| turned(robot, q, posture, &|_, _| true).is_none_or(|q| distance(&q, &one) < SAME)).then_some(one)
    }

    /// Numbers of a pose target whose joints move from `q` to `to`; `own`: the numbers that stand there.
    pub fn shifted(&self, goal: &PoseGoal, form: PoseForm, own: &[f64], q: &[f64], to: &[f64]) -> Option<Vec<f64>> {
        let (from, to) = (self.arm_at(q), self.arm_at(to));
        let meant = goal.meant(&form.pose(own)?) * (from.inverse() * to);
        Some(form.coordinates(&goal.numbers(&meant), own))
    }

    /// Numbers of a pose at joints; `near`: numbers of a pose nearby.
    pub fn written(&self, goal: &PoseGoal, form: PoseForm, q: &[f64], near: &[f64]) -> Vec<f64> {
        form.coordinates(&goal.numbers(&(self.frame.inverse() * self.arm_at(q))), near)
    }

    fn arm_at(&self, q: &[f64]) -> Isometry3<f64> {
        arm::isometry(&self.tooled.robot.forward(q))
    }

    /// Why joints with their offset cannot be written as this target.
    ///
    /// # Errors
    /// In words.
    pub fn may_be(&self, goal: &PoseGoal, q: &[f64], digit: f64) -> Result<(), &'static str> {
        let robot = &self.tooled.robot;
        within(robot, q)?;
        if let (Some(arm), Solution::Configured(c), true) = (&self.tooled.arm, &goal.solution, goal.binding)
            && !allows(c, arm, q, -CLEAR)
        {
            return Err("its offset would pass a border of the target's configuration");
        }
        // half a last digit of the pose, as joints
        if robot.dof() >= 6 && robot.axis_joints().all(|j| j.kind == JointKind::Revolute) {
            let (_, jacobian) = robot.chain().jacobian(q);
            let least = jacobian.singular_values().min();
            if 0.5 * digit > LOST_RAD * least {
                return Err("so near to a singularity the digits of a pose do not tell its joints");
            }
        }
        Ok(())
    }
}

/// The configuration in which an arm of six joints stands, by three signs: of its front, elbow and wrist where the wrist is
/// spherical; else of its elbow, its wrist and its Jacobian's determinant, which is their product with the shoulder's. `None`: on a border.
fn class_of(robot: &Robot, arm: &Arm, q: &[f64]) -> Option<[bool; 3]> {
    let signs = match arm.posture(q) {
        Some(p) => [p.front_m, p.elbow, q.get(4)?.sin()],
        None => {
            let (_, jacobian) = robot.chain().jacobian(q);
            let square = (jacobian.ncols() == 6).then(|| jacobian.fixed_columns::<6>(0).into_owned())?;
            [square.determinant(), q.get(2)?.sin(), q.get(4)?.sin()]
        }
    };
    signs.iter().all(|s| s.abs() > ON_BORDER).then(|| signs.map(|s| s > 0.0))
}

/// Of the solutions as near as the nearest the one with which the point was taught; `None`: none, or several.
fn taught(goal: &PoseGoal, arm: &Arm, all: &[Vec<f64>], beside: &[f64], first: f64) -> Option<usize> {
    let Solution::Configured(c) = &goal.solution else { return None };
    let tied = || (0..all.len()).filter(|&k| distance(&all[k], beside) < first + AS_NEAR);
    let only = |found: Vec<usize>| if let [one] = found[..] { Some(one) } else { None };
    let allowed: Vec<usize> = tied().filter(|&k| allows(c, arm, &all[k], SLACK)).collect();
    match allowed.len() {
        0 | 1 => only(allowed),
        _ => only(allowed.into_iter().filter(|&k| prefers(c, arm, &all[k])).collect()),
    }
}

/// The solution that fits a configuration best that none has and that the controller does not look at; `None`: two fit as well.
fn fitting(configuration: &Configuration, arm: &Arm, all: &[Vec<f64>]) -> Option<Vec<f64>> {
    let fit: Option<Vec<f64>> = all.iter().map(|q| misfit(configuration, arm, q)).collect();
    let fit = fit?;
    let best = (0..all.len()).min_by(|a, b| fit[*a].total_cmp(&fit[*b]))?;
    let alone = (0..all.len()).all(|k| k == best || fit[k] > fit[best] + BESIDE);
    alone.then(|| all[best].clone())
}

pub const NO_START: &str = "a Cartesian target without a known start, and without a configuration";
const SEVERAL: &str = "a Cartesian target that several arm configurations reach";
const OTHER_ARM: &str = "a Cartesian target in another arm configuration than that next to the joints before";
const OUTSIDE: &str = "a Cartesian target outside of the joint limits";

/// Within the limits of the joints.
fn within(robot: &Robot, q: &[f64]) -> Result<(), &'static str> {
    let outside = |(j, v): (&crate::robot::Joint, &f64)| {
        j.limits.is_some_and(|[lo, hi]| !(lo - ON_LIMIT..=hi + ON_LIMIT).contains(v))
    };
    if robot.axis_joints().zip(q).any(outside) { Err(OUTSIDE) } else { Ok(()) }
}

/// Joints by the whole turns nearest to `near` that stay within the limits and that `may` allows; `None`: there are none.
fn turned(robot: &Robot, q: &[f64], near: &[f64], may: &dyn Fn(usize, f64) -> bool) -> Option<Vec<f64>> {
    let of = |(axis, joint): (usize, &crate::robot::Joint)| {
        let at = near.get(axis).copied().unwrap_or(0.0);
        let own = q.get(axis)? - ((q.get(axis)? - at) / TAU).round() * TAU;
        let inside =
            |v: &f64| joint.limits.is_none_or(|[lo, hi]| (lo - ON_LIMIT..=hi + ON_LIMIT).contains(v)) && may(axis, *v);
        let all = (-2..=2).map(|k| own + TAU * f64::from(k)).filter(inside);
        all.min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()))
    };
    robot.axis_joints().enumerate().map(of).collect()
}

/// Largest distance of a joint, rad.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// The nearest candidate, its distance and that of the next one.
fn nearest(candidates: &[Vec<f64>], near: &[f64]) -> (usize, f64, f64) {
    let mut best = (0, f64::INFINITY, f64::INFINITY);
    for (k, q) in candidates.iter().enumerate() {
        let d = distance(q, near);
        if d < best.1 {
            best = (k, d, best.1);
        } else if d < best.2 {
            best.2 = d;
        }
    }
    best
}

/// Numbers of a pose target as they stand there, in SI.
pub fn own_numbers(script: &Script, goal: &PoseGoal) -> Option<(PoseForm, Vec<f64>)> {
    let target = script.targets.get(goal.target?)?;
    let form = target.pose?;
    let values: Option<Vec<f64>> = target.values.iter().map(|v| v.map(|v| v.si)).collect();
    values.filter(|v| v.len() == form.count()).map(|v| (form, v))
}

/// Makes poses of the edits of Cartesian targets, which are joints until here. An edit that its target cannot hold goes, and
/// `left` says why. Returns how many new points had to go.
pub fn write(script: &Script, runs: &[Run], edits: &mut Edits, left: &mut BTreeMap<usize, String>) -> u64 {
    let mut gone = 0;
    for run in runs {
        for vertex in run.vertices.iter().filter(|v| v.role == Role::Goal) {
            let Some(StepKind::Move(Move { goal: Goal::Pose(goal), .. })) =
                script.steps.get(vertex.step).map(|s| &s.kind)
            else {
                continue;
            };
            let Some(edit) = edits.steps.get_mut(&vertex.step).filter(|e| !e.as_joint_moves) else { continue };
            let (Some(place), Some((form, own))) = (run.places.get(&vertex.step), own_numbers(script, goal)) else {
                edits.steps.remove(&vertex.step);
                continue;
            };
            let digit = finest_angle(script, goal);
            edit.before.retain_mut(|point| {
                let may = place.may_be(goal, &point.q, digit).is_ok();
                if may {
                    point.q = place.written(goal, form, &point.q, &own);
                }
                gone += u64::from(!may);
                may
            });
            if let Some(q) = edit.goal.take() {
                match place.may_be(goal, &q, digit) {
                    Ok(()) => edit.goal = place.shifted(goal, form, &own, &vertex.q, &q),
                    Err(why) => drop(left.insert(vertex.step, why.to_string())),
                }
            }
            if edit.goal.is_none() && edit.before.is_empty() {
                edits.steps.remove(&vertex.step);
            }
        }
    }
    gone
}

/// Weight of the finest digit of the coarsest angle of a target, rad (of a quaternion's parts twice that).
fn finest_angle(script: &Script, goal: &PoseGoal) -> f64 {
    let Some(target) = goal.target.and_then(|t| script.targets.get(t)) else { return 0.0 };
    let factor = |k: usize| match target.pose.map(|f| f.quantity(k)) {
        Some(Quantity::Angle) => 1.0,
        Some(Quantity::Ratio) => 2.0,
        _ => 0.0,
    };
    target.values.iter().enumerate().filter_map(|(k, v)| Some(v.as_ref()?.finest * factor(k))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};
    use proptest::prelude::*;

    const ARMS: [&str; 5] = [
        include_str!("../../../configs/kuka-kr120-r2500-pro.yaml"),
        include_str!("../../../configs/abb-irb1600-6-145.yaml"),
        include_str!("../../../configs/fanuc-m10ia.yaml"),
        include_str!("../../../configs/motoman-ma2010.yaml"),
        include_str!("../../../configs/universal-robots-ur10.yaml"),
    ];
    const FORMS: [PoseForm; 4] =
        [PoseForm::EulerZyx, PoseForm::Quaternion, PoseForm::FixedXyz, PoseForm::RotationVector];

    fn isometry(v: &[f64]) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(v[3], v[4], v[5]));
        Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation)
    }

    fn place(k: usize, tool: Isometry3<f64>, frame: Isometry3<f64>) -> Place {
        let robot = Robot::parse("r", ARMS[k]).unwrap();
        Place { tooled: Arc::new(Tooled::new(&robot, tool)), frame, posture: None }
    }

    fn goal(at: &Isometry3<f64>, solution: Solution) -> PoseGoal {
        PoseGoal {
            target: None,
            position_m: at.translation.vector,
            rotation: Some(at.rotation),
            frame: Frame::Null,
            tool: Frame::Null,
            solution,
            binding: true,
            ..PoseGoal::default()
        }
    }

    fn joints(place: &Place, shares: &[f64]) -> Vec<f64> {
        let robot = &place.tooled.robot;
        robot.axis_joints().zip(shares).map(|(j, s)| j.limits.map_or(0.0, |[a, b]| a + s * (b - a))).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// Rounded to digits, the pose that is written is that of q + offset within half a last digit.
        #[test]
        fn what_is_written_is_the_pose_of_the_joints_with_their_offset(
            k in 0..5usize, f in 0..4usize,
            shares in prop::collection::vec(0.2..0.8f64, 6), by in prop::collection::vec(-1e-4..1e-4f64, 6),
            tool in prop::collection::vec(-0.3..0.3f64, 6), frame in prop::collection::vec(-1.0..1.0f64, 6),
        ) {
            let place = place(k, isometry(&tool), isometry(&frame));
            let form = FORMS[f];
            let q = joints(&place, &shares);
            let to: Vec<f64> = q.iter().zip(&by).map(|(a, b)| a + b).collect();
            let plain = PoseGoal::default();
            let own = place.written(&plain, form, &q, &[0.0; 7]);
            let new = place.shifted(&plain, form, &own, &q, &to).unwrap();
            // the digits of a language: 0.001 mm, 0.0001 deg, 1e-7 of a quaternion
            let digit = |i: usize| match form.quantity(i) {
                Quantity::Length => 1e-6,
                Quantity::Angle => 1e-4_f64.to_radians(),
                Quantity::Ratio => 1e-7,
            };
            let rounded: Vec<f64> = new.iter().enumerate().map(|(i, v)| (v / digit(i)).round() * digit(i)).collect();
            let wanted = place.frame.inverse() * place.arm_at(&to);
            let back = form.pose(&rounded).unwrap();
            prop_assert!((back.translation.vector - wanted.translation.vector).abs().max() <= 0.5e-6 + 1e-12);
            let turn = (wanted.rotation.inverse() * back.rotation).scaled_axis().norm();
            // three angles of half a digit each; a quaternion's parts count twice
            let most = if f == 1 { 4.0 * 0.5e-7 * 2.0 } else { 3.0 * 0.5 * digit(3) };
            prop_assert!(turn <= most + 1e-9, "{turn} {most}");
            // nothing moves where no joint does
            let same = place.shifted(&plain, form, &own, &q, &q).unwrap();
            prop_assert!(own.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-11), "{own:?} {same:?}");
        }

        /// A KUKA's S and T name the joints, without any joints before; so do those before alone.
        #[test]
        fn status_and_turn_or_the_joints_before_give_the_joints(
            shares in prop::collection::vec(0.05..0.95f64, 6), near in prop::collection::vec(-0.05..0.05f64, 6),
        ) {
            let place = place(0, Isometry3::translation(0.1, 0.0, 0.2), Isometry3::identity());
            let q = joints(&place, &shares);
            let arm = place.tooled.arm.as_ref().unwrap();
            let posture = arm.posture(&q).unwrap();
            prop_assume!(q.iter().all(|v| v.abs() > 0.05 && v.abs() < 3.1) && posture.front_m.abs() > 0.05);
            prop_assume!(posture.elbow.abs() > 0.05 && q[4].sin().abs() > 0.05);
            let at = place.arm_at(&q);
            let turn = q.iter().enumerate().map(|(i, v)| u8::from(*v < 0.0) << i).sum();
            let status = u8::from(posture.front_m < 0.0) + 2 * u8::from(posture.elbow > 0.0) + 4 * u8::from(q[4] < 0.0);
            let taught = Solution::Configured(Configuration::Kuka { status: Some(status), turn: Some(turn) });
            let found = place.joints(&goal(&at, taught), None, PathKind::Joint, None).unwrap();
            prop_assert!(distance(&found, &q) < 1e-6, "{found:?} {q:?}");
            let from: Vec<f64> = q.iter().zip(&near).map(|(a, b)| a + b).collect();
            let found = place.joints(&goal(&at, Solution::Same), Some(&from), PathKind::Joint, None).unwrap();
            prop_assert!(distance(&found, &q) < 1e-6, "{found:?} {q:?}");
        }
    }

    #[test]
    fn a_configuration_that_names_other_joints_than_those_before_leaves_the_move() {
        let place = place(0, Isometry3::identity(), Isometry3::identity());
        let q: Vec<f64> = [10.0, -80.0, 95.0, 12.0, 40.0, -20.0].map(f64::to_radians).into();
        let at = place.arm_at(&q);
        let kuka = |status, turn| Solution::Configured(Configuration::Kuka { status: Some(status), turn: Some(turn) });
        let own = goal(&at, kuka(2, 0b100010));
        assert!(distance(&place.joints(&own, Some(&q), PathKind::Joint, None).unwrap(), &q) < 1e-6);
        // the wrist turned over: A5 below zero
        let flipped = goal(&at, kuka(6, 0b011010));
        assert!(place.joints(&flipped, Some(&q), PathKind::Joint, None).is_err());
        let other = place.joints(&goal(&at, kuka(6, 0b011010)), None, PathKind::Joint, None).unwrap();
        assert!(other[4] < 0.0 && distance(&other, &q) > 1.0);
        // on a straight path the controller does not look at it
        let linear = PoseGoal { binding: false, ..flipped };
        assert!(distance(&place.joints(&linear, Some(&q), PathKind::Linear, None).unwrap(), &q) < 1e-6);
    }

    #[test]
    fn joints_elsewhere_tell_the_arm_configuration_of_an_unknown_start() {
        let place = place(4, Isometry3::translation(0.0, 0.0, 0.1), Isometry3::identity());
        let q: Vec<f64> = [20.0, -80.0, 90.0, -100.0, -90.0, 30.0].map(f64::to_radians).into();
        let goal = PoseGoal { binding: false, ..goal(&place.arm_at(&q), Solution::Same) };
        let from = |hint: Option<&[f64]>| place.joints(&goal, None, PathKind::Linear, hint);
        assert_eq!(from(None), Err(NO_START));
        let elsewhere: Vec<f64> = q.iter().zip([0.4, -0.2, 0.3, -0.2, 0.1, 0.2]).map(|(a, b)| a + b).collect();
        assert!(distance(&from(Some(&elsewhere)).unwrap(), &q) < 1e-6);
        // the elbow bent the other way: another arm, or none that is certain
        let other: Vec<f64> = [20.0, -20.0, -90.0, 20.0, -90.0, 30.0].map(f64::to_radians).into();
        assert!(from(Some(&other)).map_or(f64::INFINITY, |found| distance(&found, &q)) > 0.5);
    }

    #[test]
    fn a_posture_that_the_user_gives_chooses_the_arm_configuration_wherever_it_stands() {
        // the same elbow and wrist far away, for arms with and without a spherical wrist
        let postures = [[-60.0, -100.0, 110.0, 0.0, 70.0, 0.0], [150.0, -60.0, 70.0, -110.0, -60.0, -20.0]];
        let there = [[40.0, -70.0, 80.0, 20.0, 30.0, -10.0], [20.0, -80.0, 90.0, -100.0, -90.0, 30.0]];
        for (k, (posture, q)) in [0, 4].into_iter().zip(postures.into_iter().zip(there)) {
            let mut place = place(k, Isometry3::translation(0.0, 0.0, 0.1), Isometry3::identity());
            let q: Vec<f64> = q.map(f64::to_radians).into();
            let goal = PoseGoal { binding: false, ..goal(&place.arm_at(&q), Solution::Same) };
            assert_eq!(place.joints(&goal, None, PathKind::Linear, None), Err(NO_START));
            place.posture = Some(posture.map(f64::to_radians).into());
            let found = place.joints(&goal, None, PathKind::Linear, None).unwrap();
            assert!(distance(&found, &q) < 1e-6, "{k}: {found:?}");
            // another wrist is another solution
            let mut other = posture.map(f64::to_radians);
            other[4] = -other[4];
            place.posture = Some(other.into());
            let found = place.joints(&goal, None, PathKind::Linear, None).unwrap();
            assert!((found[4].sin() > 0.0) != (q[4].sin() > 0.0), "{k}: {found:?}");
            assert!((place.arm_at(&found).translation.vector - place.arm_at(&q).translation.vector).norm() < 1e-9);
        }
    }

    #[test]
    fn a_displaced_target_is_written_in_its_own_numbers() {
        let place = place(1, Isometry3::identity(), Isometry3::identity());
        let q: Vec<f64> = [10.0, 20.0, 15.0, 30.0, 40.0, -20.0].map(f64::to_radians).into();
        let to: Vec<f64> = q.iter().map(|v| v + 7e-5).collect();
        let shift = crate::program::script::Shift {
            before: isometry(&[0.1, 0.2, 0.0, 0.0, 0.0, 0.3]),
            after: isometry(&[0.0, 0.0, -0.05, 0.2, 0.0, 0.0]),
        };
        let numbers = shift.before.inverse() * place.arm_at(&q) * shift.after.inverse();
        let goal = goal(&numbers, Solution::Same).shifted(shift);
        let form = PoseForm::Quaternion;
        let own = form.coordinates(&numbers, &[0.0; 7]);
        let found = place.joints(&goal, Some(&q), PathKind::Joint, None).unwrap();
        assert!(distance(&found, &q) < 1e-6, "{found:?}");
        let new = form.pose(&place.shifted(&goal, form, &own, &q, &to).unwrap()).unwrap();
        let (meant, wanted) = (goal.meant(&new), place.arm_at(&to));
        assert!((meant.translation.vector - wanted.translation.vector).norm() < 1e-12);
        assert!(meant.rotation.angle_to(&wanted.rotation) < 1e-7);
    }

    #[test]
    fn several_frames_are_known_where_all_are_the_same() {
        let robot = Robot::parse("r", ARMS[0]).unwrap();
        let any = |names: &[&str]| Frame::Any(names.iter().map(|n| Frame::Named((*n).into())).collect());
        let asks = |names: &[&str]| PoseGoal { frame: any(names), ..goal(&Isometry3::identity(), Solution::Same) };
        let text = "schema: lostmotion/frames/1\nframes: {a: {xyz_mm: [1, 0, 0]}, b: {xyz_mm: [1, 0, 0]}, c: {}}\n";
        let mut poses = Poses::new(&robot, &Frames::parse("f", text).unwrap());
        assert!(poses.place(&asks(&["a", "b"])).is_ok());
        assert!(poses.place(&asks(&["a", "c"])).unwrap_err().contains("not certain"));
        assert!(poses.missing.is_empty());
        assert!(poses.place(&asks(&["a", "d"])).unwrap_err().contains("frame `d`"));
    }

    #[test]
    fn an_offset_across_a_border_of_the_configuration_leaves_the_target() {
        let place = place(0, Isometry3::identity(), Isometry3::identity());
        let q: Vec<f64> = [10.0, -80.0, 95.0, 0.001, 40.0, -20.0].map(f64::to_radians).into();
        let taught = Solution::Configured(Configuration::Kuka { status: Some(2), turn: Some(0b100010) });
        let goal = goal(&place.arm_at(&q), taught);
        let mut to = q.clone();
        to[0] += 5e-5;
        to[3] += 1e-3;
        assert!(place.may_be(&goal, &to, 1e-6).is_ok());
        to[3] = -5e-5;
        assert!(place.may_be(&goal, &to, 1e-6).unwrap_err().contains("border"));
    }

    #[test]
    fn what_is_not_known_is_asked_for_by_name_with_the_moves_that_wait() {
        let robot = Robot::parse("r", ARMS[0]).unwrap();
        let mut poses = Poses::new(&robot, &Frames::default());
        let waiting = PoseGoal {
            frame: Frame::Named("2".into()),
            tool: Frame::Named("tGun".into()),
            ..goal(&Isometry3::identity(), Solution::Same)
        };
        for _ in 0..2 {
            assert!(poses.place(&waiting).unwrap_err().contains("frame `2` and tool `tGun`"));
        }
        assert_eq!((poses.missing.frames["2"], poses.missing.tools["tGun"]), (2, 2));
        let text = "schema: lostmotion/frames/1\nframes: {\"2\": {}}\ntools: {tgun: {}}\n";
        let mut poses = Poses::new(&robot, &Frames::parse("f", text).unwrap());
        assert!(poses.place(&waiting).is_ok() && poses.missing.is_empty());
    }
}
