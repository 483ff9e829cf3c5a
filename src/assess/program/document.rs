//! The document `lostmotion/program-assessment/1`.

use super::{Assessment, Figures};
use crate::robot::Robot;
use serde_json::{Map, Value, json};

pub const SCHEMA: &str = "lostmotion/program-assessment/1";

fn round(v: f64, decimals: i32) -> Value {
    let k = 10f64.powi(decimals);
    ((v * k).round() / k + 0.0).into()
}

fn um(m: f64) -> Value {
    round(m * 1e6, 3)
}

/// The figures alone, as `rewrite` reports them.
pub fn figures(f: &Figures) -> Value {
    let pair = |v: [f64; 2]| json!({"before": um(v[0]), "after": um(v[1])});
    json!({
        "rms_um": pair(f.rms_m),
        "mean_um": pair(f.mean_m),
        "largest_um": pair(f.largest_m),
        "worst_reversal_growth_um": um(f.worst_reversal_growth_m),
        "cycle_time_s": {"before": round(f.cycle_s[0], 6), "after": round(f.cycle_s[1], 6)},
        "points": {"before": f.points[0], "after": f.points[1]},
        "stops": {"before": f.stops[0], "after": f.stops[1]},
    })
}

impl Assessment {
    /// The document; micrometres are distances of the TCP to the reference path.
    pub fn to_json(&self, robot: &Robot) -> Value {
        let reversals: Vec<Value> = self
            .reversals
            .iter()
            .map(|r| {
                let joint = robot.axis(r.axis);
                let mut one = Map::new();
                one.insert("joint".into(), joint.name.clone().into());
                one.insert("t_s".into(), round(r.at_s, 4));
                one.insert(format!("command_{}", joint.kind.unit()), round(joint.kind.to_user_unit(r.command), 6));
                one.insert("direction".into(), r.direction.into());
                one.insert("before_um".into(), um(r.before_m));
                one.insert("after_um".into(), um(r.after_m));
                Value::Object(one)
            })
            .collect();
        let mut doc = json!({
            "schema": SCHEMA,
            "robot": {"name": robot.name, "sha256": robot.fingerprint()},
            "before": self.before.name,
            "after": self.after.name,
            "verdict": self.verdict.text(),
            "path_length_mm": round(self.before.length_m * 1e3, 4),
            "reversals": reversals,
            "notes": self.notes,
        });
        if let (Value::Object(doc), Value::Object(f)) = (&mut doc, figures(&self.figures)) {
            doc.extend(f);
        }
        doc
    }
}
