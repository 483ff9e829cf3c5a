//! Has the last correction of a joint helped? What runs left after its reversals, and the better measured offsets.
//!
//! A compensator that was corrected keeps, joint by joint, the offsets from before and what their run left. Where the run with the
//! corrected ones leaves more, beyond what both runs may scatter, the joint gets back the ones from before.

use super::evidence::Reversal;
use crate::compensator::note::{Change, Note};
use crate::compensator::{Compensator, JointCompensator, JointEvidence, Replaced, RunLeft};
use crate::robot::Robot;

/// Standard errors of the difference beyond which a run is worse.
const WORSE: f64 = 2.0;
/// Reversals from which a run says something of a joint.
const LEAST: usize = 3;

/// What a run left after the reversals of a joint.
pub fn of_joint(standing: &[Reversal], axis: usize) -> Option<RunLeft> {
    let own: Vec<&Reversal> = standing.iter().filter(|r| r.axis == axis).collect();
    if own.len() < LEAST {
        return None;
    }
    let n = own.len() as f64;
    let mean = own.iter().map(|r| r.left_m2).sum::<f64>() / n;
    // by the scatter of the reversals, and never less than noise alone makes
    let scatter = own.iter().map(|r| (r.left_m2 - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
    let noise = own.iter().map(|r| r.left_sigma_m2.powi(2)).sum::<f64>() / (n * n);
    Some(RunLeft { left_m2: mean, sigma_m2: scatter.max(noise).sqrt(), reversals: own.len() })
}

/// Gives a joint back the offsets from before its last correction where the run with the corrected ones is worse.
pub fn restored(robot: &Robot, axis: usize, run: Option<RunLeft>, next: &mut Compensator) -> bool {
    let Some(known) = next.evidence.joints.iter_mut().find(|j| j.axis == axis) else { return false };
    let (Some(run), Some(before)) = (run, &known.replaced) else { return false };
    if run.left_m2 - before.run.left_m2 <= WORSE * run.sigma_m2.hypot(before.run.sigma_m2) {
        return false;
    }
    let left_m = |r: RunLeft| r.left_m2.max(0.0).sqrt();
    let change = Change::TakenBack { with_m: left_m(run), without_m: left_m(before.run) };
    let note = Note::Run { joint: robot.axis(axis).name.clone(), change };
    let offsets = before.offsets.clone();
    known.run = Some(before.run);
    known.replaced = None;
    next.evidence.notes.push(note);
    next.joints.retain(|j| j.axis != axis);
    next.joints.extend(offsets);
    next.joints.sort_by_key(|j| j.axis);
    true
}

/// Writes down what a run showed of a joint, and, where it was corrected, the offsets of that run.
pub fn kept_in_mind(
    axis: usize,
    run: Option<RunLeft>,
    corrected: Option<Option<&JointCompensator>>,
    next: &mut Compensator,
) {
    let Some(run) = run else { return };
    let at = next.evidence.joints.iter().position(|j| j.axis == axis).unwrap_or_else(|| {
        next.evidence.joints.push(JointEvidence { axis, ..JointEvidence::default() });
        next.evidence.joints.len() - 1
    });
    let known = &mut next.evidence.joints[at];
    // a correction is made only where it helps strokes that it was not fitted to
    known.proved |= corrected.is_some();
    (known.run, known.replaced) = match corrected {
        // the corrected offsets have no run yet
        Some(offsets) => (None, Some(Replaced { offsets: offsets.cloned(), run })),
        None => (Some(run), None),
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, Evidence};
    use crate::effects::GapCurve;

    fn reversals(left_um: &[f64]) -> Vec<Reversal> {
        let of = |v: &f64| Reversal {
            log: 0,
            axis: 0,
            t_s: 0.0,
            at: 0.0,
            before_m2: 0.0,
            left_m2: (v * 1e-6).powi(2),
            left_sigma_m2: 1e-13,
            ratio: 1.0,
            sigma: 0.1,
            ..Reversal::default()
        };
        left_um.iter().map(of).collect()
    }

    fn offsets(half_gap: f64) -> JointCompensator {
        let backlash = Some(BacklashOffset::symmetric(GapCurve::Constant(half_gap)));
        JointCompensator { axis: 0, backlash, friction: None }
    }

    /// A correction from 1e-5 to 2e-5 rad and a run with it.
    fn after(first_um: &[f64], second_um: &[f64]) -> (bool, Compensator) {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let mut c = Compensator {
            robot_name: robot.name.clone(),
            robot_sha256: robot.fingerprint(),
            joints: vec![offsets(2e-5)],
            evidence: Evidence::default(),
        };
        kept_in_mind(0, of_joint(&reversals(first_um), 0), Some(Some(&offsets(1e-5))), &mut c);
        let yaml = c.to_yaml(&robot).unwrap();
        let mut again = Compensator::parse("c.yaml", &yaml, &robot).unwrap();
        let back = restored(&robot, 0, of_joint(&reversals(second_um), 0), &mut again);
        (back, again)
    }

    fn half_gap(c: &Compensator) -> f64 {
        c.joints[0].backlash.as_ref().unwrap().positive.at(0.0)
    }

    #[test]
    fn a_run_that_is_worse_beyond_its_scatter_brings_the_offsets_from_before_back() {
        let (back, c) = after(&[4.0, 5.0, 6.0, 5.0], &[12.0, 13.0, 11.0, 12.0]);
        assert!(back && (half_gap(&c) - 1e-5).abs() < 1e-12, "{}", half_gap(&c));
        let known = &c.evidence.joints[0];
        assert!(known.replaced.is_none() && known.run.is_some_and(|r| r.left_m2 < (6e-6f64).powi(2)), "{known:?}");
        let words = c.evidence.notes[0].to_string();
        assert!(words.contains("12.0 um left after its reversals with it, 5.0 um without"), "{words}");
    }

    #[test]
    fn a_run_that_is_better_or_within_the_scatter_keeps_the_correction() {
        for second in [&[3.0, 3.0, 4.0, 3.0], &[5.0, 9.0, 2.0, 6.5]] {
            let (back, c) = after(&[4.0, 5.0, 6.0, 5.0], second);
            assert!(!back && (half_gap(&c) - 2e-5).abs() < 1e-12, "{second:?}");
        }
    }

    #[test]
    fn two_reversals_say_nothing_and_joints_that_had_no_offsets_get_none_back() {
        assert!(of_joint(&reversals(&[4.0, 5.0]), 0).is_none());
        let (_, mut c) = after(&[4.0, 5.0, 6.0, 5.0], &[4.0, 5.0, 6.0]);
        let run = RunLeft { left_m2: 1e-12, sigma_m2: 1e-13, reversals: 5 };
        kept_in_mind(0, Some(run), Some(None), &mut c);
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let mut c = Compensator::parse("c.yaml", &c.to_yaml(&robot).unwrap(), &robot).unwrap();
        assert!(restored(&robot, 0, of_joint(&reversals(&[9.0, 9.0, 9.5]), 0), &mut c));
        assert!(c.joints.is_empty());
    }
}
