//! Branches, threads, calls and frames: what ends what is known, and what does not.

use super::*;

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
fn a_tcp_that_a_function_below_sets_is_in_force_in_one_above_that_it_calls() {
    let above =
        "def go():\n  movel(p[0.5,0,0.3,0,3.14,0])\nend\ndef main():\n  set_tcp(p[0,0,0.1,0,0,0])\n  go()\nend\n";
    let Goal::Pose(p) = &moves(above)[0].goal else { panic!() };
    assert!(matches!(&p.tool, Frame::Given(_)), "{:?}", p.tool);
    let own = "def main():\n  movel(p[0.5,0,0.3,0,3.14,0])\n  set_tcp(p[0,0,0.1,0,0,0])\nend\n";
    let Goal::Pose(p) = &moves(own)[0].goal else { panic!() };
    assert!(matches!(&p.tool, Frame::Named(n) if n == "tcp"), "{:?}", p.tool);
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
fn a_function_begins_where_its_calls_stand_if_all_of_them_are_in_the_text() {
    let joins = |main: &str| {
        let source = format!("def go():\n movej({Q})\nend\ndef m():\n movej({Q})\n{main}end\nm()\n");
        let doc = document(&source);
        let start = 0;
        assert_eq!(harness::kinds(doc.script())[start], "Start");
        let join = doc.script().joins.iter().find(|j| j.at == start);
        join.map_or(0, |j| j.from.len())
    };
    assert_eq!((joins(" go()\n"), joins(&format!(" go()\n movej({Q})\n go()\n"))), (1, 2));
    // as a condition, in a thread, or never called
    assert_eq!((joins(" go()\n if go():\n sync()\n end\n"), joins(" run t()\n go()\n"), joins("")), (0, 0, 0));
    assert_eq!(joins(" go()\n x = go()\n"), 0);
    // with what a program starts nothing leads to it
    let doc = document(&format!("def m():\n movej({Q})\nend\nm()\n"));
    assert!(doc.script().joins.iter().all(|j| j.at != 0));
}

/// What calls the program again leads to its start, as the end of RAPID's `main` does.
#[test]
fn the_program_is_reached_from_its_other_calls_too() {
    let body = format!("def prog():\n  movej({Q})\n  movej({Q})\n");
    for (rest, moves_before) in [
        ("end\nprog()\n", vec![]),
        ("end\nprog()\nprog()\n", vec![2]),
        ("end\nwhile True:\n  prog()\nend\n", vec![2]),
        ("  prog()\nend\nprog()\n", vec![2]),
    ] {
        let doc = document(&format!("{body}{rest}"));
        let script = doc.script();
        let again = script.again.as_ref().map(|join| join.from.clone()).unwrap_or_default();
        let moves = |until: usize| script.moves().take_while(|(k, _)| *k < until).count();
        // what stands before each of them, where it is a move
        let steps =
            |k: &usize| script.steps.get(k.checked_sub(1)?).map(|s| matches!(s.kind, crate::script::StepKind::Move(_)));
        let known: Vec<usize> = again.iter().filter(|k| steps(k) == Some(true)).map(|k| moves(*k)).collect();
        assert_eq!(known, moves_before, "{rest}: {again:?} {:?}", script.joins);
    }
}

/// PolyScope programs define their functions and threads at the beginning of the one with which they start.
#[test]
fn what_calls_the_program_leads_to_its_first_move_where_functions_are_defined_before_it() {
    let moves = format!("  movej({Q})\n  movej({Q})\nend\n");
    for inner in [
        format!("  def f():\n    movej({Q})\n  end\n"),
        "  def f():\n    set_digital_out(1, True)\n  end\n".into(),
        "  thread t():\n    while True:\n      sync()\n    end\n  end\n".into(),
        "  x = 1\n  def f():\n    def g():\n      sync()\n    end\n  end\n  def h():\n    sync()\n  end\n".into(),
    ] {
        for calls in ["while True:\n  prog()\nend\n", "prog()\nprog()\n"] {
            let source = format!("def prog():\n{inner}{moves}{calls}");
            let doc = document(&source);
            let script = doc.script();
            let is_move =
                |k: usize| matches!(script.steps.get(k).map(|s| &s.kind), Some(crate::script::StepKind::Move(_)));
            let again = script.again.as_ref().unwrap_or_else(|| panic!("{source}"));
            assert_eq!(Some(again.at), script.entry, "{source}");
            // its first move follows, and its last one leads there
            let last = script.moves().last().map(|(k, _)| k + 1);
            assert!(is_move(again.at + 1) && again.from.iter().any(|k| Some(*k) == last), "{source}: {again:?}");
        }
    }
}
