//! The plan as a document (`lostmotion/recording/1`), as words and as a program.

use super::{Note, Options, Reason, Recording};
use crate::gaps::file::NameAndHash;
use crate::io::keyed::Keyed;
use crate::log::write;
use crate::numerics::normal::Z95;
use crate::plan::path::DECIMALS;
use crate::robot::{Joint, Robot};
use serde::Serialize;
use serde_json::Value;
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

/// What `plan-experiment --for static` and the like print with `--json`.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    kind: &'static str,
    robot: NameAndHash,
    instrument: &'static str,
    noise_um: f64,
    rate_hz: f64,
    duration_s: f64,
    pose: Vec<f64>,
    joints: Vec<JointFields<'a>>,
    notes: &'a [Note],
}

/// The precision that a joint's gap will have.
#[derive(Serialize)]
struct JointFields<'a> {
    joint: &'a str,
    #[serde(flatten)]
    sigma_half_gap: Keyed<Option<f64>>,
    #[serde(flatten)]
    sigma_at_a_place: Keyed<Option<f64>>,
    reversals: usize,
    sensitivity_m: f64,
    reason: Option<Reason>,
}

fn significant(v: f64) -> f64 {
    format!("{v:.4e}").parse().unwrap_or(v)
}

/// The document.
pub fn document(recording: &Recording, robot: &Robot, options: &Options) -> Value {
    let edge = |axis: usize, v: f64| significant(robot.axis(axis).kind.to_user_unit(v));
    let joints = recording.precision.iter().map(|p| {
        let joint = robot.axis(p.axis);
        let figure = |name: &str, v: Option<f64>| Keyed::new(name, joint.kind.unit(), v.map(|v| edge(p.axis, v)));
        JointFields {
            joint: &joint.name,
            sigma_half_gap: figure("sigma_half_gap", p.sigma),
            sigma_at_a_place: figure("sigma_at_a_place", p.sigma_at_a_place),
            reversals: p.reversals,
            sensitivity_m: significant(p.sensitivity_m),
            reason: p.reason,
        }
    });
    let fields = Document {
        schema: SCHEMA,
        kind: recording.kind.name(),
        robot: NameAndHash::of_robot(robot),
        instrument: options.instrument.name(),
        noise_um: options.noise_m * 1e6,
        rate_hz: options.rate_hz,
        duration_s: (recording.duration_s * 100.0).round() / 100.0,
        pose: recording.pose.iter().enumerate().map(|(a, v)| edge(a, *v)).collect(),
        joints: joints.collect(),
        notes: &recording.notes,
    };
    serde_json::to_value(fields).unwrap_or_default()
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
    // the same log tells more or less to another method: dwells alone do not separate a gap from wind-up for `identify`
    text.push_str(match recording.kind {
        super::Kind::Static => "expected of `identify static`:\n",
        super::Kind::Path if options.bar_m.is_some() => "expected of `identify`:\n",
        super::Kind::Path => "expected of `identify path`:\n",
        super::Kind::Excitation => "expected of `identify path` (for `identify`, use it together with a static log):\n",
    });
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
