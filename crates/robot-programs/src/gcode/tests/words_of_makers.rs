//! Words of firmware, controls and cycles.

use super::*;

#[test]
fn axis_letters_behind_a_firmware_word_are_no_places() {
    let text = format!("{PRINTER}M205 X8.00 Y8.00 ; jerk\nG1 X20 E0.5\nM84 X Y E\n");
    let found = goals(&text);
    assert_eq!(found.len(), 2);
    let last = found[1].as_ref().unwrap();
    assert!(last[0] == 20.0 && last[1].is_nan(), "{found:?}");
    // modal motion with a word of firmware after it is a motion
    let text = format!("{PRINTER}X20 M106 S255\n");
    assert_eq!(goals(&text)[1].as_ref().unwrap()[0], 20.0);
    // a machine that is no printer may have a motion there: it is not edited
    let other = "G21 G90\nG1 X10 Y10 F300\nM205 X8.00 Y8.00\nG1 X20\n";
    assert_eq!(opaque(other), ["words that may be those of M205"]);
}

#[test]
fn homing_by_bare_letters_and_words_of_firmware_are_read() {
    for line in
        ["G28 X Y", "G28 W", "G28 X", "M115 U3.8.1", "M862.3 P \"MK3\"", "M117 50% (done", "M84 X Y E", "G29 P1"]
    {
        let text = format!("{PRINTER}{line}\nG1 X20 Y5\n");
        assert_eq!(goals(&text).last().unwrap().as_ref().unwrap()[0], 20.0, "{line}");
    }
    for line in ["G1 X Y5", "G0 X", "X1.2.3", "G1 X50%"] {
        let text = format!("{PRINTER}{line}\n");
        assert!(refusal(&Gcode, &text, &robot()).contains(":5:"), "{line}");
    }
}

#[test]
fn settings_of_a_printer_do_not_end_what_is_known() {
    let breaks = |line: &str| {
        let text = format!("{PRINTER}{line}\nG1 X20\n");
        script_of(&Gcode, &text, &robot()).steps.iter().filter(|s| matches!(s.kind, StepKind::Break(_))).count()
    };
    let none = breaks("");
    for line in ["M204 S1000", "M73 P5 R7", "M205 X8 Y8", "G10", "G11", "M900 K0.05", "M221 S95", "M486 S1"] {
        assert_eq!(breaks(line), none, "{line}");
    }
    for line in ["G29", "G80", "M600", "M206 X1", "M92 X80"] {
        assert!(breaks(line) > none, "{line}");
    }
}

#[test]
fn a_message_behind_a_stop_leaves_the_modes() {
    let text = format!("{PRINTER}M0 Clean the nozzle\nG1 X20\n");
    assert!(goals(&text)[1].is_some());
}

#[test]
fn polar_words_lead_to_a_place_that_is_not_told() {
    let text = format!("{HEAD}G1 @10 ^30 F300\nX5\nG91\n^15 Z-1\nX1\n");
    assert_eq!(goals(&text).iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, true, false, false]);
    // after it a relative word leads from a place that is not known
    let found = opaque(&text);
    assert!(found[0] == "polar coordinates" && found[2].starts_with("a relative word"), "{found:?}");
}

#[test]
fn a_motion_beside_the_end_of_a_cycle_stays() {
    assert!(goals("G0 G90 G40 G21 G17 G80\nX10 Y5\n")[0].is_some());
    assert_eq!(opaque("G21 G90 G0\nG80\nX10 Y5\n"), ["no G0, G1, G2 or G3 is certain here"]);
}

#[test]
fn units_of_siemens_controls_are_read_where_the_text_is_certainly_theirs() {
    let first = |text: &str| goals(text)[0].as_ref().map(|q| q[0]);
    for (unit, x) in [("G71", 50.0), ("G710", 50.0), ("G70", 1270.0), ("G700", 1270.0)] {
        for own in ["T=\"MILL10\" D1\nM6\n", "", "DIAMOF\n"] {
            let text = format!("N10 {unit} G90 G17 G54 G94\n{own}G0 X50 Y0 Z0\nG1 Y=IC(-10)\n");
            let text = if own.is_empty() { text.replace("Y=IC(-10)", "Y10") } else { text };
            assert_eq!(first(&text), if own.is_empty() { None } else { Some(x) }, "{text}");
        }
    }
    // a bolt circle or a turning cycle of others
    assert!(opaque("G21 G90\nG71 I5 J0 K90 L4\nG0 X1\n")[0].contains("G71"));
}

#[test]
fn the_number_of_a_spindle_is_no_call() {
    let text = format!("{HEAD}G1 X10.0 F100\nM3 $1 S1\nG1 X5.0\n");
    assert!(opaque(&text).is_empty(), "{:?}", opaque(&text));
    assert_eq!(goals(&text).iter().flatten().count(), 3);
}

#[test]
fn a_line_of_many_numbers_and_slashes_is_read_in_time() {
    let began = std::time::Instant::now();
    let text = format!("G21 G90\nG1 X1 Y1 Z1 F100\n{}\nG1 X2\n", "N1/".repeat(300_000));
    assert_eq!(script_of(&Gcode, &text, &robot()).moves().count(), 2);
    assert!(began.elapsed().as_secs() < 30, "{:?}", began.elapsed());
}
