//! Arcs: their turns, pieces and centres.

use super::*;

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
    assert!(left[0].1.to_string().contains("circle"), "{}", left[0].1);
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
        let again = super::super::whole::program(vec![Text::new("again", out.clone())], &robot).unwrap();
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
