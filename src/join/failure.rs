//! Why there is no fit of the clocks.

/// Why there is no fit; the words stand after "found".
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// So few readings lie within the controller's recording.
    #[error("{0} readings of the tracker within the controller's recording")]
    FewReadings(usize),
    /// No rigid transform brings the commanded path to the measured one.
    #[error("a path that does not fit in any frame")]
    NoFrame,
    /// The motion leaves the clock open.
    #[error("a motion that does not determine the clock offset")]
    Open,
    /// Clocks of devices do not drift apart like this, ppm.
    #[error("clocks that drift apart by {0} ppm")]
    Drift(i64),
    /// The rounds were used up.
    #[error("a fit of the clock that does not converge")]
    NotSettled,
}

impl Failure {
    /// What a motion or a recording must be like instead.
    pub fn expected(self) -> &'static str {
        match self {
            Self::FewReadings(_) | Self::NoFrame | Self::NotSettled => {
                "recordings of one motion that overlap by several seconds"
            }
            Self::Open => "an approximate offset, or a motion that moves every joint faster or longer",
            Self::Drift(_) => {
                "clocks that agree within 1000 ppm, as those of devices do: check the unit of both times, or give an approximate offset"
            }
        }
    }

    /// Whether an approximate offset may help.
    pub fn near_helps(self) -> bool {
        matches!(self, Self::Open | Self::Drift(_))
    }
}
