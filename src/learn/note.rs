//! What a reader of learned kinematics should know. Code compares the variants; the words are for readers.

/// A remark on a training.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Note {
    /// Joints that do not move in the logs.
    #[error(
        "{} stand still in the logs: the learned kinematics are valid only for this position of these joints",
        joints.join(", ")
    )]
    StandStill {
        /// Names of the joints.
        joints: Vec<String>,
    },
    /// A training that has not ended.
    #[error("{coordinate}: stopped after {steps} steps while the cost was still decreasing")]
    Stopped {
        /// `x`, `y` or `z`.
        coordinate: &'static str,
        /// How many steps.
        steps: usize,
    },
    /// No rows for a test.
    #[error("no test rows: the errors are those of the training")]
    NoTest,
}

crate::io::in_words!(Note);
