//! What a rewrite did, as the contract's summary line and as one JSON document.

use super::UncheckedRates;
use super::outcome::{Outcome, Vendor};
use super::script::change::Change;
use super::script::coverage::Reason;
use crate::error::{Error, one_line};
use crate::io::keyed::Keyed;
use crate::robot::frames::Missing;
use crate::robot::{Joint, Robot};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

pub const SCHEMA: &str = "lostmotion/rewrite/1";

/// How a program came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
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
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
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
    /// Of a program of a folder, where the verdict was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_error: Option<PathErrors>,
    pub sha256_in: Option<String>,
    pub sha256_out: Option<String>,
    /// Of a program of a manifest: by what it was rewritten, so that shards of different compensators, robot files or options are told
    /// apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rewritten_by: Option<RewrittenBy>,
}

/// What decides how a program is rewritten.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct RewrittenBy {
    /// SHA-256 of the compensator file, or of the model.
    pub compensator: String,
    /// Hash of the robot's numbers, as a compensator has it.
    pub robot: String,
    /// SHA-256 of the options.
    pub options: String,
}

impl RewrittenBy {
    /// Of a robot's hash, a compensator's, and the options as a note has them.
    pub fn of(robot: &str, compensator: &str, options: &[String]) -> Self {
        let options = crate::io::input::hex(&Sha256::digest(options.join("\n").as_bytes()));
        Self { compensator: compensator.into(), robot: robot.into(), options }
    }

    /// In which of its parts it differs from another.
    pub fn differs(&self, other: &Self) -> Option<&'static str> {
        match (self.compensator == other.compensator, self.robot == other.robot, self.options == other.options) {
            (false, ..) => Some("compensator"),
            (_, false, _) => Some("robot file"),
            (.., false) => Some("set of options"),
            _ => None,
        }
    }
}

/// Path error of a program on the machine that its offsets rest on: before and after.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PathErrors {
    /// `better`, `unchanged` or `worse`; null where it could not be worked out.
    pub verdict: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_um: Option<BeforeAfter>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_um: Option<BeforeAfter>,
    /// Why there is no verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The verdict is `worse`.
    #[serde(skip)]
    pub worse: bool,
}

/// A reason of several lines, one for each number or limit, as one line.
fn in_one_line(reason: &str) -> String {
    let lines: Vec<&str> = reason.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    one_line(&lines.join("; "))
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
            reason: o.refusal.as_ref().map(|r| in_one_line(r)),
            moves: o.points,
            editable: o.vendor.as_ref().map_or(o.points, |v| v.coverage.editable),
            edited_as_joints: o.vendor.as_ref().map(|v| v.coverage.as_joints),
            edited_as_poses: o.vendor.as_ref().map(|v| v.coverage.as_poses),
            missing: o.vendor.as_ref().map(|v| v.missing.clone()).filter(|m| !m.is_empty()),
            reversals: o.stats.reversals.iter().sum(),
            inserted: o.stats.inserted,
            path_error: None,
            sha256_in: o.sha256_in.clone(),
            sha256_out: o.sha256_out.clone(),
            rewritten_by: None,
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
            path_error: None,
            sha256_in,
            sha256_out: None,
            rewritten_by: None,
        }
    }

    /// As a line of JSON.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// `lostmotion/rewrite/1`: what a rewrite did, as `rewrite --json` prints it.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Document {
    schema: &'static str,
    /// The line of the summary, with the whole text of a refusal.
    #[serde(flatten)]
    line: Line,
    joints: Vec<JointEntry>,
    largest_change_um: f64,
    cycle_time_s: Option<BeforeAfter>,
    limits_exceeded: u64,
    rates_not_checked: Option<&'static str>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    vendor: Option<VendorEntries>,
}

/// A figure of the original and of the rewritten program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BeforeAfter {
    pub before: f64,
    pub after: f64,
}

/// One joint of the document; the unit of a length or an angle stands in its key.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct JointEntry {
    joint: String,
    reversals: u64,
    #[serde(flatten)]
    largest_offset: Keyed<f64>,
    #[serde(flatten)]
    largest_left: Keyed<f64>,
    decimals: Option<u8>,
}

/// What the document of a vendor program has beyond that of CSV.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct VendorEntries {
    format: &'static str,
    coverage_percent: f64,
    left: u64,
    not_edited: Vec<Reason>,
    missing: Missing,
    closed: u64,
    runs: usize,
    directions_lost: Vec<DirectionLost>,
    points_not_placed: u64,
    points_without_corner: Vec<PointsOnLine>,
    new_stops: Vec<StopsOnLine>,
    changes: Vec<Change>,
    notes: Vec<NoteOnLine>,
    rounding: Vec<Rounding>,
    rounding_pose_mm: f64,
    rounding_pose_deg: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct DirectionLost {
    line: u64,
    why: String,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct PointsOnLine {
    line: u64,
    points: u64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct StopsOnLine {
    line: u64,
    stops: u64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct NoteOnLine {
    line: u64,
    text: String,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct Rounding {
    joint: String,
    #[serde(flatten)]
    rounding: Keyed<f64>,
}

/// The whole report as one document: the fields of the summary line, and each joint.
pub fn document(outcome: &Outcome, robot: &Robot) -> Document {
    let a = &outcome.stats;
    Document {
        schema: SCHEMA,
        line: Line { reason: outcome.refusal.clone(), ..Line::of(outcome) },
        joints: robot.axis_joints().enumerate().map(|(k, joint)| joint_entry(outcome, k, joint)).collect(),
        largest_change_um: round(a.largest_change_m * 1e6, 3),
        cycle_time_s: a
            .duration_s
            .map(|[before, after]| BeforeAfter { before: round(before, 6), after: round(after, 6) }),
        limits_exceeded: a.violations_total,
        rates_not_checked: a.unchecked_rates.map(UncheckedRates::text),
        vendor: outcome.vendor.as_ref().map(|v| vendor_entries(v, robot)),
    }
}

fn joint_entry(outcome: &Outcome, axis: usize, joint: &Joint) -> JointEntry {
    let a = &outcome.stats;
    let in_unit = |name: &str, values: &[f64]| {
        let v = joint.kind.to_user_unit(values.get(axis).copied().unwrap_or(0.0));
        Keyed::new(name, joint.kind.unit(), round(v, 9))
    };
    JointEntry {
        joint: joint.name.clone(),
        reversals: a.reversals.get(axis).copied().unwrap_or(0),
        largest_offset: in_unit("largest_offset", &a.largest_offset),
        largest_left: in_unit("largest_left", &a.largest_left),
        decimals: outcome.written.get(axis).copied().flatten(),
    }
}

fn vendor_entries(v: &Vendor, robot: &Robot) -> VendorEntries {
    let rounding = |(j, lost): (&Joint, &Option<f64>)| {
        let lost = round(j.kind.to_user_unit((*lost)?), 9);
        Some(Rounding { joint: j.name.clone(), rounding: Keyed::new("rounding", j.kind.unit(), lost) })
    };
    let [length, angle] = v.written.pose_lost;
    VendorEntries {
        format: v.format,
        coverage_percent: round(v.coverage.percent(), 3),
        left: v.coverage.moves - v.coverage.editable,
        not_edited: v.coverage.reasons.clone(),
        missing: v.missing.clone(),
        closed: v.coverage.closed,
        runs: v.runs,
        directions_lost: v.gaps.iter().map(|g| DirectionLost { line: g.at.line, why: g.why.to_string() }).collect(),
        points_not_placed: v.unplaced.points + v.unplaced.rounded + v.unplaced.little,
        points_without_corner: v
            .written
            .stops
            .iter()
            .map(|s| PointsOnLine { line: s.at.line, points: s.points })
            .collect(),
        new_stops: v.written.halts.iter().map(|h| StopsOnLine { line: h.at.line, stops: h.stops }).collect(),
        changes: v.changes.clone(),
        notes: v.notes.iter().map(|n| NoteOnLine { line: n.place.line, text: n.text.to_string() }).collect(),
        rounding: robot.axis_joints().zip(&v.written.lost).filter_map(rounding).collect(),
        rounding_pose_mm: round(length * 1e3, 9),
        rounding_pose_deg: round(angle.to_degrees(), 9),
    }
}

fn round(v: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (v * unit).round() / unit
}
