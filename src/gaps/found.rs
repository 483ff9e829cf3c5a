//! The gaps of a machine as an identification finds them.

use super::distrust::Distrust;
use super::estimate::Estimate;
use super::note::Note;
use crate::effects::{Decay, GapCurve};
use crate::log::Log;
use crate::log::registration::Registered;
use crate::robot::Robot;

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
    pub estimate: Option<Estimate>,
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
