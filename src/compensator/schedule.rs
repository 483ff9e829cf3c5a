//! A half gap over position as it stands in a document: `{kind: polynomial, coefficients: [c0, c1, ...], range_deg: [lo,
//! hi]}` (gap in deg for a position in deg) or `{kind: pchip, knots: [[deg, half_gap_deg], ...]}`; `_mm` for a prismatic joint.
//!
//! A polynomial without a range holds over the limits of its joint; beyond its range or its knots a schedule is constant. A
//! schedule that falls below zero anywhere is refused: a gap cannot be negative.

use crate::effects::{GapCurve, curve::Pchip};
use crate::robot::Joint;
use serde_yaml::{Mapping, Value};

/// Gaps below this (rad or m) are zero up to number noise of a polynomial's ends.
const NEGATIVE_NOISE: f64 = 1e-12;

/// What is wrong: the key, what was found, what is expected.
pub type Wrong = (String, String, String);

/// Digits of [`tidy`].
const DIGITS: i32 = 12;

/// Twelve digits: enough for 1e-9 of a gap, without the noise of the conversion to degrees.
pub fn tidy(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// One value as a message shows it.
pub fn shown(v: &Value) -> String {
    serde_yaml::to_string(v).map_or_else(|_| "?".into(), |s| s.trim().replace('\n', " "))
}

fn wrong(key: &str, found: impl Into<String>, expected: impl Into<String>) -> Wrong {
    (key.to_string(), found.into(), expected.into())
}

fn pchip(map: &Mapping, joint: &Joint) -> Result<GapCurve, Wrong> {
    let (si, unit) = (joint.kind.si_per_user_unit(), joint.kind.unit());
    let knots: Option<Vec<[f64; 2]>> = map.get("knots").and_then(|v| serde_yaml::from_value(v.clone()).ok());
    let pairs = knots.map(|k| k.iter().map(|p| p.map(|v| v * si)).collect::<Vec<_>>());
    let expected =
        || format!("two or more pairs [position_{unit}, half_gap_{unit}], finite, positions strictly rising");
    let curve = pairs.and_then(|p| Pchip::new(&p)).map(GapCurve::Pchip);
    curve.ok_or_else(|| wrong("knots", "knots that cannot be joined", expected()))
}

fn polynomial(map: &Mapping, range_key: &str, joint: &Joint) -> Result<GapCurve, Wrong> {
    let si = joint.kind.si_per_user_unit();
    let numbers = |key: &str| -> Option<Vec<f64>> {
        let v: Vec<f64> = serde_yaml::from_value(map.get(key)?.clone()).ok()?;
        (!v.is_empty() && v.iter().all(|x| x.is_finite())).then_some(v)
    };
    let c = numbers("coefficients")
        .ok_or_else(|| wrong("coefficients", "no coefficients, or one that is not a number", "finite numbers"))?;
    let range = match (map.contains_key(range_key), joint.limits) {
        (true, _) => numbers(range_key)
            .and_then(|v| <[f64; 2]>::try_from(v).ok())
            .map(|r| r.map(|v| v * si))
            .filter(|[lo, hi]| lo < hi),
        (false, limits) => limits,
    };
    let range = range.ok_or_else(|| {
        wrong(range_key, format!("no usable `{range_key}`"), format!("`{range_key}: [lower, upper]`"))
    })?;
    let coefficients = c.iter().enumerate().map(|(k, c)| c * si / si.powi(k as i32)).collect();
    Ok(GapCurve::Polynomial { coefficients, range })
}

/// Reads a schedule for `joint`.
pub fn read(value: &Value, joint: &Joint) -> Result<GapCurve, Wrong> {
    let unit = joint.kind.unit();
    let Value::Mapping(map) = value else {
        return Err(wrong("schedule", shown(value), "`{kind: polynomial, ...}` or `{kind: pchip, ...}`"));
    };
    let range_key = format!("range_{unit}");
    let kind = map.get("kind").and_then(Value::as_str).unwrap_or_default();
    let allowed: &[&str] = match kind {
        "polynomial" => &["kind", "coefficients", range_key.as_str()],
        "pchip" => &["kind", "knots"],
        other => {
            return Err(wrong("kind", format!("schedule of kind `{other}`"), "`polynomial` or `pchip`"));
        }
    };
    if let Some(key) = map.keys().map(shown).find(|k| !allowed.contains(&k.as_str())) {
        return Err(wrong(&key, format!("unknown key `{key}`"), format!("only {}", allowed.join(", "))));
    }
    let curve = if kind == "pchip" { pchip(map, joint)? } else { polynomial(map, &range_key, joint)? };
    if curve.smallest() < -NEGATIVE_NOISE {
        let at = format!("a half gap of {} {unit}", tidy(joint.kind.to_user_unit(curve.smallest())));
        return Err(wrong("schedule", at, "half gaps of 0 or more everywhere"));
    }
    Ok(curve)
}

/// A schedule in the units of the edges; `None` for a constant.
pub fn write(curve: &GapCurve, joint: &Joint) -> Option<Value> {
    let kind = joint.kind;
    let edge = |v: f64| Value::from(tidy(kind.to_user_unit(v)));
    let mut map = Mapping::new();
    match &curve.for_digits(DIGITS) {
        GapCurve::Constant(_) => return None,
        GapCurve::Polynomial { coefficients, range } => {
            let si = kind.si_per_user_unit();
            map.insert("kind".into(), "polynomial".into());
            let c = coefficients.iter().enumerate();
            let c = c.map(|(k, c)| Value::from(tidy(c / si * si.powi(k as i32)))).collect();
            map.insert("coefficients".into(), Value::Sequence(c));
            let range = range.iter().map(|&v| edge(v)).collect();
            map.insert(format!("range_{}", kind.unit()).into(), Value::Sequence(range));
        }
        GapCurve::Pchip(p) => {
            map.insert("kind".into(), "pchip".into());
            let knots = p.knots().iter().map(|k| Value::Sequence(k.iter().map(|&v| edge(v)).collect())).collect();
            map.insert("knots".into(), Value::Sequence(knots));
        }
    }
    Some(Value::Mapping(map))
}
