//! `bearing_wobble`: the axis of a joint tilts as it turns: all that it carries turns by a small angle about a fixed direction.
//!
//! The tilt is `amplitude * sin(cycles * q + phase)` about `direction`, a vector across the axis in the frame of the joint before
//! its own turn (z is the axis, x that of the DH frame); `q` is the command. A slide pitches or rolls in the same way along its
//! rail, with cycles per turn of its lead. Reference: ISO 230-7:2015 (axis of rotation: tilt error motion); Evans, Hocken, Estler
//! (1996), CIRP Annals 45(2).
//!
//! Parameters: amplitude at most 0.002 rad; cycles 0.05 to 10,000; phase within half a turn. Typical: 0.001 to 0.01 deg, 1 or 2
//! cycles. Action: replace or preload the bearing. No offset of one joint undoes it.

use super::common::*;
use super::site::within;
use crate::robot::Robot;
use nalgebra::{UnitQuaternion, Vector3};
use serde_yaml::{Mapping, Value};
use std::f64::consts::{PI, TAU};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "bearing_wobble",
    heading: "bearing wobble",
    stage: Stage::Link,
    family: Family::Ripple,
    acts_on: ActsOn::Joint,
    adds: "the axis tilts as its joint turns",
    equation: "rotation of everything after the joint by amplitude sin(cycles q + phase) about a direction perpendicular to the axis",
    reference: "ISO 230-7:2015; Evans, Hocken, Estler (1996), CIRP Annals 45(2)",
    parameters: &[
        ("amplitude_deg", "0 to 0.002 rad"),
        ("cycles_per_rev", "periods per turn (for a prismatic joint, per turn of its lead screw), 0.05 to 10,000"),
        ("phase_deg", "within half a turn either way"),
        (
            "direction",
            "[x, y, z] in the frame of the joint before its rotation; the component along the axis is ignored",
        ),
    ],
    confused_with: &["transmission_error", "link_error"],
    decide_by: "measure two reflectors far apart on the link after the joint while this joint alone turns: a wobble tilts them about another axis",
    action: "preload or replace the bearing; correct poses with a calibration that contains the wobble",
    undone: "nothing: it changes poses, not joint positions",
    special: Special::NONE,
    example: (
        "{effect: bearing_wobble, joint: A1, amplitude_deg: 0.004, cycles_per_rev: 6, phase_deg: 0, direction: [0, 1, 0]}",
        View::TcpOverTime,
    ),
    read,
    typical: |size| {
        let direction = Value::Sequence(vec![1.0.into(), 0.5.into(), 0.0.into()]);
        vec![
            ("amplitude_deg".into(), 0.003.into()),
            ("cycles_per_rev".into(), if size.is_revolute() { 2.0 } else { 0.1 }.into()),
            ("direction".into(), direction),
        ]
    },
    candidates: |survey, list| {
        for axis in survey.moving() {
            let turns = survey.axes[axis].travel / Site { robot: survey.robot, target: Target::Joint(axis) }.rev();
            // what does not make half a period is no wobble that a log tells from a bow
            for cycles in [1.0, 2.0, 3.0].into_iter().filter(|c| c * turns > 0.5 && survey.points) {
                list.push(wobble(survey.robot, axis, cycles));
            }
        }
    },
};

/// Amplitude in rad, periods per turn, phase in rad, direction across the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingWobble {
    /// Amplitude of the tilt, rad.
    pub amplitude_rad: f64,
    /// Periods per revolution of the joint.
    pub cycles_per_rev: f64,
    /// Phase at position 0, rad.
    pub phase_rad: f64,
    /// Unit vector across the axis about which the link tilts, in the x and y of the joint's frame.
    pub direction: [f64; 2],
}

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let without_lead = site.axis().is_some_and(|a| site.robot.axis(a).lead_m_per_rev.is_none());
    if !site.is_revolute() && without_lead {
        let found = format!("no `lead_mm_per_rev` of {} in the robot file", f.named());
        return Err(f.bad("", found, "the lead of the screw: cycles count its turns"));
    }
    let d = f.direction()?;
    let across = d.x.hypot(d.y);
    if across < 1e-6 {
        return Err(f.bad("direction", "a direction along the axis", "a direction across the axis, as [1, 0, 0]"));
    }
    Ok(BearingWobble {
        amplitude_rad: f.needed("amplitude_deg", 0.0)?.to_radians(),
        cycles_per_rev: f.above_0("cycles_per_rev")?,
        phase_rad: f.phase_rad()?,
        direction: [d.x / across, d.y / across],
    }
    .into())
}

/// Wobble of an axis at a number of cycles per turn: sine and cosine about x and y; built along the strongest direction.
pub fn wobble(robot: &Robot, axis: usize, cycles_per_rev: f64) -> Candidate {
    let along = move |x: f64, y: f64, phase_rad: f64| {
        let amplitude_rad = x.hypot(y);
        let direction = if amplitude_rad > 0.0 { [x / amplitude_rad, y / amplitude_rad] } else { [1.0, 0.0] };
        BearingWobble { amplitude_rad, cycles_per_rev, phase_rad, direction }
    };
    // coefficients: x sine, y sine, x cosine, y cosine
    Candidate::of_sizes(robot, Target::Joint(axis), &[1e-6; 4], move |c| match c[0] != 0.0 || c[1] != 0.0 {
        true => along(c[0], c[1], 0.0),
        false => along(c[2], c[3], 0.5 * PI),
    })
    .built_by(Target::Joint(axis), move |c| {
        let (s, k) = ([c[0], c[1]], [c[2], c[3]]);
        let dot = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[0] + a[1] * b[1];
        let phase = 0.5 * (2.0 * dot(&s, &k)).atan2(dot(&s, &s) - dot(&k, &k));
        let at = |i: usize| s[i] * phase.cos() + k[i] * phase.sin();
        along(at(0), at(1), phase)
    })
}

impl EffectType for BearingWobble {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    /// The coordinates of amplitude times direction, then cycles and phase.
    fn values(&self) -> Vec<f64> {
        let [x, y] = self.direction.map(|d| d * self.amplitude_rad);
        vec![x, y, self.cycles_per_rev, self.phase_rad]
    }

    fn with(&self, v: &[f64]) -> Effect {
        let amplitude_rad = v[0].hypot(v[1]);
        let direction = if amplitude_rad > 0.0 { [v[0] / amplitude_rad, v[1] / amplitude_rad] } else { self.direction };
        Self { amplitude_rad, cycles_per_rev: v[2], phase_rad: v[3], direction }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let tilt = |k: usize| Parameter::degrees(&format!("amplitude_deg[{k}]"), within(0.002), 0.003f64.to_radians());
        let cycles = Parameter::new("cycles_per_rev", 1.0, (0.05, 1e4), 2.0);
        vec![tilt(0), tilt(1), cycles, Parameter::degrees("phase_deg", within(PI), PI)]
    }

    fn write(&self, _site: &Site, entry: &mut Mapping) {
        entry.insert("amplitude_deg".into(), self.amplitude_rad.to_degrees().into());
        entry.insert("cycles_per_rev".into(), self.cycles_per_rev.into());
        entry.insert("phase_deg".into(), self.phase_rad.to_degrees().into());
        let [x, y] = self.direction;
        entry.insert("direction".into(), Value::Sequence(vec![x.into(), y.into(), 0.0.into()]));
    }

    fn displacement_m(&self, target: Target, row: &Row, point_m: &Vector3<f64>) -> Vector3<f64> {
        let Some(frame) = row.frame_of_axis(target) else { return Vector3::zeros() };
        let (q, rev) = (row.inputs.command(frame.axis)[row.index], row.inputs.rev(frame.axis));
        let tilt = self.amplitude_rad * (TAU * self.cycles_per_rev * q / rev + self.phase_rad).sin();
        let about = frame.fixed_x * self.direction[0] + frame.fixed_y * self.direction[1];
        let arm = point_m - frame.origin_m;
        UnitQuaternion::from_scaled_axis(about * tilt) * arm - arm
    }

    fn displaces(&self) -> bool {
        true
    }

    fn uses_frames(&self) -> bool {
        true
    }

    fn phase(&self) -> Option<usize> {
        Some(3)
    }

    fn magnitude(&self) -> f64 {
        self.amplitude_rad
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::moves_poses()
    }
}
