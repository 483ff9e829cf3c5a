//! Documents that say different things about one joint.
//!
//! Two documents contradict each other where the half gap of one lies outside what the other allows: intervals that do not
//! meet, and a difference that exceeds [`SHARE`] of the larger. A schedule is compared over its own tested places, so it
//! allows everything between its smallest and its largest value. A joint estimate allows its gap alone up to its gap with
//! wind-up and both changes of its spikes beside another kind of document: a test that is too short sees friction as a gap. That sum is
//! known better than its parts, so its own interval counts (by the covariance of the estimate).

use crate::compensator::note::{Contradiction, Stated};
use crate::effects::GapCurve;
use crate::gaps::estimate::Estimate;
use crate::gaps::{Gaps, JointGap};
use crate::numerics::normal::Z95;
use crate::robot::Robot;

/// Differences below this share of the larger value are left to the weights.
const SHARE: f64 = 0.1;

/// All contradictions, with both values.
pub fn contradictions(documents: &[Gaps], robot: &Robot) -> Vec<Contradiction> {
    let mut out = Vec::new();
    for (k, later) in documents.iter().enumerate() {
        for earlier in &documents[..k] {
            for b in &later.joints {
                for a in earlier.joints.iter().filter(|a| a.axis == b.axis) {
                    // two estimates of gap and friction together leave nothing to friction
                    let both = earlier.estimate.is_some() && later.estimate.is_some();
                    let (ra, rb) = (allowed(earlier, a, both, robot), allowed(later, b, both, robot));
                    let apart = (ra[0] - rb[1]).max(rb[0] - ra[1]);
                    if apart > SHARE * a.half_gap.abs().max(b.half_gap.abs()) && a.significant && b.significant {
                        out.push(contradiction(robot, (earlier, a), (later, b)));
                    }
                }
            }
        }
    }
    out
}

/// Half gaps that a document allows for a joint.
fn allowed(document: &Gaps, joint: &JointGap, alone: bool, robot: &Robot) -> [f64; 2] {
    let wide = joint.ci95[1] - joint.half_gap;
    let [mut lo, mut hi] = joint.ci95;
    if let Some(curve) = joint.schedule.as_ref().filter(|c| !matches!(c, GapCurve::Constant(_))) {
        (lo, hi) = (lo.min(curve.smallest() - wide), hi.max(curve.largest() + wide));
    }
    let estimate = document.estimate.iter().flat_map(|e| &e.joints).find(|e| e.axis == joint.axis);
    if let Some(e) = estimate.filter(|_| !alone) {
        let name = robot.axis(joint.axis).name.as_str();
        hi = match document.estimate.as_ref().and_then(|all| spread_of_all(all, name)) {
            // the largest gap of a schedule stays allowed
            Some(sigma) => {
                let all = e.response.windup() + 2.0 * e.response.spikes.iter().map(|s| s.gain).sum::<f64>();
                let half = Z95 * sigma * robot.axis(joint.axis).kind.si_per_user_unit();
                (hi - wide + all + half).max(hi)
            }
            None => hi + e.windup_ci95[1].max(0.0) + 2.0 * e.spikes_ci95.iter().map(|ci| ci[1].max(0.0)).sum::<f64>(),
        };
    }
    [lo, hi]
}

/// Standard deviation of a joint's mean gap with wind-up and both changes of its spikes, deg or mm.
fn spread_of_all(estimate: &Estimate, joint: &str) -> Option<f64> {
    let (names, covariance) = estimate.covariance.as_ref()?;
    let part = |name: &str| name.strip_prefix(joint)?.strip_prefix('.').map(String::from);
    let is = |name: &String, what: &str| part(name).is_some_and(|p| p.starts_with(what));
    let knots = names.iter().filter(|n| is(n, "half_gap_")).count().max(1) as f64;
    let weight = |name: &String| match name {
        n if is(n, "half_gap_") => 1.0 / knots,
        n if is(n, "windup_") => 1.0,
        n if is(n, "spike_") => 2.0,
        _ => 0.0,
    };
    let weights: Vec<f64> = names.iter().map(weight).collect();
    let row = |r: &Vec<f64>| r.iter().zip(&weights).map(|(c, w)| c * w).sum::<f64>();
    let variance: f64 = covariance.iter().zip(&weights).map(|(r, w)| w * row(r)).sum();
    (weights.iter().any(|w| *w != 0.0) && variance >= 0.0).then(|| variance.sqrt())
}

fn contradiction(robot: &Robot, earlier: (&Gaps, &JointGap), later: (&Gaps, &JointGap)) -> Contradiction {
    let joint = robot.axis(earlier.1.axis);
    let stated = |(document, gap): (&Gaps, &JointGap)| Stated {
        half_gap: gap.half_gap,
        ci95: gap.ci95,
        varies: gap.schedule.is_some(),
        log: document.logs.first().map(|l| l.name.clone()),
    };
    Contradiction { joint: joint.name.clone(), kind: joint.kind, earlier: stated(earlier), later: stated(later) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\nname: one\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        Robot::parse("robot.yaml", text).unwrap()
    }

    fn document(half_gap_deg: f64, wide_deg: f64, schedule: &str) -> Gaps {
        let text = format!(
            "schema: lostmotion/gaps/1\nrobot: {{name: one, sha256: {}}}\njoints:\n  - {{joint: A1, half_gap_deg: {half_gap_deg}, \
             ci95: [{}, {}], significant: true, schedule: {schedule}}}\n",
            robot().fingerprint(),
            half_gap_deg - wide_deg,
            half_gap_deg + wide_deg
        );
        Gaps::parse("gaps.yaml", &text, &robot()).unwrap()
    }

    #[test]
    fn both_values_are_named_where_intervals_do_not_meet() {
        let found = contradictions(&[document(0.0028, 1e-5, "null"), document(0.0056, 1e-5, "null")], &robot());
        assert_eq!(found.len(), 1);
        let words = found[0].to_string();
        assert!(words.contains("0.00280") && words.contains("0.00560"), "{words}");
    }

    #[test]
    fn a_schedule_contradicts_a_constant_only_beyond_its_own_range() {
        let varying = || document(0.0030, 1e-5, "{kind: pchip, knots: [[-10, 0.0020], [10, 0.0040]]}");
        assert!(contradictions(&[varying(), document(0.0038, 1e-5, "null")], &robot()).is_empty());
        assert_eq!(contradictions(&[varying(), document(0.0056, 1e-5, "null")], &robot()).len(), 1);
    }

    /// An estimate of gap and friction, whose spikes are as large as its gap.
    fn estimated(half_gap_deg: f64, wide_deg: f64) -> Gaps {
        use crate::effects::response::{Response, Spike, Windup};
        use crate::gaps::estimate::{Estimate, JointEstimate, Trust, Why};
        let spike = Spike { gain: half_gap_deg.to_radians(), decay_s: 1.0 };
        let joint = JointEstimate {
            axis: 0,
            response: Response {
                presliding: 1e-4,
                windups: [Windup { half: 0.0, presliding: 1e-4 }; 3],
                spikes: [spike; 3],
            },
            presliding_ci95: [1e-5, 1e-3],
            windup_ci95: [0.0, 0.0],
            spikes_ci95: vec![[0.0, half_gap_deg.to_radians()]; 3],
            scatter: 0.0,
            trust: Trust { compensate: true, before_m: 1e-5, after_m: 1e-6, reversals: 9, reason: Why::Helps },
            agreement: None,
        };
        let estimate = Estimate { joints: vec![joint], predicted: Vec::new(), reversals: Vec::new(), covariance: None };
        Gaps { estimate: Some(estimate), ..document(half_gap_deg, wide_deg, "null") }
    }

    #[test]
    fn two_estimates_of_two_machines_contradict_each_other_whatever_their_friction_is() {
        let found = contradictions(&[estimated(0.0037, 0.0008), estimated(0.0014, 0.0006)], &robot());
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(contradictions(&[estimated(0.0014, 0.0006), document(0.0037, 1e-5, "null")], &robot()).is_empty());
        assert!(contradictions(&[estimated(0.0025, 0.0006), estimated(0.0020, 0.0006)], &robot()).is_empty());
    }

    #[test]
    fn gap_and_windup_together_are_known_better_than_each() {
        let mut gaps = estimated(0.0014, 0.0010);
        let estimate = gaps.estimate.as_mut().unwrap();
        estimate.joints[0].response.spikes[0].gain = 0.0003_f64.to_radians();
        for spike in &mut estimate.joints[0].response.spikes[1..] {
            spike.gain = 0.0;
        }
        // each of gap and wind-up is uncertain by 0.0005 deg, their sum by 0.00003 deg
        let names = ["A1.half_gap_deg(0)", "A1.windup_deg(1 presliding)", "A1.spike_deg(1 s)", "A1.ln_presliding"];
        let (own, other) = (2.5e-7, -2.4955e-7);
        let matrix = vec![vec![own, other, 0.0, 0.0], vec![other, own, 0.0, 0.0], vec![0.0; 4], vec![0.0; 4]];
        estimate.covariance = Some((names.map(String::from).to_vec(), matrix));
        let of = |half_gap_deg: f64| contradictions(&[gaps.clone(), document(half_gap_deg, 1e-5, "null")], &robot());
        assert!(of(0.0014).is_empty() && of(0.0020).is_empty(), "friction that has not decayed");
        assert_eq!(of(0.0042).len(), 1, "three times the gap");
    }
}
