//! Fisher's F distribution.

use statrs::function::beta::beta_reg;

/// Denominator's degrees of freedom beyond which F is chi-squared over its degrees of freedom, to a relative error of the
/// tail of about `(f d1)^2 / d2`: below 1e-5 down to tails of 1e-40. The incomplete beta function loses more there.
const MANY: f64 = 1e9;

/// Probability of a ratio of `f` or more with `d1` and `d2` degrees of freedom; 1 where there is nothing to test with.
pub fn tail(f: f64, d1: f64, d2: f64) -> f64 {
    if f.is_nan() || f <= 0.0 || d1.is_nan() || d1 <= 0.0 || d2.is_nan() || d2 <= 0.0 {
        return 1.0;
    }
    if f.is_infinite() {
        return 0.0;
    }
    if d2 > MANY {
        return super::chi_squared::tail(f * d1, d1);
    }
    beta_reg(0.5 * d2, 0.5 * d1, d2 / (d2 + d1 * f)).clamp(0.0, 1.0)
}

/// Ratio that is exceeded with probability `p`.
pub fn exceeded_with(p: f64, d1: f64, d2: f64) -> f64 {
    super::where_it_falls_to(p, |f| tail(f, d1, d2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `stats.f.sf` of scipy.
    #[test]
    fn val_far_tails_agree_with_scipy() {
        for (f, d1, d2, want) in [
            (1_122.426_098_102_633_7, 12.0, 39.0, 1.414_553_022_795_642_4e-45),
            (409.466_609_486_768_8, 18.0, 57.0, 1.705_735_675_330_734_3e-53),
            (2.0, 3.0, 10.0, 0.178_007_407_375_2),
        ] {
            let is = tail(f, d1, d2);
            assert!((is / want - 1.0).abs() < 1e-9, "{is:e} for {want:e}");
        }
    }
}
