//! Runs: stretches of a program on which each position certainly follows the one before it.
//!
//! A label, a loop, a call, or a target that cannot be determined ends a run: after it the directions are unknown. The first
//! movement's direction is taken, but only at the start of the program the first point carries its offset: anywhere else the
//! robot may come to it from the other side. A dwell, a process or a comment ends nothing.

use super::approach::{Directions, Sides};
use super::cause::Cause;
use super::circles;
use super::clock;
use super::poses::{Place, Poses, Tooled};
use super::way;
use crate::program::script::{
    At, Break, Goal, Move, Note, PathKind, PoseGoal, Script, Solution, Speed, StepKind, TargetRef, Way,
};
use crate::robot::Robot;
use crate::robot::arm::{Arm, isometry};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A tool that turns by less on a straight way goes straight with all its points, rad: one that is 0.5 m long leaves its line by 2 um, as the
/// sagitta of a turn is length * turn^2 / 8.
const SAME_TURN_RAD: f64 = 5e-3;

/// What a vertex stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The goal of its step.
    Goal,
    /// A turning point on the way to it.
    Way,
    /// The place where the robot waits.
    Hold,
    /// A point from which the goal is reached from its side.
    Approach,
}

/// A point of a run.
#[derive(Debug, Clone)]
pub struct Vertex {
    pub step: usize,
    pub role: Role,
    /// rad or m, one per axis.
    pub q: Vec<f64>,
    /// Share of the way to the step's goal; 1 for a goal.
    pub share: f64,
    /// Its numbers may be written (or, on a way, a point may be put there).
    pub editable: bool,
    pub t_s: f64,
    /// The duration of the move to here is the program's own, no estimate.
    pub certain: bool,
}

/// A stretch with known directions.
#[derive(Debug, Clone, Default)]
pub struct Run {
    pub vertices: Vec<Vertex>,
    /// The first move whose duration cannot be determined.
    pub untimed: Option<At>,
    /// ... and are those of the program, no estimate from joint speeds.
    pub certain: bool,
    /// Every duration is written in the program.
    pub by_program: bool,
    /// Sampled ways of straight TCP moves, by step.
    pub lines: BTreeMap<usize, way::Line>,
    /// Straight moves and arcs whose way the robot's kinematics cannot follow: where a point on it would stand is not known.
    pub unfollowed: BTreeSet<usize>,
    /// Frame and tool of Cartesian targets, by step.
    pub places: BTreeMap<usize, Place>,
    /// The program starts with it: nothing that moves stands before.
    pub entry: bool,
}

impl Run {
    /// Times are known all along.
    pub fn timed(&self) -> bool {
        self.untimed.is_none()
    }

    /// The sampled way of a step.
    pub fn line(&self, step: usize) -> Option<&way::Line> {
        self.lines.get(&step)
    }
}

/// What ended a run, or what could not be followed on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    pub at: At,
    pub why: Cause,
}

/// A script in runs.
#[derive(Debug, Default)]
pub struct Cut {
    pub runs: Vec<Run>,
    pub gaps: Vec<Gap>,
    /// Moves after which it is not yet known where every axis stands.
    pub partial: Vec<usize>,
    /// Why Cartesian moves stay as they are, by step.
    pub left: BTreeMap<usize, Cause>,
    pub notes: Vec<Note>,
}

/// How a script is cut into runs.
pub struct Choice<'a> {
    pub robot: &'a Robot,
    /// Movement that is number noise, per axis, rad or m.
    pub deadband: &'a [f64],
    /// TCP speed where a move has none that can be determined, m/s.
    pub tcp_speed_m_s: Option<f64>,
    /// TCP speed of every move whose own is a joint speed, m/s: the user knows it.
    pub certain_speed_m_s: Option<f64>,
    /// Steps that are left as they are on request.
    pub excluded: &'a dyn Fn(usize) -> bool,
    /// Write Cartesian moves as joint moves that stay within this distance of the TCP's line, m.
    pub solve_within_m: Option<f64>,
    /// Axes that some target of the script names.
    pub commanded: &'a [bool],
    /// Cartesian targets are written as Cartesian targets.
    pub as_poses: bool,
    /// Joints on a way that the format alone knows.
    pub on_way: &'a dyn Fn(usize, f64) -> Option<Vec<f64>>,
    /// Sides from which targets are reached.
    pub approach: Sides,
}

/// The runs of a script, and where directions are lost.
pub fn cut(script: &Script, choice: &Choice, poses: &mut Poses) -> Cut {
    let start = |k: usize| matches!(script.steps[k].kind, StepKind::Break(Break::Start));
    let entry = script.entry.or_else(|| (0..script.steps.len()).find(|&k| start(k)));
    let plain = Arc::new(Tooled::new(choice.robot, choice.robot.tool));
    let run = empty_run(entry.is_none());
    // what joint targets say of the arm serves Cartesian ones alone
    let solves = poses.posture.is_some() || script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_)));
    let one_arm = !solves || one_configuration(script, &plain);
    let hint = script.targets.iter().find_map(|t| joints_of(t, choice.robot.dof())).filter(|_| one_arm);
    if !one_arm {
        poses.posture = None;
    }
    let mut out = Cut::default();
    if let Some(note) = contradiction(script, &plain, poses.posture.as_deref()) {
        poses.posture = None;
        out.notes.push(note);
    }
    let mut cutter = Cutter {
        choice,
        poses,
        plain,
        out,
        run,
        known: Vec::new(),
        hint,
        one_arm,
        named: 0,
        directions: Directions::default(),
    };
    for (k, step) in script.steps.iter().enumerate() {
        match &step.kind {
            StepKind::Move(m) => cutter.take(script, k, step.at, m),
            StepKind::Dwell(seconds) => cutter.dwell(*seconds),
            // what moves nothing leaves a program at its start
            StepKind::Break(Break::Frame | Break::Interrupt) => {
                let still = cutter.run.vertices.is_empty() && cutter.run.entry && cutter.known.is_empty();
                cutter.end(still);
            }
            StepKind::Break(_) => cutter.end(entry == Some(k)),
            StepKind::Process(_) | StepKind::Pragma(_) => {}
        }
    }
    cutter.end(false);
    let mut out = cutter.out;
    out.notes.splice(0..0, another_robot(script, &out.left));
    out
}

/// That most configurations which the program orders are none of this robot's: its file is another arm's, or its flange is turned.
fn another_robot(script: &Script, left: &BTreeMap<usize, Cause>) -> Option<Note> {
    const LEAST: usize = 3;
    let ordered = |m: &Move| match &m.goal {
        Goal::Pose(goal) => goal.binding && matches!(goal.solution, Solution::Configured(_)),
        _ => false,
    };
    let all = script.moves().filter(|(_, m)| ordered(m)).count();
    let mut not = left.iter().filter(|(_, why)| **why == Cause::NotConfigured).map(|(step, _)| *step);
    let (first, others) = (not.next()?, not.count());
    let text = format!(
        "{} of {all} Cartesian targets name an arm configuration that this robot does not have there: if this is the robot of the program, compare a pose (position and angles) computed with its file with the pendant (`flange`, `base`, lengths)",
        others + 1
    );
    (others + 1 >= LEAST && 2 * (others + 1) > all).then(|| Note { place: script.steps[first].at, text })
}

/// Joints of a target that names them all.
fn joints_of(target: TargetRef, dof: usize) -> Option<Vec<f64>> {
    let values = target.values.iter().map(|v| v.map(|v| v.si)).collect::<Option<Vec<f64>>>()?;
    (target.pose.is_none() && values.len() == dof).then_some(values)
}

/// The arm configuration of joints: of an arm without a spherical wrist the bends of its third and fifth joint.
fn class(arm: &Arm, q: &[f64]) -> [bool; 3] {
    match arm.posture(q) {
        Some(p) => [p.front_m > 0.0, p.elbow > 0.0, q[4].sin() > 0.0],
        None => [true, q[2].sin() > 0.0, q[4].sin() > 0.0],
    }
}

/// That the posture which the user gives is of another configuration than a joint target of the program.
fn contradiction(script: &Script, plain: &Tooled, posture: Option<&[f64]>) -> Option<Note> {
    let (arm, posture) = (plain.arm.as_ref()?, posture?);
    let other = |t: &TargetRef| joints_of(*t, plain.robot.dof()).is_some_and(|q| class(arm, &q) != class(arm, posture));
    let target = script.targets.iter().find(other)?;
    let text = "the joints of this target are of another arm configuration than `posture_deg`, which is not used";
    Some(Note { place: target.at, text: text.into() })
}

/// Whether all joint targets of a script, and all configurations that it orders, are of one arm configuration.
fn one_configuration(script: &Script, plain: &Tooled) -> bool {
    let Some(arm) = &plain.arm else { return true };
    let joints = script.targets.iter().filter_map(|t| joints_of(t, plain.robot.dof()));
    let mut classes = joints.map(|q| class(arm, &q));
    let first = classes.next();
    let ordered = |m: &Move| match &m.goal {
        Goal::Pose(goal) => match &**goal {
            PoseGoal { solution: Solution::Configured(c), binding: true, .. } => c.posture(),
            _ => None,
        },
        _ => None,
    };
    let mut orders = script.moves().filter_map(|(_, m)| ordered(m));
    let order = orders.next();
    classes.all(|c| Some(c) == first) && orders.all(|o| Some(o) == order)
}

fn empty_run(entry: bool) -> Run {
    Run { certain: true, by_program: true, entry, ..Run::default() }
}

/// Where a move leads.
struct Reached {
    /// Joints before it, where they are known.
    from: Option<Vec<f64>>,
    q: Vec<f64>,
    editable: bool,
    /// A Cartesian target that is written as joint moves.
    solved: bool,
    /// The robot with the tool that goes straight to joint values; `None`: with its own.
    tooled: Option<Arc<Tooled>>,
    /// A point on the way of an arc to joint values, in the robot's world, m.
    via: Option<Vector3<f64>>,
}

/// Tool of a straight way or an arc, and a point of the arc between its ends; `None`: a joint move, and a straight way.
type ToolAndMiddle = (Option<Arc<Tooled>>, Option<Vector3<f64>>);

struct Cutter<'a> {
    choice: &'a Choice<'a>,
    poses: &'a mut Poses,
    /// The robot with its own tool.
    plain: Arc<Tooled>,
    out: Cut,
    run: Run,
    /// Where the axes stand that were commanded before a run has begun.
    known: Vec<Option<f64>>,
    /// Joints at the last place of the program where they are known, else those of its first joint target; `None`: the arm may have
    /// gone over into another configuration since.
    hint: Option<Vec<f64>>,
    /// All that the script says of the arm's configuration is the same.
    one_arm: bool,
    /// Targets whose configurations are noted.
    named: usize,
    directions: Directions,
}

impl Cutter<'_> {
    /// Ends the run; `entry`: the next one is the program's first.
    fn end(&mut self, entry: bool) {
        self.known.clear();
        self.directions.forget();
        let mut run = std::mem::replace(&mut self.run, empty_run(entry));
        // from which side the robot comes to the first point after a label, a loop or a call is not known: it stays
        if !run.entry
            && let Some(first) = run.vertices.first_mut()
        {
            first.editable = false;
        }
        if !run.vertices.is_empty() {
            self.out.runs.push(run);
        }
    }

    fn lost(&mut self, at: At, why: Cause) {
        self.end(false);
        self.out.gaps.push(Gap { at, why });
    }

    /// A move that cannot be determined: only straight ones and arcs keep the arm in its configuration.
    fn forget(&mut self, m: &Move) {
        if m.path == PathKind::Joint {
            self.hint = None;
        }
    }

    fn dwell(&mut self, seconds: Option<f64>) {
        let Some(last) = self.run.vertices.last() else { return };
        let hold = Vertex {
            role: Role::Hold,
            share: 1.0,
            editable: false,
            t_s: last.t_s + seconds.unwrap_or(0.0).max(1e-3),
            certain: true,
            ..last.clone()
        };
        self.run.vertices.push(hold);
    }

    /// The first point of a run.
    fn start(&mut self, step: usize, q: Vec<f64>, editable: bool) {
        self.directions.go(self.choice.robot, &q, self.choice.deadband);
        self.run.vertices.push(Vertex { step, role: Role::Goal, q, share: 1.0, editable, t_s: 0.0, certain: true });
    }

    /// Joints of a Cartesian target, with its frame and tool.
    fn pose(&mut self, goal: &PoseGoal, m: &Move, from: Option<&[f64]>) -> Result<(Vec<f64>, Place), Cause> {
        let place = self.poses.place(goal)?;
        let q = place.joints(goal, from, m.path, self.hint.as_deref())?;
        Ok((q, place))
    }

    fn take(&mut self, script: &Script, step: usize, at: At, m: &Move) {
        let from = self.run.vertices.last().map(|v| v.q.clone());
        let reached = match &m.goal {
            Goal::Joints(target) => self.joint_goal(script, script.targets.get(*target), step, at, m, from),
            Goal::Pose(goal) => self.pose_goal(goal, step, at, m, from),
            Goal::Opaque(_) => {
                // a relative motion would carry the offset of the goal before it along
                if let Some(last) = self.run.vertices.last_mut() {
                    last.editable = false;
                }
                self.forget(m);
                return self.lost(at, Cause::Undetermined);
            }
        };
        let Some(mut reached) = reached else { return };
        match &mut self.hint {
            hint if !self.one_arm => *hint = None,
            Some(hint) => hint.clone_from(&reached.q),
            hint => *hint = Some(reached.q.clone()),
        }
        match reached.from.take() {
            // where the robot stands it takes no step
            None => self.start(step, reached.q, reached.editable && m.speed != Speed::Seconds(0.0)),
            Some(from) => self.go(step, at, m, &from, reached),
        }
    }

    /// The joints that a move names; `None` where it is not yet known where every axis stands.
    fn joint_goal(
        &mut self,
        script: &Script,
        target: Option<TargetRef>,
        step: usize,
        at: At,
        m: &Move,
        from: Option<Vec<f64>>,
    ) -> Option<Reached> {
        let Some(target) = target else {
            self.lost(at, Cause::NoTarget);
            return None;
        };
        let dof = self.choice.robot.dof();
        let given = |k: usize| target.values.get(k).map(|v| v.si);
        // an axis without a value stays where it is; before a run that is what the moves before have said. A number in
        // the place of one that is not known would be written into new points. Only an axis that no target names
        // does not matter: it is not written.
        let before = |k: usize| from.as_ref().map(|q| q[k]).or(self.known.get(k).copied().flatten());
        let all: Vec<Option<f64>> = (0..dof).map(|k| given(k).or(before(k))).collect();
        let matters = |k: usize| self.choice.commanded.get(k).copied().unwrap_or(true);
        if (0..dof).any(|k| all[k].is_none() && matters(k)) {
            self.known = all;
            self.out.partial.push(step);
            return None;
        }
        // the moves before have not carried its offset: this one does not either
        let editable = Cause::of(m).is_none() && !(self.choice.excluded)(step) && self.known.is_empty();
        // nor is it the first that moves
        self.run.entry &= self.known.is_empty();
        self.known.clear();
        let q: Vec<f64> = all.iter().map(|v| v.unwrap_or_default()).collect();
        let curve = m.path == PathKind::Curve && !m.turns_known && !self.is_gantry();
        let followed = match (&from, m.circle) {
            (Some(from), Some(targets)) if !self.is_gantry() => self.on_circle(script, targets, m, from, &q),
            (Some(_), _) if curve => Err(Cause::CurveToJoints),
            (Some(from), _) => self.tool_of_way(m, from, &q).map(|tooled| (tooled, None)),
            (None, _) => Ok((None, None)),
        };
        match followed {
            Ok((tooled, via)) => Some(Reached { from, q, editable, solved: false, tooled, via }),
            Err(why) => {
                // where it turns its joints is not known, and so not from which side it reaches the goal
                self.out.left.insert(step, why.clone());
                self.lost(at, why);
                self.start(step, q, false);
                None
            }
        }
    }

    /// How a move goes that leads to a point of an arc through three joint targets: the tool, and a point on the way to the second or third.
    fn on_circle(
        &mut self,
        script: &Script,
        targets: [usize; 3],
        m: &Move,
        from: &[f64],
        to: &[f64],
    ) -> Result<ToolAndMiddle, Cause> {
        let dof = self.choice.robot.dof();
        let points = targets.map(|t| script.targets.get(t).and_then(|t| joints_of(t, dof)));
        let [Some(a), Some(b), Some(c)] = points else { return Err(Cause::CurveToJoints) };
        let points = [&a[..], &b, &c];
        let tooled = self.tool_of_circle(m, points)?;
        let middles = circles::middles(&tooled, points).ok_or(Cause::CurveToJoints)?;
        match points.iter().position(|q| *q == to) {
            Some(0) => Ok((self.tool_of_way(m, from, to)?, None)),
            Some(k) if points[k - 1] == from => Ok((Some(tooled), Some(middles[k - 1]))),
            _ => Err(Cause::CurveToJoints),
        }
    }

    /// The robot with the tool whose TCP goes on an arc; where no tool turns on it, all its points go on arcs alike.
    fn tool_of_circle(&mut self, m: &Move, points: [&[f64]; 3]) -> Result<Arc<Tooled>, Cause> {
        let tool = m.tool.as_ref().ok_or(Cause::CurveToJoints)?;
        let rotations = points.map(|q| isometry(&self.plain.robot.forward(q)).rotation);
        let turns = (1..3).any(|k| rotations[0].angle_to(&rotations[k]) >= way::SAME_TURN);
        match self.poses.tool(tool) {
            Ok(tooled) => Ok(tooled),
            Err(_) if !turns => Ok(self.plain.clone()),
            Err(why) => {
                self.poses.waits_for(&why);
                Err(why)
            }
        }
    }

    /// The robot with the tool whose TCP goes straight to joint values; `None`: that of the robot file.
    fn tool_of_way(&mut self, m: &Move, from: &[f64], to: &[f64]) -> Result<Option<Arc<Tooled>>, Cause> {
        let Some(tool) = m.tool.as_ref().filter(|_| m.path == PathKind::Linear && !self.is_gantry()) else {
            return Ok(None);
        };
        let robot = &self.plain.robot;
        let turn = isometry(&robot.forward(from)).rotation.angle_to(&isometry(&robot.forward(to)).rotation);
        match self.poses.tool(tool) {
            Ok(tooled) => Ok(Some(tooled)),
            // where the tool does not turn, all its points go straight
            Err(_) if turn < SAME_TURN_RAD => Ok(None),
            Err(why) => {
                self.poses.waits_for(&why);
                Err(why)
            }
        }
    }

    /// All its axes are linear.
    fn is_gantry(&self) -> bool {
        self.choice.robot.axis_joints().all(|j| j.kind == crate::robot::JointKind::Prismatic)
    }

    /// Joints of a Cartesian target, known also where the way to it is not, if its configuration names them.
    fn solve_pose(
        &mut self,
        goal: &PoseGoal,
        step: usize,
        at: At,
        m: &Move,
        from: &mut Option<Vec<f64>>,
    ) -> Option<(Vec<f64>, Place)> {
        let why = match self.pose(goal, m, from.as_deref()) {
            Ok(found) => return Some(found),
            Err(why) => why,
        };
        // a target whose configuration names its joints is known wherever the robot comes from
        let alone = from.as_ref().filter(|_| why == Cause::NotReached);
        let alone = alone.and_then(|_| self.pose(goal, m, None).ok());
        if alone.is_some() {
            self.lost(at, Cause::NotFollowed);
            *from = None;
        } else {
            self.forget(m);
            self.poses.missing.posture += u64::from(why == Cause::NoStart && self.poses.posture.is_none());
            if matches!(why, Cause::NotConfigured | Cause::OtherArm) {
                self.name_configurations(goal, at, from.as_deref());
            }
            self.out.left.insert(step, why.clone());
            self.lost(at, why);
        }
        alone
    }

    /// Notes the configurations that the robot has at a target whose own is none of them or another; of the first such targets.
    fn name_configurations(&mut self, goal: &PoseGoal, at: At, from: Option<&[f64]>) {
        const TARGETS: usize = 8;
        if self.named < TARGETS
            && let Ok(place) = self.poses.place(goal)
            && let Some(text) = place.configurations_text(goal, from)
            && !self.out.notes.iter().any(|n| n.text == text)
        {
            self.named += 1;
            self.out.notes.push(Note { place: at, text });
        }
    }

    /// The joints at a Cartesian target, and whether its numbers may be written.
    fn pose_goal(
        &mut self,
        goal: &PoseGoal,
        step: usize,
        at: At,
        m: &Move,
        mut from: Option<Vec<f64>>,
    ) -> Option<Reached> {
        let excluded = (self.choice.excluded)(step);
        let (q, place) = self.solve_pose(goal, step, at, m, &mut from)?;
        self.run.entry &= self.known.is_empty();
        self.known.clear();
        let asked = self.choice.solve_within_m.is_some();
        let solved = asked && m.path == PathKind::Linear && m.closed.is_none() && !excluded && from.is_some();
        // where a spline turns its joints is not known, nor an arc without a known start
        if m.path == PathKind::Curve && (goal.via_m.is_none() || from.is_none()) {
            self.out.left.insert(step, Cause::EndOfCurve);
            self.lost(at, Cause::Curve);
            self.run.entry = false;
            self.start(step, q, false);
            return None;
        }
        let written = self.choice.as_poses && goal.target.is_some() && m.fixed.is_none();
        if let Some(why) = m.fixed.clone().filter(|_| !solved) {
            self.out.left.insert(step, Cause::Program(why));
        } else if goal.target.is_none() && !solved {
            self.out.left.insert(step, Cause::NoNumbers);
        }
        self.run.places.insert(step, place);
        Some(Reached { from, q, editable: solved || written && !excluded, solved, tooled: None, via: None })
    }

    /// A move between two known places: its turning points, its duration and its goal.
    fn go(&mut self, step: usize, at: At, m: &Move, from: &[f64], reached: Reached) {
        let robot = self.choice.robot;
        let Reached { q, mut editable, solved, tooled, via, .. } = reached;
        let t0 = self.run.vertices.last().map_or(0.0, |v| v.t_s);
        let speed = match self.choice.certain_speed_m_s {
            Some(v) if !clock::is_certain(m.speed) => Speed::Tcp(v),
            _ => m.speed,
        };
        // points of an arc that is closed to new ones stay inside it; its turns still say how its end is reached
        let of_pose = matches!(&m.goal, Goal::Pose(goal) if goal.via_m.is_some());
        let arc = m.path == PathKind::Curve && (of_pose || via.is_some());
        let shut = m.closed.is_some() && m.path != PathKind::Linear && !arc;
        let ways = if shut { Some(Vec::new()) } else { self.ways(step, m, (from, &q), solved, (tooled, via)) };
        let on_way = |share: f64| {
            let known = (self.choice.on_way)(step, share);
            known.or_else(|| self.run.line(step).filter(|_| arc)?.at(share))
        };
        let duration = clock::duration_s(robot, from, &q, m.path, speed, self.choice.tcp_speed_m_s, &on_way);
        if duration.is_none() {
            self.run.untimed.get_or_insert(at);
        }
        let certain = clock::is_certain(speed) && duration.is_some();
        self.run.certain &= clock::is_certain(speed);
        self.run.by_program &= matches!(speed, Speed::Seconds(_));
        let duration = duration.unwrap_or(0.0);
        let ways = ways.unwrap_or_else(|| {
            // as joint moves it would leave its line
            editable &= !solved;
            self.run.unfollowed.insert(step);
            Vec::new()
        });
        for w in ways {
            let t_s = t0 + w.share * duration;
            self.directions.go(robot, &w.q, self.choice.deadband);
            self.run.vertices.push(Vertex { step, role: Role::Way, q: w.q, share: w.share, editable, t_s, certain });
        }
        let goal = Vertex { step, role: Role::Goal, q, share: 1.0, editable, t_s: t0 + duration, certain };
        if editable
            && m.closed.is_none()
            && self.choice.approach.count(m)
            && let Some(point) = self.choice.approach.point(robot, &self.run, &self.directions, &goal.q)
        {
            let last = self.run.vertices.last().map_or(t0, |v| v.t_s);
            self.directions.go(robot, &point, self.choice.deadband);
            self.run.vertices.push(self.choice.approach.vertex(&goal, 0.5 * (last + goal.t_s), point));
        }
        self.directions.go(robot, &goal.q, self.choice.deadband);
        self.run.vertices.push(goal);
    }

    /// Points between the start and the goal of a move; `None`: its line cannot be followed closely enough.
    fn ways(
        &mut self,
        step: usize,
        m: &Move,
        (from, to): (&[f64], &[f64]),
        solved: bool,
        (tooled, via): ToolAndMiddle,
    ) -> Option<Vec<Way>> {
        let via = match &m.goal {
            Goal::Pose(goal) => self.run.places.get(&step).and_then(|p| p.via(goal)),
            _ => via,
        };
        if !m.way.is_empty() || m.path != PathKind::Linear && via.is_none() {
            return Some(m.way.to_vec());
        }
        // straight in the joints is straight at the TCP where all joints are prismatic
        if self.is_gantry() {
            return Some(Vec::new());
        }
        let of_pose = || self.run.places.get(&step).map(|p| p.tooled.clone());
        let tooled = tooled.or_else(of_pose).unwrap_or_else(|| self.plain.clone());
        let line = way::Line::between(&tooled, from, to, via)?;
        let mut ways = line.turning_points(self.choice.deadband);
        if let Some(within) = self.choice.solve_within_m.filter(|_| solved) {
            ways.extend(chords(&tooled.robot, &line, within)?);
            ways.sort_by(|a, b| a.share.total_cmp(&b.share));
            ways.dedup_by(|b, a| b.share - a.share < 1e-3);
        }
        self.run.lines.insert(step, line);
        Some(ways)
    }
}

/// Points on a TCP line between which joint moves stay within `within` metres of it; `None`: so many points are too few.
fn chords(robot: &Robot, line: &way::Line, within: f64) -> Option<Vec<Way>> {
    const MOST: usize = 1024;
    let mut parts = 1;
    loop {
        let points: Option<Vec<Vec<f64>>> = (0..=parts).map(|k| line.at(k as f64 / parts as f64)).collect();
        let points = points?;
        let worst = (0..parts).try_fold(0.0f64, |worst, k| {
            let middle = line.at((k as f64 + 0.5) / parts as f64)?;
            let chord: Vec<f64> = points[k].iter().zip(&points[k + 1]).map(|(x, y)| 0.5 * (x + y)).collect();
            Some(worst.max((robot.tcp_m(&chord) - robot.tcp_m(&middle)).norm()))
        })?;
        // half of what is allowed, as the largest distance need not stand in the middle
        if worst <= 0.5 * within {
            let inner = points.into_iter().enumerate().skip(1).take(parts - 1);
            return Some(inner.map(|(k, q)| Way { share: k as f64 / parts as f64, q }).collect());
        }
        parts *= 2;
        if parts > MOST {
            return None;
        }
    }
}
