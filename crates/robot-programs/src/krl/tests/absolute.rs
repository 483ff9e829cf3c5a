//! Which goals that cannot be determined are whole places all the same.

use super::*;

/// Letters of the moves: `a` where the goal is one, `o` where it is another one that is not known.
fn kinds(lines: &str, list: &str) -> String {
    let src = format!("DEF a()\n{lines}END\n");
    let d = doc(&[src.as_bytes(), format!("DEFDAT a\n{list}ENDDAT\n").as_bytes()]);
    let letter = |m: &Move| match m.goal {
        Goal::Opaque(_) if m.absolute => 'a',
        Goal::Opaque(_) => 'o',
        _ => 'k',
    };
    d.script().moves().map(|(_, m)| letter(m)).collect()
}

const POSE: &str = "{X 900.0,Y 0.0,Z 800.0,A 0.0,B 90.0,C 0.0,S 2,T 2}";
const AXES: &str = "{A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 45.0,A6 0.0}";

#[test]
fn a_point_that_is_declared_whole_stays_whole_where_its_parts_are_assigned() {
    let list = format!("DECL E6POS XP={POSE}\nDECL E6POS XQ={POSE}\nDECL E6AXIS XA={AXES}\n");
    let of = |lines: &str| kinds(lines, &list);
    assert_eq!(of("XP.Z=XP.Z+100\nLIN XP\nPTP XP C_PTP\n"), "aa");
    assert_eq!(of("XA.A1=n\nPTP XA\n"), "a");
    assert_eq!(of("XP=XQ\nXP.Z=XP.Z+h\nLIN XP\n"), "a");
    assert_eq!(of("XP=XQ\nXQ=XP\nXQ.Z=1\nLIN XP\n"), "o", "copies in a circle");
    // a list with all parts, computed or not; a product
    assert_eq!(of("LIN {X 900.0,Y n,Z h+1,A 0.0,B 90.0,C 0.0}\n"), "a");
    assert_eq!(of("XP.Z=h\nLIN XP:{X 0.0,Y 0.0,Z 5.0,A 0.0,B 0.0,C 0.0}\n"), "a");
    // parts, calls, where the robot stands, arcs and relative motions
    for lines in [
        "LIN {Z h}\n",
        "PTP {A1 n}\n",
        "XP.Z=h\nLIN XP:{Z 5.0}\n",
        "LIN f(XQ)\n",
        "LIN {X f(1),Y n,Z h+1,A 0.0,B 90.0,C 0.0}\n",
        "LIN {X $POS_ACT.X,Y n,Z h+1,A 0.0,B 90.0,C 0.0}\n",
        "XP.Z=h\nLIN_REL {Z h}\n",
        "XP.Z=h\nCIRC XQ,XP\n",
        "LIN XE\n",
        "XP.Z=h\nf(XP)\nLIN XP\n",
        "XP={Z 5.0}\nXP.X=h\nLIN XP\n",
        "XP=g()\nLIN XP\n",
    ] {
        assert_eq!(of(lines), "o", "{lines}");
    }
}

#[test]
fn a_point_without_a_value_may_lack_parts() {
    assert_eq!(kinds("XP.Z=5\nLIN XP\n", "DECL E6POS XP\n"), "o");
    assert_eq!(kinds("XP.Z=5\nLIN XP\n", "DECL E6POS XP={X 5.0,Y 0.0}\n"), "o");
    let set = format!("XP={POSE}\nXP.Z=n\nLIN XP\n");
    assert_eq!(kinds(&set, "DECL E6POS XP\n"), "a");
    assert_eq!(kinds(&format!("IF n==1 THEN\n{set}ENDIF\nLIN XP\n"), "DECL E6POS XP\n"), "oo");
}

#[test]
fn an_element_by_a_computed_index_is_whole_where_all_are() {
    let of = |lines: &str, second: &str| kinds(lines, &format!("DECL E6POS P[2]\nP[1]={POSE}\nP[2]={second}\n"));
    assert_eq!(of("LIN P[n]\n", POSE), "a");
    assert_eq!(of("LIN P[n]\n", "{X 5.0}"), "o");
    assert_eq!(of("P[n]=XQ\nLIN P[n]\n", POSE), "o");
    assert_eq!(of("P[n].X=5\nLIN P[2]\n", POSE), "o");
    assert_eq!(of("LIN P[f(1)]\n", POSE), "o");
}

/// By move: whether its goal stays, and whether it is closed to new points.
fn kept(lines: &str, list: &str) -> Vec<(bool, bool)> {
    let src = format!("DEF a()\n{lines}END\n");
    let d = doc(&[src.as_bytes(), format!("DEFDAT a\n{list}ENDDAT\n").as_bytes()]);
    d.script().moves().map(|(_, m)| (m.fixed.is_some(), m.closed.is_some())).collect()
}

#[test]
fn the_move_before_a_goal_that_lacks_parts_stays_and_no_point_comes_between() {
    let (whole, to) = ("LIN {X 900.0,Y 0.0,Z 800.0,A 0.0,B 90.0,C 0.0}\n", "PTP {A1 5.0,A2 -90.0}\n");
    let list = "DECL POS XP={X 900.0,Y 200.0,Z 800.0}\nDECL FRAME XF={X 1.0,Y 2.0,Z 3.0,A 5.0}\nDECL E6AXIS XA={A1 10.0,A2 -90.0}\n";
    let (free, stays, shut) = ((false, false), (true, false), (false, true));
    for goal in ["XP", "XF", "{X 900.0,Y 200.0,Z 800.0}"] {
        let all = kept(&format!("{whole}{whole}LIN {goal}\n{whole}"), list);
        assert_eq!(all, [free, stays, shut, free], "{goal}");
    }
    assert_eq!(kept(&format!("{whole}{whole}LIN {{Z 800.0}}\n"), list)[..2], [free, stays]);
    // on several ways
    let branches = format!("IF x THEN\n{whole}ELSE\n{to}ENDIF\n$OUT[1]=TRUE\nPTP XP\n{whole}");
    assert_eq!(kept(&branches, list), [stays, stays, shut, free]);
    let around = format!("{whole}LOOP\nLIN XP\n{whole}{to}ENDLOOP\n");
    assert_eq!(kept(&around, list), [stays, shut, free, stays]);
    // axes that a joint target does not name stay where they are commanded, and points on its way leave them there
    assert_eq!(kept(&format!("{to}PTP XA\n{to}"), list), [free; 3]);
}

#[test]
fn the_last_move_before_a_routine_that_begins_with_a_goal_that_lacks_parts_stays() {
    let to = "PTP {A1 5.0,A2 -90.0}\n";
    let src = format!("DEF a()\n{to}{to}b()\n{to}END\nDEF b()\nLIN {{X 900.0,Y 200.0,Z 800.0}}\n{to}END\n");
    let d = doc(&[src.as_bytes()]);
    let fixed: Vec<bool> = d.script().moves().map(|(_, m)| m.fixed.is_some()).collect();
    assert_eq!(fixed, [false, true, false, false, false]);
}

#[test]
fn a_goal_with_some_of_its_angles_cannot_be_determined_and_the_move_before_it_stays() {
    let whole = "LIN {X 900.0,Y 0.0,Z 800.0,A 0.0,B 90.0,C 0.0}\n";
    let of = |angles: &str| {
        let at = format!("{{X 900.0,Y 200.0,Z 800.0{angles}}}");
        let [inline, declared] = [&at, "XP"].map(|goal| {
            let src = format!("DEF a()\n{whole}{whole}LIN {goal}\n{whole}END\n");
            let d = doc(&[src.as_bytes(), format!("DEFDAT a\nDECL POS XP={at}\nENDDAT\n").as_bytes()]);
            let all: Vec<Move> = d.script().moves().map(|(_, m)| m.clone()).collect();
            let why = match &all[2].goal {
                Goal::Opaque(why) => why.to_string().replace("XP", "its position"),
                Goal::Pose(pose) => format!("turned: {}", pose.rotation.is_some()),
                other => format!("{other:?}"),
            };
            (why, all.iter().map(|m| m.fixed.is_some()).collect::<Vec<_>>())
        });
        if !angles.contains('n') {
            assert_eq!(inline, declared, "{angles}");
        }
        (inline.0, inline.1[1])
    };
    let missing = ("a part of its position is not given".to_string(), true);
    for angles in [",A 5.0", ",B 5.0", ",C 5.0", ",A 5.0,B 6.0", ",A 5.0,C 6.0", ",B 5.0,C 6.0", ",A n,B 5.0"] {
        assert_eq!(of(angles), missing, "{angles}");
    }
    assert_eq!(of(""), ("turned: false".to_string(), true));
    assert_eq!(of(",A 5.0,B 6.0,C 7.0"), ("turned: true".to_string(), false));
    // a computed angle is not that of the position before
    assert_eq!(of(",A n,B 6.0,C 7.0"), ("A of its position is an expression".to_string(), false));
}
