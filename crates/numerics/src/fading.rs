//! `exp` of many numbers that are not positive: shares that are left of something that fades.
//!
//! Method: `x = k ln 2 + r` with `|r| <= ln(2) / 2`; the series of `exp(r)` up to `r^13`, whose remainder is below 5e-18, in pairs of
//! terms (Estrin's scheme); `2^k` is put into the exponent. There is neither a branch nor a table, so that several numbers
//! are worked out at once, and only additions and multiplications that every processor rounds alike: the bits do not depend on the
//! machine.
//!
//! Accuracy: 4e-16 of the value against the exact one. Below -700 the value is that at -700, 1e-304: nothing beside 1. A number that is not
//! a number stays none.

/// Numbers that are worked out at once.
pub const LANES: usize = 8;

/// 1.5 * 2^52: a number that is added to it is rounded to an integer, which stands in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// `ln 2` in two parts, the first of which has 21 zeros at its end, so that its product with a small integer is exact.
const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
const LN_2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);
const LEAST: f64 = -700.0;

/// `1 / n!`
const fn inverse_factorial(n: u32) -> f64 {
    let (mut product, mut k) = (1.0, 2);
    while k <= n {
        product *= k as f64;
        k += 1;
    }
    1.0 / product
}

/// Coefficients of the series.
const C: [f64; 14] = {
    let mut c = [0.0; 14];
    let mut n = 0;
    while n < 14 {
        c[n] = inverse_factorial(n as u32);
        n += 1;
    }
    c
};

/// `exp(x)` for `x <= 0`.
#[inline(always)]
fn one(x: f64) -> f64 {
    // a comparison that is false for a number that is none, so that it stays
    let x = if x < LEAST { LEAST } else { x };
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    let (r2, pair) = (r * r, |n: usize| C[n] + C[n + 1] * r);
    let r4 = r2 * r2;
    let upper = (pair(8) + pair(10) * r2) + pair(12) * r4;
    let lower = (pair(4) + pair(6) * r2) + upper * r4;
    // 1 + r last: their sum holds the digits
    let series = 1.0 + (r + r2 * ((C[2] + C[3] * r) + lower * r2));
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    series * scale
}

/// Replaces each `x`, none of them above 0, by `exp(x)`. Inlined, so that it is compiled for the registers that its caller has.
#[inline(always)]
pub fn fade(x: &mut [f64; LANES]) {
    for x in x {
        *x = one(*x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_that_are_left_are_those_of_the_mathematical_library() {
        let mut x: Vec<f64> = (0..400_000).map(|i| -f64::from(i) * 1.7e-3 - 1e-5).collect();
        x.extend((0..330).map(|i| -(2f64).powi(-i)));
        x.extend((0..200).map(|i| -f64::from(i) * std::f64::consts::LN_2 / 2.0));
        x.push(-0.0);
        for chunk in x.chunks(LANES) {
            let mut row = [0.0; LANES];
            row[..chunk.len()].copy_from_slice(chunk);
            fade(&mut row);
            for (is, x) in row.iter().zip(chunk) {
                let want = x.max(LEAST).exp();
                assert!((is / want - 1.0).abs() <= 4e-16, "exp({x}) is {is:e} for {want:e}");
            }
        }
    }

    #[test]
    fn nothing_fades_in_no_time_and_everything_in_a_long_one() {
        let mut x = [0.0, -0.0, -1e-300, -1e3, f64::NEG_INFINITY, f64::NAN, -1.0, -37.0];
        fade(&mut x);
        assert_eq!(x[..3], [1.0; 3]);
        assert!(x[3] < 1e-300 && x[4] < 1e-300 && x[5].is_nan());
    }
}
