//! Found effects that the logs do not determine, or that blocks which were not fitted do not support: they go.
//!
//! A name needs a size that is not zero for the shape that it has, and it must lessen what is left of data that it was not fitted to,
//! beside all the others. The weakest goes first, the rest is refitted. A shape that the logs do not tell (the time constant of a drift
//! whose end they do not see) is held instead of a value without meaning. Where the shape is known so badly that the interval of the size
//! holds zero all the same, the effect stays, as it explains what it explains, but it is no name by itself ([`doubtful`]).

use crate::diagnose::candidates;
use crate::diagnose::candidates::sensitivities::Sensitivities;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::course::SearchState;
use crate::diagnose::search::doubt::mark;
use crate::diagnose::search::finding::WITHIN;
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::prepared::Prepared;
use crate::diagnose::search::together::blocks::Blocks;
use crate::diagnose::search::together::members::SUPPORTED;
use crate::diagnose::search::together::{members, prior};
use crate::diagnose::search::{Search, freed, precise, remaining, sandwich, unnamed};
use crate::effects::EffectInstance;
use crate::numerics::chi_squared;
use crate::numerics::normal::Z95;
use crate::numerics::normal_equations::pseudo_inverse;
use nalgebra::{DMatrix, DVector};

/// Chance that a size is zero above which its interval contains zero.
const HOLDS_ZERO: f64 = 0.05;
/// Eigenvalue, after scaling, below which a direction of the sizes is open.
const OPEN: f64 = 1e-12;

/// Gain in 2 ln L of each free effect on blocks that were not fitted, beside all the others.
pub fn support(problem: &Problem, fit: &Fit, whitening: &Whitening) -> Vec<f64> {
    let s = Sensitivities::new(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let columns: Vec<&[f64]> = s.columns().map(|c| c.as_slice()).collect();
    let blocks = Blocks::new(problem, &columns, &whitening.of(problem, &fit.state.residual));
    let (values, none) = (members::linear_values(problem, fit), vec![0.0; columns.len()]);
    let sum = |left: Vec<f64>| left.iter().sum::<f64>();
    // a threshold is held: what a few samples say of it tells nothing of others
    let kinds = fit.free.iter().flat_map(|&i| prior::kinds(problem, &fit.hypothesis.effects[i]));
    let all: Vec<usize> =
        kinds.enumerate().filter(|(_, kind)| *kind != prior::Kind::Threshold).map(|(c, _)| c).collect();
    let now = sum(blocks.held_out(&all, &none, &none));
    let without = |range: std::ops::Range<usize>| {
        let gone: Vec<usize> = range.collect();
        let pick: Vec<usize> = all.iter().copied().filter(|c| !gone.contains(c)).collect();
        sum(blocks.held_out_without(&pick, &gone, &values, &none, &none))
    };
    members::columns_of(fit).into_iter().map(|range| without(range) - now).collect()
}

/// What the shape of an effect is while its sizes are compared with zero.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// What it was found to be: where nothing is there, there is no shape.
    Held,
    /// Open, as for the interval of a size.
    Open,
}

/// Chance that the sizes of the k-th free effect are all zero, by their covariance.
fn chance_of_zero(problem: &Problem, fit: &Fit, k: usize, shape: Shape) -> f64 {
    let placed = &fit.hypothesis.effects[fit.free[k]];
    let Some(range) = members::columns_of(fit).into_iter().nth(k) else { return 0.0 };
    let kinds = prior::kinds(problem, placed);
    let sizes: Vec<usize> = (0..kinds.len()).filter(|&v| kinds[v] == prior::Kind::Size).collect();
    let beside: Vec<usize> = if shape == Shape::Held { (0..kinds.len()).collect() } else { sizes.clone() };
    let values = placed.effect.values();
    let size = |v: usize| if kinds[v] == prior::Kind::Size { values[v] } else { 0.0 };
    let x = DVector::from_iterator(beside.len(), beside.iter().map(|&v| size(v)));
    let at = |v: usize| range.start + beside[v];
    let covariance = DMatrix::from_fn(beside.len(), beside.len(), |a, b| fit.covariance[(at(a), at(b))]);
    if sizes.is_empty() || covariance.iter().all(|v| *v == 0.0) {
        return 0.0;
    }
    // with a shape beside them, the inverse holds the sizes' own part given that shape
    chi_squared::tail((x.transpose() * pseudo_inverse(&covariance, OPEN) * &x)[(0, 0)], sizes.len() as f64)
}

/// Which free effects have sizes whose interval contains zero, by a covariance that knows of misfit: they are no names by themselves.
pub fn doubtful(problem: &Problem, fit: &Fit) -> Vec<bool> {
    let named = |k: usize| !unnamed::is_unnamed(&fit.hypothesis.effects[fit.free[k]]);
    (0..fit.free.len())
        .map(|k| fit.converged && named(k) && chance_of_zero(problem, fit, k, Shape::Open) > HOLDS_ZERO)
        .collect()
}

/// The same by standard uncertainties of each free effect's values.
pub fn doubtful_by(problem: &Problem, fit: &Fit, sigma: &[Vec<f64>]) -> Vec<bool> {
    let holds_zero = |(k, sigma): (usize, &Vec<f64>)| {
        let placed = &fit.hypothesis.effects[fit.free[k]];
        let kinds = prior::kinds(problem, placed);
        let values = placed.effect.values();
        let sizes: Vec<usize> = (0..kinds.len()).filter(|&v| kinds[v] == prior::Kind::Size && sigma[v] > 0.0).collect();
        let sum: f64 = sizes.iter().map(|&v| (values[v] / sigma[v]).powi(2)).sum();
        fit.converged
            && !sizes.is_empty()
            && !unnamed::is_unnamed(placed)
            && !candidates::is_geometry(placed.effect.name())
            && chi_squared::tail(sum, sizes.len() as f64) > HOLDS_ZERO
    };
    sigma.iter().enumerate().map(holds_zero).collect()
}

/// Lengths of the longest log at which a time constant may be held: the shortest that explains as much.
const HELD_AT: [f64; 3] = [1.0, 3.0, 10.0];

/// A free effect whose shape the logs do not tell, with the forms that hold it.
fn with_open_shape(problem: &Problem, fit: &Fit) -> Option<(usize, Vec<EffectInstance>)> {
    let longest_s = candidates::clock(problem).map_or(0.0, |c| c.1);
    (0..fit.free.len()).find_map(|k| {
        let placed = &fit.hypothesis.effects[fit.free[k]];
        let shape = placed.effect.shape()?;
        let (value, sigma) = (placed.effect.values()[shape], fit.sigma_of(k)[shape]);
        let open = !fit.converged || sigma <= 0.0 || Z95 * sigma > value.abs();
        let held =
            |times: f64| Some(EffectInstance::new(placed.target, placed.effect.with_held_shape(longest_s, times)?));
        let forms: Vec<EffectInstance> = HELD_AT.iter().filter(|_| open).filter_map(|times| held(*times)).collect();
        (!forms.is_empty()).then_some((k, forms))
    })
}

impl Search<'_> {
    /// Takes out of a course what the logs do not determine or support. Returns whether that changed anything.
    pub(in crate::diagnose) fn only_determined(
        &self,
        course: &mut SearchState,
        prepared: &Prepared,
        rms_nuisance: f64,
    ) -> bool {
        let p = self.problem;
        let mut changed = false;
        if course.group.is_some() {
            return false;
        }
        for _ in 0..2 * self.limits.effects {
            if course.fit.free.is_empty() {
                break;
            }
            if !course.fit.converged {
                course.fit = fit::refit(p, &course.fit.hypothesis, &course.fit.free, &course.whitening);
            }
            let mut wide = course.fit.clone();
            sandwich::widen(p, &mut wide, &course.whitening);
            if let Some((k, forms)) = with_open_shape(p, &wide) {
                course.fit = held_in(p, &course.fit, k, forms, &course.whitening);
                changed = true;
                continue;
            }
            let Some((k, why)) = weakest(p, &wide, &course.whitening) else { break };
            let mut h = course.fit.hypothesis.clone();
            let old = h.effects.remove(course.fit.free[k]);
            mark(&mut course.steps, &old.named(&p.robot), why);
            let free: Vec<usize> = (self.known..h.effects.len()).collect();
            course.fit = fit::refit(p, &h, &free, &course.whitening);
            changed = true;
        }
        if changed {
            let SearchState { fit, whitening, .. } = course;
            *whitening = precise::noise_left(p, fit, whitening, &prepared.groups);
            *fit = fit::refit(p, &fit.hypothesis, &fit.free, whitening);
            course.structure = freed::tested(p, fit, &prepared.groups);
            course.remains =
                remaining::remaining(p, &course.structure, (&prepared.free, &prepared.groups), fit, rms_nuisance);
        }
        changed
    }
}

/// The fit with the first of some forms of its k-th free effect that leaves as little as it does; else with the last.
fn held_in(problem: &Problem, fit: &Fit, k: usize, forms: Vec<EffectInstance>, whitening: &Whitening) -> Fit {
    let mut found = fit.clone();
    for form in forms {
        let mut h = fit.hypothesis.clone();
        h.effects[fit.free[k]] = form;
        found = fit::refit(problem, &h, &fit.free, whitening);
        if found.cost < fit.cost + WITHIN {
            break;
        }
    }
    found
}

/// The free effect that is least determined, or least supported, if one is not; and why it goes.
fn weakest(problem: &Problem, fit: &Fit, whitening: &Whitening) -> Option<(usize, &'static str)> {
    let all = 0..fit.free.len();
    let zero = all.map(|k| (k, chance_of_zero(problem, fit, k, Shape::Held))).max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((k, _)) = zero.filter(|z| z.1 > HOLDS_ZERO) {
        return Some((k, "nothing: its size may be zero"));
    }
    let least = support(problem, fit, whitening).into_iter().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    // of joint sensors a misfit stays, which any effect may follow a little
    let needed = if problem.recording() == Recording::JointSensors { SUPPORTED } else { 0.0 };
    (least.1 <= needed).then_some((least.0, "nothing: it does not explain data that it was not fitted to"))
}
