//! Everything at once: the whole catalogue fitted together under weak priors, for machines on which everything is wrong.
//!
//! On a real machine ten to twenty effects stand far above the noise, and none of them helps enough alone while the others are
//! missing. Their sizes are micrometres, so that they are nearly linear: the whole catalogue is fitted in one regularised
//! Gauss-Newton refit (a maximum a posteriori fit) through the project's own chain. Groups enter first (lags of all joints and
//! the clock, geometry, gravity, gaps), then friction, drift and ripple by what they gain on held-out blocks; then every
//! member leaves that the held-out blocks do not support.
//!
//! Modules, in the order of the work:
//! - [`prior`]: typical sizes; [`pool`]: the groups and the terms that may join them; [`blocks`]: held-out blocks by linear
//!   algebra; [`triage`]: is this such a machine?; [`members`]: which terms join and which leave; [`alternatives`]: what else a gap may be;
//!   [`beside`]: curves for what has no name; [`considered`]: what was left out, as uncertainty; [`contribution`]: how far each effect
//!   moves the TCP; [`share`]: intervals, the story.
//!
//! Files beside:
//! - `outcome`: the joint fit as an outcome that the document tells

pub(crate) mod alternatives;
pub(crate) mod beside;
pub(crate) mod blocks;
pub(crate) mod considered;
pub(crate) mod contribution;
pub(crate) mod members;
pub(crate) mod outcome;
pub(crate) mod pool;
pub(crate) mod prior;
pub(crate) mod share;
pub(crate) mod triage;

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::sensitivities::Sensitivities;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::prepare;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::search::fit::{self, Fit, Prior};
use crate::effects::{EffectInstance, thermal_growth};

/// A machine fitted with all effects after the known ones free, under the prior and the noise that stand beside.
#[derive(Clone)]
pub struct MachineFit {
    pub fit: Fit,
    pub sensitivities: Sensitivities,
    pub whitening: Whitening,
    pub prior: Prior,
    geometry: prior::Geometry,
    known: usize,
}

impl MachineFit {
    /// Fits a hypothesis of which the first `known` effects are given.
    fn new(problem: &Problem, h: &Hypothesis, known: usize, whitening: Whitening, geometry: prior::Geometry) -> Self {
        let free: Vec<usize> = (known..h.effects.len()).collect();
        let prior = prior::of(problem, h, &free, geometry);
        let (fit, sensitivities) = fit::refit_with_prior(problem, h, &free, &whitening, &prior);
        Self { fit, sensitivities, whitening, prior, geometry, known }
    }

    /// The fit from another hypothesis.
    fn from(self, problem: &Problem, h: &Hypothesis) -> Self {
        Self::new(problem, h, self.known, self.whitening, self.geometry)
    }

    /// The fit under the noise of what it leaves, and the geometry's own width; slow wander of arm and air is noise.
    fn settled(self, problem: &Problem) -> Self {
        let whitening = Whitening::with_wander(problem, &self.fit.state.residual, self.fit.parameters());
        let geometry = self.geometry.of_fit(problem, &self.fit);
        Self::new(problem, &self.fit.hypothesis, self.known, whitening, geometry)
    }

    /// The fit with more effects.
    fn with(self, problem: &Problem, more: Vec<EffectInstance>) -> Self {
        if more.is_empty() {
            return self;
        }
        let mut h = self.fit.hypothesis.clone();
        h.effects.extend(more);
        self.from(problem, &h)
    }

    /// The fit with some of its free effects alone.
    fn keeping(self, problem: &Problem, kept: &[usize]) -> Self {
        if kept.len() == self.fit.free.len() {
            return self;
        }
        let all = &self.fit.hypothesis.effects;
        let effects = all[..self.known].iter().chain(kept.iter().map(|&k| &all[self.fit.free[k]])).cloned().collect();
        let h = Hypothesis { effects, ..self.fit.hypothesis.clone() };
        self.from(problem, &h)
    }
}

/// Rounds in which friction and ripple are sought; the second sees what the first has left.
const ROUNDS: usize = 2;

/// Fits everything, from a hypothesis of known effects and a frame; how many samples were left out.
pub fn run(problem: &mut Problem, start: &Hypothesis) -> (MachineFit, usize) {
    let (mut machine, outliers) = groups(problem, start);
    let mut friction = pool::friction(problem);
    // growth is small: it is sought in what friction and ripple leave
    let growth: Vec<Candidate> = friction.extract_if(.., |c| c.effect == thermal_growth::INFO.name).collect();
    let mut growth = Some(growth);
    for round in 0..ROUNDS {
        machine = machine.settled(problem);
        if round > 0 {
            friction.extend(growth.take().into_iter().flatten());
        }
        let joining = members::join(problem, &machine, &friction);
        machine = machine.with(problem, joining);
        let joining = members::join(problem, &machine, &pool::ripple(problem, &machine));
        machine = machine.with(problem, joining);
    }
    machine = machine.settled(problem);
    let curved = members::curved(problem, &machine);
    if curved.effects != machine.fit.hypothesis.effects {
        machine = machine.from(problem, &curved);
    }
    let kept = members::supported(problem, &machine);
    machine = machine.keeping(problem, &kept).settled(problem);
    for _ in 0..ROUNDS {
        // under the noise of what is left now, a member of the geometry may support no more
        let support = members::support(problem, &machine);
        let kept: Vec<usize> = (0..support.len()).filter(|&k| support[k] > 0.0).collect();
        if kept.len() == support.len() {
            break;
        }
        machine = machine.keeping(problem, &kept).settled(problem);
    }
    (machine, outliers)
}

/// The groups that every machine has, without the outliers that stand out of them; how many were left out.
fn groups(problem: &mut Problem, start: &Hypothesis) -> (MachineFit, usize) {
    let known = start.effects.len();
    let mut h = start.clone();
    h.effects.extend(pool::core(problem, &h));
    let white = |problem: &Problem, h: &Hypothesis| Whitening::white(problem, &problem.evaluate(h).residual);
    let mut machine = MachineFit::new(problem, &h, known, white(problem, &h), prior::Geometry::default());
    if let Some(clock) = pool::clock(&machine.fit) {
        machine = machine.with(problem, vec![clock]);
    }
    let mut outliers = prepare::drop_spikes(problem, &machine.fit.state);
    let state = problem.evaluate(&machine.fit.hypothesis);
    outliers += prepare::drop_single(problem, &state.residual);
    let h = machine.fit.hypothesis;
    let white = white(problem, &h);
    (MachineFit::new(problem, &h, known, white, prior::Geometry::default()), outliers)
}
