//! `transmission_error`: the gear leads and trails periodically: adds `amplitude * sin(cycles * p + phase)`.
//!
//! `cycles` counts periods per turn of the joint, or per turn of the screw of a prismatic joint (its lead). It acts on the
//! signal that arrives. Parameters: amplitude 0 or more, and such that the joint does not turn back (`amplitude * cycles < 1`
//! rad); cycles above 0; phase within half a turn either way. Action: service the gear (a tooth, the wave generator); an
//! offset of the negative undoes it.

use super::site::within;
use super::*;
use crate::robot::{JointKind, Robot};
use std::f64::consts::{PI, TAU};

pub static INFO: EffectInfo = EffectInfo {
    name: "transmission_error",
    heading: "transmission error",
    stage: Stage::Gear,
    family: Family::Ripple,
    acts_on: ActsOn::Joint,
    adds: "the gear leads and trails periodically over the joint's position",
    equation: "amplitude sin(cycles p + phase); cycles of a prismatic joint count turns of its lead",
    reference: "kinematic error of harmonic drives: Tuttle, Seering (1996), IEEE Trans. Robotics and Automation 12(3)",
    parameters: &[
        ("amplitude_deg", "0 to 0.1 rad (10 mm), and small enough that the joint does not turn back"),
        ("cycles_per_rev", "periods per turn, 0.05 to 10,000"),
        ("phase_deg", "within half a turn either way"),
    ],
    confused_with: &["vibration", "encoder_scale"],
    decide_by: "move the joint at two speeds: a vibration keeps its frequency, a transmission error its period in degrees",
    action: "service the gear (worn tooth, wave generator, eccentric pinion); an offset of the negative undoes it",
    undone: "all of it, point by point",
    after_reversal: AfterReversal::Nothing,
    includes: &[],
    imitates: &[],
    needs_motion: false,
    example: (
        "{effect: transmission_error, joint: A1, amplitude_deg: 0.002, cycles_per_rev: 60, phase_deg: 0}",
        View::JointOverCommand,
    ),
    read,
    typical: |size| {
        let cycles = if size.is_revolute() { 37.0 } else { 1.0 };
        // a period of about 10 deg, or of a turn of the lead
        vec![(size.key("amplitude"), (0.5 * size.gap).into()), ("cycles_per_rev".into(), cycles.into())]
    },
    // a spectrum finds the frequencies: [`ripple`]
    candidates: |_, _| {},
};

/// Amplitude in rad or m, periods per turn, phase in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionError {
    pub amplitude: f64,
    pub cycles_per_rev: f64,
    pub phase_rad: f64,
}

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let without_lead = site.axis().is_some_and(|a| site.robot.axis(a).lead_m_per_rev.is_none());
    if site.kind() == JointKind::Prismatic && without_lead {
        let found = format!("no `lead_mm_per_rev` of {} in the robot file", f.named());
        return Err(f.bad("", found, "the lead of the screw: cycles count its turns"));
    }
    Ok(TransmissionError {
        amplitude: f.length("amplitude", 0.0)?,
        cycles_per_rev: f.above_0("cycles_per_rev")?,
        phase_rad: f.phase_rad()?,
    }
    .into())
}

/// Ripple of an axis at a number of cycles per revolution (of its lead, for a prismatic one).
pub fn ripple(robot: &Robot, axis: usize, cycles_per_rev: f64) -> Candidate {
    Candidate::of_sizes(robot, Target::Joint(axis), &[candidate::TRIAL; 2], move |c| TransmissionError {
        amplitude: c[0].hypot(c[1]),
        cycles_per_rev,
        phase_rad: c[1].atan2(c[0]),
    })
    .with_shape(1)
}

impl EffectType for TransmissionError {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.amplitude, self.cycles_per_rev, self.phase_rad]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { amplitude: v[0], cycles_per_rev: v[1], phase_rad: v[2] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let wave = self.cycles_per_rev.max(1e-3) / if site.is_revolute() { 1.0 } else { site.rev() / TAU };
        vec![
            site.length("amplitude", (0.0, site.most_lost().min(1.0 / wave)), site.typical(0.003, 0.003)),
            Parameter::new("cycles_per_rev", 1.0, (0.05, 1e4), 100.0),
            Parameter::degrees("phase_deg", within(PI), PI),
        ]
    }

    fn position_error(&self, arriving: f64, rev: f64) -> Option<f64> {
        let wave = self.cycles_per_rev * TAU / rev;
        Some(self.amplitude * (wave * arriving + self.phase_rad).sin())
    }

    fn phase(&self) -> Option<usize> {
        Some(2)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
