//! Sizes at which effects matter, for those of which no size is known yet.
//!
//! Shop-floor magnitudes: a half gap of 0.003 deg or 5 um (seed 000 measured 0.002 to 0.01 deg), a lag of 10 ms, 100 ppm of
//! a gear, 0.1 mm of a link. Where rivals of a found effect are asked for, lost motion is made as large as the found one,
//! with the transition so short that a log of common speed has no row in it: the hard case.

use crate::effects::{Effect, EffectInstance, entry};
use crate::error::{Error, Result};
use crate::io::yaml::Document;
use crate::robot::{JointKind, Robot};
use serde_yaml::{Mapping, Value};

/// What a size leans on.
#[derive(Debug, Clone)]
pub struct Scale<'a> {
    pub robot: &'a Robot,
    /// Least and most of each axis in the experiment, rad or m.
    pub window: &'a [[f64; 2]],
    pub speed_m_s: f64,
    pub duration_s: f64,
    /// Lost motion of a found effect, rad or m, by axis.
    pub lost: Vec<Option<f64>>,
}

/// Half of the lost motion that an effect makes at a reversal, rad or m.
pub fn lost_motion(effect: &Effect) -> Option<f64> {
    match effect {
        Effect::Backlash(b) => Some(b.half_gap.largest()),
        Effect::BacklashSpeed(b) => Some(b.half_gap),
        Effect::Hysteresis(h) => Some(h.half_width),
        Effect::Stiction(s) => Some(s.spike),
        _ => None,
    }
    .filter(|b| *b > 0.0)
}

/// Travel behind a reversal over which an effect is in transition, rad or m.
pub fn transition(effect: &Effect) -> Option<f64> {
    match effect {
        Effect::Hysteresis(h) => Some(h.presliding),
        Effect::Stiction(s) => match s.decay {
            crate::effects::Decay::Travel(x) => Some(x),
            crate::effects::Decay::Time(_) => Some(2.0 * s.spike),
        },
        other => lost_motion(other).map(|b| 2.0 * b),
    }
}

/// The effect `name` on `target` with the keys `given`; what is not given has its typical size.
pub fn placed(name: &str, target: &str, given: &Mapping, scale: &Scale, doc: &Document) -> Result<EffectInstance> {
    let mut map = typical(name, target, given, scale);
    for (k, v) in given {
        map.insert(k.clone(), v.clone());
    }
    map.insert("effect".into(), name.into());
    let key = match name {
        "tool_error" | "thermal_drift" | "vibration" | "time_offset" | "axis_coupling" | "link_error" => "target",
        _ => "joint",
    };
    if !target.is_empty() {
        map.insert(key.into(), target.into());
    }
    let placed = entry::read(&Value::Mapping(map), scale.robot, doc)?;
    let inside =
        placed.effect.values().iter().zip(placed.bounds(scale.robot)).all(|(v, (lo, hi))| *v >= lo && *v <= hi);
    if !inside {
        let found = format!("{name} {target} of a size that no machine has");
        return Err(Error::bad(doc.place(&[name]), found, "a size within the bounds of the catalogue"));
    }
    Ok(placed)
}

fn typical(name: &str, target: &str, given: &Mapping, scale: &Scale) -> Mapping {
    let joint = target.split(['<', '.']).next().unwrap_or_default().trim();
    let axis = scale.robot.axis_named(joint);
    let kind = axis.map_or(JointKind::Revolute, |a| scale.robot.axis(a).kind);
    let unit = kind.unit();
    let lost = axis.and_then(|a| scale.lost.get(a).copied().flatten());
    let gap = lost.map_or(if kind == JointKind::Revolute { 0.003 } else { 0.005 }, |b| kind.to_edge(b));
    let mut map = Mapping::new();
    let mut put = |key: String, value: f64| {
        map.insert(Value::String(key), value.into());
    };
    let has = |start: &str| given.keys().any(|k| k.as_str().is_some_and(|k| k.starts_with(start)));
    let joint_key = |key: &str| format!("{key}_{unit}");
    match name {
        "servo_lag" => put("lag_s".into(), 0.01),
        "stiction" => {
            put(joint_key("spike"), gap);
            if !has("decay") {
                put("decay_s".into(), 1.5);
            }
        }
        "encoder_scale" => put("scale_ppm".into(), 100.0),
        "transmission_error" => {
            put(joint_key("amplitude"), 0.5 * gap);
            // a period of about 10 deg, or of a turn of the lead
            put("cycles_per_rev".into(), if kind == JointKind::Revolute { 37.0 } else { 1.0 });
        }
        "backlash" => put(joint_key("half_gap"), gap),
        "backlash_speed" => {
            put(joint_key("half_gap"), 0.5 * gap);
            put(format!("slope_{unit}_per_mm_s"), 0.5 * gap / (scale.speed_m_s * 1e3));
        }
        "backlash_position" if !has("knots") => {
            let [lo, hi] = axis.and_then(|a| scale.window.get(a)).map_or([-1.0, 1.0], |w| w.map(|v| kind.to_edge(v)));
            let knot = |p: f64, b: f64| Value::Sequence(vec![p.into(), b.into()]);
            let knots = vec![knot(lo, 0.6 * gap), knot(0.5 * (lo + hi), gap), knot(hi, 1.4 * gap)];
            map.insert("knots".into(), Value::Sequence(knots));
        }
        "hysteresis" => {
            put(joint_key("half_width"), gap);
            put(joint_key("presliding"), 5.0 * gap);
        }
        "joint_zero_offset" => put(joint_key("offset"), if kind == JointKind::Revolute { 0.01 } else { 0.05 }),
        "axis_coupling" => put("ratio".into(), 1e-4),
        "gravity_compliance" => match kind {
            JointKind::Revolute => put("compliance_deg_per_nm".into(), 2e-5),
            JointKind::Prismatic => put("compliance_mm_per_n".into(), 2e-5),
        },
        "link_error" if target.ends_with(".alpha") => put("delta_deg".into(), 0.005),
        "link_error" => put("delta_mm".into(), 0.1),
        "tool_error" if !(has("x_") || has("y_") || has("z_")) => {
            ["x_mm", "y_mm", "z_mm"].into_iter().for_each(|k| put(k.into(), 0.05));
        }
        "thermal_drift" => {
            if !(has("x_") || has("y_") || has("z_")) {
                ["x_mm", "y_mm", "z_mm"].into_iter().for_each(|k| put(k.into(), 0.03));
            }
            put("tau_s".into(), (0.5 * scale.duration_s).max(1.0));
        }
        "vibration" => {
            put("amplitude_um".into(), 10.0);
            put("frequency_hz".into(), 7.3);
            map.insert("direction".into(), Value::Sequence(vec![0.5.into(), 0.6.into(), 0.62.into()]));
        }
        "time_offset" => put("offset_s".into(), 0.01),
        _ => {}
    }
    map
}
