//! The axes of a robot as far as a program knows them: names, kinds, limits, and how a controller counts them.
//!
//! Targets hold one value per *axis*, that is, per joint with its own command, in order, in radians or metres. A joint that
//! follows another one (the second half of a parallelogram) has no value; it is listed so that a message can say so.

use nalgebra::Isometry3;

/// Kind of a joint; it fixes the unit of its command (rad or m).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// Turns: rad inside, deg in programs.
    Revolute,
    /// Slides: m inside, mm in programs.
    Prismatic,
}

impl JointKind {
    /// Unit at the edges: `deg` or `mm`, as it stands in keys and column names.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Revolute => "deg",
            Self::Prismatic => "mm",
        }
    }

    /// Edge unit to SI: multiply (rad per deg, m per mm).
    pub fn si_per_user_unit(self) -> f64 {
        match self {
            Self::Revolute => std::f64::consts::PI / 180.0,
            Self::Prismatic => 1e-3,
        }
    }

    /// SI value in the unit of the edges (deg or mm).
    pub fn to_user_unit(self, si: f64) -> f64 {
        match self {
            Self::Revolute => si.to_degrees(),
            Self::Prismatic => si * 1e3,
        }
    }
}

/// One joint. Limits are in rad or m, per second, per second squared.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of the joint as programs and messages show it.
    pub name: String,
    /// What the joint does.
    pub kind: JointKind,
    /// Lower and upper limit.
    pub limits: Option<[f64; 2]>,
    /// Highest speed, rad/s or m/s.
    pub max_speed: Option<f64>,
    /// Highest acceleration, rad/s^2 or m/s^2.
    pub max_accel: Option<f64>,
    /// Pulses of the controller per rad or m, with sign: programs may hold joints in pulses.
    pub pulses: Option<f64>,
    /// Name of the joint that drives this one; `None`: it has its own command.
    pub follows: Option<String>,
}

impl Axis {
    /// A joint with its own command and without limits.
    pub fn new(name: impl Into<String>, kind: JointKind) -> Self {
        let name = name.into();
        Self { name, kind, limits: None, max_speed: None, max_accel: None, pulses: None, follows: None }
    }
}

/// The joints of a robot in the order in which targets give them, and where its base and tool are.
///
/// ```
/// use robot_programs::axes::{Axes, Axis, JointKind};
/// let mut wheel = Axis::new("A2b", JointKind::Revolute);
/// wheel.follows = Some("A2".into());
/// let axes = Axes::new("arm", vec![Axis::new("A1", JointKind::Revolute), Axis::new("A2", JointKind::Revolute), wheel]);
/// assert_eq!((axes.dof(), axes.axis_named("a2")), (2, Some(1)));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// Name of the robot, for messages.
    pub name: String,
    /// Robot base in the world.
    pub base: Isometry3<f64>,
    /// TCP in the flange frame.
    pub tool: Isometry3<f64>,
    /// How the control reads G-code before a program says so.
    pub control: crate::control::Control,
    joints: Vec<Axis>,
    /// Joints with their own command.
    commanded: Vec<usize>,
}

impl Axes {
    /// A table of joints; base and tool are null.
    pub fn new(name: impl Into<String>, joints: Vec<Axis>) -> Self {
        let commanded = (0..joints.len()).filter(|&i| joints[i].follows.is_none()).collect();
        Self {
            name: name.into(),
            base: Isometry3::identity(),
            tool: Isometry3::identity(),
            control: crate::control::Control::default(),
            joints,
            commanded,
        }
    }

    /// All joints, those that follow another one included.
    pub fn joints(&self) -> &[Axis] {
        &self.joints
    }

    /// Number of axes: the length of a joint vector.
    pub fn dof(&self) -> usize {
        self.commanded.len()
    }

    /// The joint of axis `axis`.
    ///
    /// # Panics
    /// If `axis` is not below [`Axes::dof`].
    pub fn axis(&self, axis: usize) -> &Axis {
        &self.joints[self.commanded[axis]]
    }

    /// The joints that have their own command, in order.
    pub fn axis_joints(&self) -> impl ExactSizeIterator<Item = &Axis> + Clone {
        self.commanded.iter().map(|&i| &self.joints[i])
    }

    /// Axis of a joint name, case ignored.
    pub fn axis_named(&self, name: &str) -> Option<usize> {
        self.axis_joints().position(|j| j.name.eq_ignore_ascii_case(name))
    }

    /// Axis names in order, for messages.
    pub fn axis_names(&self) -> Vec<&str> {
        self.axis_joints().map(|j| j.name.as_str()).collect()
    }
}
