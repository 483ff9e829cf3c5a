//! `tool_error`: the TCP stands elsewhere in the flange frame than the robot file says.
//!
//! Parameter: the three coordinates of the change, at most 200 mm each. It moves the TCP (the first reflector); further
//! reflectors keep the positions of `tools:`. Action: measure the tool again and enter it.

use nalgebra::Vector3;

/// Change of the TCP in the flange frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolError {
    pub offset_m: Vector3<f64>,
}
