//! Words that act once, the default plane of a lathe, and words that are not needed.

use super::*;
use crate::axes::Axes;

const START: &str = "G21 G90 G17 G94 G40 G54\nG0 X0.0 Y0.0 Z0.0\nX10.0 Y20.0 Z-1.0\n";

#[test]
fn a_skip_and_a_limit_of_the_look_ahead_end_with_their_block() {
    for line in ["G31 Z-20.0 F50", "G103 P1", "G103"] {
        let text = format!("{START}{line}\nG0 X5.0 Y1.0 Z-2.0\nX3.0\n");
        assert_eq!(goals(&text).iter().rev().take(2).filter(|g| g.is_some()).count(), 2, "{line}");
        // which motion is on after it is not certain
        let text = format!("{START}{line}\nX5.0 Y1.0 Z-2.0\n");
        assert!(goals(&text).last().unwrap().is_none(), "{line}");
        let sub = format!("{START}{line}\nG0 X5.0\nM98 P2\nG0 X3.0\nM30\nO2\nM99\n");
        assert!(opaque(&sub).iter().all(|why| !why.contains("may be on")), "{line}: {:?}", opaque(&sub));
    }
    // a mirror, a setting of a printer's probe
    for text in [format!("{START}G101 X0\nG0 X5.0\n"), format!("M104 S200\n{START}G31 Z1.2 P500\nG0 X5.0\n")] {
        assert!(goals(&text).last().unwrap().is_none(), "{text}");
    }
}

#[test]
fn arcs_of_a_lathe_without_a_y_axis_lie_in_the_only_plane() {
    let joints = robot().axis_joints().filter(|j| j.name != "Y").cloned().collect();
    let mut lathe = Axes::new("Lathe", joints);
    lathe.control = crate::gcode::Control::of_words(["diameter", "G90"]).unwrap();
    let read = |head: &str, arc: &str| {
        let text = format!("G21 G40 {head}\nT0101\nG96 S180 M3\nG0 X40.0 Z-1.0\nG1 Z-20.0\n{arc}\n");
        moves(&script_of(&Gcode, &text, &lathe)).last().map(|m| (m.1.path, m.1.goal.clone())).unwrap()
    };
    for arc in ["G2 X50.0 Z-25.0 R5.0", "G2 X50.0 Z-25.0 I5.0 K0.0"] {
        assert!(matches!(read("", arc), (PathKind::Curve, Goal::Joints(_))), "{arc}");
        assert!(matches!(read("G17", arc).1, Goal::Opaque(_)), "{arc}");
    }
    assert!(matches!(read("", "G2 X50.0 Z-25.0 R5.0 J1.0").1, Goal::Opaque(_)));
}

#[test]
fn a_colon_begins_a_program_as_an_o_does() {
    let text =
        |name: &str| format!("{START}M98 P0100\nG0 X3.0 Y0.0 Z0.0\nM30\n{name} (SUB)\nG91 G1 X1.0 F100\nG90\nM99\n");
    let steps = |name: &str| {
        let script = script_of(&Gcode, &text(name), &robot());
        script.steps.iter().map(|s| format!("{:?} {:?}", s.at, s.kind)).collect::<Vec<_>>()
    };
    assert_eq!(steps(":0100"), steps("O0100"));
    assert!(refusal(&Gcode, &format!("{START}: X1\n"), &robot()).contains("`: X1`"));
}

#[test]
fn a_word_that_leads_where_its_axis_stands_is_not_added() {
    let text = "G20 G90 G17\nG0 X-0.5 Y0.5 Z-0.1\nG1 Z-0.2 F20.\nX3.5\nY1.5\n";
    let down = 0.2 * 25.4 + 0.01;
    let out = written(
        text,
        &[
            (1, Some([-12.7, 12.7, -down]), vec![]),
            (2, Some([88.92, 12.7, -down]), vec![]),
            (3, Some([88.92, 38.13, -down]), vec![]),
        ],
    );
    assert!(out.contains("\nX3.5008\nY1.5012\n"), "{out}");
}
