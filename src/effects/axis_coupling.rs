//! `axis_coupling`: a joint is turned along by another one's command: adds `ratio * p` of that joint.
//!
//! Wrists whose motors sit in the arm are geared this way; the controller takes it out, with a ratio that may be wrong.
//! Parameter: `ratio` (rad or m per rad or m; at the edges in the units of the two joints), at most 0.5 either way: hollow-shaft
//! wrists couple by 1/100 or so, and only the error of the ratio is left. Action: correct the coupling ratio in the controller.

/// Movement of this joint per movement of the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCoupling {
    pub ratio: f64,
}
