//! Arcs of a Yaskawa job through three positions with joint values.
//!
//! The only gap is that of the S axis, which turns the arm about the vertical. The TCP goes on a horizontal circle with one
//! orientation, so that S is the direction of the TCP seen from that axis, and is largest where the circle touches a line from there.

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use std::path::Path;

const HALF_GAP_DEG: f64 = 0.02;
/// Joint values on the circle of 80 mm about (1282, 0, 873.4) mm at -20, 60, 110 and 150 deg. S is largest at 94 deg: 3.7231 deg.
const WIDE: [&str; 4] = [
    "-1.1991,5.7525,5.9553,-0.6908,-60.2100,1.3817",
    "3.1176,3.1756,3.2374,1.7974,-60.1107,-3.5965",
    "3.5709,-1.8807,-1.8591,2.0590,-60.0859,-4.1207",
    "1.9703,-5.1353,-4.9737,1.1353,-60.1811,-2.2711",
];
/// On the circle of 0.4 mm at -20, 60, 170 and 150 deg: no larger than the gap.
const SMALL: [&str; 4] = [
    "-0.0064,0.0283,0.0283,-0.0037,-60.0000,0.0073",
    "0.0161,0.0151,0.0151,0.0093,-60.0000,-0.0186",
    "0.0032,-0.0297,-0.0297,0.0019,-60.0000,-0.0037",
    "0.0093,-0.0261,-0.0261,0.0054,-60.0000,-0.0107",
];
const ARC: &str = "MOVC C00001 V=50.0\nMOVC C00002 V=50.0\nMOVC C00003 V=50.0\n";

/// Rewrites a job that goes from S -5 deg over an arc; the lines of the job that it becomes and what is said of it.
fn rewritten(points: [&str; 4], arc: &str, more: &str) -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/motoman-ma2010.yaml");
    std::fs::copy(robot, path("robot.yaml")).unwrap();
    let model = format!(
        "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {{effect: backlash, joint: S, half_gap_deg: {HALF_GAP_DEG}}}\n"
    );
    std::fs::write(path("model.yaml"), model).unwrap();
    let start = "C00000=-5.0000,5.7525,5.9553,-0.6908,-60.2100,1.3817\n";
    let list: String = points.iter().zip(1..).map(|(p, k)| format!("C{k:05}={p}\n")).collect();
    let head = "///DATE 2024/01/01 10:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n";
    let job = format!(
        "/JOB\n//NAME A\n//POS\n///NPOS 5,0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n{start}{list}//INST\n{head}\
         MOVJ C00000 VJ=25.00\n{arc}MOVL C00004 V=50.0\nMOVJ C00000 VJ=25.00\nEND\n"
    );
    std::fs::write(path("part.JBI"), job.replace('\n', "\r\n")).unwrap();
    let tools = "schema: lostmotion/frames/1\ntools:\n  \"0\": {xyz_mm: [0, 0, 0]}\n";
    std::fs::write(path("frames.yaml"), tools).unwrap();
    let line = format!("rewrite --model model.yaml part.JBI --frames frames.yaml --output out.JBI{more}");
    let run =
        Command::cargo_bin("lostmotion").unwrap().current_dir(folder.path()).args(line.split(' ')).assert().success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    let out = std::fs::read_to_string(path("out.JBI")).unwrap_or_default();
    (folder, out, said)
}

/// S of a position of a job, deg.
fn s_deg(job: &str, name: &str) -> f64 {
    let line = job.lines().find(|l| l.starts_with(&format!("{name}="))).unwrap();
    line.split(['=', ',']).nth(1).unwrap().parse().unwrap()
}

#[test]
fn the_points_of_an_arc_are_reached_from_the_side_from_which_the_arc_comes() {
    let (folder, out, _) = rewritten(WIDE, ARC, "");
    // S rises on the straight path to the arc and on its first part; on the second part it turns, and reaches the end falling
    for (name, own, side) in
        [("C00001", -1.1991, 1.0), ("C00002", 3.1176, 1.0), ("C00003", 3.5709, -1.0), ("C00004", 1.9703, -1.0)]
    {
        let wanted = own + side * HALF_GAP_DEG;
        assert!((s_deg(&out, name) - wanted).abs() < 6e-5, "{name}: {} instead of {wanted}", s_deg(&out, name));
    }
    // no step is added to an arc, and undo gives the job back
    assert_eq!(out.matches("MOVC ").count(), 3);
    let undo = ["undo", "out.JBI", "--output", "back.JBI"];
    Command::cargo_bin("lostmotion").unwrap().current_dir(folder.path()).args(undo).assert().success();
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("back.JBI"), read("part.JBI"));
}

#[test]
fn the_verdict_follows_an_arc_of_joint_values() {
    let (folder, _, _) = rewritten(WIDE, ARC, "");
    let line = "assess program --before part.JBI --after out.JBI --model model.yaml --frames frames.yaml --json";
    let run = Command::cargo_bin("lostmotion").unwrap().current_dir(folder.path()).args(line.split(' ')).assert();
    let all: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(all["at_targets"]["verdict"], "better");
    let text = all.to_string();
    assert!(!text.contains("arc or spline"), "{text}");
}

#[test]
fn an_arc_no_larger_than_the_gap_keeps_its_points() {
    let (_folder, out, said) = rewritten(SMALL, ARC, "");
    assert!(contains("so small that offsets at its ends would bend it").eval(&said), "{said}");
    for (name, own) in [("C00001", -0.0064), ("C00002", 0.0161), ("C00003", 0.0032)] {
        assert_eq!(s_deg(&out, name), own, "{name}");
    }
}

/// S rises to C00003 on the circle of C00001 to C00003, and falls to it on that of C00002 to C00004 (40 mm about (1282, 0, 873.4) mm, at
/// 45, 120 and 250 deg); found by its own solver.
const TWO_WAYS: [&str; 4] = [
    "0.9161,5.8506,6.0604,0.5278,-60.2140,-1.0556",
    "1.2857,2.1643,2.1931,0.7420,-60.0371,-1.4841",
    "1.6372,-1.4671,-1.4539,0.9449,-60.0267,-1.8900",
    "-1.7671,-0.9861,-0.9801,-1.0199,-60.0217,2.0402",
];

#[test]
fn four_circular_steps_are_edited_where_every_arc_through_them_comes_from_one_side() {
    let four = format!("{ARC}MOVC C00004 V=50.0\n");
    let (_folder, out, said) = rewritten(WIDE, &four, "");
    for (name, own, side) in
        [("C00001", -1.1991, 1.0), ("C00002", 3.1176, 1.0), ("C00003", 3.5709, -1.0), ("C00004", 1.9703, -1.0)]
    {
        let wanted = own + side * HALF_GAP_DEG;
        assert!((s_deg(&out, name) - wanted).abs() < 6e-5, "{name}: {} instead of {wanted}\n{said}", s_deg(&out, name));
    }
    assert_eq!(out.matches("MOVC ").count(), 4);
    let (_folder, out, said) = rewritten(TWO_WAYS, &four, "");
    assert!(
        contains("the end of an arc or spline on which the turning points of the joints are not known").eval(&said),
        "{said}"
    );
    for (name, own) in [("C00001", 0.9161), ("C00002", 1.2857), ("C00003", 1.6372), ("C00004", -1.7671)] {
        assert!(out.is_empty() || s_deg(&out, name) == own, "{name}\n{said}");
    }
}
