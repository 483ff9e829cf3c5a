//! Branches, calls, traps, processes and searches: what ends what is known, and what does not.

use super::*;

#[test]
fn branches_loops_labels_calls_handlers_and_interrupts_end_what_is_known() {
    let move_ = "MoveAbsJ j1,v100,fine,tool0;";
    let source = program(
        J,
        &format!(
            "IF x=1 THEN\n{move_}\nELSE\n{move_}\nENDIF\nWHILE TRUE DO\n{move_}\nENDWHILE\nTEST n\nCASE 1,2:\n{move_}\nDEFAULT:\n{move_}\nENDTEST\nlab:\nGOTO lab;\nElsewhere;\n%\"proc\"+s%;\nCONNECT i1 WITH tr;\nISignalDI d,1,i1;\nPDispOn p1,tool0;\nERROR\nRETRY;"
        ),
    );
    let expected = [
        "Start",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "Loop",
        "move",
        "Loop",
        "Jump",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "Jump",
        "Jump",
        "Call",
        "Call",
        "Interrupt",
        "Interrupt",
        "Frame",
        "Start",
        "Jump",
    ];
    assert_eq!(kinds(&source), expected);
}

#[test]
fn a_trap_that_may_move_is_said() {
    let trap = |body: &str| {
        program(J, "CONNECT i1 WITH tr;").replace("ENDMODULE", &format!("TRAP tr\n{body}\nENDTRAP\nENDMODULE"))
    };
    let said = |source: &str| {
        let d = document(source);
        d.script().notes.iter().any(|n| n.text.starts_with("tr may move the robot while the program waits or moves"))
    };
    assert!(said(&trap("MoveAbsJ j1,v10,fine,tool0;")));
    assert!(!said(&trap("Set d1;")));
    assert!(!said(&program(J, "CONNECT i1 WITH elsewhere;")));
}

#[test]
fn an_error_handler_that_moves_and_goes_back_is_said() {
    let said = |handler: &str| {
        let d = document(&program(J, &format!("MoveAbsJ j1,v10,fine,tool0;\nERROR\n{handler}")));
        d.script().notes.iter().any(|n| n.text.starts_with("the error handler before "))
    };
    assert!(said("MoveAbsJ j1,v10,fine,tool0;\nRETRY;") && said("MoveAbsJ j1,v10,fine,tool0;\nTRYNEXT;"));
    assert!(!said("Set d1;\nRETRY;") && !said("MoveAbsJ j1,v10,fine,tool0;\nRAISE;"));
}

#[test]
fn what_does_not_move_ends_nothing() {
    let body = "MoveAbsJ j1,v100,fine,tool0;\nSet d1;\nWaitTime 0.5;\nWaitTime \\InPos, n;\nWaitDI d,1;\nIF d=1 THEN\n  SetDO e,0;\nELSEIF f\n  THEN Reset e;\nENDIF\nWHILE d=0 DO\nWaitTime 0.1;\nENDWHILE\nIF e GOTO lab2;\nx:=Sin(y)+n{2};\nConfL\\Off;\nGrip 5;";
    let source = program(J, body).replace(
        "ENDMODULE",
        "PROC Grip(num n)\nSetDO g,n;\nOpen2;\nENDPROC\nPROC Open2()\nWaitDI g,1;\nENDPROC\nENDMODULE",
    );
    let steps = kinds(&source);
    assert_eq!(
        steps[..7],
        ["Start", "move", "dwell Some(0.5)", "dwell None", "dwell None", "dwell Some(0.1)", "Start"],
        "{steps:?}"
    );
}

#[test]
fn a_routine_that_moves_through_another_one_is_a_call() {
    let source = program(J, "Grip 5;").replace(
        "ENDMODULE",
        "PROC Grip(num n)\nOpen2;\nENDPROC\nPROC Open2()\nMoveAbsJ j1,v10,fine,tool0;\nENDPROC\nENDMODULE",
    );
    assert_eq!(kinds(&source)[..2], ["Start", "Call"]);
    let function = program(J, "x:=Foreign(5);");
    assert_eq!(kinds(&function), ["Start", "Call"]);
}

#[test]
fn processes_are_noted() {
    let body = "ArcLStart p1,v100,s1,w1,fine,tool0;\nArcL p2,v100,s1,w1,z1,tool0;\nArcLEnd p3,v100,s1,w1,fine,tool0;\nDispL \\On,p1,v100,b1,z5,tool0;\nDispL \\Off,p1,v100,b1,z5,tool0;\nSpotL p4,v500,sp1,gun1,tool0;";
    let expected = [
        "Start",
        "move",
        "process true",
        "move",
        "move",
        "process false",
        "move",
        "process true",
        "move",
        "process false",
        "move",
        "dwell None",
    ];
    assert_eq!(kinds(&program("", body)), expected);
}

#[test]
fn pragmas_are_steps() {
    let body = "! lostmotion: off\nMoveAbsJ j1,v100,fine,tool0; ! lostmotion: on\nMoveAbsJ j1,v100,fine,tool0;";
    assert_eq!(kinds(&program(J, body)), ["Start", "pragma false", "move", "pragma true", "move"]);
}

#[test]
fn a_search_ends_anywhere_and_external_axes_alone_are_a_pause() {
    let body = "SearchL \\Stop,di1,psearch,p1,v50,tool0;\nMoveExtJ j1,vrot10,fine;";
    assert_eq!(kinds(&program(J, body)), ["Start", "move", "dwell None"]);
    assert!(opaque(&moves(&program(J, body))[0]).contains("search"));
}

#[test]
fn a_search_sets_the_point_that_it_finds_and_no_other() {
    let data = "[[500,0,400],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let declared = format!("LOCAL PERS robtarget pseam:={data};\nLOCAL PERS robtarget pend:={data};");
    let body = "SearchL \\Stop,di1,pseam,pend,v50,tool0;\nMoveL pseam,v100,fine,tool0;\nMoveL pend,v100,fine,tool0;";
    let all = moves(&program(&declared, body));
    assert!(opaque(&all[1]).contains("`SearchL`, which may set it"));
    assert!(matches!(all[2].goal, Goal::Pose(_)));
}

#[test]
fn a_calibration_takes_joints_and_sets_its_tool_and_another_routine_of_its_name_may_set_all() {
    let joints = "[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let declared: String = (1..=6).map(|k| format!("LOCAL PERS jointtarget q{k}:={joints};\n")).collect();
    let move_all: String = (1..=6).map(|k| format!("MoveAbsJ q{k},v100,fine,tool0;\n")).collect();
    let of = |more: &str, calls: &str| -> String {
        let source = program(&format!("{declared}{more}"), &format!("{move_all}{calls}"));
        moves(&source).iter().map(|m| if matches!(m.goal, Goal::Joints(_)) { 'j' } else { 'o' }).collect()
    };
    let calls = "MToolTCPCalib q1,q2,q3,q4,tGun,nMax,nMean;\nMToolRotCalib q4,q5\\XPos:=q6,tGun;";
    assert_eq!(of("", calls), "jjjjjj");
    assert_eq!(of("", "MToolTCPCalib q1,q2,q3,q4,tGun,q5,q6;"), "jjjjoo");
    assert_eq!(of("", "OwnCalib q1,q2,q3,q4,tGun,q5,q6;"), "oooooo");
    let own = "PROC MToolTCPCalib(INOUT jointtarget a)\na.robax.rax_1:=0;\nENDPROC\n";
    let source = program(
        &declared,
        &format!("{move_all}MToolTCPCalib q1;\nENDPROC\n{}", own.trim_end().trim_end_matches("ENDPROC")),
    );
    assert!(opaque(&moves(&source)[0]).contains("which may set it"));
    // what it reads stays: the motion gets a clone
    let point = "[[500,0,400],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let points: String = (1..=3).map(|k| format!("LOCAL PERS robtarget p{k}:={point};\n")).collect();
    let body = "Search_1D peResult,p1,p2,v100,tool0;\nMoveL p1,v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\nSearch_1D \\NotOff,p3,p1,p2,v100,tool0;\nMoveL p3,v100,fine,tool0;";
    let all = moves(&program(&points, body));
    assert!(matches!(all[0].goal, Goal::Pose(_)) && matches!(all[1].goal, Goal::Pose(_)), "{all:?}");
    assert!(opaque(&all[2]).contains("which may set it"));
}

#[test]
fn start_of_a_routine_is_a_break_and_at_its_line() {
    let doc = document(&program(J, INLINE));
    let step = &doc.script().steps[0];
    assert!(matches!(step.kind, StepKind::Break(Break::Start)) && step.at.line == 3);
}

#[test]
fn a_procedure_whose_name_begins_with_wait_may_move() {
    let of = |line: &str| {
        kinds(&program(
            "",
            &format!(
                "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n{line}\nMoveAbsJ [[2,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;"
            ),
        ))
    };
    let quiet = of("WaitDI d,1;");
    for line in ["WaitHome;", "WaitPartAndMove 5;", "WaitWObj wobjcnv1\\RelDist:=10;", "DropWObj wobjcnv1;"] {
        let now = of(line);
        assert!(
            now.iter().any(|k| k == "Call" || k == "Frame") && !quiet.iter().any(|k| k == "Call"),
            "{line}: {now:?}"
        );
    }
}

#[test]
fn moves_that_a_sensor_or_a_soft_arm_leads_away_stay() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    for (on, off) in
        [("SoftAct 1,50;", "SoftDeact;"), ("SyncToSensor s\\On;", "SyncToSensor s\\Off;"), ("FCAct tool0;", "FCDeact;")]
    {
        let body = format!("{}{on}\n{}{}{off}\n{}", j(1.0), j(2.0), j(3.0), j(4.0));
        assert_eq!(left(&program("", &body)), [false, true, true, false], "{on}");
        // a branch may be passed by
        for branch in [format!("{on}\nIF a THEN\n{off}\nENDIF\n"), format!("IF a THEN\n{on}\nELSE\n{off}\nENDIF\n")] {
            assert_eq!(left(&program("", &format!("{branch}{}{off}\n{}", j(1.0), j(2.0)))), [true, false], "{branch}");
        }
        // one routine switches it on, another off
        let two = format!("MODULE T\nPROC main()\nsoft;\n{}ENDPROC\nPROC soft()\n{on}\nENDPROC\nENDMODULE\n", j(1.0));
        assert_eq!(left(&two), [true], "{on}");
    }
    let at = "[[900,0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for line in [
        format!("MoveL {at},v100,fine,tool0\\Corr;"),
        format!("ArcL {at},v100,sm1,wd1\\Weave:=wv1,fine,tool0\\Track:=tr1;"),
        format!("ArcL {at},v100,sm1,wd1\\Weave:=wv1,fine,tool0;"),
    ] {
        assert_eq!(left(&program("", &line)), [true], "{line}");
    }
    assert_eq!(left(&program("", &format!("ArcL {at},v100,sm1,wd1,fine,tool0;"))), [false]);
}

#[test]
fn an_axis_of_softness_zero_goes_to_its_targets() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    let of = |before: &str, after: &str| left(&program("", &format!("{before}\n{}{after}\n{}", j(1.0), j(2.0))));
    assert_eq!(of("SoftAct 4,0;", ""), [false, false]);
    assert_eq!(of("SoftAct 4,50\\Ramp:=200;", "SoftAct 4,0;"), [true, false]);
    assert_eq!(of("SoftAct 4,50;\nSoftAct 3,20;", "SoftAct 4,0;"), [true, true]);
    assert_eq!(of("SoftAct 4,50;\nSoftAct 3,20;", "SoftAct 4,0;\nSoftAct 3,0;"), [true, false]);
    // of an axis that is not known, or of another unit, nothing is
    for on in ["SoftAct n,50;", "SoftAct \\MechUnit:=orbit1,4,50;", "SoftAct 4,s;"] {
        assert!(of(on, "SoftAct 4,0;")[0], "{on}");
    }
    for off in ["SoftAct n,0;", "SoftAct 4,s;", "SoftAct \\MechUnit:=orbit1,4,0;", "IF a SoftAct 4,0;"] {
        assert_eq!(of("SoftAct 4,50;", off), [true, true], "{off}");
    }
    for branch in ["IF a THEN\nSoftAct 4,0;\nENDIF", "FOR i FROM 1 TO n DO\nSoftAct 4,0;\nENDFOR"] {
        assert_eq!(of("SoftAct 4,50;", branch), [true, true], "{branch}");
    }
    // what a branch may have left soft is not made stiff by another axis
    assert_eq!(of("SoftAct 3,50;\nIF a THEN\nSoftDeact;\nENDIF", "SoftAct 4,0;"), [true, true]);
    assert_eq!(of("IF a THEN\nSoftAct 3,50;\nELSE\nSoftAct 3,0;\nENDIF", "SoftAct 4,0;"), [true, true]);
    // what another routine leaves soft may be soft in all
    let two = |body: &str| {
        format!("MODULE T\nPROC main()\nSoftAct 4,0;\n{}ENDPROC\nPROC soft()\n{body}\nENDPROC\nENDMODULE\n", j(1.0))
    };
    assert_eq!(left(&two("SoftAct 3,50;")), [true]);
    assert_eq!(left(&two("SoftAct 4,50;\nIF a RETURN;\nSoftAct 4,0;")), [false]);
    assert_eq!(left(&two("SoftAct 3,50;\nIF a RETURN;\nSoftAct 3,0;")), [true]);
}

#[test]
fn a_move_after_which_the_program_reads_its_place_keeps_its_goal() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    for (line, kept) in [
        ("p1:=CRobT(\\Tool:=tool0);\n", true),
        ("p1:=Offs(CRobT(),0,0,10);\n", true),
        ("jx:=CJointT();\nWaitTime 1;\n", true),
        ("n:=CalcRobT(jx,tool0);\n", false),
        ("MoveL RelTool(CRobT(\\Tool:=tool0),0,0,-50),v100,fine,tool0;\n", true),
        ("TPWrite \"at\"\\Pos:=CPos();\n", false),
    ] {
        let source = program("", &format!("{}{}{line}{}", j(1.0), j(2.0), j(3.0)));
        let fixed: Vec<bool> = moves(&source).iter().map(|m| m.fixed.is_some()).collect();
        assert_eq!((fixed[0], fixed[1], fixed.last()), (false, kept, Some(&false)), "{line}");
    }
}

#[test]
fn instructions_of_the_language_are_asked_of_no_user() {
    let of = |line: &str| {
        let source = program(J, &format!("MoveAbsJ j1,v100,fine,tool0;\n{line}\nMoveAbsJ j1,v100,fine,tool0;"));
        let d = document(&source);
        assert!(d.script().unknown_calls.is_empty(), "{line}: {:?}", d.script().unknown_calls);
        kinds(&source)
    };
    for line in
        ["StopMove;", "StorePath;", "PathRecStart id1;", "WZBoxDef\\Inside,wz1,p1,p2;", "WZLimSup\\Stat,wz2,wz1;"]
    {
        assert_eq!(of(line), ["Start", "move", "move"], "{line}");
    }
    assert_eq!(of("Stop;"), ["Start", "move", "dwell None", "move"]);
    for line in ["RestoPath;", "StartMove;", "PathRecMoveBwd;"] {
        assert_eq!(of(line), ["Start", "move", "Call", "move"], "{line}");
    }
}

/// Steps of moves after which `main` runs again from its start, as numbers of the moves.
fn runs_again_after(source: &str) -> Vec<usize> {
    let doc = document(source);
    let script = doc.script();
    let moves = |until: usize| script.moves().take_while(|(k, _)| *k < until).count();
    let Some(again) = &script.again else { return Vec::new() };
    assert_eq!(Some(again.at), script.entry);
    again.from.iter().map(|k| moves(*k)).collect()
}

#[test]
fn main_runs_again_from_its_start_where_its_end_is_reached() {
    let m = "MoveAbsJ j1,v100,fine,tool0;\n";
    let with = |main: &str, rest: &str| program(J, main).replace("ENDMODULE", &format!("{rest}ENDMODULE"));
    let cases: [(&str, String, &[usize]); 15] = [
        ("its end", with(&format!("{m}{m}"), ""), &[2]),
        ("waits and messages there", with(&format!("{m}{m}WaitTime 1;\nSetDO d1,0;"), ""), &[2]),
        ("RETURN", with(&format!("{m}IF a RETURN;\n{m}RETURN;"), ""), &[1, 2]),
        ("a branch at its end", with(&format!("{m}IF a THEN\n{m}ELSE\n{m}ENDIF"), ""), &[2, 3]),
        ("a loop with an end", with(&format!("{m}WHILE a DO\n{m}ENDWHILE\nFOR i FROM 1 TO 3 DO\n{m}ENDFOR"), ""), &[3]),
        ("ExitCycle", with(&format!("{m}WHILE TRUE DO\n{m}IF a ExitCycle;\n{m}ENDWHILE"), ""), &[2]),
        (
            "in what it calls",
            with(&format!("{m}WHILE TRUE DO\nsub;\nENDWHILE"), &format!("PROC sub()\n{m}ExitCycle;\nENDPROC\n")),
            &[2],
        ),
        ("no end", with(&format!("{m}WHILE TRUE DO\n{m}ENDWHILE"), ""), &[]),
        ("out of such a loop", with(&format!("{m}WHILE TRUE DO\n{m}IF a GOTO l;\nENDWHILE\nl:\n{m}"), ""), &[3]),
        ("a jump back", with(&format!("l:\n{m}{m}GOTO l;"), ""), &[]),
        ("EXIT", with(&format!("{m}{m}EXIT;"), ""), &[]),
        ("Stop", with(&format!("{m}{m}Stop;"), ""), &[]),
        ("Stop before", with(&format!("{m}Stop;\n{m}"), ""), &[2]),
        ("a handler", with(&format!("{m}{m}ERROR\n{m}RETRY;"), ""), &[2]),
        ("no main", with(&format!("{m}{m}"), "").replace("main", "work"), &[]),
    ];
    for (what, source, expected) in cases {
        assert_eq!(runs_again_after(&source), expected, "{what}");
    }
}

#[test]
fn a_procedure_is_entered_from_its_calls_unless_a_handler_may_run_one_again() {
    // breaks: 0 main, 2 the call, 3 or 4 the procedure
    let joins = |handler: &str, head: &str, tail: &str| {
        let part = format!("{handler}ENDPROC\n{head}\nMoveAbsJ j1,v10,fine,tool0;\n{tail}");
        let source = program(J, &format!("MoveAbsJ j1,v100,fine,tool0;\npart;\n{part}"));
        let d = document(&source);
        let starts = |k: &usize| matches!(d.script().steps[*k].kind, StepKind::Break(Break::Start));
        d.script().joins.iter().filter(|j| starts(&j.at)).map(|j| j.from.clone()).collect::<Vec<_>>()
    };
    const PART: &str = "PROC part()";
    assert_eq!(joins("", PART, ""), [vec![2]]);
    assert_eq!(joins("ERROR\nRAISE;\n", "LOCAL PROC part()", ""), [vec![2]]);
    for (handler, head, tail) in [
        ("ERROR\nRETRY;\n", PART, ""),
        ("ERROR\nTRYNEXT;\n", PART, ""),
        ("%\"pa\"+\"rt\"%;\n", PART, ""),
        ("MoveLSync p1,v1,z1,tool0,\"Part\";\n", PART, ""),
        ("CONNECT i1 WITH t;\n", PART, ""),
        ("", PART, "ENDPROC\nPROC part()\n"),
        (
            "part f(1);\n",
            PART,
            "ENDPROC\nFUNC num f(num n)\nMoveAbsJ j1,v10,fine,tool0;\nRETURN 1;\nENDFUNC\nPROC last()\n",
        ),
    ] {
        assert_eq!(joins(handler, head, tail), Vec::<Vec<usize>>::new(), "{handler}");
    }
    // external axes that the robot does not have; another module may call it
    let axes = "MoveAbsJ [[1,2,3,4,5,6],[100,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;\n";
    assert!(joins("", &format!("PROC part()\n{axes}"), "").is_empty());
    let source = program(J, "part;\nENDPROC\nPROC part()\nMoveAbsJ j1,v10,fine,tool0;\n").replace("main", "other");
    assert!(document(&source).script().joins.iter().all(|j| j.at == 1));
}
