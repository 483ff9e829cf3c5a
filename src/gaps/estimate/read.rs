//! The joint estimate from the fields of a document.

use super::{Agreement, JointEstimate, LocalReversal, Trust, Why};
use crate::effects::response::{MOST_SPIKES, MOST_WINDUPS, Response, Spike, Windup};
use crate::robot::{JointKind, Robot};
use serde_json::Value;

/// What is wrong with a joint's response; the words say what is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(in crate::gaps) enum BadResponse {
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

/// A number of a document; `None` where it is none, or not finite.
fn finite(v: Option<&Value>) -> Option<f64> {
    v.and_then(Value::as_f64).filter(|x| x.is_finite())
}

/// An interval of a document, times `si`; where there is none, `about` at both ends as it is.
fn interval(v: Option<&Value>, about: f64, si: f64) -> [f64; 2] {
    let list = v.and_then(Value::as_array).map(|a| a.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
    list.and_then(|l| <[f64; 2]>::try_from(l).ok()).map_or([about; 2], |p| p.map(|x| x * si))
}

/// A joint's fields as they stand in a document; `None` where there is no response.
pub(in crate::gaps) fn read_joint(
    axis: usize,
    kind: JointKind,
    v: &Value,
) -> Option<Result<JointEstimate, BadResponse>> {
    let response = v.get("response").filter(|r| !r.is_null())?;
    Some(with_response(axis, kind, v, response))
}

fn with_response(axis: usize, kind: JointKind, v: &Value, r: &Value) -> Result<JointEstimate, BadResponse> {
    let (unit, si) = (kind.unit(), kind.si_per_user_unit());
    let presliding = finite(r.get(format!("presliding_{unit}"))).filter(|x| *x > 0.0).ok_or(BadResponse::Presliding)?;
    let mut windups = [Windup { half: 0.0, presliding: presliding * si }; MOST_WINDUPS];
    let listed = r.get("windups").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    if listed.len() > MOST_WINDUPS {
        return Err(BadResponse::ManyWindups);
    }
    for (w, v) in windups.iter_mut().zip(listed) {
        let (Some(half), Some(over)) = (finite(v.get(0)), finite(v.get(1)).filter(|p| *p > 0.0)) else {
            return Err(BadResponse::Windup);
        };
        *w = Windup { half: half * si, presliding: over * si };
    }
    let windup = windups.iter().map(|w| w.half).sum::<f64>() / si;
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    let mut spikes_ci95 = vec![[0.0; 2]; MOST_SPIKES];
    let listed = r.get("spikes").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    if listed.len() > MOST_SPIKES {
        return Err(BadResponse::ManySpikes);
    }
    for (k, s) in listed.iter().enumerate() {
        let (Some(gain), Some(decay_s)) = (finite(s.get(0)), finite(s.get(1)).filter(|d| *d > 0.0)) else {
            return Err(BadResponse::Spike);
        };
        spikes[k] = Spike { gain: gain * si, decay_s };
        spikes_ci95[k] = interval(r.get("spikes_ci95").and_then(|c| c.get(k)), gain, si);
    }
    Ok(JointEstimate {
        axis,
        response: Response { presliding: presliding * si, windups, spikes },
        presliding_ci95: interval(r.get("presliding_ci95"), presliding, si),
        windup_ci95: interval(r.get("windup_ci95"), windup, si),
        spikes_ci95,
        scatter: finite(v.get("scatter")).unwrap_or(0.0),
        trust: read_trust(v.get("trust")),
        agreement: v.get("agreement").and_then(|a| read_agreement(a, kind)),
    })
}

/// Whether a joint is to be compensated; a document that does not say so has it compensated.
fn read_trust(t: Option<&Value>) -> Trust {
    let of = |key: &str| t.and_then(|t| t.get(key));
    Trust {
        compensate: of("compensate").and_then(Value::as_bool).unwrap_or(true),
        before_m: finite(of("before_um")).unwrap_or(0.0) * 1e-6,
        after_m: finite(of("after_um")).unwrap_or(0.0) * 1e-6,
        reversals: finite(of("reversals")).unwrap_or(0.0).max(0.0) as usize,
        reason: Why::read(of("reason").and_then(Value::as_str).unwrap_or_default()),
    }
}

fn read_agreement(a: &Value, kind: JointKind) -> Option<Agreement> {
    let (unit, si) = (kind.unit(), kind.si_per_user_unit());
    let all_logs = finite(a.get(format!("all_logs_{unit}")))?;
    let single = finite(a.get(format!("single_reversals_{unit}")))?;
    Some(Agreement {
        all_logs: all_logs * si,
        all_logs_ci95: interval(a.get("all_logs_ci95"), all_logs, si),
        single: single * si,
        single_ci95: interval(a.get("single_reversals_ci95"), single, si),
        agree: a.get("agree")?.as_bool()?,
    })
}

/// Single reversals of a document; entries that cannot be read are passed over, as they decide nothing.
pub(in crate::gaps) fn read_reversals(v: &Value, robot: &Robot) -> Vec<LocalReversal> {
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
pub(in crate::gaps) fn read_predicted(v: &Value) -> Vec<(String, f64, f64)> {
    let entry = |p: &Value| {
        let um = |key: &str| p.get(key)?.as_f64().map(|x| x * 1e-6);
        Some((p.get("log")?.as_str()?.to_string(), um("before_um")?, um("after_um")?))
    };
    v.get("predicted").and_then(Value::as_array).map(|a| a.iter().filter_map(entry).collect()).unwrap_or_default()
}

/// The covariance of a document.
pub(in crate::gaps) fn read_covariance(v: &Value) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let c = v.get("covariance")?;
    let names: Vec<String> = serde_json::from_value(c.get("parameters")?.clone()).ok()?;
    let matrix: Vec<Vec<f64>> = serde_json::from_value(c.get("matrix")?.clone()).ok()?;
    (matrix.len() == names.len() && matrix.iter().all(|r| r.len() == names.len())).then_some((names, matrix))
}
