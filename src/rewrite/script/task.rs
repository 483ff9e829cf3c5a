//! What is asked of a vendor program: the choices of a user, and all that is the same for the programs of a call.

use crate::compensator::Compensator;
use crate::rewrite::Options;
use crate::robot::Robot;
use crate::robot::frames::Frames;

/// What a user may choose about vendor programs alone.
#[derive(Debug, Clone, Default)]
pub struct Choices {
    /// Moves while a process (welding, dispensing) is on stay as they are.
    pub exclude_process: bool,
    /// Write Cartesian moves between joint moves as joint moves, within this distance of the TCP's line, m.
    pub solve_within_m: Option<f64>,
    /// Share of the moves that must be editable, 0 to 1.
    pub require_coverage: Option<f64>,
    /// TCP speed instead of what joint speeds would make it, m/s.
    pub speed_m_s: Option<f64>,
    /// Frames and tools by the controller's names, besides those of the robot file.
    pub frames: Frames,
    /// Cartesian targets stay as they are.
    pub leave_poses: bool,
    /// Most points that may be added to a program.
    pub max_added: Option<u64>,
    /// The points of a move gain at least this much at the TCP, m.
    pub least_gain_m: Option<f64>,
    /// No points are added while a process is on; targets are edited.
    pub leave_process: bool,
    /// Direction in which each axis comes to targets at which the robot stops, +1 or -1; 0: any. Empty: all any.
    pub approach_from: Vec<i8>,
    /// Targets at which the robot stops and that it may reach from anywhere are reached over an added point.
    pub approach_unknown: bool,
}

/// The task: what is the same for all programs of a call.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The robot that the program moves.
    pub robot: &'a Robot,
    /// What is to be undone.
    pub compensator: &'a Compensator,
    /// Options of the engine.
    pub options: &'a Options,
    /// What the user chooses for programs.
    pub choices: &'a Choices,
    /// Dead bands that were asked for, per axis.
    pub deadband: &'a [Option<f64>],
    /// Weight of the last digit that changed numbers should have at most, per axis, rad or m.
    pub digit: &'a [f64],
    /// ... and of lengths (m) and angles (rad) of poses.
    pub pose_digit: [f64; 2],
    /// Changes that are listed.
    pub listed: usize,
}
