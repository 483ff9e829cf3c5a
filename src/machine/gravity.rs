//! Torque of gravity about each axis.
//!
//! The generalised force of the weights along an axis' command: `sum m g . dc/dq` over all masses after the joint, and over
//! the joints that follow the axis. Masses: the robot file's `links`, their centres in the link frame of their joint (after
//! the whole transform of that joint, in either convention), and the payload at the flange. Sign: a positive torque turns
//! (or pushes) the axis positive. Unit: Nm, N for a prismatic axis.

use crate::numerics::parallel;
use crate::robot::{Chain, Convention, JointFrame, JointKind, Robot};
use nalgebra::{Rotation3, Vector3};

/// Rows that one thread takes at a time.
const BLOCK: usize = 4096;

/// Masses of a robot.
#[derive(Debug, Clone)]
pub struct Gravity {
    /// Mass and centre in the frame that [`Chain::frames`] gives, per joint; empty without links.
    masses: Vec<(f64, Vector3<f64>)>,
    revolute: Vec<bool>,
    /// The flange in the frame of the last joint.
    flange: Vector3<f64>,
    g_m_s2: Vector3<f64>,
}

impl Gravity {
    /// The masses of a robot file and where they act.
    pub fn new(robot: &Robot) -> Self {
        // from a joint's link frame to the frame before its own a and alpha
        let before = |joint: usize, c: Vector3<f64>| match robot.convention {
            Convention::Modified => c,
            Convention::Standard => {
                let j = &robot.joints[joint];
                let (s, cos) = j.alpha_rad.sin_cos();
                let c =
                    if j.beta_rad == 0.0 { c } else { Rotation3::from_axis_angle(&Vector3::y_axis(), j.beta_rad) * c };
                Vector3::new(j.a_m + c.x, cos * c.y - s * c.z, s * c.y + cos * c.z)
            }
        };
        Self {
            masses: robot.links.iter().enumerate().map(|(i, l)| (l.mass_kg, before(i, l.com_m))).collect(),
            revolute: robot.joints.iter().map(|j| j.kind == JointKind::Revolute).collect(),
            flange: before(robot.joints.len() - 1, Vector3::zeros()),
            g_m_s2: robot.gravity_m_s2,
        }
    }

    /// There are links.
    pub fn is_known(&self) -> bool {
        !self.masses.is_empty()
    }

    /// Torques of all axes at `q`, into `out`.
    pub fn at(&self, chain: &Chain, q: &[f64], payload_kg: f64, lines: &mut Vec<Line>, out: &mut [f64]) {
        out.fill(0.0);
        if !self.is_known() {
            return;
        }
        lines.clear();
        let last = self.masses.len() - 1;
        chain.frames(q, |i, [x, y, z, o]| {
            let world = |c: &Vector3<f64>| o + x * c.x + y * c.y + z * c.z;
            let (mass, centre) = &self.masses[i];
            let mut moment = world(centre) * *mass;
            let mut m = *mass;
            if i == last && payload_kg != 0.0 {
                moment += world(&self.flange) * payload_kg;
                m += payload_kg;
            }
            lines.push(Line { z: *z, o: *o, mass_kg: m, moment });
        });
        let (mut mass, mut moment) = (0.0, Vector3::zeros());
        for (i, line) in lines.iter().enumerate().rev() {
            mass += line.mass_kg;
            moment += line.moment;
            let (axis, gain) = chain.drive_of(i);
            let along = if self.revolute[i] { line.z.cross(&(moment - line.o * mass)) } else { line.z * mass };
            out[axis] += gain * along.dot(&self.g_m_s2);
        }
    }

    /// Moment of the weights about a point at `q`, Nm.
    pub fn moment_about(&self, chain: &Chain, q: &[f64], payload_kg: f64, about_m: &Vector3<f64>) -> Vector3<f64> {
        let (mut moment, last) = (Vector3::zeros(), self.masses.len().saturating_sub(1));
        chain.frames(q, |i, [x, y, z, o]| {
            let world = |c: &Vector3<f64>| o + x * c.x + y * c.y + z * c.z - about_m;
            if let Some((mass, centre)) = self.masses.get(i) {
                moment += (world(centre) * *mass).cross(&self.g_m_s2);
                if i == last {
                    moment += (world(&self.flange) * payload_kg).cross(&self.g_m_s2);
                }
            }
        });
        moment
    }

    /// Torques `[axis][row]` over rows of commands.
    pub fn over(&self, chain: &Chain, cmd: &[Vec<f64>], payload_kg: Option<&[f64]>) -> Vec<Vec<f64>> {
        let rows = cmd.first().map_or(0, Vec::len);
        let mut all = vec![vec![0.0; rows]; cmd.len()];
        if !self.is_known() {
            return all;
        }
        let blocks: Vec<Vec<f64>> = parallel::map_awaited(rows.div_ceil(BLOCK), |b| {
            let range = b * BLOCK..((b + 1) * BLOCK).min(rows);
            let mut block = vec![0.0; range.len() * cmd.len()];
            let mut q = vec![0.0; cmd.len()];
            let mut lines = Vec::new();
            for (row, out) in range.zip(block.chunks_exact_mut(cmd.len())) {
                for (v, column) in q.iter_mut().zip(cmd) {
                    *v = column[row];
                }
                let payload = payload_kg.and_then(|p| p.get(row)).copied().unwrap_or(0.0);
                self.at(chain, &q, payload, &mut lines, out);
            }
            block
        });
        for (row, torques) in blocks.iter().flat_map(|b| b.chunks_exact(cmd.len())).enumerate() {
            for (column, &t) in all.iter_mut().zip(torques) {
                column[row] = t;
            }
        }
        all
    }
}

/// `(z cross x) . g` and `(z cross y) . g` of an axis and the frame of a joint after it, `g` the direction of gravity, at `q`.
pub fn levers(
    chain: &Chain,
    g_m_s2: &Vector3<f64>,
    q: &[f64],
    axis: usize,
    joint: usize,
    frames: &mut Vec<JointFrame>,
) -> [f64; 2] {
    chain.joint_frames(q, frames);
    let Some(after) = frames.get(joint) else { return [0.0; 2] };
    let down = g_m_s2.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let mut levers = [0.0; 2];
    // the axis, and the joints that follow it
    for (k, frame) in frames.iter().enumerate().take(joint + 1).filter(|(_, f)| f.axis == axis) {
        let (_, gain) = chain.drive_of(k);
        levers[0] += gain * frame.z.cross(&after.x).dot(&down);
        levers[1] += gain * frame.z.cross(&after.y).dot(&down);
    }
    levers
}

/// A joint's axis in the world, and the mass that it carries itself.
#[derive(Debug, Clone)]
pub struct Line {
    z: Vector3<f64>,
    o: Vector3<f64>,
    mass_kg: f64,
    /// Mass times its centre.
    moment: Vector3<f64>,
}
