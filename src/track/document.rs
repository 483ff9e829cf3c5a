//! What was tracked: JSON (`lostmotion/tracking/1`), words, and why the answer is no.

use super::LETTERS;
use super::follow::{Bound, Tracked};
use super::path::Path;
use crate::error::{Result, counted};
use crate::gaps::LogRef;
use crate::gaps::file::{number, value};
use crate::numerics::robust::range;
use crate::robot::Robot;
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;

/// The schema that the document names.
pub const SCHEMA: &str = "lostmotion/tracking/1";
/// Places that are listed.
const LISTED: usize = 20;

/// The kinematics by which was tracked.
#[derive(Debug, Clone)]
pub struct Origin {
    /// In words.
    pub by: String,
    /// The learned kinematics, or the model; `None`: the robot file.
    pub file: Option<LogRef>,
}

/// The document.
#[derive(Serialize, schemars::JsonSchema)]
pub(crate) struct Tracking<'a> {
    schema: &'static str,
    robot: Source<'a>,
    path: Source<'a>,
    kinematics: &'a str,
    kinematics_file: Option<Source<'a>>,
    method: &'a str,
    coordinates: Vec<&'static str>,
    points: usize,
    duration_s: Option<Value>,
    mean_error_mm: Value,
    max_error_mm: Value,
    between_points_mm: Value,
    joints: Vec<Map<String, Value>>,
}

/// A file that something comes from.
#[derive(Serialize, schemars::JsonSchema)]
struct Source<'a> {
    name: &'a str,
    sha256: &'a str,
}

impl Tracked {
    /// Mean distance from the path, m.
    pub fn mean_error_m(&self) -> f64 {
        self.error_m.iter().sum::<f64>() / self.error_m.len().max(1) as f64
    }

    /// Largest distance from the path, m.
    pub fn largest_error_m(&self) -> f64 {
        self.error_m.iter().copied().fold(0.0, f64::max)
    }

    /// The JSON document; lengths in mm.
    ///
    /// # Errors
    /// Internal, where it cannot be written as JSON.
    pub fn to_json(&self, robot: &Robot, path: &Path, origin: &Origin, method: &str) -> Result<Value> {
        let joints = robot.axis_joints().enumerate().map(|(a, j)| {
            let edge = |v: f64| j.kind.to_user_unit(v);
            let ends = range(self.q.iter().map(|q| q[a]));
            // these keys carry the unit of the joint
            let mut one = Map::new();
            one.insert("joint".into(), j.name.clone().into());
            one.insert(format!("range_{}", j.kind.unit()), ends.iter().map(|v| number(edge(*v))).collect());
            one.insert(format!("max_speed_{}_s", j.kind.unit()), number(edge(self.speed[a])));
            one
        });
        value(&Tracking {
            schema: SCHEMA,
            robot: Source { name: &robot.name, sha256: &robot.fingerprint() },
            path: Source { name: &path.name, sha256: &path.sha256 },
            kinematics: &origin.by,
            kinematics_file: origin.file.as_ref().map(|f| Source { name: &f.name, sha256: &f.sha256 }),
            method,
            coordinates: path.coordinates.iter().map(|&c| LETTERS[c]).collect(),
            points: self.q.len(),
            duration_s: self.t_s.last().zip(self.t_s.first()).map(|(b, a)| number(b - a)),
            mean_error_mm: number(self.mean_error_m() * 1e3),
            max_error_mm: number(self.largest_error_m() * 1e3),
            between_points_mm: number(self.between_m * 1e3),
            joints: joints.collect(),
        })
    }

    /// What was done, in lines.
    pub fn words(&self, path: &Path, kinematics: &str) -> String {
        format!(
            "{} in {}, {kinematics}\nwith these kinematics: {:.6} mm from the path on average, {:.6} mm at most; half way between two points {:.6} mm at most\n",
            counted(self.q.len(), "point"),
            path.coordinates.iter().map(|&c| LETTERS[c]).collect::<Vec<_>>().join(", "),
            self.mean_error_m() * 1e3,
            self.largest_error_m() * 1e3,
            self.between_m * 1e3
        )
    }

    /// Why the path cannot be followed, one place a line; `None`: it can.
    pub fn refusal(&self, robot: &Robot, path: &Path, tolerance_m: f64) -> Option<String> {
        if self.misses.is_empty() && self.too_fast.is_empty() {
            return None;
        }
        let mut text = String::new();
        if !self.misses.is_empty() {
            let _ = write!(
                text,
                "{}: {} of {} cannot be met within {} mm; nothing was written",
                path.name,
                self.misses.len(),
                counted(self.q.len(), "point"),
                number(tolerance_m * 1e3)
            );
            for m in self.misses.iter().take(LISTED) {
                let _ = write!(text, "\n  {}:{}: {:.4} mm away", path.name, path.line[m.point], m.distance_m * 1e3);
                let held = |&(a, b): &(usize, Bound)| {
                    let what = if b == Bound::Range { "at the end of its range" } else { "at its highest speed" };
                    format!("{} {what}", robot.axis(a).name)
                };
                let held: Vec<String> = m.held.iter().map(held).collect();
                let _ = if held.is_empty() {
                    write!(text, ", out of reach from there (or try another start)")
                } else {
                    write!(text, "; {}", held.join(", "))
                };
            }
            more(&mut text, self.misses.len());
        }
        if !self.too_fast.is_empty() {
            let start = if text.is_empty() { "" } else { "\n" };
            let _ = write!(
                text,
                "{start}{}: an acceleration limit would be exceeded {}; slow the path down, or round its corners; nothing was written",
                path.name,
                if self.too_fast.len() == 1 { "once".into() } else { format!("{} times", self.too_fast.len()) }
            );
            for f in self.too_fast.iter().take(LISTED) {
                let joint = robot.axis(f.axis);
                let (edge, unit) = (|v: f64| joint.kind.to_user_unit(v), joint.kind.unit());
                let _ = write!(
                    text,
                    "\n  {}:{}: {} {:.3} {unit}/s2, limit {:.3} {unit}/s2",
                    path.name,
                    path.line[f.point],
                    joint.name,
                    edge(f.value),
                    edge(f.limit)
                );
            }
            more(&mut text, self.too_fast.len());
        }
        Some(text)
    }
}

fn more(text: &mut String, all: usize) {
    if all > LISTED {
        let _ = write!(text, "\n  and {} more", all - LISTED);
    }
}
