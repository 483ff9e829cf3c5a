//! Every trap of URScript programs that we know of.

mod added;
mod fewer;
mod flow;
mod folded;
mod in_force;
mod run;

use super::*;
use crate::script::harness::{self, Outcome, opaque, round_trip};
use crate::script::pose::Frame;
use crate::script::{Edit, Goal, Move, NewPoint, PathKind, Speed, text};

use crate::fixtures::ur10 as robot;

fn document(source: &str) -> Box<dyn Document> {
    harness::parse(&UrScript, source.as_bytes(), &robot()).unwrap()
}

fn moves(source: &str) -> Vec<Move> {
    document(source).script().moves().map(|(_, m)| m.clone()).collect()
}

fn joints(source: &str, n: usize) -> Vec<f64> {
    let doc = document(source);
    let (_, m) = doc.script().moves().nth(n).unwrap();
    let Goal::Joints(t) = m.goal else { panic!("{:?}", m.goal) };
    doc.script().targets.get(t).unwrap().values.iter().map(|v| v.unwrap().si).collect()
}

fn kinds(source: &str) -> Vec<String> {
    harness::kinds(document(source).script())
}

/// Moves axis 0 of the named moves (by number) by so many rad.
fn shifted(source: &str, by: &[(usize, f64)]) -> Edits {
    harness::shifted(document(source).script(), by, 1e-6)
}

fn rewritten(source: &str, edits: &Edits) -> String {
    assert_eq!(round_trip(&UrScript, source.as_bytes(), &robot(), edits), Ok(Outcome::Kept));
    let doc = document(source);
    let bytes = text::apply(&doc.script().texts, &doc.patches(edits).unwrap()).unwrap();
    String::from_utf8(bytes.into_iter().next().unwrap()).unwrap()
}

/// New points before move `n`, with axis 0 at 0.5 rad, at these shares of the way.
fn inserted(source: &str, n: usize, shares: &[f64], clearance_m: f64) -> Edits {
    let mut q = joints(source, n);
    q[0] = 0.5;
    let point =
        |share: &f64| NewPoint { q: q.clone(), share: *share, t_s: None, clearance_m, of_way: false, waits: false };
    let (step, _) = document(source).script().moves().nth(n).map(|(k, m)| (k, m.clone())).unwrap();
    let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
    edits.steps.insert(step, Edit { before: shares.iter().map(point).collect(), ..Edit::default() });
    edits
}

const Q: &str = "[0.1, -1.57, 1.2, -2, .5, 3.]";

#[test]
fn a_literal_list_is_edited_and_everything_else_stays() {
    let source = format!("def p():\n  # caf\u{e9} movej({Q})\n  movej({Q}, a=1.4, v=1.05) # there\nend\n");
    assert_eq!(joints(&source, 0), [0.1, -1.57, 1.2, -2.0, 0.5, 3.0]);
    let out = rewritten(&source, &shifted(&source, &[(0, 0.000_123)]));
    assert_eq!(out, source.replace("  movej([0.1,", "  movej([0.100123,"));
}

#[test]
fn degrees_inside_d2r_are_edited_in_degrees_also_at_zero() {
    let source = "movej([d2r(0), d2r(-90.5), 1.2, d2r(45), 0, 0], a=1.4, v=1.05)\n";
    assert!((joints(source, 0)[1] + 90.5f64.to_radians()).abs() < 1e-15);
    let out = rewritten(source, &shifted(source, &[(0, 0.01f64.to_radians())]));
    assert_eq!(out, source.replace("d2r(0)", "d2r(0.01000)"));
}

#[test]
fn a_list_with_names_or_unknown_calls_is_left_alone() {
    for list in ["[a,0,0,0,0,0]", "[sin(1),0,0,0,0,0]", "[q[0],0,0,0,0,0]", "[1/0,0,0,0,0,0]"] {
        assert!(opaque(&moves(&format!("movej({list}, a=1)\n"))[0]).contains("value 1"), "{list}");
    }
    assert!(opaque(&moves("movej(q1 + q2)\n")[0]).contains("expression"));
}

#[test]
fn a_number_takes_the_place_of_an_expression_of_plain_numbers() {
    for (list, value) in [
        ("[1+0.1, 0, 0, 0, 0, 0]", 1.1),
        ("[-d2r(90),0,0,0,0,0]", -std::f64::consts::FRAC_PI_2),
        ("[90*3/180,0,0,0,0,0]", 1.5),
    ] {
        let source = format!("movej({list}, a=1)\n");
        assert!((joints(&source, 0)[0] - value).abs() < 1e-6, "{list}");
        let out = rewritten(&source, &shifted(&source, &[(0, 1e-3)]));
        let expected = format!("movej([{:.6},{}", value + 1e-3, list.split_once(',').unwrap().1);
        assert!(out.starts_with(&expected), "{out}");
    }
}

#[test]
fn a_displaced_pose_is_edited_in_its_own_numbers() {
    let p = "def p():\n  a = p[0.1,0.2,0.3,0,0,0]\n  b = p[0.4,0.0,0.1,0,3.1,0]\n";
    for (call, at, name) in [
        ("pose_trans(a, b)", [0.5, 0.2, 0.4], "b"),
        ("pose_add(b, p[0,0,0.05,0,0,0])", [0.4, 0.0, 0.15], "b"),
        ("get_inverse_kin(a)", [0.1, 0.2, 0.3], "a"),
    ] {
        let source = format!("{p}  movel({call}, a=1)\n  movel(p[0,0,0,0,0,0])\nend\n");
        let Goal::Pose(pose) = &moves(&source)[0].goal else { panic!("{call}") };
        assert!((pose.position_m - nalgebra::Vector3::from(at)).norm() < 1e-12, "{call}: {}", pose.position_m);
        let script = document(&source);
        let target = &script.script().targets.get(pose.target.unwrap()).unwrap();
        assert_eq!(target.name, Some(name));
        // the goal is what is written, seen through the displacement
        let values: Vec<f64> = target.values.iter().map(|v| v.unwrap().si).collect();
        let meant = pose.meant(&crate::script::PoseForm::RotationVector.pose(&values).unwrap());
        assert!((meant.translation.vector - pose.position_m).norm() < 1e-12);
    }
    assert!(matches!(moves("movel(pose_add(p[0,0,0,0,0,0], p[0,0,0,1,0,0]))\n")[0].goal, Goal::Opaque(_)));
}

#[test]
fn a_variable_that_is_assigned_once_is_a_target_of_all_its_moves() {
    let source = format!("def p():\n  global q1 = {Q}\n  movej(q1, a=1)\n  movel(q1, a=1)\nend\n");
    assert_eq!(joints(&source, 1)[0], 0.1);
    assert_eq!(moves(&source)[1].path, PathKind::Linear);
    let both = rewritten(&source, &shifted(&source, &[(0, 1e-3), (1, 1e-3)]));
    assert_eq!(both, source.replace("[0.1,", "[0.101000,"));
    let one = rewritten(&source, &shifted(&source, &[(1, 1e-3)]));
    let clone = format!("  global q1 = {Q}\n  global q1_lm1 = {}\n", Q.replace("[0.1,", "[0.101000,"));
    assert!(one.contains(&clone) && one.contains("movej(q1, a=1)\n  movel(q1_lm1, a=1)"), "{one}");
}

#[test]
fn a_list_that_is_read_elsewhere_is_cloned() {
    for reader in ["x = q1[0]", "movej(get_inverse_kin(p[0,0,0,0,0,0], qnear=q1))", "textmsg(q1)"] {
        let source = format!("def p():\n  q1 = {Q}\n  movej(q1)\n  {reader}\nend\n");
        let out = rewritten(&source, &shifted(&source, &[(0, 1e-3)]));
        assert!(out.contains(&format!("q1 = {Q}\n  q1_lm1 = [0.101000,")), "{out}");
    }
}

#[test]
fn a_variable_that_may_hold_something_else_is_not_certain() {
    let other = Q.replace("0.1,", "0.7,");
    let cases = [
        (format!("q1 = {Q}\nwhile a:\n  movej(q1)\n  q1 = {other}\nend\n"), "more than once"),
        (format!("q1 = {Q}\nif a:\n  q1[0] = 2\nend\nmovej(q1)\n"), "element"),
        (format!("if a:\n  q1 = {Q}\nend\nmovej(q1)\n"), "condition"),
        (format!("def p(q1):\n  movej(q1)\nend\nq1 = {Q}\n"), "parameter"),
        ("movej(q9)\n".into(), "not assigned in this file"),
        ("q1 = get_actual_joint_positions()\nmovej(q1)\n".into(), "no list"),
        (format!("def p():\n  q1 = {Q}\n  while b:\n    q1 = {other}\n  end\n  movej(q1)\nend\n"), "more than once"),
        (
            format!("def p():\n  global q1 = {Q}\n  movej(q1)\nend\nthread t():\n  q1 = {other}\nend\n"),
            "more than once",
        ),
    ];
    for (source, why) in cases {
        let all = moves(&source);
        assert!(opaque(all.last().unwrap()).contains(why), "{source}: {}", opaque(all.last().unwrap()));
    }
}

#[test]
fn one_name_in_two_functions_means_two_lists_unless_it_is_global() {
    let source = |qualifier: &str| {
        let other = Q.replace("0.1,", "0.7,");
        format!("def a():\n  {qualifier}q = {Q}\n  movej(q)\nend\ndef b():\n  q = {other}\n  movej(q)\nend\n")
    };
    assert_eq!((joints(&source(""), 0)[0], joints(&source(""), 1)[0]), (0.1, 0.7));
    assert_eq!((joints(&source("global "), 0)[0], joints(&source("global "), 1)[0]), (0.1, 0.7));
    let called = source("global ").replace("movej(q)\nend\ndef b", "b()\n  movej(q)\nend\ndef b");
    assert_eq!((joints(&called, 0)[0], joints(&called, 1)[0]), (0.7, 0.7));
    let local = format!("q = {Q}\ndef b():\n  local q = {}\n  movej(q)\nend\nmovej(q)\n", Q.replace("0.1,", "0.7,"));
    assert_eq!((joints(&local, 0)[0], joints(&local, 1)[0]), (0.7, 0.1));
}

#[test]
fn the_list_behind_qnear_is_no_target() {
    let source = format!(
        "def p():\n  q1 = {Q}\n  movej(get_inverse_kin(p[0.4,0,0.3,0,3.14,0], qnear=q1), a=1)\n  movej(get_inverse_kin(pick, qnear={Q}))\nend\n"
    );
    let all = moves(&source);
    assert!(matches!(&all[0].goal, Goal::Pose(p) if (p.position_m.x - 0.4).abs() < 1e-12));
    assert!(opaque(&all[1]).contains("get_inverse_kin"));
    assert!(document(&source).script().targets.iter().all(|t| t.pose.is_some()));
}

#[test]
fn the_tcp_of_a_pose_is_that_of_set_tcp_or_the_installations() {
    let pose = |before: &str| match &moves(&format!("{before}movel(p[0.4, 0.1, 0.3, 0, 3.14, 0], a=1)\n"))[0].goal {
        Goal::Pose(p) => p.tool.clone(),
        other => panic!("{other:?}"),
    };
    let at = |z: f64| Frame::Given(nalgebra::Isometry3::translation(0.0, 0.0, z));
    assert_eq!(pose(""), Frame::Named("tcp".into()));
    assert_eq!(pose("set_tcp(p[0,0,0,0,0,0])\n"), at(0.0));
    assert_eq!(pose("set_tcp(p[0,0,0.1,0,0,0])\n"), at(0.1));
    assert_eq!(pose("tcp2 = p[0,0,0.2,0,0,0]\nset_tcp(tcp2)\n"), at(0.2));
    // what computes it is asked for, and one of several is known where all are the same
    assert_eq!(pose("set_tcp(tcp1)\n"), Frame::Computed("set_tcp tcp1".into()));
    let twice = "tcp2 = p[0,0,0,0,0,0]\ntcp2 = p[0,0,1,0,0,0]\nset_tcp(tcp2)\n";
    assert_eq!(pose(twice), Frame::Computed("set_tcp tcp2".into()));
    let several = pose("set_tcp(p[0,0,0.1,0,0,0])\nset_tcp(p[0,0,0.2,0,0,0])\n");
    assert_eq!(several, at(0.2));
}

#[test]
fn a_cartesian_move_can_be_written_with_joint_values() {
    let source = "set_tcp(p[0,0,0,0,0,0])\nmovel(p[0.4, 0, 0.3, 0, 3.14, 0], a=1.2, v=0.1)\n";
    let mut edits = Edits { digit: vec![1e-7; 6], ..Edits::default() };
    let point = NewPoint { q: vec![0.2; 6], share: 0.5, t_s: None, clearance_m: 0.1, of_way: false, waits: false };
    edits
        .steps
        .insert(1, Edit { before: vec![point], goal: Some(vec![0.3; 6]), as_joint_moves: true, ..Edit::default() });
    let doc = document(source);
    let out =
        String::from_utf8(text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap().remove(0)).unwrap();
    assert_eq!((joints(&out, 0)[0], joints(&out, 1)[5]), (0.2, 0.3));
    assert!(
        out.contains("movel([0.3000000, 0.3000000, 0.3000000, 0.3000000, 0.3000000, 0.3000000], a=1.2, v=0.1)"),
        "{out}"
    );
}

#[test]
fn calls_over_several_lines_and_texts_with_hashes_pass() {
    let source = format!(
        "def p():\n  popup(\"no # comment: movej([1])\", title=\"a # b\", blocking=True)\n  movej({}, # first\n    a=1.4,\n    v=1)\nend\n",
        Q.replace(", 1.2", ",\n   1.2")
    );
    assert_eq!(moves(&source).len(), 1);
    let out = rewritten(&source, &inserted(&source, 0, &[0.5], 0.01));
    assert!(out.contains("  movej([0.500000, -1.57, 1.2, -2, .5, 3.], a=1.4, v=1)\n  movej([0.1,"), "{out}");
}

#[test]
fn pragmas_and_editor_marks_pass() {
    let source = format!(
        "def p():\n  $ 1 \"BeforeStart\"\n  # lostmotion: off\n  movej({Q})\n  $ 2 \"it's\" \"noBreak\"\nend\n"
    );
    assert_eq!(kinds(&source), ["Start", "pragma false", "move", "Start"]);
}

#[test]
fn text_that_is_no_urscript_is_refused_with_its_place() {
    let cases = [
        ("def p():\n  movej([0,0,0,0,0], a=1)\nend\n", "2:9: found a joint target of 5 numbers"),
        ("def p():\n  movej([0,0,0,0,0,0]\nend\n", "2:8: found `(` that is not closed"),
        ("def p():\n  sync()\n", "1:1: found `def`; expected `end`"),
        ("end\n", "1:1: found `end`"),
        ("while True\nend\n", "1:11: found the end of the line"),
        ("textmsg(\"a)\n", "1:9: found a string"),
        ("movej()\n", "1:1: found `movej`"),
        ("a = \u{1}\n", "1:5: found the character"),
        ("a = 1)\n", "1:6: found `)`"),
        ("def p():\n  {% if CB3 %}\n  halt\n", "2:3: found a mark of a template"),
        ("servoj(q, t=0.008, {{GAIN}})\n", "1:20: found a mark of a template"),
        ("def p():\n  for i in range(3):\n    halt\n  end\nend\n", "2:3: found `for`"),
    ];
    for (source, message) in cases {
        let found =
            harness::parse(&UrScript, source.as_bytes(), &robot()).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(found.contains(message), "{source:?}: {found}");
    }
}

#[test]
fn a_script_is_recognised_by_its_first_line() {
    assert!(UrScript.recognises(b"# x\n\ndef main():\n") && UrScript.recognises(b"movej([0,0,0,0,0,0])\n"));
    assert!(!UrScript.recognises(b"MODULE M\n") && !UrScript.recognises(b"a1_deg\n"));
}

/// Anything that grows with the square of the length would take hours here.
#[test]
fn long_and_deep_files_are_read() {
    let long = format!("def p():\n{}end\n", format!("  movej({Q}, a=1.4, v=1.05, r=0.01)\n").repeat(30_000));
    assert_eq!(document(&long).script().steps.len(), 30_002);
    let blocks = format!("{}{}", "if a: ".repeat(100_000), "end ".repeat(100_000));
    assert!(kinds(&blocks).is_empty());
    let defs = "def a():\n".repeat(1000);
    assert!(harness::parse(&UrScript, defs.as_bytes(), &robot()).is_err());
}

#[test]
fn a_second_statement_on_a_line_is_a_statement_of_its_own() {
    let two = format!("def p():\n movej({Q}) movej([1,2,3,4,5,6], a=1)\n movej({Q}); movej([1,2,3,4,5,6])\nend\n");
    assert_eq!(moves(&two).len(), 4);
    assert_eq!(joints(&two, 1), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    // an expression goes on after a call
    assert_eq!(moves(&format!("def p():\n ready() and movej({Q})\n x = f(1) + 2\n movej({Q})\nend\n")).len(), 1);
    let out = rewritten(&two, &shifted(&two, &[(1, 0.002)]));
    assert!(out.contains(&format!("movej({Q}) movej([1.002")), "{out}");
}

#[test]
fn a_list_that_a_method_changes_is_not_certain() {
    let edited = |line: &str| {
        let source = format!("q = {Q}\n{line}\nmovej(q)\n");
        !matches!(moves(&source)[0].goal, Goal::Opaque(_))
    };
    assert!(edited("n = q.length()") && edited("textmsg(q.slice(0, 2))") && edited("other.pop()"));
    for line in
        ["q.append(0.1)", "n = q.pop()", "q.insert(0, 1.0)", "if q.remove(0) > 1:\n  sleep(1)\nend", "q.clear()"]
    {
        assert!(!edited(line), "{line}");
    }
}

#[test]
fn an_arc_that_keeps_the_tool_to_its_tangent_ends_in_no_known_orientation() {
    let goals = |mode: &str| {
        let arc = format!("movec(p[0.5,0,0.3,0,0,0], p[0.6,0.1,0.3,0,0,0], a=1, v=0.1, r=0{mode})");
        let all = moves(&format!("def p():\n  movel(p[0.4,0,0.3,0,0,0])\n  {arc}\nend\n"));
        all.iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<_>>()
    };
    assert_eq!((goals(""), goals(", mode=0"), goals(", mode=1")), (vec![false; 2], vec![false; 2], vec![false, true]));
}
