mod arcs;
mod calls;
mod codes;
mod cycles;
mod doubts;
mod flows;
mod frames;
mod lathes;
mod machine;
mod numbers;
mod once;
mod places;
mod random;
mod random_flows;
mod relative;
mod rotary;
mod small_arcs;
mod starts;
mod waits;
mod words_of_makers;

use super::Gcode;
use crate::error::Error;
use crate::script::harness::{self, count, edited, generator, moves, refusal, script_of, values};
use crate::script::{Break, Edit, Edits, Format, Goal, NewPoint, PathKind, Script, Speed, StepKind, Text};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::fixtures::gantry as robot;

fn point(mm: [f64; 3], share: f64, of_way: bool) -> NewPoint {
    NewPoint { q: mm.map(|v| v * 1e-3).to_vec(), share, t_s: None, clearance_m: 0.001, of_way, waits: false }
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
        Goal::Opaque(why) => Some(why.to_string()),
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
        ("G21 G90\nL10\nG0 X1\n", "after a call"),
        ("G21 G90\nN5 L10 P3\nG0 X1\n", "after a call"),
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
            StepKind::Sets(name) => format!("sets {name}"),
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
    assert!(m[3].speed == Speed::Seconds(30.0) && m[3].closed.as_ref().unwrap().to_string().contains("G93"));
    assert!(
        m[4].closed.as_ref().unwrap().to_string().contains(" M ")
            && m[5].closed.as_ref().unwrap().to_string().contains(" E ")
    );
}

const PRINTER: &str = "M104 S200\nG21 G90\nM83\nG1 X10 Y10 F3000\n";
