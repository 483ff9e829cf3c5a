//! What the search ends with.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::Score;
use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::Note;
use crate::diagnose::problem::forward::{Problem, State};
use crate::diagnose::search::contradiction::Contradiction;
use crate::diagnose::search::finding::{Alternative, Next, Step};
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::geometry;
use crate::diagnose::search::slow::SlowPart;
use crate::diagnose::search::together::share::TogetherReport;
use crate::effects::Family;

/// What the search ends with.
pub struct Outcome {
    /// Logs and model that were diagnosed.
    pub problem: Problem,
    /// Everything that was tried.
    pub candidates: Vec<Candidate>,
    /// Effects that were added, in their order.
    pub steps: Vec<Step>,
    /// Fit of the last round.
    pub fit: Fit,
    /// Number of known effects: the first of the hypothesis.
    pub known: usize,
    /// Noise model of the last round.
    pub whitening: Whitening,
    /// The geometry of a real arm, found as one: the first of the free effects.
    pub group: Option<geometry::Group>,
    /// What a reader should know about the channels, and about what was not named.
    pub notes: Vec<Note>,
    /// Alternatives of each found effect, with the found one among them, best first.
    pub alternatives: Vec<Vec<Alternative>>,
    /// Sizes and nested fits where everything was fitted together.
    pub together: Option<TogetherReport>,
    /// Test of what the effects leave.
    pub structure: Tested,
    /// Structure that remains, if it is more than chance.
    pub remains: Option<Ratio>,
    /// What varies more slowly than the instrument scatters, where nothing else remains.
    pub slow: Option<SlowPart>,
    /// Gain in 2 ln L of each free effect on blocks that were not fitted, beside all the others.
    pub support: Vec<f64>,
    /// Whether the interval of a free effect's size holds zero; empty where effects stand as groups.
    pub doubtful: Vec<bool>,
    /// What a further round would have named, where the rounds ended at their limit.
    pub next: Option<Next>,
    /// Screening at the end: what is left and what would have been seen.
    pub last: Vec<Score>,
    /// Number of rows that were left out as gross errors.
    pub outliers: usize,
    /// What the logs say against what was taken as known.
    pub contradictions: Vec<Contradiction>,
    /// One effect more than the limit of effects.
    pub further: Option<Next>,
    /// rms of the residual: as given, with the frame refitted; and the largest as given.
    pub rms_given: f64,
    /// Largest residual as given, m or rad.
    pub max_given: f64,
    /// Root mean square residual with the frame refitted, m or rad.
    pub rms_nuisance: f64,
    /// rms of what the named effects leave: curves without a name may describe more of it.
    pub rms_named: f64,
    /// Prediction with the frame refitted.
    pub state_nuisance: State,
    /// Price of a parameter in 2 ln L.
    pub price: f64,
}

impl Outcome {
    /// Whether the effects of the catalogue that were found leave nothing but noise.
    pub fn explains_all(&self) -> bool {
        let found = self.fit.free.iter().map(|&i| &self.fit.hypothesis.effects[i].effect);
        let mut curves = found.filter(|e| e.info().family == Family::Empirical);
        let more = [&self.next, &self.further].iter().any(|n| n.is_some());
        self.remains.is_none() && !more && self.contradictions.is_empty() && curves.next().is_none()
    }

    /// What stays of a real arm beside its group, whatever its size, where it is more than chance.
    pub fn remains_of_arm(&self) -> Option<Ratio> {
        let tested = &self.structure;
        if !geometry::is_structured(tested) {
            return None;
        }
        let worst = tested.groups.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.gain.total_cmp(&a.gain)));
        let mut told = worst.unwrap_or(&tested.whole).clone();
        // the size is that of everything
        (told.gain, told.dof, told.p_value) = (tested.whole.gain, tested.whole.dof, tested.whole.p_value);
        Some(told)
    }
}
