//! A number of a program as it is written: an integer and the place of its point, exactly.
//!
//! A [`Decimal`] is read from digits, compared, offset and printed in integers, without a binary fraction but for the
//! offset that is added. Numbers with an exponent, and those of more than 18 digits, are no decimals: they go through the
//! standard library.
//!
//! Modules:
//! - [`read`]: bytes to decimals, a word at a time.
//! - [`mod@print`]: decimals to bytes, eight digits at a time.
//! - [`patch`]: digits moved where they stand.
//!
//! # Example
//!
//! An offset is added to what is written, not to a double near it; halves are rounded away from zero.
//!
//! ```
//! use robot_programs::decimal::Decimal;
//!
//! let written = Decimal::read(b"-12.3400").expect("a decimal");
//! assert_eq!((written.mantissa(), written.decimals()), (-123_400, 4));
//! let moved = written.offset(0.00285, 4).expect("few digits");
//! let mut out = Vec::new();
//! moved.write(&mut out);
//! // -12.3400 + 0.00285 = -12.33715
//! assert_eq!(out, b"-12.3372");
//! ```

pub mod patch;
pub mod print;
pub mod read;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::fmt;

/// `10^d`, exact.
pub const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
/// The same as integers.
pub const POW10_INT: [u64; 19] = {
    let mut powers = [1; 19];
    let mut d = 1;
    while d < powers.len() {
        powers[d] = powers[d - 1] * 10;
        d += 1;
    }
    powers
};
/// Digits after the point, and digits in all, of a decimal.
pub const MOST: u8 = 18;
/// An offset counts to so many digits beyond the last one that is written; what is left of it is rounded. Noise of a double stays
/// far below that, so that an offset of 0.00285 is a tie at four digits, and is rounded as one.
pub const GUARD: u8 = 5;
/// Integers up to this are doubles.
const EXACT: u64 = 1 << 53;

/// `-12.3400`: a sign, the digits 123400, of which 4 stand after the point.
///
/// Equality and order are those of the numbers: 1.50 equals 1.5.
#[derive(Debug, Clone, Copy, Default)]
pub struct Decimal {
    /// Below `10^18`.
    magnitude: u64,
    decimals: u8,
    /// Also that of a zero: it is written, and a double has it.
    negative: bool,
}

impl Decimal {
    /// `mantissa * 10^-decimals`; `None`: too many digits.
    pub fn new(mantissa: i64, decimals: u8) -> Option<Self> {
        Self::signed(mantissa < 0, mantissa.unsigned_abs(), decimals)
    }

    /// The same with its own sign.
    #[inline]
    pub fn signed(negative: bool, magnitude: u64, decimals: u8) -> Option<Self> {
        (magnitude < POW10_INT[usize::from(MOST)] && decimals <= MOST).then_some(Self { magnitude, decimals, negative })
    }

    /// The decimal with so many digits after the point that is nearest to `value`, halves away from zero; `None`: too many digits.
    #[inline]
    pub fn nearest(value: f64, decimals: u8) -> Option<Self> {
        let count = (value * POW10.get(usize::from(decimals))?).round();
        // beyond this a double does not know the last digit
        if count.is_nan() || count.abs() > EXACT as f64 {
            return None;
        }
        Self::signed(count < 0.0, count.abs() as u64, decimals)
    }

    /// Digits without the point, with the sign of the number.
    pub fn mantissa(&self) -> i64 {
        let size = self.magnitude as i64; // below 10^18
        if self.negative { -size } else { size }
    }

    /// Digits after the point.
    pub fn decimals(&self) -> u8 {
        self.decimals
    }

    /// A minus is written before it; zero may have one.
    pub fn is_negative(&self) -> bool {
        self.negative
    }

    /// The double that is nearest.
    #[inline]
    pub fn value(&self) -> f64 {
        let size = if self.magnitude <= EXACT {
            // both are exact, so that the quotient is correctly rounded (Clinger 1990)
            self.magnitude as i64 as f64 / POW10[usize::from(self.decimals)]
        } else {
            // by the standard library's parser, which takes any number of digits
            format!("{}e-{}", self.magnitude, self.decimals).parse().unwrap_or(f64::NAN)
        };
        if self.negative { -size } else { size }
    }

    /// The sum with `by`, which counts to [`GUARD`] digits beyond the last, with so many digits after the point; halves away from
    /// zero. `None`: too many digits.
    pub fn offset(&self, by: f64, decimals: u8) -> Option<Self> {
        let place = decimals.checked_add(GUARD)?;
        let by = (by * POW10.get(usize::from(place))?).round();
        if by.is_nan() || by.abs() > EXACT as f64 {
            return None;
        }
        if let Some(lift) = place.checked_sub(self.decimals)
            && lift < 10
            && self.magnitude < POW10_INT[9]
        {
            let sum = self.mantissa() * POW10_INT[usize::from(lift)] as i64 + by as i64;
            let count = unguarded(sum);
            return Self::signed(sum < 0 && count > 0, count, decimals);
        }
        let fine = place.max(self.decimals);
        let own = i128::from(self.mantissa()).checked_mul(power(fine - self.decimals)?)?;
        let sum = own.checked_add((by as i128).checked_mul(power(fine - place)?)?)?;
        let unit = power(fine - decimals)?;
        Self::counted(nearest_quotient(sum, unit), decimals)
    }

    /// With so many digits after the point; halves away from zero. `None`: too many digits.
    pub fn rounded(&self, decimals: u8) -> Option<Self> {
        self.scaled(decimals, nearest_quotient)
    }

    /// The largest with so many digits after the point that is not above it. `None`: too many digits.
    pub fn floor(&self, decimals: u8) -> Option<Self> {
        self.scaled(decimals, i128::div_euclid)
    }

    /// The smallest with so many digits after the point that is not below it. `None`: too many digits.
    pub fn ceil(&self, decimals: u8) -> Option<Self> {
        self.scaled(decimals, |a, b| -(-a).div_euclid(b))
    }

    fn scaled(&self, decimals: u8, quotient: impl Fn(i128, i128) -> i128) -> Option<Self> {
        let own = i128::from(self.mantissa());
        let count = match decimals.checked_sub(self.decimals) {
            Some(more) => own.checked_mul(power(more)?)?,
            None => quotient(own, power(self.decimals - decimals)?),
        };
        let mut scaled = Self::counted(count, decimals)?;
        scaled.negative |= self.negative && count == 0 && self.magnitude == 0;
        Some(scaled)
    }

    fn counted(count: i128, decimals: u8) -> Option<Self> {
        Self::signed(count < 0, u64::try_from(count.unsigned_abs()).ok()?, decimals)
    }
}

/// Last digits in a count of [`GUARD`] digits more, without its sign; halves away from zero.
#[inline(always)]
pub(crate) fn unguarded(fine: i64) -> u64 {
    const UNIT: u64 = POW10_INT[GUARD as usize];
    (fine.unsigned_abs() + UNIT / 2) / UNIT
}

/// Halves away from zero.
fn nearest_quotient(a: i128, unit: i128) -> i128 {
    let (whole, rest) = (a / unit, a % unit);
    if 2 * rest.abs() >= unit { whole + a.signum() } else { whole }
}

fn power(d: u8) -> Option<i128> {
    (d <= 38).then(|| 10i128.pow(u32::from(d)))
}

impl PartialEq for Decimal {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Decimal {}

impl PartialOrd for Decimal {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Decimal {
    fn cmp(&self, other: &Self) -> Ordering {
        // at most 36 digits
        let scaled = |a: &Self, b: &Self| {
            let more = b.decimals.saturating_sub(a.decimals).min(MOST);
            i128::from(a.mantissa()) * i128::from(POW10_INT[usize::from(more)])
        };
        scaled(self, other).cmp(&scaled(other, self))
    }
}

impl fmt::Display for Decimal {
    /// All digits, with the sign of the number; a zero before the point where nothing else stands there.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Vec::new();
        self.write(&mut text);
        let sign = if self.negative && self.magnitude == 0 { "-" } else { "" };
        write!(f, "{sign}{}", String::from_utf8_lossy(&text))
    }
}
