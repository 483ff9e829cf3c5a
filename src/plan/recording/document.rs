//! The plan as a document (`lostmotion/recording/1`), as words and as a program.

use super::{Options, Recording};
use crate::log::write;
use crate::numerics::normal::Z95;
use crate::plan::path::DECIMALS;
use crate::robot::{Joint, Robot};
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// The schema that the document names.
pub const SCHEMA: &str = "lostmotion/recording/1";

/// The program: `t_s` and a column per joint.
pub fn program(recording: &Recording, robot: &Robot) -> Vec<u8> {
    let mut out = b"t_s".to_vec();
    for joint in robot.axis_joints() {
        out.extend_from_slice(format!(",{}_{}", joint.name.to_lowercase(), joint.kind.unit()).as_bytes());
    }
    out.push(b'\n');
    for (t, row) in &recording.rows {
        write::number(&mut out, *t, DECIMALS);
        for (axis, v) in row.iter().enumerate() {
            out.push(b',');
            write::number(&mut out, robot.axis(axis).kind.to_user_unit(*v), DECIMALS);
        }
        out.push(b'\n');
    }
    out
}

fn significant(v: f64) -> Value {
    let rounded: f64 = format!("{v:.4e}").parse().unwrap_or(v);
    json!(rounded)
}

/// The document.
pub fn document(recording: &Recording, robot: &Robot, options: &Options) -> Value {
    let joints: Vec<Value> = recording
        .precision
        .iter()
        .map(|p| {
            let joint = robot.axis(p.axis);
            let unit = joint.kind.unit();
            let edge = |v: Option<f64>| v.map_or(Value::Null, |v| significant(joint.kind.to_user_unit(v)));
            let mut m = Map::new();
            m.insert("joint".into(), joint.name.clone().into());
            m.insert(format!("sigma_half_gap_{unit}"), edge(p.sigma));
            m.insert(format!("sigma_at_a_place_{unit}"), edge(p.sigma_at_a_place));
            m.insert("reversals".into(), p.reversals.into());
            m.insert("sensitivity_m".into(), significant(p.sensitivity_m));
            m.insert("reason".into(), p.reason.clone().into());
            Value::Object(m)
        })
        .collect();
    let pose: Vec<Value> =
        recording.pose.iter().enumerate().map(|(a, v)| significant(robot.axis(a).kind.to_user_unit(*v))).collect();
    json!({
        "schema": SCHEMA,
        "kind": recording.kind.name(),
        "robot": {"name": robot.name, "sha256": robot.fingerprint()},
        "instrument": options.instrument.name(),
        "noise_um": options.noise_m * 1e6,
        "rate_hz": options.rate_hz,
        "duration_s": (recording.duration_s * 100.0).round() / 100.0,
        "pose": pose,
        "joints": joints,
        "notes": recording.notes,
    })
}

/// The plan in words.
pub fn words(recording: &Recording, robot: &Robot, options: &Options) -> String {
    let minutes = recording.duration_s / 60.0;
    let mut text = format!(
        "{} program: {:.0} s ({minutes:.1} min), {}, noise {:.1} um, {:.1} rows a second\n",
        recording.kind.name(),
        recording.duration_s,
        options.instrument.name(),
        options.noise_m * 1e6,
        options.rate_hz
    );
    for p in &recording.precision {
        let joint = robot.axis(p.axis);
        let _ = match p.sigma {
            Some(s) => write!(
                text,
                "  {}: half gap within +- {} ({} {})",
                joint.name,
                shown(joint, Z95 * s),
                p.reversals,
                if p.sigma_at_a_place.is_some() { "places" } else { "reversals" }
            ),
            None => write!(text, "  {}: not determined", joint.name),
        };
        if let Some(s) = p.sigma_at_a_place {
            let _ = write!(text, ", at one place within +- {}", shown(joint, Z95 * s));
        }
        if let Some(reason) = &p.reason {
            let _ = write!(text, "; {reason}");
        }
        text.push('\n');
    }
    text
}

fn shown(joint: &Joint, v: f64) -> String {
    format!("{:.5} {}", joint.kind.to_user_unit(v), joint.kind.unit())
}
