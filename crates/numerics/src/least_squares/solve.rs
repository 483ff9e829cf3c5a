//! The loop: damped steps until nothing is left to gain, and why it stopped.

use super::{Flow, Information, LinearModel, Problem, Progress};
use nalgebra::DMatrix;

/// What the damping is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// Norms of the columns at the point (Marquardt 1963).
    Columns,
    /// The largest norm of each column so far (Moré 1978): a parameter that lost its effect does not run away.
    LargestColumns,
    /// The largest norm of all columns: parameters are of one kind, and the step of least norm is wanted.
    Uniform,
}

/// Settings of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Steps at most.
    pub max_steps: usize,
    /// Share of the cost: a step that gains less, and was predicted to, is the last.
    pub cost_tolerance: f64,
    /// The same as a number, in the unit of the cost.
    pub cost_tolerance_absolute: f64,
    /// Largest cosine between the residuals and a column of the Jacobian at a minimum.
    pub gradient_tolerance: f64,
    /// Share of the parameters' norm: a smaller step is the last.
    pub step_tolerance: f64,
    /// Damping of the first step: above 1 a fit from far off does not leap into another valley; 1e-3 or less is faster
    /// where the start is good.
    pub initial_damping: f64,
    /// Damping below which good steps lower it no further.
    pub least_damping: f64,
    /// Damping at which no step helps any more.
    pub most_damping: f64,
    /// Least factor of the damping after a good step.
    pub least_easing: f64,
    /// What the damping is measured in.
    pub scaling: Scaling,
    /// Whether the linear model is computed again at the last point, so that the covariance belongs to it.
    pub model_at_end: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_steps: 1000,
            cost_tolerance: 0.0,
            cost_tolerance_absolute: 0.0,
            gradient_tolerance: 1e-15,
            step_tolerance: 1e-14,
            initial_damping: 1e3,
            least_damping: 1e-15,
            most_damping: 1e16,
            least_easing: 1.0 / 3.0,
            scaling: Scaling::LargestColumns,
            model_at_end: true,
        }
    }
}

/// By which criterion a fit converged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// The residuals are at right angles to all columns.
    Gradient,
    /// No step is predicted to gain anything worth having, or the last one did not.
    Cost,
    /// The last step was too small to matter.
    Step,
    /// What is left to gain is below the rounding of the cost.
    Rounding,
    /// The problem's own.
    Caller,
}

/// Why a fit stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TerminationReason {
    /// A criterion is met.
    Converged(Criterion),
    /// No step reduces the cost although one should: a kink, a wrong derivative, or a bound.
    NoProgress,
    /// The steps are used up and the cost still falls.
    StepLimit,
    /// The cost at the start, or the linear model, is not finite.
    NotFinite,
    /// The problem gave the fit up.
    Abandoned,
}

impl TerminationReason {
    /// Whether a criterion of convergence is met.
    pub fn converged(self) -> bool {
        matches!(self, Self::Converged(_))
    }

    /// In words, for documents.
    pub fn text(self) -> &'static str {
        match self {
            Self::Converged(_) => "converged",
            Self::NoProgress => "no progress",
            Self::StepLimit => "step limit",
            Self::NotFinite => "not finite",
            Self::Abandoned => "abandoned",
        }
    }
}

/// Where a fit ended, and why.
#[must_use = "a fit may not have converged: look at `reason`"]
pub struct Solution<P: Problem> {
    /// The best point seen.
    pub point: P::Point,
    /// Its evaluation.
    pub state: P::State,
    /// Sum of squares there.
    pub cost: f64,
    /// Why the fit stopped.
    pub reason: TerminationReason,
    /// Steps taken.
    pub steps: usize,
    /// Points evaluated.
    pub evaluations: usize,
    /// The last linear model; none where nothing was linearised.
    pub model: Option<P::Model>,
}

impl<P: Problem> Solution<P> {
    /// Rank, condition and inverse of the last linear model.
    pub fn information(&self) -> Information {
        self.model.as_ref().map_or_else(|| Information::of_gram(&DMatrix::zeros(0, 0)), LinearModel::information)
    }

    /// Covariance for residuals of variance `variance`; `None` where the fit did not converge or a direction is open.
    pub fn covariance(&self, variance: f64) -> Option<DMatrix<f64>> {
        self.reason.converged().then(|| self.information().covariance(variance)).flatten()
    }
}

/// Gain, over the cost, that the rounding of the cost hides.
const HIDDEN: f64 = 1e-14;
/// Share of the step before that a step may have where its gain is hidden.
const SHRINKS: f64 = 0.9;

/// Minimises from `start`.
pub fn minimise<P: Problem>(problem: &mut P, start: P::Point, options: &Options) -> Solution<P> {
    let state = problem.evaluate(&start);
    let cost = problem.cost(&start, &state);
    let reason = TerminationReason::StepLimit;
    let at = Solution { point: start, state, cost, reason, steps: 0, evaluations: 1, model: None };
    let damping = options.initial_damping;
    let (gain, size) = (f64::INFINITY, f64::INFINITY);
    let mut run = Run { at, damping, growth: 2.0, gain, size, stale: true, largest: Vec::new(), options };
    let reason = run.until_the_end(problem);
    if options.model_at_end && run.stale && reason != TerminationReason::NotFinite {
        run.at.model = Some(problem.linearise(&run.at.point, &run.at.state));
    }
    Solution { reason, ..run.at }
}

struct Run<'a, P: Problem> {
    /// The point reached, with the last linear model.
    at: Solution<P>,
    damping: f64,
    /// Factor by which the next failure raises the damping.
    growth: f64,
    /// Fall of the cost in the last step.
    gain: f64,
    /// Relative size of the last step.
    size: f64,
    /// Whether a step was taken since the model was computed.
    stale: bool,
    /// Largest squared norm of each column so far.
    largest: Vec<f64>,
    options: &'a Options,
}

/// What a round of attempts came to.
enum Outcome {
    /// A step was taken; the fit goes on.
    Moved,
    /// The fit ends where it stands.
    Ended(TerminationReason),
}

impl<P: Problem> Run<'_, P> {
    fn until_the_end(&mut self, problem: &mut P) -> TerminationReason {
        if !self.at.cost.is_finite() {
            return TerminationReason::NotFinite;
        }
        loop {
            let progress = Progress { steps: self.at.steps, cost: self.at.cost, gain: self.gain };
            match problem.judge(&self.at.point, &self.at.state, &progress) {
                Flow::Continue => {}
                Flow::Reached => return TerminationReason::Converged(Criterion::Caller),
                Flow::Abandon => return TerminationReason::Abandoned,
            }
            if self.at.steps >= self.options.max_steps {
                return TerminationReason::StepLimit;
            }
            let model = problem.linearise(&self.at.point, &self.at.state);
            self.stale = false;
            self.at.cost = problem.cost(&self.at.point, &self.at.state);
            let mut held = vec![false; model.gradient().len()];
            problem.hold(&self.at.point, model.gradient(), &mut held);
            let outcome = match self.gradient_vanishes(&model, &held) {
                None => Outcome::Ended(TerminationReason::NotFinite),
                Some(true) => Outcome::Ended(TerminationReason::Converged(Criterion::Gradient)),
                Some(false) => self.attempts(problem, &model, &held),
            };
            self.at.model = Some(model);
            if let Outcome::Ended(reason) = outcome {
                return reason;
            }
        }
    }

    /// Whether the free columns are at right angles to the residuals; `None` where the model is not finite.
    fn gradient_vanishes(&self, model: &P::Model, held: &[bool]) -> Option<bool> {
        if !model.gradient().iter().chain(model.squared_norms()).all(|v| v.is_finite()) {
            return None;
        }
        let small = |(k, g): (usize, &f64)| {
            let longest = (model.squared_norms()[k] * self.at.cost).sqrt();
            held[k] || g.abs() <= self.options.gradient_tolerance * longest
        };
        Some(model.gradient().iter().enumerate().all(small))
    }

    /// Squared norms that the damping is measured in.
    fn scales(&mut self, model: &P::Model) -> Vec<f64> {
        let norms = model.squared_norms();
        let largest = norms.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        match self.options.scaling {
            Scaling::Uniform => vec![largest; norms.len()],
            // a column of zeros would leave its parameter undamped
            Scaling::Columns => norms.iter().map(|v| v.max(1e-12 * largest)).collect(),
            Scaling::LargestColumns => {
                self.largest.resize(norms.len(), 0.0);
                self.largest.iter_mut().zip(norms).for_each(|(l, v)| *l = l.max(v.max(1e-12 * largest)));
                self.largest.clone()
            }
        }
    }

    /// Tries steps, more damped from one to the next, until one lowers the cost.
    fn attempts(&mut self, problem: &mut P, model: &P::Model, held: &[bool]) -> Outcome {
        let options = self.options;
        let scales = self.scales(model);
        while self.damping <= options.most_damping {
            let weights: Vec<f64> = scales.iter().map(|s| s * self.damping).collect();
            let Some((next, change)) = self.bounded_step(problem, model, &weights, held) else {
                self.raise();
                continue;
            };
            let slope: f64 = model.gradient().iter().zip(&change).map(|(g, s)| g * s).sum();
            let predicted = -2.0 * slope - model.image_squared(&change);
            if predicted.is_nan() || predicted <= 0.0 && change.iter().any(|s| *s != 0.0) {
                // a bound cut one parameter off and the damping kept the others from following
                self.raise();
                continue;
            }
            if predicted < options.cost_tolerance_absolute {
                return Outcome::Ended(TerminationReason::Converged(Criterion::Cost));
            }
            let size = problem.relative_change(&self.at.point, &change);
            let small = size <= options.step_tolerance;
            let state = problem.evaluate(&next);
            self.at.evaluations += 1;
            let cost = problem.cost(&next, &state);
            let gain = self.at.cost - cost;
            // a gain that rounding hides: steps are taken while each is smaller than the one before
            let hidden = predicted <= HIDDEN * self.at.cost;
            let shrinks = hidden && gain >= -HIDDEN * self.at.cost && size <= SHRINKS * self.size;
            if shrinks || (!hidden && gain > 0.0) {
                self.size = size;
                (self.at.point, self.at.state, self.at.cost) = (next, state, cost);
                self.at.steps += 1;
                self.gain = gain;
                self.stale = true;
                self.ease(if hidden { 1.0 } else { gain / predicted });
                return self.after(gain, predicted, small);
            }
            if hidden || small {
                let by = if hidden { Criterion::Rounding } else { Criterion::Step };
                return Outcome::Ended(TerminationReason::Converged(by));
            }
            self.raise();
        }
        Outcome::Ended(TerminationReason::NoProgress)
    }

    /// The damped step; where bounds cut parameters off, the others are solved again with those where they were cut.
    fn bounded_step(
        &self,
        problem: &P,
        model: &P::Model,
        weights: &[f64],
        held: &[bool],
    ) -> Option<(P::Point, Vec<f64>)> {
        let mut held = held.to_vec();
        let mut at = vec![0.0; held.len()];
        loop {
            let asked = model.step(weights, &held, &at)?;
            let mut change = asked.clone();
            let next = problem.moved(&self.at.point, &mut change);
            let cut: Vec<usize> = (0..held.len()).filter(|&k| !held[k] && change[k] != asked[k]).collect();
            if cut.is_empty() {
                return Some((next, change));
            }
            for k in cut {
                held[k] = true;
                at[k] = change[k];
            }
        }
    }

    /// Whether a step that was taken is the last.
    fn after(&self, gain: f64, predicted: f64, small: bool) -> Outcome {
        let worth = self.options.cost_tolerance * (self.at.cost + gain);
        let settled = gain <= worth && predicted <= worth || gain < self.options.cost_tolerance_absolute;
        let by = match () {
            () if settled => Criterion::Cost,
            () if small => Criterion::Step,
            () => return Outcome::Moved,
        };
        Outcome::Ended(TerminationReason::Converged(by))
    }

    fn ease(&mut self, ratio: f64) {
        let factor = (1.0 - (2.0 * ratio - 1.0).powi(3)).max(self.options.least_easing);
        self.damping = (self.damping * factor.min(2.0)).max(self.options.least_damping);
        self.growth = 2.0;
    }

    fn raise(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
    }
}
