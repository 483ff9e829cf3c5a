//! The reference path, and the distance of points to it in the order in which they pass.
//!
//! Method: a point of a run has come some length along the commanded path. Its nearest point on the reference is looked for among
//! the segments whose length of path lies within [`SLACK_M`] (and the difference between both lengths) of that. So a path
//! that crosses itself, comes back on itself, or pauses, is followed without ambiguity. A run as a whole is followed from point to point
//! too ([`Reference::follow`]): what a rewrite adds makes single parts longer, so that lengths from the start drift apart by more than the
//! slack and come together again. Both ends of the reference go on straight for the longest step between its points: the rows of two runs
//! end up to a row apart, and a run that is early or late along the path has no error.

use nalgebra::Vector3;

/// Length of path on either side within which the nearest point is looked for, m.
pub const SLACK_M: f64 = 1e-3;
/// Distances that differ by less are equal, m.
const SAME_M: f64 = 1e-9;

/// A path that is no longer has not moved, m.
const STILL_M: f64 = 1e-12;

/// Segments at which points of a run are compared with a path, at most: a short path of very many points is thinned.
const MOST_COMPARED: f64 = 2e8;

/// A path with its length up to every point.
#[derive(Debug, Clone)]
pub struct Reference {
    points: Vec<Vector3<f64>>,
    t_s: Vec<f64>,
    along: Vec<f64>,
    /// Whether it is smooth at each point; empty: straight from point to point.
    smooth: Vec<bool>,
    /// How far it is from its chords at most, m.
    off_chords_m: f64,
    /// Longest step between two points, m.
    step_m: f64,
}

/// Length of a path up to each of its points, m.
pub fn lengths(points: impl IntoIterator<Item = Vector3<f64>>) -> Vec<f64> {
    let (mut sum, mut last) = (0.0, None);
    let of = |point: Vector3<f64>| {
        sum += last.replace(point).map_or(0.0, |before: Vector3<f64>| (point - before).norm());
        sum
    };
    points.into_iter().map(of).collect()
}

/// The points of a path that are kept, by its length up to each; `None`: all. Where so many lie within the slack that each point of a run
/// would be compared with very many, points a few micrometres apart are kept, and both ends.
fn thinned(along: &[f64]) -> Option<Vec<usize>> {
    let mut ahead = 0;
    let within = |(i, a): (usize, &f64)| {
        while ahead < along.len() && along[ahead] <= a + 2.0 * SLACK_M {
            ahead += 1;
        }
        ahead.saturating_sub(i) as f64
    };
    let compared: f64 = along.iter().enumerate().map(within).sum();
    if compared <= MOST_COMPARED {
        return None;
    }
    let apart_m = 2.0 * SLACK_M * along.len() as f64 / MOST_COMPARED;
    let mut last = f64::NEG_INFINITY;
    let keeps = |&i: &usize| {
        let keeps = along[i] - last >= apart_m || i + 1 == along.len();
        last = if keeps { along[i] } else { last };
        keeps
    };
    Some((0..along.len()).filter(keeps).collect())
}

/// The place of a path nearest to a point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nearest {
    /// Distance of the point.
    pub off_m: f64,
    /// Time of the reference there.
    pub t_s: f64,
    /// The place, and the direction of the path there (zero where the path stands still).
    pub at: Vector3<f64>,
    pub direction: Vector3<f64>,
    /// Length of the path up to it, m.
    pub along_m: f64,
}

impl Reference {
    /// Of points and their times, s.
    pub fn new(mut points: Vec<Vector3<f64>>, mut t_s: Vec<f64>) -> Self {
        let mut along = lengths(points.iter().copied());
        if let Some(kept) = thinned(&along) {
            points = kept.iter().map(|&i| points[i]).collect();
            [t_s, along] = [t_s, along].map(|of| kept.iter().map(|&i| of[i]).collect());
        }
        let step_m = points.windows(2).map(|w| (w[1] - w[0]).norm()).fold(0.0, f64::max);
        Self { points, t_s, along, smooth: Vec::new(), off_chords_m: 0.0, step_m }
    }

    /// The same path, bent between two points of which one or both are `smooth`: the TCP of a fast arm leaves the chord between rows that
    /// are millimetres apart by micrometres.
    pub fn bent(self, smooth: Vec<bool>) -> Self {
        if smooth.len() != self.points.len() {
            return self;
        }
        let mut bent = Self { smooth, ..self };
        let off = (1..bent.points.len()).map(|i| bent.bend(i - 1).norm() / 8.0);
        bent.off_chords_m = off.fold(0.0, f64::max);
        bent
    }

    /// Second derivative by time between point `i` and the next, times the square of the time between them, m. At the share `s` of the
    /// chord, the path is off it by `s (s - 1) / 2` times that.
    fn bend(&self, i: usize) -> Vector3<f64> {
        let second = |k: usize| {
            let smooth = self.smooth.get(k) == Some(&true) && k > 0 && k + 1 < self.points.len();
            let [before, after] = if smooth {
                [k - 1, k].map(|j| (self.points[j + 1] - self.points[j], self.t_s[j + 1] - self.t_s[j]))
            } else {
                return None;
            };
            (before.1 > 0.0 && after.1 > 0.0)
                .then(|| (after.0 / after.1 - before.0 / before.1) * (2.0 / (before.1 + after.1)))
        };
        let duration = self.t_s[i + 1] - self.t_s[i];
        let mean = match (second(i), second(i + 1)) {
            (Some(first), Some(last)) => (first + last) * 0.5,
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return Vector3::zeros(),
        };
        mean * (duration * duration)
    }

    pub fn length_m(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// Point of the path at a length, m.
    pub fn at(&self, along: f64) -> Vector3<f64> {
        let i = self.along.partition_point(|&a| a < along).min(self.points.len() - 1);
        let Some(before) = i.checked_sub(1) else { return self.points[i] };
        let (from, to) = (self.along[before], self.along[i]);
        let share = if to > from { ((along - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        self.points[before].lerp(&self.points[i], share)
    }

    /// The places nearest to the points of a run that has come `along` at each (times `scale` of this path's length): near that length of
    /// this path, or as far after the previous place as the run has advanced since, whichever is nearer.
    pub fn follow<'a>(
        &'a self,
        points: &'a [Vector3<f64>],
        along: &'a [f64],
        scale: f64,
        slack_m: f64,
    ) -> impl Iterator<Item = Nearest> + 'a {
        let mut before: Option<(f64, f64)> = None;
        let of = move |(point, along): (&Vector3<f64>, &f64)| {
            let along = along * scale;
            let hint = before.map(|(place, was)| place + along - was);
            // no place near the length from the start is further than one that stands there
            let hinted = hint.map_or(f64::INFINITY, |hint| (self.at(hint) - point).norm());
            let within = hint.is_some_and(|hint| (hint - along).abs() <= slack_m);
            let mut near = self.nearest_within(point, along, slack_m, if within { hinted } else { f64::INFINITY });
            if let Some(hint) = hint {
                let after = self.nearest_within(point, hint, SLACK_M, hinted.min(near.off_m));
                if after.off_m < near.off_m - SAME_M {
                    near = after;
                }
            }
            before = Some((near.along_m, along));
            near
        };
        points.iter().zip(along).map(of)
    }

    /// The place of the path nearest to a point, near a length of it; beyond the ends by a step at most.
    pub fn nearest(&self, point: &Vector3<f64>, along: f64, slack_m: f64) -> Nearest {
        self.nearest_within(point, along, slack_m, f64::INFINITY)
    }

    /// The same where a place no further than `bound_m` is known or wanted; infinitely far: there is none so near.
    fn nearest_within(&self, point: &Vector3<f64>, along: f64, slack_m: f64, bound_m: f64) -> Nearest {
        let last = self.points.len() - 1;
        let from = self.along.partition_point(|&a| a < along - slack_m).saturating_sub(1).min(last.saturating_sub(1));
        let to = self.along.partition_point(|&a| a <= along + slack_m).max(from + 1).min(last);
        let mut start =
            Nearest { off_m: f64::INFINITY, t_s: self.t_s[from], at: self.points[from], ..Nearest::default() };
        start.along_m = self.along[from];
        let mut best = (start, 0.0);
        // places are known on chords; the path is near them
        let near =
            bound_m.min((self.at(along.clamp(self.along[from], self.along[to])) - point).norm()) + self.off_chords_m;
        let mut i = from;
        while i < to {
            let (a, b) = (self.points[i], self.points[i + 1]);
            // along the path a distance changes by no more than the length: what is too far stays so for a while. Both ends go on straight
            let spare = (point - a).norm() - near.min(best.0.off_m) - self.off_chords_m - SAME_M;
            let passed = self.along[i + 1] - self.along[i];
            if spare > passed && i > 0 && i + 1 < last {
                let far = |a: &f64| *a < self.along[i] + spare;
                let skipped = self.along[i..=to].partition_point(far).saturating_sub(1).max(1);
                i = (i + skipped).min(last - 1);
                continue;
            }
            let step = b - a;
            let length2 = step.norm_squared();
            let on = if length2 > 0.0 { (point - a).dot(&step) / length2 } else { 0.0 };
            let share = on.clamp(0.0, 1.0);
            let beyond = self.step_m / length2.sqrt().max(f64::MIN_POSITIVE);
            let nearest = on.clamp(if i == 0 { -beyond } else { 0.0 }, if i + 1 == last { 1.0 + beyond } else { 1.0 });
            let bend =
                if self.smooth.is_empty() { Vector3::zeros() } else { self.bend(i) * (share * (share - 1.0) / 2.0) };
            let off = (point - a - step * nearest - bend).norm();
            // of equal distances the place nearest in length counts: a path that comes back on itself has two
            let apart = (self.along[i] + share * length2.sqrt() - along).abs();
            if off < best.0.off_m - SAME_M || (off < best.0.off_m + SAME_M && apart < best.1) {
                let near = Nearest {
                    off_m: off,
                    t_s: self.t_s[i] + share * (self.t_s[i + 1] - self.t_s[i]),
                    at: a + step * nearest + bend,
                    direction: step.try_normalize(0.0).unwrap_or_default(),
                    along_m: self.along[i] + share * length2.sqrt(),
                };
                best = (near, apart);
            }
            // while the path rests it is at one place: thousands of rows of a dwell are no nearer than the first
            let rests = |a: &f64| *a <= self.along[i] + STILL_M;
            let rested = if passed <= STILL_M { self.along[i..=to].partition_point(rests) } else { 0 };
            i += rested.saturating_sub(1).max(1);
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_path_of_very_many_points_is_thinned_and_stays_where_it_is() {
        // 2 mm out in 100,000 points, and a rest of as many
        let points: Vec<_> = (0..200_000).map(|i| Vector3::new(2e-8 * f64::from(i.min(100_000)), 0.0, 0.0)).collect();
        let t: Vec<f64> = (0..points.len()).map(|i| i as f64 * 1e-3).collect();
        let path = Reference::new(points, t);
        assert!((100..2000).contains(&path.points.len()), "{}", path.points.len());
        assert!((path.length_m() - 2e-3).abs() < 1e-12);
        for x in [0.0, 0.5e-3, 1.99e-3, 2e-3] {
            let near = path.nearest(&Vector3::new(x, 3e-6, 0.0), x, SLACK_M);
            assert!((near.off_m - 3e-6).abs() < 1e-12 && (near.along_m - x).abs() < 1e-12, "{near:?}");
        }
        // an ordinary path keeps all of its points
        assert_eq!(line().points.len(), 21);
    }

    #[test]
    fn a_smooth_path_bends_between_its_points_and_stays_straight_beside_a_corner() {
        // a quarter of a circle of 0.5 m in steps of 20 mm, then straight on across it
        let arc = (0..40).map(|k| f64::from(k) * 0.04).map(|w| Vector3::new(w.sin(), 1.0 - w.cos(), 0.0) * 0.5);
        let mut points: Vec<_> = arc.collect();
        let last = points[39];
        points.extend((1..10).map(|k| last + Vector3::z() * (0.02 * f64::from(k))));
        let t: Vec<f64> = (0..points.len()).map(|i| i as f64 * 0.1).collect();
        let smooth = (0..points.len()).map(|i| i != 39 && i != 0).collect();
        let straight = Reference::new(points, t);
        let on = Vector3::new(0.46_f64.sin(), 1.0 - 0.46_f64.cos(), 0.0) * 0.5;
        let chord = straight.nearest(&on, 0.5 * 0.46, 2e-3).off_m;
        assert!((chord - 0.5 * (1.0 - 0.02_f64.cos())).abs() < 1e-8, "{chord}");
        let bent = straight.bent(smooth);
        for w in [0.03_f64, 0.46, 1.5, 1.545] {
            let off = bent.nearest(&(Vector3::new(w.sin(), 1.0 - w.cos(), 0.0) * 0.5), 0.5 * w, 2e-3).off_m;
            assert!(off < 2e-6, "{w}: {off}");
        }
        let beside = bent.nearest(&(last + Vector3::z() * 0.011), 0.5 * 1.56 + 0.011, 2e-3).off_m;
        assert!(beside < 1e-9, "{beside}");
    }

    #[test]
    fn a_path_that_rests_in_very_many_rows_is_compared_in_no_time() {
        // out, 200 s of rest at 250 Hz, back
        let x = |k: u32| {
            f64::from(if k < 100 {
                k
            } else if k < 50_100 {
                100
            } else {
                50_200 - k
            }) * 1e-4
        };
        let points: Vec<_> = (0..=50_200).map(|k| Vector3::new(x(k), 0.0, 0.0)).collect();
        let t: Vec<f64> = (0..points.len()).map(|i| i as f64 * 4e-3).collect();
        let path = Reference::new(points.clone(), t);
        let run: Vec<_> = points.iter().map(|p| p + Vector3::new(0.0, 7e-6, 0.0)).collect();
        let along = lengths(run.iter().copied());
        let start = std::time::Instant::now();
        let far = path.follow(&run, &along, 1.0, SLACK_M).map(|near| (near.off_m - 7e-6).abs()).fold(0.0, f64::max);
        assert!(far < 1e-12, "{far}");
        // minutes if every row were compared with all of the rest
        assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
    }

    fn line() -> Reference {
        // 0 -> 10 mm and back, one second a millimetre
        let mm = |x: f64| Vector3::new(x * 1e-3, 0.0, 0.0);
        let points: Vec<_> = (0..=10).chain((0..10).rev()).map(|x| mm(f64::from(x))).collect();
        let t: Vec<f64> = (0..points.len()).map(|i| i as f64).collect();
        Reference::new(points, t)
    }

    #[test]
    fn a_path_that_comes_back_on_itself_is_followed_in_order() {
        let path = line();
        let point = Vector3::new(4.5e-3, 7e-6, 0.0);
        let [out, back] = [4.5e-3, 15.5e-3].map(|along| path.nearest(&point, along, SLACK_M));
        assert!((out.off_m - 7e-6).abs() < 1e-12 && (back.off_m - 7e-6).abs() < 1e-12);
        assert!((out.t_s - 4.5).abs() < 1e-6 && (back.t_s - 15.5).abs() < 1e-6, "{} {}", out.t_s, back.t_s);
        assert!((out.along_m - 4.5e-3).abs() < 1e-12 && (back.along_m - 15.5e-3).abs() < 1e-12);
    }

    #[test]
    fn a_point_beyond_the_end_is_as_far_as_the_end_less_a_step() {
        // the steps of this path are 1 mm
        let near = line().nearest(&Vector3::new(-2.5e-3, 0.0, 0.0), 20e-3, SLACK_M);
        assert!((near.off_m - 1.5e-3).abs() < 1e-12 && (near.t_s - 20.0).abs() < 1e-9);
    }

    #[test]
    fn a_run_that_ends_between_rows_of_the_reference_or_starts_late_has_the_error_across_the_path_alone() {
        let points: Vec<_> = (0..=10).map(|x| Vector3::new(f64::from(x) * 1e-4, 0.0, 0.0)).collect();
        let path = Reference::new(points, (0..=10).map(f64::from).collect());
        for (x, along) in [(1.085e-3, 1.085e-3), (-0.06e-3, 0.0)] {
            let off = path.nearest(&Vector3::new(x, 4e-6, 0.0), along, SLACK_M).off_m;
            assert!((off - 4e-6).abs() < 1e-12, "{x}: {off}");
        }
    }

    #[test]
    fn a_run_with_longer_and_shorter_parts_is_followed_from_point_to_point() {
        // 0 -> 100 mm and up by 50 mm; the run has a detour of 4 mm out and back on its way, and a corner cut by 4 mm later
        let (x, y) = (Vector3::x() * 1e-3, Vector3::y() * 1e-3);
        let walk = |parts: &[(Vector3<f64>, usize)]| {
            let mut points = vec![Vector3::zeros()];
            for (step, n) in parts {
                for _ in 0..*n {
                    points.push(points[points.len() - 1] + step * 0.1);
                }
            }
            points
        };
        let points = walk(&[(x, 1000), (y, 500)]);
        let times = (0..points.len()).map(|i| i as f64).collect();
        let path = Reference::new(points, times);
        let run = walk(&[(x, 500), (x, 20), (-x, 20), (x, 500), (y, 500)]);
        let along = lengths(run.iter().copied());
        let off = path.follow(&run, &along, 150.0 / 154.0, SLACK_M).map(|n| n.off_m).fold(0.0, f64::max);
        assert!(off < 1e-9, "{off}");
        // what leaves the path is still seen
        let astray = walk(&[(x, 1000), (x, 10), (-x, 10), (y, 500)]);
        let along = lengths(astray.iter().copied());
        let off = path.follow(&astray, &along, 150.0 / 152.0, SLACK_M).map(|n| n.off_m).fold(0.0, f64::max);
        assert!((off - 1e-3).abs() < 1e-9, "{off}");
    }
}
