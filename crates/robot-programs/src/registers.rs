//! Registers of a controller, as the user has them listed: values that programs go to and do not hold.
//!
//! FANUC alone has them; its listings are read by [`crate::fanuc`].

use crate::script::pose::Configuration;
use std::collections::BTreeMap;

/// Values of registers of group 1, by their numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Registers {
    /// Position registers.
    pub positions: BTreeMap<u64, Register>,
}

/// The value of a position register.
#[derive(Debug, Clone, PartialEq)]
pub enum Register {
    /// J1 to J6, deg.
    Joints([f64; 6]),
    /// X, Y, Z in mm; W, P, R in deg: rotations about fixed X, Y, Z in this order. Frame and tool are those that are selected when it is
    /// used.
    Pose([f64; 6], Configuration),
}
