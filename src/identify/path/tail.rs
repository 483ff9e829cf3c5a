//! Tail probabilities and quantiles for the fit.
//!
//! Above [`MANY`] degrees of freedom the F distribution is the chi-squared one to better than its use here needs, and the
//! library's F loses digits there.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

const MANY: f64 = 2000.0;

/// P(F >= f) for `d1` and `d2` degrees of freedom.
pub fn f_tail(f: f64, d1: f64, d2: f64) -> f64 {
    if !(f.is_finite() && f > 0.0) {
        return if f == f64::INFINITY { 0.0 } else { 1.0 };
    }
    let p = if d2 > MANY {
        ChiSquared::new(d1).map(|c| c.sf(f * d1))
    } else {
        return FisherSnedecor::new(d1, d2).map_or(1.0, |d| d.sf(f).clamp(0.0, 1.0));
    };
    p.map_or(1.0, |p| p.clamp(0.0, 1.0))
}

/// Factor of a standard error for a 95 % interval.
pub fn t95(dof: f64) -> f64 {
    if dof > MANY {
        return 1.959964;
    }
    StudentsT::new(0.0, 1.0, dof.max(1.0)).map_or(1.96, |t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_scipy() {
        // scipy.stats.f.sf(12, 2, 500), f.sf(1.7, 15, 1e5), t.ppf(.975, 30)
        for (got, want) in
            [(f_tail(12.0, 2.0, 500.0), 8.122306e-06), (f_tail(1.7, 15.0, 1e5), 0.04363735), (t95(30.0), 2.0422725)]
        {
            assert!((got / want - 1.0).abs() < 1e-2, "{got} {want}");
        }
    }
}
