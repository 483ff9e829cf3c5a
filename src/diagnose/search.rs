//! The rounds: screen, refine, accept, swap, drop, until nothing is missing.
//!
//! Method: a round screens every candidate by linear algebra, refits the best of them with their shapes free and
//! everything else again, and takes the one with the best BIC if its gain cannot be chance among all that was tried.
//! Then every found effect is put in doubt: taken out, replaced by whatever explains its part best, kept only if it is
//! still needed. The search is greedy with swaps; it ends at [`MOST_EFFECTS`] effects.

use super::candidates::{self, Candidate};
use super::fit::{self, Fit, Whitening};
use super::forward::{Hypothesis, Problem};
use super::screen::{Ground, Score};
use super::structure::{self, Bundle, Ratio, Tested};
use super::{across, arm, direction, geometry, precise, prepare, spectrum, verdict};
use crate::effect::{Effect, Placed};
use crate::stats::fisher;
use rayon::prelude::*;

/// Effects that are found at most.
pub const MOST_EFFECTS: usize = 4;
/// Rounds at most: where none describes what is there, effects could take turns without end.
const MOST_ROUNDS: usize = 6;
/// Probability, all that is tried counted, below which a gain is no chance.
const CHANCE: f64 = 1e-4;
/// Candidates that are refitted with their shapes free in a round.
const REFINED: usize = 12;
/// Refined are those whose screening gain is at least this part of the best: the shapes of the screening are coarse.
const NEAR: f64 = 0.5;
/// The same where parts of the data may refuse the best: what stands behind it must have been refined, too.
const NEAR_BEHIND_REFUSED: f64 = 0.15;
/// The same where an effect is put in doubt, which was refined before.
const NEAR_IN_DOUBT: f64 = 0.85;
/// Part of what two effects explain that one must promise to be tried in their place.
const SHARED: f64 = 0.5;
/// Gain in 2 ln L, with the noise fitted anew on both sides, below which an effect is not believed.
const LEAST_GAIN: f64 = 15.0;

/// A candidate refitted with everything else.
#[derive(Debug, Clone)]
pub struct Refined {
    pub effect: &'static str,
    pub target: String,
    pub placed: Vec<Placed>,
    /// Gain in 2 ln L over the hypothesis without it.
    pub gain: f64,
    /// Parameters it adds.
    pub parameters: usize,
    /// Gain that the screening promised.
    pub promised: f64,
    pub fit: Fit,
}

impl Refined {
    /// Gain less the price of the parameters (BIC).
    pub fn merit(&self, price: f64) -> f64 {
        self.gain - price * self.parameters as f64
    }
}

/// One accepted effect, in the order of acceptance.
#[derive(Debug, Clone)]
pub struct Step {
    pub effect: &'static str,
    pub target: String,
    /// Residual rms of the reflectors before, predicted and after, m (or rad where only joints were measured).
    pub rms_before: f64,
    pub rms_predicted: f64,
    pub rms_after: f64,
    pub gain: f64,
    pub parameters: usize,
    pub p_value: f64,
    /// The best of what was tried, best first.
    pub table: Vec<(&'static str, String, f64, usize)>,
    /// A later step put another effect in its place.
    pub replaced_by: Option<String>,
}

/// What the search ends with.
pub struct Outcome {
    pub problem: Problem,
    pub candidates: Vec<Candidate>,
    pub steps: Vec<Step>,
    pub fit: Fit,
    /// Number of known effects: the first of the hypothesis.
    pub known: usize,
    pub whitening: Whitening,
    /// The geometry of a real arm, found as one: the first of the free effects.
    pub group: Option<geometry::Group>,
    /// What a reader should know about the channels, and about what was not named.
    pub notes: Vec<String>,
    /// Rivals of each found effect, with the found one among them, best first.
    pub rivals: Vec<Vec<Refined>>,
    pub structure: Tested,
    /// Structure that remains, if it is more than chance.
    pub remains: Option<Ratio>,
    /// Screening at the end: what is left and what would have been seen.
    pub last: Vec<Score>,
    pub outliers: usize,
    /// rms of the residual: as given, with the frame refitted.
    pub rms_given: f64,
    pub rms_nuisance: f64,
    pub state_nuisance: super::forward::State,
    /// Price of a parameter in 2 ln L.
    pub price: f64,
}

/// rms per coordinate of the reflectors' residual; of all where none is measured.
pub fn rms(problem: &Problem, residual: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0usize);
    let points = problem.groups.iter().any(|g| g.dims == 3);
    for g in problem.groups.iter().filter(|g| !points || g.dims == 3) {
        sum += residual[g.range()].iter().map(|v| v * v).sum::<f64>();
        n += g.range().len();
    }
    (sum / n.max(1) as f64).sqrt()
}

pub(super) struct Search<'a> {
    pub(super) problem: &'a Problem,
    pub(super) candidates: &'a [Candidate],
    pub(super) known: usize,
    pub(super) price: f64,
    tried: f64,
    /// Effects that may be tried; all where `None`.
    pub(super) only: Option<fn(&str) -> bool>,
}

/// Runs the rounds from a hypothesis of known effects.
pub fn run(mut problem: Problem, start: Hypothesis) -> Outcome {
    let known = start.effects.len();
    let mut h = start;
    let rms_given;
    let mut outliers;
    {
        let state = problem.evaluate(&h);
        rms_given = rms(&problem, &state.residual);
        outliers = prepare::drop_spikes(&mut problem, &state);
    }
    let white = |problem: &Problem, h: &Hypothesis| {
        let state = problem.evaluate(h);
        let noise = problem
            .groups
            .iter()
            .map(|g| {
                let v = &state.residual[g.range()];
                super::noise::Noise::white((v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt().max(1e-9))
            })
            .collect();
        Whitening::new(problem, noise)
    };
    let mut fit = fit::refit(&problem, &h, &[], &white(&problem, &h));
    let poses = geometry::applies(&problem);
    outliers += if poses {
        let noise = |p: &Problem, f: &Fit| Whitening::of_residual(p, &f.state.residual, 0).0;
        geometry::drop_gross(&mut problem, &fit.hypothesis, &noise)
    } else {
        prepare::poses_without_outliers(&mut problem, &fit.state)
    };
    h = fit.hypothesis.clone();
    fit = fit::refit(&problem, &h, &[], &white(&problem, &h));
    let candidates = candidates::all(&problem);
    let mut bundles = structure::basis(&problem, &h, &fit.state, &candidates);
    let (first, mut free) = first_noise(&problem, &fit, &white(&problem, &h), &bundles);
    let mut whitening = first;
    let single = prepare::drop_single(&mut problem, &free.freed);
    if single > 0 {
        outliers += single;
        fit = fit::refit(&problem, &h, &[], &white(&problem, &h));
        bundles = structure::basis(&problem, &h, &fit.state, &candidates);
        (whitening, free) = first_noise(&problem, &fit, &white(&problem, &h), &bundles);
    }
    fit = fit::refit(&problem, &fit.hypothesis, &[], &whitening);
    let rms_nuisance = rms(&problem, &fit.state.residual);
    let state_nuisance = fit.state.clone();
    let price = (problem.n as f64).ln().min(8.0);
    let mut search =
        Search { problem: &problem, candidates: &candidates, known, price, tried: candidates.len() as f64, only: None };
    let mut steps: Vec<Step> = Vec::new();
    let mut notes = problem.notes.clone();
    let mut group = None;
    let mut gaps = direction::Terms::default();
    if poses && let Some((found, next)) = search.geometry(&fit, &whitening) {
        steps.extend(search.steps_of(&fit, &next, &found));
        group = Some(found);
        fit = search.arm(next, &mut whitening, &mut steps, &mut gaps, &mut notes);
    }
    while group.is_none() && fit.free.len() < MOST_EFFECTS && steps.len() < MOST_ROUNDS {
        let Some((step, next)) = search.round(&fit, &whitening) else { break };
        steps.push(step);
        fit = search.settle(next, &whitening, &mut steps);
        whitening = precise::noise_left(&problem, &fit, &whitening, &bundles);
        fit = fit::refit(&problem, &fit.hypothesis, &fit.free, &whitening);
    }
    let mut structure = tested(&problem, &fit, &bundles);
    let mut remains =
        if group.is_some() { None } else { verdict::remaining(&problem, &structure, &free, &fit, rms_nuisance) };
    if remains.is_none()
        && group.is_none()
        && let Some(simpler) = search.merge(&fit, &whitening, &mut steps)
    {
        fit = simpler;
        while fit.free.len() < MOST_EFFECTS && steps.len() < MOST_ROUNDS {
            let Some((step, next)) = search.round(&fit, &whitening) else { break };
            steps.push(step);
            fit = search.settle(next, &whitening, &mut steps);
        }
        structure = tested(&problem, &fit, &bundles);
        remains = verdict::remaining(&problem, &structure, &free, &fit, rms_nuisance);
    }
    // of joint sensors a misfit stays, and effects stand out of it by their shape
    if let Some(r) = remains.as_ref().filter(|_| !precise::sensors_alone(&problem)) {
        fit = search.without_substitutes(fit, r, &whitening, &mut steps);
    }
    // the noise of what is left: that of the freed residual is a little too quiet for a test
    whitening = precise::noise_left(&problem, &fit, &whitening, &bundles);
    let in_group = group.as_ref().map_or(0, |g: &geometry::Group| g.count);
    let mut exchanged = 0;
    let rivals = loop {
        let all: Vec<Vec<Refined>> = (0..fit.free.len())
            .map(|k| {
                if k < in_group {
                    return vec![geometry::own_rival(&problem, &fit, k)];
                }
                search.only = group.as_ref().map(|_| arm::is_gravity as fn(&str) -> bool);
                match &fit.hypothesis.effects[fit.free[k]].effect {
                    Effect::Backlash(_) if group.is_some() => direction::gap_rivals(&problem, &fit, &gaps.terms),
                    _ => search.rivals(&fit, k, &whitening),
                }
            })
            .collect();
        // a rival that the whole set makes the better one takes the place
        let swap = (in_group..all.len()).find_map(|k| {
            let old = &fit.hypothesis.effects[fit.free[k]];
            let name = (old.effect.name(), old.target_text(&problem.robot));
            let own = all[k].iter().find(|r| r.effect == name.0 && r.target == name.1)?.merit(price);
            let best = all[k].iter().find(|r| !r.placed.is_empty() && r.merit(price) > own + 2.0)?;
            Some((name, best.clone()))
        });
        match swap {
            Some((name, best)) if group.is_none() && exchanged < MOST_EFFECTS => {
                exchanged += 1;
                mark(&mut steps, &name, &format!("{} {}", best.effect, best.target));
                fit = best.fit;
            }
            _ => break all,
        }
    };
    let tangent = fit::tangent(&problem, &fit.hypothesis, &fit.state, &fit.free, &whitening);
    let ground = Ground::new(&problem, &fit.hypothesis, &fit.state, &whitening, tangent);
    let last = ground.score_all(&candidates);
    Outcome {
        candidates,
        steps,
        fit,
        known,
        whitening,
        group,
        notes,
        rivals,
        structure,
        remains,
        last,
        outliers,
        rms_given,
        rms_nuisance,
        state_nuisance,
        price,
        problem,
    }
}

/// The test without the catalogue, under the noise of what is left.
fn tested(problem: &Problem, fit: &Fit, bundles: &[Bundle]) -> Tested {
    let whitening = Whitening::of_residual(problem, &fit.state.residual, fit.parameters()).0;
    let whitening = precise::noise_left(problem, fit, &whitening, bundles);
    let tangent = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, &whitening);
    structure::test(&Ground::new(problem, &fit.hypothesis, &fit.state, &whitening, tangent), bundles)
}

/// Noise of the residual freed of the whole catalogue-free basis, in two turns.
pub(super) fn first_noise(problem: &Problem, fit: &Fit, white: &Whitening, bundles: &[Bundle]) -> (Whitening, Tested) {
    let mut whitening = white.clone();
    let mut turn = 0;
    loop {
        let tangent = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, &whitening);
        let ground = Ground::new(problem, &fit.hypothesis, &fit.state, &whitening, tangent);
        let tested = structure::test(&ground, bundles);
        whitening = Whitening::of_residual(problem, &tested.freed, tested.whole.dof).0;
        turn += 1;
        if turn == 2 {
            return (whitening, tested);
        }
    }
}

impl Search<'_> {
    /// Screens and refines; the refined candidates, best first.
    pub(super) fn refine(&mut self, base: &Fit, whitening: &Whitening, also: Option<&[Placed]>) -> Vec<Refined> {
        let p = self.problem;
        let tangent = fit::tangent(p, &base.hypothesis, &base.state, &base.free, whitening);
        let ground = Ground::new(p, &base.hypothesis, &base.state, whitening, tangent);
        let spectral = if self.only.is_some() { Vec::new() } else { ground.spectral() };
        self.tried = self.candidates.len() as f64 + spectrum::tried(&ground);
        let mut scored: Vec<(Score, &Candidate)> =
            ground.score_all(self.candidates).into_iter().zip(self.candidates).collect();
        let more: Vec<Score> = ground.score_all(&spectral);
        scored.extend(more.into_iter().zip(&spectral));
        let only = self.only;
        scored.retain(|(s, c)| s.gain > 0.0 && only.is_none_or(|f| f(c.effect)));
        let merit = |s: &Score, c: &Candidate| s.gain - self.price * c.parameters() as f64;
        scored.sort_by(|(a, ca), (b, cb)| merit(b, cb).total_cmp(&merit(a, ca)));
        // of every effect on every target the best shape; of gaps over position the best number of knots
        let near = match also {
            Some(_) => NEAR_IN_DOUBT,
            None if p.logs.len() > 1 || precise::sensors_alone(p) => NEAR_BEHIND_REFUSED,
            None => NEAR,
        };
        let mut picked: Vec<&(Score, &Candidate)> = Vec::new();
        let best = scored.first().map_or(0.0, |s| s.0.gain);
        for s in &scored {
            let again =
                picked.iter().any(|q| q.1.effect == s.1.effect && q.1.target == s.1.target && q.1.form == s.1.form);
            if !again && picked.len() < REFINED && s.0.gain > near * best {
                picked.push(s);
            }
        }
        let mut trials: Vec<(&'static str, String, Vec<Placed>, f64)> = picked
            .iter()
            .map(|(s, c)| (c.effect, c.target.clone(), c.at(&s.coefficients), s.gain))
            .filter(|t| !t.2.is_empty())
            .collect();
        if let Some(also) = also
            && let Some(first) = also.first()
        {
            trials.push((first.effect.name(), first.target_text(&p.robot), also.to_vec(), 0.0));
        }
        let mut refined: Vec<Refined> = trials
            .into_par_iter()
            .map(|(effect, target, placed, promised)| {
                let mut h = base.hypothesis.clone();
                let mut free = base.free.clone();
                let bounds: Vec<Placed> = placed.iter().map(|q| inside(q, p)).collect();
                for q in bounds {
                    free.push(h.effects.len());
                    h.effects.push(q);
                }
                let fit = fit::refit(p, &h, &free, whitening);
                let placed: Vec<Placed> = fit.hypothesis.effects[base.hypothesis.effects.len()..].to_vec();
                let parameters = placed.iter().map(|q| q.effect.values().len()).sum();
                Refined { effect, target, gain: base.cost - fit.cost, parameters, promised, placed, fit }
            })
            .collect();
        refined.sort_by(|a, b| b.merit(self.price).total_cmp(&a.merit(self.price)));
        refined.retain(|r| precise::determined(p, r) && across::agrees(p, r, whitening));
        let mut seen: Vec<(&str, String)> = Vec::new();
        refined.retain(|r| {
            let key = (r.effect, r.target.clone());
            let new = !seen.contains(&key);
            seen.push(key);
            new
        });
        refined
    }

    /// Chance that the best of all that was tried gains this much.
    pub(super) fn chance(&self, gain: f64, parameters: usize) -> f64 {
        let n = self.problem.n as f64;
        let d = parameters as f64;
        (self.tried * fisher::tail(gain / d, d, n)).min(1.0)
    }

    /// Is a refined candidate more than chance, also where the noise may explain what it can?
    fn believed(&self, base: &Fit, r: &Refined) -> bool {
        if self.chance(r.gain, r.parameters) > CHANCE {
            return false;
        }
        let with = Whitening::of_residual(self.problem, &r.fit.state.residual, 0).1;
        let without = Whitening::of_residual(self.problem, &base.state.residual, 0).1;
        with - without > LEAST_GAIN + r.parameters as f64
    }

    pub(super) fn round(&mut self, fit: &Fit, whitening: &Whitening) -> Option<(Step, Fit)> {
        let refined = self.refine(fit, whitening, None);
        let best = refined.iter().find(|r| self.believed(fit, r))?.clone();
        let p = self.problem;
        let (before, after) = (rms(p, &fit.state.residual), rms(p, &best.fit.state.residual));
        let white = (fit.cost / p.n as f64).max(1e-300);
        let step = Step {
            effect: best.effect,
            target: best.target.clone(),
            rms_before: before,
            rms_predicted: before * ((white - best.promised / p.n as f64) / white).max(0.0).sqrt(),
            rms_after: after,
            gain: best.gain,
            parameters: best.parameters,
            p_value: self.chance(best.gain, best.parameters),
            table: refined.iter().map(|r| (r.effect, r.target.clone(), r.gain, r.parameters)).collect(),
            replaced_by: None,
        };
        Some((step, best.fit))
    }

    /// The fit without its k-th found effect: refitted, and with the others where they are. From there rivals start:
    /// others that have bent themselves to the missing one would not find back.
    fn without(&self, fit: &Fit, k: usize, whitening: &Whitening) -> (Fit, Fit) {
        let mut h = fit.hypothesis.clone();
        h.effects.remove(fit.free[k]);
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        let state = self.problem.evaluate(&h);
        let refitted = fit::refit(self.problem, &h, &free, whitening);
        let bare = Fit { hypothesis: h, state, free, ..refitted.clone() };
        (refitted, bare)
    }

    /// Puts every found effect in doubt until none gives way.
    fn settle(&mut self, mut fit: Fit, whitening: &Whitening, steps: &mut [Step]) -> Fit {
        if fit.free.len() < 2 {
            return fit;
        }
        for _ in 0..3 {
            let mut changed = false;
            for k in (0..fit.free.len()).rev() {
                let (base, bare) = self.without(&fit, k, whitening);
                let old = fit.hypothesis.effects[fit.free[k]].clone();
                let name = (old.effect.name(), old.target_text(&self.problem.robot));
                let refined = self.refine(&bare, whitening, Some(std::slice::from_ref(&old)));
                let Some(best) = refined.first() else { continue };
                if !self.believed(&base, best) {
                    mark(steps, &name, "nothing: the others explain it");
                    fit = base;
                    changed = true;
                    break;
                }
                let own = refined
                    .iter()
                    .find(|r| r.effect == name.0 && r.target == name.1)
                    .map_or(0.0, |r| r.merit(self.price));
                if (best.effect, &best.target) != (name.0, &name.1) && best.merit(self.price) > own + 2.0 {
                    mark(steps, &name, &format!("{} {}", best.effect, best.target));
                    fit = best.fit.clone();
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

    /// Found effects that only stand in for structure which none describes go: those on the structure's joint, or on none,
    /// whose gain is not far beyond that of the structure.
    fn without_substitutes(&self, mut fit: Fit, structure: &Ratio, whitening: &Whitening, steps: &mut [Step]) -> Fit {
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
                let name = (old.effect.name(), old.target_text(&p.robot));
                mark(steps, &name, "unknown: it stood in for structure that no effect describes");
            }
        }
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        fit = fit::refit(p, &h, &free, whitening);
        fit
    }

    /// Largest gain that the screening promises.
    fn largest_gain(&self, base: &Fit, whitening: &Whitening) -> f64 {
        let p = self.problem;
        let tangent = fit::tangent(p, &base.hypothesis, &base.state, &base.free, whitening);
        let ground = Ground::new(p, &base.hypothesis, &base.state, whitening, tangent);
        let spectral = ground.spectral();
        let gains = ground.score_all(self.candidates).into_iter().chain(ground.score_all(&spectral)).map(|s| s.gain);
        gains.fold(0.0, f64::max)
    }

    /// One effect in the place of two, where the BIC likes it better: two wrong ones may share what one right one explains.
    fn merge(&mut self, fit: &Fit, whitening: &Whitening, steps: &mut Vec<Step>) -> Option<Fit> {
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
                let needed = fit::refit(p, &h, &free, whitening).cost - fit.cost;
                let state = p.evaluate(&h);
                let bare = Fit { hypothesis: h, state, free, ..fit.clone() };
                if self.largest_gain(&bare, whitening) < SHARED * needed {
                    continue;
                }
                for r in self.refine(&bare, whitening, None).into_iter().take(3) {
                    let then = worth(&r.fit);
                    if then < now - 2.0 && best.as_ref().is_none_or(|o| then < o.0) {
                        best = Some((then, (a, b), r));
                    }
                }
            }
        }
        let (_, (a, b), r) = best?;
        for k in [a, b] {
            let old = &fit.hypothesis.effects[fit.free[k]];
            let name = (old.effect.name(), old.target_text(&p.robot));
            mark(steps, &name, &format!("{} {}", r.effect, r.target));
        }
        let (before, after) = (rms(p, &fit.state.residual), rms(p, &r.fit.state.residual));
        steps.push(Step {
            effect: r.effect,
            target: r.target.clone(),
            rms_before: before,
            rms_predicted: after,
            rms_after: after,
            gain: r.gain,
            parameters: r.parameters,
            p_value: self.chance(r.gain.max(0.0), r.parameters),
            table: Vec::new(),
            replaced_by: None,
        });
        Some(r.fit)
    }

    /// What could stand in the place of the k-th found effect, itself included.
    fn rivals(&mut self, fit: &Fit, k: usize, whitening: &Whitening) -> Vec<Refined> {
        let (_, base) = self.without(fit, k, whitening);
        let old = fit.hypothesis.effects[fit.free[k]].clone();
        let mut rivals = self.refine(&base, whitening, Some(std::slice::from_ref(&old)));
        if old.effect.name() == "time_offset"
            && let Some(own) = rivals.iter().find(|r| r.effect == "time_offset")
            && let Some(lag) = across::common_lag(self.problem, &base, whitening, &own.placed[0], own.gain)
        {
            rivals.push(lag);
            rivals.sort_by(|a, b| b.merit(self.price).total_cmp(&a.merit(self.price)));
        }
        rivals
    }
}

fn mark(steps: &mut [Step], name: &(&'static str, String), by: &str) {
    if let Some(s) =
        steps.iter_mut().rev().find(|s| s.effect == name.0 && s.target == name.1 && s.replaced_by.is_none())
    {
        s.replaced_by = Some(by.into());
    }
}

/// First values held inside their bounds.
fn inside(placed: &Placed, problem: &Problem) -> Placed {
    let values: Vec<f64> =
        placed.effect.values().iter().zip(placed.bounds(&problem.robot)).map(|(v, (lo, hi))| v.clamp(lo, hi)).collect();
    Placed { target: placed.target, effect: placed.effect.with_values(&values) }
}
