//! `robot check` and `robot init` through the binary.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

fn run(args: &[&str]) -> std::process::Output {
    Command::cargo_bin("lostmotion").unwrap().args(args).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn every_bundled_robot_passes_the_check() {
    let mut checked = 0;
    for entry in std::fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        let out = run(&["robot", "check", path.to_str().unwrap()]);
        assert!(out.status.success(), "{}: {}", path.display(), words(&out.stderr));
        checked += 1;
    }
    assert!(checked >= 7, "{checked}");
}

/// The KR 120 at zero, by hand from its data sheet: 350 + 1150 + 1000 mm out, wrist flange and tool beyond, 675 - 41 mm up.
#[test]
fn the_tcp_at_a_pose_is_that_of_forward_kinematics() {
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    let out = run(&["robot", "check", robot, "--pose", "0,-90,90,0,0,0", "--json"]);
    let doc: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(doc["schema"], "lostmotion/robot-check/1");
    let loaded = lostmotion::robot::Robot::load(Path::new(robot)).unwrap();
    let q: Vec<f64> = [0.0f64, -90.0, 90.0, 0.0, 0.0, 0.0].map(f64::to_radians).to_vec();
    let tcp = loaded.tcp_m(&q) * 1e3;
    let pose = &doc["poses"][2]["xyz_mm"];
    for k in 0..3 {
        assert!((pose[k].as_f64().unwrap() - tcp[k]).abs() < 1e-9);
    }
}

#[test]
fn metres_and_radians_are_found() {
    let text = std::fs::read_to_string("configs/kuka-kr120-r2500-pro.yaml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a robot in metres.yaml");
    let mut in_metres = String::new();
    for line in text.lines() {
        let changed = line.replace("d_mm: ", "d_mm: 0.000").replace("a_mm: ", "a_mm: 0.000");
        in_metres.push_str(
            &changed.replace("0.000-", "-0.000").replace("xyz_mm: [156, 0, 63]", "xyz_mm: [0.156, 0, 0.063]"),
        );
        in_metres.push('\n');
    }
    std::fs::write(&path, in_metres).unwrap();
    let out = run(&["robot", "check", path.to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(1), "{}", words(&out.stdout));
    assert!(words(&out.stderr).contains("metres written as millimetres"), "{}", words(&out.stderr));
}

#[test]
fn a_urdf_becomes_a_robot_file_that_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("robot.yaml");
    let out = run(&["robot", "init", "--urdf", "samples/robots/scara.urdf", "--output", made.to_str().unwrap()]);
    assert!(out.status.success(), "{}", words(&out.stderr));
    let robot = lostmotion::robot::Robot::load(&made).unwrap();
    assert_eq!(robot.axis_names(), ["shoulder", "elbow", "quill"]);
    // by hand: arms of 325 and 225 mm in line, quill 60 mm down from 400 mm, flange 20 mm below it
    let tcp = robot.tcp_m(&[0.0, 0.0, 0.06]) * 1e3;
    assert!((tcp - nalgebra::Vector3::new(550.0, 0.0, 320.0)).norm() < 1e-9, "{tcp}");
    // elbow at a right angle
    let tcp = robot.tcp_m(&[0.0, std::f64::consts::FRAC_PI_2, 0.0]) * 1e3;
    assert!((tcp - nalgebra::Vector3::new(325.0, 225.0, 380.0)).norm() < 1e-9, "{tcp}");
}

#[test]
fn what_is_no_urdf_is_refused_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.urdf");
    for (text, needle) in
        [("", "XML"), ("<robot name='r'>", "x.urdf:1:"), ("<mujoco/>", "<robot>"), ("<robot name='r'/>", "no chain")]
    {
        std::fs::write(&path, text).unwrap();
        let out = run(&["robot", "init", "--urdf", path.to_str().unwrap()]);
        assert_eq!(out.status.code(), Some(2), "{text}");
        assert!(words(&out.stderr).contains(needle), "{text}: {}", words(&out.stderr));
        assert!(out.stdout.is_empty());
    }
}
