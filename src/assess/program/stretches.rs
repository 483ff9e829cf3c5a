//! Two programs of which parts are not known, stretch by stretch.
//!
//! Method: both programs are read by the same rules, so that a change of numbers leaves their stretches as they are, in their order. A
//! stretch of the program after may be that of the program before if it starts and ends where that does, as far as offsets move it, and has
//! about its length. Of all ways to pair them in order, the one with the most pairs counts, and of those the one whose paths lie closest:
//! branches that lead to one target, one straight and one in the joints, have ends in common and nothing else. A stretch without a partner
//! is left out, and that is noted. So is one in which the TCP does not move: it has no path.

use super::note::Note;
use super::path::lengths;
use super::source::{Source, half_gap};
use crate::model::Model;
use crate::program::Program;
use nalgebra::Vector3;
use std::ops::Range;

/// Stretches whose starts and ends are closer may be the same one, m; or by as much more as offsets may move them, and that many times.
const APART_M: f64 = 1e-3;
const OFFSETS: f64 = 1.2;
/// Stretches of the other program among which the partner is looked for, besides those by which their numbers differ, as far as these
/// count.
const AHEAD: usize = 16;
const MORE: usize = 64;
/// Places at which the paths of stretches are compared, evenly along them.
const PLACES: usize = 9;
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
    /// Where the TCP is at [`PLACES`].
    path_m: [Vector3<f64>; PLACES],
    length_m: f64,
    /// How far offsets may move its ends, m.
    moved_m: f64,
}

impl Stretch {
    fn of(model: &Model, program: &Program, points: Range<usize>) -> Self {
        let robot = &model.robot;
        let mut q = vec![0.0; robot.dof()];
        let mut at = |i: usize| {
            program.point_into(i, &mut q);
            robot.tcp_m(&q)
        };
        let path: Vec<Vector3<f64>> = points.clone().map(&mut at).collect();
        let along = lengths(path.iter().copied());
        let length_m = along.last().copied().unwrap_or(0.0);
        let place = |n: usize| {
            let wanted = length_m * n as f64 / (PLACES - 1) as f64;
            let k = along.partition_point(|a| *a < wanted).min(path.len().saturating_sub(1));
            let (Some(to), Some(from)) = (path.get(k), path.get(k.saturating_sub(1))) else { return Vector3::zeros() };
            let step = along[k] - along[k.saturating_sub(1)];
            if step > 0.0 { to + (from - to) * ((along[k] - wanted) / step) } else { *to }
        };
        let path_m = std::array::from_fn(place);
        let ends = [points.start, points.end.saturating_sub(1)];
        let moved_m = ends.into_iter().filter(|i| points.contains(i)).map(|i| moved_m(model, program, i));
        Self { path_m, length_m, moved_m: moved_m.fold(0.0, f64::max), points }
    }

    /// How far the TCP of another one is from its own at some of the places.
    fn apart_m(&self, other: &Self, places: impl Iterator<Item = usize>) -> f64 {
        places.map(|n| (self.path_m[n] - other.path_m[n]).norm()).fold(0.0, f64::max)
    }

    /// Whether a stretch of the program after may be this one.
    fn may_be(&self, other: &Self) -> bool {
        let near = APART_M.max(OFFSETS * self.moved_m);
        self.apart_m(other, [0, PLACES - 1].into_iter()) <= near
            && (self.length_m - other.length_m).abs() <= APART_M.max(0.1 * self.length_m)
    }
}

/// How far the offsets of all joints may move the TCP at a point, m.
fn moved_m(model: &Model, program: &Program, point: usize) -> f64 {
    let mut q = vec![0.0; model.robot.dof()];
    program.point_into(point, &mut q);
    let here = model.robot.tcp_m(&q);
    let by = |axis: usize| {
        let mut there = q.clone();
        there[axis] += half_gap(model, axis, q[axis]);
        (model.robot.tcp_m(&there) - here).norm()
    };
    (0..q.len()).map(by).sum()
}

/// What is best for the first stretches of both programs: how many of them are pairs, how far these are apart together, m, and whether the
/// last ones are a pair (0) or the last one of the program before (1) or after (2) has no partner.
type Best = (usize, f64, u8);

/// Stretches that belong together, in their order.
fn partners(ours: &[Stretch], theirs: &[Stretch]) -> Vec<(usize, usize)> {
    let band = AHEAD + ours.len().abs_diff(theirs.len()).min(MORE);
    let columns = |i: usize| i.saturating_sub(band)..(i + band).min(theirs.len()) + 1;
    let mut rows: Vec<Vec<Best>> = Vec::with_capacity(ours.len() + 1);
    for i in 0..=ours.len() {
        let mut row: Vec<Best> = Vec::with_capacity(2 * band + 1);
        for k in columns(i) {
            let before = i.checked_sub(1);
            let above = |k: usize| Some((before?, k)).and_then(|(i, k)| rows[i].get(k.checked_sub(columns(i).start)?));
            let mut best = row.last().map_or((0, 0.0, 2), |b| (b.0, b.1, 2));
            let skipped = above(k).map(|b| (b.0, b.1, 1));
            let paired =
                before.zip(k.checked_sub(1)).filter(|(i, k)| ours[*i].may_be(&theirs[*k])).and_then(|(i, k)| {
                    let apart = ours[i].apart_m(&theirs[k], 0..PLACES);
                    above(k).map(|b| (b.0 + 1, b.1 + apart, 0))
                });
            for other in skipped.into_iter().chain(paired) {
                if other.0 > best.0 || other.0 == best.0 && other.1 <= best.1 {
                    best = other;
                }
            }
            row.push(best);
        }
        rows.push(row);
    }
    let (mut i, mut k) = (ours.len(), columns(ours.len()).end - 1);
    let mut pairs = Vec::new();
    while i > 0 {
        match k.checked_sub(columns(i).start).and_then(|k| rows[i].get(k)).map_or(1, |b| b.2) {
            0 => {
                (i, k) = (i - 1, k.saturating_sub(1));
                pairs.push((i, k));
            }
            2 if k > columns(i).start => k -= 1,
            _ => i -= 1,
        }
    }
    pairs.reverse();
    pairs
}

/// The stretches of two programs that belong together; `None`: at least one is a log, or both are known from end to end.
pub fn of(model: &Model, before: &Source, after: &Source, notes: &mut Vec<Note>) -> Option<Vec<Pair>> {
    let (Source::Program(before), Source::Program(after)) = (before, after) else { return None };
    let [ours, theirs] = [before.stretches(), after.stretches()];
    if ours.len() == 1 && theirs.len() == 1 {
        return None;
    }
    let all = |p: &Program, list: Vec<Range<usize>>| -> Vec<Stretch> {
        list.into_iter().map(|points| Stretch::of(model, p, points)).filter(|s| s.length_m > LEAST_M).collect()
    };
    let (ours, theirs) = (all(before, ours), all(after, theirs));
    let pair = |(i, k): (usize, usize)| Pair {
        before: before.stretch(ours[i].points.clone()),
        after: after.stretch(theirs[k].points.clone()),
        length_m: ours[i].length_m,
        anew: ours[i].points.start > 0,
    };
    let pairs: Vec<Pair> = partners(&ours, &theirs).into_iter().map(pair).collect();
    if pairs.len() < ours.len() {
        notes.push(Note::StretchesLeftOut { stretches: ours.len() - pairs.len() });
    }
    Some(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From (0, 0) to `end` over (50 mm, `up`), mm.
    fn stretch(end: [f64; 2], up: f64) -> Stretch {
        let place = |n: usize| {
            let share = n as f64 / (PLACES - 1) as f64;
            let bow = up * 4.0 * share * (1.0 - share);
            Vector3::new(end[0] * share, end[1] * share + bow, 0.0) * 1e-3
        };
        Stretch { points: 0..2, path_m: std::array::from_fn(place), length_m: 0.1, moved_m: 1.5e-3 }
    }

    #[test]
    fn branches_with_the_same_ends_have_their_own_partners() {
        let ours = [stretch([100.0, 0.0], 17.0), stretch([100.0, 0.0], 0.0)];
        // offsets move the end of the first by 1.3 mm and that of the second by 0.9 mm
        let theirs = [stretch([101.3, 0.0], 17.3), stretch([100.9, 0.0], 0.2)];
        assert_eq!(partners(&ours, &theirs), [(0, 0), (1, 1)]);
        // without a partner of one, the other keeps its own
        assert_eq!(partners(&ours, &theirs[1..]), [(1, 0)]);
        assert_eq!(partners(&ours, &theirs[..1]), [(0, 0)]);
        assert_eq!(partners(&ours[1..], &theirs), [(0, 1)]);
    }

    #[test]
    fn a_stretch_that_leaves_its_way_is_compared_with_its_own() {
        let ours = [stretch([100.0, 0.0], 17.0), stretch([100.0, 0.0], 0.0)];
        let theirs = [stretch([100.0, 0.0], 0.0), stretch([100.0, 0.0], 0.0)];
        assert_eq!(partners(&ours, &theirs), [(0, 0), (1, 1)]);
    }

    #[test]
    fn stretches_are_paired_in_their_order_however_many_are_new() {
        let at = |k: usize| stretch([100.0 + 50.0 * k as f64, 0.0], 0.0);
        let ours: Vec<Stretch> = (0..200).map(at).collect();
        let theirs: Vec<Stretch> = (0..30).map(|k| at(900 + k)).chain((0..200).map(at)).collect();
        let pairs: Vec<(usize, usize)> = (0..200).map(|k| (k, k + 30)).collect();
        assert_eq!(partners(&ours, &theirs), pairs);
        assert_eq!(partners(&theirs, &ours), pairs.iter().map(|(a, b)| (*b, *a)).collect::<Vec<_>>());
        assert!(partners(&ours, &[]).is_empty() && partners(&[], &theirs).is_empty());
    }
}
