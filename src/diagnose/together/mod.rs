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
//!   algebra; [`members`]: which terms join and which leave; [`share`]: what each term does to the TCP, intervals, the story.

pub mod blocks;
pub mod members;
pub mod outcome;
pub mod pool;
pub mod prior;
pub mod share;

use super::fit::{self, Fit};
use super::forward::{Hypothesis, Problem};
use super::prepare;
use super::signatures::Signatures;
use super::whitening::Whitening;

/// What the joint fit ends with.
pub struct Found {
    pub fit: Fit,
    pub whitening: Whitening,
    /// Gain on held-out blocks of each free effect beside all the others, in 2 ln L.
    pub support: Vec<f64>,
    pub story: share::Story,
    pub outliers: usize,
}

/// Rounds in which friction and ripple are sought; the second sees what the first has left.
const ROUNDS: usize = 2;

/// Fits everything, from a hypothesis of known effects and a frame.
pub fn run(problem: &mut Problem, start: &Hypothesis) -> Found {
    let known = start.effects.len();
    let mut h = start.clone();
    h.effects.extend(pool::core(problem));
    // the groups under white noise, then without outliers under the noise that is left
    let white = Whitening::white(problem, &problem.evaluate(&h).residual);
    let mut fit = refit(problem, &h, known, &white).0;
    let mut outliers = prepare::drop_spikes(problem, &fit.state);
    fit.state = problem.evaluate(&fit.hypothesis);
    outliers += prepare::drop_single(problem, &fit.state.residual);
    let mut whitening = Whitening::white(problem, &problem.evaluate(&fit.hypothesis).residual);
    let mut sensitivities;
    for _ in 0..ROUNDS {
        fit = refit(problem, &fit.hypothesis, known, &whitening).0;
        whitening = noise_left(problem, &fit);
        (fit, sensitivities) = refit(problem, &fit.hypothesis, known, &whitening);
        for more in [pool::friction(problem), pool::ripple(problem, &fit, &whitening)] {
            let joining = members::join(problem, &fit, &sensitivities, &whitening, &more);
            if joining.is_empty() {
                continue;
            }
            let mut h = fit.hypothesis.clone();
            h.effects.extend(joining);
            (fit, sensitivities) = refit(problem, &h, known, &whitening);
        }
    }
    whitening = noise_left(problem, &fit);
    (fit, sensitivities) = refit(problem, &fit.hypothesis, known, &whitening);
    let kept = members::supported(problem, &fit, &sensitivities, &whitening);
    if kept.len() < fit.free.len() {
        let mut h = fit.hypothesis.clone();
        h.effects = h.effects[..known].iter().cloned().chain(kept.iter().map(|&k| fit.hypothesis.effects[fit.free[k]].clone())).collect();
        (fit, sensitivities) = refit(problem, &h, known, &whitening);
    }
    let support = members::support(problem, &fit, &sensitivities, &whitening);
    let story = share::story(problem, &fit, &sensitivities, &whitening);
    Found { fit, whitening, support, story, outliers }
}

/// Refit of all effects behind the known ones under the prior.
fn refit(problem: &Problem, h: &Hypothesis, known: usize, whitening: &Whitening) -> (Fit, Signatures) {
    let free: Vec<usize> = (known..h.effects.len()).collect();
    let prior = prior::of(problem, h, &free);
    let r = fit::refit_with_prior(problem, h, &free, whitening, &prior);
    if std::env::var_os("LM_DEBUG").is_some() {
        eprintln!("refit n {} p {} cost {:.0} rms {:.2} um converged {}", problem.n, r.1.normal.nrows(), r.0.cost, super::outcome::rms(problem, &r.0.state.residual) * 1e6, r.0.converged);
    }
    r
}

/// Noise of what a fit leaves; slow wander of the arm and of the air is noise here.
fn noise_left(problem: &Problem, fit: &Fit) -> Whitening {
    let w = Whitening::with_wander(problem, &fit.state.residual, fit.parameters());
    if std::env::var_os("LM_DEBUG").is_some() {
        eprintln!("noise {:?}", w.noise);
    }
    w
}
