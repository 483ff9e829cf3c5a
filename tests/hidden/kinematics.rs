//! Forward kinematics by 4x4 products in either Denavit-Hartenberg convention, gravity torques, and rigid fits.
//!
//! Shares no code with the crate: what is checked must not check itself.

use crate::robots::Robot;
use nalgebra::{Matrix3, Matrix4, Vector3};

/// A homogeneous transform.
pub type Pose = Matrix4<f64>;

pub const GRAVITY_M_S2: f64 = 9.80665;

pub fn translation(xyz_m: [f64; 3]) -> Pose {
    Pose::new_translation(&Vector3::from(xyz_m))
}

fn rot_x(a: f64) -> Pose {
    let (s, c) = a.sin_cos();
    Pose::new(1., 0., 0., 0., 0., c, -s, 0., 0., s, c, 0., 0., 0., 0., 1.)
}

fn rot_y(a: f64) -> Pose {
    let (s, c) = a.sin_cos();
    Pose::new(c, 0., s, 0., 0., 1., 0., 0., -s, 0., c, 0., 0., 0., 0., 1.)
}

fn rot_z(a: f64) -> Pose {
    let (s, c) = a.sin_cos();
    Pose::new(c, -s, 0., 0., s, c, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.)
}

/// Rotations about the fixed axes X, then Y, then Z (rad).
pub fn rpy(a: [f64; 3]) -> Pose {
    rot_z(a[2]) * rot_y(a[1]) * rot_x(a[0])
}

pub fn position(pose: &Pose) -> Vector3<f64> {
    Vector3::new(pose[(0, 3)], pose[(1, 3)], pose[(2, 3)])
}

pub fn apply(pose: &Pose, p: &Vector3<f64>) -> Vector3<f64> {
    pose.fixed_view::<3, 3>(0, 0) * p + position(pose)
}

/// The frames of an arm at one pose: the axis and origin of each joint, the frame of each link, the TCP.
pub struct Frames {
    pub axis: Vec<Vector3<f64>>,
    pub origin: Vec<Vector3<f64>>,
    /// Directions of x and y of each joint before its turn.
    pub across: Vec<[Vector3<f64>; 2]>,
    pub link: Vec<Pose>,
    pub tcp: Vector3<f64>,
}

/// Frames for joint values `q` (rad or m), in the base.
pub fn frames(robot: &Robot, tool: &Pose, q: &[f64]) -> Frames {
    let n = robot.joints.len();
    let mut f = Frames {
        axis: Vec::with_capacity(n),
        origin: Vec::with_capacity(n),
        across: Vec::with_capacity(n),
        link: Vec::with_capacity(n),
        tcp: Vector3::zeros(),
    };
    let mut at = Pose::identity();
    for (j, &value) in robot.joints.iter().zip(q) {
        let (mut theta, mut d) = (j.theta_rad, j.d_m);
        if j.revolute {
            theta += j.direction * value;
        } else {
            d += j.direction * value;
        }
        // The joint moves about (along) the z axis of the frame that stands before Rot_z Trans_z.
        let before = if robot.modified { at * rot_x(j.alpha_rad) * translation([j.a_m, 0., 0.]) } else { at };
        f.axis.push(before.fixed_view::<3, 1>(0, 2).into_owned());
        f.origin.push(position(&before));
        f.across.push([0, 1].map(|c| before.fixed_view::<3, 1>(0, c).into_owned()));
        at = before * rot_z(theta) * translation([0., 0., d]);
        if !robot.modified {
            at = at * translation([j.a_m, 0., 0.]) * rot_x(j.alpha_rad);
        }
        f.link.push(at);
    }
    f.tcp = position(&(at * tool));
    f
}

/// TCP in the base (m).
pub fn forward(robot: &Robot, tool: &Pose, q: &[f64]) -> Vector3<f64> {
    frames(robot, tool, q).tcp
}

/// Gravity torque (N m) or force (N) on joint `j`, positive where it turns the joint positive.
pub fn gravity_load(robot: &Robot, f: &Frames, j: usize) -> f64 {
    let mut load = 0.0;
    for (link, pose) in robot.links.iter().zip(&f.link).skip(j) {
        let weight = Vector3::new(0., 0., -GRAVITY_M_S2 * link.mass_kg);
        load += if robot.joints[j].revolute {
            (apply(pose, &link.com_m) - f.origin[j]).cross(&weight).dot(&f.axis[j])
        } else {
            weight.dot(&f.axis[j])
        };
    }
    load * robot.joints[j].direction
}

/// TCP velocity per unit speed of each joint.
pub fn jacobian(robot: &Robot, f: &Frames) -> Vec<Vector3<f64>> {
    (0..robot.joints.len())
        .map(|j| {
            let v = if robot.joints[j].revolute { f.axis[j].cross(&(f.tcp - f.origin[j])) } else { f.axis[j] };
            v * robot.joints[j].direction
        })
        .collect()
}

/// Moves `q`'s three arm joints until the TCP stands at `target` (Newton); false if it does not get there.
pub fn reach(robot: &Robot, tool: &Pose, q: &mut [f64], target: &Vector3<f64>) -> bool {
    for _ in 0..30 {
        let f = frames(robot, tool, q);
        let gap = target - f.tcp;
        if gap.norm() < 1e-12 {
            return true;
        }
        let all = jacobian(robot, &f);
        let cols = robot.arm.map(|j| all[j]);
        let Some(inverse) = Matrix3::from_columns(&cols).try_inverse() else { return false };
        let step = inverse * gap;
        for (k, &j) in robot.arm.iter().enumerate() {
            q[j] += step[k].clamp(-0.2, 0.2);
        }
        if gap.norm() < 1e-9 {
            return true;
        }
    }
    false
}

/// The rigid transform that brings `from` nearest to `to` in least squares (Kabsch 1976), over rows where both stand.
pub fn rigid_fit(from: &[Vector3<f64>], to: &[Option<Vector3<f64>>]) -> Pose {
    let pairs = || from.iter().zip(to).filter_map(|(a, b)| b.as_ref().map(|b| (a, b)));
    let n = pairs().count().max(1) as f64;
    let (sa, sb) = pairs().fold((Vector3::zeros(), Vector3::zeros()), |s, (a, b)| (s.0 + a, s.1 + b));
    let (ca, cb) = (sa / n, sb / n);
    let h: Matrix3<f64> = pairs().map(|(a, b)| (a - ca) * (b - cb).transpose()).sum();
    let svd = h.svd(true, true);
    let (u, v) = (svd.u.expect("asked for"), svd.v_t.expect("asked for").transpose());
    let sign = (v * u.transpose()).determinant().signum();
    let r = v * Matrix3::from_diagonal(&Vector3::new(1., 1., sign)) * u.transpose();
    let mut pose = Pose::identity();
    pose.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&(cb - r * ca));
    pose
}
