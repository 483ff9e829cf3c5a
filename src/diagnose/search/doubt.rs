//! Found effects in doubt: taken out, exchanged for a better one, merged, or found to be stand-ins for what is unknown.
//!
//! Method: without an effect the others stay where they are and everything is screened and refitted in its place; BIC
//! decides. The search ([`crate::diagnose::search`]) is greedy, and this is what makes good its first guesses.

use crate::diagnose::candidates;
use crate::diagnose::candidates::sensitivities::{APART, Sensitivities};
use crate::diagnose::candidates::structure::Ratio;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::search::direction;
use crate::diagnose::search::finding::{Refined, Step, flat};
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::geometry;
use crate::diagnose::search::{RefineRequest, Search};
use crate::effects::{EffectInstance, Nature, Target, ThermalDrift, TrackerFrame, tracker_frame};

/// Merit (2 ln L less the price of the parameters) by which another effect must be better to take the place of a found one.
pub(in crate::diagnose::search) const BETTER: f64 = 2.0;
/// Part of what two effects explain that one must promise to be tried in their place.
const SHARED: f64 = 0.5;

impl Search<'_> {
    /// The fit without its k-th found effect: refitted, and with the others where they are. From there alternatives start:
    /// others that have bent themselves to the missing one would not find back.
    fn without(&self, fit: &Fit, k: usize, whitening: &Whitening) -> (Fit, Fit) {
        let mut h = fit.hypothesis.clone();
        h.effects.remove(fit.free[k]);
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        let state = self.problem.evaluate(&h);
        let refitted = fit::refit_above(self.problem, &h, &free, whitening, fit.cost);
        let bare = Fit { hypothesis: h, state, free, ..refitted.clone() };
        (refitted, bare)
    }

    /// Puts every found effect that the newest one touches in doubt, and the newest itself, until none gives way.
    pub(in crate::diagnose) fn settle(&mut self, mut fit: Fit, whitening: &Whitening, steps: &mut [Step]) -> Fit {
        if fit.free.len() < 2 {
            return fit;
        }
        let mut newest = fit.free.len() - 1;
        for _ in 0..3 {
            let mut changed = false;
            let doubtful = self.touched(&fit, newest, whitening);
            if doubtful.is_empty() {
                break;
            }
            for k in doubtful.into_iter().rev() {
                let (base, bare) = self.without(&fit, k, whitening);
                let old = fit.hypothesis.effects[fit.free[k]].clone();
                let name = self.name_of(&fit, k);
                let refined = self.refine(&bare, whitening, &in_place_of(&old, fit.cost));
                let Some(best) = refined.first() else { continue };
                if !self.believed(&base, best) {
                    mark(steps, &name, "nothing: the others explain it");
                    fit = base;
                    newest = usize::MAX;
                    changed = true;
                    break;
                }
                let own = refined
                    .iter()
                    .find(|r| r.effect == name.0 && r.target == name.1)
                    .map_or(0.0, |r| r.merit(self.price));
                if (best.effect, &best.target) != (name.0, &name.1) && best.merit(self.price) > own + BETTER {
                    mark(steps, &name, &format!("{} {}", best.effect, best.target));
                    fit = best.fit.clone();
                    newest = fit.free.len() - 1;
                    changed = true;
                    break;
                }
                if best.fit.cost < fit.cost - 0.5 {
                    fit = best.fit.clone();
                }
            }
            if !changed {
                break;
            }
        }
        fit
    }

    /// Found effects whose sensitivities have something in common with those of the k-th, itself among them where there are any;
    /// all of them where there is no such k. Those apart from it stand as they stood: what they explain has not changed.
    fn touched(&self, fit: &Fit, k: usize, whitening: &Whitening) -> Vec<usize> {
        let all = 0..fit.free.len();
        if !all.contains(&k) {
            return if fit.free.len() < 2 { Vec::new() } else { all.collect() };
        }
        let s = Sensitivities::new(self.problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
        let found: Vec<usize> = all.filter(|&j| j == k || s.shared(j, k) > APART).collect();
        if found.len() < 2 { Vec::new() } else { found }
    }

    /// Found effects that only stand in for structure which none describes go: those on the structure's joint, or on none,
    /// whose gain is not far beyond that of the structure.
    pub(in crate::diagnose) fn without_substitutes(
        &self,
        fit: Fit,
        structure: &Ratio,
        whitening: &Whitening,
        steps: &mut [Step],
    ) -> Fit {
        const FAR: f64 = 30.0;
        const ELSEWHERE: f64 = 3.0;
        let p = self.problem;
        let stands = |k: usize| {
            let placed = &fit.hypothesis.effects[fit.free[k]];
            let related = placed.axis().is_none() || placed.axis() == structure.axis;
            let needed = if related { FAR } else { ELSEWHERE };
            let gain = self.without(&fit, k, whitening).0.cost - fit.cost;
            gain > needed * (structure.gain - structure.dof as f64)
        };
        let kept: Vec<bool> = (0..fit.free.len()).map(stands).collect();
        if kept.iter().all(|k| *k) {
            return fit;
        }
        let mut h = fit.hypothesis.clone();
        for (k, stays) in kept.iter().enumerate().rev() {
            if !stays {
                let old = h.effects.remove(fit.free[k]);
                let name = old.named(&p.robot);
                mark(steps, &name, "unknown: it stood in for structure that no effect describes");
            }
        }
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        fit::refit(p, &h, &free, whitening)
    }

    /// One effect instead of two, where the BIC prefers it: two wrong ones may share what one right one explains.
    pub(in crate::diagnose) fn merge(
        &mut self,
        fit: &Fit,
        whitening: &Whitening,
        steps: &mut Vec<Step>,
    ) -> Option<Fit> {
        let p = self.problem;
        let values =
            |f: &Fit| f.free.iter().map(|&i| f.hypothesis.effects[i].effect.values().len()).sum::<usize>() as f64;
        let price = self.price;
        let worth = |f: &Fit| f.cost + price * values(f);
        let now = worth(fit);
        let mut best: Option<(f64, (usize, usize), Refined)> = None;
        for a in 0..fit.free.len() {
            for b in a + 1..fit.free.len() {
                let mut h = fit.hypothesis.clone();
                h.effects.remove(fit.free[b]);
                h.effects.remove(fit.free[a]);
                let free: Vec<usize> = (self.known..h.effects.len()).collect();
                let state = p.evaluate(&h);
                let bare = Fit { hypothesis: h, state, free, ..fit.clone() };
                // of two joints, the effect of the one instead of both is what the rounds have tried already
                let axis = |k: usize| fit.hypothesis.effects[fit.free[k]].axis();
                let apart = axis(a) != axis(b);
                let but = if apart { vec![self.name_of(fit, a), self.name_of(fit, b)] } else { Vec::new() };
                let aim = Some(now - price * values(&bare));
                let asked = RefineRequest { also: None, aim, promise: Some((SHARED, fit.cost)), but: &but };
                for r in self.refine(&bare, whitening, &asked).into_iter().take(3) {
                    let then = worth(&r.fit);
                    if then < now - BETTER && best.as_ref().is_none_or(|o| then < o.0) {
                        best = Some((then, (a, b), r));
                    }
                }
            }
        }
        let (_, (a, b), r) = best?;
        for k in [a, b] {
            mark(steps, &self.name_of(fit, k), &format!("{} {}", r.effect, r.target));
        }
        steps.push(Step::new(r.effect, r.target.clone()));
        Some(r.fit)
    }

    /// What could replace the k-th found effect, itself included.
    fn alternatives(&mut self, fit: &Fit, k: usize, whitening: &Whitening) -> Vec<Refined> {
        let (_, base) = self.without(fit, k, whitening);
        let old = fit.hypothesis.effects[fit.free[k]].clone();
        let mut alternatives = self.refine(&base, whitening, &in_place_of(&old, fit.cost));
        if old.effect.nature() == Nature::Clock
            && let Some(own) = alternatives.iter().find(|r| r.effect == old.effect.name())
            && let Some(lag) = self.lags_for_clock(&base, own, whitening)
        {
            alternatives.push(lag);
        }
        if let Some(drift) = self.drift_of_tracker(&base, &old, whitening) {
            let better = |r: &Refined| r.effect != drift.effect || r.merit(self.price) > drift.merit(self.price);
            alternatives.retain(better);
            if !alternatives.iter().any(|r| r.effect == drift.effect) {
                alternatives.push(drift);
            }
        }
        alternatives.sort_by(|a, b| b.merit(self.price).total_cmp(&a.merit(self.price)));
        alternatives
    }

    /// The tracker's own drift instead of one of the TCP: along a straight line nothing but a fixed nest tells them apart.
    fn drift_of_tracker(&self, base: &Fit, old: &EffectInstance, whitening: &Whitening) -> Option<Refined> {
        let (effect, target) = (tracker_frame::INFO.name, Target::Log.text(&self.problem.robot));
        let drift = old.effect.get::<ThermalDrift>()?;
        let (_, length_s) = candidates::clock(self.problem)?;
        let moved = EffectInstance::new(Target::Log, TrackerFrame::moving(drift.after_m(length_s), length_s));
        let mut h = base.hypothesis.clone();
        h.effects.push(moved.clone());
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        let fit = fit::refit(self.problem, &h, &free, whitening);
        let (gain, parameters) = (base.cost - fit.cost, old.effect.values().len().max(moved.effect.values().len() + 1));
        (gain > 0.0).then(|| Refined { effect, target, gain, parameters, placed: vec![moved], fit })
    }

    /// Alternatives of every found effect. One that the whole set makes the better one takes the place, and those that it touches are
    /// sought again. Returns the alternatives, and whether one took a place.
    pub(in crate::diagnose) fn exchange(
        &mut self,
        fit: &mut Fit,
        whitening: &Whitening,
        steps: &mut [Step],
    ) -> (Vec<Vec<Refined>>, bool) {
        let mut exchanged = 0;
        let mut all: Vec<Vec<Refined>> = (0..fit.free.len()).map(|k| self.alternatives(fit, k, whitening)).collect();
        loop {
            let swap = (0..all.len()).find_map(|k| {
                let name = self.name_of(fit, k);
                let own = match all[k].iter().find(|r| r.effect == name.0 && r.target == name.1) {
                    Some(own) => own.merit(self.price),
                    // it was no alternative of the plain gap
                    None if flat(&fit.hypothesis.effects[fit.free[k]].effect).is_some() => f64::NEG_INFINITY,
                    None => return None,
                };
                let best = all[k].iter().find(|r| !r.placed.is_empty() && r.merit(self.price) > own + BETTER)?;
                Some((k, name, best.clone()))
            });
            match swap {
                Some((k, name, best)) if exchanged < self.limits.effects => {
                    exchanged += 1;
                    mark(steps, &name, &format!("{} {}", best.effect, best.target));
                    *fit = best.fit;
                    // it stands after the others now; lags of all joints are several
                    all.remove(k);
                    let several = fit.free.len() != all.len() + 1;
                    all.resize(fit.free.len(), Vec::new());
                    let Some(newest) = all.len().checked_sub(1) else { return (all, true) };
                    let mut touched = if several { Vec::new() } else { self.touched(fit, newest, whitening) };
                    if several {
                        touched.extend(0..all.len());
                    } else if !touched.contains(&newest) {
                        touched.push(newest);
                    }
                    for j in touched {
                        all[j] = self.alternatives(fit, j, whitening);
                    }
                }
                _ => return (all, exchanged > 0),
            }
        }
    }

    /// Alternatives after the geometry of a real arm: parameters of the group have none, gravity has gravity, a gap those of its
    /// direction terms.
    pub(in crate::diagnose) fn alternatives_beside_geometry(
        &mut self,
        group: &geometry::Group,
        fit: &Fit,
        terms: &[direction::Term],
        whitening: &Whitening,
    ) -> Vec<Vec<Refined>> {
        self.only = Some(geometry::is_gravity);
        (0..fit.free.len())
            .map(|k| match &fit.hypothesis.effects[fit.free[k]].effect {
                _ if k < group.count => vec![geometry::other_geometry(self.problem, fit, k)],
                found if found.is_play() => {
                    direction::gap_alternatives(self.problem, fit, terms, fit.hypothesis.effects[fit.free[k]].axis())
                }
                _ => self.alternatives(fit, k, whitening),
            })
            .collect()
    }

    /// Name and target of the k-th found effect.
    fn name_of(&self, fit: &Fit, k: usize) -> (&'static str, String) {
        let placed = &fit.hypothesis.effects[fit.free[k]];
        placed.named(&self.problem.robot)
    }
}

/// A found effect in doubt: what takes its place must leave as little.
fn in_place_of(old: &EffectInstance, cost: f64) -> RefineRequest<'_> {
    RefineRequest { also: Some(std::slice::from_ref(old)), aim: Some(cost), promise: None, but: &[] }
}

/// Notes on the step that named an effect what has taken its place.
pub(in crate::diagnose::search) fn mark(steps: &mut [Step], name: &(&'static str, String), by: &str) {
    if let Some(s) =
        steps.iter_mut().rev().find(|s| s.effect == name.0 && s.target == name.1 && s.replaced_by.is_none())
    {
        s.replaced_by = Some(by.into());
    }
}
