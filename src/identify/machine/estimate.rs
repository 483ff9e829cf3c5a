//! From the solved problem to the document: gaps, responses, intervals, trust.

use super::evidence::{Evidence, Reversal};
use super::law::{FRICTION, JointLaw, OVER, SPIKES, TAUS_S, WINDUPS, turns};
use super::predict::{self, Left, Ratio, along_path, random_effect, recordings};
use super::problem::Problem;
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS};
use crate::compensator::{Response, Spike, Windup};
use crate::effects::{GapCurve, curve::Pchip};
use crate::gaps::estimate::{Agreement, Estimate, JointEstimate, LocalReversal, Trust, Why};
use crate::gaps::{GapPoint, JointGap};
use crate::numerics::fisher;
use crate::numerics::normal::Z95;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use nalgebra::{DMatrix, DVector};

/// p below which a gap counts as varying with position.
const VARIES: f64 = 0.01;
/// Points of a schedule between two knots of the fit.
const SUBDIVIDED: usize = 4;
/// Ratio beyond which, in standard deviations of ratio and scatter together, a reversal is outlying.
const OUTLYING: f64 = 4.0;
/// Reversals from which an outlying one can be determined.
const FEW: usize = 6;
/// Gain must exceed this many standard errors of it.
const BEYOND_DOUBT: f64 = 2.0;

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
    let log_sigma = Z95 * cov[(knots + FRICTION - 1, knots + FRICTION - 1)].max(0.0).sqrt();
    let response = Response { presliding: law.presliding, windups, spikes };
    let wound = cov.view((knots + SPIKES, knots + SPIKES), (WINDUPS, WINDUPS)).sum().max(0.0).sqrt();
    let estimate = JointEstimate {
        axis,
        response,
        presliding_ci95: [law.presliding * (-log_sigma).exp(), law.presliding * log_sigma.exp()],
        windup_ci95: [-Z95, Z95].map(|z| response.windup() + z * wound),
        spikes_ci95: (0..SPIKES).map(|k| around(knots + k, law.spikes[k])).collect(),
        scatter,
        trust: told(trust(&own, &ratio), lost_motion(problem, evidence, axis)),
        agreement: agreement(problem, evidence, axis, &ratio),
    };
    let points = (0..knots)
        .map(|k| (problem.splines[axis].knot(k), k))
        .filter(|(x, _)| *x >= range[0] && *x <= range[1])
        .map(|(at, k)| {
            let s = Z95 * gap_cov[(k, k)].max(0.0).sqrt();
            let half = (problem.splines[axis].knot(1) - problem.splines[axis].knot(0)) / 2.0;
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
        })
        .collect();
    Some((gap, estimate, points))
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

/// Error after reversals below which a joint has no lost motion, m at the TCP: what trackers and programs resolve. Where logs hold next to no
/// noise, the rest of other joints would be taken for it.
const LEAST_M: f64 = 0.5e-6;
/// Share of the error from which what is left counts as no less.
const LITTLE: f64 = 0.9;

/// Share of the mean square error beyond which nothing is gained: 1 % of the root.
const NOTHING: f64 = 0.98;

/// What compensating the joint does at its reversals.
///
/// An error `e` becomes `e - m` by an offset `m`, and its mean square changes by `m^2 (1 - 2 r)` with `r` the error along the model as
/// a multiple of it: compensation helps where `r` exceeds one half, whatever else is in the error. Where too few reversals show
/// `r`, the mean squares before and after decide. What is predicted to be left is never less than the standard error of the mean of `r`.
fn trust(own: &[&Reversal], ratio: &Ratio) -> Trust {
    let n = own.len() as f64;
    let mut trust =
        Trust { compensate: false, before_m: 0.0, after_m: 0.0, reversals: own.len(), reason: Why::NoReversal };
    if own.is_empty() {
        return trust;
    }
    let before = own.iter().map(|r| r.before_m2).sum::<f64>() / n;
    let [left, spread] = weighted(own, before, |r| r.left_m2);
    trust.before_m = before.sqrt();
    let again = predict::after_reversals(own, before, ratio);
    let after = again.unwrap_or(left.max(staying(ratio).powi(2) * before)).max(0.0);
    if trust.before_m < LEAST_M {
        trust.after_m = trust.before_m;
        trust.reason = Why::TooSmall;
        return trust;
    }
    trust.compensate = before - left > BEYOND_DOUBT * spread || ratio.mean - BEYOND_DOUBT * ratio.sigma > 0.5;
    // where the error along the model says that an offset helps, what seems to be more than before is noise
    // an offset is no more certain than the mean of the reversals that it was estimated from
    let floor = ratio.sigma.powi(2) * before;
    // what is left again and again holds no noise: where that is as much as before, an offset on average has no effect that anybody sees
    if trust.compensate && again.is_some_and(|left| left.max(floor) > NOTHING * before) {
        trust.compensate = false;
        trust.after_m = trust.before_m;
        trust.reason = Why::NoLess;
        return trust;
    }
    trust.after_m = if trust.compensate { after.max(floor).min(before) } else { after }.sqrt();
    trust.reason = match trust.compensate {
        true if trust.after_m > LITTLE * trust.before_m => Why::HelpsInTheMean,
        true => Why::Helps,
        false => Why::NotBeyondDoubt,
    };
    trust
}

/// Trust where the lost motion as a whole may be zero: single reversals show an error that something else may make. On a motion of one speed a
/// lag does, and every reversal shows it alike.
fn told(mut trust: Trust, lost: Option<(f64, f64)>) -> Trust {
    if trust.compensate && lost.is_some_and(|(lost, sigma)| Z95 * sigma >= lost.abs()) {
        trust.compensate = false;
        trust.reason = Why::NotTold;
    }
    trust
}

/// Mean over reversals, each by what its noise leaves of it, and the standard error.
fn weighted(own: &[&Reversal], before: f64, of: impl Fn(&Reversal) -> f64) -> [f64; 2] {
    let weight = |r: &Reversal| predict::weight(r, before);
    let total: f64 = own.iter().map(|r| weight(r)).sum();
    let mean = own.iter().map(|r| weight(r) * of(r)).sum::<f64>() / total;
    let spread = own.iter().map(|r| (weight(r) * (of(r) - mean)).powi(2)).sum::<f64>().sqrt() / total;
    [mean, spread]
}

/// Share of the lost motion that the mean and the scatter of single reversals leave.
fn staying(ratio: &Ratio) -> f64 {
    (ratio.mean - 1.0).hypot(ratio.scatter)
}

/// Reversals of an axis without those that stand out of the others: there the estimate without its stretch of the log was drawn off,
/// or something else happened. They are shown as outlying.
fn of_axis(evidence: &Evidence, axis: usize) -> Vec<&Reversal> {
    let own: Vec<&Reversal> = evidence.reversals.iter().filter(|r| r.axis == axis).collect();
    let known: Vec<f64> = own.iter().filter(|r| r.sigma < 1.0).map(|r| r.ratio).collect();
    let Some(middle) = median_of(&mut known.clone()).filter(|_| known.len() >= FEW) else { return own };
    let mut off: Vec<f64> = known.iter().map(|r| (r - middle).abs()).collect();
    let scatter = SIGMA_PER_MAD * median_of(&mut off).unwrap_or(0.0);
    own.into_iter()
        .filter(|r| r.sigma >= 1.0 || (r.ratio - middle).abs() <= OUTLYING * scatter.hypot(r.sigma))
        .collect()
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

/// Whether compensation would leave as much along the paths of all logs together as is there.
///
/// What is left holds the scatter of single reversals and what the model lacks. On machines that the model describes it is a tenth to
/// a third of what is there.
fn gains_nothing(predicted: &[(String, f64, f64)]) -> bool {
    let sum = |of: fn(&(String, f64, f64)) -> f64| predicted.iter().map(|p| of(p).powi(2)).sum::<f64>();
    !predicted.is_empty() && sum(|p| p.2) >= sum(|p| p.1)
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

    fn reversal(ratio: f64, sigma: f64, left_um: f64) -> Reversal {
        Reversal {
            log: 0,
            axis: 0,
            t_s: 0.0,
            at: 0.0,
            before_m2: 1e-10,
            left_m2: (left_um * 1e-6).powi(2),
            left_sigma_m2: 1e-12,
            ratio,
            sigma,
            ..Reversal::default()
        }
    }

    /// Ratios that scatter evenly about a mean with a standard deviation.
    fn even(mean: f64, scatter: f64, sigma: f64) -> Vec<Reversal> {
        (0..41).map(|i| reversal(mean + scatter * f64::from(i - 20) / 11.83, sigma, 1.0)).collect()
    }

    #[test]
    fn the_random_effect_gives_mean_and_scatter() {
        let all = even(0.97, 0.06, 0.01);
        let found = random_effect(&all.iter().collect::<Vec<_>>());
        assert!((found.mean - 0.97).abs() < 1e-9, "{found:?}");
        assert!((found.scatter - 0.06).abs() < 0.005, "{found:?}");
        assert!((found.sigma - 0.06 / 41f64.sqrt()).abs() < 0.001, "{found:?}");
    }

    #[test]
    fn single_reversals_agree_with_all_logs_within_the_uncertainty_of_both() {
        let of = |mean: f64| compared(2e-4, 4e-6, &Ratio { mean, sigma: 0.03, scatter: 0.1 });
        let (close, far) = (of(1.05), of(1.2));
        assert!(close.agree && close.reason().contains("both agree"));
        assert!(!far.agree && far.reason().contains("the fit of all logs is used because"));
        assert!((far.single - 2.4e-4).abs() < 1e-12 && far.all_logs == 2e-4);
        assert!((far.single_ci95[1] - far.single - Z95 * 6e-6).abs() < 1e-12, "{far:?}");
    }

    #[test]
    fn a_model_that_leaves_as_much_as_is_there_is_not_used() {
        let log = |before: f64, after: f64| ("log.csv".to_string(), before, after);
        assert!(gains_nothing(&[log(27e-6, 41e-6), log(31e-6, 40e-6)]));
        assert!(!gains_nothing(&[log(27e-6, 4e-6), log(5e-6, 6e-6)]));
        assert!(!gains_nothing(&[]), "dwells alone have no path");
    }

    #[test]
    fn a_joint_that_hardly_moves_the_tcp_is_not_compensated_however_well_it_is_known() {
        for (before_m, compensate) in [(0.1e-6, false), (1e-6, true)] {
            let mut all = even(1.0, 0.02, 0.005);
            for r in &mut all {
                (r.before_m2, r.left_m2, r.left_sigma_m2) = (before_m * before_m, 0.0, 0.0);
            }
            let own: Vec<&Reversal> = all.iter().collect();
            let found = trust(&own, &random_effect(&own));
            assert_eq!(found.compensate, compensate, "{found:?}");
            assert!((found.before_m - before_m).abs() < 1e-12 && found.after_m <= found.before_m, "{found:?}");
        }
    }

    #[test]
    fn a_joint_whose_predicted_error_is_no_less_is_not_compensated() {
        // along the model the mean exceeds one half beyond doubt, but single reversals scatter by more than the lost motion
        let of = |scatter: f64| {
            let mut all = even(1.0, scatter, 0.01);
            for (k, r) in all.iter_mut().enumerate() {
                (r.t_s, r.direction) = (10.0 * k as f64, 1.0);
            }
            let own: Vec<&Reversal> = all.iter().collect();
            trust(&own, &random_effect(&own))
        };
        let (good, wild) = (of(0.1), of(1.2));
        assert!(good.compensate && good.after_m < 0.2 * good.before_m, "{good:?}");
        assert!(!wild.compensate && wild.reason == Why::NoLess && wild.after_m == wild.before_m, "{wild:?}");
    }

    #[test]
    fn lost_motion_that_a_lag_makes_as_well_is_not_compensated() {
        let all = even(1.0, 0.02, 0.005);
        let own: Vec<&Reversal> = all.iter().collect();
        let found = || trust(&own, &random_effect(&own));
        assert!(told(found(), Some((2e-5, 0.9e-5))).compensate);
        let open = told(found(), Some((2e-5, 1.1e-5)));
        assert!(!open.compensate && open.reason == Why::NotTold, "{open:?}");
    }

    #[test]
    fn reversals_that_stand_out_decide_nothing() {
        let mut all = even(1.0, 0.03, 0.02);
        all.extend((0..6).map(|_| reversal(-2.3, 0.017, 90.0)));
        let evidence = Evidence { covariance: DMatrix::zeros(0, 0), within: DMatrix::zeros(0, 0), reversals: all };
        let kept = of_axis(&evidence, 0);
        assert_eq!(kept.len(), 41);
        assert!((random_effect(&kept).mean - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_joint_is_compensated_where_the_error_along_the_model_exceeds_one_half_beyond_doubt() {
        // what is left is a little more than what was there: noise, which no offset reduces
        let noisy = |mean: f64, sigma: f64| -> Vec<Reversal> {
            (0..40).map(|i| reversal(mean + 0.05 * f64::from(i % 3 - 1), sigma, 10.5)).collect()
        };
        for (mean, sigma, compensate) in [(0.9, 0.1, true), (0.55, 0.9, false), (0.4, 0.05, false), (0.0, 0.05, false)]
        {
            let all = noisy(mean, sigma);
            let own: Vec<&Reversal> = all.iter().collect();
            assert_eq!(trust(&own, &random_effect(&own)).compensate, compensate, "ratio {mean} +- {sigma}");
        }
    }
}
