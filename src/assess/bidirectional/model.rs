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
//! leave means that lie closer to the curve than they should. [`Errors`](super::data::Errors) chooses one.
//!
//! How it fails: a state that changes the curve's slope about the middle of the line and not its mean passes the test of the
//! offset; a note says so where its slope would be significant. Two columns that always change together are one state.

use super::data::{Data, Options, Reference, Scatter, design};
use super::degree::{self, LackOfFit};
use super::note::Note;
use super::poses::Pose;
use super::state::States;
use super::terms::{StateTest, Terms};
use crate::error::{Error, Place, Result};
use crate::numerics::linear::{self, Fit};
use crate::numerics::{legendre, student};
use nalgebra::{DMatrix, DVector};

/// A polynomial of the final model: the reference's curve, or what a state adds to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// `None`: the reference's curve.
    pub state: Option<usize>,
    /// Coefficients of Legendre polynomials on the range, m.
    pub legendre: Vec<f64>,
    /// The same as coefficients of powers of the position, in m over m to the power.
    pub powers: Vec<f64>,
    /// 95 % intervals of the coefficients, m over m to the power.
    pub ci95: Vec<[f64; 2]>,
}

/// The final model.
#[derive(Debug, Clone)]
pub struct Model {
    /// Number of the state that the others are compared with.
    pub reference: usize,
    /// Positions that were measured.
    pub range_m: [f64; 2],
    /// Degree of the polynomial over position.
    pub degree: usize,
    /// The degree was given by the user.
    pub given: bool,
    /// Its lack of fit is not significant; `None`: cannot be tested.
    pub adequate: Option<bool>,
    /// From the first degree that was tried.
    pub lack_of_fit: Vec<LackOfFit>,
    /// p value of the test that the backlash is the same at all poses of the reference.
    pub varies_p_value: Option<f64>,
    /// Student's tests of the coefficients by which states differ.
    pub tests: Vec<StateTest>,
    /// The curve of the reference state, then what each other state adds.
    pub blocks: Vec<Block>,
    /// Scatter by which coefficients are judged.
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

    /// States that have their own term.
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
    notes: &mut Vec<Note>,
) -> Result<std::result::Result<Model, NoModel>> {
    let reference = Reference::new(poses, order, states, file)?;
    let (base, range) = (&reference.base, reference.range);
    let curve = match Curve::choose(base, options)? {
        Ok(curve) => curve,
        Err(none) => return Ok(Err(none)),
    };
    curve.note(base, options, notes);
    let degree = curve.degree;
    let terms = Terms::test(&reference, poses, order, states, degree, options, notes);
    let data = Data::of(poses, range, &terms.present);
    let Some(fit) = linear::weighted(&design(&data, degree, &terms.kept), &data.y, &data.r) else {
        return Err(Error::bad(
            Place::file(file),
            format!("poses that do not determine a curve of degree {degree}"),
            "more positions, or a lower degree",
        )
        .mended_by(&["degree"]));
    };
    let scatter = Scatter::of_model(&fit, &data, options.errors, curve.adequate);
    let covariance = &fit.inverse * scatter.variance_m2;
    let blocks = blocks(&fit, &covariance, degree, &terms.kept, range, scatter.dof);
    let all_states = (terms.present.len() > 1).then(|| over_all_states(&fit, &data, degree, options, notes)).flatten();
    Ok(Ok(Model {
        reference: reference.state,
        range_m: range,
        degree,
        given: options.degree.is_some(),
        adequate: curve.adequate,
        lack_of_fit: curve.table,
        varies_p_value: curve.varies_p_value,
        tests: terms.tests,
        blocks,
        scatter,
        all_states,
        covariance,
    }))
}

/// The degree of the reference's curve and the tests that chose it.
struct Curve {
    degree: usize,
    adequate: Option<bool>,
    table: Vec<LackOfFit>,
    varies_p_value: Option<f64>,
    /// Highest degree that was tried.
    tried: usize,
}

impl Curve {
    fn choose(base: &Data, options: &Options) -> Result<std::result::Result<Self, NoModel>> {
        let n = base.y.len();
        if let Some(d) = options.degree
            && d >= n
        {
            return Err(Error::setting(
                "degree",
                format!("degree {d} for {n} poses"),
                format!("a degree of at most {}", n - 1),
            ));
        }
        let highest = options.highest.unwrap_or(degree::HIGHEST);
        let mut table = degree::table(base, highest.max(options.degree.unwrap_or(0)), options.alpha);
        let varies_p_value = table.first().map(|t| t.p_value);
        let tried = table.last().map_or(0, |t| t.degree);
        // a line of few poses: the first degree that can be tested
        let lowest = options.lowest.min(tried);
        let chosen = degree::choose(&table, lowest, options.alpha).map(|t| t.degree);
        let degree = match options.degree.or(chosen) {
            Some(degree) => degree,
            None if base.pure_dof() <= 0.0 && n > 1 => return Ok(Err(NoModel::NoPureError)),
            None => 0,
        };
        let adequate = table.iter().find(|t| t.degree == degree).map(|t| t.adequate);
        table.retain(|t| t.degree >= lowest);
        Ok(Ok(Self { degree, adequate, table, varies_p_value, tried }))
    }

    fn note(&self, base: &Data, options: &Options, notes: &mut Vec<Note>) {
        if self.adequate == Some(false) && options.degree.is_none() {
            notes.push(Note::LackOfFit { tried: self.tried, poses: base.y.len(), degree: self.degree });
        }
        if base.pure_dof() > 0.0 && base.pure == 0.0 {
            notes.push(Note::RepeatsAgree);
        }
    }
}

/// Lack of fit of the final model over all states.
fn over_all_states(
    fit: &Fit,
    data: &Data,
    degree: usize,
    options: &Options,
    notes: &mut Vec<Note>,
) -> Option<LackOfFit> {
    let dof = [data.y.len() as f64 - fit.coefficients.len() as f64, data.pure_dof()];
    let test = LackOfFit::new(degree, fit.residual, data.pure, dof, options.alpha)?;
    if !test.adequate {
        notes.push(Note::LackOfFitOverStates { f: test.f, p_value: test.p_value });
    }
    Some(test)
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
