//! Gaps from settled poses: an error that depends on the side of the approach. A misfit looks like one where poses happen to go with
//! directions. Two guards: a smooth even nuisance (each joint's error a quadratic form in all joints, and its own third and
//! fourth degree) is fitted beside; and decoys: a joint that runs ahead of its command cannot be play, so the terms of the wrong
//! sign show what misfit does. A gap is named where its term is four and a half standard uncertainties large and twice the
//! largest of the wrong sign, from two poses or more per parameter of the nuisance. Uncertainties are by pose (a sandwich): the reflectors
//! of a pose err together.
//!
//! Fails on an arm whose misfit itself depends on the approach (cables, belts): the decoys grow, nothing is named.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::is_geometry;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::Note;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::search::finding::Refined;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::geometry::PRIOR;
use crate::effects::{Backlash, Effect, EffectInstance, Target};
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::range;
use nalgebra::{DMatrix, DVector};

/// Standard deviation of the coefficients of the smooth nuisance, rad (m for a prismatic joint).
const RIDGE: f64 = 0.3e-3;
/// Size of a direction term in standard uncertainties, and in the largest of the wrong sign.
const SEEN: f64 = 4.5;
const ABOVE_DECOYS: f64 = 2.0;
/// Poses per parameter of the nuisance: with fewer the scatter over poses says nothing about uncertainty.
const LEAST_POSES: f64 = 2.0;

/// Direction term of one joint beside the smooth nuisance.
#[derive(Debug, Clone)]
pub struct Term {
    pub axis: usize,
    /// Error in the direction of motion, rad or m: negative stops short, as play does.
    pub size: f64,
    pub z: f64,
}

/// Direction terms of all joints, and how many there are poses for each parameter of the nuisance.
#[derive(Debug, Clone, Default)]
pub struct Terms {
    pub terms: Vec<Term>,
    pub poses_per_parameter: f64,
}

/// Direction terms of all joints.
pub fn directions(problem: &Problem, fit: &Fit, whitening: &Whitening, candidates: &[Candidate]) -> Terms {
    let context = fit.screening(problem, whitening);
    let mut even = smooth(problem, fit);
    let mut ridge = vec![RIDGE; even.len()];
    // and the whole geometry: what the group has not
    for c in candidates.iter().filter(|c| is_geometry(c.effect)) {
        let columns = c.columns(problem, &fit.hypothesis, &fit.state);
        ridge.extend(vec![PRIOR; columns.len()]);
        even.extend(columns);
    }
    context.project(&mut even);
    let m = even.len();
    let n = context.residual.len();
    let a = DMatrix::from_fn(n, m, |i, j| even[j][i]);
    let mut normal = a.transpose() * &a;
    let bare = normal.clone();
    for (i, sigma) in ridge.iter().enumerate() {
        normal[(i, i)] += 1.0 / (sigma * sigma);
    }
    let Some(factor) = normal.cholesky() else { return Terms::default() };
    // the nuisance takes freedom from the residual
    let freedom = factor.solve(&bare).trace() + fit.parameters() as f64;
    let fewer = n as f64 / (n as f64 - freedom).max(1.0);
    let off = |v: &[f64]| -> DVector<f64> {
        let v = DVector::from_row_slice(v);
        let right = a.transpose() * &v;
        v - &a * factor.solve(&right)
    };
    let residual = off(&context.residual);
    let mut terms = Vec::new();
    for axis in 0..problem.robot.dof() {
        let mut columns = vec![vec![0.0; problem.n]];
        for l in 0..problem.logs.len() {
            let dir = problem.logs[l].trajectory.track(axis).dir.to_vec();
            let of = |r: usize| f64::from(dir.get(r).copied().unwrap_or(0));
            problem.add_joint_change(&fit.state, l, axis, &of, None, &mut columns[0]);
        }
        let before = context.project(&mut columns)[0];
        let d = DVector::from_row_slice(&columns[0]);
        let own = off(&columns[0]);
        let norm = own.dot(&d);
        if before <= 0.0 || norm < 1e-6 * before {
            continue;
        }
        let size = own.dot(&DVector::from_row_slice(&context.residual)) / norm;
        let score = sums_by_pose(problem, |i| own[i] * (residual[i] - size * own[i]));
        let sigma = (fewer * score.iter().map(|s| s * s).sum::<f64>()).sqrt() / norm;
        terms.push(Term { axis, size, z: if sigma > 0.0 { size / sigma } else { 0.0 } });
    }
    let poses: usize = problem.logs.iter().map(|l| l.log.len()).sum();
    Terms { terms, poses_per_parameter: poses as f64 / (m + fit.parameters()).max(1) as f64 }
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
    let commands = |a: usize| problem.logs.iter().flat_map(move |l| l.trajectory.command(a).iter().copied());
    let ranges: Vec<[f64; 2]> = (0..dof).map(|a| range(commands(a))).collect();
    let unit = |l: usize, a: usize, r: usize| {
        let [lo, hi] = ranges[a];
        if hi > lo { 2.0 * (problem.logs[l].trajectory.command(a)[r] - lo) / (hi - lo) - 1.0 } else { 0.0 }
    };
    let moving: Vec<usize> = (0..dof).filter(|&a| ranges[a][1] > ranges[a][0]).collect();
    let mut forms: Vec<(usize, Option<usize>)> = moving.iter().map(|&a| (a, None)).collect();
    for (i, &a) in moving.iter().enumerate() {
        forms.extend(moving[i..].iter().map(|&b| (a, Some(b))));
    }
    (0..dof)
        .par_map(|axis| {
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
        .into_iter()
        .flatten()
        .collect()
}

/// The joints that have a gap beyond what misfit does, and what to note where none has.
pub fn gaps(problem: &Problem, found: &Terms) -> (Vec<EffectInstance>, Option<Note>) {
    let terms = &found.terms;
    let decoy = terms.iter().map(|t| t.z).fold(0.0, f64::max);
    let enough = found.poses_per_parameter >= LEAST_POSES;
    let stands = |t: &&Term| enough && -t.z >= SEEN && -t.z >= ABOVE_DECOYS * decoy;
    let mut clear: Vec<&Term> = terms.iter().filter(stands).collect();
    clear.sort_by(|a, b| a.z.total_cmp(&b.z));
    if !clear.is_empty() {
        let gap = |t: &&Term| EffectInstance::on_axis(t.axis, Backlash::constant(-t.size));
        return (clear.iter().map(gap).collect(), None);
    }
    let Some(most) = terms.iter().min_by(|a, b| a.z.total_cmp(&b.z)).filter(|t| t.z <= -3.0) else {
        return (Vec::new(), None);
    };
    let joint = problem.robot.axis(most.axis);
    let none = Note::NoGapNamed {
        joint: joint.name.clone(),
        kind: joint.kind,
        half_gap: -most.size,
        z: -most.z,
        wrong_z: decoy,
        few_poses: (!enough).then_some(found.poses_per_parameter),
    };
    (Vec::new(), Some(none))
}

/// Direction terms as a note.
pub fn note_of(problem: &Problem, terms: &[Term]) -> Note {
    let term = |t: &Term| (problem.robot.axis(t.axis).name.clone(), -t.z);
    Note::DirectionTerms { terms: terms.iter().map(term).collect() }
}

/// A gap by its direction term: several joints may have one, so that none is another's alternative.
pub fn gap_alternatives(problem: &Problem, fit: &Fit, terms: &[Term], axis: Option<usize>) -> Vec<Refined> {
    let alternatives: Vec<Refined> = terms
        .iter()
        .filter(|t| t.z < 0.0 && Some(t.axis) == axis)
        .map(|t| {
            let effect = Effect::new(Backlash::constant(-t.size));
            let placed = EffectInstance { target: Target::Joint(t.axis), effect };
            Refined {
                effect: placed.effect.name(),
                target: placed.target_text(&problem.robot),
                placed: vec![placed],
                gain: t.z * t.z,
                parameters: 1,
                fit: fit.clone(),
            }
        })
        .collect();
    alternatives
}
