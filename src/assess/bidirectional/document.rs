//! The document `lostmotion/bidirectional/1` (contract, section 8): millimetres, micrometres; coefficients in micrometres over
//! millimetres to the power.

use super::data::Errors;
use super::degree::LackOfFit;
use super::equation::{self, um_per_mm, unit};
use super::terms::StateTest;
use super::{Assessment, Model, Pose};
use crate::gaps::file::number;
use serde_json::{Map, Value, json};

pub const SCHEMA: &str = "lostmotion/bidirectional/1";

fn um(m: f64) -> Value {
    number(m * 1e6)
}

fn um_or_null(m: Option<f64>) -> Value {
    m.map_or(Value::Null, um)
}

fn interval(ci: Option<[f64; 2]>) -> Value {
    ci.map_or(Value::Null, |c| c.iter().map(|v| um(*v)).collect())
}

impl Assessment {
    /// The document.
    pub fn to_json(&self) -> Value {
        json!({
            "schema": SCHEMA,
            "readings": {"name": self.file, "sha256": self.sha256, "used": self.used, "missing": self.missing},
            "significant_below_p": number(self.alpha),
            "poses": self.poses.iter().map(|p| self.pose(p)).collect::<Vec<_>>(),
            "line": self.lines.iter().map(|l| json!({
                "state": self.state(l.state),
                "backlash_um": um(l.mean_m),
                "ci95": interval(l.ci95_m),
                "t": l.t.map_or(Value::Null, number),
                "dof": number(l.dof),
                "p_value": l.p_value.map_or(Value::Null, number),
                "significant": l.p_value.is_some_and(|p| p < self.alpha),
                "half_offset_um": um(0.5 * l.mean_m),
                "repeatability_bidirectional_um": um_or_null(l.bidirectional_m),
                "repeatability_bidirectional_iso230_um": um_or_null(l.bidirectional_iso230_m),
                "poses_beyond_0": l.poses_beyond[0],
                "poses_with_interval": l.poses_beyond[1],
            })).collect::<Vec<_>>(),
            "model": self.model.as_ref().map_or(Value::Null, |m| self.model_json(m)),
            "notes": self.notes,
        })
    }

    fn state(&self, state: usize) -> Value {
        let level = |l: &super::state::Level| l.number.map_or_else(|| l.text.clone().into(), number);
        let pairs = self.states.names.iter().zip(&self.states.all[state]);
        Value::Object(pairs.map(|(n, l)| (n.clone(), level(l))).collect::<Map<_, _>>())
    }

    fn pose(&self, p: &Pose) -> Value {
        let mut one = Map::new();
        let mut put = |k: &str, v: Value| one.insert(k.into(), v);
        put("position_mm", number(p.position_m * 1e3));
        if !self.states.names.is_empty() {
            put("state", self.state(p.state));
        }
        put("backlash_um", um_or_null(p.backlash.map(|b| b.mean_m)));
        put("ci95", interval(p.backlash.and_then(|b| b.ci95_m)));
        put("repeatability_forward_um", um_or_null(p.forward.as_ref().and_then(|w| w.repeatability_m())));
        put("repeatability_backward_um", um_or_null(p.backward.as_ref().and_then(|w| w.repeatability_m())));
        put("repeatability_bidirectional_um", um_or_null(p.bidirectional_m(super::poses::COVERAGE)));
        put("repeatability_bidirectional_iso230_um", um_or_null(p.bidirectional_m(super::poses::COVERAGE_ISO230)));
        put("mean_forward_um", um_or_null(p.forward.as_ref().map(|w| w.mean_m)));
        put("mean_backward_um", um_or_null(p.backward.as_ref().map(|w| w.mean_m)));
        put("repeats_forward", p.forward.as_ref().map_or(0, |w| w.errors_m.len()).into());
        put("repeats_backward", p.backward.as_ref().map_or(0, |w| w.errors_m.len()).into());
        put("pairs", p.pairs_m.len().into());
        Value::Object(one)
    }

    fn model_json(&self, m: &Model) -> Value {
        let list = |ci: &[[f64; 2]]| -> Value {
            ci.iter().enumerate().map(|(k, c)| c.iter().map(|v| number(um_per_mm(*v, k))).collect::<Value>()).collect()
        };
        let numbers = |c: Vec<f64>| -> Value { c.into_iter().map(number).collect() };
        let curve = &m.blocks[0];
        let letters = m.blocks.len() - 1;
        let indicators: Vec<Value> = m.blocks[1..]
            .iter()
            .enumerate()
            .map(|(k, b)| {
                json!({
                    "letter": equation::indicator(k, letters),
                    "name": b.state.map_or(String::new(), |s| self.states.difference(s, m.reference)),
                    "coefficients": numbers(equation::coefficients(b)),
                    "ci95": list(&b.ci95),
                })
            })
            .collect();
        json!({
            "degree": m.degree,
            "degree_given": m.given,
            "adequate": m.adequate,
            "equation": equation::of(m),
            "coefficients": numbers(equation::coefficients(curve)),
            "units": (0..=m.degree).map(unit).collect::<Vec<_>>(),
            "ci95": list(&curve.ci95),
            "range_mm": m.range_m.iter().map(|v| number(v * 1e3)).collect::<Value>(),
            "reference": self.state(m.reference),
            "indicators": indicators,
            "errors": {
                "from": if m.scatter.from == Errors::Means { "means" } else { "readings" },
                "sigma_um": number(m.scatter.variance_m2.sqrt() * 1e6),
                "dof": number(m.scatter.dof),
            },
            "states": m.tests.iter().map(|t| self.student(m, t)).collect::<Vec<_>>(),
            "lack_of_fit": m.lack_of_fit.iter().map(lack_of_fit).collect::<Vec<_>>(),
            "lack_of_fit_all_states": m.all_states.as_ref().map_or(Value::Null, lack_of_fit),
            "varies_p_value": m.varies_p_value.map_or(Value::Null, number),
        })
    }

    fn student(&self, m: &Model, t: &StateTest) -> Value {
        json!({
            "name": self.states.difference(t.state, m.reference),
            "state": self.state(t.state),
            "order": t.order,
            "coefficient": number(um_per_mm(t.coefficient, t.order)),
            "unit": unit(t.order),
            "ci95": t.ci95.iter().map(|v| number(um_per_mm(*v, t.order))).collect::<Value>(),
            "t": number(t.t),
            "dof": number(t.dof),
            "t_critical": number(t.t_critical),
            "p_value": number(t.p_value),
            "significant": t.significant,
        })
    }
}

fn lack_of_fit(t: &LackOfFit) -> Value {
    let um2 = |m2: f64| number(m2 * 1e12);
    json!({
        "degree": t.degree,
        "F": number(t.f),
        "dof": t.dof.iter().map(|d| *d as u64).collect::<Vec<_>>(),
        "F_critical": number(t.f_critical),
        "p_value": number(t.p_value),
        "adequate": t.adequate,
        "sum_squares_um2": {"lack_of_fit": um2(t.lack_m2), "pure_error": um2(t.pure_m2), "residual": um2(t.lack_m2 + t.pure_m2)},
        "mean_squares_um2": {"lack_of_fit": um2(t.lack_m2 / t.dof[0]), "pure_error": um2(t.pure_m2 / t.dof[1])},
    })
}
