use super::Gcode;
use crate::error::Error;
use crate::script::harness::{self, count, edited, generator, moves, refusal, script_of, values};
use crate::script::{Break, Edit, Edits, Format, Goal, NewPoint, PathKind, Script, Speed, StepKind, Text};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

mod codes;
mod doubts;
mod frames;
mod small_arcs;

use crate::fixtures::gantry as robot;

fn point(mm: [f64; 3], share: f64, of_way: bool) -> NewPoint {
    NewPoint { q: mm.map(|v| v * 1e-3).to_vec(), share, t_s: None, clearance_m: 0.001, of_way }
}

/// Move, goal and new points in mm.
type Wish = (usize, Option<[f64; 3]>, Vec<NewPoint>);

/// Edits by the number of the move.
fn edits(script: &Script, list: &[Wish]) -> Edits {
    let steps: Vec<usize> = script.moves().map(|m| m.0).collect();
    let mut edits = Edits { digit: vec![1e-5; 3], ..Edits::default() };
    for (k, goal, before) in list {
        let goal = goal.map(|g| g.map(|v| v * 1e-3).to_vec());
        edits.steps.insert(steps[*k], Edit { goal, before: before.clone(), ..Edit::default() });
    }
    edits
}

fn attempt(text: &str, list: &[Wish]) -> crate::error::Result<String> {
    let robot = robot();
    let script = script_of(&Gcode, text, &robot);
    let out = edited(&Gcode, text.as_bytes(), &edits(&script, list), &robot)?;
    Ok(String::from_utf8(out).unwrap())
}

fn written(text: &str, list: &[Wish]) -> String {
    attempt(text, list).unwrap()
}

/// Goals of all moves in mm; NaN where an axis is not commanded; `None`: opaque.
fn goals(text: &str) -> Vec<Option<Vec<f64>>> {
    let script = script_of(&Gcode, text, &robot());
    let one = |(k, m): &(usize, _)| match &(m as &crate::script::Move).goal {
        Goal::Joints(_) => Some(values(&script, *k).iter().map(|v| (v * 1e9).round() / 1e6).collect()),
        _ => None,
    };
    moves(&script).iter().map(one).collect()
}

fn opaque(text: &str) -> Vec<String> {
    let script = script_of(&Gcode, text, &robot());
    let why = |m: &(usize, crate::script::Move)| match &m.1.goal {
        Goal::Opaque(why) => Some(why.clone()),
        _ => None,
    };
    moves(&script).iter().filter_map(why).collect()
}

const HEAD: &str = "G21 G90 G17\nG0 X0 Y0 Z0\n";

#[test]
fn words_meet_axes_by_name_with_any_spacing_and_case() {
    let n = f64::NAN;
    let found = goals("g21g90\nN10G1X10Y20.5F300\nG01 x 30\nz-5\n(a)X1(b)Y2;c\n");
    let wanted = [[10.0, 20.5, n], [30.0, n, n], [n, n, -5.0], [1.0, 2.0, n]];
    for (a, b) in found.iter().zip(wanted) {
        assert!(a.as_ref().unwrap().iter().zip(b).all(|(x, y)| x == &y || (x.is_nan() && y.is_nan())), "{found:?}");
    }
}

#[test]
fn a_changed_word_changes_its_digits_and_nothing_else() {
    let text = "%\nO1000 (TEST)\nG21 G90\r\nN10 G00 X0. Y0. Z0.\r\nN20 G01 X10.000 Y5. F300 (corner)\r\nM30\n%\n";
    let out = written(text, &[(1, Some([10.0502, 5.0, 0.0]), vec![])]);
    assert_eq!(out, text.replace("X10.000", "X10.050"));
}

#[test]
fn a_new_block_has_no_line_number_and_leaves_modal_feed_alone() {
    let text = "G21 G90\nN10 G00 X0 Y0 Z0\nN20 G01 X10.0 Y5.0 F300 ; attached\nN30 X0\n";
    let out = written(text, &[(1, None, vec![point([2.0, 1.0, 0.0], 0.2, false)])]);
    assert_eq!(out, text.replace("N20", "G01 X2.00 Y1.00 F300\nN20"));
    let out = written(text, &[(2, None, vec![point([9.0, 5.05, 0.0], 0.1, false)])]);
    assert_eq!(out, text.replace("N30 X0\n", "X9.00 Y5.05\nN30 X0\n"));
}

#[test]
fn an_axis_that_is_not_named_stays_with_its_offset_until_it_is_named() {
    let text = format!("{HEAD}G1 Y10.00 F100\nX10\nX20\nY3.00\n");
    let out = written(
        &text,
        &[
            (1, Some([0.0, 10.05, 0.0]), vec![]),
            (2, Some([10.0, 10.05, 0.0]), vec![]),
            (3, Some([20.0, 10.05, 0.0]), vec![]),
        ],
    );
    assert_eq!(out, text.replace("Y10.00", "Y10.05"));
    // an offset that changes where the axis has no word adds the word
    let out = written(&text, &[(1, Some([0.0, 10.05, 0.0]), vec![]), (2, Some([10.0, 10.02, 0.0]), vec![])]);
    assert_eq!(out, text.replace("Y10.00", "Y10.05").replace("X10\n", "X10 Y10.02\n"));
}

#[test]
fn relative_words_behind_a_change_take_it_back() {
    let text = format!("{HEAD}G91\nG1 X10 F100\nX-4\nX1\nG90\nX0\n");
    let out = written(&text, &[(1, Some([10.05, 0.0, 0.0]), vec![])]);
    assert_eq!(out, text.replace("G1 X10 ", "G1 X10.05 ").replace("X-4\n", "X-4.05\n"));
    // a change that stays changes one word; an axis without a word gets one
    let out = written(
        &text,
        &[
            (1, Some([10.05, 0.0, 0.0]), vec![]),
            (2, Some([6.05, 0.02, 0.0]), vec![]),
            (3, Some([7.05, 0.0, 0.0]), vec![]),
        ],
    );
    assert_eq!(
        out,
        text.replace("G1 X10 ", "G1 X10.05 ").replace("X-4\n", "X-4 Y0.02\n").replace("X1\n", "X1 Y-0.02\n")
    );
    // a new point takes its part of the way
    let out = written(&text, &[(2, None, vec![point([9.0, 0.0, 0.0], 0.25, false)])]);
    assert_eq!(out, text.replace("X-4\n", "X-1.00\nX-3.00\n"));
}

#[test]
fn rounding_of_relative_words_does_not_add_up() {
    let text = format!("{HEAD}G91\nG1 F100 X1\n{}G90\nX0\n", "X1\n".repeat(30));
    let list: Vec<_> = (1..31).map(|k| (k, Some([k as f64 + 0.000_333 * k as f64, 0.0, 0.0]), vec![])).collect();
    let robot = robot();
    let script = script_of(&Gcode, &text, &robot);
    let mut edits = edits(&script, &list);
    edits.digit = vec![1e-6; 3];
    // the comparison is made at every block, to half a digit
    let out = String::from_utf8(edited(&Gcode, text.as_bytes(), &edits, &robot).unwrap()).unwrap();
    assert!(out.contains("X1.001\n") && out.contains("G90\nX0\n"), "{out}");
}

#[test]
fn the_last_relative_move_before_the_position_is_lost_is_fixed() {
    for (after, fixed) in [
        ("M98 P100\n", true),
        ("", true),
        ("G92 X0\n", true),
        ("#1=2\nX#2\n", true),
        ("G90\nG1 X0\n", false),
        ("G90\nM98 P1\n", true),
        ("G28 X0\n", true),
    ] {
        let script = script_of(&Gcode, &format!("{HEAD}G91\nG1 X10 F100\nX-4\n{after}"), &robot());
        let moves = moves(&script);
        assert!(moves[1].1.fixed.is_none() && moves[2].1.fixed.is_some() == fixed, "{after}: {:?}", moves[2]);
    }
    // a way home in relative words is none of these
    let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\nG91 G28 Z0\n"), &robot());
    assert!(moves(&script)[1].1.fixed.is_none());
    // even before G92 in absolute words, as the change would stay in the frame
    let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\nG92 X0\nX5\n"), &robot());
    assert!(moves(&script)[1].1.fixed.is_some());
    let text = format!("{HEAD}G91\nG1 X10 F100\nX-4\nM98 P100\n");
    assert!(matches!(attempt(&text, &[(2, Some([6.1, 0.0, 0.0]), vec![])]), Err(Error::Refused(_))));
    let out = written(&text, &[(1, Some([10.1, 0.0, 0.0]), vec![])]);
    assert!(out.contains("X10.10 F100\nX-4.10\n"), "{out}");
}

#[test]
fn a_move_from_which_relative_words_count_later_on_is_fixed() {
    // by axis: Y is relative while its place is not known, X and Z are not
    let tail = |loses: &str, words: &str| format!("{HEAD}G1 X17 Y12 F100\n{loses}\nG90 G1 X5\n{words}\n");
    for loses in ["M6 T1", "M98 P100", "G20", "G55"] {
        for (words, fixed) in
            [("G91 G1 Y-3", true), ("G1 Y-3", false), ("G1 Y3\nG91 Y-3", false), ("G91 G28 Y0", false)]
        {
            let script = script_of(&Gcode, &tail(loses, words), &robot());
            // units after a call are not certain, so that the absolute word says nothing
            let fixed = fixed || loses == "M98 P100" && words.contains("G91 Y");
            assert_eq!(moves(&script)[1].1.fixed.is_some(), fixed, "{loses} {words}: {:?}", moves(&script)[1]);
        }
    }
    // twice lost, once known between: from the move after which it was lost last
    let text = format!("{HEAD}G1 X17 Y12 F100\nM6 T1\nG1 X5 Y5\nM6 T2\nG1 X4\nG91 G1 Y-3\n");
    let script = script_of(&Gcode, &text, &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(fixed[..3], [false, false, true], "{fixed:?}");
    // a part that is called from several places of the text
    let text = format!("{HEAD}G1 X17 Y12 F100\nM98 P100\nG90 G1 X5 Y2\nM98 P100\nM30\nO100\nG91 G1 X3\nG90\nM99\n");
    let script = script_of(&Gcode, &text, &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert!(fixed[1] && fixed[2], "{fixed:?}");
}

#[test]
fn inches_are_metres_and_new_digits_are_inches() {
    let text = "G20 G90\nG0 X0 Y0 Z0\nG1 X1.0 F10\n";
    assert_eq!(goals(text)[1].as_ref().unwrap()[0], 25.4);
    let out = written(text, &[(1, Some([25.4508, 0.0, 0.0]), vec![])]);
    assert!(out.contains("X1.0020 "), "{out}");
    // a switch of units moves nothing
    assert_eq!(goals("G21 G90\nG0 X25.4\nG20\nG1 X2\n")[1].as_ref().unwrap()[0], 50.8);
}

#[test]
fn shifted_frames_are_known_or_counted_from_elsewhere() {
    // G92: the position is called something else
    let found = goals("G21 G90\nG0 X10 Y0 Z0\nG92 X100\nG1 X101 F9\nG92.1\nG1 X7\nG52 X1\nG1 X7\nG52 X0\nG1 X7\n");
    let x: Vec<f64> = found.iter().map(|g| g.as_ref().unwrap()[0]).collect();
    assert_eq!(x, [10.0, 11.0, 7.0, 8.0, 7.0]);
    // another work frame has another, unknown offset: how far the axes move in it is known
    let text = "G21 G90 G54\nG0 X1 Y1 Z1\nG55\nG0 X1\nG54\nG0 X2\n";
    assert_eq!(goals(text).iter().map(Option::is_some).collect::<Vec<_>>(), [true; 3]);
    let displaced = |text: &str| -> Vec<bool> {
        let script = script_of(&Gcode, text, &robot());
        moves(&script).iter().map(|(_, m)| m.displaced.has(0)).collect()
    };
    assert_eq!(displaced(text), [false, true, false]);
    assert_eq!(displaced("G21 G90\nG0 X1\nG10 L2 P1 X5\nG0 X2\n"), [false, true]);
    let breaks = script_of(&Gcode, text, &robot())
        .steps
        .iter()
        .filter(|s| matches!(s.kind, StepKind::Break(Break::Frame)))
        .count();
    assert_eq!(breaks, 3);
    // a second tool length moves Z by what nobody knows, and X not at all
    let lengths = script_of(&Gcode, "G21 G90 G17\nG43 H1\nG0 Z5\nG43 H2\nG0 Z5\nG0 X1\n", &robot());
    let displaced: Vec<bool> = moves(&lengths).iter().map(|(_, m)| m.displaced.has(2)).collect();
    assert_eq!(displaced, [false, true, true]);
}

#[test]
fn what_cannot_be_told_is_opaque_and_says_why() {
    for (text, why) in [
        ("G90\nG0 X1\n", "G20 nor G21"),
        ("G21\nG0 X1\n", "G90 nor G91"),
        ("G21 G90\nX1\n", "no G0"),
        ("G21 G90\nG0 X[1+#2]\n", "expression"),
        ("G21 G90\nG0 X#<pos>\n", "expression"),
        ("G21 G90\nG0 X-#1\n", "expression"),
        ("G21 G91\nG0 X1\n", "position before it is not known"),
        ("G21 G90\nG0 X1 Y1 Z1\nG81 X5 Y5 Z-2 R1 F100\n", "canned cycle G81"),
        ("G21 G90\nG41 D1\nG1 X1\n", "cutter compensation"),
        ("G21 G90\nG53 G0 X1\n", "G53"),
        ("G21 G90\nG28 X0\n", "reference point"),
        ("G21 G90\nG0 X0 Y0 Z0\nG1 Z-1 G4 P0.5\n", "G4 beside positions"),
        ("G21 G90\nG68 R45\nG1 X1\n", "G68"),
        ("G21 G90\nG0 X1 X2\n", "twice"),
        ("G21 G90\nG0 X1 A2\n", "no such axis"),
        ("G21 G90\n/G0 X1\n", "switch off"),
        ("G21 G90\nG0 X1. Y2\n", "increments"),
        ("G21 G90\nM98 P100\nG0 X1\n", "after a call"),
        ("G21 G90\nM98 P100\nG40 G0 X1\n", "G90 nor G91"),
        ("G21 G90\nG1 X1 ,C2\n", "chamfer"),
        ("G21 G90\nN1 G1 X1*71\n", "checksum"),
        ("G21 G90\nG2 X1 I1\n", "not known"),
        ("G21 G90\nG0 X0 Y0 Z0\nG2 X5 Y5 I1 J1\n", "different radii"),
        ("G21 G90\nG0 X0 Y0 Z0\nG2 X5 Y5\n", "neither"),
        ("G21 G90\nG0 X0 Y0 Z0\nG2 X5 Y5 R1\n", "radius"),
    ] {
        let found = opaque(text);
        assert!(found.last().is_some_and(|w| w.contains(why)), "{text}: {found:?}");
    }
}

#[test]
fn zero_is_zero_with_and_without_a_point() {
    assert!(goals("G21 G90\nG0 X0 Y1.\n")[0].is_some());
    let script = script_of(&Gcode, "G21 G90\nG0 X0 Y1.\nX5\nX5.0\n", &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(fixed, [true, false, false]);
}

#[test]
fn text_that_is_no_gcode_is_refused_with_its_place() {
    for (text, place) in [
        ("G0 X\n", "job:1:4"),
        ("G0 X1.2.3\n", "job:1:4"),
        ("G1 (open\n", "job:1:4"),
        ("\n& foo\n", "job:2:1"),
        ("G0 X[1\n", "job:1:4"),
    ] {
        assert!(refusal(&Gcode, text, &robot()).starts_with(place), "{text}: {}", refusal(&Gcode, text, &robot()));
    }
    let kuka = crate::fixtures::kr120();
    assert!(refusal(&Gcode, "G0 X1\n", &kuka).contains("A1, A2"));
}

#[test]
fn calls_labels_loops_dwells_and_processes_are_steps() {
    let text = "%\nO100 (A)\nM3 S1000\nG4 P500\nG4 P0.5\nG4 X1.5\n(lostmotion: off)\nM5\no101 while [#1 lt 3]\no101 endwhile\n\
                o<sub> call\nIF [#1 EQ 1] GOTO 10\nN10 M62 P1\nM63 P1\nM8\nM0\n#1=5\nG65 P9000\nM99\n";
    let kinds: Vec<String> = script_of(&Gcode, text, &robot())
        .steps
        .iter()
        .map(|s| match &s.kind {
            StepKind::Move(_) => "move".into(),
            StepKind::Dwell(s) => format!("{s:?}"),
            StepKind::Break(b) => format!("{b:?}"),
            StepKind::Process(p) => format!("{p}"),
            StepKind::Pragma(p) => format!("pragma {p}"),
        })
        .collect();
    let wanted = [
        "Start",
        "Start",
        "Start",
        "true",
        "None",
        "Some(0.5)",
        "Some(1.5)",
        "pragma false",
        "false",
        "Loop",
        "Loop",
        "Call",
        "Jump",
        "Jump",
        "true",
        "false",
        "None",
        "Call",
        "Call",
    ];
    assert_eq!(kinds, wanted);
}

#[test]
fn speeds_paths_and_stops_are_told() {
    let script = script_of(
        &Gcode,
        "G21 G90 G94\nG0 X0 Y0 Z0\nG61 G1 X1 F600\nG64 X2\nG93 X3 F2\nM3 G94 X4 F600\nX5 E1\n",
        &robot(),
    );
    let m: Vec<_> = moves(&script).into_iter().map(|m| m.1).collect();
    assert_eq!((m[0].speed, m[0].path), (Speed::Unknown, PathKind::Joint));
    assert_eq!((m[1].speed, m[1].blend_m), (Speed::Tcp(0.01), Some(0.0)));
    assert_eq!((m[2].blend_m, m[2].closed.is_none()), (None, true));
    assert!(m[3].speed == Speed::Seconds(30.0) && m[3].closed.as_ref().unwrap().contains("G93"));
    assert!(m[4].closed.as_ref().unwrap().contains(" M ") && m[5].closed.as_ref().unwrap().contains(" E "));
}

#[test]
fn arcs_turn_at_their_quadrants_by_centre_and_by_radius() {
    for arc in ["G3 X0 Y10 I-10 J0", "G3 X0 Y10 R10"] {
        let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\n{arc}\n"), &robot());
        assert!(moves(&script)[2].1.way.is_empty(), "a quarter between quadrants turns nowhere");
    }
    for arc in ["G2 X0 Y10 I-10 J0", "G2 X0 Y10 R-10"] {
        let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\n{arc}\n"), &robot());
        let way = &moves(&script)[2].1.way;
        let at: Vec<[i64; 3]> = way.iter().map(|w| [0, 1, 2].map(|k| (w.q[k] * 1e9).round() as i64)).collect();
        assert_eq!(at, [[0, -10_000_000, 0], [-10_000_000, 0, 0]]);
        assert!((way[0].share - 1.0 / 3.0).abs() < 1e-12);
    }
    // a full circle commands both axes although no word says so; a helix climbs on the way
    let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\nG3 I-10\nG3 Z-4 I-10\n"), &robot());
    let moves = moves(&script);
    assert_eq!(moves[2].1.way.len(), 3);
    assert!((moves[3].1.way[1].q[2] + 0.002).abs() < 1e-12);
    assert!(values(&script, moves[2].0)[..2].iter().zip([0.01, 0.0]).all(|(a, b)| (a - b).abs() < 1e-15));
    // other planes: G18 runs from Z to X
    let script = script_of(&Gcode, &format!("{HEAD}G18 G3 X0 Z0 K-10\nG19 G2 Y0 Z0 J10\n"), &robot());
    let way = |n: usize| script.moves().nth(n).unwrap().1.way[0].q.clone();
    assert!(way(1)[0] > 0.0 && way(2)[2] > 0.0);
}

#[test]
fn an_arc_is_split_where_its_offset_changes() {
    let text = format!("{HEAD}G1 X10.0 F100\nN5 G3 X-10.0 Y0.0 I-10.0 J0.0\nG1 Y-5\n");
    // Y turns at the top: the offset comes in right after it
    let list = [
        (2, Some([-10.0, -0.05, 0.0]), vec![point([0.0, 10.0, 0.0], 0.5, true), point([0.0, 9.95, 0.0], 0.5, false)]),
        (3, Some([-10.0, -5.05, 0.0]), vec![]),
    ];
    let out = written(&text, &list);
    let expected = text
        .replace("N5 G3", "G3 X0.00 Y10.00 I-10.0 J0.0\nG1 X0.00 Y9.95\nN5 G3")
        .replace("Y0.0 I-10.0 J0.0\nG1 Y-5\n", "Y-0.05 I0.0 J-10.0\nG1 Y-5.05\n");
    assert_eq!(out, expected, "{out}");
}

#[test]
fn an_arc_whose_ends_move_alike_keeps_its_centre_and_its_radius() {
    for arc in ["G3 X-10.0 Y0.0 I-10.0 J0.0", "G3 X-10.0 Y0.0 R10.0"] {
        let text = format!("{HEAD}G1 X10.0 F100\n{arc}\n");
        let out = written(&text, &[(1, Some([10.05, 0.0, 0.0]), vec![]), (2, Some([-9.95, 0.0, 0.0]), vec![])]);
        assert_eq!(out, text.replace("X10.0 F", "X10.05 F").replace("X-10.0", "X-9.95"));
    }
}

#[test]
fn an_arc_whose_ends_move_differently_gets_a_centre_between() {
    for arc in ["G3 X-10.0 Y0.0 I-10.0 J0.0", "G3 X-10.0 Y0.0 R10.0", "G90.1 G3 X-10.0 Y0.0 I0.0 J0.0"] {
        let text = format!("{HEAD}G1 X10.0 F100\n{arc}\n");
        let out = written(&text, &[(2, Some([-10.05, 0.02, 0.0]), vec![])]);
        // the harness has read it as an arc: both radii agree
        assert!(out.contains("X-10.05 Y0.02"), "{out}");
        assert_eq!(out.lines().count(), text.lines().count());
    }
}

#[test]
fn a_circle_whose_end_alone_moves_is_refused() {
    let text = format!("{HEAD}G1 X10.0 F100\nG3 I-10.0\n");
    assert!(matches!(attempt(&text, &[(2, Some([10.05, 0.0, 0.0]), vec![])]), Err(Error::Refused(_))));
    // with a point between it is not
    let way = vec![point([0.0, 10.0, 0.0], 0.25, true), point([0.0, 9.95, 0.0], 0.25, false)];
    let out = written(&text, &[(2, Some([10.0, -0.05, 0.0]), way)]);
    assert!(out.contains("G3 X10.00 Y-0.05 I0.0 J-10.0"), "{out}");
}

#[test]
fn one_arc_that_cannot_be_written_is_named_and_the_rest_is_written_without_it() {
    let text = format!("{HEAD}G1 X10.0 F100\nG3 I-10.0\nG1 X20.0\nX30.0\n");
    let (robot, all) = (robot(), [(2, Some([10.05, 0.0, 0.0]), vec![]), (4, Some([30.05, 0.0, 0.0]), vec![])]);
    let doc = harness::parse(&Gcode, text.as_bytes(), &robot).unwrap();
    let mut wish = edits(doc.script(), &all);
    let left = doc.unwritable(&wish);
    let circle = moves(doc.script())[2].0;
    assert_eq!(left.iter().map(|l| l.0).collect::<Vec<_>>(), [circle]);
    assert!(left[0].1.contains("circle"), "{}", left[0].1);
    wish.steps.remove(circle);
    assert!(doc.unwritable(&wish).is_empty());
    let out = edited(&Gcode, text.as_bytes(), &wish, &robot).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), text.replace("X30.0", "X30.05"));
}

#[test]
fn a_new_point_beside_its_arc_is_refused() {
    let text = format!("{HEAD}G1 X10.0 F100\nG3 X-10.0 Y0.0 I-10.0 J0.0\n");
    let way = vec![point([0.0, 10.0, 0.0], 0.5, true), point([-1.0, 9.0, 0.0], 0.55, false)];
    assert!(attempt(&text, &[(2, None, way)]).unwrap_err().to_string().contains("beside the arc"));
}

#[test]
fn modal_arcs_without_a_g_word_stay_arcs_behind_a_straight_piece() {
    let text = format!("{HEAD}G1 X10.0 F100\nG3 X0.0 Y10.0 I-10.0 J0.0\nX-10.0 Y0.0 I0.0 J-10.0\n");
    let list = [(3, Some([-10.0, -0.05, 0.0]), vec![point([-0.0001, 9.95, 0.0], 0.00001, false)])];
    let out = written(&text, &list);
    assert!(out.contains("\nG1 X") && out.contains("\nG3 X-10.0 Y-0.05 "), "{out}");
}

#[test]
fn ten_megabytes_are_read_and_written_in_linear_time() {
    let n = 400_000;
    let text: String = HEAD.to_string()
        + "G1 F100\n"
        + &(0..n).map(|k| format!("X{}.125 Y{}.5\n", k % 900, k % 700)).collect::<String>();
    let begun = std::time::Instant::now();
    let robot = robot();
    let document = Gcode.parse(vec![Text::new("job", text.into_bytes())], &robot).unwrap();
    assert_eq!(document.script().moves().count(), n + 1);
    let mut edits = Edits { digit: vec![1e-7; 3], ..Edits::default() };
    for (k, _) in document.script().moves().skip(1) {
        let goal = values(document.script(), k).iter().map(|v| if v.is_nan() { 0.0 } else { v + 5e-5 }).collect();
        edits.steps.insert(k, Edit { goal: Some(goal), ..Edit::default() });
    }
    assert_eq!(document.patches(&edits).unwrap().len(), 2 * n);
    assert!(begun.elapsed().as_secs() < 60, "quadratic");
}

/// A random program: absolute and relative words, arcs in three forms, shifts, labels.
fn random_program(rng: &mut impl Rng) -> String {
    let mut text = String::from(if rng.random_bool(0.8) { "G21 G90 G17\n" } else { "G20 G90\n" });
    let inch = text.starts_with("G20");
    let scale = if inch { 0.04 } else { 1.0 };
    let decimals = rng.random_range(1..5);
    let f = |v: f64| format!("{v:.decimals$}");
    text.push_str("G0 X0.0 Y0.0 Z0.0\n");
    let (mut at, mut absolute) = ([0.0f64; 3], true);
    let mut known = true;
    for n in 0..rng.random_range(1..14) {
        let number = if rng.random_bool(0.3) { format!("N{} ", 10 * n) } else { String::new() };
        match rng.random_range(0..12) {
            0 => {
                absolute = !absolute;
                text.push_str(if absolute { "G90\n" } else { "G91\n" });
            }
            1 => text.push_str("(comment X1)\n"),
            2 => text.push_str("G4 P0.5\n"),
            3 => text.push_str("G92 X1.0\nG92.1\n"),
            4 if known => {
                // an arc about a centre that is written exactly
                let r = f(rng.random_range(2.0..20.0) * scale).parse::<f64>().unwrap();
                let ccw = rng.random_bool(0.5);
                let code = if ccw { 3 } else { 2 };
                let quarter = rng.random_range(1..5);
                // from the right of the centre by quarters
                let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2 * if ccw { 1.0 } else { -1.0 };
                let by = [r * (angle.cos() - 1.0), r * angle.sin()];
                let start = at;
                let word = |k: usize| if absolute { f(start[k] + by[k]) } else { f(by[k]) };
                let centre = match rng.random_range(0..2) {
                    0 if quarter < 4 => format!("R{}", f(if quarter > 2 { -r } else { r })),
                    _ => format!("I{} J0.0", f(-r)),
                };
                let helix = if rng.random_bool(0.3) {
                    format!(" Z{}", f(if absolute { at[2] - scale } else { -scale }))
                } else {
                    String::new()
                };
                if !helix.is_empty() {
                    at[2] -= scale;
                }
                text.push_str(&format!("{number}G{code} X{} Y{}{helix} {centre} F100\n", word(0), word(1)));
                at[0] += by[0];
                at[1] += by[1];
            }
            5 if rng.random_bool(0.3) => {
                text.push_str("M98 P1\nG90 G17 G40 G54\n");
                text.push_str(if inch { "G20\n" } else { "G21\n" });
                (absolute, known) = (true, false);
                text.push_str("G0 X0.0 Y0.0 Z0.0\n");
                at = [0.0; 3];
                known |= true;
            }
            _ => {
                let mut line = format!("{number}G{}", rng.random_range(0..2));
                for (k, l) in ["X", "Y", "Z"].iter().enumerate() {
                    if rng.random_bool(0.5) {
                        let to = f(rng.random_range(-50.0..50.0) * scale).parse::<f64>().unwrap();
                        line.push_str(&format!(
                            "{}{l}{}",
                            if rng.random_bool(0.5) { " " } else { "" },
                            f(if absolute { to } else { to - at[k] })
                        ));
                        at[k] = to;
                    }
                }
                text.push_str(&line);
                text.push('\n');
            }
        }
    }
    if rng.random_bool(0.3) { text.replace('\n', "\r\n") } else { text }
}

/// Offsets as a compensation makes them: each axis has one, that changes at some blocks.
fn random_edits(rng: &mut impl Rng, script: &Script) -> Edits {
    let mut edits = Edits { digit: vec![1e-8; 3], ..Edits::default() };
    let mut offset = [0.0f64; 3];
    let mut at = [None; 3];
    for (k, step) in script.steps.iter().enumerate() {
        let m = match &step.kind {
            StepKind::Move(m) => m,
            StepKind::Break(_) => {
                (offset, at) = ([0.0; 3], [None; 3]);
                continue;
            }
            _ => continue,
        };
        let Goal::Joints(t) = m.goal else {
            (offset, at) = ([0.0; 3], [None; 3]);
            continue;
        };
        let from = at;
        for (a, v) in script.targets.get(t).unwrap().values.iter().enumerate() {
            at[a] = v.map(|v| v.si).or(at[a]);
        }
        if m.fixed.is_some() {
            offset = [0.0; 3];
            continue;
        }
        let mut before = Vec::new();
        let open = m.closed.is_none() && from.iter().zip(&at).all(|(a, b)| a.is_some() == b.is_some());
        for w in m.way.iter().filter(|_| open) {
            before.push(NewPoint {
                q: (0..3).map(|a| w.q[a] + offset[a]).collect(),
                share: w.share,
                t_s: None,
                clearance_m: 0.0,
                of_way: true,
            });
            if rng.random_bool(0.7) {
                offset[rng.random_range(0..2)] += rng.random_range(-1e-4..1e-4);
                before.push(NewPoint {
                    q: (0..3).map(|a| w.q[a] + offset[a]).collect(),
                    share: w.share,
                    t_s: None,
                    clearance_m: 0.0,
                    of_way: false,
                });
            }
        }
        if m.way.is_empty() && m.path == PathKind::Joint {
            offset[rng.random_range(0..3)] += rng.random_range(-1e-4..1e-4);
            if open && rng.random_bool(0.4) {
                let share = rng.random_range(0.1..0.9);
                let q =
                    (0..3).map(|a| from[a].zip(at[a]).map_or(0.0, |(x, y)| x + share * (y - x)) + offset[a]).collect();
                before.push(NewPoint { q, share, t_s: None, clearance_m: 0.0, of_way: false });
            }
        }
        // what a driver does not know of an axis is zero
        let goal = (0..3).map(|a| at[a].map_or(0.0, |v| v + offset[a])).collect();
        edits.steps.insert(k, Edit { before, goal: Some(goal), ..Edit::default() });
    }
    edits
}

/// Whether two programs end every arc and line at the same places but for offsets: checked by the harness; here, that bytes
/// outside of numbers stay.
fn letters(text: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(text).into_owned();
    text.lines()
        .filter(|l| l.starts_with('(') || l.starts_with('N') || l.starts_with("G9") || l.starts_with('M'))
        .map(|l| l.chars().filter(char::is_ascii_alphabetic).collect())
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: u32::try_from(count("PROPTEST_CASES", 256)).unwrap(), ..ProptestConfig::default() })]
    #[test]
    fn edits_come_back_when_the_program_is_read_again(seed in any::<u64>()) {
        let robot = robot();
        let mut rng = generator(seed);
        let text = random_program(&mut rng);
        let script = script_of(&Gcode, &text, &robot);
        let edits = random_edits(&mut rng, &script);
        match edited(&Gcode, text.as_bytes(), &edits, &robot) {
            Ok(out) => {
                let (old, new) = (letters(text.as_bytes()), letters(&out));
                prop_assert!(old.len() <= new.len(), "{text}\n{}", String::from_utf8_lossy(&out));
            }
            // a whole circle, or what no digits hold: said, not done
            Err(Error::Refused(why)) => prop_assert!(why.contains("circle") || why.contains("no arc") || why.contains("very end"), "{why}\n{text}"),
            Err(e) => prop_assert!(false, "{e}\n{text}"),
        }
    }
}

#[test]
fn damaged_programs_are_refused_or_come_back() {
    let source = |rng: &mut ChaCha8Rng| vec![random_program(rng).into_bytes()];
    harness::survives(&Gcode, &robot(), &source, &|script, rng| random_edits(rng, script));
}

#[test]
fn other_formats_are_not_taken_for_gcode() {
    for text in [
        "/JOB\n//NAME A\n//POS\n",
        "a1_deg,a2_deg\n1,2\n",
        "MODULE M\n  PROC main()\n",
        "&ACCESS RVP\nDEF A()\n",
        "def f():\n  movej([0,1])\n",
        "/PROG A\n/ATTR\n",
    ] {
        assert!(!Gcode.recognises(text.as_bytes()), "{text}");
    }
    for text in ["%\nO1000\nG21\n", "; comment\nG0X1Y2\n", "(a)\nN10 G90 G21\n"] {
        assert!(Gcode.recognises(text.as_bytes()), "{text}");
    }
}

#[test]
fn the_samples_are_read_and_their_edits_come_back() {
    let robot = robot();
    let samples = harness::samples(&Gcode);
    for (name, bytes) in &samples {
        assert!(Gcode.recognises(bytes), "{name}");
        let doc = harness::parse(&Gcode, bytes, &robot).unwrap();
        assert!(doc.script().moves().any(|(_, m)| matches!(m.goal, Goal::Joints(_))), "{name}");
        match edited(&Gcode, bytes, &random_edits(&mut generator(3), doc.script()), &robot) {
            Ok(_) => {}
            Err(e) => assert!(matches!(e, Error::Refused(_)), "{name}: {e}"),
        }
    }
    assert!(samples.len() >= 9, "{} samples", samples.len());
}

#[test]
fn pieces_of_an_arc_stay_as_near_to_it_as_their_offsets_are_large() {
    let robot = robot();
    let mut rng = generator(17);
    let text = "G21 G90 G17\nG0 X200 Y100 Z0\nG1 X220.0 F600\nG3 X180.0 Y100.0 I-20.0 J0.0\nG2 X220.0 Y100.0 R20.0\n";
    let script = script_of(&Gcode, text, &robot);
    for _ in 0..300 {
        let mut offset = || [0, 1].map(|_| rng.random_range(-0.05..0.05));
        let (start, top, after, end) = (offset(), offset(), offset(), offset());
        let on = |degrees: f64, o: [f64; 2]| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [200.0 + 20.0 * cos + o[0], 100.0 + 20.0 * sin + o[1], 0.0]
        };
        let list = [
            (1, Some(on(0.0, start)), vec![]),
            (2, Some(on(180.0, end)), vec![point(on(90.0, top), 0.5, true), point(on(99.0, after), 0.55, true)]),
            (3, Some(on(0.0, start)), vec![]),
        ];
        let mut edits = edits(&script, &list);
        edits.digit = vec![1e-7; 3];
        let out = edited(&Gcode, text.as_bytes(), &edits, &robot).unwrap();
        let again = super::read::program(vec![Text::new("again", out.clone())], &robot).unwrap();
        let arcs: Vec<_> = again.statements.arcs();
        // the short piece after the top may be straight: nine degrees less
        let straight = 4 - arcs.len();
        assert!(straight <= 1, "{}", String::from_utf8_lossy(&out));
        let turns: f64 = arcs.iter().map(|(arc, _)| arc.sweep).sum::<f64>() + straight as f64 * 9f64.to_radians();
        assert!(turns.abs() < 0.02, "half a turn there and half a turn back, not {turns}");
        for (arc, _) in arcs {
            for k in 0..=20 {
                let p = arc.at(f64::from(k) / 20.0);
                let off = (p[0] - 200.0).hypot(p[1] - 100.0) - 20.0;
                assert!(off.abs() < 0.1, "{off} mm beside the circle\n{}", String::from_utf8_lossy(&out));
            }
        }
    }
}

const PRINTER: &str = "M104 S200\nG21 G90\nM83\nG1 X10 Y10 F3000\n";

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
