//! Lathes: X as a diameter, feeds of a turn, threads.

use super::*;
use crate::axes::Axes;

/// A machine whose control says these words.
fn machine(words: &[&str]) -> Axes {
    let mut axes = robot();
    axes.control = crate::gcode::Control::of_words(words.iter().copied()).unwrap();
    axes
}

/// X and Z of every move, mm, NaN where it is not commanded, or why it stays.
fn read(text: &str, words: &[&str]) -> Vec<Result<[f64; 2], String>> {
    let script = script_of(&Gcode, text, &machine(words));
    let one = |(k, m): &(usize, crate::script::Move)| match &m.goal {
        Goal::Opaque(why) => Err(why.to_string()),
        _ => {
            let q = values(&script, *k);
            Ok([q[0], q[2]].map(|v| (v * 1e9).round() / 1e6))
        }
    };
    moves(&script).iter().map(one).collect()
}

fn x(text: &str, words: &[&str]) -> Vec<Option<f64>> {
    read(text, words).into_iter().map(|m| m.ok().map(|m| m[0]).filter(|x| !x.is_nan())).collect()
}

const HEADER: &str = "G21 G18 G40 G95\nG97 S900 M3\n";
const PART: &str = "G0 X60. Z-5.\nG1 Z-10. F.2\nX52.\nZ-45.\n";

#[test]
fn x_of_a_lathe_is_half_of_its_word_where_the_control_says_diameter() {
    let text = format!("{HEADER}{PART}");
    assert_eq!(x(&text, &["G90", "diameter"]), [Some(30.0), None, Some(26.0), None]);
    assert_eq!(x(&text, &["G90", "radius"]), [Some(60.0), None, Some(52.0), None]);
    let inches = text.replace("G21", "G20");
    assert_eq!(x(&inches, &["G90", "diameter"])[0], Some(762.0));
    // relative words and frames, too
    let text = "G21 G18 G90 G95\nG0 X60.0 Z-5.0\nG91 G1 X4.0 F0.2\nG90 G92 X10.0\nX14.0\n";
    assert_eq!(x(text, &["diameter"]), [Some(30.0), Some(32.0), Some(34.0)]);
}

#[test]
fn an_offset_of_x_is_doubled_in_a_diameter_and_that_of_z_is_not() {
    let axes = machine(&["G90", "diameter"]);
    let text = format!("{HEADER}{PART}");
    let script = script_of(&Gcode, &text, &axes);
    let wish = edits(&script, &[(2, Some([26.05, 0.0, -10.0]), vec![]), (3, Some([26.05, 0.0, -45.1]), vec![])]);
    let out = String::from_utf8(edited(&Gcode, text.as_bytes(), &wish, &axes).unwrap()).unwrap();
    assert_eq!(out, text.replace("X52.", "X52.10").replace("Z-45.", "Z-45.10"));
}

/// Radii of the arcs, mm.
fn radii(text: &str, words: &[&str]) -> Vec<f64> {
    let texts = vec![Text::new("a", text.as_bytes().to_vec())];
    let program = super::super::whole::program(texts, &machine(words)).unwrap();
    program.statements.arcs().iter().map(|a| (a.0.radius[0] * 1e6).round() / 1e6).collect()
}

#[test]
fn the_radius_and_the_centre_of_an_arc_are_no_diameters() {
    for (arc, radius) in [("G3 X52. Z-50. R27.", 27.0), ("G2 X60. Z-46. K-18.", 18.0), ("G3 X64. Z-12. I2. K0.", 2.0)] {
        let text = format!("{HEADER}G0 X60. Z-10.\n{arc} F.2\n");
        assert_eq!(radii(&text, &["G90", "diameter"]), [radius], "{arc}");
    }
    // its end is no place of the circle if X is a radius
    let text = format!("{HEADER}G0 X60. Z-10.\nG3 X64. Z-12. I2. K0. F.2\n");
    assert!(read(&text, &["G90", "radius"])[1].clone().is_err_and(|why| why.contains("different radii")));
}

#[test]
fn an_arc_between_diameters_is_written_with_the_radius_that_a_control_finds() {
    let words = ["G90", "diameter"];
    let axes = machine(&words);
    for arc in ["G3 X52. Z-50. R27.", "G3 X64. Z-12. I2. K0."] {
        let text = format!("{HEADER}G0 X60. Z-10.\n{arc} F.2\nG1 Z-65.\n");
        let end = read(&text, &words)[1].clone().unwrap();
        // the offset changes on the way
        let script = script_of(&Gcode, &text, &axes);
        let wish = edits(&script, &[(1, Some([end[0] - 0.05, 0.0, end[1] - 0.1]), vec![])]);
        let out = String::from_utf8(edited(&Gcode, text.as_bytes(), &wish, &axes).unwrap()).unwrap();
        let goal = read(&out, &words)[1].clone().unwrap();
        assert!((goal[0] - end[0] + 0.05).abs() < 1e-5 && (goal[1] - end[1] + 0.1).abs() < 1e-5, "{out}");
        assert!((radii(&text, &words)[0] - radii(&out, &words)[0]).abs() < 0.1, "{out}");
    }
}

#[test]
fn x_of_what_may_be_a_lathe_stays_until_it_is_stated_and_z_alone_does_not() {
    for header in [
        "G21 G18 G40 G90 G95\n",
        "G21 G40 G99\nG50 S2500\n",
        "G21 G40 G99\nG96 S150 M3\n",
        "G21 G40\nG92 S2500\n",
        "G21 G40\nT0101\n",
        "G21 G40\nG97 S900 M3\n",
        "G21 G40 G99\n",
    ] {
        let text = format!("{header}{PART}G1 X50. Z-60.\nG3 X52. Z-61. R2.\nG91 Z-1.\n");
        let found = read(&text, &["G90"]);
        let stays = |k: usize| found[k].as_ref().err().is_some_and(|why| why.contains("--assume diameter"));
        assert!(stays(0) && stays(2) && stays(4) && stays(5), "{header}: {found:?}");
        assert!(found[1].is_ok() && found[3].is_ok(), "{header}: {found:?}");
        assert!(script_of(&Gcode, &text, &machine(&["G90"])).diameter_unstated, "{header}");
        for words in [["G90", "diameter"], ["G90", "radius"]] {
            let script = script_of(&Gcode, &text, &machine(&words));
            assert!(!script.diameter_unstated && read(&text, &words)[0].is_ok(), "{header}");
        }
    }
}

#[test]
fn a_mill_is_no_lathe() {
    for text in [
        // arcs in G18 beside Y moves
        "G21 G90 G94\nG0 X0. Y0. Z-5.\nG18 G3 X10. Z-5. R5. F100.\nG17 G1 Y10.\n",
        "G21 G90 G18\nG0 X0. Y0. Z-5.\nG3 X10. Z-5. R5. F100.\n",
        "G21 G90 G17 G94\nG0 X0. Z-5.\nG1 X10. F100.\n",
        "G21 G90\nG0 X0. Z-5.\nG1 X10. F100.\n",
        "G21 G90 G17\nT0101 M6\nG0 X0. Z-5.\nG1 X10. F100.\n",
        "G21 G90 G17\nG0 X0. Z-5.\nG99 G81 X10. Z-8. R-6. F100.\nG0 X20.\n",
        // a limit of the spindle alone, beside Y
        "G21 G90 G17\nG92 S2500\nG0 X0. Y0. Z-5.\nG1 X10. F100.\n",
    ] {
        let found = read(text, &[]);
        assert!(!script_of(&Gcode, text, &machine(&[])).diameter_unstated && found[0].is_ok(), "{text}: {found:?}");
    }
    // driven tools with Y
    let text = "G21 G90\nG50 S2500\nT0101\nG96 S150\nG0 X60. Y0. Z-5.\n";
    assert!(script_of(&Gcode, text, &machine(&[])).diameter_unstated);
}

#[test]
fn words_of_linuxcnc_and_siemens_say_what_x_counts() {
    let part = "G0 X60.0 Z-5.0\nG1 X52.0 F0.2\n";
    for (word, of) in [("G7", 0.5), ("G8", 1.0), ("DIAMON", 0.5), ("DIAMOF", 1.0), ("diam90", 0.5)] {
        let text = format!("G21 G18 G40 G90 G95 {word}\n{part}");
        assert_eq!(x(&text, &[]), [Some(60.0 * of), Some(52.0 * of)], "{word}");
        // stronger than the robot file
        assert_eq!(x(&text, &["radius"]), [Some(60.0 * of), Some(52.0 * of)], "{word}");
    }
    // DIAM90 counts relative words in radii, the others do not
    for (word, to) in [("DIAM90", 32.0), ("DIAMON", 31.0)] {
        let text = format!("G21 G18 G40 G90 G95 {word}\nG0 X60.0 Z-5.0\nG91\nG1 X2.0 F0.2\n");
        assert_eq!(x(&text, &[]), [Some(30.0), Some(to)], "{word}");
    }
    // a change ends what is known of the position, and of two words the one that is in force at a label is not certain
    let text = format!("G21 G18 G40 G90 G95 G7\n{part}G8\nG0 X9.0\nN10 G0 X8.0\nIF [#1 EQ 1] GOTO 10\n");
    assert_eq!(x(&text, &[]), [Some(30.0), Some(26.0), Some(9.0), None]);
    // other words with these numbers, and other axes
    let text = format!("G21 G18 G40 G90 G95\nG8 P1\n{part}");
    assert_eq!(x(&text, &["diameter"])[0], Some(30.0));
    assert_eq!(x(&format!("G21 G90 G17\nG7 X0\n{part}Y1.0\n"), &[])[0], None);
    assert_eq!(x(&format!("G21 G90 G17\nDIAMON[X2]\n{part}Y1.0\n"), &[])[0], None);
}

#[test]
fn an_absolute_centre_is_not_certain_where_x_is_a_diameter() {
    let text = "G21 G18 G90 G90.1 G95\nG0 X60.0 Z-10.0\nG3 X60.0 Z-20.0 I30.0 K-15.0 F0.2\n";
    assert!(read(text, &["radius"]).iter().all(|m| !m.clone().is_err_and(|why| why.contains("diameter"))));
    assert!(read(text, &["diameter"])[1].clone().is_err_and(|why| why.contains("G90.1")));
}

#[test]
fn a_feed_of_a_turn_is_no_speed() {
    let speed = |header: &str, words: &[&str]| {
        let text = format!("G21 G18 G40 {header}\nG97 S900 M3\nG0 X60. Z-5.\nG1 Z-10. F.2\n");
        moves(&script_of(&Gcode, &text, &machine(words))).last().unwrap().1.speed
    };
    for header in ["G99", "G95", "", "G95 G98"] {
        assert_eq!(speed(header, &["G90", "diameter"]), Speed::Unknown, "{header}");
    }
    for header in ["G98", "G94"] {
        assert!(matches!(speed(header, &["G90", "diameter"]), Speed::Tcp(_)), "{header}");
    }
    // the level to which a cycle returns on mills
    let mill = "G21 G90 G17 G99\nG0 X0. Y0. Z-5.\nG1 X10. F100.\n";
    assert!(matches!(moves(&script_of(&Gcode, mill, &machine(&[])))[1].1.speed, Speed::Tcp(_)));
}

#[test]
fn a_g92_with_a_feed_cuts_a_thread_on_a_lathe() {
    let text = "G21 G18 G40 G99\nG97 S500\nG0 X24. Z-5.\nG92 X19.5 Z-30. F1.5\nX19.2\nG0 X40.\nZ-1.\n";
    let found = read(text, &["G90", "diameter"]);
    assert!(found[1].clone().is_err_and(|why| why.contains("canned cycle G92")), "{found:?}");
    assert!(found[2].clone().is_err_and(|why| why.contains("canned cycle G92")), "{found:?}");
    assert_eq!(found[3].clone().unwrap()[0], 20.0);
}

#[test]
fn g28_with_u_and_w_loses_the_position_and_nothing_else() {
    let text = format!("{HEADER}{PART}G28 U0 W0\nG0 X60. Z-5.\nX50.\n");
    assert_eq!(x(&text, &["G90", "diameter"])[5..], [Some(30.0), Some(25.0)]);
}
