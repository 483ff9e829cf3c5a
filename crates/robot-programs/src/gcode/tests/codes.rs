//! Words that name axes and lead nowhere, frames by number, splines and corners.

use super::*;
use crate::script::Step;

fn breaks(text: &str) -> usize {
    let frame = |s: &&Step| matches!(s.kind, StepKind::Break(Break::Frame));
    script_of(&Gcode, text, &robot()).steps.iter().filter(frame).count()
}

/// X of every goal that is known.
fn known_x(text: &str) -> Vec<f64> {
    goals(text).into_iter().flatten().map(|g| g[0]).collect()
}

#[test]
fn a_g50_with_axis_words_sets_coordinates_and_one_without_does_nothing() {
    let text = format!("{HEAD}G1 X60.0 F100\nG50 X200. Z150.\nG1 X210.5\n");
    assert_eq!(known_x(&text), [0.0, 60.0, 70.5]);
    assert_eq!(breaks(&text), 1);
    // the place after which it counts stays, as before a G92
    assert!(moves(&script_of(&Gcode, &text, &robot()))[1].1.fixed.is_some());
    for line in ["G50", "G50 S2000"] {
        let text = format!("{HEAD}G1 X60.0 F100\n{line}\nG1 X210.5\n");
        assert_eq!((known_x(&text), breaks(&text)), (vec![0.0, 60.0, 210.5], 0), "{line}");
    }
    // a lathe's relative words shift axes that have other names
    let script = script_of(&Gcode, &format!("{HEAD}G1 X60.0 F100\nG50 X1.0 W3.0\nG1 Z5.0\n"), &robot());
    assert!(moves(&script)[2].1.displaced.has(2));
}

#[test]
fn mirrors_and_scalings_end_what_is_known_and_lead_nowhere() {
    let text = format!("{HEAD}G1 X60.0 F100\nG1 X20.0\nG50.1 X0. Y0.\nG1 X60.0\n");
    assert_eq!((known_x(&text), breaks(&text)), (vec![0.0, 60.0, 20.0, 60.0], 1));
    for (on, why) in [("G51.1 X0.", "G51.1 is on"), ("G51 X0. Y0. P2.", "G51 is on")] {
        let text = format!("{HEAD}G1 X60.0 F100\n{on}\nG1 X20.0\n");
        // one move less than a goal at the mirror would make
        assert_eq!((opaque(&text), breaks(&text)), (vec![why.to_string()], 1), "{on}");
    }
    // relative words after it lead from a place that is not known
    let text = format!("{HEAD}G91\nG1 X10.0 F100\nG50.1 X0.\nX5.0\n");
    assert!(moves(&script_of(&Gcode, &text, &robot()))[1].1.fixed.is_some());
    assert!(opaque(&text)[0].contains("relative word"));
}

#[test]
fn an_m_word_that_mirrors_on_older_controls_leads_nowhere_until_it_ends() {
    for on in ["M21", "M22"] {
        let text = format!("{HEAD}G1 X60.0 F100\n{on}\nG1 X20.0\nX30.0\nM23\nG1 X10.0\n");
        assert_eq!(opaque(&text), [format!("{on} may mirror an axis"), format!("{on} may mirror an axis")], "{on}");
        assert_eq!(known_x(&text), [0.0, 60.0, 10.0], "{on}");
    }
    // what else is on stays on
    let text = format!("{HEAD}G68 X0 Y0 R30\nM21\nM23\nG1 X10.0 F100\n");
    assert_eq!(opaque(&text), ["G68 is on", "G68 is on"]);
    // a part that is cut again, mirrored
    let text = format!("{HEAD}M98 P7\nM21\nM98 P7\nM23\nM30\nO7\nG90 G21 G1 X10.0 Y0.0 Z0.0 F100\nM99\n");
    assert!(opaque(&text).iter().all(|w| w.contains("M21 or M22 may be on")) && opaque(&text).len() == 1);
    // the tailstock of a lathe
    let text = "G21 G90 G50 S2000\nG0 X10.0 Z5.0\nM21\nG1 X8.0 Z5.0 F0.1\n";
    assert!(opaque(text).iter().all(|w| w.contains("turning cycle")), "{:?}", opaque(text));
}

#[test]
fn splines_are_no_straight_moves() {
    for code in ["G5.1", "G5", "G5.2", "G5.3", "G6.2", "G06"] {
        let text = format!("{HEAD}G1 X60.0 F100\n{code} X40.0 Y1.0 I10 J10\nX30.0\nG1 X10.0 Y0.0 Z0.0\n");
        let found = opaque(&text);
        assert!(found.len() == 2 && found.iter().all(|w| w.starts_with("spline G")), "{code}: {found:?}");
        assert_eq!(known_x(&text), [0.0, 60.0, 10.0], "{code}");
    }
    // look-ahead
    let text = format!("{HEAD}G5.1 Q1\nG1 X60.0 F100\nX20.0\nG5.1 Q0\nX60.0\n");
    assert_eq!((known_x(&text), breaks(&text)), (vec![0.0, 60.0, 20.0, 60.0], 0));
}

#[test]
fn the_p_of_a_work_frame_is_a_part_of_its_name() {
    for (first, other) in [("G54.1 P1", "G54.1 P2"), ("G54", "G54 P2"), ("G54.1 P1", "G54.1 P#1"), ("G54 P1", "G54")] {
        let text = format!("G21 G90 {first}\nG0 X1.0 Y1.0 Z1.0\n{other}\nG0 X1.5\n{first}\nG0 X2.0\n");
        let script = script_of(&Gcode, &text, &robot());
        let displaced: Vec<bool> = moves(&script).iter().map(|(_, m)| m.displaced.has(0)).collect();
        assert_eq!(displaced, [false, true, false], "{first}, {other}");
    }
    // one frame by two names; the P of a call or a dwell is none
    for (first, same) in [("G54.1 P2", "G54 P2"), ("G54", "G54 G4 P2.0"), ("G54.1 P1", "G54.1 P1.0")] {
        let text = format!("G21 G90 {first}\nG0 X1.0 Y1.0 Z1.0\n{same}\nG0 X1.5\n");
        assert_eq!(known_x(&text), [1.0, 1.5], "{first}, {same}");
    }
}

#[test]
fn a_straight_move_with_the_word_of_a_corner_is_left() {
    for word in ["R5", "R-5.0", "R#1", "C2", "A45", "I2", "K-2"] {
        let text = format!("{HEAD}G1 X60.0 F100\nG1 X50.0 {word}\nG1 X70.0\n");
        assert_eq!(opaque(&text).len(), 1, "{word}");
        assert_eq!(known_x(&text), [0.0, 60.0, 70.0], "{word}");
    }
    // an arc's radius is none of these
    assert!(opaque(&format!("{HEAD}G1 X60.0 F100\nG2 X50.0 R5\n")).is_empty());
    assert!(opaque(&format!("{HEAD}G1 X60.0 F100\nG1 X50.0 R0\n")).is_empty());
}

#[test]
fn homing_of_named_axes_ends_what_is_known_of_the_position() {
    // Sailfish: axes to their largest or smallest end stop
    for home in ["G162 X Y F3000", "G161 Z F1000", "G28 X Y"] {
        let text = format!("{HEAD}G1 X10.0 F100\n{home}\nG91 G1 X1.0\nG90 G1 X2.0 Y3.0 Z0.0\nX4.0\n");
        let goals: Vec<bool> =
            moves(&script_of(&Gcode, &text, &robot())).iter().map(|m| matches!(m.1.goal, Goal::Joints(_))).collect();
        // an axis that was not named stays known
        assert_eq!(goals, [true, true, false, home.starts_with("G161"), true, true], "{home}");
    }
}

#[test]
fn what_the_program_never_says_is_named_and_may_be_assumed() {
    let text = "G1 X10.0 Y5.0 F100\nX20.0\n";
    let script = script_of(&Gcode, text, &robot());
    assert_eq!(script.missing, ["G90 or G91", "G20 or G21"]);
    assert!(moves(&script).iter().all(|m| matches!(m.1.goal, Goal::Opaque(_))));
    let mut axes = robot();
    axes.control = crate::gcode::Control::of_words(["G21", "G90"]).unwrap();
    let script = script_of(&Gcode, text, &axes);
    assert!(script.missing.is_empty());
    assert_eq!(values(&script, moves(&script)[1].0)[0], 0.020);
    // what the program says is stronger
    let script = script_of(&Gcode, &format!("G20\n{text}"), &axes);
    assert!((values(&script, moves(&script)[1].0)[0] - 0.508).abs() < 1e-12);
    assert!(script_of(&Gcode, &format!("G91 G20\n{text}"), &robot()).missing.is_empty());
}

#[test]
fn expressions_with_one_value_lead_to_known_places_and_are_edited_as_numbers() {
    let text = "#1=.5\nG21 G90 G0 X0 Y0 Z0\nG1 X[#1*53] Y-#1 F[#1*100]\nG1 X[10+2*SIN[30]]\n";
    assert_eq!(known_x(text), [0.0, 26.5, 11.0]);
    let out = written(text, &[(1, Some([26.5012, -0.5, 0.0]), vec![])]);
    assert_eq!(out, text.replace("X[#1*53]", "X26.5012"));
    let notes = script_of(&Gcode, text, &robot()).notes;
    assert!(notes.iter().any(|n| n.text.contains("folded")), "{notes:?}");
    // after a branch only what one block assigns before all branches; nothing after a call of something else
    let text = "#1=5\n#2=6\nG21 G90 G0 X0 Y0 Z0\no1 if [#9 gt 1]\n#3=4\no1 endif\nG0 X#1\nG0 X#2\nG0 X#3\nG65 P9000\nG21 G90 G0 G17 G40 X#1\n";
    assert_eq!(known_x(text), [0.0, 5.0, 6.0]);
    let twice = text.replace("#3=4", "#2=4");
    assert_eq!(known_x(&twice), [0.0, 5.0]);
    // a loop that counts
    let text = "#1=5\nG21 G90 G0 X0 Y0 Z0\no1 while [#1 lt 9]\nG1 X#1 F100\n#1=[#1+1]\no1 endwhile\n";
    assert_eq!(opaque(text), ["an expression or a variable"]);
}

#[test]
fn modes_behind_a_call_of_a_subprogram_in_the_text_are_those_that_the_text_never_changes() {
    let sub = "o<hole> sub\nG0 Z5\nG1 Z-2 F50\no<hole> endsub\n";
    let main = "G21 G90 G0 X0 Y0 Z9\no<hole> call\nG0 X10 Y0 Z9\n";
    // those of the subprogram have the modes of its call
    assert_eq!(goals(&format!("{sub}{main}")).iter().filter(|g| g.is_none()).count(), 0);
    assert_eq!(known_x(&format!("{main}M2\n{sub}"))[..2], [0.0, 10.0]);
    let fanuc = "G21 G90 G0 X0 Y0 Z9\nM98 P200\nG0 X10 Y0 Z9\nM30\nO0200\nG1 Z-2 F50\nM99\n";
    assert_eq!(known_x(fanuc)[..2], [0.0, 10.0]);
    // changed in the subprogram, called elsewhere, or after a code that is not known
    for (from, to) in [("G1 Z-2", "G91 G1 Z-2"), ("P200", "P300"), ("G1 Z-2", "G68 R1\nG1 Z-2")] {
        assert_eq!(known_x(&fanuc.replace(from, to))[..], [0.0], "{to}");
    }
}

#[test]
fn a_function_behind_a_letter_is_an_expression() {
    assert_eq!(opaque("G21 G90 G0 X EXISTS[#1]\n"), ["an expression or a variable"]);
}

/// Moves whose goal is known, and reasons for the others, in their order.
fn told(text: &str) -> Vec<Option<f64>> {
    goals(text).into_iter().map(|g| g.map(|g| g[0])).collect()
}

const START: &str = "G21 G90 G17\nG0 X10 Y10 Z-5\nG1 X50 F900\n";
const ANEW: &str = "G21 G90 G17 G40 G54\nG0 X10 Y10 Z-5\nG1 X50 F900\n";

#[test]
fn an_assignment_beside_other_words_ends_what_is_told_and_nothing_before_it() {
    for line in [
        "#1=ROUND[3] G1 X5",
        "#[#4]=3 G1 X5",
        "#100=40 (depth) G1 X55",
        "#1=3 G91",
        "#1=3 (c) G91",
        "#1=3 G91 G1 X5",
        "#1=#2=40",
        "#3005=1",
    ] {
        assert_eq!(told(&format!("{START}{line}\nG1 X40\nG1 X20\n")), [Some(10.0), Some(50.0), None, None], "{line}");
        // it may have run before a label to which control comes back
        let text = format!("{START}N10 G0 X10 Y10 Z-5\nG1 X40\n{line}\nIF [#9 LT 3] GOTO 10\n{ANEW}");
        assert_eq!(told(&text), [Some(10.0), Some(50.0), None, None, None, None], "{line}");
        // or before a subprogram ends
        let text = format!("{START}M98 P2\n{ANEW}M30\nO2\n{line}\nM99\n");
        assert_eq!(told(&text), [Some(10.0), Some(50.0), None, None], "{line}");
    }
}

#[test]
fn a_variable_is_not_known_where_an_assignment_to_it_is_not_certain() {
    for (line, x) in [
        ("#100=41", Some(41.0)),
        ("/#100=40", None),
        ("#2=5 #3=[#1+#2] #100=30", None),
        ("#100=40 (depth) #100=45", None),
        ("#100=4(c)0", None),
        ("IF [#1 EQ 0] THEN #100=45", None),
    ] {
        let text = format!("#100=30\n#101=60\n{START}{line}\n{ANEW}G1 X#100\nG1 X#101\n");
        // #101 keeps its value; after a condition too
        assert_eq!(told(&text)[4..], [x, x.or(Some(60.0)).filter(|_| x.is_none()).or(Some(60.0))], "{line}");
    }
    // before a loop whose end assigns it, blanks in its name or not
    for line in ["# 100=45", "#10 0=45", "#100 = 45", "/#100=45", "#[#7]=45"] {
        let text = format!("#100=40\n{START}o1 while [#2 lt 3]\n{ANEW}G1 X#100\n{line}\no1 endwhile\n");
        assert_eq!(told(&text).last(), Some(&None), "{line}");
    }
}

#[test]
fn a_variable_of_the_control_may_move_a_frame() {
    for line in ["#5221=5", "#[5000+221]=5", "#[5221]=5", "/#5221=5", "#2501=1", "IF [#1 EQ 2] THEN #5221=5"] {
        let text = format!("{START}{line}\nG1 X30 Y5 Z-4\nG1 X40\nG54\nG1 X20 Y2 Z2\n");
        assert_eq!(told(&text), [Some(10.0), Some(50.0), None, None, None], "{line}");
        let text = format!("O1\n{ANEW}M98 P2\nG1 X30 Y5 Z-4\nG1 X40\nM30\nO2\n{line}\nM99\n");
        assert_eq!(told(&text)[2..], [None, None], "{line}");
    }
}

#[test]
fn nothing_is_told_between_g66_and_g67() {
    let text = format!("{START}G66 P9100\n#100=40\n{ANEW}G1 X#100\nG67\n{ANEW}");
    assert_eq!(told(&text), [Some(10.0), Some(50.0), None, None, None, Some(10.0), Some(50.0)]);
    // of two it ends one, and a loop may have begun several
    let text = format!("{START}G66 P1\nG66 P2\nG67\n{ANEW}");
    assert_eq!(told(&text)[2..], [None, None]);
    let text = format!("N10 {START}G66 P1\nIF [#1 EQ 3] GOTO 10\nG67\n{ANEW}");
    assert_eq!(told(&text), [None; 4]);
}

#[test]
fn modes_of_a_block_that_may_be_switched_off_or_that_are_brought_back_are_not_certain() {
    for line in ["/G91", "/G20", "/G92 X5", "/G51 X0 Y0 P2", "/G55", "M72", "M73", "M#1", "/G90 G91"] {
        assert_eq!(told(&format!("{START}{line}\nX40\nX20\n"))[2..], [None, None], "{line}");
    }
    for line in ["/M8", "/(text)", "/G1 F200"] {
        assert_eq!(told(&format!("{START}{line}\nX40\nX20\n"))[2..], [Some(40.0), Some(20.0)], "{line}");
    }
}

#[test]
fn a_code_that_changes_what_words_mean_counts_at_a_label_before_it() {
    let text = format!("{START}N10 G90 G0 X10 Y10 Z-5\nG1 X40\nG51 X0 Y0 P2\nIF [#1 EQ 3] GOTO 10\n");
    assert_eq!(told(&text), [Some(10.0), Some(50.0), None, None]);
    assert!(opaque(&text).iter().all(|why| why == "G51 may be on"));
}

#[test]
fn a_probing_move_leads_to_no_place_and_leaves_modes() {
    let text = format!("{START}G38.2 Z-20 F50\nG0 X10 Y10 Z5\nG1 X40\n");
    assert_eq!(told(&text), [Some(10.0), Some(50.0), None, Some(10.0), Some(40.0)]);
}

#[test]
fn a_place_that_a_frame_or_a_variable_may_keep_is_left_as_it_is() {
    for line in ["#5221=#5021", "#1=#<_x>", "#[#2]=3", "#1=3 G91", "G10 L20 P1 X0", "/G91", "#1=#5041"] {
        let text = format!("{START}{line}\nG1 X40\n");
        let before = moves(&script_of(&Gcode, &text, &robot()))[1].1.clone();
        assert!(before.fixed.is_some(), "{line}: {before:?}");
    }
    let text = format!("{START}#1=3\nG1 X40\n");
    assert!(moves(&script_of(&Gcode, &text, &robot()))[1].1.fixed.is_none());
}

/// Moves with known goals, and the doubts of the others.
fn whole_numbers(text: &str, words: &[&str]) -> (usize, Vec<String>) {
    let mut axes = robot();
    axes.control = crate::gcode::Control::of_words(words.iter().copied()).unwrap();
    let script = script_of(&Gcode, text, &axes);
    let known = moves(&script).iter().filter(|m| matches!(m.1.goal, Goal::Joints(_))).count();
    let doubts = moves(&script).into_iter().filter_map(|(_, m)| match m.goal {
        Goal::Opaque(why) => Some(why.to_string()),
        _ => None,
    });
    (known, doubts.collect())
}

#[test]
fn whole_numbers_alone_may_count_increments_until_the_control_is_known() {
    let text = "G21 G90 G17\nG0 X500 Y200 Z-100\nG1 X300 F100.5\nX500\nX0\nX100\nX150\n";
    let (known, doubts) = whole_numbers(text, &[]);
    assert_eq!((known, doubts.len()), (1, 5), "{doubts:?}");
    assert!(doubts.iter().all(|d| d.contains("may count increments")), "{doubts:?}");
    assert_eq!(whole_numbers(text, &["whole-units"]), (6, vec![]));
    let said = |text: &str, words: &[&str]| {
        let mut axes = robot();
        axes.control = crate::gcode::Control::of_words(words.iter().copied()).unwrap();
        script_of(&Gcode, text, &axes).only_whole_numbers
    };
    assert!(said(text, &[]) && said("G20 G90\nG2 X1 Y1 R5\n", &[]) && !said(text, &["Whole-Units"]));
    // one axis word or centre with a point says how the control reads them all; a feed, a dwell or a comment does not
    for pointed in ["G1 X0.5", "X12.125", "G1 X10 Y10\nG2 X15 Y10 I2.5 J0"] {
        assert!(!said(&format!("{text}{pointed}\n"), &[]), "{pointed}");
        assert!(whole_numbers(&format!("{text}{pointed}\n"), &[]).1.is_empty(), "{pointed}");
    }
    for other in ["G4 P0.5", "(X0.5)", "S1000.5", "F200.0"] {
        assert!(said(&format!("{text}{other}\n"), &[]), "{other}");
    }
    // many lines of one form, of which a late one has a point
    let lines: String = (0..40).map(|k| format!("X{}\n", k + 1)).collect();
    assert!(said(&format!("{text}{lines}"), &[]) && !said(&format!("{text}{lines}X9.5\n"), &[]));
    // printers know no increments, and zeros are the same in both
    assert!(!said("M104 S200\nG21 G90\nG1 X10 Y20 F1000\n", &[]) && !said("G21 G90\nG0 X0 Y0\n", &[]));
    // beside numbers that end in a point the word changes nothing
    assert!(!whole_numbers("G21 G90\nG0 X1. Y0. Z0.\nG1 X5 F9\n", &["whole-units"]).1.is_empty());
}

#[test]
fn of_the_samples_two_are_written_in_whole_numbers_alone() {
    let mut whole = Vec::new();
    for (name, bytes) in harness::samples(&Gcode) {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let [without, with] = [&[][..], &["whole-units"]].map(|words| whole_numbers(&text, words).0);
        if without != with {
            whole.push((name, without, with));
        }
    }
    let names: Vec<_> = whole.iter().map(|w| (w.0.rsplit('/').next().unwrap_or_default(), w.1, w.2)).collect();
    assert_eq!(names, [("relative.nc", 0, 6), ("squeezed.tap", 0, 4)]);
}

#[test]
fn a_feed_or_a_spindle_word_beside_a_dwell_is_the_time_of_the_dwell() {
    let read = |dwell: &str| {
        let text = format!("G21 G90\nG0 X0 Y0 Z0\nG1 X10.0 F500\n{dwell}\nX20.0\n");
        let script = script_of(&Gcode, &text, &robot());
        let dwell = script.steps.iter().find_map(|s| match s.kind {
            StepKind::Dwell(seconds) => Some(seconds),
            _ => None,
        });
        (dwell.expect("a dwell"), moves(&script).last().unwrap().1.speed)
    };
    let feed = read("G4 X2.0").1;
    assert!(matches!(feed, Speed::Tcp(v) if (v - 0.5 / 60.0).abs() < 1e-12), "{feed:?}");
    for (dwell, seconds) in [
        ("G4 F2", Some(2.0)),
        ("G4 F0.5", Some(0.5)),
        ("F2 G4", Some(2.0)),
        // turns of the spindle
        ("G4 S30", None),
        ("G4 X1.5", Some(1.5)),
        ("G4 P0.5", Some(0.5)),
        ("G4 P500", None),
    ] {
        assert_eq!(read(dwell), (seconds, feed), "{dwell}");
    }
    // beside another time an F may be either
    assert_eq!(read("G4 P0.5 F100"), (Some(0.5), Speed::Unknown));
    assert_eq!(read("G4 X1.5 F100"), (Some(1.5), Speed::Unknown));
    // of printers S counts seconds
    let printer = "M104 S200\nG21 G90\nG1 X10.0 F500\nG4 S2\nG1 X20.0\n";
    let script = script_of(&Gcode, printer, &robot());
    assert!(script.steps.iter().any(|s| matches!(s.kind, StepKind::Dwell(Some(s)) if s == 2.0)));
}

#[test]
fn high_speed_modes_without_axes_change_nothing() {
    let text = format!("{HEAD}G05 P10000\nG1 X10 F300\nN5 G5 P0\nX5\n");
    assert_eq!(goals(&text).iter().flatten().count(), 3, "{:?}", opaque(&text));
    // a cycle that runs, a spline, and words that are not known
    for other in ["G05 P10001", "G05 P2", "G05", "G05 P10000 R3", "G05 P0 L2", "G5 P10000 X5"] {
        let text = format!("{HEAD}{other}\nG5 X1\nG1 X10 F300\n");
        assert!(!opaque(&text).is_empty(), "{other}");
    }
    assert_eq!(opaque(&format!("{HEAD}G05 P10001\nG1 X10 F300\n")), ["G5 is on"]);
}

#[test]
fn an_override_at_corners_ends_exact_stops_and_changes_nothing_else() {
    let text = format!("{HEAD}G61\nG1 X10 F300\nG62\nX5\nG64\nX1\n");
    let script = script_of(&Gcode, &text, &robot());
    let stops: Vec<_> = moves(&script).iter().map(|m| m.1.blend_m).collect();
    assert_eq!(stops, [None, Some(0.0), None, None]);
    // with axes it is a mirror on some controls
    assert_eq!(opaque(&format!("{HEAD}G62 X1\nG1 X10 F300\n")), ["G62 is on", "G62 is on"]);
}
