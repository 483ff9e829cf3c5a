//! The search again with forms that have more freedom, where the plain ones leave something, or split one shape into pieces.
//!
//! Friction that builds up, is larger one way or grows with load, play whose flank follows the load, a ripple that fades with
//! speed: each includes a plain effect of the catalogue and has one to three parameters more. Tried everywhere, they would slow
//! every diagnosis and stand in for what has no name. So they are tried on the joint that the remainder depends on, or that has an
//! effect twice, then on the next one, and taken only where nothing but noise is left with them, and likelier than without. A freedom
//! that the log does not need beyond doubt is taken back. Where what is left is mostly slow noise, the joint is that of the form
//! which explains most of it: a load that changes its side a few times looks like slow noise.

use crate::diagnose::candidates::cache::ScreeningCache;
use crate::diagnose::candidates::screen::Score;
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::noise::Noise;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::course::{End, SearchState};
use crate::diagnose::search::doubt::BETTER;
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::geometry;
use crate::diagnose::search::prepared::Prepared;
use crate::diagnose::search::rounds::{CHANCE, LEAST_GAIN, Limits, Search, alike};
use crate::effects::EffectInstance;

/// Joints on which wider forms are tried.
const MOST_JOINTS: usize = 2;
/// Where a search with them ends: what needs more effects has no name.
const FEW: Limits = Limits { effects: 6, rounds: 9, pieces: true };
/// Share of the variance, and correlation from sample to sample, beyond which noise is mostly slow.
const MOSTLY: f64 = 0.5;
const SLOW: f64 = 0.9;

impl Search<'_> {
    /// The search with wider forms of the joints that need them, where it explains the logs better.
    pub(in crate::diagnose) fn with_wider_forms(
        &self,
        prepared: &Prepared,
        rms_nuisance: f64,
        plain: &End,
    ) -> Option<End> {
        let mut joints: Vec<usize> = Vec::new();
        let mut next = in_need(plain).or_else(|| self.behind_slow_noise(plain));
        while let Some(axis) = next.filter(|a| joints.len() < MOST_JOINTS && !joints.contains(a)) {
            joints.push(axis);
            let mut list: Vec<Candidate> = candidates::all(self.problem);
            if prepared.recording == Recording::SettledPoses {
                list.extend(geometry::further(self.problem));
            }
            list.extend(joints.iter().flat_map(|&a| candidates::wider(self.problem, a)));
            let mut search = Search {
                candidates: &list,
                kept: ScreeningCache::default(),
                tried: list.len() as f64,
                wider: &joints,
                limits: FEW,
                ..*self
            };
            let mut end = search.course(prepared, rms_nuisance);
            search.to_plainer_forms(&mut end.course);
            let better = || !plain.explains_all() || self.worth(&end) > self.worth(plain) + BETTER;
            if end.explains_all() && self.is_wider(&end) && better() {
                return Some(end);
            }
            next = in_need(&end);
        }
        None
    }

    /// Whether a found effect has a wider form, and the log samples the course of each: a rise shorter than its rows, or as long as
    /// its decay, is another course than the one that is named.
    fn is_wider(&self, end: &End) -> bool {
        let fit = &end.course.fit;
        let step_s = candidates::clock(self.problem).map_or(0.0, |c| c.0);
        let found = fit.free.iter().map(|&i| &fit.hypothesis.effects[i].effect).filter(|e| e.is_wider());
        let sampled: Vec<bool> = found.map(|e| e.is_sampled(step_s)).collect();
        !sampled.is_empty() && sampled.iter().all(|s| *s)
    }

    /// Puts the plainer form in the place of each wider one that the log does not need beyond doubt.
    fn to_plainer_forms(&self, course: &mut SearchState) {
        let p = self.problem;
        let likely = |f: &Fit| Whitening::of_residual(p, &f.state.residual, 0).1;
        let mut k = 0;
        while k < course.fit.free.len() {
            let at = course.fit.free[k];
            let placed = &course.fit.hypothesis.effects[at];
            let Some(plainer) = placed.effect.plainer() else {
                k += 1;
                continue;
            };
            let fewer = placed.effect.values().len() - plainer.values().len();
            let mut h = course.fit.hypothesis.clone();
            h.effects[at] = fit::inside(&EffectInstance::new(placed.target, plainer), p);
            let next = fit::refit(p, &h, &course.fit.free, &course.whitening);
            if likely(&course.fit) - likely(&next) > LEAST_GAIN + self.price * fewer as f64 {
                k += 1;
            } else {
                // and perhaps a still plainer one
                course.fit = next;
            }
        }
    }

    /// The joint of the wider form that explains most of what is left, where that is mostly slow noise and no chance.
    fn behind_slow_noise(&self, end: &End) -> Option<usize> {
        let (p, SearchState { fit, whitening, group, .. }) = (self.problem, &end.course);
        let slow = |n: &Noise| n.share > MOSTLY && n.phi > SLOW;
        if group.is_some() || !whitening.noise.iter().any(slow) {
            return None;
        }
        let mut list: Vec<Candidate> = (0..p.robot.dof()).flat_map(|axis| candidates::wider(p, axis)).collect();
        list.retain(|c| c.sensitivities() == 1 && c.shape_parameters <= 2);
        let context = fit.screening(p, whitening);
        let scored = context.score_all(&list);
        let merit = |(s, c): &(&Score, &Candidate)| s.gain - self.price * c.parameters() as f64;
        let finite = scored.iter().zip(&list).filter(|(s, _)| s.gain.is_finite());
        let (score, best) = finite.max_by(|a, b| merit(a).total_cmp(&merit(b)))?;
        (self.chance(score.gain, best.parameters()) < CHANCE).then(|| best.axis()).flatten()
    }

    /// 2 ln L with the noise fitted anew, less the price of the parameters.
    fn worth(&self, end: &End) -> f64 {
        let fit = &end.course.fit;
        let values: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
        Whitening::of_residual(self.problem, &fit.state.residual, 0).1 - self.price * values as f64
    }
}

/// The joint that the remainder depends on, or that has an effect twice.
fn in_need(end: &End) -> Option<usize> {
    if end.course.group.is_some() {
        return None;
    }
    let fit = &end.course.fit;
    let found = fit.free.iter().map(|&i| &fit.hypothesis.effects[i]);
    let twice = || found.filter(|p| alike(fit, p) > 1).find_map(|p| p.axis());
    end.course.remains.as_ref().and_then(|r| r.axis).or_else(twice)
}
