//! Degree of the polynomial by successive tests for lack of fit against pure error (Slamani (2012) section 2.2).
//!
//! A degree `p` leaves `SSLF = sum r_i (mean_i - curve_i)^2` with `n - p - 1` degrees of freedom; the repeats leave the pure error
//! `SSPE` with `n_t - n`. `F = MSLF / MSPE` above its critical value: the degree lacks terms, and the next one is tried
//! (equations 7 to 14, table I). The sum of squares is computed directly, not as a difference of two larger ones, so it
//! cannot be negative; the paper's table II prints -4.21e-4 with one degree of freedom for a mean formed with two.
//!
//! The first degree that is not rejected is chosen. Where all are rejected, the highest one whose own term is significant
//! (its fall of `SSLF` against `MSPE`, at the same level) is: a term that explains nothing is dropped even where no better one exists.

use super::data::{Data, design};
use crate::numerics::{fisher, linear};

/// Highest degree that is tried unless the user requests more: beyond it a polynomial swings between its poses.
pub const HIGHEST: usize = 6;

/// A line of the table of lack of fit (table I). Sums of squares in m^2.
#[derive(Debug, Clone, PartialEq)]
pub struct LackOfFit {
    pub degree: usize,
    pub f: f64,
    /// Of the lack of fit and of the pure error.
    pub dof: [f64; 2],
    pub f_critical: f64,
    pub p_value: f64,
    pub lack_m2: f64,
    pub pure_m2: f64,
    /// Not rejected.
    pub adequate: bool,
}

impl LackOfFit {
    /// The test; `None` without degrees of freedom of either kind.
    pub fn new(degree: usize, lack_m2: f64, pure_m2: f64, dof: [f64; 2], alpha: f64) -> Option<Self> {
        if dof[0] <= 0.0 || dof[1] <= 0.0 {
            return None;
        }
        let (lack, pure) = (lack_m2 / dof[0], pure_m2 / dof[1]);
        // repeats that agree to the last digit: the curve is right or it is not
        let f = if pure > 0.0 {
            lack / pure
        } else if lack > 0.0 {
            f64::INFINITY
        } else {
            0.0
        };
        let p_value = fisher::tail(f, dof[0], dof[1]);
        let f_critical = fisher::exceeded_with(alpha, dof[0], dof[1]);
        Some(Self { degree, f, dof, f_critical, p_value, lack_m2, pure_m2, adequate: p_value >= alpha })
    }
}

/// Lack of fit of each degree from 0 to `highest` that can be tested, for the means of one state.
pub fn table(data: &Data, highest: usize, alpha: f64) -> Vec<LackOfFit> {
    let n = data.y.len();
    let mut table = Vec::new();
    for degree in 0..=highest.min(n.saturating_sub(2)) {
        let x = design(data, degree, &[]);
        let Some(fit) = linear::weighted(&x, &data.y, &data.r) else { break };
        let dof = [(n - degree - 1) as f64, data.pure_dof()];
        // what rounding leaves of a curve that goes through every mean is no lack of fit
        let scale: f64 = data.y.iter().zip(&data.r).map(|(y, r)| r * y * y).sum();
        let lack = if fit.residual <= 1e-26 * scale { 0.0 } else { fit.residual };
        let Some(test) = LackOfFit::new(degree, lack, data.pure, dof, alpha) else { break };
        table.push(test);
    }
    table
}

/// The chosen line of a table of degrees `lowest`, `lowest + 1`, ...: the first that is not rejected, else the highest whose
/// own term is significant, else the first.
pub fn choose(table: &[LackOfFit], lowest: usize, alpha: f64) -> Option<&LackOfFit> {
    let tried = || table.iter().filter(|t| t.degree >= lowest);
    if let Some(adequate) = tried().find(|t| t.adequate) {
        return Some(adequate);
    }
    let improves = |t: &&LackOfFit| {
        let below = table.iter().find(|b| b.degree + 1 == t.degree);
        below.is_some_and(|b| {
            let f = (b.lack_m2 - t.lack_m2) / (t.pure_m2 / t.dof[1]);
            fisher::tail(f, 1.0, t.dof[1]) < alpha
        })
    };
    tried().rfind(improves).or(tried().next())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(degree: usize, lack: f64) -> LackOfFit {
        LackOfFit::new(degree, lack, 45.0, [4.0 - degree as f64, 45.0], 0.05).unwrap()
    }

    #[test]
    fn the_critical_value_is_that_of_the_papers_table() {
        // Slamani (2012) section 4 prints F(0.05; 1, 45) = 4.05; scipy: 4.0566
        assert!((line(3, 1.0).f_critical - 4.0566).abs() < 5e-5);
    }

    #[test]
    fn the_first_degree_that_is_not_rejected_is_chosen() {
        let table = [line(0, 900.0), line(1, 60.0), line(2, 5.0), line(3, 4.0)];
        assert_eq!(choose(&table, 1, 0.05).unwrap().degree, 2);
        assert_eq!(choose(&[line(0, 3.0), line(1, 2.0)], 1, 0.05).unwrap().degree, 1);
        assert_eq!(choose(&[line(0, 3.0), line(1, 2.0)], 0, 0.05).unwrap().degree, 0);
    }

    #[test]
    fn where_all_are_rejected_a_term_that_explains_nothing_is_not_kept() {
        let table = [line(0, 900.0), line(1, 200.0), line(2, 50.0), line(3, 49.0)];
        let chosen = choose(&table, 1, 0.05).unwrap();
        assert!(chosen.degree == 2 && !chosen.adequate);
    }

    #[test]
    fn repeats_that_agree_to_the_last_digit_reject_any_curve_that_misses_a_mean() {
        let test = |lack| LackOfFit::new(1, lack, 0.0, [2.0, 8.0], 0.05).unwrap();
        assert!(test(0.0).adequate && !test(1e-12).adequate);
        assert!(LackOfFit::new(1, 1.0, 1.0, [0.0, 8.0], 0.05).is_none());
    }
}
