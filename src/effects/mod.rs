//! The effect catalogue: every fault of a machine that the tool knows, in one place, for simulating, diagnosing and
//! compensating alike.
//!
//! An effect acts at one place of the chain: command -> servo -> gear -> link -> geometry -> TCP -> measurement. Those of servo
//! and gear turn the signal that arrives into the one that leaves (the gear sees what the servo made; not added as in
//! seed 000 equation 10; the two differ only while a gap is crossed). The chain itself is [`crate::machine`].
//!
//! Rooms:
//! - [`track`]: a joint's command with its directions and turning points, which effects look at; [`smooth`]: what a motion
//!   does between its samples; [`curve`]: a half gap as a function of position.
//! - one file per effect, named after it: equation, parameters with their bounds and why, what to do about it.
//! - [`instance`]: an effect and where it acts: keys, bounds; [`entry`]: the same as it stands in a model file, to and from its
//!   type, with every refusal; [`catalogue`]: what a user reads about each.
//!
//! Adding an effect is a file here, a variant of [`Effect`] below, and its lines in [`instance`], [`entry`] and [`catalogue`].

pub mod axis_coupling;
pub mod backlash;
pub mod backlash_speed;
pub mod catalogue;
pub mod curve;
pub mod encoder_scale;
pub mod entry;
pub mod gravity_compliance;
pub mod hysteresis;
pub mod instance;
pub mod joint_zero_offset;
pub mod link_error;
pub mod servo_lag;
pub mod smooth;
pub mod stiction;
pub mod thermal_drift;
pub mod time_offset;
pub mod tool_error;
pub mod track;
pub mod transmission_error;
pub mod values;
pub mod vibration;

pub use axis_coupling::AxisCoupling;
pub use backlash::Backlash;
pub use backlash_speed::BacklashSpeed;
pub use curve::GapCurve;
pub use encoder_scale::EncoderScale;
pub use gravity_compliance::GravityCompliance;
pub use hysteresis::Hysteresis;
pub use instance::EffectInstance;
pub use joint_zero_offset::JointZeroOffset;
pub use link_error::LinkError;
pub use servo_lag::ServoLag;
pub use stiction::{Decay, Stiction};
pub use thermal_drift::ThermalDrift;
pub use time_offset::TimeOffset;
pub use tool_error::ToolError;
pub use track::{Between, Track, Turn};
pub use transmission_error::TransmissionError;
pub use vibration::Vibration;

/// Place in the chain; effects act in this order, and within a stage in the order of the model file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    Servo,
    Gear,
    Link,
    Geometry,
    Tcp,
    Measurement,
}

/// A DH parameter that a [`LinkError`] changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DhParameter {
    A,
    D,
    Alpha,
}

impl DhParameter {
    /// As it stands behind the dot of a target.
    pub fn text(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::D => "d",
            Self::Alpha => "alpha",
        }
    }
}

/// Where an effect acts. `Joint`, `to` and `from` count axes (joints with a command of their own); `joint` counts
/// [`crate::robot::Robot::joints`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    Joint(usize),
    Coupled { to: usize, from: usize },
    Link { joint: usize, parameter: DhParameter },
    Tool,
    Tcp,
    Log,
}

/// One effect. Values are SI (rad or m, s).
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    ServoLag(ServoLag),
    Stiction(Stiction),
    EncoderScale(EncoderScale),
    TransmissionError(TransmissionError),
    /// `backlash` and `backlash_position`: the play operator with a half gap that may depend on position.
    Backlash(Backlash),
    BacklashSpeed(BacklashSpeed),
    Hysteresis(Hysteresis),
    JointZeroOffset(JointZeroOffset),
    AxisCoupling(AxisCoupling),
    GravityCompliance(GravityCompliance),
    LinkError(LinkError),
    ToolError(ToolError),
    ThermalDrift(ThermalDrift),
    Vibration(Vibration),
    TimeOffset(TimeOffset),
}

impl Effect {
    /// Name in the catalogue.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ServoLag(_) => "servo_lag",
            Self::Stiction(_) => "stiction",
            Self::EncoderScale(_) => "encoder_scale",
            Self::TransmissionError(_) => "transmission_error",
            Self::Backlash(b) if b.half_gap.constant().is_none() => "backlash_position",
            Self::Backlash(_) => "backlash",
            Self::BacklashSpeed(_) => "backlash_speed",
            Self::Hysteresis(_) => "hysteresis",
            Self::JointZeroOffset(_) => "joint_zero_offset",
            Self::AxisCoupling(_) => "axis_coupling",
            Self::GravityCompliance(_) => "gravity_compliance",
            Self::LinkError(_) => "link_error",
            Self::ToolError(_) => "tool_error",
            Self::ThermalDrift(_) => "thermal_drift",
            Self::Vibration(_) => "vibration",
            Self::TimeOffset(_) => "time_offset",
        }
    }

    /// Where it acts.
    pub fn stage(&self) -> Stage {
        match self {
            Self::ServoLag(_) | Self::Stiction(_) => Stage::Servo,
            Self::EncoderScale(_)
            | Self::TransmissionError(_)
            | Self::Backlash(_)
            | Self::BacklashSpeed(_)
            | Self::Hysteresis(_) => Stage::Gear,
            Self::JointZeroOffset(_) | Self::AxisCoupling(_) | Self::GravityCompliance(_) => Stage::Link,
            Self::LinkError(_) | Self::ToolError(_) => Stage::Geometry,
            Self::ThermalDrift(_) | Self::Vibration(_) => Stage::Tcp,
            Self::TimeOffset(_) => Stage::Measurement,
        }
    }

    /// It remembers where the joint came from, so that it depends on turning points and not on the present alone.
    pub fn has_memory(&self) -> bool {
        matches!(self, Self::Stiction(_) | Self::Backlash(_) | Self::BacklashSpeed(_) | Self::Hysteresis(_))
    }

    /// Turns the arriving signal (rad or m, one value per sample of `track`) into the leaving one, in place. Effects behind
    /// the gear do nothing here: they need more than one joint.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        match self {
            Self::ServoLag(e) => e.apply(track, signal),
            Self::Stiction(e) => e.apply(track, signal),
            Self::EncoderScale(e) => e.apply(signal),
            Self::TransmissionError(e) => e.apply(track, signal),
            Self::Backlash(e) => e.apply(track, signal),
            Self::BacklashSpeed(e) => e.apply(track, signal),
            Self::Hysteresis(e) => e.apply(track, signal),
            _ => {}
        }
    }
}

/// Applies the effects of one stage to a signal, in their order.
pub fn apply_stage<'a>(stage: Stage, track: &Track, effects: impl IntoIterator<Item = &'a Effect>, signal: &mut [f64]) {
    for e in effects.into_iter().filter(|e| e.stage() == stage) {
        e.apply(track, signal);
    }
}

/// Output of a joint's gear for its command: servo, then gear, in the order given within each.
pub fn joint_output<'a>(track: &Track, effects: impl IntoIterator<Item = &'a Effect> + Clone) -> Vec<f64> {
    let mut signal = track.p.to_vec();
    apply_stage(Stage::Servo, track, effects.clone(), &mut signal);
    apply_stage(Stage::Gear, track, effects, &mut signal);
    signal
}
