//! The document `lostmotion/bidirectional/1` (contract, section 8): millimetres, micrometres; coefficients in micrometres over
//! millimetres to the power. Fields stand in the order in which the document gives them.

use super::data::Errors;
use super::degree::LackOfFit;
use super::equation::{self, um_per_mm, unit};
use super::terms::StateTest;
use super::{Assessment, Line, Model, Note, Pose};
use crate::error::Result;
use crate::gaps::file::{number, value};
use serde::Serialize;
use serde_json::{Map, Value};

pub const SCHEMA: &str = "lostmotion/bidirectional/1";

#[derive(Serialize, schemars::JsonSchema)]
pub(crate) struct Document<'a> {
    schema: &'static str,
    readings: ReadingsJson<'a>,
    significant_below_p: Value,
    poses: Vec<PoseJson>,
    line: Vec<LineJson>,
    model: Option<ModelJson<'a>>,
    #[schemars(with = "Vec<String>")]
    notes: &'a [Note],
}

#[derive(Serialize, schemars::JsonSchema)]
struct ReadingsJson<'a> {
    name: &'a str,
    sha256: &'a str,
    used: usize,
    missing: usize,
}

/// Lost motion over the whole line, in one state.
#[derive(Serialize, schemars::JsonSchema)]
struct LineJson {
    state: Value,
    backlash_um: Value,
    ci95: Value,
    t: Value,
    dof: Value,
    p_value: Value,
    significant: bool,
    half_offset_um: Value,
    repeatability_bidirectional_um: Value,
    repeatability_bidirectional_iso230_um: Value,
    poses_beyond_0: usize,
    poses_with_interval: usize,
}

/// A position in one state.
#[derive(Serialize, schemars::JsonSchema)]
struct PoseJson {
    position_mm: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<Value>,
    backlash_um: Value,
    ci95: Value,
    repeatability_forward_um: Value,
    repeatability_backward_um: Value,
    repeatability_bidirectional_um: Value,
    repeatability_bidirectional_iso230_um: Value,
    mean_forward_um: Value,
    mean_backward_um: Value,
    repeats_forward: usize,
    repeats_backward: usize,
    pairs: usize,
}

/// The curve of lost motion over position and state.
#[derive(Serialize, schemars::JsonSchema)]
struct ModelJson<'a> {
    degree: usize,
    degree_given: bool,
    adequate: Option<bool>,
    equation: String,
    coefficients: Value,
    units: Vec<String>,
    ci95: Value,
    range_mm: Value,
    reference: Value,
    indicators: Vec<IndicatorJson>,
    errors: ErrorsJson<'a>,
    states: Vec<StateJson>,
    lack_of_fit: Vec<LackOfFitJson>,
    lack_of_fit_all_states: Option<LackOfFitJson>,
    varies_p_value: Value,
}

/// How a state differs from the reference.
#[derive(Serialize, schemars::JsonSchema)]
struct IndicatorJson {
    letter: String,
    name: String,
    coefficients: Value,
    ci95: Value,
}

#[derive(Serialize, schemars::JsonSchema)]
struct ErrorsJson<'a> {
    from: &'a str,
    sigma_um: Value,
    dof: Value,
}

/// Student's test of one coefficient of a state.
#[derive(Serialize, schemars::JsonSchema)]
struct StateJson {
    name: String,
    state: Value,
    order: usize,
    coefficient: Value,
    unit: String,
    ci95: Value,
    t: Value,
    dof: Value,
    t_critical: Value,
    p_value: Value,
    significant: bool,
}

/// Fisher's test of a degree.
#[derive(Serialize, schemars::JsonSchema)]
struct LackOfFitJson {
    degree: usize,
    #[serde(rename = "F")]
    f: Value,
    dof: Vec<u64>,
    #[serde(rename = "F_critical")]
    f_critical: Value,
    p_value: Value,
    adequate: bool,
    sum_squares_um2: Squares,
    mean_squares_um2: MeanSquares,
}

#[derive(Serialize, schemars::JsonSchema)]
struct Squares {
    lack_of_fit: Value,
    pure_error: Value,
    residual: Value,
}

#[derive(Serialize, schemars::JsonSchema)]
struct MeanSquares {
    lack_of_fit: Value,
    pure_error: Value,
}

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
    ///
    /// # Errors
    /// Internal, where it cannot be written as JSON.
    pub fn to_json(&self) -> Result<Value> {
        value(&Document {
            schema: SCHEMA,
            readings: ReadingsJson { name: &self.file, sha256: &self.sha256, used: self.used, missing: self.missing },
            significant_below_p: number(self.alpha),
            poses: self.poses.iter().map(|p| self.pose(p)).collect(),
            line: self.lines.iter().map(|l| self.line(l)).collect(),
            model: self.model.as_ref().map(|m| self.model_json(m)),
            notes: &self.notes,
        })
    }

    fn line(&self, l: &Line) -> LineJson {
        LineJson {
            state: self.state(l.state),
            backlash_um: um(l.mean_m),
            ci95: interval(l.ci95_m),
            t: l.t.map_or(Value::Null, number),
            dof: number(l.dof),
            p_value: l.p_value.map_or(Value::Null, number),
            significant: l.p_value.is_some_and(|p| p < self.alpha),
            half_offset_um: um(0.5 * l.mean_m),
            repeatability_bidirectional_um: um_or_null(l.bidirectional_m),
            repeatability_bidirectional_iso230_um: um_or_null(l.bidirectional_iso230_m),
            poses_beyond_0: l.poses_beyond[0],
            poses_with_interval: l.poses_beyond[1],
        }
    }

    fn state(&self, state: usize) -> Value {
        let level = |l: &super::state::Level| l.number.map_or_else(|| l.text.clone().into(), number);
        let pairs = self.states.names.iter().zip(&self.states.all[state]);
        Value::Object(pairs.map(|(n, l)| (n.clone(), level(l))).collect::<Map<_, _>>())
    }

    fn pose(&self, p: &Pose) -> PoseJson {
        let (forward, backward) = (p.forward.as_ref(), p.backward.as_ref());
        PoseJson {
            position_mm: number(p.position_m * 1e3),
            state: (!self.states.names.is_empty()).then(|| self.state(p.state)),
            backlash_um: um_or_null(p.backlash.map(|b| b.mean_m)),
            ci95: interval(p.backlash.and_then(|b| b.ci95_m)),
            repeatability_forward_um: um_or_null(forward.and_then(|w| w.repeatability_m())),
            repeatability_backward_um: um_or_null(backward.and_then(|w| w.repeatability_m())),
            repeatability_bidirectional_um: um_or_null(p.bidirectional_m(super::poses::COVERAGE)),
            repeatability_bidirectional_iso230_um: um_or_null(p.bidirectional_m(super::poses::COVERAGE_ISO230)),
            mean_forward_um: um_or_null(forward.map(|w| w.mean_m)),
            mean_backward_um: um_or_null(backward.map(|w| w.mean_m)),
            repeats_forward: forward.map_or(0, |w| w.errors_m.len()),
            repeats_backward: backward.map_or(0, |w| w.errors_m.len()),
            pairs: p.pairs_m.len(),
        }
    }

    fn model_json(&self, m: &Model) -> ModelJson<'static> {
        let list = |ci: &[[f64; 2]]| -> Value {
            ci.iter().enumerate().map(|(k, c)| c.iter().map(|v| number(um_per_mm(*v, k))).collect::<Value>()).collect()
        };
        let numbers = |c: Vec<f64>| -> Value { c.into_iter().map(number).collect() };
        let curve = &m.blocks[0];
        let letters = m.blocks.len() - 1;
        let indicator = |(k, b): (usize, &super::model::Block)| IndicatorJson {
            letter: equation::indicator(k, letters),
            name: b.state.map_or(String::new(), |s| self.states.difference(s, m.reference)),
            coefficients: numbers(equation::coefficients(b)),
            ci95: list(&b.ci95),
        };
        ModelJson {
            degree: m.degree,
            degree_given: m.given,
            adequate: m.adequate,
            equation: equation::of(m),
            coefficients: numbers(equation::coefficients(curve)),
            units: (0..=m.degree).map(unit).collect(),
            ci95: list(&curve.ci95),
            range_mm: m.range_m.iter().map(|v| number(v * 1e3)).collect(),
            reference: self.state(m.reference),
            indicators: m.blocks[1..].iter().enumerate().map(indicator).collect(),
            errors: ErrorsJson {
                from: if m.scatter.from == Errors::Means { "means" } else { "readings" },
                sigma_um: number(m.scatter.variance_m2.sqrt() * 1e6),
                dof: number(m.scatter.dof),
            },
            states: m.tests.iter().map(|t| self.student(m, t)).collect(),
            lack_of_fit: m.lack_of_fit.iter().map(lack_of_fit).collect(),
            lack_of_fit_all_states: m.all_states.as_ref().map(lack_of_fit),
            varies_p_value: m.varies_p_value.map_or(Value::Null, number),
        }
    }

    fn student(&self, m: &Model, t: &StateTest) -> StateJson {
        StateJson {
            name: self.states.difference(t.state, m.reference),
            state: self.state(t.state),
            order: t.order,
            coefficient: number(um_per_mm(t.coefficient, t.order)),
            unit: unit(t.order),
            ci95: t.ci95.iter().map(|v| number(um_per_mm(*v, t.order))).collect(),
            t: number(t.t),
            dof: number(t.dof),
            t_critical: number(t.t_critical),
            p_value: number(t.p_value),
            significant: t.significant,
        }
    }
}

fn lack_of_fit(t: &LackOfFit) -> LackOfFitJson {
    let um2 = |m2: f64| number(m2 * 1e12);
    LackOfFitJson {
        degree: t.degree,
        f: number(t.f),
        dof: t.dof.iter().map(|d| *d as u64).collect(),
        f_critical: number(t.f_critical),
        p_value: number(t.p_value),
        adequate: t.adequate,
        sum_squares_um2: Squares {
            lack_of_fit: um2(t.lack_m2),
            pure_error: um2(t.pure_m2),
            residual: um2(t.lack_m2 + t.pure_m2),
        },
        mean_squares_um2: MeanSquares { lack_of_fit: um2(t.lack_m2 / t.dof[0]), pure_error: um2(t.pure_m2 / t.dof[1]) },
    }
}
