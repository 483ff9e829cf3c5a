//! Whether a path is in millimetres: one in metres is a path of a few millimetres about the robot's origin.
//!
//! Assumptions: the path is in the frame of the robot file. Of an arm whose world stands in its foot or shoulder no TCP gets there; a
//! machine of slides may well have a path of 1 mm at its zero, so there it is a doubt.

use super::Path;
use crate::robot::plausible::reach_m;
use crate::robot::{JointKind, Robot};

/// Largest coordinate of a path in metres that is read as millimetres, as a share of the reach; and least, beyond which it would be
/// nothing even in metres.
const SHARES: [f64; 2] = [5e-5, 2e-3];
/// The world stands in the arm where its base is no farther than this share of the reach.
const IN_THE_ARM: f64 = 0.5;
/// Turning joints of an arm.
const TURNING: usize = 3;

/// A path that looks like one in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InMetres {
    /// Largest coordinate as read, m.
    pub largest_m: f64,
    /// The robot's TCP cannot get there: it is inside of the arm.
    pub certain: bool,
}

/// Whether a path looks like one in metres, for the kinematics of a robot file.
pub fn in_metres(robot: &Robot, path: &Path) -> Option<InMetres> {
    if path.coordinates.len() < 2 {
        return None;
    }
    let largest_m = path.points_m.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    let reach_m = reach_m(robot);
    if !(SHARES[0] * reach_m..=SHARES[1] * reach_m).contains(&largest_m) {
        return None;
    }
    let turning = robot.joints.iter().filter(|j| j.kind == JointKind::Revolute).count();
    let near = robot.base.translation.vector.norm() <= IN_THE_ARM * reach_m;
    let slides = robot.joints.iter().any(|j| j.kind == JointKind::Prismatic);
    let certain = path.coordinates.len() == 3 && turning >= TURNING && near && !slides;
    Some(InMetres { largest_m, certain })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::from_bytes;

    fn found(robot: &str, rows: &str) -> Option<bool> {
        let robot = Robot::parse("robot.yaml", robot).unwrap();
        let path = Path::parse(from_bytes("path.csv".into(), rows.into()).unwrap()).unwrap();
        in_metres(&robot, &path).map(|f| f.certain)
    }

    #[test]
    fn a_path_in_metres_is_inside_of_an_arm_and_a_doubt_of_a_gantry() {
        let arm = include_str!("../../configs/kuka-kr120-r2500-pro.yaml");
        let gantry = include_str!("../../configs/gantry-xyz-ballscrew.yaml");
        assert_eq!(found(arm, "x_mm,y_mm,z_mm\n1.4,0.2,1.1\n1.41,0.25,1.1\n"), Some(true));
        assert_eq!(found(arm, "x_mm,y_mm\n1.4,0.2\n1.41,0.25\n"), Some(false), "z is free");
        assert_eq!(found(arm, "x_mm,y_mm,z_mm\n1400,200,1100\n1410,250,1100\n"), None);
        assert_eq!(found(arm, "x_mm,y_mm,z_mm\n0,0,1100\n1,0.5,1100\n"), None, "above the arm");
        assert_eq!(found(gantry, "x_mm,y_mm,z_mm\n0,0,0\n0.5,0.3,-0.1\n"), Some(false));
        assert_eq!(found(gantry, "x_mm,y_mm,z_mm\n0,0,0\n0,0,0.01\n"), None, "nothing even in metres");
    }
}
