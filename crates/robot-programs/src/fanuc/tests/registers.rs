//! Position registers whose values a listing tells: where they are known, and what makes them unknown.

use super::*;
use crate::fanuc::Registers;
use crate::no_motion::NoMotion;
use crate::script::Shift;
use crate::script::pose::Frame;
use nalgebra::Vector3;

const LISTING: &str = "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[2,255] OF Position Reg\n    [1,1] =   '@Home'   Group: 1\n\
    \x20 J1 =   -70.000 deg   J2 =   -25.000 deg   J3 =     0.000 deg \n  J4 =     0.000 deg   J5 =   -90.000 deg   J6 =   -20.000 deg \n\
    \x20   [1,2] =   '' \n  Group: 1   Config: N U T, 0, 0, 0\n  X:   900.000   Y:     0.000   Z:   300.000\n  W:   180.000   P:     0.000   R:     0.000\n\
    \x20   [1,3] =   '' Uninitialized\n\
    \x20   [1,4] =   'up' \n  Group: 1   Config: N U T, 0, 0, 0\n  X:     0.000   Y:     0.000   Z:   -20.000\n  W:     0.000   P:     0.000   R:     0.000\n\
    \x20   [1,5] =   'turn' \n  Group: 1   Config: N U T, 0, 0, 0\n  X:     0.000   Y:     0.000   Z:     0.000\n  W:     0.000   P:     0.000   R:     9.000\n";

fn numbered(lines: &str) -> String {
    lines.lines().enumerate().map(|(k, l)| format!("{:4}:  {l} ;\n", k + 1)).collect()
}

/// A program with two joint positions and a Cartesian one in frame 3 for tool 2.
fn source(lines: &str) -> Vec<u8> {
    let joints = |n: u32| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 3, UT : 2,\n\tJ1=    1{n}.000 deg,\tJ2=   -20.000 deg,\tJ3=    30.000 deg,\n\tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\n}};\n"
        )
    };
    let pose = "P[3]{\n   GP1:\n\tUF : 3, UT : 2,\tCONFIG : 'N U T, 0, 0, 0',\n\tX =   900.000  mm,\tY =     0.000  mm,\tZ =   300.000  mm,\n\tW =   180.000 deg,\tP =     0.000 deg,\tR =     0.000 deg\n};\n";
    format!("/PROG  P\n/ATTR\n/MN\n{}/POS\n{}{}{pose}/END\n", numbered(lines), joints(1), joints(2)).into_bytes()
}

fn script(lines: &str, said: &[&str], beside: &[(&str, &str)]) -> crate::script::Script {
    let mut robot = m10ia();
    robot.registers = Registers::read("POSREG.VA", LISTING).unwrap();
    robot.no_motion = NoMotion::of(said.iter().copied());
    let mut texts = vec![Text::new("P.LS", source(lines))];
    texts.extend(beside.iter().map(|(name, lines)| {
        Text::of_context(
            format!("{name}.LS"),
            format!("/PROG  {name}\n/ATTR\n/MN\n{}/POS\n/END\n", numbered(lines)).into_bytes(),
        )
    }));
    Fanuc.parse(texts, &robot).unwrap().script().clone()
}

/// What is known of the goal of the second move.
fn goal(lines: &str, said: &[&str], beside: &[(&str, &str)]) -> Goal {
    let script = script(lines, said, beside);
    script.moves().nth(1).unwrap().1.goal.clone()
}

fn opaque(goal: &Goal) -> String {
    match goal {
        Goal::Opaque(why) => why.to_string(),
        _ => "known".into(),
    }
}

#[test]
fn a_motion_to_a_register_of_the_listing_leads_to_a_known_place_and_is_not_edited() {
    let lines = "J P[1] 100% FINE\nJ PR[1:@Home] 100% FINE\nJ P[2] 100% FINE";
    let script = script(lines, &[], &[]);
    let (_, m) = script.moves().nth(1).unwrap();
    let Goal::Joints(target) = m.goal else { panic!("{:?}", m.goal) };
    let target = script.targets.get(target).unwrap();
    let deg: Vec<f64> = target.values.iter().map(|v| v.unwrap().si.to_degrees()).collect();
    let listed = [-70.0, -25.0, 0.0, 0.0, -90.0, -20.0];
    assert!(deg.iter().zip(listed).all(|(a, b)| (a - b).abs() < 1e-9), "{deg:?}");
    assert!(m.fixed.as_ref().is_some_and(|why| why.to_string().contains("PR[1]")) && m.closed.is_some());
    let note = script.notes.iter().find(|n| n.text.contains("must hold these values")).unwrap();
    assert!(note.text.contains("PR[1]") && note.place.line == 5, "{note:?}");
    // a rewritten program reads alike
    let d = doc(&source(lines));
    assert!(matches!(moves(d.as_ref())[1].1.goal, Goal::Opaque(_)), "without a listing");
}

#[test]
fn a_cartesian_register_counts_in_the_frame_and_for_the_tool_that_are_selected() {
    let frame_of = |lines: &str| match goal(lines, &[], &[]) {
        Goal::Pose(p) => Ok((p.frame.clone(), p.tool.clone(), p.position_m)),
        other => Err(opaque(&other)),
    };
    let at = Vector3::new(0.9, 0.0, 0.3);
    // by the position before
    let named = |f: &str, t: &str| Ok((Frame::Named(f.into()), Frame::Named(t.into()), at));
    assert_eq!(frame_of("J P[1] 100% FINE\nL PR[2] 100mm/sec FINE"), named("3", "2"));
    assert_eq!(frame_of("J P[1] 100% FINE\nUFRAME_NUM=4\nUTOOL_NUM=1\nL PR[2] 100mm/sec FINE"), named("4", "1"));
    for between in
        ["UFRAME_NUM=R[1]", "LBL[1]", "IF R[1]=1,UFRAME_NUM=1", "CALL SEL", "UFRAME[3]=PR[9]", "JMP LBL[1]\nLBL[1]"]
    {
        let lines = format!("J P[1] 100% FINE\n{between}\nL PR[2] 100mm/sec FINE");
        let found = match goal(&lines, &[], &[("SEL", "UFRAME_NUM=1")]) {
            Goal::Opaque(why) => why.to_string(),
            _ => "known".into(),
        };
        assert!(found.starts_with("a position register: "), "{between}: {found}");
    }
}

#[test]
fn a_register_that_anything_among_the_files_may_set_is_not_known() {
    let after = |line: &str| format!("J P[1] 100% FINE\nJ PR[1] 100% FINE\n{line}");
    assert_eq!(
        opaque(&goal(&after("R[1]=PR[1,1]"), &[], &[("OTHER", "PR[6]=PR[1]\nL PR[1] 100mm/sec FINE")])),
        "known"
    );
    let own = [
        "PR[1]=LPOS",
        "PR[1,3]=5",
        "PR[GP2:1,1]=5",
        "PR[R[1]]=LPOS",
        "PR[R[1],2]=1",
        "PR[1:home]=PR[2]",
        "IF R[1]=1,PR[1]=LPOS",
        "IF (R[1]=1),PR[1,1]=(5)",
        "Search Start[1] PR[1]",
        "CALL KAREL(1)",
        "CALL SR[1]",
        "RUN GONE",
        "Find Part",
        "FOO[1]=PR[2]",
        "J P[1] 100% FINE TB .10sec,CALL GONE",
        "J P[1] 100% FINE TB .10sec,PR[1]=LPOS",
        "SELECT R[1]=1,CALL GONE",
    ];
    for line in own {
        let found = opaque(&goal(&after(line), &[], &[]));
        assert!(found.starts_with("a position register: "), "{line}: {found}");
        // in any program of the folder, whether it is called or not
        let other = opaque(&goal(&after("R[1]=1"), &[], &[("OTHER", line)]));
        assert!(other.starts_with("a position register: ") && other.contains("OTHER"), "{line}: {other}");
    }
    for n in [3, 77] {
        assert!(
            opaque(&goal(&format!("J P[1] 100% FINE\nJ PR[{n}] 100% FINE"), &[], &[])).contains("not in the program")
        );
    }
    // one that is declared may set a register that it is given the number of
    assert_eq!(opaque(&goal(&after("CALL KAREL"), &["KAREL"], &[])), "known");
    assert_eq!(opaque(&goal(&after("Find Part"), &["find part"], &[])), "known");
    assert!(opaque(&goal(&after("CALL KAREL(1)"), &["KAREL"], &[])).contains("KAREL"));
    // one that cannot be read
    let mut robot = m10ia();
    robot.registers = Registers::read("POSREG.VA", LISTING).unwrap();
    let texts = vec![Text::new("P.LS", source(&after("R[1]=1"))), Text::unread("OTHER.LS")];
    let d = Fanuc.parse(texts, &robot).unwrap();
    assert!(opaque(&moves(d.as_ref())[1].1.goal).contains("cannot be read"));
}

#[test]
fn a_motion_that_is_more_than_one_to_a_register_stays_unknown() {
    for motion in [
        "L PR[2] 100mm/sec FINE Offset,PR[4]",
        "J PR[1] 100% FINE INC",
        "J PR[R[1]] 100% FINE",
        "L PR[2] 100mm/sec FINE COORD",
        "J PR[1] 100% FINE Foo",
        "L PR[2] 100mm/sec FINE RTCP",
        "L PR[2] 100mm/sec FINE Search[-Z]",
    ] {
        let found = goal(&format!("J P[1] 100% FINE\n{motion}"), &[], &[]);
        assert!(matches!(found, Goal::Opaque(_)), "{motion}: {found:?}");
    }
    let led = goal("J P[1] 100% FINE\nWeave Sine[1]\nJ PR[1] 100% FINE", &[], &[]);
    assert!(matches!(led, Goal::Opaque(_)), "{led:?}");
}

#[test]
fn an_offset_by_a_register_of_the_listing_displaces_the_position() {
    let shifted = |option: &str, more: &str| match goal(
        &format!("J P[1] 100% FINE\nL P[3] 100mm/sec FINE {option}\n{more}"),
        &[],
        &[],
    ) {
        Goal::Pose(p) => (p.shift.clone().map(|s| *s), format!("{:?} {:?}", p.frame, p.tool), p.position_m),
        other => panic!("{other:?}"),
    };
    let up = Vector3::new(0.0, 0.0, -0.02);
    let (shift, _, at) = shifted("Offset,PR[4:up]", "");
    assert!(shift == Some(Shift::in_frame(up)) && (at - Vector3::new(0.9, 0.0, 0.28)).norm() < 1e-12, "{at:?}");
    // a comment on the register is none on the kind of offset
    let (named, ..) = shifted("Offset,PR[4:TOOL UP]", "");
    assert_eq!(named, Some(Shift::in_frame(up)));
    // the tool points down
    let (shift, _, at) = shifted("Tool_Offset,PR[4]", "");
    assert!(
        shift == Some(Shift::of_pose(nalgebra::Translation3::from(up).into())) && (at.z - 0.32).abs() < 1e-12,
        "{at:?}"
    );
    for (option, more) in [
        ("Offset,PR[5]", ""),
        ("Offset,PR[4]", "PR[4,3]=R[1]"),
        ("Offset,PR[1]", ""),
        ("Offset,PR[R[1]]", ""),
        ("Offset", ""),
    ] {
        let (shift, frames, _) = shifted(option, more);
        assert!(shift.is_none() && frames.contains("with OFFSET"), "{option} {more}: {frames}");
    }
}

#[test]
fn a_register_that_is_not_known_is_a_whole_place_and_an_increment_is_none() {
    let absolute = |lines: &str| script(lines, &[], &[]).moves().nth(1).is_some_and(|(_, m)| m.absolute);
    const TO: &str = "J P[1] 50% FINE\n";
    for line in [
        "L PR[9] 100mm/sec FINE",
        "J PR[R[1]] 50% CNT100",
        "L P[R[2]] 100mm/sec FINE",
        "L PR[9] 100mm/sec FINE Offset,PR[8]",
        "J P[2] 50% FINE Offset,PR[8]",
    ] {
        assert!(absolute(&format!("{TO}{line}")), "{line}");
    }
    for line in [
        "L PR[9] 100mm/sec FINE INC",
        "L P[2] 100mm/sec FINE INC",
        "C P[2]\n    PR[9] 100mm/sec FINE",
        "L PR[9] 100mm/sec FINE Skip,LBL[1]",
        "L PR[9] 100mm/sec FINE COORD",
        "L P[9] 100mm/sec FINE",
    ] {
        assert!(!absolute(&format!("{TO}{line}")), "{line}");
    }
}
