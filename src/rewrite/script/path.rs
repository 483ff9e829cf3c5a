//! A vendor program as one path in the joints, for jobs that run it on a machine: the verdict, `simulate`, `show`.
//!
//! Method: the runs of [`run::cut`], which solve Cartesian targets as a rewrite does. Joint moves go straight in the joints. A straight
//! move of the TCP and an arc through three points are solved at so many places ([`super::way::Line::at`]) that the TCP leaves them by at
//! most [`WITHIN_M`] between two. Where a move comes from, or the way that it takes, is not known, a new stretch starts at its goal; the
//! way there is straight in the joints and belongs to no stretch. Programs of joint moves to joint targets alone that do not branch are
//! read move by move ([`crate::program::joint_path`]).
//!
//! Assumptions: corners are not cut (zones, C_DIS, CNT), and a program is read once, in the order of its text. Where a program is so
//! long that it would have more than [`MOST_POINTS`] points, they stand further apart.

use super::approach::Sides;
use super::clock::{self, ARC_PARTS, LastTcp};
use super::context::Contexts;
use super::installation;
use super::job;
use super::poses::Poses;
use super::run::{self, Choice, Cut, Role, Run, Vertex};
use crate::error::{Error, Result, counted};
use crate::io::input::{self, Input};
use crate::numerics::parallel::ParMap;
use crate::program::files::Files;
use crate::program::formats::{self, Recognised};
use crate::program::script::{
    At, AxisSet, Break, Document, Format, Goal, Move, PathKind, Script, Speed, StepKind, Text, Way,
};
use crate::program::{Assumed, Moves, Program, ScriptPath, exact_stops};
use crate::robot::frames::{Frames, Missing};
use crate::robot::{JointKind, Robot};
use std::collections::BTreeMap;
use std::path::Path;

/// Most by which the TCP leaves its path between two solved places, m.
const WITHIN_M: f64 = 0.2e-6;
/// Points of solved ways at most.
const MOST_POINTS: usize = 200_000;
/// Joints that move by less stand still: the rounding of the solver, rad or m.
const STILL: f64 = 1e-9;
/// A move that turns no joint by more leads to where the robot stands: the rounding of a pose's last digits, rad or m.
const NO_MOVE: f64 = 2e-6;
/// Movement up to which a turn on a way gets no additional point, rad or m.
const TURN: f64 = 1e-7;
/// Way to the start of a stretch: TCP speed, m/s, share of the joints' largest speeds, and least duration, s.
const JOIN_M_S: f64 = 0.25;
const JOIN_SHARE: f64 = 0.5;
const JOIN_S: f64 = 0.1;

/// How programs are read.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    /// The robot of the program.
    pub robot: &'a Robot,
    /// Frames and tools besides those of the robot file.
    pub frames: &'a Frames,
    /// TCP speed of moves whose own is not known, m/s; `None`: [`Assumed`].
    pub tcp_speed_m_s: Option<f64>,
    /// The format that was asked for; else it is recognised.
    pub format: Option<Recognised>,
}

impl<'a> Reading<'a> {
    /// For a robot, with a TCP speed in mm/s where the user gives one.
    pub fn new(robot: &'a Robot, frames: &'a Frames, tcp_speed_mm_s: Option<f64>) -> Self {
        Self { robot, frames, tcp_speed_m_s: tcp_speed_mm_s.map(|v| v * 1e-3), format: None }
    }
}

impl Reading<'_> {
    /// Reads the program at `path`, whose bytes are `input`'s: rows of joints as they are, a vendor's with the files that belong to it.
    ///
    /// # Errors
    /// Where it cannot be read, and where it has no move whose goal is known.
    pub fn load(&self, path: &Path, input: Input) -> Result<Program> {
        match self.format.unwrap_or_else(|| formats::recognise(path, &input.bytes)) {
            Recognised::Csv => Program::parse(input, self.robot),
            Recognised::Script(format) => {
                let Input { bytes, sha256, .. } = input;
                let (texts, _) =
                    job::texts(format, path, bytes, &Files::Disk, &Contexts::default(), self.robot.axes())?;
                self.solved(format, texts, sha256)
            }
        }
    }

    /// Reads a program that was written from the one at `path`: its own text and those that belong to it, by name and bytes. What
    /// stands beside `path` counts for it, too.
    ///
    /// # Errors
    /// As for [`Self::load`].
    pub fn written(&self, path: &Path, texts: Vec<(String, Vec<u8>)>) -> Result<Program> {
        let head = texts.first().map_or(&[][..], |t| t.1.as_slice());
        let Recognised::Script(format) = self.format.unwrap_or_else(|| formats::recognise(path, head)) else {
            return Program::of_texts(texts, self.robot);
        };
        let sha256 = input::sha256(head);
        let own = texts.into_iter().map(|(name, bytes)| Text::new(name, bytes));
        let texts = own.chain(Contexts::default().of(format, path, self.robot.axes())).collect();
        self.solved(format, texts, sha256)
    }

    fn solved(&self, format: &dyn Format, texts: Vec<Text>, sha256: String) -> Result<Program> {
        let held = installation::with_bases(self.robot, self.frames);
        let axes = held.as_ref().unwrap_or(self.robot).axes();
        let document = format.parse(texts, axes)?;
        let script = document.script();
        // between joint values a straight move of an arm is straight at the TCP
        let arm = self.robot.axis_joints().all(|j| j.kind == JointKind::Revolute);
        let plain = |m: &Move| matches!(m.goal, Goal::Joints(_)) && !(arm && m.path == PathKind::Linear);
        let assumed = self.assumed(script);
        // where control branches, the moves do not follow each other in the order of the text
        let branches = |kind: &StepKind| matches!(kind, StepKind::Break(Break::Jump | Break::Loop));
        // and what stands after the call of a routine of the text is reached from the end of that routine
        let routines = script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Start))).count();
        let in_order = routines < 2 && !script.steps.iter().any(|s| branches(&s.kind));
        if script.moves().all(|(_, m)| plain(m)) && in_order {
            return self.plain(document.as_ref(), sha256, assumed);
        }
        // the joints of Cartesian targets are those that the rewriter finds
        let limited = installation::limited(script, self.frames, self.robot);
        let robot = limited.as_ref().map_or(self.robot, |l| &l.0);
        let commanded = super::commanded(script, robot.dof());
        let choice = Choice {
            robot,
            deadband: &vec![TURN; robot.dof()],
            tcp_speed_m_s: Some(assumed.m_s()),
            certain_speed_m_s: None,
            excluded: &|_| false,
            solve_within_m: None,
            commanded: &commanded,
            by_place: AxisSet::default(),
            as_poses: true,
            on_way: &|step, share| document.on_way(step, share),
            approach: Sides::default(),
            forgets_over: None,
            crossing_s: &[],
            sides_given: true,
            rounds: true,
            joins: false,
        };
        let mut poses = Poses::new(robot, self.frames);
        let root = installation::root(script, self.frames)?;
        poses.world = installation::world(robot, root.as_ref());
        let Cut { mut runs, gaps, .. } = run::cut(script, &choice, &mut poses);
        begin_where_control_does(script, &mut runs);
        let moves = script.moves().count();
        let mut path = Points::new(robot, script, runs.iter().all(Run::timed));
        let within_m = spacing(&runs);
        for run in &runs {
            path.take(document.as_ref(), run, within_m);
        }
        if path.points() == 0 {
            let first = script.moves().next().map_or(At { file: 0, line: 1 }, |(k, _)| script.steps[k].at);
            let none = (first, String::from("no move whose goal is known"));
            let (at, why) = gaps.first().map_or(none, |g| (g.at, g.why.to_string()));
            let expected = "a program with at least one move to a known position";
            return Err(Error::bad(script.place(at), why, expected).mended_by(&["frames"]));
        }
        let unknown_speed = path.assumed;
        let told = Moves { all: moves, known: path.known, unknown_start: path.unknown_start, unknown_speed };
        let name = script.texts.first().map_or(String::new(), |t| t.name.clone());
        let exact_stops = exact_stops(document.as_ref());
        let waits_for = waits_for(&poses.missing);
        let script_path = ScriptPath { starts: path.starts, moves: told, exact_stops, waits_for, assumed };
        let t_s = path.timed.then_some(path.t_s);
        Ok(Program { goals: path.goals, ..Program::of_path(name, sha256, path.q, t_s, script_path) })
    }

    /// The speed of moves that state none. New points repeat the speeds of a program, so that the middle one of the different speeds is
    /// the same before and after a rewrite.
    fn assumed(&self, script: &Script) -> Assumed {
        if let Some(v) = self.tcp_speed_m_s {
            return Assumed::Requested(v);
        }
        let stated = script.moves().filter_map(|(_, m)| match m.speed {
            Speed::Tcp(v) if v > 0.0 => Some(v),
            _ => None,
        });
        let mut stated: Vec<f64> = stated.collect();
        stated.sort_by(f64::total_cmp);
        stated.dedup();
        stated.get(stated.len().saturating_sub(1) / 2).map_or(Assumed::Manual, |v| Assumed::OfProgram(*v))
    }

    /// A program of joint moves to joint targets alone, at its own times or at its speeds.
    fn plain(&self, document: &dyn Document, sha256: String, assumed: Assumed) -> Result<Program> {
        let program = Program::of_document(document, sha256.clone(), self.robot)?;
        if program.t_s.is_some() {
            return Ok(program);
        }
        let otherwise = Some(assumed.m_s());
        let none = |_: f64| None;
        let duration = |m: &Move, from: &[f64], to: &[f64]| {
            clock::duration_s(self.robot, from, to, m.path, m.speed, otherwise, &none, &mut LastTcp::default())
        };
        let mut program = Program::of_document_timed(document, sha256, self.robot, &duration)?;
        if let Some(told) = &mut program.script {
            told.assumed = assumed;
            let unknown = document.script().moves().skip(1).filter(|(_, m)| m.speed == Speed::Unknown).count();
            told.moves.unknown_speed = if program.t_s.is_some() { unknown } else { 0 };
        }
        Ok(program)
    }
}

/// Frames and tools that moves wait for.
fn waits_for(missing: &Missing) -> Vec<String> {
    let of = |what: &'static str, names: &BTreeMap<String, u64>| -> Vec<String> {
        names.iter().map(|(name, moves)| format!("{what} `{name}` ({})", counted(*moves as usize, "move"))).collect()
    };
    [of("frame", &missing.frames), of("tool", &missing.tools)].concat()
}

/// Puts what leads to the first run before it, where that is reached from a routine of the text and not from the program's start.
fn begin_where_control_does(script: &Script, runs: &mut [Run]) {
    let is_move = |k: &usize| matches!(script.steps.get(*k).map(|s| &s.kind), Some(StepKind::Move(_)));
    for done in 0..runs.len() {
        let Some(first) = runs.first().filter(|run| !run.entry).and_then(|run| run.own().first()) else { return };
        let leads = |at: usize| at < first.step && !(at..first.step).any(|k| is_move(&k));
        let Some(join) = script.joins.iter().rev().find(|join| leads(join.at)) else { return };
        let last = join.from.first().and_then(|&end| (0..end).rev().find(is_move));
        let of = |run: &Run| run.own().iter().any(|v| Some(v.step) == last);
        // those before it are in their order already
        let Some(k) = runs.iter().position(of).filter(|k| *k > done) else { return };
        runs[..=k].rotate_right(1);
    }
}

/// Distance within which ways are followed: [`WITHIN_M`], or more for a program of too many points.
fn spacing(runs: &[Run]) -> f64 {
    let of = |run: &Run| run.lines.values().map(|l| l.parts_within(WITHIN_M)).sum::<usize>();
    let points: usize = runs.iter().map(of).sum();
    WITHIN_M * (points as f64 / MOST_POINTS as f64).max(1.0).powi(2)
}

/// The points of a path as they come together.
struct Points<'a> {
    robot: &'a Robot,
    script: &'a Script,
    q: Vec<Vec<f64>>,
    t_s: Vec<f64>,
    timed: bool,
    starts: Vec<usize>,
    /// Points that are goals of moves.
    goals: Vec<usize>,
    known: usize,
    unknown_start: usize,
    assumed: usize,
    /// Time of a run's clock at 0 on that of the program, s.
    offset_s: f64,
}

impl<'a> Points<'a> {
    fn new(robot: &'a Robot, script: &'a Script, timed: bool) -> Self {
        Self {
            robot,
            script,
            q: vec![Vec::new(); robot.dof()],
            t_s: Vec::new(),
            timed,
            starts: Vec::new(),
            goals: Vec::new(),
            known: 0,
            unknown_start: 0,
            assumed: 0,
            offset_s: 0.0,
        }
    }

    fn points(&self) -> usize {
        self.t_s.len()
    }

    fn push(&mut self, q: &[f64], t_s: f64) {
        let first = self.starts.last().copied().unwrap_or(0) == self.points();
        for (column, &v) in self.q.iter_mut().zip(q) {
            let stands = column.last().copied().filter(|last| !first && (v - last).abs() < STILL);
            column.push(stands.unwrap_or(v));
        }
        self.t_s.push(t_s);
    }

    /// Whether the robot stands at these joints already.
    fn stands_at(&self, q: &[f64]) -> bool {
        self.q.iter().zip(q).all(|(column, v)| column.last().is_some_and(|last| (v - last).abs() <= NO_MOVE))
    }

    /// A stretch starts where the robot stands at `v`.
    fn start(&mut self, v: &Vertex) {
        let mut t_s = 0.0;
        if let Some(last) = self.t_s.last() {
            let before: Vec<f64> = self.q.iter().filter_map(|c| c.last().copied()).collect();
            let tcp_s = (self.robot.tcp_m(&v.q) - self.robot.tcp_m(&before)).norm() / JOIN_M_S;
            let joint_s = |(k, j): (usize, &crate::robot::Joint)| {
                j.max_speed.map_or(0.0, |speed| (v.q[k] - before[k]).abs() / (speed * JOIN_SHARE))
            };
            t_s = last + self.robot.axis_joints().enumerate().map(joint_s).fold(tcp_s.max(JOIN_S), f64::max);
            self.starts.push(self.points());
        }
        self.offset_s = t_s - v.t_s;
        self.push(&v.q, t_s);
    }

    fn take(&mut self, document: &dyn Document, run: &Run, within_m: f64) {
        // the ways between goals do not depend on each other
        let ends: Vec<usize> =
            (0..run.vertices.len()).filter(|&i| matches!(run.vertices[i].role, Role::Goal | Role::Hold)).collect();
        let ways: Vec<Option<Vec<Way>>> = (0..ends.len()).par_map(|n| {
            let from = n.checked_sub(1).map(|before| ends[before])?;
            self.way(document, run, &run.vertices[from..=ends[n]], within_m)
        });
        let mut before: Option<&Vertex> = None;
        for (&end, way) in ends.iter().zip(ways) {
            let v = &run.vertices[end];
            let StepKind::Move(m) = &self.script.steps[v.step].kind else { continue };
            match (before, way) {
                (Some(from), Some(way)) => {
                    // a full circle ends where it begins, too
                    let stays = v.role == Role::Goal && way.iter().all(|w| self.stands_at(&w.q));
                    let way = if stays { Vec::new() } else { way };
                    for Way { share, q } in way {
                        self.push(&q, self.offset_s + from.t_s + share * (v.t_s - from.t_s));
                    }
                    self.known += usize::from(v.role == Role::Goal);
                    self.assumed += usize::from(v.role == Role::Goal && m.speed == Speed::Unknown);
                }
                _ => {
                    self.start(v);
                    self.unknown_start += 1;
                }
            }
            if v.role == Role::Goal {
                self.goals.push(self.points() - 1);
            }
            before = Some(v);
        }
    }

    /// Joints on the way from the first of `vertices` to the last, both ends' shares 0 and 1, without the start; `None`: the way is not
    /// known.
    fn way(&self, document: &dyn Document, run: &Run, vertices: &[Vertex], within_m: f64) -> Option<Vec<Way>> {
        let (goal, turns) = (vertices.last()?, vertices.get(1..vertices.len() - 1)?);
        let end = Way { share: 1.0, q: goal.q.to_vec() };
        if goal.role == Role::Hold {
            return Some(vec![end]);
        }
        let StepKind::Move(m) = &self.script.steps[goal.step].kind else { return None };
        let points = |parts: usize, at: &dyn Fn(f64) -> Option<Vec<f64>>| {
            let inner = (1..parts).map(|k| k as f64 / parts as f64).map(|share| Some(Way { share, q: at(share)? }));
            inner.collect::<Option<Vec<Way>>>()
        };
        let mut way = match run.line_to(goal) {
            Some(line) => points(line.parts_within(within_m), &|share| line.at(share))?,
            None if m.path == PathKind::Curve && document.on_way(goal.step, 0.5).is_some() => {
                points(ARC_PARTS, &|share| Some(run.standing(goal.step, document.on_way(goal.step, share)?, &goal.q)))?
            }
            None if self.is_straight(m) => Vec::new(),
            None => return None,
        };
        way.extend(turns.iter().filter(|v| v.role == Role::Way).map(|v| Way { share: v.share, q: v.q.to_vec() }));
        way.sort_by(|a, b| a.share.total_cmp(&b.share));
        way.push(end);
        Some(way)
    }

    /// Whether a move without a solved way is straight in the joints. A straight move between joint values that lead through
    /// another arm configuration has no way that an arm could take; its ends are known all the same, and what a joint does
    /// between them decides on which side of its gap it stands.
    fn is_straight(&self, m: &Move) -> bool {
        let gantry = || self.robot.axis_joints().all(|j| j.kind == JointKind::Prismatic);
        let linear = m.path == PathKind::Linear;
        m.path == PathKind::Joint || !m.way.is_empty() || linear && (gantry() || matches!(m.goal, Goal::Joints(_)))
    }
}
