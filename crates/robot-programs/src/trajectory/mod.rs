//! ROS trajectories: `trajectory_msgs/JointTrajectory` in YAML and JSON, alone or within another message.
//!
//! A trajectory is a mapping with `joint_names` and `points`; every one in a file is a run of its own. Points hold positions
//! (rad, m) in the order of `joint_names`, a time, and perhaps velocities, accelerations and efforts. Joints are those of the
//! robot by name; other joints move on as written. Points are passed, not cut, so that the radius of their corners is 0.
//! What is edited, and how new points fit into a controller's splines: docs/program-trajectory.md.
//!
//! Rooms:
//! - [`tree`]: YAML and JSON with the bytes of every node.
//! - [`read`]: trajectories, with every refusal.
//! - [`spline`]: what a controller makes of points; times and velocities of new ones.
//! - [`write`]: patches, and new points in the style of the file.
//!
//! References: trajectory_msgs (common_interfaces), control_msgs/FollowJointTrajectory, moveit_msgs/RobotTrajectory; YAML 1.2.

mod read;
mod spline;
#[cfg(test)]
mod tests;
mod tree;
mod write;

use super::script::{At, Break, Document, Edits, Format, Goal, Move, Note, Patch, PathKind, Script, Speed, Step};
use super::script::{StepKind, Target, Text, Value, number, pragma};
use crate::axes::Axes;
use crate::error::Result;
use read::{Content, Num, Point, Trajectory};
use tree::Tree;

/// Digits behind the point that a changed number gets where it has fewer and more are asked for: 1e-9 rad is far below any
/// encoder, and a controller holds doubles.
const DECIMALS: u8 = 9;
/// A double has no more.
const MOST_DECIMALS: u8 = 17;

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
        let tree = Tree::read(text)?;
        let content = read::content(text, &tree)?;
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

/// Whether a word stands as a key: at the start of a line or behind a bracket, comma, dash or quote, and a colon behind it.
fn has_key(bytes: &[u8], key: &[u8]) -> bool {
    memchr::memmem::find_iter(bytes, key).any(|at| {
        // a line of JSON can be as long as the file
        let far = at.saturating_sub(4096);
        let start = bytes[far..at].iter().rposition(|b| matches!(b, b'\n' | b'\r')).map_or(far, |k| far + k + 1);
        let before = bytes[start..at].trim_ascii_end();
        let before = before.strip_suffix(b"\"").or_else(|| before.strip_suffix(b"'")).unwrap_or(before);
        let before = before.trim_ascii_end();
        let opens = matches!(before.last(), None | Some(b'{' | b'[' | b',' | b'-' | b'\xBF'));
        let behind = &bytes[at + key.len()..];
        let behind = behind.strip_prefix(b"\"").or_else(|| behind.strip_prefix(b"'")).unwrap_or(behind);
        opens && !before.contains(&b'#') && behind.trim_ascii_start().first() == Some(&b':')
    })
}

/// Decimals that a position can have at most.
fn most_decimals(style: number::Style) -> u8 {
    DECIMALS.max(style.decimals.min(MOST_DECIMALS))
}

/// First byte, step, trajectory and point.
type Found = (usize, StepKind, Option<(usize, usize)>);

/// A file of trajectories.
struct Trajectories {
    script: Script,
    tree: Tree,
    content: Content,
    /// `axes[trajectory][column]`: axis of the robot, where it has one of that name.
    axes: Vec<Vec<Option<usize>>>,
    /// Trajectory and point of each step that is a move.
    of_step: Vec<Option<(usize, usize)>>,
}

impl Document for Trajectories {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Vec<Patch>> {
        write::patches(self, edits)
    }
}

impl Trajectories {
    /// Steps, targets and notes.
    fn fill(&mut self, text: &Text, robot: &Axes) -> Result<()> {
        let at = |byte: usize| At { file: 0, line: text.line_of(byte) };
        let mut steps: Vec<Found> = Vec::new();
        for c in &self.tree.comments {
            if let Some(on) = pragma(text.slice(c.clone())) {
                steps.push((c.start, StepKind::Pragma(on), None));
            }
        }
        for (byte, reason) in &self.content.left {
            self.script.notes.push(Note { place: at(*byte), text: reason.clone() });
        }
        for (k, t) in self.content.trajectories.iter().enumerate() {
            let axes: Vec<Option<usize>> = t.names.iter().map(|n| robot.axis_named(n)).collect();
            self.script.notes.extend(note(t, &axes, robot, text)?);
            steps.push((t.start, StepKind::Break(Break::Start), None));
            for (i, p) in t.points.iter().enumerate() {
                let before = i.checked_sub(1).and_then(|b| t.points.get(b));
                let target = self.script.targets.len();
                let m = movement(before, p, target);
                if let Goal::Joints(_) = m.goal {
                    let values = values(p, &axes, robot.dof());
                    self.script.targets.push(Target { name: None, at: at(p.span.start), values });
                }
                steps.push((p.span.start, StepKind::Move(m), Some((k, i))));
            }
            self.axes.push(axes);
        }
        // stable: the start of a trajectory stands before its first point, wherever that is
        steps.sort_by_key(|s| s.0);
        for (byte, kind, of) in steps {
            self.script.steps.push(Step { at: at(byte), kind });
            self.of_step.push(of);
        }
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

fn movement(before: Option<&Point>, p: &Point, target: usize) -> Move {
    let h_s = p.t_s - before.map_or(0.0, |b| b.t_s);
    Move {
        path: PathKind::Joint,
        goal: if p.positions.is_empty() {
            Goal::Opaque("the point gives no positions".into())
        } else {
            Goal::Joints(target)
        },
        fixed: None,
        closed: closed(before, p),
        speed: if h_s > 0.0 { Speed::Seconds(h_s) } else { Speed::Unknown },
        blend_m: Some(0.0),
        way: Vec::new(),
    }
}

/// Why no point can be put before this one.
fn closed(before: Option<&Point>, p: &Point) -> Option<String> {
    let Some(b) = before else { return Some("first point: where the robot comes from is not in the file".into()) };
    if let Some(key) = &p.foreign {
        return Some(format!("the point has a key `{key}` that a copy would repeat"));
    }
    if b.positions.is_empty() || p.positions.is_empty() {
        return Some("a point without positions".into());
    }
    if b.velocities.is_empty() != p.velocities.is_empty() || b.accelerations.is_empty() != p.accelerations.is_empty() {
        return Some("velocities or accelerations at one end of the way only".into());
    }
    if p.velocities.is_empty() && !p.accelerations.is_empty() {
        return Some("accelerations without velocities".into());
    }
    None
}

fn values(p: &Point, axes: &[Option<usize>], dof: usize) -> Vec<Option<Value>> {
    let mut values = vec![None; dof];
    for (n, axis) in p.positions.iter().zip(axes) {
        if let Some(slot) = axis.and_then(|a| values.get_mut(a)) {
            *slot = Some(value(n));
        }
    }
    values
}

fn value(n: &Num) -> Value {
    let weight = |decimals: u8| 10f64.powi(-i32::from(decimals));
    Value {
        si: n.value,
        start: n.start,
        end: n.end,
        style: n.style,
        digit: weight(n.style.decimals),
        finest: weight(most_decimals(n.style)),
    }
}
