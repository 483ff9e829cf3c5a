//! Settled poses of a real arm: the geometry as one group, gravity, and gaps beside the misfit that stays.
//!
//! A real arm differs from its drawing in ten to twenty parameters at once; found one by one, each of them bends the others.
//! - The group: forward selection among zero offsets, DH parameters and the tool (frame and further reflectors projected
//!   off; what the chosen ones explain to 1e-4 is no parameter), refitted together, then backward: what does not stand four
//!   standard uncertainties from zero goes. Three or more make a group, which counts as one effect.
//! - Behind it gravity compliance alone. What stays of an arm (tenths of a millimetre) is smooth in the pose, and scale,
//!   coupling and slow ripple are, too: which of them it is, poses do not say, so none of them is named. What stays is
//!   told as `unexplained`; the verdict is `unknown` only where nothing was named.
//! - Gaps: an error that depends on the side of the approach. A misfit looks like one where poses happen to go with
//!   directions. Two guards: a smooth even nuisance (each joint's error a quadratic form in all joints, and its own third and
//!   fourth degree) is fitted beside; and decoys: a joint that runs ahead of its command cannot be play, so the terms of the wrong
//!   sign show what misfit does. A gap is named where its term is five standard uncertainties large and twice the
//!   largest of the wrong sign. Uncertainties are by pose (a sandwich): the reflectors of a pose err together.
//!
//! Gross poses: all reflectors of a pose beyond six times the median are left out, after the group was fitted.
//! Fails on an arm whose misfit itself depends on the approach (cables, belts): the decoys grow, nothing is named.

use super::candidates::Candidate;
use super::fit::{self, Fit, Whitening, dot};
use super::forward::{Hypothesis, Problem};
use super::layout::Sensor;
use super::screen::{Ground, orthonormal, project_off};
use super::search::{Outcome, Refined, rms};
use super::structure::Ratio;
use crate::effect::{Backlash, Effect, Placed, Target};
use crate::stats::fisher;
use crate::stats::robust::median;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Parameters that make a group.
const GROUP: usize = 3;
/// Chance below which a parameter enters the group, all that is tried counted.
const CHANCE: f64 = 1e-4;
/// Squared share of a column that must be its own.
const OWN: f64 = 1e-8;
/// Standard uncertainties from zero below which a parameter leaves the group.
const NO_PARAMETER: f64 = 4.0;
/// Parameters of a group at most.
const MOST: usize = 40;
/// Residual of a pose, in medians, beyond which it is gross.
const GROSS: f64 = 6.0;
/// Standard deviation of the coefficients of the smooth nuisance, rad (m for a prismatic joint).
const RIDGE: f64 = 0.3e-3;
/// The same of geometry that the group has not: rad or m.
const GEOMETRY_RIDGE: f64 = 3e-3;
/// Size of a direction term in standard uncertainties, and in the largest of the wrong sign.
const SEEN: f64 = 5.0;
const ABOVE_DECOYS: f64 = 2.0;
/// Chance of structure below which it is told.
const STRUCTURED: f64 = 1e-5;

/// Is an effect one of the geometry?
pub fn is_geometry(effect: &str) -> bool {
    matches!(effect, "joint_zero_offset" | "link_error" | "tool_error")
}

/// Are all logs settled poses with points?
pub fn applies(problem: &Problem) -> bool {
    problem.logs.iter().all(|l| l.log.poses && l.reflectors() > 0)
}

/// The group as it was found.
#[derive(Debug, Clone)]
pub struct Group {
    /// Effects of the group: the first of the free ones.
    pub count: usize,
    pub parameters: usize,
    /// Gain in 2 ln L over the frame alone.
    pub gain: f64,
    pub f: f64,
    pub p_value: f64,
}

/// Fits the group from `base`, whose free effects are none; `None` where fewer than three parameters are found.
pub fn group(problem: &Problem, base: &Fit, whitening: &Whitening, candidates: &[Candidate]) -> Option<(Group, Fit)> {
    let known = base.hypothesis.effects.len();
    let mut fit = base.clone();
    let pool: Vec<&Candidate> = candidates.iter().filter(|c| is_geometry(c.effect)).collect();
    // selected at one linearisation, then again where the refit stands
    for _ in 0..4 {
        let more = select(problem, &fit, whitening, &pool);
        if more.is_empty() {
            break;
        }
        let mut h = fit.hypothesis.clone();
        h.effects.extend(more);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        fit = fit::refit(problem, &h, &free, whitening);
    }
    while let Some(weakest) = weakest(problem, &fit) {
        let mut h = fit.hypothesis.clone();
        h.effects.remove(known + weakest);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        fit = fit::refit(problem, &h, &free, whitening);
    }
    let parameters: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    if parameters < GROUP {
        return None;
    }
    let (n, k) = (problem.n as f64, parameters as f64);
    let gain = base.cost - fit.cost;
    let f = (gain / k) / (fit.cost / (n - k).max(1.0));
    let p_value = fisher::tail(f, k, n - k);
    Some((Group { count: fit.free.len(), parameters, gain, f, p_value }, fit))
}

/// Forward selection at one linearisation.
fn select(problem: &Problem, fit: &Fit, whitening: &Whitening, pool: &[&Candidate]) -> Vec<Placed> {
    let taken = |c: &Candidate| {
        fit.free.iter().any(|&i| {
            let p = &fit.hypothesis.effects[i];
            p.effect.name() == c.effect && p.target_text(&problem.robot) == c.target
        })
    };
    let tangent = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let ground = Ground::new(problem, &fit.hypothesis, &fit.state, whitening, tangent);
    let mut left: Vec<(&Candidate, Vec<Vec<f64>>, Vec<f64>)> = pool
        .par_iter()
        .filter(|c| !taken(c))
        .map(|c| {
            let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
            let before = ground.project(&mut columns);
            (*c, columns, before)
        })
        .collect();
    let tried = left.len() as f64;
    let mut residual = ground.residual.clone();
    let mut chosen: Vec<(&Candidate, Vec<Vec<f64>>)> = Vec::new();
    let n = residual.len() as f64;
    while chosen.len() + fit.free.len() < MOST {
        let rss = dot(&residual, &residual);
        let mut best: Option<(f64, usize, Vec<Vec<f64>>)> = None;
        // the tool is as rough as the frame: what it explains is not sought elsewhere
        let tool = left.iter().position(|l| l.0.effect == "tool_error");
        for (i, (_, columns, before)) in left.iter().enumerate().filter(|(i, _)| tool.is_none_or(|t| *i == t)) {
            let own = columns.iter().zip(before).all(|(c, b)| dot(c, c) > OWN * b);
            if !own {
                continue;
            }
            let basis = orthonormal(columns.clone());
            let k = basis.len() as f64;
            let gain: f64 = basis.iter().map(|b| dot(b, &residual).powi(2)).sum();
            let f = (gain / k) / ((rss - gain).max(1e-300) / n);
            if (tool.is_some() || tried * fisher::tail(f, k, n) < CHANCE) && best.as_ref().is_none_or(|b| f > b.0) {
                best = Some((f, i, basis));
            }
        }
        let Some((_, i, basis)) = best else {
            match tool {
                // nothing of its own
                Some(i) => {
                    left.remove(i);
                    continue;
                }
                None => break,
            }
        };
        let (c, columns, _) = left.remove(i);
        project_off(&basis, &mut residual);
        left.par_iter_mut().for_each(|l| l.1.iter_mut().for_each(|c| project_off(&basis, c)));
        chosen.push((c, columns));
    }
    // where they start: zero, the refit is nearly linear
    chosen.iter().flat_map(|(c, columns)| c.at(&vec![0.0; columns.len()])).collect()
}

/// The effect nearest to zero, where that is nearer than a parameter of the group may be.
fn weakest(problem: &Problem, fit: &Fit) -> Option<usize> {
    let scale = (fit.cost / problem.n.max(1) as f64).sqrt();
    (0..fit.free.len())
        .map(|k| (k, significance(fit, k) / scale))
        .filter(|(_, z)| *z < NO_PARAMETER)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(k, _)| k)
}

/// Largest value of the k-th effect in its standard uncertainties.
fn significance(fit: &Fit, k: usize) -> f64 {
    let values = fit.hypothesis.effects[fit.free[k]].effect.values();
    values.iter().zip(fit.sigma_of(k)).map(|(v, s)| if s > 0.0 { v.abs() / s } else { 0.0 }).fold(0.0, f64::max)
}

/// A found effect as its own only rival: what taking it out would cost, by its covariance.
pub fn own_rival(problem: &Problem, fit: &Fit, k: usize) -> Refined {
    let placed = fit.hypothesis.effects[fit.free[k]].clone();
    let values = placed.effect.values();
    let start: usize = fit.free[..k].iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    let covariance = fit.covariance.view((start, start), (values.len(), values.len())).into_owned();
    let v = DVector::from_row_slice(&values);
    let gain = covariance.pseudo_inverse(1e-300).map_or(0.0, |inverse| (inverse * &v).dot(&v));
    Refined {
        effect: placed.effect.name(),
        target: placed.target_text(&problem.robot),
        parameters: values.len(),
        placed: vec![placed],
        gain,
        promised: gain,
        fit: fit.clone(),
    }
}

/// Poses that the geometry leaves far off are left out, all their reflectors; says how many.
pub fn drop_gross(problem: &mut Problem, h: &Hypothesis, white: &dyn Fn(&Problem, &Fit) -> Whitening) -> usize {
    let mut dropped = 0;
    for _ in 0..4 {
        let base = fit::refit(problem, h, &[], &white_of(problem, h));
        let candidates = super::candidates::all(problem);
        let whitening = white(problem, &base);
        let fit = group(problem, &base, &whitening, &candidates).map_or(base, |g| g.1);
        let mut found = Vec::new();
        for l in 0..problem.logs.len() {
            let mut size = vec![None; problem.logs[l].log.len()];
            for g in problem.groups_of(l).filter(|g| g.dims == 3) {
                let (n, v) = (g.len(), &fit.state.residual[g.range()]);
                for b in 0..n {
                    let s: f64 = (0..3).map(|c| v[c * n + b].powi(2)).sum::<f64>().sqrt();
                    let row = &mut size[g.middle(b)];
                    *row = Some(row.unwrap_or(0.0_f64).max(s));
                }
            }
            let there: Vec<f64> = size.iter().flatten().copied().collect();
            let limit = GROSS * median(&there);
            if there.len() >= 12 {
                found.extend(
                    size.iter().enumerate().filter(|(_, s)| s.is_some_and(|s| s > limit)).map(|(row, _)| (l, row)),
                );
            }
        }
        if found.is_empty() {
            break;
        }
        dropped += found.len();
        super::prepare::leave_poses_out(problem, &found);
    }
    dropped
}

fn white_of(problem: &Problem, h: &Hypothesis) -> Whitening {
    let state = problem.evaluate(h);
    let sigma = rms(problem, &state.residual).max(1e-9);
    Whitening::new(problem, vec![super::noise::Noise::white(sigma); problem.groups.len()])
}

/// Direction term of one joint beside the smooth nuisance.
#[derive(Debug, Clone)]
pub struct Term {
    pub axis: usize,
    /// Error in the direction of motion, rad or m: negative stops short, as play does.
    pub size: f64,
    pub z: f64,
}

/// Direction terms of all joints.
pub fn directions(problem: &Problem, fit: &Fit, whitening: &Whitening, candidates: &[Candidate]) -> Vec<Term> {
    let tangent = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let ground = Ground::new(problem, &fit.hypothesis, &fit.state, whitening, tangent);
    let mut even = smooth(problem, fit);
    let mut ridge = vec![RIDGE; even.len()];
    // and the whole geometry: what the group has not
    for c in candidates.iter().filter(|c| is_geometry(c.effect)) {
        let columns = c.columns(problem, &fit.hypothesis, &fit.state);
        ridge.extend(vec![GEOMETRY_RIDGE; columns.len()]);
        even.extend(columns);
    }
    ground.project(&mut even);
    let m = even.len();
    let n = ground.residual.len();
    let a = DMatrix::from_fn(n, m, |i, j| even[j][i]);
    let mut normal = a.transpose() * &a;
    let bare = normal.clone();
    for (i, sigma) in ridge.iter().enumerate() {
        normal[(i, i)] += 1.0 / (sigma * sigma);
    }
    let Some(factor) = normal.cholesky() else { return Vec::new() };
    // the nuisance takes freedom from the residual
    let freedom = factor.solve(&bare).trace() + fit.parameters() as f64;
    let fewer = n as f64 / (n as f64 - freedom).max(1.0);
    let off = |v: &[f64]| -> DVector<f64> {
        let v = DVector::from_row_slice(v);
        let right = a.transpose() * &v;
        v - &a * factor.solve(&right)
    };
    let residual = off(&ground.residual);
    let mut terms = Vec::new();
    for axis in 0..problem.robot.dof() {
        let mut columns = vec![vec![0.0; problem.n]];
        for l in 0..problem.logs.len() {
            let dir = problem.logs[l].drive.track(axis).dir.to_vec();
            let of = |r: usize| f64::from(dir.get(r).copied().unwrap_or(0));
            problem.add_joint_change(&fit.state, l, axis, &of, None, &mut columns[0]);
        }
        let before = ground.project(&mut columns)[0];
        let d = DVector::from_row_slice(&columns[0]);
        let own = off(&columns[0]);
        let norm = own.dot(&d);
        if before <= 0.0 || norm < 1e-6 * before {
            continue;
        }
        let size = own.dot(&DVector::from_row_slice(&ground.residual)) / norm;
        let score = sums_by_pose(problem, |i| own[i] * (residual[i] - size * own[i]));
        let sigma = (fewer * score.iter().map(|s| s * s).sum::<f64>()).sqrt() / norm;
        terms.push(Term { axis, size, z: if sigma > 0.0 { size / sigma } else { 0.0 } });
    }
    terms
}

/// Sums of a value per observation over the observations of each pose.
fn sums_by_pose(problem: &Problem, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut sums: Vec<Vec<f64>> = problem.logs.iter().map(|l| vec![0.0; l.log.len()]).collect();
    for g in &problem.groups {
        for c in 0..g.dims {
            for b in 0..g.len() {
                sums[g.log][g.middle(b)] += value(g.offset + c * g.len() + b);
            }
        }
    }
    sums.into_iter().flatten().collect()
}

/// Each joint's error as a quadratic form in all joints, and its own third and fourth degree (Legendre).
fn smooth(problem: &Problem, fit: &Fit) -> Vec<Vec<f64>> {
    let dof = problem.robot.dof();
    let range: Vec<(f64, f64)> = (0..dof)
        .map(|a| {
            let all = problem.logs.iter().flat_map(|l| l.drive.command(a).iter().copied());
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
        })
        .collect();
    let unit = |l: usize, a: usize, r: usize| {
        let (lo, hi) = range[a];
        if hi > lo { 2.0 * (problem.logs[l].drive.command(a)[r] - lo) / (hi - lo) - 1.0 } else { 0.0 }
    };
    let moving: Vec<usize> = (0..dof).filter(|&a| range[a].1 > range[a].0).collect();
    let mut forms: Vec<(usize, Option<usize>)> = moving.iter().map(|&a| (a, None)).collect();
    for (i, &a) in moving.iter().enumerate() {
        forms.extend(moving[i..].iter().map(|&b| (a, Some(b))));
    }
    (0..dof)
        .into_par_iter()
        .flat_map_iter(|axis| {
            let column = |value: &dyn Fn(usize, usize) -> f64| {
                let mut out = vec![0.0; problem.n];
                for l in 0..problem.logs.len() {
                    problem.add_joint_change(&fit.state, l, axis, &|r| value(l, r), None, &mut out);
                }
                out
            };
            let mut columns: Vec<Vec<f64>> =
                forms.iter().map(|&(a, b)| column(&|l, r| unit(l, a, r) * b.map_or(1.0, |b| unit(l, b, r)))).collect();
            columns.push(column(&|l, r| {
                let x = unit(l, axis, r);
                0.5 * x * (5.0 * x * x - 3.0)
            }));
            columns.push(column(&|l, r| {
                let x = unit(l, axis, r);
                0.125 * (x * x * (35.0 * x * x - 30.0) + 3.0)
            }));
            columns
        })
        .collect()
}

/// The joint that has a gap beyond what misfit does, and what to say where none has.
pub fn gap(problem: &Problem, terms: &[Term]) -> (Option<Placed>, Option<String>) {
    let decoy = terms.iter().map(|t| t.z).fold(0.0, f64::max);
    let Some(most) = terms.iter().min_by(|a, b| a.z.total_cmp(&b.z)).filter(|t| t.z < 0.0) else { return (None, None) };
    if -most.z >= SEEN && -most.z >= ABOVE_DECOYS * decoy {
        let effect = Effect::Backlash(Backlash::constant(-most.size));
        return (Some(Placed { target: Target::Joint(most.axis), effect }), None);
    }
    let joint = problem.robot.axis(most.axis);
    let said = (-most.z >= 3.0).then(|| {
        format!(
            "no gap is named: the largest direction-dependent part, on {}, is {:.4} deg or mm, {:.1} standard uncertainties, and terms of \
             the wrong sign, which no play has, reach {decoy:.1}",
            joint.name,
            -most.size / joint.kind.si(),
            -most.z,
        )
    });
    (None, said)
}

/// Direction terms in words.
pub fn terms_said(problem: &Problem, terms: &[Term]) -> String {
    let each: Vec<String> = terms.iter().map(|t| format!("{} {:.1}", problem.robot.axis(t.axis).name, -t.z)).collect();
    format!("direction terms in standard uncertainties, positive as of play: {}", each.join(", "))
}

/// Gaps of the joints by their terms.
pub fn gap_rivals(problem: &Problem, fit: &Fit, terms: &[Term]) -> Vec<Refined> {
    let mut rivals: Vec<Refined> = terms
        .iter()
        .filter(|t| t.z < 0.0)
        .map(|t| {
            let effect = Effect::Backlash(Backlash::constant(-t.size));
            let placed = Placed { target: Target::Joint(t.axis), effect };
            Refined {
                effect: placed.effect.name(),
                target: placed.target_text(&problem.robot),
                placed: vec![placed],
                gain: t.z * t.z,
                parameters: 1,
                promised: t.z * t.z,
                fit: fit.clone(),
            }
        })
        .collect();
    rivals.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    rivals
}

/// What stays of a real arm behind its group: told, whatever its size, where it is more than chance.
pub fn remains(outcome: &Outcome) -> Option<Ratio> {
    let tested = &outcome.structure;
    if tested.whole.p_value > STRUCTURED {
        return None;
    }
    let worst = tested.bundles.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.gain.total_cmp(&a.gain)));
    let mut told = worst.unwrap_or(&tested.whole).clone();
    // the size is that of everything
    (told.gain, told.dof, told.p_value) = (tested.whole.gain, tested.whole.dof, tested.whole.p_value);
    Some(told)
}

/// Correlation of the residuals of the reflectors of one pose makes them count for less: the factor of their variance.
pub fn inflation(problem: &Problem, log: usize, residual: &[f64]) -> f64 {
    let groups: Vec<_> = problem.groups_of(log).filter(|g| matches!(g.sensor, Sensor::Reflector(_))).collect();
    if groups.len() < 2 || !problem.logs[log].log.poses {
        return 1.0;
    }
    let rows = problem.logs[log].log.len();
    let mut sums = vec![[0.0_f64; 3]; rows];
    let mut squares = 0.0;
    for g in &groups {
        let (n, v) = (g.len(), &residual[g.range()]);
        for b in 0..n {
            for (c, s) in sums[g.middle(b)].iter_mut().enumerate() {
                *s += v[c * n + b];
                squares += v[c * n + b].powi(2);
            }
        }
    }
    let together: f64 = sums.iter().flatten().map(|s| s * s).sum();
    if squares > 0.0 { (together / squares).clamp(1.0, groups.len() as f64) } else { 1.0 }
}
