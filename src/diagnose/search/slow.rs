//! What varies more slowly than the instrument scatters: the noise model may hold it for wander although it is structure.
//!
//! An autoregressive noise with a correlation near 1 explains any slow course, a step and a drift among them, so that nothing is left for
//! a test. How an instrument scatters from one sample to the next does not depend on that: the second differences of what is left
//! have six times the variance of white noise, and slow courses vanish from them. What is left far beyond it is reported.

use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::Group;
use crate::diagnose::search::fit::Fit;
use crate::numerics::robust::{SIGMA_PER_MAD, median};

/// Slow part, in standard deviations of the instrument, beyond which it is reported.
const FAR: f64 = 2.0;
/// Samples of a group that tell how an instrument scatters.
const ENOUGH: usize = 100;

/// What varies slowly, and what it depends on.
#[derive(Debug, Clone)]
pub struct SlowPart {
    /// rms per coordinate, m or rad.
    pub rms: f64,
    /// Scatter of the instrument from one sample to the next, m or rad.
    pub instrument: f64,
    /// The largest structure in it.
    pub ratio: Ratio,
}

/// Scatter of one group from one sample to the next: by its second differences, whose median does not see a few jumps.
fn scatter(group: &Group, residual: &[f64]) -> f64 {
    let n = group.len();
    let series = (0..group.dims).map(|c| &residual[group.offset + c * n..group.offset + (c + 1) * n]);
    let second: Vec<f64> = series.flat_map(|v| v.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())).collect();
    SIGMA_PER_MAD * median(&second) / 6f64.sqrt()
}

/// The slow part of what a fit leaves, where it is far beyond the scatter of the instrument; `tested`: the test without the catalogue of
/// the same residual, which says what it depends on most.
pub fn beside_instrument(problem: &Problem, fit: &Fit, tested: &Tested) -> Option<SlowPart> {
    let residual = &fit.state.residual;
    let of = |g: &Group| {
        let v = &residual[g.range()];
        (v.iter().map(|x| x * x).sum::<f64>() / v.len().max(1) as f64, scatter(g, residual).powi(2))
    };
    // rotations stand beside points, in another unit
    let points = problem.groups.iter().any(|g| g.sensor.is_length());
    let shown = |g: &&Group| g.sensor.is_length() == points && g.len() >= ENOUGH && !problem.logs[g.log].log.poses;
    let motions = problem.groups.iter().filter(shown);
    let far = |(all, own): &(f64, f64)| all - own > FAR * FAR * own && *own > 0.0;
    let (all, own) = motions.map(of).filter(far).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let most = tested.groups.iter().max_by(|a, b| (a.gain - a.dof as f64).total_cmp(&(b.gain - b.dof as f64)))?;
    Some(SlowPart { rms: (all - own).sqrt(), instrument: own.sqrt(), ratio: most.clone() })
}
