//! Equation 17 of Zhang (2023): `{g, l, k_t}` that follow an exponential decay as closely as points of one spacing allow.
//!
//! The friction offset at the k-th point after a reversal is `g exp(1 - (1 + (k-1)/(k_t-1))^l)` for `k = 1..=k_t` and 0 after;
//! between points the controller moves linearly. Sought is the smallest largest distance to `s exp(-t/tau)` over all
//! `t >= 0`, between points too. For given `k_t` and `l` that is convex in `g` (ternary search); `l` is searched on a grid and refined;
//! `k_t` runs through all counts up to eight decays.

/// Largest count of points.
const MOST: u32 = 60;
/// Exponents that are searched.
const EXPONENTS: [f64; 2] = [0.25, 8.0];
/// Places per segment, or per decay where that is shorter, at which the distance is taken.
const PER_SCALE: f64 = 8.0;

/// `{g, l, k_t}` and the largest distance to the decay that they leave, in the unit of the spike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosesFit {
    /// Offset at the first point after a reversal (`g`), rad or m.
    pub gain: f64,
    /// Exponent of the decay (`l`).
    pub exponent: f64,
    /// Number of points over which the offset fades (`k_t`).
    pub poses: u32,
    /// Largest deviation from the friction that was fitted, rad or m.
    pub largest_left: f64,
}

/// Equation 17 without its gain, at point `k` (from 1).
pub fn shape(k: u32, exponent: f64, poses: u32) -> f64 {
    if k == 0 || k > poses {
        return 0.0;
    }
    let share = f64::from(k - 1) / f64::from(poses.max(2) - 1);
    (1.0 - (1.0 + share).powf(exponent)).exp()
}

/// How far the points' polygon is from `spike exp(-t/tau)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Largest distance, in the unit of the spike.
    pub largest: f64,
    /// Squared distance over all time, as a share of that of the decay itself: above 1 the points do harm on the whole.
    pub energy: f64,
}

/// Distance of the polygon with the given numbers to the decay.
pub fn distance(spike: f64, tau_s: f64, spacing_s: f64, gain: f64, exponent: f64, poses: u32) -> Distance {
    let segments = poses.max((8.0 * tau_s / spacing_s).ceil().min(1000.0) as u32);
    let per_segment = (PER_SCALE * (spacing_s / tau_s).max(1.0)).ceil().min(2e4) as usize;
    let step_s = spacing_s / per_segment as f64;
    let (mut largest, mut energy) = (0.0f64, 0.0);
    let mut from = gain * shape(1, exponent, poses);
    for k in 1..=segments {
        let to = gain * shape(k + 1, exponent, poses);
        for i in 0..per_segment {
            let u = i as f64 / per_segment as f64;
            let t = (f64::from(k - 1) + u) * spacing_s;
            let off = from + (to - from) * u - spike * (-t / tau_s).exp();
            largest = largest.max(off.abs());
            energy += off * off * step_s;
        }
        from = to;
    }
    Distance { largest, energy: energy / (spike * spike * tau_s / 2.0) }
}

/// Best gain for a count and an exponent.
fn best_gain(spike: f64, tau_s: f64, spacing_s: f64, exponent: f64, poses: u32) -> PosesFit {
    let (mut lo, mut hi) = (0.0, 2.0 * spike);
    let left = |g: f64| distance(spike, tau_s, spacing_s, g, exponent, poses).largest;
    for _ in 0..40 {
        let (a, b) = (lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0);
        if left(a) < left(b) { hi = b } else { lo = a }
    }
    let gain = (lo + hi) / 2.0;
    PosesFit { gain, exponent, poses, largest_left: left(gain) }
}

/// Fits `{g, l, k_t}` to a decay (spike in any unit, times in s).
pub fn fit(spike: f64, tau_s: f64, spacing_s: f64) -> PosesFit {
    let most = ((8.0 * tau_s / spacing_s).ceil() as u32 + 2).clamp(2, MOST);
    let closer = |a: &PosesFit, b: &PosesFit| a.largest_left.total_cmp(&b.largest_left);
    let mut best = PosesFit { gain: 0.0, exponent: 1.0, poses: 2, largest_left: spike };
    for poses in 2..=most {
        let (mut lo, mut hi): (f64, f64) = (EXPONENTS[0].ln(), EXPONENTS[1].ln());
        for _ in 0..3 {
            let step = (hi - lo) / 12.0;
            let grid = (0..=12).map(|i| best_gain(spike, tau_s, spacing_s, (lo + step * f64::from(i)).exp(), poses));
            let Some(found) = grid.min_by(closer) else { break };
            if found.largest_left < best.largest_left {
                best = found;
            }
            (lo, hi) = (found.exponent.ln() - step, found.exponent.ln() + step);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_is_that_of_equation_17() {
        // k_t = 5, l = 3: exp(1 - (1 + (k-1)/4)^3)
        let want = [1.0, 0.385534, 0.0930145, 0.0127864, 0.000911882];
        for (k, w) in (1..).zip(want) {
            assert!((shape(k, 3.0, 5) / w - 1.0).abs() < 1e-4, "{k}: {}", shape(k, 3.0, 5));
        }
        assert_eq!(shape(6, 3.0, 5), 0.0);
    }

    #[test]
    fn finds_a_fit_no_worse_than_the_papers_numbers() {
        // the paper's circle: points 5.236 s apart, a decay of the area of k_t = 5, l = 3
        let (spike, tau, spacing) = (0.0034, 5.2, 5.236);
        let paper = best_gain(spike, tau, spacing, 3.0, 5);
        let found = fit(spike, tau, spacing);
        assert!(found.largest_left <= paper.largest_left, "{found:?} against {paper:?}");
        assert!(found.largest_left < 0.12 * spike, "{found:?}");
    }

    #[test]
    fn dense_points_follow_the_decay_closely() {
        let found = fit(1.0, 5.0, 0.5);
        assert!(found.largest_left < 0.05, "{found:?}");
    }
}
