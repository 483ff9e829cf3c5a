//! The rounds of settled poses of a real arm: its geometry as one group, gravity, a gap ([`crate::diagnose::search::geometry`] has the
//! reasons).

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::Note;
use crate::diagnose::search::direction;
use crate::diagnose::search::finding::{Refined, Step};
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::geometry;
use crate::diagnose::search::rounds::{CHANCE, RefineRequest, Search};

/// Joints that yield to gravity, at most.
const MOST_GRAVITY: usize = 4;

impl Search<'_> {
    /// The geometry of a real arm as one group, where it explains more than any single effect.
    pub(in crate::diagnose) fn geometry(
        &mut self,
        base: &Fit,
        whitening: &Whitening,
    ) -> Option<(geometry::Group, Fit)> {
        let (group, fit) = geometry::group(self.problem, base, whitening, self.candidates)?;
        let single = self.refine(base, whitening, &RefineRequest::default());
        let best = single.first().map_or(0.0, |r| r.merit(self.price));
        (group.gain - self.price * group.parameters as f64 > best).then_some((group, fit))
    }

    /// The effects of the group as steps.
    pub(in crate::diagnose) fn steps_of(&self, after: &Fit, group: &geometry::Group) -> Vec<Step> {
        let p = self.problem;
        let step = |k: usize| {
            let own = geometry::other_geometry(p, after, k);
            Step::new(own.effect, own.target)
        };
        (0..group.count).map(step).collect()
    }

    /// After the geometry of a real arm: gravity, then a gap.
    pub(in crate::diagnose) fn arm(
        &mut self,
        mut fit: Fit,
        whitening: &mut Whitening,
        steps: &mut Vec<Step>,
        gaps: &mut direction::Terms,
        notes: &mut Vec<Note>,
    ) -> Fit {
        let p = self.problem;
        let mut again = |fit: &Fit| {
            *whitening = Whitening::of_residual(p, &fit.state.residual, fit.parameters()).0;
            (fit::refit(p, &fit.hypothesis, &fit.free, whitening), whitening.clone())
        };
        let mut noise;
        (fit, noise) = again(&fit);
        self.only = Some(geometry::is_gravity);
        for _ in 0..MOST_GRAVITY {
            let refined = self.refine(&fit, &noise, &RefineRequest::default());
            let stands = |r: &&Refined| {
                let own = r.placed.last();
                self.believed(&fit, r)
                    && own.is_some_and(|e| geometry::stands_beside(p, &fit, &noise, self.candidates, e))
            };
            let Some(best) = refined.iter().find(stands) else { break };
            steps.push(Step::new(best.effect, best.target.clone()));
            (fit, noise) = again(&best.fit);
        }
        self.only = None;
        *gaps = direction::directions(p, &fit, &noise, self.candidates);
        let (found, none) = direction::gaps(p, gaps);
        notes.push(direction::note_of(p, &gaps.terms));
        notes.extend(none);
        if !found.is_empty() {
            steps.extend(found.iter().map(|gap| Step::new(gap.effect.name(), gap.target_text(&p.robot))));
            let mut h = fit.hypothesis.clone();
            h.effects.extend(found);
            let free: Vec<usize> = (self.known..h.effects.len()).collect();
            (fit, _) = again(&fit::refit(p, &h, &free, &noise));
            // gravity that only stood in for a gap goes
            while let Some(k) = self.no_longer_gravity(&fit) {
                let mut h = fit.hypothesis.clone();
                let old = h.effects.remove(fit.free[k]);
                let target = old.target_text(&p.robot);
                if let Some(s) = steps.iter_mut().find(|s| s.effect == old.effect.name() && s.target == target) {
                    s.replaced_by = Some("nothing: a gap explains it".into());
                }
                let free: Vec<usize> = (self.known..h.effects.len()).collect();
                (fit, _) = again(&fit::refit(p, &h, &free, &noise));
            }
        }
        fit
    }

    /// A found gravity (place among the free effects) that explains no more than chance beside all the others.
    fn no_longer_gravity(&self, fit: &Fit) -> Option<usize> {
        (0..fit.free.len()).find(|&k| {
            let own = geometry::other_geometry(self.problem, fit, k);
            geometry::is_gravity(own.effect) && self.chance(own.gain, own.parameters) > CHANCE
        })
    }
}
