//! Every trap of URScript programs that we know of.

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
    let point = |share: &f64| NewPoint { q: q.clone(), share: *share, t_s: None, clearance_m, of_way: false };
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
    let cases = [
        (format!("q1 = {Q}\nmovej(q1)\nq1 = {Q}\n"), "more than once"),
        (format!("q1 = {Q}\nq1[0] = 2\nmovej(q1)\n"), "element"),
        (format!("if a:\n  q1 = {Q}\nend\nmovej(q1)\n"), "condition"),
        (format!("def p(q1):\n  movej(q1)\nend\nq1 = {Q}\n"), "parameter"),
        ("movej(q9)\n".into(), "not assigned in this file"),
        ("q1 = get_actual_joint_positions()\nmovej(q1)\n".into(), "no list"),
        (format!("def p():\n  q1 = {Q}\n  while True:\n    q1 = {Q}\n  end\n  movej(q1)\nend\n"), "more than once"),
        (format!("def p():\n  global q1 = {Q}\n  movej(q1)\nend\nthread t():\n  q1 = {Q}\nend\n"), "more than once"),
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
    assert!(opaque(&moves(&source("global "))[0]).contains("more than once"));
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
    assert_eq!(pose("set_tcp(tcp1)\n"), Frame::Named("set_tcp tcp1".into()));
    let twice = "tcp2 = p[0,0,0,0,0,0]\ntcp2 = p[0,0,1,0,0,0]\nset_tcp(tcp2)\n";
    assert_eq!(pose(twice), Frame::Named("set_tcp tcp2".into()));
    let several = pose("set_tcp(p[0,0,0.1,0,0,0])\nset_tcp(p[0,0,0.2,0,0,0])\n");
    assert_eq!(several, Frame::Any(vec![at(0.1), at(0.2)]));
}

#[test]
fn a_new_point_has_the_call_of_its_move_and_a_blend_that_fits() {
    let source = format!("def p():\n\tmovej({Q}, a=1.4, v=speed, r=0.05)\nend\n");
    let out = |clearance_m| rewritten(&source, &inserted(&source, 0, &[0.5], clearance_m));
    let copy = Q.replace("[0.1,", "[0.500000,");
    assert!(
        out(0.01)
            .contains(&format!("\tmovej({copy}, a=1.4, v=speed, r=0.00100)\n\tmovej({Q}, a=1.4, v=speed, r=0.05)")),
        "{}",
        out(0.01)
    );
    assert!(out(0.000_456).contains("r=0.00045)"));
    assert!(out(1e-7).contains("r=0)"));
}

#[test]
fn a_copy_of_an_exact_stop_stops() {
    let source = format!("movej({Q}, a=1.4, v=1)\nmovej({Q}, 1.4, 1, 0, 0.0)\n");
    assert_eq!(moves(&source)[1].blend_m, Some(0.0));
    let out = rewritten(&source, &inserted(&source, 1, &[0.5], 0.01));
    assert!(out.contains(", 1.4, 1, 0, 0.0)\nmovej([0.1,"), "{out}");
}

#[test]
fn the_moves_own_blend_is_shrunk_where_it_is_asked_for() {
    let source = format!("rad = 0.03\nmovej({Q}, r=0.05)\nmovej({Q}, r=rad)\nmovej({Q}, r=other)\n");
    let with = |n: usize, most: f64| {
        let mut edits = shifted(&source, &[(n, 0.0)]);
        edits.steps.retain(|_, e| {
            e.blend_at_most_m = Some(most);
            true
        });
        edits
    };
    assert!(rewritten(&source, &with(0, 0.012_345_6)).contains("r=0.01234)"));
    assert!(rewritten(&source, &with(1, 0.01)).contains("r=0.01000)"));
    assert_eq!(rewritten(&source, &with(0, 0.06)), source);
    assert!(document(&source).patches(&with(2, 0.01)).is_err());
}

#[test]
fn a_time_is_shared_out_and_overrides_the_speed() {
    let source = format!("movej({Q}, a=1, v=1, t=2)\n");
    assert_eq!(moves(&source)[0].speed, Speed::Seconds(2.0));
    let out = rewritten(&source, &inserted(&source, 0, &[0.25], 0.01));
    assert!(out.contains("t=0.50000)\n") && out.ends_with("t=1.50000)\n"), "{out}");
    assert_eq!(moves(&format!("movej({Q}, a=1, v=0.7, t=0)\n"))[0].speed, Speed::Joint(0.7));
    assert_eq!(moves(&format!("movel({Q})\n"))[0].speed, Speed::Tcp(0.25));
    assert!(moves(&format!("movej({Q}, t=t1)\n"))[0].closed.is_some());
}

#[test]
fn a_stream_of_set_points_keeps_its_time() {
    let source = format!("servoj({Q}, 0, 0, 0.1, 0.1, 300)\nservoj({Q}, t=0.008, lookahead_time=0.1)\nservoj({Q})\n");
    let all = moves(&source);
    assert_eq!((all[0].speed, all[1].speed), (Speed::Seconds(0.1), Speed::Seconds(0.008)));
    assert!(all[0].closed.is_none() && all[1].closed.is_some() && all[2].closed.is_some());
    let out = rewritten(&source, &inserted(&source, 0, &[0.0, 0.5], 0.01));
    let times: f64 = out.lines().take(3).map(|l| l.split(", ").nth(8).unwrap().parse::<f64>().unwrap()).sum();
    assert!((times - 0.1).abs() < 1e-9, "{out}");
    // three legs of 8 ms and more
    assert!(out.lines().take(3).all(|l| l.split(", ").nth(8).unwrap().parse::<f64>().unwrap() >= 0.008), "{out}");
}

#[test]
fn what_cannot_take_new_points_says_why() {
    let cases = [
        ("movec(p[0,0,0,0,0,0], p[1,0,0,0,0,0], a=1, mode=1)".to_string(), "arc"),
        ("movec(p[0,0,0,0,0,0], p[1,0,0,0,0,0], 1, 0.25, 0, m)".to_string(), "arc"),
        ("movec(elsewhere, p[1,0,0,0,0,0])".to_string(), "arc"),
        (format!("if a: movej({Q}) end"), "line"),
        ("speedj([0.1,0,0,0,0,0], 0.5, 1)".into(), "velocity"),
    ];
    for (source, why) in cases {
        assert!(moves(&source)[0].closed.as_ref().unwrap().contains(why), "{source}");
    }
}

#[test]
fn a_cartesian_move_can_be_written_with_joint_values() {
    let source = "set_tcp(p[0,0,0,0,0,0])\nmovel(p[0.4, 0, 0.3, 0, 3.14, 0], a=1.2, v=0.1)\n";
    let mut edits = Edits { digit: vec![1e-7; 6], ..Edits::default() };
    let point = NewPoint { q: vec![0.2; 6], share: 0.5, t_s: None, clearance_m: 0.1, of_way: false };
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
fn branches_loops_threads_calls_and_frames_end_what_is_known() {
    let m = format!("movej({Q})");
    let source = format!(
        "def p():\n set_tcp(p[0,0,0,0,0,0])\n while True:\n  {m}\n  if a:\n   {m}\n  elif b:\n   {m}\n  else:\n   {m}\n  end\n end\n foreign(1)\n x = other(2)\n t = run th()\nend\n"
    );
    let expected = [
        "Start",
        "Frame",
        "Loop",
        "move",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "Loop",
        "Call",
        "Call",
        "Interrupt",
        "Call",
        "Start",
    ];
    assert_eq!(kinds(&source), expected);
}

#[test]
fn a_thread_that_may_move_is_said() {
    let m = format!("movej({Q})");
    let source = |body: &str| format!("thread t():\n {body}\nend\ndef p():\n h = run t()\n {m}\nend\n");
    let said = |source: &str| {
        let d = document(source);
        d.script().notes.iter().any(|n| n.text.starts_with("t may move the robot while the program waits or moves"))
    };
    assert!(said(&source(&m)));
    assert!(!said(&source("set_digital_out(1, True)")));
}

#[test]
fn what_does_not_move_ends_nothing() {
    let m = format!("movej({Q})");
    let source = format!(
        "def grip(n):\n set_digital_out(n, True)\n sleep(0.3)\nend\ndef p():\n {m}\n sleep(0.5)\n sync()\n grip(1)\n if get_digital_in(1):\n  textmsg(\"x\")\n  return True\n end\n while not ready():\n  sync()\n end\n x = sin(1) + norm(y)\n socket_send_string(\"a\", \"s\")\n {m}\nend\ndef ready():\n return get_digital_in(2)\nend\n"
    );
    let steps = kinds(&source);
    assert_eq!(
        steps[..9],
        ["Start", "dwell Some(0.3)", "Start", "Start", "move", "dwell Some(0.5)", "dwell None", "dwell None", "move"],
        "{steps:?}"
    );
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
fn a_target_is_not_reached_while_forces_or_a_conveyor_lead_the_robot() {
    let pairs = [
        ("force_mode(p[0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,5,0,0,0], 2, [1,1,1,1,1,1])", "end_force_mode()"),
        ("track_conveyor_linear(p[0,1,0,0,0,0], 2000.0)", "stop_conveyor_tracking(a=15)"),
        ("path_offset_enable()", "path_offset_disable(a=20)"),
    ];
    for (on, off) in pairs {
        let all = moves(&format!("movej({Q})\n{on}\nmovel({Q})\nmovel(p[0.1,0.2,0.3,0,0,0])\n{off}\nmovej({Q})\n"));
        assert!(matches!(all[0].goal, Goal::Joints(_)) && matches!(all[3].goal, Goal::Joints(_)), "{on}");
        let name = on.split('(').next().unwrap();
        assert!(all[1..3].iter().all(|m| opaque(m).contains(name)), "{on}");
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
fn a_straight_move_is_not_stopped_on_its_way_and_ends_as_it_did() {
    for (call, copy) in [
        (format!("movel({Q}, a=1.2, v=0.25)"), ", a=1.2, v=0.25, r=0.00100)"),
        (format!("movel({Q}, 1.2, 0.25, 0, 0)"), ", 1.2, 0.25, 0, 0.00100)"),
        (format!("movep({Q}, 1.2, # slowly\n    v=0.25)"), ", 1.2, v=0.25, r=0.00100)"),
    ] {
        let source = format!("{call}\n");
        let out = rewritten(&source, &inserted(&source, 0, &[0.5], 0.02));
        assert!(out.lines().next().unwrap().ends_with(copy), "{out}");
        assert!(out.ends_with(&source), "{out}");
    }
    // no corner fits, and a joint move that stops exactly
    let source = format!("movel({Q}, a=1.2, v=0.25)\n");
    assert!(!rewritten(&source, &inserted(&source, 0, &[0.5], 1e-6)).contains("r="));
    let source = format!("movej({Q}, a=1.2, v=0.25)\n");
    assert!(!rewritten(&source, &inserted(&source, 0, &[0.5], 0.02)).contains("r="));
}

#[test]
fn what_a_function_of_the_file_leads_away_stays_behind_its_call() {
    let j = |v: f64| format!("  movej([{v},-1.5,1.2,-1.7,-1.5,0])\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    let on = "def press():\n  push()\nend\ndef push():\n  force_mode(p[0,0,0,0,0,0],[0,0,1,0,0,0],[0,0,9,0,0,0],2,[1,1,1,1,1,1])\nend\n";
    let off = "def release():\n  end_force_mode()\nend\n";
    let main = format!("def main():\n{}  press()\n{}  release()\n{}end\n", j(0.1), j(0.2), j(0.3));
    assert_eq!(left(&format!("{on}{off}{main}")), [false, true, false]);
    assert_eq!(left(&format!("{main}{off}{on}")), [false, true, false]);
    // a branch may be passed by
    for branch in ["  if a:\n    release()\n  end\n", "  if a:\n    press()\n  else:\n    release()\n  end\n"] {
        let main = format!("def main():\n  press()\n{branch}{}  release()\n{}end\n", j(0.1), j(0.2));
        assert_eq!(left(&format!("{main}{off}{on}")), [true, false], "{branch}");
    }
}

#[test]
fn a_tcp_that_a_function_below_sets_may_be_in_force_in_one_above() {
    let above =
        "def go():\n  movel(p[0.5,0,0.3,0,3.14,0])\nend\ndef main():\n  set_tcp(p[0,0,0.1,0,0,0])\n  go()\nend\n";
    let Goal::Pose(p) = &moves(above)[0].goal else { panic!() };
    assert!(matches!(&p.tool, Frame::Any(all) if all.len() == 2), "{:?}", p.tool);
    let own = "def main():\n  movel(p[0.5,0,0.3,0,3.14,0])\n  set_tcp(p[0,0,0.1,0,0,0])\nend\n";
    let Goal::Pose(p) = &moves(own)[0].goal else { panic!() };
    assert!(matches!(&p.tool, Frame::Named(n) if n == "tcp"), "{:?}", p.tool);
}

#[test]
fn a_movec_is_split_into_arcs() {
    let source = "  via = p[0.1, 0.2, 0.3, 0, 3.1, 0]\n  movec(via, p[0.5, 0, 0.3, 0, 3.2, 0], a=1.2, v=0.1)\n";
    let (step, m) = {
        let doc = document(source);
        let (step, m) = doc.script().moves().next().unwrap();
        (step, m.clone())
    };
    assert_eq!((m.closed.as_deref(), m.blend_m), (None, Some(0.0)));
    let q = |x: f64| vec![x, 0.0, 0.3, 0.0, 3.2, 0.0];
    let point = |x, share| NewPoint { q: q(x), share, t_s: None, clearance_m: 0.01, of_way: false };
    let vias = vec![vec![0.1, 0.04, 0.3], vec![0.2, 0.05, 0.31], vec![0.3, 0.051, 0.3]];
    let edit =
        Edit { before: vec![point(0.41, 0.3), point(0.42, 0.4)], goal: Some(q(0.5001)), vias, ..Edit::default() };
    let edits = |edit: Edit| Edits { steps: [(step, edit)].into(), pose_digit: [1e-7, 1e-6], ..Edits::default() };
    let out = rewritten(source, &edits(edit.clone()));
    let piece = |via: &str, x: &str, r: &str| {
        format!("  movec(p[{via}, 0, 3.2, 0], p[{x}, 0, 0.3, 0, 3.2, 0], a=1.2, v=0.1{r})\n")
    };
    let pieces = [
        piece("0.1000000, 0.0400000, 0.3", "0.4100000", ", r=0.00100"),
        piece("0.2000000, 0.0500000, 0.3100000", "0.4200000", ", r=0.00100"),
        piece("0.3000000, 0.0510000, 0.3", "0.5001000", ""),
    ];
    assert_eq!(out.replace("0.0000000", "0"), source.lines().next().unwrap().to_string() + "\n" + &pieces.concat());
    let doc = document(source);
    assert!(doc.patches(&edits(Edit { vias: Vec::new(), ..edit })).is_err());
    // the point on the way alone
    let alone = rewritten(source, &edits(Edit { vias: vec![vec![0.11, 0.2, 0.3]], ..Edit::default() }));
    assert_eq!(alone, source.replace("movec(via", "movec(p[0.1100000, 0.2000000, 0.3, 0, 3.2, 0]"));
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
fn a_move_after_which_the_program_reads_its_place_keeps_its_goal() {
    let fixed = |line: &str| {
        let source = format!("def p():\n movej({Q})\n movej([1,2,3,4,5,6])\n {line}\n movej({Q})\nend\n");
        moves(&source).iter().map(|m| m.fixed.is_some()).collect::<Vec<_>>()
    };
    for line in ["here = get_actual_tcp_pose()", "q = get_target_joint_positions()", "p1 = get_forward_kin()"] {
        assert_eq!(fixed(line), [false, true, false], "{line}");
    }
    for line in ["p1 = get_forward_kin([1,2,3,4,5,6])", "textmsg(get_actual_tcp_pose())"] {
        assert_eq!(fixed(line), [false; 3], "{line}");
    }
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
