//! What the search holds between its steps: from the first finds to what stays unexplained.

use crate::diagnose::candidates::structure::{Ratio, Tested};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::Note;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::contradiction::{self, Contradiction};
use crate::diagnose::search::finding::{Next, Refined, Step};
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::prepared::Prepared;
use crate::diagnose::search::{Limits, Search, direction, freed, geometry, precise, remaining};

/// What the search holds between its steps.
pub(in crate::diagnose) struct SearchState {
    pub(in crate::diagnose) fit: Fit,
    pub(in crate::diagnose) whitening: Whitening,
    pub(in crate::diagnose) steps: Vec<Step>,
    pub(in crate::diagnose) notes: Vec<Note>,
    /// The geometry of a real arm, found as one.
    pub(in crate::diagnose) group: Option<geometry::Group>,
    /// Gaps that settled poses show by the side of the approach.
    pub(in crate::diagnose) gaps: direction::Terms,
    pub(in crate::diagnose) structure: Tested,
    pub(in crate::diagnose) next: Option<Next>,
    pub(in crate::diagnose) remains: Option<Ratio>,
}

/// A course at its end.
pub(in crate::diagnose) struct End {
    pub(in crate::diagnose) course: SearchState,
    pub(in crate::diagnose) alternatives: Vec<Vec<Refined>>,
    /// One effect more than the limit.
    pub(in crate::diagnose) further: Option<Next>,
    pub(in crate::diagnose) contradictions: Vec<Contradiction>,
}

impl End {
    /// Whether there are more effects than these limits allow.
    pub(in crate::diagnose) fn is_beyond(&self, limits: Limits) -> bool {
        self.course.group.is_none() && self.course.fit.free.len() > limits.effects
    }

    /// Whether the effects leave nothing but noise.
    pub(in crate::diagnose) fn explains_all(&self) -> bool {
        let more = [&self.course.next, &self.further].iter().any(|n| n.is_some());
        self.course.remains.is_none() && !more && self.contradictions.is_empty()
    }
}

impl SearchState {
    /// What could replace each found effect. Where one has replaced another, what is left has changed: rounds again.
    fn alternatives(&mut self, search: &mut Search, prepared: &Prepared, rms_nuisance: f64) -> Vec<Vec<Refined>> {
        if let Some(group) = &self.group {
            return search.alternatives_beside_geometry(group, &self.fit, &self.gaps.terms, &self.whitening);
        }
        let Self { fit, whitening, steps, .. } = self;
        let (mut alternatives, exchanged) = search.exchange(fit, whitening, steps);
        if !exchanged {
            search.side_by_side(fit, whitening, &mut alternatives);
            return alternatives;
        }
        *whitening = precise::noise_left(search.problem, fit, whitening, &prepared.groups);
        *fit = fit::refit(search.problem, &fit.hypothesis, &fit.free, whitening);
        self.next = search.rounds(fit, whitening, steps, &prepared.groups);
        self.structure = freed::tested(search.problem, fit, &prepared.groups);
        self.remains = remaining::remaining(
            search.problem,
            &self.structure,
            (&prepared.free, &prepared.groups),
            fit,
            rms_nuisance,
        );
        let mut alternatives = search.exchange(fit, whitening, steps).0;
        search.side_by_side(fit, whitening, &mut alternatives);
        alternatives
    }

    /// What stays unexplained: an effect that the limit of effects left out, a contradiction to what is known, one effect found
    /// several times on one joint. Returns one effect more than the limit, and the contradictions.
    fn remaining(&mut self, search: &Search, alternatives: &[Vec<Refined>]) -> (Option<Next>, Vec<Contradiction>) {
        let (problem, known) = (search.problem, search.known);
        let next = self.next.take().filter(|_| self.remains.is_none());
        let (next, further) = remaining::beyond_limit(next, &self.fit, search.limits.effects, &mut self.notes);
        if let Some(n) = &next {
            self.remains =
                Some(Ratio { axis: n.axis, aspect: None, gain: n.gain, dof: n.parameters, p_value: n.p_value });
        }
        self.next = next;
        let contradictions = contradiction::find(problem, &self.fit, known);
        if self.group.is_none()
            && let Some(first) = contradictions.first()
        {
            self.remains = Some(first.ratio.clone());
        }
        self.notes.extend(contradiction::registration(problem, &self.fit, known));
        // one effect found several times on one joint is a shape taken to pieces
        if self.group.is_none() && self.remains.is_none() {
            self.remains = search.repeated(&self.fit, alternatives);
        }
        (further, contradictions)
    }
}

impl Search<'_> {
    /// The search to its end, within its limits.
    pub(in crate::diagnose) fn course(&mut self, prepared: &Prepared, rms_nuisance: f64) -> End {
        let mut course = self.find(prepared, rms_nuisance);
        self.only_determined(&mut course, prepared, rms_nuisance);
        let mut alternatives = course.alternatives(self, prepared, rms_nuisance);
        if self.only_determined(&mut course, prepared, rms_nuisance) {
            alternatives = self.exchange(&mut course.fit, &course.whitening, &mut course.steps).0;
        }
        let (further, contradictions) = course.remaining(self, &alternatives);
        End { course, alternatives, further, contradictions }
    }

    /// Geometry as one group where settled poses of a real arm show it, else rounds until nothing more is believed.
    fn find(&mut self, prepared: &Prepared, rms_nuisance: f64) -> SearchState {
        let Prepared { groups, free, recording, .. } = prepared;
        let (mut fit, mut whitening) = (prepared.fit.clone(), prepared.whitening.clone());
        let mut steps: Vec<Step> = Vec::new();
        let mut notes = self.problem.notes.clone();
        let mut group = None;
        let mut gaps = direction::Terms::default();
        if *recording == Recording::SettledPoses
            && let Some((found, next)) = self.geometry(&fit, &whitening)
        {
            steps.extend(self.steps_of(&next, &found));
            group = Some(found);
            fit = self.arm(next, &mut whitening, &mut steps, &mut gaps, &mut notes);
        }
        let (structure, next, remains) = match &group {
            Some(_) => (freed::tested(self.problem, &fit, groups), None, None),
            None => {
                let problem = self.problem;
                let left = |structure: &Tested, fit: &Fit| {
                    remaining::remaining(problem, structure, (free, groups), fit, rms_nuisance)
                };
                self.rounds_and_merge(&mut fit, &mut whitening, &mut steps, groups, &left)
            }
        };
        // of joint sensors a misfit stays, and effects stand out of it by their shape
        if let Some(r) = remains.as_ref().filter(|_| *recording != Recording::JointSensors) {
            fit = self.without_substitutes(fit, r, &whitening, &mut steps);
        }
        // the noise of what is left: that of the freed residual is a little too small for a test
        whitening = precise::noise_left(self.problem, &fit, &whitening, groups);
        SearchState { fit, whitening, steps, notes, group, gaps, structure, next, remains }
    }
}
