//! Which program, and what a user may choose about it.

use crate::machine::measurement::Instrument;
use nalgebra::Vector3;

/// Which program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Bidirectional dwells of one joint at a time.
    Static,
    /// A slow path with reversals.
    Path,
    /// All joints at once, each with its own frequencies.
    Excitation,
}

impl Kind {
    /// Name as it stands on the command line and in documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Path => "path",
            Self::Excitation => "excitation",
        }
    }
}

/// What a user may choose; SI.
#[derive(Debug, Clone)]
pub struct Options {
    /// Joints about which to move, rad or m; `None`: chosen by the plan.
    pub pose: Option<Vec<f64>>,
    /// Place of the tracker in the robot's world frame: the TCP stays visible from it.
    pub tracker_m: Option<Vector3<f64>>,
    /// Largest angle between the reflector's axis and the beam, rad.
    pub acceptance_rad: f64,
    /// What measures.
    pub instrument: Instrument,
    /// Length of a double ballbar, m, which reads about a millimetre either way of it; `None`: the distance may change by more.
    pub bar_m: Option<f64>,
    /// Standard deviation of a reading, m.
    pub noise_m: f64,
    /// Rows of the log per second.
    pub rate_hz: f64,
    /// Largest speed of the TCP, m/s.
    pub speed_m_s: f64,
    /// Largest travel of a revolute joint to either side, rad.
    pub travel_rad: f64,
    /// Largest travel of a prismatic joint to either side, m.
    pub travel_m: f64,
    /// Of a path or an excitation.
    pub duration_s: f64,
    /// Of a static test.
    pub dwell_s: f64,
    /// How often a static test visits each place from each side.
    pub cycles: usize,
    /// Number of places of a static test.
    pub places: usize,
}
