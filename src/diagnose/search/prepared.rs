//! What the rounds begin with: outliers gone, the nuisances fitted, the noise of the residual freed of all structure.

use crate::diagnose::candidates::basis::BasisGroup;
use crate::diagnose::candidates::structure::{self, Tested};
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::prepare;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::problem::residual::{largest, rms};
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::{freed, geometry};

/// The problem without outliers, the fit of the nuisances, and the noise under which the rounds begin.
pub(in crate::diagnose) struct Prepared {
    pub(in crate::diagnose) fit: Fit,
    pub(in crate::diagnose) whitening: Whitening,
    /// The residual freed of the whole basis.
    pub(in crate::diagnose) free: Tested,
    pub(in crate::diagnose) groups: Vec<BasisGroup>,
    pub(in crate::diagnose) candidates: Vec<Candidate>,
    pub(in crate::diagnose) recording: Recording,
    pub(in crate::diagnose) outliers: usize,
    pub(in crate::diagnose) rms_given: f64,
    pub(in crate::diagnose) max_given: f64,
}

impl Prepared {
    pub(in crate::diagnose) fn new(problem: &mut Problem, start: Hypothesis) -> Self {
        let state = problem.evaluate(&start);
        let (rms_given, max_given) = (rms(problem, &state.residual), largest(problem, &state.residual));
        let mut outliers = prepare::drop_spikes(problem, &state);
        let white = |problem: &Problem, h: &Hypothesis| Whitening::white(problem, &problem.evaluate(h).residual);
        let mut fit = fit::refit(problem, &start, &[], &white(problem, &start));
        let recording = problem.recording();
        outliers += if recording == Recording::SettledPoses {
            let noise = |p: &Problem, f: &Fit| Whitening::of_residual(p, &f.state.residual, 0).0;
            geometry::drop_gross(problem, &fit.hypothesis, &noise)
        } else {
            prepare::poses_without_outliers(problem, &fit.state)
        };
        let h = fit.hypothesis.clone();
        fit = fit::refit(problem, &h, &[], &white(problem, &h));
        let mut candidates = candidates::all(problem);
        if recording == Recording::SettledPoses {
            candidates.extend(geometry::further(problem));
        }
        let mut groups = structure::basis(problem, &h, &fit.state, &candidates);
        let (mut whitening, mut free) = freed::first_noise(problem, &fit, &white(problem, &h), &groups);
        let single = prepare::drop_single(problem, &free.freed);
        if single > 0 {
            outliers += single;
            fit = fit::refit(problem, &h, &[], &white(problem, &h));
            groups = structure::basis(problem, &h, &fit.state, &candidates);
            // hardly anything has changed: one turn from the noise that is known
            (whitening, free) =
                freed::noise_of_freed(problem, &fit, &Whitening::new(problem, whitening.noise), &groups);
        }
        fit = fit::refit(problem, &fit.hypothesis, &[], &whitening);
        Self { fit, whitening, free, groups, candidates, recording, outliers, rms_given, max_given }
    }
}
