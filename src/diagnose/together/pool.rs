//! The groups that a machine is fitted with first, and the terms that may join them.

use super::super::candidates::{self, Candidate};
use super::super::fit::Fit;
use super::super::forward::Problem;
use super::super::screen::Ground;
use super::super::spectrum;
use super::super::whitening::Whitening;
use crate::effects::{
    Backlash, DhParameter, Effect, GravityCompliance, JointZeroOffset, LinkError, EffectInstance, ServoLag, Target, ToolError,
};
use crate::robot::JointKind;
use nalgebra::Vector3;

/// Travel of a joint, deg or mm, below which it counts as at rest.
const AT_REST: f64 = 1e-2;
/// Cycles of a ripple over the travel at least.
const LEAST_CYCLES: f64 = 2.0;

/// Joints that move in some log.
pub fn moving(problem: &Problem) -> Vec<usize> {
    let travel = |a: usize| problem.logs.iter().map(|l| l.log.travel(a)).fold(0.0, f64::max);
    (0..problem.robot.dof()).filter(|&a| travel(a) > AT_REST * problem.robot.axis(a).kind.si()).collect()
}

/// The groups: lags, gaps, gravity, geometry; all of size zero.
pub fn core(problem: &Problem) -> Vec<EffectInstance> {
    let mut all = Vec::new();
    let moving = moving(problem);
    let points = problem.logs.iter().any(|l| l.reflectors() > 0);
    for &a in &moving {
        if candidates::clock(problem).is_some() {
            all.push(EffectInstance::on_axis(a, Effect::ServoLag(ServoLag { lag_s: 0.0 })));
        }
        all.push(EffectInstance::on_axis(a, Effect::Backlash(Backlash::constant(0.0))));
    }
    for a in 0..problem.robot.dof() {
        if problem.logs.iter().any(|l| varies(l.drive.gravity_torque(a))) {
            all.push(EffectInstance::on_axis(a, Effect::GravityCompliance(GravityCompliance { compliance: 0.0 })));
        }
    }
    if points {
        geometry(problem, &moving, &mut all);
    }
    all
}

fn varies(torque: &[f64]) -> bool {
    let (lo, hi) = torque.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    hi - lo > 1e-6
}

fn geometry(problem: &Problem, moving: &[usize], all: &mut Vec<EffectInstance>) {
    for &a in moving {
        all.push(EffectInstance::on_axis(a, Effect::JointZeroOffset(JointZeroOffset { offset: 0.0 })));
    }
    for (joint, j) in problem.robot.joints.iter().enumerate() {
        for parameter in [DhParameter::A, DhParameter::D, DhParameter::Alpha] {
            if parameter == DhParameter::D && j.kind == JointKind::Prismatic {
                continue;
            }
            let target = Target::Link { joint, parameter };
            all.push(EffectInstance { target, effect: Effect::LinkError(LinkError { delta: 0.0 }) });
        }
    }
    all.push(EffectInstance { target: Target::Tool, effect: Effect::ToolError(ToolError { offset_m: Vector3::zeros() }) });
}

/// Friction of all joints, with the shapes of the screening, and drift of the TCP.
pub fn friction(problem: &Problem) -> Vec<Candidate> {
    let wanted = |c: &Candidate| match c.effect {
        "stiction" => c.form == "time",
        "hysteresis" | "thermal_drift" => true,
        _ => false,
    };
    candidates::all(problem).into_iter().filter(wanted).collect()
}

/// Ripple at the peaks of the spectra of what a fit leaves: at least two cycles over the travel.
pub fn ripple(problem: &Problem, fit: &Fit, whitening: &Whitening) -> Vec<Candidate> {
    let ground = Ground::new(problem, &fit.hypothesis, &fit.state, whitening, Vec::new());
    let back = ground.back();
    spectrum::ripples(&ground, &back).into_iter().filter(|c| identifiable(problem, c)).collect()
}

/// A ripple with enough cycles over the travel of its joint.
fn identifiable(problem: &Problem, candidate: &Candidate) -> bool {
    let placed = candidate.at(&[1e-6, 0.0]);
    let Some((a, Effect::TransmissionError(e))) = placed.first().and_then(|p| Some((p.axis()?, &p.effect))) else {
        return false;
    };
    let joint = problem.robot.axis(a);
    let turn = if joint.kind == JointKind::Revolute { std::f64::consts::TAU } else { joint.lead_m_per_rev.unwrap_or(1.0) };
    let travel = problem.logs.iter().map(|l| l.log.travel(a)).fold(0.0, f64::max);
    e.cycles_per_rev * travel / turn >= LEAST_CYCLES
}
