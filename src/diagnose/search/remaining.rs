//! Is there structure that remains beyond what was found?

use crate::diagnose::candidates::basis::BasisGroup;
use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::noise::Noise;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::Note;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::finding::Next;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::freed;
use crate::numerics::parallel::ParMap;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Chance of a structure ratio below which structure remains.
const STRUCTURED: f64 = 1e-5;
/// The same where the noise is that of the freed residual, which is a little too small.
const BEYOND_DOUBT: f64 = 1e-15;
/// The same where that noise is mostly white: logs without structure that are drawn from it, and by how many of their standard
/// deviations the structure must exceed what they show.
const DRAWS: u64 = 8;
const EXCEEDS: f64 = 6.0;
/// Share of the variance of slow noise up to which instruments and air are known to have it.
const USUAL: f64 = 0.5;
/// Likelihood that freeing the residual may gain beyond its degrees of freedom, in standard deviations of that.
const SWALLOWED_BY_NOISE: f64 = 12.0;
/// Structure smaller than this part of what was explained is the imprecision of the explained effects.
const IMPRECISION: f64 = 0.06;

/// Structure that is more than chance and more than the imprecision of what was explained.
///
/// `now` is the test under the noise of what is left, `first` the one before the first round, `rms_nuisance` the rms that
/// the frame alone leaves (m or rad); `groups`: the basis of both tests.
pub fn remaining(
    problem: &Problem,
    now: &Tested,
    (first, groups): (&Tested, &[BasisGroup]),
    fit: &Fit,
    rms_nuisance: f64,
) -> Option<Ratio> {
    let left = rms(problem, &fit.state.residual);
    let n = problem.n as f64;
    let explained = (rms_nuisance.powi(2) - left.powi(2)).max(0.0);
    let tolerated = IMPRECISION * IMPRECISION * explained / left.powi(2).max(1e-300) * n;
    let told = |r: &Ratio, tests: f64| r.p_value * tests < STRUCTURED && r.gain - r.dof as f64 > tolerated;
    let likeliest = |of: &Tested| {
        let best = of.groups.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.gain.total_cmp(&a.gain)));
        best.unwrap_or(&of.whole).clone()
    };
    let count = now.groups.len() as f64;
    if told(&now.whole, 1.0) || now.groups.iter().any(|r| told(r, count)) {
        return Some(likeliest(now));
    }
    // the noise model may have taken structure for slow noise: then the residual freed of it is much likelier
    let likely = |residual: &[f64]| Whitening::of_residual(problem, residual, 0).1;
    let dof = now.whole.dof as f64;
    let gain = likely(&now.freed) - likely(&fit.state.residual);
    if gain - dof * (1.0 + dof / n) > SWALLOWED_BY_NOISE * (2.0 * dof).sqrt() && gain - dof > tolerated {
        return Some(Ratio { gain, ..likeliest(now) });
    }
    let doubtless = fit.free.is_empty() && first.whole.p_value < BEYOND_DOUBT;
    (doubtless && !is_slow_noise(problem, first, fit, groups)).then(|| likeliest(first))
}

/// Whether slow noise alone would show as much structure. Freed of the whole basis a residual loses a part of its slow noise, so
/// that the rest of it looks like structure: by how much, logs tell that are drawn from the noise of this one.
fn is_slow_noise(problem: &Problem, first: &Tested, fit: &Fit, groups: &[BasisGroup]) -> bool {
    let noise = Whitening::of_residual(problem, &fit.state.residual, fit.parameters()).0.noise;
    if noise.iter().any(|n| n.share > USUAL) {
        return false;
    }
    let drawn = |seed: u64| {
        let mut without = fit.clone();
        without.state.residual = drawn_noise(problem, &noise, seed);
        let white = Whitening::white(problem, &without.state.residual);
        freed::first_noise(problem, &without, &white, groups).1.whole.gain
    };
    let gains: Vec<f64> = (0..DRAWS as usize).par_map(|k| drawn(k as u64));
    let mean = gains.iter().sum::<f64>() / gains.len() as f64;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (gains.len() - 1) as f64;
    first.whole.gain < mean + EXCEEDS * variance.sqrt()
}

/// A residual of this noise, coordinate by coordinate.
fn drawn_noise(problem: &Problem, noise: &[Noise], seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut out = vec![0.0; problem.n];
    for (g, noise) in problem.groups.iter().zip(noise) {
        for series in out[g.range()].chunks_exact_mut(g.len().max(1)) {
            let mut slow = normal();
            for (value, step) in series.iter_mut().zip(&g.steps) {
                let kept = noise.phi.powf(step.max(1.0));
                slow = kept * slow + (1.0 - kept * kept).max(0.0).sqrt() * normal();
                *value = noise.sigma * ((1.0 - noise.share).sqrt() * normal() + noise.share.sqrt() * slow);
            }
        }
    }
    out
}

/// The rounds ended at the limit of effects. What the next one would name is structure, too, if it repeats one on its joint (a
/// shape taken to pieces): that is returned first. Else it is one effect more than the limit: returned second, with a
/// note.
pub(in crate::diagnose) fn beyond_limit(
    next: Option<Next>,
    fit: &Fit,
    most: usize,
    notes: &mut Vec<Note>,
) -> (Option<Next>, Option<Next>) {
    let Some(n) = next else { return (None, None) };
    let repeats =
        fit.free.iter().map(|&i| &fit.hypothesis.effects[i]).any(|p| p.effect.name() == n.effect && p.axis() == n.axis);
    if repeats {
        return (Some(n), None);
    }
    notes.push(Note::BeyondLimit { most, effect: n.effect, target: n.target.clone() });
    (None, Some(n))
}
