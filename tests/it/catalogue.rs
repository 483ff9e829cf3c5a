//! The effect catalogue against an oracle that was written from the equations alone, and its entries in model files.
//!
//! `tests/oracle/catalogue_oracle.py` steps every effect in time (0.25 ms, commands by formula) and multiplies 4 x 4 matrices; the
//! logs show `simulate` the same commands at 20 Hz. Largest difference found: 0.2 um.

use crate::support::{self, WorkFolder};
use lostmotion::effects::{ActsOn, Effect, EffectInstance, catalogue, entry};
use lostmotion::io::yaml::Document;
use lostmotion::log::Log;
use lostmotion::machine::{CommandTrajectory, predict};
use lostmotion::model::Model;
use lostmotion::robot::Robot;
use serde_json::Value;
use std::path::Path;

const TOLERANCE_UM: f64 = 0.5;
const FOLDER: &str = "tests/data/catalogue";

struct Case {
    name: String,
    robot: String,
    input: String,
    effects: Value,
    preload: Value,
    registration: Value,
    rows: Vec<usize>,
    xyz_mm: Vec<[f64; 3]>,
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(format!("{FOLDER}/cases.json")).unwrap();
    let all: Vec<Value> = serde_json::from_str(&text).unwrap();
    let text = |v: &Value| v.as_str().unwrap().to_string();
    all.iter()
        .map(|c| Case {
            name: text(&c["name"]),
            robot: text(&c["robot"]),
            input: text(&c["input"]),
            effects: c["effects"].clone(),
            preload: c["preload"].clone(),
            registration: c["registration"].clone(),
            rows: serde_json::from_value(c["rows"].clone()).unwrap(),
            xyz_mm: serde_json::from_value(c["xyz_mm"].clone()).unwrap(),
        })
        .collect()
}

fn model_yaml(robot: &str, case: &Case) -> String {
    let frame =
        if case.registration.is_null() { String::new() } else { format!("registration: {}\n", case.registration) };
    let (side, effects) = (&case.preload, &case.effects);
    // `preload` is the older name of `initial_gap_side`
    format!("schema: lostmotion/model/1\nrobot: {robot}\n{frame}preload: {side}\neffects: {effects}\n")
}

fn load(case: &Case) -> Model {
    let text = model_yaml(&case.robot, case);
    Model::parse("model.yaml", &text, &|name| Robot::load(&Path::new(FOLDER).join(name))).unwrap()
}

/// TCP of a log in mm.
fn tcp_mm(csv: &str) -> Vec<[f64; 3]> {
    let mut lines = csv.lines().filter(|l| !l.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = ["x_mm", "y_mm", "z_mm"].map(|n| names.iter().position(|c| *c == n).unwrap());
    lines
        .map(|l| {
            let cells: Vec<&str> = l.split(',').collect();
            at.map(|i| cells[i].parse().unwrap())
        })
        .collect()
}

/// TCP in mm with the torques of the drives, which the log's columns `torque_<joint>_nm` hold.
fn with_torques(case: &Case) -> Vec<[f64; 3]> {
    let (model, path) = (load(case), Path::new(FOLDER).join(&case.input));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut rows = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let rows: Vec<Vec<&str>> = rows.collect();
    let column = |name: &str| {
        let at = head.iter().position(|c| c.eq_ignore_ascii_case(&format!("torque_{name}_nm")))?;
        Some(rows.iter().map(|r| r[at].parse().unwrap()).collect::<Vec<f64>>())
    };
    let torques = model.robot.axis_names().iter().map(|n| column(n)).collect();
    let log = Log::load(&path, &model.robot).unwrap();
    let trajectory = CommandTrajectory::of_log(&model.robot, &log).with_measured_torque(torques);
    predict(&model, &trajectory).points_m[0].iter().map(|p| [p.x * 1e3, p.y * 1e3, p.z * 1e3]).collect()
}

/// Largest distance from the oracle over the kept rows, um, and where.
fn worst_um(case: &Case) -> (f64, usize) {
    if case.effects.to_string().contains("torque\"") || case.name.contains("torque_windup") {
        return farthest(case, &with_torques(case));
    }
    let folder = WorkFolder::new();
    let model = folder.join("model.yaml");
    let robot = std::fs::canonicalize(Path::new(FOLDER).join(&case.robot)).unwrap();
    std::fs::write(&model, model_yaml(robot.to_str().unwrap(), case)).unwrap();
    let input = format!("{FOLDER}/{}", case.input);
    let out = support::command()
        .args(["simulate", "--rate-hz", "20", "--model", model.to_str().unwrap(), "--input", &input])
        .output()
        .unwrap();
    assert!(out.status.success(), "{}: {}", case.name, String::from_utf8_lossy(&out.stderr));
    farthest(case, &tcp_mm(&String::from_utf8(out.stdout).unwrap()))
}

fn farthest(case: &Case, found: &[[f64; 3]]) -> (f64, usize) {
    let distance = |row: usize, want: &[f64; 3]| {
        let d2: f64 = found[row].iter().zip(want).map(|(a, b)| (a - b).powi(2)).sum();
        d2.sqrt() * 1e3
    };
    case.rows
        .iter()
        .zip(&case.xyz_mm)
        .map(|(&r, w)| (distance(r, w), r))
        .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
}

#[test]
fn every_effect_agrees_with_an_oracle_stepped_in_time() {
    let cases = cases();
    assert!(cases.len() >= 70);
    let mut bad = Vec::new();
    for case in &cases {
        let (um, row) = worst_um(case);
        println!("{um:9.4} um at row {row:4}  {} {}", case.robot, case.name);
        if um > TOLERANCE_UM {
            bad.push(format!("{} {}: {um:.3} um at row {row}", case.robot, case.name));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn the_oracle_has_every_effect_of_the_catalogue() {
    let text = std::fs::read_to_string(format!("{FOLDER}/cases.json")).unwrap();
    for card in catalogue::ALL {
        assert!(text.contains(&format!("\"effect\":\"{}\"", card.name)), "{}", card.name);
    }
}

#[test]
fn what_an_entry_says_is_written_as_it_was_read() {
    for case in cases() {
        let model = load(&case);
        for placed in &model.effects {
            let value = entry::write(placed, &model.robot);
            let again = entry::read(&value, &model.robot, &Document { name: "m", text: "" }).unwrap();
            assert_eq!(again.target, placed.target);
            assert_eq!(again.effect.name(), placed.effect.name());
            for (a, b) in again.effect.values().iter().zip(placed.effect.values()) {
                assert!((a - b).abs() <= 1e-14 * b.abs(), "{}: {a} {b}", case.name);
            }
        }
        let text = model.to_yaml("robot.yaml").unwrap();
        let back = Model::parse("m", &text, &|_| Ok(model.robot.clone())).unwrap();
        assert_eq!(back.effects.len(), model.effects.len());
    }
}

#[test]
fn values_keys_and_bounds_go_together_and_hold_the_value() {
    for case in cases() {
        let model = load(&case);
        for placed in &model.effects {
            let values = placed.effect.values();
            let (keys, bounds) = (placed.keys(&model.robot), placed.bounds(&model.robot));
            assert_eq!((values.len(), values.len()), (keys.len(), bounds.len()), "{}", placed.effect.name());
            assert!(values.iter().zip(&bounds).all(|(v, (lo, hi))| v >= lo && v <= hi), "{placed:?} {bounds:?}");
            let again = placed.effect.with_values(&values).values();
            assert!(again.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-15), "{placed:?}");
            // a key and its factor say what the file says
            let file = serde_json::to_value(entry::write(placed, &model.robot)).unwrap();
            for ((key, factor), value) in keys.iter().zip(&values) {
                if let Some(written) = file.get(key).and_then(Value::as_f64) {
                    assert!((written - value * factor).abs() <= 1e-12 * written.abs(), "{key}");
                }
            }
            let card = placed.effect.info();
            // of those that act at one of two places the stage is that of the place
            let two = matches!(card.acts_on, ActsOn::JointOrDhParameter(_) | ActsOn::JointOrTcp);
            assert!(two || card.stage == placed.effect.stage(), "{}", card.name);
        }
    }
}

#[test]
fn names_that_a_card_calls_rivals_are_effects() {
    for card in catalogue::ALL {
        for alternative in card.confused_with {
            assert!(catalogue::find(alternative).is_some(), "{}: {alternative}", card.name);
        }
        assert!(card.decide_by.len() > 20 && card.action.len() > 20 && !card.parameters.is_empty());
    }
}

#[test]
fn an_axis_at_rest_and_an_empty_list_of_effects_change_nothing() {
    let robot = Robot::load(Path::new("tests/data/catalogue/arm.yaml")).unwrap();
    let t_s: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.1).collect();
    let cmd: Vec<Vec<f64>> =
        (0..6).map(|a| t_s.iter().map(|t| if a == 2 { (t * 0.7).sin() } else { 0.2 }).collect()).collect();
    let trajectory = CommandTrajectory::of_columns(&robot, t_s, cmd.clone(), None, false);
    for (axis, command) in cmd.iter().enumerate() {
        assert_eq!(&trajectory.gear(axis, &[], 0), command);
        assert_eq!(&trajectory.servo(axis, &[], 1), command);
        assert_eq!(trajectory.is_stationary(axis), axis != 2);
    }
    let ideal = predict(&Model::ideal(robot.clone()), &trajectory);
    assert!((ideal.points_m[0][7] - robot.tcp_m(&cmd.iter().map(|c| c[7]).collect::<Vec<_>>())).norm() < 1e-12);
}

#[test]
fn an_effect_that_cannot_be_is_refused_with_its_line() {
    let case = |entry: &str, says: &[&str]| {
        let text = format!("schema: lostmotion/model/1\nrobot: slide.yaml\neffects:\n  - {entry}\n");
        let error = Model::parse("model.yaml", &text, &|name| Robot::load(&Path::new(FOLDER).join(name))).unwrap_err();
        let error = error.to_string();
        assert!(error.starts_with("model.yaml:4"), "{entry}: {error}");
        for s in says {
            assert!(error.contains(s), "{entry}: {error}");
        }
    };
    case("{effect: servo_lag, joint: S, lag_s: -0.01}", &["lag_s: -0.01", "0 or more"]);
    case("{effect: servo_lag, lag_s: 0.01}", &["servo_lag without `joint`"]);
    case("{effect: encoder_scale, joint: S}", &["no `scale_ppm`"]);
    case("{effect: encoder_scale, joint: S, scale_ppm: .nan}", &["scale_ppm", "finite"]);
    case("{effect: backlash_speed, joint: S, half_gap_mm: 0.1}", &["no `slope_mm_per_mm_s`"]);
    case("{effect: backlash_speed, joint: J1, half_gap_mm: 0.1}", &["no `half_gap_deg`"]);
    case("{effect: hysteresis, joint: J1, half_width_deg: 0.1, presliding_deg: 0}", &["presliding_deg: 0", "above 0"]);
    case("{effect: transmission_error, joint: J1, amplitude_deg: 0.1, cycles_per_rev: 0}", &["cycles_per_rev: 0"]);
    case("{effect: joint_zero_offset, joint: J2b, offset_deg: 1}", &["joint `J2b`", "S, J1, J2, J3"]);
    case("{effect: axis_coupling, joint: J3, ratio: 0.1}", &["no `from`", "J3"]);
    case("{effect: axis_coupling, target: J3<-J9, ratio: 0.1}", &["joint `J9`"]);
    case("{effect: axis_coupling, target: J3<-J3, ratio: 0.1}", &["coupled with itself"]);
    case("{effect: axis_coupling, target: J3<-S, from: J1, ratio: 0.1}", &["from `J1`"]);
    case("{effect: gravity_compliance, joint: S, compliance_deg_per_nm: 1}", &["no `compliance_mm_per_n`"]);
    case("{effect: link_error, target: J2, delta_mm: 1}", &["target `J2`", "JOINT.a"]);
    case("{effect: link_error, target: J2.theta, delta_mm: 1}", &["J2.theta"]);
    case("{effect: link_error, target: J2.alpha, delta_mm: 1}", &["no `delta_deg`"]);
    case("{effect: link_error, delta_mm: 1}", &["no `target`"]);
    case("{effect: tool_error}", &["x_mm"]);
    case("{effect: tool_error, target: log, x_mm: 1}", &["target `log`"]);
    case("{effect: thermal_drift, x_mm: 1, tau_s: 0}", &["tau_s: 0"]);
    case("{effect: vibration, amplitude_um: 1, frequency_hz: 2, direction: [0, 0, 0]}", &["direction"]);
    case("{effect: vibration, amplitude_um: 1, frequency_hz: 2}", &["no `direction`"]);
    case("{effect: time_offset, offset_s: soon}", &["offset_s: soon"]);
    case("{effect: time_offset, offset_s: 1, tau_s: 2}", &["unknown key `tau_s`"]);
    case("{effect: backlesh, joint: S}", &["backlesh", "nearest is `backlash`", "docs/effects.md"]);
    case("{effect: stiction, joint: S, spike_positive_mm: 0.1, rise_s: 1, decay_s: 1}", &["`spike_negative_mm`"]);
    case("{effect: stiction, joint: S, spike_mm: 0.1, rise_s: 1, rise_mm: 1, decay_s: 1}", &["two rises", "`rise_mm`"]);
    case("{effect: hysteresis, joint: S, elements: [[0.1, 2], [0.1, 1]]}", &["elements", "above 0 and rising"]);
    case("{effect: empirical, joint: S, over: colour, knots: [[0, 1], [1, 2]]}", &["one of position, direction"]);
    case("{effect: empirical, joint: S, over: position, knots: [[1, 1], [0, 2]]}", &["arguments rising"]);
    case("{effect: empirical, target: tcp, over: position, knots: [[0, 1, 1, 1], [1, 1, 1, 1]]}", &["`of: JOINT`"]);
    case("{effect: thermal_growth, joint: S, per_hour_mm: 1, per_k_mm: 1}", &["one of `per_hour_mm`"]);
    case("{effect: thermal_growth, target: J2.alpha, per_hour_deg: 1}", &["target `J2.alpha`", "JOINT.a"]);
    case("{effect: gravity_compliance, joint: S, moments: [[J2, 1, 1]]}", &["moments", "a revolute joint"]);
    case("{effect: gravity_compliance, joint: J3, moments: [[J2, 1, 1]]}", &["moments", "joints after it"]);
    case(
        "{effect: bearing_wobble, joint: J2, amplitude_deg: 1, cycles_per_rev: 1, direction: [0, 0, 1]}",
        &["a direction along the axis"],
    );
    case("{effect: tracker_frame, t_s: 3}", &["no movement and no turn"]);
    case("{effect: loaded_play, joint: S, half_gap_mm: 0.1, torque_nm: 3}", &["no `force_n`"]);
}

#[test]
fn a_transmission_error_of_a_slide_without_lead_is_refused() {
    let text = "schema: lostmotion/model/1\nrobot: {schema: lostmotion/robot/1, joints: [{name: X, kind: prismatic}]}\n\
                effects:\n  - {effect: transmission_error, joint: X, amplitude_mm: 0.1, cycles_per_rev: 1}\n";
    let e = Model::parse("m.yaml", text, &|_| unreachable!()).unwrap_err().to_string();
    assert!(e.starts_with("m.yaml:4") && e.contains("lead_mm_per_rev"), "{e}");
}

#[test]
fn a_rewritten_program_brings_the_joints_where_the_program_wants_them() {
    let folder = WorkFolder::new();
    let robot = std::fs::canonicalize(Path::new(FOLDER).join("arm.yaml")).unwrap();
    let effects = "[{effect: encoder_scale, joint: A1, scale_ppm: 150},
  {effect: transmission_error, joint: A2, amplitude_deg: 0.004, cycles_per_rev: 7, phase_deg: 20},
  {effect: joint_zero_offset, joint: A3, offset_deg: 0.02}, {effect: axis_coupling, target: A6<-A5, ratio: 0.002},
  {effect: gravity_compliance, joint: A2, compliance_deg_per_nm: 5.0e-6}, {effect: backlash, joint: A6, half_gap_deg: 0.02},
  {effect: hysteresis, joint: A1, half_width_deg: 0.004, presliding_deg: 0.2},
  {effect: empirical, joint: A4, over: position, knots: [[0, 0.02], [25, -0.01], [60, 0.03]]},
  {effect: gravity_compliance, joint: A3, moments: [[A3, 0.01, 0.004], [A5, 0.003, 0.002]]}]";
    let model = folder.join("model.yaml");
    let yaml = format!("schema: lostmotion/model/1\nrobot: {}\neffects: {effects}\n", robot.display());
    std::fs::write(&model, yaml).unwrap();
    let ideal = folder.join("ideal.yaml");
    std::fs::write(&ideal, format!("schema: lostmotion/model/1\nrobot: {}\neffects: []\n", robot.display())).unwrap();
    // a dense program: the rows of the arm's log
    let log = std::fs::read_to_string(format!("{FOLDER}/arm_log.csv")).unwrap();
    let program = folder.join("p.csv");
    let rows: Vec<String> =
        log.lines().map(|l| l.replace("cmd_", "").split(',').take(7).collect::<Vec<_>>().join(",")).collect();
    std::fs::write(&program, rows.join("\n") + "\n").unwrap();
    let rewritten = folder.join("out.csv");
    let text = |p: &Path| p.to_str().unwrap().to_string();
    support::command()
        .args(["rewrite", "--model", &text(&model), &text(&program), "--output", &text(&rewritten)])
        .assert()
        .success();
    let run = |model: &Path, program: &Path| {
        let out = support::command()
            .args(["simulate", "--rate-hz", "20", "--model", &text(model), "--input", &text(program)])
            .output()
            .unwrap();
        tcp_mm(&String::from_utf8(out.stdout).unwrap())
    };
    let wanted = run(&ideal, &program);
    let rms = |path: &[[f64; 3]]| {
        // the play and the hysteresis start in the middle: compare after the first reversals
        let d: Vec<f64> = path
            .iter()
            .zip(&wanted)
            .skip(150)
            .map(|(a, b)| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>())
            .collect();
        (d.iter().sum::<f64>() / d.len() as f64).sqrt() * 1e3
    };
    let (before, after) = (rms(&run(&model, &program)), rms(&run(&model, &rewritten)));
    println!("{before} um before, {after} um after");
    assert!(before > 300.0 && after < 3.0, "{before} um before, {after} um after");
}

/// `EffectInstance` and `Effect` are what others build on.
#[test]
fn targets_are_named_as_documents_name_them() {
    let model = load(cases().iter().find(|c| c.name.starts_with("axis_coupling A6")).unwrap());
    assert_eq!(model.effects[0].target_text(&model.robot), "A6<-A5");
    let tool = EffectInstance {
        target: lostmotion::effects::Target::Tool,
        effect: Effect::new(lostmotion::effects::ToolError { offset_m: nalgebra::Vector3::x() }),
    };
    assert_eq!((tool.target_text(&model.robot).as_str(), tool.axis()), ("tool", None));
}
