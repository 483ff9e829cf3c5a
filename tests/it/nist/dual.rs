//! Numbers that carry their derivatives: forward-mode differentiation of the models.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the models are written in.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn atan(self) -> Self;
}

impl Number for f64 {
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn ln(self) -> Self {
        f64::ln(self)
    }
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn cos(self) -> Self {
        f64::cos(self)
    }
    fn atan(self) -> Self {
        f64::atan(self)
    }
}

/// A value and its derivatives by `N` variables.
#[derive(Debug, Clone, Copy)]
pub struct Dual<const N: usize> {
    pub value: f64,
    pub derivatives: [f64; N],
}

impl<const N: usize> Dual<N> {
    pub fn variable(value: f64, k: usize) -> Self {
        let mut derivatives = [0.0; N];
        derivatives[k] = 1.0;
        Self { value, derivatives }
    }

    /// `f(self)` with the value and the slope of `f`.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, derivatives: self.derivatives.map(|d| d * slope) }
    }

    fn with(self, other: Self, value: f64, by_self: f64, by_other: f64) -> Self {
        let of = |k: usize| self.derivatives[k] * by_self + other.derivatives[k] * by_other;
        Self { value, derivatives: std::array::from_fn(of) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.with(o, self.value + o.value, 1.0, 1.0)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.with(o, self.value - o.value, 1.0, -1.0)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.with(o, self.value * o.value, o.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        self.with(o, self.value / o.value, 1.0 / o.value, -self.value / (o.value * o.value))
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    fn add(self, o: f64) -> Self {
        self.chain(self.value + o, 1.0)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.chain(self.value * o, o)
    }
}

impl<const N: usize> Number for Dual<N> {
    fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    fn atan(self) -> Self {
        self.chain(self.value.atan(), 1.0 / (1.0 + self.value * self.value))
    }
}
