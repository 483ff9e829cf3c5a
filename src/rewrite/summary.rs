//! What a rewrite did, as the contract's summary line and as one JSON document.

use super::outcome::{Outcome, Vendor};
use crate::error::{Error, one_line};
use crate::robot::frames::Missing;
use crate::robot::{Joint, Robot};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// How a program came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Of a program of a manifest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
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
            key: None,
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
            reversals: o.stats.reversals.iter().sum(),
            inserted: o.stats.inserted,
            sha256_in: o.sha256_in.clone(),
            sha256_out: o.sha256_out.clone(),
        }
    }

    /// The line of a program that did not.
    pub fn failed(input: String, e: &Error, sha256_in: Option<String>) -> Self {
        let refused = matches!(e, Error::Refused(_) | Error::RewrittenAlready(_));
        let status = if refused { Status::Refused } else { Status::Failed };
        Self::without_result(input, status, &e.to_string(), sha256_in)
    }

    /// The line of a folder, or of an entry of one, that cannot be read.
    pub fn unreadable(input: String, why: &str) -> Self {
        Self::without_result(input, Status::Failed, why, None)
    }

    /// The line of a program that a check finds no golden file for.
    pub fn without_golden(input: String, golden: &str, sha256_in: Option<String>) -> Self {
        let why = format!("{golden}: found no file; expected the rewritten program");
        Self::without_result(input, Status::Refused, &why, sha256_in)
    }

    fn without_result(input: String, status: Status, why: &str, sha256_in: Option<String>) -> Self {
        Self {
            key: None,
            input,
            output: None,
            status,
            reason: Some(one_line(why)),
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

    /// As a line of JSON.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// The whole report as one document: the fields of the summary line, and each joint.
pub fn document(outcome: &Outcome, robot: &Robot) -> Value {
    let line = Line::of(outcome);
    let mut map = Map::new();
    map.insert("schema".into(), json!("lostmotion/rewrite/1"));
    if let Ok(Value::Object(fields)) = serde_json::to_value(&line) {
        map.extend(fields);
    }
    map.insert("reason".into(), json!(outcome.refusal));
    let a = &outcome.stats;
    let joints: Vec<Value> = robot.axis_joints().enumerate().map(|(k, joint)| joint_entry(outcome, k, joint)).collect();
    map.insert("joints".into(), json!(joints));
    map.insert("largest_change_um".into(), json!(round(a.largest_change_m * 1e6, 3)));
    let cycle = a.duration_s.map(|[before, after]| json!({"before": round(before, 6), "after": round(after, 6)}));
    map.insert("cycle_time_s".into(), json!(cycle));
    map.insert("limits_exceeded".into(), json!(a.violations_total));
    map.insert("rates_not_checked".into(), json!(a.unchecked_rates));
    if let Some(v) = &outcome.vendor {
        vendor_entries(v, robot, &mut map);
    }
    Value::Object(map)
}

/// One joint of the document.
fn joint_entry(outcome: &Outcome, axis: usize, joint: &Joint) -> Value {
    let a = &outcome.stats;
    let unit = joint.kind.unit();
    let mut j = Map::new();
    j.insert("joint".into(), json!(joint.name));
    j.insert("reversals".into(), json!(a.reversals.get(axis).copied().unwrap_or(0)));
    let offset = joint.kind.to_user_unit(a.largest_offset.get(axis).copied().unwrap_or(0.0));
    j.insert(format!("largest_offset_{unit}"), json!(round(offset, 9)));
    let left = joint.kind.to_user_unit(a.largest_left.get(axis).copied().unwrap_or(0.0));
    j.insert(format!("largest_left_{unit}"), json!(round(left, 9)));
    j.insert("decimals".into(), json!(outcome.written.get(axis).copied().flatten()));
    Value::Object(j)
}

/// What the document of a vendor program has beyond that of CSV.
fn vendor_entries(v: &Vendor, robot: &Robot, map: &mut Map<String, Value>) {
    let mut put = |key: &str, value: Value| map.insert(key.into(), value);
    put("format", json!(v.format));
    put("coverage_percent", json!(round(v.coverage.percent(), 3)));
    put("edited_as_joints", json!(v.coverage.as_joints));
    put("edited_as_poses", json!(v.coverage.as_poses));
    put("left", json!(v.coverage.moves - v.coverage.editable));
    put("not_edited", json!(v.coverage.reasons));
    put("missing", json!(v.missing));
    put("closed", json!(v.coverage.closed));
    put("runs", json!(v.runs));
    put("directions_lost", v.gaps.iter().map(|g| json!({"line": g.at.line, "why": g.why})).collect());
    put("points_not_placed", json!(v.unplaced.points + v.unplaced.rounded));
    put(
        "points_without_corner",
        v.written.stops.iter().map(|s| json!({"line": s.at.line, "points": s.points})).collect(),
    );
    put("new_stops", v.written.halts.iter().map(|h| json!({"line": h.at.line, "stops": h.stops})).collect());
    put("changes", json!(v.changes));
    put("notes", v.notes.iter().map(|n| json!({"line": n.place.line, "text": n.text})).collect());
    let rounding = |(j, lost): (&Joint, &Option<f64>)| {
        let lost = round(j.kind.to_user_unit((*lost)?), 9);
        Some(json!({"joint": j.name, format!("rounding_{}", j.kind.unit()): lost}))
    };
    put("rounding", robot.axis_joints().zip(&v.written.lost).filter_map(rounding).collect());
    let [length, angle] = v.written.pose_lost;
    put("rounding_pose_mm", json!(round(length * 1e3, 9)));
    put("rounding_pose_deg", json!(round(angle.to_degrees(), 9)));
}

fn round(v: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (v * unit).round() / unit
}
