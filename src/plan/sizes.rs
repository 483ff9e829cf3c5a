//! Sizes at which effects matter, for those of which no size is known yet.
//!
//! Shop-floor magnitudes: a half gap of 0.003 deg or 5 um (Zhang (2023) measured 0.002 to 0.01 deg), a lag of 10 ms, 100 ppm of
//! a gear, 0.1 mm of a link. Where alternatives of a found effect are requested, lost motion is made as large as the found one,
//! with the transition so short that a log of common speed has no row in it: the hard case.

use crate::effects::{ActsOn, Effect, EffectInfo, EffectInstance, TypicalSize, catalogue, entry};
use crate::error::{Error, Result};
use crate::io::yaml::Document;
use crate::robot::{JointKind, Robot};
use serde_yaml::{Mapping, Value};

/// What a size leans on.
#[derive(Debug, Clone)]
pub struct Scale<'a> {
    /// The robot of the motion.
    pub robot: &'a Robot,
    /// Least and most of each axis in the experiment, rad or m.
    pub window: &'a [[f64; 2]],
    /// Speed of the TCP, m/s.
    pub speed_m_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Lost motion of a found effect, rad or m, by axis.
    pub lost: Vec<Option<f64>>,
}

/// Half of the lost motion that an effect makes at a reversal, rad or m.
pub fn lost_motion(effect: &Effect) -> Option<f64> {
    effect.largest_after_reversal().filter(|b| *b > 0.0)
}

/// Travel after a reversal over which an effect is in transition, rad or m.
pub fn transition(effect: &Effect) -> Option<f64> {
    effect.transition()
}

/// The effect `name` on `target` with the keys `given`; what is not given has its typical size.
pub fn placed(name: &str, target: &str, given: &Mapping, scale: &Scale, doc: &Document) -> Result<EffectInstance> {
    let info = catalogue::find(name);
    let mut map = info.map_or_else(Mapping::new, |i| typical(i, target, given, scale));
    for (k, v) in given {
        map.insert(k.clone(), v.clone());
    }
    map.insert("effect".into(), name.into());
    let key = if info.is_none_or(|i| i.acts_on == ActsOn::Joint) { "joint" } else { "target" };
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

fn typical(info: &EffectInfo, target: &str, given: &Mapping, scale: &Scale) -> Mapping {
    let joint = target.split(['<', '.']).next().unwrap_or_default().trim();
    let axis = scale.robot.axis_named(joint);
    let kind = axis.map_or(JointKind::Revolute, |a| scale.robot.axis(a).kind);
    let lost = axis.and_then(|a| scale.lost.get(a).copied().flatten());
    let size = TypicalSize {
        kind,
        target,
        gap: lost.map_or(if kind == JointKind::Revolute { 0.003 } else { 0.005 }, |b| kind.to_user_unit(b)),
        window: axis.and_then(|a| scale.window.get(a)).map_or([-1.0, 1.0], |w| w.map(|v| kind.to_user_unit(v))),
        tcp_speed_mm_s: scale.speed_m_s * 1e3,
        duration_s: scale.duration_s,
        given,
    };
    (info.typical)(&size).into_iter().map(|(k, v)| (Value::String(k), v)).collect()
}
