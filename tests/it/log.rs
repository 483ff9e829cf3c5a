//! Logs that are right in an unusual way, column maps, and plausibility checks that must stay quiet.

use crate::support::{WorkFolder, bundled};
use lostmotion::io::input::Input;
use lostmotion::log::{ColumnMap, Log, plausibility};
use lostmotion::robot::{JointKind, Robot};
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};
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

/// A log of the KUKA in a turned frame: `path(i)` in degrees, noise in m.
fn measured(rows: usize, noise_m: f64, path: impl Fn(f64) -> [f64; 6]) -> Log {
    let robot = robot();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let turn = Rotation3::from_euler_angles(0.1, -0.3, 2.0);
    let mut log = parse(
        "t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm\n0,0,0,0,0,0,0,0,0,0\n",
        &robot,
    );
    log.t_s = (0..rows).map(|i| i as f64 * 0.04).collect();
    log.line = (0..rows as u32).map(|i| i + 2).collect();
    log.cmd = vec![Vec::new(); 6];
    log.tcp_m.clear();
    for i in 0..rows {
        let q = path(i as f64 / rows as f64).map(f64::to_radians);
        for (column, v) in log.cmd.iter_mut().zip(q) {
            column.push(v);
        }
        let jitter = Vector3::from_fn(|_, _| noise_m * (rng.random::<f64>() - 0.5) * 3.46);
        log.tcp_m.push(Some(turn * robot.tcp_m(&q) + Vector3::new(1.0, 2.0, 3.0) + jitter));
    }
    log
}

fn six(s: f64) -> [f64; 6] {
    let w = |k: f64, a: f64| a * (std::f64::consts::TAU * k * s + k).sin();
    [w(1.0, 20.0), -80.0 + w(2.0, 10.0), 85.0 + w(3.0, 12.0), w(2.0, 30.0), 30.0 + w(1.0, 20.0), w(3.0, 60.0)]
}

#[test]
fn hygiene_is_quiet_on_a_good_log() {
    let found = plausibility::check(&measured(2000, 1e-5, six), &robot()).unwrap();
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    assert!(found.misfit_m.unwrap() < 3e-5 && found.spread_m > 0.2);
}

#[test]
fn hygiene_says_nothing_where_the_travel_is_short() {
    // a tenth of a millimetre of travel in noise of 30 um: no scale can be seen in it
    let short = |s: f64| [0.003 * (20.0 * s).sin(), -80.0, 85.0 + 0.002 * (31.0 * s).cos(), 0.0, 0.0, 0.0];
    assert!(plausibility::check(&measured(500, 3e-5, short), &robot()).unwrap().notes.is_empty());
    assert!(plausibility::check(&measured(5, 1e-5, six), &robot()).is_ok());
    assert!(plausibility::check(&measured(500, 1e-5, |_| [0.0; 6]), &robot()).is_ok());
}

/// Zero offsets, a wrong tool, outliers and drift are the business of effects and robust fits, not of plausibility checks.
#[test]
fn hygiene_does_not_mistake_an_effect_for_a_unit() {
    let robot = robot();
    for axis in 0..6 {
        for offset_deg in [0.1_f64, 1.0, 5.0] {
            for (name, path) in [
                ("six axes", six as fn(f64) -> [f64; 6]),
                ("A4 alone", |s| [0.0, -52.0, 58.0, 340.0 * s - 170.0, 0.0, 0.0]),
            ] {
                let mut log = measured(400, 1e-5, path);
                log.cmd[axis].iter_mut().for_each(|v| *v += offset_deg.to_radians());
                plausibility::check(&log, &robot)
                    .unwrap_or_else(|e| panic!("{name}, axis {axis} by {offset_deg} deg: {e}"));
            }
        }
    }
    let mut wild = measured(1000, 1e-5, six);
    wild.tcp_m.iter_mut().step_by(9).for_each(|p| *p = p.map(|p| p + Vector3::new(0.5, -0.4, 0.3)));
    assert!(plausibility::check(&wild, &robot).is_ok());
    let mut other_tool = robot.clone();
    let tool = nalgebra::Isometry3::translation(0.25, -0.1, 0.3);
    other_tool = Robot::new(other_tool.name, other_tool.convention, other_tool.joints, other_tool.base, tool);
    assert!(plausibility::check(&measured(1000, 1e-5, six), &other_tool).is_ok());
}

#[test]
fn hygiene_refuses_a_path_of_another_robot() {
    let mut other = robot();
    let mut joints = other.joints.clone();
    for (j, d) in joints.iter_mut().zip([0.0, -0.6, 0.4, -0.8, 0.0, 0.0]) {
        j.a_m += d;
        j.alpha_rad += d;
    }
    other = Robot::new(other.name, other.convention, joints, other.base, other.tool);
    let refused = plausibility::check(&measured(1000, 1e-5, six), &other).unwrap_err().to_string();
    assert!(refused.contains("another shape"), "{refused}");
}

#[test]
fn hygiene_sees_clocks_apart() {
    let mut log = measured(2000, 1e-5, six);
    log.tcp_m.rotate_right(5);
    log.tcp_m[..5].fill(None);
    let found = plausibility::check(&log, &robot()).unwrap();
    assert!(found.notes.iter().any(|n| n.to_string().contains("about 0.20 s behind")), "{:?}", found.notes);
    log.tcp_m.rotate_right(45);
    log.tcp_m[..50].fill(None);
    let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
    assert!(refused.contains("about 2.00 s behind") && refused.contains("one clock"), "{refused}");
}

/// Recordings of one test that were started by hand, one half a minute after the other.
#[test]
fn hygiene_sees_clocks_that_are_far_apart() {
    // A2 goes to places 10 deg apart, up and down again, with a rest of 16 s at each: 50 rests in 800 s
    let tour = |s: f64| {
        let rest = (50.0 * s).floor();
        let way = ((50.0 * s - rest) * 5.0).min(1.0);
        let place = |k: f64| 10.0 * (k % 8.0 - 4.0).abs();
        [0.0, -80.0 + place(rest) + way * (place(rest + 1.0) - place(rest)), 85.0, 10.0, 20.0, 30.0]
    };
    for shift_s in [15.0, 30.0] {
        let mut log = measured(20_000, 1e-5, tour);
        // a sensor behind the gear, half a half gap off its commands
        let late = |rows: usize| -> Vec<Option<f64>> {
            let seen = log.cmd[1].iter().map(|v| v + 1e-4);
            std::iter::repeat_n(None, rows).chain(seen.map(Some)).take(log.len()).collect()
        };
        let sensors = [0, 5, 25].map(late);
        for (column, refused) in sensors.into_iter().zip([false, false, true]) {
            let mut log = log.clone();
            log.tcp_m.fill(None);
            log.meas = vec![None; 6];
            log.meas[1] = Some(column);
            let found = plausibility::check(&log, &robot());
            assert_eq!(found.is_err(), refused, "{found:?}");
            let right = |e: lostmotion::error::Error| e.to_string().contains("`meas_A2_deg` about 1.00 s behind");
            assert!(found.err().is_none_or(right));
        }
        // of a sensor of the wrong sign half a period would be a shift, too
        let mut reversed = log.clone();
        reversed.tcp_m.fill(None);
        reversed.meas = vec![None; 6];
        reversed.meas[1] = Some(log.cmd[1].iter().map(|v| Some(-v)).collect());
        let notes = plausibility::check(&reversed, &robot()).unwrap().notes;
        assert!(notes.iter().any(|n| n.to_string().contains("wrong sign")), "{notes:?}");
        let rows = (shift_s / 0.04) as usize;
        log.tcp_m.rotate_right(rows);
        log.tcp_m[..rows].fill(None);
        let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
        assert!(refused.contains("ten seconds or more") && refused.contains("one clock"), "{refused}");
    }
}

#[test]
fn hygiene_compares_encoders_with_commands() {
    let good = measured(500, 1e-5, six);
    let with = |factor: f64, offset: f64| {
        let mut log = good.clone();
        log.enc[0] = Some(log.cmd[0].iter().map(|v| Some(v * factor + offset)).collect());
        log
    };
    assert!(plausibility::check(&with(1.0, 1e-5), &robot()).unwrap().notes.is_empty());
    let refused =
        plausibility::check(&with(JointKind::Revolute.si_per_user_unit(), 0.0), &robot()).unwrap_err().to_string();
    assert!(refused.contains("enc_A1_deg") && refused.contains("radians"), "{refused}");
    let against = plausibility::check(&with(-1.0, 0.0), &robot()).unwrap();
    assert!(against.notes.iter().any(|n| n.to_string().contains("wrong sign")), "{:?}", against.notes);
    let apart = plausibility::check(&with(1.0, 0.2), &robot()).unwrap();
    assert!(apart.notes.iter().any(|n| n.to_string().contains("differs from the command")), "{:?}", apart.notes);
}

/// A sensor in another unit would make a gap of another size.
#[test]
fn hygiene_refuses_joint_sensors_that_do_not_follow_their_commands_one_to_one() {
    let good = measured(500, 1e-5, six);
    let with = |factor: f64| {
        let mut log = good.clone();
        log.tcp_m.fill(None);
        log.meas = vec![None; 6];
        let zero = log.cmd[1][0];
        log.meas[1] = Some(log.cmd[1].iter().map(|v| Some(zero + (v - zero) * factor)).collect());
        plausibility::check(&log, &robot()).map(|found| found.notes)
    };
    for (factor, says) in [
        (60.0, "`{to: meas_A2_deg, scale: 0.0166667}`"),
        (60.0, "as if they were in minutes of arc"),
        (-60.0, "`{to: meas_A2_deg, sign: -1, scale: 0.0166667}`"),
        (3600.0, "scale: 0.000277778"),
        (1.0 / 360.0, "scale: 360}"),
        (1.12, "scale: 0.892857"),
        (0.85, "move 0.8500 times as far as the commands of A2"),
    ] {
        let refused = with(factor).unwrap_err().to_string();
        assert!(refused.contains(says), "{factor}: {refused}");
    }
    for factor in [0.93, 1.05] {
        let notes = with(factor).unwrap();
        assert!(notes.iter().any(|n| n.to_string().contains("meas_A2 moves")), "{factor}: {notes:?}");
    }
    for factor in [0.98, 1.0, 1.02] {
        assert!(with(factor).unwrap().is_empty(), "{factor}");
    }
    // a motor that also turns for another joint, as in a coupled wrist: no scale mends it
    let mut coupled = good.clone();
    coupled.tcp_m.fill(None);
    coupled.enc = vec![None; 6];
    coupled.cmd[4] = coupled.t_s.iter().map(|t| 0.5 * t.sin()).collect();
    coupled.cmd[5] = coupled.t_s.iter().map(|t| 0.5 * (t.sin() + 0.3 * (3.0 * t).sin())).collect();
    coupled.enc[4] = Some((0..coupled.len()).map(|i| Some(coupled.cmd[4][i] + 0.2 * coupled.cmd[5][i])).collect());
    assert!(plausibility::check(&coupled, &robot()).is_ok());
    // a wrong scale is one under a lag too
    coupled.enc[4] = Some(coupled.t_s.iter().map(|t| Some(0.6 * (t - 0.08).sin())).collect());
    let refused = plausibility::check(&coupled, &robot()).unwrap_err().to_string();
    assert!(refused.contains("`enc_A5_deg` that move 1.19"), "{refused}");
    // behind tendons the ratio is not known
    let mut log = good.clone();
    log.meas = vec![None; 6];
    log.meas[1] = Some(log.cmd[1].iter().map(|v| Some(v * 1.5)).collect());
    assert!(plausibility::check_for(&log, &robot(), plausibility::Kinematics::Unknown).is_ok());
}

#[test]
fn hygiene_notes_speeds_and_limits_that_cannot_be() {
    let mut log = measured(500, 1e-5, six);
    // an eighth of the rows a thousand times closer: noted; all of them: refused
    let mut some = log.clone();
    let mut t = 0.0;
    for i in 1..some.len() {
        t += (log.t_s[i] - log.t_s[i - 1]) * if (100..160).contains(&i) { 1e-3 } else { 1.0 };
        some.t_s[i] = t;
    }
    let fast = plausibility::check(&some, &robot()).unwrap().notes;
    assert!(
        fast.iter().any(|n| n.to_string().contains("A1 moves at") && n.to_string().contains("its limit is 136")),
        "{fast:?}"
    );
    log.t_s.iter_mut().for_each(|t| *t *= 1e-3);
    let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
    assert!(refused.contains("A1 at more than 3 times its largest speed, 136 deg/s"), "{refused}");
    log.t_s.iter_mut().for_each(|t| *t *= 1e6);
    let step_s = log.t_s[1] - log.t_s[0];
    let slow = match plausibility::check(&log, &robot()) {
        Err(refused) => refused.to_string(),
        Ok(found) => found.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    };
    assert!(slow.contains("milliseconds"), "{step_s}: {slow}");
    // slower rows are refused, faster ones noted
    for (apart_s, refused) in [(40.0, true), (4.0, false)] {
        let mut log = log.clone();
        log.t_s.iter_mut().for_each(|t| *t *= apart_s / step_s);
        assert_eq!(plausibility::check(&log, &robot()).is_err(), refused, "{apart_s}");
    }
    let beyond = measured(500, 1e-5, |s| {
        let mut q = six(s);
        q[1] += 120.0;
        q
    });
    let notes = plausibility::check(&beyond, &robot()).unwrap().notes;
    assert!(
        notes
            .iter()
            .map(ToString::to_string)
            .any(|n| { n.starts_with("line ") && n.contains("A2") && n.contains("outside its limits") }),
        "{notes:?}"
    );
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
