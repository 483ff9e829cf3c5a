//! Which programs are refused because what is written leaves the path of what was given.

use crate::support::{WorkFolder, bundled};
use crate::vendor_loops;
use assert_cmd::Command;
use predicates::str::contains;
use std::path::Path;

/// A straight motion whose speed is in a register, and fast joint motions whose corners the TCP, half a metre from the flange, rounds.
fn program() -> String {
    let mut points = vec![([0.0, 0.0], "J @ 100% FINE"), ([60.0, 0.0], "L @ R[1]mm/sec FINE")];
    let mut at = [60.0, 0.0];
    for k in 0..24 {
        match k % 2 {
            1 => at[1] += if (k / 2) % 2 == 1 { -30.0 } else { 30.0 },
            _ => at[0] += if (k / 4) % 2 == 0 { -30.0 } else { 30.0 },
        }
        points.push((at, "J @ 100% CNT100"));
    }
    points.push(([0.0, 0.0], "J @ 100% FINE"));
    let (mut lines, mut list) = (String::new(), String::new());
    for (n, ([j1, j2], words)) in points.iter().enumerate().map(|(n, p)| (n + 1, p)) {
        lines += &format!("{n:4}:{}    ;\r\n", words.replace('@', &format!("P[{n}]")));
        list += &format!(
            "P[{n}]{{\r\n   GP1:\r\n\tUF : 0, UT : 1,\t\r\n\tJ1={j1:10.3} deg,\tJ2={j2:10.3} deg,\tJ3=     0.000 deg,\r\n\
             \tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\r\n}};\r\n"
        );
    }
    format!("/PROG  PART\r\n/ATTR\r\nLINE_COUNT\t= {};\r\n/MN\r\n{lines}/POS\r\n{list}/END\r\n", points.len())
}

#[test]
fn fast_moves_in_a_long_program_are_not_taken_for_a_lost_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/fanuc-m10ia.yaml");
    let text = std::fs::read_to_string(robot).unwrap();
    let long = text.replace("\ntool: {xyz_mm: [0, 0, 0]", "\ntool: {xyz_mm: [0, 0, 500]");
    assert_ne!(text, long);
    std::fs::write(path("robot.yaml"), long).unwrap();
    let effects = "effects:\n  - {effect: backlash, joint: J1, half_gap_deg: 0.004}\n";
    std::fs::write(path("model.yaml"), format!("schema: lostmotion/model/1\nrobot: robot.yaml\n{effects}")).unwrap();
    let tools = "schema: lostmotion/frames/1\ntools:\n  \"1\": {xyz_mm: [0, 0, 500]}\n";
    std::fs::write(path("frames.yaml"), tools).unwrap();
    std::fs::write(path("part.LS"), program()).unwrap();
    let line = "rewrite --model model.yaml part.LS --frames frames.yaml --output out.LS";
    let run = Command::cargo_bin("lostmotion").unwrap().current_dir(folder.path()).args(line.split(' ')).assert();
    run.success().stderr(contains("verdict on the model's machine: better"));
    assert!(path("out.LS").exists());
}

/// Three branches of joint targets: no move goes from the end of one of them to the start of another.
#[test]
fn branches_of_joint_targets_are_not_run_one_after_another() {
    let desk = vendor_loops::desk();
    let all = |list: &[i32]| list.iter().map(|deg| vendor_loops::to(*deg)).collect::<String>();
    let body = format!(
        "{}TEST i\nCASE 1:\n{}CASE 2:\n{}DEFAULT:\n{}ENDTEST\n{}",
        all(&[0, 20, 5]),
        all(&[20]),
        all(&[30]),
        all(&[40]),
        all(&[45])
    );
    desk.write("p.mod", &vendor_loops::program(&body));
    let run = desk.run("rewrite --model model.yaml p.mod --output out.mod").success();
    run.stderr(contains("verdict on the model's machine: better"));
}

#[test]
fn a_straight_move_that_the_arm_cannot_follow_gets_no_points_on_its_way() {
    let folder = WorkFolder::new();
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    std::fs::copy(bundled("configs/motoman-ma2010.yaml"), folder.join("robot.yaml")).unwrap();
    let effects = "effects:\n  - {effect: backlash, joint: S, half_gap_deg: 0.02}\n";
    write("model.yaml", format!("schema: lostmotion/model/1\nrobot: robot.yaml\n{effects}"));
    write("frames.yaml", "schema: lostmotion/frames/1\ntools:\n  \"0\": {xyz_mm: [0, 0, 0]}\n".into());
    // S turns at C00001; the wrist stands the same way, or turned over, at C00002, with the same pose
    let moves = |wrist: &str| {
        let list = format!(
            "C00000=-5.0000,5.0000,5.0000,-90.0000,-60.0000,0.0000\nC00001=0.0000,5.0000,5.0000,-90.0000,-60.0000,0.0000\n\
             C00002=-4.0000,9.0000,5.0000,{wrist}\nC00003=-6.0000,9.0000,5.0000,{wrist}\n"
        );
        write(
            "part.JBI",
            format!(
                "/JOB\n//NAME A\n//POS\n///NPOS 4,0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n{list}//INST\n\
                 ///DATE 2024/01/01 10:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\nMOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\n\
                 MOVL C00002 V=50.0\nMOVJ C00003 VJ=25.00\nEND\n"
            ),
        );
        folder.run("rewrite --model model.yaml part.JBI --frames frames.yaml --output out.JBI").success();
        let out = std::fs::read_to_string(folder.join("out.JBI")).unwrap();
        let s_deg = |name: &str| -> f64 {
            let line = out.lines().find(|l| l.starts_with(&format!("{name}="))).unwrap();
            line.split(['=', ',']).nth(1).unwrap().parse().unwrap()
        };
        // the goal carries the step all the same
        assert!((s_deg("C00002") + 4.02).abs() < 1e-4, "{}", s_deg("C00002"));
        out.matches("\nMOV").count()
    };
    assert!(moves("-90.0000,-60.0000,0.0000") > 4);
    assert_eq!(moves("90.0000,60.0000,180.0000"), 4);
    // nor a point from which its goal is reached from another side, and it carries the offset of its own
    let exact = std::fs::read_to_string(folder.join("part.JBI"))
        .unwrap()
        .replace("MOVL C00002 V=50.0", "MOVL C00002 V=50.0 PL=0");
    write("part.JBI", exact);
    let sided = "rewrite --model model.yaml part.JBI --frames frames.yaml --output sided.JBI --approach-from S=+";
    let outcome = folder.run(sided).success();
    assert!(outcome.stderr.contains("no point can be added before them (lines 19"), "{}", outcome.stderr);
    let out = std::fs::read_to_string(folder.join("sided.JBI")).unwrap();
    assert!(out.contains("C00002=-4.0200,"), "{out}");
    assert_eq!(out.matches("\nMOVL").count(), 1);
}
