//! Two programs of which parts are not known, stretch by stretch.
//!
//! Method: both programs are read by the same rules, so that a change of numbers leaves their stretches as they are. A stretch of the
//! program before belongs to the next one of the program after that starts and ends where it does, within [`APART_M`], or has about its
//! length. One without a partner is left out, and that is noted. So is one in which the TCP does not move: it has no path.

use super::note::Note;
use super::path::lengths;
use super::source::Source;
use crate::program::Program;
use crate::robot::Robot;
use nalgebra::Vector3;
use std::ops::Range;

/// Stretches whose starts and ends are closer are the same one, m.
const APART_M: f64 = 1e-3;
/// Stretches of the other program among which the partner is looked for.
const AHEAD: usize = 16;
/// A shorter path is not counted, m.
const LEAST_M: f64 = 1e-6;

/// The same stretch of two programs.
pub struct Pair {
    pub before: Program,
    pub after: Program,
    /// Length of the path before, m.
    pub length_m: f64,
    /// It does not start where the program starts.
    pub anew: bool,
}

/// A stretch and where its TCP goes.
struct Stretch {
    points: Range<usize>,
    ends_m: [Vector3<f64>; 2],
    length_m: f64,
}

impl Stretch {
    fn of(robot: &Robot, program: &Program, points: Range<usize>) -> Self {
        let mut q = vec![0.0; robot.dof()];
        let mut at = |i: usize| {
            program.point_into(i, &mut q);
            robot.tcp_m(&q)
        };
        let path: Vec<Vector3<f64>> = points.clone().map(&mut at).collect();
        let end = |p: Option<&Vector3<f64>>| p.copied().unwrap_or_default();
        let length_m = lengths(&path).last().copied().unwrap_or(0.0);
        Self { points, ends_m: [end(path.first()), end(path.last())], length_m }
    }

    fn is(&self, other: &Self) -> bool {
        let apart = self.ends_m.iter().zip(&other.ends_m).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        apart <= APART_M && (self.length_m - other.length_m).abs() <= APART_M.max(0.1 * self.length_m)
    }
}

/// The stretches of two programs that belong together; `None`: at least one is a log, or both are known from end to end.
pub fn of(robot: &Robot, before: &Source, after: &Source, notes: &mut Vec<Note>) -> Option<Vec<Pair>> {
    let (Source::Program(before), Source::Program(after)) = (before, after) else { return None };
    let [ours, theirs] = [before.stretches(), after.stretches()];
    if ours.len() == 1 && theirs.len() == 1 {
        return None;
    }
    let all = |p: &Program, list: Vec<Range<usize>>| -> Vec<Stretch> {
        list.into_iter().map(|points| Stretch::of(robot, p, points)).filter(|s| s.length_m > LEAST_M).collect()
    };
    let (ours, theirs) = (all(before, ours), all(after, theirs));
    let (mut pairs, mut next) = (Vec::new(), 0);
    for stretch in &ours {
        let Some(k) = (next..theirs.len().min(next + AHEAD)).find(|&k| stretch.is(&theirs[k])) else { continue };
        next = k + 1;
        pairs.push(Pair {
            before: before.stretch(stretch.points.clone()),
            after: after.stretch(theirs[k].points.clone()),
            length_m: stretch.length_m,
            anew: stretch.points.start > 0,
        });
    }
    if pairs.len() < ours.len() {
        notes.push(Note::StretchesLeftOut { stretches: ours.len() - pairs.len() });
    }
    Some(pairs)
}
