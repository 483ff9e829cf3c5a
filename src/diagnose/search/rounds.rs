//! One round after the other: screen, refine, accept what is more than chance, and put in doubt what was found.

use crate::diagnose::candidates::basis::BasisGroup;
use crate::diagnose::candidates::cache::ScreeningCache;
use crate::diagnose::candidates::screen::{Score, ScreeningContext};
use crate::diagnose::candidates::sensitivities::Sensitivities;
use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::candidates::{spectrum, steps};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::finding::{Next, Refined, Step, flat};
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::{across, freed, precise, supported};
use crate::effects::{Backlash, EffectInstance, TrackerFrame, backlash, catalogue};
use crate::numerics::fisher;
use crate::numerics::parallel;

/// The plain gap, which some effects include.
const PLAIN: &str = backlash::INFO.name;
/// Effects that are found at most, where they explain everything.
pub const MOST_EFFECTS: usize = 16;
/// Effects of one name at one place at most, as the orders of a ripple or the modes of a structure: more of them are a shape
/// taken to pieces that the catalogue does not have.
const MOST_ALIKE: usize = 2;

/// Where the search ends.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Limits {
    /// Effects at most.
    pub effects: usize,
    /// Rounds at most: where none describes what is there, effects could take turns without end.
    pub(super) rounds: usize,
    /// Whether a name that comes at one place again and again ends the search.
    pub(super) pieces: bool,
}

pub(super) const FAR: Limits = Limits { effects: MOST_EFFECTS, rounds: 24, pieces: true };
/// Where something remains all the same: of what a fifth effect and further ones explain, much is what the catalogue does not have.
pub(super) const NEAR_BY: Limits = Limits { effects: 4, rounds: 6, pieces: false };
/// Probability, all that is tried counted, below which a gain is no chance.
pub(super) const CHANCE: f64 = 1e-4;
/// Candidates that are refitted with their shapes free in a round.
const REFINED: usize = 12;
/// Refined are those whose screening gain is at least this part of the best: the shapes of the screening are coarse.
const NEAR: f64 = 0.5;
/// The same where parts of the data may refuse the best: what stands after it must have been refined, too.
const NEAR_BEHIND_REFUSED: f64 = 0.15;
/// The same where an effect is put in doubt, which was refined before.
const NEAR_IN_DOUBT: f64 = 0.85;
/// Gain in 2 ln L that a wider form of an effect must promise beyond the plain one to be refitted.
const WIDER: f64 = 2.0;
/// Gain in 2 ln L, with the noise fitted anew on both sides, below which an effect is not believed.
pub(super) const LEAST_GAIN: f64 = 15.0;

pub(in crate::diagnose) struct Search<'a> {
    pub(in crate::diagnose) problem: &'a Problem,
    pub(in crate::diagnose) candidates: &'a [Candidate],
    pub(in crate::diagnose) known: usize,
    pub(in crate::diagnose) price: f64,
    pub(super) tried: f64,
    pub(in crate::diagnose) kept: ScreeningCache,
    /// Effects that may be tried; all where `None`.
    pub(in crate::diagnose) only: Option<fn(&str) -> bool>,
    /// Where it ends.
    pub(in crate::diagnose) limits: Limits,
    /// Joints on which forms with more freedom are tried, too.
    pub(super) wider: &'a [usize],
}

/// What a refinement is for.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::diagnose) struct RefineRequest<'a> {
    /// What stood there before: it is refined, too.
    pub(in crate::diagnose) also: Option<&'a [EffectInstance]>,
    /// The cost that is to be reached; else what the screening promises of the best.
    pub(in crate::diagnose) aim: Option<f64>,
    /// Nothing is refined of which the screening promises less than this share of what stands between the others, refitted to
    /// first order, and this cost.
    pub(in crate::diagnose) promise: Option<(f64, f64)>,
    /// Effects that are not asked for: themselves, on their own targets.
    pub(in crate::diagnose) but: &'a [(&'static str, String)],
}

/// An effect, its target, and the instances with first values.
type Trial = (&'static str, String, Vec<EffectInstance>);

impl Search<'_> {
    /// Screens and refines; the refined candidates, best first.
    pub(in crate::diagnose) fn refine(
        &mut self,
        base: &Fit,
        whitening: &Whitening,
        asked: &RefineRequest,
    ) -> Vec<Refined> {
        let p = self.problem;
        let sensitivities = Sensitivities::new(p, &base.hypothesis, &base.state, &base.free, whitening);
        let context = ScreeningContext::new(p, &base.hypothesis, &base.state, whitening, sensitivities.to_columns());
        let mut spectral = if self.only.is_some() { Vec::new() } else { context.spectral() };
        let in_need = spectral.iter().filter(|c| c.axis().is_some_and(|a| self.wider.contains(&a)));
        let fading: Vec<Candidate> = in_need.flat_map(|c| candidates::fading(p, c)).collect();
        self.tried = (self.candidates.len() + fading.len()) as f64 + spectrum::tried(&context);
        spectral.extend(fading);
        let mut scored: Vec<(Score, &Candidate)> =
            self.kept.score(&context, self.candidates).into_iter().zip(self.candidates).collect();
        let more: Vec<Score> = context.score_all(&spectral);
        scored.extend(more.into_iter().zip(&spectral));
        let only = self.only;
        let asked_for =
            |c: &Candidate| !asked.but.iter().any(|(effect, target)| c.effect == *effect && c.target == *target);
        scored.retain(|(s, c)| s.gain > 0.0 && only.is_none_or(|f| f(c.effect)) && asked_for(c));
        let merit = |s: &Score, c: &Candidate| s.gain - self.price * c.parameters() as f64;
        scored.sort_by(|(a, ca), (b, cb)| merit(b, cb).total_cmp(&merit(a, ca)));
        let best = scored.first().map_or(0.0, |s| s.0.gain);
        let promised =
            asked.promise.map_or(0.0, |(share, cost)| share * (dot(&context.residual, &context.residual) - cost));
        if best < promised {
            return Vec::new();
        }
        let aim = asked.aim.unwrap_or(base.cost - best);
        let trials = self.trials(&scored, (best, promised), asked);
        let mut refined: Vec<Refined> = parallel::of_each(trials, |(effect, target, placed)| {
            let mut h = base.hypothesis.clone();
            let mut free = base.free.clone();
            let bounds: Vec<EffectInstance> = placed.iter().map(|q| fit::inside(q, p)).collect();
            for q in bounds {
                free.push(h.effects.len());
                h.effects.push(q);
            }
            let fit = fit::refit_near(p, &h, &free, whitening, &sensitivities, aim);
            let placed: Vec<EffectInstance> = fit.hypothesis.effects[base.hypothesis.effects.len()..].to_vec();
            let parameters = placed.iter().map(|q| q.effect.values().len()).sum();
            Refined { effect, target, gain: base.cost - fit.cost, parameters, placed, fit }
        });
        refined.sort_by(|a, b| b.merit(self.price).total_cmp(&a.merit(self.price)));
        refined.retain(|r| precise::determined(p, r) && across::agrees(p, r, whitening));
        refined.retain(|r| r.placed.iter().all(|q| spectrum::is_seen(p, q) && is_seen_as_step(p, r, q)));
        // a gap that is the same at every knot is a plain gap, however exact the log
        let plain: Vec<String> = refined.iter().filter(|r| r.effect == PLAIN).map(|r| r.target.clone()).collect();
        refined.retain(|r| !(r.is_flat() && plain.contains(&r.target)));
        let mut seen: Vec<(&str, String)> = Vec::new();
        refined.retain(|r| {
            let key = (r.effect, r.target.clone());
            let new = !seen.contains(&key);
            seen.push(key);
            new
        });
        refined
    }

    /// Which candidates are refined, and from which values: of every effect on every target the best shape, of gaps over
    /// position the best number of knots; also what stood there before. `best` is the largest gain of the screening, `least` that
    /// which must be promised.
    fn trials(&self, scored: &[(Score, &Candidate)], (best, least): (f64, f64), asked: &RefineRequest) -> Vec<Trial> {
        let p = self.problem;
        let near = match asked.also {
            Some(_) => NEAR_IN_DOUBT,
            None if p.logs.len() > 1 || p.recording() == Recording::JointSensors => NEAR_BEHIND_REFUSED,
            None => NEAR,
        };
        let mut picked: Vec<&(Score, &Candidate)> = Vec::new();
        for s in scored {
            let again =
                picked.iter().any(|q| q.1.effect == s.1.effect && q.1.target == s.1.target && q.1.form == s.1.form);
            if !again && picked.len() < REFINED && s.0.gain > near * best && s.0.gain >= least {
                picked.push(s);
            }
        }
        // a gap over position or speed that promises no more than the same gap everywhere is that gap
        let promised = |target: &str| picked.iter().find(|s| s.1.effect == PLAIN && s.1.target == target);
        let plain: Vec<(String, f64)> =
            picked.iter().filter_map(|s| promised(&s.1.target)).map(|s| (s.1.target.clone(), s.0.gain)).collect();
        picked.retain(|(s, c)| {
            !catalogue::find(c.effect).is_some_and(|e| e.special.includes.contains(&PLAIN))
                || !plain.iter().any(|(target, gain)| *target == c.target && s.gain < gain + WIDER)
        });
        let mut trials: Vec<Trial> = picked
            .iter()
            .map(|(s, c)| (c.effect, c.target.clone(), c.at(&s.coefficients)))
            .filter(|t| !t.2.is_empty())
            .collect();
        if let Some(also) = asked.also
            && let Some(first) = also.first()
        {
            trials.push((first.effect.name(), first.target_text(&p.robot), also.to_vec()));
            if let Some(gap) = flat(&first.effect) {
                let plain = EffectInstance::new(first.target, Backlash::constant(gap));
                trials.retain(|t| t.0 != PLAIN || t.1 != first.target_text(&p.robot));
                trials.push((PLAIN, first.target_text(&p.robot), vec![plain]));
            }
        }
        trials
    }

    /// Rounds until nothing more is believed; where nothing remains, the simpler of two explanations of the same, and rounds
    /// again. Returns the test without the catalogue, what the limit of effects left out, and what remains unexplained.
    pub(in crate::diagnose) fn rounds_and_merge(
        &mut self,
        fit: &mut Fit,
        whitening: &mut Whitening,
        steps: &mut Vec<Step>,
        groups: &[BasisGroup],
        left: &dyn Fn(&Tested, &Fit) -> Option<Ratio>,
    ) -> (Tested, Option<Next>, Option<Ratio>) {
        let next = self.rounds(fit, whitening, steps, groups);
        let structure = freed::tested(self.problem, fit, groups);
        let remains = left(&structure, fit);
        if remains.is_none()
            && let Some(simpler) = self.merge(fit, whitening, steps)
        {
            *fit = simpler;
            let next = self.rounds(fit, whitening, steps, groups);
            let structure = freed::tested(self.problem, fit, groups);
            let remains = left(&structure, fit);
            return (structure, next, remains);
        }
        (structure, next, remains)
    }

    /// Chance that the best of all that was tried gains this much.
    pub(in crate::diagnose) fn chance(&self, gain: f64, parameters: usize) -> f64 {
        let n = self.problem.n as f64;
        let d = parameters as f64;
        (self.tried * fisher::tail(gain / d, d, n)).min(1.0)
    }

    /// Is a refined candidate more than chance, also where the noise may explain what it can?
    pub(in crate::diagnose) fn believed(&self, base: &Fit, r: &Refined) -> bool {
        if self.chance(r.gain, r.parameters) > CHANCE {
            return false;
        }
        let with = Whitening::of_residual(self.problem, &r.fit.state.residual, 0).1;
        let without = Whitening::of_residual(self.problem, &base.state.residual, 0).1;
        with - without > LEAST_GAIN + r.parameters as f64
    }

    /// What an effect explains that was found before at its place; of several the smallest.
    pub(in crate::diagnose) fn repeated(&self, fit: &Fit, alternatives: &[Vec<Refined>]) -> Option<Ratio> {
        let placed = |k: usize| &fit.hypothesis.effects[fit.free[k]];
        let again = |k: &usize| alike(fit, placed(*k)) > 1;
        let ratio = |k: usize| {
            let (p, target) = (placed(k), placed(k).target_text(&self.problem.robot));
            let own = alternatives.get(k)?.iter().find(|r| r.effect == p.effect.name() && r.target == target)?;
            let p_value = self.chance(own.gain, own.parameters);
            Some(Ratio { axis: p.axis(), aspect: None, gain: own.gain, dof: own.parameters, p_value })
        };
        (0..fit.free.len()).filter(again).filter_map(ratio).min_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Rounds until nothing more is believed, or until the limit of effects: then the effect that would be next.
    pub(in crate::diagnose) fn rounds(
        &mut self,
        fit: &mut Fit,
        whitening: &mut Whitening,
        steps: &mut Vec<Step>,
        groups: &[BasisGroup],
    ) -> Option<Next> {
        loop {
            let (step, next) = self.round(fit, whitening)?;
            let in_pieces = self.limits.pieces
                && next.hypothesis.effects.last().is_some_and(|newest| alike(&next, newest) > MOST_ALIKE);
            if fit.free.len() >= self.limits.effects || steps.len() >= self.limits.rounds || in_pieces {
                let placed = next.hypothesis.effects.last()?;
                let (gain, parameters) = (fit.cost - next.cost, placed.effect.values().len());
                let p_value = self.chance(gain, parameters);
                return Some(Next {
                    effect: step.effect,
                    target: step.target,
                    axis: placed.axis(),
                    gain,
                    parameters,
                    p_value,
                });
            }
            steps.push(step);
            let settled = self.settle(next, whitening, steps);
            let settled = self.as_gaps(settled, whitening, steps);
            *fit = self.as_elements(settled, whitening, steps);
            *whitening = precise::noise_left(self.problem, fit, whitening, groups);
            *fit = fit::refit(self.problem, &fit.hypothesis, &fit.free, whitening);
        }
    }

    /// One round: the best candidate that is believed, and the fit with it.
    pub(in crate::diagnose) fn round(&mut self, fit: &Fit, whitening: &Whitening) -> Option<(Step, Fit)> {
        let refined = self.refine(fit, whitening, &RefineRequest::default());
        let supported = |r: &&Refined| supported::supported(self.problem, fit, r, whitening);
        let mut believed = refined.iter().filter(|r| self.believed(fit, r)).filter(supported).peekable();
        // where a clock offset may be lags of all joints, what is needed beside it must be needed beside them
        let lagging = believed.peek().and_then(|_| self.lagging(fit, whitening));
        let beside = |r: &&Refined| lagging.as_ref().is_none_or(|lags| self.is_beside_lags(lags, r, whitening));
        let best = believed.find(beside)?.clone();
        let step = Step::new(best.effect, best.target.clone());
        Some((step, best.fit))
    }
}

/// Is an effect of a refined fit seen as a step, if it is one?
fn is_seen_as_step(problem: &Problem, r: &Refined, placed: &EffectInstance) -> bool {
    if placed.effect.get::<TrackerFrame>().is_none() {
        return true;
    }
    let Fit { hypothesis: h, state, .. } = &r.fit;
    let step = problem.difference(h, state, &[], std::slice::from_ref(placed), 1.0);
    let with: Vec<f64> = state.residual.iter().zip(&step).map(|(r, s)| r + s).collect();
    steps::is_seen(problem, placed, &with)
}

/// Number of found effects of the same name at the same place, this one among them. A tracker may lock again at several times.
pub(super) fn alike(fit: &Fit, one: &EffectInstance) -> usize {
    let found = fit.free.iter().map(|&i| &fit.hypothesis.effects[i]);
    let when = |p: &EffectInstance| p.effect.get::<TrackerFrame>().map(|f| (f.from, f.only_log));
    found.filter(|p| p.effect.name() == one.effect.name() && p.target == one.target && when(p) == when(one)).count()
}
