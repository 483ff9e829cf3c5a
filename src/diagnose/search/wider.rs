//! The search again with forms of more freedom, where the plain ones leave something, or take one shape to pieces.
//!
//! Friction that builds up, is larger one way or grows with load, play whose flank follows the load, a ripple that fades with
//! speed: each includes a plain effect of the catalogue and has one to three parameters more. Tried everywhere, they would slow
//! every diagnosis and stand in for what has no name. So they are tried on the joint that the remainder goes with, or that has an
//! effect twice, then on the next one, and taken only where nothing but noise is left with them, and likelier than without.

use crate::diagnose::candidates::cache::ScreeningCache;
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::search::course::End;
use crate::diagnose::search::doubt::BETTER;
use crate::diagnose::search::prepared::Prepared;
use crate::diagnose::search::{Limits, Search, alike};

/// Joints on which wider forms are tried.
const MOST_JOINTS: usize = 2;
/// Where a search with them ends: what needs more effects has no name.
const FEW: Limits = Limits { effects: 6, rounds: 9, pieces: true };

impl Search<'_> {
    /// The search with wider forms of the joints that need them, where it explains the logs better.
    pub(in crate::diagnose) fn with_wider_forms(
        &self,
        prepared: &Prepared,
        rms_nuisance: f64,
        plain: &End,
    ) -> Option<End> {
        let mut joints: Vec<usize> = Vec::new();
        let mut next = in_need(plain);
        while let Some(axis) = next.filter(|a| joints.len() < MOST_JOINTS && !joints.contains(a)) {
            joints.push(axis);
            let mut list: Vec<Candidate> = candidates::all(self.problem);
            list.extend(joints.iter().flat_map(|&a| candidates::wider(self.problem, a)));
            let mut search = Search {
                candidates: &list,
                kept: ScreeningCache::default(),
                tried: list.len() as f64,
                wider: true,
                limits: FEW,
                ..*self
            };
            let end = search.course(prepared, rms_nuisance);
            if end.explains_all() && (!plain.explains_all() || self.worth(&end) > self.worth(plain) + BETTER) {
                return Some(end);
            }
            next = in_need(&end);
        }
        None
    }

    /// 2 ln L with the noise fitted anew, less the price of the parameters.
    fn worth(&self, end: &End) -> f64 {
        let fit = &end.course.fit;
        let values: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
        Whitening::of_residual(self.problem, &fit.state.residual, 0).1 - self.price * values as f64
    }
}

/// The joint that the remainder goes with, or that has an effect twice.
fn in_need(end: &End) -> Option<usize> {
    if end.course.group.is_some() {
        return None;
    }
    let fit = &end.course.fit;
    let found = fit.free.iter().map(|&i| &fit.hypothesis.effects[i]);
    let twice = || found.filter(|p| alike(fit, p) > 1).find_map(|p| p.axis());
    end.course.remains.as_ref().and_then(|r| r.axis).or_else(twice)
}
