//! Predicted error after compensation: what the machine leaves, not what the tracker sees.
//!
//! A window after a reversal holds the tracker's noise, the wander of its frame and of the TCP, and what other joints leave. To take off
//! a variance that the model of the noise states leaves what that model lacks. Instead, the held-out remainders of two reversals of the
//! same direction are multiplied: noise and wander of windows that do not overlap have nothing to do with each other, so the mean
//! product holds what is left again and again, and nothing else. What differs from one reversal to the next is the scatter of
//! the lost motion itself (a random effect, noise taken off).
//!
//! What no log tells: where friction is larger one way, the wind-ups of the two directions differ, and half the difference is a constant
//! offset of the joint, which looks like its zero position. It is an error all the same, and counts by its expected size.

use super::evidence::{AFTER_S, APART_S, Reversal};
use super::law::{SPIKES, WINDUPS, turns};
use super::problem::Problem;
use crate::machine::measurement::Instrument;
use nalgebra::{DMatrix, Vector3};

/// Friction of one direction beyond the mean of both, at most, as a share of that mean. The Coulomb friction both ways of the six joints of
/// a PUMA 560 in Corke's Robotics Toolbox (after Corke and Armstrong-Helouvry 1994) gives 0.05 to 0.45, rms 0.25.
const UNEVEN: f64 = 0.3;
/// Relative to the mean square lost motion, the scatter of single windows that their weights assume beside noise.
const UNEQUAL: f64 = 0.3;

/// What is left of a joint's lost motion.
#[derive(Debug, Clone, Copy)]
pub struct Left {
    /// Share that stays along a stroke.
    pub share: f64,
    /// Mean square TCP error within [`AFTER_S`] of a reversal, m^2; `None`: that share of the lost motion there, too.
    pub after_reversal_m2: Option<f64>,
}

/// The single reversals of a joint together: lost motion as a multiple of the model's.
#[derive(Debug, Clone, Copy)]
pub struct Ratio {
    pub mean: f64,
    /// Standard error of the mean; infinite where too few reversals can be judged.
    pub sigma: f64,
    /// Standard deviation from reversal to reversal.
    pub scatter: f64,
}

/// Mean and scatter of the single reversals' ratios as a random effect (DerSimonian and Laird 1986).
pub fn random_effect(own: &[&Reversal]) -> Ratio {
    let known: Vec<(f64, f64)> =
        own.iter().filter(|r| r.sigma.is_finite() && r.sigma < 1.0).map(|r| (r.ratio, r.sigma.powi(-2))).collect();
    let total: f64 = known.iter().map(|k| k.1).sum();
    if known.len() < 3 || total <= 0.0 {
        return Ratio { mean: 1.0, sigma: f64::INFINITY, scatter: 0.0 };
    }
    let first = known.iter().map(|(r, w)| r * w).sum::<f64>() / total;
    let q: f64 = known.iter().map(|(r, w)| w * (r - first).powi(2)).sum();
    let squares: f64 = known.iter().map(|k| k.1 * k.1).sum();
    let variance = ((q - (known.len() - 1) as f64) / (total - squares / total)).max(0.0);
    let weight = |w: f64| (1.0 / w + variance).recip();
    let all: f64 = known.iter().map(|k| weight(k.1)).sum();
    let mean = known.iter().map(|(r, w)| r * weight(*w)).sum::<f64>() / all;
    Ratio { mean, sigma: all.sqrt().recip(), scatter: variance.sqrt() }
}

/// Weight of a reversal by the noise of its window.
pub fn weight(r: &Reversal, before_m2: f64) -> f64 {
    (r.left_sigma_m2.powi(2) + (UNEQUAL * before_m2).powi(2)).recip()
}

/// Mean product of what two reversals of the same direction in one log leave; `None` without such a pair.
fn repeated(own: &[&Reversal], before_m2: f64, product: impl Fn(&Reversal, &Reversal) -> f64) -> Option<f64> {
    let (mut sum, mut all) = (0.0, 0.0);
    for (i, a) in own.iter().enumerate() {
        for b in &own[i + 1..] {
            if a.log == b.log && a.direction == b.direction && (a.t_s - b.t_s).abs() > APART_S {
                let w = (weight(a, before_m2) * weight(b, before_m2)).sqrt();
                sum += w * product(a, b);
                all += w;
            }
        }
    }
    (all > 0.0).then(|| sum / all)
}

/// Mean square TCP error that compensation leaves within [`AFTER_S`] of a reversal, m^2.
pub fn after_reversals(own: &[&Reversal], before_m2: f64, ratio: &Ratio) -> Option<f64> {
    let again = repeated(own, before_m2, |a, b| a.left.dot(&((a.energy + b.energy) * b.left)) / 2.0)?;
    Some(again.max(0.0) + ratio.scatter.powi(2) * before_m2)
}

/// Share of the lost motion that compensation leaves along a stroke: what is left at the end of the windows, and the scatter.
pub fn share_that_stays(own: &[&Reversal], before_m2: f64, ratio: &Ratio) -> Option<f64> {
    let again = repeated(own, before_m2, |a, b| a.end_m * b.end_m)?.max(0.0);
    let lost = own.iter().map(|r| r.lost_end_m.powi(2)).sum::<f64>() / own.len() as f64;
    (lost > 0.0).then(|| (again / lost + ratio.scatter.powi(2)).sqrt())
}

/// Mean square of the constant offset of a joint by uneven friction, rad^2 or m^2: every unevenness up to the largest is as likely, and
/// the wind-up is what the logs tell of it, with its uncertainty.
fn unseen(problem: &Problem, covariance: &DMatrix<f64>, axis: usize) -> f64 {
    let Some(law) = &problem.laws[axis] else { return 0.0 };
    let first = problem.offset(axis) + law.gap.len() + SPIKES;
    let variance = covariance.view((first, first), (WINDUPS, WINDUPS)).sum().max(0.0);
    UNEVEN.powi(2) / 3.0 * (law.windup().powi(2) + variance)
}

/// What was recorded together: a log of the TCP or of one reading by itself, the joint sensors of a log together.
pub fn recordings(problem: &Problem) -> Vec<Vec<usize>> {
    let sensed = |l: usize| match problem.logs[l].instrument {
        Instrument::Joint { axis } => Some(axis),
        _ => None,
    };
    let mut out: Vec<Vec<usize>> = Vec::new();
    for l in 0..problem.logs.len() {
        // the sensors of a log follow each other in the order of their axes
        let with = out.last().and_then(|r| r.last()).copied().filter(|&k| {
            let alike = problem.logs[k].name == problem.logs[l].name && problem.logs[k].bins == problem.logs[l].bins;
            alike && sensed(k).zip(sensed(l)).is_some_and(|(a, b)| a < b)
        });
        match (with, out.last_mut()) {
            (Some(_), Some(recording)) => recording.push(l),
            _ => out.push(vec![l]),
        }
    }
    out
}

/// Root mean square distance from the path along a recording, m: of all lost motion, and of what is left of it.
///
/// Along the path lost motion is a delay and no deviation, so its component along the movement does not count; nor do bins at rest.
pub fn along_path(
    problem: &Problem,
    covariance: &DMatrix<f64>,
    recording: &[usize],
    left: &dyn Fn(usize) -> Left,
) -> Option<[f64; 2]> {
    let l = &problem.logs[*recording.first()?];
    let (mut before, mut after, mut n) = (0.0, 0.0, 0.0);
    let mut each = Vec::new();
    for &log in recording {
        for ((axis, response), (_, rows)) in problem.responses(log, false).into_iter().zip(&problem.logs[log].moving) {
            let mut errors = Vec::new();
            problem.logs[log].average(&response.error, &mut errors);
            let turned: Vec<f64> = turns(&rows.x).into_iter().map(|k| rows.t_s[k]).collect();
            let near = |t: f64| turned[..turned.partition_point(|s| *s <= t)].last().is_some_and(|s| t - s <= AFTER_S);
            let near: Vec<bool> = l.t_s.iter().map(|t| near(*t)).collect();
            each.push((axis, left(axis), errors, near, unseen(problem, covariance, axis)));
        }
    }
    for b in (0..l.len()).filter(|b| recording.iter().all(|log| !problem.unused[*log][*b])) {
        let velocity: Vector3<f64> = l.jacobian[b].iter().zip(&l.speed[b]).map(|(j, v)| j * *v).sum();
        let Some(along) = velocity.try_normalize(1e-6) else { continue };
        let across = |v: Vector3<f64>| v - along * along.dot(&v);
        let mut lost = Vector3::zeros();
        for (axis, left, errors, near, unseen) in &each {
            let column = l.jacobian[b][*axis];
            let part = across(column * errors[b]);
            lost += part;
            after += unseen * across(column).norm_squared();
            after += match left.after_reversal_m2.filter(|_| near[b]) {
                Some(m2) => m2 * across(column).norm_squared() / column.norm_squared().max(f64::MIN_POSITIVE),
                None => left.share.powi(2) * part.norm_squared(),
            };
        }
        before += lost.norm_squared();
        n += 1.0;
    }
    (n > 0.0).then(|| [(before / n).sqrt(), (after / n).sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// Sixty reversals that leave a step of 3 um again and again, and a wander of 8 um that changes slowly: neighbours share it.
    fn wandering(apart_s: f64) -> Vec<Reversal> {
        let mut state = 12345u64;
        let mut normal = || {
            let uniform = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 11) as f64 / (1u64 << 53) as f64
            };
            std::iter::repeat_with(uniform).take(12).sum::<f64>() - 6.0
        };
        (0..60)
            .map(|i| {
                let left = 3e-6 + 8e-6 * normal();
                Reversal {
                    t_s: apart_s * f64::from(i),
                    direction: f64::from(i % 2 * 2 - 1),
                    left: Vector3::new(left, 0.0, 0.0),
                    energy: Matrix3::identity(),
                    before_m2: 2.5e-9,
                    left_sigma_m2: 1e-11,
                    end_m: left,
                    lost_end_m: 5e-5,
                    ..Reversal::default()
                }
            })
            .collect()
    }

    const EVEN: Ratio = Ratio { mean: 1.0, sigma: 0.01, scatter: 0.0 };

    #[test]
    fn what_is_left_again_and_again_is_told_from_noise_of_unknown_size() {
        let all = wandering(10.0);
        let own: Vec<&Reversal> = all.iter().collect();
        let left = after_reversals(&own, 2.5e-9, &EVEN).unwrap().sqrt();
        let raw = (all.iter().map(|r| r.left.x.powi(2)).sum::<f64>() / 60.0).sqrt();
        assert!(raw > 7e-6, "the mean square holds the noise: {raw}");
        assert!((left - 3e-6).abs() < 1.5e-6, "{left}");
        let share = share_that_stays(&own, 2.5e-9, &EVEN).unwrap();
        assert!((share - left / 5e-5).abs() < 1e-9, "{share}");
        let scattering = Ratio { scatter: 0.1, ..EVEN };
        let more = after_reversals(&own, 2.5e-9, &scattering).unwrap();
        assert!((more - left.powi(2) - 2.5e-11).abs() < 1e-15, "scatter of single reversals counts: {more}");
    }

    #[test]
    fn without_two_windows_of_one_direction_that_do_not_overlap_nothing_is_told() {
        let all = wandering(10.0);
        assert!(after_reversals(&[&all[0], &all[1]], 2.5e-9, &EVEN).is_none(), "one up, one down");
        let close = wandering(1.0);
        assert!(share_that_stays(&[&close[0], &close[2]], 2.5e-9, &EVEN).is_none(), "windows overlap");
    }
}
