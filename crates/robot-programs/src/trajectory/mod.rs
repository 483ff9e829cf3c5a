//! ROS trajectories: `trajectory_msgs/JointTrajectory` in YAML and JSON, alone or within another message.
//!
//! A trajectory is a mapping with `joint_names` and `points`; every one in a file is a separate run. Points hold positions
//! (rad, m) in the order of `joint_names`, a time, and perhaps velocities, accelerations and efforts. Joints are those of the
//! robot by name; other joints move on as written. Points are passed, not cut, so that the radius of their corners is 0.
//! What is edited, and how new points fit into a controller's splines: docs/program-trajectory.md.
//!
//! Modules:
//! - [`tree`]: YAML and JSON with the bytes of every node; [`plain`]: the same of plain texts, fast.
//! - [`read`]: trajectories, with every refusal.
//! - [`spline`]: what a controller makes of points; velocities of new ones.
//! - [`time`]: times of new points.
//! - [`passed`]: points of splines for those who follow the path.
//! - [`reason`]: why a point stays.
//! - [`write`]: patches, and new points in the style of the file.
//!
//! References: trajectory_msgs (common_interfaces), control_msgs/FollowJointTrajectory, moveit_msgs/RobotTrajectory; YAML 1.2.
//!
//! # Example
//!
//! The first point of a trajectory, in rad.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, Goal, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"joint_names: [J1, J2, J3, J4, J5, J6]\npoints:\n  - positions: [0.1, 0, 0, 0, 0, 0]\n    time_from_start: {sec: 1, nanosec: 0}\n";
//! let program = robot_programs::trajectory::Ros.parse(vec![Text::new("home.yaml", source.to_vec())], &axes)?;
//! let (_, goal) = program.script().moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let target = program.script().targets.get(target).expect("the target of a move");
//! let deg: Vec<f64> = target.values.iter().map(|v| v.map_or(f64::NAN, |v| v.si.to_degrees())).collect();
//! let written = [0.1f64.to_degrees(), 0.0, 0.0, 0.0, 0.0, 0.0];
//! assert!(deg.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-9));
//! # Ok::<(), robot_programs::Error>(())
//! ```

mod passed;
mod plain;
mod read;
pub(crate) mod reason;
mod spline;
#[cfg(test)]
mod tests;
mod time;
mod tree;
mod write;

use super::script::cursor::unmarked;
use super::script::lex::not_too_long;
use super::script::{
    At, Break, Document, Edits, Format, Goal, How, Move, Note, Patches, PathKind, Script, Speed, Step, Way,
};
use super::script::{StepKind, Target, Text, Value, number, pragma};
use crate::axes::Axes;
use crate::error::Result;
use read::{Content, Num, Point, Trajectory};
pub use reason::Reason;
use std::collections::BTreeMap;
use time::Shares;
use tree::Tree;

/// Digits after the point that a changed number gets where it has fewer and more are asked for: 1e-9 rad is far below any
/// encoder, and a controller holds doubles.
const DECIMALS: u8 = 9;
/// A double has no more.
const MOST_DECIMALS: u8 = 17;
/// Decimals of a velocity, acceleration, effort or time at most.
const RATE_DECIMALS: u8 = 12;

/// The format.
pub struct Ros;

impl Format for Ros {
    fn name(&self) -> &'static str {
        "trajectory"
    }

    fn title(&self) -> &'static str {
        "ROS JointTrajectory (YAML, JSON)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["yaml", "yml", "json"]
    }

    /// `joint_names` and `points` as keys, in whatever order: robot files, models and summaries have no such pair.
    fn recognises(&self, bytes: &[u8]) -> bool {
        has_key(bytes, b"joint_names") && has_key(bytes, b"points")
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        let empty = Text::default();
        let text = texts.first().unwrap_or(&empty);
        not_too_long(text)?;
        lines_end_alike(text)?;
        let mut tree = Tree::read(text)?;
        let content = read::content(text, &mut tree)?;
        if content.trajectories.is_empty() {
            let expected = "a JointTrajectory: a mapping with `joint_names` and `points`";
            return Err(text.bad(0, "no trajectory", expected));
        }
        let mut document =
            Trajectories { script: Script::default(), tree, content, axes: Vec::new(), of_step: Vec::new() };
        document.fill(text, robot)?;
        document.script.texts = texts;
        Ok(Box::new(document))
    }
}

/// Refuses a carriage return alone among line feeds: to YAML it ends a line, to an editor and to our lines it does not, so that what
/// stands after it would be copied with a point to which it does not belong. In JSON it is a blank.
fn lines_end_alike(text: &Text) -> Result<()> {
    let bytes = unmarked(&text.bytes);
    let json = matches!(bytes.trim_ascii_start().first(), Some(b'{' | b'['));
    if json || memchr::memchr(b'\n', &text.bytes).is_none() {
        return Ok(());
    }
    match memchr::memchr_iter(b'\r', &text.bytes).find(|at| text.bytes.get(at + 1) != Some(&b'\n')) {
        Some(at) => Err(text.bad(at, "a carriage return without a line feed", "lines that all end in the same way")),
        None => Ok(()),
    }
}

/// Whether a word stands as a key: at the start of a line or after a bracket, comma, dash or quote, and a colon after it.
fn has_key(bytes: &[u8], key: &[u8]) -> bool {
    memchr::memmem::find_iter(bytes, key).any(|at| {
        // a line of JSON can be as long as the file
        let far = at.saturating_sub(4096);
        let start = bytes[far..at].iter().rposition(|b| matches!(b, b'\n' | b'\r')).map_or(far, |k| far + k + 1);
        let before = bytes[start..at].trim_ascii_end();
        let before = before.strip_suffix(b"\"").or_else(|| before.strip_suffix(b"'")).unwrap_or(before);
        let before = before.trim_ascii_end();
        let opens = matches!(before.last(), None | Some(b'{' | b'[' | b',' | b'-' | b'\xBF'));
        let following = &bytes[at + key.len()..];
        let following = following.strip_prefix(b"\"").or_else(|| following.strip_prefix(b"'")).unwrap_or(following);
        opens && !before.contains(&b'#') && following.trim_ascii_start().first() == Some(&b':')
    })
}

/// Decimals that a position can have at most.
fn most_decimals(style: number::Style) -> u8 {
    DECIMALS.max(style.decimals.min(MOST_DECIMALS))
}

/// A number with `decimals` digits, zeros after those of its style left out.
fn fine(value: f64, style: number::Style, decimals: u8) -> String {
    let text = number::write(value, style, decimals.max(style.decimals.min(RATE_DECIMALS)));
    let Some((whole, digits)) = text.split_once('.') else { return text };
    let keep = digits.trim_end_matches('0').len().max(usize::from(style.decimals.min(RATE_DECIMALS)));
    let digits = digits.get(..keep).unwrap_or(digits);
    if digits.is_empty() && !style.point { whole.into() } else { format!("{whole}.{digits}") }
}

/// First byte, step, trajectory and point.
type Found = (u32, Step, Option<(u32, u32)>);

/// A file of trajectories.
struct Trajectories {
    script: Script,
    tree: Tree,
    content: Content,
    /// `axes[trajectory][column]`: axis of the robot, where it has one of that name.
    axes: Vec<Vec<Option<usize>>>,
    /// Trajectory and point of each step that is a move.
    of_step: Vec<Option<(u32, u32)>>,
}

impl Document for Trajectories {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::patches(self, edits)
    }

    fn passes_points(&self) -> bool {
        true
    }

    /// On the spline, at the time at which a new point of this share is written: where the spline turns between its points, shares are
    /// those of its time, else those of the way of the joint that goes furthest.
    fn on_way(&self, step: usize, share: f64) -> Option<Vec<f64>> {
        let (t, before, p, axes) = self.between(step)?;
        if p.order_from(before) == spline::Order::Linear {
            return None;
        }
        let x = Shares::of(t, (before, p), axes).of_time(p, share);
        Some(on_spline(t, (before, p), axes, self.dof(), x))
    }

    fn passed(&self) -> BTreeMap<usize, Vec<Way>> {
        self.splines()
    }

    fn straightened(&self, step: usize) -> Option<Vec<f64>> {
        self.off_spline(step)
    }
}

impl Trajectories {
    /// Steps, targets and notes.
    fn fill(&mut self, text: &Text, robot: &Axes) -> Result<()> {
        let at = |byte: usize| At { file: 0, line: text.line_of(byte) };
        let points = self.content.trajectories.iter().map(|t| t.points.len() + 1).sum::<usize>();
        let mut steps: Vec<Found> = Vec::with_capacity(points + self.tree.comments.len());
        let mut add = |byte: usize, kind: StepKind, of: Option<(u32, u32)>| {
            let step = Step::following(steps.last().map(|before| &before.1), at(byte), kind);
            steps.push((byte as u32, step, of));
        };
        for c in &self.tree.comments {
            if let Some(on) = pragma(text.slice(c.clone())) {
                add(c.start, StepKind::Pragma(on), None);
            }
        }
        for (byte, reason) in &self.content.left {
            self.script.notes.push(Note { place: at(*byte), text: reason.clone() });
        }
        for (k, t) in self.content.trajectories.iter().enumerate() {
            let axes: Vec<Option<usize>> = t.names.iter().map(|n| robot.axis_named(n)).collect();
            self.script.notes.extend(note(t, &axes, robot, text)?);
            add(t.start, StepKind::Break(Break::Start), None);
            for (i, p) in t.points.iter().enumerate() {
                let before = i.checked_sub(1).and_then(|b| t.points.get(b));
                let target = self.script.targets.len();
                let m = movement(t, (before, p), target, &axes, robot.dof());
                if let Goal::Joints(_) = m.goal {
                    let values = values(t.numbers(p.positions), &axes, robot.dof());
                    self.script.targets.push(Target { at: at(p.span.start()), values, ..Target::default() });
                }
                add(p.span.start(), StepKind::Move(m), Some((k as u32, i as u32)));
            }
            self.axes.push(axes);
        }
        // stable: the start of a trajectory stands before its first point, wherever that is
        steps.sort_by_key(|s| s.0);
        self.of_step = steps.iter().map(|step| step.2).collect();
        self.script.steps = steps.into_iter().map(|step| step.1).collect();
        Ok(())
    }
}

/// What a user should know of a trajectory's joints; refuses one that has none of the robot's.
fn note(t: &Trajectory, axes: &[Option<usize>], robot: &Axes, text: &Text) -> Result<Vec<Note>> {
    if axes.iter().all(Option::is_none) {
        let found = format!("joints {}", t.names.join(", "));
        return Err(text.bad(
            t.names_at,
            found,
            format!("at least one of the robot: {}", robot.axis_names().join(", ")),
        ));
    }
    let place = At { file: 0, line: text.line_of(t.names_at) };
    let foreign: Vec<&str> = t.names.iter().zip(axes).filter(|(_, a)| a.is_none()).map(|(n, _)| n.as_str()).collect();
    let idle: Vec<&str> =
        robot.axis_names().into_iter().enumerate().filter(|(k, _)| !axes.contains(&Some(*k))).map(|(_, n)| n).collect();
    let mut notes = Vec::new();
    if !foreign.is_empty() {
        let text = format!("not joints of the robot, left as they are: {}", foreign.join(", "));
        notes.push(Note { place, text });
    }
    if !idle.is_empty() {
        notes.push(Note { place, text: format!("joints of the robot that are not commanded: {}", idle.join(", ")) });
    }
    Ok(notes)
}

/// Turns of a spline nearer to one of its ends than this share of its time are those of the end.
const AT_END: f64 = 1e-3;
/// Parts of a spline between which a joint turns at most once.
const PARTS: u32 = 64;

/// Shares of the time between two points at which joints of the robot turn: their velocity changes its sign.
fn turns(t: &Trajectory, before: &Point, p: &Point, axes: &[Option<usize>]) -> Vec<f64> {
    let (order, h_s) = (p.order_from(before), p.t_s - before.t_s);
    let mut shares = Vec::new();
    if order == spline::Order::Linear || before.positions.is_empty() || p.positions.is_empty() {
        return shares;
    }
    for (c, _) in axes.iter().enumerate().filter(|(_, axis)| axis.is_some()) {
        let (from, to) = (state(t, before, c), state(t, p, c));
        let velocity = |x: f64| spline::at(order, from, to, h_s, x).v;
        for k in 0..PARTS {
            let part = |k: u32| AT_END + (1.0 - 2.0 * AT_END) * f64::from(k) / f64::from(PARTS);
            let (mut low, mut high) = (part(k), part(k + 1));
            let rising = velocity(high) > 0.0;
            if rising == (velocity(low) > 0.0) {
                continue;
            }
            while high - low > 1e-12 {
                let middle = f64::midpoint(low, high);
                *(if (velocity(middle) > 0.0) == rising { &mut high } else { &mut low }) = middle;
            }
            shares.push(f64::midpoint(low, high));
        }
    }
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|b, a| *b - *a < AT_END);
    shares
}

/// The robot's joints at a share of the time between two points; NaN for an axis that the message does not name.
fn on_spline(
    t: &Trajectory,
    (before, p): (&Point, &Point),
    axes: &[Option<usize>],
    dof: usize,
    share: f64,
) -> Vec<f64> {
    let (order, h_s) = (p.order_from(before), p.t_s - before.t_s);
    let mut q = vec![f64::NAN; dof];
    for (c, axis) in axes.iter().enumerate() {
        if let Some(slot) = axis.and_then(|a| q.get_mut(a)) {
            *slot = spline::at(order, state(t, before, c), state(t, p, c), h_s, share).p;
        }
    }
    q
}

/// Position, velocity and acceleration of a column at a point.
fn state(t: &Trajectory, p: &Point, column: usize) -> spline::State {
    let of = |list| t.numbers(list).get(column).map_or(0.0, |n| n.value);
    spline::State { p: of(p.positions), v: of(p.velocities), a: of(p.accelerations) }
}

fn movement(
    t: &Trajectory,
    (before, p): (Option<&Point>, &Point),
    target: usize,
    axes: &[Option<usize>],
    dof: usize,
) -> Move {
    let h_s = p.t_s - before.map_or(0.0, |b| b.t_s);
    let closed = closed(before, p).map(Into::into);
    let way = match before {
        Some(b) if closed.is_none() => turns(t, b, p, axes),
        _ => Vec::new(),
    };
    let way = before.filter(|_| !way.is_empty()).map_or(Vec::new(), |b| {
        let shares = Shares::of(t, (b, p), axes);
        // a point can stand there only at a time that can be written
        let written = way.into_iter().map(|share| shares.of_time(p, share));
        written.map(|share| Way { share, q: on_spline(t, (b, p), axes, dof, share) }).collect()
    });
    // the robot stands at a first point at time 0
    let stands = before.is_none() && p.t_s == 0.0;
    let goal = if p.positions.is_empty() { Goal::opaque(Reason::NoPositions) } else { Goal::Joints(target) };
    let speed = match () {
        () if h_s > 0.0 => Speed::Seconds(h_s),
        () if stands => Speed::Seconds(0.0),
        () => Speed::Unknown,
    };
    Move::new(How { path: PathKind::Joint, closed, speed, blend_m: Some(0.0), ..How::default() }, goal, way)
}

/// Why no point can be put before this one.
fn closed(before: Option<&Point>, p: &Point) -> Option<Reason> {
    let Some(b) = before else { return Some(Reason::First) };
    if let Some(key) = &p.foreign {
        return Some(Reason::ForeignKey(key.clone()));
    }
    if b.positions.is_empty() || p.positions.is_empty() {
        return Some(Reason::EndWithoutPositions);
    }
    if b.velocities.is_empty() != p.velocities.is_empty() || b.accelerations.is_empty() != p.accelerations.is_empty() {
        return Some(Reason::AtOneEnd);
    }
    if p.velocities.is_empty() && !p.accelerations.is_empty() {
        return Some(Reason::AccelerationsAlone);
    }
    None
}

fn values(positions: &[Num], axes: &[Option<usize>], dof: usize) -> Vec<Option<Value>> {
    let mut values = vec![None; dof];
    for (n, axis) in positions.iter().zip(axes) {
        if let Some(slot) = axis.and_then(|a| values.get_mut(a)) {
            *slot = Some(value(n));
        }
    }
    values
}

fn value(n: &Num) -> Value {
    Value {
        si: n.value,
        start: n.span.start(),
        end: n.span.end(),
        style: n.style,
        digit: number::last_digit(n.style.decimals),
        finest: number::last_digit(most_decimals(n.style)),
    }
}
