//! Whether the numbers of a robot file can be those of a machine: units mistaken, limits forgotten, axes that do the same.
//!
//! A robot file that is well formed may still hold metres where millimetres are expected; every later figure would then be wrong
//! by a factor, without a message. Bounds are far beyond what machines have, so that a finding is worth reading.

use super::{JointKind, Robot};
use nalgebra::Vector3;

/// Reach of the smallest and of the largest machine that is believed, m. An instrument of 30 mm and a gantry of 100 m are inside.
const REACH_M: [f64; 2] = [0.005, 150.0];
/// Travel of a revolute joint below which all limits together look like radians, deg.
const RADIANS_DEG: f64 = 7.0;
/// Heaviest link that is believed, kg.
const HEAVY_KG: f64 = 20_000.0;
/// Link frames at a smaller distance and angle do the same, m and rad.
const SAME: f64 = 1e-9;

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub enum Finding {
    /// Largest distance that the links span, m, is none of a machine.
    Reach { reach_m: f64 },
    /// Every revolute joint has limits of a few degrees: radians?
    LimitsInRadians,
    /// Axes of two consecutive joints coincide.
    SameAxis { joints: [String; 2] },
    /// A mass that no link has, kg.
    Mass { joint: String, mass_kg: f64 },
    /// Joints without limits of travel: nothing can be checked for them.
    NoLimits { joints: Vec<String> },
    /// Joints without a largest speed.
    NoSpeeds { joints: Vec<String> },
    /// Joints without a largest acceleration.
    NoAccelerations { joints: Vec<String> },
    /// No masses: gravity is left out.
    NoMasses,
}

/// Joints that lack something, and what is found of them.
type Lack = (Vec<String>, fn(Vec<String>) -> Finding);

impl Finding {
    /// Whether the file must be wrong; else it only lacks something.
    pub fn is_fault(&self) -> bool {
        !matches!(self, Self::NoLimits { .. } | Self::NoSpeeds { .. } | Self::NoAccelerations { .. } | Self::NoMasses)
    }
}

/// Everything that is odd about a robot.
pub fn findings(robot: &Robot) -> Vec<Finding> {
    let mut out = Vec::new();
    let reach_m = reach_m(robot);
    if !(REACH_M[0]..=REACH_M[1]).contains(&reach_m) {
        out.push(Finding::Reach { reach_m });
    }
    let degrees: Vec<[f64; 2]> =
        (robot.joints.iter()).filter(|j| j.kind == JointKind::Revolute).filter_map(|j| j.limits).collect();
    if degrees.len() > 1 && degrees.iter().flatten().all(|v| v.abs().to_degrees() < RADIANS_DEG) {
        out.push(Finding::LimitsInRadians);
    }
    for pair in robot.joints.windows(2) {
        let [a, b] = pair else { continue };
        let one_axis = match robot.convention {
            super::Convention::Standard => a.alpha_rad.sin().abs() < SAME && a.a_m.abs() < SAME,
            super::Convention::Modified => b.alpha_rad.sin().abs() < SAME && b.a_m.abs() < SAME,
        };
        // a joint that follows another one may well move about its axis
        if one_axis && a.kind == b.kind && a.follows.is_none() && b.follows.is_none() {
            out.push(Finding::SameAxis { joints: [a.name.clone(), b.name.clone()] });
        }
    }
    for (link, joint) in robot.links.iter().zip(&robot.joints) {
        if link.mass_kg > HEAVY_KG {
            out.push(Finding::Mass { joint: joint.name.clone(), mass_kg: link.mass_kg });
        }
    }
    let without = |lacks: &dyn Fn(&super::Joint) -> bool| -> Vec<String> {
        robot.axis_joints().filter(|j| lacks(j)).map(|j| j.name.clone()).collect()
    };
    let lacking: [Lack; 3] = [
        (without(&|j| j.limits.is_none()), |joints| Finding::NoLimits { joints }),
        (without(&|j| j.max_speed.is_none()), |joints| Finding::NoSpeeds { joints }),
        (without(&|j| j.max_accel.is_none()), |joints| Finding::NoAccelerations { joints }),
    ];
    out.extend(lacking.into_iter().filter(|(joints, _)| !joints.is_empty()).map(|(joints, finding)| finding(joints)));
    if robot.links.is_empty() {
        out.push(Finding::NoMasses);
    }
    out
}

/// Length of the stretched chain from the first axis to the TCP, strokes of prismatic joints included, m: an upper bound of the reach.
pub fn reach_m(robot: &Robot) -> f64 {
    let strokes = robot.joints.iter().filter(|j| j.kind == JointKind::Prismatic).filter_map(|j| j.limits);
    let links: f64 = robot.joints.iter().map(|j| Vector3::new(j.a_m, 0.0, j.d_m).norm()).sum();
    links
        + robot.flange().translation.vector.norm()
        + robot.tool.translation.vector.norm()
        + strokes.map(|[lo, hi]| lo.abs().max(hi.abs())).sum::<f64>()
}
