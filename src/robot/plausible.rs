//! Whether the numbers of a robot file can be those of a machine: units mistaken, limits forgotten, axes that do the same.
//!
//! A robot file that is well formed may still hold metres where millimetres are expected; every later figure would then be wrong
//! by a factor, without a message. Bounds are far beyond what machines have, so that a finding is worth reading.

use super::{JointKind, Robot};
use nalgebra::Vector3;

/// Reach of the smallest and of the largest machine that is plausible, m. An instrument of 30 mm and a gantry of 100 m are inside.
const REACH_M: [f64; 2] = [0.005, 150.0];
/// Travel of a revolute joint below which all limits together look like radians, deg.
const RADIANS_DEG: f64 = 7.0;
/// Heaviest link that is plausible, kg.
const HEAVY_KG: f64 = 20_000.0;
/// Link frames at a smaller distance and angle do the same, m and rad.
const SAME: f64 = 1e-9;

/// An angle this near to a multiple of a quarter turn in radians, in quarter turns, is one.
const QUARTER: f64 = 1e-3;
/// A length in metres would be between these shares of the longest one.
const LIKE_OTHERS: [f64; 2] = [0.08, 1.2];
/// Lengths in metres beside others in millimetres: more are those of a calibration.
const FEW: usize = 2;
/// A joint below this speed, deg/s, and below this share of the fastest one, may have it in rad/s.
const SLOW_DEG_S: f64 = 10.0;
const SLOWER: f64 = 0.1;

/// Share of a quarter turn within which an angle of a frame is one in radians: 1.5708 and 3.142, not an angle of a calibration.
const QUARTER_OF_FRAME: f64 = 3e-4;
/// A tool in metres would be between these shares of the reach; and is shorter than this, m.
const LIKE_TOOL: [f64; 2] = [0.01, 0.6];
const SHORT_TOOL_M: f64 = 2e-3;
/// Travel of another revolute joint from which on limits of a few degrees stand out, deg.
const WIDE_DEG: f64 = 30.0;

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub enum Finding {
    /// Largest distance that the links span, m, is not that of a machine.
    Reach {
        /// That distance, m.
        reach_m: f64,
    },
    /// Every revolute joint has limits of a few degrees: radians?
    LimitsInRadians,
    /// Axes of two consecutive joints coincide.
    SameAxis {
        /// Names of the joints.
        joints: [String; 2],
    },
    /// A link angle that is a multiple of a quarter turn in radians, deg as read.
    AngleInRadians {
        /// Name of the joint.
        joint: String,
        /// Key in the robot file.
        key: &'static str,
        /// The angle as read, deg.
        value: f64,
    },
    /// An angle of a frame that is a multiple of a quarter turn in radians, deg as read.
    FrameInRadians {
        /// `base`, `flange` or `tool`.
        frame: &'static str,
        /// The angle as read, deg.
        value: f64,
    },
    /// A tool that would be one in metres, mm as read.
    ToolInMetres {
        /// Its length as read, mm.
        mm: f64,
    },
    /// Limits of one joint of a few degrees, where others turn far.
    JointLimitsInRadians {
        /// Name of the joint.
        joint: String,
        /// The limits as read, deg.
        limits: [f64; 2],
    },
    /// A length far below the others that would be one of them in metres, mm as read.
    LengthInMetres {
        /// Name of the joint.
        joint: String,
        /// Key in the robot file.
        key: &'static str,
        /// The length as read, mm.
        mm: f64,
    },
    /// A largest speed far below that of the other joints, deg/s as read.
    SpeedInRadians {
        /// Name of the joint.
        joint: String,
        /// The speed as read, deg/s.
        deg_s: f64,
    },
    /// A mass that no link has, kg.
    Mass {
        /// Name of the joint.
        joint: String,
        /// The mass, kg.
        mass_kg: f64,
    },
    /// Joints without limits of travel: nothing can be checked for them.
    NoLimits {
        /// Names of the joints.
        joints: Vec<String>,
    },
    /// Joints without a largest speed.
    NoSpeeds {
        /// Names of the joints.
        joints: Vec<String>,
    },
    /// Joints without a largest acceleration.
    NoAccelerations {
        /// Names of the joints.
        joints: Vec<String>,
    },
    /// No masses: gravity is left out.
    NoMasses,
}

/// Joints that lack something, and what is found of them.
type Lack = (Vec<String>, fn(Vec<String>) -> Finding);

impl Finding {
    /// Whether the file must be wrong; else it only lacks something.
    pub fn is_fault(&self) -> bool {
        !matches!(
            self,
            Self::NoLimits { .. }
                | Self::NoSpeeds { .. }
                | Self::NoAccelerations { .. }
                | Self::NoMasses
                | Self::LengthInMetres { .. }
                | Self::ToolInMetres { .. }
                | Self::JointLimitsInRadians { .. }
                | Self::SpeedInRadians { .. }
        )
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
    } else {
        limits_of_single_joints(robot, &mut out);
    }
    frames(robot, reach_m, &mut out);
    units_of_single_numbers(robot, &mut out);
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

/// Limits of a joint that stand out among the others as radians would.
fn limits_of_single_joints(robot: &Robot, out: &mut Vec<Finding>) {
    let turning = || {
        let limits = robot.joints.iter().filter(|j| j.kind == JointKind::Revolute);
        limits.filter_map(|j| Some((j, j.limits?.map(f64::to_degrees))))
    };
    let wide = turning().any(|(_, [lo, hi])| hi - lo > WIDE_DEG);
    let narrow = |limits: [f64; 2]| limits.iter().all(|v| v.abs() < RADIANS_DEG);
    let found = turning().filter(|(_, limits)| wide && narrow(*limits));
    out.extend(found.map(|(j, limits)| Finding::JointLimitsInRadians { joint: j.name.clone(), limits }));
}

/// Angles of base, flange and tool in radians, and a tool in metres.
fn frames(robot: &Robot, reach_m: f64, out: &mut Vec<Finding>) {
    for (frame, placed) in [("base", &robot.base), ("flange", robot.flange()), ("tool", &robot.tool)] {
        let (r, p, y) = placed.rotation.euler_angles();
        for value in [r, p, y].map(f64::to_degrees) {
            let turns = value / std::f64::consts::FRAC_PI_2;
            if turns.round() != 0.0 && (turns - turns.round()).abs() < QUARTER_OF_FRAME && turns.abs() < 4.5 {
                out.push(Finding::FrameInRadians { frame, value });
            }
        }
    }
    let tool_m = robot.tool.translation.vector.norm();
    let share = 1e3 * tool_m / reach_m;
    if tool_m < SHORT_TOOL_M && (LIKE_TOOL[0]..=LIKE_TOOL[1]).contains(&share) {
        out.push(Finding::ToolInMetres { mm: tool_m * 1e3 });
    }
}

/// Numbers of single joints that look like another unit beside those of the others.
fn units_of_single_numbers(robot: &Robot, out: &mut Vec<Finding>) {
    let angles = robot.joints.iter().flat_map(|j| [(j, "theta_deg", j.theta_rad), (j, "alpha_deg", j.alpha_rad)]);
    for (j, key, rad) in angles {
        let read = rad.to_degrees();
        let turns = read / std::f64::consts::FRAC_PI_2;
        if turns.round() != 0.0 && (turns - turns.round()).abs() < QUARTER && turns.abs() < 4.5 {
            out.push(Finding::AngleInRadians { joint: j.name.clone(), key, value: read });
        }
    }
    let lengths: Vec<(&super::Joint, &str, f64)> =
        robot.joints.iter().flat_map(|j| [(j, "d_mm", j.d_m), (j, "a_mm", j.a_m)]).collect();
    let longest = lengths.iter().fold(0.0f64, |m, l| m.max(l.2.abs()));
    let small = |m: f64| (1e3 * m.abs() / longest >= LIKE_OTHERS[0]) && (1e3 * m.abs() / longest <= LIKE_OTHERS[1]);
    let found: Vec<_> = lengths.iter().filter(|l| l.2 != 0.0 && small(l.2)).collect();
    // calibrated robots have many small lengths
    if found.len() <= FEW {
        let finding = |l: &&(&super::Joint, &'static str, f64)| Finding::LengthInMetres {
            joint: l.0.name.clone(),
            key: l.1,
            mm: l.2 * 1e3,
        };
        out.extend(found.iter().map(finding));
    }
    let speeds: Vec<(&super::Joint, f64)> = (robot.joints.iter().filter(|j| j.kind == JointKind::Revolute))
        .filter_map(|j| Some((j, j.max_speed?.to_degrees())))
        .collect();
    let fastest = speeds.iter().fold(0.0f64, |m, s| m.max(s.1));
    let slow = |deg_s: f64| deg_s < SLOW_DEG_S && (deg_s < SLOWER * fastest || fastest < SLOW_DEG_S);
    out.extend(
        (speeds.iter().filter(|s| slow(s.1))).map(|s| Finding::SpeedInRadians { joint: s.0.name.clone(), deg_s: s.1 }),
    );
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
