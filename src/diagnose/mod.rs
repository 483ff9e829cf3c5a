//! Diagnosis: a model and logs in; where they disagree, which effect is missing, how sure, and the model with it, out.
//!
//! The form is detection, identification, adaptation (Baarda's data snooping, Teunissen's DIA): every effect of the
//! catalogue is a hypothesis about the residual, compared by generalised least squares under coloured noise; what is found
//! goes into the model, everything is fitted again, until a test without the catalogue sees no structure.
//!
//! Modules, in the order of the work; none imports one that stands after it:
//! - [`mod@note`]: what a reader should know.
//! - [`problem`]: observations and the chain that predicts them; [`noise`]: white and coloured noise of the sensors.
//! - [`candidates`]: what may be missing, its sensitivities, what it would explain, the test without the catalogue.
//! - [`prepare`]: logs to a problem: frames, what drives the gears, samples that cannot be trusted.
//! - [`search`]: a few effects one by one, or everything together (`search::together`); curves for what
//!   has no name (`search::unnamed`); what it ends with.
//! - [`verdict`]: sets, blind spots; [`result`]: the document, for a terminal and a page.
//!
//! # Example
//!
//! A carriage that lags 0.1 mm behind its command after every reversal has a half gap of 0.05 mm.
//!
//! ```
//! use lostmotion::{diagnose, io::input::from_bytes, log::Log, model::Model, robot::Robot};
//! use std::fmt::Write;
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/gantry-xyz-ballscrew.yaml"))?;
//! let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n");
//! for k in 0..600_i32 {
//!     let t = 0.1 * f64::from(k);
//!     let [x, y, z] = [0.31, 0.23, 0.17].map(|w| 60.0 * (w * t).sin());
//!     // the play of X by hand; readings that scatter by a few um
//!     let lost = 0.05 * (0.31 * t).cos().signum();
//!     let noise = |n: i32| 0.002 * f64::from((k * 7919 + n * 104_729) % 101 - 50) / 50.0;
//!     let command = [500.0 + x, 400.0 + y, -200.0 + z];
//!     let (a, b, c) = (command[0] - lost + noise(1), command[1] + noise(2), command[2] + noise(3));
//!     let _ = writeln!(text, "{t:.3},{:.6},{:.6},{:.6},{a:.6},{b:.6},{c:.6}", command[0], command[1], command[2]);
//! }
//! let log = Log::parse(from_bytes("log.csv".into(), text.into_bytes())?, &robot)?;
//! let model = Model::ideal(robot);
//! let outcome = diagnose::diagnose(&model, &[log])?;
//! let found = diagnose::model_with(&model, &outcome);
//! let gap = found.effects.iter().find_map(|e| e.effect.half_gap()).expect("a gap");
//! assert!((gap.at(0.5) - 0.05e-3).abs() < 5e-6, "{} m", gap.at(0.5));
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub(crate) mod candidates;
pub mod noise;
pub mod note;
pub(crate) mod prepare;
pub mod problem;
pub mod result;
pub mod search;
pub(crate) mod verdict;

use crate::error::Result;
use crate::log::Log;
use crate::model::Model;
pub use note::Note;
pub use result::document::Diagnosis;
pub use search::outcome::Outcome;
pub use verdict::Verdict;

/// Diagnoses logs of one machine against its model: the outcome of the search, from which [`result::document::of`] makes the
/// document and [`model_with`] the model.
///
/// Logs have been through [`crate::log::plausibility`]. Errors: no measured column, or points from which no frame follows.
pub fn diagnose(model: &Model, logs: &[Log]) -> Result<Outcome> {
    let (problem, start) = prepare::problem(model, logs)?;
    if search::together::triage::many(model, logs)
        && let Some((many, members)) = search::together::outcome::of_many(problem.copy(), start.clone())
    {
        // what fewer parameters explain whole needs no lag and no geometry beside them; more of them are needed where fewer leave something
        let few = (members <= search::MOST_EFFECTS).then(|| search::run(problem, start));
        let leaves_less = |few: &Outcome| !many.explains_all() && few.rms_named < many.rms_named;
        let simpler =
            |few: &Outcome| few.explains_all() && (few.fit.parameters() <= many.fit.parameters() || leaves_less(few));
        return Ok(few.filter(simpler).unwrap_or(many));
    }
    Ok(search::run(problem, start))
}

/// The model with what was found inside, and the estimated frame. A ripple whose phase is another in each log is not in it.
pub fn model_with(model: &Model, outcome: &Outcome) -> Model {
    let mut found = model.clone();
    found.effects = outcome.fit.hypothesis.effects.clone();
    // what belongs to these logs alone would be wrong on the next one
    found.effects.retain(|p| !p.effect.of_its_logs_alone());
    if outcome.problem.groups.iter().any(|g| g.dims == 3) {
        // of several stations of the tracker none is the next log's
        found.registration = match outcome.fit.hypothesis.frames.as_slice() {
            [frame] => Some(*frame),
            _ => None,
        };
        // how a probe sits on the tool is no reflector
        if !outcome.problem.is_turned() {
            for (p, d) in found.robot.reflectors_m.iter_mut().zip(&outcome.fit.hypothesis.points_m) {
                *p += d;
            }
        }
    }
    found
}
