//! What the figures of a bidirectional assessment take: positions in mm, errors and backlash in µm.

/// Errors at poses in both directions, one panel a state (Slamani (2012) figures 3 and 4).
#[derive(Debug, Clone, Default)]
pub struct BothWaysView {
    pub panels: Vec<BothWaysPanel>,
}

#[derive(Debug, Clone, Default)]
pub struct BothWaysPanel {
    /// The state; empty where there is one only.
    pub title: String,
    pub forward: Vec<WayPoint>,
    pub backward: Vec<WayPoint>,
}

/// A direction at a pose.
#[derive(Debug, Clone, Default)]
pub struct WayPoint {
    pub at_mm: f64,
    pub mean_um: f64,
    /// Half width of the band, 3 standard deviations; 0 where it is not known.
    pub band_um: f64,
    pub readings_um: Vec<f64>,
}

/// Backlash over position, states in one figure (Slamani (2012) figures 5 to 10).
#[derive(Debug, Clone, Default)]
pub struct BacklashCurvesView {
    pub states: Vec<BacklashCurve>,
}

/// One state: backlash of its poses, and the fitted curve.
#[derive(Debug, Clone, Default)]
pub struct BacklashCurve {
    pub name: String,
    pub points: Vec<BacklashPoint>,
    /// The curve, sampled; empty where the state shares the curve of the first, or where there is none.
    pub at_mm: Vec<f64>,
    pub fit_um: Vec<f64>,
    /// 95 % band of the curve.
    pub band_um: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, Default)]
pub struct BacklashPoint {
    pub at_mm: f64,
    pub backlash_um: f64,
    pub ci95_um: Option<[f64; 2]>,
}
