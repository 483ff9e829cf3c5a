//! What a rewrite did, as the contract's summary line, as one JSON document, and in words.

use super::job::Outcome;
use super::script::job::Vendor;
use super::stream::guard::is_already;
use crate::error::{Error, one_line};
use crate::robot::Robot;
use crate::robot::frames::Missing;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// How a program came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Written,
    /// Of a dry run or a check: nothing was written, and could be.
    WouldBeWritten,
    /// Equal to the input byte for byte.
    Unchanged,
    /// The answer is no: a limit, a check, a program that has been rewritten already.
    Refused,
    /// The input could not be read, or the output not be written.
    Failed,
}

/// One line of a batch summary.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    pub input: String,
    pub output: Option<String>,
    pub status: Status,
    pub reason: Option<String>,
    pub moves: u64,
    pub editable: u64,
    /// Of a vendor program: moves edited as joint targets and as poses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edited_as_joints: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edited_as_poses: Option<u64>,
    /// Frames and tools that moves wait for; not in the line, which must be the same when a folder is taken up again.
    #[serde(skip)]
    pub missing: Option<Missing>,
    pub reversals: u64,
    pub inserted: u64,
    pub sha256_in: Option<String>,
    pub sha256_out: Option<String>,
}

impl Line {
    /// The line of a program that went through.
    pub fn of(o: &Outcome) -> Self {
        Self {
            input: o.input.clone(),
            output: o.output.clone(),
            status: match (&o.refusal, o.unchanged) {
                (Some(_), _) => Status::Refused,
                (None, true) => Status::Unchanged,
                (None, false) if o.output.is_none() => Status::WouldBeWritten,
                (None, false) => Status::Written,
            },
            reason: o.refusal.as_ref().map(|r| one_line(r)),
            moves: o.points,
            editable: o.vendor.as_ref().map_or(o.points, |v| v.coverage.editable),
            edited_as_joints: o.vendor.as_ref().map(|v| v.coverage.as_joints),
            edited_as_poses: o.vendor.as_ref().map(|v| v.coverage.as_poses),
            missing: o.vendor.as_ref().map(|v| v.missing.clone()).filter(|m| !m.is_empty()),
            reversals: o.account.reversals.iter().sum(),
            inserted: o.account.inserted,
            sha256_in: o.sha256_in.clone(),
            sha256_out: o.sha256_out.clone(),
        }
    }

    /// The line of a program that did not.
    pub fn failed(input: String, e: &Error, sha256_in: Option<String>) -> Self {
        let refused = matches!(e, Error::Refused(_)) || is_already(e);
        Self {
            input,
            output: None,
            status: if refused { Status::Refused } else { Status::Failed },
            reason: Some(one_line(&e.to_string())),
            moves: 0,
            editable: 0,
            edited_as_joints: None,
            edited_as_poses: None,
            missing: None,
            reversals: 0,
            inserted: 0,
            sha256_in,
            sha256_out: None,
        }
    }

    /// The line of a folder, or of an entry of one, that cannot be read.
    pub fn unreadable(input: String, why: &str) -> Self {
        let reason = Some(one_line(why));
        let status = Status::Failed;
        Self { status, reason, input, ..Self::failed(String::new(), &Error::Unchanged, None) }
    }

    /// As a line of JSON.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// The whole account as one document: the fields of the summary line, and each joint.
pub fn document(outcome: &Outcome, robot: &Robot) -> Value {
    let line = Line::of(outcome);
    let mut map = Map::new();
    map.insert("schema".into(), json!("lostmotion/rewrite/1"));
    if let Ok(Value::Object(fields)) = serde_json::to_value(&line) {
        map.extend(fields);
    }
    map.insert("reason".into(), json!(outcome.refusal));
    let a = &outcome.account;
    let joints: Vec<Value> = robot
        .axis_joints()
        .enumerate()
        .map(|(k, joint)| {
            let unit = joint.kind.unit();
            let mut j = Map::new();
            j.insert("joint".into(), json!(joint.name));
            j.insert("reversals".into(), json!(a.reversals.get(k).copied().unwrap_or(0)));
            let offset = joint.kind.to_user_unit(a.largest_offset.get(k).copied().unwrap_or(0.0));
            j.insert(format!("largest_offset_{unit}"), json!(round(offset, 9)));
            let left = joint.kind.to_user_unit(a.largest_left.get(k).copied().unwrap_or(0.0));
            j.insert(format!("largest_left_{unit}"), json!(round(left, 9)));
            j.insert("decimals".into(), json!(outcome.written.get(k).copied().flatten()));
            Value::Object(j)
        })
        .collect();
    map.insert("joints".into(), json!(joints));
    map.insert("largest_change_um".into(), json!(round(a.largest_change_m * 1e6, 3)));
    let cycle = a.duration_s.map(|[before, after]| json!({"before": round(before, 6), "after": round(after, 6)}));
    map.insert("cycle_time_s".into(), json!(cycle));
    map.insert("limits_exceeded".into(), json!(a.violations_total));
    map.insert("rates_not_checked".into(), json!(a.unchecked_rates));
    if let Some(v) = &outcome.vendor {
        map.insert("format".into(), json!(v.format));
        map.insert("coverage_percent".into(), json!(round(v.coverage.percent(), 3)));
        map.insert("edited_as_joints".into(), json!(v.coverage.as_joints));
        map.insert("edited_as_poses".into(), json!(v.coverage.as_poses));
        map.insert("left".into(), json!(v.coverage.moves - v.coverage.editable));
        map.insert("not_edited".into(), json!(v.coverage.reasons));
        map.insert("missing".into(), json!(v.missing));
        map.insert("closed".into(), json!(v.coverage.closed));
        map.insert("runs".into(), json!(v.runs));
        let gaps: Vec<Value> = v.gaps.iter().map(|g| json!({"line": g.at.line, "why": g.why})).collect();
        map.insert("directions_lost".into(), json!(gaps));
        map.insert("points_not_placed".into(), json!(v.unplaced.points + v.unplaced.rounded));
        let stops: Vec<Value> =
            v.written.stops.iter().map(|s| json!({"line": s.at.line, "points": s.points})).collect();
        map.insert("points_without_corner".into(), json!(stops));
        let halts: Vec<Value> = v.written.halts.iter().map(|h| json!({"line": h.at.line, "stops": h.stops})).collect();
        map.insert("new_stops".into(), json!(halts));
        map.insert("changes".into(), json!(v.changes));
        let notes: Vec<Value> = v.notes.iter().map(|n| json!({"line": n.place.line, "text": n.text})).collect();
        map.insert("notes".into(), json!(notes));
        let lost: Vec<Value> = robot
            .axis_joints()
            .zip(&v.written.lost)
            .filter_map(|(j, l)| {
                let mut m = Map::new();
                m.insert("joint".into(), json!(j.name));
                m.insert(format!("rounding_{}", j.kind.unit()), json!(round(j.kind.to_user_unit((*l)?), 9)));
                Some(Value::Object(m))
            })
            .collect();
        map.insert("rounding".into(), json!(lost));
        let [length, angle] = v.written.pose_lost;
        map.insert("rounding_pose_mm".into(), json!(round(length * 1e3, 9)));
        map.insert("rounding_pose_deg".into(), json!(round(angle.to_degrees(), 9)));
    }
    Value::Object(map)
}

fn round(v: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (v * unit).round() / unit
}

/// What the words tell of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Told {
    /// What was done.
    Done,
    /// What would be done, change by change.
    Plan,
    /// What would be done, for a check or a refusal.
    Check,
}

/// The account in words, for stderr.
pub fn words(outcome: &Outcome, robot: &Robot, told: Told) -> String {
    let dry = told != Told::Done;
    let a = &outcome.account;
    let mut text = String::new();
    let written = if dry { "to be written" } else { "written" };
    let editable = outcome.vendor.as_ref().map_or(outcome.points, |v| v.coverage.editable);
    if outcome.points == 0 {
        let _ = writeln!(text, "{}: no moves", outcome.input);
    } else {
        let _ = writeln!(
            text,
            "{}: {}, {}; {}, {} {}",
            outcome.input,
            counted(outcome.points, "move"),
            if editable == outcome.points { "all editable".into() } else { format!("{editable} editable") },
            counted(a.reversals.iter().sum(), "reversal"),
            counted(a.inserted, "point"),
            if dry { "to be added" } else { "added" }
        );
    }
    if let Some(v) = &outcome.vendor {
        coverage_words(&mut text, v);
    }
    for (k, joint) in robot.axis_joints().enumerate() {
        let reversals = a.reversals.get(k).copied().unwrap_or(0);
        let offset = a.largest_offset.get(k).copied().unwrap_or(0.0);
        if reversals == 0 && offset == 0.0 {
            continue;
        }
        let unit = joint.kind.unit();
        let offset = joint.kind.to_user_unit(offset);
        let reversals = counted(reversals, "reversal");
        let _ = write!(text, "  {}: {reversals}, largest offset {offset:.6} {unit}", joint.name);
        if let Some(d) = outcome.written.get(k).copied().flatten() {
            let lost = 0.5 * 10f64.powi(-i32::from(d));
            let _ = write!(text, "; {written} with {d} decimals, rounding loses up to {lost} {unit}");
            if offset > 0.0 {
                let _ = write!(text, " ({:.1} %)", 100.0 * lost / offset);
            }
        }
        if let Some(v) = &outcome.vendor
            && let Some(Some(lost)) = v.written.lost.get(k)
        {
            let (lost, digit) = (joint.kind.to_user_unit(*lost), joint.kind.to_user_unit(v.written.digit[k]));
            let _ = write!(text, "; {written} in steps of {digit:.6} {unit}, rounding loses up to {lost:.6} {unit}");
            if offset > 0.0 {
                let _ = write!(text, " ({:.1} %)", 100.0 * lost / offset);
            }
        }
        let left = a.largest_left.get(k).copied().unwrap_or(0.0);
        if left > 0.0 {
            let _ = write!(text, "; up to {:.6} {unit} is left behind a reversal", joint.kind.to_user_unit(left));
            if left > a.largest_offset.get(k).copied().unwrap_or(f64::INFINITY) {
                text.push_str(
                    ", more than without compensation until the step is done (nearer to the turn: --step-fraction)",
                );
            }
        }
        text.push('\n');
    }
    if a.largest_change_m > 0.0 {
        let odd = if a.largest_change_m > UNUSUAL_M {
            ", far more than lost motion usually is: check the offsets"
        } else {
            ""
        };
        let _ = writeln!(text, "  largest change at the TCP {:.1} um{odd}", a.largest_change_m * 1e6);
    }
    if let Some(why) = a.unchecked_rates.filter(|_| !outcome.unchanged) {
        let _ = writeln!(text, "  not everywhere checked against limits of speed and acceleration: {why}");
    }
    if let Some([before, after]) = a.duration_s {
        // of a vendor's moves the speeds are known, not how the controller rounds corners and slows down at new points
        let halts: u64 = outcome.vendor.iter().flat_map(|v| &v.written.halts).map(|h| h.stops).sum();
        let passed = a.inserted.saturating_sub(halts);
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
    if let Some(v) = outcome.vendor.as_ref().filter(|_| told == Told::Plan) {
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

/// What of a vendor program is not edited, and why; where directions start anew.
fn coverage_words(text: &mut String, v: &Vendor) {
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
            let _ = writeln!(text, "  {what} `{name}` is not known: {} (--list-frames)", waits(*moves));
        }
    }
    for r in &v.coverage.reasons {
        let _ = writeln!(text, "  not edited: {} ({}; {})", counted(r.moves, "move"), r.why, r.lines_text());
    }
    if v.anew > 0 {
        let _ = writeln!(
            text,
            "  directions start anew {} (labels, loops, calls, targets that cannot be told): the first point there stays as it is",
            if v.anew == 1 { "once".into() } else { format!("{} times", v.anew) }
        );
    }
    for g in v.gaps.iter().take(FEW) {
        let _ = writeln!(text, "  line {}: directions are lost at {}", g.at.line, g.why);
    }
    if v.gaps.len() > FEW {
        let _ = writeln!(text, "  and at {} more", counted((v.gaps.len() - FEW) as u64, "place"));
    }
    if v.unplaced.points > 0 {
        let _ = writeln!(
            text,
            "  {} on moves that take none, or stay as they are: there the step is spread over the whole move ({})",
            counted(v.unplaced.points, "new point"),
            lines_text(&v.unplaced.lines)
        );
    }
    if !v.written.stops.is_empty() {
        let lines: Vec<u64> = v.written.stops.iter().map(|s| s.at.line).collect();
        let points = v.written.stops.iter().map(|s| s.points).sum();
        let _ = writeln!(
            text,
            "  {} on straight TCP moves without a corner, as none fits: the robot stops there for a moment, or nearly ({})",
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
    for n in v.notes.iter().take(FEW) {
        let _ = writeln!(text, "  line {}: {}", n.place.line, n.text);
    }
    if v.notes.len() > FEW {
        let _ = writeln!(text, "  and {}", counted((v.notes.len() - FEW) as u64, "more note"));
    }
}
