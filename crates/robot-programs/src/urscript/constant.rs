//! Values that a program computes from constants: numbers, poses, lists and structures, and what the functions of the language make of
//! poses.
//!
//! Reference: Universal Robots, The URScript Programming Language (`pose_trans`, `pose_inv`, `pose_add`, `pose_sub`, `interpolate_pose`;
//! a pose is three lengths in m and a rotation vector in rad).

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::rc::Rc;

/// A value that is the same whenever the program comes to it.
#[derive(Debug, Clone, PartialEq)]
pub enum Constant {
    Number(f64),
    /// m and rad (rotation vector).
    Pose([f64; 6]),
    List(Rc<[Constant]>),
    /// Members by name.
    Struct(Rc<[(String, Constant)]>),
}

/// The pose of six numbers.
pub fn isometry([x, y, z, rx, ry, rz]: [f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz)))
}

/// Six numbers of a pose, with a turn of at most half a turn.
fn numbers(pose: &Isometry3<f64>) -> [f64; 6] {
    let (at, turn) = (pose.translation.vector, pose.rotation.scaled_axis());
    [at.x, at.y, at.z, turn.x, turn.y, turn.z]
}

/// Nearer to half a turn than this, rad, the axis of a turn is not certain.
const HALF_TURN: f64 = 1e-6;

impl Constant {
    pub fn number(&self) -> Option<f64> {
        if let Self::Number(v) = self { Some(*v) } else { None }
    }

    fn pose(&self) -> Option<[f64; 6]> {
        if let Self::Pose(p) = self { Some(*p) } else { None }
    }

    /// Its numbers, if it is a list of numbers.
    pub fn list(&self) -> Option<Vec<f64>> {
        let Self::List(all) = self else { return None };
        all.iter().map(Self::number).collect()
    }

    /// A pose of six numbers.
    pub fn pose_of(all: &[Self]) -> Option<Self> {
        let numbers: Option<Vec<f64>> = all.iter().map(Self::number).collect();
        Some(Self::Pose(numbers?.try_into().ok()?))
    }

    /// An element of a pose or a list.
    pub fn element(&self, index: &Self) -> Option<Self> {
        let k = index.number().filter(|k| *k >= 0.0 && k.fract() == 0.0)? as usize;
        match self {
            Self::Pose(all) => all.get(k).copied().map(Self::Number),
            Self::List(all) => all.get(k).cloned(),
            _ => None,
        }
    }

    /// The same value with another element; `None`: it has no such element, or that is of another kind.
    pub fn with_element(&self, index: &Self, value: &Self) -> Option<Self> {
        let k = index.number().filter(|k| *k >= 0.0 && k.fract() == 0.0)? as usize;
        match self {
            Self::Pose(all) => {
                let mut all = *all;
                *all.get_mut(k)? = value.number()?;
                Some(Self::Pose(all))
            }
            Self::List(all) => {
                let mut all = all.to_vec();
                let place = all.get_mut(k)?;
                if std::mem::discriminant(place) != std::mem::discriminant(value) {
                    return None;
                }
                *place = value.clone();
                Some(Self::List(all.into()))
            }
            _ => None,
        }
    }

    /// A member of a structure.
    pub fn member(&self, name: &str) -> Option<Self> {
        let Self::Struct(all) = self else { return None };
        all.iter().find(|m| m.0 == name).map(|m| m.1.clone())
    }

    /// What a function of the language gives; `None`: not certain.
    pub fn of_function(name: &str, args: &[Self]) -> Option<Self> {
        let pose = |k: usize| args.get(k)?.pose();
        let number = |k: usize| args.get(k)?.number();
        match (name, args.len()) {
            ("d2r", 1) => Some(Self::Number(number(0)?.to_radians())),
            ("r2d", 1) => Some(Self::Number(number(0)?.to_degrees())),
            ("pose_trans", 2) => Some(Self::Pose(numbers(&(isometry(pose(0)?) * isometry(pose(1)?))))),
            ("pose_inv", 1) => Some(Self::Pose(numbers(&isometry(pose(0)?).inverse()))),
            ("pose_add", 2) => added(pose(0)?, pose(1)?, 1.0).map(Self::Pose),
            ("pose_sub", 2) => added(pose(0)?, pose(1)?, -1.0).map(Self::Pose),
            ("interpolate_pose", 3) => between(pose(0)?, pose(1)?, number(2)?).map(Self::Pose),
            _ => None,
        }
    }
}

/// A pose to which another one without a turn is added, or from which it is taken: how turns are added differs by the controller's version.
fn added(a: [f64; 6], b: [f64; 6], sign: f64) -> Option<[f64; 6]> {
    let [x, y, z] = [0, 1, 2].map(|k| a[k] + sign * b[k]);
    b[3..].iter().all(|v| *v == 0.0).then_some([x, y, z, a[3], a[4], a[5]])
}

/// The pose at a share of the way from one to another: straight, and by the turn about one axis.
fn between(from: [f64; 6], to: [f64; 6], share: f64) -> Option<[f64; 6]> {
    let (a, b) = (isometry(from), isometry(to));
    let turn = a.rotation.inverse() * b.rotation;
    if turn.angle() > std::f64::consts::PI - HALF_TURN {
        return None;
    }
    let at = a.translation.vector.lerp(&b.translation.vector, share);
    let rotation = a.rotation * UnitQuaternion::from_scaled_axis(turn.scaled_axis() * share);
    Some(numbers(&Isometry3::from_parts(at.into(), rotation)))
}
