//! `vibration`: the TCP vibrates along one direction: adds `A * sin(2 pi f t + phase)`.
//!
//! Parameters: amplitude at most 5 mm; frequency 0.01 Hz to 1 kHz; phase within half a turn either way; a direction in the base
//! frame. A log shows it at its alias where it has fewer than two rows a period. Action: find what vibrates (a fan, a
//! pump, a resonance: see whether it stays when the robot stands); damp it, or avoid motions that contain its frequency.

use super::common::*;
use super::site::within;
use crate::robot::Robot;
use nalgebra::Vector3;
use serde_yaml::{Mapping, Value};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "vibration",
    heading: "vibration",
    stage: Stage::Tcp,
    family: Family::Vibration,
    acts_on: ActsOn::Tcp,
    adds: "the TCP vibrates along one direction",
    equation: "A sin(2 pi f t + phase), t from the first row",
    reference: "ISO 230-8:2010, Test code for machine tools - Vibrations",
    parameters: &[
        ("amplitude_um", "0 to 5,000 um"),
        ("frequency_hz", "0.01 to 1,000 Hz"),
        ("phase_deg", "within half a turn either way"),
        ("direction", "[x, y, z] in the base frame"),
    ],
    confused_with: &["transmission_error"],
    decide_by: "log while the robot stands still; or move at two speeds",
    action: "find the source (fan, pump, resonance) and damp it; avoid motions that contain its frequency",
    undone: "nothing: it depends on time, not on the program",
    special: Special::NONE,
    example: (
        "{effect: vibration, amplitude_um: 40, frequency_hz: 0.7, phase_deg: 0, direction: [1, 0, 0.5]}",
        View::TcpOverTime,
    ),
    read: |f| {
        Ok(Vibration {
            amplitude_m: f.needed("amplitude_um", 0.0)? * 1e-6,
            frequency_hz: f.above_0("frequency_hz")?,
            phase_rad: f.phase_rad()?,
            direction: f.direction()?,
        }
        .into())
    },
    typical: |_| {
        let direction = Value::Sequence(vec![0.5.into(), 0.6.into(), 0.62.into()]);
        vec![("amplitude_um".into(), 10.0.into()), ("frequency_hz".into(), 7.3.into()), ("direction".into(), direction)]
    },
    // a spectrum finds the frequencies: [`swing`]
    candidates: |_, _| {},
};

/// Amplitude in m along a unit vector, frequency, phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// Amplitude, m.
    pub amplitude_m: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at the first row, rad.
    pub phase_rad: f64,
    /// Direction of the oscillation, a unit vector in the base frame.
    pub direction: Vector3<f64>,
}

impl Vibration {
    /// Of a vector along the direction with the length of the amplitude.
    fn along(v: Vector3<f64>, frequency_hz: f64, phase_rad: f64, otherwise: Vector3<f64>) -> Self {
        let amplitude_m = v.norm();
        let direction = if amplitude_m > 0.0 { v / amplitude_m } else { otherwise };
        Self { amplitude_m, frequency_hz, phase_rad, direction }
    }
}

/// Vibration of the TCP at a frequency: sine and cosine in three directions; built along the strongest one.
pub fn swing(robot: &Robot, frequency_hz: f64) -> Candidate {
    let halves = |c: &[f64]| (Vector3::new(c[0], c[1], c[2]), Vector3::new(c[3], c[4], c[5]));
    // the six coefficients of an ellipse hold one more than a line has
    Candidate::of_sizes(robot, Target::Tcp, &[1e-5; 6], move |c| {
        let (s, c) = halves(c);
        match s.norm() > 0.0 {
            true => Vibration::along(s, frequency_hz, 0.0, Vector3::x()),
            false => Vibration::along(c, frequency_hz, FRAC_PI_2, Vector3::x()),
        }
    })
    .built_by(Target::Tcp, move |c| {
        let (s, c) = halves(c);
        // the phase at which the ellipse is longest: its major axis is the line of motion
        let phase = 0.5 * (2.0 * s.dot(&c)).atan2(s.norm_squared() - c.norm_squared());
        Vibration::along(s * phase.cos() + c * phase.sin(), frequency_hz, phase, Vector3::x())
    })
}

/// What a mean over so many turns leaves of a swing.
fn mean_of_swing(turns: f64) -> f64 {
    let half = PI * turns;
    if half.abs() < 1e-6 { 1.0 } else { half.sin() / half }
}

impl EffectType for Vibration {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    /// The coordinates of amplitude times direction, then frequency and phase.
    fn values(&self) -> Vec<f64> {
        let a = self.direction * self.amplitude_m;
        vec![a.x, a.y, a.z, self.frequency_hz, self.phase_rad]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self::along(Vector3::new(v[0], v[1], v[2]), v[3], v[4], self.direction).into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let mut all: Vec<Parameter> =
            (0..3).map(|k| Parameter::new(&format!("amplitude_um[{k}]"), 1e6, within(5e-3), 10e-6)).collect();
        all.push(Parameter::new("frequency_hz", 1.0, (0.01, 1e3), 10.0));
        all.push(Parameter::degrees("phase_deg", within(PI), PI));
        all
    }

    fn write(&self, _site: &Site, entry: &mut Mapping) {
        entry.insert("amplitude_um".into(), (self.amplitude_m * 1e6).into());
        entry.insert("frequency_hz".into(), self.frequency_hz.into());
        entry.insert("phase_deg".into(), self.phase_rad.to_degrees().into());
        let direction = self.direction.iter().map(|&x| x.into()).collect();
        entry.insert("direction".into(), Value::Sequence(direction));
    }

    fn displacement_m(&self, _target: Target, row: &Row, _point_m: &Vector3<f64>) -> Vector3<f64> {
        if row.settled {
            return Vector3::zeros();
        }
        let turns = (self.frequency_hz * row.t_s).fract();
        let mean = mean_of_swing(self.frequency_hz * row.inputs.mean_over_s());
        self.direction * (self.amplitude_m * mean * (TAU * turns + self.phase_rad).sin())
    }

    fn displaces(&self) -> bool {
        true
    }

    fn phase(&self) -> Option<usize> {
        Some(4)
    }

    fn magnitude(&self) -> f64 {
        self.amplitude_m
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        in_settled_poses(settled_poses)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it depends on time, not on the program")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_over_part_of_a_turn_leaves_what_the_samples_in_it_average_to() {
        for (turns, phase) in [(0.0, 0.3), (0.25, 1.0), (0.8, -2.0), (1.3, 0.7)] {
            const N: usize = 10_000;
            let at = |k: usize| TAU * turns * ((k as f64 + 0.5) / N as f64 - 0.5) + phase;
            let mean = (0..N).map(|k| at(k).sin()).sum::<f64>() / N as f64;
            assert!((mean - mean_of_swing(turns) * phase.sin()).abs() < 1e-7, "{turns}: {mean}");
        }
    }
}
