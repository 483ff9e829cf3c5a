//! All joint vectors that bring a six-axis arm to a pose.
//!
//! Method: the axes are read off the chain as lines at all joints zero, so that the pose is a product of rotations about fixed
//! lines (Brockett 1984; Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 3). Two families
//! have a closed form, which takes in nearly all industrial arms:
//! - [`Form::Spherical`]: axes 4, 5, 6 meet in one point and axes 2 and 3 are parallel (KUKA, ABB, FANUC, Yaskawa). The wrist's
//!   centre gives joint 1, the triangle shoulder - elbow - wrist joints 2 and 3, the rotation that is left joints 4 to 6.
//! - [`Form::Parallel`]: axes 2, 3, 4 are parallel and axes 5 and 6 meet (Universal Robots). Their meeting point gives joint 1,
//!   the rotation joints 5, 6 and the sum of 2 to 4, the triangle joints 2 and 3.
//!
//! Both have up to eight solutions. Arms that miss the form by less than [`MEETS_M`] and [`PARALLEL`] (calibrated ones) are taken
//! as that form, and every solution is then brought onto the arm's own geometry by the numerical inverse. Joints that follow
//! others about the same line (the elbow of FANUC arms) are taken in by a matrix from commands to turns. Other six-axis arms are
//! solved numerically from a fixed set of starts ([`numeric`]), which may miss solutions.
//!
//! Accuracy: a solution that is returned reaches the pose within [`REACHED_M`] and [`REACHED_RAD`], by forward kinematics.
//! Where a solution is singular (axis 4 on axis 6; wrist on axis 1) the free angle is that of the joints `near`.
//!
//! In this folder: [`lines`] (rotations about lines, the two equations), [`closed`] (the two families), [`numeric`], [`posture`]
//! (front or rear, elbow, wrist: what makers' configurations name).

pub mod closed;
mod lines;
mod numeric;
pub mod posture;

use super::inverse::rotation_vector;
use super::{InverseOptions, JointKind, Pose, Robot, Target};
use lines::Line;
use nalgebra::{Isometry3, Matrix6, Point3, Rotation3, UnitQuaternion, Vector3, Vector6};
use std::f64::consts::TAU;

/// A pose counts as reached within these, m and rad.
pub const REACHED_M: f64 = 1e-9;
/// Largest rotation error of a solution, rad.
pub const REACHED_RAD: f64 = 1e-9;
/// Axes that pass each other closer than this meet, m.
const MEETS_M: f64 = 5e-3;
/// Axes whose directions differ by less are parallel: sine of the angle.
const PARALLEL: f64 = 0.02;
/// Solutions closer than this in every joint are one, rad.
const SAME_RAD: f64 = 1e-6;

/// A six-axis arm, prepared for the inverse.
#[derive(Debug, Clone)]
pub struct Arm {
    lines: [Line; 6],
    /// Turns about the lines by commands: `turns = gains * q`.
    gains: Matrix6<f64>,
    commands: Matrix6<f64>,
    /// Pose at all joints zero.
    zero: Isometry3<f64>,
    form: Form,
}

/// What makes the inverse solvable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// The wrist's centre at all joints zero.
    Spherical(Vector3<f64>),
    /// Where axes 5 and 6 meet at all joints zero.
    Parallel(Vector3<f64>),
    /// No closed form: joints are found numerically.
    General,
}

impl Arm {
    /// The arm of a robot; `None`: it does not have six revolute axes, each with its own command.
    pub fn of(robot: &Robot) -> Option<Self> {
        if robot.dof() != 6 || robot.joints.iter().any(|j| j.kind != JointKind::Revolute) {
            return None;
        }
        let q = [0.0; 6];
        let mut lines: Vec<Line> = Vec::new();
        let mut gains = Matrix6::zeros();
        let mut fits = true;
        robot.chain().frames(&q, |joint, [_, _, z, o]| {
            let line = Line { direction: *z, point: *o };
            let same = lines.last().is_some_and(|l| l.is_same(&line));
            if !same {
                lines.push(line);
            }
            let (axis, gain) = robot.chain().drive_of(joint);
            let (Some(row), Some(last)) = (lines.len().checked_sub(1).filter(|r| *r < 6), lines.last()) else {
                fits = false;
                return;
            };
            gains[(row, axis)] += gain * last.direction.dot(z).signum();
        });
        let lines: [Line; 6] = lines.try_into().ok().filter(|_| fits)?;
        // a whole turn of a command must be whole turns about the lines
        let whole = gains.iter().all(|g: &f64| (g - g.round()).abs() < 1e-9);
        let commands = gains.try_inverse().filter(|_| whole)?;
        let form = form(&lines);
        Some(Self { lines, gains, commands, zero: isometry(&robot.forward(&q)), form })
    }

    /// How the joints of a pose are found.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Every solution, each joint by the whole turns nearest to `near` (rad); sorted, none twice.
    pub fn solutions(&self, robot: &Robot, pose: &Pose, near: &[f64]) -> Vec<Vec<f64>> {
        let target = isometry(pose);
        let mut found: Vec<Vec<f64>> = Vec::new();
        let starts = match self.form {
            Form::General => return numeric::solutions(robot, pose, near),
            _ => self.closed(&target, &self.turns(near)),
        };
        for turns in starts {
            let mut q: Vec<f64> = (self.commands * turns).iter().copied().collect();
            nearest_turns(&mut q, near);
            let Some(mut q) = polished(robot, pose, q) else { continue };
            nearest_turns(&mut q, near);
            let same = |other: &Vec<f64>| other.iter().zip(&q).all(|(a, b)| (a - b).abs() < SAME_RAD);
            if !found.iter().any(same) {
                found.push(q);
            }
        }
        found.sort_by(|a, b| {
            a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        });
        found
    }

    /// The solution nearest to `near` (largest distance of a joint), each joint by the whole turns nearest to it: as
    /// [`Self::solutions`] has it, without working out the others.
    pub fn nearest(&self, robot: &Robot, pose: &Pose, near: &[f64]) -> Option<Vec<f64>> {
        let far = |q: &[f64]| q.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if self.form == Form::General {
            return numeric::solutions(robot, pose, near).into_iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        }
        let command = |turns: Vector6<f64>| {
            let mut q: Vec<f64> = (self.commands * turns).iter().copied().collect();
            nearest_turns(&mut q, near);
            q
        };
        let mut starts: Vec<Vec<f64>> =
            self.closed(&isometry(pose), &self.turns(near)).into_iter().map(command).collect();
        starts.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let mut q = starts.into_iter().find_map(|q| polished(robot, pose, q))?;
        nearest_turns(&mut q, near);
        Some(q)
    }

    /// Turns about the lines for commands.
    fn turns(&self, q: &[f64]) -> Vector6<f64> {
        let at = |k: usize| q.get(k).copied().unwrap_or(0.0);
        self.gains * Vector6::new(at(0), at(1), at(2), at(3), at(4), at(5))
    }
}

/// Moves each angle by whole turns next to that of `near`.
pub fn nearest_turns(q: &mut [f64], near: &[f64]) {
    for (v, n) in q.iter_mut().zip(near) {
        *v -= ((*v - n) / TAU).round() * TAU;
    }
}

/// A solution on the arm's own geometry; `None`: it is no solution there.
fn polished(robot: &Robot, pose: &Pose, q: Vec<f64>) -> Option<Vec<f64>> {
    let reached = |q: &[f64]| {
        let is = robot.forward(q);
        let turned = rotation_vector(&(pose.rotation.matrix() * is.rotation.matrix().transpose())).norm();
        (is.position - pose.position).norm() <= REACHED_M && turned <= REACHED_RAD
    };
    if reached(&q) {
        return Some(q);
    }
    let options = InverseOptions {
        target_error_m: REACHED_M * 1e-2,
        target_error_rad: REACHED_RAD * 1e-2,
        max_iterations: 20,
        ..InverseOptions::default()
    };
    let found = robot.inverse(&Target::Pose(*pose), &q, &options).q;
    reached(&found).then_some(found)
}

/// The form of six lines.
fn form(lines: &[Line; 6]) -> Form {
    let [_, two, three, four, five, six] = lines;
    let parallel = |a: &Line, b: &Line| a.direction.cross(&b.direction).norm() < PARALLEL;
    let Some(meeting) = five.meets(six, MEETS_M) else { return Form::General };
    if parallel(two, three) && parallel(three, four) && !parallel(four, five) {
        return Form::Parallel(meeting);
    }
    let on_four = four.distance(&meeting) < MEETS_M;
    if parallel(two, three) && on_four && !parallel(four, five) && !parallel(&lines[0], two) {
        return Form::Spherical(meeting);
    }
    Form::General
}

/// A pose as an isometry.
pub fn isometry(pose: &Pose) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*pose.rotation.matrix()));
    Isometry3::from_parts(pose.position.into(), rotation)
}

/// An isometry as a pose.
pub fn pose_of(isometry: &Isometry3<f64>) -> Pose {
    Pose { position: isometry.translation.vector, rotation: isometry.rotation.to_rotation_matrix() }
}

fn moved(isometry: &Isometry3<f64>, point: &Vector3<f64>) -> Vector3<f64> {
    isometry.transform_point(&Point3::from(*point)).coords
}

#[cfg(test)]
mod tests;
