//! The document `lostmotion/gaps/1` as text: JSON on standard output, YAML in a file, the same content; and the pieces that other
//! documents share with it.
//!
//! Keys carry the unit of their joint: `half_gap_deg` of a revolute joint, `half_gap_mm` of a prismatic one. Figures are
//! written with ten significant digits. [`super::document`] holds the fields, [`super::read`] reads them back.

pub use super::document::document;
pub use super::values::{NameAndHash, SIGNIFICANT_DIGITS, extend, in_user_unit, keyed, keyed_list, number, value};

use crate::error::{Error, Result};
use crate::io::yaml;
use serde_json::Value;

/// The schema that a gaps file names.
pub const SCHEMA: &str = "lostmotion/gaps/1";

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
