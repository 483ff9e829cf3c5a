//! What every effect implements ([`EffectType`]), a value of any of them ([`Effect`]), and one at its place ([`EffectInstance`]).
//!
//! Only what an effect does differently from doing nothing has to be written: every hook of the chain has a default. Values are SI
//! (rad or m, s, Nm or N).

use super::{Clock, Decay, EffectInfo, GapCurve, Nature, Parameter, Site, Stage, Target, Track};
use super::{Geometry, Idle, Inputs, Row, WhyIdle};
use crate::robot::Robot;
use nalgebra::Vector3;
use serde_yaml::Mapping;
use std::any::Any;
use std::fmt::Debug;
use std::ops::Deref;
use std::sync::Arc;

/// An effect of the catalogue: its equation, its parameters and what undoes it.
pub trait EffectType: EffectObject + Debug + Send + Sync {
    /// What holds for all values: name, stage, words, how an entry is read, what a diagnosis tries.
    fn info(&self) -> &'static EffectInfo;

    /// Free parameters, SI, in the order of [`Self::parameters`].
    fn values(&self) -> Vec<f64>;

    /// The same effect with other values, as many as [`Self::values`] has.
    fn with(&self, values: &[f64]) -> Effect;

    /// Key, unit, bounds and typical size of each value.
    fn parameters(&self, site: &Site) -> Vec<Parameter>;

    /// Puts the parameters into the entry of a model file: each under its key.
    fn write(&self, site: &Site, entry: &mut Mapping) {
        for (parameter, value) in self.parameters(site).iter().zip(self.values()) {
            entry.insert(parameter.key.clone().into(), (value * parameter.user_units_per_si).into());
        }
    }

    /// The parameters in a few words for a page: each with its key.
    fn brief(&self, site: &Site) -> String {
        let each = self.parameters(site);
        let each = each.iter().zip(self.values()).map(|(p, v)| format!("{} {}", p.key, short(v * p.user_units_per_si)));
        each.collect::<Vec<_>>().join(", ")
    }

    /// Where in the chain it acts, where that depends on its form.
    fn stage(&self) -> Stage {
        self.info().stage
    }

    /// Servo and gear: turns the arriving signal (rad or m, one value per sample of `track`) into the leaving one, in place.
    fn apply(&self, track: &Track, signal: &mut [f64]) {
        if self.position_error(0.0, track.rev).is_some() {
            for s in signal {
                *s += self.position_error(*s, track.rev).unwrap_or(0.0);
            }
        }
    }

    /// Gear: what it adds to an arriving position, where that position alone decides; `rev` is one turn of the joint (2 pi
    /// rad, or the lead of a screw in m).
    fn position_error(&self, _arriving: f64, _rev: f64) -> Option<f64> {
        None
    }

    /// Link: adds its part of the joint's position, row by row, rad or m.
    fn add_to_joint(&self, _target: Target, _inputs: &dyn Inputs, _joint: &mut [f64]) {}

    /// Geometry: changes the kinematic parameters.
    fn change_geometry(&self, _target: Target, _geometry: &mut Geometry) {}

    /// After the kinematics: how far a point of the tool is moved, m, base frame.
    fn displacement_m(&self, _target: Target, _row: &Row, _point_m: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// [`Self::displacement_m`] is not zero everywhere.
    fn displaces(&self) -> bool {
        false
    }

    /// It looks at [`Row::frames`].
    fn uses_frames(&self) -> bool {
        false
    }

    /// Measurement: the measurement at a time shows the robot at another one.
    fn clock(&self) -> Clock {
        Clock::default()
    }

    /// It remembers where the joint came from, so that it depends on turning points and not on the present alone.
    fn has_memory(&self) -> bool {
        false
    }

    /// It looks at the commanded TCP speed ([`Track::tcp_speed_m_s`]).
    fn uses_tcp_speed(&self) -> bool {
        false
    }

    /// It looks at the torque of gravity ([`Track::load`]), which may change while the joint is stationary.
    fn uses_load(&self) -> bool {
        false
    }

    /// The joint stands still after a reversal until the command has moved this far, rad or m; 0: it does not.
    fn sticks_by(&self) -> f64 {
        0.0
    }

    /// It filters the command in time, so that its output turns elsewhere than the command: [`Self::turning_points`].
    fn filters_in_time(&self) -> bool {
        false
    }

    /// Where the output of a filter turns between samples: `(sample before, t in s, command there)`.
    fn turning_points(&self, _track: &Track) -> Vec<(usize, f64, f64)> {
        Vec::new()
    }

    /// It looks at [`Inputs::gravity_torque`].
    fn uses_gravity(&self) -> bool {
        false
    }

    /// It is a play: several in series act as one of their sum.
    fn is_play(&self) -> bool {
        false
    }

    /// Half of what a joint loses at a reversal, once it is through it, as a function of position; at rest, where it depends on
    /// the speed.
    fn half_gap(&self) -> Option<GapCurve> {
        None
    }

    /// Half of the largest error after a reversal, rad or m.
    fn largest_after_reversal(&self) -> Option<f64> {
        self.half_gap().map(|b| b.largest())
    }

    /// Travel after a reversal over which the error builds up or fades, rad or m.
    fn transition(&self) -> Option<f64> {
        self.largest_after_reversal().filter(|b| *b > 0.0).map(|b| 2.0 * b)
    }

    /// One number for its size, in the unit of the coefficients of its candidates.
    fn magnitude(&self) -> f64 {
        self.values().first().map_or(0.0, |v| v.abs())
    }

    /// Which value is a phase, which goes round instead of stopping at a bound.
    fn phase(&self) -> Option<usize> {
        None
    }

    /// Is this value a phase, too?
    fn is_phase(&self, value: usize) -> bool {
        self.phase() == Some(value)
    }

    /// Is this value a threshold, beyond which something else happens? What it does comes in steps: a derivative tells little of it.
    fn is_threshold(&self, _value: usize) -> bool {
        false
    }

    /// It is a form with more freedom, which a diagnosis tries where the plain ones leave something.
    fn is_wider(&self) -> bool {
        false
    }

    /// Rows that follow each other after this time, s, show its course.
    fn is_sampled(&self, _step_s: f64) -> bool {
        true
    }

    /// The next form with less freedom, with values near its own; `None`: there is none.
    fn plainer(&self) -> Option<Effect> {
        None
    }

    /// The same with a shape that is no parameter of a fit, at most so many times `longest_s`, the length of the longest log, which does
    /// not tell it; `None`: it has no such form.
    fn with_held_shape(&self, _longest_s: f64, _times: f64) -> Option<Effect> {
        None
    }

    /// Which value is the shape that [`Self::with_held_shape`] holds.
    fn shape(&self) -> Option<usize> {
        None
    }

    /// What to do at the machine, where that depends on its form.
    fn action(&self) -> &'static str {
        self.info().action
    }

    /// What it is in one log (by its place in the list), where that is not what it is in the first.
    fn in_log(&self, _log: usize) -> Option<Effect> {
        None
    }

    /// What it is belongs to the logs that it was found in: another run does not have it.
    fn of_its_logs_alone(&self) -> bool {
        false
    }

    /// What other modules treat apart.
    fn nature(&self) -> Nature {
        Nature::Other
    }

    /// Why it does nothing on this robot, or in settled poses.
    fn idle(&self, _site: &Site, _settled_poses: bool) -> Option<&'static str> {
        None
    }

    /// Columns of a log that it follows, where these inputs hold none of them: it then does nothing.
    fn without_columns(&self, _target: Target, _inputs: &dyn Inputs) -> Option<&'static str> {
        None
    }

    /// What `rewrite` undoes of it.
    fn undo(&self, context: &UndoContext) -> Undo;
}

/// What [`EffectType`] needs of a type; every `PartialEq` type has it.
pub trait EffectObject: Any {
    /// The effect as its own type.
    fn as_any(&self) -> &dyn Any;
    /// Whether the other effect is of the same type with the same values.
    fn equals(&self, other: &dyn EffectType) -> bool;
}

impl<T: EffectType + PartialEq> EffectObject for T {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn equals(&self, other: &dyn EffectType) -> bool {
        other.as_any().downcast_ref::<T>().is_some_and(|o| self == o)
    }
}

/// An effect with its values.
#[derive(Clone)]
pub struct Effect(Arc<dyn EffectType>);

impl Effect {
    /// An effect of the catalogue from its values.
    pub fn new(effect: impl EffectType) -> Self {
        Self(Arc::new(effect))
    }

    /// Name in the catalogue.
    pub fn name(&self) -> &'static str {
        self.info().name
    }

    /// The effect as its own type, if it is one of that.
    pub fn get<T: EffectType>(&self) -> Option<&T> {
        self.0.as_any().downcast_ref()
    }

    /// The same effect with other values; one that is missing stays.
    pub fn with_values(&self, values: &[f64]) -> Self {
        let mut all = self.values();
        for (old, new) in all.iter_mut().zip(values) {
            *old = *new;
        }
        self.with(&all)
    }
}

impl Deref for Effect {
    type Target = dyn EffectType;

    fn deref(&self) -> &Self::Target {
        self.0.as_ref()
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.equals(other.0.as_ref())
    }
}

impl Debug for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl<T: EffectType> From<T> for Effect {
    fn from(effect: T) -> Self {
        Self::new(effect)
    }
}

/// Notes on effects that do nothing in any of these logs or programs, because the columns that they follow are in none.
pub fn without_columns(effects: &[EffectInstance], robot: &Robot, inputs: &[&dyn Inputs]) -> Vec<Idle> {
    let note = |e: &EffectInstance| {
        let missing: Option<Vec<&'static str>> =
            inputs.iter().map(|i| e.effect.without_columns(e.target, *i)).collect();
        let columns = missing?.first().copied()?;
        Some(Idle { effect: e.effect.name(), target: e.target_text(robot), why: WhyIdle::NoColumn(columns) })
    };
    effects.iter().filter_map(note).collect()
}

/// An effect at its place.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectInstance {
    /// Where it acts.
    pub target: Target,
    /// The effect with its values.
    pub effect: Effect,
}

impl EffectInstance {
    /// An effect at a target.
    pub fn new(target: Target, effect: impl Into<Effect>) -> Self {
        Self { target, effect: effect.into() }
    }

    /// An effect on one axis.
    pub fn on_axis(axis: usize, effect: impl Into<Effect>) -> Self {
        Self::new(Target::Joint(axis), effect)
    }

    /// Its target on a robot.
    pub fn site<'a>(&self, robot: &'a Robot) -> Site<'a> {
        Site { robot, target: self.target }
    }

    /// The axis whose position it changes.
    pub fn axis(&self) -> Option<usize> {
        self.target.axis()
    }

    /// As a reader knows it: "A1", "A2.a", "A6<-A5", "tool", "tcp", "log".
    pub fn target_text(&self, robot: &Robot) -> String {
        self.target.text(robot)
    }

    /// Its name and its target, as documents give them.
    pub fn named(&self, robot: &Robot) -> (&'static str, String) {
        (self.effect.name(), self.target_text(robot))
    }

    /// Keys, bounds and typical sizes of the values, in the order of [`EffectType::values`].
    pub fn parameters(&self, robot: &Robot) -> Vec<Parameter> {
        self.effect.parameters(&self.site(robot))
    }

    /// Keys of the parameters in a model file, and the factor from SI to their unit. Knots are `knots[0]`, ...; the coordinates
    /// of a vibration's amplitude are `amplitude_um[0]`, ... (in a file they stand as amplitude and direction).
    pub fn keys(&self, robot: &Robot) -> Vec<(String, f64)> {
        self.parameters(robot).into_iter().map(|p| (p.key, p.user_units_per_si)).collect()
    }

    /// Least and most of each value, SI.
    pub fn bounds(&self, robot: &Robot) -> Vec<(f64, f64)> {
        self.parameters(robot).into_iter().map(|p| (p.least, p.most)).collect()
    }
}

/// What else is known where an effect is to be undone.
#[derive(Debug, Clone, Copy)]
pub struct UndoContext<'a> {
    /// The target and its robot.
    pub site: Site<'a>,
    /// TCP speed of the program, where it is known.
    pub tcp_speed_m_s: Option<f64>,
    /// It is the only effect with memory on its joint.
    pub alone: bool,
}

/// What `rewrite` undoes of an effect.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Undo {
    /// An offset of this half gap in the direction of travel.
    pub gap: Option<GapCurve>,
    /// An offset after each reversal: its size, with the sign of the new movement, and how it fades.
    pub friction: Option<(f64, Decay)>,
    /// The commands of the moment fix the error: it is taken off point by point.
    pub point_by_point: bool,
    /// What is left, and why.
    pub left: Option<&'static str>,
}

impl Undo {
    /// Nothing can be done by offsets.
    pub fn nothing(why: &'static str) -> Self {
        Self { left: Some(why), ..Self::default() }
    }

    /// It shows in poses, not in joints.
    pub fn moves_poses() -> Self {
        Self::nothing("it moves poses, not joints: correct it in the kinematics")
    }

    /// It follows the measured torque.
    pub fn needs_torque() -> Self {
        Self::nothing("a program contains no torque")
    }

    /// A gap of this half width.
    pub fn gap(half_gap: GapCurve) -> Self {
        Self { gap: Some(half_gap), ..Self::default() }
    }

    /// The error depends on the commands of the moment alone.
    pub fn point_by_point() -> Self {
        Self { point_by_point: true, ..Self::default() }
    }
}

/// A number with six digits at most.
pub fn short(v: f64) -> String {
    let digits = if v == 0.0 { 0 } else { (5 - v.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
