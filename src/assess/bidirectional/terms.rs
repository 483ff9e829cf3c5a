//! Which terms a state adds to the reference's curve: Student tests of its indicator variable, the offset first (Slamani (2012)
//! equations 16 and 20).

use super::data::{Data, Options, Reference, Scatter, design};
use super::note::Note;
use super::poses::Pose;
use super::state::States;
use crate::numerics::{legendre, linear, student};

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

/// What the states add to the reference's curve.
pub(super) struct Terms {
    pub(super) tests: Vec<StateTest>,
    /// States with a significant term, and the order of the last.
    pub(super) kept: Vec<(usize, usize)>,
    /// States that have poses, the reference first.
    pub(super) present: Vec<usize>,
}

impl Terms {
    pub(super) fn test(
        reference: &Reference,
        poses: &[Pose],
        order: &[usize],
        states: &States,
        degree: usize,
        options: &Options,
        notes: &mut Vec<Note>,
    ) -> Self {
        let mut terms = Self { tests: Vec::new(), kept: Vec::new(), present: vec![reference.state] };
        for &state in &order[1..] {
            let data = Data::of(poses, reference.range, &[reference.state, state]);
            if data.y.len() == reference.base.y.len() {
                notes.push(Note::StateLeftOut { state: states.text(state) });
                continue;
            }
            terms.present.push(state);
            let term = |k: usize| student_test(&data, degree, state, k, reference.range, options);
            terms.state(state, &states.text(state), degree, term, notes);
        }
        terms
    }

    /// Tests the terms of one state in rising order; the first that is not significant ends it.
    fn state(
        &mut self,
        state: usize,
        name: &str,
        degree: usize,
        term: impl Fn(usize) -> Option<StateTest>,
        notes: &mut Vec<Note>,
    ) {
        for k in 0..=degree {
            let Some(test) = term(k) else {
                if k == 0 {
                    notes.push(Note::TooFewPoses { state: name.into() });
                }
                return;
            };
            let significant = test.significant;
            if significant {
                self.kept.retain(|(s, _)| *s != state);
                self.kept.push((state, k));
            } else if k == 0
                && degree > 0
                && let Some(slope) = term(1).filter(|t| t.significant)
            {
                notes.push(Note::SlopeAlone { state: name.into(), t: slope.t });
            }
            self.tests.push(test);
            if !significant {
                return;
            }
        }
    }
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
