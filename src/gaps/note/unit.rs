//! Values of notes in the units of documents.

use crate::robot::JointKind;

/// The unit in which a lever is shown: TCP over joint.
pub(super) fn lever_unit(kind: JointKind) -> &'static str {
    if kind == JointKind::Revolute { "mm per radian" } else { "um per mm" }
}
