//! The result as a `lostmotion/gaps/1` document: what every identification writes, and what the static test knows beyond it.

use super::polynomial::Fit;
use super::schedule::Schedule;
use super::summary::{Angle, NoiseFrom, Summary};
use super::{Found, JointTest};
use crate::gaps::document::{CurveFields, document as plain};
use crate::gaps::file::{extend, in_user_unit, keyed, keyed_list, number};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

/// What a registration reports about its dwells.
#[derive(Serialize)]
struct FrameFields {
    points: usize,
    points_rms_um: Value,
    points_dropped: usize,
    given: bool,
}

/// What a place says beyond its half gap.
#[derive(Serialize)]
struct PointFields {
    #[serde(flatten)]
    dropped: Option<Keyed<Value>>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    flagged: bool,
    #[serde(flatten)]
    schedule: Option<Keyed<Value>>,
    #[serde(flatten)]
    band: Option<Keyed<Value>>,
}

/// What a static test says of a joint beyond its gap.
#[derive(Serialize)]
struct JointFields<'a> {
    places: usize,
    cycles: Option<usize>,
    measured_by: &'static str,
    unpaired_dwells: usize,
    noise: NoiseFields,
    #[serde(skip_serializing_if = "Option::is_none")]
    creep: Option<CreepFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    varies: Option<VariesFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    curves: Option<CurvesFields<'a>>,
}

#[derive(Serialize)]
struct NoiseFields {
    #[serde(flatten)]
    sigma: Keyed<Value>,
    dof: Value,
    from: &'static str,
    #[serde(flatten)]
    sigma_in_dwells: Keyed<Value>,
}

#[derive(Serialize)]
struct CreepFields {
    probability: Value,
    pace_s: Value,
    pace_ci95_s: [Value; 2],
    #[serde(flatten)]
    at_stop: Keyed<Value>,
    #[serde(flatten)]
    at_end: Keyed<Value>,
    dwell_s: Value,
    needed_dwell_s: Value,
}

#[derive(Serialize)]
struct VariesFields {
    p_any_shape: Value,
    p_slope_and_bow: Option<Value>,
    level: f64,
}

#[derive(Serialize)]
struct CurvesFields<'a> {
    averaged: usize,
    polynomial_weight: Value,
    degree: &'a Option<usize>,
    lack_of_fit: Vec<FitFields>,
    few_parameters: CurveFields,
    few_knots: Option<KnotFields>,
    #[serde(flatten)]
    band: Keyed<Value>,
    band_is: &'static str,
}

#[derive(Serialize)]
struct KnotFields {
    knots: Vec<Value>,
    p_value: Value,
    weight: Value,
}

#[derive(Serialize)]
struct FitFields {
    degree: usize,
    #[serde(rename = "F")]
    f: Value,
    dof: [Value; 2],
    p_value: Value,
}

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "static".into();
    if let Some(f) = &found.frame {
        let fields = FrameFields {
            points: f.points,
            points_rms_um: number(f.points_rms_m * 1e6),
            points_dropped: f.dropped,
            given: f.given,
        };
        extend(&mut doc["registration"], &fields);
    }
    let mut point = 0;
    for (i, test) in found.joints.iter().enumerate() {
        let kind = robot.axis(test.axis).kind;
        for (k, angle) in test.summary.angles.iter().enumerate() {
            extend(&mut doc["points"][point], &point_fields(angle, test, k, kind));
            point += 1;
        }
        extend(&mut doc["joints"][i], &joint_fields(test, kind));
    }
    doc
}

fn point_fields(angle: &Angle, test: &JointTest, k: usize, kind: JointKind) -> PointFields {
    let schedule = test.schedule.as_ref();
    PointFields {
        dropped: (!angle.dropped.is_empty()).then(|| keyed_list("dropped", &angle.dropped, kind)),
        flagged: angle.flagged,
        schedule: schedule.map(|s| keyed("schedule", s.heights[k], kind)),
        band: schedule.map(|s| keyed("band", s.band[k], kind)),
    }
}

fn joint_fields(test: &JointTest, kind: JointKind) -> JointFields<'_> {
    let s = &test.summary;
    JointFields {
        places: s.angles.len(),
        cycles: s.angles.iter().map(|a| a.cycles.len()).max(),
        measured_by: if test.measured { "meas" } else { "tcp" },
        unpaired_dwells: test.unpaired,
        noise: noise(s, kind),
        creep: s.creep.as_ref().map(|c| CreepFields {
            probability: number(c.probability),
            pace_s: number(c.pace_s),
            pace_ci95_s: c.pace_ci95_s.map(number),
            at_stop: keyed("at_stop", c.at_stop, kind),
            at_end: keyed("at_end", c.at_end, kind),
            dwell_s: number(c.dwell_s),
            needed_dwell_s: number(c.needed_dwell_s),
        }),
        varies: s.gate.as_ref().map(|g| VariesFields {
            p_any_shape: number(g.p_any_shape),
            p_slope_and_bow: g.p_slope_and_bow.map(number),
            level: super::summary::ALPHA,
        }),
        curves: test.schedule.as_ref().map(|s| curves(s, kind)),
    }
}

fn noise(s: &Summary, kind: JointKind) -> NoiseFields {
    NoiseFields {
        sigma: keyed("sigma", s.noise.variance.sqrt(), kind),
        dof: number(s.noise.dof),
        from: match s.noise.from {
            NoiseFrom::Cycles => "cycles",
            NoiseFrom::Places => "places",
            NoiseFrom::Dwells => "dwells",
        },
        sigma_in_dwells: keyed("sigma_in_dwells", s.sigma_in_dwell, kind),
    }
}

fn curves(s: &Schedule, kind: JointKind) -> CurvesFields<'_> {
    CurvesFields {
        averaged: s.averaged,
        polynomial_weight: number(s.polynomial_weight),
        degree: &s.degree,
        lack_of_fit: s.polynomials.iter().map(fit).collect(),
        few_parameters: CurveFields::new(&s.few, kind),
        few_knots: s.readable.as_ref().map(|r| KnotFields {
            knots: r.knots.iter().map(|k| in_user_unit(k, kind)).collect(),
            p_value: number(r.p_value),
            weight: number(r.weight),
        }),
        band: keyed_list("band", &s.band, kind),
        band_is: "approximate, not pointwise",
    }
}

fn fit(fit: &Fit) -> FitFields {
    FitFields { degree: fit.degree, f: number(fit.f), dof: fit.dof.map(number), p_value: number(fit.p_value) }
}
