//! The document `lostmotion/circle/1` (contract, section 8): degrees, millimetres, micrometres.

use super::{Assessment, Measured, SMOOTHING_S, WINDOW_DEG};
use crate::robot::Robot;
use serde_json::{Map, Value, json};

pub const SCHEMA: &str = "lostmotion/circle/1";

impl Assessment {
    /// The document; `reduction` stands in both halves, null without a log after compensation.
    pub fn to_json(&self, robot: &Robot) -> Value {
        let n = &self.nominal;
        json!({
            "schema": SCHEMA,
            "robot": {"name": robot.name, "sha256": robot.fingerprint()},
            "nominal": {
                "radius_mm": round(n.circle.radius_m * 1e3, 6),
                "centre_mm": millimetres(&n.circle.centre_m),
                "normal": n.circle.normal.iter().map(|v| round(*v, 9)).collect::<Vec<_>>(),
                "revolutions": round(n.revolutions(), 6),
                "assessed_phase_deg": [round(n.from_deg, 4), round(n.to_deg, 4)],
                "chord_max_um": um(n.chord.in_plane_m.iter().zip(&n.chord.out_of_plane_m).map(|(a, b)| a.hypot(*b)).fold(0.0, f64::max)),
            },
            "smoothing_s": SMOOTHING_S,
            "window_deg": WINDOW_DEG,
            "before": self.half(robot, &self.before),
            "after": self.after.as_ref().map(|m| self.half(robot, m)),
            "histogram": {
                "bin_um": um(self.histogram.width_m),
                "before": self.histogram.before,
                "after": self.after.as_ref().map(|_| &self.histogram.after),
            },
            "notes": self.notes,
        })
    }

    fn half(&self, robot: &Robot, m: &Measured) -> Value {
        let mut half = Map::new();
        let mut put = |key: &str, value: Value| half.insert(key.into(), value);
        put("log", json!({"name": m.name, "sha256": m.sha256}));
        put("rows", m.rows.into());
        put("averaged_rows", m.averaged_rows.into());
        put("covered_phase_deg", json!(m.covered_deg.map(|v| round(v, 4))));
        put("registration_rms_um", um(m.registration_rms_m));
        put("radius_mm", round(m.circle.radius_m * 1e3, 6));
        put("centre_mm", json!(millimetres(&m.circle.centre_m)));
        for (name, max, rms) in [
            ("total", m.total_max_m, m.total_rms_m),
            ("in_plane", m.in_plane_max_m, m.in_plane_rms_m),
            ("out_of_plane", m.out_of_plane_max_m, m.out_of_plane_rms_m),
            ("beyond_nominal", m.beyond_nominal_max_m, m.beyond_nominal_rms_m),
        ] {
            put(&format!("{name}_max_um"), um(max));
            put(&format!("{name}_rms_um"), um(rms));
        }
        let reversals = m.reversals.iter().enumerate().map(|(i, e)| {
            let r = &self.nominal.reversals[i];
            let joint = robot.axis(r.axis);
            let mut one = Map::new();
            one.insert("joint".into(), joint.name.clone().into());
            one.insert("at_deg".into(), round(if r.at_deg < 359.99995 { r.at_deg } else { 0.0 }, 4));
            one.insert(format!("command_{}", joint.kind.unit()), round(joint.kind.to_user_unit(r.command), 6));
            one.insert("direction".into(), r.direction.into());
            one.insert("line".into(), r.line.into());
            one.insert("total_um".into(), optional(e.total_m.map(um)));
            one.insert("in_plane_um".into(), optional(e.in_plane_m.map(um)));
            one.insert("out_of_plane_um".into(), optional(e.out_of_plane_m.map(um)));
            one.insert("beyond_nominal_um".into(), optional(e.beyond_nominal_m.map(um)));
            one.insert("reduction".into(), optional(self.reduction(i).map(|v| round(v, 4))));
            one.insert(
                "reduction_beyond_nominal".into(),
                optional(self.reduction_beyond_nominal(i).map(|v| round(v, 4))),
            );
            Value::Object(one)
        });
        put("reversals", reversals.collect::<Vec<_>>().into());
        Value::Object(half)
    }
}

fn optional(v: Option<Value>) -> Value {
    v.unwrap_or(Value::Null)
}

/// Micrometres with a nanometre as the last digit.
fn um(m: f64) -> Value {
    round(m * 1e6, 3)
}

fn millimetres(p: &nalgebra::Vector3<f64>) -> Vec<Value> {
    p.iter().map(|v| round(v * 1e3, 6)).collect()
}

fn round(v: f64, decimals: i32) -> Value {
    let k = 10f64.powi(decimals);
    ((v * k).round() / k + 0.0).into()
}
