//! Sizes that no lost motion has: an offset beyond ten times anything real is a slip of a unit or of a decimal point, and it moves
//! a robot. It is refused unless it is forced.
//!
//! The largest half gaps known: 1.75 deg in the cable-driven joints of a small instrument (samples/instrument), 0.5 mm in a worn
//! screw; at the TCP, 3 mm with the play of hobby servos (industrial robots: 0.05 to 0.2 mm).

use crate::compensator::{Compensator, JointCompensator};
use crate::robot::{JointKind, Robot};

/// Largest real half gap of a revolute joint, rad.
const REAL_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Largest real half gap of a prismatic joint, m.
const REAL_M: f64 = 0.5e-3;
/// Largest real displacement of the TCP by one half gap, m.
const REAL_TCP_M: f64 = 3e-3;
/// So many times beyond anything real is refused.
const BEYOND: f64 = 10.0;

/// Joints whose offset nothing real explains, each with what was found; empty: all are plausible.
pub fn implausible(robot: &Robot, compensator: &Compensator) -> Vec<String> {
    let joints = compensator.joints.iter().filter(|j| j.axis < robot.dof());
    joints.filter_map(|j| implausible_joint(robot, j)).collect()
}

fn implausible_joint(robot: &Robot, compensator: &JointCompensator) -> Option<String> {
    let joint = robot.axis(compensator.axis);
    let gap = compensator.backlash.as_ref().map_or(0.0, |b| b.positive.largest().max(b.negative.largest()));
    let size = gap.max(compensator.friction.map_or(0.0, |f| f.gain.abs()));
    let (real, lever_m) = match joint.kind {
        JointKind::Revolute => (REAL_RAD, lever_m(robot, compensator.axis)),
        JointKind::Prismatic => (REAL_M, 1.0),
    };
    let most = (BEYOND * real).min(BEYOND * REAL_TCP_M / lever_m);
    (size > most).then(|| {
        let (edge, unit) = (|v: f64| joint.kind.to_user_unit(v), joint.kind.unit());
        format!(
            "an offset of {:.6} {unit} for {}, up to {:.1} mm at the TCP (at most {:.6} {unit} is plausible there)",
            edge(size),
            joint.name,
            size * lever_m * 1e3,
            edge(most)
        )
    })
}

/// The longest way from the axis of a revolute joint to the TCP, m: all lengths of the chain after it, stretched out.
fn lever_m(robot: &Robot, axis: usize) -> f64 {
    let name = &robot.axis(axis).name;
    let mut after = robot.joints.iter().skip_while(|j| j.name != *name);
    let own = after.next().map_or(0.0, |j| j.a_m.abs());
    let travel = |j: &crate::robot::Joint| match (j.kind, j.limits) {
        (JointKind::Prismatic, Some([lo, hi])) => lo.abs().max(hi.abs()),
        _ => 0.0,
    };
    let rest: f64 = after.map(|j| j.a_m.hypot(j.d_m.abs() + travel(j))).sum();
    (own + rest + robot.flange().translation.vector.norm() + robot.tool.translation.vector.norm()).max(1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, Evidence};
    use crate::effects::GapCurve;

    fn refused(robot: &str, half_gap: f64) -> bool {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(robot);
        let robot = Robot::load(&path).unwrap();
        let gap = GapCurve::Constant(half_gap * robot.axis(0).kind.si_per_user_unit());
        let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
        let joints = vec![JointCompensator { axis: 0, backlash, friction: None }];
        let compensator = Compensator {
            robot_name: String::new(),
            robot_sha256: String::new(),
            joints,
            evidence: Evidence::default(),
        };
        !implausible(&robot, &compensator).is_empty()
    }

    #[test]
    fn a_slip_of_the_decimal_point_is_implausible_and_a_worn_gear_is_not() {
        for (half_gap, slip) in [(0.0028, false), (0.05, false), (0.2, false), (2.8, true), (28.0, true)] {
            assert_eq!(refused("kuka-kr120-r2500-pro.yaml", half_gap), slip, "{half_gap} deg");
        }
        for (half_gap, slip) in [(0.11625, false), (1.0, false), (11.6, true)] {
            assert_eq!(refused("gantry-xyz-ballscrew.yaml", half_gap), slip, "{half_gap} mm");
        }
    }
}
