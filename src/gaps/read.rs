//! Reading of the document `lostmotion/gaps/1`, as YAML or JSON (which is YAML).
//!
//! Keys that are not known are left alone (fields may be added), but for those that are almost a known one. Refused, with file and line:
//! another schema, another robot, an unknown joint, a number that is missing or not finite, knots that do not rise.
//!
//! Parts: `node` values by their keys, and the places of what is wrong.

mod node;

use super::estimate::{self, Estimate};
use super::file::SCHEMA;
use super::{Distrust, GapPoint, Gaps, JointGap, LogRef, Note, Registered, Sides, StictionFound};
use crate::effects::curve::Pchip;
use crate::effects::{Decay, GapCurve};
use crate::error::{Error, Place, Result};
use crate::io::{input, yaml::Document};
use crate::robot::file::FrameFile;
use crate::robot::{JointKind, Robot};
use node::Node;
use serde_json::Value;
use std::path::Path;

impl Gaps {
    /// Reads and checks a gaps file for a robot; `-` is standard input.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text, robot)
    }

    /// Parses and checks the text of a gaps file; `name` stands in messages.
    pub fn parse(name: &str, text: &str, robot: &Robot) -> Result<Self> {
        let doc = Document { name, text };
        let root: Value = doc.parse("a gaps file (schema lostmotion/gaps/1)")?;
        let top = Node { doc: &doc, robot, value: &root, path: Vec::new() };
        if root.get("schema").is_none() {
            return Err(Error::bad(
                Place::file(name),
                "a document without `schema`",
                format!("a gaps file (schema {SCHEMA})"),
            ));
        }
        doc.require_schema(&top.text("schema")?, SCHEMA)?;
        top.refuse_misspelt(TOP)?;
        let robot_node = top.child("robot");
        let robot_name = robot_node.as_ref().map_or(Ok(String::new()), |r| r.text("name"))?;
        let robot_sha256 = match &robot_node {
            Some(r) if r.child("sha256").is_some() => r.text("sha256")?,
            _ => robot.fingerprint(),
        };
        if robot_sha256 != robot.fingerprint() {
            return Err(Error::bad(
                doc.place(&["sha256"]),
                format!("gaps of another robot, `{robot_name}` ({robot_sha256})"),
                format!("gaps of `{}` ({})", robot.name, robot.fingerprint()),
            ));
        }
        let logs = top
            .children("logs")?
            .iter()
            .map(|l| Ok(LogRef { name: l.text("name")?, sha256: l.text("sha256")? }))
            .collect::<Result<_>>()?;
        Ok(Self {
            robot_name,
            robot_sha256,
            logs,
            registration: top.child("registration").map(|r| r.registration()).transpose()?,
            estimate: top.estimate()?,
            points: top.children("points")?.iter().map(Node::point).collect::<Result<_>>()?,
            joints: top.joints()?,
            tcp_speed_m_s: top.optional("tcp_speed_mm_s")?.map(|v| v * 1e-3),
            distrust: top.distrust()?,
            notes: top
                .children("notes")?
                .iter()
                .filter_map(|n| n.value.as_str().map(|s| Note::Read(s.into())))
                .collect(),
        })
    }
}

/// Keys at the top.
const TOP: &[&str] = &[
    "schema",
    "robot",
    "logs",
    "registration",
    "points",
    "joints",
    "tcp_speed_mm_s",
    "distrust",
    "notes",
    "reversals",
    "covariance",
    "predicted",
];

/// Keys of an entry of `joints`.
const JOINT: &[&str] = &[
    "joint",
    "half_gap_UNIT",
    "ci95",
    "significant",
    "positive_UNIT",
    "positive_ci95",
    "negative_UNIT",
    "negative_ci95",
    "schedule",
    "varies_p_value",
    "stiction",
    "stiction_p_value",
    "response",
    "scatter",
    "trust",
];

impl Node<'_> {
    /// Why the gaps cannot be trusted.
    fn distrust(&self) -> Result<Option<Distrust>> {
        let Some(node) = self.child("distrust") else { return Ok(None) };
        let read = serde_json::from_value(node.value.clone());
        read.map(Some).map_err(|e| self.bad("distrust", format!("`{}` ({e})", node.value), "a reason and its fields"))
    }

    fn registration(&self) -> Result<Registered> {
        self.refuse_misspelt(&["xyz_mm", "rpy_deg", "rms_um", "samples", "sigma_um", "sigma_deg"])?;
        let frame = FrameFile { xyz_mm: self.array("xyz_mm")?, rpy_deg: self.array("rpy_deg")? };
        let sigma = |key: &str, scale: f64| -> Result<[f64; 3]> {
            if self.child(key).is_some() { Ok(self.array::<3>(key)?.map(|v| v * scale)) } else { Ok([0.0; 3]) }
        };
        Ok(Registered {
            frame: frame.to_isometry(),
            rms_m: self.optional("rms_um")?.unwrap_or(0.0) * 1e-6,
            samples: self.optional("samples")?.unwrap_or(0.0).max(0.0) as usize,
            sigma_m: sigma("sigma_um", 1e-6)?,
            sigma_rad: sigma("sigma_deg", 1f64.to_radians())?,
        })
    }

    fn point(&self) -> Result<GapPoint> {
        let (axis, kind) = self.axis()?;
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        let per_cycle = format!("per_cycle_{unit}");
        self.refuse_misspelt(&["joint", "at_UNIT", "half_gap_UNIT", "ci95", "cycles", "per_cycle_UNIT"])?;
        Ok(GapPoint {
            axis,
            at: self.number(&format!("at_{unit}"))? * si,
            half_gap: self.number(&format!("half_gap_{unit}"))? * si,
            ci95: self.array::<2>("ci95")?.map(|v| v * si),
            cycles: self.optional("cycles")?.unwrap_or(0.0).max(0.0) as usize,
            per_cycle: match self.child(&per_cycle) {
                Some(_) => self.numbers(&per_cycle)?.iter().map(|v| v * si).collect(),
                None => Vec::new(),
            },
        })
    }

    /// What a joint estimate added, where any joint has a response.
    fn estimate(&self) -> Result<Option<Estimate>> {
        let mut joints = Vec::new();
        for node in self.children("joints")? {
            let (axis, kind) = node.axis()?;
            match estimate::read_joint(axis, kind, node.value) {
                None => {}
                Some(Ok(e)) => joints.push(e),
                Some(Err(expected)) => {
                    return Err(node.bad("response", "a response that cannot be read".into(), &expected.to_string()));
                }
            }
        }
        Ok((!joints.is_empty()).then(|| Estimate {
            joints,
            predicted: estimate::read_predicted(self.value),
            reversals: estimate::read_reversals(self.value, self.robot),
            covariance: estimate::read_covariance(self.value),
        }))
    }

    /// One entry per joint: of two, one would silently be lost.
    fn joints(&self) -> Result<Vec<JointGap>> {
        let mut joints: Vec<JointGap> = Vec::new();
        for node in self.children("joints")? {
            let joint = node.joint()?;
            if joints.iter().any(|j| j.axis == joint.axis) {
                let name = &self.robot.axis(joint.axis).name;
                return Err(node.bad("joint", format!("a second entry for {name}"), "one entry per joint"));
            }
            joints.push(joint);
        }
        Ok(joints)
    }

    fn joint(&self) -> Result<JointGap> {
        let (axis, kind) = self.axis()?;
        self.refuse_misspelt(JOINT)?;
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        let half_gap = self.number(&format!("half_gap_{unit}"))? * si;
        let ci95 = if self.child("ci95").is_some() { self.array::<2>("ci95")?.map(|v| v * si) } else { [half_gap; 2] };
        if ci95[0] > ci95[1] {
            return Err(self.bad("ci95", format!("[{}, {}]", ci95[0] / si, ci95[1] / si), "[lower, upper]"));
        }
        Ok(JointGap {
            axis,
            half_gap,
            ci95,
            significant: match self.value.get("significant") {
                Some(Value::Bool(b)) => *b,
                None | Some(Value::Null) => ci95[0] > 0.0 || ci95[1] < 0.0,
                Some(v) => return Err(self.bad("significant", format!("`{v}`"), "true or false")),
            },
            sides: self.sides(kind)?,
            schedule: self.child("schedule").map(|s| s.curve(kind)).transpose()?,
            varies_p_value: self.optional("varies_p_value")?,
            stiction: self.child("stiction").map(|s| s.stiction(kind)).transpose()?,
            stiction_p_value: self.optional("stiction_p_value")?,
        })
    }

    /// Both offsets or none; a joint that goes beyond its command on one side has no gap there.
    fn sides(&self, kind: JointKind) -> Result<Option<Sides>> {
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        let keys = ["positive", "negative"].map(|s| format!("{s}_{unit}"));
        let (positive, negative) = match (self.optional(&keys[0])?, self.optional(&keys[1])?) {
            (None, None) => return Ok(None),
            (Some(p), Some(n)) if p >= 0.0 && n >= 0.0 => (p * si, n * si),
            (p, n) => {
                let shown = |v: Option<f64>| v.map_or("nothing".into(), |v| v.to_string());
                let found = format!("`{}`: {}, `{}`: {}", keys[0], shown(p), keys[1], shown(n));
                return Err(self.bad(&keys[usize::from(p.is_some_and(|p| p >= 0.0))], found, "both, each 0 or more"));
            }
        };
        let interval = |key: &str, value: f64| -> Result<[f64; 2]> {
            if self.child(key).is_some() { Ok(self.array::<2>(key)?.map(|v| v * si)) } else { Ok([value; 2]) }
        };
        Ok(Some(Sides {
            positive,
            positive_ci95: interval("positive_ci95", positive)?,
            negative,
            negative_ci95: interval("negative_ci95", negative)?,
        }))
    }

    fn curve(&self, kind: JointKind) -> Result<GapCurve> {
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        match self.text("kind")?.as_str() {
            "constant" => Ok(GapCurve::Constant(self.number(&format!("half_gap_{unit}"))? * si)),
            "pchip" => {
                let expected = "two or more pairs `[position, half gap]` with rising positions";
                let shown = || self.value.get("knots").map_or("no `knots`".into(), |v| format!("`{v}`"));
                let knots: Option<Vec<[f64; 2]>> =
                    self.value.get("knots").and_then(|v| serde_json::from_value(v.clone()).ok());
                knots
                    .map(|k| k.iter().map(|p| p.map(|v| v * si)).collect::<Vec<_>>())
                    .and_then(|k| Pchip::new(&k))
                    .map(GapCurve::Pchip)
                    .ok_or_else(|| self.bad("knots", shown(), expected))
            }
            "polynomial" => {
                let coefficients = self.numbers("coefficients")?;
                if coefficients.is_empty() {
                    return Err(self.bad("coefficients", "an empty list".into(), "one coefficient or more"));
                }
                let key = format!("range_{unit}");
                let range = if self.child(&key).is_some() {
                    self.array::<2>(&key)?.map(|v| v * si)
                } else {
                    [f64::MIN, f64::MAX]
                };
                if range[0] >= range[1] {
                    return Err(self.bad(&key, format!("[{}, {}]", range[0] / si, range[1] / si), "[lower, upper]"));
                }
                let coefficients = coefficients.iter().enumerate().map(|(k, c)| c * si.powi(1 - k as i32)).collect();
                Ok(GapCurve::Polynomial { coefficients, range })
            }
            other => Err(self.bad("kind", format!("kind `{other}`"), "`pchip`, `polynomial` or `constant`")),
        }
    }

    fn stiction(&self, kind: JointKind) -> Result<StictionFound> {
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        let spike = self.number(&format!("spike_{unit}"))? * si;
        let travel = format!("decay_{unit}");
        let (decay, scale) = match (self.optional("decay_s")?, self.optional(&travel)?) {
            (Some(s), None) if s > 0.0 => (Decay::Time(s), 1.0),
            (None, Some(x)) if x > 0.0 => (Decay::Travel(x * si), si),
            _ => {
                return Err(self.bad(
                    "decay_s",
                    "no decay above 0, or two".into(),
                    &format!("`decay_s` or `{travel}`"),
                ));
            }
        };
        let value = match decay {
            Decay::Time(v) | Decay::Travel(v) => v,
        };
        let interval = |key: &str, scale: f64, value: f64| -> Result<[f64; 2]> {
            if self.child(key).is_some() { Ok(self.array::<2>(key)?.map(|v| v * scale)) } else { Ok([value; 2]) }
        };
        Ok(StictionFound {
            spike,
            ci95: interval("ci95", si, spike)?,
            decay,
            decay_ci95: interval("decay_ci95", scale, value)?,
        })
    }
}
