//! Where programs work: the pose in the middle of the joints that they command.
//!
//! Friction depends on load, a gap on position, and what a joint's error does to the TCP on the pose, so a test near the programs
//! describes them better than one elsewhere. The middle is that of the positions without those at which a program starts and ends, which
//! are a home position as a rule, and without the outer tenths of the others.

use crate::numerics::robust::quantile_of_sorted;
use crate::program::Program;

/// Share of a program's points on either side that do not count.
const OUTER: f64 = 0.1;

/// Middle of each joint's range, over all programs, rad or m; `None` where none has a point.
pub fn middle_of(programs: &[Program]) -> Option<Vec<f64>> {
    let axes = programs.iter().map(|p| p.q.len()).min()?;
    let middle = |axis: usize| {
        let ends = programs.iter().filter_map(|p| {
            let mut sorted: Vec<f64> = between_homes(p).map(|point| p.q[axis][point]).collect();
            sorted.sort_by(f64::total_cmp);
            Some([quantile_of_sorted(&sorted, OUTER)?, quantile_of_sorted(&sorted, 1.0 - OUTER)?])
        });
        let all = ends.reduce(|[lo, hi], [a, b]| [lo.min(a), hi.max(b)]);
        all.map(|[lo, hi]| 0.5 * (lo + hi))
    };
    (0..axes).map(middle).collect()
}

/// Points of a program other than those at which it starts and ends; all of them where nothing else is there.
fn between_homes(program: &Program) -> impl Iterator<Item = usize> {
    let count = program.q.first().map_or(0, Vec::len);
    let is_at = |point: usize, home: usize| program.q.iter().all(|q| q[point] == q[home]);
    let mut kept: Vec<usize> = (0..count).filter(|&k| !is_at(k, 0) && !is_at(k, count - 1)).collect();
    if kept.is_empty() {
        kept = (0..count).collect();
    }
    kept.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::from_bytes;
    use crate::robot::Robot;

    fn program(rows: &str) -> Program {
        let robot = Robot::load(std::path::Path::new("configs/gantry-xyz-ballscrew.yaml")).unwrap();
        let text = format!("x_mm,y_mm,z_mm\n{rows}");
        Program::parse(from_bytes("program.csv".into(), text.into_bytes()).unwrap(), &robot).unwrap()
    }

    #[test]
    fn the_middle_is_that_of_all_programs_and_homes_do_not_move_it() {
        let work: String = (0..=100).map(|k| format!("{},{},-200\n", 400 + k, 300 - k)).collect();
        let with_homes = program(&format!("0,0,0\n{work}0,0,0\n"));
        let middle = middle_of(std::slice::from_ref(&with_homes)).unwrap();
        for (found, expected) in middle.iter().zip([0.45, 0.25, -0.2]) {
            assert!((found - expected).abs() < 2e-3, "{middle:?}");
        }
        let short = program("0,0,0\n500,300,-200\n520,310,-210\n510,305,-205\n0,0,0\n");
        assert!((middle_of(&[short]).unwrap()[0] - 0.51).abs() < 1e-9);
        let elsewhere = program("700,250,-200\n700,250,-200\n");
        let both = middle_of(&[with_homes, elsewhere]).unwrap();
        assert!((both[0] - 0.5 * (0.41 + 0.7)).abs() < 2e-3, "{both:?}");
        assert_eq!(middle_of(&[]), None);
    }
}
