//! `simulate` against the twin, against analytic cases, and its refusals.

use crate::support::{self, WorkFolder};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const CIRCLE: &str = "samples/circle/circle_program.csv";

/// Columns of a CSV (gzip too) by name; empty cells are NaN.
fn columns(path: &Path) -> HashMap<String, Vec<f64>> {
    let input = lostmotion::io::input::read(path).unwrap();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(input.bytes.as_slice());
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_string).collect();
    let mut table: HashMap<String, Vec<f64>> = names.iter().map(|n| (n.clone(), Vec::new())).collect();
    for record in reader.records() {
        for (name, text) in names.iter().zip(record.unwrap().iter()) {
            table.get_mut(name).unwrap().push(text.parse().unwrap_or(f64::NAN));
        }
    }
    table
}

fn simulate(folder: &Path, args: &[&str]) -> PathBuf {
    let out = folder.join("log.csv");
    support::command().arg("simulate").args(args).arg("--output").arg(&out).assert().success();
    out
}

/// Largest difference of two columns, where the rows of `decimated` are every `every`th of `all`.
fn difference(all: &[f64], decimated: &[f64], every: usize) -> f64 {
    assert_eq!(all.len().div_ceil(every), decimated.len());
    all.iter().step_by(every).zip(decimated).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn agrees_with_the_twin(model: &str, program: &str, truth: &str, encoders: bool) {
    let folder = WorkFolder::new();
    let model = format!("samples/models/{model}");
    let mut args = vec!["--model", &model, "--input", program];
    if encoders {
        args.push("--encoders");
    }
    let ours = columns(&simulate(folder.path(), &args));
    let twin = columns(Path::new(truth));
    for (name, want) in &twin {
        // the twin writes 4 decimals of a millimetre and 6 of a degree
        let rounding = if name.ends_with("_mm") { 0.51e-4 } else { 1.01e-6 };
        let worst = difference(&ours[name], want, 50);
        assert!(worst <= rounding, "{name}: {worst}");
    }
}

#[test]
fn the_circle_is_that_of_the_twin_on_constant_gaps() {
    agrees_with_the_twin("kuka-table3.model.yaml", CIRCLE, "tests/data/twin/run_table3.csv.gz", true);
}

#[test]
fn the_circle_is_that_of_the_twin_on_gaps_that_vary_with_position() {
    agrees_with_the_twin("kuka-figure5.model.yaml", CIRCLE, "tests/data/twin/run_figure5.csv.gz", true);
}

#[test]
fn a_compensated_program_is_run_as_the_twin_runs_it() {
    let program = "tests/data/twin/best_program.csv";
    agrees_with_the_twin("kuka-table3.model.yaml", program, "tests/data/twin/run_best.csv.gz", false);
}

/// Model of the static test: figure 5 without stiction, as text with an absolute robot path.
fn static_model(folder: &Path) -> PathBuf {
    let text = std::fs::read_to_string("samples/models/kuka-figure5.model.yaml").unwrap();
    let configs = std::fs::canonicalize("configs").unwrap();
    let lines: Vec<String> = text
        .lines()
        .filter(|l| !l.contains("effect: stiction"))
        .map(|l| l.replace("../../configs", configs.to_str().unwrap()))
        .collect();
    let path = folder.join("model.yaml");
    std::fs::write(&path, lines.join("\n")).unwrap();
    path
}

#[test]
fn a_program_with_times_follows_them() {
    let folder = WorkFolder::new();
    let model = static_model(folder.path());
    let program = "tests/data/twin/static_A2_program.csv";
    let out = simulate(folder.path(), &["--model", model.to_str().unwrap(), "--input", program, "--rate-hz", "2"]);
    let (ours, twin) = (columns(&out), columns(Path::new("tests/data/twin/static_A2.csv.gz")));
    for name in ["t_s", "cmd_A2_deg", "x_mm", "y_mm", "z_mm"] {
        let worst = difference(&ours[name], &twin[name], 1);
        assert!(worst <= 0.51e-4, "{name}: {worst}");
    }
}

/// A force that no column tells moves nothing, and that is said.
#[test]
fn an_effect_whose_columns_are_absent_is_named() {
    let folder = WorkFolder::new();
    let model = static_model(folder.path());
    let mut text = std::fs::read_to_string(&model).unwrap();
    text += "\n  - {effect: process_force, joint: A2, compliance_deg_per_nm: 1.0e-5}\n";
    text += "  - {effect: torque_windup, joint: A1, compliance_deg_per_nm: 1.0e-5}\n";
    std::fs::write(&model, text).unwrap();
    let mut command = support::command();
    command.args(["simulate", "--input", CIRCLE, "--model"]).arg(&model);
    let run = command.arg("--output").arg(folder.join("log.csv")).assert().success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    for (effect, columns) in [("process_force of A2", "fx_n, fy_n, fz_n"), ("torque_windup of A1", "torque_<joint>_nm")]
    {
        assert!(said.contains(&format!("{effect} has no effect: no column {columns}")), "{said}");
    }
}

#[test]
fn dwells_of_a_log_are_predicted_where_the_twin_measures_them() {
    let folder = WorkFolder::new();
    let model = static_model(folder.path());
    let log = "tests/data/twin/static_A2.csv.gz";
    let ours = columns(&simulate(folder.path(), &["--model", model.to_str().unwrap(), "--input", log]));
    let twin = columns(Path::new(log));
    let (mut dwells, mut worst) = (0, 0f64);
    for (i, _) in twin["trigger"].iter().enumerate().filter(|(_, t)| **t != 0.0) {
        dwells += 1;
        worst = ["x_mm", "y_mm", "z_mm"].iter().map(|c| (ours[*c][i] - twin[*c][i]).abs()).fold(worst, f64::max);
    }
    assert!(dwells > 150 && worst <= 0.51e-4, "{dwells} rows, {worst} mm");
}

#[test]
fn a_log_keeps_its_columns_as_text() {
    let folder = WorkFolder::new();
    let log = folder.join("in.csv");
    let text = "# a comment\nt_s,note,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm,cycle\n\
                0.000,\"a, b\",60,-90.00,1e1,0,0,0,1,2,3,0\n0.500,,60.5,-90.00,1e1,0,0,0,,,,1\n";
    std::fs::write(&log, text).unwrap();
    let model = "samples/models/kuka-table3.model.yaml";
    let out = simulate(folder.path(), &["--model", model, "--input", log.to_str().unwrap()]);
    let written = std::fs::read_to_string(out).unwrap();
    let lines: Vec<&str> = written.lines().collect();
    assert_eq!(lines[1], text.lines().nth(1).unwrap());
    assert!(lines[2].starts_with("0.000,\"a, b\",60,-90.00,1e1,0,0,0,") && lines[2].ends_with(",0"), "{}", lines[2]);
    assert!(lines[3].starts_with("0.500,,60.5,-90.00,1e1,0,0,0,") && !lines[3].contains(",,,"), "{}", lines[3]);
}

/// A log of the gantry with names, units, signs and separators of its own, a lost point, and a column that nobody knows.
const FOREIGN: &str = "Zeit;Achse X;Achse Y;Achse Z;Wagen;pX;pY;pZ;Notiz\n0,0;0,1;-200,5;30,25;0,1;;;;\"a; b\"\n\
                       500,0;0,101;-200,5;30,25;0,101;1,0;2,0;3,0;\n1000,0;0,1;-200,5;30,25;0,1;1,0;2,0;3,0;c\n";
const MAP: &str = "schema: lostmotion/columns/1\nseparator: \";\"\ndecimal: \",\"\ncolumns:\n  Zeit: {to: t_s, unit: ms}\n  \
                   Achse X: {to: cmd_X_mm, unit: m}\n  Achse Y: {to: cmd_Y_mm, sign: -1}\n  Achse Z: cmd_Z_mm\n  \
                   Wagen: {to: meas_X_mm, unit: m}\n  pX: {to: x_mm, unit: um}\n  pY: {to: y_mm, unit: m, sign: -1}\n  pZ: z_mm\n";
/// The same in the names of the log format.
const OWN: &str = "t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,meas_X_mm,x_mm,y_mm,z_mm\n0,100,200.5,30.25,100,,,\n\
                   0.5,101,200.5,30.25,101,1,2,3\n1,100,200.5,30.25,100,1,2,3\n";

#[test]
fn a_log_with_other_names_and_units_keeps_them() {
    let folder = WorkFolder::new();
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_string()
    };
    let (own, foreign, map) = (file("own.csv", OWN), file("foreign.csv", FOREIGN), file("map.yaml", MAP));
    let model = "samples/models/gantry-2015.model.yaml";
    let other = WorkFolder::new();
    let want = columns(&simulate(other.path(), &["--model", model, "--input", &own]));
    let out = simulate(folder.path(), &["--model", model, "--input", &foreign, "--columns", &map]);
    let text = std::fs::read_to_string(&out).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split(';').collect()).collect();
    assert_eq!(rows[0].join(";"), FOREIGN.lines().next().unwrap());
    assert_eq!(rows[1][..4].join(";"), "0,0;0,1;-200,5;30,25");
    assert_eq!(rows[1][8..].join(";"), "\"a; b\"");
    assert_eq!(rows[3][8], "c");
    // the gap of X shows, and stands in metres, micrometres, and metres of the other sign
    assert!((want["meas_X_mm"][1] - 101.0).abs() > 0.05, "{}", want["meas_X_mm"][1]);
    for (row, cells) in rows[1..].iter().enumerate() {
        let number = |field: usize| cells[field].replace(',', ".").parse::<f64>().unwrap();
        for (field, name, per_mm) in [(4, "meas_X_mm", 1e-3), (5, "x_mm", 1e3), (6, "y_mm", -1e-3), (7, "z_mm", 1.0)] {
            let off = number(field) / per_mm - want[name][row];
            assert!(off.abs() < 1.1e-6, "{name} of row {row}: {off} mm");
        }
    }
    // the same map reads it again
    let again = folder.join("again.csv");
    std::fs::copy(&out, &again).unwrap();
    let args = ["--model", model, "--input", again.to_str().unwrap(), "--columns", &map];
    let twice = std::fs::read_to_string(simulate(folder.path(), &args)).unwrap();
    assert_eq!(twice.lines().skip(1).collect::<Vec<_>>(), text.lines().skip(1).collect::<Vec<_>>());
}

#[test]
fn with_columns_the_input_is_a_log() {
    let folder = WorkFolder::new();
    let map = folder.join("map.yaml");
    std::fs::write(&map, "schema: lostmotion/columns/1\ncolumns: {a1_deg: cmd_A1_deg}\n").unwrap();
    let run = |args: &[&str]| support::command().arg("simulate").args(args).args(["--input", CIRCLE]).assert().code(2);
    let model = "samples/models/kuka-table3.model.yaml";
    let refused = run(&["--model", model, "--columns", map.to_str().unwrap()]);
    let error = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(error.contains("circle_program.csv:") && error.contains("no column `cmd_A2_deg`"), "{error}");
    run(&["--model", model, "--robot", "configs/kuka-kr120-r2500-pro.yaml"]);
    run(&[]);
}

#[test]
fn of_a_robot_alone_the_tcp_is_where_the_robot_file_says() {
    let folder = WorkFolder::new();
    let robot_file = "configs/kuka-kr120-r2500-pro.yaml";
    let out = columns(&simulate(folder.path(), &["--robot", robot_file, "--input", CIRCLE]));
    let robot = lostmotion::robot::Robot::load(Path::new(robot_file)).unwrap();
    let rows = out["t_s"].len();
    assert!(rows > 1000);
    for row in (0..rows).step_by(97) {
        let q: Vec<f64> = (1..=6).map(|a| out[&format!("cmd_A{a}_deg")][row].to_radians()).collect();
        let tcp_mm = robot.tcp_m(&q) * 1e3;
        for (c, name) in ["x_mm", "y_mm", "z_mm"].iter().enumerate() {
            // 6 decimals of a degree at a reach of 2.5 m
            assert!((out[*name][row] - tcp_mm[c]).abs() < 1e-4, "{name} of row {row}");
        }
    }
}

#[test]
fn a_prismatic_axis_lags_by_its_half_gap() {
    let folder = WorkFolder::new();
    let program = folder.join("p.csv");
    std::fs::write(&program, "x_mm,y_mm,z_mm\n100,50,20\n300,50,20\n150,50,20\n").unwrap();
    let model = "samples/models/gantry-2015.model.yaml";
    let args = ["--model", model, "--input", program.to_str().unwrap(), "--speed-mm-s", "10", "--rate-hz", "10"];
    let log = columns(&simulate(folder.path(), &args));
    // Gantry (2015): 0.11625 mm; X starts in the middle of its gap
    let at = |i: usize| log["x_mm"][i] - log["x_mm"][0];
    let command = |i: usize| log["cmd_X_mm"][i] - log["cmd_X_mm"][0];
    let sense = if at(200) > 0.0 { 1.0 } else { -1.0 };
    assert_eq!(log["t_s"].len(), 351);
    assert!((sense * at(100) - (command(100) - 0.11625)).abs() < 1e-6, "{}", at(100));
    assert!((sense * at(200) - (200.0 - 0.11625)).abs() < 1e-6);
    assert!((sense * at(300) - (command(300) + 0.11625)).abs() < 1e-6);
}

#[test]
fn a_coarse_log_of_a_smooth_motion_is_predicted_as_if_its_turning_points_were_rows() {
    let folder = WorkFolder::new();
    let program = folder.join("p.csv");
    let mut text = String::from("t_s,x_mm,y_mm,z_mm\n");
    for i in 0..=40_000 {
        let t = f64::from(i) / 1000.0;
        let x = 300.0 + 100.0 * (t * std::f64::consts::TAU / 19.0).sin();
        text.push_str(&format!("{t:.3},{x:.9},50,20\n"));
    }
    std::fs::write(&program, text).unwrap();
    let model = "samples/models/gantry-2015.model.yaml";
    let truth = simulate(folder.path(), &["--model", model, "--input", program.to_str().unwrap(), "--rate-hz", "5"]);
    let log = folder.join("coarse.csv");
    std::fs::rename(truth, &log).unwrap();
    let (truth, ours) = (columns(&log), simulate(folder.path(), &["--model", model, "--input", log.to_str().unwrap()]));
    // rows alone would miss up to 55 um of a turning point and with it of the half gap of 116 um
    let worst = difference(&columns(&ours)["x_mm"], &truth["x_mm"], 1);
    assert!(worst < 0.3e-3, "{worst} mm");
}

#[test]
fn settled_poses_carry_no_decaying_stiction() {
    let folder = WorkFolder::new();
    let log = folder.join("poses.csv");
    let mut text = String::from("cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg\n");
    for a1 in [0.0, 5.0, 10.0, 5.0, 0.0, 5.0] {
        text.push_str(&format!("{a1},-60,60,0,0,0\n"));
    }
    std::fs::write(&log, text).unwrap();
    let robot = std::fs::canonicalize("configs/kuka-kr120-r2500-pro.yaml").unwrap();
    let model = |effects: &str| {
        let path = folder.join("m.yaml");
        let robot = robot.display();
        std::fs::write(&path, format!("schema: lostmotion/model/1\nrobot: {robot}\neffects: [{effects}]\n")).unwrap();
        columns(&simulate(folder.path(), &["--model", path.to_str().unwrap(), "--input", log.to_str().unwrap()]))
    };
    let gap = "{effect: backlash, joint: A1, half_gap_deg: 0.003}";
    let stick = "{effect: stiction, joint: A1, spike_deg: 0.5, decay_s: 5}";
    let (plain, with) = (model(gap), model(&format!("{gap}, {stick}")));
    assert_eq!(plain["y_mm"], with["y_mm"]);
    let travel = "{effect: stiction, joint: A1, spike_deg: 0.5, decay_deg: 5}";
    assert_ne!(plain["y_mm"], model(&format!("{gap}, {travel}"))["y_mm"]);
}

#[test]
fn a_finer_rate_gives_the_same_rows_at_the_same_times() {
    let folder = WorkFolder::new();
    let run = |rate: &str| {
        let model = "samples/models/kuka-figure5.model.yaml";
        columns(&simulate(folder.path(), &["--model", model, "--input", CIRCLE, "--rate-hz", rate, "--encoders"]))
    };
    let (coarse, fine) = (run("1"), run("20"));
    for (name, values) in &coarse {
        let worst = values.iter().zip(fine[name].iter().step_by(20)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= 1.01e-6, "{name}: {worst}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let run = |threads: &str, seed: &str| {
        let model = "samples/models/kuka-table3.model.yaml";
        support::command()
            .env("RAYON_NUM_THREADS", threads)
            .args(["simulate", "--model", model, "--input", CIRCLE, "--noise-um", "11", "--seed", seed])
            .output()
            .unwrap()
            .stdout
    };
    let one = run("1", "5");
    assert!(one.len() > 4_000_000);
    assert!(one == run("4", "5"), "threads change the bytes");
    assert!(one != run("4", "6"), "the seed changes nothing");
}

#[test]
fn the_base_frame_is_the_tracker_frame_turned_back() {
    let folder = WorkFolder::new();
    let model = "samples/models/kuka-table3.model.yaml";
    let args = ["--model", model, "--input", CIRCLE, "--rate-hz", "0.1", "--base-frame"];
    let base = columns(&simulate(folder.path(), &args));
    // the circle stands at x = 1780 mm, centre (450, 1200) mm, radius 250 mm
    assert!(base["x_mm"].len() > 200);
    for ((x, y), z) in base["x_mm"].iter().zip(&base["y_mm"]).zip(&base["z_mm"]) {
        let radius = (y - 450.0).hypot(z - 1200.0);
        assert!((x - 1780.0).abs() < 0.3 && (radius - 250.0).abs() < 0.3, "{x} {y} {z}");
    }
}

#[test]
fn a_move_that_turns_the_tool_about_the_tcp_takes_what_its_joint_needs() {
    let robot = lostmotion::robot::Robot::parse(
        "r.yaml",
        "schema: lostmotion/robot/1\njoints: [{name: J1, kind: revolute, a_mm: 100, max_speed_deg_s: 90}, \
         {name: J2, kind: revolute, max_speed_deg_s: 180}]\n",
    )
    .unwrap();
    let input = lostmotion::io::input::Input {
        name: "p.csv".into(),
        bytes: b"j1_deg,j2_deg\n0,0\n0,90\n57.29577951308232,90\n57.29577951308232,90\n".to_vec(),
        sha256: String::new(),
    };
    let program = lostmotion::program::Program::parse(input, &robot).unwrap();
    let timing = lostmotion::simulate::Timing::at_speed(&robot, &program, 0.01);
    // 90 deg at 180 deg/s; a chord of 2 * 100 mm * sin(0.5 rad) at 10 mm/s; a repeated point
    let want = [0.0, 0.5, 0.5 + 20.0 * 0.5f64.sin(), 0.504 + 20.0 * 0.5f64.sin()];
    assert!(timing.t_s.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", timing.t_s);
    assert_eq!((timing.held_by_a_joint, timing.unknown_speed), (1, 0));
}

#[test]
fn refuses_bad_input_with_its_place_and_writes_nothing() {
    let folder = WorkFolder::new();
    let bad = folder.join("bad.csv");
    let out = folder.join("log.csv");
    let model = "samples/models/gantry-2015.model.yaml";
    for (text, says) in [
        ("x_mm,y_mm,z_mm\n0,0,0\n1,nan,0\n", "bad.csv:3:2: found `nan` in column `y_mm`"),
        ("x_mm,y_mm,z_mm\n0,0,0\n1,2\n", "bad.csv:3"),
        ("x_mm,z_mm\n0,0\n1,2\n", "bad.csv:1: found no column y_mm"),
        ("x_mm,y_mm,z_mm\n0,0,0\n", "a program of 1 point;"),
        ("t_s,x_mm,y_mm,z_mm\n1,0,0,0\n0.5,0,0,1\n", "bad.csv:3:1: found time 0.5 s after 1 s"),
        ("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm\n1,0,0,0\n1,0,0,1\n", "times that strictly increase"),
    ] {
        std::fs::write(&bad, text).unwrap();
        let assert = support::command()
            .args(["simulate", "--model", model, "--input", bad.to_str().unwrap(), "--output", out.to_str().unwrap()])
            .assert()
            .code(2);
        let stderr = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(stderr.contains(says), "{stderr}");
        assert!(!out.exists());
    }
    std::fs::write(&bad, "x_mm,y_mm,z_mm\n0,0,0\n1000,0,0\n").unwrap();
    for (option, value) in [("--rate-hz", "0"), ("--rate-hz", "1e9"), ("--speed-mm-s", "nan"), ("--noise-um", "-1")] {
        let args = ["simulate", "--model", model, "--input", bad.to_str().unwrap(), option, value];
        support::command().args(args).assert().code(2);
    }
    let slow = ["--rate-hz", "100000", "--speed-mm-s", "0.001"];
    support::command()
        .args(["simulate", "--model", model, "--input", bad.to_str().unwrap()])
        .args(slow)
        .assert()
        .code(2);
}

#[test]
fn the_document_says_what_was_run_and_leaves_the_log_alone() {
    let folder = WorkFolder::new();
    let args = ["--model", "samples/models/kuka-table3.model.yaml", "--input", CIRCLE, "--noise-um", "11"];
    let plain = std::fs::read(simulate(folder.path(), &args)).unwrap();
    let out = folder.join("with.csv");
    let run = support::command().arg("simulate").args(args).arg("--json").arg("--output").arg(&out).output().unwrap();
    let told: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(std::fs::read(&out).unwrap(), plain);
    assert_eq!(told["rows"].as_u64().unwrap() as usize, columns(&out)["x_mm"].len());
    assert_eq!((told["noise_um"].as_f64(), told["seed"].as_u64()), (Some(11.0), Some(1)));
    assert!(told["effects"].as_array().unwrap().iter().any(|e| e["effect"] == "backlash" && e["joint"] == "A1"));
    // both on standard output would be neither
    support::command().arg("simulate").args(args).arg("--json").assert().code(2);
}

#[test]
fn a_time_offset_shows_sensors_of_joints_as_they_are_later() {
    let folder = WorkFolder::new();
    let robot = std::fs::canonicalize("configs/gantry-xyz-ballscrew.yaml").unwrap();
    let model = folder.join("model.yaml");
    let effects = "effects:\n  - {effect: time_offset, offset_s: 0.05}\n";
    std::fs::write(&model, format!("schema: lostmotion/model/1\nrobot: {}\n{effects}", robot.display())).unwrap();
    let at = |t: f64| 200.0 + 50.0 * (0.8 * t).sin();
    let times: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.02).collect();
    let mut log = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,enc_X_mm,meas_X_mm\n");
    for t in &times {
        log += &format!("{t:.3},{:.9},100,100,0,0\n", at(*t));
    }
    let input = folder.join("in.csv");
    std::fs::write(&input, log).unwrap();
    let out = simulate(folder.path(), &["--model", model.to_str().unwrap(), "--input", input.to_str().unwrap()]);
    let columns = columns(&out);
    for (i, t) in times.iter().enumerate().take(395).skip(5) {
        assert!((columns["meas_X_mm"][i] - at(t + 0.05)).abs() < 1e-5, "{t}: {}", columns["meas_X_mm"][i]);
        assert!((columns["enc_X_mm"][i] - at(*t)).abs() < 1e-5, "{t}: {}", columns["enc_X_mm"][i]);
    }
}
