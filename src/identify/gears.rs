//! Robot and logs by gears, where gears turn by sums of axes (`gap_of`, FANUC's J3): a half gap belongs to its gear.
//!
//! Where J2 moves alone, such an elbow's gear moves too and loses its own gap; a fit by axes alone gives part of it to J2. Commands,
//! encoders and sensors are therefore added up before anything is identified, and the arm is that of [`Robot::of_gears`]. Half gaps,
//! and the positions of those that vary, come out by gears, as `rewrite` applies them.

use crate::gaps::Note;
use crate::log::Log;
use crate::robot::Robot;
use std::borrow::Cow;

/// A robot and its logs, by gears.
#[derive(Debug)]
pub(crate) struct Geared<'a> {
    /// One command for each gear.
    pub robot: Cow<'a, Robot>,
    /// Columns added up.
    pub logs: Cow<'a, [Log]>,
    /// What a reader should know.
    pub notes: Vec<Note>,
}

/// The robot and its logs by gears; as they are where every gear turns by its own axis.
pub(crate) fn geared<'a>(robot: &'a Robot, logs: &'a [Log]) -> Geared<'a> {
    if !robot.has_sums() {
        return Geared { robot: Cow::Borrowed(robot), logs: Cow::Borrowed(logs), notes: Vec::new() };
    }
    let Some(of_gears) = robot.of_gears() else {
        let notes = robot.by_joints_alone().map(Note::JointsAlone).into_iter().collect();
        return Geared { robot: Cow::Borrowed(robot), logs: Cow::Borrowed(logs), notes };
    };
    let logs = logs.iter().map(|log| log.by_gears(robot)).collect();
    Geared { robot: Cow::Owned(of_gears), logs: Cow::Owned(logs), notes: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::Input;

    const ARM: &str = "schema: lostmotion/robot/1
convention: dh-standard
joints:
  - {name: J1, kind: revolute, d_mm: 500, a_mm: 150, alpha_deg: -90, limits_deg: [-170, 170]}
  - {name: J2, kind: revolute, theta_deg: -90, a_mm: 790, alpha_deg: 180, limits_deg: [-90, 150]}
  - {name: J23, kind: revolute, follows: {joint: J2, ratio: 1}}
  - {name: J3, kind: revolute, a_mm: 900, limits_deg: [-180, 270]}
gap_of: {J3: J2 + J3}
";

    #[test]
    fn columns_are_added_up_and_the_arm_stands_where_it_stood() {
        let robot = Robot::parse("robot.yaml", ARM).unwrap();
        let text = "t_s,cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,enc_J3_deg,x_mm,y_mm,z_mm\n0,10,20,-5.5,-5.4,1,2,3\n1,11,25.25,-7,,1,2,3\n";
        let input = Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() };
        let log = Log::parse(input, &robot).unwrap();
        let found = geared(&robot, std::slice::from_ref(&log));
        let summed = &found.logs[0];
        let deg = |v: f64| (v.to_degrees() * 1e9).round() / 1e9;
        assert_eq!(summed.cmd[2].iter().map(|v| deg(*v)).collect::<Vec<_>>(), [14.5, 18.25]);
        let enc = summed.enc[2].as_ref().unwrap();
        assert_eq!((enc[0].map(deg), enc[1]), (Some(14.6), None));
        assert_eq!(summed.cmd_decimals[2], 2);
        for row in 0..2 {
            let apart = found.robot.tcp_m(&summed.command(row)) - robot.tcp_m(&log.command(row));
            assert!(apart.norm() < 1e-12, "row {row}: {apart:?}");
        }
        assert_eq!(found.robot.axis(2).limits, None, "the limits of the pendant's J3 are not those of its gear");
    }

    #[test]
    fn a_robot_without_sums_keeps_its_logs() {
        let robot = Robot::parse("robot.yaml", &ARM.replace("gap_of: {J3: J2 + J3}\n", "")).unwrap();
        let found = geared(&robot, &[]);
        assert!(matches!(found.robot, Cow::Borrowed(_)) && found.notes.is_empty());
    }
}
