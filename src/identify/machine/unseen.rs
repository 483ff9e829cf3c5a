//! Joints of which single readings tell nothing.
//!
//! A ballbar or a dial sees a joint only as far as it moves the TCP along the reading, and apart from others only where it does so in its
//! own way. What is left open is filled by priors: an estimate of that kind is none, and is not given. Where a tracker has seen the joint,
//! it is.

use super::estimate::mean_weights;
use super::evidence::Evidence;
use super::problem::Problem;
use crate::identify::scalar::DETERMINED;
use crate::machine::measurement::Instrument;
use crate::robot::JointKind;

/// Why a joint gets no estimate, where single readings alone have seen it and do not determine its gap.
pub fn note(problem: &Problem, evidence: &Evidence, axis: usize) -> Option<String> {
    let law = problem.laws[axis].as_ref()?;
    let mut with = problem.logs.iter().filter(|l| l.moving.iter().any(|m| m.0 == axis));
    if with.any(|l| l.instrument == Instrument::Tcp) {
        return None;
    }
    let (weights, _, turns) = mean_weights(problem, axis);
    let (at, knots) = (problem.offset(axis), law.gap.len());
    let covariance = evidence.within.view((at, at), (knots, knots)).into_owned();
    let sigma = weights.dot(&(covariance * &weights)).max(0.0).sqrt();
    let joint = problem.robot.axis(axis);
    let limit = DETERMINED[usize::from(joint.kind == JointKind::Prismatic)] * joint.kind.si_per_user_unit();
    (turns > 0 && sigma > limit).then(|| {
        format!(
            "{}: not determined by these readings (standard deviation {:.4} {}): it hardly moves along them, or as other joints do",
            joint.name,
            joint.kind.to_user_unit(sigma),
            joint.kind.unit()
        )
    })
}
