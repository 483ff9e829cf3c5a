//! The parts of a robot: joints with their Denavit-Hartenberg parameters, links, the gears that turn by a sum of axes.

use nalgebra::Vector3;

pub use robot_programs::axes::JointKind;

/// Standard acceleration of free fall, m/s^2 (CGPM 1901).
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// Denavit-Hartenberg convention of a robot file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha): Zhang (2023) equation 2.
    Standard,
    /// Craig: Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d).
    Modified,
}

/// Axes and origin of a joint's frame, after the joint's own turn and slide: `z` is its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFrame {
    /// Direction of x in the base frame.
    pub x: Vector3<f64>,
    /// Direction of y in the base frame.
    pub y: Vector3<f64>,
    /// Direction of z, the axis of the joint, in the base frame.
    pub z: Vector3<f64>,
    /// Origin in the base frame, m.
    pub origin_m: Vector3<f64>,
    /// `x` and `y` before the turn.
    pub fixed_x: Vector3<f64>,
    /// Direction of y before the joint's own rotation, in the base frame.
    pub fixed_y: Vector3<f64>,
    /// Direction of the joint's DH parameter `a`.
    pub along_a: Vector3<f64>,
    /// Axis that drives the joint.
    pub axis: usize,
}

/// A joint driven by another one: `command = ratio * command of that axis`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follow {
    /// Index of the driving joint in [`Robot::joints`](super::Robot::joints).
    pub joint: usize,
    /// Movement of this joint per movement of the other one.
    pub ratio: f64,
}

/// One joint with its DH parameters (radians, metres) and limits (radians or metres, per second, per second squared).
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, as files and messages show it.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Denavit-Hartenberg angle about z at command 0, rad.
    pub theta_rad: f64,
    /// Denavit-Hartenberg distance along z at command 0, m.
    pub d_m: f64,
    /// Denavit-Hartenberg distance along x, m.
    pub a_m: f64,
    /// Denavit-Hartenberg angle about x, rad.
    pub alpha_rad: f64,
    /// Hayati's twist about y after `alpha`, for nearly parallel axes.
    pub beta_rad: f64,
    /// +1 or -1: sense of the command.
    pub direction: f64,
    /// Least and largest command, rad or m; `None`: not known.
    pub limits: Option<[f64; 2]>,
    /// Largest speed, rad/s or m/s; `None`: not known.
    pub max_speed: Option<f64>,
    /// Largest acceleration, rad/s^2 or m/s^2; `None`: not known.
    pub max_accel: Option<f64>,
    /// Lead of the screw that drives the joint, m per revolution.
    pub lead_m_per_rev: Option<f64>,
    /// Pulses of the controller per rad or m, with sign: programs may hold joints in pulses.
    pub pulses: Option<f64>,
    /// The joint that this one follows; `None`: it has its own command.
    pub follows: Option<Follow>,
}

/// Mass of a link and its centre of mass in the link frame of its joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the link's frame, m.
    pub com_m: Vector3<f64>,
}

/// The gear of an axis turns by the axis' own value and those of others.
#[derive(Debug, Clone, PartialEq)]
pub struct GapOf {
    /// The axis that bears the joint's name.
    pub axis: usize,
    /// Further axes of the sum, +1 or -1 each. Empty: the gear turns by the axis alone, and the robot file says so.
    pub others: Vec<(usize, f64)>,
}
