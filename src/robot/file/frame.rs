//! A frame in a document: millimetres and degrees.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A frame at the edges: fixed-axis X, then Y, then Z; degrees and millimetres.
#[derive(Debug, Clone, Serialize, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameFile {
    /// Position, mm.
    #[serde(default)]
    pub xyz_mm: [f64; 3],
    /// Roll, pitch, yaw, deg: rotations about the fixed axes x, y, z in this order.
    #[serde(default)]
    pub rpy_deg: [f64; 3],
}

impl FrameFile {
    /// To SI.
    pub fn to_isometry(&self) -> Isometry3<f64> {
        let [r, p, y] = self.rpy_deg.map(f64::to_radians);
        Isometry3::from_parts((Vector3::from(self.xyz_mm) * 1e-3).into(), UnitQuaternion::from_euler_angles(r, p, y))
    }

    /// Whether it neither moves nor turns.
    pub(in crate::robot) fn is_still(&self) -> bool {
        [self.xyz_mm, self.rpy_deg].iter().flatten().all(|v| *v == 0.0)
    }

    /// From SI. Where the pitch is a quarter turn, roll and yaw turn about one axis: the yaw is written as 0.
    pub fn from_isometry(frame: &Isometry3<f64>) -> Self {
        let m = frame.rotation.to_rotation_matrix();
        let level = m[(0, 0)].hypot(m[(1, 0)]);
        let pitch = (-m[(2, 0)]).atan2(level);
        let (roll, yaw) = if level < 1e-12 {
            (pitch.signum() * m[(0, 1)].atan2(m[(1, 1)]), 0.0)
        } else {
            (m[(2, 1)].atan2(m[(2, 2)]), m[(1, 0)].atan2(m[(0, 0)]))
        };
        // -0.0 + 0.0 is 0.0
        let rpy_deg = [roll, pitch, yaw].map(|v| v.to_degrees() + 0.0);
        Self { xyz_mm: (frame.translation.vector * 1e3).into(), rpy_deg }
    }
}
