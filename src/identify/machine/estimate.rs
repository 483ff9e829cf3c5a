//! From the solved problem to the document: gaps, responses, intervals; [`trust`](super::trust) judges them.

use super::evidence::{Evidence, Reversal};
use super::law::{FRICTION, JointLaw, OVER, SPIKES, TAUS_S, WINDUPS, turns};
use super::predict::{self, Left, Ratio, along_path, random_effect, recordings};
use super::problem::Problem;
use super::trust::{OUTLYING, distrusted_if_zero, gains_nothing, of_axis, trust};
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS};
use crate::compensator::{Response, Spike, Windup};
use crate::effects::{GapCurve, curve::Pchip};
use crate::gaps::estimate::{Agreement, Estimate, JointEstimate, LocalReversal, Why};
use crate::gaps::{GapPoint, JointGap};
use crate::numerics::fisher;
use crate::numerics::normal::Z95;
use nalgebra::{DMatrix, DVector};

/// p below which a gap counts as varying with position.
const VARIES: f64 = 0.01;
/// Points of a schedule between two knots of the fit.
const SUBDIVIDED: usize = 4;

/// Covariance of the parameters of one axis, as a block.
fn block(problem: &Problem, evidence: &Evidence, axis: usize, n: usize) -> DMatrix<f64> {
    let at = problem.offset(axis);
    evidence.covariance.view((at, at), (n, n)).into_owned()
}

/// Mean of the spline's weights over the places where the joint turns, their range and number.
pub fn mean_weights(problem: &Problem, axis: usize) -> (DVector<f64>, [f64; 2], usize) {
    let spline = &problem.splines[axis];
    let mut sum = DVector::zeros(spline.knots());
    let (mut n, mut range) = (0usize, [f64::INFINITY, f64::NEG_INFINITY]);
    let mut w = vec![0.0; spline.knots()];
    for log in &problem.logs {
        for (_, rows) in log.moving.iter().filter(|m| m.0 == axis) {
            for row in turns(&rows.x) {
                spline.weights(rows.x[row], &mut w);
                sum += DVector::from_column_slice(&w);
                n += 1;
                range = [range[0].min(rows.x[row]), range[1].max(rows.x[row])];
            }
        }
    }
    if n > 0 {
        (sum / n as f64, range, n)
    } else {
        (DVector::from_element(spline.knots(), 1.0 / spline.knots() as f64), range, 0)
    }
}

/// p value of the test that the gap is the same at all knots.
///
/// The covariance is itself estimated, from as many independent windows as the joint has reversals: Hotelling's T squared, not
/// chi-squared (Hotelling 1931).
fn varies_p(problem: &Problem, within: &DMatrix<f64>, axis: usize) -> Option<f64> {
    let law = problem.laws[axis].as_ref()?;
    let k = law.gap.len();
    if k < 2 {
        return None;
    }
    let cov = within.view((problem.offset(axis), problem.offset(axis)), (k, k)).into_owned();
    // differences of neighbouring knots
    let contrast = DMatrix::from_fn(k - 1, k, |i, j| f64::from(i8::from(j == i + 1) - i8::from(j == i)));
    let d = &contrast * DVector::from_column_slice(&law.gap);
    let spread = &contrast * cov * contrast.transpose();
    let squares = d.dot(&nalgebra::Cholesky::new(spread)?.solve(&d));
    let (differences, reversals) = ((k - 1) as f64, mean_weights(problem, axis).2 as f64);
    let freedom = reversals - differences;
    // too few reversals to tell
    Some(if freedom < 1.0 {
        1.0
    } else {
        fisher::tail(squares * freedom / (differences * (reversals - 1.0)), differences, freedom)
    })
}

/// Axes whose gap does not vary beyond doubt, with the p value; `within` is the covariance without what logs disagree in.
pub fn constant_axes(problem: &Problem, within: &DMatrix<f64>) -> Vec<(bool, Option<f64>)> {
    (0..problem.laws.len())
        .map(|a| {
            let p = varies_p(problem, within, a);
            (p.is_none_or(|p| p >= VARIES), p)
        })
        .collect()
}

/// Gap and estimate of an axis.
pub fn joint(
    problem: &Problem,
    evidence: &Evidence,
    axis: usize,
    p: Option<f64>,
) -> Option<(JointGap, JointEstimate, Vec<GapPoint>)> {
    let law = problem.laws[axis].as_ref()?;
    let (weights, range, n) = mean_weights(problem, axis);
    if n == 0 {
        return None;
    }
    let knots = law.gap.len();
    let cov = block(problem, evidence, axis, law.parameters());
    let gap_cov = cov.view((0, 0), (knots, knots)).into_owned();
    let mean = weights.dot(&DVector::from_column_slice(&law.gap));
    let sigma = weights.dot(&(&gap_cov * &weights)).max(0.0).sqrt();
    let schedule = (!problem.constant[axis]).then(|| schedule(problem, axis, law)).flatten();
    let own = of_axis(evidence, axis);
    let ratio = random_effect(&own);
    let (centre, scatter) = (if ratio.mean > 0.0 { ratio.mean } else { 1.0 }, ratio.scatter);
    let half_gap = mean.max(0.0);
    let gap = JointGap {
        axis,
        half_gap,
        ci95: [(mean - Z95 * sigma).max(0.0), (mean + Z95 * sigma).max(0.0)],
        significant: mean > Z95 * sigma,
        sides: None,
        schedule,
        varies_p_value: p,
        stiction: None,
        stiction_p_value: None,
    };
    let around = |k: usize, v: f64| {
        let s = Z95 * cov[(k, k)].max(0.0).sqrt();
        [v - s, v + s]
    };
    let log_sigma = Z95 * cov[(knots + FRICTION - 1, knots + FRICTION - 1)].max(0.0).sqrt();
    let response = response(law, mean);
    let wound = cov.view((knots + SPIKES, knots + SPIKES), (WINDUPS, WINDUPS)).sum().max(0.0).sqrt();
    let estimate = JointEstimate {
        axis,
        response,
        presliding_ci95: [law.presliding * (-log_sigma).exp(), law.presliding * log_sigma.exp()],
        windup_ci95: [-Z95, Z95].map(|z| response.windup() + z * wound),
        spikes_ci95: (0..SPIKES).map(|k| around(knots + k, law.spikes[k])).collect(),
        scatter,
        trust: distrusted_if_zero(trust(&own, &ratio), lost_motion(problem, evidence, axis)),
        agreement: agreement(problem, evidence, axis, &ratio),
    };
    let points = points(problem, (axis, law), &own, centre, range, &gap_cov);
    Some((gap, estimate, points))
}

/// The law as a compensator has it; `mean` is the gap's mean, rad or m.
fn response(law: &JointLaw, mean: f64) -> Response {
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    for (s, (gain, tau)) in spikes.iter_mut().zip(law.spikes.iter().zip(TAUS_S)) {
        *s = Spike { gain: *gain, decay_s: tau };
    }
    // a joint that leads by its gap winds up by so much less
    let mut windups = [Windup { half: 0.0, presliding: law.presliding }; MOST_WINDUPS];
    for (w, (half, over)) in windups.iter_mut().zip(law.windups.iter().zip(OVER)) {
        *w = Windup { half: *half, presliding: law.presliding * over };
    }
    windups[0].half += mean.min(0.0);
    Response { presliding: law.presliding, windups, spikes }
}

/// The gap at the knots within `range`, with what single reversals near each say of it as multiples of `centre`.
fn points(
    problem: &Problem,
    (axis, law): (usize, &JointLaw),
    own: &[&Reversal],
    centre: f64,
    range: [f64; 2],
    gap_cov: &DMatrix<f64>,
) -> Vec<GapPoint> {
    let spline = &problem.splines[axis];
    let half = (spline.knot(1) - spline.knot(0)) / 2.0;
    let at_knot = |k: usize| {
        let at = spline.knot(k);
        let s = Z95 * gap_cov[(k, k)].max(0.0).sqrt();
        let near: Vec<f64> =
            own.iter().filter(|r| (r.at - at).abs() <= half).map(|r| r.ratio / centre * law.gap[k]).collect();
        GapPoint {
            axis,
            at,
            half_gap: law.gap[k],
            ci95: [law.gap[k] - s, law.gap[k] + s],
            cycles: near.len(),
            per_cycle: near,
        }
    };
    let within = |k: &usize| (range[0]..=range[1]).contains(&spline.knot(*k));
    (0..law.gap.len()).filter(within).map(at_knot).collect()
}

/// Lost motion after a reversal by the fit of all logs and by the single reversals.
///
/// Each reversal is judged by an estimate that did not use its stretch of the log, as a multiple of that estimate's lost motion; the
/// mean of the multiples is a random effect. Of the fit the sum counts: gap, spikes and wind-up are known together far better than each.
fn agreement(problem: &Problem, evidence: &Evidence, axis: usize, ratio: &Ratio) -> Option<Agreement> {
    let (lost, sigma) = lost_motion(problem, evidence, axis)?;
    ratio.sigma.is_finite().then(|| compared(lost, sigma, ratio))
}

/// Lost motion of a joint just after a reversal (half gap, spikes and wind-up together) and its standard deviation, rad or m.
fn lost_motion(problem: &Problem, evidence: &Evidence, axis: usize) -> Option<(f64, f64)> {
    let law = problem.laws[axis].as_ref()?;
    let (weights, _, n) = mean_weights(problem, axis);
    if n == 0 {
        return None;
    }
    let mut each = DVector::zeros(law.parameters());
    each.rows_mut(0, weights.len()).copy_from(&weights);
    each.rows_mut(weights.len(), SPIKES + WINDUPS).fill(1.0);
    let lost = each.dot(&DVector::from_vec(law.to_vec()));
    let at = problem.offset(axis);
    let within = evidence.within.view((at, at), (each.len(), each.len()));
    Some((lost, each.dot(&(within * &each)).max(0.0).sqrt()))
}

/// Lost motion by all logs, with its standard deviation, against the multiple of it that single reversals show.
fn compared(lost: f64, sigma: f64, ratio: &Ratio) -> Agreement {
    let (single, single_sigma) = (ratio.mean * lost, ratio.sigma * lost.abs());
    let around = |value: f64, sigma: f64| [value - Z95 * sigma, value + Z95 * sigma];
    Agreement {
        all_logs: lost,
        all_logs_ci95: around(lost, sigma),
        single,
        single_ci95: around(single, single_sigma),
        agree: (single - lost).abs() <= Z95 * sigma.hypot(single_sigma),
    }
}

/// The fitted spline as a curve of the document; never below zero.
fn schedule(problem: &Problem, axis: usize, law: &JointLaw) -> Option<GapCurve> {
    let spline = &problem.splines[axis];
    let n = (spline.knots() - 1) * SUBDIVIDED;
    let (lo, hi) = (spline.knot(0), spline.knot(spline.knots() - 1));
    let knots: Vec<[f64; 2]> =
        (0..=n).map(|i| lo + (hi - lo) * i as f64 / n as f64).map(|x| [x, spline.at(x, &law.gap).max(0.0)]).collect();
    Pchip::new(&knots).map(GapCurve::Pchip)
}

/// Single reversals for the document.
pub fn local(problem: &Problem, evidence: &Evidence, joints: &[JointEstimate]) -> Vec<LocalReversal> {
    let of = |r: &Reversal| {
        let scatter = joints.iter().find(|j| j.axis == r.axis).map_or(0.0, |j| j.scatter);
        let (ratio, sigma) = (r.ratio, r.sigma);
        LocalReversal {
            axis: r.axis,
            log: problem.logs[r.log].name.clone(),
            t_s: r.t_s,
            at: r.at,
            ratio,
            sigma,
            outlying: (ratio - 1.0).abs() > OUTLYING * sigma.hypot(scatter),
        }
    };
    evidence.reversals.iter().filter(|r| r.sigma < 1.0).map(of).collect()
}

/// The whole estimate; covariance in the units of its names.
pub fn whole(problem: &Problem, evidence: &Evidence, mut joints: Vec<JointEstimate>) -> Estimate {
    let mut names = Vec::new();
    let mut at = Vec::new();
    for (axis, law) in problem.laws.iter().enumerate() {
        let Some(law) = law else { continue };
        let joint = problem.robot.axis(axis);
        let (kind, unit, first) = (joint.kind, joint.kind.unit(), problem.offset(axis));
        let scale = kind.to_user_unit(1.0);
        let knots = law.gap.len();
        for k in 0..knots {
            let place = kind.to_user_unit(problem.splines[axis].knot(k));
            names.push(format!("{}.half_gap_{unit}({place:.3})", joint.name));
            at.push((first + k, scale));
        }
        for (k, tau) in TAUS_S.iter().enumerate() {
            names.push(format!("{}.spike_{unit}({tau} s)", joint.name));
            at.push((first + knots + k, scale));
        }
        for (k, over) in OVER.iter().enumerate() {
            names.push(format!("{}.windup_{unit}({over} presliding)", joint.name));
            at.push((first + knots + SPIKES + k, scale));
        }
        names.push(format!("{}.ln_presliding", joint.name));
        at.push((first + knots + FRICTION - 1, 1.0));
    }
    let matrix =
        at.iter().map(|(i, a)| at.iter().map(|(k, b)| evidence.covariance[(*i, *k)] * a * b).collect()).collect();
    let reversals = local(problem, evidence, &joints);
    let left = |axis: usize| {
        let trust = joints.iter().find(|j| j.axis == axis).map(|j| &j.trust).filter(|t| t.compensate);
        let Some(t) = trust else { return Left { share: 1.0, after_reversal_m2: None } };
        let (own, before) = (of_axis(evidence, axis), t.before_m.powi(2));
        let whole = (t.after_m.powi(2) / before.max(f64::MIN_POSITIVE)).sqrt();
        let share = predict::share_that_stays(&own, before, &random_effect(&own)).unwrap_or(whole).min(1.0);
        Left { share, after_reversal_m2: Some(t.after_m.powi(2)) }
    };
    let moving = |r: &Vec<usize>| r.iter().map(|l| problem.logs[*l].moving.len()).sum::<usize>();
    let several = recordings(problem).into_iter().filter(|r| moving(r) > 1);
    let predicted: Vec<(String, f64, f64)> = several
        .filter_map(|r| {
            let errors = along_path(problem, &evidence.covariance, &r, &left)?;
            Some((problem.logs[*r.first()?].name.clone(), errors))
        })
        .map(|(name, [before, after])| (name, before, after))
        .collect();
    if gains_nothing(&predicted) {
        for joint in joints.iter_mut().filter(|j| j.trust.compensate) {
            joint.trust.compensate = false;
            joint.trust.reason = Why::NothingGained;
        }
    }
    Estimate { joints, predicted, reversals, covariance: Some((names, matrix)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_reversals_agree_with_all_logs_within_the_uncertainty_of_both() {
        let of = |mean: f64| compared(2e-4, 4e-6, &Ratio { mean, sigma: 0.03, scatter: 0.1 });
        let (close, far) = (of(1.05), of(1.2));
        assert!(close.agree && close.reason().contains("both agree"));
        assert!(!far.agree && far.reason().contains("the fit of all logs is used because"));
        assert!((far.single - 2.4e-4).abs() < 1e-12 && far.all_logs == 2e-4);
        assert!((far.single_ci95[1] - far.single - Z95 * 6e-6).abs() < 1e-12, "{far:?}");
    }
}
