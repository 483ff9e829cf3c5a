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
