//! `link_error`: a DH parameter of a joint (`a`, `d`, `alpha`) differs from the robot file.
//!
//! Parameter: `delta` of either sign, at most 50 mm or 0.1 rad: a robot farther off is another robot. Action: enter the
//! calibrated parameter, where the controller lets one; else correct poses with the calibrated inverse kinematics.

/// Change of the parameter, m or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkError {
    pub delta: f64,
}
