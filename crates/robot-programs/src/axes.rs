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

    /// What holds for this kind, of a revolute and a prismatic joint.
    ///
    /// ```
    /// use robot_programs::axes::JointKind;
    /// assert_eq!(JointKind::Prismatic.pick(["turns", "slides"]), "slides");
    /// ```
    pub fn pick<T>(self, [revolute, prismatic]: [T; 2]) -> T {
        match self {
            Self::Revolute => revolute,
            Self::Prismatic => prismatic,
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
    /// Numbers, from 1, of the axes of the arm, in the order of [`Places::arm`]: by their names (`J6`, `wrist3`), else by their order.
    pub numbers: Vec<usize>,
    /// The names tell these numbers, or the arm has all six of a controller's list.
    pub numbered: bool,
}

/// Joints of an arm in a list of a controller.
pub const OF_ARM: usize = 6;

/// Numbers of the axes of arms that keep the tool upright by their linkage: the controller counts the two that they lack as 0.
const UPRIGHT: [usize; 4] = [1, 2, 3, 6];

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
        let names: Vec<&str> = arm.iter().filter_map(|k| axes.get(*k)).map(|j| j.name.as_str()).collect();
        let named = numbers_by_name(&names);
        let numbered = named.is_some() || arm.len() == OF_ARM;
        let numbers = named.unwrap_or_else(|| (1..=arm.len()).collect());
        Self { arm, external, certain, numbers, numbered }
    }

    /// The number of an axis of the arm, from 1.
    pub fn number(&self, axis: usize) -> Option<usize> {
        self.arm.iter().position(|a| *a == axis).and_then(|k| self.numbers.get(k).copied())
    }

    /// Numbers of a controller's list for which the robot file has a joint, from the first on.
    pub fn own_numbers(&self) -> [bool; OF_ARM] {
        std::array::from_fn(|k| self.numbers.contains(&(k + 1)))
    }

    /// Whether the arm has four axes that a controller of six counts as 1, 2, 3 and 6: the two between are always 0.
    pub fn keeps_upright(&self) -> bool {
        self.numbered && self.numbers == UPRIGHT
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

/// Numbers, from 1, that all names of an arm tell: one digit after the same word (`J1`, `joint_a1`, `rax_1`), or the words of Universal
/// Robots (`base`, `shoulder`, `elbow`, `wrist1`; `shoulder_pan_joint`, ...); `None`: one tells none, or two tell the same.
fn numbers_by_name(names: &[&str]) -> Option<Vec<usize>> {
    let numbers = numbers_by_words(names).or_else(|| numbers_by_digit(names))?;
    let mut sorted = numbers.clone();
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1]).then_some(numbers)
}

/// By the last digit, which follows the same word in all names.
fn numbers_by_digit(names: &[&str]) -> Option<Vec<usize>> {
    let word = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).to_ascii_uppercase();
    let first = word(names.first()?);
    let number = |name: &&str| {
        let [digit @ b'1'..=b'6'] = name.as_bytes().get(first.len()..)? else { return None };
        (word(name) == first).then_some(usize::from(digit - b'0'))
    };
    names.iter().map(number).collect()
}

/// By the words of Universal Robots, with or without `_joint` after them and a name of the robot before them.
fn numbers_by_words(names: &[&str]) -> Option<Vec<usize>> {
    const WORDS: [(&str, usize); 8] = [
        ("SHOULDERPAN", 1),
        ("SHOULDERLIFT", 2),
        ("BASE", 1),
        ("SHOULDER", 2),
        ("ELBOW", 3),
        ("WRIST1", 4),
        ("WRIST2", 5),
        ("WRIST3", 6),
    ];
    let number = |name: &&str| {
        let bare: String = name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_uppercase();
        let bare = bare.strip_suffix("JOINT").unwrap_or(&bare);
        WORDS.iter().find(|w| bare.ends_with(w.0)).map(|w| w.1)
    };
    names.iter().map(number).collect()
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
        let numbers: Vec<usize> = (1..=6).collect();
        let six = Places { arm: (0..6).collect(), external: vec![], certain: true, numbers, numbered: true };
        assert_eq!(with(&[], &[]), six);
        let rail = Places { arm: (1..7).collect(), external: vec![(1, 0)], ..six.clone() };
        for name in ["E1", "eax_a", "J7", "joint_7", "rail"] {
            assert_eq!(with(&[(name, P)], &[]), rail, "{name}");
        }
        assert_eq!(with(&[("E2", R)], &[]).external(2), Some(0));
        let after = Places { external: vec![(1, 6), (2, 7)], ..six };
        assert_eq!(with(&[], &[("turn", R), ("tilt", R)]), after);
        assert!(!with(&[("x", P), ("y", P)], &[]).certain);
        assert!(!with(&[("E1", P), ("eax_a", R)], &[]).certain);
        assert!(!with(&[("E1", P), ("turn", R)], &[]).certain);
    }
    #[test]
    fn the_names_of_an_arm_tell_the_numbers_of_its_axes() {
        let of = |names: &[&'static str]| {
            let places = places(&names.iter().map(|n| (*n, JointKind::Revolute)).collect::<Vec<_>>());
            places.numbered.then_some(places.numbers)
        };
        assert_eq!(of(&["J1", "J2", "J3", "J6"]), Some(vec![1, 2, 3, 6]));
        assert_eq!(of(&["joint_a2", "joint_a1"]), Some(vec![2, 1]));
        assert_eq!(of(&["E1", "rax_1", "rax_6"]), Some(vec![1, 6]));
        assert_eq!(of(&["base", "shoulder", "elbow", "wrist2", "wrist3"]), Some(vec![1, 2, 3, 5, 6]));
        assert_eq!(
            of(&["ur5_shoulder_pan_joint", "ur5_shoulder_lift_joint", "ur5_wrist_1_joint"]),
            Some(vec![1, 2, 4])
        );
        assert_eq!(of(&["wrist1", "wrist2"]), Some(vec![4, 5]));
        assert_eq!(of(&["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"]), Some((1..=6).collect()));
        // six of any name stand in their order
        assert_eq!(of(&["S", "L", "U", "R", "B", "T"]), Some((1..=6).collect()));
        for unclear in
            [&["S", "L", "U", "T"][..], &["J1", "A2"], &["J1", "j1"], &["J12", "J23"], &["J0", "J1"], &["X", "J2"]]
        {
            assert_eq!(of(unclear), None, "{unclear:?}");
        }
        let upright = Axes::new("r", ["J1", "J2", "J3", "J6"].map(|n| Axis::new(n, JointKind::Revolute)).to_vec());
        assert!(upright.places().keeps_upright());
        assert_eq!((upright.places().number(3), upright.places().number(4)), (Some(6), None));
        assert_eq!(upright.places().own_numbers(), [true, true, true, false, false, true]);
    }
}
