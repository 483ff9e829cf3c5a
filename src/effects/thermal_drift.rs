//! `thermal_drift`: the TCP creeps to another place: adds `D * (1 - exp(-t/tau))` in the base frame.
//!
//! Parameters: the three coordinates of `D`, at most 10 mm each; `tau_s` between 1 s and 1e6 s: faster is a settling servo,
//! slower is no drift of one log. Times count from the first row. Action: warm up before measuring and working; zero again.

use nalgebra::Vector3;

/// Where it ends, m, and its time constant, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalDrift {
    pub amplitude_m: Vector3<f64>,
    pub tau_s: f64,
}

impl ThermalDrift {
    /// Displacement `t_s` seconds behind the first row, m; none before it.
    #[inline]
    pub fn at(&self, t_s: f64) -> Vector3<f64> {
        self.amplitude_m * -(-t_s.max(0.0) / self.tau_s).exp_m1()
    }
}
