//! Joints and the numbers of a target where these differ: a palletizer, and an arm of seven axes.

use crate::recording::options;
use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use lostmotion::io::input::Input;
use lostmotion::plan::recording::vendor::{self, Language};
use lostmotion::plan::recording::{Kind, Recording, plan};
use lostmotion::program::Program;
use lostmotion::robot::Robot;

/// A palletizer with four axes, whose linkage keeps the tool upright.
const PALLETIZER: &str = "schema: lostmotion/robot/1
name: palletizer
convention: dh-standard
joints:
  - {name: J1, kind: revolute, theta_deg: 0, d_mm: 814.5, a_mm: 300, alpha_deg: -90, limits_deg: [-180, 180], max_speed_deg_s: 95, max_accel_deg_s2: 200}
  - {name: J2, kind: revolute, theta_deg: -90, d_mm: 0, a_mm: 1280, alpha_deg: 0, limits_deg: [-42, 85], max_speed_deg_s: 95, max_accel_deg_s2: 200}
  - {name: J23, kind: revolute, theta_deg: 90, d_mm: 0, a_mm: 0, alpha_deg: 0, direction: -1, follows: {joint: J2, ratio: 1}}
  - {name: J3, kind: revolute, theta_deg: 0, d_mm: 0, a_mm: 1350, alpha_deg: 0, limits_deg: [-20, 120], max_speed_deg_s: 95, max_accel_deg_s2: 200}
  - {name: J33, kind: revolute, theta_deg: 0, d_mm: 0, a_mm: 250, alpha_deg: -90, direction: -1, follows: {joint: J3, ratio: 1}}
  - {name: J6, kind: revolute, theta_deg: 0, d_mm: 220, a_mm: 0, alpha_deg: 0, limits_deg: [-300, 300], max_speed_deg_s: 240, max_accel_deg_s2: 500}
tool: {xyz_mm: [200, 0, 100], rpy_deg: [0, 0, 0]}
";

/// The bundled arm of seven axes with pulses: 1000 a degree for S, 1100 for L, 1200 for E, and so on along the arm.
fn seven() -> String {
    let text = std::fs::read_to_string(bundled("configs/motoman-sia20d.yaml")).unwrap();
    let mut pulses = 900;
    let line = |line: &str| {
        if !line.contains("kind: revolute") {
            return line.to_string();
        }
        pulses += 100;
        line.replacen("kind: revolute,", &format!("kind: revolute, pulses_per_deg: {pulses},"), 1)
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// The static test of a robot in a language, and its text.
fn planned(robot: &Robot, language: Language) -> (Recording, String) {
    let recording = plan(robot, Kind::Static, &options()).unwrap();
    let bytes = vendor::program(&recording, robot, language, "static test 1").unwrap();
    (recording, String::from_utf8(bytes).unwrap())
}

/// Numbers between `[[` or `=` and the next `]` or the end of the line.
fn numbers(line: &str, after: &str) -> Vec<f64> {
    let inner = line.split_once(after).unwrap().1.split(']').next().unwrap();
    inner.split(',').map(|v| v.trim().parse().unwrap()).collect()
}

#[test]
fn a_palletizer_is_rewritten_with_its_fourth_joint_in_the_sixth_number() {
    let desk = Desk::new(0.0);
    desk.write("r.yaml", PALLETIZER);
    let gaps: String = ["J1, half_gap_deg: 0.01", "J2, half_gap_deg: 0.02", "J6, half_gap_deg: 0.1"]
        .map(|g| format!("  - {{effect: backlash, joint: {g}}}\n"))
        .concat();
    desk.write("m.yaml", &format!("schema: lostmotion/model/1\nrobot: r.yaml\neffects:\n{gaps}"));
    let target = |t: &str| format!("  MoveAbsJ [[{t}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;\n");
    let body: String = ["0,0,10,0,0,0", "10,10,20,0,0,90", "0,0,10,0,0,-90", "10,10,20,0,0,90"].map(target).concat();
    desk.write("a.mod", &format!("MODULE a\nPROC main()\n{body}ENDPROC\nENDMODULE\n"));
    desk.run("rewrite --model m.yaml a.mod --output o.mod").success();
    let out = String::from_utf8(desk.read("o.mod")).unwrap();
    let all: Vec<Vec<f64>> = out.lines().filter(|l| l.contains("MoveAbsJ")).map(|l| numbers(l, "[[")).collect();
    assert!(all.len() > 4, "{out}");
    for q in &all {
        assert_eq!((q[3], q[4]), (0.0, 0.0), "{out}");
    }
    // every new point stands where the axis reverses: near the target before it, with all of its numbers
    for q in &all {
        let near = [[0.0, 0.0, 10.0, 0.0], [10.0, 10.0, 20.0, 90.0], [0.0, 0.0, 10.0, -90.0]]
            .iter()
            .any(|t| [0, 1, 2, 5].iter().zip(t).all(|(k, t)| (q[*k] - t).abs() < 0.25));
        assert!(near, "{q:?} in {out}");
    }
    let sixth: Vec<f64> = all.iter().map(|q| q[5]).collect();
    assert!(sixth.iter().any(|v| (v.abs() - 90.0).abs() > 0.05), "no offset of J6: {sixth:?}");
}

#[test]
fn a_static_test_of_a_palletizer_moves_its_fourth_joint_by_the_sixth_number() {
    let robot = Robot::parse("r.yaml", PALLETIZER).unwrap();
    for (language, file) in [(Language::Rapid, "s.mod"), (Language::Krl, "s.src"), (Language::Fanuc, "s.ls")] {
        let (recording, text) = planned(&robot, language);
        let bytes = text.clone().into_bytes();
        let program = Program::parse(Input { name: file.into(), bytes, sha256: String::new() }, &robot).unwrap();
        let widest = |all: &mut dyn Iterator<Item = f64>| all.map(f64::abs).fold(0.0, f64::max).to_degrees();
        let of_plan = widest(&mut recording.rows.iter().map(|r| r.1[3]));
        let of_program = widest(&mut program.q[3].iter().copied());
        assert!(of_plan > 1.0 && (of_plan - of_program).abs() < 1e-3, "{file}: {of_plan} {of_program}");
        if language == Language::Rapid {
            let all: Vec<Vec<f64>> =
                text.lines().filter(|l| l.contains("MoveAbsJ")).map(|l| numbers(l, "[[")).collect();
            assert!(all.iter().all(|q| q[3] == 0.0 && q[4] == 0.0), "{text}");
            let sixth = all.iter().map(|q| q[5].abs()).fold(0.0, f64::max);
            assert!((sixth - of_plan).abs() < 1e-3, "{sixth} {of_plan}");
        }
    }
}

#[test]
fn a_static_test_of_an_arm_of_seven_axes_has_the_third_joint_as_its_last_number() {
    let robot = Robot::parse("sia.yaml", &seven()).unwrap();
    let (recording, text) = planned(&robot, Language::Inform);
    let lines: Vec<Vec<f64>> = text.lines().filter(|l| l.starts_with("C0")).map(|l| numbers(l, "=")).collect();
    assert!(!lines.is_empty() && lines.iter().all(|l| l.len() == 7));
    // S L U R B T E of the line are 0 1 3 4 5 6 2 of the arm
    for (number, axis) in [0, 1, 3, 4, 5, 6, 2].into_iter().enumerate() {
        let per_deg = 1000.0 + 100.0 * axis as f64;
        let widest =
            |all: &mut dyn Iterator<Item = f64>| all.fold([f64::MAX, f64::MIN], |w, v| [w[0].min(v), w[1].max(v)]);
        let plan = widest(&mut recording.rows.iter().map(|r| r.1[axis].to_degrees()));
        let line = widest(&mut lines.iter().map(|l| l[number] / per_deg));
        assert!((0..2).all(|k| (plan[k] - line[k]).abs() < 2e-3), "{axis}: {plan:?} {line:?}");
    }
    let bytes = text.into_bytes();
    let program = Program::parse(Input { name: "s.jbi".into(), bytes, sha256: String::new() }, &robot).unwrap();
    for (axis, column) in program.q.iter().enumerate() {
        let ends =
            |all: &mut dyn Iterator<Item = f64>| all.fold([f64::MAX, f64::MIN], |w, v| [w[0].min(v), w[1].max(v)]);
        let (read, plan) = (ends(&mut column.iter().copied()), ends(&mut recording.rows.iter().map(|r| r.1[axis])));
        assert!((0..2).all(|k| (read[k] - plan[k]).abs() < 5e-5), "{axis}: {read:?} {plan:?}");
    }
}

#[test]
fn names_that_tell_no_numbers_are_refused_with_what_to_do() {
    let text = PALLETIZER.replace("name: J6,", "name: hand,");
    let robot = Robot::parse("r.yaml", &text).unwrap();
    let recording = plan(&robot, Kind::Static, &options()).unwrap();
    for language in [Language::Rapid, Language::Krl] {
        let refused = vendor::program(&recording, &robot, language, "t").unwrap_err().to_string();
        assert!(refused.contains("J1, J2, J3, hand") && refused.contains(".csv"), "{refused}");
    }
}
