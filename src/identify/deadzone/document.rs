//! The result as a `lostmotion/gaps/1` document: what every identification writes, and what the sweeps know beyond it.

use super::Found;
use crate::gaps::file::{document as plain, in_user_unit, number};
use crate::robot::Robot;
use serde_json::{Value, json};

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "deadzone".into();
    let mut point = 0;
    for (i, sweeps) in found.joints.iter().enumerate() {
        let kind = robot.axis(sweeps.axis).kind;
        let unit = kind.unit();
        for d in &sweeps.deadzones {
            let p = &mut doc["points"][point];
            p[format!("from_{unit}")] = number(kind.to_user_unit(d.from));
            p[format!("to_{unit}")] = number(kind.to_user_unit(d.to));
            p[format!("deadzone_{unit}")] = number(kind.to_user_unit(d.size));
            p["t_s"] = number(d.t_s);
            p["log"] = d.log.into();
            p["line"] = d.line.into();
            point += 1;
        }
        let mean = sweeps.deadzones.iter().map(|d| d.size).sum::<f64>() / sweeps.deadzones.len().max(1) as f64;
        let joint = &mut doc["joints"][i];
        joint["deadzones"] = sweeps.deadzones.len().into();
        joint[format!("mean_deadzone_{unit}")] = number(kind.to_user_unit(mean));
        joint["turns"] = json!({
            "all": sweeps.turns,
            "inside_the_gap": sweeps.inside,
            "not_crossed": sweeps.not_crossed,
            "too_short": sweeps.too_short,
            "unseen": sweeps.unseen + sweeps.unfitted,
        });
        joint["noise_um"] = number(sweeps.noise_m * 1e6);
        joint["rest_um"] = number(sweeps.radius_m * 1e6);
        joint["scatter"] = number(sweeps.map.scatter);
        joint["scatter_p_value"] = sweeps.map.scatter_p_value.map_or(Value::Null, number);
        if !sweeps.map.band.is_empty() {
            joint[format!("band_{unit}")] = in_user_unit(&sweeps.map.band, kind);
        }
    }
    doc
}
