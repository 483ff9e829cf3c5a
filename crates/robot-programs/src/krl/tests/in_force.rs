//! Which base and tool are in force, and what leads the robot, where that does not follow from the order of the text.

use super::*;

const AT: &str = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";
const AXES: &str = "PTP {A1 0,A2 -90,A3 90,A4 10,A5 30,A6 0}\n";
pub(super) const B: &str = "{X 100.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}";

fn shown(f: &Frame) -> String {
    match f {
        Frame::Named(name) | Frame::Computed(name) => name.clone(),
        Frame::Null => "null".into(),
        Frame::Given(f) => format!("X {:.0}", f.translation.x * 1e3),
        Frame::Any(all) => all.iter().map(shown).collect::<Vec<String>>().join(" or "),
        Frame::Unknown(why) => why.to_string(),
        Frame::Base => "base".into(),
    }
}

/// Base and tool of each pose, or why a motion stays; nothing of motions to axis values.
pub(super) fn said(src: &str) -> Vec<String> {
    let src = if src.starts_with("DEF ") { src.to_string() } else { format!("DEF a()\n{src}END\n") };
    let dat = "DEFDAT a\nDECL FRAME F1={X 1,Y 2,Z 3,A 0,B 0,C 0}\nDECL INT N=1\nENDDAT\n";
    let d = doc(&[src.as_bytes(), dat.as_bytes()]);
    let of = |m: &Move| match &m.goal {
        Goal::Pose(p) => Some(format!("{}; {}", shown(&p.frame), shown(&p.tool))),
        Goal::Opaque(why) => Some(why.to_string()),
        Goal::Joints(_) => None,
    };
    moves(d.as_ref()).iter().filter_map(|(_, m)| of(m)).collect()
}

#[test]
fn a_base_that_is_set_further_down_in_a_loop_holds_from_the_second_pass_on() {
    let set = format!("$BASE={B}\n{AXES}");
    for (open, close) in
        [("FOR I=1 TO 2", "ENDFOR"), ("WHILE $IN[1]", "ENDWHILE"), ("LOOP", "ENDLOOP"), ("REPEAT", "UNTIL $IN[1]")]
    {
        let src = format!("$TOOL=$NULLFRAME\n{AXES}{open}\n{AT}{set}{AT}{close}\n");
        assert_eq!(said(&src), ["$BASE or X 100; null", "X 100; null"], "{open}");
    }
    let src = format!("$TOOL=$NULLFRAME\n{AXES}AGAIN:\n{AT}{set}GOTO AGAIN\n");
    assert_eq!(said(&src), ["$BASE or X 100; null"]);
    let src = format!("$BASE=$NULLFRAME\n{AXES}FOR I=1 TO 2\n{AT}$TOOL={B}\n{AXES}ENDFOR\n{AT}");
    assert_eq!(said(&src), ["null; $TOOL or X 100", "null; X 100"]);
    // it is the same on every pass
    let src = format!("$TOOL=$NULLFRAME\n$BASE={B}\nFOR I=1 TO 2\n{AT}$BASE={B}\n{AT}ENDFOR\n");
    assert_eq!(said(&src), ["X 100; null"; 2]);
}

#[test]
fn a_routine_has_the_base_of_the_places_that_call_it() {
    let of =
        |main: &str, sub: &str| said(&format!("DEF a()\n$TOOL=$NULLFRAME\n{AXES}{main}END\nDEF B()\n{AXES}{sub}END\n"));
    let set = format!("$BASE={B}\n");
    // the call stands before the setting
    assert_eq!(of(&format!("{AT}B()\n{set}{AXES}"), AT), ["$BASE; null"; 2]);
    assert_eq!(of(&format!("B()\n{set}B()\n"), AT), ["$BASE or X 100; null"]);
    assert_eq!(of(&format!("{set}B()\n"), AT), ["X 100; null"]);
    // it leaves behind what it sets
    assert_eq!(of(&format!("{AT}B()\n{AT}"), &set), ["$BASE; null", "X 100; null"]);
    assert_eq!(of(&format!("B()\n{AT}"), &format!("IF $IN[1] THEN\n{set}ENDIF\n")), ["$BASE or X 100; null"]);
    // and nothing where it sets none
    assert_eq!(of(&format!("B()\n{AT}{set}B()\n{AT}"), ""), ["$BASE; null", "X 100; null"]);
    // one that the file does not call
    assert_eq!(of(&format!("{AT}{set}{AXES}"), AT), ["$BASE; null", "$BASE or X 100; $TOOL or null"]);
}

#[test]
fn what_a_block_without_motions_sets_is_not_forgotten_after_it() {
    let after = |open: &str, set: &str, close: &str| {
        said(&format!("$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n{AXES}{open}\n{set}\n{close}\n{AT}")).remove(0)
    };
    for (open, close) in
        [("IF $IN[1] THEN", "ENDIF"), ("WHILE $IN[1]", "ENDWHILE"), ("LOOP\nEXIT\nENDLOOP\nIF $IN[1] THEN", "ENDIF")]
    {
        assert_eq!(after(open, "$IPO_MODE=#TCP", close), "$IPO_MODE is set; null", "{open}");
        assert_eq!(after(open, "$WORLD={X 100,Y 0,Z 0,A 0,B 0,C 0}", close), "$WORLD is set; null", "{open}");
        let turns = after(open, "$ORI_TYPE=#CONSTANT", close);
        assert!(turns.starts_with("$ORI_TYPE"), "{open}: {turns}");
        assert_eq!(after(open, "$OUT[1]=TRUE", close), "null; null", "{open}");
        assert_eq!(after(open, "$BASE=$NULLFRAME", close), "null; null", "{open}");
        assert_eq!(after(open, &format!("$BASE={B}"), close), "null or X 100; null", "{open}");
    }
    assert_eq!(after("IF $IN[1] THEN", "$IPO_MODE=#TCP\nELSE\n$IPO_MODE=#BASE", "ENDIF"), "$IPO_MODE is set; null");
}

#[test]
fn a_routine_that_is_called_while_something_leads_the_robot_stays() {
    // of motions to axis values: which stay
    let left = |src: &str| {
        let d = doc(&[src.as_bytes()]);
        moves(d.as_ref()).iter().map(|(_, m)| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>()
    };
    for (on, off, why) in [
        ("RSI_ON(#RELATIVE)", "RSI_OFF()", "a sensor (RSI_ON)"),
        ("$TECH[1].MODE=#CYCLE", "$TECH[1].MODE=#OFF", "a function generator ($TECH)"),
        ("CONVEYOR.FOLLOW(#C1,1,1)", "CONVEYOR.QUIT(#C1)", "a conveyor"),
    ] {
        let subs = format!("DEF SUB()\n{AXES}{AXES}DEEP()\nEND\nDEF DEEP()\n{AXES}END\nDEF OTHER()\n{AXES}END\n");
        let src = format!("DEF a()\n{AXES}OTHER()\n{on}\nSUB()\n{off}\n{AXES}END\n{subs}");
        assert_eq!(left(&src), [false, false, true, true, true, false], "{on}");
        let d = doc(&[src.as_bytes()]);
        let reason = moves(d.as_ref()).iter().find_map(|(_, m)| match &m.goal {
            Goal::Opaque(why) => Some(why.to_string()),
            _ => None,
        });
        assert_eq!(reason, Some(format!("{why} leads the robot away from its points")));
    }
}

/// Lines of the motions and of the breaks of frames, which are negative.
pub(super) fn breaks(src: &str) -> Vec<i64> {
    let d = doc(&[src.as_bytes()]);
    let of = |s: &crate::script::Step| match s.kind {
        StepKind::Move(_) => Some(s.at.line as i64),
        StepKind::Break(Break::Frame) => Some(-(s.at.line as i64)),
        _ => None,
    };
    d.script().steps.iter().filter_map(of).collect()
}

#[test]
fn a_computed_base_is_another_one_after_each_assignment_of_what_it_is_computed_from() {
    let named = |src: &str| {
        said(&format!("$TOOL=$NULLFRAME\n{src}")).iter().map(|s| s.replace("; null", "")).collect::<Vec<String>>()
    };
    let index = format!("N=1\n$BASE=BASE_DATA[N]\n{AT}N=2\n$BASE=BASE_DATA[N]\n{AT}");
    assert_eq!(named(&index), ["BASE_DATA[N]", "BASE_DATA[N] (2)"]);
    assert_eq!(breaks(&format!("DEF a()\n{index}END\n")), [-2, 4, -5, 7]);
    let element = format!("BASE_DATA[1].X=100\nBAS(#BASE,1)\n{AT}BASE_DATA[1].X=400\nBAS(#BASE,1)\n{AT}");
    assert_eq!(named(&element), ["1 as the program sets it", "1 as the program sets it (2)"]);
    assert_eq!(breaks(&format!("DEF a()\n{element}END\n")), [-2, 4, -5, 7]);
    let frame = format!("$BASE=F1\n{AT}F1.X=F1.X+300\n$BASE=F1\n{AT}");
    assert_eq!(named(&frame), ["F1", "F1 (2)"]);
    assert_eq!(breaks(&format!("DEF a()\n{frame}END\n")), [3, -4, 6]);
    let part = format!("$BASE={B}\n$BASE.X=200\n{AT}$BASE={}\n$BASE.X=200\n{AT}", B.replace("Y 0.0", "Y 5.0"));
    assert_eq!(named(&part), ["X set to 200", "X set to 200 (2)"]);
    assert_eq!(breaks(&format!("DEF a()\n{part}END\n")), [-3, 4, -6, 7]);
    // one that is set once has its plain name
    assert_eq!(named(&format!("N=1\n$BASE=BASE_DATA[N]\n{AT}$BASE=BASE_DATA[N]\n{AT}")), ["BASE_DATA[N]"; 2]);
    assert_eq!(named(&format!("BASE_DATA[1].X=100\nBAS(#BASE,1)\n{AT}")), ["1 as the program sets it"]);
    // other elements, and another frame
    assert_eq!(
        named(&format!("BASE_DATA[1].X=1\nBAS(#BASE,1)\n{AT}BASE_DATA[7].X=1\nF1.X=2\nBAS(#BASE,1)\n{AT}")),
        ["1 as the program sets it"; 2]
    );
}

#[test]
fn a_computed_base_is_another_one_after_a_routine_that_assigns_what_it_is_computed_from() {
    let of =
        |sub: &str| format!("DEF a()\n$TOOL=$NULLFRAME\n$BASE=F1\n{AT}SUB()\n$BASE=F1\n{AT}END\nDEF SUB()\n{sub}END\n");
    assert_eq!(said(&of("F1.X=300\n")), ["F1; null", "F1 (2); null"]);
    assert_eq!(said(&of("$OUT[1]=TRUE\n")), ["F1; null"; 2].map(|s| s.replace("F1", "X 1")));
    assert_eq!(breaks(&of("F1.X=300\n")), [4, -5, 7, -10]);
    // perhaps: either
    assert_eq!(said(&of("IF $IN[1] THEN\nF1.X=300\nENDIF\n"))[1], "F1 or F1 (2); null");
    // a part of what is not certain
    let part = said(&format!("$TOOL=$NULLFRAME\nIF $IN[1] THEN\n$BASE={B}\nENDIF\n$BASE.X=5\n{AT}"));
    assert_eq!(part, ["a base or tool of which it is not certain what was assigned last; null"]);
}

#[test]
fn a_local_routine_is_entered_from_its_calls() {
    let joins = |before: &str, head: &str, after: &str| {
        let src = format!("DEF a()\n{before}PTP {{A1 1.0}}\npart( )\nEND\n{head}\nPTP {{A1 5.0}}\nEND\n{after}");
        let d = doc(&[src.as_bytes()]);
        let starts = |k: &usize| matches!(d.script().steps[*k].kind, StepKind::Break(Break::Start));
        d.script().joins.iter().filter(|j| starts(&j.at)).map(|j| j.from.clone()).collect::<Vec<_>>()
    };
    assert_eq!(joins("", "DEF part( )", ""), [vec![2]]);
    for (before, head, after) in [
        ("", "GLOBAL DEF part( )", ""),
        ("INTERRUPT DECL 3 WHEN $IN[1] DO part( )\n", "DEF part( )", ""),
        ("", "DEF part( )", "DEF part( )\nEND\n"),
        ("", "DEF part( )", "DEF b()\nRESUME\nEND\n"),
        ("n=f(part( ))\n", "DEF part( )", ""),
    ] {
        assert_eq!(joins(before, head, after), Vec::<Vec<usize>>::new(), "{before}{head}{after}");
    }
}
