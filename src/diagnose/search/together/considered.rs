//! Effects that were left out for lack of support, as a part of the uncertainty of those that were not.
//!
//! Method: a term that held-out blocks do not support may still be there, and what it does is then taken for something else: a
//! small spike of friction for lag, wind-up for gap, a length of the last link for one of the tool, gravity for lengths of the arm. Such
//! terms are set beside the fit as columns under their weak prior; the variance of each value is that of this wider fit, and the square of
//! how far the wider fit would move it is added (consider covariance; Schmidt 1966, Advances in Control Systems 3, with what the data say
//! of the considered terms). Values stay.
//!
//! Wind-up beside a gap is considered without what the data say of it ([`windup_beside_gaps`]): how it builds up differs from
//! machine to machine, and a shape that the data tell from a gap is not the shape of the machine.
//!
//! The masses of a robot file are known roughly: beside gravity that is in the fit, every link that the joint carries may bend it
//! by more or less than they say ([`masses`]).
//!
//! Assumptions: the terms are linear in their size; wind-up of gear and friction is up to a third of the gap beside it, one
//! standard deviation; so are masses and centres of mass known to 15 %.

use super::{MachineFit, alternatives, members, pool, prior};
use crate::diagnose::problem::forward::Problem;
use crate::effects::{
    Backlash, BacklashPosition, Candidate, EffectInstance, FreeMassGravity, GravityCompliance, Hysteresis,
};
use crate::numerics::parallel::ParMap;
use crate::robot::{Convention, JointKind, STANDARD_GRAVITY_M_S2};

/// Wind-up beside a gap, in parts of the gap, one standard deviation.
const WINDUP: f64 = 1.0 / 3.0;
/// Masses and centres of mass of a robot file, in parts of them, one standard deviation.
const MASSES: f64 = 0.15;
/// Bend of a joint below which it gets no column, rad.
const NO_BEND: f64 = 1e-7;
/// Trial of a wind-up, rad or m.
const TRIAL: f64 = 1e-6;

/// Half gap of a plain gap, or its mean over the position, rad or m.
pub(super) fn size_of_gap(placed: &EffectInstance) -> Option<f64> {
    let plain = placed.effect.get::<Backlash>().map(|b| b.half_gap);
    let curve = placed.effect.get::<BacklashPosition>();
    plain.or(curve.map(|b| 0.5 * (b.half_gap.smallest() + b.half_gap.largest())))
}

/// Wind-up of every joint with a gap that has none yet, with the width of its prior.
fn windups(problem: &Problem, machine: &MachineFit) -> Vec<(Candidate, f64)> {
    let fit = &machine.fit;
    let mut list = Vec::new();
    for gap in fit.free.iter().map(|&i| &fit.hypothesis.effects[i]) {
        let (Some(size), Some(axis)) = (size_of_gap(gap), gap.axis()) else { continue };
        if size <= 0.0 || alternatives::winds_up(&fit.hypothesis.effects, gap.target) {
            continue;
        }
        let unit = problem.robot.axis(axis).kind.si_per_user_unit();
        let width = WINDUP * size / (alternatives::TRAVELS.len() as f64).sqrt();
        list.extend(alternatives::TRAVELS.map(|travel| {
            let make = move |half_width| Hysteresis { half_width, presliding: travel * unit };
            (Candidate::of_size(&problem.robot, gap.target, TRIAL, make), width)
        }));
    }
    list
}

/// Friction and drift that are not in the fit, with the widths of their priors.
fn friction(problem: &Problem, machine: &MachineFit) -> Vec<(Candidate, f64)> {
    let fit = &machine.fit;
    let found = |c: &Candidate| {
        let same = |p: &EffectInstance| c.names(p, &problem.robot);
        fit.free.iter().any(|&i| same(&fit.hypothesis.effects[i]))
    };
    let width = |c: &Candidate| {
        let placed = c.at(&vec![1e-9; c.sensitivities()]);
        placed.first().and_then(|p| prior::widths(problem, p).first().copied()).filter(|w| w.is_finite())
    };
    let open = pool::friction(problem).into_iter().filter(|c| !found(c));
    open.filter_map(|c| width(&c).map(|w| (c, w))).collect()
}

/// Geometry that is not in the fit, as others stand for it or as it was not supported, as wide as the arm itself shows.
fn geometry(problem: &Problem, machine: &MachineFit) -> Vec<(Candidate, f64)> {
    let effects = &machine.fit.hypothesis.effects;
    let open = |p: &EffectInstance| !effects.iter().any(|e| e.target == p.target && e.effect.name() == p.effect.name());
    let one = |p: EffectInstance| {
        let width = machine.geometry.width(problem, &p)?;
        let of_size = move |v: f64| p.effect.with_values(&[v]);
        Some((Candidate::of_size(&problem.robot, p.target, TRIAL, of_size), width))
    };
    pool::geometry(problem, &pool::moving(problem)).into_iter().filter(open).filter_map(one).collect()
}

/// Gravity that is not in the fit, as wide as its prior.
fn gravity(problem: &Problem, machine: &MachineFit) -> Vec<(Candidate, f64)> {
    let effects = &machine.fit.hypothesis.effects;
    let found = |axis: usize| effects.iter().any(|e| e.effect.uses_gravity() && e.axis() == Some(axis));
    let loaded = |axis: &usize| problem.logs.iter().any(|l| pool::varies(l.trajectory.gravity_torque(*axis)));
    let one = |axis: usize| {
        let yields = |compliance| GravityCompliance { compliance };
        let trial = EffectInstance::on_axis(axis, yields(0.0));
        (Candidate::of_size(&problem.robot, trial.target, 1e-8, yields), prior::widths(problem, &trial)[0])
    };
    (0..problem.robot.dof()).filter(|&a| !found(a)).filter(loaded).map(one).collect()
}

/// What the weight of each link, and of all that hangs on it, may bend a joint more or less than the robot file's masses say.
fn masses(problem: &Problem, machine: &MachineFit) -> Vec<(Candidate, f64)> {
    let (robot, fit) = (&problem.robot, &machine.fit);
    let mut list = Vec::new();
    for placed in fit.free.iter().map(|&i| &fit.hypothesis.effects[i]) {
        let (Some(gravity), Some(axis)) = (placed.effect.get::<GravityCompliance>(), placed.axis()) else { continue };
        if robot.axis(axis).kind != JointKind::Revolute {
            continue;
        }
        for link in robot.axis_index(axis)..robot.links.len() {
            let behind: f64 = robot.links[link + 1..].iter().map(|l| l.mass_kg).sum();
            let (own, next) = (&robot.joints[link], robot.joints.get(link + 1));
            let along = match robot.convention {
                Convention::Standard => own.a_m,
                Convention::Modified => next.map_or(0.0, |j| j.a_m),
            };
            let reach = along.hypot(next.map_or(0.0, |j| j.d_m));
            let moment = robot.links[link].mass_kg * robot.links[link].com_m.norm() + behind * reach;
            let width = MASSES * gravity.compliance.abs() * STANDARD_GRAVITY_M_S2 * moment;
            if width > NO_BEND {
                let make = move |c: &[f64]| FreeMassGravity { moments: vec![(link, [c[0], c[1]])] };
                list.push((Candidate::of_sizes(robot, placed.target, &[TRIAL, TRIAL], make), width));
            }
        }
    }
    list
}

/// How far wind-up that is not in the fit may move the value of each gap: variance of every column, 0 for what is no gap.
/// Of one joint's travels any may be the right one: the one that moves the gap most counts, with the whole width.
pub fn windup_beside_gaps(problem: &Problem, machine: &MachineFit) -> Vec<f64> {
    let MachineFit { fit, whitening, .. } = machine;
    let mut variances = vec![0.0; fit.parameters()];
    let list = windups(problem, machine);
    let columns: Vec<Vec<f64>> = list
        .par_map(|(c, _)| {
            let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
            columns.iter_mut().for_each(|c| whitening.apply(problem, c));
            columns
        })
        .into_iter()
        .flatten()
        .collect();
    let shifts = members::table(problem, machine, &columns).shifts(fit.parameters());
    for (range, &i) in members::columns_of(fit).into_iter().zip(&fit.free) {
        let gap = &fit.hypothesis.effects[i];
        let Some(size) = size_of_gap(gap) else { continue };
        let own = list.iter().enumerate().filter(|(_, (c, _))| c.axis() == gap.axis());
        let own: Vec<usize> = own.map(|(column, _)| column).collect();
        for k in range {
            let most = own.iter().map(|&column| shifts[(k, column)].abs()).fold(0.0, f64::max);
            variances[k] = (most * WINDUP * size).powi(2);
        }
    }
    variances
}

/// Variance of every column of a fit with what was left out considered.
pub fn variances(problem: &Problem, machine: &MachineFit) -> Vec<f64> {
    let MachineFit { fit, whitening, .. } = machine;
    let mut list = friction(problem, machine);
    list.extend(windups(problem, machine));
    list.extend(geometry(problem, machine));
    list.extend(gravity(problem, machine));
    list.extend(masses(problem, machine));
    let columns: Vec<(Vec<Vec<f64>>, f64)> = list.par_map(|(c, width)| {
        let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
        columns.iter_mut().for_each(|c| whitening.apply(problem, c));
        (columns, *width)
    });
    let widths: Vec<f64> = columns.iter().flat_map(|(c, w)| vec![*w; c.len()]).collect();
    let columns: Vec<Vec<f64>> = columns.into_iter().flat_map(|c| c.0).collect();
    let (change, covariance) = members::table(problem, machine, &columns).beside(&widths);
    (0..fit.parameters()).map(|k| covariance[(k, k)].max(0.0) + change[k] * change[k]).collect()
}
