//! The rounds of settled poses of a real arm: its geometry as one group, gravity, a gap ([`super::geometry`] has the reasons).

use super::fit::{self, Fit, Whitening};
use super::search::{MOST_EFFECTS, Search, Step, rms};
use super::{direction, geometry};

/// The one effect that is sought behind the group, but for gaps.
pub(super) fn is_gravity(effect: &str) -> bool {
    effect == "gravity_compliance"
}

impl Search<'_> {
    /// The geometry of a real arm as one group, where it explains more than any single effect.
    pub(super) fn geometry(&mut self, base: &Fit, whitening: &Whitening) -> Option<(geometry::Group, Fit)> {
        let (group, fit) = geometry::group(self.problem, base, whitening, self.candidates)?;
        let single = self.refine(base, whitening, None);
        let best = single.first().map_or(0.0, |r| r.merit(self.price));
        (group.gain - self.price * group.parameters as f64 > best).then_some((group, fit))
    }

    /// The effects of the group as steps.
    pub(super) fn steps_of(&self, before: &Fit, after: &Fit, group: &geometry::Group) -> Vec<Step> {
        let p = self.problem;
        let (rms_before, rms_after) = (rms(p, &before.state.residual), rms(p, &after.state.residual));
        let step = |k: usize| {
            let own = geometry::own_rival(p, after, k);
            Step {
                effect: own.effect,
                target: own.target,
                rms_before,
                rms_predicted: rms_after,
                rms_after,
                gain: own.gain,
                parameters: own.parameters,
                p_value: group.p_value,
                table: Vec::new(),
                replaced_by: None,
            }
        };
        (0..group.count).map(step).collect()
    }

    /// Behind the geometry of a real arm: gravity, then a gap.
    pub(super) fn arm(
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
            let before = rms(p, &fit.state.residual);
            let mut h = fit.hypothesis.clone();
            h.effects.push(gap.clone());
            let free: Vec<usize> = (self.known..h.effects.len()).collect();
            let z = gaps.terms.iter().map(|t| t.z).fold(0.0, f64::min);
            (fit, _) = again(&fit::refit(p, &h, &free, &noise));
            let rms_after = rms(p, &fit.state.residual);
            steps.push(Step {
                effect: gap.effect.name(),
                target: gap.target_text(&p.robot),
                rms_before: before,
                rms_predicted: rms_after,
                rms_after,
                gain: z * z,
                parameters: 1,
                p_value: self.chance(z * z, 1),
                table: Vec::new(),
                replaced_by: None,
            });
        }
        fit
    }
}
