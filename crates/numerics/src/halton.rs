//! Halton's sequence: points that fill a range evenly, however many are taken.
//!
//! Reference: Halton (1960), Numerische Mathematik 2. Coordinates of one point use bases that have no common factor.

/// Member `i` of the sequence of a base, within 0 to 1.
///
/// ```
/// use lostmotion_numerics::halton::member;
/// assert_eq!([1, 2, 3].map(|i| member(i, 2)), [0.5, 0.25, 0.75]);
/// ```
pub fn member(mut i: usize, base: usize) -> f64 {
    let (mut f, mut r) = (1.0, 0.0);
    while i > 0 {
        f /= base as f64;
        r += f * (i % base) as f64;
        i /= base;
    }
    r
}
