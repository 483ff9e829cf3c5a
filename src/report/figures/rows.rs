//! Rows of the tables of a page: reversals, gaps, friction, compensator.

use super::Run;

/// Errors at each reversal, side by side for several runs (Zhang (2023) table 5).
#[derive(Debug, Clone, Default)]
pub struct ReversalsView {
    /// Runs that are compared.
    pub runs: Vec<Run>,
    /// Reversals in the order of the path.
    pub rows: Vec<ReversalRow>,
}

/// Errors at one reversal.
#[derive(Debug, Clone, Default)]
pub struct ReversalRow {
    /// Name of the joint that reverses.
    pub joint: String,
    /// Angle of the circle, where the path is one.
    pub at_deg: Option<f64>,
    /// Direction after the reversal, -1 or 1.
    pub sense: i8,
    /// One per run.
    pub values: Vec<ReversalValue>,
}

/// Error of one run at a reversal.
#[derive(Debug, Clone, Default)]
pub struct ReversalValue {
    /// Largest distance from the circle near the reversal, um.
    pub total_um: f64,
    /// Beyond what the program's own chords leave.
    pub beyond_nominal_um: Option<f64>,
    /// Share by which the total error fell against the first run.
    pub reduction: Option<f64>,
}

/// A joint's lost motion, for a table.
#[derive(Debug, Clone, Default)]
pub struct GapRow {
    /// Name of the joint.
    pub joint: String,
    /// Half gap, thousandths of deg or mm.
    pub half_gap_milli: f64,
    /// Its 95 % interval, thousandths of deg or mm.
    pub ci95_milli: [f64; 2],
    /// Whether the interval leaves out zero.
    pub significant: bool,
    /// p value of the test that the gap does not vary with position.
    pub varies_p_value: Option<f64>,
    /// TCP error of one half gap at a stated pose, µm.
    pub tcp_um: Option<f64>,
    /// Stiction of the joint, where it was found.
    pub stiction: Option<StictionRow>,
}

/// Stiction of one joint.
#[derive(Debug, Clone, Default)]
pub struct StictionRow {
    /// Size after a reversal, thousandths of deg or mm.
    pub spike_milli: f64,
    /// Its 95 % interval, thousandths of deg or mm.
    pub ci95_milli: [f64; 2],
    /// Decay and its interval in `decay_unit` (s, deg or mm).
    pub decay: f64,
    /// 95 % interval of the decay, in `decay_unit`.
    pub decay_ci95: [f64; 2],
    /// Unit of the decay: seconds, or deg or mm of travel.
    pub decay_unit: String,
}

/// A joint of a compensator, for a table.
#[derive(Debug, Clone, Default)]
pub struct CompensatorRow {
    /// Name of the joint.
    pub joint: String,
    /// Offset moving up and moving down; two ends each where it is scheduled.
    pub positive_milli: Option<[f64; 2]>,
    /// Offset moving down, thousandths of deg or mm; two ends where it is scheduled.
    pub negative_milli: Option<[f64; 2]>,
    /// "constant", "PCHIP, 5 knots", "polynomial of degree 2".
    pub kind: String,
    /// Offset against friction after a reversal, thousandths of deg or mm.
    pub friction_gain_milli: Option<f64>,
    /// "decays over 5.2 s", "equation 17, l = 3, 5 points".
    pub friction_shape: String,
}
