//! Is this a machine on which everything is wrong? Asked before the search for a few effects, of a thinned copy of the logs.
//!
//! Method: lags, gaps, gravity and geometry are fitted together, with the noise of what is left; counted are the lags and gaps
//! that held-out blocks support far beyond chance. Where they are no more than the search for a few effects can find, that has the
//! first word.

use super::{MachineFit, groups, members};
use crate::diagnose::prepare;
use crate::effects::{Family, ServoLag};
use crate::log::Log;
use crate::model::Model;
use crate::numerics::robust::median;

/// Rows of each log that are looked at.
const ROWS: usize = 1500;
/// Supported lags and gaps that make such a machine.
pub const MANY: usize = 5;
/// Gain on held-out blocks, in 2 ln L, beyond which one counts.
pub const CLEAR: f64 = 40.0;

/// Whether there may be more effects than the search for a few can find.
pub fn many(model: &Model, logs: &[Log]) -> bool {
    if logs.iter().any(|l| l.poses || l.tcp_m.is_empty()) {
        return false;
    }
    let Ok((mut problem, start)) = prepare::problem_of_at_most(model, logs, ROWS) else { return false };
    let machine = groups(&mut problem, &start).0.settled(&problem);
    let support = members::support(&problem, &machine);
    clear(&machine, &support) >= MANY
}

/// Lags, gaps, friction and ripple that held-out blocks support far beyond chance. Lags that are the same within their
/// uncertainty are one: a clock offset makes as many.
pub fn clear(machine: &MachineFit, support: &[f64]) -> usize {
    let fit = &machine.fit;
    let effect = |k: usize| &fit.hypothesis.effects[fit.free[k]].effect;
    let all: Vec<usize> = (0..support.len()).filter(|&k| support[k] > CLEAR).collect();
    let lags: Vec<(f64, f64)> =
        all.iter().filter_map(|&k| Some((effect(k).get::<ServoLag>()?.lag_s, fit.sigma_of(k)[0]))).collect();
    let common = median(&lags.iter().map(|l| l.0).collect::<Vec<_>>());
    let differ = |l: &&(f64, f64)| (l.0 - common).abs() > (APART * l.1).max(ALIKE * common);
    let own = |k: &&usize| matches!(effect(**k).info().family, Family::Gap | Family::Friction | Family::Ripple);
    all.iter().filter(own).count() + lags.iter().filter(differ).count() + usize::from(!lags.is_empty())
}

/// Difference of two lags, in uncertainties and as a part of them, beyond which they are not one.
const APART: f64 = 4.0;
const ALIKE: f64 = 0.1;
