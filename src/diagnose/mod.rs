//! Diagnosis: a model and logs in; where they disagree, which effect is missing, how sure, and the model with it, out.
//!
//! The form is detection, identification, adaptation (Baarda's data snooping, Teunissen's DIA): every effect of the
//! catalogue is a hypothesis about the residual, compared by generalised least squares under coloured noise; what is found
//! goes into the model, everything is fitted again, until a test without the catalogue sees no structure.
//!
//! Rooms, in the order of the work:
//! - [`prepare`]: logs to a problem: observations, frames, samples that cannot be trusted; [`layout`] is their long vector.
//! - [`sensors`]: what drives the gears where the log has encoders.
//! - [`forward`]: the chain evaluated for a hypothesis; signatures of its parameters; `nuisance`: those of frames and zeros.
//! - [`noise`]: white and coloured noise of a sensor; [`whitening`]: that of all; [`signatures`]: whitened derivatives, kept while they
//!   hold; [`normal`]: their products; [`fit`]: the refit of everything.
//! - [`candidates`], [`spectrum`]: what may be missing; [`screen`]: what each would explain; `kept`: that, again and again.
//! - [`geometry`]: settled poses: the geometry as one group; [`direction`]: gaps beside the misfit of a real arm; `arm`: its rounds;
//!   `precise`: joint sensors beside a misfit.
//! - [`structure`]: the test without the catalogue.
//! - [`across`]: what several logs agree about.
//! - [`search`]: the rounds; [`outcome`]: what they end with; `doubt`: found effects taken out, exchanged, merged; [`contradiction`]: what is taken as known in doubt; [`story`]: the found effects told one by one, and on held-out parts.
//! - [`together`]: machines on which everything is wrong, fitted as a whole: groups, members by held-out blocks, the story by micrometres.
//! - [`synthetic`]: a problem of commands alone, for planning an experiment.
//! - [`verdict`]: sets, remaining structure, blind spots; [`document`]: the result as it is written, `round` a found effect of it; [`display`]: for a
//!   terminal; [`traces`]: for a page; [`words`]: for both.

pub mod across;
mod arm;
pub mod candidates;
pub mod contradiction;
pub mod direction;
pub mod display;
pub mod document;
mod doubt;
pub mod fit;
pub mod forward;
pub mod geometry;
mod kept;
pub mod layout;
pub mod noise;
pub mod normal;
mod nuisance;
pub mod outcome;
mod precise;
pub mod prepare;
mod round;
pub mod screen;
pub mod search;
pub mod sensors;
pub mod signatures;
pub mod spectrum;
pub mod story;
pub mod structure;
pub mod synthetic;
pub mod together;
pub mod traces;
pub mod verdict;
pub mod whitening;
pub mod words;

use crate::error::Result;
use crate::log::Log;
use crate::model::Model;
pub use document::Diagnosis;
pub use outcome::Outcome;
pub use verdict::Verdict;

/// Diagnoses logs of one machine against its model: the outcome of the search, from which [`document::of`] makes the
/// document and [`model_with`] the model.
///
/// Logs have been through [`crate::log::hygiene`]. Errors: no measured column, or points from which no frame follows.
pub fn diagnose(model: &Model, logs: &[Log]) -> Result<Outcome> {
    let (problem, start) = prepare::problem(model, logs)?;
    if together::triage::many(model, logs)
        && let Some(many) = together::outcome::of_many(problem.copy(), start.clone())
    {
        return Ok(many);
    }
    Ok(search::run(problem, start))
}

/// The model with what was found inside, and the estimated frame.
pub fn model_with(model: &Model, outcome: &Outcome) -> Model {
    let mut found = model.clone();
    found.effects = outcome.fit.hypothesis.effects.clone();
    if outcome.problem.groups.iter().any(|g| g.dims == 3) {
        // of several stations of the tracker none is the next log's
        found.registration = match outcome.fit.hypothesis.frames.as_slice() {
            [frame] => Some(*frame),
            _ => None,
        };
        for (p, d) in found.robot.reflectors_m.iter_mut().zip(&outcome.fit.hypothesis.points_m) {
            *p += d;
        }
    }
    found
}
