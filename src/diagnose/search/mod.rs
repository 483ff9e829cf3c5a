//! The rounds: screen, refine, accept, swap, drop, until nothing is missing.
//!
//! Method: a round screens every candidate by linear algebra, refits the best of them with their shapes free and
//! everything else again, and takes the one with the best BIC if its gain cannot be chance among all that was tried.
//! Then every found effect is put in doubt: taken out, replaced by whatever explains its part best, kept only if it is
//! still needed. The search is greedy with swaps; it ends at [`MOST_EFFECTS`] effects,
//! and where something remains then, it is made again with four.
//!
//! Files beside:
//! - `across`: one machine, several logs: an effect has one size in all of them, and one lag of all joints looks like a clock
//!   offset
//! - `arm`: the rounds of settled poses of a real arm: its geometry as one group, gravity, a gap
//!   (`crate::diagnose::search::geometry` has the reasons)
//! - `contradiction`: what is taken as known put in doubt: one frame for all logs, the model's registration, the sizes of its
//!   own effects
//! - `course`: what the search holds between its steps: the first finds, and what stays unexplained
//! - `determined`: found effects that the logs do not determine, or that data which were not fitted do not support, go
//! - `direction`: gaps from settled poses: an error that depends on the side of the approach
//! - `elements`: several lost motions of one joint as the elements of one
//! - `finding`: what the search is made of on its way: refined candidates, alternatives, accepted effects
//! - `fit`: generalised least squares over the whole chain: all found effects and the nuisance (frames, sensor zeros) refitted
//!   together
//! - `freed`: the residual freed of the whole catalogue-free basis: its noise, and the test whether structure is left
//! - `geometry`: settled poses of a real arm: the geometry as one group, gravity, and gaps beside the misfit that stays
//! - `lagging`: a clock offset and lags of all joints by one time: what the one leaves of the other is no effect
//! - `outcome`: what the search ends with
//! - `precise`: joint sensors measure so precisely that a misfit stays: noise and slow ripple beside it
//! - `prepared`: what the rounds begin with: outliers gone, the nuisances fitted, the noise of the residual freed of all
//!   structure
//! - `remaining`: is there structure that remains beyond what was found?
//! - `alternative`: what stands beside an effect whose size may be zero
//! - `rounds`: one round after the other: screening, refining, accepting
//! - `sandwich`: uncertainties under misfit, from the scatter between parts of the logs and between logs
//! - `side_by_side`: gaps of joints that reverse together, in the one reading of a ballbar or a dial
//! - `slow`: what varies more slowly than the instrument scatters, which the noise model may hold for wander
//! - `story`: the found effects one by one: what each leaves, and what it leaves of data that it was not fitted to
//! - `supported`: effects of joint sensors must lessen what is left of blocks that were not fitted
//! - `together`: everything at once: the whole catalogue fitted together under weak priors, for machines on which everything is
//!   wrong
//! - `unnamed`: structure that no effect names, as curves: `empirical` terms, as few and as smooth as held-out blocks support
//! - `wider`: the search again with forms that have more freedom, where the plain ones leave something

pub(crate) mod across;
pub(crate) mod alternative;
pub(crate) mod arm;
pub(crate) mod contradiction;
pub(crate) mod course;
pub(crate) mod determined;
pub(crate) mod direction;
pub(crate) mod doubt;
pub(crate) mod elements;
pub(crate) mod finding;
pub mod fit;
pub(crate) mod freed;
pub(crate) mod geometry;
pub(crate) mod lagging;
pub(crate) mod outcome;
pub(crate) mod precise;
pub(crate) mod prepared;
pub(crate) mod remaining;
mod rounds;
pub(crate) mod sandwich;
pub(crate) mod side_by_side;
pub(crate) mod slow;
pub(crate) mod story;
pub(crate) mod supported;
pub(crate) mod together;
pub(crate) mod unnamed;
pub(crate) mod wider;

use crate::diagnose::candidates::cache::ScreeningCache;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::course::{End, SearchState};
use crate::diagnose::search::finding::Alternative;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::search::prepared::Prepared;
pub use rounds::MOST_EFFECTS;
use rounds::{FAR, NEAR_BY};
pub(in crate::diagnose) use rounds::{Limits, RefineRequest, Search};

/// Runs the rounds from a hypothesis of known effects.
pub fn run(mut problem: Problem, start: Hypothesis) -> Outcome {
    let known = start.effects.len();
    let prepared = Prepared::new(&mut problem, start);
    let rms_nuisance = rms(&problem, &prepared.fit.state.residual);
    let price = (problem.n as f64).ln().min(8.0);
    let mut search = Search {
        problem: &problem,
        candidates: &prepared.candidates,
        known,
        price,
        tried: prepared.candidates.len() as f64,
        kept: ScreeningCache::default(),
        only: None,
        limits: FAR,
        wider: &[],
    };
    let mut end = search.course(&prepared, rms_nuisance);
    if let Some(whole) = search.with_wider_forms(&prepared, rms_nuisance, &end) {
        end = whole;
    }
    if end.is_beyond(NEAR_BY) && !end.explains_all() {
        search.limits = NEAR_BY;
        end = search.course(&prepared, rms_nuisance);
    }
    let End { course, alternatives, further, contradictions } = end;
    let mut alternatives: Vec<Vec<Alternative>> =
        alternatives.iter().map(|all| all.iter().map(Alternative::from).collect()).collect();
    let rms_named = rms(&problem, &course.fit.state.residual);
    let SearchState { mut fit, mut whitening, mut steps, notes, group, structure, next, remains, .. } = course;
    let structured = remains.is_some() || group.is_some() && geometry::is_structured(&structure);
    if structured && contradictions.is_empty() {
        let known = group.is_none().then_some(known);
        (fit, whitening) = unnamed::conclude(&problem, fit, whitening, known, &mut alternatives, &mut steps);
    }
    // one list for each effect, whatever took whose place
    alternatives.resize(fit.free.len(), Vec::new());
    sandwich::widen(&problem, &mut fit, &whitening);
    let motion = prepared.recording != Recording::JointSensors && remains.is_none() && group.is_none();
    let slow = motion.then(|| slow::beside_instrument(&problem, &fit, &structure)).flatten();
    let support = determined::support(&problem, &fit, &whitening);
    // the geometry of an arm is one name
    let together = group.as_ref().map_or(0, |g| g.count);
    let mut doubtful = determined::doubtful(&problem, &fit);
    doubtful.iter_mut().take(together).for_each(|d| *d = false);
    alternative::beside(&problem, &fit, &whitening, (&prepared.candidates, price), &doubtful, &mut alternatives);
    unnamed::with_intervals(&problem, &mut fit);
    let context = fit.screening(&problem, &whitening);
    let last = search.kept.score(&context, &prepared.candidates);
    let Prepared { fit: first, candidates, outliers, rms_given, max_given, .. } = prepared;
    Outcome {
        together: None,
        candidates,
        steps,
        fit,
        known,
        whitening,
        group,
        notes,
        alternatives,
        structure,
        remains,
        slow,
        support,
        doubtful,
        next,
        last,
        outliers,
        contradictions,
        further,
        rms_given,
        max_given,
        rms_nuisance,
        rms_named,
        state_nuisance: first.state,
        price,
        problem,
    }
}
