//! The joint estimate as fields of a document.

use super::{Agreement, Estimate, JointEstimate, LocalReversal};
use crate::effects::response::Spike;
use crate::gaps::values::{in_user_unit, keyed, number};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

/// Fields of a joint in the document.
#[derive(Serialize)]
pub(in crate::gaps) struct JointFields<'a> {
    response: ResponseFields,
    scatter: Value,
    trust: TrustFields<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    agreement: Option<AgreementFields>,
}

/// Lost motion by both estimates.
#[derive(Serialize)]
struct AgreementFields {
    #[serde(flatten)]
    all_logs: Keyed<Value>,
    all_logs_ci95: Value,
    #[serde(flatten)]
    single: Keyed<Value>,
    single_reversals_ci95: Value,
    agree: bool,
    used: &'static str,
    reason: &'static str,
}

impl AgreementFields {
    fn new(a: &Agreement, kind: JointKind) -> Self {
        Self {
            all_logs: keyed("all_logs", a.all_logs, kind),
            all_logs_ci95: in_user_unit(&a.all_logs_ci95, kind),
            single: keyed("single_reversals", a.single, kind),
            single_reversals_ci95: in_user_unit(&a.single_ci95, kind),
            agree: a.agree,
            used: "all_logs",
            reason: a.reason(),
        }
    }
}

#[derive(Serialize)]
struct ResponseFields {
    #[serde(flatten)]
    presliding: Keyed<Value>,
    presliding_ci95: Value,
    #[serde(flatten)]
    windup: Keyed<Value>,
    windup_ci95: Value,
    windups: Vec<[Value; 2]>,
    spikes: Vec<[Value; 2]>,
    spikes_ci95: Vec<Value>,
}

#[derive(Serialize)]
struct TrustFields<'a> {
    compensate: bool,
    before_um: Value,
    after_um: Value,
    reversals: usize,
    reason: &'a str,
}

impl<'a> JointFields<'a> {
    pub(in crate::gaps) fn new(e: &'a JointEstimate, kind: JointKind) -> Self {
        let t = &e.trust;
        Self {
            response: ResponseFields::new(e, kind),
            scatter: number(e.scatter),
            trust: TrustFields {
                compensate: t.compensate,
                before_um: number(t.before_m * 1e6),
                after_um: number(t.after_m * 1e6),
                reversals: t.reversals,
                reason: t.reason.format_text(),
            },
            agreement: e.agreement.as_ref().map(|a| AgreementFields::new(a, kind)),
        }
    }
}

impl ResponseFields {
    fn new(e: &JointEstimate, kind: JointKind) -> Self {
        let r = &e.response;
        let used: Vec<(&Spike, &[f64; 2])> =
            r.spikes.iter().zip(&e.spikes_ci95).filter(|(s, _)| s.gain != 0.0).collect();
        // the sum of the parts as they are written, so that the document stays the same when it is read and written again
        let halves = r.windups.iter().filter_map(|w| number(kind.to_user_unit(w.half)).as_f64());
        let wound = r.windups.iter().filter(|w| w.half != 0.0);
        Self {
            presliding: keyed("presliding", r.presliding, kind),
            presliding_ci95: in_user_unit(&e.presliding_ci95, kind),
            windup: Keyed::new("windup", kind.unit(), number(halves.sum())),
            windup_ci95: in_user_unit(&e.windup_ci95, kind),
            windups: wound.map(|w| [w.half, w.presliding].map(|v| number(kind.to_user_unit(v)))).collect(),
            spikes: used.iter().map(|(s, _)| [number(kind.to_user_unit(s.gain)), number(s.decay_s)]).collect(),
            spikes_ci95: used.iter().map(|(_, ci)| in_user_unit(*ci, kind)).collect(),
        }
    }
}

/// Fields at the top of the document.
#[derive(Serialize)]
pub(in crate::gaps) struct TopFields<'a> {
    predicted: Vec<PredictedFields<'a>>,
    reversals: Vec<ReversalFields<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    covariance: Option<CovarianceFields<'a>>,
}

#[derive(Serialize)]
struct PredictedFields<'a> {
    log: &'a str,
    before_um: Value,
    after_um: Value,
}

#[derive(Serialize)]
struct ReversalFields<'a> {
    joint: &'a str,
    log: &'a str,
    t_s: Value,
    #[serde(flatten)]
    at: Keyed<Value>,
    ratio: Value,
    sigma: Value,
    outlying: bool,
}

#[derive(Serialize)]
struct CovarianceFields<'a> {
    parameters: &'a [String],
    matrix: Vec<Vec<Value>>,
}

impl<'a> TopFields<'a> {
    pub(in crate::gaps) fn new(e: &'a Estimate, robot: &'a Robot) -> Self {
        let four = |v: f64| number((v * 1e4).round() / 1e4);
        let reversal = |r: &'a LocalReversal| {
            let joint = robot.axis(r.axis);
            ReversalFields {
                joint: &joint.name,
                log: &r.log,
                t_s: number((r.t_s * 1e3).round() / 1e3),
                at: Keyed::new("at", joint.kind.unit(), four(joint.kind.to_user_unit(r.at))),
                ratio: four(r.ratio),
                sigma: four(r.sigma),
                outlying: r.outlying,
            }
        };
        let um = |m: f64| number(m * 1e6);
        let predicted = |(log, before, after): &'a (String, f64, f64)| PredictedFields {
            log,
            before_um: um(*before),
            after_um: um(*after),
        };
        let short = |v: &f64| number(format!("{v:.4e}").parse().unwrap_or(*v));
        Self {
            predicted: e.predicted.iter().map(predicted).collect(),
            reversals: e.reversals.iter().map(reversal).collect(),
            covariance: e.covariance.as_ref().map(|(parameters, matrix)| CovarianceFields {
                parameters,
                matrix: matrix.iter().map(|row| row.iter().map(short).collect()).collect(),
            }),
        }
    }
}
