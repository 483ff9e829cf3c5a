//! The points of a run, and what is known of it as a whole.

use super::joints::Joints;
use crate::program::script::{At, AxisSet, Script, StepKind};
use crate::rewrite::script::poses::Place;
use crate::rewrite::script::way;
use std::collections::{BTreeMap, BTreeSet};

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
    /// The place where the robot stands, once more: there joints cross their gaps before they turn back.
    Crossing,
    /// A point of the way to where the run begins, which another run writes: it says from which side joints come.
    Before,
}

/// A point of a run.
#[derive(Debug, Clone)]
pub struct Vertex {
    pub step: usize,
    pub role: Role,
    /// rad or m, one per axis.
    pub q: Joints,
    /// Share of the way to the step's goal; 1 for a goal.
    pub share: f64,
    /// Its numbers may be written (or, on a way, a point may be put there).
    pub editable: bool,
    pub t_s: f64,
    /// The duration of the move to here is the program's own, no estimate.
    pub certain: bool,
    /// On the second pass of a loop: what comes out here has to be what came out on the first.
    pub again: bool,
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
    /// Those of first moves of loops from the end of the loop.
    pub lines_again: BTreeMap<usize, way::Line>,
    /// Straight moves and arcs whose way the robot's kinematics cannot follow: where a point on it would stand is not known.
    pub unfollowed: BTreeSet<usize>,
    /// First moves of loops, which come from before the loop and from its end: no point can be on both ways.
    pub entered: BTreeSet<usize>,
    /// Moves on which a frame or tool changes and one of them is computed: what is written in the one given for it is right in the same one
    /// alone, so that no point can be on their way.
    pub changing: BTreeSet<usize>,
    /// Frame and tool of Cartesian targets, by step.
    pub places: BTreeMap<usize, Place>,
    /// Axes that stand elsewhere on a step, nobody knows where: the run says where they stood before.
    pub elsewhere: BTreeMap<usize, AxisSet>,
    /// The program starts with it: nothing that moves stands before.
    pub entry: bool,
    /// Directions in which its gears first move by the program's own points, per axis; 0: they do not. Empty: it does not begin with a
    /// point that is to be added.
    pub first_directions: Vec<i8>,
}

impl Run {
    /// Times are known all along.
    pub fn timed(&self) -> bool {
        self.untimed.is_none()
    }

    /// It goes on from a place that another run leads to.
    pub fn goes_on(&self) -> bool {
        self.vertices.first().is_some_and(|v| v.role == Role::Before)
    }

    /// Its first target is reached over an added point, from known sides.
    pub fn is_approached(&self) -> bool {
        self.vertices.first().is_some_and(|v| v.role == Role::Approach)
    }

    /// Its points without those of another run before them.
    pub fn own(&self) -> &[Vertex] {
        self.vertices.get(self.before()..).unwrap_or_default()
    }

    /// Number of points of another run before its own.
    pub fn before(&self) -> usize {
        self.vertices.iter().take_while(|v| v.role == Role::Before).count()
    }

    /// What it writes another run has written: both have to agree.
    pub fn is_again(&self) -> bool {
        self.goes_on() && self.own().first().is_some_and(|v| v.again)
    }

    /// Goals of moves, each once.
    pub fn goals(&self) -> impl Iterator<Item = &Vertex> {
        self.vertices.iter().filter(|v| v.role == Role::Goal && !v.again)
    }

    /// A place on the way of a step, as the format tells it: an axis that stands elsewhere, or that the format does not tell, stays
    /// where the run has it, as `at`.
    pub fn standing(&self, step: usize, mut place: Vec<f64>, at: &[f64]) -> Vec<f64> {
        for axis in self.elsewhere.get(&step).into_iter().flat_map(|axes| axes.axes()) {
            if let (Some(q), Some(at)) = (place.get_mut(axis), at.get(axis)) {
                *q = *at;
            }
        }
        place.iter_mut().zip(at).filter(|(q, _)| q.is_nan()).for_each(|(q, at)| *q = *at);
        place
    }

    /// Axes that count from an origin that is not in the program, all along.
    pub fn unplaced(&self, script: &Script) -> AxisSet {
        let of = |v: &Vertex| match script.steps.get(v.step).map(|s| &s.kind) {
            Some(StepKind::Move(m)) => m.unplaced,
            _ => AxisSet::default(),
        };
        self.vertices.iter().map(of).reduce(AxisSet::and).unwrap_or_default()
    }

    /// The sampled way that leads to a goal: on the second pass of a loop its first move comes from the end of the loop.
    pub fn line_to(&self, goal: &Vertex) -> Option<&way::Line> {
        let again = self.lines_again.get(&goal.step).filter(|_| goal.again);
        again.or_else(|| self.line(goal.step))
    }

    /// The sampled way of a step.
    pub fn line(&self, step: usize) -> Option<&way::Line> {
        self.lines.get(&step)
    }
}

/// The goal of a step with which a run begins.
pub(super) fn first(step: usize, q: Joints, editable: bool) -> Vertex {
    Vertex { step, role: Role::Goal, q, share: 1.0, editable, t_s: 0.0, certain: true, again: false }
}

/// The place where the robot waits at a point for a while, s.
pub(super) fn held(at: &Vertex, seconds: f64) -> Vertex {
    let t_s = at.t_s + seconds;
    Vertex { role: Role::Hold, share: 1.0, editable: false, t_s, certain: true, ..at.clone() }
}

/// A run without points; `entry`: the program starts with it.
pub(super) fn empty_run(entry: bool) -> Run {
    Run { certain: true, by_program: true, entry, ..Run::default() }
}
