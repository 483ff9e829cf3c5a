//! The priors of the joint estimation: of lost motion about nothing, or of corrections about what is known.

use super::law::{FRICTION, SPIKES, WINDUPS};
use super::problem::Problem;
use nalgebra::{DMatrix, DVector};

/// Standard deviation of a correction by a run, as a share of the joint's lost motion.
pub const SHARE: f64 = 0.05;
/// The same of gap and wind-up together.
pub const STAYS: f64 = 0.01;
/// Spread of the prior of neighbouring knots, as a share of the gap.
const KNOT_SPREAD: f64 = 0.35;
/// Standard deviation of the logarithm of the presliding, about the joint's lost motion.
const PRESLIDING_SPREAD: f64 = 0.8;
/// Standard deviations of a spike and of a wind-up, as shares of the joint's lost motion: where the logs cannot tell them from a
/// gap, it is a gap.
const SPIKE_SPREAD: f64 = 0.3;
const WINDUP_SPREAD: f64 = 0.04;
/// Prior standard deviation of a mean gap at the TCP, m.
const GAP_M: f64 = 1e-3;

impl Problem<'_> {
    /// Precision of the priors and the values about which they stand.
    pub fn prior(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.len();
        let mut precision = DMatrix::zeros(n, n);
        let mut about = DVector::zeros(n);
        if let Some(centre) = &self.centre {
            self.corrections(centre, &mut precision, &mut about);
            self.nuisance_priors(&mut precision);
            return (precision, about);
        }
        for (axis, law) in self.laws.iter().enumerate() {
            let Some(law) = law else { continue };
            let (at, lever, knots) = (self.offset(axis), self.levers[axis], law.gap.len());
            let spread = if self.constant[axis] { 1e-4 } else { KNOT_SPREAD };
            let size = self.sizes[axis];
            let tie = (spread * size).powi(-2);
            for k in 0..knots {
                precision[(at + k, at + k)] += (GAP_M / lever).powi(-2);
                if k > 0 {
                    precision[(at + k, at + k)] += tie;
                    precision[(at + k - 1, at + k - 1)] += tie;
                    precision[(at + k, at + k - 1)] -= tie;
                    precision[(at + k - 1, at + k)] -= tie;
                }
            }
            for k in knots..knots + SPIKES + WINDUPS {
                let spread = if k < knots + SPIKES { SPIKE_SPREAD } else { WINDUP_SPREAD };
                precision[(at + k, at + k)] = (spread * size).powi(-2);
            }
            let k = at + knots + FRICTION - 1;
            precision[(k, k)] = PRESLIDING_SPREAD.powi(-2);
            about[k] = size.ln();
        }
        self.nuisance_priors(&mut precision);
        (precision, about)
    }

    /// What the scores of the priors have in scatter beyond their precision where a wind-up is any share of gap and wind-up together, all
    /// shares being as likely, and any mixture of its parts: an estimate that a prior draws towards zero is off by
    /// `H^-1 P w` for a true wind-up `w`, so `P E(w w') P` replaces `P`.
    pub fn open_wind_up(&self, prior: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(prior.nrows(), prior.ncols());
        if self.centre.is_some() {
            return out;
        }
        for (axis, law) in self.laws.iter().enumerate() {
            let Some(law) = law else { continue };
            let first = self.offset(axis) + law.gap.len() + SPIKES;
            let gap = (law.gap.iter().sum::<f64>() / law.gap.len() as f64).max(0.0);
            // second moments of a uniform share and of a uniform mixture (Dirichlet) of n parts
            let parts = WINDUPS as f64;
            let whole = (gap + law.windup()).powi(2) / 3.0 / (parts * (parts + 1.0));
            for i in first..first + WINDUPS {
                for k in first..first + WINDUPS {
                    let moment = if i == k { 2.0 * whole } else { whole };
                    out[(i, k)] = prior[(i, i)] * moment * prior[(k, k)];
                }
                out[(i, i)] -= prior[(i, i)].min(out[(i, i)]);
            }
        }
        out
    }

    fn nuisance_priors(&self, precision: &mut DMatrix<f64>) {
        let first = self.lost();
        for (k, s) in self.sigmas.iter().enumerate() {
            precision[(first + k, first + k)] = s.powi(-2);
        }
    }

    /// Priors of corrections: each parameter about its known value, neighbouring knots alike; gap and wind-up together, which
    /// stay along a stroke, are known better than each, and slow noise of a run says little of them.
    fn corrections(&self, centre: &[f64], precision: &mut DMatrix<f64>, about: &mut DVector<f64>) {
        for (axis, law) in self.laws.iter().enumerate() {
            let Some(law) = law else { continue };
            let (at, knots) = (self.offset(axis), law.gap.len());
            let each = (SHARE * self.sizes[axis]).powi(-2);
            for k in 0..law.parameters() {
                about[at + k] = centre[at + k];
                precision[(at + k, at + k)] = if k + 1 == law.parameters() { SHARE.powi(-2) } else { each };
                if k > 0 && k < knots {
                    precision[(at + k, at + k)] += each;
                    precision[(at + k - 1, at + k - 1)] += each;
                    precision[(at + k, at + k - 1)] -= each;
                    precision[(at + k - 1, at + k)] -= each;
                }
            }
            let sum = (STAYS * self.sizes[axis]).powi(-2) / knots as f64;
            for k in 0..knots {
                let stays: Vec<usize> =
                    std::iter::once(at + k).chain((0..WINDUPS).map(|m| at + knots + SPIKES + m)).collect();
                for &i in &stays {
                    for &m in &stays {
                        precision[(i, m)] += sum;
                    }
                }
            }
        }
    }
}
