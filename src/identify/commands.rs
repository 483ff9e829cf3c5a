//! How well the commands of a log are known: noise of a controller that logs encoder readings, and the last digit of the file.
//!
//! The play operator takes every peak of the noise as a command, so a gap seems larger by some standard deviations, and each peak seems
//! to be a reversal. Method: the standard deviation comes from third differences (median, so that corners do not count), taken over
//! rows and over times; the smaller counts, because a motion that is smooth in either is no noise. Differences of white noise change sign
//! from one to the next three times of four, those of a motion hardly ever: with a change in fewer than half, it is a motion.
//!
//! Commands that are noisy beyond their last digit are smoothed: straight lines through the rows before and after each row, as long as
//! the noise allows (intersection of confidence intervals: Goldenshluger and Nemirovski 1997; Katkovnik 1999), so that corners stay.
//! Between reversals (a movement back of more than [`NOISY`] standard deviations) the result is made monotone by isotonic regression (Ayer
//! et al. 1955).
//!
//! What is left after that, or the rounding of the file, widens intervals. A gap of which it is more than [`MOST_OF_GAP`] is not trusted,
//! and friction of a joint with more than [`MOST_FOR_FRICTION`] is not stated. Assumes noise that is white over rows; slower noise is not
//! seen.

use crate::effects::Track;
use crate::gaps::note::commands::Note;
use crate::gaps::note::path;
use crate::gaps::{Distrust, Gaps, Note as AnyNote};
use crate::log::Log;
use crate::numerics::normal::Z95;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use crate::robot::Robot;
use std::borrow::Cow;

/// Standard deviations of a noisy command up to which a movement back is noise (as in `deadzone`): 1 row of 2 million.
const NOISY: f64 = 5.0;
/// Differences that are looked at, at most.
const SEEN: usize = 20_000;
/// Standard deviations by which the estimates of longer and shorter lines may differ. A bias of as many is possible; Katkovnik (1999)
/// finds values from 1 to 2 best, larger ones cut corners.
const MAY_DIFFER: f64 = 1.5;
/// Rows of the longest line: it leaves less than a twentieth of the noise.
const LONGEST: usize = 2000;
/// Rows of the shortest line, and growth of the next.
const SHORTEST: usize = 4;
const GROWTH: f64 = 1.4;
/// Share of a half gap that may be unknown in the commands: with an interval that reaches to half of the gap, a compensation still takes
/// out half of it.
const MOST_OF_GAP: f64 = 0.25;
/// The same where friction is to be told from the gap (`docs/identify-path.md`: to 10 %).
const MOST_FOR_FRICTION: f64 = 0.1;
/// Share of the half width of an interval below which the commands' part changes it by less than half a percent.
const NEGLIGIBLE: f64 = 0.1;
/// Decimals of a command column whose number is not known.
const DECIMALS: u8 = 6;
/// Steps from which rounding can be seen.
const FEWEST_STEPS: usize = 20;

/// What is known of one command column; rad or m.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// Axis of the robot.
    axis: usize,
    /// Standard deviation of the noise; 0: none beyond the last digit.
    noise: f64,
    /// Root mean square error of the commands that are used.
    left: f64,
}

/// Logs with the noise of their commands taken out.
pub(crate) struct Cleaned<'a> {
    /// The logs; as they were where no command is noisy.
    pub logs: Cow<'a, [Log]>,
    /// For each log, its commands that move.
    known: Vec<Vec<Known>>,
}

/// The logs with smooth commands.
pub(crate) fn cleaned<'a>(robot: &Robot, logs: &'a [Log]) -> Cleaned<'a> {
    let mut out = Cleaned { logs: Cow::Borrowed(logs), known: vec![Vec::new(); logs.len()] };
    for (k, log) in logs.iter().enumerate().filter(|(_, log)| !log.poses) {
        for (axis, command) in log.cmd.iter().enumerate() {
            let decimals = log.cmd_decimals.get(axis).copied().unwrap_or(DECIMALS);
            let digit = 10f64.powi(-i32::from(decimals)) * robot.axis(axis).kind.si_per_user_unit();
            let noise = noise(&log.t_s, command);
            let rounding = if rounded(command, digit) { digit / 12f64.sqrt() } else { 0.0 };
            if noise <= digit {
                out.known[k].push(Known { axis, noise: 0.0, left: rounding });
                continue;
            }
            let (smooth, left) = smoothed(&log.t_s, command, noise);
            if let Some(log) = out.logs.to_mut().get_mut(k) {
                log.cmd[axis] = smooth;
            }
            out.known[k].push(Known { axis, noise, left });
        }
    }
    out
}

impl Cleaned<'_> {
    /// Remarks on the commands that were smoothed.
    pub fn notes(&self, robot: &Robot) -> Vec<AnyNote> {
        let of = |(log, known): (&Log, &Vec<Known>)| {
            let noisy = known.iter().filter(|k| k.noise > 0.0);
            noisy
                .map(|k| {
                    let joint = robot.axis(k.axis);
                    let (log, name) = (log.name.clone(), joint.name.clone());
                    Note::Smoothed { log, joint: name, kind: joint.kind, noise: k.noise, left: k.left }.into()
                })
                .collect::<Vec<AnyNote>>()
        };
        self.logs.iter().zip(&self.known).flat_map(of).collect()
    }

    /// Widens intervals by what is not known of the commands; takes back what is not known because of it.
    pub fn doubt(&self, robot: &Robot, gaps: &mut Gaps) {
        let left = |axis: usize| {
            let of = self.known.iter().flatten().filter(|k| k.axis == axis);
            of.fold((0.0, 0.0), |(left, noise): (f64, f64), k| (left.max(k.left), noise.max(k.noise)))
        };
        for point in &mut gaps.points {
            point.ci95 = wider(point.half_gap, point.ci95, left(point.axis).0);
        }
        let mut distrust = None;
        for gap in &mut gaps.joints {
            let (left, noise) = left(gap.axis);
            let widened = wider(gap.half_gap, gap.ci95, left);
            if widened == gap.ci95 {
                continue;
            }
            gap.significant &= gap.half_gap.abs() > Z95 * left;
            gap.ci95 = widened;
            let joint = robot.axis(gap.axis);
            let unit = joint.kind.si_per_user_unit();
            if left <= MOST_FOR_FRICTION * gap.half_gap.abs() {
                if let Some(s) = &mut gap.stiction {
                    s.ci95 = wider(s.spike, s.ci95, left);
                }
                continue;
            }
            if gap.stiction.take().is_some() {
                gap.stiction_p_value = None;
                let name = &joint.name;
                gaps.notes
                    .retain(|n| !matches!(n, AnyNote::Path(path::Note::LagKnownBest { joint, .. }) if joint == name));
                gaps.notes.push(Note::FrictionUnknown { joint: joint.name.clone(), kind: joint.kind, left }.into());
            }
            let small = left <= MOST_OF_GAP * gap.half_gap.abs();
            if gap.significant && !small && distrust.is_none() {
                let (half_gap, left, noise) = (gap.half_gap / unit, left / unit, noise / unit);
                let (joint, unit) = (joint.name.clone(), joint.kind.unit().to_string());
                distrust = Some(Distrust::CommandsNotKnown { joint, unit, half_gap, left, noise });
            }
        }
        if let Some(why) = distrust
            && gaps.distrust.is_none()
        {
            gaps.notes.insert(0, AnyNote::Distrust(why.clone()));
            gaps.distrust = Some(why);
        }
    }
}

/// An interval with an independent error of standard deviation `left` added to either side.
fn wider(value: f64, ci95: [f64; 2], left: f64) -> [f64; 2] {
    if Z95 * left <= NEGLIGIBLE * (ci95[1] - ci95[0]) / 2.0 {
        return ci95;
    }
    let low = value - (value - ci95[0]).hypot(Z95 * left);
    [if ci95[0] < 0.0 { low } else { low.max(0.0) }, value + (ci95[1] - value).hypot(Z95 * left)]
}

/// Whether a column that moves shows that its values are rounded to `digit`. Set points of a test with dwells may be whole numbers that
/// are exact: their steps stand alone and are large.
fn rounded(p: &[f64], digit: f64) -> bool {
    let moved = |i: usize| i > 0 && i < p.len() && p[i] != p[i - 1];
    let steps = (1..p.len()).filter(|i| moved(*i));
    let (mut all, mut fine) = (0, 0);
    for i in steps {
        all += 1;
        let least = (p[i] - p[i - 1]).abs() < 1.5 * digit;
        fine += usize::from(least || moved(i - 1) || moved(i + 1));
    }
    all >= FEWEST_STEPS && 2 * fine > all
}

/// Standard deviation of the white noise of a command, rad or m; 0 where its differences are those of a motion.
fn noise(t_s: &[f64], p: &[f64]) -> f64 {
    let by_rows = scatter(p, |_| [-1.0, 3.0, -3.0, 1.0]);
    let by_times = scatter(p, |i| {
        let t = [t_s[i], t_s[i + 1], t_s[i + 2], t_s[i + 3]];
        [0, 1, 2, 3].map(|j| 1.0 / (0..4).filter(|m| *m != j).map(|m| t[j] - t[m]).product::<f64>())
    });
    by_rows.min(by_times)
}

/// The same by third differences with these weights.
fn scatter(p: &[f64], weights: impl Fn(usize) -> [f64; 4]) -> f64 {
    let difference = |i: usize| {
        let w = p.get(i..i + 4)?;
        // rows at rest would hide the scatter of those that move
        if w[0] == w[3] {
            return None;
        }
        let by = weights(i);
        let norm = by.iter().map(|b| b * b).sum::<f64>().sqrt();
        Some(by.iter().zip(w).map(|(b, v)| b * v).sum::<f64>() / norm).filter(|d| d.is_finite())
    };
    let (mut sizes, mut pairs, mut changes) = (Vec::new(), 0, 0);
    for i in (0..p.len().saturating_sub(4)).step_by((p.len() / SEEN).max(1)) {
        let Some(d) = difference(i) else { continue };
        sizes.push(d.abs());
        if let Some(next) = difference(i + 1) {
            pairs += 1;
            changes += usize::from(d * next < 0.0);
        }
    }
    if 2 * changes <= pairs { 0.0 } else { SIGMA_PER_MAD * median_of(&mut sizes).unwrap_or(0.0) }
}

/// The smoothed command, and the root mean square error that is left.
fn smoothed(t_s: &[f64], p: &[f64], noise: f64) -> (Vec<f64>, f64) {
    let mut out = Vec::with_capacity(p.len());
    let mut left2 = 0.0;
    for i in 0..p.len() {
        let sides = [line_to(t_s, p, i, true, noise), line_to(t_s, p, i, false, noise)];
        let (mut value, mut weight) = (0.0, 0.0);
        for (v, variance) in sides.into_iter().flatten() {
            value += v / variance;
            weight += 1.0 / variance;
        }
        if weight > 0.0 {
            out.push(p[i] + value / weight);
            left2 += 1.0 / weight;
        } else {
            out.push(p[i]);
            left2 += 1.0;
        }
    }
    monotone(t_s, &mut out, NOISY * noise);
    // what the rule lets pass as bias, and what is left of the noise
    (out, (1.0 + MAY_DIFFER) * noise * (left2 / p.len().max(1) as f64).sqrt())
}

/// The end, at row `i`, of a straight line through the rows before or after it, less the row's own value, and its variance in units of
/// that of a row: the longest line that agrees with all shorter ones.
fn line_to(t_s: &[f64], p: &[f64], i: usize, before: bool, noise: f64) -> Option<(f64, f64)> {
    let most = if before { i + 1 } else { p.len() - i }.min(LONGEST);
    let (mut n, mut t, mut tt, mut v, mut tv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut lo, mut hi) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut found, mut next) = (None, SHORTEST);
    for k in 0..most {
        let j = if before { i - k } else { i + k };
        let (x, y) = (t_s[j] - t_s[i], p[j] - p[i]);
        n += 1.0;
        t += x;
        tt += x * x;
        v += y;
        tv += x * y;
        if k + 1 < next {
            continue;
        }
        next = (next as f64 * GROWTH).ceil() as usize;
        let determinant = n * tt - t * t;
        if determinant <= 0.0 {
            continue;
        }
        let (value, variance) = ((tt * v - t * tv) / determinant, tt / determinant);
        let may = MAY_DIFFER * noise * variance.sqrt();
        (lo, hi) = (lo.max(value - may), hi.min(value + may));
        if lo > hi {
            break;
        }
        found = Some((value, variance));
    }
    found
}

/// Makes a command monotone between its reversals: least squares, by pooling neighbours that are out of order.
fn monotone(t_s: &[f64], p: &mut [f64], deadband: f64) {
    let track = Track::new(t_s, p, deadband);
    let Some(first) = track.dir.iter().position(|d| *d != 0) else { return };
    let mut dir = f64::from(track.dir[first]);
    let mut from = 0;
    let mut ends: Vec<(usize, f64)> = Vec::new();
    for turn in track.turns.iter() {
        ends.push((turn.index + 1, dir));
        dir = f64::from(turn.dir);
    }
    ends.push((p.len(), dir));
    for (to, dir) in ends {
        if let Some(run) = p.get_mut(from..to) {
            pool(run, dir);
        }
        from = to;
    }
}

/// Isotonic regression of one run.
fn pool(run: &mut [f64], dir: f64) {
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for &v in run.iter() {
        let mut block = (v, 1);
        while let Some(&(mean, n)) = blocks.last()
            && dir * (mean - block.0) > 0.0
        {
            blocks.pop();
            let all = n + block.1;
            block = ((mean * n as f64 + block.0 * block.1 as f64) / all as f64, all);
        }
        blocks.push(block);
    }
    let values = blocks.into_iter().flat_map(|(mean, n)| std::iter::repeat_n(mean, n));
    run.iter_mut().zip(values).for_each(|(r, v)| *r = v);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    /// A slow polygon that turns twice, rad, at 25 Hz.
    fn polygon() -> (Vec<f64>, Vec<f64>) {
        let corners = [0.0, 1e-3, 1.8e-3, 2.2e-3, 2.4e-3, 2.2e-3, 1.7e-3, 0.9e-3, 0.8e-3, 1.2e-3];
        let t: Vec<f64> = (0..9 * 125).map(|i| f64::from(i) / 25.0).collect();
        let p = (0..t.len()).map(|i| {
            let (k, s) = (i / 125, (i % 125) as f64 / 125.0);
            corners[k] + s * (corners[k + 1] - corners[k])
        });
        let p = p.collect();
        (t, p)
    }

    fn noisy(p: &[f64], sigma: f64) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let normal = Normal::new(0.0, sigma).unwrap();
        p.iter().map(|v| v + normal.sample(&mut rng)).collect()
    }

    #[test]
    fn noise_is_found_and_taken_out_of_a_polygon() {
        let (t, p) = polygon();
        let jittering = noisy(&p, 2e-5);
        let found = noise(&t, &jittering);
        assert!((found / 2e-5 - 1.0).abs() < 0.1, "{found:e}");
        let (smooth, left) = smoothed(&t, &jittering, found);
        let rms = |a: &[f64]| (a.iter().zip(&p).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / p.len() as f64).sqrt();
        assert!(rms(&smooth) < 0.5 * rms(&jittering) && rms(&smooth) < left, "{:e} of {left:e}", rms(&smooth));
        assert_eq!(Track::new(&t, &smooth, 0.0).turns.len(), 2);
    }

    #[test]
    fn a_motion_is_no_noise() {
        let (t, p) = polygon();
        assert!(noise(&t, &p) < 1e-12);
        // fast, and with times that are known but uneven
        let uneven: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.04 + 0.004 * f64::from(i * 7919 % 13)).collect();
        let fast: Vec<f64> = uneven.iter().map(|t| (3.0 * t).sin()).collect();
        assert!(noise(&uneven, &fast) < 1e-12);
        assert!(noise(&uneven, &vec![0.3; 2000]) < 1e-12);
    }

    #[test]
    fn rounding_is_told_from_set_points_that_are_whole_numbers() {
        let slow: Vec<f64> = (0..3000).map(|i| (f64::from(i) * 0.01 * 0.7).round() / 1.0).collect();
        assert!(rounded(&slow, 1.0));
        let dwells: Vec<f64> = (0..3000).map(|i| f64::from(i / 100) * 10.0).collect();
        assert!(!rounded(&dwells, 1.0));
    }
}
