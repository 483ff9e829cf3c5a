//! A robot file as a person writes it: one line for each joint, limits and speeds to four decimals.
//!
//! A URDF gives limits in radians, of which degrees have no end: -2.2 rad is -126.05071492878112 deg. A ten-thousandth of a degree is
//! far below what a limit means, and limits are rounded inwards. Geometry keeps every digit, so the arm stands where the source has it.

use super::Robot;
use super::file::{JointFile, RobotFile};
use crate::error::{Error, Place, Result};
use serde_yaml::{Mapping, Value};

/// Decimals of limits and speeds, deg or mm.
const DECIMALS: i32 = 4;

impl Robot {
    /// The robot file, below a comment of one line where one is given.
    ///
    /// # Errors
    /// Where a number is none that YAML can hold.
    pub fn to_lines(&self, comment: &str) -> Result<String> {
        let mut file = self.to_file();
        file.joints.iter_mut().for_each(round_limits);
        let text =
            written(&file).ok_or_else(|| Error::bad(Place::default(), "a robot", "values that YAML can hold"))?;
        let comment = comment.replace(['\n', '\r'], " ");
        Ok(if comment.is_empty() { text } else { format!("# {comment}\n{text}") })
    }
}

/// Limits and rates with [`DECIMALS`], never wider than they were; what a conversion of units leaves is not taken for a digit.
fn round_limits(joint: &mut JointFile) {
    const CONVERSION: f64 = 1e-6;
    let digits = 10f64.powi(DECIMALS);
    let down = |v: &mut f64| *v = (*v * digits + CONVERSION).floor() / digits + 0.0;
    for [lower, upper] in [&mut joint.limits_deg, &mut joint.limits_mm].into_iter().flatten() {
        *lower = (*lower * digits - CONVERSION).ceil() / digits + 0.0;
        down(upper);
    }
    let rates = [
        &mut joint.max_speed_deg_s,
        &mut joint.max_speed_mm_s,
        &mut joint.max_accel_deg_s2,
        &mut joint.max_accel_mm_s2,
    ];
    rates.into_iter().flatten().for_each(down);
}

/// Each key of the document on a line; lists of joints, links and the like with an item on each line.
fn written(file: &RobotFile) -> Option<String> {
    let Value::Mapping(document) = serde_yaml::to_value(file).ok()? else { return None };
    let mut out = String::new();
    for (key, value) in &document {
        let key = inline(key)?;
        match value {
            Value::Sequence(items) if items.iter().any(Value::is_mapping) => {
                out += &format!("{key}:\n");
                for item in items {
                    out += &format!("  - {}\n", inline(item)?);
                }
            }
            Value::Mapping(map) if map.values().any(Value::is_mapping) => {
                out += &format!("{key}:\n");
                for (name, item) in map {
                    out += &format!("  {}: {}\n", inline(name)?, inline(item)?);
                }
            }
            other => out += &format!("{key}: {}\n", inline(other)?),
        }
    }
    Some(out)
}

/// A value on one line.
fn inline(value: &Value) -> Option<String> {
    Some(match value {
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => match n.as_f64() {
            // whole numbers without a point, as people write them
            Some(v) if v.fract() == 0.0 && v.abs() < 1e15 => format!("{v:.0}"),
            Some(v) if v.is_finite() => v.to_string(),
            _ => return None,
        },
        Value::String(s) if is_plain(s) => s.clone(),
        Value::String(s) => serde_json::to_string(s).ok()?,
        Value::Sequence(items) => format!("[{}]", items.iter().map(inline).collect::<Option<Vec<_>>>()?.join(", ")),
        Value::Mapping(map) => format!("{{{}}}", pairs(map)?.join(", ")),
        Value::Tagged(_) => return None,
    })
}

fn pairs(map: &Mapping) -> Option<Vec<String>> {
    map.iter().map(|(k, v)| Some(format!("{}: {}", inline(k)?, inline(v)?))).collect()
}

/// Text that YAML reads as this text without quotes, within braces, too.
fn is_plain(s: &str) -> bool {
    let simple = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '/' | ' ' | '.' | '+');
    let begins = s.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
    let same = || serde_yaml::from_str::<Value>(s).is_ok_and(|v| v.as_str() == Some(s));
    begins && s.chars().all(simple) && s.trim() == s && !is_old_bool(s) && same()
}

/// What older readers of YAML take for a truth value.
fn is_old_bool(s: &str) -> bool {
    ["y", "n", "yes", "no", "on", "off"].contains(&s.to_ascii_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_has_one_line_with_rounded_limits_and_the_same_geometry() {
        let text = "schema: lostmotion/robot/1\nname: \"arm: 2\"\njoints:\n  - {name: Y, kind: revolute, d_mm: 127.30000000000001, alpha_deg: -90, \
                    limits_deg: [-126.05071492878112, 343.77467707849394], max_speed_deg_s: 171.88733853924697}\n\
                    tools: {gripper: {xyz_mm: [0, 0, 100], rpy_deg: [0, 0, 0]}}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let lines = robot.to_lines("from arm.urdf").unwrap();
        assert!(lines.starts_with("# from arm.urdf\nschema: lostmotion/robot/1\nname: \"arm: 2\"\n"), "{lines}");
        let joint = lines.lines().find(|l| l.starts_with("  - {name: \"Y\"")).unwrap();
        assert!(joint.contains("limits_deg: [-126.0507, 343.7746], max_speed_deg_s: 171.8873}"), "{joint}");
        assert!(lines.contains("  gripper: {xyz_mm: [0, 0, 100], rpy_deg: [0, 0, 0]}\n"), "{lines}");
        let again = Robot::parse("again.yaml", &lines).unwrap();
        assert_eq!(again.forward(&[0.3]).position, robot.forward(&[0.3]).position);
        assert_eq!(again.to_lines("from arm.urdf").unwrap(), lines);
    }
}
