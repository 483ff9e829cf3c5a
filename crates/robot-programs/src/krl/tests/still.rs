//! What a routine does between two motions, and whether the joints' directions stay known over it.

use super::*;

const AT: &str = "PTP {A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n";

/// Kinds of the steps of lines between two motions, and notes.
fn between(lines: &str, more: &str, beside: &[(&str, &str)]) -> (Vec<String>, Vec<String>) {
    let own = Text::new("p.src", format!("DEF p( )\n{AT}{lines}{AT}END\n{more}").into_bytes());
    let list = Text::new("p.dat", b"DEFDAT p\nENDDAT\n".to_vec());
    let others = beside.iter().map(|(n, t)| Text::of_context(*n, t.as_bytes().to_vec()));
    let d = Krl.parse([own, list].into_iter().chain(others).collect(), &kr120()).unwrap();
    let kinds = harness::kinds(d.script());
    let last = kinds.iter().skip(2).position(|k| k == "move").unwrap();
    (kinds[2..2 + last].to_vec(), d.script().notes.iter().map(|n| n.text.clone()).collect())
}

#[test]
fn a_block_in_which_nothing_moves_ends_nothing() {
    for quiet in [
        "IF $IN[1]==TRUE THEN\n$OUT[1]=TRUE\nELSE\nn=n+1\nENDIF\n",
        "WHILE NOT $IN[1]\nENDWHILE\n",
        "FOR i=1 TO 6\n$VEL_AXIS[i]=50\nENDFOR\n",
        "SWITCH n\nCASE 1\nn=2\nDEFAULT\nn=3\nENDSWITCH\n",
        "REPEAT\nn=n+1\nUNTIL n>4\n",
        "LOOP\nIF $IN[1] THEN\nEXIT\nENDIF\nENDLOOP\n",
        "IF n>4 THEN\nGOTO over\nENDIF\n",
        "IF n>4 THEN\nRETURN\nENDIF\n",
    ] {
        assert!(between(quiet, "", &[]).0.is_empty(), "{quiet}: {:?}", between(quiet, "", &[]).0);
    }
    assert_eq!(between("LOOP\nWAIT SEC 0.1\nEXIT\nENDLOOP\n", "", &[]).0, ["dwell Some(0.1)"]);
}

#[test]
fn a_routine_of_the_program_that_has_the_name_of_a_function_is_called_in_its_place() {
    let moves = "DEF ROUND( )\nPTP {A1 50.0}\nEND\nDEF helper( )\nROUND()\nEND\n";
    for line in ["ROUND()\n", "helper()\n", "n=ROUND(2)\n", "IF ROUND(2)>1 THEN\nn=1\nENDIF\n"] {
        assert!(between(line, moves, &[]).0.contains(&"Call".to_string()), "{line}");
    }
    assert!(between("n=ROUND(2)\n", "DEFFCT INT ROUND(n:IN)\nINT n\nRETURN n\nENDFCT\n", &[]).0.is_empty());
    assert!(between("n=ROUND(2)\n", "", &[]).0.is_empty());
}

/// A speed or a frame that a routine sets says nothing of what it calls.
#[test]
fn a_routine_that_sets_a_speed_and_calls_what_may_move_is_not_still() {
    let is_still = |pick: &str, set: &str| {
        let job = format!("DEF JOB1( )\n{set}\nPICK( )\nEND\n");
        let deep = "DEF DEEP( )\nPTP {A1 80.0}\nEND\n";
        let beside: &[(&str, &str)] = &[("job1.src", &job), ("deep.src", deep), ("pick.src", pick)];
        let beside = if pick.is_empty() { &beside[..2] } else { beside };
        between("JOB1( )\n", "", beside).1.iter().any(|n| n.contains("JOB1") && n.contains("moves nothing"))
    };
    let moves = "DEF PICK( )\nPTP {A1 80.0}\nEND\n";
    let deeper = "DEF PICK( )\nDEEP( )\nEND\n";
    for set in ["$VEL_AXIS[1]=50", "$BASE=$NULLFRAME"] {
        for pick in [moves, "", deeper] {
            assert!(!is_still(pick, set), "{set} {pick}");
        }
        assert!(is_still("DEF PICK( )\n$OUT[1]=TRUE\nEND\n", set), "{set}");
    }
}

#[test]
fn a_block_that_moves_or_calls_what_is_not_known_ends_the_known_direction() {
    for busy in [
        "LOOP\nEXT_STEP()\nENDLOOP\n",
        "IF may_move() THEN\nn=1\nENDIF\n",
        "REPEAT\nn=1\nUNTIL may_move()\n",
        "IF n>1 THEN\nINTERRUPT ON 3\nENDIF\n",
        "IF n>1 THEN\nover:\nENDIF\n",
        "IF n>1 THEN\nn=2\n",
        "ENDIF\n",
        "over:\n",
        "GOTO over\n",
    ] {
        let found = between(busy, "", &[]).0;
        assert!(found.iter().any(|k| !k.starts_with("dwell")), "{busy}: {found:?}");
    }
    // the motion stands within
    let kinds = between(&format!("FOR i=1 TO 3\n{AT}ENDFOR\n"), "", &[]).0;
    assert_eq!(kinds, ["Loop"]);
}

#[test]
fn settings_within_a_block_are_not_certain_after_it_and_those_before_a_quiet_one_are() {
    let base = |lines: &str| {
        let src = format!("DEF p( )\n$BASE={{X 1,Y 0,Z 0,A 0,B 0,C 0}}\n{lines}LIN {{X 1,Y 2,Z 3,A 0,B 0,C 0}}\nEND\n");
        let src = format!("{src}DEF q( )\n$BASE={{X 2,Y 0,Z 0,A 0,B 0,C 0}}\nEND\n");
        let d = doc(&[src.as_bytes()]);
        let Goal::Pose(pose) = &moves(d.as_ref())[0].1.goal else { panic!("no pose") };
        pose.frame.clone()
    };
    assert!(matches!(base("IF n>1 THEN\nn=1\nENDIF\n"), Frame::Given(_)));
    for lines in [
        "IF n>1 THEN\n$BASE={X 3,Y 0,Z 0,A 0,B 0,C 0}\nENDIF\n",
        "IF n>1 THEN\n$BASE={X 3,Y 0,Z 0,A 0,B 0,C 0}\nELSE\nn=1\nENDIF\n",
        "IF n>1 THEN\nIF n>2 THEN\n$BASE={X 3,Y 0,Z 0,A 0,B 0,C 0}\nENDIF\nENDIF\n",
    ] {
        assert!(matches!(base(lines), Frame::Any(all) if all.len() == 2), "{lines}");
    }
}

#[test]
fn a_call_of_a_routine_of_the_project_that_moves_nothing_ends_nothing_and_a_note_says_so() {
    let own = "DEF grip(n:IN)\nINT n\n;opens\n$OUT[n]=TRUE\nWAIT FOR $IN[n]\nIF $IN[2] THEN\nlamp()\nENDIF\nEND\n";
    let lamp = [("lamp.src", "&ACCESS RVP\nDEF lamp( )\n$OUT[9]=TRUE\nEND\n")];
    let (found, notes) = between("grip(1)\n", own, &lamp);
    assert_eq!(found, ["dwell None"]);
    let text = "the routines GRIP, LAMP that it calls move nothing, by the files of the project";
    assert!(notes.iter().any(|n| n == text), "{notes:?}");
    let function = "DEFFCT INT count(n:IN)\nINT n\nRETURN(n+1)\nENDFCT\n";
    assert!(between("n=count(2)\nIF count(3)>2 THEN\nn=1\nENDIF\n", function, &[]).0.is_empty());
}

#[test]
fn a_call_of_a_routine_that_may_move_or_is_not_certain_ends_the_known_direction() {
    for body in [
        AT,
        "LIN_REL {Z 1}\n",
        "other()\n",
        "sub()\n",
        "INTERRUPT ON 3\n",
        "$BASE=$NULLFRAME\n",
        "$VEL.CP=0.1\n",
        "BAS(#BASE,2)\n",
        "BASE_DATA[2]=$NULLFRAME\n",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE\n",
        "n=RSI_ON(#RELATIVE)\n",
        "ARC_ON(1)\n",
        "CONVEYOR.FOLLOW(1)\n",
        "unknown\n",
        "GLOBAL INTERRUPT DECL 3 WHEN $IN[1]==TRUE DO stop()\n",
    ] {
        let (found, _) = between("sub()\n", &format!("DEF sub( )\n{body}END\n"), &[]);
        assert_eq!(found, ["Call"], "{body}");
    }
    // another routine of the name that moves, none, a file that cannot be read
    let twice = [("sub.src", "DEF sub( )\nPTP XHOME\nEND\n")];
    assert_eq!(between("sub()\n", "DEF sub( )\n$OUT[1]=TRUE\nEND\n", &twice).0, ["Call"]);
    assert_eq!(between("sub()\n", "", &[]).0, ["Call"]);
}

#[test]
fn a_routine_of_an_interrupt_that_may_move_is_said() {
    let said = |routine: &str, name: &str| {
        let declared = format!("INTERRUPT DECL 3 WHEN $IN[1]==TRUE DO {name}( )\nINTERRUPT ON 3\n");
        let notes = between(&declared, &format!("DEF svc( )\n{routine}END\n"), &[]).1;
        notes.iter().any(|n| n.starts_with("SVC may move the robot while the program waits or moves"))
    };
    assert!(said("PTP {A1 40.0}\n", "svc"));
    assert!(!said("$OUT[1]=TRUE\n", "svc"));
    // what a controller brings along stops the robot
    assert!(!said("PTP {A1 40.0}\n", "IR_STOPM"));
}
