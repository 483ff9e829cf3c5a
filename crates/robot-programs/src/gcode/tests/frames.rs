//! Work frames, tool lengths and places of the machine: which axes they move, and what stays known.

use super::*;
use crate::script::{AxisSet, How};

/// A change of the meaning of some axes, or of all, and the axes that a move to an unknown place moves, by line.
fn slips(text: &str) -> Vec<(u64, Option<Vec<usize>>)> {
    let axes = |set: AxisSet| Some(set.axes().collect());
    let script = script_of(&Gcode, text, &robot());
    let one = |s: &crate::script::Step| match &s.kind {
        StepKind::Break(Break::Frame) => Some((s.at.line, None)),
        StepKind::Break(Break::Axes(set)) => Some((s.at.line, axes(*set))),
        StepKind::Move(m) => matches!(m.goal, Goal::Opaque(_)).then(|| (s.at.line, m.moves_alone.and_then(axes))),
        _ => None,
    };
    script.steps.iter().filter_map(one).collect()
}

fn hows(text: &str) -> Vec<How> {
    moves(&script_of(&Gcode, text, &robot())).into_iter().map(|(_, m)| (*m).clone()).collect()
}

/// The header of most programs of CAM systems, with two tools.
const CAM: &str = "G21 G90 G17 G40 G49 G80\nT1 M6\nG0 G54 X0 Y0\nG43 Z5 H1\nG1 Z-1 F100\nG1 X10 Y5\nX5\n\
                   T2 M6\nG0 G54 X0 Y0\nG43 Z5 H2\nG1 Z-1 F100\nX10\nX5\nM30\n";

#[test]
fn the_header_of_a_cam_system_leaves_every_move_known() {
    assert!(opaque(CAM).is_empty(), "{:?}", opaque(CAM));
    assert_eq!(goals(CAM).len(), 10);
    // G43 moves Z alone
    let lengths: Vec<_> = slips(CAM).into_iter().filter(|(line, _)| [4, 10].contains(line)).collect();
    assert_eq!(lengths, [(4, Some(vec![2])), (10, Some(vec![2]))]);
    let all = |set: AxisSet| set.axes().collect::<Vec<_>>();
    let how = hows(CAM);
    assert!(how.iter().all(|h| all(h.unplaced) == [0, 1, 2]));
    // of the second tool Z counts from elsewhere than of the first
    let displaced: Vec<Vec<usize>> = how.iter().map(|h| all(h.displaced)).collect();
    assert_eq!((&displaced[1], &displaced[9]), (&vec![], &vec![2]));
}

#[test]
fn a_tool_length_moves_any_axis_in_another_plane_and_a_dynamic_one_takes_the_words() {
    for text in ["G18\nG43 H1\n", "G43.1 H1\n"] {
        let text = format!("{HEAD}{text}G1 X5 F9\n");
        assert_eq!(slips(&text).last().unwrap().1, None, "{text}");
    }
    assert!(opaque(&format!("{HEAD}G43.1 Z5\n"))[0].contains("G43.1"));
}

#[test]
fn a_reference_point_and_g53_lose_the_axes_that_they_name_alone() {
    for (line, axes) in [
        ("G28 X0 Y0", Some(vec![0, 1])),
        ("G91 G28 Z0\nG90", Some(vec![2])),
        ("G30 P2 Z0", Some(vec![2])),
        ("G53 G0 Z0", Some(vec![2])),
        // all axes; an axis that the robot file does not have; a word that is no number; an arc; a relative one
        ("G28", None),
        ("G28 A0", None),
        ("G53 G0 Z0 A0", None),
        ("G53 G2 X5 Y5 R5", None),
        ("G91 G53 G0 Z0\nG90", None),
        ("/G53 G0 Z0", None),
    ] {
        let text = format!("{HEAD}{line}\nG1 X5 F9\nX3\n");
        assert_eq!(slips(&text), [(3, axes)], "{line}");
        assert!(goals(&text).iter().skip(2).all(Option::is_some), "{line}");
    }
    // a control gives up the tool length for it
    let text = format!("{HEAD}G43 H1 Z5\nG53 G0 X0\n");
    assert_eq!(slips(&text).last().unwrap().1, Some(vec![0, 2]));
    // a mirrored or turned axis word moves another axis
    assert_eq!(slips(&format!("{HEAD}G68 R30\nG53 G0 Z0\n")).last().unwrap().1, None);
    assert_eq!(slips(&format!("{HEAD}G41 D1\nG28 Z0\n")).last().unwrap().1, None);
}

#[test]
fn what_may_turn_the_axes_leaves_all_that_follows() {
    for line in ["G10 L2 P1 R45", "G10 L50\nN1 R1\nG11", "G10 P1 Z0 R1", "G54.4 P1", "G54.2 P1", "#5230=45"] {
        let text = format!("{HEAD}{line}\nG1 X5 F9\n");
        assert!(goals(&text).last().unwrap().is_none(), "{line}");
    }
    for line in ["G10 L2 P1 X5", "G10 L20 P1 X0", "G10 L1 P1 Z5 R1", "G59.3"] {
        let text = format!("{HEAD}{line}\nG1 X5 F9\n");
        assert!(goals(&text).last().unwrap().is_some(), "{line}");
    }
    // also at a label from which it may be reached
    let text = "G21 G90 G17\nN10 G0 X1 Y1 Z1\nG10 L2 P1 R45\nIF [#1 EQ 1] GOTO 10\n";
    assert!(goals(text)[0].is_none());
}

#[test]
fn an_axis_that_stands_elsewhere_is_not_written_and_the_others_keep_what_was_changed() {
    // X stands at 10.004 before and after, so the arc begins there
    let text = format!("{HEAD}G1 X10.000 F100\nG28 Z0\nG3 X-10.000 Y0.000 I-10.000 J0.000\n");
    let out = written(&text, &[(1, Some([10.004, 0.0, 0.0]), vec![])]);
    assert!(out.contains("X10.004 F100\nG28 Z0\n"), "{out}");
    assert!(!out.contains("G3 X-10.000 Y0.000 I-10.000"), "{out}");
    let text = format!("{HEAD}G53 G0 Z0\nG1 X5.000 F9\n");
    assert!(written(&text, &[(2, Some([5.004, 0.0, 0.3]), vec![])]).ends_with("G1 X5.004 F9\n"));
}

#[test]
fn a_call_of_another_file_asks_for_the_work_frame_again() {
    let text = |again: &str| format!("G21 G90 G17 G40 G54\nG0 X1 Y1 Z1\nM98 P100\nG21 G90 G17 G40{again}\nG0 X2\n");
    assert!(opaque(&text(""))[0].contains("work frame"));
    assert!(opaque(&text(" G54")).is_empty());
}

#[test]
fn cutter_compensation_is_off_at_every_label_where_it_is_on_between_them_alone() {
    let text = |inside: &str| {
        format!(
            "O100\nG21 G90 G17\nG0 X0 Y0 Z0\nG1 X10 F9\nG41 D1 X20\n{inside}X30\nG40\nX5\nM98 P200\nG1 X6\nM30\nO200\nG1 X7\nM99\n"
        )
    };
    let left = opaque(&text(""));
    assert_eq!(left.len(), 2, "{left:?}");
    // a call, a label or a block that may be switched off while it is on
    for inside in ["M98 P200\n", "IF [#1 EQ 2] GOTO 5\nN5 X25\n", "/G40\nG41 D1\n", "#1=1\nWHILE [#1 LT 2] DO1\nEND1\n"]
    {
        assert!(opaque(&text(inside)).len() > 4, "{inside}: {:?}", opaque(&text(inside)));
    }
}

/// Whether each move counts from another origin than the first; `None`: it stays.
fn displaced(text: &str) -> Vec<Option<bool>> {
    let script = script_of(&Gcode, text, &robot());
    let one = |(_, m): &(usize, crate::script::Move)| match m.goal {
        Goal::Joints(_) => Some(!m.displaced.is_empty()),
        _ => None,
    };
    moves(&script).iter().map(one).collect()
}

#[test]
fn further_work_frames_of_haas_are_work_frames() {
    const HAAS: &str = "G21 G90 G17\nG154 P1\nG0 X0 Y0 Z0\n";
    // the same frame by its other name, another one, and back
    let text = format!("{HAAS}G110\nG1 X10 F300\nG154 P2\nX5\nG0 G113 X1\nG154 P1\nX2\n");
    let (there, away) = (Some(false), Some(true));
    assert_eq!(displaced(&text), [there, there, away, away, there], "{:?}", opaque(&text));
    // a change loses the place
    let first = |script: &Script, k: usize| moves(script)[k].0;
    let script = script_of(&Gcode, &text, &robot());
    let steps = &script.steps[first(&script, 1)..first(&script, 2)];
    assert!(steps.iter().any(|s| matches!(s.kind, StepKind::Break(Break::Frame))));
    // a computed one is no other line's
    assert_eq!(displaced(&format!("{HAAS}G154 P1 G4 P2\nX5\n")), [there, away]);
    for other in ["G154", "G154 P100", "G154 P1.5", "G154 P#1", "G112", "G116 T5", "G110 X5 Y5", "G129 P1"] {
        let text = format!("{HAAS}{other}\nG1 X10 F300\n");
        assert_eq!(displaced(&text).last(), Some(&None), "{other}");
    }
    // without a word of Haas it may be anything
    assert_eq!(displaced(&format!("{HEAD}G110\nG1 X10 F300\n")), [there, None]);
    assert_eq!(displaced(&format!("{HEAD}G113\nG1 X10 F300\n")), [there, there]);
    // a label is reached in any of them
    let jumps = format!("{HAAS}G187 P3\nG110\nX3\nN5 G90 G21\nG1 X10 F300\nIF [#1 EQ 2] GOTO 5\n");
    assert_eq!(displaced(&jumps).last(), Some(&away));
}

#[test]
fn work_frames_of_siemens_are_work_frames_in_their_programs() {
    let text = format!("{HEAD}T=\"MILL10\"\nM6\nG500\nG0 X10 Y10 Z10\nG505\nX5 Y5 Z5\nG500\nX1\n");
    let found = displaced(&text);
    assert_eq!(found, [Some(false), Some(true), Some(true), Some(true)], "{:?}", opaque(&text));
    // a macro of another control
    for other in ["G500", "G505"] {
        assert_eq!(displaced(&format!("{HEAD}{other}\nG1 X10 F300\n")), [Some(false), None], "{other}");
    }
}
