//! Lines of a program: which of them belong together, what moves besides motions, where the known direction ends.

use super::*;

/// A program of these lines, with three positions.
pub(super) fn of_lines(lines: &str) -> String {
    let position = |n: usize, j1: &str| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1=    {j1} deg,\tJ2=    10.000 deg,\tJ3=    10.000 deg,\n\
             \tJ4=     0.000 deg,\tJ5=    90.000 deg,\tJ6=     0.000 deg\n}};\n"
        )
    };
    let positions: String =
        ["10.000", "20.000", "30.000"].iter().enumerate().map(|(i, v)| position(i + 1, v)).collect();
    let count = lines.lines().count();
    format!("/PROG  OWN\n/ATTR\nLINE_COUNT\t= {count};\n/MN\n{lines}\n/POS\n{positions}/END\n")
}

#[test]
fn a_position_that_an_offset_an_increment_or_an_unknown_option_moves_too_is_never_changed_in_place() {
    let fixed = ["Offset,PR[1]", "Tool_Offset,PR[2]", "INC", "Elsewhere", "VOFFSET,VR[1]"];
    let others = fixed.iter().map(|o| format!("L P[1] 100mm/sec FINE {o}"));
    for other in others.chain(["J P[R[1]] 100% FINE".to_string(), "C P[R[1]]    :  P[2] 50mm/sec FINE".to_string()]) {
        let text = of_lines(&format!("   1:J P[1] 100% FINE    ;\n   2:J P[3] 100% FINE    ;\n   3:{other}    ;"));
        let d = doc(text.as_bytes());
        let k = moves(d.as_ref())[0].0;
        let after = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(k, 0.5)], &[])).as_ref());
        assert!(after.contains("   1:J P[4] 100% FINE    ;"), "{after}");
        assert!(
            after.contains(&format!("   3:{other}    ;"))
                && after.contains("P[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1=    10.000 deg")
        );
    }
}

#[test]
fn motions_of_palletizing_are_moves_that_stay() {
    let lines = "   1:J P[1] 50% FINE ;\n   2:  PALLETIZING-B_3 ;\n   3:J PAL_3[A_1] 50% FINE ;\n   4:L PAL_3[BTM] 100mm/sec FINE ;\n   \
                 5:L PAL_3[R_1] 100mm/sec CNT50 ;\n   6:  PALLETIZING-END_3 ;\n   7:L P[2] 100mm/sec FINE ;";
    let d = doc(of_lines(lines).as_bytes());
    let moves = moves(d.as_ref());
    let stays = |m: &Move| matches!(&m.goal, Goal::Opaque(why) if why.to_string().contains("palletizing"));
    assert_eq!(moves.iter().map(|(_, m)| stays(m)).collect::<Vec<_>>(), [false, true, true, true, false]);
}

#[test]
fn a_register_that_is_set_is_another_offset_from_there_on() {
    let sets = |line: &str| {
        let lines = format!("   1:L P[1] 100mm/sec FINE Offset,PR[12]    ;\n   2:  {line} ;");
        let d = doc(of_lines(&lines).as_bytes());
        let names = d.script().steps.iter().filter_map(|s| match &s.kind {
            StepKind::Sets(name) => Some(name.to_string()),
            _ => None,
        });
        names.collect::<Vec<_>>()
    };
    assert_eq!(sets("PR[12,1]=PR[12,1]+50"), ["pr[12"]);
    assert_eq!(sets("PR[12:UP]=LPOS"), ["pr[12"]);
    assert_eq!(sets("PR[R[1],3]=R[2]"), ["pr"]);
    assert!(sets("R[1]=PR[12,1]").is_empty() && sets("!PR[12]=LPOS").is_empty());
    let d = doc(of_lines("   1:L P[1] 100mm/sec FINE    ;\n   2:  PR[12]=LPOS ;").as_bytes());
    assert!(!d.script().steps.iter().any(|s| matches!(s.kind, StepKind::Sets(_))), "no goal is moved by it");
}

#[test]
fn a_macro_whose_name_begins_like_an_input_or_a_register_ends_the_known_direction() {
    let breaks = |line: &str| {
        let d = doc(of_lines(&format!("   1:  {line} ;\n   2:J P[1] 100% FINE    ;")).as_bytes());
        let steps = &d.script().steps;
        steps.iter().filter(|s| matches!(s.kind, StepKind::Break(_))).count() - 1
    };
    for line in [
        "GO HOME",
        "R HOME",
        "DO SERVICE",
        "PAYLOAD WEIGH",
        "MESSAGE",
        "LOCK GRIPPER",
        "WEAVE HOME",
        "OVERRIDE TEST",
        "R_HOME",
    ] {
        assert_eq!(breaks(line), 1, "{line}");
    }
    for line in [
        "DO[1]=ON",
        "R[1:count]=R[1:count]+1",
        "TIMER[1]=START",
        "OVERRIDE=50%",
        "PAYLOAD[1]",
        "MESSAGE[READY]",
        "LOCK PREG",
        "LINEAR_MAX_SPEED=100",
        "Weave Sine[1]",
        "$WAITTMOUT=100",
    ] {
        assert_eq!(breaks(line), 0, "{line}");
    }
}

#[test]
fn a_line_without_its_end_never_takes_the_next_statement_in() {
    let first = refusal(of_lines(":!no number\n:UFRAME_NUM=0\n:J P[1] 100% FINE;\n:J P[2] 100% FINE;").as_bytes());
    assert!(first.contains("p.ls:6:") || first.contains("UFRAME_NUM"), "{first}");
    for lines in [
        ":UFRAME_NUM=0\n:J P[1] 100% FINE;",
        "    :UFRAME_NUM=0\n    :J P[1] 100% FINE;",
        "   1:UFRAME_NUM=0\n:J P[1] 100% FINE;",
        "   1:UFRAME_NUM=0\n    :J P[1] 100% FINE;",
        "   1:UFRAME_NUM=0\n   2:J P[1] 100% FINE;",
    ] {
        let message = refusal(of_lines(lines).as_bytes());
        assert!(message.contains("p.ls:5:") && message.contains("`:UFRAME_NUM=0`"), "{lines}\n{message}");
    }
    let d =
        doc(of_lines("   1:J P[1] 100% FINE\n    :  ACC80 TB .10sec,DO[1]=ON    ;\n   2:J P[2] 100% FINE    ;")
            .as_bytes());
    assert_eq!(moves(d.as_ref()).len(), 2);
    let d = doc(of_lines(":UFRAME_NUM=0;\n:J P[1] 100% FINE;\n:J P[2] 100% FINE;").as_bytes());
    assert_eq!(moves(d.as_ref()).len(), 2);
}

#[test]
fn tabs_and_six_decimals_stay() {
    let text = of_lines("   1:J P[1] 100% FINE    ;\n   2:J P[2] 100% FINE    ;")
        .replace("J1=    10.000 deg", "J1=\t10.000000\tdeg")
        .replace("J1=    20.000 deg", "J1= \t9.9 deg");
    let d = doc(text.as_bytes());
    let m = moves(d.as_ref());
    let by = [(m[0].0, 0.012_345_6), (m[1].0, 0.25)];
    let mut fine = edits(d.as_ref(), &by, &[]);
    fine.digit = vec![1e-6_f64.to_radians(); 6];
    let after = self::text(rewrite(d.as_ref(), &fine).as_ref());
    assert!(after.contains("\tJ1=\t10.012346\tdeg,\tJ2=    10.012 deg"), "{after}");
    assert!(after.contains("\tJ1= \t10.150 deg,\t"), "{after}");
    let coarse = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &by[..1], &[])).as_ref());
    assert!(coarse.contains("J1=\t10.012346\tdeg"), "{coarse}");
}

#[test]
fn a_new_line_keeps_the_speed_of_the_process() {
    for speed in ["PSPD50", "PSPD R[5]", "ACC80 PSPD120"] {
        let text = of_lines(&format!("   1:J P[1] 100% FINE {speed} TA .10sec,DO[1]=ON    ;"));
        let d = doc(text.as_bytes());
        let k = moves(d.as_ref())[0].0;
        let after = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[k])).as_ref());
        assert!(after.contains(&format!("   1:J P[4] 100% FINE {speed}    ;\n   2:J P[1]")), "{after}");
    }
}

#[test]
fn german_words_for_actions_tools_and_loads_are_known() {
    let d = doc(of_lines(
        "   1:  BENUTZER_NUM=0 ;\n   2:  WKZ_NUM=1 ;\n   3:  TRAGLST[1] ;\n   4:J P[1] 100% CNT0 ACC100 ZEIT VOR    .10sek,P-SPS    ;\n\
         \x20     1:  A[23]=AUS ;\n       ------ ;\n   5:  A[80]=AN ;\n   6:J P[2] 100% FINE ZEIT NACH    .10sek,AUFRUF AUF    ;\n\
         \x20  7:J P[3] 100% CNT100 WEG VOR    0.0mm,A[1]=AN    ;\n   8:  WARTE    .20(sek) ;\n   9:  MRK[1] ;\n  10:J P[1] 100% FINE ;\n\
         \x2011:  WENN R[1]=1,SPRUNG MRK[1] ;",
    )
    .as_bytes());
    let m = moves(d.as_ref());
    assert!(m.iter().all(|m| matches!(m.1.goal, Goal::Joints(_))), "{m:?}");
    assert!(m.iter().all(|m| m.1.closed.is_none()), "{m:?}");
    let starts: Vec<Option<f64>> = m.iter().map(|m| m.1.end_trigger.as_ref().map(|t| t.time_s)).collect();
    assert_eq!(starts, [Some(0.1), None, None, None], "a time before the end of a joint motion");
    let breaks: Vec<Break> =
        d.script().steps.iter().filter_map(|s| if let StepKind::Break(b) = s.kind { Some(b) } else { None }).collect();
    assert_eq!(breaks, [Break::Start, Break::Call, Break::Jump]);
    assert!(d.script().steps.iter().any(|s| matches!(s.kind, StepKind::Dwell(Some(s)) if s == 0.2)));
    let after = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[2].0])).as_ref());
    assert!(
        after.contains("   7:J P[4] 100% CNT0    ;\n   8:J P[3] 100% CNT100 WEG VOR    0.0mm,A[1]=AN    ;"),
        "{after}"
    );
}

#[test]
fn a_remark_may_go_on_over_any_number_of_lines() {
    for more in ["", "    :  second\n", "    :  second\n    :  third\n", "    :  second\n    :  third\n    :  last ;\n"]
    {
        let end = if more.is_empty() { "    ;" } else { "" };
        let text =
            of_lines(&format!("   1:  !first{end}\n{more}   2:J P[1] 100% FINE    ;\n   3:J P[2] 100% FINE    ;"));
        let d = doc(text.as_bytes());
        assert_eq!(moves(d.as_ref()).len(), 2, "{text}");
        let k = moves(d.as_ref())[1].0;
        let after = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[k])).as_ref());
        assert!(after.contains(more) && after.contains("   4:J P[2] 100% FINE    ;"), "{after}");
    }
}

#[test]
fn blank_statements_are_passed_over() {
    for blank in ["   2:", "   2:  ", "   2:  ;", "   2:\n    ;"] {
        let text = of_lines(&format!("   1:J P[1] 100% FINE    ;\n{blank}\n   3:J P[2] 100% FINE    ;"));
        assert_eq!(moves(doc(text.as_bytes()).as_ref()).len(), 2, "{text}");
    }
    // a statement whose end stands on the next line
    let text = of_lines("   1:J P[1] 100% FINE\n    ;\n   2:J P[2] 100% FINE    ;");
    assert_eq!(moves(doc(text.as_bytes()).as_ref()).len(), 2);
}

#[test]
fn a_frame_that_a_system_variable_sets_ends_the_known_direction_and_so_does_a_macro_named_wait() {
    let kinds = |line: &str| {
        let text = of_lines(&format!("   1:J P[1] 100% FINE    ;\n   2:  {line} ;\n   3:J P[2] 100% FINE    ;"));
        harness::kinds(doc(text.as_bytes()).script())[2].clone()
    };
    for (line, kind) in [
        ("$MNUFRAME[1,1]=PR[1]", "Frame"),
        ("$MNUTOOL[1,R[2]]=PR[1]", "Frame"),
        ("STOP_TRACKING", "Frame"),
        ("WAIT HOME", "Call"),
        ("DO[1]=ON,CALL HOME", "Call"),
        ("PAUSE ROBOT", "Call"),
        ("WAIT   .50(sec)", "dwell Some(0.5)"),
        ("WAIT DI[1]=ON", "dwell None"),
        ("WAIT (F[1])", "dwell None"),
        ("WAIT R[1]", "dwell None"),
        ("PAUSE", "dwell None"),
        ("$WAITTMOUT=200", "move"),
    ] {
        assert_eq!(kinds(line), kind, "{line}");
    }
}

#[test]
fn a_motion_after_which_the_program_reads_its_place_keeps_its_goal() {
    for (line, kept) in [
        ("PR[5]=LPOS", true),
        ("PR[5:place] = JPOS", true),
        ("P[9]=LPOS", true),
        ("PR[5]=PR[2]+LPOS", true),
        ("PR[5]=PR[2]-JPOS", true),
        ("FOR R[1]=1 TO LPOS", true),
        ("R[1]=$SCR_GRP[1].$MCH_POS_X", true),
        ("IF $SCR_GRP[1].$MCH_POS_Z>=100,JMP LBL[1]", true),
        ("R[1]=$MOR_GRP[1].$CURRENT_ANG[2]", true),
        ("PR[5]=LPOS-LPOS", false),
        ("PR[5]=JPOS-JPOS", false),
        ("PR[5:LPOS]=P[1]", false),
        ("R[1]=R[2]", false),
        ("!PR[5]=LPOS", false),
    ] {
        let text = of_lines(&format!(
            "   1:J P[1] 100% FINE    ;\n   2:J P[2] 100% FINE    ;\n   3:  {line} ;\n   4:J P[1] 100% FINE    ;"
        ));
        let d = doc(text.as_bytes());
        let fixed: Vec<bool> = d.script().moves().map(|(_, m)| m.fixed.is_some()).collect();
        assert_eq!(fixed, [false, kept, false], "{line}");
    }
}

#[test]
fn the_motion_before_a_reading_of_the_place_is_found_along_control() {
    let of = |lines: &[&str]| -> Vec<bool> {
        let numbered = lines.iter().enumerate().map(|(k, line)| match line.starts_with('J') {
            true => format!("{:4}:{line} 100% FINE    ;", k + 1),
            false => format!("{:4}:  {line} ;", k + 1),
        });
        let d = doc(of_lines(&numbered.collect::<Vec<String>>().join("\n")).as_bytes());
        d.script().moves().map(|(_, m)| m.fixed.is_some()).collect()
    };
    let cases: [(&[&str], &[bool]); 4] = [
        (&["J P[1]", "LBL[1]", "PR[5]=LPOS", "J P[2]", "JMP LBL[1]"], &[true, true]),
        (
            &["J P[1]", "FOR R[1]=1 TO 3", "PR[5]=LPOS", "J P[2]", "J P[1]", "ENDFOR", "J P[2]"],
            &[true, false, true, false],
        ),
        (&["J P[1]", "IF R[1]=1,JMP LBL[1]", "J P[2]", "LBL[1]", "PR[5]=JPOS", "J P[1]"], &[true, true, false]),
        // when the program is run again
        (&["PR[5]=LPOS", "J P[1]", "J P[2]"], &[false, true]),
    ];
    for (lines, kept) in cases {
        assert_eq!(of(lines), kept, "{lines:?}");
    }
}

#[test]
fn a_remark_that_stands_after_the_end_of_a_statement_is_passed_over() {
    let text = of_lines(
        "   1:J P[1] 100% FINE    ; ! to the place\n   2:  WAIT DI[1]=ON ; ! \u{10c}ek\u{e1}\n   3:   ; !\n   4:  !HOME ? ; ! start\n   5:J P[2] 100% FINE    ;",
    );
    let d = doc(text.as_bytes());
    assert_eq!(harness::kinds(d.script())[1..], ["move", "dwell None", "move"]);
}
