//! Stations, rails and second groups.

use super::*;

#[test]
fn second_groups_stations_arcs_and_conditions_take_no_new_points() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1,1,1,1,1,1\nEC00000=0,5\nEC00001=7,5";
    let text = job(
        "2,0,2,0,0,0",
        list,
        "MOVJ C00000 VJ=25.00  +MOVJ C00001 VJ=25.00\nMOVJ C00000 EC00000 VJ=5.00\nMOVJ C00001 EC00000 VJ=5.00\n\
         MOVL C00000 EC00001 V=5.0\nSMOVL C00000 V=5.0\n+MOVJ EC00000\nMOVC C00000 V=5.0\nMOVL C00000 V=5.0 UNTIL IN#(16)=ON\n\
         MOVL C00000 V=5.0 FOO=1\nMOVL C00000 V=5.0 NWAIT\nDOUT OT#(1) ON",
    );
    let script = script_of(&Inform, &text, &robot());
    let closed: Vec<bool> = moves(&script).iter().map(|m| m.1.closed.is_some()).collect();
    assert_eq!(closed, [true, true, false, true, true, true, true, true, true]);
}

#[test]
fn a_move_with_which_the_next_instruction_runs_takes_no_new_points() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1,1,1,1,1,1";
    for (next, closed) in [
        ("DOUT OT#(1) ON", true),
        ("'a comment\n\nDOUT OT#(1) ON", true),
        ("CALL JOB:GLUE", true),
        ("JUMP *A IF IN#(1)=ON\nMOVJ C00000 VJ=5.00", true),
        ("*B\nPULSE OT#(1)", true),
        ("JUMP *A\nMOVJ C00000 VJ=5.00", true),
        ("", true),
        ("MOVL C00000 V=5.0 NWAIT\nMOVJ C00001 VJ=5.00", false),
        ("'a comment\n*B\nMOVL C00000 V=5.0", false),
        ("JUMP *C", false),
    ] {
        let lines = format!("*A\nDOUT OT#(2) ON\n*C\nMOVJ C00000 VJ=5.00\nMOVL C00001 V=5.0 NWAIT\n{next}");
        let script = script_of(&Inform, &job("2,0,0,0,0,0", list, lines.trim_end()), &robot());
        let why = moves(&script)[1].1.closed.clone();
        assert_eq!(why.is_some(), closed, "{next}: {why:?}");
        assert!(why.is_none_or(|why| why.to_string().contains("NWAIT")));
    }
}

#[test]
fn a_new_point_of_a_move_with_a_station_that_stands_gets_a_station_line_of_its_own() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1,1,1,1,1,1\n///TOOL 1\nEC00000=0,5";
    let text = job("2,0,1,0,0,0", list, "MOVJ C00000 EC00000 VJ=5.00\nMOVJ C00001 EC00000 VJ=5.00");
    let out = written(&text, &[(2, None, vec![[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])]);
    assert!(out.contains("NPOS 3,0,2,0,0,0") && out.contains("EC00000=0,5\r\nEC00001=0,5\r\n//INST"), "{out}");
    assert!(out.contains("MOVJ C00002 EC00001 VJ=5.00\r\nMOVJ C00001 EC00000"), "{out}");
}

#[test]
fn a_rail_of_the_robot_file_is_read_from_the_base_axis() {
    let robot = fixtures::ma2010_on_a_rail();
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nBC00000=-5000";
    let text = job("1,1,0,0,0,0", list, "MOVJ C00000 BC00000 VJ=5.00");
    let script = script_of(&Inform, &text, &robot);
    assert!((values(&script, 1)[6] - 0.05).abs() < 1e-15);
    let mut edits = Edits { digit: vec![1e-9; 7], ..Edits::default() };
    edits.steps.insert(1, Edit { goal: Some([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.051].to_vec()), ..Edit::default() });
    let out = edited(&Inform, text.as_bytes(), &edits, &robot).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), text.replace("=-5000", "=-5100"));
}

#[test]
fn a_rail_under_the_arm_is_the_base_axis_and_no_joint_of_it() {
    let on_rail = fixtures::ma2010_on_a_rail();
    let mut joints: Vec<_> = on_rail.axis_joints().cloned().collect();
    joints.rotate_right(1);
    joints[0].name = "E1".into();
    let robot = Axes::new("rail first", joints);
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=1000,2,3,4,5,6\nBC00000=-5000\n///TOOL 0\nEC00000=7";
    let text = job("1,1,1,0,0,0", list, "MOVJ C00000 BC00000 VJ=5.00\nMOVJ C00000 EC00000 VJ=5.00");
    let script = script_of(&Inform, &text, &robot);
    let own = values(&script, 1);
    assert!((own[0] - 0.05).abs() < 1e-15 && own[1] > 0.0 && own.len() == 7, "{own:?}");
    // a station is no rail
    assert!(matches!(&moves(&script)[1].1.goal, Goal::Opaque(why) if why.to_string().contains("base axes")));
    let mut edits = Edits { digit: vec![1e-9; 7], ..Edits::default() };
    let goal = [&[0.051], &own[1..]].concat();
    edits.steps.insert(1, Edit { goal: Some(goal), ..Edit::default() });
    let out = edited(&Inform, text.as_bytes(), &edits, &robot).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), text.replace("=-5000", "=-5100"));
}

/// A line that is read like the one before it may have a line of another group after a comment.
#[test]
fn a_station_that_moves_after_a_comment_is_seen_beside_moves_that_are_alike() {
    let list =
        "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1,1,1,1,1,1\nC00002=2,2,2,2,2,2\nEC00000=0\nEC00001=9";
    let ways = |between: &str| {
        let text = job(
            "3,0,2,0,0,0",
            list,
            &format!(
                "MOVJ C00000 VJ=25.00 +MOVJ EC00000\nMOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\n{between}SMOVL C00002 V=5.0 +MOVJ EC00000\nDOUT OT#(1) ON"
            ),
        );
        let script = script_of(&Inform, &text, &robot());
        moves(&script).last().unwrap().1.other_way
    };
    assert_eq!(ways(""), None);
    assert_eq!(ways("' a comment\n+MOVJ EC00001\n"), Some(crate::script::OtherWay::Carried));
}
