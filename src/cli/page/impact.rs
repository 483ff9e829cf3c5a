//! Page of `assess impact`: what one half gap of each joint moves the TCP.

use crate::assess::impact::JointImpact;
use crate::report::{BarRow, BarsView, Page, Role, Run, method};
use crate::robot::Robot;

fn page(robot: &Robot, title: &str, rows: Vec<BarRow>, runs: Vec<Run>, how: &str) -> Page {
    let mut page = super::start("assess impact", title, robot);
    let view = BarsView { quantity: "TCP displacement of one half gap".into(), unit: "µm".into(), runs, rows };
    page.section("Which joints matter", how, view);
    page.section("", "", vec![method::IMPACT]);
    page
}

/// At poses: axis, half gap, pose, displacement in m.
pub fn of_poses(robot: &Robot, rows: &[(usize, f64, &[f64], f64)]) -> Page {
    let bars = rows
        .iter()
        .map(|(axis, _, _, m)| BarRow { label: robot.axis(*axis).name.clone(), values: vec![Some(m * 1e6)] })
        .collect();
    let runs = vec![Run::new("at the pose", Role::After)];
    page(
        robot,
        "TCP displacement of one half gap",
        bars,
        runs,
        "Two measurements from opposite sides differ by twice this distance.",
    )
}

/// Over a program.
pub fn of_program(robot: &Robot, joints: &[JointImpact]) -> Page {
    let bars = joints
        .iter()
        .map(|j| BarRow {
            label: robot.axis(j.axis).name.clone(),
            values: vec![Some(j.largest_m * 1e6), Some(j.rms_m * 1e6)],
        })
        .collect();
    let runs = vec![Run::new("largest", Role::Before), Run::new("rms", Role::After)];
    page(robot, "TCP displacement of one half gap over a program", bars, runs, "Over all points of the program.")
}
