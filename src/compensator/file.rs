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

use super::evidence;
use super::response::{MOST_SPIKES, MOST_WINDUPS};
use super::schedule::{self, shown, tidy};
use super::{BacklashOffset, Compensator, FrictionOffset, FrictionShape, JointCompensator, Response, Spike, Windup};
use crate::effects::{Decay, GapCurve};
use crate::error::{Error, Place, Result};
use crate::io::{input, yaml::Document};
use crate::robot::{Joint, Robot};
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

pub(super) fn write_joint(j: &JointCompensator, joint: &Joint) -> Mapping {
    let mut entry = Mapping::new();
    if let Some(b) = &j.backlash {
        entry.insert("backlash".into(), write_backlash(b, joint));
    }
    if let Some(f) = &j.friction {
        entry.insert("friction".into(), write_friction(f, joint));
    }
    entry
}

pub(super) fn read_joint(axis: usize, value: &Value, joint: &Joint, at: &Spot) -> Result<JointCompensator> {
    let map = at.mapping(value)?;
    at.only(map, &["backlash", "friction"])?;
    let backlash = match map.get("backlash") {
        None => None,
        Some(v) => Some(read_backlash(v, joint, &at.at("backlash"))?),
    };
    let friction = match map.get("friction") {
        None => None,
        Some(v) => Some(read_friction(v, joint, &at.at("friction"))?),
    };
    Ok(JointCompensator { axis, backlash, friction })
}

fn read_backlash(value: &Value, joint: &Joint, at: &Spot) -> Result<BacklashOffset> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let keys = [format!("half_gap_{unit}"), "schedule".into(), format!("positive_{unit}"), format!("negative_{unit}")];
    let sides = ["positive_schedule", "negative_schedule"];
    let map = at.mapping(value)?;
    let known: Vec<&str> = keys.iter().map(String::as_str).chain(sides).collect();
    at.only(map, &known)?;
    let curve = |number_key: &str, schedule_key: &str| -> Result<Option<GapCurve>> {
        let number = at.number(map, number_key, 0.0)?;
        match (number, map.get(schedule_key)) {
            (Some(_), Some(_)) => {
                Err(at.bad(format!("both `{number_key}` and `{schedule_key}`"), "one of the two".into()))
            }
            (Some(x), None) => Ok(Some(GapCurve::Constant(x * si))),
            (None, Some(v)) => match schedule::read(v, joint) {
                Ok(c) => Ok(Some(c)),
                Err((key, found, expected)) => {
                    let path = [&at.path[..], &[schedule_key, key.as_str()]].concat();
                    Err(Spot { doc: at.doc, path }.bad(found, expected))
                }
            },
            (None, None) => Ok(None),
        }
    };
    match (curve(&keys[0], "schedule")?, curve(&keys[2], sides[0])?, curve(&keys[3], sides[1])?) {
        (Some(c), None, None) => Ok(BacklashOffset::symmetric(c)),
        (None, Some(positive), Some(negative)) => Ok(BacklashOffset { positive, negative }),
        _ => Err(at.bad(
            "no gap, or two kinds of it".into(),
            format!("`half_gap_{unit}`, or `schedule`, or both `positive_{unit}` and `negative_{unit}`"),
        )),
    }
}

fn write_backlash(b: &BacklashOffset, joint: &Joint) -> Value {
    let unit = joint.kind.unit();
    let mut map = Mapping::new();
    let mut put = |curve: &GapCurve, number_key: String, schedule_key: &str| match schedule::write(curve, joint) {
        Some(v) => map.insert(schedule_key.into(), v),
        None => map.insert(number_key.into(), tidy(joint.kind.to_user_unit(curve.at(0.0))).into()),
    };
    if b.positive == b.negative {
        put(&b.positive, format!("half_gap_{unit}"), "schedule");
    } else {
        put(&b.positive, format!("positive_{unit}"), "positive_schedule");
        put(&b.negative, format!("negative_{unit}"), "negative_schedule");
    }
    Value::Mapping(map)
}

fn read_friction(value: &Value, joint: &Joint, at: &Spot) -> Result<FrictionOffset> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let (gain_key, travel_key) = (format!("gain_{unit}"), format!("decay_{unit}"));
    let map = at.mapping(value)?;
    let response_key = "response";
    at.only(map, &[&gain_key, "decay_s", &travel_key, "exponent", "poses", response_key])?;
    if let Some(value) = map.get(response_key) {
        if map.len() > 2 || (map.len() == 2 && !map.contains_key(gain_key.as_str())) {
            return Err(at.bad("a response with another way to fade".into(), "`response` alone".into()));
        }
        at.number(map, &gain_key, 0.0)?;
        return read_response(value, joint, &at.at(response_key)).map(FrictionOffset::of_response);
    }
    let above_zero = f64::MIN_POSITIVE;
    let gain = at.number(map, &gain_key, 0.0)?;
    let time = at.number(map, "decay_s", above_zero)?;
    let travel = at.number(map, &travel_key, above_zero)?;
    let exponent = at.number(map, "exponent", above_zero)?;
    let poses = at.number(map, "poses", 2.0)?;
    let Some(gain) = gain else {
        return Err(at.bad(format!("no `{gain_key}`"), format!("`{gain_key}`, and how it fades")));
    };
    let shape = match (time, travel, exponent, poses) {
        (Some(s), None, None, None) => FrictionShape::Decay(Decay::Time(s)),
        (None, Some(x), None, None) => FrictionShape::Decay(Decay::Travel(x * si)),
        (None, None, Some(exponent), Some(poses)) => {
            if poses.fract() != 0.0 || poses > f64::from(u32::MAX) {
                return Err(at.at("poses").bad(format!("poses: {poses}"), "a whole number of 2 or more".into()));
            }
            FrictionShape::Poses { exponent, poses: poses as u32 }
        }
        _ => {
            return Err(at.bad(
                "a gain without the way it fades, or with two of them".into(),
                format!("one of `decay_s`, `{travel_key}`, or both `exponent` and `poses`"),
            ));
        }
    };
    Ok(FrictionOffset { gain: gain * si, shape })
}

/// `response: {presliding_deg, windups: [[windup_deg, presliding_deg], ...], spikes: [[gain_deg, decay_s], ...]}`.
fn read_response(value: &Value, joint: &Joint, at: &Spot) -> Result<Response> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let presliding_key = format!("presliding_{unit}");
    let map = at.mapping(value)?;
    at.only(map, &[&presliding_key, "windups", "spikes"])?;
    let Some(presliding) = at.number(map, &presliding_key, f64::MIN_POSITIVE)? else {
        return Err(at.bad(format!("no `{presliding_key}`"), "the travel over which friction turns over".into()));
    };
    let pairs = |key: &str, most: usize, second: &str| -> Result<Vec<[f64; 2]>> {
        let read: Option<Vec<[f64; 2]>> = match map.get(key) {
            None => Some(Vec::new()),
            Some(v) => serde_yaml::from_value(v.clone()).ok(),
        };
        let sound =
            |p: &Vec<[f64; 2]>| p.len() <= most && p.iter().all(|[g, d]| g.is_finite() && d.is_finite() && *d > 0.0);
        read.filter(sound).ok_or_else(|| {
            let expected = format!("at most {most} pairs of a size in {unit} and a {second} above 0, finite");
            at.bad(format!("{key} that cannot be read"), expected)
        })
    };
    let mut windups = [Windup { half: 0.0, presliding }; MOST_WINDUPS];
    for (w, [half, over]) in windups.iter_mut().zip(pairs("windups", MOST_WINDUPS, "presliding")?) {
        *w = Windup { half: half * si, presliding: over * si };
    }
    let pairs = pairs("spikes", MOST_SPIKES, "decay_s")?;
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    for (s, [gain, decay_s]) in spikes.iter_mut().zip(pairs) {
        *s = Spike { gain: gain * si, decay_s };
    }
    Ok(Response { presliding: presliding * si, windups, spikes })
}

fn write_friction(f: &FrictionOffset, joint: &Joint) -> Value {
    let unit = joint.kind.unit();
    let mut map = Mapping::new();
    map.insert(format!("gain_{unit}").into(), tidy(joint.kind.to_user_unit(f.gain)).into());
    match f.shape {
        FrictionShape::Decay(Decay::Time(s)) => {
            map.insert("decay_s".into(), tidy(s).into());
        }
        FrictionShape::Decay(Decay::Travel(x)) => {
            map.insert(format!("decay_{unit}").into(), tidy(joint.kind.to_user_unit(x)).into());
        }
        FrictionShape::Poses { exponent, poses } => {
            map.insert("exponent".into(), tidy(exponent).into());
            map.insert("poses".into(), poses.into());
        }
        FrictionShape::Response(r) => {
            let edge = |v: f64| Value::from(tidy(joint.kind.to_user_unit(v)));
            let mut response = Mapping::new();
            response.insert(format!("presliding_{unit}").into(), edge(r.presliding));
            let wound = r.windups.iter().filter(|w| w.half != 0.0);
            let pairs = wound.map(|w| Value::Sequence(vec![edge(w.half), edge(w.presliding)])).collect();
            response.insert("windups".into(), Value::Sequence(pairs));
            let used = r.spikes.iter().filter(|s| s.gain != 0.0);
            let pairs = used.map(|s| Value::Sequence(vec![edge(s.gain), tidy(s.decay_s).into()])).collect();
            response.insert("spikes".into(), Value::Sequence(pairs));
            map.insert("response".into(), Value::Mapping(response));
        }
    }
    Value::Mapping(map)
}

/// Whether the day `YYYY-MM-DD` lies before `today`, days since 1970-01-01.
pub fn is_past(day: &str, today: i64) -> bool {
    let number = |r: std::ops::Range<usize>| day.get(r).and_then(|s| s.parse::<i64>().ok());
    let (Some(y), Some(m), Some(d)) = (number(0..4), number(5..7), number(8..10)) else { return false };
    // years begin in March, so that the leap day is their last (Hinnant, days_from_civil)
    let (y, m) = if m > 2 { (y, m - 3) } else { (y - 1, m + 9) };
    let (era, of_era) = (y.div_euclid(400), y.rem_euclid(400));
    let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + (153 * m + 2) / 5 + d - 1 - 719_468;
    days < today
}

/// `YYYY-MM-DD` with a month and a day that exist.
pub fn is_date(text: &str) -> bool {
    let b = text.as_bytes();
    let digits = |r: std::ops::Range<usize>| {
        text.get(r).filter(|s| s.bytes().all(|b| b.is_ascii_digit())).and_then(|s| s.parse::<u32>().ok())
    };
    if b.len() != 10 || b[4] != b'-' || b[7] != b'-' {
        return false;
    }
    let (Some(year), Some(month), Some(day)) = (digits(0..4), digits(5..7), digits(8..10)) else { return false };
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        4 | 6 | 9 | 11 => 30,
        2 => 28 + u32::from(leap),
        _ => 31,
    };
    (1..=12).contains(&month) && (1..=days).contains(&day)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("  A1: {friction: {gain_deg: 0.1}}\n", 4, "without the way it fades"),
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
