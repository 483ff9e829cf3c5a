//! The error at the targets of a vendor program: where the robot stops or is taught, apart from the way between them.
//!
//! Method: at a target the error is the whole distance between the TCP and the place where the machine without the joint errors that an
//! offset can undo would have it: at a stop an error along the path counts, too. It is taken on arrival, before a joint turns: what is
//! left after a reversal belongs to the way. Both runs have a row at each target.
//!
//! Points that a rewrite added are no targets: a target of the program before is looked for in the program after in order, within
//! three times the largest half gap. One that is not found is left out. Goals that stand closer to each other than twice that are points
//! of a path, which the error along the way covers.

use super::source::{Source, half_gap};
use crate::model::Model;
use crate::program::Program;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Offset of a joint within which two targets are the same one: half gaps, and its bounds, rad or m.
const NEAR_GAPS: f64 = 3.0;
const NEAR: [f64; 2] = [2e-4, 1.5e-3];
/// Points that may have been added before a target.
const ADDED: usize = 24;
/// A joint that moves by less stands still, rad or m.
const STILL: f64 = 1e-9;
/// Two targets whose distances from one differ by less are equally near, rad or m.
const SAME: f64 = 1e-7;

/// Targets of the program before and the points of the program after that they became; none where one is a log.
#[derive(Debug, Default)]
pub struct Targets {
    pub before: Vec<usize>,
    pub after: Vec<usize>,
}

impl Targets {
    pub fn of(model: &Model, before: &Source, after: &Source) -> Self {
        let (Source::Program(ours), Source::Program(theirs)) = (before, after) else { return Self::default() };
        let gap = |axis: usize| ours.q[axis].first().map_or(0.0, |&q| half_gap(model, axis, q));
        let gaps = (0..ours.q.len()).map(gap).fold(0.0, f64::max);
        let near = (NEAR_GAPS * gaps).clamp(NEAR[0], NEAR[1]);
        let (before, after) = pairs(ours, theirs, near).into_iter().unzip();
        Self { before, after }
    }

    /// Errors at them, m, before and after. `wanted_m`, `off_m`: how far the TCP is from where the nominal robot has it, in the run of the
    /// program before on the machine without errors, and in both runs.
    pub fn errors(
        &self,
        robot: &Robot,
        sources: [&Source; 2],
        wanted_m: &[Vector3<f64>],
        off_m: [&[Vector3<f64>]; 2],
    ) -> Vec<[f64; 2]> {
        let [Source::Program(before), Source::Program(after)] = sources else { return Vec::new() };
        let of = |k: usize| {
            let shift = commanded(robot, after, self.after[k]) - commanded(robot, before, self.before[k]);
            let off = off_m.map(|run| run[k] - wanted_m[k]);
            [off[0].norm(), (off[1] + shift).norm()]
        };
        let known = off_m.iter().chain([&wanted_m]).map(|run| run.len()).min().unwrap_or(0);
        (0..self.before.len().min(known)).map(of).collect()
    }
}

/// Targets of the program before, each with the point of the program after that it became.
fn pairs(before: &Program, after: &Program, near_by: f64) -> Vec<(usize, usize)> {
    let (mut out, mut next, mut last) = (Vec::new(), 0, 0);
    for k in apart(before, near_by) {
        let goal = before.goals[k];
        let ahead = after.goals.get(next..).unwrap_or_default().iter().take(k - last + 1 + ADDED);
        let near = ahead.enumerate().map(|(n, &point)| (n, point, distance((before, goal), (after, point))));
        let mut near = near.skip_while(|n| n.2 > near_by).take_while(|n| n.2 <= near_by);
        let Some(mut found) = near.next() else { continue };
        // a point from which it is reached may stand near it
        for n in near {
            if n.2 < found.2 - SAME {
                found = n;
            }
        }
        (next, last) = (next + found.0 + 1, k + 1);
        out.push((goal, found.1));
    }
    out
}

/// The goals that stand apart from those before and after them, by their places in the list. Of goals at one place the first counts.
fn apart(program: &Program, near_by: f64) -> Vec<usize> {
    let goals = &program.goals;
    let step = |k: usize| distance((program, goals[k - 1]), (program, goals[k]));
    let moves: Vec<usize> = (0..goals.len()).filter(|&k| k == 0 || step(k) > STILL).collect();
    let far = |n: usize| distance((program, goals[moves[n - 1]]), (program, goals[moves[n]])) > 2.0 * near_by;
    (0..moves.len()).filter(|&n| (n == 0 || far(n)) && (n + 1 == moves.len() || far(n + 1))).map(|n| moves[n]).collect()
}

/// Largest difference of a joint between points of two programs, rad or m.
fn distance((a, i): (&Program, usize), (b, k): (&Program, usize)) -> f64 {
    a.q.iter().zip(&b.q).map(|(x, y)| (x[i] - y[k]).abs()).fold(0.0, f64::max)
}

/// Where a point of a program puts the nominal robot, m.
fn commanded(robot: &Robot, program: &Program, point: usize) -> Vector3<f64> {
    let mut q = vec![0.0; robot.dof()];
    program.point_into(point, &mut q);
    robot.tcp_m(&q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::ScriptPath;

    fn program(q: &[f64]) -> Program {
        let path = Program::of_path("p".into(), String::new(), vec![q.to_vec()], None, ScriptPath::default());
        Program { goals: (0..q.len()).collect(), ..path }
    }

    #[test]
    fn points_that_were_added_are_no_targets_and_targets_that_are_gone_are_left_out() {
        let before = program(&[0.0, 0.5, 0.2, 0.9, 0.2]);
        // an offset of 7e-5; a step after the turn, one on the way, a point before the last target; 0.9 is gone
        let after = program(&[0.0, 0.50007, 0.49, 0.19993, 0.21, 0.2004, 0.19993]);
        assert_eq!(pairs(&before, &after, 1.5e-3), [(0, 0), (1, 1), (2, 3), (4, 6)]);
    }

    #[test]
    fn a_target_twice_in_a_row_is_one_and_points_close_together_are_none() {
        let (before, after) = (program(&[0.3, 0.3, 0.1]), program(&[0.30007, 0.30007, 0.2, 0.1]));
        assert_eq!(pairs(&before, &after, 1.5e-3), [(0, 0), (2, 3)]);
        let dense = program(&[0.0, 0.4, 0.401, 0.402, 0.9]);
        assert_eq!(pairs(&dense, &dense, 1.5e-3), [(0, 0), (4, 4)]);
    }

    #[test]
    fn a_place_near_a_target_that_is_left_out_is_not_taken_for_another() {
        // 80, 82, 79, 82 mm with offsets of 0.01 mm
        let (before, after) = (program(&[0.080, 0.082, 0.079, 0.082]), program(&[0.08001, 0.08201, 0.07901, 0.08201]));
        assert_eq!(pairs(&before, &after, 2e-4), [(0, 0), (1, 1), (2, 2), (3, 3)]);
    }
}
