//! Gaps of joints that reverse together, in the one reading of a ballbar or a dial.
//!
//! Such a reading shows the sum of what the joints lose. Where two of them reverse at the same places of a path, their gaps look like
//! one lost motion that is crossed over more than one travel: a hysteresis of either joint. The rounds go one effect at a time, find that
//! first, and a ridge of the cost separates it from the gaps. Method: instead of the hysteresis, gaps of its joint and of another are
//! refitted from several shares of its size; the best take its place where BIC prefers them. Where two gaps and one hysteresis explain as
//! much, each is in the set of the other: the reading cannot tell them.

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Hypothesis;
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::search::Search;
use crate::diagnose::search::doubt::{BETTER, mark};
use crate::diagnose::search::finding::{Refined, Step, WITHIN};
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::{Backlash, EffectInstance, Hysteresis, Target};
use crate::numerics::parallel::of_each;

/// Shares of the hysteresis that the gap of its own joint has at the start, where the joints move the reading alike,
const SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// and where they move it against each other.
const AGAINST: [f64; 4] = [1.2, 1.6, 2.2, 3.2];
/// Squared cosine between what the gaps of two joints change in the readings from which they reverse together.
const TOGETHER: f64 = 0.5;
/// Presliding of a hysteresis at the start, in parts of its half width.
const ROUNDED: [f64; 2] = [0.7, 1.5];

impl Search<'_> {
    /// Puts gaps of two joints in the place of a hysteresis of one, where they explain more.
    pub(in crate::diagnose) fn as_gaps(&self, mut fit: Fit, whitening: &Whitening, steps: &mut Vec<Step>) -> Fit {
        if !self.reads_sums() {
            return fit;
        }
        for _ in 0..fit.free.len() {
            let better = |other: &Fit| self.cost_with_price(other) < self.cost_with_price(&fit) - BETTER;
            let mut splits = (0..fit.free.len()).filter_map(|k| Some((k, self.split(&fit, k, whitening)?)));
            let Some((k, next)) = splits.find(|s| better(&s.1)) else { break };
            let robot = &self.problem.robot;
            let old = &fit.hypothesis.effects[fit.free[k]];
            let placed: Vec<&EffectInstance> = next.hypothesis.effects.iter().rev().take(2).collect();
            let names: Vec<String> =
                placed.iter().map(|p| format!("{} {}", p.effect.name(), p.target_text(robot))).collect();
            mark(steps, &old.named(robot), &names.join(" and "));
            for p in &placed {
                let stood = |e: &EffectInstance| e.effect.name() == p.effect.name() && e.target == p.target;
                if !fit.free.iter().any(|i| stood(&fit.hypothesis.effects[*i])) {
                    steps.push(Step::new(p.effect.name(), p.target_text(robot)));
                }
            }
            fit = next;
        }
        fit
    }

    /// Adds to the alternatives of every found gap and hysteresis what explains as much together with, or instead of, another joint.
    pub(in crate::diagnose) fn side_by_side(
        &self,
        fit: &Fit,
        whitening: &Whitening,
        alternatives: &mut [Vec<Refined>],
    ) {
        if !self.reads_sums() {
            return;
        }
        let axis = |k: usize| fit.hypothesis.effects[fit.free[k]].axis();
        let is_gap = |k: usize| fit.hypothesis.effects[fit.free[k]].effect.get::<Backlash>().is_some();
        for k in 0..fit.free.len() {
            if let (Some(other), Some(a)) = (self.split(fit, k, whitening), axis(k)) {
                let gap = EffectInstance::new(Target::Joint(a), Backlash::constant(0.0));
                self.add_alternative(fit, k, &gap, &other, alternatives);
            }
            for j in (k + 1..fit.free.len()).filter(|j| is_gap(k) && is_gap(*j) && axis(k) != axis(*j)) {
                for (other, one) in self.merged(fit, [k, j], whitening) {
                    self.add_alternative(fit, k, &one, &other, alternatives);
                    self.add_alternative(fit, j, &one, &other, alternatives);
                }
            }
        }
    }

    /// Adds an alternative of the k-th effect, where it explains as much.
    fn add_alternative(
        &self,
        fit: &Fit,
        k: usize,
        alternative: &EffectInstance,
        other: &Fit,
        alternatives: &mut [Vec<Refined>],
    ) {
        let behind = self.cost_with_price(other) - self.cost_with_price(fit);
        let robot = &self.problem.robot;
        let found = &fit.hypothesis.effects[fit.free[k]];
        let (name, target) = found.named(robot);
        let Some(all) = alternatives.get_mut(k) else { return };
        let own = all.iter().find(|r| r.effect == name && r.target == target).map(|r| r.merit(self.price));
        let (Some(own), true) = (own, behind < WITHIN) else { return };
        let (effect, target) = alternative.named(robot);
        let parameters = alternative.effect.values().len();
        let gain = own - behind + self.price * parameters as f64;
        all.retain(|r| r.effect != effect || r.target != target || r.merit(self.price) > own - behind);
        if !all.iter().any(|r| r.effect == effect && r.target == target) {
            all.push(Refined { effect, target, placed: Vec::new(), gain, parameters, fit: other.clone() });
            all.sort_by(|a, b| b.merit(self.price).total_cmp(&a.merit(self.price)));
        }
    }

    /// Whether a log has one reading a row, which shows a sum of what several joints do.
    fn reads_sums(&self) -> bool {
        self.problem.groups.iter().any(|g| g.sensor == Sensor::Reading)
    }

    /// Cost with the price of the values (BIC).
    fn cost_with_price(&self, fit: &Fit) -> f64 {
        let values: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
        fit.cost + self.price * values as f64
    }

    /// The best fit with gaps of two joints, which stand last, in the place of the k-th effect, a hysteresis.
    fn split(&self, fit: &Fit, k: usize, whitening: &Whitening) -> Option<Fit> {
        let found = &fit.hypothesis.effects[fit.free[k]];
        let (own, wide) = (found.axis()?, found.effect.get::<Hysteresis>()?.half_width);
        if wide <= 0.0 {
            return None;
        }
        let p = self.problem;
        let mut starts = Vec::new();
        for other in (0..p.robot.dof()).filter(|b| *b != own && p.logs.iter().any(|l| l.log.travel(*b) > 0.0)) {
            let gap = |e: &EffectInstance| {
                (e.target == Target::Joint(other)).then(|| e.effect.get::<Backlash>().map(|b| b.half_gap)).flatten()
            };
            let gone: Vec<usize> = fit
                .free
                .iter()
                .copied()
                .filter(|i| *i == fit.free[k] || gap(&fit.hypothesis.effects[*i]).is_some())
                .collect();
            let before: f64 = gone.iter().filter_map(|i| gap(&fit.hypothesis.effects[*i])).sum();
            let mut h = fit.hypothesis.clone();
            gone.iter().rev().for_each(|i| drop(h.effects.remove(*i)));
            let state = p.evaluate(&h);
            let column = |axis: usize| p.difference(&h, &state, &[], &[gap_of(axis, wide)], wide);
            let (a, b) = (column(own), column(other));
            let (ab, aa, bb) = (dot(&a, &b), dot(&a, &a), dot(&b, &b));
            if ab * ab <= TOGETHER * aa * bb {
                continue;
            }
            let shares = if ab > 0.0 { SHARES.as_slice() } else { AGAINST.as_slice() };
            starts.extend(shares.iter().map(|share| {
                let mut start = h.clone();
                start.effects.push(gap_of(own, share * wide));
                start.effects.push(gap_of(other, before + (1.0 - share) * wide * ab / bb));
                start
            }));
        }
        self.best_of(starts, whitening)
    }

    /// Fits with one hysteresis, which stands last, in the place of two gaps: of either joint.
    fn merged(&self, fit: &Fit, [k, j]: [usize; 2], whitening: &Whitening) -> Vec<(Fit, EffectInstance)> {
        let p = self.problem;
        let both = [k, j].map(|k| &fit.hypothesis.effects[fit.free[k]]);
        let [Some(one), Some(other)] = both.map(EffectInstance::axis) else { return Vec::new() };
        let sizes = both.map(|e| e.effect.get::<Backlash>().map_or(0.0, |b| b.half_gap));
        let mut h = fit.hypothesis.clone();
        let mut gone = [fit.free[k], fit.free[j]];
        gone.sort_unstable();
        gone.iter().rev().for_each(|i| drop(h.effects.remove(*i)));
        let state = p.evaluate(&h);
        let size = sizes[0].max(sizes[1]).max(f64::MIN_POSITIVE.sqrt());
        let [a, b] = [one, other].map(|axis| p.difference(&h, &state, &[], &[gap_of(axis, size)], size));
        let (ab, aa, bb) = (dot(&a, &b), dot(&a, &a), dot(&b, &b));
        if ab * ab <= TOGETHER * aa * bb {
            return Vec::new();
        }
        let widths = [(one, sizes[0] + sizes[1] * ab / aa), (other, sizes[1] + sizes[0] * ab / bb)];
        let of_joint = |(axis, half_width): (usize, f64)| {
            let starts = ROUNDED.map(|part| {
                let mut start = h.clone();
                let rounded = Hysteresis { half_width: half_width.abs(), presliding: part * half_width.abs() };
                start.effects.push(EffectInstance::new(Target::Joint(axis), rounded));
                start
            });
            let best = self.best_of(starts.into(), whitening)?;
            let one = best.hypothesis.effects.last()?.clone();
            Some((best, one))
        };
        widths.into_iter().filter_map(of_joint).collect()
    }

    /// The best refit of several starts.
    fn best_of(&self, starts: Vec<Hypothesis>, whitening: &Whitening) -> Option<Fit> {
        let p = self.problem;
        let refitted = of_each(starts, |mut h| {
            h.effects.iter_mut().skip(self.known).for_each(|e| *e = fit::inside(e, p));
            let free: Vec<usize> = (self.known..h.effects.len()).collect();
            fit::refit(p, &h, &free, whitening)
        });
        refitted.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}

fn gap_of(axis: usize, half_gap: f64) -> EffectInstance {
    EffectInstance::new(Target::Joint(axis), Backlash::constant(half_gap.max(0.0)))
}
