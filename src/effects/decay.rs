//! How friction decays after a reversal.

/// How the spike decays: `exp(-(t - t_rev) / s)`, or `exp(-|p - p_rev| / travel)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decay {
    /// Time constant, s.
    Time(f64),
    /// Travel constant, rad or m.
    Travel(f64),
}

impl Decay {
    /// Share of the spike that is left `since_s` seconds and `travel` (rad or m) after the reversal.
    #[inline]
    pub fn left(&self, since_s: f64, travel: f64) -> f64 {
        match self {
            Self::Time(tau) => (-since_s / tau).exp(),
            Self::Travel(lambda) => (-travel.abs() / lambda).exp(),
        }
    }
}
