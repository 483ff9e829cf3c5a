//! Relative motions: where they lead, and what stays as it is because of them.

use super::*;
use crate::script::harness::opaque;

/// Moves of lines after a point at which the tool looks along the base's x.
fn of(lines: &str) -> Vec<Move> {
    let at = "LIN {X 500,Y 100,Z 900,A 0,B 90,C 0}\n";
    let d = doc(&[format!("DEF p( )\n{at}{lines}LIN {{X 500,Y 100,Z 950,A 0,B 90,C 0}}\nEND\n").as_bytes()]);
    moves(d.as_ref()).into_iter().map(|m| m.1).collect()
}

fn position_mm(m: &Move) -> Option<[f64; 3]> {
    let Goal::Pose(pose) = &m.goal else { return None };
    Some([0, 1, 2].map(|k| (pose.position_m[k] * 1e9).round() * 1e-6))
}

#[test]
fn a_relative_motion_after_a_known_place_counts_along_the_base_or_the_tool() {
    for (line, expected) in [
        ("LIN_REL {X 10,Z -20.5}\n", [510.0, 100.0, 879.5]),
        ("LIN_REL {X 10,Z -20.5} #BASE\n", [510.0, 100.0, 879.5]),
        // the tool's z is the base's x, its x points down
        ("LIN_REL {Z 30} C_DIS #TOOL\n", [530.0, 100.0, 900.0]),
        ("lin_rel {x 5,Y 1,A 0,B 0,C 0}#TOOL\n", [500.0, 101.0, 895.0]),
        ("SLIN_REL {Z 300}  C_SPL\n", [500.0, 100.0, 1200.0]),
    ] {
        let m = of(line);
        assert_eq!(position_mm(&m[1]), Some(expected), "{line}");
        assert!(m[1].fixed.is_some() && m[1].goal.target().is_none(), "{line}");
        assert!(m[0].fixed.as_ref().is_some_and(|w| w.to_string().contains("carry")) && m[2].fixed.is_none(), "{line}");
    }
    let twice = of("LIN_REL {Z 10}\nn=n+1\nLIN_REL {Z 10}\n");
    assert_eq!(position_mm(&twice[2]), Some([500.0, 100.0, 920.0]));
}

#[test]
fn a_relative_motion_is_not_known_where_it_turns_or_the_place_before_is_not_certain() {
    for line in [
        "LIN_REL {Z 10,A 5}\n",
        "LIN_REL {Z n}\n",
        "LIN_REL P1\n",
        "LIN_REL {Z 10\n",
        "PTP_REL {Z 10}\n",
        "PTP_REL {A1 5}\n",
        "CIRC_REL {X 1},{X 2}\n",
        "LIN_REL {Z 10} WITH $BASE=$NULLFRAME\n",
        "$BASE=$NULLFRAME\nLIN_REL {Z 10}\n",
        "BAS(#TOOL,2)\nLIN_REL {Z 10}\n",
        "IF n>1 THEN\nLIN_REL {Z 10}\nENDIF\n",
        "may_move()\nLIN_REL {Z 10}\n",
        "LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_DIS\nLIN_REL {Z 10}\n",
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nLIN_REL {Z 10}\n",
        "LIN XP1\nLIN_REL {Z 10}\n",
    ] {
        let m = of(line);
        let relative = m.iter().rev().nth(1).unwrap();
        assert!(opaque(relative).contains("relative"), "{line}");
        // the one before does not carry an offset into it, whatever stands between
        let before = m.iter().rev().nth(2).unwrap();
        assert!(before.fixed.is_some() || matches!(before.goal, Goal::Opaque(_)), "{line}");
    }
}

#[test]
fn axis_values_that_count_from_known_ones_are_known_and_stay() {
    let of = |lines: &str| {
        let d = doc(&[format!("DEF p( )\n{lines}END\n").as_bytes()]);
        let m = moves(d.as_ref());
        let last = m.last().unwrap();
        let angles = deg(d.as_ref(), &last.1);
        (
            angles.iter().map(|v| v.map(|v| (v * 1e6).round() * 1e-6)).collect::<Vec<_>>(),
            last.1.fixed.is_some(),
            last.1.relative,
        )
    };
    let at = "PTP {A1 10,A2 -90,A3 90,A4 0,A5 0,A6 0}\n";
    let to = |a1: f64, a6: Option<f64>| (vec![Some(a1), None, None, None, None, a6], true, true);
    assert_eq!(of(&format!("{at}PTP_REL {{A1 5.5}}\n")), to(15.5, None));
    assert_eq!(of(&format!("{at}PTP {{A1 20,A6 0}}\nSPTP_REL {{A6 -0.001,A1 1}} C_PTP\n")), to(21.0, Some(-0.001)));
    assert_eq!(of(&format!("{at}PTP_REL {{A6 2}}\nPTP_REL {{A1 5,A6 1}}\n")), to(15.0, Some(3.0)));
    // after lines that are read by the one before them
    let others = ["20", "30", "7"].map(|a1| at.replacen("10", a1, 1)).concat();
    assert_eq!(of(&format!("{at}{others}PTP_REL {{A1 5}}\n")), to(12.0, None));
    assert_eq!(of(&format!("{at}{others}PTP_REL {{A2 -1}}\nPTP_REL {{A1 1}}\n")), to(8.0, None));
    for lines in [
        "PTP_REL {A1 5}\n",
        "PTP {A1 5,A2 -90}\nPTP {A2 -80}\nPTP_REL {A1 5}\n",
        "PTP {A1 5} C_PTP\nPTP_REL {A1 5}\n",
        "PTP {A1 5}\nmay_move()\nPTP_REL {A1 5}\n",
        "PTP {A1 5}\nL1:\nPTP_REL {A1 5}\n",
        "PTP {A1 5}\nLIN {X 500,Y 0,Z 900,A 0,B 90,C 0}\nPTP_REL {A1 5}\n",
        "PTP {A1 5}\nPTP_REL {A1 n}\n",
        "PTP {A1 5}\nPTP_REL {A1 5,E1 3}\n",
        "PTP {A1 5}\nPTP_REL {Z 5}\n",
        "PTP {A1 5}\nPTP_REL P1\n",
        "PTP {A1 5}\nLIN_REL {A1 5}\n",
    ] {
        assert!(of(lines).0.is_empty(), "{lines}");
    }
    // the point before it stays, and new points are none of its
    let d = doc(&[format!("DEF p( )\n{at}PTP_REL {{A1 5}}\nPTP {{A1 0}}\nEND\n").as_bytes()]);
    let m = moves(d.as_ref());
    assert_eq!(m.iter().map(|m| m.1.fixed.is_some()).collect::<Vec<_>>(), [true, true, false]);
    assert!(m[1].1.closed.is_some() && m[2].1.closed.is_none());
}

#[test]
fn a_relative_motion_leaves_external_axes_where_they_are() {
    let closed = |lines: &str| {
        let d = doc(&[format!("DEF p( )\n{lines}END\n").as_bytes()]);
        moves(d.as_ref()).last().unwrap().1.closed.is_some()
    };
    let to = |z: u32, e: &str| format!("LIN {{X 500,Y 0,Z {z},A 0,B 90,C 0{e}}}\n");
    assert!(!closed(&format!("{}LIN_REL {{Z 10}}\n{}", to(900, ""), to(950, ""))));
    assert!(!closed(&format!("{}PTP_REL {{A1 10}}\n{}", to(900, ""), to(950, ""))));
    assert!(!closed(&format!("{}{}LIN_REL {{Z 10}}\n{}", to(900, ",E1 0"), to(900, ",E1 5"), to(950, ",E1 5"))));
    // it may move to the place after it, or may have been moved before
    assert!(closed(&format!("{}{}LIN_REL {{Z 10}}\n{}", to(900, ",E1 0"), to(900, ",E1 5"), to(950, ",E1 0"))));
    assert!(closed(&format!("{}L1:\nLIN_REL {{Z 10}}\n{}", to(900, ",E1 5"), to(950, ",E1 0"))));
    assert!(closed(&format!("{}LIN_REL {{Z 10,E1 5}}\n{}", to(900, ""), to(950, ""))));
    assert!(closed(&format!("{}LIN_REL P1\n{}", to(900, ""), to(950, ""))));
}

/// Which moves of a text stay, with the modules beside it.
fn fixed(src: &str, beside: &str) -> Vec<bool> {
    let mut texts = vec![Text::new("a.src", src.as_bytes().to_vec())];
    texts.push(Text::of_context("b.src", beside.as_bytes().to_vec()));
    let d = Krl.parse(texts, &kr120()).unwrap();
    moves(d.as_ref()).iter().map(|m| m.1.fixed.is_some()).collect()
}

#[test]
fn moves_from_which_a_relative_motion_may_count_stay() {
    let (a, b, relative) = ("PTP {A1 5}\n", "PTP {A1 9}\n", "PTP_REL {A1 2}\n");
    for (lines, expected) in [
        // both branches end before it
        (format!("IF $IN[1] THEN\n{b}{a}ELSE\n{b}ENDIF\n{relative}{a}"), vec![false, true, true, false, true]),
        // so does the loop itself
        (format!("{a}LOOP\n{relative}{b}{a}ENDLOOP\n"), vec![true, false, false, true]),
        (format!("{a}IF $IN[1] THEN\nGOTO L1\nENDIF\n{b}L1:\n{relative}"), vec![true, true, true]),
        // a routine that is called from two places
        (
            format!("{a}sub()\n{b}{a}sub()\n{b}{a}END\nDEF sub()\n{relative}{a}{b}"),
            vec![true, false, true, false, true, false, false, true],
        ),
    ] {
        let src = format!("DEF a()\n{lines}END\n");
        assert_eq!(fixed(&src, ""), expected, "{src}");
    }
    // one of another module, and one that calls it
    for (beside, stays) in [
        (format!("DEF sub()\n{relative}END\n"), true),
        (format!("DEF sub()\n{a}END\n"), false),
        (format!("DEF sub()\nother()\nEND\nDEF other()\n{relative}END\n"), true),
    ] {
        assert_eq!(fixed(&format!("DEF a()\n{a}{b}sub()\n{a}END\n"), &beside), [false, stays, false], "{beside}");
    }
}

#[test]
fn a_motion_after_which_the_program_reads_its_place_keeps_its_goal() {
    let (a, b) = ("PTP {A1 5}\n", "PTP {A1 9}\n");
    for (read, kept) in [
        ("HERE=$POS_ACT\n", true),
        ("HERE.Z=$pos_act.z+100\n", true),
        ("Q[1]=$AXIS_ACT\nWAIT SEC 1\n", true),
        ("IF $POS_ACT.X>5 THEN\nN=1\nENDIF\n", true),
        ("WAIT FOR $AXIS_ACT.A1>5\n", true),
        ("CWRITE(h,s,m,\"%r\",$POS_ACT)\n", false),
        ("N=1 ;$POS_ACT\n", false),
    ] {
        let src = format!("DEF a()\n{a}{b}{read}{a}{b}END\n");
        assert_eq!(fixed(&src, ""), [false, kept, false, false], "{read}");
    }
    // a call may move nothing
    assert_eq!(fixed(&format!("DEF a()\n{a}X()\nHERE=$POS_ACT\n{b}END\n"), ""), [true, false]);
    // in a routine of another file, also two calls deep
    for beside in ["DEF rd()\nHERE=$POS_ACT\nEND\n", "DEF rd()\nget()\nEND\nDEF get()\nHERE=$POS_ACT\nEND\n"] {
        assert_eq!(fixed(&format!("DEF a()\n{a}{b}rd()\n{a}other()\nEND\n"), beside), [false, true, false], "{beside}");
    }
    // along control: after a jump, in the next pass, after a routine, in a routine, when the program runs again
    let read = "HERE=$POS_ACT\n";
    let cases: [(String, &[bool]); 7] = [
        (format!("DEF a()\n{a}GOTO L\n{a}L:\n{read}{b}END\n"), &[true, false, false]),
        (format!("DEF a()\n{a}LOOP\n{read}{a}{b}ENDLOOP\nEND\n"), &[true, false, true]),
        (format!("DEF a()\n{a}REPEAT\n{b}UNTIL $POS_ACT.X>5\n{a}END\n"), &[false, true, false]),
        (format!("DEF a()\n{a}s()\n{read}{a}END\nDEF s()\n{b}{b}END\n"), &[false, false, false, true]),
        (format!("DEF a()\n{a}{b}s()\n{a}END\nDEF s()\n{read}END\n"), &[false, true, false]),
        (format!("DEF a()\n{read}{a}{b}END\n"), &[false, true]),
        (format!("DEF a()\nINTERRUPT DECL 3 WHEN $IN[1] DO s()\n{a}{b}END\nDEF s()\n{read}END\n"), &[false, false]),
    ];
    for (src, kept) in cases {
        assert_eq!(fixed(&src, ""), kept, "{src}");
    }
}

#[test]
fn the_last_move_before_a_routine_of_another_file_that_begins_with_a_goal_that_lacks_parts_stays() {
    let (to, whole) = ("PTP {A1 5.0,A2 -90.0}\n", "LIN {X 900.0,Y 0.0,Z 800.0,A 0.0,B 90.0,C 0.0}\n");
    let lacks = "LIN {X 900.0,Y 200.0,Z 800.0}\n";
    let fixed = |first: &str, more: &str| {
        let src = format!("DEF a()\nEXT sub2()\n{to}{to}sub2()\n{whole}{to}END\nDEF own()\n{lacks}END\n");
        let beside = format!("DEF sub2()\n{first}{to}END\n{more}");
        let list = "DEFDAT sub2\nDECL POS XQ={X 900.0,Y 200.0,Z 800.0}\nDECL E6POS XW={X 9.0,Y 2.0,Z 8.0,A 0.0,B 9.0,C 0.0}\nENDDAT\n";
        let mut texts = vec![Text::new("a.src", src.into_bytes())];
        texts.push(Text::of_context("sub2.src", beside.into_bytes()));
        texts.push(Text::of_context("sub2.dat", list.as_bytes().to_vec()));
        let d = Krl.parse(texts, &kr120()).unwrap();
        d.script().moves().take(3).map(|(_, m)| m.fixed.is_some()).collect::<Vec<bool>>()
    };
    let (free, stays) = ([false; 3], [false, true, false]);
    let deep = format!("DEF sub3()\n{lacks}END\n");
    for (first, more) in [
        (lacks, ""),
        ("LIN XQ\n", ""),
        ("CIRC XW,XQ\n", ""),
        ("sub3()\n", deep.as_str()),
        ("own()\n", ""),
        (&format!("IF x THEN\n{whole}ENDIF\n{lacks}"), ""),
        (&format!("IF x THEN\nGOTO L\nENDIF\n{whole}L:\n{lacks}"), ""),
        (&format!("PTP {{A1 5.0}}\n{lacks}"), ""),
    ] {
        assert_eq!(fixed(first, more), stays, "{first}");
    }
    // what it lacks is then that of another place
    for (first, more) in [
        (&format!("{whole}{lacks}") as &str, ""),
        (&format!("LIN XW\n{lacks}"), ""),
        (&format!("{whole}sub3()\n"), deep.as_str()),
        (whole, deep.as_str()),
    ] {
        assert_eq!(fixed(first, more), free, "{first}");
    }
}
