//! Which TCP is in force, and what leads the robot, in the order in which functions run.

use super::*;

const AT: &str = "movel(p[0.5,0,0.3,0,3.14,0])\n";
const A: &str = "set_tcp(p[0,0,0.1,0,0,0])\n";
const B: &str = "set_tcp(p[0.05,0,0.25,0.5,0,0])\n";

fn shown(f: &Frame) -> String {
    match f {
        Frame::Named(name) | Frame::Computed(name) => name.clone(),
        Frame::Given(f) => format!("z {:.0}", f.translation.z * 1e3),
        Frame::Any(all) => all.iter().map(shown).collect::<Vec<String>>().join(" or "),
        Frame::Unknown(why) => why.to_string(),
        other => format!("{other:?}"),
    }
}

/// The TCP of each move to a pose.
fn tcps(source: &str) -> Vec<String> {
    let of = |m: &Move| match &m.goal {
        Goal::Pose(p) => Some(shown(&p.tool)),
        _ => None,
    };
    moves(source).iter().filter_map(of).collect()
}

#[test]
fn a_function_that_stands_above_has_not_run() {
    let of = |call: &str| format!("def grip():\n{B}end\ndef main():\n{AT}{call}{AT}end\nmain()\n");
    assert_eq!(tcps(&of("grip()\n")), ["tcp", "z 250"]);
    assert_eq!(tcps(&of("")), ["tcp", "tcp"]);
    // within the function that calls it
    assert_eq!(tcps(&format!("def p():\n def st():\n {B} end\n{AT}st()\n{AT}end\n")), ["tcp", "z 250"]);
    // straight to joint values
    let joints = of("").replace(AT, &format!("movel({Q})\n"));
    let tools: Vec<_> = moves(&joints).iter().map(|m| m.tool.as_deref().map(shown)).collect();
    assert_eq!(tools, [Some("tcp".to_string()), Some("tcp".to_string())]);
}

#[test]
fn a_tcp_that_is_set_in_a_branch_or_further_down_in_a_loop_may_be_in_force() {
    let of = |body: &str| tcps(&format!("def p():\n{body}end\n"));
    assert_eq!(of(&format!("if x:\n{B}end\n{AT}")), ["tcp or z 250"]);
    assert_eq!(of(&format!("if x:\n{B}else:\n{A}end\n{AT}")), ["z 250 or z 100"]);
    assert_eq!(of(&format!("if x:\n{B}else:\n{B}end\n{AT}")), ["z 250"]);
    assert_eq!(of(&format!("if x:\n{B}{AT}end\n{A}{AT}")), ["z 250", "z 100"]);
    assert_eq!(of(&format!("while True:\n{AT}{B}{AT}end\n")), ["tcp or z 250", "z 250"]);
    assert_eq!(of(&format!("{A}while True:\n{AT}end\n")), ["z 100"]);
    assert_eq!(of(&format!("{A}{AT}{B}{AT}")), ["z 100", "z 250"]);
}

#[test]
fn a_function_has_the_tcp_of_those_that_call_it() {
    let of = |main: &str| tcps(&format!("def go():\n{AT}end\ndef main():\n{main}end\nmain()\n"));
    assert_eq!(of(&format!("{A}go()\n")), ["z 100"]);
    assert_eq!(of(&format!("go()\n{A}go()\n")), ["tcp or z 100"]);
    assert_eq!(of("go()\n"), ["tcp"]);
    // one that is never called, and a thread beside
    assert_eq!(of(A), ["tcp or z 100"]);
    assert_eq!(tcps(&format!("thread t():\n{B}end\ndef p():\n{A}run t()\n{AT}end\n")), ["z 250 or z 100"]);
}

#[test]
fn a_tcp_that_is_computed_anew_has_a_name_of_its_own() {
    let two = format!(
        "def p():\ntool=p[0,0,0.15,0,0,0]\nset_tcp(tool)\n{AT}tool=p[0.05,0,0.25,0.5,0,0]\nset_tcp(tool)\n{AT}end\n"
    );
    assert_eq!(tcps(&two), ["set_tcp tool", "set_tcp tool (2)"]);
    let once = format!("def p():\nset_tcp(tool)\n{AT}set_tcp(tool)\n{AT}end\n");
    assert_eq!(tcps(&once), ["set_tcp tool"; 2]);
    let of = |calls: &str| tcps(&format!("def use(t):\nset_tcp(t)\nend\ndef main():\n{calls}end\nmain()\n"));
    assert_eq!(of(&format!("use(a)\n{AT}")), ["set_tcp t"]);
    let why = "a TCP that may be another one each time its function is called";
    assert_eq!(of(&format!("use(a)\n{AT}use(b)\n{AT}")), [why; 2]);
}

#[test]
fn a_function_that_is_called_while_something_leads_the_robot_stays() {
    let j = |v: f64| format!("movej([{v},-1.5,1.2,-1.7,-1.5,0])\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    let on = "force_mode(p[0,0,0,0,0,0],[0,0,1,0,0,0],[0,0,9,0,0,0],2,[1,1,1,1,1,1])\n";
    let subs = format!("def deep():\n{}end\ndef sub():\n{}deep()\nend\ndef other():\n{}end\n", j(0.1), j(0.2), j(0.3));
    let main = format!("def p():\n{}other()\n{on}sub()\nend_force_mode()\n{}end\np()\n", j(0.4), j(0.5));
    assert_eq!(left(&format!("{subs}{main}")), [true, true, false, false, false]);
    let sub = moves(&format!("{subs}{main}"));
    assert!(opaque(&sub[0]).contains("force_mode"), "{}", opaque(&sub[0]));
    // it is on from the second pass on
    let round = format!("def p():\n{}while True:\n{}{}{on}{}end\nend\n", j(0.1), j(0.2), j(0.3), j(0.4));
    assert_eq!(left(&round), [false, true, true, true]);
}

/// Numbers of the moves to `[n,2,3,4,5,6]` that keep their goals, as the program reads where the robot stands.
fn kept(source: &str) -> Vec<usize> {
    let doc = document(source);
    let script = doc.script();
    let of = |m: &Move| {
        let target = script.targets.get(m.goal.target()?)?;
        let first = target.values.iter().next()??;
        m.fixed.is_some().then(|| first.si.round() as usize)
    };
    let mut all: Vec<usize> = script.moves().filter_map(|(_, m)| of(m)).collect();
    all.sort_unstable();
    all
}

#[test]
fn the_move_before_a_reading_of_the_place_is_found_along_control() {
    let [a, b, c, d] = [1, 2, 3, 4].map(|k| format!("movej([{k},2,3,4,5,6])\n"));
    let read = "x = get_actual_tcp_pose()\n";
    let rd = "def rd():\n return get_actual_tcp_pose()\nend\n";
    let sub = format!("def sub():\n{c}{d}end\n");
    let cases: [(&str, &str, String, &[usize]); 9] = [
        ("in the text", "", format!("{a}{b}{read}{c}"), &[2]),
        ("after what is called", &sub, format!("{a}sub()\n{read}{b}"), &[4]),
        ("perhaps called", &sub, format!("{a}if x:\nsub()\nend\n{read}{b}"), &[1, 4]),
        ("in what is called", rd, format!("{a}{b}x = rd()\n{c}"), &[2]),
        ("in the next pass", "", format!("{a}while True:\n{read}{b}{c}end\n"), &[1, 3]),
        ("in the condition of a loop", "", format!("{a}while get_actual_tcp_pose()==x:\n{b}{c}end\n{d}"), &[1, 3]),
        ("in a condition", "", format!("{a}{b}if get_actual_joint_positions()==q:\n x = 1\nend\n{c}"), &[2]),
        ("after both branches", "", format!("{a}if x:\n{b}else:\n{c}end\n{read}{d}"), &[2, 3]),
        ("with a TCP", "", format!("set_tcp(p[0,0,0.1,0,0,0])\n{a}{b}textmsg(get_actual_tcp_pose())\n{c}"), &[]),
    ];
    for (what, above, main, expected) in cases {
        assert_eq!(kept(&format!("{above}def main():\n{main}end\nmain()\n")), expected, "{what}");
    }
}
