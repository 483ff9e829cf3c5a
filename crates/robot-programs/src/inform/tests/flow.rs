//! What a job does between two moves, and whether the joints' directions stay known over it.

use super::*;
use crate::script::Text;

/// Kinds of the steps of lines between two moves, and notes.
fn between(lines: &str, beside: &[(&str, &str)]) -> (Vec<String>, Vec<String>) {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,0,0,0,0,0";
    let source = job("2,0,0,0,0,0", list, &format!("MOVJ C00000 VJ=5.00\n{lines}\nMOVJ C00001 VJ=5.00"));
    let mut texts = vec![Text::new("TEST.JBI", source.into_bytes())];
    texts.extend(beside.iter().map(|(name, lines)| {
        let job = format!(
            "/JOB\n//NAME {name}\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n{lines}\nEND\n"
        );
        Text::of_context(format!("{name}.JBI"), job.into_bytes())
    }));
    let d = Inform.parse(texts, &robot()).unwrap();
    let kinds = harness::kinds(d.script());
    let last = kinds.iter().skip(2).position(|k| k == "move").unwrap();
    (kinds[2..2 + last].to_vec(), d.script().notes.iter().map(|n| n.text.clone()).collect())
}

#[test]
fn a_jump_with_a_condition_and_a_block_in_which_nothing_moves_end_nothing() {
    for quiet in [
        "JUMP *OVER IF IN#(1)=ON",
        "JUMP JOB:OTHER IF B000=1",
        "RET IF B000=1",
        "IFTHEN B000=1\nANDIF B001=0\nDOUT OT#(1) ON\nELSEIF B000=2\nSET B000 1\nELSE\nINC B000\nENDIF",
        "WHILE IN#(1)=OFF\nSET B000 1\nENDWHILE",
        "FOR I000=1 TO 5\nINC B001\nNEXT I000",
        "SWITCH B000\nCASE 1\nSET B001 1\nDEFAULT\nSET B001 2\nENDSWITCH",
        "*NEVER",
        "JUMP *HERE IF B000=1\nSET B001 1\n*HERE",
    ] {
        assert!(between(quiet, &[]).0.is_empty(), "{quiet}: {:?}", between(quiet, &[]).0);
    }
    assert_eq!(between("*WAIT\nTIMER T=0.10\nJUMP *WAIT IF IN#(1)=OFF", &[]).0, ["dwell Some(0.1)"]);
}

#[test]
fn a_branch_that_moves_or_does_what_is_not_known_ends_the_known_direction() {
    for busy in [
        "JUMP *OVER",
        "IFTHEN B000=1\nGETFOO\nENDIF",
        "IFTHEN B000=1\nSETTOOL TL#(1) P001\nENDIF",
        "IFTHEN B000=1",
        "IF B000=1",
        "ANDIF B000=1",
        "CASE 1 CALL JOB:SUB",
        "*L1\nCALL JOB:SUB\nJUMP *L1 IF IN#(1)=OFF",
        "*L1\nJUMP LB000 IF IN#(1)=OFF",
        "*L1 SET B000 1",
        "*L1\nJUMP *L1 IF IN#(1)=OFF\n*L1",
    ] {
        let found = between(busy, &[]).0;
        assert!(found.iter().any(|k| !k.starts_with("dwell")), "{busy}: {found:?}");
    }
    // reached from after the next move
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,0,0,0,0,0";
    let loops = "*L1\nMOVJ C00000 VJ=5.00\nMOVJ C00001 VJ=5.00\nJUMP *L1 IF IN#(1)=OFF";
    let script = script_of(&Inform, &job("2,0,0,0,0,0", list, loops), &robot());
    assert!(harness::kinds(&script).contains(&"Jump".to_string()));
}

#[test]
fn a_call_of_a_job_beside_it_that_moves_nothing_ends_nothing_and_a_note_says_so() {
    let grip = ("GRIP", "'opens\nDOUT OT#(1) ON\nWAIT IN#(1)=ON\nCALL JOB:LAMP IF B000=1\nRET");
    let (found, notes) = between("CALL JOB:GRIP (1, 2) IF B001=1", &[grip, ("LAMP", "PULSE OT#(2) T=0.10")]);
    assert_eq!(found, ["dwell None"]);
    let text = "the job GRIP that it calls moves nothing, by the file beside it";
    assert!(notes.iter().any(|n| n == text), "{notes:?}");
    for body in [
        "MOVJ C00000 VJ=5.00",
        "IMOV P000 V=10.0",
        "CALL JOB:OTHER",
        "CALL I001",
        "SFTON P001",
        "ARCON",
        "SETTOOL TL#(1) P001",
        "MFRAME UF#(1) P001 P002 P003",
        "OPENGUN",
        "PSTART JOB:OTHER SUB1",
        "+MOVJ EC00000",
        "SWITCH B000\nCASE 1 MOVJ P001\nENDSWITCH",
    ] {
        assert_eq!(between("CALL JOB:SUB", &[("SUB", body)]).0, ["Call"], "{body}");
    }
    // a job that calls itself moves nothing by that
    assert!(between("CALL JOB:SUB", &[("SUB", "CALL JOB:SUB")]).0.is_empty());
    assert_eq!(between("CALL JOB:SUB", &[("SUB", "NOP"), ("SUB", "NOP")]).0, ["Call"]);
    // it goes on in another job
    let jumps = |line: &'static str| {
        between("CALL JOB:SUB", &[("SUB", line), ("MOVER", "MOVJ C00000 VJ=5.00"), ("REST", "NOP")]).0
    };
    for line in ["JUMP JOB:MOVER", "JUMP JOB:MOVER IF B000=1", "JUMP JOB:GONE"] {
        assert_eq!(jumps(line), ["Call"], "{line}");
    }
    assert!(jumps("JUMP JOB:REST IF B000=1").is_empty());
    assert_eq!(between("CALL JOB:SUB", &[("SUB2", "NOP")]).0, ["Call"]);
}

#[test]
fn a_move_before_imov_stays_and_its_position_too() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,0,0,0,0,0";
    let lines = "MOVJ C00001 VJ=5.00\nMOVJ C00000 VJ=5.00\nMOVJ C00001 VJ=5.00\nTIMER T=0.10\nIMOV P001 V=10.0 BF";
    let script = script_of(&Inform, &job("2,0,0,0,0,0", list, lines), &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(fixed, [false, false, true, false]);
    // the other move to that position gets a separate line
    let text = written(&job("2,0,0,0,0,0", list, lines), &[(1, Some([990.0, 0.0, 0.0, 0.0, 0.0, 0.0]), vec![])]);
    assert!(text.contains("C00001=1000,0,0,0,0,0") && text.contains("C00002=990,0,0,0,0,0"), "{text}");
    assert!(text.contains("MOVJ C00002 VJ=5.00") && text.contains("MOVJ C00001 VJ=5.00\r\nTIMER"), "{text}");
}

#[test]
fn moves_from_which_a_relative_move_may_count_stay() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,0,0,0,0,0";
    let fixed = |lines: &str, beside: &[(&str, &str)]| {
        let mut texts = vec![Text::new("TEST.JBI", job("2,0,0,0,0,0", list, lines).into_bytes())];
        texts.extend(beside.iter().map(|(name, lines)| {
            let job = format!("/JOB\n//NAME {name}\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\nNOP\n{lines}\nEND\n");
            Text::of_context(format!("{name}.JBI"), job.into_bytes())
        }));
        let d = Inform.parse(texts, &robot()).unwrap();
        d.script().moves().map(|m| m.1.fixed.is_some()).collect::<Vec<bool>>()
    };
    let (a, b, relative) = ("MOVJ C00000 VJ=5.00", "MOVJ C00001 VJ=5.00", "IMOV P001 V=10.0 BF");
    let branches = format!("{a}\nIFTHEN B000=1\n{b}\nELSE\n{a}\nENDIF\n{relative}");
    assert_eq!(fixed(&branches, &[]), [true, true, true, true]);
    for (called, stays) in [(relative, true), (a, false), ("CALL JOB:SHIFT2", true)] {
        let beside = [("SHIFT", called), ("SHIFT2", relative)];
        assert_eq!(fixed(&format!("{a}\n{b}\nCALL JOB:SHIFT\n{a}"), &beside), [false, stays, false], "{called}");
    }
}

#[test]
fn a_motion_that_is_laid_over_the_path_goes_on_where_its_end_may_be_passed_by() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,0,0,0,0,0";
    let left = |lines: &str| {
        let script = script_of(&Inform, &job("2,0,0,0,0,0", list, lines), &robot());
        script
            .moves()
            .map(|m| matches!(&m.1.goal, Goal::Opaque(why) if why.to_string().ends_with("is on")))
            .collect::<Vec<bool>>()
    };
    let m = "MOVJ C00000 VJ=5.00";
    for (lines, expected) in [
        (format!("WVON WEV#(1)\n{m}\nWVOF\n{m}"), vec![true, false]),
        (format!("WVON WEV#(1)\nJUMP *L1 IF B000=1\nWVOF\n*L1\n{m}"), vec![true]),
        (format!("WVON WEV#(1)\nIFTHEN B000=1\nWVOF\n{m}\nENDIF\n{m}"), vec![false, true]),
        (format!("*L1\n{m}\nSFTON P001\n{m}\nJUMP *L1"), vec![true, true]),
        (format!("*L1\n{m}\nSFTON P001\n{m}\nSFTOF\nJUMP *L1"), vec![false, true]),
        (format!("{m}\nCOMARCOF\n{m}"), vec![true, false]),
    ] {
        assert_eq!(left(&lines), expected, "{lines}");
    }
}
