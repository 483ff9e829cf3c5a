//! Why the gaps of a document cannot be trusted.

use crate::log::plausibility::AnotherArm;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why the gaps of a document cannot be trusted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Distrust {
    /// The residual is of another order than the noise of the log.
    ModelDoesNotDescribeLog {
        /// Factor on the variance by which correlated residuals inflate it.
        #[serde(rename = "variance_inflation")]
        inflation: f64,
        /// Gaps were given as known and held.
        gaps_held: bool,
    },
    /// The measured points stand further from the robot file's places than an arm's own errors put them.
    FarFromRobotFile {
        /// A tenth of them stand so far or more from their places after the best rigid fit, mm.
        misfit_mm: f64,
        /// The largest of them, mm.
        largest_mm: f64,
    },
    /// The robot file seems to describe another arm.
    AnotherArm(AnotherArm),
    /// The commands jitter, or are written with too few digits for the gap.
    CommandsNotKnown {
        /// Name of the joint.
        joint: String,
        /// Unit of the values: `deg` or `mm`.
        unit: String,
        /// Half gap that was found.
        half_gap: f64,
        /// Root mean square error of the commands that were used.
        left: f64,
        /// Standard deviation of their noise; 0: their last digit is the cause.
        noise: f64,
    },
}

impl fmt::Display for Distrust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ModelDoesNotDescribeLog { inflation, gaps_held } => {
                let held = if *gaps_held { "the gaps given as known, " } else { "" };
                write!(
                    f,
                    "the model does not describe this log (variance inflated {inflation:.1} times), so the gaps cannot be trusted: check {held}the \
                     order and sign of the x, y, z columns, units and the robot file"
                )
            }
            Self::FarFromRobotFile { misfit_mm, largest_mm } => write!(
                f,
                "a tenth of the measured points are {misfit_mm:.1} mm or more (the largest {largest_mm:.1} mm) from the positions computed with the robot file, and calibration errors are at most a few millimetres: the gaps cannot be trusted; check that the robot file describes this robot (model, lengths), its `tool` and its zero positions"
            ),
            Self::CommandsNotKnown { joint, unit, half_gap, left, noise } => {
                let (why, expected) = if *noise > 0.0 {
                    (format!("jitter ({noise:.6} {unit})"), "log the commanded positions instead of measured ones")
                } else {
                    ("are written with few digits".into(), "log the commands with more decimals")
                };
                write!(
                    f,
                    "the commands of {joint} {why}: their error of {left:.6} {unit} is not small against a half gap of {half_gap:.6} {unit}, so the gaps \
                     cannot be trusted: {expected}"
                )
            }
            Self::AnotherArm(AnotherArm { misfit_mm, path_mm, tool_offset_mm }) => write!(
                f,
                "the robot file seems to describe another arm: the measured path fits best with a TCP {tool_offset_mm:.0} mm from the file's `tool`, and still differs by {misfit_mm:.2} mm on a path of {path_mm:.0} mm; the gaps cannot be trusted: check the robot file (model, lengths, order of the joints) and its `tool`"
            ),
        }
    }
}
