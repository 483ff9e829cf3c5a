//! Targets whose arm configuration is not that of the joints before, and targets that name none: what is written is the pose of the joints
//! with their offsets, by a formula of this file.

use crate::support::{Outcome, WorkFolder, bundled};
use lostmotion::robot::Robot;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Write;

const ROBOT: &str = "kuka-kr120-r2500-pro.yaml";
const HALF_GAP_DEG: f64 = 0.004;

/// The robot without its tool, as `$TOOL=$NULLFRAME` has it.
fn robot() -> Robot {
    let text = std::fs::read_to_string(bundled("configs").join(ROBOT)).unwrap();
    let tool = "tool: {xyz_mm: [156, 0, 63]";
    assert!(text.contains(tool));
    Robot::parse("robot.yaml", &text.replace(tool, "tool: {xyz_mm: [0, 0, 0]")).unwrap()
}

/// Position, mm, and rotation of the flange.
fn pose(q_deg: &[f64; 6]) -> (Vector3<f64>, Matrix3<f64>) {
    let pose = robot().forward(&q_deg.map(f64::to_radians));
    (pose.position * 1e3, *pose.rotation.matrix())
}

/// A, B, C in degrees: turns about Z, the new Y and the new X, out of their matrix.
fn abc(r: &Matrix3<f64>) -> [f64; 3] {
    let b = (-r[(2, 0)]).asin();
    [r[(1, 0)].atan2(r[(0, 0)]), b, r[(2, 1)].atan2(r[(2, 2)])].map(f64::to_degrees)
}

/// `X 1.0,Y ...,C ...` of the pose at joints.
fn written(q_deg: &[f64; 6]) -> String {
    let (at, turn) = pose(q_deg);
    let [a, b, c] = abc(&turn);
    format!("X {:.4},Y {:.4},Z {:.4},A {a:.5},B {b:.5},C {c:.5}", at.x, at.y, at.z)
}

/// The six numbers of the aggregates of a program that begin with X.
fn numbers(program: &str) -> Vec<[f64; 6]> {
    let of = |part: &str| {
        let end = part.find(['}', 'S']).unwrap_or(part.len());
        let all = part[..end].split(',').filter_map(|n| n.trim().split(' ').next_back()?.parse().ok());
        let all: Vec<f64> = all.collect();
        <[f64; 6]>::try_from(all).ok()
    };
    program.split("{X ").skip(1).filter_map(of).collect()
}

/// A folder with a robot, a model of equal gaps, and files.
fn folder(files: &[(&str, &str)]) -> WorkFolder {
    let work = WorkFolder::new();
    std::fs::copy(bundled("configs").join(ROBOT), work.join("robot.yaml")).unwrap();
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for joint in robot().axis_names() {
        let _ = writeln!(model, "  - {{effect: backlash, joint: {joint}, half_gap_deg: {HALF_GAP_DEG}}}");
    }
    for (name, text) in [("model.yaml", model.as_str())].iter().chain(files) {
        std::fs::create_dir_all(work.join(name).parent().unwrap()).unwrap();
        std::fs::write(work.join(name), text).unwrap();
    }
    work
}

fn text(work: &WorkFolder, name: &str) -> String {
    std::fs::read_to_string(work.join(name)).unwrap()
}

/// The wrist turns over and back on joint motions, as status and turn order it: A4 and A6 turn by far more than to the nearer solution, in
/// the other direction.
#[test]
fn a_joint_move_over_to_the_other_wrist_is_written_with_the_offsets_of_its_own_directions() {
    let joints: [[f64; 6]; 5] = [
        [0.0, -90.0, 90.0, 5.0, 30.0, 5.0],
        [5.0, -85.0, 95.0, 10.0, 40.0, 10.0],
        [8.0, -80.0, 99.0, 170.0, -35.0, -160.0],
        [3.0, -84.0, 92.0, 150.0, -45.0, -120.0],
        [9.0, -79.0, 97.0, 12.0, 35.0, 20.0],
    ];
    let mut source = String::from("DEF p( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n");
    for q in &joints[..2] {
        let [a, b, c, d, e, f] = q;
        let _ = writeln!(source, "PTP {{A1 {a},A2 {b},A3 {c},A4 {d},A5 {e},A6 {f}}}");
    }
    for q in &joints[2..] {
        let turn: u8 = q.iter().enumerate().map(|(k, v)| u8::from(*v < 0.0) << k).sum();
        let _ = writeln!(source, "PTP {{{},S {},T {turn}}}", written(q), if q[4] < 0.0 { 6 } else { 2 });
    }
    source += "END\n";
    let work = folder(&[("p.src", &source)]);
    let done: serde_json::Value =
        work.run("rewrite --model model.yaml p.src --output out.src --json --max-added 0").success().json();
    assert_eq!(done["edited_as_poses"], 3, "{done}");
    let notes = done["notes"].to_string();
    assert!(notes.contains("another arm configuration than that before") && notes.contains("lines 6, 8"), "{notes}");
    let after = text(&work, "out.src");
    let found = numbers(&after);
    let goals = &found[found.len() - 3..];
    // on a joint motion every joint turns one way; a command is ahead of its joint by the half gap
    for (k, numbers) in (2..).zip(goals) {
        let ahead = |axis: usize| joints[k][axis] + HALF_GAP_DEG * (joints[k][axis] - joints[k - 1][axis]).signum();
        let (at, turn) = pose(&[0, 1, 2, 3, 4, 5].map(ahead));
        let [a, b, c] = abc(&turn);
        let wanted = [at.x, at.y, at.z, a, b, c];
        let off: Vec<f64> = numbers.iter().zip(wanted).map(|(n, w)| (n - w).abs()).collect();
        assert!(off[..3].iter().all(|d| *d < 2e-3) && off[3..].iter().all(|d| *d < 2e-4), "{k}: {off:?}\n{after}");
    }
    // and not the offsets of the nearer solution, nor none
    let same = numbers(&source);
    assert!(goals.iter().zip(&same[same.len() - 3..]).all(|(a, b)| a != b), "{after}");
    work.run("undo out.src --output back.src").success();
    assert_eq!(text(&work, "back.src"), source);
    work.run("rewrite --model model.yaml out.src --output again.src").ends_with(2);
}

/// Three of four motions go over into another configuration: frames or robot are others than those of the program.
#[test]
fn a_program_that_goes_over_all_the_time_is_left() {
    let joints: [[f64; 6]; 4] = [
        [8.0, -80.0, 99.0, 170.0, -35.0, -160.0],
        [9.0, -79.0, 97.0, 12.0, 35.0, 20.0],
        [7.0, -82.0, 95.0, 165.0, -30.0, -150.0],
        [5.0, -81.0, 96.0, 150.0, -35.0, -140.0],
    ];
    let mut source =
        String::from("DEF p( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {A1 0,A2 -90,A3 90,A4 5,A5 30,A6 5}\n");
    for q in &joints {
        let turn: u8 = q.iter().enumerate().map(|(k, v)| u8::from(*v < 0.0) << k).sum();
        let _ = writeln!(source, "PTP {{{},S {},T {turn}}}", written(q), if q[4] < 0.0 { 6 } else { 2 });
    }
    let work = folder(&[("p.src", &(source + "END\n"))]);
    let done: serde_json::Value = work.run("rewrite --model model.yaml p.src --dry-run --json --force").json();
    assert!(done["not_edited"].to_string().contains("differs from the one nearest"), "{done}");
    assert!(!done["notes"].to_string().contains("another arm configuration than that before"), "{done}");
}

/// Frames without a status in a project whose points have one configuration: the same bytes as with its home position as posture.
#[test]
fn frames_of_a_project_are_edited_in_the_configuration_of_its_points() {
    let joints: [[f64; 6]; 4] = [
        [3.0, -86.0, 94.0, 3.0, 47.0, 3.0],
        [5.0, -83.0, 97.0, 6.0, 42.0, 8.0],
        [1.0, -88.0, 91.0, 2.0, 50.0, 2.0],
        [6.0, -82.0, 98.0, 5.0, 44.0, 6.0],
    ];
    let mut source = String::from("DEF p( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n");
    for q in &joints {
        let _ = writeln!(source, "LIN {{{}}}", written(q));
    }
    source += "END\n";
    let home = "DEFDAT $CONFIG\nE6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 30.0,A6 0.0}\nENDDAT\n";
    let point = |status: u8| {
        format!("DEFDAT b\nDECL E6POS XP1={{X 1500.0,Y 0.0,Z 1500.0,A 0.0,B 90.0,C 0.0,S {status},T 2}}\nENDDAT\n")
    };
    let run = |status: u8, config: &str, more: &str| -> (WorkFolder, Outcome) {
        let list = point(status);
        let files = [("R1/System/$config.dat", config), ("R1/Program/b.dat", &list), ("R1/Program/p.src", &source)];
        let work = folder(&files);
        std::fs::write(work.join("posture.yaml"), "schema: lostmotion/frames/1\nposture_deg: [0, -90, 90, 0, 30, 0]\n")
            .unwrap();
        let done = work.run(&format!("rewrite --model model.yaml R1/Program/p.src --output out.src --json{more}"));
        (work, done)
    };
    let (given, _) = run(2, "DEFDAT $CONFIG\nENDDAT\n", " --frames posture.yaml");
    let (known, done) = run(2, home, "");
    assert_eq!(done.success().json::<serde_json::Value>()["edited_as_poses"], 4);
    assert_eq!(text(&given, "out.src"), text(&known, "out.src"));
    assert_ne!(text(&known, "out.src"), source);
    // the other wrist has the same front and elbow; another elbow, or no home position, tells nothing
    let (other_wrist, _) = run(6, home, "");
    assert_eq!(text(&other_wrist, "out.src"), text(&known, "out.src"));
    for (status, config) in [(0, home), (3, home), (2, "DEFDAT $CONFIG\nENDDAT\n")] {
        let (_, done) = run(status, config, " --force");
        assert_eq!(done.json::<serde_json::Value>()["edited_as_poses"], 0, "{status}");
    }
}
