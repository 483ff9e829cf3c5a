//! Values of notes in the units of documents.

use crate::robot::JointKind;

/// A value of a joint (rad or m) in the unit of the edges, without that unit.
pub(super) fn edge(value: f64, kind: JointKind) -> f64 {
    kind.to_user_unit(value)
}

/// The unit in which a lever is shown: TCP over joint.
pub(super) fn lever_unit(kind: JointKind) -> &'static str {
    if kind == JointKind::Revolute { "mm per radian" } else { "um per mm" }
}
