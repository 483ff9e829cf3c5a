//! Legendre polynomials: a basis for polynomials on a range that stays well conditioned, and its powers.

/// `P_k(u)`, for `u` within -1..1.
pub fn value(k: usize, u: f64) -> f64 {
    let (mut before, mut now) = (1.0, u);
    if k == 0 {
        return before;
    }
    for j in 1..k {
        let j = j as f64;
        (before, now) = (now, ((2.0 * j + 1.0) * u * now - j * before) / (j + 1.0));
    }
    now
}

/// Place `p` of a range on -1..1; 0 where the range has no width.
pub fn mapped(p: f64, [lo, hi]: [f64; 2]) -> f64 {
    if hi > lo { (2.0 * p - lo - hi) / (hi - lo) } else { 0.0 }
}

/// `sum c_k P_k(u)` with the range mapped to -1..1, as `sum b_k p^k`.
pub fn in_powers(legendre: &[f64], [lo, hi]: [f64; 2]) -> Vec<f64> {
    let k = legendre.len();
    if k < 2 || hi <= lo {
        return legendre.to_vec();
    }
    // powers of u: P_0 = 1, P_1 = u, (j + 1) P_{j+1} = (2j + 1) u P_j - j P_{j-1}
    let mut rows: Vec<Vec<f64>> = vec![vec![0.0; k]; k];
    rows[0][0] = 1.0;
    rows[1][1] = 1.0;
    for j in 1..k - 1 {
        let f = j as f64;
        for m in 0..k {
            let up = if m > 0 { rows[j][m - 1] } else { 0.0 };
            rows[j + 1][m] = ((2.0 * f + 1.0) * up - f * rows[j - 1][m]) / (f + 1.0);
        }
    }
    let in_u: Vec<f64> = (0..k).map(|m| (0..k).map(|j| legendre[j] * rows[j][m]).sum()).collect();
    // u = a p + b, by Horner on polynomials of p
    let (a, b) = (2.0 / (hi - lo), -(lo + hi) / (hi - lo));
    let mut coefficients = vec![0.0; k];
    for c in in_u.iter().rev() {
        for m in (0..k).rev() {
            let below = if m > 0 { coefficients[m - 1] } else { 0.0 };
            coefficients[m] = coefficients[m] * b + below * a;
        }
        coefficients[0] += c;
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_position_give_the_same_values_as_legendre() {
        let c = [33.0, -7.0, 12.0, 0.5, -3.0];
        let range = [-150.0, 800.0];
        let powers = in_powers(&c, range);
        for i in 0..=10 {
            let p = range[0] + (range[1] - range[0]) * f64::from(i) / 10.0;
            let want: f64 = c.iter().enumerate().map(|(k, c)| c * value(k, mapped(p, range))).sum();
            let found = powers.iter().rev().fold(0.0, |s, c| s * p + c);
            assert!((found - want).abs() < 1e-11, "{p}: {found} {want}");
        }
    }

    #[test]
    fn a_constant_is_itself_on_any_range() {
        assert_eq!(in_powers(&[2.5], [3.0, 3.0]), [2.5]);
    }
}
