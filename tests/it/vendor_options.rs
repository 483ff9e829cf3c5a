//! Vendor programs through the command line: what options mean for them, and what the tool reports.

use crate::support::{self, bundled};
use crate::vendor_rewrite::{Desk, PROGRAM};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

const RUN: &str = "rewrite --model model.yaml part.src --output out.src";

/// A desk with the robot of `config` instead of the KUKA, and its `joint` in the model.
fn desk_of(config: &str, joint: &str, half_gap_deg: f64) -> Desk {
    let desk = Desk::new(half_gap_deg);
    let robot = bundled("configs").join(config);
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let model = String::from_utf8(desk.read("model.yaml")).unwrap().replace("joint: A1", &format!("joint: {joint}"));
    desk.write("model.yaml", &model);
    desk
}

/// Lines of a file that hold a word.
fn lines(desk: &Desk, name: &str, word: &str) -> Vec<String> {
    let text = String::from_utf8(desk.read(name)).unwrap();
    text.lines().filter(|l| l.contains(word)).map(str::to_string).collect()
}

#[test]
fn a_dry_run_says_what_would_be_written_and_writes_nothing() {
    let desk = Desk::new(0.003);
    let status = |name: &str| {
        let line = String::from_utf8(desk.read(name)).unwrap();
        let line: serde_json::Value = serde_json::from_str(line.lines().next().unwrap()).unwrap();
        line["status"].as_str().unwrap().to_string()
    };
    let run = desk.run("rewrite --model model.yaml part.src --dry-run --summary dry.jsonl");
    run.success().stderr(contains("1 point to be added").and(contains("to be written in steps of")));
    assert_eq!(status("dry.jsonl"), "would_be_written");
    desk.run(&format!("{RUN} --summary done.jsonl")).success().stderr(contains("; written in steps of"));
    assert_eq!(status("done.jsonl"), "written");
    desk.run("rewrite --model model.yaml part.src --check out.src --summary check.jsonl").success();
    assert_eq!(status("check.jsonl"), "would_be_written");
    desk.write("cell/part.src", PROGRAM);
    desk.run("rewrite --model model.yaml cell --dry-run --summary cell.jsonl")
        .success()
        .stderr(contains("1 program: 1 would be written, 0 unchanged"));
    assert_eq!(status("cell.jsonl"), "would_be_written");
    // nothing to do is nothing to do, written or not
    desk.run("rewrite --model model.yaml cell --dry-run --gain 0 --exit-code").code(3);
}

#[test]
fn options_for_rows_are_refused_where_a_program_has_none() {
    let desk = Desk::new(0.003);
    for refine in ["cubic", "cartesian"] {
        let run = desk.run(&format!("{RUN} --refine {refine}"));
        run.code(2).stderr(contains("--refine").and(contains("KUKA KRL")).and(contains("turning points")));
    }
    desk.run(&format!("{RUN} --chord-um 5")).code(2).stderr(contains("--chord-um 5 without --refine cartesian"));
    assert!(!desk.path("out.src").exists());
    desk.run(&format!("{RUN} --refine none")).success();
    // and what is for vendor programs has nothing to do on rows, and a note reports it
    desk.write(
        "part.csv",
        "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n0,-90,90,0,10,0\n9,-90,90,0,10,0\n5,-90,90,0,10,0\n",
    );
    let run = desk.run("rewrite --model model.yaml part.csv --output out.csv --solve-cartesian");
    run.success().stderr(contains("--solve-cartesian").and(contains("vendor programs")));
}

#[test]
fn only_numbers_that_are_written_count_for_the_steps_that_are_said() {
    let desk = Desk::new(0.003);
    // whole degrees on the joints that stay
    let text = PROGRAM.replace("A3 90.0000", "A3 90").replace("A3 95.0000", "A3 95").replace("A4 0.0", "A4 0");
    desk.write("part.src", &text);
    let run = desk.run("rewrite --model model.yaml part.src --dry-run --json").success();
    let document: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    let joints: Vec<&str> =
        document["rounding"].as_array().unwrap().iter().filter_map(|r| r["joint"].as_str()).collect();
    assert_eq!(joints, ["A1", "A2", "A3"], "{document}");
    desk.run(RUN).success().stderr(contains("A1: 1 reversal").and(contains("in steps of 0.0001")));
}

#[test]
fn the_points_of_a_solved_line_are_passed_and_its_end_is_the_old_one() {
    let desk = desk_of("universal-robots-ur10.yaml", "base", 0.003);
    let line = "movel(p[-0.87741, -0.02046, 0.32866, 2.15337, 2.14798, -0.00000], a=1.2, v=0.25)";
    let at = |pan: f64| format!("  movej([{pan}, -1.2, 1.5, -1.8, -1.5, 0.0], a=1.4, v=1.05)\n");
    desk.write(
        "part.script",
        &format!("def part():\n  set_tcp(p[0,0,0,0,0,0])\n{}  {line}\n{}end\n", at(0.0), at(0.3)),
    );
    let run = desk.run("rewrite --model model.yaml part.script --output out.script --solve-cartesian=20");
    run.success().stderr(contains("without corner rounding").not());
    let moves = lines(&desk, "out.script", "movel");
    let (last, way) = moves.split_last().unwrap();
    assert!(way.len() > 8 && way.iter().all(|l| l.contains(", r=0.00")), "{way:?}");
    assert!(!last.contains("r="), "{last}");
    // a format without such moves leaves them, and says so
    let desk = Desk::new(0.003);
    let lin = "LIN {X 1800.0,Y 0.0,Z 1900.0}";
    desk.write("part.src", &PROGRAM.replace("END\r\n", &format!("{lin}\r\nEND\r\n")));
    desk.run(&format!("{RUN} --solve-cartesian"))
        .success()
        .stderr(contains("Cartesian moves as joint moves: KUKA KRL"));
    assert_eq!(lines(&desk, "out.src", lin).len(), 1);
}

/// The arc is no larger than a gap, so that it and the move before it stay where they are.
#[test]
fn a_solved_line_before_an_arc_that_stays_is_written_with_the_joints_of_its_pose() {
    let desk = desk_of("universal-robots-ur10.yaml", "base", 0.02);
    let program = "def part():\n  set_tcp(p[0.01, 0.05, 0.162, 0, 0.29, 0])\n  movej([-0.6423, -1.2275, 1.6534, -1.4526, -1.3716, 0.8584], a=1.4, v=1.05)\n  \
        movel(p[-0.71253, 0.31207, 0.10291, 2.54109, 0.31371, 0.39110], a=0.5, v=0.1, r=0.01)\n  \
        movec(p[-0.75368, 0.27177, 0.05174, 2.54109, 0.31371, 0.39110], p[-0.70703, 0.35077, 0.15961, 2.54109, 0.31371, 0.39110], a=0.5, v=0.1)\nend\n";
    desk.write("part.script", program);
    desk.run("rewrite --model model.yaml part.script --output out.script --solve-cartesian").success();
    let solved = lines(&desk, "out.script", "movel");
    assert!(!solved.is_empty() && solved.iter().all(|l| l.contains("movel([")), "{solved:?}");
}

#[test]
fn points_that_stop_a_straight_move_are_said_with_their_lines() {
    let desk = desk_of("motoman-ma2010.yaml", "S", 0.02);
    let job = "/JOB\r\n//NAME A\r\n//POS\r\n///NPOS 3,0,0,0,0,0\r\n///TOOL 0\r\n///POSTYPE PULSE\r\n///PULSE\r\n\
        C00000=0,0,0,0,-60000,0\r\nC00001=6800,300,-300,0,-62000,6220\r\nC00002=1000,300,-300,0,-62000,6220\r\n//INST\r\n\
        ///DATE 2024/01/01 10:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\nMOVJ C00000 VJ=25.00\r\nMOVL C00001 V=50.0 PL=0\r\n\
        MOVL C00002 V=50.0 PL=0\r\nEND\r\n";
    desk.write("part.JBI", job);
    desk.write(
        "frames.yaml",
        "schema: lostmotion/frames/1\ntools:\n  \"0\": {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}\n",
    );
    let run =
        desk.run("rewrite --model model.yaml part.JBI --output out.JBI --step-fraction 0.01 --frames frames.yaml");
    run.success()
        .stderr(contains("on straight TCP moves are written without corner rounding").and(contains("line 18")));
    let out = lines(&desk, "out.JBI", "MOVL");
    assert!(out.len() > 2 && out.last().unwrap().contains("C00002 V=50.0 PL=0"), "{out:?}");
}

#[test]
fn a_program_without_moves_has_none_to_edit_and_none_that_lacks() {
    let desk = Desk::new(0.003);
    desk.write("part.src", "DEF part( )\r\nWAIT SEC 1.0\r\nEND\r\n");
    let run = desk.run(&format!("{RUN} --require-coverage 100%"));
    run.success().stderr(contains("no moves").and(contains("all editable").not()));
    assert_eq!(desk.read("out.src"), desk.read("part.src"));
}

#[test]
fn a_folder_that_is_not_there_is_named_and_no_temporary_file() {
    let desk = Desk::new(0.003);
    for line in [
        "rewrite --model model.yaml part.src --output nowhere/out.src",
        "rewrite --model model.yaml part.src --output out.src --summary nowhere/s.jsonl",
    ] {
        desk.run(line).code(2).stderr(contains("a folder that does not exist, nowhere").and(contains(".part").not()));
    }
    desk.run(RUN).success();
    desk.run("undo out.src --output nowhere/back.src").code(2).stderr(contains("nowhere"));
}

#[test]
fn results_inside_the_folder_of_the_programs_are_no_programs_of_the_next_run() {
    let desk = Desk::new(0.003);
    desk.write("cell/a.src", PROGRAM);
    desk.write("cell/sub/b.src", &PROGRAM.replace("20.0000", "21.0000"));
    let run = |to: &str| desk.run(&format!("rewrite --model model.yaml cell --output-dir cell/{to}"));
    run("done").success().stderr(contains("2 programs: 2 written"));
    run("done").success().stderr(contains("2 programs: 2 written"));
    // another folder: what stands in the first is no input, and a note reports it
    run("again").success().stderr(contains("2 programs: 2 written").and(contains("cell/done are results")));
    assert!(!desk.path("cell/again/done").exists());
    let run = desk.run("rewrite --model model.yaml cell --dry-run");
    run.success().stderr(contains("2 programs: 2 would be written"));
    // a program of its own is one, whatever note lies beside it
    desk.write("cell/done/c.src", PROGRAM);
    let run = desk.run("rewrite --model model.yaml cell/done --dry-run");
    run.code(1).stderr(contains("3 programs: 1 would be written, 0 unchanged, 2 refused"));
}

#[test]
fn a_step_that_is_too_fast_gets_the_advice_to_spread_it() {
    let desk = Desk::new(0.5);
    let robot = String::from_utf8(desk.read("robot.yaml")).unwrap();
    desk.write("robot.yaml", &robot.replacen("max_accel_deg_s2: 300", "max_accel_deg_s2: 60", 1));
    let row = |k: i32| format!("{:.2},{:.3},-90,90,0,10,0\n", f64::from(k) * 0.05, (f64::from(k) * 0.05).sin() * 20.0);
    let rows: String = (0..120).map(row).collect();
    desk.write("part.csv", &format!("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n{rows}"));
    let line = "rewrite --model model.yaml part.csv --dry-run";
    desk.run(line).code(1).stderr(contains("A1 acceleration").and(contains("--ramp-deg 2 may help")));
    // who has asked for it is not told again, and a range is not kept by spreading
    desk.run(&format!("{line} --ramp-deg 1")).stderr(contains("may help").not());
    desk.write("robot.yaml", &robot.replacen("limits_deg: [-185, 185]", "limits_deg: [-20, 20]", 1));
    desk.run(line).code(1).stderr(contains("A1 position").and(contains("may help").not()));
}

#[test]
fn a_comment_for_the_tool_that_it_does_not_understand_is_said() {
    let desk = Desk::new(0.003);
    for (comment, said) in [
        ("lostmotion: of", true),
        ("Lost motion: off", true),
        ("lostmotion off (seam)", true),
        ("lostmotion: off", false),
        ("lost motion of 3 mdeg was measured here", false),
        ("lostmotion is a tool", false),
    ] {
        let text = PROGRAM.replace("PTP {A1 20.0000", &format!("; {comment}\r\nPTP {{A1 20.0000"));
        desk.write("part.src", &text);
        let run = desk.run("rewrite --model model.yaml part.src --dry-run").success();
        let told = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert_eq!(told.contains("line 5: a comment for this tool that is not understood"), said, "{comment}: {told}");
    }
}

#[test]
fn a_program_comes_through_a_pipe_as_it_does_from_a_file() {
    let desk = Desk::new(0.003);
    desk.run(RUN).success();
    let mut command = support::command();
    let line = "rewrite --model model.yaml - --output -";
    let run = command.current_dir(desk.folder.path()).args(line.split(' ')).write_stdin(PROGRAM).assert().success();
    assert_eq!(run.get_output().stdout, desk.read("out.src"));
}

#[test]
fn a_program_that_names_no_joints_waits_for_a_posture_of_the_arm() {
    let desk = desk_of("universal-robots-ur10.yaml", "base", 0.003);
    let pose = |y: f64| format!("  movel(p[0.5, {y}, 0.4, 0, 3.14, 0], a=1.2, v=0.1)\n");
    let program =
        format!("def work():\n  set_tcp(p[0, 0, 0.1, 0, 0, 0])\n{}{}{}end\n", pose(-0.3), pose(0.3), pose(-0.2));
    desk.write("p.script", &program);
    desk.run("rewrite --model model.yaml p.script --output out.script")
        .success()
        .stderr(contains("no posture of the arm is known: 3 moves wait for it"));
    desk.run("rewrite --model model.yaml p.script --list-frames")
        .success()
        .stdout(contains("Moves that need them: 3."));
    let frames =
        |posture: &str| desk.write("frames.yaml", &format!("schema: lostmotion/frames/1\nposture_deg: {posture}\n"));
    frames("[0, -90, 90]");
    let run = "rewrite --model model.yaml p.script --frames frames.yaml --output posed.script";
    desk.run(run).code(2).stderr(contains("`posture_deg` of 3 numbers").and(contains("6, one for each axis")));
    // with the elbow up and with it down: the way of the first joint is the same, and so is its step at the turn
    for posture in ["[180, -90, 90, -90, -90, 0]", "[180, -10, -90, 10, -90, 0]"] {
        frames(posture);
        desk.run(&format!("{run} --force")).success();
        let own: Vec<&str> = program.lines().filter(|l| l.contains("movel")).collect();
        // points that are added are passed
        let mut new = lines(&desk, "posed.script", "movel");
        new.retain(|l| !l.contains("r="));
        assert_eq!(own.len(), new.len(), "{new:?}");
        let changed: Vec<bool> = own.iter().zip(&new).map(|(a, b)| a != b).collect();
        assert!(changed[2], "{posture}: {new:?}");
        // the offset of the turned joint at the reach of the arm, and no other pose
        let at = |l: &str, k: usize| l.split(['[', ',', ']']).nth(1 + k).unwrap().trim().parse::<f64>().unwrap();
        for (a, b) in own.iter().zip(&new) {
            let off = (0..3).map(|k| (at(a, k) - at(b, k)).powi(2)).sum::<f64>().sqrt();
            assert!(off < 0.006f64.to_radians() * 0.7, "{posture}: {off} {b}");
        }
    }
}

#[test]
fn a_posture_that_contradicts_the_program_s_own_joints_is_not_used() {
    let desk = desk_of("universal-robots-ur10.yaml", "base", 0.003);
    let pose = |y: f64| format!("  movel(p[0.5, {y}, 0.4, 0, 3.14, 0], a=1.2, v=0.1)\n");
    let joints = "  foo()\n  movej([-2.5, -1.0, -1.5, -2.0, 1.57, 0], a=1.2, v=0.25)\n";
    let program = format!(
        "def work():\n  set_tcp(p[0, 0, 0.1, 0, 0, 0])\n{}{}{}{joints}end\n",
        pose(-0.3),
        pose(0.3),
        pose(-0.2)
    );
    desk.write("p.script", &program);
    desk.write("frames.yaml", "schema: lostmotion/frames/1\nposture_deg: [0, -90, 90, -90, -90, 0]\n");
    desk.run("rewrite --model model.yaml p.script --frames frames.yaml --output posed.script --force")
        .success()
        .stderr(contains("of another arm configuration than `posture_deg`"));
}

#[test]
fn friction_that_fades_in_seconds_is_left_out_where_no_speed_can_be_told() {
    let desk = Desk::new(0.003);
    desk.run(RUN).success();
    let gaps_alone = desk.read("out.src");
    let model = String::from_utf8(desk.read("model.yaml")).unwrap();
    desk.write("model.yaml", &format!("{model}  - {{effect: stiction, joint: A1, spike_deg: 0.0034, decay_s: 5.2}}\n"));
    desk.run(&format!("{RUN} --force"))
        .success()
        .stderr(contains("only the gaps are compensated").and(contains("give a TCP speed")));
    assert_eq!(String::from_utf8(desk.read("out.src")).unwrap(), String::from_utf8(gaps_alone.clone()).unwrap());
    // with a speed the friction is in it
    desk.run(&format!("{RUN} --speed-mm-s 10")).success().stderr(contains("only the gaps are compensated").not());
    assert_ne!(desk.read("out.src"), gaps_alone);
}

/// Offsets are differences along a program: beside a number of 1e21 deg a double holds none of them.
#[test]
fn a_joint_value_beyond_any_machine_is_refused_with_its_place() {
    let desk = Desk::new(0.003);
    let line = |a1: &str| format!("  PTP {{A1 {a1}, A2 -80.0, A3 90.0, A4 0.0, A5 30.0, A6 0.0}}\n");
    let text = [line("10.0"), line("4000000000000000000000.0"), line("20.0"), line("10.0")].concat();
    desk.write("far.src", &format!("DEF far()\n{text}END\n"));
    desk.run("rewrite --model model.yaml far.src --output out.src --max-added 1")
        .code(2)
        .stderr(contains("far.src:3").and(contains("a position that the joint can have")));
    assert!(!desk.path("out.src").exists());
}

#[test]
fn moves_stay_while_a_process_may_be_on_wherever_control_comes_from() {
    let desk = Desk::new(0.003);
    let text = |body: &str| {
        let go = |line: &str| match line.strip_prefix("go ") {
            Some(a1) => format!("PTP {{A1 {a1},A2 -80,A3 95,A4 20,A5 30,A6 10}}\n"),
            None => format!("{line}\n"),
        };
        body.split('|').map(go).collect::<String>()
    };
    let called = "DEF part()|go 0|ARC_ON()|B()|ARC_OFF()|go 0|go 4|go 1|END|DEF B()|go 5|go 10|go 15|go 5|END";
    let pass = "DEF part()|go 0|LOOP|go 6|go 3|ARC_ON()|go 0|go 4|ENDLOOP|END";
    let passed_by = "DEF part()|go 0|go 9|ARC_ON()|IF $IN[1] THEN|ARC_OFF()|ENDIF|go 6|go 7|go 0|END";
    for (body, inside) in [(called, 10..14), (pass, 3..8), (passed_by, 7..10)] {
        desk.write("part.src", &text(body));
        desk.run(&format!("{RUN} --force")).success();
        let free = String::from_utf8(desk.read("out.src")).unwrap();
        desk.run(&format!("{RUN} --force --exclude-process")).success();
        let out = String::from_utf8(desk.read("out.src")).unwrap();
        let written: Vec<&str> = out.lines().collect();
        let stay: Vec<String> = text(body).lines().map(str::to_string).collect();
        let stay = &stay[inside];
        assert!(stay.iter().all(|line| written.contains(&line.as_str())), "{body}: {out}");
        assert_ne!(out, free, "{body}: all of it stays");
    }
}
