//! What the file of an effect needs beside itself: the trait and its types, none of the other effects.

pub use super::candidate::{self, Candidate, Survey};
pub use super::clock::Clock;
pub use super::curve::GapCurve;
pub use super::decay::Decay;
pub use super::effect::{Effect, EffectInstance, EffectType, Undo, UndoContext};
pub use super::fields::Fields;
pub use super::info::{ActsOn, AfterReversal, EffectForm, EffectInfo, Family, Nature, Special, TypicalSize, View};
pub use super::inputs::{Geometry, Inputs, Row};
pub use super::site::{Parameter, Site};
pub use super::stage::Stage;
pub use super::target::{DhParameter, Target};
pub use super::track::{Between, Track};
pub use crate::error::Result;
pub use crate::numerics::robust::largest_size;

/// Why an effect over time does nothing in settled poses.
pub fn in_settled_poses(settled_poses: bool) -> Option<&'static str> {
    settled_poses.then_some("settled poses have no time")
}

/// The column that an effect of the measured torque lacks.
pub fn without_torque(target: Target, inputs: &dyn Inputs) -> Option<&'static str> {
    let axis = target.axis()?;
    inputs.measured_torque(axis).is_none().then_some("torque_<joint>_nm")
}
