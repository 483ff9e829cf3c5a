//! The forms in which languages write a pose, to and from their numbers.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// How a pose is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseForm {
    /// X, Y, Z, and the turns about the fixed X, Y, Z in this order: FANUC (W, P, R), INFORM (Rx, Ry, Rz).
    FixedXyz,
    /// X, Y, Z, and the turns about Z, the new Y, the new X in this order: KRL (A, B, C).
    EulerZyx,
    /// x, y, z and a quaternion, its real part first: RAPID.
    Quaternion,
    /// x, y, z and axis times angle: URScript.
    RotationVector,
}

/// Below this cosine of the middle angle the other two turn about one line.
const LOCKED: f64 = 1e-9;
/// Angles that stand there within half a turn (and the rounding of their digits) stay within it.
const HALF_TURN: f64 = PI + 1e-6;

impl PoseForm {
    /// Numbers of a pose.
    pub fn count(self) -> usize {
        if self == Self::Quaternion { 7 } else { 6 }
    }

    /// Whether number `k` is a length (m), an angle (rad), or neither.
    pub fn quantity(self, k: usize) -> Quantity {
        match self {
            _ if k < 3 => Quantity::Length,
            Self::Quaternion => Quantity::Ratio,
            _ => Quantity::Angle,
        }
    }

    /// SI value of the unit in which number `k` is written.
    pub fn unit(self, k: usize) -> f64 {
        match (self, self.quantity(k)) {
            (Self::RotationVector, _) | (_, Quantity::Ratio) => 1.0,
            (_, Quantity::Length) => 1e-3,
            (_, Quantity::Angle) => PI / 180.0,
        }
    }

    /// The pose of numbers in SI; `None`: too few of them, or a quaternion that is far from a unit one.
    pub fn pose(self, values: &[f64]) -> Option<Isometry3<f64>> {
        let [x, y, z, ref turn @ ..] = *values else { return None };
        let rotation = match (self, turn) {
            (Self::FixedXyz, [a, b, c]) | (Self::EulerZyx, [c, b, a]) => UnitQuaternion::from_euler_angles(*a, *b, *c),
            (Self::Quaternion, [w, x, y, z]) => {
                let q = Quaternion::new(*w, *x, *y, *z);
                UnitQuaternion::try_new(q, 0.1).filter(|q| q.coords.iter().all(|c| c.is_finite()))?
            }
            (Self::RotationVector, [x, y, z]) => UnitQuaternion::from_scaled_axis(Vector3::new(*x, *y, *z)),
            _ => return None,
        };
        Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
    }

    /// The numbers of a pose, in SI, nearest to `near` among those that mean the same.
    pub fn coordinates(self, pose: &Isometry3<f64>, near: &[f64]) -> Vec<f64> {
        let at = |k: usize| near.get(k).copied().unwrap_or(0.0);
        let mut out: Vec<f64> = pose.translation.vector.iter().copied().collect();
        match self {
            Self::FixedXyz => out.extend(euler(pose, [at(3), at(4), at(5)])),
            Self::EulerZyx => {
                let [a, b, c] = euler(pose, [at(5), at(4), at(3)]);
                out.extend([c, b, a]);
            }
            Self::Quaternion => {
                let own = Quaternion::new(at(3), at(4), at(5), at(6));
                let q = pose.rotation.quaternion();
                // a quaternion that was rounded to digits keeps its length
                let scale = if own.norm() > 0.5 { own.norm() } else { 1.0 };
                let sign = if own.dot(q) < 0.0 { -scale } else { scale };
                out.extend([q.w * sign, q.i * sign, q.j * sign, q.k * sign]);
            }
            Self::RotationVector => {
                let v = scaled_axis(&pose.rotation);
                let own = Vector3::new(at(3), at(4), at(5));
                let axis = v.try_normalize(1e-12).or_else(|| own.try_normalize(1e-12)).unwrap_or_default();
                let around = |k: i32| v + axis * (TAU * f64::from(k));
                let best = (-2..=2).map(around).min_by(|a, b| (a - own).norm().total_cmp(&(b - own).norm()));
                out.extend(best.unwrap_or(v).iter());
            }
        }
        out
    }
}

/// What a number of a pose is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Millimetres or inches in programs, m inside.
    Length,
    /// Degrees or radians in programs, rad inside.
    Angle,
    /// Without a unit: a part of a quaternion.
    Ratio,
}

/// Axis times angle, with digits at half a turn.
fn scaled_axis(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (w, v) = (q.w * sign, Vector3::new(q.i, q.j, q.k) * sign);
    let sine = v.norm();
    if sine < 1e-12 { v * 2.0 } else { v * (2.0 * sine.atan2(w) / sine) }
}

/// Turns about the fixed X, Y, Z, nearest to `near`.
fn euler(pose: &Isometry3<f64>, near: [f64; 3]) -> [f64; 3] {
    let rotation: Rotation3<f64> = pose.rotation.to_rotation_matrix();
    let m: &Matrix3<f64> = rotation.matrix();
    let level = m[(0, 0)].hypot(m[(1, 0)]);
    let b = (-m[(2, 0)]).atan2(level);
    let candidates = if level < LOCKED {
        // a and c turn about one line: a stays, c takes all
        let a = near[0];
        let sum = (-m[(0, 1)]).atan2(m[(1, 1)]);
        vec![[a, b, if b > 0.0 { sum + a } else { sum - a }]]
    } else {
        let (a, c) = (m[(2, 1)].atan2(m[(2, 2)]), m[(1, 0)].atan2(m[(0, 0)]));
        vec![[a, b, c], [a + PI, PI - b, c + PI]]
    };
    let beside = |angles: [f64; 3]| {
        let mut out = angles;
        for (v, n) in out.iter_mut().zip(near) {
            *v -= ((*v - n) / TAU).round() * TAU;
            if n.abs() <= HALF_TURN && v.abs() > HALF_TURN {
                *v -= v.signum() * TAU;
            }
        }
        out
    };
    let distance = |angles: &[f64; 3]| {
        angles.iter().zip(near).map(|(v, n)| ((v - n) - ((v - n) / TAU).round() * TAU).abs()).sum::<f64>()
    };
    let all = candidates.into_iter().map(beside);
    all.min_by(|x, y| distance(x).total_cmp(&distance(y))).unwrap_or([0.0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FORMS: [PoseForm; 4] =
        [PoseForm::FixedXyz, PoseForm::EulerZyx, PoseForm::Quaternion, PoseForm::RotationVector];

    fn same(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
        (a.translation.vector - b.translation.vector).norm() < 1e-12 && a.rotation.angle_to(&b.rotation) < 1e-7
    }

    proptest! {
        #[test]
        fn numbers_of_a_pose_come_back(k in 0..4usize, v in prop::collection::vec(-3.1..3.1f64, 6)) {
            let rotation = UnitQuaternion::from_euler_angles(v[3], v[4], v[5]);
            let pose = Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation);
            let own = FORMS[k].coordinates(&pose, &[0.0; 7]);
            prop_assert_eq!(own.len(), FORMS[k].count());
            prop_assert!(same(&FORMS[k].pose(&own).unwrap(), &pose));
            // what stands there already is what comes back
            let again = FORMS[k].coordinates(&pose, &own);
            prop_assert!(own.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} {:?}", own, again);
        }

        #[test]
        fn a_small_turn_changes_numbers_by_little(k in 0..4usize, v in prop::collection::vec(-1.4..1.4f64, 6)) {
            let rotation = UnitQuaternion::from_euler_angles(v[3], v[4], v[5]);
            let pose = Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation);
            let own = FORMS[k].coordinates(&pose, &[0.0; 7]);
            let turned = pose * UnitQuaternion::from_scaled_axis(Vector3::new(1e-5, -1e-5, 1e-5));
            let new = FORMS[k].coordinates(&turned, &own);
            prop_assert!(own.iter().zip(&new).all(|(a, b)| (a - b).abs() < 2e-4), "{:?} {:?}", own, new);
        }
    }

    /// KUKA: A 90, B 0, C 90 turns x into y, then tilts: the tool's z points along the base's x.
    #[test]
    fn angles_mean_what_their_makers_say() {
        let turn = PI / 2.0;
        let kuka = PoseForm::EulerZyx.pose(&[0.0, 0.0, 0.0, turn, 0.0, turn]).unwrap();
        assert!((kuka * Vector3::z() - Vector3::x()).norm() < 1e-12, "{}", kuka * Vector3::z());
        // FANUC W 180, P 0, R 0: the tool looks down, its x along the world's
        let fanuc = PoseForm::FixedXyz.pose(&[0.0, 0.0, 0.0, PI, 0.0, 0.0]).unwrap();
        assert!(
            (fanuc * Vector3::z() + Vector3::z()).norm() < 1e-12
                && (fanuc * Vector3::x() - Vector3::x()).norm() < 1e-12
        );
        // RAPID [0, 0, 1, 0]: half a turn about y
        let rapid = PoseForm::Quaternion.pose(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        assert!(
            (rapid * Vector3::x() + Vector3::x()).norm() < 1e-12
                && (rapid * Vector3::y() - Vector3::y()).norm() < 1e-12
        );
        // URScript p[0, 0, 0, 0, 3.14159..., 0]: the same
        let ur = PoseForm::RotationVector.pose(&[0.0, 0.0, 0.0, 0.0, PI, 0.0]).unwrap();
        assert!((ur * Vector3::x() + Vector3::x()).norm() < 1e-12);
    }

    #[test]
    fn a_locked_middle_angle_keeps_the_first_and_half_turns_stay_within_half_a_turn() {
        let own = [0.0, 0.0, 0.0, 0.3, PI / 2.0, -0.2];
        let pose = PoseForm::FixedXyz.pose(&own).unwrap();
        let again = PoseForm::FixedXyz.coordinates(&pose, &own);
        assert!(same(&PoseForm::FixedXyz.pose(&again).unwrap(), &pose) && (again[3] - 0.3).abs() < 1e-9, "{again:?}");
        let own = [0.0, 0.0, 0.0, PI - 1e-5, 0.0, 0.0];
        let pose =
            PoseForm::FixedXyz.pose(&own).unwrap() * UnitQuaternion::from_scaled_axis(Vector3::new(5e-5, 0.0, 0.0));
        let new = PoseForm::FixedXyz.coordinates(&pose, &own);
        assert!((new[3] + PI - 4e-5).abs() < 1e-9, "{new:?}");
    }

    #[test]
    fn a_rounded_quaternion_keeps_its_length_and_sign() {
        let own = [0.0, 0.0, 0.0, -0.60001, 0.0, 0.80001, 0.0];
        let pose = PoseForm::Quaternion.pose(&own).unwrap();
        let again = PoseForm::Quaternion.coordinates(&pose, &own);
        assert!(own.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12), "{again:?}");
    }
}
