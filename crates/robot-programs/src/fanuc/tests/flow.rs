//! What a program does between two motions, and whether the joints' directions stay known over it.

use super::lines::of_lines;
use super::*;
use crate::files::Folders;

/// Kinds of the steps between the motions of lines, without the start of the program.
fn between(lines: &str, beside: &[(&str, &str)]) -> (Vec<String>, Vec<String>) {
    let lines: String = lines.lines().enumerate().map(|(k, l)| format!("{:4}:  {l} ;\n", k + 1)).collect();
    let mut texts = vec![Text::new("p.ls", of_lines(lines.trim_end_matches('\n')).into_bytes())];
    texts.extend(beside.iter().map(|(name, lines)| Text::of_context(format!("{name}.LS"), called(name, lines))));
    let d = Fanuc.parse(texts, &m10ia()).unwrap();
    let kinds = harness::kinds(d.script()).into_iter().skip(1).filter(|k| k != "move").collect();
    (kinds, d.script().notes.iter().map(|n| n.text.clone()).collect())
}

fn called(name: &str, lines: &str) -> Vec<u8> {
    let lines: String = lines.lines().enumerate().map(|(k, l)| format!("{:4}:  {l} ;\n", k + 1)).collect();
    format!("/PROG  {name}\n/ATTR\n/MN\n{lines}/POS\n/END\n").into_bytes()
}

fn steps(lines: &str) -> Vec<String> {
    between(lines, &[]).0
}

#[test]
fn a_jump_that_may_be_taken_and_a_block_in_which_nothing_moves_end_nothing() {
    for quiet in [
        "IF R[1]=1 AND DI[2]=ON,JMP LBL[9]",
        "IF R[1]=1,R[2]=(R[1]+1)",
        "IF (!DI[1] AND F[2]),DO[1]=(ON)",
        "SELECT R[1]=1,JMP LBL[8]\n       =2,JMP LBL[9]\n       ELSE,JMP LBL[8]",
        "IF (R[1]=1) THEN\nDO[1]=ON\nELSE\nIF R[2]=1,JMP LBL[9]\nENDIF",
        "FOR R[1]=1 TO 5\nR[2]=R[2]+R[1]\nENDFOR",
        "IF (R[1]=1) THEN\nJMP LBL[9]\nENDIF",
        "WENN R[1]=1,SPRUNG MRK[9]",
    ] {
        let lines = format!("J P[1] 100% FINE\n{quiet}\nJ P[2] 100% FINE\nEND\nLBL[8]\nLBL[9]\nJ P[3] 100% FINE");
        // the ends below: END itself, and the labels that are reached from above
        assert_eq!(steps(&lines).first().map(String::as_str), Some("Jump"), "{quiet}");
        assert!(steps(&lines).len() <= 3, "{quiet}: {:?}", steps(&lines));
    }
    let waits = "J P[1] 100% FINE\nIF (R[1]=1) THEN\nWAIT .50(sec)\nENDIF\nJ P[2] 100% FINE";
    assert_eq!(steps(waits), ["dwell Some(0.5)"]);
}

#[test]
fn moves_from_which_an_increment_may_count_stay() {
    let fixed = |lines: &str, beside: &[(&str, &str)]| {
        let lines: String = lines.lines().enumerate().map(|(k, l)| format!("{:4}:  {l} ;\n", k + 1)).collect();
        let mut texts = vec![Text::new("p.ls", of_lines(lines.trim_end_matches('\n')).into_bytes())];
        texts.extend(beside.iter().map(|(name, lines)| Text::of_context(format!("{name}.LS"), called(name, lines))));
        let d = Fanuc.parse(texts, &m10ia()).unwrap();
        moves(d.as_ref()).iter().map(|m| m.1.fixed.is_some()).collect::<Vec<bool>>()
    };
    let (a, b, inc) = ("J P[1] 100% FINE", "J P[2] 100% FINE", "L P[3] 50mm/sec FINE INC");
    assert_eq!(fixed(&format!("{a}\n{b}\n{inc}\n{a}"), &[]), [false, true, false, false]);
    assert_eq!(
        fixed(&format!("{a}\nL P[2] 50mm/sec FINE Skip,LBL[9]\n{inc}\nLBL[9]\n{a}"), &[]),
        [false, true, false, false]
    );
    // of both ways to the label
    let ways = format!("{a}\nIF R[1]=1,JMP LBL[1]\n{b}\nLBL[1]\n{inc}");
    assert_eq!(fixed(&ways, &[]), [true, true, true]);
    assert_eq!(fixed(&format!("{a}\n{b}\nCALL SHIFT\n{a}"), &[("SHIFT", inc)]), [false, true, false]);
    let through = [("OTHER", "CALL SHIFT"), ("SHIFT", inc)];
    assert_eq!(fixed(&format!("{a}\n{b}\nCALL OTHER\n{a}"), &through), [false, true, false]);
    assert_eq!(fixed(&format!("{a}\n{b}\nCALL OTHER\n{a}"), &[("OTHER", a)]), [false, false, false]);
    // in front of a program that reads where the robot stands
    for call in ["CALL OTHER", "IF R[1]=1,CALL OTHER"] {
        let through = [("OTHER", "CALL HERE"), ("HERE", "PR[5]=LPOS")];
        assert_eq!(fixed(&format!("{a}\n{b}\n{call}\n{a}"), &through), [false, true, false], "{call}");
    }
}

#[test]
fn a_branch_that_moves_or_does_what_is_not_known_ends_the_known_direction() {
    for busy in [
        "IF (R[1]=1) THEN\nJ P[3] 100% FINE\nENDIF",
        "IF R[1]=1,CALL GONE",
        "IF R[1]=1,CALL SR[1]",
        "IF (R[1]=1) THEN\nGO HOME\nENDIF",
        "IF (R[1]=1) THEN\nDO[1]=ON",
        "IF R[1]=1,UFRAME[1]=PR[2]",
        "IF R[1]=1,DO[1]=ON,CALL GONE",
        "SELECT R[1]=1,CALL GONE\n       ELSE,JMP LBL[9]",
        "FOR R[1]=1 TO 5\nL P[3] 100mm/sec FINE\nENDFOR",
        "IF R[1]=1,OPEN HAND",
    ] {
        let found = steps(&format!("J P[1] 100% FINE\n{busy}\nJ P[2] 100% FINE"));
        assert!(found.iter().any(|k| k != "dwell None"), "{busy}: {found:?}");
    }
}

#[test]
fn a_label_at_which_a_program_waits_ends_nothing_and_one_that_is_reached_from_a_motion_does() {
    let quiet = [
        "LBL[1]\nWAIT .10(sec)\nIF DI[1]=OFF,JMP LBL[1]",
        "LBL[1:never]",
        "IF R[1]=1,JMP LBL[1]\nR[2]=1\nLBL[1]",
        "WAIT DI[1]=ON TIMEOUT,LBL[1]\nLBL[1]",
    ];
    for lines in quiet {
        let found = steps(&format!("J P[1] 100% FINE\n{lines}\nJ P[2] 100% FINE"));
        assert!(found.iter().all(|k| k.starts_with("dwell")), "{lines}: {found:?}");
    }
    let busy = [
        "LBL[1]\nJ P[3] 100% FINE\nIF DI[1]=OFF,JMP LBL[1]",
        "LBL[1]\nJ P[3] 100% FINE Skip,LBL[1]",
        "LBL[1]\nR[1]=R[1]+1\nJ P[3] 100% FINE\nJMP LBL[R[1]]",
        "LBL[1]\nIF DI[1]=OFF,JMP LBL[1]\nLBL[1]",
        "LBL[1]\nCALL GONE\nIF DI[1]=OFF,JMP LBL[1]",
        "LBL[1]\nIF (R[1]=1) THEN\nJ P[3] 100% FINE\nJMP LBL[1]\nENDIF",
        "IF R[1]=2,JMP LBL[R[2]]\nLBL[1]",
    ];
    for lines in busy {
        let found = steps(&format!("J P[1] 100% FINE\n{lines}\nJ P[2] 100% FINE"));
        assert!(found.iter().any(|k| k == "Jump"), "{lines}: {found:?}");
    }
}

#[test]
fn a_call_of_a_program_beside_it_that_moves_nothing_ends_nothing_and_a_note_says_so() {
    let lines = "J P[1] 100% FINE\nCALL GRIP(1,R[2])\nIF R[1]=1,CALL LAMP\nJ P[2] 100% FINE";
    let grip = ("GRIP", "!opens\nRO[1]=ON\nWAIT RI[1]=ON\nIF AR[1]=1,JMP LBL[1]\nCALL LAMP\nLBL[1]");
    let (found, notes) = between(lines, &[grip, ("LAMP", "DO[1]=PULSE,0.1sec\nR[1]=1")]);
    assert_eq!(found, ["dwell None"]);
    let text = "the programs GRIP, LAMP that it calls move nothing, by the files beside it";
    assert!(notes.iter().any(|n| n == text), "{notes:?}");
    let upper = between("J P[1] 100% FINE\nCALL LAMP\nJ P[2] 100% FINE", &[("Lamp", "DO[1]=ON")]);
    assert!(upper.0.is_empty(), "{:?}", upper.0);
}

#[test]
fn a_call_of_a_program_that_may_move_or_is_not_certain_ends_the_known_direction() {
    let lines = "J P[1] 100% FINE\nCALL SUB\nJ P[2] 100% FINE";
    for body in [
        "J P[1] 100% FINE",
        "L PR[1] 100mm/sec FINE",
        "HOME",
        "RUN OTHER",
        "CALL OTHER",
        "IF R[1]=1,CALL OTHER",
        "IF R[1]=1,HOME",
        "UFRAME[1]=PR[1]",
        "OFFSET CONDITION PR[1]",
        "MONITOR WATCH",
        "Arc Start[1]",
        "Weave Sine[1]",
        "CALL SR[1]",
        "SELECT R[1]=1,CALL OTHER",
    ] {
        assert_eq!(between(lines, &[("SUB", body)]).0.first().map(String::as_str), Some("Call"), "{body}");
    }
    // a program that calls itself moves nothing by that
    assert!(between(lines, &[("SUB", "CALL SUB")]).0.is_empty());
    // two files of one name, a file of another program, none, one that cannot be read
    assert_eq!(between(lines, &[("SUB", "DO[1]=ON"), ("sub", "DO[2]=ON")]).0, ["Call"]);
    assert_eq!(between(lines, &[("SUB2", "DO[1]=ON")]).0, ["Call"]);
    assert_eq!(between(lines, &[]).0, ["Call"]);
    let source = of_lines("   1:J P[1] 100% FINE ;\n   2:  CALL SUB ;\n   3:J P[2] 100% FINE ;");
    let texts = vec![Text::new("p.ls", source.into_bytes()), Text::unread("SUB.LS")];
    let d = Fanuc.parse(texts, &m10ia()).unwrap();
    assert!(harness::kinds(d.script()).contains(&"Call".to_string()));
}

#[test]
fn files_of_called_programs_are_looked_up_beside_a_program_and_through_their_calls() {
    let folder = std::env::temp_dir().join(format!("lostmotion-fanuc-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (name, lines) in
        [("MAIN.LS", "CALL GRIP"), ("grip.ls", "IF R[1]=1,CALL LAMP"), ("LAMP.LS", "DO[1]=ON"), ("OTHER.LS", "R[1]=1")]
    {
        std::fs::write(folder.join(name), called("X", lines)).unwrap();
    }
    let found = Fanuc.context(&folder.join("MAIN.LS"), &Folders::default(), &m10ia());
    assert_eq!(found, [folder.join("LAMP.LS"), folder.join("grip.ls")]);
    assert!(Fanuc.context(&folder.join("OTHER.LS"), &Folders::default(), &m10ia()).is_empty());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_motion_before_an_increment_stays_and_the_others_are_edited() {
    let text = "   1:J P[1] 100% FINE ;\n   2:J P[2] 100% FINE ;\n   3:  CALL SUB ;\n   4:J P[3] 100% FINE INC ;\n   5:J P[1] 100% FINE ;";
    let d = doc(of_lines(text).as_bytes());
    let fixed: Vec<bool> = moves(d.as_ref()).iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(fixed, [false, true, false, false]);
    assert!(moves(d.as_ref())[1].1.fixed.as_ref().is_some_and(|w| w.to_string().contains("INC")));
}
