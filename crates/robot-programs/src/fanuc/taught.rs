//! The positions of `/POS` as targets of the script, and what they say of axes that are none of the robot's.

use super::positions::{Field, Position, is_extended, is_joint};
use super::reason::Reason;
use crate::axes::{Axes, JointKind, Places};
use crate::error::Result;
use crate::script::{self, At, PoseForm, PoseGoal, Target, Targets, Text, Value, number};
use std::collections::HashMap;

/// The finest weight of a digit in a position: the controller writes three decimals, deg or mm. A number that stands there
/// with more keeps them.
pub(super) const FINEST: f64 = 1e-3;

/// Positions as targets. Lists without another word have one entry per position.
pub(super) struct Taught {
    pub positions: Vec<Position>,
    /// Position by its index.
    pub by_index: HashMap<u64, usize>,
    pub targets: Targets,
    /// Position of each target.
    pub of_target: Vec<usize>,
    /// Target of each position's joints; why there is none.
    pub joints: Vec<std::result::Result<usize, script::Reason>>,
    /// Target of each Cartesian position.
    poses: Vec<Option<usize>>,
    /// What each position says of axes that are not the robot's, and whether all say the same.
    pub extras: Vec<Vec<u8>>,
    pub idle: bool,
}

impl Taught {
    pub fn of(text: &Text, robot: &Axes, positions: Vec<Position>) -> Result<Self> {
        let mut taught = Self {
            by_index: HashMap::new(),
            targets: Targets::of_text(text),
            of_target: Vec::new(),
            joints: Vec::with_capacity(positions.len()),
            poses: Vec::with_capacity(positions.len()),
            extras: Vec::with_capacity(positions.len()),
            idle: false,
            positions: Vec::new(),
        };
        for (i, p) in positions.iter().enumerate() {
            if taught.by_index.insert(p.index, i).is_some() {
                return Err(text.bad(p.head.start, format!("a second P[{}]", p.index), "each position once"));
            }
            taught.add(text, robot, i, p)?;
            taught.extras.push(extras(text, robot, p));
        }
        taught.idle = taught.extras.windows(2).all(|w| w[0] == w[1]);
        taught.positions = positions;
        Ok(taught)
    }

    /// The target of position `i`.
    fn add(&mut self, text: &Text, robot: &Axes, i: usize, p: &Position) -> Result<()> {
        let mut pose = None;
        let joints = if !p.ours {
            Err(Reason::NoGroup(p.index).into())
        } else if p.untaught() {
            Err(Reason::NotTaught(p.index).into())
        } else if p.is_joints() {
            match robot.places() {
                places if !places.certain => Err(script::Reason::unclear_axes(&robot.axis_names())),
                places if !places.numbered && p.arm_fields() != places.arm.len() => {
                    Err(script::Reason::unclear_numbers(&robot.axis_names()))
                }
                places => Ok(self.push(i, target(text, robot, p, places)?)),
            }
        } else if let Some(target) = coordinates(p, robot) {
            pose = Some(self.push(i, target));
            Err(Reason::Cartesian.into())
        } else {
            Err(Reason::NeitherJointsNorPose(p.index).into())
        };
        self.joints.push(joints);
        self.poses.push(pose);
        Ok(())
    }

    /// The target of a register's joints, deg, at a motion's line: numbers that do not stand in the program.
    pub fn stands(&mut self, register: u64, line: u64, deg: [f64; 6]) -> usize {
        let style = number::read(b"0.000").map(|n| n.1).unwrap_or_default();
        let value = |deg: f64| {
            Some(Value {
                si: deg.to_radians(),
                start: 0,
                end: 0,
                style,
                digit: FINEST.to_radians(),
                finest: FINEST.to_radians(),
            })
        };
        let values = deg.map(value).to_vec();
        let target = Target { name: Some(format!("PR[{register}]")), at: At { file: 0, line }, values, pose: None };
        self.push(usize::MAX, target)
    }

    fn push(&mut self, position: usize, target: Target) -> usize {
        self.targets.push(target);
        self.of_target.push(position);
        self.targets.len() - 1
    }

    /// The Cartesian target of a position.
    pub fn pose(&self, position: usize, robot: &Axes) -> Option<PoseGoal> {
        let target = self.poses.get(position).copied().flatten()?;
        self.positions.get(position)?.pose(target, robot)
    }

    /// Whether the other groups of all positions stand at one place: what they carry does not move.
    pub fn leader_stands(&self) -> bool {
        self.idle && self.positions.iter().all(|p| !p.others.is_empty())
    }
}

/// What a position says of other groups and further axes, for comparison.
fn extras(text: &Text, robot: &Axes, p: &Position) -> Vec<u8> {
    let mut other = p.others.clone();
    let own: Vec<&Field> = match p.is_joints() {
        true => p.fields_of(robot.places()).unwrap_or_default(),
        false => p.placed(robot).into_iter().map(|f| f.1).collect(),
    };
    let mut axes = p.fields.iter().filter(|f| is_joint(f.name()) || is_extended(f.name()));
    if axes.all(|f| own.iter().any(|o| std::ptr::eq(*o, f))) {
        // nearly always: all of them are the robot's
        return other;
    }
    for f in p.axes().into_iter().filter(|f| own.iter().all(|o| o.name() != f.name())) {
        other.extend_from_slice(text.slice(f.field).trim_ascii());
        other.push(b' ');
    }
    other
}

/// The joints of a position, as many as the robot has axes.
fn target(text: &Text, robot: &Axes, p: &Position, places: &Places) -> Result<Target> {
    let axes = match p.fields_of(places) {
        Ok(axes) => axes,
        Err(missing) => {
            let found = format!("{} joint values in P[{}], and no `{missing}`", p.axes().len(), p.index);
            return Err(text.bad(p.head.start, found, format!("{}: one for each axis of the robot", robot.dof())));
        }
    };
    let mut values = Vec::with_capacity(robot.dof());
    for (field, joint) in axes.into_iter().zip(robot.axis_joints()) {
        let mm = joint.kind == JointKind::Prismatic;
        if field.mm != mm {
            let found = format!("`{}` in {}", field.name(), if field.mm { "mm" } else { "deg" });
            return Err(text.bad(
                field.number.start(),
                found,
                format!("{} for axis {}", joint.kind.unit(), joint.name),
            ));
        }
        values.push(field.value().map(|(value, style)| Value {
            si: value * joint.kind.si_per_user_unit(),
            start: field.number.start(),
            end: field.number.end(),
            style,
            digit: number::last_digit(style.decimals) * joint.kind.si_per_user_unit(),
            finest: FINEST.min(number::last_digit(style.decimals)) * joint.kind.si_per_user_unit(),
        }));
    }
    Ok(Target { name: Some(format!("P[{}]", p.index)), at: At { file: 0, line: p.line }, values, pose: None })
}

/// The numbers of a Cartesian position.
fn coordinates(p: &Position, robot: &Axes) -> Option<Target> {
    let form = PoseForm::FixedXyz;
    let value = |(k, field): (usize, &Field)| {
        let (value, style) = field.value()?;
        let (unit, digit) = (form.unit(k), number::last_digit(style.decimals));
        let (start, end) = (field.number.start(), field.number.end());
        Some(Value { si: value * unit, start, end, style, digit: digit * unit, finest: FINEST.min(digit) * unit })
    };
    let mut values: Vec<Option<Value>> = p.coordinates()?.into_iter().enumerate().map(value).collect();
    for (axis, field) in p.placed(robot) {
        let unit = robot.axis(axis).kind.si_per_user_unit();
        let (value, style) = field.value()?;
        let digit = number::last_digit(style.decimals);
        let (start, end) = (field.number.start(), field.number.end());
        values.push(Some(Value {
            si: value * unit,
            start,
            end,
            style,
            digit: digit * unit,
            finest: FINEST.min(digit) * unit,
        }));
    }
    let at = At { file: 0, line: p.line };
    Some(Target { name: Some(format!("P[{}]", p.index)), at, values, pose: Some(form) })
}

/// Whether the file leaves the zero before the point off, as older controllers do.
pub(super) fn bare(positions: &[Position]) -> bool {
    let values = || positions.iter().flat_map(|p| &p.fields).filter_map(Field::value);
    values().any(|v| v.1.bare) || !values().any(|v| v.0.abs() < 1.0)
}
