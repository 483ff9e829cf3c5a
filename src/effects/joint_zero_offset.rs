//! `joint_zero_offset`: the joint stands a constant off its command.
//!
//! Parameter: `offset` of either sign, at most 0.2 rad or 50 mm: a robot mastered worse than that does not reach its work.
//! Action: master the joint again (or enter the offset in the controller).

/// Constant, rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointZeroOffset {
    pub offset: f64,
}
