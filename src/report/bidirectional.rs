//! What the figures of a bidirectional assessment take: positions in mm, errors and backlash in µm.

/// Errors at poses in both directions, one panel a state (Slamani (2012) figures 3 and 4).
#[derive(Debug, Clone, Default)]
pub struct BothWaysView {
    /// One picture for each state of the machine.
    pub panels: Vec<BothWaysPanel>,
}

/// Errors of one state over position, both ways.
#[derive(Debug, Clone, Default)]
pub struct BothWaysPanel {
    /// The state; empty where there is one only.
    pub title: String,
    /// Positions approached with rising values.
    pub forward: Vec<WayPoint>,
    /// Positions approached with falling values.
    pub backward: Vec<WayPoint>,
}

/// A direction at a pose.
#[derive(Debug, Clone, Default)]
pub struct WayPoint {
    /// Commanded position, mm.
    pub at_mm: f64,
    /// Mean error of the readings, um.
    pub mean_um: f64,
    /// Half width of the band, 3 standard deviations; 0 where it is not known.
    pub band_um: f64,
    /// Single readings, um.
    pub readings_um: Vec<f64>,
}

/// Backlash over position, states in one figure (Slamani (2012) figures 5 to 10).
#[derive(Debug, Clone, Default)]
pub struct BacklashCurvesView {
    /// One curve for each state of the machine.
    pub states: Vec<BacklashCurve>,
}

/// One state: backlash of its poses, and the fitted curve.
#[derive(Debug, Clone, Default)]
pub struct BacklashCurve {
    /// Name of the state.
    pub name: String,
    /// Measured positions.
    pub points: Vec<BacklashPoint>,
    /// The curve, sampled; empty where the state shares the curve of the first, or where there is none.
    pub at_mm: Vec<f64>,
    /// The fitted curve at the same places as its abscissa, um.
    pub fit_um: Vec<f64>,
    /// 95 % band of the curve.
    pub band_um: Vec<[f64; 2]>,
}

/// Backlash at one position.
#[derive(Debug, Clone, Default)]
pub struct BacklashPoint {
    /// Commanded position, mm.
    pub at_mm: f64,
    /// Mean of one direction less mean of the other, um.
    pub backlash_um: f64,
    /// 95 % interval of the backlash, um; `None` without repeats.
    pub ci95_um: Option<[f64; 2]>,
}
