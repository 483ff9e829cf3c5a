//! Screening many times from much the same place: whitened sensitivities of the candidates, kept from one screening to the next.
//!
//! Method: a sensitivity depends on the noise and on the effects of its own joint; of the rest of the hypothesis only by the
//! product of two small things. It is computed anew where those effects have changed and whitened anew where the noise has; all
//! others are compared with another residual and another tangent by two matrix products, which cost a tenth of the sensitivities.
//!
//! What is screened is refitted before anything is believed, so that a sensitivity that is a little old does no harm.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::{Score, ScreeningContext, scored};
use crate::diagnose::noise::Noise;
use crate::diagnose::problem::normal::gram;
use crate::effects::{EffectInstance, Target};
use crate::numerics::parallel::ParMap;
use nalgebra::{DMatrix, DVector};
use std::mem::size_of;

/// Largest memory for sensitivities; candidates beyond it are screened one by one, bytes.
const MOST_BYTES: usize = 256 << 20;
/// A value that has moved by less than this share of itself turns no sensitivity.
const SAME: f64 = 0.01;
/// Versions of a candidate that are kept beside the present one, where there is memory for all.
const MOST_VERSIONS: usize = 3;
/// Columns that one thread multiplies at a time.
const PART: usize = 48;

/// Sensitivities of a list of candidates.
#[derive(Default)]
pub struct ScreeningCache {
    noise: Vec<Noise>,
    /// As computed, by candidate: single precision is far finer than what a screening tells.
    raw: Vec<Vec<Vec<f32>>>,
    /// Is what stands in `columns` whitened by the noise that stands here?
    white: Vec<bool>,
    /// Whitened, column by column.
    columns: DMatrix<f64>,
    /// First column of each candidate, and one after the last.
    starts: Vec<usize>,
    /// Effects of its joint with which each candidate was computed; `None`: not yet.
    with: Vec<Option<Vec<EffectInstance>>>,
    /// Normal matrices of the candidates, before the tangent is taken off.
    normals: Vec<DMatrix<f64>>,
    /// What was computed of each candidate with other effects on its joint: an effect in doubt is taken out and put back.
    before: Vec<Vec<Version>>,
}

/// Sensitivities of one candidate beside certain effects of its joint.
struct Version {
    with: Vec<EffectInstance>,
    raw: Vec<Vec<f32>>,
    /// Whitened, with their normal matrix; `None` where the noise has changed since.
    white: Option<(DMatrix<f64>, DMatrix<f64>)>,
}

impl ScreeningCache {
    /// Scores of all candidates in a context, in their order; the list must be the same in all calls.
    pub fn score(&mut self, context: &ScreeningContext, candidates: &[Candidate]) -> Vec<Score> {
        let count: usize = candidates.iter().map(Candidate::sensitivities).sum();
        let n = context.residual.len();
        if count * n * size_of::<f64>() > MOST_BYTES {
            return context.score_all(candidates);
        }
        if self.starts.last() != Some(&count) || self.columns.nrows() != n {
            self.starts = std::iter::once(0)
                .chain(candidates.iter().scan(0, |at, c| {
                    *at += c.sensitivities();
                    Some(*at)
                }))
                .collect();
            self.columns = DMatrix::zeros(n, count);
            self.normals = vec![DMatrix::zeros(0, 0); candidates.len()];
            self.with = vec![None; candidates.len()];
            self.raw = vec![Vec::new(); candidates.len()];
            self.before = candidates.iter().map(|_| Vec::new()).collect();
            self.noise.clear();
        }
        if self.noise != context.whitening.noise {
            self.noise.clone_from(&context.whitening.noise);
            self.white = vec![false; candidates.len()];
            self.before.iter_mut().flatten().for_each(|v| v.white = None);
        }
        self.renew(context, candidates);
        let basis = context.basis_rows();
        let residual = DVector::from_column_slice(&context.residual);
        let width = count.div_ceil(PART);
        let parts: Vec<(DMatrix<f64>, DVector<f64>)> = (0..width).par_map(|k| {
            let columns = self.columns.columns_range(k * PART..count.min((k + 1) * PART));
            (&basis * columns, columns.tr_mul(&residual))
        });
        let at = |c: usize| (&parts[c / PART], c % PART);
        let score = |i: usize| {
            let own: Vec<usize> = (self.starts[i]..self.starts[i + 1]).collect();
            let inside = DMatrix::from_fn(basis.nrows(), own.len(), |b, c| {
                let (part, column) = at(own[c]);
                part.0[(b, column)]
            });
            let right = DVector::from_iterator(own.len(), own.iter().map(|&c| at(c).0.1[at(c).1]));
            scored(i, &self.normals[i], &inside, &right, candidates[i].positive)
        };
        (0..candidates.len()).par_map(score)
    }

    /// Replaces the present version by one that was computed before, where there is one with the effects that the joint
    /// has now.
    fn recall(&mut self, context: &ScreeningContext, candidates: &[Candidate]) {
        let all = self.columns.len() * (size_of::<f64>() + size_of::<f32>());
        let versions = (MOST_BYTES / all.max(1)).min(MOST_VERSIONS);
        for (i, candidate) in candidates.iter().enumerate() {
            let now = of_joint(context, candidate);
            let Some(with) = self.with[i].take_if(|w| !same(w, &now)) else { continue };
            let range = self.starts[i]..self.starts[i + 1];
            if versions > 0 {
                let white = self.white[i].then(|| {
                    (self.columns.columns_range(range.clone()).into_owned(), std::mem::take(&mut self.normals[i]))
                });
                self.before[i].push(Version { with, raw: std::mem::take(&mut self.raw[i]), white });
            }
            let Some(k) = self.before[i].iter().position(|v| same(&v.with, &now)) else {
                let surplus = self.before[i].len().saturating_sub(versions);
                self.before[i].drain(..surplus);
                continue;
            };
            let version = self.before[i].remove(k);
            (self.with[i], self.raw[i], self.white[i]) = (Some(version.with), version.raw, version.white.is_some());
            if let Some((columns, normal)) = version.white {
                self.columns.columns_range_mut(range).copy_from(&columns);
                self.normals[i] = normal;
            }
        }
    }

    /// Computes anew what has become old.
    fn renew(&mut self, context: &ScreeningContext, candidates: &[Candidate]) {
        self.recall(context, candidates);
        let moved = |i: usize| self.with[i].is_none();
        let old: Vec<(usize, bool)> =
            (0..candidates.len()).map(|i| (i, moved(i))).filter(|&(i, moved)| moved || !self.white[i]).collect();
        type Fresh = (Option<Vec<Vec<f32>>>, Vec<Vec<f64>>, DMatrix<f64>);
        let fresh: Vec<Fresh> = old.par_map(|&(i, moved)| {
            let mut columns = match moved {
                true => candidates[i].columns(context.problem, context.hypothesis, context.state),
                false => self.raw[i].iter().map(|c| c.iter().map(|v| f64::from(*v)).collect()).collect(),
            };
            let raw = moved.then(|| columns.iter().map(|c| c.iter().map(|v| *v as f32).collect()).collect());
            columns.iter_mut().for_each(|c| context.whitening.apply(context.problem, c));
            let normal = gram(&columns);
            (raw, columns, normal)
        });
        for ((i, _), (raw, columns, normal)) in old.into_iter().zip(fresh) {
            for (at, column) in (self.starts[i]..).zip(&columns) {
                self.columns.column_mut(at).copy_from_slice(column);
            }
            self.normals[i] = normal;
            self.white[i] = true;
            if let Some(raw) = raw {
                self.raw[i] = raw;
                self.with[i] = Some(of_joint(context, &candidates[i]));
            }
        }
    }
}

/// Effects of the hypothesis on the joint of a candidate.
fn of_joint(context: &ScreeningContext, candidate: &Candidate) -> Vec<EffectInstance> {
    let Some(axis) = candidate.axis() else { return Vec::new() };
    context.hypothesis.effects.iter().filter(|p| p.target == Target::Joint(axis)).cloned().collect()
}

/// The same effects, hardly moved.
fn same(a: &[EffectInstance], b: &[EffectInstance]) -> bool {
    let near = |x: &EffectInstance, y: &EffectInstance| {
        x.effect.name() == y.effect.name() && {
            let (x, y) = (x.effect.values(), y.effect.values());
            x.len() == y.len() && x.iter().zip(&y).all(|(x, y)| (x - y).abs() <= SAME * x.abs())
        }
    };
    a.len() == b.len() && a.iter().zip(b).all(|(x, y)| near(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::candidates;
    use crate::diagnose::candidates::sensitivities::tangent;
    use crate::diagnose::noise::whitening::Whitening;
    use crate::diagnose::problem::synthetic::tests::closed_path_with_gaps;

    #[test]
    fn kept_sensitivities_score_as_new_ones_do() {
        let (problem, h) = closed_path_with_gaps();
        let list = candidates::all(&problem);
        let mut kept = ScreeningCache::default();
        let mut without = h.clone();
        without.effects.clear();
        // there and back again: with the gaps, without, with them
        for h in [&h, &without, &h] {
            let state = problem.evaluate(h);
            let whitening = Whitening::new(&problem, vec![Noise::white(1e-5); problem.groups.len()]);
            let free: Vec<usize> = (0..h.effects.len()).collect();
            let tangent = tangent(&problem, h, &state, &free, &whitening);
            let context = ScreeningContext::new(&problem, h, &state, &whitening, tangent);
            let (fast, plain) = (kept.score(&context, &list), context.score_all(&list));
            for (f, p) in fast.iter().zip(&plain) {
                // a sensitivity that is none of a joint's was computed a few micrometres away: two per cent of its gain at most
                let exact = list[p.candidate].axis().is_some();
                let tolerance = if exact { 1e-6 } else { 0.02 };
                assert!(
                    (f.gain - p.gain).abs() <= tolerance * (1.0 + p.gain),
                    "{}: {} {}",
                    list[p.candidate].effect,
                    f.gain,
                    p.gain
                );
                assert!((f.own - p.own).abs() < if exact { 1e-9 } else { 1e-4 });
            }
            assert!(plain.iter().any(|s| s.gain > 10.0));
        }
    }

    #[test]
    fn an_effect_that_moves_makes_signatures_of_its_joint_old() {
        let (_, h) = closed_path_with_gaps();
        let moved = |by: f64| {
            let mut list = h.effects.clone();
            let values: Vec<f64> = list[0].effect.values().iter().map(|v| v * by).collect();
            list[0].effect = list[0].effect.with_values(&values);
            list
        };
        assert!(same(&h.effects, &moved(1.001)));
        assert!(!same(&h.effects, &moved(1.1)));
        assert!(!same(&h.effects, &h.effects[1..]));
    }
}
