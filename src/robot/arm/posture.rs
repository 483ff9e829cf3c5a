//! Posture of an arm with a spherical wrist: what makers' configurations name.
//!
//! Seen from the side towards which the arm reaches at all joints zero:
//! - front: the wrist's centre is on that side of axis 1; else it is behind it (KUKA: overhead area).
//! - elbow up: the forearm is bent forward from the line of the upper arm, so that the elbow stands above the line from
//!   shoulder to wrist where the arm is in front.

use super::{Arm, Form};
use nalgebra::Vector3;

/// Posture, with how far it is from its borders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posture {
    /// Distance of the wrist's centre from axis 1 towards the front, m; negative: behind.
    pub front_m: f64,
    /// Sine of the bend of the elbow; positive: up.
    pub elbow: f64,
}

impl Arm {
    /// Posture at `q` (rad); `None`: the arm has no spherical wrist, or does not reach to a side at zero.
    pub fn posture(&self, q: &[f64]) -> Option<Posture> {
        let Form::Spherical(centre) = self.form else { return None };
        let [one, two, three, ..] = &self.lines;
        let side = two.direction.cross(&one.direction);
        let at_zero = side.dot(&(centre - one.point));
        let forward: Vector3<f64> = side.try_normalize(1e-6).filter(|_| at_zero.abs() > 1e-6)? * at_zero.signum();
        let x = self.turns(q);
        let elbow = two.turned(x[1], &three.point);
        let wrist = two.turned(x[1], &three.turned(x[2], &centre));
        let n = two.direction;
        let across = |v: Vector3<f64>| v - n * n.dot(&v);
        let upper = across(elbow - two.point).try_normalize(1e-9)?;
        let fore = across(wrist - elbow).try_normalize(1e-9)?;
        // on all arms axis 2 leans the upper arm forward where its value grows; the base may stand on its head, or only the frame in which
        // its file begins
        let bend = n.dot(&upper.cross(&fore)) * self.gains[(1, 1)].signum();
        Some(Posture { front_m: forward.dot(&(wrist - one.point)), elbow: bend })
    }
}
