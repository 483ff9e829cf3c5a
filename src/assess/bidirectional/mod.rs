//! Bidirectional assessment: what positions along a line show when they are reached from both sides (Slamani, Nubiola and
//! Bonev, "Modeling and assessment of the backlash error of an industrial robot", Robotica 30, 2012: Slamani (2012)).
//!
//! In the order of the work: [`readings`] (with [`columns`], [`direction`], [`state`]) reads errors at positions, from both directions,
//! repeated, in one state (speed, payload) or several. [`poses`] gives each pose its repeatabilities and its backlash. [`degree`] finds
//! the polynomial of the backlash over position by tests for lack of fit; [`terms`] tests with Student whether a state adds an
//! offset, a slope, ...; [`model`] fits the whole to the rows of [`data`]; [`equation`] prints it as the paper does. [`gap`] turns the
//! curve into the half gap of a joint. [`document`] is the JSON.
//!
//! Sign: an error is measured minus commanded, forward is towards rising positions. A play then reads low going forward
//! and high going backward: its backlash `y` is negative, its half gap `-y/2`.
//!
//! Files beside:
//! - `digits`: numbers as a report prints them
//! - [`mod@note`]: what a reader should know

pub(crate) mod columns;
pub(crate) mod data;
pub(crate) mod degree;
pub(crate) mod digits;
pub(crate) mod direction;
pub(crate) mod document;
pub mod equation;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod gap;
pub mod model;
pub mod note;
pub(crate) mod poses;
pub mod readings;
pub(crate) mod state;
pub(crate) mod terms;

pub use data::{Errors, Options};
pub use model::Model;
pub use note::Note;
pub use poses::{Line, Pose};
pub use readings::Readings;

use crate::error::{Error, Result};
use model::NoModel;
use note::{PoseName, PoseRemark};
use state::States;

/// Why an assessment gives no gap.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The difference of the directions has the sign that no play gives.
    #[error(
        "forward readings are {:.1} um {} backward ones on average, which is not play of the joint: with play, the joint would lag in both directions",
        1e6 * backlash_m.abs(), if *backlash_m > 0.0 { "above" } else { "below" }
    )]
    NoPlay {
        /// Mean of forward minus backward, m.
        backlash_m: f64,
    },
    #[error(
        "no speed changes the backlash significantly: `backlash_speed` would have no slope (use backlash_position)"
    )]
    /// No slope of the backlash over speed is significant.
    NoSlope,
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(Box::new(refusal))
    }
}

/// The whole result; SI.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// Name of the file with the readings.
    pub file: String,
    /// SHA-256 of that file, hexadecimal.
    pub sha256: String,
    /// Readings that were used, and those that are missing.
    pub used: usize,
    /// Number of readings without a value.
    pub missing: usize,
    /// States of the machine (temperature, load) in which it was measured.
    pub states: States,
    /// States in the order of the report, the reference first.
    pub order: Vec<usize>,
    /// Every position in every state.
    pub poses: Vec<Pose>,
    /// Mean backlash of the line in every state.
    pub lines: Vec<Line>,
    /// Curve of the backlash over position and state; none with too few positions.
    pub model: Option<Model>,
    /// Level of significance of all tests.
    pub alpha: f64,
    /// What a reader should know.
    pub notes: Vec<Note>,
}

/// Assesses readings; `reference` chooses the reference state by `column=value` pairs.
pub fn assess(readings: Readings, reference: &[(String, String)], options: &Options) -> Result<Assessment> {
    let order = readings.states.sorted(reference, &readings.name)?;
    let poses = poses::group(&readings, &order);
    let mut notes = readings.notes.clone();
    about_poses(&poses, &readings.states, &mut notes);
    about_states(&readings.states, &order, &mut notes);
    let fitted = model::fit(&poses, &order, &readings.states, options, &readings.name, &mut notes)?;
    let model = match fitted {
        Ok(model) => Some(model),
        Err(NoModel::NoPureError) => {
            notes.push(Note::NoPureError);
            None
        }
    };
    let lines = order.iter().filter_map(|s| poses::line(&poses, *s)).collect();
    let used = readings.rows.iter().filter(|r| r.error_m.is_some()).count();
    Ok(Assessment {
        file: readings.name,
        sha256: readings.sha256,
        used,
        missing: readings.missing,
        states: readings.states,
        order,
        poses,
        lines,
        model,
        alpha: options.alpha,
        notes,
    })
}

/// What is not as it should be at single poses.
fn about_poses(poses: &[Pose], states: &States, notes: &mut Vec<Note>) {
    let name = |p: &Pose| PoseName { position_m: p.position_m, state: states.text(p.state) };
    let mut note = |which: &dyn Fn(&Pose) -> bool, remark: PoseRemark| {
        let found: Vec<PoseName> = poses.iter().filter(|p| which(p)).map(name).collect();
        if !found.is_empty() {
            notes.push(Note::Poses { remark, poses: found });
        }
    };
    note(&|p| p.forward.is_none() && p.backward.is_none(), PoseRemark::NoReading);
    note(&|p| p.forward.is_some() != p.backward.is_some(), PoseRemark::OneDirection);
    note(&|p| p.by_order, PoseRemark::PairedByOrder);
    note(&|p| p.backlash.is_some() && p.unpaired > 0, PoseRemark::Unpaired);
    let one = |p: &Pose| p.backlash.is_some() && p.bidirectional_m(1.0).is_none();
    if poses.iter().any(|p| p.bidirectional_m(1.0).is_some()) {
        note(&one, PoseRemark::OneReading);
    }
}

/// State columns that cannot be distinguished, and those that never change.
fn about_states(states: &States, order: &[usize], notes: &mut Vec<Note>) {
    let varying = states.varying();
    for (i, &a) in varying.iter().enumerate() {
        for &b in &varying[i + 1..] {
            let pairs = |k: usize| order.iter().map(|s| &states.all[*s][k]).collect::<Vec<_>>();
            let (x, y) = (pairs(a), pairs(b));
            let same = |v: &[&state::Level], i: usize, j: usize| v[i] == v[j];
            let together = (0..x.len()).all(|i| (0..i).all(|j| same(&x, i, j) == same(&y, i, j)));
            if together {
                notes.push(Note::ChangeTogether { columns: [a, b].map(|k| states.names[k].clone()) });
            }
        }
    }
}
