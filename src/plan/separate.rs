//! How well a motion separates alternatives: the expected difference in 2 ln L between the truth and the best-fitting other.
//!
//! Method: the log that the truth would give is made without noise; the alternative is refitted to it with everything that a
//! diagnosis would refit (its shape parameters, the frame where the model has none, further found effects). What it leaves,
//! whitened by the noise, is the non-centrality: with noise the difference in 2 ln L is this much on average, with twice its
//! root as standard deviation (Cox 1961, for separate families). Both ways round, as a truth may be determined better than its
//! alternative; a narrow alternative inside a wider one is no way to be wrong about the narrow one, so only the wide truth counts.
//!
//! Assumptions: the sizes are those given; noise white, or as a diagnosis found it. How it fails: a refit that stops in a
//! local minimum promises too much; every refit starts from two screened shapes and from the alternative's own size.

use super::motions::Motion;
use super::path::Envelope;
use super::question::{Alternative, Set};
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::noise::Noise;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::problem::synthetic::{self, Channels, Run};
use crate::diagnose::search::finding::WITHIN;
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::EffectInstance;
use crate::model::Model;
use crate::numerics::normal;
use crate::robot::JointKind;

/// Expected difference from which a set is separated in 99 of 100 logs: [`named`] of it is 0.99.
pub const NEEDED: f64 = 30.0;
/// Noise of an encoder or secondary encoder: rad (1 arcsec), m.
const SENSOR_SIGMA: [f64; 2] = [5e-6, 1e-6];

/// One alternative as the truth, another refitted to its log.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Number of the set, of the truth and of the other in it.
    pub set: usize,
    /// Number of the alternative that is taken as true.
    pub truth: usize,
    /// Number of the alternative that is fitted instead.
    pub other: usize,
    /// Non-centrality.
    pub evidence: f64,
    /// The other's effects as they fit the truth best.
    pub fitted: Vec<EffectInstance>,
}

/// The score of a motion for the question.
#[derive(Debug, Clone, Default)]
pub struct DesignScore {
    /// Every pair of alternatives, both ways.
    pub comparisons: Vec<Comparison>,
    /// The least over all comparisons.
    pub evidence: f64,
    /// The least with which any alternative shows at all beside the frame.
    pub visible: f64,
    /// The effect outside the sets that comes nearest to one of the alternatives, and what it leaves; where it was looked for.
    pub outside: Option<(f64, String)>,
}

impl DesignScore {
    /// Evidence against the set's alternatives and against everything else.
    pub fn whole(&self) -> f64 {
        self.outside.as_ref().map_or(self.evidence, |o| self.evidence.min(o.0))
    }
}

/// Probability that 2 ln L is larger for the truth than for its alternative.
pub fn right(evidence: f64) -> f64 {
    normal::below(0.5 * evidence.max(0.0).sqrt())
}

/// Probability that a diagnosis names the truth alone: the alternative fits worse by more than what keeps it in the set.
pub fn named(evidence: f64) -> f64 {
    if evidence > 0.0 { normal::below((evidence - WITHIN) / (2.0 * evidence.sqrt())) } else { 0.0 }
}

/// What everything is evaluated with.
#[derive(Debug, Clone)]
pub struct Experiment<'a> {
    /// The machine as it is known.
    pub model: &'a Model,
    /// Limits of the motions.
    pub envelope: &'a Envelope<'a>,
    /// Of one coordinate of a reflector, m.
    pub noise: Noise,
    /// Mass at the flange, kg.
    pub payload_kg: f64,
    /// What is recorded.
    pub channels: Channels,
}

impl Experiment<'_> {
    /// Logs of a motion: one, or one per payload.
    pub fn problem(&self, motion: &Motion) -> (Problem, Hypothesis, Whitening) {
        let (t_s, cmd) = rows_of_log(motion, self.envelope);
        let payloads = if motion.two_payloads { vec![Some(0.0), Some(self.payload_kg)] } else { vec![None] };
        let runs =
            payloads.into_iter().map(|payload_kg| Run { t_s: t_s.clone(), cmd: cmd.clone(), payload_kg }).collect();
        let (problem, start) = synthetic::problem(self.model, runs, self.channels);
        let noise = problem.groups.iter().map(|g| match g.sensor {
            Sensor::Reflector(_) | Sensor::Reading | Sensor::Orientation => self.noise,
            Sensor::Motor(a) | Sensor::Joint(a) => {
                let revolute = self.model.robot.axis(a).kind == JointKind::Revolute;
                Noise::white(SENSOR_SIGMA[usize::from(!revolute)])
            }
        });
        let whitening = Whitening::new(&problem, noise.collect());
        (problem, start, whitening)
    }

    /// The score of a motion for all sets.
    pub fn worth(&self, motion: &Motion, sets: &[Set]) -> DesignScore {
        let (mut problem, start, whitening) = self.problem(motion);
        let candidates = candidates::all(&problem);
        let mut worth = DesignScore { evidence: f64::INFINITY, visible: f64::INFINITY, ..DesignScore::default() };
        for (number, set) in sets.iter().enumerate() {
            let mut base = start.clone();
            base.effects.extend(set.common.iter().cloned());
            let known = start.effects.len();
            for (i, truth) in set.alternatives.iter().enumerate() {
                let mut h = base.clone();
                h.effects.extend(truth.effects.iter().cloned());
                synthetic::measure(&mut problem, &h);
                let asked: Vec<usize> =
                    (0..set.alternatives.len()).filter(|&j| j != i && !nested(truth, &set.alternatives[j])).collect();
                if !truth.effects.is_empty() {
                    let nothing = Alternative { name: String::new(), effects: Vec::new() };
                    let (seen, _) = left_by(&problem, &base, known, &nothing, &candidates, &whitening);
                    worth.visible = worth.visible.min(seen);
                }
                for j in asked {
                    let (evidence, fitted) =
                        left_by(&problem, &base, known, &set.alternatives[j], &candidates, &whitening);
                    worth.evidence = worth.evidence.min(evidence);
                    worth.comparisons.push(Comparison { set: number, truth: i, other: j, evidence, fitted });
                }
            }
        }
        if worth.comparisons.is_empty() {
            worth.evidence = 0.0;
        }
        worth
    }
}

/// Effects outside a set that are refitted to every truth.
const OUTSIDE: usize = 3;

impl Experiment<'_> {
    /// The effect outside the sets that fits best what a motion would show of one of the alternatives, and what it leaves: a motion
    /// that tells two alternatives apart may confuse both with a third. Looked for where the truth is one effect.
    pub fn outside(&self, motion: &Motion, sets: &[Set]) -> Option<(f64, String)> {
        let (mut problem, start, whitening) = self.problem(motion);
        let candidates = candidates::all(&problem);
        let known = start.effects.len();
        let mut nearest: Option<(f64, String)> = None;
        for set in sets {
            let mut base = start.clone();
            base.effects.extend(set.common.iter().cloned());
            let free: Vec<usize> = (known..base.effects.len()).collect();
            for truth in set.alternatives.iter().filter(|r| r.effects.len() == 1) {
                let mut h = base.clone();
                h.effects.extend(truth.effects.iter().cloned());
                synthetic::measure(&mut problem, &h);
                let state = problem.evaluate(&base);
                let tangent = tangent(&problem, &base, &state, &free, &whitening);
                let context = ScreeningContext::new(&problem, &base, &state, &whitening, tangent);
                let inside = |c: &Candidate| {
                    set.alternatives
                        .iter()
                        .flat_map(|r| &r.effects)
                        .any(|p| p.named(&problem.robot) == (c.effect, c.target.clone()))
                };
                let mut scored: Vec<(f64, Alternative)> = context
                    .score_all(&candidates)
                    .iter()
                    .map(|s| (s, &candidates[s.candidate]))
                    .filter(|(s, c)| s.gain > 0.0 && !inside(c))
                    .map(|(s, c)| {
                        (
                            s.gain,
                            Alternative { name: format!("{} {}", c.effect, c.target), effects: c.at(&s.coefficients) },
                        )
                    })
                    .filter(|(_, r)| !r.effects.is_empty() && !nested(truth, r))
                    .collect();
                scored.sort_by(|a, b| b.0.total_cmp(&a.0));
                let mut tried: Vec<Alternative> = Vec::new();
                for (_, r) in scored {
                    if tried.len() < OUTSIDE && !tried.iter().any(|t| t.name == r.name) {
                        tried.push(r);
                    }
                }
                for mut r in tried {
                    r.effects = r.effects.into_iter().map(|p| self::inside(p, &problem)).collect();
                    let (left, _) = left_by(&problem, &base, known, &r, &[], &whitening);
                    if nearest.as_ref().is_none_or(|n| left < n.0) {
                        nearest = Some((left, format!("{} for {}", r.name, truth.name)));
                    }
                }
            }
        }
        nearest
    }
}

/// Is every log of `narrow` one of `wide`, too?
pub fn nested(narrow: &Alternative, wide: &Alternative) -> bool {
    let key = |p: &EffectInstance| (p.effect.name(), p.target);
    if narrow.effects.len() < wide.effects.len() {
        let mut rest: Vec<_> = wide.effects.iter().map(key).collect();
        return narrow.effects.iter().all(|p| {
            let at = rest.iter().position(|r| *r == key(p));
            at.map(|k| rest.remove(k)).is_some()
        });
    }
    match (narrow.effects.as_slice(), wide.effects.as_slice()) {
        ([a], [b]) if a.target == b.target => b.effect.info().special.includes.contains(&a.effect.name()),
        _ => false,
    }
}

/// What the best fit of an alternative leaves of the measurements, whitened and squared, and the alternative's effects there.
fn left_by(
    problem: &Problem,
    base: &Hypothesis,
    known: usize,
    alternative: &Alternative,
    candidates: &[Candidate],
    whitening: &Whitening,
) -> (f64, Vec<EffectInstance>) {
    let from = base.effects.len();
    let mut starts = vec![alternative.effects.clone()];
    for rank in 0..2 {
        if let Some(found) = screened(problem, base, known, alternative, candidates, whitening, rank) {
            starts.push(found);
        }
    }
    let mut best: Option<Fit> = None;
    for effects in starts {
        let mut h = base.clone();
        h.effects.extend(effects);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        let fit = fit::refit(problem, &h, &free, whitening);
        if best.as_ref().is_none_or(|b| fit.cost < b.cost) {
            best = Some(fit);
        }
        if alternative.effects.is_empty() {
            break;
        }
    }
    match best {
        Some(fit) => (fit.cost, fit.hypothesis.effects[from..].to_vec()),
        None => (0.0, Vec::new()),
    }
}

/// An alternative with the shapes that screening likes best (`rank` 0) or next to best for its first effect.
fn screened(
    problem: &Problem,
    base: &Hypothesis,
    known: usize,
    alternative: &Alternative,
    candidates: &[Candidate],
    whitening: &Whitening,
    rank: usize,
) -> Option<Vec<EffectInstance>> {
    let from = base.effects.len();
    let mut h = base.clone();
    for (k, wanted) in alternative.effects.iter().enumerate() {
        let name = wanted.named(&problem.robot);
        let state = problem.evaluate(&h);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        let tangent = tangent(problem, &h, &state, &free, whitening);
        let context = ScreeningContext::new(problem, &h, &state, whitening, tangent);
        if dot(&context.residual, &context.residual) == 0.0 {
            return None;
        }
        // what has a phase has a frequency, which a spectrum finds
        let spectral = if wanted.effect.phase().is_some() { context.spectral() } else { Vec::new() };
        let mut scored: Vec<(f64, Vec<EffectInstance>)> = candidates
            .iter()
            .chain(&spectral)
            .filter(|c| c.effect == name.0 && c.target == name.1)
            .map(|c| {
                let s = context.score(0, c);
                (s.gain, c.at(&s.coefficients))
            })
            .filter(|(gain, placed)| *gain > 0.0 && !placed.is_empty())
            .collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        let pick = if k == 0 { rank } else { 0 };
        let (_, placed) = scored.into_iter().nth(pick)?;
        h.effects.extend(placed.into_iter().map(|p| inside(p, problem)));
    }
    Some(h.effects[from..].to_vec())
}

fn inside(placed: EffectInstance, problem: &Problem) -> EffectInstance {
    let bounds = placed.bounds(&problem.robot);
    let values: Vec<f64> = placed.effect.values().iter().zip(bounds).map(|(v, (lo, hi))| v.clamp(lo, hi)).collect();
    EffectInstance { target: placed.target, effect: placed.effect.with_values(&values) }
}

/// Times and commands `[axis][row]` at which a tracker of the envelope's rate sees the motion: straight between the program's rows.
pub fn rows_of_log(motion: &Motion, envelope: &Envelope) -> (Vec<f64>, Vec<Vec<f64>>) {
    let last = motion.rows.len() - 1;
    let duration_s = last as f64 * envelope.step_s;
    let count = (duration_s * envelope.rate_hz + 1e-6).floor() as usize + 1;
    let t_s: Vec<f64> = (0..count).map(|i| i as f64 / envelope.rate_hz).collect();
    let cmd = (0..envelope.pose.len())
        .map(|axis| {
            t_s.iter()
                .map(|t| {
                    let x = t / envelope.step_s;
                    let i = ((x + 1e-6) as usize).min(last);
                    let (from, share) = (motion.rows[i][axis], x - i as f64);
                    match motion.rows.get(i + 1) {
                        Some(next) if share > 1e-6 => from + share * (next[axis] - from),
                        _ => from,
                    }
                })
                .collect()
        })
        .collect();
    (t_s, cmd)
}

/// Two motions one after the other, in one program.
pub fn joined(a: &Motion, b: &Motion) -> Motion {
    let rows = a.rows.iter().chain(b.rows.iter().skip(1)).cloned().collect();
    Motion {
        name: format!("{}, then {}", a.name, b.name),
        does: format!("{}; then {}", a.does, b.does),
        rows,
        two_payloads: a.two_payloads || b.two_payloads,
    }
}
