//! Denavit-Hartenberg parameters (standard convention) of given joint axes.
//!
//! Method (Denavit and Hartenberg 1955): the z axis of frame i lies on the axis of joint i + 1, its x axis on the common normal
//! of the axes of joints i and i + 1. Where the axes intersect, x is perpendicular to both; where they are parallel, the normal
//! through the origin before is taken, so that d is 0; where they coincide, nothing changes.
//!
//! Assumptions: axes whose angle is below [`PARALLEL_RAD`] are parallel. Axes that are parallel within 1e-4 rad, but not exactly, have a
//! common normal far away: the parameters are then right and large.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

/// Axes at a smaller angle count as parallel, rad.
const PARALLEL_RAD: f64 = 1e-9;
/// Axes at a smaller distance count as one, m.
const SAME_M: f64 = 1e-9;

/// Axis of a joint in the base frame, at the zero configuration.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// A point on the line, m.
    pub point: Vector3<f64>,
    /// Direction of the line.
    pub direction: Unit<Vector3<f64>>,
}

/// One row of the table, rad and m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Angle about z, rad.
    pub theta_rad: f64,
    /// Distance along z, m.
    pub d_m: f64,
    /// Distance along x, m.
    pub a_m: f64,
    /// Angle about x, rad.
    pub alpha_rad: f64,
}

/// Table, base before it and tool after it; `frames[i]` is the link frame of joint i at the zero configuration.
#[derive(Debug, Clone)]
pub struct Table {
    /// World frame to the frame of the first joint.
    pub base: Isometry3<f64>,
    /// Parameters, one row for each joint.
    pub rows: Vec<Row>,
    /// Frame of the last joint to the TCP.
    pub tool: Isometry3<f64>,
    /// Frame of each joint at the zero configuration, in the world frame.
    pub frames: Vec<Isometry3<f64>>,
}

/// Parameters of the axes `lines`, with the TCP at `tip` at the zero configuration.
pub fn of_lines(lines: &[Line], tip: &Isometry3<f64>) -> Table {
    let Some(first) = lines.first() else {
        return Table { base: Isometry3::identity(), rows: Vec::new(), tool: *tip, frames: Vec::new() };
    };
    // the point of the first axis next to the base's origin, x as near to the base's x as it can be
    let z = first.direction;
    let origin = first.point - z.into_inner() * first.point.dot(&z);
    let base = frame(origin, across(&Vector3::x(), &z).or_else(|| across(&Vector3::y(), &z)), z);
    let (mut rows, mut frames, mut at) = (Vec::with_capacity(lines.len()), Vec::with_capacity(lines.len()), base);
    for next in &lines[1..] {
        let to = common_normal(&at, next);
        rows.push(row(&at, &to));
        frames.push(to);
        at = to;
    }
    // after the last axis: along it as far as the TCP, the rest is the tool
    let d = (at.inverse() * tip).translation.vector.z;
    let flange = at * Translation3::new(0.0, 0.0, d);
    rows.push(row(&at, &flange));
    frames.push(flange);
    Table { base, rows, tool: flange.inverse() * tip, frames }
}

/// Frame on the axis `next` whose x lies on the common normal with the z axis of `at`.
fn common_normal(at: &Isometry3<f64>, next: &Line) -> Isometry3<f64> {
    let origin = at.translation.vector;
    let (x0, z0) = (at.rotation * Vector3::x(), at.rotation * Vector3::z());
    let z1 = next.direction.into_inner();
    let between = next.point - origin;
    let normal = z0.cross(&z1);
    if normal.norm() < PARALLEL_RAD {
        let foot = next.point - z1 * between.dot(&z1);
        let offset = foot - origin;
        let x = if offset.norm() < SAME_M { Unit::try_new(x0, 0.0) } else { Unit::try_new(offset, 0.0) };
        let place = if offset.norm() < SAME_M { origin } else { foot };
        return frame(place, x, next.direction);
    }
    // feet of the common normal: origin + s z0 and point + t z1
    let square = normal.norm_squared();
    let s = between.cross(&z1).dot(&normal) / square;
    let t = between.cross(&z0).dot(&normal) / square;
    let (foot0, foot1) = (origin + z0 * s, next.point + z1 * t);
    let offset = foot1 - foot0;
    let sign = if offset.norm() > SAME_M { offset.dot(&normal) } else { normal.dot(&x0) };
    let x = Unit::try_new(if sign < 0.0 { -normal } else { normal }, 0.0);
    frame(foot1, x, next.direction)
}

/// The part of `v` across `z`, as a direction; none where `v` lies along `z`.
fn across(v: &Vector3<f64>, z: &Unit<Vector3<f64>>) -> Option<Unit<Vector3<f64>>> {
    Unit::try_new(v - z.into_inner() * v.dot(z), 1e-6)
}

fn frame(origin: Vector3<f64>, x: Option<Unit<Vector3<f64>>>, z: Unit<Vector3<f64>>) -> Isometry3<f64> {
    let x = x.unwrap_or_else(Vector3::x_axis).into_inner();
    let y = z.cross(&x).normalize();
    let matrix = Matrix3::from_columns(&[y.cross(&z), y, z.into_inner()]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Isometry3::from_parts(origin.into(), rotation)
}

/// The four parameters that lead from one frame to the next.
fn row(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Row {
    let m = from.inverse() * to;
    let r = m.rotation.to_rotation_matrix();
    let theta = tidy(r[(1, 0)].atan2(r[(0, 0)]));
    let p = m.translation.vector;
    Row {
        theta_rad: theta,
        d_m: tidy(p.z),
        a_m: tidy(p.x * theta.cos() + p.y * theta.sin()),
        alpha_rad: tidy(r[(2, 1)].atan2(r[(2, 2)])),
    }
}

/// Rounding of a few floating-point steps is taken away: 1e-15 is no parameter, and a quarter turn is a quarter turn.
fn tidy(v: f64) -> f64 {
    const ROUNDING: f64 = 1e-12;
    let quarter = std::f64::consts::FRAC_PI_2;
    let multiple = (v / quarter).round() * quarter;
    if (v - multiple).abs() < ROUNDING { multiple + 0.0 } else { v }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(point: [f64; 3], direction: [f64; 3]) -> Line {
        Line { point: Vector3::from(point), direction: Unit::new_normalize(Vector3::from(direction)) }
    }

    #[test]
    fn parallel_axes_have_a_link_length_and_no_offset() {
        let lines = [line([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), line([0.3, 0.0, 0.7], [0.0, 0.0, 1.0])];
        let table = of_lines(&lines, &Isometry3::translation(0.5, 0.0, 0.1));
        assert_eq!((table.rows[0].a_m, table.rows[0].d_m, table.rows[0].alpha_rad), (0.3, 0.0, 0.0));
        assert!((table.rows[1].d_m - 0.1).abs() < 1e-15 && (table.tool.translation.vector.x - 0.2).abs() < 1e-15);
    }

    #[test]
    fn crossing_axes_have_a_twist_and_an_offset() {
        let lines = [line([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), line([0.2, 0.0, 0.5], [0.0, 1.0, 0.0])];
        let table = of_lines(&lines, &Isometry3::identity());
        let r = table.rows[0];
        assert!((r.d_m - 0.5).abs() < 1e-15 && (r.a_m - 0.2).abs() < 1e-15, "{r:?}");
        assert_eq!(r.alpha_rad, -std::f64::consts::FRAC_PI_2);
    }
}
