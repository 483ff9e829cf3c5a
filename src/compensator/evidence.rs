//! The `evidence` of a compensator file: what the offsets are based on.

use super::file::{Spot, read_joint, write_joint};
use super::schedule::{shown, tidy};
use super::{Evidence, JointEvidence, Note, Predicted, Replaced, RunLeft};
use crate::error::{Error, Result};
use crate::gaps::LogRef;
use crate::io::yaml::Document;
use crate::robot::Robot;
use serde::{Deserialize, Serialize};
use serde_yaml::{Mapping, Value};

#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct EvidenceFile {
    #[serde(default)]
    logs: Vec<LogFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tcp_speed_mm_s: Option<f64>,
    #[serde(default)]
    joints: Mapping,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    predicted: Vec<PredictedFile>,
    #[serde(default)]
    notes: Vec<Note>,
}

#[derive(Debug, Serialize, Deserialize)]
struct PredictedFile {
    log: String,
    before_um: f64,
    after_um: f64,
}

impl PredictedFile {
    fn of(p: &Predicted) -> Self {
        Self { log: p.log.clone(), before_um: tidy(p.before_m * 1e6), after_um: tidy(p.after_m * 1e6) }
    }

    fn read(self) -> Option<Predicted> {
        let known = [self.before_um, self.after_um].iter().all(|v| v.is_finite() && *v >= 0.0);
        known.then_some(Predicted { log: self.log, before_m: self.before_um * 1e-6, after_m: self.after_um * 1e-6 })
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct LogFile {
    name: String,
    #[serde(default)]
    sha256: String,
}

pub(super) fn read(value: &Value, robot: &Robot, doc: &Document) -> Result<Evidence> {
    if value.is_null() {
        return Ok(Evidence::default());
    }
    let file: EvidenceFile = serde_yaml::from_value(value.clone()).map_err(|e| {
        Error::bad(doc.place(&["evidence"]), e.to_string(), "evidence as `fit` writes it, or no evidence")
    })?;
    if let Some(v) = file.tcp_speed_mm_s
        && !(v.is_finite() && v > 0.0)
    {
        return Err(Error::bad(doc.place(&["tcp_speed_mm_s"]), format!("{v}"), "a finite speed above 0"));
    }
    let mut joints = Vec::new();
    for (key, v) in &file.joints {
        let Some(axis) = robot.axis_named(&shown(key)) else { continue };
        let kind = robot.axis(axis).kind;
        let (unit, si) = (kind.unit(), kind.si_per_user_unit());
        let pair = |k: String, scale: f64| -> Option<[f64; 2]> {
            let p: [f64; 2] = serde_yaml::from_value(v.get(k.as_str())?.clone()).ok()?;
            Some(p.map(|x| x * scale))
        };
        let number = |k: String| v.get(k.as_str()).and_then(Value::as_f64).map(|x| x * si);
        let replaced = match v.get(REPLACED) {
            None => None,
            Some(old) => replaced(axis, old, robot, doc, &shown(key))?,
        };
        joints.push(JointEvidence {
            axis,
            run: v.get("run").and_then(read_run),
            replaced,
            proved: v.get(PROVED).and_then(Value::as_bool).unwrap_or(false),
            half_gap_ci95: pair(format!("half_gap_{unit}_ci95"), si),
            gain_ci95: pair(format!("gain_{unit}_ci95"), si),
            decay_s_ci95: pair("decay_s_ci95".into(), 1.0),
            largest_before: number(format!("largest_before_{unit}")),
            largest_after: number(format!("largest_after_{unit}")),
        });
    }
    Ok(Evidence {
        logs: file.logs.into_iter().map(|l| LogRef { name: l.name, sha256: l.sha256 }).collect(),
        tcp_speed_m_s: file.tcp_speed_mm_s.map(|v| v * 1e-3),
        valid_until: None,
        joints,
        predicted: file.predicted.into_iter().filter_map(PredictedFile::read).collect(),
        notes: file.notes,
    })
}

/// Key of a joint that is compensated whatever the interval of its half gap.
const PROVED: &str = "proved";
/// Key of the offsets that the last correction replaced.
const REPLACED: &str = "replaced";
/// Square micrometres in a square metre.
const UM2: f64 = 1e12;

fn read_run(v: &Value) -> Option<RunLeft> {
    let number = |k: &str| v.get(k).and_then(Value::as_f64).filter(|x| x.is_finite());
    let reversals = v.get("reversals").and_then(Value::as_u64)? as usize;
    let sigma = number("left_um2_se").filter(|s| *s >= 0.0)?;
    Some(RunLeft { left_m2: number("left_um2")? / UM2, sigma_m2: sigma / UM2, reversals })
}

fn write_run(r: &RunLeft) -> Mapping {
    let entries: [(&str, Value); 3] = [
        ("left_um2", tidy(r.left_m2 * UM2).into()),
        ("left_um2_se", tidy(r.sigma_m2 * UM2).into()),
        ("reversals", r.reversals.into()),
    ];
    entries.into_iter().map(|(k, v)| (k.into(), v)).collect()
}

/// Offsets that may come back are checked like those that stand in `joints`.
fn replaced(axis: usize, v: &Value, robot: &Robot, doc: &Document, name: &str) -> Result<Option<Replaced>> {
    let Some(run) = v.get("run").and_then(read_run) else { return Ok(None) };
    let offsets = match v.get("offsets") {
        None => None,
        Some(old) => {
            let at = Spot { doc, path: vec!["evidence", "joints", name, REPLACED, "offsets"] };
            Some(read_joint(axis, old, robot.axis(axis), &at)?)
        }
    };
    Ok(Some(Replaced { offsets, run }))
}

pub(super) fn write(e: &Evidence, robot: &Robot) -> EvidenceFile {
    let mut joints = Mapping::new();
    for j in &e.joints {
        let joint = robot.axis(j.axis);
        let unit = joint.kind.unit();
        let edge = |v: f64| Value::from(tidy(joint.kind.to_user_unit(v)));
        let mut map = Mapping::new();
        let pair = |p: [f64; 2]| Value::Sequence(p.iter().map(|&v| edge(v)).collect());
        let entries = [
            (format!("half_gap_{unit}_ci95"), j.half_gap_ci95.map(pair)),
            (format!("gain_{unit}_ci95"), j.gain_ci95.map(pair)),
            ("decay_s_ci95".into(), j.decay_s_ci95.map(|p| Value::Sequence(p.map(|v| tidy(v).into()).into()))),
            (format!("largest_before_{unit}"), j.largest_before.map(edge)),
            (format!("largest_after_{unit}"), j.largest_after.map(edge)),
        ];
        for (key, value) in entries {
            if let Some(v) = value {
                map.insert(key.into(), v);
            }
        }
        if j.proved {
            map.insert(PROVED.into(), true.into());
        }
        if let Some(run) = &j.run {
            map.insert("run".into(), write_run(run).into());
        }
        if let Some(old) = &j.replaced {
            let mut entry = Mapping::new();
            entry.insert("run".into(), write_run(&old.run).into());
            if let Some(offsets) = &old.offsets {
                entry.insert("offsets".into(), write_joint(offsets, joint).into());
            }
            map.insert(REPLACED.into(), entry.into());
        }
        joints.insert(joint.name.clone().into(), Value::Mapping(map));
    }
    EvidenceFile {
        logs: e.logs.iter().map(|l| LogFile { name: l.name.clone(), sha256: l.sha256.clone() }).collect(),
        tcp_speed_mm_s: e.tcp_speed_m_s.map(|v| tidy(v * 1e3)),
        joints,
        predicted: e.predicted.iter().map(PredictedFile::of).collect(),
        notes: e.notes.clone(),
    }
}
