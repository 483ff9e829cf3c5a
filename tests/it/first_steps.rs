//! What a new user meets first: messages name the place, what is meant, and what to do, each thing once.

use super::vendor_rewrite::Desk;
use crate::support::bundled;
use lostmotion::robot::Robot;
use nalgebra::{Rotation3, UnitQuaternion};

const AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

/// A desk with an ABB arm whose first joint has a gap.
fn abb() -> (Desk, Robot) {
    let desk = Desk::new(0.02);
    let file = bundled("configs/abb-irb1600-6-145.yaml");
    std::fs::copy(file, desk.path("robot.yaml")).unwrap();
    let effect = "  - {effect: backlash, joint: J1, half_gap_deg: 0.02}\n";
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effect}"));
    let robot = Robot::load(&desk.path("robot.yaml")).unwrap();
    (desk, robot)
}

fn words(run: &assert_cmd::assert::Assert) -> String {
    String::from_utf8_lossy(&run.get_output().stderr).into_owned()
}

/// A target at which the joints stand so, with a configuration as it is written.
fn robtarget(robot: &Robot, joints_deg: [f64; 6], conf: &str) -> String {
    let pose = robot.forward(&joints_deg.map(f64::to_radians));
    let p = pose.position * 1e3;
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*pose.rotation.matrix()));
    format!("[[{:.5},{:.5},{:.5}],[{:.9},{:.9},{:.9},{:.9}],{conf},{AXES}]", p.x, p.y, p.z, q.w, q.i, q.j, q.k)
}

fn module(body: &str) -> String {
    format!("MODULE M\nPROC main()\n{body}Stop;\nENDPROC\nENDMODULE\n")
}

/// The joints are known, so that their quarters of a turn are, too: cf1 0, cf4 -1, cf6 0; the wrist in front, A5 above zero.
#[test]
fn a_configuration_that_does_not_fit_is_answered_with_those_that_do() {
    let (desk, robot) = abb();
    let program = |conf: &str| {
        let there = robtarget(&robot, [25.0, 5.0, 12.0, -15.0, 40.0, 20.0], conf);
        let start = format!("MoveAbsJ [[20,0,10,-15,45,25],{AXES}],v500,fine,tool0;\n");
        module(&format!("{start}MoveJ {there},v500,fine,tool0;\n{start}"))
    };
    desk.write("wrong.mod", &program("[3,0,-3,7]"));
    let said = words(&desk.run("rewrite --model model.yaml wrong.mod --dry-run").success());
    assert!(said.contains("line 4: the configuration here is `[3,0,-3,7]`"), "{said}");
    assert!(said.contains("reaches the target in `[0,-1,0,0]`"), "{said}");
    // what is named once is not named again
    assert_eq!(said.matches("no joints with its configuration").count(), 1, "{said}");
    desk.write("right.mod", &program("[0,-1,0,0]"));
    let said = words(&desk.run("rewrite --model model.yaml right.mod --dry-run").success());
    assert!(said.contains("all editable") && !said.contains("the configuration here"), "{said}");
}

#[test]
fn a_line_that_is_not_edited_is_named_once_with_what_becomes_of_directions() {
    let (desk, robot) = abb();
    let there = robtarget(&robot, [25.0, 5.0, 12.0, -15.0, 40.0, 20.0], "[0,-1,0,0]");
    let body = format!("MoveL {there},v50,fine,tUnknown;\n").repeat(3);
    desk.write("tool.mod", &module(&body));
    let said = words(&desk.run("rewrite --model model.yaml tool.mod --dry-run").success());
    assert!(said.contains("lines 3, 4, 5); directions are lost there"), "{said}");
    assert_eq!(said.matches("with unknown tool `tUnknown`").count(), 1, "{said}");
}

#[test]
fn an_assessment_names_the_tool_that_moves_wait_for() {
    let (desk, robot) = abb();
    let there = |a1: f64| robtarget(&robot, [a1, 5.0, 12.0, -15.0, 40.0, 20.0], "[0,-1,0,0]");
    let known: String = [5.0, 15.0, 25.0, 10.0].map(|a| format!("MoveJ {},v50,fine,tool0;\n", there(a))).concat();
    let waits = format!("MoveL {},v50,fine,tGun;\n", there(12.0));
    desk.write("a.mod", &module(&(known + &waits)));
    let run = desk.run("assess program --model model.yaml --before a.mod --after a.mod").success();
    assert!(
        words(&run).contains("tool `tGun` (1 move)") && words(&run).contains("a file of frames"),
        "{}",
        words(&run)
    );
}

/// A module that holds nothing declares nothing; one that may set a tool makes it uncertain.
#[test]
fn an_empty_module_beside_a_program_changes_nothing() {
    let (desk, robot) = abb();
    let tool = "PERS tooldata tPen:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n";
    let there = |a1: f64| robtarget(&robot, [a1, 5.0, 12.0, -15.0, 40.0, 20.0], "[0,-1,0,0]");
    let moves: String = [5.0, 25.0, 10.0].map(|a| format!("MoveJ {},v50,fine,tPen;\n", there(a))).concat();
    desk.write("cell/p.mod", &format!("MODULE M\n{tool}PROC main()\n{moves}Stop;\nENDPROC\nENDMODULE\n"));
    let edited = |said: String| said.contains("all editable");
    let run = || words(&desk.run("rewrite --model model.yaml cell/p.mod --dry-run").success());
    assert!(edited(run()), "{}", run());
    desk.write("cell/empty.mod", "");
    assert!(edited(run()), "{}", run());
    desk.write("cell/empty.mod", "MODULE E\nPROC x()\ntPen:=tOther;\nENDPROC\nENDMODULE\n");
    assert!(!edited(run()), "{}", run());
}

#[test]
fn a_folder_names_each_program_once() {
    let (desk, _) = abb();
    desk.write("cell/bad.mod", "MODULE M\nPROC main()\n");
    let run = desk.run("rewrite --model model.yaml cell --output-dir done").code(1);
    let said = words(&run);
    assert_eq!(said.matches("bad.mod").count(), 1, "{said}");
    assert!(said.contains("1 program:") && said.contains("1 of 1 program was not rewritten"), "{said}");
}

#[test]
fn one_program_is_one_program() {
    let (desk, _) = abb();
    desk.write("cell/a.mod", &module(&format!("MoveAbsJ [[20,0,10,-15,45,25],{AXES}],v500,fine,tool0;\n")));
    let said = words(&desk.run("manifest cell --output m.jsonl").success());
    assert_eq!(said.trim(), "1 program");
    desk.run("rewrite --model model.yaml cell --manifest m.jsonl --output-dir done --summary s.jsonl").success();
    let said = words(&desk.run("merge --manifest m.jsonl s.jsonl --output all.jsonl").success());
    assert!(said.starts_with("1 program: "), "{said}");
}

#[test]
fn a_table_says_how_it_names_the_robot() {
    let (desk, _) = abb();
    desk.write("table.csv", "name,d_mm,a_mm,alpha_deg\nJ1,400,25,-90\nJ2,0,455,0\n");
    let said = words(&desk.run("robot init --dh table.csv --output a.yaml").success());
    assert!(said.contains("the robot is named `table`, after the file (--name gives another)"), "{said}");
    desk.run("robot init --dh table.csv --name Cell4 --output b.yaml").success();
    assert!(String::from_utf8(desk.read("b.yaml")).unwrap().contains("name: Cell4"));
}

#[test]
fn help_of_help_is_help() {
    let (desk, _) = abb();
    assert!(words(&desk.run("help --help").success()).is_empty());
}

/// Logs of one arm with another one's file, 50 mm longer and shorter in places: the gaps come out nearly right and are not to be trusted.
#[test]
fn another_arms_file_is_found_by_the_measured_points() {
    let (desk, _) = abb();
    let own = String::from_utf8(desk.read("robot.yaml")).unwrap();
    let other =
        own.replace("a_mm: 150", "a_mm: 100").replace("d_mm: 600", "d_mm: 660").replace("a_mm: 700", "a_mm: 640");
    assert_ne!(own, other);
    desk.write("other.yaml", &other);
    desk.run("plan-experiment static --robot robot.yaml --pose 0,0,0,20,40,20 --output plan.csv").success();
    desk.run("simulate --model model.yaml --input plan.csv --noise-um 10 --rate-hz 5 --output log.csv").success();
    let said = words(&desk.run("identify static --robot robot.yaml --log log.csv --output right.yaml").success());
    assert!(!said.contains("cannot be trusted") && !said.contains("calibration errors"), "{said}");
    desk.run("fit --robot robot.yaml --gaps right.yaml --output right.comp.yaml").success();
    let said = words(&desk.run("identify static --robot other.yaml --log log.csv --output wrong.yaml").success());
    assert!(
        said.contains("the gaps cannot be trusted") && said.contains("a tenth of the measured points are"),
        "{said}"
    );
    let said = words(&desk.run("fit --robot other.yaml --gaps wrong.yaml --output wrong.comp.yaml").code(1));
    assert!(said.contains("--force"), "{said}");
    desk.run("fit --robot other.yaml --gaps wrong.yaml --output wrong.comp.yaml --force").success();
}

#[test]
fn positions_in_metres_are_answered_with_the_entry_that_mends_them() {
    let (desk, _) = abb();
    desk.run("plan-experiment path --robot robot.yaml --pose 0,0,0,20,40,20 --output plan.csv").success();
    desk.run("simulate --model model.yaml --input plan.csv --noise-um 10 --rate-hz 10 --output log.csv").success();
    let log = String::from_utf8(desk.read("log.csv")).unwrap();
    let in_metres = |line: &str| -> String {
        let number = |(k, field): (usize, &str)| match field.parse::<f64>() {
            Ok(v) if k >= 7 => format!("{:.9}", v / 1e3),
            _ => field.to_string(),
        };
        line.split(',').enumerate().map(number).collect::<Vec<_>>().join(",")
    };
    desk.write("metres.csv", &log.lines().map(|l| in_metres(l) + "\n").collect::<String>());
    let said = words(&desk.run("identify path --robot robot.yaml --log metres.csv --output gaps.yaml").code(2));
    assert!(said.contains("`x_mm: {to: x_mm, unit: m}, the same for y and z`"), "{said}");
    // and that mends them
    let entries: String = ["x", "y", "z"].map(|c| format!("  {c}_mm: {{to: {c}_mm, unit: m}}\n")).concat();
    desk.write("map.yaml", &format!("schema: lostmotion/columns/1\ncolumns:\n{entries}"));
    desk.run("identify path --robot robot.yaml --log metres.csv --columns map.yaml --output gaps.yaml").success();
}

/// What the model predicts of both programs is what logs of both runs show, but for the mean that a rigid fit of each log takes.
#[test]
fn logs_of_a_ring_are_fitted_across_the_path_and_not_along_it() {
    let (desk, _) = abb();
    let step = |k: f64| (0.5 + k * std::f64::consts::TAU / 48.0).sin_cos();
    let rows: String = (0..=48)
        .map(|k| {
            let (s, c) = step(f64::from(k));
            format!("{:.5},{:.5},{:.5},0,40,0\n", 8.0 * c, 5.0 + 6.0 * s, 10.0 - 4.0 * s)
        })
        .collect();
    desk.write("ring.csv", &format!("J1_deg,J2_deg,J3_deg,J4_deg,J5_deg,J6_deg\n{rows}"));
    desk.run("rewrite --model model.yaml ring.csv --speed-mm-s 20 --output done.csv").success();
    for (program, log) in [("ring.csv", "before.csv"), ("done.csv", "after.csv")] {
        let line = format!("simulate --model model.yaml --input {program} --speed-mm-s 20 --rate-hz 25 --output {log}");
        desk.run(&line).success();
    }
    let run = desk.run("assess program --model model.yaml --before before.csv --after after.csv --json").success();
    let result: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    // the same programs on the same machine, without logs
    let run = desk
        .run("assess program --model model.yaml --before ring.csv --after done.csv --speed-mm-s 20 --json")
        .success();
    let programs: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    let after = |of: &serde_json::Value| of["rms_um"]["after"].as_f64().unwrap();
    let before = result["rms_um"]["before"].as_f64().unwrap();
    assert!(after(&result) < after(&programs) + 5.0 && after(&result) < 0.1 * before, "{result}");
}

#[test]
fn a_file_of_another_kind_is_called_what_it_is() {
    let (desk, _) = abb();
    desk.write("p.mod", &module(&format!("MoveAbsJ [[20,0,10,-15,45,25],{AXES}],v500,fine,tool0;\n")));
    desk.write("log.csv", "t_s,cmd_J1_deg,x_mm,y_mm,z_mm\n0,1,2,3,4\n");
    desk.write("german.csv", "t_s;cmd_J1_deg;x_mm;y_mm;z_mm\n0,0;1,5;2,5;3,5;4,5\n");
    for (line, says) in [
        ("identify path --robot robot.yaml --log p.mod --output x.yaml", "no header: the first line is `MODULE M`"),
        ("identify path --robot robot.yaml --log german.csv --output x.yaml", "`decimal: \",\"`"),
        ("fit --robot robot.yaml --gaps log.csv --output x.yaml", "a gaps file (schema lostmotion/gaps/1)"),
        ("status --manifest log.csv", "a line that is not JSON"),
    ] {
        let said = words(&desk.run(line).code(2));
        assert!(said.contains(says), "{line}: {said}");
    }
}

/// A FANUC program of poses, reached over one joint target: the format's 0.001 deg cannot hold a gap of 0.0003 deg, its 0.001 mm can.
#[test]
fn a_joint_target_too_coarse_for_a_gap_does_not_refuse_a_program_of_poses() {
    let (desk, _) = abb();
    let file = bundled("configs/fanuc-m20ia.yaml");
    std::fs::copy(file, desk.path("robot.yaml")).unwrap();
    let effect = "  - {effect: backlash, joint: J1, half_gap_deg: 0.0003}\n";
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effect}"));
    let robot = Robot::load(&desk.path("robot.yaml")).unwrap();
    let start = [20.0, 15.0, -25.0, 20.0, -45.0, 10.0];
    let joints: Vec<String> = start.iter().enumerate().map(|(a, v)| format!("J{}= {v:9.3} deg", a + 1)).collect();
    let mut positions = format!("P[1]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{}\n}};\n", joints.join(",\t"));
    let mut lines = String::from("   1:J P[1] 20% FINE    ;\n");
    for (k, j1) in [22.0, 24.0, 26.0, 24.0, 22.0, 20.5].into_iter().enumerate() {
        let mut q = start.map(f64::to_radians);
        q[0] = f64::to_radians(j1);
        let pose = robot.forward(&q);
        let (w, p, r) = pose.rotation.euler_angles();
        let (at, n) = (pose.position * 1e3, k + 2);
        let _ = std::fmt::Write::write_fmt(
            &mut positions,
            format_args!(
                "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {:9.3}  mm,\tY = {:9.3}  mm,\tZ = {:9.3}  mm,\n\tW = {:9.3} deg,\tP = {:9.3} deg,\tR = {:9.3} deg\n}};\n",
                at.x,
                at.y,
                at.z,
                w.to_degrees(),
                p.to_degrees(),
                r.to_degrees()
            ),
        );
        lines += &format!("{n:4}:L P[{n}] 20mm/sec CNT100    ;\n");
    }
    desk.write("seam.ls", &format!("/PROG  SEAM\n/ATTR\nLINE_COUNT\t= 7;\n/MN\n{lines}/POS\n{positions}/END\n"));
    desk.write(
        "frames.yaml",
        "schema: lostmotion/frames/1\nframes: {}\ntools:\n  \"1\": {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}\n",
    );
    let run = desk.run("rewrite --model model.yaml seam.ls --frames frames.yaml --output out.ls").success();
    assert!(words(&run).contains("joint targets hold no offset of J1 (half gap 0.000300 deg"), "{}", words(&run));
    let out = std::fs::read_to_string(desk.path("out.ls")).unwrap();
    assert!(out.contains("J1=    20.000 deg"), "the joint target stays:\n{out}");
    assert_ne!(out, std::fs::read_to_string(desk.path("seam.ls")).unwrap());
}

#[test]
fn a_header_with_other_names_is_answered_with_the_map_that_reads_it_or_the_command_that_drafts_one() {
    let (desk, robot) = abb();
    let q: Vec<String> = (0..6).map(|k| format!("target_q_{k}")).collect();
    desk.write("rtde.csv", &format!("timestamp {}\n0.0 0 0 0 0 0.1 0\n", q.join(" ")));
    desk.write("tracker.csv", "Time;X;Y;Z\n0;1,5;2;3\n");
    let said = words(&desk.run("join --robot robot.yaml --controller rtde.csv --tracker tracker.csv --tracker-columns tracker --output log.csv").code(2));
    assert!(said.contains("--controller-columns rtde reads this header"), "{said}");
    let columns = "--controller-columns rtde --output log.csv";
    let said = words(
        &desk.run(&format!("join --robot robot.yaml --controller rtde.csv --tracker tracker.csv {columns}")).code(2),
    );
    assert!(said.contains("--tracker-columns tracker reads this header"), "{said}");
    let axes: Vec<String> = (1..=6).map(|n| format!("Achse {n} [rad]")).collect();
    desk.write("own.csv", &format!("Zeit [ms];{};X [mm];Y [mm];Z [mm]\n0;0;0;0;0;0,5;0;1;2;3\n", axes.join(";")));
    let said = words(&desk.run("identify --robot robot.yaml --log own.csv").code(2));
    assert!(said.contains("`lostmotion columns` drafts a column map"), "{said}");
    desk.run("columns own.csv --robot robot.yaml --output map.yaml").success();
    let map = lostmotion::log::ColumnMap::load(&desk.path("map.yaml")).unwrap();
    let log = lostmotion::log::Log::load_with(&desk.path("own.csv"), &robot, Some(&map)).unwrap();
    assert_eq!((log.command(0)[4], log.t_s[0]), (0.5, 0.0));
}

#[test]
fn a_dry_run_gives_the_verdict_and_leaves_nothing() {
    let (desk, robot) = abb();
    let there = |a1: f64| robtarget(&robot, [a1, 5.0, 12.0, -15.0, 40.0, 20.0], "[0,-1,0,0]");
    let moves: String =
        [5.0, 6.0, 7.0, 8.0, 7.0, 6.0, 5.0].map(|a| format!("MoveL {},v50,z1,tool0;\n", there(a))).concat();
    let start = format!("MoveAbsJ [[4,5,12,-15,40,20],{AXES}],v500,fine,tool0;\n");
    desk.write("a.mod", &module(&(start + &moves)));
    let before = std::fs::read_dir(desk.path("")).unwrap().count();
    let said = words(&desk.run("rewrite --model model.yaml a.mod --dry-run").success());
    assert!(said.contains("verdict on the model's machine"), "{said}");
    assert_eq!(std::fs::read_dir(desk.path("")).unwrap().count(), before);
}

#[test]
fn a_document_of_another_kind_is_answered_with_the_command_that_makes_the_right_one() {
    let (desk, _) = abb();
    desk.write("gaps.yaml", "schema: lostmotion/gaps/1\n");
    let said = words(&desk.run("rewrite --robot robot.yaml --compensator gaps.yaml x.csv --output y.csv").code(2));
    assert!(said.contains("expected schema `lostmotion/compensator/1` (`fit` makes one of gaps)"), "{said}");
    let robot = std::fs::read_to_string(desk.path("robot.yaml")).unwrap();
    desk.write("typo.yaml", &robot.replacen(", max_speed_deg_s", ", max_sped_deg_s", 1));
    let said = words(&desk.run("robot check typo.yaml").code(2));
    assert!(said.contains("an unknown key `max_sped_deg_s`; expected perhaps `max_speed_deg_s`"), "{said}");
}
