//! `gravity_compliance`: the gear yields to gravity: adds `compliance * torque` about the joint's axis.
//!
//! The torque is that of the weights of `links` and, where logged, of `payload_kg` at the flange, at the commanded pose; a positive
//! one turns the joint positive. Parameter: compliance 0 or more (a spring gives way along its load), at most 1e-3 rad/Nm or
//! 1e-4 m/N. Action: an elasto-static correction (most controllers have one, with load data); check the counterbalance.

/// rad/Nm, or m/N for a prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GravityCompliance {
    pub compliance: f64,
}
