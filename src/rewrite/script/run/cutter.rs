//! What cuts a script into runs: its state from step to step, and what comes out.

use super::super::approach::{self, Directions, Sides};
use super::super::cause::Cause;
use super::super::clock::{self, LastTcp};
use super::super::poses::{Place, Poses, Tooled};
use super::joints::Joints;
use super::lengths::Lengths;
use super::stretch::{Role, Run, Vertex, empty_run, first};
use crate::program::script::pose::Frame;
use crate::program::script::{
    At, AxisSet, Break, Goal, Move, Note, PathKind, PoseGoal, Round, Script, Speed, StepKind,
};
use crate::robot::Robot;
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

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
    /// Why moves stay as they are, by step, as far as that is known before the engine.
    pub left: BTreeMap<usize, Cause>,
    pub notes: Vec<Note>,
    /// Runs through the first moves of a program that runs again from its start, from where it ends: they write nothing.
    pub again: Vec<Run>,
    /// The same for other meanings of the letters for the wrist, which are as possible.
    pub others: Vec<Cut>,
    /// What speaks against the meaning of this one.
    pub tells: Tells,
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
    /// Axes whose offset depends on where they stand.
    pub by_place: AxisSet,
    /// Cartesian targets are written as Cartesian targets.
    pub as_poses: bool,
    /// Joints on a way that the format alone knows.
    pub on_way: &'a dyn Fn(usize, f64) -> Option<Vec<f64>>,
    /// Sides from which targets are reached.
    pub approach: Sides,
    /// Travel of each gear over which its offset forgets what was before a turn, rad or m; `None`: some offset lasts longer.
    pub forgets_over: Option<&'a [f64]>,
    /// Time in which each axis crosses its gap, s; 0, or no entry: it has none.
    pub crossing_s: &'a [f64],
    /// The user gives the sides from which joints come to the first point of the program.
    pub sides_given: bool,
    /// Go through loops whose passes are alike.
    pub rounds: bool,
    /// Go on where it is known from where control comes to a break.
    pub joins: bool,
}

/// What a cut tells of the meaning that it was made with.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tells {
    /// Moves that would not be so with this meaning.
    pub(super) against: usize,
    /// Targets at which a joint stands on the border of its turn.
    pub(super) on_border: usize,
    /// Some run begins with joints that a letter alone chose.
    pub(super) by_letter: bool,
}

/// The frame of a Cartesian target, which axes may carry that the robot file does not have, and its tool.
#[derive(Debug, Clone)]
pub(super) struct LastFrame {
    /// Its name without the places of these axes.
    pub(super) name: String,
    /// Its orientation in the world where they stand.
    pub(super) rotation: UnitQuaternion<f64>,
    /// Frame and tool as the program names them.
    pub(super) own: [Frame; 2],
}

/// Where a move leads.
pub(super) struct Reached {
    /// Joints before it, where they are known.
    pub(super) from: Option<Joints>,
    pub(super) q: Joints,
    /// Axes that the target names.
    pub(super) named: AxisSet,
    pub(super) editable: bool,
    /// A Cartesian target that is written as joint moves.
    pub(super) solved: bool,
    /// The robot with the tool that goes straight to joint values; `None`: with its own.
    pub(super) tooled: Option<Arc<Tooled>>,
    /// A point on the way of an arc to joint values, in the robot's world, m.
    pub(super) via: Option<Vector3<f64>>,
}

/// Tool of a straight way or an arc, and a point of the arc between its ends; `None`: a joint move, and a straight way.
pub(super) type ToolAndMiddle = (Option<Arc<Tooled>>, Option<Vector3<f64>>);

/// A run that goes through a loop.
pub(super) struct Pass {
    pub(super) round: Round,
    /// Step of the first move in it.
    pub(super) first: Option<usize>,
    /// Vertices before it.
    pub(super) vertices: usize,
}

pub(super) struct Cutter<'a> {
    pub(super) choice: &'a Choice<'a>,
    pub(super) poses: &'a mut Poses,
    /// The robot with its own tool.
    pub(super) plain: Arc<Tooled>,
    pub(super) out: Cut,
    pub(super) run: Run,
    /// Where the axes stand that were commanded before a run has begun.
    pub(super) known: Vec<Option<f64>>,
    /// Axes of the run that stand elsewhere than it says, nobody knows where: it goes on in the others until one of them is named again.
    pub(super) free: AxisSet,
    /// Where the axes stood when the last run ended because one of them was named again.
    pub(super) rest: Option<Joints>,
    /// Joints at the last place of the program where they are known, else those of its first joint target; `None`: the arm may have
    /// gone over into another configuration since.
    pub(super) hint: Option<Joints>,
    /// All that the script says of the arm's configuration is the same.
    pub(super) one_arm: bool,
    /// Targets whose configurations are noted.
    pub(super) named: usize,
    /// Steps of joint motions that go over into another configuration of the arm.
    pub(super) over: Vec<usize>,
    /// The joints before are those of a target by its own letter for the wrist.
    pub(super) lettered: bool,
    /// Which wrist the robot has is known by a letter alone.
    pub(super) by_letter: bool,
    /// What speaks against the meaning of the letters.
    pub(super) tells: Tells,
    /// The move before led to joint values.
    pub(super) by_joints: bool,
    /// The frame of the last Cartesian target, if the last target was one.
    pub(super) last_frame: Option<LastFrame>,
    /// The robot stands still at the last vertex.
    pub(super) stands: bool,
    pub(super) tcp: LastTcp,
    pub(super) lengths: &'a Lengths,
    pub(super) directions: Directions,
    /// The loop that the run goes through.
    pub(super) pass: Option<Pass>,
    /// On its second pass.
    pub(super) again: bool,
    /// Loops whose passes are not known to be alike, by the step with which they open.
    pub(super) failed: Vec<usize>,
}

impl Cutter<'_> {
    /// Goes on over a step; the program starts with the break `entry`.
    pub(super) fn follow(&mut self, script: &Script, k: usize, rounds: &[Round], entry: Option<usize>) {
        let Some(step) = script.steps.get(k) else { return };
        match &step.kind {
            StepKind::Move(m) => self.take(script, k, step.at, m),
            StepKind::Dwell(seconds) => self.dwell(*seconds),
            // what moves nothing leaves a program at its start
            StepKind::Break(Break::Frame | Break::Interrupt) => {
                let still = self.run.vertices.is_empty() && self.run.entry && self.known.is_empty();
                self.end(still);
            }
            StepKind::Break(Break::Loop) => {
                let goes_on = match rounds.iter().find(|r| r.open == k || r.close == k) {
                    Some(round) if round.open == k => self.enter(*round),
                    Some(round) => self.second_pass(script, *round) && round.goes_on,
                    None => false,
                };
                if !goes_on {
                    self.end(false);
                }
            }
            StepKind::Break(Break::Axes(axes)) => self.slip(*axes),
            StepKind::Break(_) => self.end(entry == Some(k)),
            StepKind::Sets(name) => self.set(name),
            StepKind::Process(_) | StepKind::Pragma(_) => {}
        }
    }

    /// Ends the run; `entry`: the next one is the program's first.
    pub(super) fn end(&mut self, entry: bool) {
        if let Some(pass) = self.pass.take() {
            self.failed.push(pass.round.open);
        }
        let sides_known = self.choice.sides_given || self.directions.any();
        self.known.clear();
        self.free = AxisSet::default();
        self.directions.forget();
        let mut run = std::mem::replace(&mut self.run, empty_run(entry));
        // from which side the robot comes to the first point after a label, a loop or a call is not known: it stays
        if !run.entry
            && let Some(first) = run.vertices.first_mut().filter(|v| v.role != Role::Approach)
        {
            if first.editable {
                self.out.left.entry(first.step).or_insert(Cause::SideUnknown);
            }
            first.editable = false;
        }
        // a start from which nothing moves has no direction at all
        for still in run.vertices.iter_mut().filter(|v| !sides_known && v.editable) {
            still.editable = false;
            self.out.left.entry(still.step).or_insert(Cause::SideUnknown);
        }
        if !run.own().is_empty() {
            self.out.runs.push(run);
        } else if run.vertices.is_empty() {
            // its memory is that of the next one
            self.run.vertices = run.vertices;
        }
    }

    pub(super) fn lost(&mut self, at: At, why: Cause) {
        self.end(false);
        self.out.gaps.push(Gap { at, why });
    }

    /// A move that cannot be determined: only straight ones and arcs keep the arm in its configuration.
    pub(super) fn forget(&mut self, m: &Move) {
        self.last_frame = None;
        if m.path == PathKind::Joint {
            self.hint = None;
        }
    }

    pub(super) fn dwell(&mut self, seconds: Option<f64>) {
        let again = self.again;
        // before the first movement: the side from which that comes is the side of the first point, too
        if self.run.vertices.len() == 1 {
            return;
        }
        let Some(last) = self.run.vertices.last() else { return };
        let hold = Vertex {
            again,
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
    pub(super) fn start(&mut self, step: usize, q: Joints, editable: bool) {
        self.directions.go(self.choice.robot, &q, self.choice.deadband);
        self.run.vertices.push(first(step, q, editable));
    }

    /// The first point of a run, after a point from which its joints come to it from known sides.
    pub(super) fn start_over(&mut self, step: usize, at: At, m: &Move, reached: Reached) {
        let Reached { q, named, mut editable, tooled, .. } = reached;
        // a move to where the robot stands gets no step
        editable &= m.speed != Speed::Seconds(0.0);
        let approach = &self.choice.approach;
        let open = m.is_open_to_goal() && !self.run.entered.contains(&step) && self.free.is_empty();
        // where the program starts the first movement says from which side
        let counts = open
            && editable
            && (!self.run.entry || approach.is_apart(step))
            && approach.count(m)
            && approach.moves_all(m, named, q.len())
            && !approach.goes_without(step);
        let of_pose = || self.run.places.get(&step).map(|p| p.tooled.clone());
        let tooled = tooled.or_else(of_pose).unwrap_or_else(|| self.plain.clone());
        let point = if counts { approach.first_point(&tooled.robot, m.unplaced, &q) } else { None };
        let Some(point) = point else { return self.start(step, q, editable) };
        self.directions.go(self.choice.robot, &point, self.choice.deadband);
        let goal = first(step, q, editable);
        let speed = match m.speed {
            Speed::Seconds(whole) => Speed::Seconds(whole * approach::LEG),
            speed => speed,
        };
        let (robot, otherwise) = (self.choice.robot, self.choice.tcp_speed_m_s);
        self.tcp.knows(None);
        let duration = clock::duration_s(robot, &point, &goal.q, m.path, speed, otherwise, &|_| None, &mut self.tcp);
        if duration.is_none() {
            self.run.untimed.get_or_insert(at);
        }
        self.run.certain &= clock::is_certain(m.speed);
        self.run.by_program &= matches!(m.speed, Speed::Seconds(_));
        self.run.vertices.push(self.choice.approach.vertex(&goal, 0.0, point));
        self.directions.go(self.choice.robot, &goal.q, self.choice.deadband);
        self.run.vertices.push(Vertex { t_s: duration.unwrap_or(0.0), certain: false, ..goal });
    }

    /// Joints of a Cartesian target, with its frame and tool.
    pub(super) fn pose(&mut self, goal: &PoseGoal, m: &Move, from: Option<&[f64]>) -> Result<(Vec<f64>, Place), Cause> {
        let mut place = self.poses.place(goal)?;
        place.lettered = self.lettered;
        let q = place.joints(goal, from, m.path, self.hint.as_deref())?;
        Ok((q, place))
    }

    pub(super) fn take(&mut self, script: &Script, step: usize, at: At, m: &Move) {
        if let Some(pass) = self.pass.as_mut().filter(|p| p.first.is_none()) {
            pass.first = Some(step);
            self.run.entered.insert(step);
        }
        let from = self.run.vertices.last().map(|v| v.q.clone());
        let reached = match &m.goal {
            Goal::Joints(target) => self.joint_goal(script, script.targets.get(*target), step, at, m, from),
            Goal::Pose(goal) => self.pose_goal(goal, step, at, m, from),
            Goal::Opaque(_) if m.moves_alone.is_some() => {
                return self.goes_elsewhere(at, m.moves_alone.unwrap_or_default());
            }
            Goal::Opaque(_) => {
                // a relative motion would carry the offset of the goal before it along, and on an arc its start counts
                let counts = !m.absolute || m.path == PathKind::Curve;
                if let Some(last) = self.run.vertices.last_mut().filter(|_| counts) {
                    if last.editable {
                        self.out.left.entry(last.step).or_insert(Cause::BeforeUnknown);
                    }
                    last.editable = false;
                }
                self.forget(m);
                return self.lost(at, Cause::Undetermined);
            }
        };
        self.by_joints = matches!(m.goal, Goal::Joints(_));
        self.lettered = false;
        if self.by_joints {
            self.see_joints(reached.as_ref());
        }
        let Some(mut reached) = reached else { return };
        if let (Goal::Pose(goal), Some(place)) = (&m.goal, self.run.places.get(&step)) {
            self.lettered = place.is_preferred(goal, &reached.q);
        }
        self.hint = self.one_arm.then(|| reached.q.clone());
        match reached.from.take() {
            None => self.start_over(step, at, m, reached),
            Some(from) => self.go(script, step, at, m, &from, reached),
        }
        self.stands = m.blend_m == Some(0.0);
    }
}
