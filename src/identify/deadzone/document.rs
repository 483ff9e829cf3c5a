//! The result as a `lostmotion/gaps/1` document: what every identification writes, and what the sweeps know beyond it.

use super::{Deadzone, Found, JointSweeps};
use crate::gaps::document::document as plain;
use crate::gaps::file::{extend, keyed, keyed_list, number};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

/// What a point says beyond its half gap.
#[derive(Serialize)]
struct PointFields {
    #[serde(flatten)]
    from: Keyed<Value>,
    #[serde(flatten)]
    to: Keyed<Value>,
    #[serde(flatten)]
    deadzone: Keyed<Value>,
    t_s: Value,
    log: usize,
    line: u32,
}

/// What the sweeps say of a joint beyond its half gap.
#[derive(Serialize)]
struct JointFields {
    deadzones: usize,
    #[serde(flatten)]
    mean_deadzone: Keyed<Value>,
    turns: Turns,
    noise_um: Value,
    rest_um: Value,
    scatter: Value,
    scatter_p_value: Option<Value>,
    #[serde(flatten)]
    band: Option<Keyed<Value>>,
}

/// Turns of the command, and why some have no deadzone.
#[derive(Serialize)]
struct Turns {
    all: usize,
    inside_the_gap: usize,
    not_crossed: usize,
    too_short: usize,
    unseen: usize,
}

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "deadzone".into();
    let mut point = 0;
    for (i, sweeps) in found.joints.iter().enumerate() {
        let kind = robot.axis(sweeps.axis).kind;
        for d in &sweeps.deadzones {
            extend(&mut doc["points"][point], &point_fields(d, kind));
            point += 1;
        }
        extend(&mut doc["joints"][i], &joint_fields(sweeps, kind));
    }
    doc
}

fn point_fields(d: &Deadzone, kind: JointKind) -> PointFields {
    PointFields {
        from: keyed("from", d.from, kind),
        to: keyed("to", d.to, kind),
        deadzone: keyed("deadzone", d.size, kind),
        t_s: number(d.t_s),
        log: d.log,
        line: d.line,
    }
}

fn joint_fields(sweeps: &JointSweeps, kind: JointKind) -> JointFields {
    let mean = sweeps.deadzones.iter().map(|d| d.size).sum::<f64>() / sweeps.deadzones.len().max(1) as f64;
    let map = &sweeps.map;
    JointFields {
        deadzones: sweeps.deadzones.len(),
        mean_deadzone: keyed("mean_deadzone", mean, kind),
        turns: Turns {
            all: sweeps.turns,
            inside_the_gap: sweeps.inside,
            not_crossed: sweeps.not_crossed,
            too_short: sweeps.too_short,
            unseen: sweeps.unseen + sweeps.unfitted,
        },
        noise_um: number(sweeps.noise_m * 1e6),
        rest_um: number(sweeps.radius_m * 1e6),
        scatter: number(map.scatter),
        scatter_p_value: map.scatter_p_value.map(number),
        band: (!map.band.is_empty()).then(|| keyed_list("band", &map.band, kind)),
    }
}
