//! The report of a rewrite as text, for a terminal.

use crate::rewrite::outcome::{Outcome, Vendor};
use crate::robot::{Joint, Robot};
use std::fmt::Write;

/// Changes that a dry run lists.
const LISTED: usize = 40;
/// Change at the TCP beyond which a word is due: lost motion moves it by 0.05 to 0.2 mm, m.
const UNUSUAL_M: f64 = 2e-3;
/// Notes and places of one kind that are listed.
const FEW: usize = 8;

/// `1 move waits for it`.
fn waits(moves: u64) -> String {
    format!("{} for it", if moves == 1 { "1 move waits".into() } else { format!("{moves} moves wait") })
}

/// `1 move`, `2 moves`.
fn counted(n: u64, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// `line 3`, `lines 3, 7 and 5 more`.
fn lines_text(lines: &[u64]) -> String {
    let shown: Vec<String> = lines.iter().take(FEW).map(u64::to_string).collect();
    let word = if lines.len() == 1 { "line" } else { "lines" };
    match lines.len().saturating_sub(FEW) {
        0 => format!("{word} {}", shown.join(", ")),
        more => format!("{word} {} and {more} more", shown.join(", ")),
    }
}

/// What the text is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verbosity {
    /// What was done.
    Done,
    /// What would be done, change by change.
    Plan,
    /// What would be done, for a check or a refusal.
    Check,
}

/// The report as text, for stderr.
pub fn format_text(outcome: &Outcome, robot: &Robot, verbosity: Verbosity) -> String {
    let dry = verbosity != Verbosity::Done;
    let a = &outcome.stats;
    let mut text = String::new();
    moves_text(&mut text, outcome, dry);
    if let Some(v) = &outcome.vendor {
        coverage_text(&mut text, v);
    }
    let mut lags: Vec<&str> = Vec::new();
    for (k, joint) in robot.axis_joints().enumerate() {
        if joint_text(&mut text, outcome, k, joint, dry) {
            lags.push(&joint.name);
        }
    }
    if !lags.is_empty() {
        let _ = writeln!(
            text,
            "  until the step after a reversal is done, {} is further off than without compensation; a smaller --step-fraction puts the step nearer to the reversal",
            match lags.as_slice() {
                [one] => (*one).to_string(),
                several => format!("each of {}", several.join(", ")),
            }
        );
    }
    checks_text(&mut text, outcome);
    if let Some(duration_s) = a.duration_s {
        cycle_time_text(&mut text, outcome, duration_s);
    } else if outcome.vendor.is_some() && !outcome.unchanged {
        text.push_str(
            "  cycle time of the whole program: not known, because the speed or the start of some moves is not\n",
        );
    }
    if let Some(v) = outcome.vendor.as_ref().filter(|_| verbosity == Verbosity::Plan) {
        for c in v.changes.iter().take(LISTED) {
            let _ = writeln!(text, "  {}", c.words(robot));
        }
        if v.changes_total > LISTED {
            let _ = writeln!(text, "  and {} more (--json lists them all)", v.changes_total - LISTED);
        }
    }
    if outcome.unchanged {
        let is = if dry { "would be" } else { "is" };
        let _ = writeln!(text, "  nothing to compensate: the output {is} the input, byte for byte");
    }
    text
}

/// The largest change, and what could not be checked or looks odd.
fn checks_text(text: &mut String, outcome: &Outcome) {
    let a = &outcome.stats;
    if a.largest_change_m > 0.0 {
        let odd = if a.largest_change_m > UNUSUAL_M {
            ", far more than lost motion usually is: check the offsets"
        } else {
            ""
        };
        let _ = writeln!(text, "  largest change at the TCP: {:.1} um{odd}", a.largest_change_m * 1e6);
    }
    if let Some(why) = a.unchecked_rates.filter(|_| !outcome.unchanged) {
        let mended = if why.wants_speed() { " (--speed-mm-s gives one)" } else { "" };
        let why = why.text();
        let _ = writeln!(text, "  limits of speed and acceleration were not checked everywhere: {why}{mended}");
    }
    if a.looks_like_radians && outcome.vendor.is_none() {
        text.push_str(
            "  note: the columns are named deg, but the values look like radians: no angle is beyond 6.29, and several joints start or end at multiples of 0.7854, or no angle is beyond 3.15 in many rows; if they are radians, convert them: the offsets would be 57 times too large\n",
        );
    }
    if a.looks_like_milliseconds && outcome.vendor.is_none() {
        text.push_str(
            "  note: the times look like milliseconds: they are whole numbers, and read as seconds no joint comes near a thousandth of its largest speed; if they are milliseconds, name the column t_ms: limits of speed and acceleration were checked for a motion that is a thousand times slower\n",
        );
    }
}

/// Moves, reversals, added points.
fn moves_text(text: &mut String, outcome: &Outcome, dry: bool) {
    let _ = writeln!(text, "{}", moves_line(outcome, dry));
}

/// Moves, reversals and added points in one line.
pub fn summary_line(outcome: &Outcome) -> String {
    moves_line(outcome, true)
}

fn moves_line(outcome: &Outcome, dry: bool) -> String {
    if outcome.points == 0 {
        return format!("{}: no moves", outcome.input);
    }
    let editable = outcome.vendor.as_ref().map_or(outcome.points, |v| v.coverage.editable);
    format!(
        "{}: {}, {}; {}, {} {}",
        outcome.input,
        counted(outcome.points, "move"),
        if editable == outcome.points { "all editable".into() } else { format!("{editable} editable") },
        counted(outcome.stats.reversals.iter().sum(), "reversal"),
        counted(outcome.stats.inserted, "point"),
        if dry { "to be added" } else { "added" }
    )
}

/// One joint: reversals, the largest offset, what rounding loses, what is left. Returns whether more is left for a moment than without
/// compensation.
fn joint_text(text: &mut String, outcome: &Outcome, axis: usize, joint: &Joint, dry: bool) -> bool {
    let a = &outcome.stats;
    let reversals = a.reversals.get(axis).copied().unwrap_or(0);
    let offset = a.largest_offset.get(axis).copied().unwrap_or(0.0);
    if reversals == 0 && offset == 0.0 {
        return false;
    }
    let written = if dry { "to be written" } else { "written" };
    let unit = joint.kind.unit();
    let offset = joint.kind.to_user_unit(offset);
    let of_offset = |lost: f64| if offset > 0.0 { format!(" ({:.1} %)", 100.0 * lost / offset) } else { String::new() };
    let reversals = counted(reversals, "reversal");
    let _ = write!(text, "  {}: {reversals}, largest offset {offset:.6} {unit}", joint.name);
    if let Some(d) = outcome.written.get(axis).copied().flatten() {
        let lost = 0.5 * 10f64.powi(-i32::from(d));
        let _ = write!(text, "; {written} with {d} decimals, rounding loses up to {lost} {unit}{}", of_offset(lost));
    }
    if let Some(v) = &outcome.vendor
        && let Some(Some(lost)) = v.written.lost.get(axis)
    {
        let (lost, digit) = (joint.kind.to_user_unit(*lost), joint.kind.to_user_unit(v.written.digit[axis]));
        let _ = write!(
            text,
            "; {written} in steps of {digit:.6} {unit}, rounding loses up to {lost:.6} {unit}{}",
            of_offset(lost)
        );
    }
    let left = a.largest_left.get(axis).copied().unwrap_or(0.0);
    if left > 0.0 {
        let _ = write!(text, "; up to {:.6} {unit} remains after a reversal", joint.kind.to_user_unit(left));
    }
    text.push('\n');
    left > a.largest_offset.get(axis).copied().unwrap_or(f64::INFINITY)
}

/// Of a vendor's moves the speeds are known, not how the controller rounds corners and slows down at new points.
fn cycle_time_text(text: &mut String, outcome: &Outcome, [before, after]: [f64; 2]) {
    let halts: u64 = outcome.vendor.iter().flat_map(|v| &v.written.halts).map(|h| h.stops).sum();
    let passed = outcome.stats.inserted.saturating_sub(halts);
    let stops = match (outcome.vendor.is_some(), halts, passed) {
        (false, ..) | (_, 0, 0) => String::new(),
        (_, 0, _) => format!("; the robot may slow down at {}, which is not counted", counted(passed, "new point")),
        (_, _, 0) => format!("; {}, estimated", counted(halts, "new stop")),
        _ => format!(
            "; {}, estimated; the robot may slow down at {}, which is not counted",
            counted(halts, "new stop"),
            counted(passed, "other new point")
        ),
    };
    let _ = writeln!(
        text,
        "  cycle time {before:.3} s before, {after:.3} s after (at the speeds of the program, without waiting{stops})"
    );
}

/// A call of what no file contains, and the words that declare it.
pub(super) fn unknown_call(name: &str, moves: u64) -> String {
    format!(
        "no file contains `{name}`, which may move the robot: {}; if it moves nothing and leaves frames and tools as they are, give --no-motion \"{name}\" (or `no_motion` in the robot file)",
        waits(moves)
    )
}

/// What of a vendor program is not edited, and why; where directions start anew.
fn coverage_text(text: &mut String, v: &Vendor) {
    let c = &v.coverage;
    if c.as_poses > 0 || c.moves > c.editable {
        let _ = writeln!(
            text,
            "  edited as joints: {}, as poses: {}, left: {}",
            counted(c.as_joints, "move"),
            counted(c.as_poses, "move"),
            counted(c.moves - c.editable, "move")
        );
    }
    for (what, names) in [("frame", &v.missing.frames), ("tool", &v.missing.tools)] {
        for (name, moves) in names {
            let _ = writeln!(text, "  {what} `{name}` is not known: {} (see --list-frames)", waits(*moves));
        }
    }
    if v.missing.posture > 0 {
        let _ = writeln!(
            text,
            "  no posture of the arm is known: {} (posture_deg of --list-frames)",
            waits(v.missing.posture)
        );
    }
    for (name, moves) in &v.missing.calls {
        let _ = writeln!(text, "  {}", unknown_call(name, *moves));
    }
    for r in &v.coverage.reasons {
        let (moves, lost) = (counted(r.moves, "move"), v.lost_at(r));
        let _ = writeln!(text, "  not edited: {moves} ({}; {}){lost}", r.why, r.lines_text());
    }
    if v.anew > 0 {
        let _ = writeln!(
            text,
            "  directions start anew {} (after labels, loops, calls or targets that cannot be determined): the first point there stays as it is",
            if v.anew == 1 { "once".into() } else { format!("{} times", v.anew) }
        );
    }
    for (why, lines) in v.lost_elsewhere() {
        let _ = writeln!(text, "  directions are lost at {why} ({})", lines_text(&lines));
    }
    new_points_text(text, v);
    for n in v.notes.iter().take(FEW) {
        let _ = writeln!(text, "  line {}: {}", n.place.line, n.text);
    }
    if v.notes.len() > FEW {
        let _ = writeln!(text, "  and {}", counted((v.notes.len() - FEW) as u64, "more note"));
    }
}

/// New points that are not placed, or at which the robot stops.
fn new_points_text(text: &mut String, v: &Vendor) {
    if v.unplaced.points > 0 {
        // points beyond --max-added have no lines
        let lines = &v.unplaced.lines;
        let at = if lines.is_empty() { String::new() } else { format!(" ({})", lines_text(lines)) };
        let _ = writeln!(
            text,
            "  {} on moves that cannot be split, or that stay as they are: there the step is spread over the whole move{at}",
            counted(v.unplaced.points, "new point"),
        );
        let mut why: Vec<(String, &[u64])> =
            v.unplaced.why.iter().map(|(why, at)| (why.to_string(), &at[..])).collect();
        why.sort();
        for (why, lines) in why {
            let _ = writeln!(text, "    {why} ({})", lines_text(lines));
        }
    }
    if v.unplaced.little > 0 {
        let points = counted(v.unplaced.little, "new point");
        let _ = writeln!(text, "  left out by --min-gain: {points}; there the step is spread over the whole move");
    }
    if !v.written.stops.is_empty() {
        let lines: Vec<u64> = v.written.stops.iter().map(|s| s.at.line).collect();
        let points = v.written.stops.iter().map(|s| s.points).sum();
        let _ = writeln!(
            text,
            "  {} on straight TCP moves are written without corner rounding, because none fits: the robot stops or nearly stops there for a moment ({})",
            counted(points, "new point"),
            lines_text(&lines)
        );
    }
    if !v.written.halts.is_empty() {
        let lines: Vec<u64> = v.written.halts.iter().map(|h| h.at.line).collect();
        let stops = v.written.halts.iter().map(|h| h.stops).sum();
        let _ =
            writeln!(text, "  {} that the program did not have ({})", counted(stops, "exact stop"), lines_text(&lines));
    }
}
