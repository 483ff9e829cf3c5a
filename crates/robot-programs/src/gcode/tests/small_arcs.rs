//! Arcs that are not much larger than their last digits, or than the offset that changes on them.

use super::*;
use crate::gcode::arc::Arc;

fn ways(text: &str) -> usize {
    moves(&script_of(&Gcode, text, &robot())).last().unwrap().1.way.len()
}

/// A corner of 0.2 mm whose end stands 0.005 mm after its quadrant.
const CORNER: &str =
    "G21 G90 G17\nG0 X6.635 Y16.475 Z0.0\nG1 X13.966 Y16.484 F100\nG3 X13.906 Y16.876 I-0.055 J0.192\n";

#[test]
fn a_quadrant_within_the_last_digits_of_an_end_is_no_point_of_the_way() {
    assert_eq!(ways(CORNER), 1, "the other quadrant stays");
    // the same in finer digits is meant
    let fine = CORNER.replace("X13.906 Y16.876", "X13.906000 Y16.876000").replace("X13.966 Y", "X13.966000 Y");
    assert_eq!(ways(&fine.replace("16.484", "16.484000")), 2);
    // coarse numbers are places, not rounding
    assert_eq!(ways("G21 G90 G17\nG0 X50 Y-1 Z0\nG3 X50 Y1 I-50 J1\n"), 1);
}

#[test]
fn an_offset_may_change_over_an_arc_that_is_hardly_larger() {
    let robot = robot();
    let script = script_of(&Gcode, CORNER, &robot);
    for d in [0.02, 0.044, 0.1] {
        for (by, end) in [([d, 0.0], [0.0, d]), ([-d, d], [d, -d]), ([0.0, 0.0], [-d, -d])] {
            let list = [
                (1, Some([13.966 + by[0], 16.484 + by[1], 0.0]), vec![]),
                (2, Some([13.906 + end[0], 16.876 + end[1], 0.0]), vec![]),
            ];
            let out = edited(&Gcode, CORNER.as_bytes(), &edits(&script, &list), &robot).unwrap();
            let again = super::super::whole::program(vec![Text::new("again", out.clone())], &robot).unwrap();
            let arc: Arc = again.statements.arcs()[0].0;
            let most = 2.0 * (by[0] - end[0]).hypot(by[1] - end[1]);
            let own = Arc::about([0, 1], [13.966, 16.484], [13.906, 16.876], [13.911, 16.676], true).unwrap();
            for k in 0..=10 {
                let t = f64::from(k) / 10.0;
                let (p, q) = (arc.at(t), own.at(t));
                let off = [0, 1].map(|i| p[i] - q[i] - by[i] - t * (end[i] - by[i]));
                assert!(off[0].hypot(off[1]) <= most + 2e-3, "{off:?}\n{}", String::from_utf8_lossy(&out));
            }
        }
    }
}

#[test]
fn a_step_behind_a_quadrant_near_the_end_is_written() {
    // the quadrant of the top stands 0.03 mm before the end
    let text = "G21 G90 G17\nG0 X0.0 Y0.0 Z0.0\nG1 X13.966 Y16.484 F100\nG3 X13.881 Y16.876 I-0.055 J0.192\n";
    let script = script_of(&Gcode, text, &robot());
    let way = moves(&script)[2].1.way.clone();
    assert_eq!(way.len(), 2);
    let mm = |k: usize| [0, 1, 2].map(|a| way[k].q[a] * 1e3);
    let ([x1, y1, z], top) = (mm(0), mm(1));
    let list = [(
        2,
        Some([13.881 - 0.04, 16.876 - 0.044, z]),
        vec![point([x1, y1, z], way[0].share, true), point([top[0] - 0.04, top[1], z], way[1].share, true)],
    )];
    let out = written(text, &list);
    assert_eq!(out.lines().count(), 6, "{out}");
    assert!(out.lines().last().unwrap().starts_with("G3 X13.841"), "{out}");
}
