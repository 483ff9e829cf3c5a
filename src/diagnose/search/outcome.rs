//! What the search ends with, and what it is made of on the way.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::Score;
use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Problem, State};
use crate::diagnose::search::contradiction::Contradiction;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::geometry;
use crate::diagnose::search::together::share::Story;
use crate::effects::{BacklashPosition, Effect, EffectInstance};

/// Part of a gap by which it varies over position at least, to be worth a schedule.
const FLAT: f64 = 0.01;

/// Effects that fit within this much of 2 ln L of the named one belong to its set.
pub const WITHIN: f64 = 4.0;

/// A candidate refitted with everything else.
#[derive(Debug, Clone)]
pub struct Refined {
    pub effect: &'static str,
    pub target: String,
    pub placed: Vec<EffectInstance>,
    /// Gain in 2 ln L over the hypothesis without it.
    pub gain: f64,
    /// Parameters it adds.
    pub parameters: usize,
    pub fit: Fit,
}

impl Refined {
    /// Gain less the price of the parameters (BIC).
    pub fn merit(&self, price: f64) -> f64 {
        self.gain - price * self.parameters as f64
    }

    /// A gap over position that is the same everywhere.
    pub(in crate::diagnose) fn is_flat(&self) -> bool {
        self.placed.first().is_some_and(|p| flat(&p.effect).is_some())
    }
}

/// What could stand in the place of a found effect, the found one among them.
#[derive(Debug, Clone)]
pub struct Alternative {
    pub effect: &'static str,
    pub target: String,
    /// Gain in 2 ln L over the hypothesis without it.
    pub gain: f64,
    pub parameters: usize,
}

impl Alternative {
    /// Gain less the price of the parameters (BIC).
    pub fn merit(&self, price: f64) -> f64 {
        self.gain - price * self.parameters as f64
    }
}

impl From<&Refined> for Alternative {
    fn from(r: &Refined) -> Self {
        Self { effect: r.effect, target: r.target.clone(), gain: r.gain, parameters: r.parameters }
    }
}

/// One accepted effect, in the order of acceptance.
#[derive(Debug, Clone)]
pub struct Step {
    pub effect: &'static str,
    pub target: String,
    /// A later step put another effect in its place.
    pub replaced_by: Option<String>,
}

impl Step {
    pub(in crate::diagnose) fn new(effect: &'static str, target: String) -> Self {
        Self { effect, target, replaced_by: None }
    }
}

/// An effect that a further round would name.
#[derive(Debug, Clone)]
pub struct Next {
    pub effect: &'static str,
    pub target: String,
    pub axis: Option<usize>,
    /// Gain in 2 ln L.
    pub gain: f64,
    pub parameters: usize,
    pub p_value: f64,
}

/// What the search ends with.
pub struct Outcome {
    pub problem: Problem,
    pub candidates: Vec<Candidate>,
    pub steps: Vec<Step>,
    pub fit: Fit,
    /// Number of known effects: the first of the hypothesis.
    pub known: usize,
    pub whitening: Whitening,
    /// The geometry of a real arm, found as one: the first of the free effects.
    pub group: Option<geometry::Group>,
    /// What a reader should know about the channels, and about what was not named.
    pub notes: Vec<String>,
    /// Rivals of each found effect, with the found one among them, best first.
    pub rivals: Vec<Vec<Alternative>>,
    /// Sizes and chapters where everything was fitted together.
    pub told: Option<Story>,
    pub structure: Tested,
    /// Structure that remains, if it is more than chance.
    pub remains: Option<Ratio>,
    /// What a further round would have named, where the rounds ended at their limit.
    pub next: Option<Next>,
    /// Screening at the end: what is left and what would have been seen.
    pub last: Vec<Score>,
    pub outliers: usize,
    /// What the logs say against what was taken as known.
    pub contradictions: Vec<Contradiction>,
    /// One effect more than the limit of effects.
    pub further: Option<Next>,
    /// rms of the residual: as given, with the frame refitted; and the largest as given.
    pub rms_given: f64,
    pub max_given: f64,
    pub rms_nuisance: f64,
    /// rms of what the named effects leave: curves without a name may describe more of it.
    pub rms_named: f64,
    pub state_nuisance: State,
    /// Price of a parameter in 2 ln L.
    pub price: f64,
}

/// rms per coordinate of the reflectors' residual; of all where none is measured.
pub fn rms(problem: &Problem, residual: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0usize);
    let points = problem.groups.iter().any(|g| g.dims == 3);
    for g in problem.groups.iter().filter(|g| !points || g.dims == 3) {
        sum += residual[g.range()].iter().map(|v| v * v).sum::<f64>();
        n += g.range().len();
    }
    (sum / n.max(1) as f64).sqrt()
}

/// Largest distance between measured and predicted points, m; of joint sensors rad.
pub fn largest(problem: &Problem, residual: &[f64]) -> f64 {
    let mut most = 0.0_f64;
    for g in &problem.groups {
        let (v, n) = (&residual[g.range()], g.len());
        for b in 0..n {
            let squares: f64 = (0..g.dims).map(|c| v[c * n + b] * v[c * n + b]).sum();
            most = most.max(squares.sqrt());
        }
    }
    most
}

/// The size of a gap over position that hardly varies.
pub(in crate::diagnose) fn flat(effect: &Effect) -> Option<f64> {
    let b = effect.get::<BacklashPosition>()?;
    let (least, most) = (b.half_gap.smallest(), b.half_gap.largest());
    (most - least < FLAT * most).then_some(0.5 * (least + most))
}
