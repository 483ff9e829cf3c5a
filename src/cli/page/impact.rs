//! Page of `assess impact`: what one half gap of each joint moves the TCP.

use crate::assess::impact::JointImpact;
use crate::report::{BarRow, BarsView, Page, Role, Run, Tone, method};
use crate::robot::Robot;

fn page(robot: &Robot, title: &str, answer: String, rows: Vec<BarRow>, runs: Vec<Run>, how: &str) -> Page {
    let mut page = super::start("assess impact", title, robot);
    page.verdict(Tone::Plain, answer);
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
    let worst = rows.iter().max_by(|a, b| a.3.total_cmp(&b.3));
    let answer = worst.map_or("No joint has a gap.".to_string(), |(axis, _, _, m)| {
        format!("The gap of {} matters most: one half gap moves the TCP by {:.1} µm.", robot.axis(*axis).name, m * 1e6)
    });
    page(
        robot,
        "TCP displacement of one half gap",
        answer,
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
    let title = "TCP displacement of one half gap over a program";
    page(robot, title, of_reversing(robot, joints), bars, runs, "Over all points of the program.")
}

/// Which gaps the program shows: those of the joints that reverse in it.
fn of_reversing(robot: &Robot, joints: &[JointImpact]) -> String {
    let reverse = joints.iter().filter(|j| j.reversals > 0);
    match reverse.max_by(|a, b| a.share.total_cmp(&b.share)) {
        Some(j) => format!(
            "The gap of {} matters most ({:.0} % of the mean square of the joints that reverse): one half gap moves the TCP by up to {:.1} µm.",
            robot.axis(j.axis).name,
            100.0 * j.share,
            j.largest_m * 1e6
        ),
        None => "No joint reverses in this program, so a gap only shifts the path and does not bend it.".into(),
    }
}
