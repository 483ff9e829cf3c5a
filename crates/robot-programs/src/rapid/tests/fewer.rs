//! Arms of which the robot file has fewer joints than a target has numbers.

use super::*;

fn arm(names: &[&str]) -> Axes {
    Axes::new("arm", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect())
}

fn palletizer() -> Axes {
    arm(&["J1", "J2", "J3", "J6"])
}

const IDLE: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

fn module(targets: &[&str]) -> String {
    let body: Vec<String> = targets.iter().map(|t| format!("MoveAbsJ [[{t}],{IDLE}],v100,fine,tool0;")).collect();
    program("", &body.join("\n"))
}

fn read(source: &str, robot: &Axes) -> Box<dyn Document> {
    harness::parse(&Rapid, source.as_bytes(), robot).unwrap()
}

/// Degrees of the target of move `n`.
fn degrees_of(doc: &dyn Document, n: usize) -> Vec<f64> {
    let (step, _) = doc.script().moves().nth(n).unwrap();
    harness::values(doc.script(), step).iter().map(|v| (v.to_degrees() * 1e6).round() / 1e6).collect()
}

fn closed(doc: &dyn Document) -> Vec<bool> {
    doc.script().moves().map(|(_, m)| m.closed.is_some()).collect()
}

#[test]
fn the_fourth_joint_of_a_palletizer_is_the_sixth_number() {
    let source = module(&["10,20,30,0,0,60", "11,21,31,0,0,-90", "12,22,32,0,0,90", "13,23,33,0,0,95"]);
    let doc = read(&source, &palletizer());
    assert_eq!(degrees_of(doc.as_ref(), 0), [10.0, 20.0, 30.0, 60.0]);
    assert_eq!(degrees_of(doc.as_ref(), 3), [13.0, 23.0, 33.0, 95.0]);
    assert_eq!(closed(doc.as_ref()), [false; 4]);
    let (step, _) = doc.script().moves().nth(2).unwrap();
    let q = |deg: [f64; 4]| deg.map(f64::to_radians).to_vec();
    let point = NewPoint {
        q: q([11.0, 21.0, 31.0, -89.5]),
        share: 0.5,
        t_s: None,
        clearance_m: 0.01,
        of_way: false,
        waits: false,
    };
    let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 4], ..Edits::default() };
    edits.steps.insert(step, Edit { before: vec![point], goal: Some(q([12.0, 22.0, 32.0, 90.5])), ..Edit::default() });
    assert_eq!(round_trip(&Rapid, source.as_bytes(), &palletizer(), &edits), Ok(Outcome::Kept));
    let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let out = String::from_utf8(out.into_iter().next().unwrap()).unwrap();
    let new = format!(
        "MoveAbsJ [[11.0000,21.0000,31.0000,0,0,-89.5000],{IDLE}],v100,fine,tool0;\n\
         MoveAbsJ [[12,22,32,0,0,90.5000],{IDLE}],v100,fine,tool0;"
    );
    assert!(out.contains(&new), "{out}");
}

#[test]
fn a_cartesian_move_of_a_palletizer_becomes_a_joint_move_with_two_zeros() {
    let pose = format!("MoveJ [[1900,300,1500],[0,1,0,0],[0,0,0,0],{IDLE}],v100,fine,tool0;");
    let at = format!("MoveAbsJ [[0,0,10,0,0,0],{IDLE}],v100,fine,tool0;");
    let source = program("", &format!("{at}\n{pose}\n{at}"));
    let doc = read(&source, &palletizer());
    assert_eq!(closed(doc.as_ref()), [false; 3]);
    let (step, _) = doc.script().moves().nth(1).unwrap();
    let goal = Some([10.0, 20.0, 30.0, 60.0].map(f64::to_radians).to_vec());
    let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 4], ..Edits::default() };
    edits.steps.insert(step, Edit { goal, as_joint_moves: true, ..Edit::default() });
    let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let new = format!("MoveAbsJ [[10.0000,20.0000,30.0000,0,0,60.0000],{IDLE}],v100,fine,tool0;");
    assert!(String::from_utf8(out[0].clone()).unwrap().contains(&new));
    // the joints of other arms that the robot file lacks may stand anywhere
    let five = arm(&["J1", "J2", "J3", "J5", "J6"]);
    assert_eq!(closed(read(&source, &five).as_ref()), [true; 3]);
    assert!(read(&source, &five).patches(&edits).is_err());
}

#[test]
fn a_move_on_which_a_number_without_a_joint_changes_takes_no_point() {
    let five = arm(&["A1", "A2", "A3", "A5", "A6"]);
    let body = ["10,20,30,40,50,60", "11,21,31,40,51,61", "12,22,32,41,52,62", "13,23,33,41,53,63"];
    let doc = read(&module(&body), &five);
    assert_eq!(degrees_of(doc.as_ref(), 2), [12.0, 22.0, 32.0, 52.0, 62.0]);
    assert_eq!(closed(doc.as_ref()), [true, false, true, false]);
    let why = doc.script().moves().nth(2).unwrap().1.closed.as_ref().unwrap().to_string();
    assert_eq!(why, "axes that the robot file does not have may move along");
    // one that is computed may be any
    let computed = read(&module(&["1,2,3,a,5,6", "1,2,3,a,5,7"]), &five);
    assert_eq!(closed(computed.as_ref()), [true; 2]);
    // where it never changes, no label ends what is known of it
    let still = module(&["1,2,3,4,5,6", "2,2,3,4,5,6"]).replace(";\nMoveAbsJ", ";\nlabel:\nMoveAbsJ");
    assert_eq!(closed(read(&still, &five).as_ref()), [false; 2]);
}

#[test]
fn joints_that_may_be_any_of_the_six_numbers_are_no_targets() {
    let doc = read(&module(&["1,2,3,4,5,6"]), &arm(&["S", "L", "U", "T"]));
    let why = opaque(doc.script().moves().next().unwrap().1);
    assert!(why.contains("(S, L, U, T)") && why.contains("name them J1, J2, ..."), "{why}");
}

/// External axes beside fewer than six joints of the arm.
#[test]
fn an_external_axis_of_a_palletizer_stands_in_the_second_list() {
    let mut joints = vec![Axis::new("eax_a", JointKind::Revolute)];
    joints.extend(["J1", "J2", "J3", "J6"].map(|n| Axis::new(n, JointKind::Revolute)));
    let robot = Axes::new("on a table", joints);
    let source = module(&["1,2,3,0,0,6"]).replace("[9E9,", "[45,");
    assert_eq!(degrees_of(read(&source, &robot).as_ref(), 0), [45.0, 1.0, 2.0, 3.0, 6.0]);
    let alone = source.replace("MoveAbsJ", "MoveExtJ").replace("[1,2,3,0,0,6],", "").replace("[[45", "[45");
    let alone = alone.replace("9E9]]", "9E9]").replace(",tool0;", ";").replace("v100", "vrot10");
    let doc = harness::parse(&Rapid, alone.as_bytes(), &robot).unwrap();
    assert_eq!(opaque(doc.script().moves().next().unwrap().1), "MoveExtJ moves external axes alone");
}
