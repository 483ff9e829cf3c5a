//! Notes of gaps that come from the positions of a line, measured from both sides.

/// A remark on the gap of a joint by the backlash of a line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The line reaches beyond the limits of the joint. Ends are as shown, in `unit`.
    #[error(
        "a line from {} to {} {unit} of {joint} reaches beyond its limits {} to {} {unit}: check the joint, its origin and its lever",
        line[0], line[1], limits[0], limits[1]
    )]
    BeyondLimits {
        /// Name of the joint.
        joint: String,
        /// Unit of the ends.
        unit: &'static str,
        /// Ends of the line, rounded.
        line: [String; 2],
        /// Limits of the joint, rounded.
        limits: [String; 2],
    },
    /// The curve of the half gap is negative in places.
    #[error("the half gap is set to 0 where its curve is negative")]
    CutAtZero,
    /// One half gap without a schedule.
    #[error("the backlash does not vary with position: the result is one half gap without a schedule")]
    Constant,
    /// The state in which the gap holds, such as speed or load.
    #[error("state: {0}")]
    State(String),
    /// The equation of the fitted curve.
    #[error("assess bidirectional, backlash of the line in um over mm: {0}")]
    Equation(String),
    /// The gap over speed is a straight line.
    #[error("backlash_speed is a straight line over {speeds} speeds, with an error of at most {:.1} um", error_m * 1e6)]
    OverSpeed {
        /// Number of speeds.
        speeds: usize,
        /// Largest error of the straight line, m at the TCP.
        error_m: f64,
    },
    /// The gap over speed is a mean over the line.
    #[error("backlash_speed contains the mean over the line, not the variation of the gap with position")]
    MeanOverLine,
}
