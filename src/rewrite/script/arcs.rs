//! An arc through three points as several: the points on the way of its pieces.
//!
//! Where joints turn inside an arc, it is parted there, and behind the short piece in which their step is spread. Each piece goes
//! through the place in its middle on the arc as it was, moved by the mean of the offsets at its ends. No piece is shorter than a
//! controller needs to tell its circle: the point that parts it goes on along the arc, where a step then takes that much longer;
//! where there is no room the goal alone carries the step.

use super::way::Line;
use crate::program::script::{Edit, NewPoint};

/// Least angle, rad, and length, m, of a piece. ABB (RAPID Instructions, MoveC): points at least 0.1 mm and 1 deg apart, and each
/// piece has three.
const LEAST_RAD: f64 = 0.04;
const LEAST_M: f64 = 1e-3;
/// Longest stretch, in least pieces, over which turns close to each other share one step.
const TOGETHER: f64 = 3.0;

/// Parts the arc of `edit` at its new points: their places, and those on the way of the pieces. `start`: joints where the arc
/// starts, with their offset; `goal` and `own`: where it ends, with and without. Returns how many points found no place.
pub fn split(line: &Line, start: Option<&[f64]>, goal: &[f64], own: &[f64], edit: &mut Edit) -> u64 {
    let before = edit.before.len() as u64;
    let parted = line.arc().and_then(|size| {
        let points = places(line, size, &edit.before)?;
        let vias = vias(line, start?, &points, goal, own)?;
        Some((points, vias))
    });
    match parted {
        Some((points, vias)) if !points.is_empty() => (edit.before, edit.vias) = (points, vias),
        _ => drop(edit.clear_points()),
    }
    before - edit.before.len() as u64
}

/// The points so far apart that every piece is an arc. Of points closer to each other the first and the last stay: what turns
/// between them steps there together.
fn places(line: &Line, [radius_m, angle]: [f64; 2], points: &[NewPoint]) -> Option<Vec<NewPoint>> {
    let least = (LEAST_RAD / angle).max(LEAST_M / (radius_m * angle));
    let mut out: Vec<NewPoint> = Vec::with_capacity(points.len());
    let mut rest = points;
    while let Some(first) = rest.first() {
        let joined = |k: &usize| {
            let (own, before) = (rest[*k].share, rest[*k - 1].share);
            own - before < least && own - first.share <= TOGETHER * least
        };
        let count = 1 + (1..rest.len()).take_while(joined).count();
        let (group, behind) = rest.split_at(count);
        rest = behind;
        let after = |out: &[NewPoint]| out.last().map_or(0.0, |p| p.share) + least;
        // a turn at the start of the arc needs no point of its own, and a step at its end is that of the goal
        if let Some(last) = group.last().filter(|_| count > 1) {
            let share = first.share.min(1.0 - 2.0 * least);
            if share >= after(&out) - 0.5 * least && after(&out) <= 1.0 - 2.0 * least {
                out.push(moved(line, first, share.max(after(&out)))?);
            }
            if last.share <= 1.0 - 0.5 * least && after(&out) <= 1.0 - least {
                out.push(moved(line, last, last.share.max(after(&out)).min(1.0 - least))?);
            }
        } else if (least..=1.0 - least).contains(&first.share) && after(&out) <= 1.0 - least {
            out.push(moved(line, first, first.share.max(after(&out)))?);
        }
    }
    // corners reach no further than to the middle of a piece
    let ends: Vec<f64> = std::iter::once(0.0).chain(out.iter().map(|p| p.share)).chain([1.0]).collect();
    let chord_m = |part: f64| 2.0 * radius_m * (0.5 * part * angle).sin();
    for (point, near) in out.iter_mut().zip(ends.windows(3)) {
        point.clearance_m = 0.5 * chord_m((near[1] - near[0]).min(near[2] - near[1]));
    }
    Some(out)
}

/// A point further along the arc, with its offset.
fn moved(line: &Line, point: &NewPoint, share: f64) -> Option<NewPoint> {
    let offset = less(&point.q, &line.at(point.share)?);
    let q = line.at(share)?.iter().zip(offset).map(|(a, b)| a + b).collect();
    Some(NewPoint { q, share, ..point.clone() })
}

/// Joints at the points on the way of the pieces that end at `points` and at the goal, one each.
fn vias(line: &Line, start: &[f64], points: &[NewPoint], goal: &[f64], own: &[f64]) -> Option<Vec<Vec<f64>>> {
    let mut share = 0.0;
    let mut offset = less(start, &line.at(0.0)?);
    let mut out = Vec::with_capacity(points.len() + 1);
    for (n, end) in points.iter().map(|p| p.share).chain([1.0]).enumerate() {
        let behind = match points.get(n) {
            Some(p) => less(&p.q, &line.at(p.share)?),
            None => less(goal, own),
        };
        let middle = line.at(0.5 * (share + end))?;
        out.push(middle.iter().zip(offset.iter().zip(&behind)).map(|(q, (a, b))| q + 0.5 * (a + b)).collect());
        (share, offset) = (end, behind);
    }
    Some(out)
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
