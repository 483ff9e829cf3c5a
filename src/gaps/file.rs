//! The document `lostmotion/gaps/1`, to and from [`Gaps`]: JSON on standard output, YAML in a file, the same content.
//!
//! Keys carry the unit of their joint: `half_gap_deg` of a revolute joint, `half_gap_mm` of a prismatic one. Figures are
//! written with ten significant digits. Reading is next door ([`super::read`]).

use super::{GapPoint, Gaps, JointGap, Registered, StictionFound, estimate};
use crate::effects::{Decay, GapCurve};
use crate::error::{Error, Result};
use crate::io::yaml;
use crate::robot::file::FrameFile;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::{Map, Value, json};

/// The schema that a gaps file names.
pub const SCHEMA: &str = "lostmotion/gaps/1";

/// A number with ten significant digits; one that is not finite is null.
pub fn number(v: f64) -> Value {
    let rounded: f64 = format!("{v:.9e}").parse().unwrap_or(v);
    serde_json::Number::from_f64(rounded + 0.0).map_or(Value::Null, Value::Number)
}

/// A part of a document as JSON, its keys in the order of the fields.
///
/// # Errors
/// Internal, where a part cannot be written as JSON.
pub fn value(part: &impl Serialize) -> Result<Value> {
    serde_json::to_value(part).map_err(|e| Error::internal("write JSON", e))
}

/// Joint values (rad or m) in the unit of the edges.
pub fn in_user_unit(values: &[f64], kind: JointKind) -> Value {
    values.iter().map(|&v| number(kind.to_user_unit(v))).collect()
}

fn point(p: &GapPoint, robot: &Robot) -> Value {
    let joint = robot.axis(p.axis);
    let (kind, unit) = (joint.kind, joint.kind.unit());
    let mut m = Map::new();
    m.insert("joint".into(), joint.name.clone().into());
    m.insert(format!("at_{unit}"), number(kind.to_user_unit(p.at)));
    m.insert(format!("half_gap_{unit}"), number(kind.to_user_unit(p.half_gap)));
    m.insert("ci95".into(), in_user_unit(&p.ci95, kind));
    m.insert("cycles".into(), p.cycles.into());
    if !p.per_cycle.is_empty() {
        m.insert(format!("per_cycle_{unit}"), in_user_unit(&p.per_cycle, kind));
    }
    Value::Object(m)
}

fn joint(j: &JointGap, gaps: &Gaps, robot: &Robot) -> Value {
    let joint = robot.axis(j.axis);
    let (kind, unit) = (joint.kind, joint.kind.unit());
    let mut m = Map::new();
    m.insert("joint".into(), joint.name.clone().into());
    m.insert(format!("half_gap_{unit}"), number(kind.to_user_unit(j.half_gap)));
    m.insert("ci95".into(), in_user_unit(&j.ci95, kind));
    if let Some(s) = &j.sides {
        for (side, value, ci95) in
            [("positive", s.positive, s.positive_ci95), ("negative", s.negative, s.negative_ci95)]
        {
            m.insert(format!("{side}_{unit}"), number(kind.to_user_unit(value)));
            m.insert(format!("{side}_ci95"), in_user_unit(&ci95, kind));
        }
    }
    m.insert("significant".into(), j.significant.into());
    m.insert("schedule".into(), j.schedule.as_ref().map_or(Value::Null, |c| curve(c, kind)));
    m.insert("varies_p_value".into(), j.varies_p_value.map_or(Value::Null, number));
    m.insert("stiction".into(), j.stiction.as_ref().map_or(Value::Null, |s| stiction(s, kind)));
    if let Some(p) = j.stiction_p_value {
        m.insert("stiction_p_value".into(), number(p));
    }
    let of_all = gaps.estimate.iter().flat_map(|e| &e.joints).find(|e| e.axis == j.axis);
    if let Some(e) = of_all {
        estimate::write_joint(e, kind, &mut m);
    }
    Value::Object(m)
}

/// The document.
pub fn document(gaps: &Gaps, robot: &Robot) -> Value {
    let mut doc = Map::new();
    doc.insert("schema".into(), SCHEMA.into());
    doc.insert("robot".into(), json!({"name": gaps.robot_name, "sha256": gaps.robot_sha256}));
    doc.insert("logs".into(), gaps.logs.iter().map(|l| json!({"name": l.name, "sha256": l.sha256})).collect());
    doc.insert("registration".into(), gaps.registration.as_ref().map_or(Value::Null, registration));
    if let Some(v) = gaps.tcp_speed_m_s {
        doc.insert("tcp_speed_mm_s".into(), number(v * 1e3));
    }
    doc.insert("points".into(), gaps.points.iter().map(|p| point(p, robot)).collect());
    doc.insert("joints".into(), gaps.joints.iter().map(|j| joint(j, gaps, robot)).collect());
    if let Some(e) = &gaps.estimate {
        estimate::write_top(e, robot, &mut doc);
    }
    if let Some(distrust) = &gaps.distrust {
        doc.insert("distrust".into(), json!(distrust));
    }
    doc.insert("notes".into(), gaps.notes.iter().cloned().collect());
    Value::Object(doc)
}

fn registration(r: &Registered) -> Value {
    let frame = FrameFile::from_isometry(&r.frame);
    let list = |values: [f64; 3], scale: f64| -> Value { values.iter().map(|v| number(v * scale)).collect() };
    let mut m = Map::new();
    m.insert("xyz_mm".into(), list(frame.xyz_mm, 1.0));
    m.insert("rpy_deg".into(), list(frame.rpy_deg, 1.0));
    m.insert("rms_um".into(), number(r.rms_m * 1e6));
    m.insert("samples".into(), r.samples.into());
    if r.sigma_m.iter().chain(&r.sigma_rad).any(|s| *s > 0.0) {
        m.insert("sigma_um".into(), list(r.sigma_m, 1e6));
        m.insert("sigma_deg".into(), list(r.sigma_rad, 1f64.to_degrees()));
    }
    Value::Object(m)
}

fn stiction(s: &StictionFound, kind: JointKind) -> Value {
    let unit = kind.unit();
    let mut m = Map::new();
    m.insert(format!("spike_{unit}"), number(kind.to_user_unit(s.spike)));
    m.insert("ci95".into(), in_user_unit(&s.ci95, kind));
    match s.decay {
        Decay::Time(t) => {
            m.insert("decay_s".into(), number(t));
            m.insert("decay_ci95".into(), s.decay_ci95.iter().map(|&v| number(v)).collect());
        }
        Decay::Travel(x) => {
            m.insert(format!("decay_{unit}"), number(kind.to_user_unit(x)));
            m.insert("decay_ci95".into(), in_user_unit(&s.decay_ci95, kind));
        }
    }
    Value::Object(m)
}

/// A gap curve: `{kind: pchip, knots: [[position, half gap], ...]}` or `{kind: polynomial, coefficients, range_deg}`, position
/// and gap both in deg (or mm).
pub fn curve(curve: &GapCurve, kind: JointKind) -> Value {
    match curve {
        GapCurve::Constant(b) => {
            json!({"kind": "constant", format!("half_gap_{}", kind.unit()): number(kind.to_user_unit(*b))})
        }
        GapCurve::Pchip(p) => {
            let knots: Value = p.knots().iter().map(|k| in_user_unit(k, kind)).collect();
            json!({"kind": "pchip", "knots": knots})
        }
        GapCurve::Polynomial { coefficients, range } => {
            let si = kind.si_per_user_unit();
            let c: Value = coefficients.iter().enumerate().map(|(k, c)| number(c * si.powi(k as i32 - 1))).collect();
            json!({"kind": "polynomial", "coefficients": c, format!("range_{}", kind.unit()): in_user_unit(range, kind)})
        }
    }
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
