//! The measured orientation of the tool in a log, as three numbers a row beside the three of its position.
//!
//! What the chain predicts are points: the flange's centre and a point on each of two axes of the probe, 1 m off it. How the
//! movements of these points turn the probe is linear: a turn `w` moves the points by `w x e1` and `w x e2` beyond what moves all
//! three, so that `w = e1 (d2 . e3) - e2 (d1 . e3) + e3 (d1 . e2 - d2 . e1) / 2`. The map is applied alike to what was measured less
//! what was predicted and to every sensitivity, so that its axes need be known roughly alone. The place of the TCP is not in it: the
//! noise of an orientation is estimated apart from that of a position, and neither counts twice.
//!
//! How the probe sits on the tool is not known: three angles are estimated for all logs together.

use crate::log::Log;
use crate::robot::Robot;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Points of the flange that tell the orientation: they stand after the TCP in the list of points.
pub const POINTS: std::ops::Range<usize> = 1..4;

/// Orientations of a log.
#[derive(Debug, Clone)]
pub struct Orientation {
    measured: Vec<Option<Rotation3<f64>>>,
    /// Axes of the probe, base frame, at the commands.
    axes: Vec<Matrix3<f64>>,
}

/// Where the three points stand in the flange, m, for a probe that sits so on the tool.
pub fn points_m(robot: &Robot, sits: &Rotation3<f64>) -> Vec<Vector3<f64>> {
    let probe = robot.tool.rotation * UnitQuaternion::from_rotation_matrix(sits);
    vec![Vector3::zeros(), probe * Vector3::x(), probe * Vector3::y()]
}

impl Orientation {
    /// Of a log, for a probe that sits so on the tool; `None` where no row has one.
    pub fn of(robot: &Robot, log: &Log, sits: &Rotation3<f64>) -> Option<Self> {
        let turned = |row: usize| log.instruments.orientation.get(row).copied().flatten();
        let measured: Vec<Option<Rotation3<f64>>> =
            (0..log.len()).map(|row| Some(turned(row)?.to_rotation_matrix())).collect();
        if measured.iter().all(Option::is_none) {
            return None;
        }
        let axes = |row: usize| *(robot.chain().forward(&log.command(row)).rotation * sits).matrix();
        Some(Self { measured, axes: (0..log.len()).map(axes).collect() })
    }

    /// Whether a row has an orientation.
    pub fn is_there(&self, row: usize) -> bool {
        self.measured[row].is_some()
    }

    /// Turn of the probe, rad, base frame, as one of [`POINTS`] moves by `movement`, m.
    pub fn seen(&self, row: usize, point: usize, movement: &Vector3<f64>) -> Vector3<f64> {
        let axes = &self.axes[row];
        let d = axes.tr_mul(movement);
        let first = |d: &Vector3<f64>| Vector3::new(0.0, -d.z, 0.5 * d.y);
        let second = |d: &Vector3<f64>| Vector3::new(d.z, 0.0, -0.5 * d.x);
        axes * match point {
            1 => -(first(&d) + second(&d)),
            2 => first(&d),
            3 => second(&d),
            _ => Vector3::zeros(),
        }
    }

    /// Measured less predicted turn of a row, rad, base frame; `back` leads from the tracker's frame, `predicted` are the points.
    pub fn residual(
        &self,
        row: usize,
        back: &UnitQuaternion<f64>,
        predicted: impl Fn(usize) -> Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(measured) = &self.measured[row] else { return Vector3::zeros() };
        let place = |k: usize| match k {
            2 => back * (measured * Vector3::x()),
            3 => back * (measured * Vector3::y()),
            _ => Vector3::zeros(),
        };
        POINTS.map(|k| self.seen(row, k, &(place(k) - predicted(k)))).sum()
    }

    /// How the orientation of a row changes as the probe turns on the tool about its axis `k`.
    pub fn own(&self, k: usize, row: usize) -> Vector3<f64> {
        self.axes[row].column(k).into_owned()
    }
}

/// Places of the points in the flange as the probe turns on the tool by small angles about its own axes.
pub fn turned(places: &[Vector3<f64>], by: &[f64]) -> Vec<Vector3<f64>> {
    let [_, x, y] = places else { return places.to_vec() };
    let w = x * by[0] + y * by[1] + x.cross(y) * by[2];
    let turn = UnitQuaternion::from_scaled_axis(w);
    places.iter().map(|p| turn * p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_turn_is_seen_whole_and_a_shift_not_at_all() {
        let axes = *Rotation3::from_euler_angles(0.4, -1.1, 2.0).matrix();
        let o = Orientation { measured: vec![None], axes: vec![axes] };
        let (w, shift) = (Vector3::new(3e-5, -7e-5, 2e-5), Vector3::new(0.3, -0.1, 2.0));
        let seen: Vector3<f64> = POINTS
            .map(|k| {
                let at = if k == 1 { Vector3::zeros() } else { axes.column(k - 2).into_owned() };
                o.seen(0, k, &(shift + w.cross(&at)))
            })
            .sum();
        assert!((seen - w).norm() < 1e-15, "{seen}");
    }
}
