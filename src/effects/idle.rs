//! Effects of a model that do nothing where they stand, and why.

/// An effect that does nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{effect} of {target} has no effect: {why}")]
pub struct Idle {
    /// Name of the effect in the catalogue.
    pub effect: &'static str,
    /// Where it stands: "A1", "tool".
    pub target: String,
    /// Why it does nothing.
    pub why: WhyIdle,
}

/// Why an effect does nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WhyIdle {
    /// No log or program holds the columns that it follows.
    #[error("no column {0}")]
    NoColumn(&'static str),
    /// What the effect says of this robot, or of settled poses.
    #[error("{0}")]
    Here(&'static str),
}
