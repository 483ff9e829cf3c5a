//! Arms of which the robot file has fewer joints than a list has numbers, or has them in another order.

use super::*;
use crate::axes::{Axis, JointKind};

fn arm(names: &[&str]) -> Axes {
    Axes::new("arm", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect())
}

fn script(lists: &[&str]) -> String {
    let body: String = lists.iter().map(|l| format!("  movej([{l}])\n")).collect();
    format!("def p():\n{body}end\n")
}

fn read(source: &str, robot: &Axes) -> Box<dyn Document> {
    harness::parse(&UrScript, source.as_bytes(), robot).unwrap()
}

fn values(doc: &dyn Document, n: usize) -> Vec<f64> {
    let (step, _) = doc.script().moves().nth(n).unwrap();
    harness::values(doc.script(), step)
}

fn closed(doc: &dyn Document) -> Vec<bool> {
    doc.script().moves().map(|(_, m)| m.closed.is_some()).collect()
}

/// The list of a point before the second move, with the joints at `q`.
fn new_list(source: &str, robot: &Axes, q: Vec<f64>) -> String {
    let doc = read(source, robot);
    let (step, _) = doc.script().moves().nth(1).unwrap();
    let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
    let mut edits = Edits { digit: vec![1e-6; robot.dof()], ..Edits::default() };
    edits.steps.insert(step, Edit { before: vec![point], ..Edit::default() });
    assert_eq!(round_trip(&UrScript, source.as_bytes(), robot, &edits), Ok(Outcome::Kept));
    let bytes = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let out = String::from_utf8(bytes[0].clone()).unwrap();
    out.lines().nth(2).unwrap().trim().to_string()
}

#[test]
fn joints_are_found_by_their_names_and_the_other_numbers_stay() {
    let five = arm(&["base", "shoulder", "elbow", "wrist2", "wrist3"]);
    let source = script(&["1, 2, 3, 4, 5, 6", "1.1, 2.1, 3.1, 4, 5.1, 6.1", "1.2, 2.2, 3.2, 4.1, 5.2, 6.2"]);
    let doc = read(&source, &five);
    assert_eq!(values(doc.as_ref(), 1), [1.1, 2.1, 3.1, 5.1, 6.1]);
    assert_eq!(closed(doc.as_ref()), [true, false, true]);
    let list = new_list(&source, &five, vec![1.0, 2.0, 3.0, 5.0, 6.5]);
    assert_eq!(list, "movej([1.000000, 2.000000, 3.000000, 4, 5.000000, 6.500000])");
    // a list that ends before the last joint is none
    let short = refusal_of(&script(&["1, 2, 3, 4, 5"]), &five);
    assert!(short.contains("a joint target of 5 numbers; expected 6"), "{short}");
}

fn refusal_of(source: &str, robot: &Axes) -> String {
    harness::parse(&UrScript, source.as_bytes(), robot).err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn a_robot_file_in_another_order_has_its_numbers_by_name() {
    let names =
        ["shoulder_lift_joint", "shoulder_pan_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"];
    let source = script(&["1, 2, 3, 4, 5, 6", "1.1, 2, 3, 4, 5, 6"]);
    assert_eq!(values(read(&source, &arm(&names)).as_ref(), 0), [2.0, 1.0, 3.0, 4.0, 5.0, 6.0]);
    let list = new_list(&source, &arm(&names), vec![2.5, 1.5, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(list, "movej([1.500000, 2.500000, 3, 4, 5, 6])");
}

#[test]
fn joints_that_may_be_any_of_the_six_numbers_are_no_targets() {
    let doc = read(&script(&["1, 2, 3, 4, 5, 6"]), &arm(&["turret", "boom", "jib"]));
    let why = opaque(doc.script().moves().next().unwrap().1);
    assert!(why.contains("(turret, boom, jib)"), "{why}");
}

#[test]
fn on_the_way_to_a_pose_a_joint_without_a_name_may_move() {
    let five = arm(&["J1", "J2", "J3", "J5", "J6"]);
    let source =
        "def p():\n  movej([1, 2, 3, 4, 5, 6])\n  movel(p[0.3, 0, 0.3, 0, 0, 0])\n  movej([1, 2, 3, 4, 5, 6])\nend\n";
    assert_eq!(closed(read(source, &five).as_ref()), [true; 3]);
}
