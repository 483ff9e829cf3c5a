//! What a motion runs near its end: `TB`, `TA`, `DB`.

use super::lines::of_lines;
use super::*;
use crate::no_motion::NoMotion;
use crate::script::Script;

fn numbered(lines: &str) -> String {
    let each = lines.lines().enumerate().map(|(k, line)| match line.as_bytes() {
        [b'J' | b'L', b' ', ..] => format!("{:4}:{line}    ;", k + 1),
        _ => format!("{:4}:  {line} ;", k + 1),
    });
    each.collect::<Vec<String>>().join("\n")
}

/// A program of lines, with others beside it, and names that move nothing.
fn script(lines: &str, beside: &[(&str, &str)], declared: &[&str]) -> Script {
    let mut texts = vec![Text::new("p.ls", of_lines(&numbered(lines)).into_bytes())];
    texts.extend(beside.iter().map(|(name, lines)| {
        let text = format!("/PROG  {name}\n/ATTR\n/MN\n{}\n/POS\n/END\n", numbered(lines));
        Text::of_context(format!("{name}.LS"), text.into_bytes())
    }));
    let mut robot = m10ia();
    robot.no_motion = NoMotion::of(declared.iter().copied());
    Fanuc.parse(texts, &robot).unwrap().script().clone()
}

/// Kinds of the steps between the motions, without the start of the program.
fn between(lines: &str, beside: &[(&str, &str)], declared: &[&str]) -> Vec<String> {
    let script = script(lines, beside, declared);
    harness::kinds(&script).into_iter().skip(1).filter(|k| k != "move").collect()
}

const MOTION: &str = "L P[1] 100mm/sec FINE";

#[test]
fn a_program_that_a_motion_calls_counts_as_one_that_is_called_after_it() {
    for sub in ["UFRAME[1]=PR[5]", "R[1]=1", "DO[1]=ON", "J P[1] 100% FINE", "CALL ELSEWHERE"] {
        let beside = [("SUB", sub)];
        let own_line = between(&format!("{MOTION}\nCALL SUB\n{MOTION}"), &beside, &[]);
        for how in ["TA .10sec", "TB .10sec", "DB 10mm"] {
            let on_it = between(&format!("{MOTION} {how},CALL SUB\n{MOTION}"), &beside, &[]);
            assert_eq!(on_it, own_line, "{how}: {sub}");
        }
    }
    // the robot does not wait for it
    assert!(between(&format!("{MOTION} TA .10sec,CALL SUB\n{MOTION}"), &[("SUB", "WAIT 1.00(sec)")], &[]).is_empty());
    // a frame that an action sets itself, and a name that is computed
    assert_eq!(between(&format!("{MOTION} TB .10sec,CALL R[1]\n{MOTION}"), &[], &[]), ["Call"]);
    assert!(between(&format!("{MOTION} TB .10sec,DO[1]=PULSE,0.5sec\n{MOTION}"), &[], &[]).is_empty());
}

#[test]
fn a_program_that_a_motion_calls_and_no_file_has_waits_for_a_declaration() {
    let lines = format!("{MOTION} TB .10sec,CALL GRIP_KL\n{MOTION}");
    let unknown = script(&lines, &[], &[]);
    let named: Vec<&String> = unknown.unknown_calls.values().flatten().collect();
    assert_eq!(named, ["GRIP_KL"]);
    assert_eq!(between(&lines, &[], &[]), ["Call"]);
    assert!(between(&lines, &[], &["GRIP_KL"]).is_empty());
}

#[test]
fn a_register_that_a_called_program_sets_is_another_offset_after_the_motion() {
    let lines = format!("{MOTION} Offset,PR[3] TA .10sec,CALL SUB\n{MOTION} Offset,PR[3]");
    assert_eq!(between(&lines, &[("SUB", "PR[3,1]=R[1]")], &[]), ["sets pr"]);
}

#[test]
fn a_soft_servo_that_a_motion_switches_on_leads_the_robot_after_it() {
    let left = |option: &str, beside: &[(&str, &str)]| {
        let lines = format!("J P[1] 100% FINE {option}\nJ P[2] 100% FINE\nJ P[3] 100% FINE");
        let led = |m: &Move| matches!(&m.goal, Goal::Opaque(why) if why.to_string().contains("leads"));
        script(&lines, beside, &[]).moves().map(|(_, m)| led(m)).collect::<Vec<bool>>()
    };
    for how in ["TA .10sec", "TB .10sec", "DB 10mm"] {
        assert_eq!(left(&format!("{how},CALL SUB"), &[("SUB", "SOFTFLOAT[1]")]), [false, true, true], "{how}");
        assert_eq!(left(&format!("{how},SOFTFLOAT[1]"), &[]), [false, true, true], "{how}");
        assert_eq!(left(&format!("{how},DO[1]=ON"), &[]), [false; 3], "{how}");
    }
}

#[test]
fn a_motion_on_which_a_program_reads_the_place_keeps_its_goal() {
    let fixed = |option: &str| {
        let lines = format!("J P[1] 100% FINE\nJ P[2] 100% FINE {option}\nJ P[3] 100% FINE\nJ P[1] 100% FINE");
        let script = script(&lines, &[("RD", "PR[10]=LPOS")], &[]);
        script.moves().map(|(_, m)| m.fixed.is_some()).collect::<Vec<bool>>()
    };
    // before the end the place is one between two goals, after it one on the way to the next
    for how in ["TB .10sec", "DB 10mm"] {
        assert_eq!(fixed(&format!("{how},CALL RD")), [true, true, false, false], "{how}");
    }
    assert_eq!(fixed("TA .10sec,CALL RD"), [false, true, true, false]);
    assert_eq!(fixed("TA .10sec,DO[1]=ON"), [false; 4]);
}

#[test]
fn no_point_may_stand_where_it_would_delay_what_a_motion_starts_before_its_end() {
    // the way and the time that no point may shorten, and whether no point may be added at all
    for (motion, left, closed) in [
        ("L P[1] 100mm/sec CNT50 DB 200mm,DO[1]=ON", Some((0.2, 0.0)), false),
        ("L P[1] R[1]mm/sec CNT50 DB 20.0mm,P-SPS", Some((0.02, 0.0)), false),
        ("L P[1] 100mm/sec CNT50 TB 2.00sec,CALL GLUE", Some((0.2, 0.0)), false),
        ("L P[1] 60cm/min CNT50 TB .50sec,P-SPS", Some((0.005, 0.0)), false),
        ("L P[1] R[1]mm/sec CNT50 TB 2.00sec,CALL GLUE", Some((0.0, 2.0)), false),
        ("J P[1] 100% CNT50 TB .10sec,P-SPS", Some((0.0, 0.1)), false),
        ("J P[1] 100% CNT50 TB R[1]sec,P-SPS", None, true),
        ("J P[1] 100% CNT50 DB 20.0mm,DO[1]=ON", None, true),
        ("L P[1] 100mm/sec CNT50 DB R[1]mm,DO[1]=ON", None, true),
        ("J P[1] 100% CNT50 DB 0.0mm,DO[1]=ON", None, false),
        ("J P[1] 100% CNT50 TB 0.00sec,P-SPS", None, false),
        ("J P[1] 100% CNT50 TA 1.00sec,DO[1]=ON", None, false),
    ] {
        let script = script(motion, &[], &[]);
        let (_, m) = script.moves().next().unwrap();
        let found = m.end_trigger.as_ref().map(|t| (t.way_m, t.time_s));
        let near = found.zip(left).is_none_or(|(a, b)| (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12);
        assert!(near && found.is_some() == left.is_some(), "{motion}: {found:?}");
        let late = |why: &crate::script::Reason| why.to_string().contains("would start late");
        assert_eq!(m.closed.as_ref().map(late), closed.then_some(true), "{motion}");
    }
}
