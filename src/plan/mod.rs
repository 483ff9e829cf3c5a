//! Planning: the motion that tells alternatives apart, before it is run.
//!
//! A diagnosis ends with a set where its log cannot decide. Here the library of motions is evaluated with the diagnosis' own
//! engine: which of them would leave most of the wrong alternative, had the machine this fault or that one. Without a set, the
//! question is the whole catalogue: which motion shows its worst effect best.
//!
//! Modules, in the order of the work:
//! - [`question`]: alternatives, from the command line or a diagnosis; [`sizes`]: how large they are.
//! - [`path`]: commands from rest to rest within limits; [`motions`]: the library, one function per motion.
//! - [`mod@separate`]: the expected evidence of a motion for a set; [`mod@observe`]: what a motion shows of the catalogue.
//! - [`reasons`]: where nothing separates: why, and which measurement would.
//! - [`mod@note`]: what a reader of a plan should know.
//! - [`recording`]: programs to record, with the precision to expect of every gap.
//! - [`document`]: the result as it is written; [`display`]: for a terminal.
//!
//! # Example
//!
//! A sweep of the first axis of a gantry: from rest to rest, within its travel of 0 to 1 m.
//!
//! ```
//! use lostmotion::plan::{motions, path::{Envelope, EnvelopeOptions}};
//! use lostmotion::robot::Robot;
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/gantry-xyz-ballscrew.yaml"))?;
//! let options = EnvelopeOptions {
//!     pose: Some(vec![0.5, 0.4, -0.2]),
//!     duration_s: 30.0,
//!     rate_hz: 25.0,
//!     speed_m_s: 0.1,
//!     travel_rad: 0.5,
//!     travel_m: 0.2,
//! };
//! let envelope = Envelope::new(&robot, &options);
//! let rows = motions::sweep(&envelope, 0).expect("time enough");
//! assert_eq!(rows.first(), rows.last());
//! assert!(rows.iter().all(|q| (0.0..=1.0).contains(&q[0]) && q[1..] == rows[0][1..]));
//! let fastest = rows.windows(2).map(|w| (w[1][0] - w[0][0]).abs() / envelope.step_s).fold(0.0, f64::max);
//! assert!(fastest > 0.05 && fastest < 0.1 + 1e-3, "{fastest} m/s");
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod display;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod document;
pub mod motions;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod note;
pub(crate) mod observe;
pub mod path;
pub mod question;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod reasons;
pub mod recording;
pub mod separate;
pub mod sizes;

use crate::numerics::parallel::{self, ParMap};
use motions::Motion;
use observe::Seen;
use question::Set;
use reasons::With;
use separate::{DesignScore, Experiment, NEEDED};
use sizes::Scale;

/// Evidence below which a motion does not separate, however the noise falls: within it an alternative stays in the set.
pub const LEAST: f64 = crate::diagnose::search::finding::WITHIN;
/// Motions from which pairs are made.
const PAIRED: usize = 5;
/// Motions that are also held against the effects outside the set.
const LOOKED_AROUND: usize = 6;
/// Motions that are tried again with a further channel.
const TRIED_AGAIN: usize = 5;

/// A motion and its score.
#[derive(Debug, Clone)]
pub struct Judged {
    /// The motion itself.
    pub motion: Motion,
    /// How well it tells the alternatives apart.
    pub worth: DesignScore,
}

/// The answer to a question about alternatives.
#[derive(Debug, Clone)]
pub struct Separation {
    /// Best first.
    pub singles: Vec<Judged>,
    /// Two motions one after the other, where one alone does not do.
    pub pair: Option<Judged>,
    /// What further channels would give, where no motion separates.
    pub with: Vec<With>,
}

impl Separation {
    /// The proposed motion: the best, or the pair where it is needed.
    pub fn best(&self) -> Option<&Judged> {
        self.pair.as_ref().or(self.singles.first())
    }

    /// The cheapest channel that separates the set.
    pub fn channel(&self) -> Option<&With> {
        self.with.iter().find(|w| w.worth.evidence >= NEEDED)
    }
}

/// Axes that a question is about: those on which the alternatives act, all where one acts on the whole machine.
pub fn axes_of(sets: &[Set], dof: usize) -> Vec<usize> {
    let mut axes: Vec<usize> =
        sets.iter().flat_map(|s| &s.alternatives).flat_map(|r| &r.effects).filter_map(|p| p.axis()).collect();
    axes.sort_unstable();
    axes.dedup();
    axes.retain(|a| *a < dof);
    // of many only the motions of all together are of use
    if axes.len() > 2 { Vec::new() } else { axes }
}

/// Judges every motion for the sets, and pairs of them where no single one is enough.
pub fn separate(bench: &Experiment, library: Vec<Motion>, sets: &[Set]) -> Separation {
    let mut singles = parallel::of_each(library, |motion| {
        let worth = bench.worth(&motion, sets);
        Judged { motion, worth }
    });
    singles.sort_by(|a, b| b.worth.evidence.total_cmp(&a.worth.evidence));
    // of motions that are enough, the one that leaves no effect outside the set near either
    let enough = singles.iter().take(LOOKED_AROUND).filter(|j| j.worth.evidence >= NEEDED).count();
    parallel::change(&mut singles[..enough], |_, j| j.worth.outside = bench.outside(&j.motion, sets));
    singles[..enough].sort_by(|a, b| b.worth.whole().total_cmp(&a.worth.whole()));
    let best = singles.first().map_or(0.0, |j| j.worth.evidence);
    let mut answer = Separation { singles, pair: None, with: Vec::new() };
    if best < NEEDED {
        answer.pair = pair(bench, &answer.singles, sets).filter(|p| p.worth.evidence > (1.5 * best).max(LEAST));
    }
    let best = answer.best().map_or(0.0, |j| j.worth.evidence);
    if best < NEEDED {
        let motions: Vec<Motion> = answer.singles.iter().map(|j| j.motion.clone()).collect();
        answer.with = reasons::channels(bench, &motions, &tried_again(&answer.singles), sets);
    }
    answer
}

/// The best pair: the shortest that is enough, else the one with the most evidence.
fn pair(bench: &Experiment, singles: &[Judged], sets: &[Set]) -> Option<Judged> {
    // for several comparisons the motions that are best for each, else the best of all
    let mut few: Vec<usize> = (0..singles.len().min(PAIRED)).collect();
    let count = singles.first().map_or(0, |j| j.worth.comparisons.len());
    for c in 0..count {
        let of = |j: &Judged| j.worth.comparisons[c].evidence;
        if let Some(k) = (0..singles.len()).max_by(|&x, &y| of(&singles[x]).total_cmp(&of(&singles[y])).then(y.cmp(&x)))
            && !few.contains(&k)
        {
            few.push(k);
        }
    }
    let both: Vec<(usize, usize)> =
        few.iter().enumerate().flat_map(|(i, &a)| few[i + 1..].iter().map(move |&b| (a, b))).collect();
    let all = both.par_map(|&(a, b)| {
        let motion = separate::joined(&singles[a].motion, &singles[b].motion);
        let worth = bench.worth(&motion, sets);
        Judged { motion, worth }
    });
    let enough = |j: &Judged| j.worth.evidence >= NEEDED;
    let runs = |j: &Judged| j.motion.rows.len() * if j.motion.two_payloads { 2 } else { 1 };
    all.into_iter().reduce(|a, b| {
        let better = match (enough(&a), enough(&b)) {
            (true, true) => (runs(&b), a.worth.evidence) < (runs(&a), b.worth.evidence),
            (x, y) if x != y => y,
            _ => b.worth.evidence > a.worth.evidence,
        };
        if better { b } else { a }
    })
}

/// The best few, and those on which the alternatives show most.
fn tried_again(singles: &[Judged]) -> Vec<usize> {
    let mut few: Vec<usize> = (0..singles.len().min(TRIED_AGAIN - 2)).collect();
    let mut by_sight: Vec<usize> = (few.len()..singles.len()).collect();
    by_sight.sort_by(|&a, &b| singles[b].worth.visible.total_cmp(&singles[a].worth.visible));
    few.extend(by_sight.into_iter().take(TRIED_AGAIN - few.len()));
    few
}

/// A motion and what it shows of the catalogue.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The motion itself.
    pub motion: Motion,
    /// What the motion shows of each effect.
    pub seen: Vec<Seen>,
    /// The least ratio over all effects that any motion shows.
    pub worst: f64,
}

/// The answer to the question about the whole catalogue: motions (and the best pair), best first.
pub fn observe(bench: &Experiment, library: Vec<Motion>, scale: &Scale) -> Vec<Shown> {
    let show = |motion: Motion| {
        let seen = observe::seen(bench, &motion, scale);
        Shown { motion, seen, worst: 0.0 }
    };
    let mut all: Vec<Shown> = parallel::of_each(library, show);
    let singles: Vec<Motion> = all.iter().map(|s| s.motion.clone()).collect();
    let both: Vec<(usize, usize)> =
        (0..singles.len()).flat_map(|i| (i + 1..singles.len()).map(move |j| (i, j))).collect();
    rank(&mut all);
    let single = all.first().map_or(0.0, |s| s.worst);
    let mut pairs: Vec<Shown> = both.par_map(|&(a, b)| show(separate::joined(&singles[a], &singles[b])));
    let known: Vec<Vec<f64>> = all.iter().map(|s| s.seen.iter().map(|x| x.ratio).collect()).collect();
    pairs.iter_mut().for_each(|p| p.worst = worst(p, &known, &all));
    // a pair is twice as long: it has to be worth more than the same motion twice
    let best = pairs.into_iter().reduce(|a, b| if b.worst > a.worst { b } else { a });
    if let Some(best) = best.filter(|b| single < 1.0 && b.worst > 1.5 * single) {
        all.insert(0, best);
    }
    all
}

fn rank(all: &mut [Shown]) {
    let known: Vec<Vec<f64>> = all.iter().map(|s| s.seen.iter().map(|x| x.ratio).collect()).collect();
    let worsts: Vec<f64> = all.iter().map(|s| worst(s, &known, all)).collect();
    for (s, w) in all.iter_mut().zip(worsts) {
        s.worst = w;
    }
    all.sort_by(|a, b| b.worst.total_cmp(&a.worst));
}

/// The least ratio over all effects that at least one of `all` shows; what a motion does not have at all counts as 0.
fn worst(of: &Shown, ratios: &[Vec<f64>], all: &[Shown]) -> f64 {
    let mut least = f64::INFINITY;
    for (s, r) in all.iter().zip(ratios) {
        for (seen, ratio) in s.seen.iter().zip(r) {
            if *ratio > 0.0 {
                let here = of.seen.iter().find(|x| x.effect == seen.effect && x.target == seen.target);
                least = least.min(here.map_or(0.0, |x| x.ratio));
            }
        }
    }
    if least.is_finite() { least } else { 0.0 }
}
