//! The groups that a machine is fitted with first, and the terms that may join them.

use super::MachineFit;
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::candidates::{spectrum, steps};
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::normal::{dot, orthonormal, project_off};
use crate::diagnose::search::fit::Fit;
use crate::effects::candidate::OVER_TRAVEL;
use crate::effects::curve::Pchip;
use crate::effects::{
    Backlash, BacklashPosition, DhParameter, EffectInstance, Family, GapCurve, GravityCompliance, JointZeroOffset,
    LinkError, ServoLag, Target, TimeOffset, ToolError, time_offset,
};
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::spread;
use crate::robot::JointKind;
use nalgebra::Vector3;

/// Travel of a joint, deg or mm, below which it counts as at rest.
const AT_REST: f64 = 1e-2;
/// Joints that move in some log.
pub fn moving(problem: &Problem) -> Vec<usize> {
    let travel = |a: usize| problem.logs.iter().map(|l| l.log.travel(a)).fold(0.0, f64::max);
    (0..problem.robot.dof()).filter(|&a| travel(a) > AT_REST * problem.robot.axis(a).kind.si_per_user_unit()).collect()
}

/// The groups: lags, gaps, gravity, geometry; all of size zero.
pub fn core(problem: &Problem, h: &Hypothesis) -> Vec<EffectInstance> {
    let mut all = Vec::new();
    let moving = moving(problem);
    let points = problem.logs.iter().any(|l| l.reflectors() > 0);
    for &a in &moving {
        if candidates::clock(problem).is_some() {
            all.push(EffectInstance::on_axis(a, ServoLag { lag_s: 0.0 }));
        }
        all.push(EffectInstance::on_axis(a, Backlash::constant(0.0)));
    }
    for a in 0..problem.robot.dof() {
        if problem.logs.iter().any(|l| varies(l.trajectory.gravity_torque(a))) {
            all.push(EffectInstance::on_axis(a, GravityCompliance { compliance: 0.0 }));
        }
    }
    if points {
        all.extend(independent(problem, h, geometry(problem, &moving)));
    }
    all
}

/// Squared share of a geometry parameter's column that must be its own beside the frame and the parameters before it.
const OWN: f64 = 1e-6;

/// The parameters that the frame and those before them do not already stand for: of a point on the flange the last joint's
/// own parameters are the tool's, and the first joint's zero is a rotation of the frame.
fn independent(problem: &Problem, h: &Hypothesis, list: Vec<EffectInstance>) -> Vec<EffectInstance> {
    let state = problem.evaluate(h);
    let mut basis = orthonormal(problem.nuisance_columns(h, &state));
    let columns: Vec<Vec<Vec<f64>>> = list.par_map(|e| {
        let values = e.effect.values();
        let one = |k: usize| {
            let mut trial = vec![0.0; values.len()];
            trial[k] = TRIAL;
            let to = EffectInstance { target: e.target, effect: e.effect.with_values(&trial) };
            problem.difference(h, &state, &[], &[to], TRIAL)
        };
        (0..values.len()).map(one).collect()
    });
    let mut kept = Vec::new();
    for (effect, columns) in list.into_iter().zip(columns) {
        let mut own = false;
        for mut c in columns {
            let before = dot(&c, &c);
            project_off(&basis, &mut c);
            project_off(&basis, &mut c);
            let left = dot(&c, &c);
            if before > 0.0 && left > OWN * before {
                let per = 1.0 / left.sqrt();
                c.iter_mut().for_each(|v| *v *= per);
                basis.push(c);
                own = true;
            }
        }
        if own {
            kept.push(effect);
        }
    }
    kept
}

/// Size at which a geometry parameter is tried, m or rad.
const TRIAL: f64 = 1e-5;

/// Whether a torque of gravity is another at another pose.
pub(super) fn varies(torque: &[f64]) -> bool {
    spread(torque.iter().copied()) > 1e-6
}

/// Tool, zeros and link parameters of an arm, all of size zero.
pub(super) fn geometry(problem: &Problem, moving: &[usize]) -> Vec<EffectInstance> {
    let mut all = vec![EffectInstance::new(Target::Tool, ToolError { offset_m: Vector3::zeros() })];
    for &a in moving {
        all.push(EffectInstance::on_axis(a, JointZeroOffset { offset: 0.0 }));
    }
    for (joint, j) in problem.robot.joints.iter().enumerate() {
        for parameter in [DhParameter::A, DhParameter::D, DhParameter::Alpha] {
            if parameter == DhParameter::D && j.kind == JointKind::Prismatic {
                continue;
            }
            let target = Target::Link { joint, parameter };
            all.push(EffectInstance::new(target, LinkError { delta: 0.0 }));
        }
    }
    all
}

/// A clock offset, where a joint would have to lead its command: no lag is negative.
pub fn clock(fit: &Fit) -> Option<EffectInstance> {
    let leads = |i: &usize| fit.hypothesis.effects[*i].effect.get::<ServoLag>().is_some_and(|lag| lag.lag_s <= 0.0);
    fit.free.iter().any(leads).then(|| EffectInstance::new(Target::Log, TimeOffset::by(0.0)))
}

/// The k-th gap as a curve over the positions that its joint visits, at the size that it has: `knots` of them.
pub fn gap_over_position(problem: &Problem, gap: &EffectInstance, knots: usize) -> Option<EffectInstance> {
    let (Some(Backlash { half_gap: size }), Some(axis)) = (gap.effect.get::<Backlash>().copied(), gap.axis()) else {
        return None;
    };
    let mut at: Vec<f64> =
        problem.logs.iter().flat_map(|l| l.trajectory.turns(axis).into_iter().map(|t| t.1)).collect();
    at.sort_by(f64::total_cmp);
    let (lo, hi) = (*at.first()?, *at.last()?);
    if at.len() < 2 * knots || hi - lo < LEAST_SPAN * problem.robot.axis(axis).kind.si_per_user_unit() {
        return None;
    }
    let place = |k: usize| lo + (hi - lo) * k as f64 / (knots - 1) as f64;
    let curve = Pchip::new(&(0..knots).map(|k| [place(k), size]).collect::<Vec<_>>())?;
    Some(EffectInstance::new(gap.target, BacklashPosition { half_gap: GapCurve::Pchip(curve) }))
}

/// Span of the turning points, deg or mm, over which a gap may vary.
const LEAST_SPAN: f64 = 5.0;

/// Friction of all joints, with the shapes of the screening, drift of the TCP, and of the clock.
pub fn friction(problem: &Problem) -> Vec<Candidate> {
    let wanted = |c: &Candidate| {
        let family = c.trial.first().and_then(|t| t.0.first()).map(|p| p.effect.info().family);
        matches!(family, Some(Family::Friction | Family::Drift)) && c.form != OVER_TRAVEL
    };
    let of_clock = |c: &Candidate| c.effect == time_offset::INFO.name;
    let clock = candidates::further(problem).into_iter().filter(of_clock);
    candidates::all(problem).into_iter().filter(wanted).chain(clock).collect()
}

/// Ripple at the peaks of the spectra of what a fit leaves, and steps of the tracker that are seen in it.
pub fn ripple(problem: &Problem, machine: &MachineFit) -> Vec<Candidate> {
    let MachineFit { fit, whitening, .. } = machine;
    let context = ScreeningContext::new(problem, &fit.hypothesis, &fit.state, whitening, Vec::new());
    let back = context.back();
    let told = |c: &Candidate| c.at(&[1e-6, 0.0]).iter().all(|p| spectrum::identifiable(problem, p));
    let mut found: Vec<Candidate> = spectrum::ripples(&context, &back).into_iter().filter(told).collect();
    found.extend(steps::steps(&context, &back));
    found
}
