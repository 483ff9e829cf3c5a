//! Clock, frame of the tracker and reflector: what a fit estimates whatever its joints do.

use super::frame::Frame;
use crate::robot::Robot;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Standard deviations of the priors: reflector in the flange frame, m; zero offset and half gap, rad or m.
const TOOL_M: f64 = 1.0;
const ZERO: f64 = 0.01;
const GAP: f64 = 0.002;
/// A half gap up to this, rad or m, is none: its side is followed, its crossing is not.
pub(super) const NO_GAP: f64 = 1e-6;
/// Offset, drift, rotation, translation, reflector.
pub(super) const COMMON: usize = 11;

/// One linearised row: residual, and derivatives of the prediction.
pub(super) struct Row {
    pub residual: Vector3<f64>,
    pub columns: Vec<Vector3<f64>>,
}

/// Where two clocks, the tracker and its reflector are.
pub(super) struct Placement {
    /// Controller's time minus the tracker's in the middle, s.
    pub offset_s: f64,
    pub drift: f64,
    pub middle_s: f64,
    rotation: Rotation3<f64>,
    translation_m: Vector3<f64>,
    tool_m: Vector3<f64>,
}

impl Placement {
    /// The frame as it is, the reflector at the TCP.
    pub fn begin(frame: &Frame, start_s: f64) -> Self {
        Self {
            offset_s: start_s,
            drift: 0.0,
            middle_s: frame.middle_s,
            rotation: frame.rotation,
            translation_m: frame.translation_m,
            tool_m: Vector3::zeros(),
        }
    }

    /// Offset, s, drift, and the tracker's time at which the offset holds, s.
    pub fn clock(&self) -> [f64; 3] {
        [self.offset_s, self.drift, self.middle_s]
    }

    /// The controller's time of a reading at the tracker's time `t`, s.
    pub fn controller_s(&self, t: f64) -> f64 {
        t + self.offset_s + self.drift * (t - self.middle_s)
    }

    /// A reading at the tracker's time `t` of joints at `q` that move by `rate`, with the [`COMMON`] derivatives; and how far each joint
    /// moves the prediction.
    pub fn row(&self, robot: &Robot, q: &[f64], rate: &[f64], t: f64, at: &Vector3<f64>) -> (Row, Vec<Vector3<f64>>) {
        let (pose, geometric) = robot.chain().jacobian(q);
        let turned = *self.rotation.matrix();
        let reflector = pose.rotation * self.tool_m;
        let point = pose.position + reflector;
        let jacobian: Vec<Vector3<f64>> = (geometric.column_iter())
            .map(|c| Vector3::new(c[0], c[1], c[2]) + Vector3::new(c[3], c[4], c[5]).cross(&reflector))
            .collect();
        let velocity: Vector3<f64> = jacobian.iter().zip(rate).map(|(c, r)| c * *r).sum();
        let mut columns = Vec::with_capacity(COMMON + 6 * q.len());
        columns.extend([turned * velocity, turned * velocity * (t - self.middle_s)]);
        let lever = turned * point;
        columns.extend([Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis.cross(&lever)));
        columns.extend([Vector3::x(), Vector3::y(), Vector3::z()]);
        let frame: Matrix3<f64> = turned * pose.rotation.matrix();
        columns.extend((0..3).map(|k| frame.column(k).into_owned()));
        let levers = jacobian.iter().map(|c| turned * c).collect();
        (Row { residual: at - lever - self.translation_m, columns }, levers)
    }

    /// Takes the part of a step that is in common.
    pub fn moved(&mut self, step: &[f64]) {
        self.offset_s += step[0];
        self.drift += step[1];
        self.rotation = Rotation3::new(Vector3::new(step[2], step[3], step[4])) * self.rotation;
        self.translation_m += Vector3::new(step[5], step[6], step[7]);
        self.tool_m += Vector3::new(step[8], step[9], step[10]);
    }

    /// Deviations from the priors with the inverse variances, in the order of the parameters: `drift` is that of the drift; then zero
    /// offsets and gaps of the joints.
    pub fn priors(&self, drift: (f64, f64), zero: &[f64], gap: &[f64]) -> Vec<(f64, f64)> {
        let frame = std::iter::repeat_n((0.0, 0.0), 6);
        let tool = self.tool_m.iter().map(|v| (*v, TOOL_M.powi(-2)));
        let zero = zero.iter().map(|v| (*v, ZERO.powi(-2)));
        [(0.0, 0.0), drift].into_iter().chain(frame).chain(tool).chain(zero).chain(of_gaps(gap)).collect()
    }
}

/// Deviations of half gaps, or of what is as large as one, from their priors, with the inverse variances.
pub(super) fn of_gaps(values: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    values.iter().map(|v| (*v, GAP.powi(-2)))
}
