//! Means of poses as rows of a weighted fit, the design of its columns, and the scatter of its coefficients.

use super::poses::Pose;
use super::state::States;
use crate::error::{Error, Place, Result};
use crate::numerics::legendre;
use crate::numerics::linear::Fit;
use crate::numerics::robust::range;
use nalgebra::DMatrix;

/// Where the scatter of coefficients comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Errors {
    /// Means for Student tests; for the final model the larger of both, readings for one state whose curve fits.
    Auto,
    /// Residual of the poses' means.
    Means,
    /// Residual of the single readings.
    Readings,
}

/// Choices of the user.
#[derive(Debug, Clone)]
pub struct Options {
    /// A p value below this is significant.
    pub alpha: f64,
    /// First degree that is tried.
    pub lowest: usize,
    /// Last degree that is tried.
    pub highest: Option<usize>,
    /// This degree, whatever the tests say.
    pub degree: Option<usize>,
    /// From which the scatter was estimated.
    pub errors: Errors,
}

impl Default for Options {
    fn default() -> Self {
        Self { alpha: 0.05, lowest: 1, highest: None, degree: None, errors: Errors::Auto }
    }
}

/// Means of poses: one row each.
#[derive(Debug, Clone, Default)]
pub struct Data {
    /// Place on the range, -1..1.
    pub u: Vec<f64>,
    pub state: Vec<usize>,
    /// Mean backlash of the pairs, m.
    pub y: Vec<f64>,
    /// Pairs.
    pub r: Vec<f64>,
    /// Sum of squares within the poses, m^2.
    pub pure: f64,
}

impl Data {
    pub(super) fn of(poses: &[Pose], range: [f64; 2], states: &[usize]) -> Self {
        let mut data = Self::default();
        for p in poses.iter().filter(|p| states.contains(&p.state)) {
            let Some((mean, squares)) = p.pair_mean() else { continue };
            data.u.push(legendre::mapped(p.position_m, range));
            data.state.push(p.state);
            data.y.push(mean);
            data.r.push(p.pairs_m.len() as f64);
            data.pure += squares;
        }
        data
    }

    /// Readings less poses.
    pub fn pure_dof(&self) -> f64 {
        self.r.iter().sum::<f64>() - self.r.len() as f64
    }
}

/// Columns: the curve's Legendre polynomials, then for each `(state, order)` those of its indicator.
pub(super) fn design(data: &Data, degree: usize, states: &[(usize, usize)]) -> DMatrix<f64> {
    let blocks = std::iter::once((None, degree)).chain(states.iter().map(|(s, order)| (Some(*s), *order)));
    let columns: Vec<(Option<usize>, usize)> = blocks.flat_map(|(s, order)| (0..=order).map(move |k| (s, k))).collect();
    DMatrix::from_fn(data.y.len(), columns.len(), |i, j| {
        let (state, k) = columns[j];
        if state.is_none_or(|s| data.state[i] == s) { legendre::value(k, data.u[i]) } else { 0.0 }
    })
}

/// Variance of a reading's backlash and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    pub from: Errors,
    pub variance_m2: f64,
    pub dof: f64,
}

impl Scatter {
    fn one(from: Errors, fit: &Fit, data: &Data) -> Self {
        let k = fit.coefficients.len() as f64;
        let (sum, dof) = match from {
            Errors::Means => (fit.residual, data.y.len() as f64 - k),
            _ => (fit.residual + data.pure, data.r.iter().sum::<f64>() - k),
        };
        Self { from, variance_m2: if dof > 0.0 { sum / dof } else { f64::NAN }, dof }
    }

    /// Of a Student test: the means, as in the paper, where they leave a degree of freedom.
    pub(super) fn of_test(fit: &Fit, data: &Data, errors: Errors) -> Self {
        let means = Self::one(Errors::Means, fit, data);
        match errors {
            Errors::Auto if means.dof < 1.0 => Self::one(Errors::Readings, fit, data),
            Errors::Auto => means,
            chosen => Self::one(chosen, fit, data),
        }
    }

    /// Of the final model: one state whose curve fits depends on its readings; else the larger of both. Means that lie closer to
    /// the curve than the repeats let them do so by chance.
    pub(super) fn of_model(fit: &Fit, data: &Data, errors: Errors, adequate: Option<bool>) -> Self {
        let (means, readings) = (Self::one(Errors::Means, fit, data), Self::one(Errors::Readings, fit, data));
        let several = data.state.iter().any(|s| *s != data.state[0]);
        match errors {
            Errors::Auto if (several || adequate == Some(false)) && means.variance_m2 > readings.variance_m2 => means,
            Errors::Auto if readings.dof > 0.0 => readings,
            Errors::Auto => means,
            chosen => Self::one(chosen, fit, data),
        }
    }
}

/// The positions of the line, and the means of the reference state.
pub(super) struct Reference {
    /// The reference state.
    pub(super) state: usize,
    /// Positions that were measured, m.
    pub(super) range: [f64; 2],
    /// Means of the reference state.
    pub(super) base: Data,
}

impl Reference {
    pub(super) fn new(poses: &[Pose], order: &[usize], states: &States, file: &str) -> Result<Self> {
        let state = order.first().copied().unwrap_or(0);
        let used = poses.iter().filter(|p| !p.pairs_m.is_empty());
        let range = range(used.map(|p| p.position_m));
        let base = Data::of(poses, range, &[state]);
        if base.y.is_empty() {
            let found = match states.text(state).as_str() {
                "" => "no pose with a repeat in both directions".to_string(),
                name => format!("no pose with a repeat in both directions in the reference state ({name})"),
            };
            let expected = "the same commanded position from both directions, or another reference";
            return Err(Error::bad(Place::file(file), found, expected).mended_by(&["reference"]));
        }
        Ok(Self { state, range, base })
    }
}
