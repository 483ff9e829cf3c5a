//! The compensator file `lostmotion/compensator/1` (YAML, degrees or millimetres, seconds) to and from [`Compensator`].
//!
//! ```yaml
//! schema: lostmotion/compensator/1
//! robot: {name: KUKA KR 120 R2500 PRO, sha256: ...}
//! valid_until: 2027-01-31                               # optional
//! joints:
//!   A1: {backlash: {half_gap_deg: 0.0028}, friction: {gain_deg: 0.0034, decay_s: 5.2}}
//!   A2: {backlash: {schedule: {kind: pchip, knots: [[-110, 0.0042], [-70, 0.0022]]}}}
//!   A3: {friction: {gain_deg: 0.0017, exponent: 3, poses: 5}}
//!   Z:  {backlash: {positive_mm: 0.09, negative_mm: 0.08}}
//! evidence: {...}
//! ```
//! A file written for another robot is refused by its fingerprint: offsets of one machine are wrong on the next. Keys that
//! are not known are refused in `joints` (a misspelt key would silently compensate nothing) and passed over in `evidence`.
//!
//! Parts:
//! - [`joint`]: the entry of one joint, read and written.
//! - [`date`]: days of the calendar.

mod date;
mod joint;

use super::evidence;
use super::schedule::shown;
use super::{Compensator, JointCompensator};
use crate::error::{Error, Place, Result};
use crate::io::{input, yaml::Document};
use crate::robot::Robot;
pub use date::{is_date, is_past};
pub(super) use joint::{read_joint, write_joint};
use serde::{Deserialize, Serialize};
use serde_yaml::{Mapping, Value};
use std::path::Path;

/// The schema that a compensator file names.
pub const SCHEMA: &str = "lostmotion/compensator/1";

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CompensatorFile {
    schema: String,
    robot: RobotRef,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    valid_until: Option<String>,
    joints: Mapping,
    #[serde(default)]
    evidence: Value,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotRef {
    #[serde(default)]
    name: String,
    sha256: String,
}

impl Compensator {
    /// Reads and checks a compensator file for `robot`.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text, robot)
    }

    /// Parses and checks the text of a compensator file; `name` stands in messages.
    pub fn parse(name: &str, text: &str, robot: &Robot) -> Result<Self> {
        let doc = Document { name, text };
        let file: CompensatorFile = doc.parse_schema("a compensator file", SCHEMA)?;
        doc.require_schema(&file.schema, SCHEMA)?;
        if file.robot.sha256 != robot.fingerprint() {
            return Err(Error::bad(
                doc.place(&["sha256"]),
                format!("a compensator for `{}` with sha256 {}", file.robot.name, file.robot.sha256),
                format!("one for `{}` with sha256 {}", robot.name, robot.fingerprint()),
            ));
        }
        if let Some(day) = &file.valid_until
            && !is_date(day)
        {
            return Err(Error::bad(doc.place(&["valid_until"]), format!("`{day}`"), "a date as 2027-01-31"));
        }
        let mut joints: Vec<JointCompensator> = Vec::new();
        for (key, value) in &file.joints {
            let key = shown(key);
            let at = Spot { doc: &doc, path: vec!["joints", &key] };
            let Some(axis) = robot.axis_named(&key) else {
                return Err(at.bad(format!("joint `{key}`"), format!("one of {}", robot.axis_names().join(", "))));
            };
            if joints.iter().any(|j| j.axis == axis) {
                return Err(at.bad(format!("a second entry for {key}"), "one entry per joint, case ignored".into()));
            }
            joints.push(read_joint(axis, value, robot.axis(axis), &at)?);
        }
        joints.sort_by_key(|j| j.axis);
        let mut evidence = evidence::read(&file.evidence, robot, &doc)?;
        evidence.valid_until = file.valid_until;
        Ok(Self { robot_name: file.robot.name, robot_sha256: file.robot.sha256, joints, evidence })
    }

    /// The document as YAML text.
    pub fn to_yaml(&self, robot: &Robot) -> Result<String> {
        crate::gaps::file::to_yaml(&self.to_json(robot)?)
    }

    /// The document as a JSON value: the same keys.
    pub fn to_json(&self, robot: &Robot) -> Result<serde_json::Value> {
        serde_json::to_value(self.to_file(robot)?).map_err(|e| Error::internal("write JSON", e))
    }

    fn to_file(&self, robot: &Robot) -> Result<CompensatorFile> {
        let mut joints = Mapping::new();
        for j in &self.joints {
            let joint = robot.axis(j.axis);
            joints.insert(joint.name.clone().into(), Value::Mapping(write_joint(j, joint)));
        }
        let evidence = serde_yaml::to_value(evidence::write(&self.evidence, robot))
            .map_err(|e| Error::bad(Place::default(), e.to_string(), "values that YAML can hold"))?;
        Ok(CompensatorFile {
            schema: SCHEMA.into(),
            robot: RobotRef { name: self.robot_name.clone(), sha256: self.robot_sha256.clone() },
            valid_until: self.evidence.valid_until.clone(),
            joints,
            evidence,
        })
    }
}

/// A path of keys in the document, for the line of a refusal.
pub(super) struct Spot<'a> {
    pub(super) doc: &'a Document<'a>,
    pub(super) path: Vec<&'a str>,
}

impl<'a> Spot<'a> {
    fn at(&self, key: &'a str) -> Spot<'a> {
        let mut path = self.path.clone();
        path.push(key);
        Spot { doc: self.doc, path }
    }

    /// The line of the deepest key found, each searched from the line of the one above it.
    fn place(&self) -> Place {
        let lines: Vec<&str> = self.doc.text.lines().collect();
        let (mut line, mut found) = (0, None);
        for key in &self.path {
            let hit = lines.iter().skip(line).position(|l| {
                let bare = l.split('#').next().unwrap_or("");
                bare.match_indices(key).any(|(i, _)| {
                    let before = bare[..i].chars().next_back().is_none_or(|c| " {,\"'".contains(c));
                    before && bare[i + key.len()..].trim_start_matches(['"', '\'']).trim_start().starts_with(':')
                })
            });
            if let Some(h) = hit {
                line += h;
                found = Some(line as u64 + 1);
            }
        }
        found.map_or_else(|| Place::file(self.doc.name), |l| Place::line(self.doc.name, l))
    }

    fn bad(&self, found: String, expected: String) -> Error {
        let joint = self.path.get(1).copied().unwrap_or_default();
        Error::bad(self.place(), format!("{found} under {joint}"), expected)
    }

    fn mapping<'v>(&self, value: &'v Value) -> Result<&'v Mapping> {
        match value {
            Value::Mapping(m) if !m.is_empty() => Ok(m),
            other => Err(self.bad(shown(other), "keys and values, at least one".into())),
        }
    }

    fn only(&self, map: &Mapping, allowed: &[&str]) -> Result<()> {
        match map.keys().map(shown).find(|k| !allowed.contains(&k.as_str())) {
            None => Ok(()),
            Some(k) => Err(Spot { doc: self.doc, path: [&self.path[..], &[k.as_str()]].concat() }
                .bad(format!("unknown key `{k}`"), format!("one of {}", allowed.join(", ")))),
        }
    }

    /// A finite number of `least` or more, where the key is there.
    fn number(&self, map: &Mapping, key: &str, least: f64) -> Result<Option<f64>> {
        let Some(v) = map.get(key) else { return Ok(None) };
        match v.as_f64() {
            Some(x) if x.is_finite() && x >= least => Ok(Some(x)),
            _ => {
                let expected = if least > 0.0 { "a finite number above 0" } else { "a finite number of 0 or more" };
                let spot = Spot { doc: self.doc, path: [&self.path[..], &[key]].concat() };
                Err(spot.bad(format!("{key}: {}", shown(v)), expected.into()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::FrictionShape;
    use crate::effects::Decay;

    #[test]
    fn days_that_no_calendar_has_are_no_dates() {
        for day in ["2027-01-31", "2028-02-29", "2000-02-29", "2027-12-01"] {
            assert!(is_date(day), "{day}");
        }
        for day in [
            "2027-02-29",
            "2100-02-29",
            "2020-02-31",
            "2027-13-01",
            "2027-00-10",
            "2027-04-31",
            "2027-1-031",
            "+027-01-31",
        ] {
            assert!(!is_date(day), "{day}");
        }
    }

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\nname: two\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: Z, \
                    kind: prismatic, limits_mm: [0, 800]}\n";
        Robot::parse("robot.yaml", text).unwrap()
    }

    fn file(joints: &str) -> String {
        format!("schema: {SCHEMA}\nrobot: {{name: two, sha256: {}}}\njoints:\n{joints}", robot().fingerprint())
    }

    fn refusal(text: &str) -> String {
        Compensator::parse("c.yaml", text, &robot()).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let text = file(
            "  A1: {backlash: {schedule: {kind: polynomial, coefficients: [0.003, 0.00001], range_deg: [-90, 90]}}, \
             friction: {gain_deg: 0.0017, exponent: 3, poses: 5}}\n  Z: {backlash: {positive_mm: 0.09, negative_mm: 0.08}, \
             friction: {gain_mm: 0.01, decay_mm: 0.2}}\nevidence: {tcp_speed_mm_s: 1.5, logs: [{name: a.csv, sha256: ff}], \
             joints: {A1: {half_gap_deg_ci95: [0.002, 0.004]}}, notes: [one], more: 1}\n",
        );
        let robot = robot();
        let one = Compensator::parse("c.yaml", &text, &robot).unwrap();
        let rad = std::f64::consts::PI / 180.0;
        let gap = &one.on(0).unwrap().backlash.as_ref().unwrap().positive;
        assert!((gap.at(50.0 * rad) / rad - 0.0035).abs() < 1e-12, "gap in deg over a position in deg");
        assert_eq!(one.on(1).unwrap().friction.unwrap().shape, FrictionShape::Decay(Decay::Travel(0.2e-3)));
        assert_eq!(one.evidence.tcp_speed_m_s, Some(1.5e-3));
        let again = Compensator::parse("c.yaml", &one.to_yaml(&robot).unwrap(), &robot).unwrap();
        assert_eq!(again.to_yaml(&robot).unwrap(), one.to_yaml(&robot).unwrap());
        assert_eq!(again.joints[1].backlash, one.joints[1].backlash);
        assert_eq!(again.evidence.joints, one.evidence.joints);
    }

    #[test]
    fn refuses_with_the_line_what_cannot_be_meant() {
        for (joints, line, what) in [
            ("  A9: {backlash: {half_gap_deg: 1}}\n", 4, "joint `A9`"),
            ("  A1: {backlash: {half_gap_mm: 1}}\n", 4, "unknown key `half_gap_mm`"),
            ("  A1:\n    backlash:\n      half_gap_deg: -0.1\n", 6, "half_gap_deg: -0.1"),
            ("  A1: {backlash: {half_gap_deg: .nan}}\n", 4, "half_gap_deg"),
            ("  A1: {friction: {gain_deg: 0.1}}\n", 4, "without a decay"),
            ("  A1: {friction: {gain_deg: 0.1, decay_s: 1, exponent: 2, poses: 5}}\n", 4, "two of them"),
            ("  A1: {friction: {gain_deg: 0.1, decay_s: 0}}\n", 4, "decay_s: 0"),
            ("  A1: {friction: {gain_deg: 0.1, exponent: 3, poses: 2.5}}\n", 4, "poses: 2.5"),
            ("  A1:\n    friction:\n      gain_deg: 0.1\n      decay_s: 1\n      colour: red\n", 8, "`colour`"),
            ("  Z: {backlash: {positive_mm: 1}}\n", 4, "two kinds"),
            ("  A1: {backlash: {schedule: {kind: pchip, knots: [[1, 0.1], [0, 0.1]]}}}\n", 4, "knots"),
            (
                "  A1: {backlash: {schedule: {kind: polynomial, coefficients: [-0.1], range_deg: [0, 1]}}}\n",
                4,
                "half gap of",
            ),
            ("  A1: {backlash: {schedule: {kind: polynomial, coefficients: [0.1]}}}\n", 4, "range_deg"),
            ("  A1: {backlash: {half_gap_deg: 0}}\n  a1: {backlash: {half_gap_deg: 0}}\n", 5, "second entry"),
            ("  A1: {}\n", 4, "at least one"),
        ] {
            let message = refusal(&file(joints));
            assert!(message.starts_with(&format!("c.yaml:{line}")) && message.contains(what), "{message}");
        }
    }

    #[test]
    fn a_day_is_past_from_the_next_one_on() {
        // 2024-02-29 is day 19,782 and 2000-01-01 day 10,957 since 1970-01-01
        for (day, number) in [("1970-01-01", 0), ("2000-01-01", 10_957), ("2024-02-29", 19_782), ("2024-03-01", 19_783)]
        {
            assert!(!is_past(day, number) && is_past(day, number + 1), "{day}");
        }
    }

    #[test]
    fn refuses_another_robots_file_and_another_schema() {
        let other = file("  A1: {backlash: {half_gap_deg: 0}}\n").replace(&robot().fingerprint(), "abc");
        assert!(
            refusal(&other).contains("c.yaml:2: found a compensator for `two` with sha256 abc"),
            "{}",
            refusal(&other)
        );
        let schema = refusal("schema: lostmotion/gaps/1\nrobot: {name: two, sha256: a}\n");
        assert!(schema.contains("c.yaml:1: found schema `lostmotion/gaps/1`"), "{schema}");
        assert!(
            refusal(&format!("{}valid_until: soon\n", file("  A1: {backlash: {half_gap_deg: 0}}\n"))).contains("date")
        );
    }

    #[test]
    fn an_empty_list_of_joints_changes_nothing() {
        let c = Compensator::parse("c.yaml", &file("  {}\n"), &robot()).unwrap();
        assert!(c.is_zero() && c.joints.is_empty());
    }
}
