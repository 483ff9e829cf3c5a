//! Numbers of C lines by the names of the robot's joints.

use super::*;
use crate::axes::{Axis, JointKind};

/// Joints with 1000, 1100, ... pulses a degree in the order of the controller: S, L, U, R, B, T, E.
fn arm(names: &[&str]) -> Axes {
    let joint = |name: &&str| {
        let mut joint = Axis::new(*name, JointKind::Revolute);
        let place = "SLURBTE".find(*name).unwrap_or(0);
        joint.pulses = Some((1000.0 + 100.0 * place as f64) / JointKind::Revolute.si_per_user_unit());
        joint
    };
    Axes::new("arm", names.iter().map(joint).collect())
}

fn list(lines: &[&str]) -> String {
    let lines: Vec<String> = lines.iter().enumerate().map(|(k, l)| format!("C{k:05}={l}")).collect();
    let moves: Vec<String> = (0..lines.len()).map(|k| format!("MOVJ C{k:05} VJ=10.00")).collect();
    let all = format!("///TOOL 0\n///POSTYPE PULSE\n///PULSE\n{}", lines.join("\n"));
    job(&format!("{},0,0,0,0,0", lines.len()), &all, &moves.join("\n"))
}

fn deg(script: &Script, n: usize) -> Vec<f64> {
    let step = moves(script)[n].0;
    values(script, step).iter().map(|v| (v.to_degrees() * 1e9).round() / 1e9).collect()
}

/// The job with move `n` to joint values in deg, and a point before it.
fn with(text: &str, robot: &Axes, n: usize, goal: &[f64], point: &[f64]) -> String {
    let step = moves(&script_of(&Inform, text, robot))[n].0;
    let q = |deg: &[f64]| deg.iter().map(|v| v.to_radians()).collect::<Vec<f64>>();
    let point = NewPoint { q: q(point), share: 0.5, t_s: None, clearance_m: 0.001, of_way: false, waits: false };
    let mut edits = Edits { digit: vec![1e-7; robot.dof()], ..Edits::default() };
    edits.steps.insert(step, Edit { goal: Some(q(goal)), before: vec![point], ..Edit::default() });
    String::from_utf8(edited(&Inform, text.as_bytes(), &edits, robot).unwrap()).unwrap()
}

#[test]
fn the_third_joint_of_an_arm_of_seven_is_the_last_number() {
    let robot = arm(&["S", "L", "E", "U", "R", "B", "T"]);
    let text = list(&["1000,2200,3600,5200,7000,9000,11200", "1000,2200,3600,5200,7000,9000,0"]);
    let script = script_of(&Inform, &text, &robot);
    assert_eq!(deg(&script, 0), [1.0, 2.0, 7.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(moves(&script).iter().filter(|m| m.1.closed.is_some()).count(), 0);
    // 0.1 deg of E are 160 pulses, and no other number changes
    let out = with(&text, &robot, 1, &[1.0, 2.0, 0.1, 3.0, 4.0, 5.0, 6.0], &[1.0, 2.0, 7.1, 3.0, 4.0, 5.0, 6.0]);
    assert!(out.contains("C00001=1000,2200,3600,5200,7000,9000,160\r\n"), "{out}");
    assert!(out.contains("C00002=1000,2200,3600,5200,7000,9000,11360\r\n"), "{out}");
}

#[test]
fn a_palletizer_has_four_numbers_or_six_with_a_gap() {
    let robot = arm(&["S", "L", "U", "T"]);
    let four = list(&["1000,2200,3600,9000", "1000,2200,3600,0"]);
    assert_eq!(deg(&script_of(&Inform, &four, &robot), 0), [1.0, 2.0, 3.0, 6.0]);
    let six =
        list(&["1000,2200,3600,0,0,9000", "1000,2200,3600,0,0,0", "1000,2200,3600,7,0,0", "1000,2200,3600,7,0,1500"]);
    let script = script_of(&Inform, &six, &robot);
    assert_eq!(deg(&script, 0), [1.0, 2.0, 3.0, 6.0]);
    // a number without a joint changes on the third way, and is not known before the first
    let closed: Vec<bool> = moves(&script).iter().map(|m| m.1.closed.is_some()).collect();
    assert_eq!(closed, [true, false, true, false]);
    let out = with(&six, &robot, 1, &[1.0, 2.0, 3.0, 0.2], &[1.0, 2.0, 3.0, 5.0]);
    assert!(out.contains("C00001=1000,2200,3600,0,0,300\r\n"), "{out}");
    assert!(out.contains("C00004=1000,2200,3600,0,0,7500\r\n"), "{out}");
    // five may be any of them
    let five = script_of(&Inform, &list(&["1,2,3,4,5"]), &robot);
    assert!(harness::opaque(&moves(&five)[0].1).contains("(S, L, U, T)"));
}

#[test]
fn an_arm_whose_file_lacks_a_joint_has_its_numbers_by_name() {
    let text = list(&["1000,2200,3600,7,7000,9000", "1000,2200,3600,7,7000,0"]);
    let robot = arm(&["S", "L", "U", "B", "T"]);
    assert_eq!(deg(&script_of(&Inform, &text, &robot), 0), [1.0, 2.0, 3.0, 5.0, 6.0]);
    let unnamed = arm(&["a", "b", "c"]);
    assert!(harness::opaque(&moves(&script_of(&Inform, &text, &unnamed))[0].1).contains("(a, b, c)"));
}
