//! Groups of basis functions: what a test of structure without the catalogue is made of.

/// Splines over the position of a joint, at most.
pub const MOST_SPLINES: usize = 18;

/// What a group of basis functions depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Aspect {
    Position,
    Direction,
    Speed,
    Acceleration,
    SinceReversal,
    Torque,
    Time,
    Geometry,
}

impl Aspect {
    /// In words, after "depends on".
    pub fn text(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Direction => "direction of motion",
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::SinceReversal => "time since its reversals",
            Self::Torque => "torque",
            Self::Time => "time",
            Self::Geometry => "pose",
        }
    }
}

/// Basis functions that belong together.
pub struct BasisGroup {
    pub axis: Option<usize>,
    pub aspect: Aspect,
    pub columns: Vec<Vec<f64>>,
}

/// Uniform cubic B-splines over `lo..hi`: the values of all `n` at `x`.
pub(super) fn splines_at(x: f64, lo: f64, hi: f64, n: usize, out: &mut [f64]) {
    out.fill(0.0);
    if n < 4 {
        // too few for cubics: powers
        let u = if hi > lo { 2.0 * (x - lo) / (hi - lo) - 1.0 } else { 0.0 };
        let mut v = 1.0;
        for o in out.iter_mut() {
            *o = v;
            v *= u;
        }
        return;
    }
    let pieces = (n - 3) as f64;
    let u = ((x - lo) / (hi - lo).max(1e-300) * pieces).clamp(0.0, pieces - 1e-9);
    let i = u.floor();
    let f = u - i;
    let at = i as usize;
    let g = 1.0 - f;
    out[at] = g * g * g / 6.0;
    out[at + 1] = (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0;
    out[at + 2] = (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0;
    out[at + 3] = f * f * f / 6.0;
}
