//! TRIGGERs that read where the robot stands.

use super::*;
use crate::script::Reason;

const NAMES: [&str; 5] = ["A", "B", "C", "D", "E"];

/// Motions whose end is read, by letters; in `src`, `A` to `E` are motions that end exactly, and `a` to `e` those that go on.
fn read_of(src: &str, others: &[(&str, &str)]) -> String {
    let line = |l: &str| match NAMES.iter().position(|n| n.eq_ignore_ascii_case(l)) {
        Some(k) => format!("PTP {{A1 {k},A2 -90,A3 90,A4 10,A5 30,A6 0}}{}", if l == NAMES[k] { "" } else { " C_PTP" }),
        None => l.to_string(),
    };
    let src = if src.starts_with("DEF ") { src.to_string() } else { format!("DEF p()|{src}|END") };
    let src: String = src.split('|').map(|l| line(l) + "\n").collect();
    let mut texts = vec![Text::new("p.src", src.into_bytes())];
    texts.extend(others.iter().map(|(name, bytes)| Text::of_context(*name, bytes.as_bytes().to_vec())));
    let doc = Krl.parse(texts, &kr120()).unwrap();
    let read = |m: &Move| m.fixed.as_ref().is_some_and(|why| *why == Reason::EndIsRead);
    let name = |m: &Move| deg(doc.as_ref(), m)[0].map_or("?", |a1| NAMES[a1.round() as usize]);
    moves(doc.as_ref()).iter().filter(|(_, m)| read(m)).map(|(_, m)| name(m)).collect()
}

#[test]
fn a_trigger_that_reads_counts_where_it_strikes() {
    let of = |when: &str| read_of(&format!("A|B|TRIGGER WHEN {when} DO XQ=$AXIS_ACT|C|D|E"), &[]);
    for (when, read) in [
        ("DISTANCE=0 DELAY=0", "B"),
        ("DISTANCE = 0 DELAY = 20", "BC"),
        ("DISTANCE=1 DELAY=0", "C"),
        ("DISTANCE=1 DELAY=-50", "BC"),
        ("DISTANCE=1 DELAY=+50", "CD"),
        ("DISTANCE=1 DELAY=T", "BCD"),
        ("DISTANCE=N DELAY=0", "BCD"),
        ("PATH=0 DELAY=0", "C"),
        ("PATH=-20 DELAY=0", "BC"),
        ("PATH=-20.5 DELAY=-3", "BC"),
        ("PATH=20 DELAY=0", "CD"),
        ("PATH=-20 DELAY=50", "BCD"),
        ("PATH=WAY(1) DELAY=0", "BCD"),
        ("PATH=0 ONSTART DELAY=0", "B"),
        ("PATH=30 ONSTART DELAY=0", "BC"),
    ] {
        assert_eq!(of(when), read, "{when}");
    }
    // what it does is no reading
    for quiet in ["$OUT[1]=TRUE", "XQ=XP1", "$POS_ACT.X=5", "MSGNOTIFY($POS_ACT.X)"] {
        assert_eq!(read_of(&format!("A|TRIGGER WHEN DISTANCE=1 DELAY=0 DO {quiet}|B"), &[]), "", "{quiet}");
    }
    for reads in ["XQ.X=$POS_ACT.X+1", "NOTE($POS_ACT) PRIO=-1", "HERE=FORWARD($AXIS_ACT_MES,N)"] {
        assert_eq!(read_of(&format!("A|TRIGGER WHEN DISTANCE=1 DELAY=0 DO {reads}|B|C"), &[]), "B", "{reads}");
    }
}

#[test]
fn the_routine_of_a_trigger_reads_where_that_strikes() {
    let sub = "END|DEF RD()|GP=$POS_ACT|END";
    for (routine, when, read) in [
        ("RD()", "DISTANCE=1 DELAY=0", "B"),
        ("RD() PRIO=-1", "DISTANCE=0 DELAY=0", "A"),
        ("RD()", "PATH=-20 DELAY=0", "AB"),
        ("DEEP()", "DISTANCE=1 DELAY=0", "B"),
        ("ELSEWHERE()", "DISTANCE=1 DELAY=0", "B"),
        ("ELSEWHERE()", "DISTANCE=0 DELAY=0", "A"),
        ("ELSEWHERE()", "PATH=5 DELAY=0", "BC"),
        ("OTHER()", "DISTANCE=1 DELAY=0", ""),
    ] {
        // a routine of the file that nothing calls may be run by itself
        let own = match routine {
            "DEEP()" => format!("{sub}|DEF DEEP()|RD()|END"),
            "RD()" | "RD() PRIO=-1" => sub.into(),
            _ => "END".into(),
        };
        let src = format!("DEF p()|A|TRIGGER WHEN {when} DO {routine}|B|C|{own}");
        let others = [("x.src", "DEF ELSEWHERE()\nGP=$AXIS_ACT\nEND\nDEF OTHER()\nGP=XP\nEND\n")];
        assert_eq!(read_of(&src, &others), read, "{when} {routine}");
    }
    // called in the way of the program, too
    let both = format!("DEF p()|A|TRIGGER WHEN DISTANCE=1 DELAY=0 DO RD()|B|C|RD()|D|{sub}");
    assert_eq!(read_of(&both, &[]), "BC");
    // a routine of another file whose TRIGGER strikes at once
    let others = [("x.src", "DEF GO()\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO GP=$POS_ACT\nPTP XP\nEND\n")];
    assert_eq!(read_of("A|GO()|B", &others), "A");
}

#[test]
fn the_motion_after_a_trigger_is_found_along_control() {
    let trigger = "TRIGGER WHEN DISTANCE=1 DELAY=0 DO XQ=$AXIS_ACT";
    for (src, read) in [
        (format!("A|{trigger}|IF $IN[1] THEN|B|ENDIF|C"), "BC"),
        // the program may be run again
        (format!("A|LOOP|B|{trigger}|ENDLOOP"), "AB"),
        (format!("A|{trigger}|GOTO X|B|X:|C"), "C"),
        (format!("DEF p()|A|{trigger}|SUB()|C|END|DEF SUB()|B|D|END"), "B"),
        (format!("DEF p()|A|SUB()|C|D|END|DEF SUB()|{trigger}|END"), "C"),
        (format!("A|{trigger}|b|C"), "B"),
        (format!("A|B|{trigger}"), "A"),
        ("A|TRIGGER WHEN PATH=5 DELAY=0 DO XQ=$AXIS_ACT|B|IF $IN[1] THEN|C|ENDIF|D|E".into(), "BCD"),
    ] {
        assert_eq!(read_of(&src, &[]), read, "{src}");
    }
}
