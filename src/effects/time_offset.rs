//! `time_offset`: the clocks of tracker and controller differ: the measurement at `t` shows the robot at `t + offset`.
//!
//! Parameter: `offset_s` of either sign, at most 10 s: clocks farther apart are set, not estimated. Action: trigger both from one
//! signal; shift the times of the log.

/// s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeOffset {
    pub offset_s: f64,
}
