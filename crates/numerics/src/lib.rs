//! Numerics that do not depend on robots: fits, robust statistics, distributions.
//!
//! Read in this order:
//! - [`least_squares`]: nonlinear least squares, one Levenberg-Marquardt; [`qr`]: the decomposition below it;
//! - [`linear`]: weighted linear fits by QR; [`normal_equations`]: the inverse of a normal matrix; [`legendre`]: the basis of polynomials;
//! - [`student`], [`fisher`], [`chi_squared`], [`normal`]: tail probabilities and quantiles;
//! - [`autoregression`]: correlated noise and its whitening; [`dependent`]: uncertainties in spite of it;
//! - [`rigid`]: the rigid transform between two sets of points;
//! - [`reversal`]: reversals of a position, with a dead band;
//! - [`series`]: positions between samples;
//! - [`robust`]: median, quantiles, scale from the median, and a mean without gross errors;
//! - [`fading`]: `exp` of many numbers at once;
//! - [`fourier`]: discrete Fourier transforms; [`halton`]: points that fill a range evenly; [`parallel`]: maps over all processors.
//!
//! Accuracy against scipy (`tests/oracle/stats.py`): tails and quantiles 1e-7 relative (tails of F 1e-6), 1 to 1e7 degrees of
//! freedom. `statrs` 0.18 alone misses its quantiles from 1e4 degrees of freedom on (t at 0.975: 7e-6 relative at 1e5, 7 % at
//! 1e7) while its tails hold, so quantiles are found here by bisection on the tails.

#![warn(missing_docs)]

pub mod autoregression;
pub mod chi_squared;
pub mod dependent;
pub mod fading;
pub mod fisher;
pub mod fourier;
pub mod halton;
pub mod least_squares;
pub mod legendre;
pub mod linear;
pub mod normal;
pub mod normal_equations;
pub mod parallel;
pub mod qr;
pub mod reversal;
pub mod rigid;
pub mod robust;
pub mod series;
pub mod student;

/// Root of a falling function that is above `level` at 0: bracket by doubling, then bisection to the last digit.
fn where_it_falls_to(level: f64, tail: impl Fn(f64) -> f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    while tail(hi) > level && hi < 1e300 {
        lo = hi;
        hi *= 2.0;
    }
    for _ in 0..200 {
        let mid = 0.5 * (lo + hi);
        if mid <= lo || mid >= hi {
            break;
        }
        if tail(mid) > level { lo = mid } else { hi = mid }
    }
    0.5 * (lo + hi)
}
