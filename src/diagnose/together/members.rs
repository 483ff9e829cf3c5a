//! Which terms join the fit and which leave it: what they gain on held-out blocks.

use super::super::candidates::Candidate;
use super::super::fit::Fit;
use super::super::forward::Problem;
use super::super::signatures::Signatures;
use super::super::whitening::Whitening;
use super::blocks::Blocks;
use super::{prior, share};
use crate::effects::EffectInstance;
use rayon::prelude::*;

/// Gain on held-out blocks, in 2 ln L, below which a term is not supported.
pub const SUPPORTED: f64 = 12.0;
/// Folds of which a term must improve most.
const MOST_FOLDS: usize = 3;
/// Terms that join at most in one call.
const MOST: usize = 40;

/// The blocks of a fit and of further columns, with the prior of all: precision and pull.
struct Table {
    blocks: Blocks,
    precision: Vec<f64>,
    pull: Vec<f64>,
}

fn table(problem: &Problem, fit: &Fit, sensitivities: &Signatures, whitening: &Whitening, more: &[Vec<f64>]) -> Table {
    let white = whitening.of(problem, &fit.state.residual);
    let mut columns: Vec<&[f64]> = sensitivities.columns().map(|c| c.as_slice()).collect();
    let own = columns.len();
    columns.extend(more.iter().map(Vec::as_slice));
    let blocks = Blocks::new(problem, &columns, &white);
    let p = prior::of(problem, &fit.hypothesis, &fit.free);
    let values = fit.free.iter().flat_map(|&i| fit.hypothesis.effects[i].effect.values());
    let mut precision = p.precision.clone();
    let mut pull: Vec<f64> = values.zip(p.precision.iter().zip(&p.centre)).map(|(v, (p, c))| p * (c - v)).collect();
    for list in [&mut precision, &mut pull] {
        list.resize(own + more.len(), 0.0);
    }
    Table { blocks, precision, pull }
}

impl Table {
    fn held_out(&self, pick: &[usize]) -> Vec<f64> {
        self.blocks.held_out(pick, &self.precision, &self.pull)
    }
}

/// Gain of `with` over `without`, and in how many folds.
fn gain(without: &[f64], with: &[f64]) -> (f64, usize) {
    let gains = without.iter().zip(with).map(|(a, b)| a - b);
    (gains.clone().sum(), gains.filter(|g| *g > 0.0).count())
}

/// Candidates that the held-out blocks support, best first, one shape of an effect on a target.
pub fn join(
    problem: &Problem,
    fit: &Fit,
    sensitivities: &Signatures,
    whitening: &Whitening,
    candidates: &[Candidate],
) -> Vec<EffectInstance> {
    let taken = |c: &Candidate| {
        c.effect != "transmission_error"
            && fit.free.iter().any(|&i| {
                let p = &fit.hypothesis.effects[i];
                p.effect.name() == c.effect && p.target_text(&problem.robot) == c.target
            })
    };
    let list: Vec<&Candidate> = candidates.iter().filter(|c| !taken(c)).collect();
    let columns: Vec<Vec<Vec<f64>>> = list
        .par_iter()
        .map(|c| {
            let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
            columns.iter_mut().for_each(|c| whitening.apply(problem, c));
            columns
        })
        .collect();
    let own = sensitivities.columns().count();
    let mut starts = vec![own];
    for c in &columns {
        starts.push(starts[starts.len() - 1] + c.len());
    }
    let mut table = table(problem, fit, sensitivities, whitening, &columns.into_iter().flatten().collect::<Vec<_>>());
    for (k, c) in list.iter().enumerate() {
        let width = c.at(&vec![1e-9; c.signatures()]).first().map_or(f64::INFINITY, |p| prior::widths(problem, p)[0]);
        table.precision[starts[k]..starts[k + 1]].fill(if width.is_finite() { width.powi(-2) } else { 0.0 });
    }
    let mut pick: Vec<usize> = (0..own).collect();
    let mut joined: Vec<usize> = Vec::new();
    let mut now = table.held_out(&pick);
    while joined.len() < MOST {
        let open = |k: &usize| {
            let c = list[*k];
            !joined.iter().any(|&j| list[j].effect == c.effect && list[j].target == c.target)
        };
        let open: Vec<usize> = (0..list.len()).filter(open).collect();
        let mut gains: Vec<(usize, f64)> = open
            .par_iter()
            .filter_map(|&k| {
                let with: Vec<usize> = pick.iter().copied().chain(starts[k]..starts[k + 1]).collect();
                let (gain, folds) = gain(&now, &table.held_out(&with));
                if gain < SUPPORTED || folds < MOST_FOLDS {
                    return None;
                }
                let x = table.blocks.solve(&with, None, &table.precision, &table.pull);
                (!list[k].positive || x[pick.len()] > 0.0).then_some((k, gain))
            })
            .collect();
        gains.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
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
            if std::env::var_os("LM_DEBUG").is_some() {
                eprintln!("join {} {} {:.0}", list[k].effect, list[k].target, g);
            }
        }
        now = table.held_out(&pick);
    }
    let x = table.blocks.solve(&pick, None, &table.precision, &table.pull);
    let mut at = own;
    joined
        .iter()
        .flat_map(|&k| {
            let n = list[k].signatures();
            at += n;
            list[k].at(&x.as_slice()[at - n..at])
        })
        .collect()
}

/// Columns of each free effect.
fn columns_of(fit: &Fit) -> Vec<std::ops::Range<usize>> {
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
    table.blocks.held_out_without(&pick, &gone, values, &table.precision, &table.pull)
}

/// What one of the fit's values stands for when its effect is taken out: the size times its column; a shape counts nothing.
fn linear_values(fit: &Fit) -> Vec<f64> {
    fit.free
        .iter()
        .flat_map(|&i| {
            let effect = &fit.hypothesis.effects[i].effect;
            let values = effect.values();
            let sizes = share::sizes(effect);
            values.into_iter().enumerate().map(move |(k, v)| if k < sizes { v } else { 0.0 }).collect::<Vec<f64>>()
        })
        .collect()
}

/// Gain on held-out blocks of each free effect beside all the others.
pub fn support(problem: &Problem, fit: &Fit, sensitivities: &Signatures, whitening: &Whitening) -> Vec<f64> {
    let table = table(problem, fit, sensitivities, whitening, &[]);
    let (ranges, values, n) = (columns_of(fit), linear_values(fit), sensitivities.columns().count());
    let now = table.held_out(&(0..n).collect::<Vec<_>>());
    ranges.par_iter().map(|r| gain(&without(&table, &values, n, std::slice::from_ref(r)), &now).0).collect()
}

/// Free effects (places in the list) that stay when those leave which the held-out blocks do not support, the weakest first.
pub fn supported(problem: &Problem, fit: &Fit, sensitivities: &Signatures, whitening: &Whitening) -> Vec<usize> {
    let table = table(problem, fit, sensitivities, whitening, &[]);
    let (ranges, values, n) = (columns_of(fit), linear_values(fit), sensitivities.columns().count());
    let sizes = share::contributions(problem, fit);
    let geometric = |k: usize| super::super::geometry::is_geometry(fit.hypothesis.effects[fit.free[k]].effect.name());
    let mut out: Vec<usize> = Vec::new();
    let mut now = table.held_out(&(0..n).collect::<Vec<_>>());
    loop {
        let weakest = (0..ranges.len())
            .into_par_iter()
            .filter(|k| !out.contains(k))
            .map(|k| {
                let gone: Vec<std::ops::Range<usize>> =
                    out.iter().chain(std::iter::once(&k)).map(|&k| ranges[k].clone()).collect();
                let cost = without(&table, &values, n, &gone);
                let g = gain(&cost, &now).0;
                // geometry is one group: its members stay unless they harm
                let least = if geometric(k) { 0.0 } else { SUPPORTED };
                let least = if !geometric(k) && sizes[k] < share::LEAST_M { f64::INFINITY } else { least };
                (k, g - least, g, cost)
            })
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let Some((k, margin, g, cost)) = weakest else { break };
        if margin >= 0.0 {
            break;
        }
        if std::env::var_os("LM_DEBUG").is_some() {
            let p = &fit.hypothesis.effects[fit.free[k]];
            eprintln!("leave {} {} gain {:.1} size {:.2} um", p.effect.name(), p.target_text(&problem.robot), g, sizes[k] * 1e6);
        }
        out.push(k);
        now = cost;
    }
    (0..ranges.len()).filter(|k| !out.contains(k)).collect()
}
