//! Jobs and moves that are not for this compensator to change.

use super::*;
use crate::inform::Reason;
use crate::script::{Script, Text};

const LIST: &str = "///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,-2000,300,0,-500,622\n\
                    C00002=2000,-2000,300,0,-500,622";

fn three(instructions: &str) -> String {
    job("3,0,0,0,0,0", LIST, instructions)
}

fn fixed(script: &Script) -> Vec<bool> {
    moves(script).iter().map(|m| m.1.fixed.is_some()).collect()
}

#[test]
fn a_job_that_counts_its_moves_takes_none_and_keeps_those_that_it_reads() {
    let three_moves = "MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\nMOVJ C00002 VJ=25.00";
    let text = three(&format!("GETPOS PX000 STEP#(2)\n{three_moves}"));
    let robot = robot();
    let script = script_of(&Inform, &text, &robot);
    let found = moves(&script);
    assert!(
        found.iter().all(|m| m.1.closed.as_ref().is_some_and(|why| why.to_string().contains("STEP#"))),
        "{found:?}"
    );
    assert_eq!(fixed(&script), [false, true, false]);
    assert!(script.notes.iter().any(|n| n.text.contains("move 2 stays") && n.place.line > 9), "{:?}", script.notes);
    let point = edit(&robot, &[(1, None, vec![[1.0; 6]])]);
    assert!(matches!(edited(&Inform, text.as_bytes(), &point, &robot), Err(Error::Refused(_))));
    // others are edited
    let out = written(&text, &[(3, Some([2007.0, -2000.0, 300.0, 0.0, -500.0, 622.0]), vec![])]);
    assert_eq!(out, text.replace("C00002=2000", "C00002=2007"));
    // a number that is set at run time may be any
    let text = three(&format!("{three_moves}\nGETPOS PX000 STEP#(I000)"));
    assert_eq!(fixed(&script_of(&Inform, &text, &robot)), [true; 3]);
    // a comment counts nothing
    let text = three(&format!("'GETPOS PX000 STEP#(2)\n{three_moves}"));
    let script = script_of(&Inform, &text, &robot);
    assert!(script.notes.is_empty() && moves(&script).iter().all(|m| m.1.closed.is_none()));
}

#[test]
fn a_job_of_another_group_than_the_first_robot_is_left() {
    let text = three("MOVJ C00000 VJ=25.00\nMOVL C00001 V=50.0");
    for (group, named) in [("RB2", "RB2"), ("ST1", "ST1"), ("RB2,BS2", "RB2")] {
        let other = text.replace("///GROUP1 RB1", &format!("///GROUP1 {group}"));
        let script = script_of(&Inform, &other, &robot());
        for (_, m) in moves(&script) {
            let wanted = Reason::ForeignGroup(named.into()).into();
            assert!(matches!(&m.goal, Goal::Opaque(why) if *why == wanted), "{m:?}");
        }
    }
    for group in ["RB1", "RB1,BS1", "RB1\r\n///GROUP2 ST1"] {
        let own = text.replace("///GROUP1 RB1", &format!("///GROUP1 {group}"));
        let goals = moves(&script_of(&Inform, &own, &robot()));
        assert!(goals.iter().all(|m| matches!(m.1.goal, Goal::Joints(_))), "{group}");
    }
    // its positions may have other numbers than the robot has axes
    let station = job("1,0,0,0,0,0", "///POSTYPE PULSE\n///PULSE\nC00000=100", "MOVJ C00000 VJ=25.00");
    let station = station.replace("///GROUP1 RB1", "///GROUP1 ST1");
    assert_eq!(moves(&script_of(&Inform, &station, &robot())).len(), 1);
}

#[test]
fn a_position_variable_that_the_job_sets_in_any_spelling_is_not_known() {
    let list = format!("{LIST}\nP00105=1000,-2000,300,0,-500,622");
    let goal = |line: &str| {
        let text = job("3,0,0,1,0,0", &list, &format!("MOVJ C00000 VJ=25.00\n{line}\nMOVJ P105 VJ=25.00"));
        moves(&script_of(&Inform, &text, &robot()))[1].1.clone()
    };
    let untouched = goal("SET P001 P002");
    assert!(matches!(untouched.goal, Goal::Joints(_)) && untouched.fixed.is_none(), "{untouched:?}");
    for line in
        ["SETE P105(3) D000", "SET P105,P001", "GETS PX105//x", "CLEAR P100 10", "CLEAR ALL", "*L1 SETE P105(1) D000"]
    {
        assert!(matches!(goal(line).goal, Goal::Opaque(_)), "{line}");
    }
    // a job that is not there may set it: from which place the next move comes is not known
    assert!(matches!(goal("JUMP JOB:GONE IF IN#(1)=ON").goal, Goal::Opaque(_)));
}

#[test]
fn a_frame_or_tool_that_the_job_sets_is_not_the_one_that_is_given() {
    let list = "///USER 1\n///TOOL 2\n///POSTYPE USER\n///RECTAN\n///RCONF 1,0,0,0,0,0,0,0\nC00000=900.000,0.000,300.000,180.00,0.00,0.00\n\
                C00001=900.000,200.000,300.000,180.00,0.00,0.00\nC00002=900.000,100.000,300.000,180.00,0.00,0.00";
    let of = |line: &str| {
        let text =
            job("3,0,0,0,0,0", list, &format!("MOVJ C00000 VJ=25.00\n{line}\nMOVL C00001 V=10.0\nMOVL C00002 V=10.0"));
        let script = script_of(&Inform, &text, &robot());
        let goals = moves(&script).into_iter().map(|(_, m)| match m.goal {
            Goal::Pose(p) => (format!("{:?}", p.frame), format!("{:?}", p.tool)),
            other => panic!("{other:?}"),
        });
        let ends = script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Frame))).count();
        (goals.collect::<Vec<_>>(), ends)
    };
    let (own, none) = of("TIMER T=1.00");
    assert!(none == 0 && own.iter().all(|g| !g.0.contains("sets") && !g.1.contains("sets")));
    for line in ["MFRAME UF#(1) PX000 PX001 PX002", "SET UF#(1) P001", "MFRAME UF#(I000) C00000 C00001 C00002"] {
        let (goals, ends) = of(line);
        assert!(
            ends == 1 && goals.iter().all(|g| g.0.contains("as the job sets it") && !g.1.contains("sets")),
            "{line}: {goals:?}"
        );
    }
    let (goals, ends) = of("SETTOOL TL#(2) P001");
    assert!(
        ends == 1 && goals.iter().all(|g| g.1.contains("as the job sets it") && !g.0.contains("sets")),
        "{goals:?}"
    );
    for line in ["MFRAME UF#(3) PX000 PX001 PX002", "SETTOOL TL#(0) P001", "CNVRT PX000 PX001 UF#(1)"] {
        assert_eq!(of(line).0, own, "{line}");
    }
}

#[test]
fn moves_on_a_conveyor_or_with_soft_servos_stay() {
    for (on, off) in [("SYSTART CV#(1) STP=0 PL=1", "SYEND CV#(1)"), ("FLOATON FL#(1)", "FLOATOF")] {
        let text = three(&format!("MOVJ C00000 VJ=25.00\n{on}\nMOVJ C00001 VJ=25.00\n{off}\nMOVJ C00002 VJ=25.00"));
        let script = script_of(&Inform, &text, &robot());
        let left: Vec<bool> = moves(&script).iter().map(|m| matches!(m.1.goal, Goal::Opaque(_))).collect();
        assert_eq!(left, [false, true, false], "{on}");
    }
}

#[test]
fn a_move_after_which_the_job_reads_its_place_keeps_its_goal() {
    let moves = "MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00";
    let text = three(&format!("{moves}\nGETS PX010 $PX000\nMOVJ C00002 VJ=25.00"));
    assert_eq!(fixed(&script_of(&Inform, &text, &robot())), [false, true, false]);
    let text = three(&format!("{moves}\nGETS B010 $B000\nMOVJ C00002 VJ=25.00"));
    assert_eq!(fixed(&script_of(&Inform, &text, &robot())), [false; 3]);
}

#[test]
fn the_move_before_a_reading_of_the_place_is_found_along_control() {
    let to = |k: usize| format!("MOVJ C0000{k} VJ=25.00\n");
    let [a, b, c] = [0, 1, 2].map(to);
    let read = "GETS PX010 $PX000\n";
    let cases = [
        (format!("{a}*L\n{read}{b}{c}JUMP *L"), [true, false, true]),
        (format!("{a}WHILE I000<3\n{read}{b}ENDWHILE\n{c}"), [true, true, false]),
        (format!("{a}JUMP *L IF I000=1\n{b}*L\n{read}{c}"), [true, true, false]),
        (format!("{read}{a}{b}{c}"), [false, false, true]),
    ];
    for (lines, kept) in cases {
        assert_eq!(fixed(&script_of(&Inform, &three(lines.trim_end()), &robot())), kept, "{lines}");
    }
    // in a job that is called, also two calls deep
    let lines = format!("{a}{b}CALL JOB:SUB\n{c}");
    for sub in [read.trim_end(), "CALL JOB:DEEP"] {
        let beside = [("SUB", sub), ("DEEP", read.trim_end())];
        assert_eq!(fixed(&script_beside(&three(lines.trim_end()), &beside)), [false, true, false], "{sub}");
    }
}

#[test]
fn a_corner_whose_size_is_computed_stays_and_takes_no_points() {
    let text = three("MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00 PL=I001\nMOVL C00002 V=50.0 CR=LD001");
    for (_, m) in moves(&script_of(&Inform, &text, &robot())).iter().skip(1) {
        assert!(m.closed.as_ref().is_some_and(|why| why.to_string().contains("computed")), "{m:?}");
    }
    let goal = [1007.0, -2000.0, 300.0, 0.0, -500.0, 622.0];
    let mut edits = edit(&robot(), &[(2, Some(goal), vec![]), (3, None, vec![])]);
    for step in [2, 3] {
        edits.steps.change(step, |e| e.blend_at_most_m = Some(0.6));
    }
    let out = edited(&Inform, text.as_bytes(), &edits, &robot()).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), text.replace("C00001=1000,", "C00001=1007,"));
}

/// The script of a job with others beside it: their names and instructions.
fn script_beside(own: &str, beside: &[(&str, &str)]) -> Script {
    let mut texts = vec![Text::new("TEST.JBI", own.as_bytes().to_vec())];
    texts.extend(beside.iter().map(|(name, lines)| {
        let job = job("0,0,0,0,0,0", "", lines).replace("//NAME TEST", &format!("//NAME {name}"));
        Text::of_context(format!("{name}.JBI"), job.into_bytes())
    }));
    Inform.parse(texts, &robot()).unwrap().script().clone()
}

#[test]
fn what_a_called_job_leaves_on_leads_the_robot_after_the_call() {
    let calls = "MOVJ C00000 VJ=25.00\nCALL JOB:SUB\nMOVJ C00001 VJ=25.00\nCALL JOB:STOP\nMOVJ C00002 VJ=25.00";
    let left = |lines: &str, sub: &str| {
        let beside = [("SUB", sub), ("STOP", "SFTOF\nFLOATOF"), ("DEEP", "FLOATON FL#(1)")];
        let script = script_beside(&three(lines), &beside);
        moves(&script).iter().map(|m| matches!(m.1.goal, Goal::Opaque(_))).collect::<Vec<bool>>()
    };
    for (sub, expected) in [
        ("SFTON P001", [false, true, false]),
        ("WVON WEV#(1)", [false, true, true]),
        ("SFTON P001\nSFTOF", [false; 3]),
        ("WVON WEV#(1)\nRET IF B000=1\nWVOF", [false, true, true]),
        ("JUMP *OVER IF B000=1\nWVON WEV#(1)\n*OVER", [false, true, true]),
        ("CALL JOB:DEEP", [false, true, false]),
        ("CALL JOB:DEEP IF B000=1", [false, true, false]),
        ("SET B000 1\nJUMP JOB:DEEP", [false, true, false]),
    ] {
        assert_eq!(left(calls, sub), expected, "{sub}");
    }
    // whether the end is called is not certain
    let perhaps = "SFTON P001\nMOVJ C00000 VJ=25.00\nCALL JOB:STOP IF B000=1\nMOVJ C00001 VJ=25.00";
    assert_eq!(left(perhaps, "NOP"), [true, true]);
}

#[test]
fn a_frame_that_a_called_job_sets_is_not_the_one_that_is_given() {
    let list = "///USER 1\n///TOOL 2\n///POSTYPE USER\n///RECTAN\n///RCONF 1,0,0,0,0,0,0,0\nC00000=900.000,0.000,300.000,180.00,0.00,0.00";
    let own = job("1,0,0,0,0,0", list, "CALL JOB:SUB\nMOVJ C00000 VJ=25.00");
    let frames = |sub: &str| {
        let beside = [("SUB", sub), ("DEEP", "SETTOOL TL#(2) P001"), ("OTHER", "MFRAME UF#(1) PX000 PX001 PX002")];
        match &moves(&script_beside(&own, &beside))[0].1.goal {
            Goal::Pose(p) => [&p.frame, &p.tool].map(|f| format!("{f:?}").contains("as the job sets it")),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(frames("MFRAME UF#(1) PX000 PX001 PX002"), [true, false]);
    assert_eq!(frames("CALL JOB:DEEP"), [false, true]);
    assert_eq!(frames("MFRAME UF#(3) PX000 PX001 PX002"), [false, false]);
}
