//! Canned cycles: X and Y of a hole are targets, and nothing else of a cycle is.

use super::*;

const FROM: &str = "G21 G90 G17\nG0 X0.0 Y0.0 Z20.0\n";

/// The moves: goals in mm (NaN: not commanded), or why there is none.
fn told(text: &str) -> Vec<std::result::Result<Vec<f64>, String>> {
    let script = script_of(&Gcode, text, &robot());
    let one = |(k, m): &(usize, crate::script::Move)| match &m.goal {
        Goal::Opaque(why) => Err(why.to_string()),
        _ => Ok(values(&script, *k).iter().map(|v| (v * 1e9).round() / 1e6).collect()),
    };
    moves(&script).iter().map(one).collect()
}

/// Whether the block leads to a hole that is known.
fn is_hole(text: &str, nth: usize) -> bool {
    matches!((told(text).get(nth), told(text).get(nth + 1)), (Some(Ok(q)), Some(Err(_))) if q[2].is_nan())
}

#[test]
fn holes_are_reached_as_by_a_g0_and_their_depth_is_none() {
    for cycle in ["G81", "G82 P0.5", "G83 Q1.0", "G73 Q1.0", "G84", "G74", "G85", "G86", "G89 P1", "G98 G81", "G81 G99"]
    {
        let text = format!("{FROM}{cycle} X30.0 Y20.0 Z-5.0 R2.0 F100\nX50.0\nY[10+5] R3.0\nG80\nG0 X1.0\n");
        let found = told(&text);
        let goal = |k: usize| found[k].clone().unwrap();
        assert!(goal(1)[..2] == [30.0, 20.0] && goal(1)[2].is_nan(), "{cycle}: {found:?}");
        assert!(goal(3)[0] == 50.0 && goal(3)[1].is_nan(), "{cycle}: {found:?}");
        assert!(goal(5)[0].is_nan() && goal(5)[1] == 15.0, "{cycle}: {found:?}");
        assert!([2, 4, 6].iter().all(|k| found[*k].as_ref().is_err_and(|why| why.contains("the hole itself"))));
        assert_eq!(found.len(), 8, "{cycle}");
    }
}

#[test]
fn words_of_holes_are_changed_in_x_and_y_alone_and_no_point_is_added() {
    let text = format!("{FROM}G98 G81 Z-5. R2.0 F100 X30. Y20.\nX50.\nY25. Z-6.\nG80\nG0 Z30.0\nX1.0\n");
    let at = |x: f64, y: f64| Some([x, y, 20.01]);
    let out =
        written(&text, &[(1, at(30.01, 20.0), vec![]), (3, at(50.01, 20.02), vec![]), (5, at(50.01, 25.02), vec![])]);
    let wanted = text.replace("X30.", "X30.01").replace("X50.", "X50.01 Y20.02").replace("Y25.", "Y25.02");
    assert_eq!(out, wanted);
    let script = script_of(&Gcode, &text, &robot());
    let closed: Vec<bool> = moves(&script).iter().map(|m| m.1.closed.is_some()).collect();
    assert!(closed[1] && closed[3] && closed[5] && !closed[7]);
    // after it Z alone is not known
    let alone: Vec<_> =
        moves(&script).iter().map(|m| m.1.moves_alone.map(|a| (a.has(0), a.has(1), a.has(2)))).collect();
    assert_eq!([alone[2], alone[4], alone[6]], [Some((false, false, true)); 3]);
    // but the level to which the cycle comes back from below
    let fixed = |text: &str| -> Vec<usize> {
        let script = script_of(&Gcode, text, &robot());
        moves(&script).iter().enumerate().filter(|(_, m)| m.1.fixed.is_some()).map(|(k, _)| k).collect()
    };
    assert_eq!(fixed(&text), [0]);
    assert_eq!(fixed(&text.replace("G98 ", "")), [0]);
    assert!(fixed(&text.replace("G98", "G99")).is_empty());
    assert_eq!(fixed(&text.replace("G98", "/G99")), [0]);
    assert!(fixed(&text.replace("G98 ", "").replace("G17", "G17 G99")).is_empty());
}

#[test]
fn a_cycle_without_a_place_and_one_with_its_level_alone_move_z() {
    for block in ["G81 Z-5.0 R2.0 F100", "G81 R2.0 Z-5.0 L2", "G81 Z#1 R#2"] {
        let found = told(&format!("{FROM}{block}\nX30.0\nR4.0\nG80\n"));
        assert!(found[1].is_err() && found[2].is_ok() && found[3].is_err(), "{block}: {found:?}");
        assert!(found[4].is_err() && found.len() == 5, "{block}: {found:?}");
    }
}

#[test]
fn where_a_hole_is_or_what_it_leaves_is_not_certain_the_cycle_stays() {
    for (head, block) in [
        ("", "G76 X30.0 Y20.0 Z-5.0 R2.0 Q0.5"),
        ("", "G87 X30.0 Y20.0 Z-5.0 R2.0 Q0.5"),
        ("", "G88 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G91\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G18\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G19\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G16\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G68 R30.0\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G41 D1\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("G66 P9000\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 L0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 K0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 K#1"),
        ("", "G81 X#1 Y20.0 Z-5.0 R2.0"),
        ("", "G81 X30.0 X31.0 Y20.0 Z-5.0 R2.0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 A90.0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 U1.0"),
        ("", "G85 X30.0 Y20.0 Z-5.0 R2.0 I1.0"),
        ("", "G0 G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("", "G81 G0 G83 X30.0 Y20.0 Z-5.0 R2.0"),
        ("", "/G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("", "G81 X30.0 Y20.0 Z-5.0 R2.0 ,C2.0"),
        ("", "G53 G81 X30.0 Y20.0 Z-5.0 R2.0"),
        ("", "G81 G90 G91 X30.0 Y20.0 Z-5.0 R2.0"),
        ("M98 P9100\nG90 G21 G17 G40\n", "G81 X30.0 Y20.0 Z-5.0 R2.0"),
    ] {
        let text = format!("{FROM}{head}{block}\nG80\n");
        let nth = told(&text).iter().rposition(std::result::Result::is_err).unwrap_or(0);
        assert!(nth > 0 && !is_hole(&text, nth - 1), "{head}{block}: {:?}", told(&text));
    }
    // increments of X count, those of the level do not
    assert!(!is_hole(&format!("{FROM}G81 X30 Y20. Z-5.0 R2.0\n"), 1));
    assert!(is_hole(&format!("{FROM}G81 X30.0 Y20.0 Z-5. R2\n"), 1));
    // lathes and printers have other words of these names
    assert!(!is_hole("G21 G90\nG96 S100\nG0 X50.0 Z5.0\nG83 X30.0 Z-5.0 R2.0\n", 1));
    assert!(!is_hole("M104 S200\nG21 G90\nM83\nG1 X10 Y10 Z2 E1 F3000\nG81 X30 Y20 Z-5 R2\n", 1));
    let mut lathe = robot();
    lathe.control.diameter = Some(true);
    let script = script_of(&Gcode, &format!("{FROM}G81 X30.0 Y20.0 Z-5.0 R2.0\n"), &lathe);
    assert!(script.moves().last().is_some_and(|m| m.1.moves_alone.is_none()));
}

#[test]
fn relative_words_count_from_before_the_cycle() {
    let fixed = |text: &str| -> Vec<bool> {
        moves(&script_of(&Gcode, text, &robot())).iter().map(|m| m.1.fixed.is_some()).collect()
    };
    let holes = "G99 G81 X30.0 Y20.0 Z-5.0 R2.0 F100\nX50.0\nG80\n";
    let text = |after: &str| format!("{FROM}G1 Z10.0 F100\nG0 X5.0\n{holes}{after}\n");
    assert_eq!(fixed(&text("G91 G0 Z5.0"))[..5], [false, false, true, false, false]);
    assert_eq!(fixed(&text("G90 G0 Z5.0"))[..5], [false; 5]);
    // X goes on from its hole
    let found = fixed(&text("G91 G0 X5.0\nX1.0"));
    assert_eq!(found[..7], [false; 7], "{found:?}");
    // the last relative words before a cycle take back what is left
    let text = format!("{FROM}G91 G1 Z-1.0 F100\nG90 G81 Z-5.0 R2.0\nX5.0\n");
    assert_eq!(fixed(&text)[..2], [false, true]);
}

#[test]
fn no_word_of_another_axis_comes_into_a_cycle() {
    // what must end where it always did is the move before it, with all its axes
    let text = format!("{FROM}G0 X5.0 Z10.0\nG81 X30.0 Z-5.0 R2.0 F100\nG80\nM98 P9100\n");
    let script = script_of(&Gcode, &text, &robot());
    let all = moves(&script);
    let kept: Vec<bool> = all.iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(kept, [false, true, true, false]);
    assert!(values(&script, all[2].0)[2].is_nan() && !values(&script, all[2].0)[1].is_nan());
    let text = format!("{FROM}G91 G1 Z-1.0 F100\nG90 G0 X5.0\nG99 G81 X30.0 Z-5.0 R2.0 F100\nG80\n");
    let out = written(&text, &[(1, Some([0.0, 0.0, 19.01]), vec![]), (2, Some([5.01, 0.0, 19.01]), vec![])]);
    assert!(out.contains("G99 G81 X30.0 Z-5.0 R2.0"), "{out}");
}
