//! Student's t distribution.

use statrs::function::beta::beta_reg;

/// Degrees of freedom beyond which t is normal: to a relative error of the tail of about `t^4 / (4 dof)`.
const MANY: f64 = 1e9;

/// Two-sided p value of `t` with `dof` degrees of freedom; 1 where either is not a number one can test with.
pub fn two_sided_p(t: f64, dof: f64) -> f64 {
    if dof.is_nan() || dof <= 0.0 || t.is_nan() {
        return 1.0;
    }
    if t.is_infinite() {
        return 0.0;
    }
    if dof > MANY {
        return (2.0 * super::normal::below(-t.abs())).min(1.0);
    }
    // the argument as a quotient of positive numbers: no digits are lost in the far tail
    beta_reg(0.5 * dof, 0.5, dof / (dof + t * t)).clamp(0.0, 1.0)
}

/// Factor of a two-sided interval that holds `level` (0.95, say) of the probability; infinite without degrees of freedom.
pub fn factor(level: f64, dof: f64) -> f64 {
    if dof.is_nan() || dof <= 0.0 {
        return f64::INFINITY;
    }
    super::where_it_falls_to(1.0 - level, |t| two_sided_p(t, dof))
}
