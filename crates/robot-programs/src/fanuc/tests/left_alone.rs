//! Moves that stay as they are: something else than the program leads the robot, or a position is not known.

use super::lines::of_lines;
use super::*;
use crate::fanuc::Reason;

/// Why the goals of motions cannot be determined; empty: they can.
fn left(text: &str) -> Vec<String> {
    let why = |m: &Move| match &m.goal {
        Goal::Opaque(why) => why.to_string(),
        _ => String::new(),
    };
    moves(doc(text.as_bytes()).as_ref()).iter().map(|(_, m)| why(m)).collect()
}

#[test]
fn behind_a_search_nobody_knows_where_the_robot_stands() {
    let text = of_lines(
        "   1:J P[1] 100% FINE    ;\n   2:L P[2] 50mm/sec FINE Search[-Z]    ;\n   3:L P[3] 50mm/sec FINE    ;",
    );
    assert_eq!(left(&text), ["", "a search ends where it touches", ""]);
    let d = doc(text.as_bytes());
    let last = d.script().steps.iter().rposition(|s| matches!(s.kind, StepKind::Move(_))).unwrap();
    assert!(matches!(d.script().steps[last - 1].kind, StepKind::Break(Break::Jump)));
}

#[test]
fn motions_that_an_option_leads_otherwise_stay_and_wjnt_takes_no_points() {
    let of = |line: &str| of_lines(&format!("   1:J P[1] 100% FINE    ;\n   2:{line}    ;"));
    for option in ["RTCP", "MROT", "COORD"] {
        let left = left(&of(&format!("L P[2] 100mm/sec FINE {option}")));
        assert!(left[1].starts_with(option) && left[0].is_empty(), "{left:?}");
    }
    let closed = |line: &str| moves(doc(of(line).as_bytes()).as_ref())[1].1.closed.clone();
    assert_eq!(closed("L P[2] 100mm/sec FINE Wjnt"), Some(Reason::WristByJoint.into()));
    assert_eq!((closed("J P[2] 100% FINE Wjnt"), closed("L P[2] 100mm/sec FINE")), (None, None));
    let way = |line: &str| moves(doc(of(line).as_bytes()).as_ref())[1].1.other_way;
    assert_eq!(way("L P[2] 100mm/sec FINE Wjnt"), Some(OtherWay::Wrist));
    assert_eq!((way("J P[2] 100% FINE Wjnt"), way("L P[2] 100mm/sec FINE")), (None, None));
}

#[test]
fn a_coordinated_motion_is_known_where_the_group_that_leads_stands_still() {
    let of = |leader: [f64; 2]| {
        let mut text = of_lines(
            "   1:J P[1] 100% FINE    ;
   2:L P[2] 50mm/sec FINE COORD    ;",
        );
        for (k, deg) in leader.into_iter().chain([leader[0]]).enumerate() {
            let at = text.find(&format!("P[{}]{{", k + 1)).unwrap();
            let end = at + text[at..].find("};").unwrap();
            text.insert_str(end, &format!("   GP2:\n\tUF : 0, UT : 1,\n\tJ1=   {deg:.3} deg\n"));
        }
        text
    };
    assert_eq!(left(&of([10.0, 10.0])), ["", ""]);
    let found = moves(doc(of([10.0, 10.0]).as_bytes()).as_ref())[1].1.closed.clone();
    assert_eq!(found, Some(Reason::Coordinated.into()));
    assert!(left(&of([10.0, 20.0]))[1].starts_with("COORD"));
    // no position says where it stands
    let text = of_lines("   1:J P[1] 100% FINE    ;\n   2:L P[2] 50mm/sec FINE COORD    ;");
    assert!(left(&text)[1].starts_with("COORD"));
}

#[test]
fn motions_while_weaving_or_tracking_or_soft_stay() {
    for (on, off) in [
        ("Weave Sine[1]", "Weave End"),
        ("Weave[1]", "Weave End[1]"),
        ("Track TAST[1]", "Track End"),
        ("Track {TAST,AVC}[1]", "Track End"),
        ("SOFTFLOAT[1]", "SOFTFLOAT END"),
        ("MP OFFSET PR[11] RPM[R[1]]", "MP OFFSET END"),
        ("Touch Offset PR[32]", "Touch Offset End"),
    ] {
        let text = of_lines(&format!(
            "   1:J P[1] 100% FINE    ;\n   2:  {on} ;\n   3:L P[2] 50mm/sec FINE    ;\n   4:  {off} ;\n   5:L P[3] 50mm/sec FINE    ;"
        ));
        let left: Vec<bool> = left(&text).iter().map(|w| !w.is_empty()).collect();
        assert_eq!(left, [false, true, false], "{on}");
    }
}

#[test]
fn what_a_branch_ends_that_may_be_passed_by_goes_on() {
    let left = |lines: &str| {
        let lines: Vec<String> = lines.lines().enumerate().map(|(k, l)| format!("{:4}:{l} ;", k + 1)).collect();
        left(&of_lines(&lines.join("\n"))).iter().map(|w| w.contains("leads the robot away")).collect::<Vec<bool>>()
    };
    let (j, l) = ("J P[1] 100% FINE", "L P[2] 50mm/sec FINE");
    for (lines, expected) in [
        // past the end
        (format!("  Weave Sine[1]\n{j}\n  IF R[1]=1,JMP LBL[1]\n  Weave End\n  LBL[1]\n{l}"), vec![true, true]),
        (format!("  Weave Sine[1]\n  IF (R[1]=1) THEN\n  Weave End\n{j}\n  ENDIF\n{l}"), vec![false, true]),
        (
            format!("  SELECT R[1]=1,JMP LBL[1]\n  Track TAST[1]\n{j}\n  LBL[1]\n{l}\n  Track End\n{j}"),
            vec![true, true, false],
        ),
        // back to before the begin
        (format!("  LBL[1]\n{j}\n  Weave Sine[1]\n{l}\n  JMP LBL[1]"), vec![true, true]),
        (format!("  FOR R[1]=1 TO 3\n{j}\n  SOFTFLOAT[1]\n{l}\n  ENDFOR\n{j}"), vec![true, true, true]),
        (format!("  LBL[1]\n{j}\n  Weave Sine[1]\n{l}\n  Weave End\n  JMP LBL[1]"), vec![false, true]),
        // each ends its own
        (format!("  Weave Sine[1]\n  Track TAST[1]\n  Weave End\n{l}\n  Track End\n{l}"), vec![true, false]),
        // begun by whoever called
        (format!("{l}\n  Weave End\n{l}"), vec![true, false]),
    ] {
        assert_eq!(left(&lines), expected, "{lines}");
    }
}

#[test]
fn a_program_of_line_tracking_stays_and_schedule_0_is_none() {
    let of = |n: &str| {
        of_lines("   1:J P[1] 100% FINE    ;\n   2:L P[2] 50mm/sec FINE    ;")
            .replace("/MN", &format!("/APPL\n\nLINE_TRACK;\n  LINE_TRACK_SCHEDULE_NUMBER      : {n};\n/MN"))
    };
    assert!(left(&of("1")).iter().all(|w| w.contains("conveyor")));
    assert!(left(&of("0")).iter().all(String::is_empty));
}

/// Why the goals of the motions of numbered lines stay, in a program with others beside it; and the tool of each Cartesian one.
fn left_beside(lines: &str, beside: &[(&str, &str)]) -> Vec<String> {
    let numbered = |lines: &str| {
        let lines: Vec<String> = lines.lines().enumerate().map(|(k, l)| format!("{:4}:{l} ;", k + 1)).collect();
        lines.join("\n")
    };
    let mut texts = vec![Text::new("p.ls", of_lines(&numbered(lines)).into_bytes())];
    texts.extend(beside.iter().map(|(name, lines)| {
        let program = format!("/PROG  {name}\n/ATTR\n/MN\n{}\n/POS\n/END\n", numbered(lines));
        Text::of_context(format!("{name}.LS"), program.into_bytes())
    }));
    let d = Fanuc.parse(texts, &m10ia()).unwrap();
    let why = |m: &Move| match &m.goal {
        Goal::Opaque(why) => why.to_string(),
        _ => String::new(),
    };
    moves(d.as_ref()).iter().map(|(_, m)| why(m)).collect()
}

#[test]
fn what_a_called_program_leaves_on_leads_the_robot_after_the_call() {
    let (j, l) = ("J P[1] 100% FINE", "L P[2] 50mm/sec FINE");
    let left = |lines: &str, beside: &[(&str, &str)]| {
        left_beside(lines, beside).iter().map(|w| w.contains("leads the robot away")).collect::<Vec<bool>>()
    };
    let calls = format!("{j}\n  CALL SUB\n{l}\n  CALL STOP\n{l}");
    for (sub, expected) in [
        ("  SOFTFLOAT[1]", [false, true, false]),
        ("  IF R[1]=1,JMP LBL[1]\n  Weave Sine[1]\n  LBL[1]", [false, true, true]),
        ("  Weave Sine[1]\n  END\n  Weave End", [false, true, true]),
        ("  Weave Sine[1]\n  Weave End", [false, false, false]),
        ("  CALL DEEP", [false, true, false]),
        ("  IF R[1]=1,CALL DEEP", [false, true, false]),
    ] {
        let beside = [("SUB", sub), ("STOP", "  SOFTFLOAT END\n  Track End"), ("DEEP", "  Track TAST[1]")];
        assert_eq!(left(&calls, &beside), expected, "{sub}");
    }
    // whether the end is called is not certain
    let perhaps = format!("  SOFTFLOAT[1]\n{j}\n  IF R[1]=1,CALL STOP\n{l}");
    assert_eq!(left(&perhaps, &[("STOP", "  SOFTFLOAT END")]), [true, true]);
}

#[test]
fn a_position_that_the_program_may_teach_is_not_known_wherever_it_does_so() {
    let lines = |teaches: &str| format!("J P[1] 100% FINE\n{teaches}\nJ P[2] 100% FINE\nJ P[3] 100% FINE");
    let left = |teaches: &str| {
        let left = left_beside(&lines(teaches), &[]);
        left.iter().map(|why| why.contains("the program writes")).collect::<Vec<bool>>()
    };
    for any in ["  P[R[1]]=LPOS", "  P[R[1:at]]=PR[2]", "  IF (DI[1]),P[R[1]]=JPOS", "  P[AR[1]]=LPOS"] {
        assert_eq!(left(any), [true, true, true], "{any}");
    }
    for second in ["  P[2]=LPOS", "  P[2:a]=PR[R[1]]", "  IF (DI[1]),P[2]=LPOS", "  IF (DI[1]=ON),P[2:a]=PR[3]"] {
        assert_eq!(left(second), [false, true, false], "{second}");
    }
    assert_eq!(left("  PR[1]=P[2]"), [false, false, false]);
    // on the way of a motion
    let nested = of_lines(
        "   1:J P[1] 100% FINE DB 10.0mm {\n    :  P[2]=PR[4] ;\n    : } ;\n   2:J P[2] 100% FINE    ;\n   3:J P[3] 100% FINE    ;",
    );
    let left: Vec<bool> = self::left(&nested).iter().map(|why| why.contains("the program writes")).collect();
    assert_eq!(left[left.len() - 2..], [true, false]);
}
