//! The rounds of settled poses of a real arm: its geometry as one group, gravity, a gap ([`crate::diagnose::search::geometry`] has the reasons).

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::search::direction;
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::geometry;
use crate::diagnose::search::outcome::Step;
use crate::diagnose::search::{Asked, MOST_EFFECTS, Search};
use crate::effects::{Family, catalogue};

/// The one effect that is sought behind the group, but for gaps.
pub(in crate::diagnose) fn is_gravity(effect: &str) -> bool {
    catalogue::find(effect).is_some_and(|e| e.family == Family::Gravity)
}

impl Search<'_> {
    /// The geometry of a real arm as one group, where it explains more than any single effect.
    pub(in crate::diagnose) fn geometry(
        &mut self,
        base: &Fit,
        whitening: &Whitening,
    ) -> Option<(geometry::Group, Fit)> {
        let (group, fit) = geometry::group(self.problem, base, whitening, self.candidates)?;
        let single = self.refine(base, whitening, &Asked::default());
        let best = single.first().map_or(0.0, |r| r.merit(self.price));
        (group.gain - self.price * group.parameters as f64 > best).then_some((group, fit))
    }

    /// The effects of the group as steps.
    pub(in crate::diagnose) fn steps_of(&self, after: &Fit, group: &geometry::Group) -> Vec<Step> {
        let p = self.problem;
        let step = |k: usize| {
            let own = geometry::own_rival(p, after, k);
            Step::new(own.effect, own.target)
        };
        (0..group.count).map(step).collect()
    }

    /// Behind the geometry of a real arm: gravity, then a gap.
    pub(in crate::diagnose) fn arm(
        &mut self,
        mut fit: Fit,
        whitening: &mut Whitening,
        steps: &mut Vec<Step>,
        gaps: &mut direction::Terms,
        notes: &mut Vec<String>,
    ) -> Fit {
        let p = self.problem;
        let mut again = |fit: &Fit| {
            *whitening = Whitening::of_residual(p, &fit.state.residual, fit.parameters()).0;
            (fit::refit(p, &fit.hypothesis, &fit.free, whitening), whitening.clone())
        };
        let mut noise;
        (fit, noise) = again(&fit);
        self.only = Some(is_gravity);
        for _ in 0..MOST_EFFECTS - 2 {
            let Some((step, next)) = self.round(&fit, &noise) else { break };
            let found = next.hypothesis.effects.last();
            if !found.is_some_and(|e| geometry::stands_beside(p, &fit, &noise, self.candidates, e)) {
                break;
            }
            steps.push(step);
            (fit, noise) = again(&next);
        }
        self.only = None;
        *gaps = direction::directions(p, &fit, &noise, self.candidates);
        let (gap, said) = direction::gap(p, gaps);
        notes.push(direction::terms_said(p, &gaps.terms));
        notes.extend(said);
        if let Some(gap) = gap {
            let mut h = fit.hypothesis.clone();
            h.effects.push(gap.clone());
            let free: Vec<usize> = (self.known..h.effects.len()).collect();
            (fit, _) = again(&fit::refit(p, &h, &free, &noise));
            steps.push(Step::new(gap.effect.name(), gap.target_text(&p.robot)));
        }
        fit
    }
}
