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
    /// Programs, macros and routines that move nothing, as the user says.
    pub no_motion: crate::no_motion::NoMotion,
    /// Registers as the controller lists them.
    pub registers: crate::registers::Registers,
    /// Bases that count from another machine than the world, as the controller lists them.
    pub carried_bases: crate::bases::CarriedBases,
    joints: Vec<Axis>,
    /// Joints with their own command.
    commanded: Vec<usize>,
    places: Places,
}

impl Axes {
    /// A table of joints; base and tool are null.
    pub fn new(name: impl Into<String>, joints: Vec<Axis>) -> Self {
        let commanded: Vec<usize> = (0..joints.len()).filter(|&i| joints[i].follows.is_none()).collect();
        let places = Places::of(&commanded.iter().map(|&i| &joints[i]).collect::<Vec<_>>());
        Self {
            name: name.into(),
            base: Isometry3::identity(),
            tool: Isometry3::identity(),
            control: crate::control::Control::default(),
            no_motion: crate::no_motion::NoMotion::default(),
            registers: crate::registers::Registers::default(),
            carried_bases: crate::bases::CarriedBases::default(),
            joints,
            commanded,
            places,
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

    /// Which axes are those of the arm and which external ones, as controllers number both.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Axis names in order, for messages.
    pub fn axis_names(&self) -> Vec<&str> {
        self.axis_joints().map(|j| j.name.as_str()).collect()
    }
}

/// Axes of an arm, and external axes (a track, a positioner), as controllers number both: 1 to 6 each.
///
/// An axis is external where its name says so (`E1`, `EX1`, `EXT1`, `EAX_A`, `J7`, `joint_7`), else where it alone is linear beside six
/// that turn, else where it comes after six that turn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// Axes of the arm in their order.
    pub arm: Vec<usize>,
    /// External axes: number, from 1, and axis; ascending.
    pub external: Vec<(usize, usize)>,
    /// Names and kinds tell which axes are external.
    pub certain: bool,
}

/// Joints of an arm in a list of a controller.
const OF_ARM: usize = 6;

impl Places {
    fn of(axes: &[&Axis]) -> Self {
        let all = || axes.iter().enumerate();
        let mut external: Vec<(usize, usize)> =
            all().filter_map(|(k, j)| Some((external_number(&j.name)?, k))).collect();
        let mut certain = true;
        if external.is_empty() && axes.len() > OF_ARM {
            let linear: Vec<usize> = all().filter(|(_, j)| j.kind == JointKind::Prismatic).map(|(k, _)| k).collect();
            let turns = |k: usize| !linear.contains(&k);
            match linear[..] {
                [one] if axes.len() == OF_ARM + 1 => external.push((1, one)),
                _ => {
                    certain = (0..OF_ARM).all(turns);
                    external.extend((OF_ARM..axes.len()).map(|k| (k - OF_ARM + 1, k)));
                }
            }
        }
        external.sort_unstable();
        certain &= external.windows(2).all(|w| w[0].0 != w[1].0) && external.iter().all(|e| e.0 <= OF_ARM);
        let arm: Vec<usize> = (0..axes.len()).filter(|k| external.iter().all(|e| e.1 != *k)).collect();
        certain &= arm.len() <= OF_ARM;
        Self { arm, external, certain }
    }

    /// The external axis of a number, from 1.
    pub fn external(&self, number: usize) -> Option<usize> {
        self.external.iter().find(|e| e.0 == number).map(|e| e.1)
    }
}

/// The number of an external axis by its name: `E1`, `eax_a`, `joint_7`.
fn external_number(name: &str) -> Option<usize> {
    let name = name.to_ascii_uppercase();
    if let Some(letter) = name.strip_prefix("EAX_") {
        let [letter @ b'A'..=b'F'] = letter.as_bytes() else { return None };
        return Some(usize::from(letter - b'A') + 1);
    }
    let head = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let number: usize = name.get(head.len()..)?.parse().ok()?;
    match head.trim_end_matches('_') {
        "E" | "EX" | "EXT" => (1..=OF_ARM).contains(&number).then_some(number),
        "J" | "A" | "JOINT" | "AXIS" => (OF_ARM + 1..=2 * OF_ARM).contains(&number).then(|| number - OF_ARM),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(joints: &[(&str, JointKind)]) -> Places {
        Axes::new("r", joints.iter().map(|(n, k)| Axis::new(*n, *k)).collect()).places().clone()
    }

    #[test]
    fn external_axes_are_told_by_name_and_by_kind() {
        use JointKind::{Prismatic as P, Revolute as R};
        let arm = [("J1", R), ("J2", R), ("J3", R), ("J4", R), ("J5", R), ("J6", R)];
        let with = |before: &[(&'static str, JointKind)], after: &[(&'static str, JointKind)]| {
            places(&[before, &arm, after].concat())
        };
        assert_eq!(with(&[], &[]), Places { arm: (0..6).collect(), external: vec![], certain: true });
        let rail = Places { arm: (1..7).collect(), external: vec![(1, 0)], certain: true };
        for name in ["E1", "eax_a", "J7", "joint_7", "rail"] {
            assert_eq!(with(&[(name, P)], &[]), rail, "{name}");
        }
        assert_eq!(with(&[("E2", R)], &[]).external(2), Some(0));
        let after = Places { arm: (0..6).collect(), external: vec![(1, 6), (2, 7)], certain: true };
        assert_eq!(with(&[], &[("turn", R), ("tilt", R)]), after);
        assert!(!with(&[("x", P), ("y", P)], &[]).certain);
        assert!(!with(&[("E1", P), ("eax_a", R)], &[]).certain);
        assert!(!with(&[("E1", P), ("turn", R)], &[]).certain);
    }
}
