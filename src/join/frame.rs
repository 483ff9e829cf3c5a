//! Where a fit begins.

use super::search::Seen;
use crate::numerics::rigid;
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::{Rotation3, Vector3};

/// Where a fit begins: the frame of the tracker by a rigid fit of the paths, and the middle of the readings, s.
pub(super) struct Frame {
    pub rotation: Rotation3<f64>,
    pub translation_m: Vector3<f64>,
    pub middle_s: f64,
}

impl Frame {
    pub(super) fn of(robot: &Robot, commands: &Series, seen: &Seen, rows: &[usize], start_s: f64) -> Option<Self> {
        let n = commands.channels();
        let (mut q, mut rate) = (vec![0.0; n], vec![0.0; n]);
        let mut pairs = Vec::with_capacity(rows.len());
        for &k in rows {
            if commands.at(seen.t_s[k] + start_s, &mut q, &mut rate) {
                pairs.push((robot.tcp_m(&q), seen.at_m[k], 1.0));
            }
        }
        let found = rigid::fit(pairs.iter().copied(), false)?;
        let middle_s = 0.5 * (seen.t_s[*rows.first()?] + seen.t_s[*rows.last()?]);
        Some(Self {
            rotation: Rotation3::from_matrix_unchecked(found.rotation),
            translation_m: found.translation,
            middle_s,
        })
    }
}
