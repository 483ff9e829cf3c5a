//! Logs that are right in an unusual way, and column maps.
//!
//! Parts:
//! - [`checks`]: plausibility checks.

mod checks;

use crate::support::{WorkFolder, bundled};
use lostmotion::io::input::Input;
use lostmotion::log::{ColumnMap, Log, plausibility};
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use std::io::Write;

fn robot() -> Robot {
    Robot::load(&bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap()
}

fn gantry() -> Robot {
    Robot::load(&bundled("configs/gantry-xyz-ballscrew.yaml")).unwrap()
}

fn input(bytes: impl Into<Vec<u8>>) -> Input {
    Input { name: "log.csv".into(), bytes: bytes.into(), sha256: String::new() }
}

fn parse(text: impl Into<Vec<u8>>, robot: &Robot) -> Log {
    Log::parse(input(text), robot).unwrap()
}

fn parse_map(text: impl Into<Vec<u8>>, robot: &Robot, map: &str) -> Log {
    let map = ColumnMap::parse("map.yaml", &format!("schema: lostmotion/columns/1\n{map}")).unwrap();
    Log::parse_with(input(text), robot, Some(&map)).unwrap()
}

const PLAIN: &str =
    "t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n0,100,200.5,-30.25,1,2,3\n0.5,101,200.5,-30.25,,,\n";

fn same(a: &Log, b: &Log) {
    assert_eq!((&a.t_s, &a.cmd, &a.tcp_m, a.poses), (&b.t_s, &b.cmd, &b.tcp_m, b.poses));
}

#[test]
fn numbers_become_si_and_lost_points_are_none() {
    let log = parse(PLAIN, &gantry());
    assert_eq!(log.t_s, [0.0, 0.5]);
    assert_eq!(log.cmd, [[100.0 * 1e-3, 101.0 * 1e-3], [200.5 * 1e-3, 200.5 * 1e-3], [-30.25 * 1e-3, -30.25 * 1e-3]]);
    assert_eq!(log.tcp_m, [Some(Vector3::new(1.0, 2.0, 3.0) * 1e-3), None]);
    assert_eq!((log.cmd_decimals, log.line, log.poses), (vec![0, 1, 2], vec![2, 3], false));
}

#[test]
fn the_same_log_in_other_clothes_is_the_same_log() {
    let robot = gantry();
    let plain = parse(PLAIN, &robot);
    let quoted = "\"t_s\",\"cmd_X_mm\",cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n\"0\",\"100\",200.5,-30.25,1,2,3\n0.5,101,200.5,-30.25,,,\n";
    let dressed = [
        PLAIN.replace('\n', "\r\n"),
        format!("\u{feff}{PLAIN}"),
        PLAIN.trim_end().to_string(),
        format!("# tracker 7\n\n{}\n\n# end\n", PLAIN.replacen('\n', "\n# first row\n", 1)),
        PLAIN.replace(',', " , "),
        PLAIN.replace("cmd_X_mm", "CMD_x_MM").replace("t_s", "T_S"),
        PLAIN.replace("z_mm\n", "z_mm,note\n").replace(",3\n", ",3,\"a, b\"\n").replace(",,,\n", ",,,,half\n"),
        PLAIN.replace("100", "1e2").replace("200.5", "+200.500000000000000000"),
        quoted.to_string(),
    ];
    for text in dressed {
        same(&parse(text, &robot), &plain);
    }
}

#[test]
fn metres_and_programs_are_named_where_a_log_is_expected() {
    let refused = |text: String| Log::parse(input(text), &gantry()).unwrap_err().to_string();
    let metres = PLAIN.replace("x_mm", "x_m").replace("y_mm", "y_m").replace("z_mm", "z_m");
    let error = refused(metres);
    assert!(error.contains("`x_m` and no column `x_mm`") && error.contains("a column map"), "{error}");
    let program = refused("t_s,x_mm,y_mm,z_mm\n0,1,2,3\n".replace("x_mm", "X_mm"));
    assert!(program.contains("no column `cmd_X_mm`"), "{program}");
    let error = Log::parse(input("a1_deg,a2_deg\n0,1\n"), &robot()).unwrap_err().to_string();
    assert!(error.contains("a file with joints alone is a program"), "{error}");
    // another column in metres beside millimetres is the user's own
    let both = PLAIN.replacen("z_mm\n", "z_mm,x_m\n", 1).replace(",3\n", ",3,0.001\n").replace(",,,\n", ",,,,\n");
    same(&parse(both, &gantry()), &parse(PLAIN, &gantry()));
}

#[test]
fn gzip_is_read_as_it_is() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(PLAIN.as_bytes()).unwrap();
    let folder = WorkFolder::new();
    let path = folder.join("log of today.csv.gz");
    std::fs::write(&path, packed.finish().unwrap()).unwrap();
    let log = Log::load(&path, &gantry()).unwrap();
    same(&log, &parse(PLAIN, &gantry()));
    assert_eq!(log.sha256.len(), 64);
}

#[test]
fn a_log_without_time_is_one_of_settled_poses() {
    let log = parse("index,cmd_X_mm,cmd_Y_mm,cmd_Z_mm\n7,1,2,3\n7,2,2,3\n", &gantry());
    assert!(log.poses && log.tcp_m.is_empty());
    assert_eq!(log.t_s, [0.0, 1.0]);
}

/// Rows of a carriage that goes to and fro, with `t_s` or a column of another name in its place, `step` mm from one row to the next.
fn rows_of_a_carriage(time: &str, step: usize) -> String {
    let mut text = format!("{time},cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n");
    for k in 0..800_usize {
        let along = (k * step) % 400;
        let x = 100 + along.min(400 - along);
        text += &format!("{},{x},200,-30,{x},200,-30\n", 0.1 * k as f64);
    }
    text
}

#[test]
fn samples_of_a_motion_without_their_time_are_noted() {
    let (robot, poses) = (gantry(), "like the samples of a motion");
    let notes = |text: String| plausibility::check(&parse(text, &robot), &robot).unwrap().notes;
    let noted = |text: String| notes(text).iter().any(|n| n.to_string().contains(poses));
    assert!(noted(rows_of_a_carriage("time", 1)), "samples under another name of time");
    assert!(!noted(rows_of_a_carriage("t_s", 1)), "with times");
    assert!(!noted(rows_of_a_carriage("time", 37)), "settled poses, far from each other");
}

#[test]
fn all_columns_of_the_contract_arrive() {
    let text = "t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm,x2_mm,y2_mm,z2_mm,enc_X_mm,meas_Z_mm,trigger,cycle,speed_mm_s,payload_kg,temp_c\n\
                0,1,2,3,1,2,3,4,5,6,1.5,,-1,4,250,12.5,21\n";
    let log = parse(text, &gantry());
    assert_eq!(log.reflectors_m, [[Some(Vector3::new(4.0, 5.0, 6.0) * 1e-3)]]);
    assert_eq!(log.enc[0], Some(vec![Some(1.5 * 1e-3)]));
    assert_eq!((&log.enc[1], &log.meas[2]), (&None, &Some(vec![None])));
    assert_eq!((log.trigger, log.cycle), (Some(vec![-1]), Some(vec![4])));
    assert_eq!(
        (log.speed_m_s, log.payload_kg, log.temp_c),
        (Some(vec![Some(0.25)]), Some(vec![Some(12.5)]), Some(vec![Some(21.0)]))
    );
}

#[test]
fn a_map_reads_foreign_names_units_signs_and_commas() {
    let robot = gantry();
    let text = "Zeit;Achse X;Achse Y;Hub;PX;PY;PZ;Bemerkung\n0;0,1;-200,5;-0,0302500;1000;2000;3000;gut\n500;0,101;-200,5;-0,0302500;;;;\n";
    let map = "separator: ';'\ndecimal: ','\ncolumns:\n  Zeit: {to: t_s, unit: ms}\n  Achse X: {to: cmd_X_mm, unit: m}\n  \
               Achse Y: {to: cmd_Y_mm, sign: -1}\n  Hub: {to: cmd_z_mm, unit: m}\n  PX: {to: x_mm, unit: um}\n  PY: {to: y_mm, unit: um}\n  PZ: {to: z_mm, unit: um}\n";
    let log = parse_map(text, &robot, map);
    let plain = parse(PLAIN, &robot);
    assert_eq!(log.t_s, plain.t_s);
    for (a, b) in log.cmd.iter().flatten().zip(plain.cmd.iter().flatten()) {
        assert!((a - b).abs() < 1e-15);
    }
    assert!((log.tcp_m[0].unwrap() - plain.tcp_m[0].unwrap()).norm() < 1e-15 && log.tcp_m[1].is_none());
    // 3 decimals of a metre are none of a millimetre, 7 are 4
    assert_eq!(log.cmd_decimals, [0, 1, 4]);
}

#[test]
fn a_map_reads_radians_as_the_degrees_they_are() {
    let robot = robot();
    let degrees = "t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg\n0,30,-90,90,0,0,0\n";
    let radians =
        "t_s,cmd_A1_rad,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg\n0,0.523598775598,-90,90,0,0,0\n";
    let log = parse_map(radians, &robot, "columns: {cmd_A1_rad: {to: cmd_A1_deg, unit: rad}}\n");
    assert!((log.cmd[0][0] - parse(degrees, &robot).cmd[0][0]).abs() < 1e-12);
    assert_eq!(log.cmd_decimals[0], 10, "12 decimals of a radian are 10 of a degree");
}

#[test]
fn a_map_can_pass_a_column_over() {
    let text = PLAIN.replace("t_s", "cmd_B9_deg");
    let log = parse_map(text, &gantry(), "columns: {cmd_B9_deg: ignore}\n");
    assert!(log.poses);
}

/// Pieces are cut at fixed places: many of them, the same numbers, the right line in a refusal far down.
#[test]
fn a_long_log_is_read_whole_and_refused_at_the_right_line() {
    let robot = gantry();
    let rows = 120_000;
    let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n");
    for i in 0..rows {
        text.push_str(&format!("{:.3},{}.25,{},-7.125,{i},1.5,2.5\n", f64::from(i) * 0.004, i % 1000, i % 77));
    }
    assert!(text.len() > 3 << 20);
    let log = parse(text.clone(), &robot);
    assert_eq!(log.len(), rows as usize);
    for i in [0, 1, 40_000, 90_123, 119_999] {
        assert_eq!(log.cmd[0][i], (f64::from(i as u32 % 1000) + 0.25) * 1e-3);
        assert_eq!(log.tcp_m[i].unwrap().x, i as f64 * 1e-3);
        assert_eq!(log.line[i] as usize, i + 2);
    }
    let mut lines: Vec<&str> = text.lines().collect();
    lines[90_000] = "360.5,1,2,oops,1,1,1";
    lines[110_000] = "1";
    let refused = Log::parse(input(lines.join("\n")), &robot).unwrap_err().to_string();
    assert!(refused.starts_with("log.csv:90001:4: found `oops` in column `cmd_Z_mm`"), "{refused}");
}

#[test]
fn a_map_reads_dates_as_seconds_since_the_first_row() {
    let text = PLAIN
        .replace("t_s,", "stamp,")
        .replace("\n0,", "\n2025-12-31T23:59:59.900Z,")
        .replace("\n0.5,", "\n2026-01-01T01:00:00.4+01:00,");
    let log = parse_map(text.clone(), &gantry(), "columns: {stamp: {to: t_s, unit: iso8601}}\n");
    assert_eq!(log.t_s, [0.0, 0.5]);
    same(&log, &parse(PLAIN, &gantry()));
    let map = |map: &str| ColumnMap::parse("map.yaml", &format!("schema: lostmotion/columns/1\n{map}"));
    let wrong = map("columns: {stamp: {to: x_mm, unit: iso8601}}\n").unwrap();
    assert!(Log::parse_with(input(text.clone()), &gantry(), Some(&wrong)).is_err(), "a date is no position");
    assert!(map("columns: {stamp: {to: t_s, unit: iso8601, scale: 2}}\n").is_err());
    let map = map("columns: {stamp: {to: t_s, unit: iso8601}}\n").unwrap();
    for (bad, expected) in [("12.5", "a date and time"), ("2025-02-30T00:00:00Z", "a date and time"), ("", "empty")] {
        let broken = text.replace("2026-01-01T01:00:00.4+01:00", bad);
        let error = Log::parse_with(input(broken), &gantry(), Some(&map)).unwrap_err().to_string();
        assert!(error.contains("log.csv:3") && error.contains(expected), "{error}");
    }
}

#[test]
fn a_missing_reading_is_an_empty_cell_however_the_file_writes_it() {
    let map = "columns:\n  x_mm: {to: x_mm, missing: [nan, 0]}\n  y_mm: {to: y_mm, missing: 0}\n  z_mm: {to: z_mm, missing: .nan}\n";
    for lost in ["0,0,0", "0.000,0.0,7", "NaN,1,2", "1,0e0,3", "1,2,nan", ",,"] {
        let text = PLAIN.replace(",,,\n", &format!(",{lost}\n"));
        same(&parse_map(text, &gantry(), map), &parse(PLAIN, &gantry()));
    }
    let kept = parse_map(PLAIN.replace(",,,\n", ",1,2,0\n"), &gantry(), map);
    assert!(kept.tcp_m[1].is_some(), "0 is a place where the map does not say otherwise");
    let map = ColumnMap::parse(
        "map.yaml",
        "schema: lostmotion/columns/1\ncolumns: {cmd_Y_mm: {to: cmd_Y_mm, missing: 200.5}}\n",
    );
    let error = Log::parse_with(input(PLAIN), &gantry(), Some(&map.unwrap())).unwrap_err().to_string();
    assert!(error.contains("a missing value (`200.5`)"), "a command may not be missing: {error}");
}

#[test]
fn counts_of_an_encoder_become_degrees_by_a_scale() {
    let robot =
        Robot::parse("robot.yaml", "schema: lostmotion/robot/1\njoints:\n  - {name: S, kind: revolute, a_mm: 100}\n")
            .unwrap();
    let map = "columns:\n  goal: {to: cmd_S_deg, scale: 0.087890625}\n  pos: {to: meas_S_deg, scale: 0.087890625}\n";
    let log = parse_map("t_s,goal,pos\n0,1024,\n0.1,2048,2049\n", &robot, map);
    assert_eq!(log.cmd[0].iter().map(|v| v.to_degrees().round()).collect::<Vec<_>>(), [90.0, 180.0]);
    assert!((log.meas[0].as_ref().unwrap()[1].unwrap().to_degrees() - 180.087890625).abs() < 1e-9);
    assert_eq!(log.meas[0].as_ref().unwrap()[0], None);
}
