//! Drift within a test: what moves steadily shifts the second approach of every cycle against the first, and looks like a gap.
//!
//! The same in every cycle, such a drift scatters nothing. It shows in the middles of the pairs: half the sum of both approaches has no gap
//! in it, and from cycle to cycle at one place it changes by the drift alone. Method: a straight line over time with a level for each place
//! of a log; half of what it moves between the two approaches is the bias of the half gap.
//!
//! Assumes that the drift is as fast between the approaches as from cycle to cycle. Fails where a joint settles from cycle to cycle for
//! another reason: the cycles then scatter, too.

use crate::numerics::student;

/// Standard errors from which a drift is there: one test of 370 without a drift shows it.
const SURE: f64 = 0.9973;
/// Degrees of freedom from which its standard error is known well enough.
const LEAST_DOF: f64 = 3.0;

/// The two approaches of one pair.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Pairs with the same number were measured at one place, in one log.
    pub group: usize,
    /// Half the sum of the deviations, rad or m, and its time, s.
    pub middle: f64,
    pub at_s: f64,
    /// Time from the approach from below to the one from above, s.
    pub later_s: f64,
}

/// A drift, and what it does to the half gap of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// rad/s or m/s.
    pub rate: f64,
    /// What it adds to the half gap, rad or m.
    pub bias: f64,
    /// 95 % interval of that about `bias`, as a half width.
    pub half: f64,
}

/// The drift of a joint's pairs; `None` where they show none.
pub fn estimate(seen: &[Seen]) -> Option<Drift> {
    let mut groups: Vec<Vec<&Seen>> = Vec::new();
    for s in seen {
        match groups.iter_mut().find(|g| g[0].group == s.group) {
            Some(group) => group.push(s),
            None => groups.push(vec![s]),
        }
    }
    let (mut tt, mut ty, mut yy) = (0.0, 0.0, 0.0);
    for group in &groups {
        let mean = |of: fn(&Seen) -> f64| group.iter().map(|s| of(s)).sum::<f64>() / group.len() as f64;
        let (t0, y0) = (mean(|s| s.at_s), mean(|s| s.middle));
        for s in group {
            let (t, y) = (s.at_s - t0, s.middle - y0);
            (tt, ty, yy) = (tt + t * t, ty + t * y, yy + y * y);
        }
    }
    let dof = seen.len() as f64 - groups.len() as f64 - 1.0;
    if dof < LEAST_DOF || tt <= 0.0 {
        return None;
    }
    let rate = ty / tt;
    let error = ((yy - rate * ty).max(0.0) / dof / tt).sqrt();
    let later_s = seen.iter().map(|s| s.later_s).sum::<f64>() / seen.len() as f64;
    let found =
        Drift { rate, bias: 0.5 * rate * later_s, half: 0.5 * student::factor(0.95, dof) * error * later_s.abs() };
    (rate.abs() > student::factor(SURE, dof) * error).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four cycles of 10 s at each of five places, the approach from above 3 s after that from below.
    fn seen(rate: f64) -> Vec<Seen> {
        let one = |i: usize| {
            let (group, at_s) = (i / 4, 10.0 * i as f64);
            let noise = 1e-6 * ((i * 7919 % 13) as f64 / 6.0 - 1.0);
            Seen { group, middle: 1e-4 * group as f64 + rate * at_s + noise, at_s, later_s: 3.0 }
        };
        (0..20).map(one).collect()
    }

    #[test]
    fn a_steady_drift_is_found_with_what_it_adds_to_the_half_gap() {
        let found = estimate(&seen(2e-6)).unwrap();
        assert!((found.bias / 3e-6 - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.bias - 3e-6).abs() < 1.5 * found.half, "{found:?}");
        assert_eq!(estimate(&seen(0.0)), None);
        assert_eq!(estimate(&seen(2e-6)[..4]), None, "three cycles more than one are needed");
    }
}
