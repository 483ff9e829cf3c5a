//! What an identification found: half gaps per joint and angle, stiction, the registration. Document
//! `lostmotion/gaps/1`; written by `identify`, read by `fit`.
//!
//! [`estimate`] holds what a joint estimate over all logs of a machine adds; [`after_reversal`] its curve over time.
//! [`mod@note`] holds what a reader should know. Values are SI (rad or m, s); [`document`] turns them into the document's units, [`mod@file`] into text, [`read`] back.
//!
//! # Example
//!
//! A document is in degrees or mm, its values here in rad or m.
//!
//! ```
//! use lostmotion::{gaps::Gaps, robot::Robot};
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml"))?;
//! let text = format!(
//!     "schema: lostmotion/gaps/1\nrobot: {{name: KUKA, sha256: {}}}\nlogs: [{{name: circle.csv, sha256: aa}}]\npoints: []\njoints:\n  \
//!      - {{joint: A2, half_gap_deg: 0.0037, ci95: [0.0036, 0.0038]}}\n",
//!     robot.fingerprint()
//! );
//! let gaps = Gaps::parse("gaps.yaml", &text, &robot)?;
//! let a2 = &gaps.joints[0];
//! assert_eq!(a2.axis, 1);
//! assert!((a2.half_gap - 0.0037_f64.to_radians()).abs() < 1e-12);
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod after_reversal;
pub mod document;
pub mod estimate;
pub mod file;
pub mod note;
pub mod read;

use crate::log::plausibility::AnotherArm;
pub use crate::log::registration::Registered;
pub use note::Note;

use crate::effects::{Decay, GapCurve};
use crate::log::Log;
use crate::robot::Robot;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Result of an identification.
#[derive(Debug, Clone)]
pub struct Gaps {
    /// Name of the robot that was measured.
    pub robot_name: String,
    /// Fingerprint of that robot ([`Robot::fingerprint`]).
    pub robot_sha256: String,
    /// Logs that the gaps were identified from.
    pub logs: Vec<LogRef>,
    /// Robot frame to tracker frame, if it was estimated.
    pub registration: Option<Registered>,
    /// Gap at each tested angle (static test) or at each reversal (path).
    pub points: Vec<GapPoint>,
    /// Half gaps, one entry for each joint that was tested.
    pub joints: Vec<JointGap>,
    /// Median TCP speed of the commanded path where it moves, m/s: lets `rewrite` turn seconds into points.
    pub tcp_speed_m_s: Option<f64>,
    /// What a joint estimate over all logs adds.
    pub estimate: Option<estimate::Estimate>,
    /// Why the gaps cannot be trusted, where they cannot.
    pub distrust: Option<Distrust>,
    /// What a reader should know: dropped cycles, joints left out and why.
    pub notes: Vec<Note>,
}

impl Gaps {
    /// A document of a robot in which nothing is found yet.
    pub fn new(robot: &Robot, logs: &[Log]) -> Self {
        Self {
            robot_name: robot.name.clone(),
            robot_sha256: robot.fingerprint(),
            logs: logs.iter().map(|l| LogRef { name: l.name.clone(), sha256: l.sha256.clone() }).collect(),
            registration: None,
            points: Vec::new(),
            joints: Vec::new(),
            tcp_speed_m_s: None,
            estimate: None,
            distrust: None,
            notes: Vec::new(),
        }
    }

    /// Marks the gaps as not to be trusted where the logs' paths are those of another arm than the robot file's; a note says so first.
    pub(crate) fn doubt_robot_file(&mut self, robot: &Robot, logs: &[Log]) {
        if self.distrust.is_none()
            && let Some(why) = crate::log::plausibility::distrust(logs, robot)
        {
            let why = Distrust::AnotherArm(why);
            self.notes.insert(0, Note::Distrust(why.clone()));
            self.distrust = Some(why);
        }
    }
}

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

/// A log that was used.
#[derive(Debug, Clone, PartialEq)]
pub struct LogRef {
    /// Name of the file as messages show it.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// A half gap at one place.
#[derive(Debug, Clone)]
pub struct GapPoint {
    /// Axis of the robot.
    pub axis: usize,
    /// Position of the joint, rad or m.
    pub at: f64,
    /// Half gap there, rad or m.
    pub half_gap: f64,
    /// 95 % interval, rad or m.
    pub ci95: [f64; 2],
    /// Number of cycles at this position.
    pub cycles: usize,
    /// Each cycle's value, in order, where there are cycles.
    pub per_cycle: Vec<f64>,
}

/// A joint's lost motion.
#[derive(Debug, Clone)]
pub struct JointGap {
    /// Axis of the robot.
    pub axis: usize,
    /// Mean half gap over the tested angles.
    pub half_gap: f64,
    /// 95 % interval, rad or m.
    pub ci95: [f64; 2],
    /// The interval excludes zero.
    pub significant: bool,
    /// Offsets of both directions, where they differ.
    pub sides: Option<Sides>,
    /// Where the gap varies with position.
    pub schedule: Option<GapCurve>,
    /// p value of the test that the gap does not vary.
    pub varies_p_value: Option<f64>,
    /// Friction after reversals, if a path showed it.
    pub stiction: Option<StictionFound>,
    /// p value of the test that there is no stiction, where it was looked for.
    pub stiction_p_value: Option<f64>,
}

/// A gap whose sides differ (Gantry (2015) equation 2); rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// `c_r`: how far the joint lags its command moving up.
    pub positive: f64,
    /// 95 % interval of `positive`, rad or m.
    pub positive_ci95: [f64; 2],
    /// `-c_l`: the same moving down.
    pub negative: f64,
    /// 95 % interval of `negative`, rad or m.
    pub negative_ci95: [f64; 2],
}

/// A spike after reversals.
#[derive(Debug, Clone)]
pub struct StictionFound {
    /// Lag at the instant of a reversal, beyond the half gap, rad or m.
    pub spike: f64,
    /// 95 % interval, rad or m.
    pub ci95: [f64; 2],
    /// How the spike decays.
    pub decay: Decay,
    /// 95 % interval of the decay, in its unit.
    pub decay_ci95: [f64; 2],
}
