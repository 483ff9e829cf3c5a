//! What a rewrite did, as the contract's summary line, as one JSON document, and in words.

use super::job::Outcome;
use super::stream::guard::is_already;
use crate::error::{Error, one_line};
use crate::robot::Robot;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// How a program came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Written,
    /// Written, and equal to the input byte for byte.
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
                (None, false) => Status::Written,
            },
            reason: o.refusal.as_ref().map(|r| one_line(r)),
            moves: o.points,
            editable: o.points,
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
            reversals: 0,
            inserted: 0,
            sha256_in,
            sha256_out: None,
        }
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
            let offset = joint.kind.to_edge(a.largest_offset.get(k).copied().unwrap_or(0.0));
            j.insert(format!("largest_offset_{unit}"), json!(round(offset, 9)));
            let left = joint.kind.to_edge(a.largest_left.get(k).copied().unwrap_or(0.0));
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
    Value::Object(map)
}

fn round(v: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (v * unit).round() / unit
}

/// The account in words, for stderr.
pub fn words(outcome: &Outcome, robot: &Robot, dry: bool) -> String {
    let a = &outcome.account;
    let mut text = String::new();
    let reversals: u64 = a.reversals.iter().sum();
    let _ = writeln!(
        text,
        "{}: {} moves, all editable; {} reversals, {} points {}",
        outcome.input,
        outcome.points,
        reversals,
        a.inserted,
        if dry { "to be added" } else { "added" }
    );
    for (k, joint) in robot.axis_joints().enumerate() {
        let reversals = a.reversals.get(k).copied().unwrap_or(0);
        let offset = a.largest_offset.get(k).copied().unwrap_or(0.0);
        if reversals == 0 && offset == 0.0 {
            continue;
        }
        let unit = joint.kind.unit();
        let offset = joint.kind.to_edge(offset);
        let _ = write!(text, "  {}: {reversals} reversals, largest offset {offset:.6} {unit}", joint.name);
        if let Some(d) = outcome.written.get(k).copied().flatten() {
            let lost = 0.5 * 10f64.powi(-i32::from(d));
            let _ = write!(text, "; written with {d} decimals, rounding loses up to {lost} {unit}");
            if offset > 0.0 {
                let _ = write!(text, " ({:.1} %)", 100.0 * lost / offset);
            }
        }
        let left = a.largest_left.get(k).copied().unwrap_or(0.0);
        if left > 0.0 {
            let _ = write!(text, "; leaves up to {:.6} {unit} at a reversal", joint.kind.to_edge(left));
        }
        text.push('\n');
    }
    if a.largest_change_m > 0.0 {
        let _ = writeln!(text, "  largest change at the TCP {:.1} um", a.largest_change_m * 1e6);
    }
    if let Some([before, after]) = a.duration_s {
        let _ = writeln!(text, "  cycle time {before:.3} s before, {after:.3} s after");
    }
    if outcome.unchanged && !dry {
        let _ = writeln!(text, "  nothing to compensate: the output is the input, byte for byte");
    }
    text
}
