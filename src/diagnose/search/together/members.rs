//! Which terms join the fit and which leave it: what they gain on held-out blocks.

use super::blocks::Blocks;
use super::{MachineFit, contribution, pool, prior};
use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::sensitivities::effect_columns;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::fit::Fit;
use crate::effects::{EffectInstance, Family};
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::parallel::ParMap;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Gain on held-out blocks, in 2 ln L, below which a term is not supported.
pub const SUPPORTED: f64 = 12.0;
/// Folds of which a term must improve most.
const MOST_FOLDS: usize = 3;
/// Eigenvalue, after scaling, below which a direction of the parameters is open.
const OPEN: f64 = 1e-12;
/// Terms that join at most in one call.
const MOST: usize = 40;

/// The blocks of a fit and of further columns, with the prior of all: precision and pull.
pub(super) struct Table {
    blocks: Blocks,
    precision: Vec<f64>,
    pull: Vec<f64>,
}

pub(super) fn table(problem: &Problem, machine: &MachineFit, more: &[Vec<f64>]) -> Table {
    let MachineFit { fit, sensitivities, whitening, prior: p, .. } = machine;
    let white = whitening.of(problem, &fit.state.residual);
    let mut columns: Vec<&[f64]> = sensitivities.columns().map(|c| c.as_slice()).collect();
    let own = columns.len();
    columns.extend(more.iter().map(Vec::as_slice));
    let blocks = Blocks::new(problem, &columns, &white);
    let values = fit.free.iter().flat_map(|&i| fit.hypothesis.effects[i].effect.values());
    let mut precision = p.precision.clone();
    let mut pull: Vec<f64> = values.zip(p.precision.iter().zip(&p.centre)).map(|(v, (p, c))| p * (c - v)).collect();
    for list in [&mut precision, &mut pull] {
        list.resize(own + more.len(), 0.0);
    }
    Table { blocks, precision, pull }
}

impl Table {
    /// Which of `open` the held-out blocks support beside `pick`, whose cost is `now`: index and gain, best first. `columns` gives
    /// a candidate's columns, and whether its first value must be positive.
    fn supported(
        &self,
        pick: &[usize],
        now: &[f64],
        open: &[usize],
        columns: &(dyn Fn(usize) -> (Range<usize>, bool) + Sync),
    ) -> Vec<(usize, f64)> {
        let mut gains: Vec<(usize, f64)> = open
            .par_map(|&k| {
                let (own, positive) = columns(k);
                let with: Vec<usize> = pick.iter().copied().chain(own).collect();
                let (gain, folds) = gain(now, &self.held_out(&with));
                if gain < SUPPORTED || folds < MOST_FOLDS {
                    return None;
                }
                let x = self.blocks.solve(&with, None, &self.precision, &self.pull);
                (!positive || x[pick.len()] > 0.0).then_some((k, gain))
            })
            .into_iter()
            .flatten()
            .collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        gains
    }

    pub(super) fn held_out(&self, pick: &[usize]) -> Vec<f64> {
        self.blocks.held_out(pick, &self.precision, &self.pull)
    }

    /// The solution of all columns and its covariance, with priors of these widths for the further columns.
    pub(super) fn beside(mut self, widths: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let own = self.precision.len() - widths.len();
        self.precision[own..].iter_mut().zip(widths).for_each(|(p, w)| *p = w.powi(-2));
        let all: Vec<usize> = (0..self.precision.len()).collect();
        let mut normal = self.blocks.whole();
        self.precision.iter().enumerate().for_each(|(k, p)| normal[(k, k)] += p);
        (self.blocks.solve(&all, None, &self.precision, &self.pull), pseudo_inverse(&normal, OPEN))
    }

    /// How far the solution of the first `own` columns moves with one unit of each further column that they do not know of.
    pub(super) fn shifts(&self, own: usize) -> DMatrix<f64> {
        let whole = self.blocks.whole();
        let mut normal = whole.view((0, 0), (own, own)).into_owned();
        self.precision[..own].iter().enumerate().for_each(|(k, p)| normal[(k, k)] += p);
        pseudo_inverse(&normal, OPEN) * whole.view((0, own), (own, whole.ncols() - own))
    }

    /// The same without the columns `gone`, which stand in the residual again at `values`.
    pub(super) fn held_out_without(&self, pick: &[usize], gone: &[usize], values: &[f64]) -> Vec<f64> {
        self.blocks.held_out_without(pick, gone, values, &self.precision, &self.pull)
    }
}

/// Gain of `with` over `without`, and in how many folds.
fn gain(without: &[f64], with: &[f64]) -> (f64, usize) {
    let gains = without.iter().zip(with).map(|(a, b)| a - b);
    (gains.clone().sum(), gains.filter(|g| *g > 0.0).count())
}

/// A joint may have several ripples, and a log several steps of the tracker.
fn may_repeat(c: &Candidate) -> bool {
    c.trial.iter().flat_map(|t| &t.0).any(|p| matches!(p.effect.info().family, Family::Ripple | Family::Tracker))
}

/// Candidates that the held-out blocks support, best first, one shape of an effect on a target.
pub fn join(problem: &Problem, machine: &MachineFit, candidates: &[Candidate]) -> Vec<EffectInstance> {
    let MachineFit { fit, sensitivities, whitening, .. } = machine;
    let taken = |c: &Candidate| {
        !may_repeat(c)
            && fit.free.iter().any(|&i| {
                let p = &fit.hypothesis.effects[i];
                c.names(p, &problem.robot)
            })
    };
    let list: Vec<&Candidate> = candidates.iter().filter(|c| !taken(c)).collect();
    let white = |c: &&Candidate| {
        let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
        columns.iter_mut().for_each(|c| whitening.apply(problem, c));
        columns
    };
    let columns: Vec<Vec<Vec<f64>>> = list.par_map(white);
    let own = sensitivities.columns().count();
    let mut starts = vec![own];
    for c in &columns {
        starts.push(starts[starts.len() - 1] + c.len());
    }
    let mut table = table(problem, machine, &columns.into_iter().flatten().collect::<Vec<_>>());
    for (k, c) in list.iter().enumerate() {
        let width =
            c.at(&vec![1e-9; c.sensitivities()]).first().map_or(f64::INFINITY, |p| prior::widths(problem, p)[0]);
        table.precision[starts[k]..starts[k + 1]].fill(if width.is_finite() { width.powi(-2) } else { 0.0 });
    }
    let (pick, joined) = chosen(&table, &list, &starts);
    let x = table.blocks.solve(&pick, None, &table.precision, &table.pull);
    let mut at = own;
    joined
        .iter()
        .flat_map(|&k| {
            let n = list[k].sensitivities();
            at += n;
            list[k].at(&x.as_slice()[at - n..at])
        })
        .collect()
}

/// Columns that the held-out blocks support, and the candidates that join with them, in the order in which they join; `starts`: the first
/// column of each candidate.
fn chosen(table: &Table, list: &[&Candidate], starts: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let mut pick: Vec<usize> = (0..starts[0]).collect();
    let mut joined: Vec<usize> = Vec::new();
    let mut now = table.held_out(&pick);
    while joined.len() < MOST {
        let open = |k: &usize| {
            let c = list[*k];
            !joined.iter().any(|&j| list[j].effect == c.effect && list[j].target == c.target)
        };
        let open: Vec<usize> = (0..list.len()).filter(open).collect();
        let gains = table.supported(&pick, &now, &open, &|k| (starts[k]..starts[k + 1], list[k].positive));
        let Some(&(_, best)) = gains.first() else { break };
        // of every joint the best one at a time
        let mut targets: Vec<&str> = Vec::new();
        for (k, g) in gains {
            if g < 0.3 * best || targets.contains(&list[k].target.as_str()) {
                continue;
            }
            targets.push(&list[k].target);
            pick.extend(starts[k]..starts[k + 1]);
            joined.push(k);
        }
        now = table.held_out(&pick);
    }
    (pick, joined)
}

/// Gaps that vary over position: the hypothesis with a curve instead of every gap for which the held-out blocks prefer it.
pub fn curved(problem: &Problem, machine: &MachineFit) -> Hypothesis {
    let MachineFit { fit, sensitivities, whitening, .. } = machine;
    let mut h = fit.hypothesis.clone();
    let mut trials: Vec<(usize, EffectInstance, Vec<Vec<f64>>)> = Vec::new();
    for (k, &i) in fit.free.iter().enumerate() {
        for knots in [3, 5, 8] {
            let Some(curve) = pool::gap_over_position(problem, &fit.hypothesis.effects[i], knots) else { continue };
            let mut with = fit.hypothesis.clone();
            with.effects[i] = curve.clone();
            let mut columns = effect_columns(problem, &with, &fit.state, i);
            columns.iter_mut().for_each(|c| whitening.apply(problem, c));
            trials.push((k, curve, columns));
        }
    }
    let own = sensitivities.columns().count();
    let mut at = own;
    let starts: Vec<usize> = trials.iter().map(|t| (at, at += t.2.len()).0).collect();
    let all: Vec<Vec<f64>> = trials.iter().flat_map(|t| t.2.iter().cloned()).collect();
    let mut table = table(problem, machine, &all);
    for (t, &start) in trials.iter().zip(&starts) {
        let mean = t.1.effect.values().iter().sum::<f64>() / t.2.len() as f64;
        table.precision[start..start + t.2.len()].fill((prior::KNOT * mean.max(f64::MIN_POSITIVE)).powi(-2));
    }
    let ranges = columns_of(fit);
    let whole: Vec<usize> = (0..own).collect();
    let now = table.held_out(&whole);
    let gains: Vec<(f64, usize)> = (0..trials.len()).par_map(|k| {
        let (t, start) = (&trials[k], starts[k]);
        let others = whole.iter().copied().filter(|c| !ranges[t.0].contains(c));
        let pick: Vec<usize> = others.chain(start..start + t.2.len()).collect();
        gain(&now, &table.held_out(&pick))
    });
    for (k, &i) in fit.free.iter().enumerate() {
        let best = trials
            .iter()
            .zip(&gains)
            .filter(|(t, g)| t.0 == k && g.0 > SUPPORTED && g.1 >= MOST_FOLDS)
            .max_by(|a, b| a.1.0.total_cmp(&b.1.0));
        if let Some((t, _)) = best {
            h.effects[i] = t.1.clone();
        }
    }
    h
}

/// Columns of each free effect.
pub(in crate::diagnose::search) fn columns_of(fit: &Fit) -> Vec<std::ops::Range<usize>> {
    let mut at = 0;
    fit.free
        .iter()
        .map(|&i| {
            let n = fit.hypothesis.effects[i].effect.values().len();
            at += n;
            at - n..at
        })
        .collect()
}

/// Held-out cost without some of the effects. The residual is that of the whole fit; an effect that is taken out leaves
/// what its values explain there.
fn without(table: &Table, values: &[f64], columns: usize, out: &[std::ops::Range<usize>]) -> Vec<f64> {
    let gone: Vec<usize> = out.iter().cloned().flatten().collect();
    let pick: Vec<usize> = (0..columns).filter(|c| !gone.contains(c)).collect();
    table.held_out_without(&pick, &gone, values)
}

/// What one of the fit's values stands for when its effect is taken out: the size times its column; a shape counts nothing.
pub(in crate::diagnose::search) fn linear_values(problem: &Problem, fit: &Fit) -> Vec<f64> {
    fit.free
        .iter()
        .flat_map(|&i| {
            let placed = &fit.hypothesis.effects[i];
            let kinds = prior::kinds(problem, placed);
            placed.effect.values().into_iter().zip(kinds).map(|(v, k)| if k == prior::Kind::Size { v } else { 0.0 })
        })
        .collect()
}

/// Gain on held-out blocks of each free effect beside all the others.
pub fn support(problem: &Problem, machine: &MachineFit) -> Vec<f64> {
    let MachineFit { fit, sensitivities, .. } = machine;
    let table = table(problem, machine, &[]);
    let (ranges, values, n) = (columns_of(fit), linear_values(problem, fit), sensitivities.columns().count());
    let now = table.held_out(&(0..n).collect::<Vec<_>>());
    ranges.par_map(|r| gain(&without(&table, &values, n, std::slice::from_ref(r)), &now).0)
}

/// Free effects (places in the list) that stay when those leave which the held-out blocks do not support, the weakest first.
pub fn supported(problem: &Problem, machine: &MachineFit) -> Vec<usize> {
    let MachineFit { fit, sensitivities, .. } = machine;
    let table = table(problem, machine, &[]);
    let (ranges, values, n) = (columns_of(fit), linear_values(problem, fit), sensitivities.columns().count());
    let sizes = contribution::contributions(problem, fit);
    let worth = contribution::WORTH * rms(problem, &fit.state.residual);
    let geometric =
        |k: usize| crate::diagnose::candidates::is_geometry(fit.hypothesis.effects[fit.free[k]].effect.name());
    let mut out: Vec<usize> = Vec::new();
    let mut now = table.held_out(&(0..n).collect::<Vec<_>>());
    loop {
        let standing: Vec<usize> = (0..ranges.len()).filter(|k| !out.contains(k)).collect();
        let weakest = standing
            .par_map(|&k| {
                let gone: Vec<std::ops::Range<usize>> =
                    out.iter().chain(std::iter::once(&k)).map(|&k| ranges[k].clone()).collect();
                let cost = without(&table, &values, n, &gone);
                let g = gain(&cost, &now).0;
                // geometry is one group: its members stay unless they harm
                let least = if geometric(k) { 0.0 } else { SUPPORTED };
                let least = if sizes[k] < worth { f64::INFINITY } else { least };
                (k, g - least, cost)
            })
            .into_iter()
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let Some((k, margin, cost)) = weakest else { break };
        if margin >= 0.0 {
            break;
        }
        out.push(k);
        now = cost;
    }
    (0..ranges.len()).filter(|k| !out.contains(k)).collect()
}
