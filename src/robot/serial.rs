//! A robot as its joints in a chain, with base, flange, tool and what its controller knows.

use super::chain::{Chain, Pose};
use super::joint::{Convention, GapOf, Joint, Link, STANDARD_GRAVITY_M_S2};
use super::{Flip, Frames};
use nalgebra::{Isometry3, Vector3};
use robot_programs::axes::{Axes, Axis};
use robot_programs::gcode::Control;

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
    pub(super) flange: Isometry3<f64>,
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
    pub(super) axes: Vec<usize>,
    pub(super) chain: Chain,
    pub(super) table: Axes,
}

impl Robot {
    /// Puts the parts together; joints, base and tool are given in SI and have been checked by [`file`](mod@super::file). The flange is the
    /// frame of the last joint; [`Self::with_flange`] gives it another place.
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
