//! The result as a `lostmotion/gaps/1` document: what every identification writes, and what the static test knows beyond it.

use super::polynomial::Fit;
use super::schedule::Schedule;
use super::summary::NoiseFrom;
use super::{Found, JointTest};
use crate::gaps::file::{curve, document as plain, in_user_unit, number};
use crate::robot::{JointKind, Robot};
use serde_json::{Value, json};

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "static".into();
    if let Some(f) = &found.frame {
        let r = &mut doc["registration"];
        r["points"] = f.points.into();
        r["points_rms_um"] = number(f.points_rms_m * 1e6);
        r["points_dropped"] = f.dropped.into();
        r["given"] = f.given.into();
    }
    let mut point = 0;
    for (i, test) in found.joints.iter().enumerate() {
        let kind = robot.axis(test.axis).kind;
        let unit = kind.unit();
        for (k, angle) in test.summary.angles.iter().enumerate() {
            let p = &mut doc["points"][point];
            if !angle.dropped.is_empty() {
                p[format!("dropped_{unit}")] = in_user_unit(&angle.dropped, kind);
            }
            if angle.flagged {
                p["flagged"] = true.into();
            }
            if let Some(s) = &test.schedule {
                p[format!("schedule_{unit}")] = number(kind.to_user_unit(s.heights[k]));
                p[format!("band_{unit}")] = number(kind.to_user_unit(s.band[k]));
            }
            point += 1;
        }
        write_joint(test, kind, &mut doc["joints"][i]);
    }
    doc
}

/// What a static test says of a joint beyond its gap.
fn write_joint(test: &JointTest, kind: JointKind, joint: &mut Value) {
    let unit = kind.unit();
    let s = &test.summary;
    joint["places"] = s.angles.len().into();
    joint["cycles"] = s.angles.iter().map(|a| a.cycles.len()).max().into();
    joint["measured_by"] = if test.measured { "meas" } else { "tcp" }.into();
    joint["unpaired_dwells"] = test.unpaired.into();
    joint["noise"] = json!({
        format!("sigma_{unit}"): number(kind.to_user_unit(s.noise.variance.sqrt())),
        "dof": number(s.noise.dof),
        "from": match s.noise.from {
            NoiseFrom::Cycles => "cycles",
            NoiseFrom::Places => "places",
            NoiseFrom::Dwells => "dwells",
        },
        format!("sigma_in_dwells_{unit}"): number(kind.to_user_unit(s.sigma_in_dwell)),
    });
    if let Some(c) = &s.creep {
        joint["creep"] = json!({
            "probability": number(c.probability),
            "pace_s": number(c.pace_s),
            "pace_ci95_s": c.pace_ci95_s.map(number),
            format!("at_stop_{unit}"): number(kind.to_user_unit(c.at_stop)),
            format!("at_end_{unit}"): number(kind.to_user_unit(c.at_end)),
            "dwell_s": number(c.dwell_s),
            "needed_dwell_s": number(c.needed_dwell_s),
        });
    }
    if let Some(g) = &s.gate {
        joint["varies"] = json!({
            "p_any_shape": number(g.p_any_shape),
            "p_slope_and_bow": g.p_slope_and_bow.map(number),
            "level": super::summary::ALPHA,
        });
    }
    if let Some(schedule) = &test.schedule {
        joint["curves"] = curves(schedule, kind);
    }
}

fn curves(s: &Schedule, kind: JointKind) -> Value {
    let unit = kind.unit();
    let table: Value = s.polynomials.iter().map(row).collect();
    json!({
        "averaged": s.averaged,
        "polynomial_weight": number(s.polynomial_weight),
        "degree": s.degree,
        "lack_of_fit": table,
        "few_parameters": curve(&s.few, kind),
        "few_knots": s.readable.as_ref().map(|r| json!({
            "knots": r.knots.iter().map(|k| in_user_unit(k, kind)).collect::<Value>(),
            "p_value": number(r.p_value),
            "weight": number(r.weight),
        })),
        format!("band_{unit}"): in_user_unit(&s.band, kind),
        "band_is": "approximate, not pointwise",
    })
}

fn row(fit: &Fit) -> Value {
    json!({
        "degree": fit.degree,
        "F": number(fit.f),
        "dof": fit.dof.map(number),
        "p_value": number(fit.p_value),
    })
}
