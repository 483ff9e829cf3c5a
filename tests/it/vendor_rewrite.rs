//! Vendor programs through the command line: coverage, refusals, undo, checks, folders.

use crate::support::{self, WorkFolder, bundled};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use std::path::PathBuf;

/// A folder with a robot, a model and a program.
pub struct Desk {
    pub folder: WorkFolder,
}

pub const PROGRAM: &str = "&ACCESS RVP\r\nDEF part( )\r\n; a comment\r\nPTP {A1 0.0000,A2 -90.0000,A3 90.0000,A4 0.0,A5 10.0,A6 0.0}\r\n\
PTP {A1 20.0000,A2 -80.0000,A3 95.0000,A4 0.0,A5 10.0,A6 0.0} C_PTP\r\n\
PTP {A1 5.0000,A2 -85.0000,A3 90.0000,A4 0.0,A5 10.0,A6 0.0}\r\nEND\r\n";

impl Desk {
    pub fn new(half_gap_deg: f64) -> Self {
        let folder = WorkFolder::new();
        let robot = bundled("configs/kuka-kr120-r2500-pro.yaml");
        std::fs::copy(robot, folder.join("robot.yaml")).unwrap();
        let desk = Self { folder };
        desk.write(
            "model.yaml",
            &format!(
                "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {{effect: backlash, joint: A1, half_gap_deg: {half_gap_deg}}}\n"
            ),
        );
        desk.write("part.src", PROGRAM);
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        if let Some(parent) = self.path(name).parent() {
            std::fs::create_dir_all(parent).unwrap();
        }
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub fn run(&self, line: &str) -> assert_cmd::assert::Assert {
        support::command().current_dir(self.folder.path()).args(line.split(' ')).assert()
    }
}

#[test]
fn a_turn_gets_its_point_and_every_other_byte_stays() {
    let desk = Desk::new(0.003);
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    let lines: Vec<&str> = out.split("\r\n").collect();
    assert_eq!(lines.len(), PROGRAM.split("\r\n").count() + 1);
    assert_eq!(&lines[..3], &["&ACCESS RVP", "DEF part( )", "; a comment"]);
    assert!(lines[4].starts_with("PTP {A1 20.0030,A2 -80.0000,") && lines[4].ends_with(" C_PTP"), "{}", lines[4]);
    // the new point: on the way down, offset downwards
    assert!(lines[5].starts_with("PTP {A1 19."), "{}", lines[5]);
    assert!(lines[6].starts_with("PTP {A1 4.9970,A2 -85.0000,"), "{}", lines[6]);
}

#[test]
fn a_model_without_gaps_gives_the_same_bytes_and_no_note() {
    let desk = Desk::new(0.0);
    desk.run("rewrite --model model.yaml part.src --output out.src").success().stderr(contains("byte for byte"));
    assert_eq!(desk.read("out.src"), PROGRAM.as_bytes());
    assert!(!desk.path("out.src.lostmotion.json").exists());
    desk.run("rewrite --model model.yaml part.src --output out.src --exit-code").code(3);
}

#[test]
fn undo_gives_the_original_back_and_touches_no_program_that_was_changed() {
    let desk = Desk::new(0.003);
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
    desk.run("undo out.src --output back.src").success();
    let told = desk.run("undo out.src --output told.src --json").success();
    let told: serde_json::Value = serde_json::from_slice(&told.get_output().stdout).unwrap();
    assert_eq!(told["files"][0]["sha256"], lostmotion::io::input::sha256(&desk.read("back.src")));
    assert_eq!(desk.read("back.src"), PROGRAM.as_bytes());
    desk.run("rewrite --model model.yaml out.src --output twice.src").code(2).stderr(contains("rewritten already"));
    let mut changed = desk.read("out.src");
    changed.extend(b"; later\r\n");
    std::fs::write(desk.path("out.src"), &changed).unwrap();
    desk.run("undo out.src --output other.src").code(1).stderr(contains("changed since `rewrite` wrote it"));
    assert!(!desk.path("other.src").exists());
    std::fs::write(desk.path("out.src"), &changed[..changed.len() - 9]).unwrap();
    desk.run("undo out.src --in-place").success();
    assert_eq!(desk.read("out.src"), PROGRAM.as_bytes());
    assert!(!desk.path("out.src.lostmotion.json").exists());
    desk.run("undo out.src --in-place").code(2).stderr(contains("no note"));
}

#[test]
fn undo_gives_rows_back_as_well() {
    let desk = Desk::new(0.003);
    let row = |k: i32| format!("{}.25,-90,90,0,0,0\n", 10 - (k - 10).abs());
    let rows: String = (0..21).map(row).collect();
    desk.write("rows.csv", &format!("A1_deg,A2_deg,A3_deg,A4_deg,A5_deg,A6_deg\n{rows}"));
    desk.run("rewrite --model model.yaml rows.csv --output out.csv").success();
    assert_ne!(desk.read("out.csv"), desk.read("rows.csv"));
    desk.run("undo out.csv --output back.csv").success();
    assert_eq!(desk.read("back.csv"), desk.read("rows.csv"));
    // an unchanged result is no rewritten program: the note of an earlier one goes
    desk.run("rewrite --model model.yaml rows.csv --output out.csv --gain 0").success();
    assert_eq!(desk.read("out.csv"), desk.read("rows.csv"));
    assert!(!desk.path("out.csv.lostmotion.json").exists());
}

#[test]
fn coverage_is_said_with_lines_and_can_be_required() {
    let desk = Desk::new(0.003);
    let relative = PROGRAM.replace("END\r\n", "PTP_REL {A1 5.0}\r\nEND\r\n");
    desk.write("part.src", &relative);
    let run = desk.run("rewrite --model model.yaml part.src --dry-run");
    run.success().stderr(contains("4 moves, 2 editable").and(contains("line 6")).and(contains("line 7")));
    let run = desk.run("rewrite --model model.yaml part.src --output out.src --require-coverage 100%");
    run.code(1).stderr(contains("2 of 4 moves can be edited, 50.0 %").and(contains("line 7")));
    assert!(!desk.path("out.src").exists());
    desk.run("rewrite --model model.yaml part.src --output out.src --require-coverage 50").success();
}

#[test]
fn moves_between_off_and_on_stay_as_they_are() {
    let desk = Desk::new(0.003);
    let text = PROGRAM
        .replace("PTP {A1 20.0000", "; lostmotion: off\r\nPTP {A1 20.0000")
        .replace("PTP {A1 5.0000", "; lostmotion: on\r\nPTP {A1 5.0000");
    desk.write("part.src", &text);
    desk.run("rewrite --model model.yaml part.src --output out.src").success().stderr(contains("switched off"));
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    assert!(out.contains("PTP {A1 20.0000,") && out.contains("PTP {A1 4.9970,"), "{out}");
}

#[test]
fn a_gap_below_the_last_digit_of_the_format_is_refused() {
    let desk = Desk::new(0.0004);
    let robot = bundled("configs/fanuc-m10ia.yaml");
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let model = String::from_utf8(desk.read("model.yaml")).unwrap().replace("joint: A1", "joint: J1");
    desk.write("model.yaml", &model);
    let sample = bundled("samples/programs/fanuc/reversal.ls");
    std::fs::copy(sample, desk.path("part.ls")).unwrap();
    let run = desk.run("rewrite --model model.yaml part.ls --output out.ls");
    run.code(1).stderr(contains("0.001000 deg").and(contains("0.000400 deg")).and(contains("--leave-out J1")));
    assert!(!desk.path("out.ls").exists());
    desk.run("rewrite --model model.yaml part.ls --output out.ls --leave-out J1").success();
}

#[test]
fn a_check_names_the_first_difference_in_degrees_and_micrometres() {
    let desk = Desk::new(0.003);
    desk.run("rewrite --model model.yaml part.src --output golden.src").success();
    desk.run("rewrite --model model.yaml part.src --check golden.src").success();
    let golden = String::from_utf8(desk.read("golden.src")).unwrap().replace("A1 20.0030", "A1 20.0130");
    desk.write("golden.src", &golden);
    let run = desk.run("rewrite --model model.yaml part.src --check golden.src");
    run.code(1).stderr(contains("golden.src:5: the output differs").and(contains("A1 -0.010000 deg, at the TCP")));
}

#[test]
fn a_folder_goes_on_where_it_was_killed_and_ends_with_the_same_bytes() {
    let desk = Desk::new(0.003);
    for k in 0..12 {
        desk.write(&format!("cell/{}/p{k}.src", k % 3), &PROGRAM.replace("20.0000", &format!("{}.0000", 20 + k)));
    }
    desk.write("cell/bad.src", "DEF bad( )\r\nPTP {A1 1..5}\r\nEND\r\n");
    desk.write("cell/notes.json", "{\"a\": 1}");
    let line = "rewrite --model model.yaml cell --output-dir done --summary done.jsonl";
    desk.run(line).code(1).stderr(contains("13 programs: 12 written, 0 unchanged, 0 refused, 1 failed"));
    let before = std::fs::metadata(desk.path("done/0/p0.src")).unwrap().modified().unwrap();
    let summary = desk.read("done.jsonl");
    // a kill or a loss of power leaves programs without notes or with zeros, half-written temporary files, and no summary
    std::fs::remove_file(desk.path("done/1/p1.src.lostmotion.json")).unwrap();
    std::fs::remove_file(desk.path("done/2/p2.src")).unwrap();
    desk.write("done/2/.lostmotion-abcdefghij.part", "half");
    desk.write("done/2/p5.src", "DEF part( )\r\nPTP\0\0\0\0\0\0\0\0");
    std::fs::remove_file(desk.path("done.jsonl")).unwrap();
    desk.run(line).code(1);
    assert_eq!(desk.read("done.jsonl"), summary);
    assert_eq!(std::fs::metadata(desk.path("done/0/p0.src")).unwrap().modified().unwrap(), before, "done twice");
    assert!(!desk.path("done/2/.lostmotion-abcdefghij.part").exists());
    // an undisturbed run elsewhere, on one thread and in shards
    desk.run("rewrite --model model.yaml cell --output-dir whole --summary whole.jsonl").code(1);
    for k in 1..=2 {
        let _ = desk.run(&format!("rewrite --model model.yaml cell --output-dir parts --shard {k}/2"));
    }
    for k in 0..12 {
        let name = format!("{}/p{k}.src", k % 3);
        assert_eq!(desk.read(&format!("done/{name}")), desk.read(&format!("whole/{name}")), "{name}");
        assert_eq!(desk.read(&format!("done/{name}")), desk.read(&format!("parts/{name}")), "{name}");
    }
    let moved = String::from_utf8(desk.read("whole.jsonl")).unwrap().replace("whole/", "done/");
    assert_eq!(moved.as_bytes(), summary);
}

#[test]
fn straight_cartesian_moves_become_joint_moves_where_that_is_asked() {
    let desk = Desk::new(0.003);
    let robot = bundled("configs/universal-robots-ur10.yaml");
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let model = String::from_utf8(desk.read("model.yaml")).unwrap().replace("joint: A1", "joint: base");
    desk.write("model.yaml", &model);
    // the pose stands 150 mm beside the first point and 100 mm below it, turned alike (own matrix product)
    let cartesian = "movel(p[-0.87741, -0.02046, 0.32866, 2.15337, 2.14798, -0.00000], a=1.2, v=0.25)";
    let program = format!(
        "def part():\n  set_tcp(p[0,0,0,0,0,0])\n  movej([0.0, -1.2, 1.5, -1.8, -1.5, 0.0], a=1.4, v=1.05)\n  {cartesian}\n  \
         movej([0.3, -1.2, 1.5, -1.8, -1.5, 0.0], a=1.4, v=1.05)\nend\n"
    );
    desk.write("part.script", &program);
    let run = desk.run("rewrite --model model.yaml part.script --leave-cartesian --output plain.script");
    // the turn after it is known although it stays as it is
    run.success().stderr(contains("2 editable").and(contains("Cartesian target")).and(contains("base: 1 reversal")));
    assert!(String::from_utf8(desk.read("plain.script")).unwrap().contains(cartesian));
    let run = desk.run("rewrite --model model.yaml part.script --output solved.script --solve-cartesian=20");
    run.success().stderr(contains("3 moves, all editable"));
    let solved = String::from_utf8(desk.read("solved.script")).unwrap();
    assert!(!solved.contains("p[-0.87741"), "{solved}");
    let moves = solved.lines().filter(|l| l.contains("move")).count();
    assert!(moves > 10, "{solved}");
    // the joints of every new point lie on the line: the tip is nowhere 20 um beside it
    let robot = lostmotion::robot::Robot::load(&desk.path("robot.yaml")).unwrap();
    let program = lostmotion::program::Program::load(&desk.path("solved.script"), &robot).unwrap();
    let at = |i: usize| robot.tcp_m(&program.q.iter().map(|q| q[i]).collect::<Vec<f64>>());
    let (start, end) = (at(0), at(0) + nalgebra::Vector3::new(0.0, 0.15, -0.1));
    let along = (end - start).normalize();
    // the offsets of 0.003 degrees move the tip by 0.05 mm at most
    for i in 1..moves - 2 {
        let off = at(i) - start;
        assert!((off - along * off.dot(&along)).norm() < 1.2e-4, "point {i}");
    }
}

#[test]
fn no_number_is_made_up_for_an_axis_whose_place_is_not_known() {
    let desk = Desk::new(0.003);
    // the robot stands wherever the loop ended; the targets inside name one axis at first
    desk.write(
        "part.src",
        "DEF part( )\r\nPTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\r\nLOOP\r\nPTP {A1 10.0000}\r\nPTP {A1 5.0000}\r\n\
         PTP {A1 8.0000,A2 -85.0000}\r\nENDLOOP\r\nEND\r\n",
    );
    let run = desk.run("rewrite --model model.yaml part.src --output out.src");
    run.success().stderr(contains("before the position of every axis is known; lines 4, 5, 6"));
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    assert!(!out.contains("A3 0.0"), "{out}");
    // an axis that nobody names is not written at all
    desk.write("one.src", "DEF one( )\r\nPTP {A1 5.0}\r\nPTP {A1 10.0}\r\nPTP {A1 5.0}\r\nEND\r\n");
    desk.run("rewrite --model model.yaml one.src --output one_out.src").success();
    let out = String::from_utf8(desk.read("one_out.src")).unwrap();
    assert!(out.contains("PTP {A1 9.9") && !out.contains("A2"), "{out}");
}

#[test]
fn points_added_on_a_straight_tcp_move_stand_on_its_line() {
    let desk = Desk::new(0.003);
    let robot = bundled("configs/universal-robots-ur10.yaml");
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    // gaps next to nothing on every joint: what is written must be the path itself
    let joints = lostmotion::robot::Robot::load(&desk.path("robot.yaml")).unwrap();
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for name in joints.axis_names() {
        model += &format!("  - {{effect: backlash, joint: {name}, half_gap_deg: 0.00006}}\n");
    }
    desk.write("model.yaml", &model);
    let at = |pan: f64| format!("  movel([{pan}, -1.2, 1.5, -1.8, -1.5, 0.0], a=1.2, v=0.25)\n");
    let tcp = "  set_tcp(p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0])\n";
    let program = format!("def part():\n{tcp}{}{}{}end\n", at(-0.3), at(0.3), at(-0.3)).replacen("movel", "movej", 1);
    desk.write("part.script", &program);
    desk.run("rewrite --model model.yaml part.script --output out.script").success();
    let written = lostmotion::program::Program::load(&desk.path("out.script"), &joints).unwrap();
    assert!(written.len() > 5, "the arm folds and stretches on this line: {}", written.len());
    let tcp = |i: usize| joints.tcp_m(&written.q.iter().map(|q| q[i]).collect::<Vec<f64>>());
    let along = (joints.tcp_m(&[0.3, -1.2, 1.5, -1.8, -1.5, 0.0]) - tcp(0)).normalize();
    for i in 0..written.len() {
        let off = tcp(i) - tcp(0);
        let beside = (off - along * off.dot(&along)).norm();
        // 0.00006 degrees of six joints at 1.3 m, and the last digits
        assert!(beside < 8e-6, "point {i} stands {:.1} um beside the line", beside * 1e6);
    }
}

/// A UR10 with gaps next to nothing on every joint: what is written must be the path itself.
fn desk_of_ur10() -> (Desk, lostmotion::robot::Robot) {
    let desk = Desk::new(0.003);
    let robot = bundled("configs/universal-robots-ur10.yaml");
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let robot = lostmotion::robot::Robot::load(&desk.path("robot.yaml")).unwrap();
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for name in robot.axis_names() {
        model += &format!("  - {{effect: backlash, joint: {name}, half_gap_deg: 0.00006}}\n");
    }
    desk.write("model.yaml", &model);
    (desk, robot)
}

const TURNING: &str = "  movej([0.0, -1.57, 1.2, -1.75, -1.57, 0.0], a=1.4, v=1.05)\n\
  movel([0.3, -1.27, 1.0, -1.25, -0.57, 0.3], a=1.2, v=0.25)\n";

#[test]
fn points_on_a_straight_way_to_joint_values_stand_on_the_line_of_the_tool_that_the_program_sets() {
    let (desk, robot) = desk_of_ur10();
    desk.write("part.script", &format!("def part():\n  set_tcp(p[0.0, 0.1, 0.3, 0.0, 0.0, 0.0])\n{TURNING}end\n"));
    desk.run("rewrite --model model.yaml part.script --output out.script").success();
    let written = lostmotion::program::Program::load(&desk.path("out.script"), &robot).unwrap();
    assert!(written.len() > 4, "joints turn on this line: {}", written.len());
    let tool = nalgebra::Isometry3::translation(0.0, 0.1, 0.3);
    let tooled = robot.with_geometry(robot.joints.clone(), tool);
    let at = |i: usize| tooled.tcp_m(&written.q.iter().map(|q| q[i]).collect::<Vec<f64>>());
    let along = (at(written.len() - 1) - at(0)).normalize();
    for i in 0..written.len() {
        let off = at(i) - at(0);
        let beside = (off - along * off.dot(&along)).norm();
        assert!(beside < 1.2e-5, "point {i} stands {:.1} um beside the line", beside * 1e6);
    }
}

#[test]
fn a_straight_way_to_joint_values_of_a_tool_that_nobody_gives_stays_and_its_tool_is_asked_for() {
    let (desk, _) = desk_of_ur10();
    let text = format!("def part():\n{TURNING}end\n");
    desk.write("part.script", &text);
    let line = "rewrite --model model.yaml part.script --output out.script";
    desk.run(line).success().stderr(contains("a straight move to joint values with unknown tool `tcp`; line 3"));
    let out = String::from_utf8(desk.read("out.script")).unwrap();
    assert!(out.matches("movel").count() == 1 && out.contains("movel([0.3, -1.27, 1.0, -1.25, -0.57, 0.3]"), "{out}");
    desk.write(
        "frames.yaml",
        "schema: lostmotion/frames/1\ntools:\n  tcp: {xyz_mm: [0, 0, 300], rpy_deg: [0, 0, 0]}\n",
    );
    desk.run(&format!("{line} --frames frames.yaml --force")).success();
    assert!(String::from_utf8(desk.read("out.script")).unwrap().matches("movel").count() > 2);
}

#[test]
fn an_arc_to_joint_values_stays_as_its_joints_may_turn_on_it() {
    let desk = Desk::new(0.003);
    let robot = bundled("configs/motoman-ma2010.yaml");
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    desk.write(
        "model.yaml",
        "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect: backlash, joint: S, half_gap_deg: 0.02}\n",
    );
    let points = "C00000=0.0000,0.0000,0.0000,0.0000,-30.0000,0.0000\r\nC00001=8.0000,5.0000,0.0000,0.0000,-30.0000,0.0000\r\n\
        C00002=3.0000,10.0000,0.0000,0.0000,-30.0000,0.0000\r\nC00003=6.0000,0.0000,0.0000,0.0000,-30.0000,0.0000\r\n";
    let job = format!(
        "/JOB\r\n//NAME A\r\n//POS\r\n///NPOS 4,0,0,0,0,0\r\n///TOOL 0\r\n///POSTYPE ANGLE\r\n///ANGLE\r\n{points}//INST\r\n\
         ///DATE 2024/01/01 10:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\nMOVJ C00000 VJ=25.00\r\nMOVC C00000 V=50.0\r\n\
         MOVC C00001 V=50.0\r\nMOVC C00002 V=50.0 FPT\r\nMOVJ C00003 VJ=25.00\r\nMOVJ C00000 VJ=25.00\r\nEND\r\n"
    );
    desk.write("part.JBI", &job);
    let run = desk.run("rewrite --model model.yaml part.JBI --output out.JBI").success();
    run.stderr(contains("the end of an arc or spline on which the turning points of the joints are not known; lines"));
    let out = String::from_utf8(desk.read("out.JBI")).unwrap();
    for kept in ["C00001=8.0000,", "C00002=3.0000,"] {
        assert!(out.contains(kept), "{out}");
    }
    // the motions after it are edited
    assert!(out.contains("C00003=6.0200,"), "{out}");
}

#[test]
fn files_of_a_program_go_over_no_other_file() {
    let desk = Desk::new(0.003);
    let data = "DEFDAT part\r\nDECL E6AXIS XA={A1 5.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\r\nENDDAT\r\n";
    desk.write("part.src", "DEF part( )\r\nPTP XA\r\nPTP {A1 10.0}\r\nPTP XA\r\nEND\r\n");
    desk.write("part.dat", data);
    desk.run("rewrite --model model.yaml part.src --output part.txt").code(2).stderr(contains("file of the program"));
    desk.run("rewrite --model model.yaml part.src --output part.dat").code(2);
    desk.write("other.dat", "DEFDAT other\r\nENDDAT\r\n");
    desk.run("rewrite --model model.yaml part.src --output other.src")
        .code(1)
        .stderr(contains("no note shows that it belongs"));
    desk.run("rewrite --model model.yaml part.src --output out.src --summary part.dat").code(2);
    assert_eq!(desk.read("part.dat"), data.as_bytes());
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
    desk.run("undo out.src --output out.txt").code(2);
    desk.run("undo out.src --output back.src").success();
    assert_eq!(desk.read("back.dat"), data.as_bytes());
    assert_eq!(desk.read("back.src"), desk.read("part.src"));
    // two programs with one data list: neither is written
    desk.write("cell/part.src", "DEF part( )\r\nPTP XA\r\nEND\r\n");
    desk.write("cell/part.sub", "DEF part( )\r\nPTP XA\r\nEND\r\n");
    desk.write("cell/part.dat", data);
    let run = desk.run("rewrite --model model.yaml cell --output-dir done");
    run.code(1).stderr(contains("belongs to another program").and(contains("2 refused")));
}

const POINT_OF_ALL: &str = "DEF part( )\nPTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}\nPTP XSAFE\n\
PTP {A1 5.0,A2 -85.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}\nEND\n";

/// A project of one program whose point `$config.dat` declares.
fn project(desk: &Desk, a1_deg: f64) {
    desk.write("in/R1/Program/part.src", POINT_OF_ALL);
    let point = format!("DECL GLOBAL E6AXIS XSAFE={{A1 {a1_deg:.1},A2 -80.0,A3 95.0,A4 0.0,A5 10.0,A6 0.0}}");
    desk.write("in/R1/System/$config.dat", &format!("DEFDAT $CONFIG\n{point}\nENDDAT\n"));
}

#[test]
fn a_folder_is_done_again_where_a_file_that_declares_its_points_has_changed() {
    let desk = Desk::new(0.003);
    let batch = "rewrite --model model.yaml in --output-dir out";
    let result = || String::from_utf8(desk.read("out/R1/Program/part.src")).unwrap();
    project(&desk, 20.0);
    desk.run(batch).success();
    assert!(result().contains("PTP {A1 20.0"), "{}", result());
    // as it was: not done again, so that a mark in its note stays
    let note = "out/R1/Program/part.src.lostmotion.json";
    let marked = String::from_utf8(desk.read(note)).unwrap() + "\n\n";
    desk.write(note, &marked);
    desk.run(batch).success();
    assert_eq!(desk.read(note), marked.as_bytes());
    project(&desk, 30.0);
    desk.run(batch).success();
    assert!(result().contains("PTP {A1 30.0"), "{}", result());
}

#[test]
fn a_file_that_cannot_be_read_beside_a_program_is_said_and_leaves_what_it_may_change() {
    let desk = Desk::new(0.003);
    project(&desk, 20.0);
    let dry = "rewrite --model model.yaml in/R1/Program/part.src --dry-run --json";
    desk.run(dry).success().stdout(contains("\"editable\":3").or(contains("\"editable\": 3")));
    let wide: Vec<u8> = "DEF b( )\nXSAFE.A1=5\nEND\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(desk.path("in/R1/Program/b.src"), [&[0xff, 0xfe], wide.as_slice()].concat()).unwrap();
    desk.run(dry).success().stdout(
        contains("b.src cannot be read: moves that it may declare or change stay as they are")
            .and(contains("\"editable\":0").or(contains("\"editable\": 0"))),
    );
}
