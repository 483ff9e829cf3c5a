//! The document `lostmotion/gaps/1` as text: JSON on standard output, YAML in a file, the same content; and the pieces that other
//! documents share with it.
//!
//! Keys carry the unit of their joint: `half_gap_deg` of a revolute joint, `half_gap_mm` of a prismatic one. Figures are
//! written with ten significant digits. [`super::document`] holds the fields, [`super::read`] reads them back.

pub use super::document::document;

use crate::error::{Error, Result};
use crate::io::keyed::Keyed;
use crate::io::yaml;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

/// The schema that a gaps file names.
pub const SCHEMA: &str = "lostmotion/gaps/1";

/// Digits of the numbers of a document.
pub const SIGNIFICANT_DIGITS: i32 = 10;

/// A number with ten significant digits; one that is not finite is null.
pub fn number(v: f64) -> Value {
    let rounded: f64 = format!("{v:.9e}").parse().unwrap_or(v);
    serde_json::Number::from_f64(rounded + 0.0).map_or(Value::Null, Value::Number)
}

/// A joint's figure (rad or m) under a key that ends in its unit.
pub fn keyed(name: &str, si: f64, kind: JointKind) -> Keyed<Value> {
    Keyed::new(name, kind.unit(), number(kind.to_user_unit(si)))
}

/// A joint's figures (rad or m) under a key that ends in their unit.
pub fn keyed_list(name: &str, si: &[f64], kind: JointKind) -> Keyed<Value> {
    Keyed::new(name, kind.unit(), in_user_unit(si, kind))
}

/// A part of a document as JSON, its keys in the order of the fields.
///
/// # Errors
/// Internal, where a part cannot be written as JSON.
pub fn value(part: &impl Serialize) -> Result<Value> {
    serde_json::to_value(part).map_err(|e| Error::internal("write JSON", e))
}

/// Appends the fields of `part` to an object, in their order; a field that is there already keeps its place.
pub fn extend(object: &mut Value, part: &impl Serialize) {
    if let (Some(map), Ok(Value::Object(fields))) = (object.as_object_mut(), serde_json::to_value(part)) {
        map.extend(fields);
    }
}

/// The name of a file or a robot, and what identifies its content.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct NameAndHash {
    /// Name as messages show it.
    pub name: String,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

impl NameAndHash {
    /// Of a robot: its fingerprint.
    pub fn of_robot(robot: &Robot) -> Self {
        Self { name: robot.name.clone(), sha256: robot.fingerprint() }
    }
}

/// Joint values (rad or m) in the unit of the edges.
pub fn in_user_unit(values: &[f64], kind: JointKind) -> Value {
    values.iter().map(|&v| number(kind.to_user_unit(v))).collect()
}

/// One JSON document with a newline at its end.
pub fn to_json(doc: &Value) -> Result<String> {
    let text = serde_json::to_string_pretty(doc).map_err(|e| Error::internal("write JSON", e))?;
    Ok(text + "\n")
}

/// The same as YAML. A number like `5e-5` becomes `5.0e-05`: YAML 1.1 readers take the short form for text.
pub fn to_yaml(doc: &Value) -> Result<String> {
    let text = yaml::to_text(doc)?;
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        let cut = line.rfind([' ']).map_or(0, |i| i + 1);
        let (head, last) = line.split_at(cut);
        out.push_str(head);
        match last.split_once(['e', 'E']) {
            Some((mantissa, exponent)) if mantissa.parse::<f64>().is_ok() && exponent.parse::<i32>().is_ok() => {
                let point = if mantissa.contains('.') { "" } else { ".0" };
                let (sign, digits) = match exponent.strip_prefix('-') {
                    Some(d) => ('-', d),
                    None => ('+', exponent.trim_start_matches('+')),
                };
                out.push_str(&format!("{mantissa}{point}e{sign}{digits:0>2}"));
            }
            _ => out.push_str(last),
        }
        out.push('\n');
    }
    Ok(out)
}
