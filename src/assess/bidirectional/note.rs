//! What a reader of a bidirectional assessment should know. Code compares the variants; the words are for readers.

use super::digits::digits;
use crate::gaps;
use std::fmt;

/// A remark on an assessed line. A state is named by its columns: `speed_mm_s=1000, payload_kg=5`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Readings without a value.
    #[error("{missing} of {readings} readings {} missing", if *missing == 1 { "is" } else { "are" })]
    Missing {
        /// How many.
        missing: usize,
        /// All readings.
        readings: usize,
    },
    /// Positions may be in another unit.
    #[error("the line is {:.4} mm long: are its positions in mm? A column map with `unit: m` reads metres", length_m * 1e3)]
    ShortLine {
        /// Length of the line, m.
        length_m: f64,
    },
    /// Errors may be in another unit.
    #[error("the largest error is {:.4} um: if it is in mm, name its column error_mm", largest_m * 1e6)]
    SmallErrors {
        /// Largest error, m.
        largest_m: f64,
    },
    /// Of single poses.
    #[error("{remark}: {}", listed(poses))]
    Poses {
        /// What is to know of them.
        remark: PoseRemark,
        /// Which ones.
        poses: Vec<PoseName>,
    },
    /// Two columns of the state say the same.
    #[error("{} and {} always change together, so the effect of one of them cannot be determined", columns[0], columns[1])]
    ChangeTogether {
        /// Names of the columns.
        columns: [String; 2],
    },
    /// A state without a pose of both directions.
    #[error("{state}: no pose with a repeat in both directions; left out of the model")]
    StateLeftOut {
        /// The state.
        state: String,
    },
    /// A state whose offset cannot be tested.
    #[error("{state}: too few poses for a Student test of its offset (no degree of freedom is left)")]
    TooFewPoses {
        /// The state.
        state: String,
    },
    /// A state turns the curve without moving it.
    #[error(
        "{state}: no offset, but its slope would be significant (t = {t:.2}): it turns the curve about the middle of the line"
    )]
    SlopeAlone {
        /// The state.
        state: String,
        /// Student's t of the slope.
        t: f64,
    },
    /// No degree explains the curve.
    #[error(
        "no degree up to {tried} explains the backlash at {poses} poses: degree {degree} is kept, and its lack of fit is significant"
    )]
    LackOfFit {
        /// Highest degree that was tried.
        tried: usize,
        /// Number of poses.
        poses: usize,
        /// Degree that is kept.
        degree: usize,
    },
    /// No pure error, although there are repeats.
    #[error("the repeats agree to the last digit, so there is no pure error to compare with")]
    RepeatsAgree,
    /// The model of all states does not fit.
    #[error(
        "over all states, the residual of the model is larger than the repeats explain (F = {f:.2}, p = {p_value:.2e}): the curve or the term of a state has another form; try a higher degree"
    )]
    LackOfFitOverStates {
        /// F of the test.
        f: f64,
        /// p value of the test.
        p_value: f64,
    },
    /// One repeat only.
    #[error(
        "only one repeat: there is no pure error, so no degree can be tested and no repeatability can be reported; repeat the run, or give the degree for a curve without this test"
    )]
    NoPureError,
    /// Of the gap of the joint that moves the line.
    #[error("{0}")]
    Gap(gaps::Note),
}

/// A remark on single poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PoseRemark {
    /// No reading.
    #[error("no reading, so it is left out")]
    NoReading,
    /// Readings of one direction.
    #[error("only one direction, so no backlash")]
    OneDirection,
    /// Repeats without names in common.
    #[error("paired by their order, because the repeats have no names in common")]
    PairedByOrder,
    /// Readings without a partner.
    #[error("readings without a partner in the same repeat count for means and repeatability, not for the model")]
    Unpaired,
    /// One reading of a direction.
    #[error("only one reading of a direction, so no repeatability")]
    OneReading,
}

/// A pose by its position and its state.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseName {
    /// Position on the line, m.
    pub position_m: f64,
    /// The state; empty where the file has one state only.
    pub state: String,
}

impl fmt::Display for PoseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm", digits(self.position_m * 1e3, 9))?;
        if self.state.is_empty() { Ok(()) } else { write!(f, " ({})", self.state) }
    }
}

fn listed(poses: &[PoseName]) -> String {
    const SHOWN: usize = 6;
    let mut text: Vec<String> = poses.iter().take(SHOWN).map(PoseName::to_string).collect();
    if poses.len() > SHOWN {
        text.push(format!("{} more", poses.len() - SHOWN));
    }
    text.join(", ")
}

crate::io::in_words!(Note);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_poses_are_named_and_the_others_are_counted() {
        let pose = |k: usize| PoseName { position_m: 0.1 * k as f64, state: String::new() };
        let note = |n: usize| Note::Poses { remark: PoseRemark::NoReading, poses: (0..n).map(pose).collect() };
        assert_eq!(note(2).to_string(), "no reading, so it is left out: 0 mm, 100 mm");
        assert!(note(8).to_string().ends_with("500 mm, 2 more"), "{}", note(8));
    }
}
