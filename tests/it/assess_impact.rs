//! `assess impact` against Zhang (2023) Table 2 and analytic cases.

use crate::support::{self, WorkFolder};
use lostmotion::assess::impact::{AxisGap, displacement_m, over_program};
use lostmotion::effects::GapCurve;
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use serde_json::Value;
use std::path::Path;

const KUKA: &str = "configs/kuka-kr120-r2500-pro.yaml";

fn impact(args: &[&str]) -> Value {
    let out = support::command().args(["assess", "impact", "--json"]).args(args).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap()
}

/// Rows of Table 2: joint, pose, half gap, printed error.
fn table_2() -> Vec<(String, String, String, f64)> {
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).from_path("tests/data/zhang2023_table2.csv").unwrap();
    reader
        .records()
        .map(|r| r.unwrap())
        .map(|r| (r[0].to_string(), r[1].to_string(), r[2].to_string(), r[3].parse().unwrap()))
        .collect()
}

#[test]
fn each_joint_at_its_own_pose_rounds_to_table_2_of_seed_000() {
    let table = table_2();
    let gaps: Vec<String> = table.iter().map(|(j, _, g, _)| format!("{j}={g}")).collect();
    let gaps = gaps.join(",");
    let named: Vec<String> = table.iter().map(|(j, p, _, _)| format!("{j}@{p}")).collect();
    let in_order: Vec<String> = table.iter().map(|(_, p, _, _)| p.clone()).collect();
    for poses in [named, in_order] {
        let mut args = vec!["--robot", KUKA, "--half-gap", &gaps];
        for p in &poses {
            args.extend(["--pose", p]);
        }
        let found = impact(&args);
        assert_eq!(found["schema"], "lostmotion/impact/1");
        let joints = found["joints"].as_array().unwrap();
        assert_eq!(joints.len(), 6);
        for (j, (name, _, _, printed)) in joints.iter().zip(&table) {
            assert_eq!(j["joint"], name.as_str());
            assert_eq!(j["tcp_um"].as_f64().unwrap().round(), *printed, "{name}");
            let both = j["between_directions_um"].as_f64().unwrap();
            assert!((both - 2.0 * j["tcp_um"].as_f64().unwrap()).abs() < 0.002);
        }
    }
}

#[test]
fn one_pose_serves_all_joints() {
    let args = ["--robot", KUKA, "--pose", "40,-10,5,0,0,0", "--half-gap", "0.0032,0.005,0.0022,0.008,0.0092,0.0078"];
    let found = impact(&args);
    // computed with rotations about fixed axes
    for (j, want) in found["joints"].as_array().unwrap().iter().zip([154.86, 211.67, 49.65, 21.78, 51.19, 21.24]) {
        assert!((j["tcp_um"].as_f64().unwrap() - want).abs() < 0.006, "{j}");
    }
}

#[test]
fn a_prismatic_gap_moves_the_tcp_by_itself_anywhere() {
    let robot = Robot::load(Path::new("configs/gantry-xyz-ballscrew.yaml")).unwrap();
    for q in [[0.1, 0.2, 0.3], [0.0, 0.5, 0.1]] {
        for axis in 0..3 {
            assert!((displacement_m(&robot, &q, axis, 9.125e-5) - 9.125e-5).abs() < 1e-12);
        }
    }
}

#[test]
fn over_a_program_only_reversing_joints_share_and_the_largest_is_where_it_says() {
    let robot = Robot::load(Path::new(KUKA)).unwrap();
    let input = lostmotion::io::input::read(Path::new("samples/circle/circle_program.csv")).unwrap();
    let program = Program::parse(input, &robot).unwrap();
    let gaps: Vec<AxisGap> = [(0, 0.0028), (1, 0.0037), (2, 0.0022), (3, 0.0061)]
        .into_iter()
        .map(|(axis, deg): (usize, f64)| AxisGap { axis, curves: vec![GapCurve::Constant(deg.to_radians())] })
        .collect();
    let joints = over_program(&robot, &program, &gaps);
    assert_eq!(joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [1, 0, 2, 3]);
    assert_eq!(joints.iter().map(|j| j.reversals).collect::<Vec<_>>(), [4, 4, 4, 0]);
    assert!((joints.iter().map(|j| j.share).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!((joints[3].share, joints[3].at_reversals_m), (0.0, None));
    for j in &joints {
        let gap = gaps.iter().find(|g| g.axis == j.axis).unwrap();
        let mut q = vec![0.0; 6];
        let all: Vec<f64> = (0..program.len())
            .map(|i| {
                program.point_into(i, &mut q);
                displacement_m(&robot, &q, j.axis, gap.at(q[j.axis]))
            })
            .collect();
        let row = (0..program.len()).position(|i| program.line(i) == j.largest_line).unwrap();
        assert_eq!(all[row], j.largest_m);
        assert!(all.iter().all(|d| *d <= j.largest_m));
        let rms = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
        assert!((rms - j.rms_m).abs() < 1e-15);
    }
}

#[test]
fn two_gaps_of_a_model_on_one_joint_add_up() {
    let folder = WorkFolder::new();
    let robot = std::fs::canonicalize("configs/gantry-xyz-ballscrew.yaml").unwrap();
    let model = folder.join("m.yaml");
    let text = format!(
        "schema: lostmotion/model/1\nrobot: {}\neffects:\n- {{effect: backlash, joint: X, half_gap_mm: 0.025}}\n\
         - {{effect: backlash, joint: X, half_gap_mm: 0.09125}}\n",
        robot.display()
    );
    std::fs::write(&model, text).unwrap();
    let found = impact(&["--model", model.to_str().unwrap(), "--pose", "100,100,100"]);
    assert_eq!(found["joints"].as_array().unwrap().len(), 1);
    assert_eq!((&found["joints"][0]["tcp_um"], &found["joints"][0]["half_gap_mm"]), (&116.25.into(), &0.11625.into()));
}

#[test]
fn refuses_gaps_and_poses_that_do_not_fit_the_robot() {
    let pose = "40,-10,5,0,0,0";
    for (args, says) in [
        (vec!["--robot", KUKA, "--pose", "40,-10,5", "--half-gap", "A1=1"], "with 3 values"),
        (vec!["--robot", KUKA, "--pose", pose, "--half-gap", "0.1,0.2"], "one gap for each of A1"),
        (vec!["--robot", KUKA, "--pose", pose, "--half-gap", "A7=0.2"], "joint `A7`"),
        (vec!["--robot", KUKA, "--pose", pose, "--half-gap", "A1=-0.2"], "one gap of 0 or more"),
        (vec!["--robot", KUKA, "--pose", "A1@40,-10,5,0,0,0", "--half-gap", "A2=0.1"], "a gap for A2 and no pose"),
        (vec!["--robot", KUKA, "--pose", pose, "--pose", pose, "--half-gap", "A2=0.1"], "one per joint"),
        (vec!["--robot", KUKA, "--pose", "40,-10,5,0,0,inf", "--half-gap", "A2=0.1"], "`inf` in --pose"),
        (vec!["--robot", KUKA, "--pose", pose], "--half-gap"),
    ] {
        let assert = support::command().args(["assess", "impact"]).args(&args).assert().code(2);
        let stderr = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(stderr.contains(says), "{args:?}: {stderr}");
    }
}
