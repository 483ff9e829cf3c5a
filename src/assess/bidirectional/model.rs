//! The curve of the backlash over position and states: weighted least squares on the poses' means, Student tests of the
//! indicator variables, the final fit (Slamani (2012) sections 2.2 and 2.3).
//!
//! A state other than the reference has an indicator `D`. Its offset (equation 16) is tested in a fit of the reference and
//! that state, its slope (equation 20) where the offset is significant, and so on up to the degree of the curve; the
//! first term that is not significant ends it. The final model is fitted to all states together, those without a
//! significant term on the reference's curve (equation 19).
//!
//! Numbers: Legendre polynomials on the range of the positions, QR; coefficients and covariance are turned into powers
//! of the position at the end. The t of the highest term of a block is the same in both bases.
//!
//! Errors: Student tests take the residual of the means about the curve, as the paper does (2.45 and 2.57 are Student's
//! factors for 10 means and 4 or 5 coefficients): what is repeatable at a pose but not in the model then counts as scatter.
//! Intervals of the final model take the larger of that and of the residual of the single readings (table I): chosen terms
//! leave means that lie closer to the curve than they should. [`Errors`] chooses one.
//!
//! How it fails: a state that changes the curve's slope about the middle of the line and not its mean passes the test of the
//! offset; a note says so where its slope would be significant. Two columns that always change together are one state.

use super::degree::{self, LackOfFit};
use super::poses::Pose;
use super::state::States;
use crate::error::{Error, Place, Result};
use crate::numerics::linear::{self, Fit};
use crate::numerics::{legendre, student};
use nalgebra::{DMatrix, DVector};

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
    fn of(poses: &[Pose], range: [f64; 2], states: &[usize]) -> Self {
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
    fn of_test(fit: &Fit, data: &Data, errors: Errors) -> Self {
        let means = Self::one(Errors::Means, fit, data);
        match errors {
            Errors::Auto if means.dof < 1.0 => Self::one(Errors::Readings, fit, data),
            Errors::Auto => means,
            chosen => Self::one(chosen, fit, data),
        }
    }

    /// Of the final model: one state whose curve fits rests on its readings; else the larger of both. Means that lie closer to
    /// the curve than the repeats let them do so by chance.
    fn of_model(fit: &Fit, data: &Data, errors: Errors, adequate: Option<bool>) -> Self {
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

/// Student test of one term of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct StateTest {
    pub state: usize,
    /// 0: offset, 1: slope, ...
    pub order: usize,
    /// In m over m to the power of the order.
    pub coefficient: f64,
    pub ci95: [f64; 2],
    pub t: f64,
    pub dof: f64,
    pub t_critical: f64,
    pub p_value: f64,
    pub significant: bool,
}

/// A polynomial of the final model: the reference's curve, or what a state adds to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// `None`: the reference's curve.
    pub state: Option<usize>,
    /// Coefficients of Legendre polynomials on the range, m.
    pub legendre: Vec<f64>,
    /// The same as coefficients of powers of the position, in m over m to the power.
    pub powers: Vec<f64>,
    pub ci95: Vec<[f64; 2]>,
}

/// The final model.
#[derive(Debug, Clone)]
pub struct Model {
    pub reference: usize,
    /// Positions that were measured.
    pub range_m: [f64; 2],
    pub degree: usize,
    /// The degree was given by the user.
    pub given: bool,
    /// Its lack of fit is not significant; `None`: cannot be tested.
    pub adequate: Option<bool>,
    /// From the first degree that was tried.
    pub lack_of_fit: Vec<LackOfFit>,
    /// p value of the test that the backlash is the same at all poses of the reference.
    pub varies_p_value: Option<f64>,
    pub tests: Vec<StateTest>,
    pub blocks: Vec<Block>,
    pub scatter: Scatter,
    /// Lack of fit of the final model over all states, where there are several.
    pub all_states: Option<LackOfFit>,
    covariance: DMatrix<f64>,
}

impl Model {
    /// Legendre coefficients of a state's curve.
    pub fn legendre_of(&self, state: usize) -> Vec<f64> {
        let mut sum = self.blocks[0].legendre.clone();
        for block in self.blocks[1..].iter().filter(|b| b.state == Some(state)) {
            for (s, c) in sum.iter_mut().zip(&block.legendre) {
                *s += c;
            }
        }
        sum
    }

    /// Mean over places of a state's curve, and its standard deviation (m).
    pub fn mean_over(&self, state: usize, positions_m: &[f64]) -> (f64, f64) {
        let n = positions_m.len().max(1) as f64;
        let mean = |k: usize| {
            positions_m.iter().map(|p| legendre::value(k, legendre::mapped(*p, self.range_m))).sum::<f64>() / n
        };
        let mut row = Vec::new();
        for block in &self.blocks {
            let on = block.state.is_none_or(|s| s == state);
            row.extend((0..block.legendre.len()).map(|k| if on { mean(k) } else { 0.0 }));
        }
        let row = DVector::from_vec(row);
        let all = self.blocks.iter().flat_map(|b| b.legendre.iter().copied());
        let value = row.iter().zip(all).map(|(a, c)| a * c).sum();
        (value, (row.transpose() * &self.covariance * &row)[0].max(0.0).sqrt())
    }

    /// Value of a state's curve at a position and its 95 % interval (m).
    pub fn at(&self, state: usize, position_m: f64) -> (f64, [f64; 2]) {
        let (y, se) = self.mean_over(state, &[position_m]);
        let half = student::factor(0.95, self.scatter.dof) * se;
        (y, [y - half, y + half])
    }

    /// States that have a term of their own.
    pub fn states(&self) -> impl Iterator<Item = usize> + '_ {
        self.blocks.iter().filter_map(|b| b.state)
    }
}

/// Why there is no model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoModel {
    /// One repeat only, and no degree given.
    NoPureError,
}

/// Fits the model; `order` are the states, the reference first.
pub fn fit(
    poses: &[Pose],
    order: &[usize],
    states: &States,
    options: &Options,
    file: &str,
    notes: &mut Vec<String>,
) -> Result<std::result::Result<Model, NoModel>> {
    let reference = order.first().copied().unwrap_or(0);
    let name = |s: usize| states.text(s);
    let used = poses.iter().filter(|p| !p.pairs_m.is_empty());
    let range =
        used.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], p| [lo.min(p.position_m), hi.max(p.position_m)]);
    let base = Data::of(poses, range, &[reference]);
    let n = base.y.len();
    if n == 0 {
        let found = match name(reference).as_str() {
            "" => "no pose with a repeat in both directions".to_string(),
            state => format!("no pose with a repeat in both directions in the reference state ({state})"),
        };
        let expected = "the same commanded position from both directions; another reference with --reference";
        return Err(Error::bad(Place::file(file), found, expected));
    }
    if let Some(d) = options.degree
        && d >= n
    {
        return Err(Error::bad(
            Place::file("--degree"),
            format!("degree {d} for {n} poses"),
            format!("a degree of at most {}", n - 1),
        ));
    }
    let highest = options.highest.unwrap_or(degree::HIGHEST);
    let mut table = degree::table(&base, highest.max(options.degree.unwrap_or(0)), options.alpha);
    let varies_p_value = table.first().map(|t| t.p_value);
    // a line of few poses: the first degree that can be tested
    let lowest = options.lowest.min(table.last().map_or(0, |t| t.degree));
    let chosen = degree::choose(&table, lowest, options.alpha).cloned();
    let untested = base.pure_dof() <= 0.0;
    let degree = match (options.degree, &chosen) {
        (Some(d), _) => d,
        (None, Some(t)) => t.degree,
        (None, None) if untested && n > 1 => return Ok(Err(NoModel::NoPureError)),
        (None, None) => 0,
    };
    let adequate = table.iter().find(|t| t.degree == degree).map(|t| t.adequate);
    if adequate == Some(false) && options.degree.is_none() {
        let tried = table.last().map_or(0, |t| t.degree);
        notes.push(format!(
            "no degree up to {tried} explains the backlash at {n} poses: degree {degree} is kept, and its lack of fit is significant"
        ));
    }
    if base.pure_dof() > 0.0 && base.pure == 0.0 {
        notes.push("the repeats agree to the last digit: there is no pure error to compare with".into());
    }
    table.retain(|t| t.degree >= lowest);

    let (mut tests, mut kept) = (Vec::new(), Vec::new());
    let mut present = vec![reference];
    for &state in &order[1..] {
        let data = Data::of(poses, range, &[reference, state]);
        if data.y.len() == n {
            notes.push(format!("{}: no pose with a repeat in both directions; left out of the model", name(state)));
            continue;
        }
        present.push(state);
        let term = |k: usize| student_test(&data, degree, state, k, range, options);
        for k in 0..=degree {
            let Some(test) = term(k) else {
                if k == 0 {
                    notes.push(format!(
                        "{}: too few poses for a Student test of its offset (no degree of freedom is left)",
                        name(state)
                    ));
                }
                break;
            };
            let significant = test.significant;
            if significant {
                kept.retain(|(s, _)| *s != state);
                kept.push((state, k));
            } else if k == 0
                && degree > 0
                && let Some(slope) = term(1).filter(|t| t.significant)
            {
                notes.push(format!(
                    "{}: no offset, but its slope would be significant (t = {:.2}): it turns the curve about the middle of the line",
                    name(state),
                    slope.t
                ));
            }
            tests.push(test);
            if !significant {
                break;
            }
        }
    }
    let data = Data::of(poses, range, &present);
    let Some(fit) = linear::weighted(&design(&data, degree, &kept), &data.y, &data.r) else {
        return Err(Error::bad(
            Place::file(file),
            format!("poses that do not determine a curve of degree {degree}"),
            "more positions, or a lower --degree",
        ));
    };
    let scatter = Scatter::of_model(&fit, &data, options.errors, adequate);
    let covariance = &fit.inverse * scatter.variance_m2;
    let blocks = blocks(&fit, &covariance, degree, &kept, range, scatter.dof);
    let dof = [data.y.len() as f64 - fit.coefficients.len() as f64, data.pure_dof()];
    let all_states =
        (present.len() > 1).then(|| LackOfFit::new(degree, fit.residual, data.pure, dof, options.alpha)).flatten();
    if let Some(test) = &all_states
        && !test.adequate
    {
        notes.push(format!(
            "over all states the model leaves more than the repeats explain (F = {:.2}, p = {:.2e}): the curve, or what a state adds to it, is not of this form; a higher --degree may be",
            test.f, test.p_value
        ));
    }
    Ok(Ok(Model {
        reference,
        range_m: range,
        degree,
        given: options.degree.is_some(),
        adequate,
        lack_of_fit: table,
        varies_p_value,
        tests,
        blocks,
        scatter,
        all_states,
        covariance,
    }))
}

/// Student test of the term of `order` of a state, in a fit of the reference and that state.
fn student_test(
    data: &Data,
    degree: usize,
    state: usize,
    order: usize,
    range: [f64; 2],
    options: &Options,
) -> Option<StateTest> {
    let fit = linear::weighted(&design(data, degree, &[(state, order)]), &data.y, &data.r)?;
    let scatter = Scatter::of_test(&fit, data, options.errors);
    if scatter.dof <= 0.0 {
        return None;
    }
    let last = fit.coefficients.len() - 1;
    // of the highest power only the highest polynomial has a part
    let mut top = vec![0.0; order + 1];
    top[order] = 1.0;
    let factor = legendre::in_powers(&top, range)[order];
    let coefficient = fit.coefficients[last] * factor;
    let se = (scatter.variance_m2 * fit.inverse[(last, last)]).sqrt() * factor;
    let t = coefficient / se;
    let p_value = student::two_sided_p(t, scatter.dof);
    let half = student::factor(0.95, scatter.dof) * se;
    Some(StateTest {
        state,
        order,
        coefficient,
        ci95: [coefficient - half, coefficient + half],
        t,
        dof: scatter.dof,
        t_critical: student::factor(1.0 - options.alpha, scatter.dof),
        p_value,
        significant: p_value < options.alpha,
    })
}

fn blocks(
    fit: &Fit,
    covariance: &DMatrix<f64>,
    degree: usize,
    kept: &[(usize, usize)],
    range: [f64; 2],
    dof: f64,
) -> Vec<Block> {
    let factor = student::factor(0.95, dof);
    let mut first = 0;
    let all = std::iter::once((None, degree)).chain(kept.iter().map(|(s, order)| (Some(*s), *order)));
    all.map(|(state, order)| {
        let k = order + 1;
        let legendre: Vec<f64> = fit.coefficients.rows(first, k).iter().copied().collect();
        let columns: Vec<Vec<f64>> = (0..k)
            .map(|j| legendre::in_powers(&(0..k).map(|i| f64::from(u8::from(i == j))).collect::<Vec<_>>(), range))
            .collect();
        let turn = DMatrix::from_fn(k, k, |i, j| columns[j][i]);
        let own = covariance.view((first, first), (k, k));
        let variances = (&turn * own * turn.transpose()).diagonal();
        let powers = legendre::in_powers(&legendre, range);
        let half = |i: usize| factor * variances[i].max(0.0).sqrt();
        let ci95 = powers.iter().enumerate().map(|(i, c)| [c - half(i), c + half(i)]).collect();
        first += k;
        Block { state, legendre, powers, ci95 }
    })
    .collect()
}
