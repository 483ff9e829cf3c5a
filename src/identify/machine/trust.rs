//! Whether a joint is compensated: what an offset does at its single reversals, on parts of the logs that were not fitted.

use super::evidence::{Evidence, Reversal};
use super::predict::{self, Ratio};
use crate::gaps::estimate::{Trust, Why};
use crate::numerics::normal::Z95;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};

/// Ratio beyond which, in standard deviations of ratio and scatter together, a reversal is outlying.
pub(super) const OUTLYING: f64 = 4.0;
/// Reversals from which an outlying one can be determined.
const FEW: usize = 6;
/// Gain must exceed this many standard errors of it.
const BEYOND_DOUBT: f64 = 2.0;
/// Error after reversals below which a joint has no lost motion, m at the TCP: what trackers and programs resolve. Where logs hold next to
/// no noise, the rest of other joints would be taken for it.
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
pub(super) fn trust(own: &[&Reversal], ratio: &Ratio) -> Trust {
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

/// Trust where the lost motion as a whole may be zero: single reversals show an error that something else may make. On a motion of one
/// speed a lag does, and every reversal shows it alike.
pub(super) fn distrusted_if_zero(mut trust: Trust, lost: Option<(f64, f64)>) -> Trust {
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
pub(super) fn of_axis(evidence: &Evidence, axis: usize) -> Vec<&Reversal> {
    let own: Vec<&Reversal> = evidence.reversals.iter().filter(|r| r.axis == axis).collect();
    let known: Vec<f64> = own.iter().filter(|r| r.sigma < 1.0).map(|r| r.ratio).collect();
    let Some(middle) = median_of(&mut known.clone()).filter(|_| known.len() >= FEW) else { return own };
    let mut off: Vec<f64> = known.iter().map(|r| (r - middle).abs()).collect();
    let scatter = SIGMA_PER_MAD * median_of(&mut off).unwrap_or(0.0);
    own.into_iter()
        .filter(|r| r.sigma >= 1.0 || (r.ratio - middle).abs() <= OUTLYING * scatter.hypot(r.sigma))
        .collect()
}

/// Whether compensation would leave as much along the paths of all logs together as is there.
///
/// What is left holds the scatter of single reversals and what the model lacks. On machines that the model describes it is a tenth to
/// a third of what is there.
pub(super) fn gains_nothing(predicted: &[(String, f64, f64)]) -> bool {
    let sum = |of: fn(&(String, f64, f64)) -> f64| predicted.iter().map(|p| of(p).powi(2)).sum::<f64>();
    !predicted.is_empty() && sum(|p| p.2) >= sum(|p| p.1)
}

#[cfg(test)]
mod tests {
    use super::super::predict::random_effect;
    use super::*;
    use nalgebra::DMatrix;

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
        assert!(distrusted_if_zero(found(), Some((2e-5, 0.9e-5))).compensate);
        let open = distrusted_if_zero(found(), Some((2e-5, 1.1e-5)));
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
