//! A robot: a serial chain of revolute and prismatic joints in any mix, its base, tool and limits.
//!
//! Modules:
//! - [`mod@file`]: the robot file (YAML, degrees and millimetres) to and from this module's types (SI), with every refusal.
//! - [`chain`]: forward kinematics and the analytic Jacobian (Zhang (2023) equations 2-5; Craig's convention too).
//! - [`inverse`]: the damped numerical inverse for any subset of joints; reports why it stopped.
//! - [`arm`]: all joint vectors of a pose, in closed form for the arms of most makers.
//! - [`frames`]: frames and tools by the controller's names.
//! - [`mod@write`]: a robot back to its file, by `lines` one line for each joint.
//! - [`urdf`]: a robot from a URDF file, by [`dh`]: parameters of given joint axes.
//! - [`table`]: a robot from the Denavit-Hartenberg table of a data sheet.
//! - [`plausible`]: whether the numbers can be those of a machine.
//! - [`gap_of`]: joints whose gap belongs to a sum of axes.
//! - [`fingerprint`]: SHA-256 of the robot's numbers, so that a compensator cannot meet another robot.
//!
//! Joint vectors `q` hold one value per *axis*, that is, per joint with its own command, in file order, in radians
//! or metres. A joint that follows another one has no entry.

#![warn(missing_docs)]

pub mod arm;
pub mod chain;
pub mod dh;
pub mod file;
pub mod fingerprint;
mod flip;
pub mod frames;
pub mod gap_of;
pub mod inverse;
mod lines;
pub mod plausible;
pub mod table;
pub mod urdf;
pub mod write;

pub use arm::Arm;
pub use chain::{Chain, Pose};
pub use flip::Flip;
pub use frames::Frames;
pub use gap_of::GapOf;
pub use inverse::{Inverse, InverseOptions, Stop, Target};

pub use robot_programs::axes::{Axes, Axis, JointKind};
use robot_programs::gcode::Control;

use nalgebra::{Isometry3, Vector3};

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
    /// Index of the driving joint in [`Robot::joints`].
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

/// A robot. Its numbers are SI.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Name, as files and messages show it.
    pub name: String,
    /// Denavit-Hartenberg convention of the parameters.
    pub convention: Convention,
    /// Joints from base to flange.
    pub joints: Vec<Joint>,
    /// Empty, or one per joint.
    pub links: Vec<Link>,
    /// Robot base in the world.
    pub base: Isometry3<f64>,
    /// The maker's flange (`tool0`, face plate) in the frame of the last joint.
    flange: Isometry3<f64>,
    /// TCP (the reflector) in the flange frame.
    pub tool: Isometry3<f64>,
    /// Further reflectors in the flange frame, metres: `x2_mm`, `x3_mm`, ... of a log.
    pub reflectors_m: Vec<Vector3<f64>>,
    /// Acceleration of gravity in the world frame, m/s^2.
    pub gravity_m_s2: Vector3<f64>,
    /// Joints whose gap belongs to a sum of axes.
    pub gap_of: Vec<GapOf>,
    /// Frames and tools of its controller, as the robot file names them.
    pub frames: Frames,
    /// Which wrist its maker calls flipped; `None`: not known.
    pub wrist_flip: Option<Flip>,
    axes: Vec<usize>,
    chain: Chain,
    table: Axes,
}

impl Robot {
    /// Puts the parts together; joints, base and tool are given in SI and have been checked by [`mod@file`]. The flange is the frame
    /// of the last joint; [`Self::with_flange`] gives it another place.
    pub fn new(
        name: String,
        convention: Convention,
        joints: Vec<Joint>,
        base: Isometry3<f64>,
        tool: Isometry3<f64>,
    ) -> Self {
        let axes: Vec<usize> = (0..joints.len()).filter(|&i| joints[i].follows.is_none()).collect();
        let chain = Chain::new(convention, &joints, &axes, &base, &tool);
        let mut table = Axes::new(name.clone(), joints.iter().map(|j| row(j, &joints)).collect());
        (table.base, table.tool) = (base, tool);
        Self {
            name,
            convention,
            joints,
            links: Vec::new(),
            base,
            flange: Isometry3::identity(),
            tool,
            reflectors_m: Vec::new(),
            gravity_m_s2: Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_S2),
            gap_of: Vec::new(),
            frames: Frames::default(),
            wrist_flip: None,
            axes,
            chain,
            table,
        }
    }

    /// The same robot with its flange at another place of the last joint's frame.
    #[must_use]
    pub fn with_flange(mut self, flange: Isometry3<f64>) -> Self {
        self.flange = flange;
        self.chain = self.chain_for(&self.tool);
        self
    }

    /// The maker's flange in the frame of the last joint: where tools are mounted and from where the controller counts them.
    pub fn flange(&self) -> &Isometry3<f64> {
        &self.flange
    }

    /// How the control reads G-code before a program says so.
    pub fn assume(&mut self, control: Control) {
        self.table.control = control.or(self.table.control);
    }

    /// Programs, macros and routines that move nothing and leave frames and tools as they are, besides those named before.
    pub fn declare_no_motion<'a>(&mut self, names: impl IntoIterator<Item = &'a str>) {
        self.table.no_motion.add(names);
    }

    /// Registers as the controller lists them.
    pub fn hold_registers(&mut self, registers: robot_programs::fanuc::Registers) {
        self.table.registers = registers;
    }

    /// Bases that count from another machine than the world, besides those named before.
    pub fn hold_bases(&mut self, carried: &robot_programs::bases::CarriedBases) {
        self.table.carried_bases.add(carried);
    }

    /// The joints as programs know them: names, units, limits, pulses.
    pub fn axes(&self) -> &Axes {
        &self.table
    }

    /// The same robot with other numbers in its joints (as many, with the same names, kinds and followers) and another tool.
    pub fn with_geometry(&self, joints: Vec<Joint>, tool: Isometry3<f64>) -> Self {
        let mut robot = Self::new(self.name.clone(), self.convention, joints, self.base, tool).with_flange(self.flange);
        robot.links = self.links.clone();
        robot.reflectors_m = self.reflectors_m.clone();
        robot.gravity_m_s2 = self.gravity_m_s2;
        robot.gap_of = self.gap_of.clone();
        robot.table.control = self.table.control;
        robot.table.no_motion = self.table.no_motion.clone();
        robot.table.registers = self.table.registers.clone();
        robot.table.carried_bases = self.table.carried_bases.clone();
        robot.frames = self.frames.clone();
        robot.wrist_flip = self.wrist_flip;
        robot
    }

    /// Number of axes: the length of a joint vector.
    pub fn dof(&self) -> usize {
        self.axes.len()
    }

    /// Index of the joint of an axis in [`Self::joints`].
    pub fn axis_index(&self, axis: usize) -> usize {
        self.axes[axis]
    }

    /// The joint that axis `axis` commands.
    pub fn axis(&self, axis: usize) -> &Joint {
        &self.joints[self.axes[axis]]
    }

    /// The joints that have their own command, in file order.
    pub fn axis_joints(&self) -> impl ExactSizeIterator<Item = &Joint> + Clone {
        self.axes.iter().map(|&i| &self.joints[i])
    }

    /// Axis of a joint name, case ignored.
    pub fn axis_named(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|&i| self.joints[i].name.eq_ignore_ascii_case(name))
    }

    /// Axis names in order, for messages.
    pub fn axis_names(&self) -> Vec<&str> {
        self.axis_joints().map(|j| j.name.as_str()).collect()
    }

    /// The chain that computes.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Pose of the TCP in the world for `q` (rad or m, one value per axis; Zhang (2023) equation 3).
    pub fn forward(&self, q: &[f64]) -> Pose {
        self.chain.forward(q)
    }

    /// Position of the TCP in the world, metres.
    pub fn tcp_m(&self, q: &[f64]) -> Vector3<f64> {
        self.chain.position(q)
    }

    /// Chain to another point of the flange frame (metres): a further reflector, or a trial tool.
    pub fn chain_to(&self, point_m: &Vector3<f64>) -> Chain {
        let tool = Isometry3::from_parts((*point_m).into(), self.tool.rotation);
        self.chain_for(&tool)
    }

    /// Chain to a tool in the flange frame.
    fn chain_for(&self, tool: &Isometry3<f64>) -> Chain {
        Chain::new(self.convention, &self.joints, &self.axes, &self.base, &(self.flange * tool))
    }
}

/// A joint as programs know it.
fn row(joint: &Joint, all: &[Joint]) -> Axis {
    Axis {
        name: joint.name.clone(),
        kind: joint.kind,
        limits: joint.limits,
        max_speed: joint.max_speed,
        max_accel: joint.max_accel,
        pulses: joint.pulses,
        follows: joint.follows.and_then(|f| all.get(f.joint)).map(|driver| driver.name.clone()),
    }
}
