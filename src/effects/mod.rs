//! The effect catalogue: every fault of a machine that the tool knows, for simulating, diagnosing and compensating.
//!
//! An effect acts at one place of the chain: command -> servo -> gear -> link -> geometry -> base -> TCP -> measurement. Effects
//! of servo and gear turn the signal that arrives into the one that leaves (the gear sees what the servo made; they are not
//! added as in Zhang (2023) equation 10; the two differ only while a gap is crossed). The chain itself is
//! [`crate::machine`].
//!
//! One file per effect, named after it, holds all of it: equation and reference, parameters with unit, bounds and typical size,
//! YAML keys, how it acts, what a diagnosis tries, what `rewrite` undoes, and its text in the docs. `docs/add-an-effect.md` walks
//! through the addition of one. Read in this order:
//! - [`effect`]: the trait [`EffectType`], which every effect implements, and [`Effect`], a value of any of them.
//! - [`info`]: [`EffectInfo`], what holds for all values of an effect; [`catalogue`]: all of them, with one line each.
//! - `common`: what the file of an effect needs beside itself; `stage`: places in the chain; `output`: what a gear makes of a command;
//!   `clock`, `decay`: how two clocks differ, and how friction decays after a reversal.
//! - [`inputs`]: what effects look at; [`target`]: where they act, also in words; [`entry`] and [`fields`]: the same in a model file;
//!   [`site`]: units and keys of a target.
//! - [`candidate`]: what a diagnosis tries of an effect, and what it knows of the logs ([`candidate::Survey`]).
//! - [`track`]: a joint's command with its directions and turning points; [`smooth`]: a motion between its samples;
//!   [`curve`]: a half gap as a function of position; [`spline`]: a smooth curve that is linear in its values.

#![warn(missing_docs)]

pub mod axis_coupling;
pub mod backlash;
pub mod backlash_position;
pub mod backlash_speed;
pub mod base_tilt;
pub mod bearing_wobble;
pub mod candidate;
pub mod catalogue;
pub mod clock;
mod common;
pub mod coupled_play;
pub mod curve;
pub mod decay;
pub mod effect;
pub mod empirical;
pub mod encoder_scale;
pub mod entry;
pub mod fields;
pub mod free_mass_gravity;
pub mod gravity_compliance;
pub mod hysteresis;
pub mod idle;
pub mod info;
pub mod inputs;
pub mod joint_zero_offset;
pub mod link_error;
pub mod loaded_play;
pub mod maxwell_slip;
mod output;
pub mod presliding_stiction;
pub mod process_force;
pub mod response;
pub mod servo_lag;
pub mod site;
pub mod smooth;
pub mod spline;
mod stage;
pub mod stiction;
pub mod target;
pub mod thermal_drift;
pub mod thermal_growth;
pub mod time_offset;
pub mod tool_error;
pub mod torque_hysteresis;
pub mod torque_windup;
pub mod track;
pub mod tracker_frame;
pub mod tracker_refraction;
pub mod tracker_scale;
pub mod transmission_error;
pub mod vibration;

pub use axis_coupling::AxisCoupling;
pub use backlash::Backlash;
pub use backlash_position::BacklashPosition;
pub use backlash_speed::BacklashSpeed;
pub use base_tilt::BaseTilt;
pub use bearing_wobble::BearingWobble;
pub use candidate::{Candidate, Survey};
pub use clock::Clock;
pub use coupled_play::CoupledPlay;
pub use curve::GapCurve;
pub use decay::Decay;
pub use effect::{Effect, EffectInstance, EffectType, Undo, UndoContext, without_columns};
pub use empirical::Empirical;
pub use encoder_scale::EncoderScale;
pub use fields::Fields;
pub use free_mass_gravity::FreeMassGravity;
pub use gravity_compliance::GravityCompliance;
pub use hysteresis::Hysteresis;
pub use idle::{Idle, WhyIdle};
pub use info::{ActsOn, AfterReversal, EffectForm, EffectInfo, Family, Nature, Special, TypicalSize, View};
pub use inputs::{Geometry, Inputs, Row};
pub use joint_zero_offset::JointZeroOffset;
pub use link_error::LinkError;
pub use loaded_play::LoadedPlay;
pub use maxwell_slip::MaxwellSlip;
pub use output::{apply_stage, joint_output};
pub use presliding_stiction::PreslidingStiction;
pub use process_force::ProcessForce;
pub use servo_lag::ServoLag;
pub use site::{Parameter, Site};
pub use stage::Stage;
pub use stiction::Stiction;
pub use target::{DhParameter, Target};
pub use thermal_drift::ThermalDrift;
pub use thermal_growth::ThermalGrowth;
pub use time_offset::TimeOffset;
pub use tool_error::ToolError;
pub use torque_hysteresis::TorqueHysteresis;
pub use torque_windup::TorqueWindup;
pub use track::{Between, Track, Turn};
pub use tracker_frame::TrackerFrame;
pub use tracker_refraction::TrackerRefraction;
pub use tracker_scale::TrackerScale;
pub use transmission_error::TransmissionError;
pub use vibration::Vibration;

pub use crate::robot::JointFrame;
