//! `transmission_error`: the gear runs ahead and behind periodically: adds `amplitude * sin(cycles * p + phase)`.
//!
//! `cycles` counts periods per turn of the joint, or per turn of the screw of a prismatic joint (its lead). It acts on the
//! signal that arrives. Parameters: amplitude 0 or more, and such that the joint does not turn back (`amplitude * cycles < 1`
//! rad); cycles above 0; phase within half a turn either way. Action: service the gear (a tooth, the wave generator); an
//! offset of the negative undoes it.

use super::Track;

/// Amplitude in rad or m, periods per turn, phase in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionError {
    pub amplitude: f64,
    pub cycles_per_rev: f64,
    pub phase_rad: f64,
}

impl TransmissionError {
    /// Adds the error to `signal` in place.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        let wave = self.cycles_per_rev * std::f64::consts::TAU / track.rev;
        for s in signal {
            *s += self.amplitude * (wave * *s + self.phase_rad).sin();
        }
    }
}
