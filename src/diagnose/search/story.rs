//! The found effects one by one: what each leaves, and what it leaves of data that it was not fitted to.
//!
//! Method: the hypothesis grows from the frame alone to the last effect, refitted each time. Validation cuts every log into
//! [`FOLDS`] x [`TURNS`] consecutive parts; each fold is predicted from parameters that were fitted to the other folds (one
//! Gauss-Newton step from the full fit, which is all that a small change needs). Of joint sensors the story is one of least squares:
//! each nested fit leaves the least rms that its effects can.

use crate::diagnose::candidates::sensitivities::effect_columns;
use crate::diagnose::noise::Noise;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::normal::{dot, gram};
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::EffectInstance;
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::parallel::ParMap;
use nalgebra::DVector;

/// Folds of the cross-validation.
const FOLDS: usize = 5;
/// Parts of one fold in a log, spread over it.
const TURNS: usize = 4;

/// Weight of the full fit beside the other folds: what these do not tell at all keeps its value.
const HELD_BACK: f64 = 0.02;

/// One stage of the growing hypothesis.
#[derive(Debug, Clone)]
pub struct NestedFit {
    /// rms per coordinate, m (rad for joints).
    pub rms: f64,
    /// The same on parts that were not fitted.
    pub held_out: f64,
    /// What the nested fit before promised of this one: the rms that its sensitivity leaves there.
    pub predicted: f64,
}

/// Refits with the first 0, 1, ... found effects (`order`: indices into the hypothesis' effects).
pub fn nested_fits(
    problem: &Problem,
    last: &Fit,
    known: usize,
    order: &[usize],
    whitening: &Whitening,
) -> Vec<NestedFit> {
    let even = (problem.recording() == Recording::JointSensors).then(|| alike(problem));
    let whitening = even.as_ref().unwrap_or(whitening);
    let all = &last.hypothesis.effects;
    let (fits, mut nested_fits): (Vec<Fit>, Vec<NestedFit>) = (0..order.len() + 1)
        .par_map(|count| {
            let mut effects = all[..known].to_vec();
            effects.extend(order[..count].iter().map(|&i| all[i].clone()));
            let h = Hypothesis { effects, ..last.hypothesis.clone() };
            let free: Vec<usize> = (known..known + count).collect();
            let fit = fit::refit(problem, &h, &free, whitening);
            let left = rms(problem, &fit.state.residual);
            let held_out = held_out(problem, &fit, whitening);
            (fit, NestedFit { rms: left, held_out, predicted: left })
        })
        .into_iter()
        .unzip();
    let promised: Vec<f64> = (0..order.len()).par_map(|k| promised(problem, &fits[k], &all[order[k]], whitening));
    for (nested_fit, predicted) in nested_fits.iter_mut().skip(1).zip(promised) {
        nested_fit.predicted = predicted;
    }
    nested_fits
}

/// White noise of one size for all groups, under which a fit leaves the least rms. Under coloured noise a fit lets slow structure
/// stand, which joint sensors are precise enough to show: the rms may then rise with an effect that is right.
fn alike(problem: &Problem) -> Whitening {
    Whitening::new(problem, vec![Noise::white(EVEN); problem.groups.len()])
}

/// Its size, rad or m: that of a good encoder, so that a fit ends where nothing is left to gain.
const EVEN: f64 = 1e-6;

/// The rms that an effect would leave after a nested fit, by its sensitivity alone.
fn promised(problem: &Problem, fit: &Fit, placed: &EffectInstance, whitening: &Whitening) -> f64 {
    let mut h = fit.hypothesis.clone();
    h.effects.push(placed.clone());
    let state = problem.evaluate(&h);
    let columns = effect_columns(problem, &h, &state, h.effects.len() - 1);
    let context = fit.screening(problem, whitening);
    let left = 1.0 - context.score_columns(0, columns, false).gain / fit.cost.max(1e-300);
    rms(problem, &fit.state.residual) * left.max(0.0).sqrt()
}

/// Fold of every observation.
fn folds(problem: &Problem) -> Vec<usize> {
    let mut fold = vec![0; problem.n];
    for g in &problem.groups {
        let n = g.len();
        for c in 0..g.dims {
            for b in 0..n {
                fold[g.offset + c * n + b] = (b * FOLDS * TURNS / n.max(1)) % FOLDS;
            }
        }
    }
    fold
}

/// rms of each fold as predicted from the others.
pub(in crate::diagnose) fn held_out(problem: &Problem, fit: &Fit, whitening: &Whitening) -> f64 {
    let mut raw: Vec<Vec<f64>> =
        fit.free.iter().flat_map(|&i| effect_columns(problem, &fit.hypothesis, &fit.state, i)).collect();
    raw.extend(problem.nuisance_columns(&fit.hypothesis, &fit.state));
    let fold = folds(problem);
    let white = whitening.of(problem, &fit.state.residual);
    let columns: Vec<Vec<f64>> = raw.iter().map(|c| whitening.of(problem, c)).collect();
    let whole = gram(&columns);
    let mut predicted = fit.state.residual.clone();
    for f in 0..FOLDS {
        let masked =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&fold).map(|(v, g)| if *g == f { 0.0 } else { *v }).collect() };
        let (part, target): (Vec<Vec<f64>>, Vec<f64>) = (columns.iter().map(|c| masked(c)).collect(), masked(&white));
        let right = DVector::from_iterator(part.len(), part.iter().map(|c| dot(c, &target)));
        if part.is_empty() {
            continue;
        }
        let change = pseudo_inverse(&(gram(&part) + &whole * HELD_BACK), 1e-9) * right;
        for (c, s) in raw.iter().zip(change.iter()) {
            for ((p, v), g) in predicted.iter_mut().zip(c).zip(&fold) {
                if *g == f {
                    *p -= s * v;
                }
            }
        }
    }
    rms(problem, &predicted)
}
