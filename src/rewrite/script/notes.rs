//! Notes about a whole program: what the robot file or the program does not say, and comments that were meant for the tool.

use super::approach::Sides;
use super::cause::Cause;
use super::run::{Role, Run};
use super::task::{Choices, Task};
use crate::compensator::Compensator;
use crate::error::counted;
use crate::program::script::{At, AxisSet, Document, Edits, Format, Note, Script, StepKind};
use crate::robot::{Joint, Robot};
use std::collections::HashSet;

/// The compensator without a joint whose gear turns by more than its own axis on most arms of the format's maker, where the robot
/// file does not say by what; and a note.
pub fn uncoupled(format: &dyn Format, task: &Task) -> (Vec<Note>, Option<Compensator>) {
    let said = |axis: usize| task.robot.gap_of.iter().any(|g| g.axis == axis);
    let Some((axis, other)) = coupled(format, task.robot).filter(|&(axis, other)| {
        axis.max(other) < task.robot.dof() && !said(axis) && task.compensator.on(axis).is_some()
    }) else {
        return (Vec::new(), None);
    };
    let [own, other] = [axis, other].map(|k| task.robot.axis(k).name.as_str());
    let text = format!(
        "{own} is left out: on most arms of this manufacturer its gear turns by {other} + {own}, and the robot file does not state this \
         (`gap_of: {{{own}: {other} + {own}}}`, or `gap_of: {{{own}: {own}}}` for an arm that shows motor angles)"
    );
    let mut reduced = task.compensator.clone();
    reduced.joints.retain(|j| j.axis != axis);
    (vec![Note { place: At { file: 0, line: 1 }, text }], Some(reduced))
}

/// [`Format::coupled`] among the axes of a robot that may stand on external ones.
fn coupled(format: &dyn Format, robot: &Robot) -> Option<(usize, usize)> {
    let (axis, other) = format.coupled()?;
    let arm = &robot.axes().places().arm;
    Some((*arm.get(axis)?, *arm.get(other)?))
}

/// Why joint values of a program do not tell where the arm stands: most arms of the format's maker show a joint against the horizontal, and
/// neither a joint that takes the other one out of it nor a gear that is the joint's own says how the robot file counts it.
pub fn unknown_arm(format: &dyn Format, robot: &Robot) -> Option<Cause> {
    let (axis, other) = coupled(format, robot).filter(|&(axis, other)| axis.max(other) < robot.dof())?;
    let (own, driver) = (robot.axis_index(axis), robot.axis_index(other));
    let follows = |j: &Joint| j.follows.as_ref().is_some_and(|f| f.joint == driver);
    let shown = robot.joints[..own].iter().any(follows);
    let alone = robot.gap_of.iter().any(|g| g.axis == axis && g.others.is_empty());
    let [own, other] = [axis, other].map(|k| robot.axis(k).name.as_str());
    let text = || {
        format!(
            "most arms of this manufacturer show {own} against the horizontal; add a joint that follows {other} to the robot file, or \
             `gap_of: {{{own}: {own}}}` for an arm that shows motor angles"
        )
    };
    (!shown && !alone).then(|| Cause::UnknownArm(text()))
}

/// Axes whose limits are not checked, as a work offset or a tool length that the program does not contain is in force.
pub fn unplaced(script: &Script, robot: &Robot, runs: &[Run]) -> Option<Note> {
    let limited: AxisSet =
        robot.axis_joints().enumerate().filter(|(_, j)| j.limits.is_some()).map(|(axis, _)| axis).collect();
    let of = |run: &Run| run.unplaced(script).and(limited);
    let first = runs.iter().find(|run| !of(run).is_empty())?.vertices.first()?;
    let axes = runs.iter().map(of).fold(AxisSet::default(), AxisSet::or);
    let names: Vec<&str> = axes.axes().map(|axis| robot.axis(axis).name.as_str()).collect();
    let text = format!(
        "limits of {} are not checked: a work offset or a tool length is active, and its value is not in the program",
        names.join(", ")
    );
    Some(Note { place: script.steps.get(first.step)?.at, text })
}

/// What was asked with `--approach-from`: how many targets a point was added to, and which of those at which the robot stops are
/// reached as before.
pub fn approached(script: &Script, sides: &Sides, commanded: &[bool], runs: &[Run], edits: &Edits) -> Option<Note> {
    if !sides.wanted() {
        return None;
    }
    let vertices = || runs.iter().flat_map(|r| &r.vertices).filter(|v| !v.again);
    let added = vertices().filter(|v| v.role == Role::Approach && edits.steps.contains(v.step)).count();
    let told: HashSet<usize> =
        runs.iter().flat_map(|r| r.vertices.iter().skip(1)).filter(|v| v.editable).map(|v| v.step).collect();
    let unfollowed = |k: &usize| runs.iter().any(|r| r.unfollowed.contains(k) || r.changing.contains(k));
    let left: Vec<u64> = script
        .moves()
        .filter(|(k, m)| {
            sides.count(m) && (!m.is_open_to_goal() || unfollowed(k) || sides.goes_without(*k) || !told.contains(k))
        })
        .map(|(k, _)| script.steps[k].at.line)
        .collect();
    let shown: Vec<String> = left.iter().take(SHOWN).map(u64::to_string).collect();
    let more = if left.len() > SHOWN { format!(" and {} more", left.len() - SHOWN) } else { String::new() };
    let rest = match left.len() {
        0 => String::new(),
        k => {
            format!(
                "; {k} at which the robot stops cannot be determined, or no point can be added before them (lines {}{more})",
                shown.join(", ")
            )
        }
    };
    let lacking = script.moves().filter(|(_, m)| sides.lacks_axes(script, m, commanded)).count();
    let lacking = match lacking {
        0 => String::new(),
        k => format!(
            "; {} without all axes: there a point moves those alone that the target names",
            counted(k, "target")
        ),
    };
    let stops = script.moves().any(|(_, m)| m.blend_m == Some(0.0) || !m.waits.is_empty());
    let none = if stops { "" } else { ": the program contains no move that certainly stops at its goal" };
    let reached = counted(added, "target");
    let text = format!(
        "one-sided approach: {reached} reached from the requested side over an added point{rest}{lacking}{none}"
    );
    Some(Note { place: At { file: 0, line: 1 }, text })
}

/// What was asked with `--approach-unknown`: how many targets a point was added to, and how far from its target the furthest lies.
pub fn approached_anew(robot: &Robot, sides: &Sides, runs: &[Run], edits: &Edits) -> Option<Note> {
    if !sides.any() || sides.wanted() {
        return None;
    }
    let firsts =
        runs.iter().filter(|r| r.is_approached()).filter_map(|r| Some((r.vertices.first()?, r.vertices.get(1)?)));
    let away: Vec<f64> = firsts
        .filter(|(_, goal)| edits.steps.contains(goal.step))
        .map(|(point, goal)| (robot.tcp_m(&point.q) - robot.tcp_m(&goal.q)).norm())
        .collect();
    let furthest_um = away.iter().copied().fold(0.0, f64::max) * 1e6;
    let reached = counted(away.len(), "target");
    let text = match away.is_empty() {
        true => "targets reached from an unknown side: none at which the robot stops and to which a point can be added"
            .into(),
        false => format!(
            "targets reached from an unknown side: {reached} reached over an added point at most {furthest_um:.0} um away, back along the tool's axis and as little aside as the joints allow"
        ),
    };
    Some(Note { place: At { file: 0, line: 1 }, text })
}

/// Lines that are listed.
const SHOWN: usize = 20;

/// Files beside the program that cannot be read: what they may declare or change is left as it is.
pub fn unread(script: &Script) -> impl Iterator<Item = Note> + '_ {
    let files = script.texts.iter().filter(|t| t.unread);
    files.map(|t| {
        let text = format!("{} cannot be read: moves that it may declare or change stay as they are", t.name);
        Note { place: At { file: 0, line: 1 }, text }
    })
}

/// Words that the program lacks, with what to do.
pub fn missing(script: &Script) -> Option<Note> {
    if script.missing.is_empty() {
        return None;
    }
    let usual = |word: &&str| script.missing.iter().any(|m| m.contains(word));
    let modes: Vec<&str> = ["G21", "G90"].into_iter().filter(usual).collect();
    let text = format!(
        "the program never sets {}: if the control starts in {}, assume {} (an option), or write `control: [{}]` into the robot file",
        script.missing.join(", nor "),
        modes.join(" and "),
        modes.join(","),
        modes.join(", ")
    );
    Some(Note { place: At { file: 0, line: 1 }, text })
}

/// That whole numbers may count increments, with what to do.
pub fn only_whole_numbers(script: &Script) -> Option<Note> {
    let text = "no axis word has a decimal point, and some controls then count increments (X500 is 0.5 mm), so moves to whole numbers stay: \
                if this control reads millimetres or inches, assume whole-units (an option), or write `control: [whole-units]` into the \
                robot file";
    script.only_whole_numbers.then(|| Note { place: At { file: 0, line: 1 }, text: text.into() })
}

/// That X may be a diameter, with what to do.
pub fn diameter_unstated(script: &Script) -> Option<Note> {
    let text = "it may be a program of a lathe, whose X words may be diameters (X20. is 10 mm from the centre), so moves of X stay: assume \
                diameter or radius (an option), or write `control: [diameter]` into the robot file";
    script.diameter_unstated.then(|| Note { place: At { file: 0, line: 1 }, text: text.into() })
}

/// Comments that are meant for the tool and switch nothing, as their words are not quite those.
pub fn not_understood(script: &Script) -> Vec<Note> {
    let Some(text) = script.texts.first() else { return Vec::new() };
    let read: HashSet<At> =
        script.steps.iter().filter(|s| matches!(s.kind, StepKind::Pragma(_))).map(|s| s.at).collect();
    let places = (0..text.line_count()).map(|k| (At { file: 0, line: k as u64 + 1 }, text.line(k)));
    let missed = places.filter(|(at, line)| addresses_us(line) && !read.contains(at));
    let note = |place| {
        Note {
        place,
        text: "a comment for this tool that is not understood and has no effect (expected lostmotion: off or lostmotion: on)"
            .into(),
    }
    };
    missed.map(|(at, _)| note(at)).collect()
}

/// `lost motion: of`, `lostmotion ON (seam)`: the name and a colon, or in one word with on or off after it.
fn addresses_us(line: &[u8]) -> bool {
    let begins = |at: &usize| line.get(*at..at + 4).is_some_and(|word| word.eq_ignore_ascii_case(b"lost"));
    let Some(first) = memchr::memchr2_iter(b'l', b'L', line).find(begins) else { return false };
    let line = String::from_utf8_lossy(&line[first..]).to_ascii_lowercase();
    let after = line.trim_start_matches("lost");
    let Some(rest) = after.trim_start_matches([' ', '-', '_']).strip_prefix("motion") else { return false };
    let word = rest.trim_start_matches([' ', '\t', '-']);
    word.starts_with([':', '='])
        || after.starts_with('m')
            && word.len() < rest.len()
            && ["on", "off", "of"].contains(&word.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default())
}

/// That `--solve-cartesian` finds nothing in a format that cannot hold its result.
pub fn unsolved(format: &dyn Format, document: &dyn Document, choices: &Choices) -> Option<Note> {
    if choices.solve_within_m.is_none() || document.takes_joints_for_poses() {
        return None;
    }
    let text = format!(
        "Cartesian moves as joint moves: {} has no straight move to joint values, so Cartesian moves stay",
        format.title()
    );
    Some(Note { place: At { file: 0, line: 1 }, text })
}
