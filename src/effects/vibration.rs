//! `vibration`: the TCP swings along a direction: adds `A * sin(2 pi f t + phase)`.
//!
//! Parameters: amplitude at most 5 mm; frequency 0.01 Hz to 1 kHz; phase within half a turn either way; a direction in the base
//! frame. A log sees it at its alias where it has fewer than two rows a period. Action: find what shakes (a fan, a
//! pump, a resonance: see whether it stays when the robot stands); damp it, or keep its frequency out of the motion.

use nalgebra::Vector3;

/// Amplitude in m along a unit vector, frequency, phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    pub amplitude_m: f64,
    pub frequency_hz: f64,
    pub phase_rad: f64,
    pub direction: Vector3<f64>,
}

impl Vibration {
    /// Displacement `t_s` seconds behind the first row, m.
    #[inline]
    pub fn at(&self, t_s: f64) -> Vector3<f64> {
        let turns = (self.frequency_hz * t_s).fract();
        self.direction * (self.amplitude_m * (std::f64::consts::TAU * turns + self.phase_rad).sin())
    }
}
