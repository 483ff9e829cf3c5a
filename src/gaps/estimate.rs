//! What a joint estimate over all logs of a machine adds to the gaps: friction's response, the scatter of single reversals,
//! trust, local evidence, covariance. Values are SI; the document holds degrees or millimetres, seconds, micrometres.
//!
//! In the document: `response`, `scatter`, `trust` and `agreement` of each joint, and at the top `reversals` and `covariance`. A
//! document without them is one of a single kind of test.

use crate::effects::response::{MOST_SPIKES, MOST_WINDUPS, Response, Spike, Windup};
use crate::gaps::values::{in_user_unit, keyed, number};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

/// The joint estimate of a machine.
#[derive(Debug, Clone, Default)]
pub struct Estimate {
    /// Estimates, one for each joint.
    pub joints: Vec<JointEstimate>,
    /// Distance from the path along each log with several moving joints, m rms: name, before, after compensation.
    pub predicted: Vec<(String, f64, f64)>,
    /// Each reversal by itself.
    pub reversals: Vec<LocalReversal>,
    /// Names of parameters, as `A1.windup_deg`, and their covariance in the units of the names.
    pub covariance: Option<(Vec<String>, Vec<Vec<f64>>)>,
}

/// What is known of a joint beside its gap.
#[derive(Debug, Clone)]
pub struct JointEstimate {
    /// Axis of the robot.
    pub axis: usize,
    /// Response of the joint after a reversal: wind-up and spikes.
    pub response: Response,
    /// 95 % intervals: presliding, the whole wind-up, gain of each spike.
    pub presliding_ci95: [f64; 2],
    /// 95 % interval of the wind-up, rad or m.
    pub windup_ci95: [f64; 2],
    /// 95 % interval of each spike, rad or m.
    pub spikes_ci95: Vec<[f64; 2]>,
    /// Standard deviation of a single reversal's lost motion, as a share of it.
    pub scatter: f64,
    /// Whether the estimate reduces the errors of the logs it was not fitted to.
    pub trust: Trust,
    /// The fit of all logs against the single reversals; `None` where too few of these can be judged.
    pub agreement: Option<Agreement>,
}

/// Lost motion after a reversal (half gap, spikes and wind-up together) by the fit of all logs, which a compensator uses, and by the single
/// reversals, each estimated from its window alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// By the fit of all logs, rad or m, with its 95 % interval.
    pub all_logs: f64,
    /// Its 95 % interval.
    pub all_logs_ci95: [f64; 2],
    /// By the single reversals, rad or m.
    pub single: f64,
    /// Its 95 % interval.
    pub single_ci95: [f64; 2],
    /// Whether they differ by no more than their uncertainties allow (95 %).
    pub agree: bool,
}

impl Agreement {
    /// Which of the two a compensator uses, and why.
    pub fn reason(&self) -> &'static str {
        if self.agree {
            "both agree; the fit of all logs also has the course of a stroke"
        } else {
            "they differ; the fit of all logs is used because it has the course of a stroke and every log, and `trust` tells by the single \
             reversals whether its offset helps"
        }
    }
}

/// What compensating a joint does, predicted on parts of the logs that were not fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// Whether the joint should be compensated.
    pub compensate: bool,
    /// Root mean square TCP error after the joint's reversals without and with compensation, m.
    pub before_m: f64,
    /// Error after reversals with compensation, m at the TCP.
    pub after_m: f64,
    /// Number of reversals that were judged.
    pub reversals: usize,
    /// Why.
    pub reason: Why,
}

/// Why a joint is compensated, or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Why {
    /// Compensation helps on parts of the logs that were not fitted.
    Helps,
    /// It helps in the mean of its reversals, which scatter too much to tell by how much.
    HelpsInTheMean,
    /// It does not help beyond doubt.
    NotBeyondDoubt,
    /// As much error is predicted with compensation as without it.
    NoLess,
    /// The lost motion may be zero: something else explains it as well.
    NotTold,
    /// No reversal of the joint can be judged.
    NoReversal,
    /// The lost motion of the joint hardly moves the TCP.
    TooSmall,
    /// Compensation of all joints together would not reduce the error along the paths of the logs.
    NothingGained,
    /// The words of a document by another version or by hand.
    Words(String),
}

impl Why {
    /// The reasons that have fixed words.
    const ALL: [Self; 8] = [
        Self::Helps,
        Self::HelpsInTheMean,
        Self::NotBeyondDoubt,
        Self::NoLess,
        Self::NotTold,
        Self::NoReversal,
        Self::TooSmall,
        Self::NothingGained,
    ];

    /// The reason in words.
    pub fn format_text(&self) -> &str {
        match self {
            Self::Helps => "helps on parts of the logs that were not fitted",
            Self::HelpsInTheMean => "helps in the mean of its reversals, which scatter too much to tell by how much",
            Self::NotBeyondDoubt => "does not help beyond doubt on parts of the logs that were not fitted",
            Self::NoLess => "would leave as much error after its reversals, which scatter too much",
            Self::NotTold => {
                "would take a lag of the servo or a late clock for lost motion, which one speed does not tell apart: record a second speed, or one that varies"
            }
            Self::NoReversal => "cannot be judged: none of its reversals is far enough from others and from dwells",
            Self::TooSmall => "moves the TCP by less than 0.5 um at its reversals, which is not worth an offset",
            Self::NothingGained => {
                "would not reduce the error along the paths of these logs: the model does not describe them"
            }
            Self::Words(words) => words,
        }
    }

    fn read(words: &str) -> Self {
        Self::ALL.into_iter().find(|w| w.format_text() == words).unwrap_or_else(|| Self::Words(words.into()))
    }
}

/// One reversal, estimated from a window around it alone.
#[derive(Debug, Clone)]
pub struct LocalReversal {
    /// Axis of the robot.
    pub axis: usize,
    /// Name of the log.
    pub log: String,
    /// Time of the reversal, s.
    pub t_s: f64,
    /// Command at the reversal, rad or m.
    pub at: f64,
    /// Lost motion of this reversal as a multiple of the model's value, with its standard error.
    pub ratio: f64,
    /// Standard error of `ratio`.
    pub sigma: f64,
    /// Whether the reversal contradicts the others of its joint.
    pub outlying: bool,
}

impl std::fmt::Display for Why {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.format_text())
    }
}

/// Fields of a joint in the document.
#[derive(Serialize)]
pub(super) struct JointFields<'a> {
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
    pub(super) fn new(e: &'a JointEstimate, kind: JointKind) -> Self {
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
pub(super) struct TopFields<'a> {
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
    pub(super) fn new(e: &'a Estimate, robot: &'a Robot) -> Self {
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

/// What is wrong with a joint's response; the words say what is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum BadResponse {
    #[error("a response with a presliding travel above 0")]
    Presliding,
    #[error("at most three wind-ups")]
    ManyWindups,
    #[error("wind-ups as pairs of a size and a presliding above 0")]
    Windup,
    #[error("at most three spikes")]
    ManySpikes,
    #[error("spikes as pairs of a gain and a decay above 0")]
    Spike,
}

/// A joint's fields as they stand in a document; `None` where there is no response.
pub(super) fn read_joint(axis: usize, kind: JointKind, v: &Value) -> Option<Result<JointEstimate, BadResponse>> {
    let r = v.get("response").filter(|r| !r.is_null())?;
    let (unit, si) = (kind.unit(), kind.si_per_user_unit());
    let finite = |v: Option<&Value>| v.and_then(Value::as_f64).filter(|x| x.is_finite());
    let pair = |v: Option<&Value>, about: f64| -> [f64; 2] {
        let list = v.and_then(Value::as_array).map(|a| a.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
        list.and_then(|l| <[f64; 2]>::try_from(l).ok()).map_or([about; 2], |p| p.map(|x| x * si))
    };
    let Some(presliding) = finite(r.get(format!("presliding_{unit}"))).filter(|x| *x > 0.0) else {
        return Some(Err(BadResponse::Presliding));
    };
    let mut windups = [Windup { half: 0.0, presliding: presliding * si }; MOST_WINDUPS];
    let listed = r.get("windups").and_then(Value::as_array).cloned().unwrap_or_default();
    if listed.len() > MOST_WINDUPS {
        return Some(Err(BadResponse::ManyWindups));
    }
    for (w, v) in windups.iter_mut().zip(&listed) {
        let (Some(half), Some(over)) = (finite(v.get(0)), finite(v.get(1)).filter(|p| *p > 0.0)) else {
            return Some(Err(BadResponse::Windup));
        };
        *w = Windup { half: half * si, presliding: over * si };
    }
    let windup = windups.iter().map(|w| w.half).sum::<f64>() / si;
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    let mut spikes_ci95 = vec![[0.0; 2]; MOST_SPIKES];
    let listed = r.get("spikes").and_then(Value::as_array).cloned().unwrap_or_default();
    if listed.len() > MOST_SPIKES {
        return Some(Err(BadResponse::ManySpikes));
    }
    for (k, s) in listed.iter().enumerate() {
        let (Some(gain), Some(decay_s)) = (finite(s.get(0)), finite(s.get(1)).filter(|d| *d > 0.0)) else {
            return Some(Err(BadResponse::Spike));
        };
        spikes[k] = Spike { gain: gain * si, decay_s };
        spikes_ci95[k] = pair(r.get("spikes_ci95").and_then(|c| c.get(k)), gain);
    }
    let t = v.get("trust");
    let of_trust = |key: &str| t.and_then(|t| t.get(key));
    let trust = Trust {
        compensate: of_trust("compensate").and_then(Value::as_bool).unwrap_or(true),
        before_m: finite(of_trust("before_um")).unwrap_or(0.0) * 1e-6,
        after_m: finite(of_trust("after_um")).unwrap_or(0.0) * 1e-6,
        reversals: finite(of_trust("reversals")).unwrap_or(0.0).max(0.0) as usize,
        reason: Why::read(of_trust("reason").and_then(Value::as_str).unwrap_or_default()),
    };
    let agreement = v.get("agreement").and_then(|a| {
        let all_logs = finite(a.get(format!("all_logs_{unit}")))?;
        let single = finite(a.get(format!("single_reversals_{unit}")))?;
        Some(Agreement {
            all_logs: all_logs * si,
            all_logs_ci95: pair(a.get("all_logs_ci95"), all_logs),
            single: single * si,
            single_ci95: pair(a.get("single_reversals_ci95"), single),
            agree: a.get("agree")?.as_bool()?,
        })
    });
    Some(Ok(JointEstimate {
        axis,
        response: Response { presliding: presliding * si, windups, spikes },
        presliding_ci95: pair(r.get("presliding_ci95"), presliding),
        windup_ci95: pair(r.get("windup_ci95"), windup),
        spikes_ci95,
        scatter: finite(v.get("scatter")).unwrap_or(0.0),
        trust,
        agreement,
    }))
}

/// Single reversals of a document; entries that cannot be read are passed over, as they decide nothing.
pub(super) fn read_reversals(v: &Value, robot: &Robot) -> Vec<LocalReversal> {
    let entry = |r: &Value| -> Option<LocalReversal> {
        let axis = robot.axis_named(r.get("joint")?.as_str()?)?;
        let kind = robot.axis(axis).kind;
        Some(LocalReversal {
            axis,
            log: r.get("log")?.as_str()?.to_string(),
            t_s: r.get("t_s")?.as_f64()?,
            at: r.get(format!("at_{}", kind.unit()))?.as_f64()? * kind.si_per_user_unit(),
            ratio: r.get("ratio")?.as_f64()?,
            sigma: r.get("sigma")?.as_f64()?,
            outlying: r.get("outlying")?.as_bool()?,
        })
    };
    v.get("reversals").and_then(Value::as_array).map(|a| a.iter().filter_map(entry).collect()).unwrap_or_default()
}

/// What a document predicts along its logs.
pub(super) fn read_predicted(v: &Value) -> Vec<(String, f64, f64)> {
    let entry = |p: &Value| {
        let um = |key: &str| p.get(key)?.as_f64().map(|x| x * 1e-6);
        Some((p.get("log")?.as_str()?.to_string(), um("before_um")?, um("after_um")?))
    };
    v.get("predicted").and_then(Value::as_array).map(|a| a.iter().filter_map(entry).collect()).unwrap_or_default()
}

/// The covariance of a document.
pub(super) fn read_covariance(v: &Value) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let c = v.get("covariance")?;
    let names: Vec<String> = serde_json::from_value(c.get("parameters")?.clone()).ok()?;
    let matrix: Vec<Vec<f64>> = serde_json::from_value(c.get("matrix")?.clone()).ok()?;
    (matrix.len() == names.len() && matrix.iter().all(|r| r.len() == names.len())).then_some((names, matrix))
}
