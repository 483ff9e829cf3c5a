//! Impact: how far one half gap of a joint moves the TCP, at a pose or over a program.
//!
//! `|F(q + b_j e_j) - F(q)|` (Zhang (2023), the first equation numbered 12; its Table 2). Two measurements of one pose from
//! opposite sides differ by twice that. Over a program a joint matters where it reverses: a gap that stays on one side is
//! a constant offset. The ranking is by the share of the mean square among the joints that reverse.
//!
//! Exact, not linearised; a gap that depends on position is taken at the commanded one.

use crate::effects::{GapCurve, Track};
use crate::model::Model;
use crate::numerics::parallel::ParMap;
use crate::program::Program;
use crate::robot::Robot;

/// Command movement that is number noise, rad or m; as the rewriter has it.
const DEADBAND: f64 = 1e-8;

/// Points that one thread takes at a time; sums run in the order of these blocks.
const BLOCK: usize = 2048;

/// TCP displacement of the half gap `half_gap` (rad or m) of an axis at `q`, m.
pub fn displacement_m(robot: &Robot, q: &[f64], axis: usize, half_gap: f64) -> f64 {
    let mut moved = q.to_vec();
    moved[axis] += half_gap;
    (robot.tcp_m(&moved) - robot.tcp_m(q)).norm()
}

/// Gaps of one axis, one after the other (coupling and nut): they add up.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisGap {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Half gap over position; several gaps of a joint act one after the other.
    pub curves: Vec<GapCurve>,
}

impl AxisGap {
    /// Half gap at the commanded position `p` (rad or m).
    pub fn at(&self, p: f64) -> f64 {
        self.curves.iter().map(|c| c.at(p)).sum()
    }

    /// Gaps of a model, for the axes that have one.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let curves = |axis| {
            // at rest; a speed is not known here
            model.effects_on(axis).filter_map(|e| e.half_gap())
        };
        (0..model.robot.dof())
            .map(|axis| Self { axis, curves: curves(axis).collect() })
            .filter(|g| !g.curves.is_empty())
            .collect()
    }
}

/// One joint over a program.
#[derive(Debug, Clone, PartialEq)]
pub struct JointImpact {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Largest displacement, and the line of the program where it is.
    pub largest_m: f64,
    /// Line of the program at which the displacement is largest.
    pub largest_line: Option<u64>,
    /// Root mean square displacement over the program, m.
    pub rms_m: f64,
    /// Half gap where the displacement is largest, rad or m.
    pub half_gap: f64,
    /// Number of reversals of the axis in the program.
    pub reversals: usize,
    /// Largest displacement at a reversal; `None` where the joint does not reverse.
    pub at_reversals_m: Option<f64>,
    /// Share of the mean square of all joints that reverse, 0 to 1; 0 for the others.
    pub share: f64,
}

/// Joints with a gap over the points of a program, largest share first, then by rms.
pub fn over_program(robot: &Robot, program: &Program, gaps: &[AxisGap]) -> Vec<JointImpact> {
    let index: Vec<f64> = (0..program.len()).map(|i| i as f64).collect();
    let mut joints: Vec<JointImpact> = gaps
        .iter()
        .map(|gap| {
            let axis = gap.axis;
            let at = |i: usize| {
                let mut q = vec![0.0; robot.dof()];
                program.point_into(i, &mut q);
                displacement_m(robot, &q, axis, gap.at(q[axis]))
            };
            let blocks: Vec<(f64, usize, f64)> = (0..program.len().div_ceil(BLOCK)).par_map(|b| {
                let points = b * BLOCK..((b + 1) * BLOCK).min(program.len());
                points.map(|i| (at(i), i)).fold((-1.0, 0, 0.0), |(most, k, sum), (d, i)| {
                    if d > most { (d, i, sum + d * d) } else { (most, k, sum + d * d) }
                })
            });
            let (largest_m, point, sum) = blocks
                .into_iter()
                .fold((-1.0, 0, 0.0), |a, b| if b.0 > a.0 { (b.0, b.1, a.2 + b.2) } else { (a.0, a.1, a.2 + b.2) });
            let turns = Track::new(&index, &program.q[axis], DEADBAND).turns;
            JointImpact {
                axis,
                largest_m,
                largest_line: program.line(point),
                rms_m: (sum / program.len() as f64).sqrt(),
                half_gap: gap.at(program.q[axis][point]),
                reversals: turns.len(),
                at_reversals_m: turns.iter().map(|t| at(t.index)).max_by(f64::total_cmp),
                share: 0.0,
            }
        })
        .collect();
    let all: f64 = joints.iter().filter(|j| j.reversals > 0).map(|j| j.rms_m.powi(2)).sum();
    if all > 0.0 {
        for j in joints.iter_mut().filter(|j| j.reversals > 0) {
            j.share = j.rms_m.powi(2) / all;
        }
    }
    joints.sort_by(|a, b| b.share.total_cmp(&a.share).then(b.rms_m.total_cmp(&a.rms_m)).then(a.axis.cmp(&b.axis)));
    joints
}
