//! The pieces that documents share: figures in the units of the edges, with ten significant digits.

use crate::error::{Error, Result};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

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
