//! What holds for all values of an effect: its name, its place, its words, how its entry is read, what a diagnosis tries.

use super::{Candidate, DhParameter, Effect, Fields, Stage, Survey};
use crate::error::Result;
use crate::robot::JointKind;
use serde_yaml::{Mapping, Value};

/// One effect of the catalogue.
#[derive(Debug)]
pub struct EffectInfo {
    /// Name in model files and documents.
    pub name: &'static str,
    /// A few words for the head of a column.
    pub heading: &'static str,
    /// Where in the chain it acts.
    pub stage: Stage,
    /// Effects that a machine has together or not at all: tested as one before their members.
    pub family: Family,
    /// Kind of its target.
    pub acts_on: ActsOn,
    /// What it adds, in one line.
    pub adds: &'static str,
    /// Its equation, in one line.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub reference: &'static str,
    /// Keys of its parameters for a revolute joint, with what each means and its bounds.
    pub parameters: &'static [(&'static str, &'static str)],
    /// Effects that a log may not tell from it.
    pub confused_with: &'static [&'static str],
    /// The experiment that decides.
    pub decide_by: &'static str,
    /// What a user does about it.
    pub action: &'static str,
    /// What `rewrite --model` undoes of it.
    pub undone: &'static str,
    /// What holds for few effects.
    pub special: Special,
    /// An entry of a model file, and what a picture of it shows over what.
    pub example: (&'static str, View),
    /// Reads the keys of an entry.
    pub read: fn(&mut Fields) -> Result<Effect>,
    /// Keys and values of a size at which it matters.
    pub typical: fn(&TypicalSize) -> Vec<(String, Value)>,
    /// What a diagnosis tries at first: adds its candidates to the list.
    pub candidates: fn(&Survey, &mut Vec<Candidate>),
}

/// What holds for few effects: the rest writes [`Special::NONE`].
#[derive(Debug)]
pub struct Special {
    /// What it does after the reversals of its joint.
    pub after_reversal: AfterReversal,
    /// Effects that are special cases of it.
    pub includes: &'static [&'static str],
    /// Effects to which it comes as close as one likes, so that it always fits a log as well as they do.
    pub imitates: &'static [&'static str],
    /// It shows in motion alone: a log in which its joint is stationary does not show it.
    pub needs_motion: bool,
    /// Forms with more freedom and rarer effects, tried where the plain ones leave something, and of settled poses and clocks.
    pub further: fn(&Survey, &mut Vec<Candidate>),
}

impl Special {
    /// Nothing of it.
    pub const NONE: Self = Self {
        after_reversal: AfterReversal::Nothing,
        includes: &[],
        imitates: &[],
        needs_motion: false,
        further: |_, _| {},
    };
}

/// Another form of an effect: other keys in its entry, their own equation.
#[derive(Debug)]
pub struct EffectForm {
    /// The effect.
    pub of: &'static EffectInfo,
    /// Name of its picture.
    pub name: &'static str,
    /// Heading, after the name of the effect.
    pub heading: &'static str,
    /// Its equation, in one line.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub reference: &'static str,
    /// Sizes that one meets.
    pub typical: &'static str,
    /// An entry of a model file, and what a picture of it shows over what.
    pub example: (&'static str, View),
    /// What a diagnosis does with it.
    pub diagnosis: &'static str,
    /// What `rewrite --model` undoes of it.
    pub undone: &'static str,
}

/// Kinds of targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsOn {
    /// One joint.
    Joint,
    /// One joint by another.
    Coupling,
    /// One of these parameters of a joint.
    DhParameter(&'static [DhParameter]),
    /// A joint, or one of these parameters of one.
    JointOrDhParameter(&'static [DhParameter]),
    /// A joint, or the TCP.
    JointOrTcp,
    /// The base of the robot.
    Base,
    /// The tool.
    Tool,
    /// The TCP, in the frame of the base.
    Tcp,
    /// The log as a whole.
    Log,
}

impl ActsOn {
    /// As the documents print it: an example of a target.
    pub fn text(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::Coupling => "A6<-A5",
            Self::DhParameter(_) => "A2.a",
            Self::JointOrDhParameter(_) => "joint or A2.a",
            Self::JointOrTcp => "joint or tcp",
            Self::Base => "base",
            Self::Tool => "tool",
            Self::Tcp => "tcp",
            Self::Log => "log",
        }
    }
}

/// Effects of one kind, by which a diagnosis groups them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// Lags of the servos and the clock.
    Lag,
    /// Friction in joints.
    Friction,
    /// Play in gears and screws.
    Gap,
    /// Scales of encoders, couplings between joints.
    Scale,
    /// Errors that repeat with the revolution of a joint.
    Ripple,
    /// Zero offsets, DH parameters, tool.
    Geometry,
    /// Deflection under weight.
    Gravity,
    /// Times and temperatures.
    Drift,
    /// Oscillation of the structure.
    Vibration,
    /// The measuring system itself.
    Tracker,
    /// Curves without a physical name.
    Empirical,
}

/// What other modules treat apart, whatever the effect is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nature {
    /// A gap of one size.
    Gap,
    /// A gap over position, by knots.
    GapOverPosition,
    /// A wind-up after a reversal that stays.
    WindUp,
    /// Friction whose error fades after a reversal.
    Spike,
    /// Friction that builds up over a presliding travel.
    Presliding,
    /// The zero of a joint.
    ZeroOffset,
    /// Lengths and angles of the links.
    Link,
    /// The lag of a servo.
    Lag,
    /// The offset between two clocks.
    Clock,
    /// An error that repeats with the revolution.
    Ripple,
    /// An error in proportion to the movement.
    Scale,
    /// A movement of one joint by another.
    Coupling,
    /// A curve without a physical name.
    Unnamed,
    /// Anything else.
    Other,
}

/// What an effect does after a reversal of its joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AfterReversal {
    /// Nothing that a reversal starts.
    Nothing,
    /// A step that stays.
    Step,
    /// An error that fades.
    Tail,
}

/// What a picture shows over what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Joint error over its command.
    JointOverCommand,
    /// Joint error over time.
    JointOverTime,
    /// Joint error over the command of the second joint.
    JointOverOther,
    /// The same over time, moved ever slower.
    JointWhileSlowing,
    /// TCP error, horizontal and vertical, over time.
    TcpOverTime,
}

/// What a typical size depends on.
#[derive(Debug, Clone)]
pub struct TypicalSize<'a> {
    /// Kind of the joint.
    pub kind: JointKind,
    /// The target as text.
    pub target: &'a str,
    /// A gap of the joint, deg or mm.
    pub gap: f64,
    /// Least and most of the joint's positions, deg or mm.
    pub window: [f64; 2],
    /// TCP speed, mm/s.
    pub tcp_speed_mm_s: f64,
    /// Duration of the motion, s.
    pub duration_s: f64,
    /// Keys that are given.
    pub given: &'a Mapping,
}

impl TypicalSize<'_> {
    /// `half_gap_deg`, `half_gap_mm`.
    pub fn key(&self, name: &str) -> String {
        format!("{name}_{}", self.kind.unit())
    }

    /// A key that begins so is given.
    pub fn has(&self, start: &str) -> bool {
        self.given.keys().any(|k| k.as_str().is_some_and(|k| k.starts_with(start)))
    }

    /// Whether the joint is revolute.
    pub fn is_revolute(&self) -> bool {
        self.kind == JointKind::Revolute
    }

    /// The three coordinates of a vector, mm, unless one of them is given.
    pub fn xyz_mm(&self, each: f64) -> Vec<(String, Value)> {
        if self.has("x_") || self.has("y_") || self.has("z_") {
            return Vec::new();
        }
        ["x_mm", "y_mm", "z_mm"].map(|k| (k.to_string(), each.into())).to_vec()
    }
}
