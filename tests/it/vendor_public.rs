//! Vendor programs through the command line: what public programs brought to light.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

/// A desk with the robot of `config` and half gaps of its joints, in deg or mm.
fn desk_of(config: &str, gaps: &[(&str, &str)]) -> Desk {
    let desk = Desk::new(0.003);
    let robot = bundled("configs").join(config);
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    model(&desk, gaps);
    desk
}

fn model(desk: &Desk, gaps: &[(&str, &str)]) {
    let mut text = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for (joint, gap) in gaps {
        text += &format!("  - {{effect: backlash, joint: {joint}, {gap}}}\n");
    }
    desk.write("model.yaml", &text);
}

fn out(desk: &Desk, name: &str) -> String {
    String::from_utf8(desk.read(name)).unwrap()
}

/// A FANUC program to these joint values, deg.
fn fanuc(points: &[[f64; 6]]) -> String {
    let mut text = format!("/PROG  P\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", points.len());
    for k in 1..=points.len() {
        text += &format!("{k:4}:J P[{k}] 10% FINE    ;\n");
    }
    text += "/POS\n";
    for (k, q) in points.iter().enumerate() {
        let f = |i: usize| format!("J{}={:>10.3} deg", i + 1, q[i]);
        let rows = [[f(0), f(1), f(2)].join(",\t"), [f(3), f(4), f(5)].join(",\t")];
        text += &format!("P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{},\n\t{}\n}};\n", k + 1, rows[0], rows[1]);
    }
    text + "/END\n"
}

/// The value of a joint in every position of a FANUC program, deg.
fn written(text: &str, joint: &str) -> Vec<f64> {
    let after = |l: &str| l.split_once(joint).map(|(_, rest)| rest.trim_start_matches('=').trim().to_string());
    let number = |rest: String| rest.split_whitespace().next().and_then(|w| w.parse().ok());
    text.lines().filter_map(after).filter_map(number).collect()
}

#[test]
fn the_gap_of_a_fanuc_elbow_belongs_to_the_sum_of_two_axes() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J3", "half_gap_deg: 0.01")]);
    // J3 never turns; the elbow, J2 + J3, goes 0, 15, 0
    desk.write("part.ls", &fanuc(&[[0.0; 6], [0.0, 20.0, -5.0, 0.0, 0.0, 0.0], [0.0, 10.0, -10.0, 0.0, 0.0, 0.0]]));
    desk.run("rewrite --model model.yaml part.ls --output out.ls").success().stderr(contains("J3: 1 reversal"));
    let (j2, j3) = (written(&out(&desk, "out.ls"), "J2"), written(&out(&desk, "out.ls"), "J3"));
    assert_eq!((j3[0], j3[1], j3[2]), (0.01, -4.99, -10.01));
    assert_eq!((j2[0], j2[1], j2[2]), (0.0, 20.0, 10.0));
    // the new point stands where the robot stops, its elbow after the step
    assert!(j3.len() == 4 && (j2[3] + j3[3] - (15.0 - 0.01)).abs() < 1e-9 && j2[3] == 20.0, "{j2:?} {j3:?}");
    // what J2's own offset turns the elbow by is taken back
    model(&desk, &[("J2", "half_gap_deg: 0.004"), ("J3", "half_gap_deg: 0.01")]);
    desk.run("rewrite --model model.yaml part.ls --output both.ls").success();
    let (j2, j3) = (written(&out(&desk, "both.ls"), "J2"), written(&out(&desk, "both.ls"), "J3"));
    assert_eq!((j2[1], j3[1]), (20.004, -4.994));
    assert_eq!((j2[2], j3[2]), (9.996, -10.006));
}

#[test]
fn the_verdict_runs_a_fanuc_elbow_by_the_sum_of_two_axes() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J2", "half_gap_deg: 0.004"), ("J3", "half_gap_deg: 0.01")]);
    // J3 turns against its motor, and with it
    let points = [
        [0.0; 6],
        [0.0, 20.0, -5.0, 0.0, 0.0, 0.0],
        [0.0, 10.0, -10.0, 0.0, 0.0, 0.0],
        [0.0, 15.0, 10.0, 0.0, 0.0, 0.0],
    ];
    desk.write("part.ls", &fanuc(&points));
    let run = desk.run("rewrite --model model.yaml part.ls --output out.ls --json").success();
    let doc: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    let targets = &doc["path_error"]["at_targets"];
    let largest = |side: &str| targets["largest_um"][side].as_f64().unwrap();
    // the elbow's gap at 0.7 m is 120 um
    assert!(targets["targets"] == 4 && largest("before") > 50.0 && largest("after") < 0.5, "{doc}");
}

#[test]
fn without_the_sum_in_the_robot_file_a_fanuc_elbow_is_left_out() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J3", "half_gap_deg: 0.01")]);
    let text = fanuc(&[[0.0; 6], [0.0, 20.0, -5.0, 0.0, 0.0, 0.0], [0.0, 10.0, 10.0, 0.0, 0.0, 0.0]]);
    desk.write("part.ls", &text);
    let robot = out(&desk, "robot.yaml");
    desk.write("robot.yaml", &robot.replace("gap_of: {J3: J2 + J3}", ""));
    let run = desk.run("rewrite --model model.yaml part.ls --output out.ls");
    run.success().stderr(contains("J3 is left out").and(contains("gap_of: {J3: J2 + J3}")));
    assert_eq!(out(&desk, "out.ls"), text);
    // an arm that shows motor angles says so
    desk.write("robot.yaml", &robot.replace("gap_of: {J3: J2 + J3}", "gap_of: {J3: J3}"));
    desk.run("rewrite --model model.yaml part.ls --output own.ls").success().stderr(contains("left out").not());
    assert_eq!(written(&out(&desk, "own.ls"), "J3")[1], -5.01);
    for (wrong, found) in [
        ("{J3: J2}", "`J2`"),
        ("{J3: J9 + J3}", "`J9`"),
        ("{J9: J3}", "`J9`"),
        ("{J3: J2 + J3, J2: J3 + J2}", "a sum of another sum"),
        ("{J3: J3 J2}", "without + or -"),
    ] {
        desk.write("robot.yaml", &robot.replace("{J3: J2 + J3}", wrong));
        let run = desk.run("rewrite --model model.yaml part.ls --output wrong.ls");
        run.code(2).stderr(contains("gap_of").and(contains(found)));
    }
}

#[test]
fn straight_motions_of_a_fanuc_arm_stay_where_the_robot_file_does_not_say_how_it_counts_j3() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J1", "half_gap_deg: 0.01"), ("J2", "half_gap_deg: 0.01")]);
    let points =
        [[-10.0, 20.0, -5.0, 0.0, -60.0, 0.0], [10.0, 20.0, -5.0, 0.0, -60.0, 0.0], [-10.0, 0.0, 0.0, 0.0, -60.0, 0.0]];
    let text = fanuc(&points).replace("   2:J P[2] 10%", "   2:L P[2] 100mm/sec");
    desk.write("part.ls", &text);
    desk.write("frames.yaml", "schema: lostmotion/frames/1\ntools:\n  \"1\": {xyz_mm: [0, 0, 100]}\n");
    let robot = out(&desk, "robot.yaml");
    let lines = |name: &str| out(&desk, name).lines().filter(|l| l.contains(":L P[")).count();
    let rewrite = |name: &str| {
        desk.run(&format!("rewrite --model model.yaml part.ls --frames frames.yaml --output {name} --force"))
    };
    rewrite("own.ls").success();
    assert!(lines("own.ls") > 1, "{}", out(&desk, "own.ls"));
    // as a URDF describes the arm: J3 against the upper arm
    let against: String = robot.lines().filter(|l| !l.contains("name: J23")).map(|l| format!("{l}\n")).collect();
    for gap_of in ["gap_of: {J3: J2 + J3}", ""] {
        desk.write("robot.yaml", &against.replace("gap_of: {J3: J2 + J3}", gap_of));
        rewrite("against.ls").success().stderr(contains("show J3 against the horizontal"));
        assert_eq!(lines("against.ls"), 1, "{gap_of}");
        assert_eq!(written(&out(&desk, "against.ls"), "J1")[1], 10.0, "{gap_of}");
    }
    // an arm that shows motor angles
    desk.write("robot.yaml", &against.replace("gap_of: {J3: J2 + J3}", "gap_of: {J3: J3}"));
    rewrite("motors.ls").success();
    assert!(lines("motors.ls") > 1);
}

#[test]
fn poses_of_a_fanuc_program_need_no_joint_values_and_are_edited_without_the_count_of_j3() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J1", "half_gap_deg: 0.01")]);
    let robot: String =
        out(&desk, "robot.yaml").lines().filter(|l| !l.contains("name: J23")).map(|l| format!("{l}\n")).collect();
    desk.write("robot.yaml", &robot.replace("gap_of: {J3: J2 + J3}", ""));
    desk.write("frames.yaml", "schema: lostmotion/frames/1\ntools:\n  \"1\": {xyz_mm: [0, 0, 100]}\n");
    let mut text = String::from("/PROG  P\n/ATTR\nLINE_COUNT\t= 3;\n/MN\n");
    for k in 1..=3 {
        text += &format!("{k:4}:L P[{k}] 100mm/sec FINE    ;\n");
    }
    text += "/POS\n";
    for (k, y) in [-150.0, 150.0, -150.0].iter().enumerate() {
        text += &format!(
            "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX =   800.000  mm,\tY = {y:9.3}  mm,\tZ =   100.000  mm,\n\tW =   180.000 deg,\tP =     0.000 deg,\tR =     0.000 deg\n}};\n",
            k + 1
        );
    }
    desk.write("part.ls", &(text + "/END\n"));
    desk.run("rewrite --model model.yaml part.ls --frames frames.yaml --output out.ls").success();
    let y = written(&out(&desk, "out.ls"), "Y =");
    assert!(y[1] > 150.1 && y[2] < -150.1, "{y:?}");
}

#[test]
fn rounding_to_a_formats_digits_never_passes_a_limit() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J1", "half_gap_deg: 0.0096")]);
    let robot = out(&desk, "robot.yaml").replacen("limits_deg: [-180, 180]", "limits_deg: [-180, 179.9997]", 1);
    desk.write("robot.yaml", &robot);
    // 179.9996 is within the limit, 180.000 is not
    desk.write("part.ls", &fanuc(&[[0.0; 6], [179.99, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]]));
    desk.run("rewrite --model model.yaml part.ls --output out.ls").success();
    let j1 = written(&out(&desk, "out.ls"), "J1");
    assert!(j1[1] == 179.999 && j1.iter().all(|v| *v <= 179.9997), "{j1:?}");
}

#[test]
fn times_between_which_no_double_lies_are_refused() {
    let desk = Desk::new(0.01);
    let rows: String = [0.0, 9.0, 1.0, 5.0]
        .iter()
        .enumerate()
        .map(|(k, a)| format!("{a:.4},-90,90,0,10,0,{}\n", 1_000_000_000_000_000_u64 + k as u64))
        .collect();
    desk.write("part.csv", &format!("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg,t_s\n{rows}"));
    let run = desk.run("rewrite --model model.yaml part.csv --output out.csv --step-fraction 0.01");
    run.code(1).stderr(contains("no time between two points"));
    assert!(!desk.path("out.csv").exists());
}

#[test]
fn new_exact_stops_are_counted_with_their_lines() {
    let desk = desk_of("fanuc-m10ia.yaml", &[("J1", "half_gap_deg: 0.01")]);
    desk.write("part.ls", &fanuc(&[[0.0; 6], [20.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 6]]));
    let run = desk.run("rewrite --model model.yaml part.ls --output out.ls --json").success();
    let document: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(document["new_stops"][0]["stops"], 1);
    assert_eq!(document["new_stops"][0]["line"], 7);
    let cycle = &document["cycle_time_s"];
    if !cycle.is_null() {
        assert!(cycle["after"].as_f64() > cycle["before"].as_f64(), "{cycle}");
    }
    let run = desk.run("rewrite --model model.yaml part.ls --dry-run");
    run.success().stderr(contains("1 exact stop that the program did not have (line 7)"));
}

/// The arc goes almost round, and X and Y turn between its start and its end; its E word allows no point on the way.
const ARC: &str = "G21 G90 G17\nG0 X100 Y100 Z0\nG1 Y95.0 F600\nG1 X110.0 Y100.0\nG2 X109.8481 Y101.7365 I-10.0 J0.0 E1.0\n\
    G1 X120.0\nG1 X105.0\nG1 X108.0\n";

#[test]
fn an_arc_that_cannot_be_written_is_left_and_the_rest_of_the_file_is_not() {
    let desk = desk_of("gantry-xyz-ballscrew.yaml", &[("X", "half_gap_mm: 0.02"), ("Y", "half_gap_mm: 0.02")]);
    desk.write("part.nc", ARC);
    let run = desk.run("rewrite --model model.yaml part.nc --output out.nc");
    // the move that ends where the arc starts stays, too
    run.success().stderr(contains("not edited: 2 moves (").and(contains("whole circle")).and(contains("lines 4, 5")));
    let out = out(&desk, "out.nc");
    let arc: Vec<&str> = ARC.lines().skip(3).take(2).collect();
    assert!(out.contains(&arc.join("\n")), "{out}");
    assert!(out.contains("G1 X120.020") && out.contains("G1 X104.980") && out.contains("G1 X108.020"), "{out}");
}

#[test]
fn words_that_a_program_never_says_are_named_and_may_be_assumed() {
    let desk = desk_of("gantry-xyz-ballscrew.yaml", &[("X", "half_gap_mm: 0.02")]);
    let text = "G1 X100.0 F600\nG1 X120.0\nG1 X110.0\n";
    desk.write("part.nc", text);
    let run = desk.run("rewrite --model model.yaml part.nc --output out.nc");
    run.success().stderr(contains("never sets G90 or G91, nor G20 or G21").and(contains("assume G21,G90")));
    assert_eq!(out(&desk, "out.nc"), text);
    desk.run("rewrite --model model.yaml part.nc --output mm.nc --assume G21,G90").success();
    let mm = out(&desk, "mm.nc");
    assert!(mm.contains("G1 X120.020\n") && mm.ends_with("G1 X109.980\n"), "{mm}");
    desk.run("rewrite --model model.yaml part.nc --output x.nc --assume G5").code(2).stderr(contains("--assume G5"));
    let robot = out(&desk, "robot.yaml") + "control: [G21, G90]\n";
    desk.write("robot.yaml", &robot);
    desk.run("rewrite --model model.yaml part.nc --output robot.nc").success();
    assert_eq!(out(&desk, "robot.nc"), out(&desk, "mm.nc"));
}

#[test]
fn a_leg_shorter_than_a_tenth_of_the_half_gap_is_no_reversal() {
    let desk = Desk::new(0.003);
    let at = |a1: f64| format!("PTP {{A1 {a1:.6},A2 -90.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}}\r\n");
    let program = |turn: f64| format!("DEF part( )\r\n{}{}{}{}END\r\n", at(0.0), at(20.0), at(20.0 - turn), at(30.0));
    desk.write("part.src", &program(0.000_006));
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
    let a1 = |l: &str| l.strip_prefix("PTP {A1 ").and_then(|l| l.split(',').next()).and_then(|v| v.parse::<f64>().ok());
    let goals: Vec<f64> = out(&desk, "out.src").lines().filter_map(a1).collect();
    // nothing was added, and every goal carries the offset of a rising joint
    assert_eq!(goals, [0.003, 20.003, 20.002_99, 30.003]);
    // a leg of half a half gap is one
    desk.write("part.src", &program(0.0015));
    desk.run("rewrite --model model.yaml part.src --output two.src").success().stderr(contains("A1: 2 reversals"));
}

#[test]
fn a_limit_that_the_controller_keeps_by_itself_is_a_note_and_no_refusal() {
    let desk = desk_of("abb-irb1600-6-145.yaml", &[("J1", "half_gap_deg: 0.05")]);
    let robot = out(&desk, "robot.yaml").replacen("max_accel_deg_s2: 500", "max_accel_deg_s2: 5", 1);
    desk.write("robot.yaml", &robot);
    let at = |j1: f64| format!("    MoveL [[{j1},0,0,0,30,0]], v200, z1, tool0;\n").replace("MoveL", "MoveAbsJ");
    let extern_axes = "[9E9,9E9,9E9,9E9,9E9,9E9]";
    let body: String = [0.0, 20.0, 19.0, 20.0, 19.0].map(at).concat().replace("]], v", &format!("],{extern_axes}], v"));
    desk.write("part.mod", &format!("MODULE M\n  PROC main()\n{body}  ENDPROC\nENDMODULE\n"));
    let run = desk.run("rewrite --model model.yaml part.mod --output out.mod --speed-mm-s 2000");
    run.success().stderr(contains("the controller slows down there"));
    assert!(out(&desk, "out.mod").contains("[[20.05"));
}

#[test]
fn a_plan_keeps_its_start_and_its_velocities() {
    let desk = desk_of("universal-robots-ur10.yaml", &[("base", "half_gap_deg: 0.01")]);
    let point = |base: f64, v: f64, t: f64| {
        format!(
            "- positions: [{base}, -1.2, 1.5, -1.8, -1.5, 0.0]\n  velocities: [{v}, 0.0, 0.0, 0.0, 0.0, 0.0]\n  time_from_start: {t}\n"
        )
    };
    // the plan turns between its points, 0.05 rad beyond the second one
    let text = String::from("joint_names: [base, shoulder, elbow, wrist1, wrist2, wrist3]\npoints:\n")
        + &point(0.0, 0.0, 0.0)
        + &point(0.5, 0.4, 2.0)
        + &point(0.5, -0.4, 2.5)
        + &point(0.1, -0.2, 4.0)
        + &point(0.0, 0.0, 5.0);
    desk.write("part.yaml", &text);
    desk.run("rewrite --model model.yaml part.yaml --output out.yaml").success().stderr(contains("base: 1 reversal"));
    let out = out(&desk, "out.yaml");
    assert!(out.contains(&point(0.0, 0.0, 0.0)), "{out}");
    let lines: Vec<&str> = out.lines().collect();
    let velocity_at = |t: &str| {
        let k = lines.iter().position(|l| l.trim() == format!("time_from_start: {t}")).unwrap();
        lines[k - 1].split('[').nth(1).unwrap().split(',').next().unwrap().to_string()
    };
    assert_eq!(["2", "2.5", "4", "5"].map(velocity_at), ["0.4", "-0.4", "-0.2", "0"]);
    // the turn stands where the velocity is zero: half way, by symmetry
    let k = lines.iter().position(|l| l.contains("time_from_start: 2.25")).expect(&out);
    let number = |l: &str| l.split('[').nth(1).unwrap().split(',').next().unwrap().parse::<f64>().unwrap();
    assert!(number(lines[k - 1]).abs() < 1e-6 && (number(lines[k - 2]) - 0.55 - 0.01_f64.to_radians()).abs() < 1e-6);
}

#[test]
fn a_step_that_breaks_a_limit_at_the_times_of_a_plan_is_spread_until_it_does_not() {
    let desk = desk_of("universal-robots-ur10.yaml", &[("base", "half_gap_deg: 0.1")]);
    let robot = out(&desk, "robot.yaml").replacen("max_accel_deg_s2: 800", "max_accel_deg_s2: 100", 1);
    desk.write("robot.yaml", &robot);
    let text = "joint_names: [base, shoulder, elbow, wrist1, wrist2, wrist3]\n\
        points:\n- {positions: [0.0000, -1.2, 1.5, -1.8, -1.5, 0.0], velocities: [0, 0, 0, 0, 0, 0], time_from_start: 1.000}\n- {positions: [-0.0781, -1.2, 1.5, -1.8, -1.5, 0.0], velocities: [0, 0, 0, 0, 0, 0], time_from_start: 1.101}\n- {positions: [-0.0085, -1.2, 1.5, -1.8, -1.5, 0.0], velocities: [0, 0, 0, 0, 0, 0], time_from_start: 1.520}\n- {positions: [-0.0097, -1.2, 1.5, -1.8, -1.5, 0.0], velocities: [0, 0, 0, 0, 0, 0], time_from_start: 2.119}\n- {positions: [0.1691, -1.2, 1.5, -1.8, -1.5, 0.0], velocities: [0, 0, 0, 0, 0, 0], time_from_start: 2.468}\n";
    desk.write("part.yaml", text);
    let run = desk.run("rewrite --model model.yaml part.yaml --output out.yaml");
    run.success().stderr(contains("the step of base is spread over 0.5000 deg"));
    // a ramp that the user chooses is the user's: here it is too short, and the places are listed
    let run = desk.run("rewrite --model model.yaml part.yaml --output own.yaml --ramp-deg 0.01");
    run.code(1).stderr(contains("a limit would be exceeded").and(contains("base acceleration")));
    assert!(!desk.path("own.yaml").exists());
}

/// Between its points, 1 s apart, the first joint never rests: its spline leaves the straight line by degrees.
const COARSE_PLAN: &str = "joint_names: [A1, A2, A3, A4, A5, A6]\npoints:\n\
    - positions: [0.0, -1.2, 1.3, 0, 0.5, 0]\n  velocities: [0.35, 0.0, 0.0, 0.0, 0.0, 0.0]\n  time_from_start: {sec: 0, nanosec: 0}\n\
    - positions: [0.15, -1.1, 1.3, 0, 0.5, 0]\n  velocities: [-0.15, 0.0, 0.0, 0.0, 0.0, 0.0]\n  time_from_start: {sec: 1, nanosec: 0}\n\
    - positions: [-0.1, -1.2, 1.3, 0, 0.5, 0]\n  velocities: [-0.25, 0.0, 0.0, 0.0, 0.0, 0.0]\n  time_from_start: {sec: 2, nanosec: 0}\n\
    - positions: [-0.2, -1.2, 1.3, 0, 0.5, 0]\n  velocities: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n  time_from_start: {sec: 3, nanosec: 0}\n";

#[test]
fn new_points_of_a_coarse_plan_are_on_its_splines_and_the_verdict_follows_them() {
    let desk = desk_of("kuka-kr120-r2500-pro.yaml", &[("A1", "half_gap_deg: 0.02"), ("A2", "half_gap_deg: 0.02")]);
    desk.write("part.yaml", COARSE_PLAN);
    let run = desk.run("rewrite --model model.yaml part.yaml --output out.yaml").success();
    let words = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(words.contains("verdict on the model's machine: better"), "{words}");
    let largest = words.split("largest change at the TCP: ").nth(1).unwrap().split(' ').next().unwrap();
    assert!(largest.parse::<f64>().unwrap() < 1600.0, "{words}");
    // A2 comes from rest and goes to rest in every segment: 3 x^2 - 2 x^3 of 0.1 rad
    let out = out(&desk, "out.yaml");
    let list = |line: &str| -> Vec<f64> {
        let list = line.split_once('[').unwrap().1.split_once(']').unwrap().0;
        list.split(',').map(|n| n.trim().parse().unwrap()).collect()
    };
    let lines: Vec<&str> = out.lines().collect();
    let points = lines.iter().enumerate().filter(|(_, l)| l.contains("positions:"));
    let mut new = 0;
    for (k, line) in points {
        let time = |key: &str| -> f64 {
            let rest = lines[k + 2].split_once(key).unwrap().1;
            rest.trim_start_matches([':', ' ']).split([',', '}']).next().unwrap().parse().unwrap()
        };
        let (whole, x) = (time("{sec"), time("nanosec") * 1e-9);
        new += usize::from(x > 0.0);
        let rise = 0.1 * (3.0 * x * x - 2.0 * x * x * x);
        let plan = [-1.2 + rise, -1.1 - rise, -1.2, -1.2][whole as usize];
        let off = (list(line)[1] - plan).abs();
        assert!(off < 0.0201_f64.to_radians(), "{off} rad off at {whole} s + {x}: {out}");
    }
    assert!(new > 2, "{out}");
}

#[test]
fn gcode_of_whole_numbers_alone_is_edited_only_where_they_are_known_to_be_millimetres() {
    let desk = desk_of("gantry-xyz-ballscrew.yaml", &[("X", "half_gap_mm: 0.1")]);
    let text = "G21 G90\nG0 X500 Y200 Z-100\nG1 X300 F100\nX500\nX300\n";
    desk.write("part.nc", text);
    let run = desk.run("rewrite --model model.yaml part.nc --output out.nc");
    run.success().stderr(contains("no axis word has a decimal point").and(contains("assume whole-units")));
    assert_eq!(out(&desk, "out.nc"), text);
    desk.run("rewrite --model model.yaml part.nc --output mm.nc --assume whole-units").success();
    assert!(out(&desk, "mm.nc").contains("X299.9"), "{}", out(&desk, "mm.nc"));
    let robot = out(&desk, "robot.yaml") + "control: [whole-units]\n";
    desk.write("robot.yaml", &robot);
    // words of the command go beside those of the robot file
    desk.run("rewrite --model model.yaml part.nc --output robot.nc --assume G21").success();
    assert_eq!(out(&desk, "robot.nc"), out(&desk, "mm.nc"));
}
