//! What a diagnosis tries of an effect: one effect on one target with its shape held, linear in what is left.
//!
//! An effect whose equation is linear in its size has one trial; a shape that is not linear (a decay, a presliding) gives one
//! candidate for each of a few values, and a refit frees it later. The sensitivity of a coefficient is the difference of the
//! prediction with and without its trial, divided by the trial's size; the diagnosis computes it with the whole chain.

use super::{Effect, EffectInstance, Family, Stage, Target};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Makes effects of linear coefficients.
type Build = Box<dyn Fn(&[f64]) -> Vec<EffectInstance> + Send + Sync>;

/// Size at which joint effects are tried, rad or m: far below any gap, so that the sensitivity is that of a small one.
pub const TRIAL: f64 = 2e-6;

/// One effect on one target with its shape held.
pub struct Candidate {
    /// Name of the effect.
    pub effect: &'static str,
    /// Its target, as documents print it.
    pub target: String,
    /// Effects whose predictions are compared with, one per linear coefficient, each at its size; where `base` stands, it is
    /// taken off.
    pub trial: Vec<(Vec<EffectInstance>, f64)>,
    /// Effects that the trials are compared with; `None`: nothing.
    pub base: Option<Vec<EffectInstance>>,
    /// The log in which each trial acts; empty: in all.
    pub acts_in: Vec<usize>,
    /// The first coefficient may not be negative: a gap, a spike, a lag.
    pub positive: bool,
    /// Parameters that the shape holds.
    pub shape_parameters: usize,
    /// Forms of one effect that a refit cannot turn into each other.
    pub form: &'static str,
    /// First coefficient of those that say its size ([`super::EffectType::magnitude`]).
    pub sized_from: usize,
    /// Its coefficients are the coordinates of one vector.
    pub is_vector: bool,
    build: Build,
}

/// Form of a friction that fades over travel, not over time.
pub const OVER_TRAVEL: &str = "travel";

impl Candidate {
    /// Whether it is this effect on this target, with whatever values.
    pub fn names(&self, found: &EffectInstance, robot: &Robot) -> bool {
        found.effect.name() == self.effect && found.target_text(robot) == self.target
    }

    /// An effect with one coefficient: `make(size)`, tried at `trial`.
    pub fn of_size<E: Into<Effect>>(
        robot: &Robot,
        target: Target,
        trial: f64,
        make: impl Fn(f64) -> E + Send + Sync + 'static,
    ) -> Self {
        Self::of_sizes(robot, target, &[trial], move |c| make(c[0]))
    }

    /// An effect with several coefficients, each tried alone at its own size.
    pub fn of_sizes<E: Into<Effect>>(
        robot: &Robot,
        target: Target,
        trials: &[f64],
        make: impl Fn(&[f64]) -> E + Send + Sync + 'static,
    ) -> Self {
        let alone = |k: usize| (0..trials.len()).map(|i| if i == k { trials[k] } else { 0.0 }).collect::<Vec<f64>>();
        let placed = |c: &[f64]| vec![EffectInstance::new(target, make(c))];
        let trial: Vec<_> = trials.iter().enumerate().map(|(k, size)| (placed(&alone(k)), *size)).collect();
        let effect = trial.first().and_then(|t| t.0.first()).map_or("", |p| p.effect.name());
        Self {
            effect,
            target: target.text(robot),
            trial,
            base: None,
            acts_in: Vec::new(),
            positive: false,
            shape_parameters: 0,
            form: "",
            sized_from: 0,
            is_vector: false,
            build: Box::new(move |c| vec![EffectInstance::new(target, make(c))]),
        }
    }

    /// Three coefficients: the coordinates of a vector, m.
    pub fn of_vector<E: Into<Effect>>(
        robot: &Robot,
        target: Target,
        trial: f64,
        make: impl Fn(Vector3<f64>) -> E + Send + Sync + 'static,
    ) -> Self {
        let one = Self::of_sizes(robot, target, &[trial; 3], move |c| make(Vector3::new(c[0], c[1], c[2])));
        Self { is_vector: true, ..one }
    }

    /// Its size is 0 or more.
    pub fn positive(mut self) -> Self {
        self.positive = true;
        self
    }

    /// Parameters that its shape holds.
    pub fn with_shape(mut self, parameters: usize) -> Self {
        self.shape_parameters = parameters;
        self
    }

    /// A form that a refit cannot turn into another.
    pub fn with_form(mut self, form: &'static str) -> Self {
        self.form = form;
        self
    }

    /// Its size is that of the coefficients from this one on.
    pub fn sized_from(mut self, first: usize) -> Self {
        self.sized_from = first;
        self
    }

    /// What its coefficients make, where that is not what its trials make.
    pub fn built_by<E: Into<Effect>>(
        mut self,
        target: Target,
        make: impl Fn(&[f64]) -> E + Send + Sync + 'static,
    ) -> Self {
        self.build = Box::new(move |c| vec![EffectInstance::new(target, make(c))]);
        self
    }

    /// Trials beside a base that is taken off.
    pub fn beside(mut self, base: Vec<EffectInstance>, trial: Vec<(Vec<EffectInstance>, f64)>) -> Self {
        self.base = Some(base);
        self.trial = trial;
        self
    }

    /// Its trials in each of `logs` logs alone, those of the first log first.
    pub fn in_each_log(mut self, logs: usize) -> Self {
        let count = self.trial.len();
        self.trial = (0..logs).flat_map(|_| self.trial.clone()).collect();
        self.acts_in = (0..logs).flat_map(|l| std::iter::repeat_n(l, count)).collect();
        self
    }

    /// Linear coefficients and shape parameters.
    pub fn parameters(&self) -> usize {
        self.trial.len() + self.shape_parameters
    }

    /// Number of linear coefficients.
    pub fn sensitivities(&self) -> usize {
        self.trial.len()
    }

    /// It is linear and depends on the pose alone: geometry, couplings, gravity.
    pub fn depends_on_pose(&self) -> bool {
        let of_pose = |p: &EffectInstance| {
            matches!(p.effect.stage(), Stage::Link | Stage::Geometry) && p.effect.info().family != Family::Drift
        };
        self.shape_parameters == 0 && self.trial.iter().flat_map(|t| &t.0).all(of_pose)
    }

    /// It moves the TCP in the flange.
    pub fn is_on_tool(&self) -> bool {
        self.trial.iter().flat_map(|t| &t.0).any(|p| p.target == Target::Tool)
    }

    /// The joint whose position it changes.
    pub fn axis(&self) -> Option<usize> {
        self.trial.first().and_then(|t| t.0.first()).and_then(EffectInstance::axis)
    }

    /// The effects at the given coefficients.
    pub fn at(&self, coefficients: &[f64]) -> Vec<EffectInstance> {
        (self.build)(coefficients)
    }
}

/// What is known of the logs before anything is tried.
#[derive(Debug, Clone)]
pub struct Survey<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What is known of each axis.
    pub axes: Vec<AxisSurvey>,
    /// Length of the shortest sample interval and of the longest log, s; `None` for poses alone.
    pub clock: Option<(f64, f64)>,
    /// Fastest commanded TCP speed, m/s, above 0.
    pub fastest_m_s: f64,
    /// Points were measured, or readings of the TCP.
    pub points: bool,
    /// By a tracker.
    pub tracker: bool,
    /// Its frame is given, not estimated.
    pub frame_known: bool,
    /// A log is a motion.
    pub motion: bool,
    /// The temperature was logged.
    pub temperature: bool,
    /// The one joint that is asked after, where forms of more freedom are tried; `None`: every joint.
    pub only: Option<usize>,
}

/// The same of one axis, over all logs; rad or m.
#[derive(Debug, Clone, Default)]
pub struct AxisSurvey {
    /// Largest position less the smallest one.
    pub travel: f64,
    /// Smallest and largest position.
    pub range: [f64; 2],
    /// Gravity's torque about it is not zero throughout.
    pub loaded: bool,
    /// Largest torque of gravity about it, either way, Nm or N.
    pub load: f64,
    /// A force on the tool was logged that turns it.
    pub pressed: bool,
    /// Fastest command, rad/s or m/s; 0 for poses.
    pub fastest: f64,
    /// The torque of its drive was logged; its least and most, Nm or N, else those of gravity.
    pub torque_measured: bool,
    /// Smallest and largest torque of its drive, or of gravity, Nm or N.
    pub torque: [f64; 2],
}

impl<'a> Survey<'a> {
    /// Nothing is known of the logs.
    pub fn nothing(robot: &'a Robot) -> Self {
        let axes = vec![AxisSurvey::default(); robot.dof()];
        Self {
            robot,
            axes,
            clock: None,
            fastest_m_s: 1e-6,
            points: false,
            tracker: false,
            frame_known: false,
            motion: false,
            temperature: false,
            only: None,
        }
    }
}

impl Survey<'_> {
    /// Axes that move far enough for an effect of their motion to show.
    pub fn moving(&self) -> impl Iterator<Item = usize> {
        self.all_axes().filter(|&a| {
            let unit = self.robot.axis(a).kind.si_per_user_unit();
            self.axes[a].travel >= 1e-4 * unit.max(1e-2)
        })
    }

    /// Every axis that is asked after.
    pub fn all_axes(&self) -> std::ops::Range<usize> {
        self.only.map_or(0..self.axes.len(), |axis| axis..axis + 1)
    }
}

/// Shortest travel over which something is tried to build up or fade, deg or mm.
const SHORTEST_TRAVEL: f64 = 0.01;

impl Survey<'_> {
    /// Travels over which something may build up or fade on an axis, each `ratio` times the one before; rad or m.
    pub fn travels(&self, axis: usize, ratio: f64) -> Vec<f64> {
        let first = SHORTEST_TRAVEL * self.robot.axis(axis).kind.si_per_user_unit();
        let rising = std::iter::successors(Some(first), |x| Some(x * ratio));
        rising.take_while(|x| *x < 0.5 * self.axes[axis].travel).collect()
    }
}
