//! A smooth motion between its samples: one cubic per interval.
//!
//! Method: Hermite cubics with slopes of fourth order (the derivative of the polynomial through five samples, one-sided at
//! the ends): error `h^4/384 p''''` inside and `h^4/30 p'''''` in the slopes. Where the second differences of the five
//! samples do not vary smoothly (a corner, a stop, a change of acceleration) the interval takes the parabolas through three
//! samples in their place, blended, each limited to three times the curvature of its neighbour and left out where the two
//! bend in opposite ways. So a ramp that ends on a sample stays straight, and a corner never makes waves.
//!
//! Assumes times that strictly rise.

/// Deviation of a second difference from the mean of its neighbours, relative to the largest of the three, above which
/// the motion is not smooth there. A sine sampled 8 times a period has 0.3; a corner has 0.5 or more at one of its samples.
const ROUGH: f64 = 0.4;

/// Largest ratio of the two curvatures that are blended.
const MOST_RATIO: f64 = 3.0;

/// Samples of a motion, by index.
pub trait Samples {
    /// Number of samples.
    fn len(&self) -> usize;
    /// Time of sample `i`, s.
    fn t_s(&self, i: usize) -> f64;
    /// Position at sample `i`, rad or m.
    fn p(&self, i: usize) -> f64;

    /// Whether there is no sample.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Coefficients `c` of the cubic after sample `i`: `p(x) = p_i + c0 x + c1 x^2 + c2 x^3`, `x` in s from `t_i`.
#[inline]
pub fn cubic(s: &impl Samples, i: usize) -> [f64; 3] {
    let h = s.t_s(i + 1) - s.t_s(i);
    let chord = (s.p(i + 1) - s.p(i)) / h;
    let (m0, m1) = match (slope(s, i), slope(s, i + 1)) {
        (Some(a), Some(b)) => (a, b),
        _ => blended(s, i, h, chord),
    };
    [m0, (3.0 * chord - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * chord) / (h * h)]
}

/// Value of a cubic at `x`.
#[inline]
pub fn value(p: f64, c: &[f64; 3], x: f64) -> f64 {
    p + x * (c[0] + x * (c[1] + x * c[2]))
}

/// Slope of the polynomial through five samples at sample `k`; `None` where they are no smooth motion, or fewer.
#[inline]
fn slope(s: &impl Samples, k: usize) -> Option<f64> {
    let n = s.len();
    if n < 5 {
        return None;
    }
    let first = k.saturating_sub(2).min(n - 5);
    let mut t = [0.0; 5];
    let mut p = [0.0; 5];
    for j in 0..5 {
        t[j] = s.t_s(first + j);
        p[j] = s.p(first + j);
    }
    let mut d = [0.0; 4];
    let mut h = [0.0; 4];
    for j in 0..4 {
        h[j] = t[j + 1] - t[j];
        d[j] = (p[j + 1] - p[j]) / h[j];
    }
    let c: [f64; 3] = std::array::from_fn(|j| (d[j + 1] - d[j]) / (h[j] + h[j + 1]));
    let largest = c[0].abs().max(c[1].abs()).max(c[2].abs());
    if (c[1] - 0.5 * (c[0] + c[2])).abs() > ROUGH * largest {
        return None;
    }
    // divided differences of order 3 and 4; Newton's form differentiated at t_k
    let e0 = (c[1] - c[0]) / (t[3] - t[0]);
    let e1 = (c[2] - c[1]) / (t[4] - t[1]);
    let f = (e1 - e0) / (t[4] - t[0]);
    let x = t[k - first];
    let (a, b, g, w) = (x - t[0], x - t[1], x - t[2], x - t[3]);
    Some(d[0] + c[0] * (a + b) + e0 * (a * b + a * g + b * g) + f * (a * b * g + a * b * w + a * g * w + b * g * w))
}

/// End slopes of the blend of the parabolas on either side.
fn blended(s: &impl Samples, i: usize, h: f64, chord: f64) -> (f64, f64) {
    let curvature = |k: usize| {
        if k == 0 || k + 1 >= s.len() {
            return None;
        }
        let (h0, h1) = (s.t_s(k) - s.t_s(k - 1), s.t_s(k + 1) - s.t_s(k));
        Some(2.0 * ((s.p(k + 1) - s.p(k)) / h1 - (s.p(k) - s.p(k - 1)) / h0) / (h0 + h1))
    };
    let (left, right) = match (curvature(i), curvature(i + 1)) {
        (Some(a), Some(b)) if a * b <= 0.0 => (0.0, 0.0),
        (Some(a), Some(b)) => {
            let most = MOST_RATIO * a.abs().min(b.abs());
            (a.clamp(-most, most), b.clamp(-most, most))
        }
        (Some(a), None) | (None, Some(a)) => (a, a),
        (None, None) => (0.0, 0.0),
    };
    (chord - 0.5 * h * left, chord + 0.5 * h * right)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Of(Vec<f64>, Vec<f64>);

    impl Samples for Of {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn t_s(&self, i: usize) -> f64 {
            self.0[i]
        }
        fn p(&self, i: usize) -> f64 {
            self.1[i]
        }
    }

    fn worst(s: &Of, truth: impl Fn(f64) -> f64) -> f64 {
        let mut worst = 0f64;
        for i in 0..s.len() - 1 {
            let c = cubic(s, i);
            for k in 0..=10 {
                let x = (s.0[i + 1] - s.0[i]) * f64::from(k) / 10.0;
                worst = worst.max((value(s.1[i], &c, x) - truth(s.0[i] + x)).abs());
            }
        }
        worst
    }

    #[test]
    fn a_quartic_is_met_to_the_fourth_power_of_the_step() {
        let quartic = |t: f64| 1.0 + t - 2.0 * t * t + 0.5 * t.powi(3) - 0.3 * t.powi(4);
        let t: Vec<f64> = [0.0, 0.11, 0.19, 0.3, 0.42, 0.5, 0.61].to_vec();
        let s = Of(t.clone(), t.iter().map(|&t| quartic(t)).collect());
        // h^4/384 p'''' = 0.12^4 / 384 * 7.2
        assert!(worst(&s, quartic) < 4.0e-6, "{}", worst(&s, quartic));
    }

    #[test]
    fn a_sine_at_ten_samples_a_second_is_met_to_a_hundred_thousandth() {
        let t: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.1).collect();
        let sine = |t: f64| (t * 1.26).sin();
        let s = Of(t.clone(), t.iter().map(|&t| sine(t)).collect());
        assert!(worst(&s, sine) < 1e-5, "{}", worst(&s, sine));
    }

    #[test]
    fn a_ramp_that_starts_and_ends_on_samples_stays_straight() {
        let ramp = |t: f64| (t - 1.0).clamp(0.0, 1.0);
        let t: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.05).collect();
        let s = Of(t.clone(), t.iter().map(|&t| ramp(t)).collect());
        assert!(worst(&s, ramp) < 1e-12, "{}", worst(&s, ramp));
    }

    #[test]
    fn a_corner_between_samples_stays_within_a_part_of_its_interval() {
        let ramp = |t: f64| (t - 1.013).max(0.0);
        let t: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.05).collect();
        let s = Of(t.clone(), t.iter().map(|&t| ramp(t)).collect());
        assert!(worst(&s, ramp) < 0.2 * 0.05, "{}", worst(&s, ramp));
    }
}
