//! Where to begin: offsets of the clocks at which both recordings show one motion.
//!
//! Method: the speed of the TCP by kinematics from the controller, and as the tracker measured it, on one grid; the normalised
//! cross-correlation by fast Fourier transform gives peaks. A motion of constant speed has none, so offsets on a grid are tried
//! too. Each is judged by the rigid fit of the two paths ([`crate::numerics::rigid`]), whatever the frame of the tracker.
//!
//! Fails: [`Found::alternatives`] names offsets far from the best that fit nearly as well: a motion that repeats. The misfit is relative to
//! the size of the path, so that a short stretch in which little moves does not win.

use crate::numerics::fourier::{Complex, Fourier};
use crate::numerics::rigid;
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Half the base of a speed, s.
const BASE_S: f64 = 0.05;
/// Points of a rigid fit.
const POINTS: usize = 240;
/// Offsets of the grid.
const TRIALS: usize = 1500;
/// Peaks of the correlation that are tried.
const PEAKS: usize = 8;
/// Part of the shorter recording that must overlap.
const OVERLAP: f64 = 0.3;
/// An alternative fits within this factor of the best.
const ALIKE: f64 = 1.2;
/// And any that misses by less than this part of the path's size: starts are found to a millisecond only.
const ALIKE_FLOOR: f64 = 1e-3;
/// Longest grid of the correlation.
const LONGEST: usize = 1 << 20;

/// What the tracker saw: times, s, and positions, m.
pub struct Seen<'a> {
    pub t_s: &'a [f64],
    pub at_m: &'a [Vector3<f64>],
}

/// Offset to add to the tracker's times, s.
#[derive(Debug, Clone)]
pub struct Found {
    pub offset_s: f64,
    /// Correlation of the speeds there.
    pub correlation: f64,
    /// Root mean square of what is left there, over the size of the path.
    pub misfit: f64,
    pub alternatives: Vec<f64>,
}

/// The best start, among all offsets or those `within`; `None` where the recordings share no motion.
pub fn start(robot: &Robot, commands: &Series, seen: &Seen, within: Option<[f64; 2]>) -> Option<Found> {
    let (first, last) = (seen.t_s.first()?, seen.t_s.last()?);
    let span = commands.span();
    let shortest = (span.end - span.start).min(last - first);
    let mut from = span.start - last + OVERLAP * shortest;
    let mut to = span.end - first - OVERLAP * shortest;
    if let Some([lo, hi]) = within {
        (from, to) = (from.max(lo), to.min(hi));
    }
    let step = ((to - from) / TRIALS as f64).max(1e-3);
    let mut tries: Vec<f64> = (0..=TRIALS).map(|i| from + step * i as f64).take_while(|o| *o <= to).collect();
    let correlated = correlation(robot, commands, seen, [from, to]);
    tries.extend(correlated.iter().map(|p| p.0));
    let mut judged: Vec<(f64, f64)> =
        tries.iter().filter_map(|o| Some((relative_misfit(robot, commands, seen, *o, shortest)?, *o))).collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    // each of the best is brought to the bottom of its valley
    let mut bottoms: Vec<(f64, f64)> = Vec::new();
    for (_, offset) in judged.iter().take(4 * PEAKS) {
        let (rms, offset) = descend(robot, commands, seen, *offset, step, shortest)?;
        if bottoms.iter().all(|b| (b.1 - offset).abs() > step) {
            bottoms.push((rms, offset));
        }
    }
    bottoms.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (misfit, offset_s) = *bottoms.first()?;
    let far = 2.0 * step.max(BASE_S);
    let alternatives =
        bottoms.iter().skip(1).filter(|b| b.0 < (ALIKE * misfit).max(ALIKE_FLOOR) && (b.1 - offset_s).abs() > far);
    let near = correlated.iter().filter(|p| (p.0 - offset_s).abs() < far).map(|p| p.1);
    let correlation = near.fold(0.0, f64::max);
    Some(Found { offset_s, correlation, misfit, alternatives: alternatives.map(|b| b.1).collect() })
}

/// Golden section between the neighbours of a trial.
fn descend(robot: &Robot, commands: &Series, seen: &Seen, at: f64, step: f64, shortest: f64) -> Option<(f64, f64)> {
    const RATIO: f64 = 0.618_033_988_749_895;
    let cost = |o: f64| relative_misfit(robot, commands, seen, o, shortest).unwrap_or(f64::INFINITY);
    let (mut lo, mut hi) = (at - step, at + step);
    while hi - lo > 1e-3 {
        let (a, b) = (hi - RATIO * (hi - lo), lo + RATIO * (hi - lo));
        if cost(a) <= cost(b) { hi = b } else { lo = a }
    }
    let offset = 0.5 * (lo + hi);
    Some((relative_misfit(robot, commands, seen, offset, shortest)?, offset))
}

/// Root mean square of the rigid fit at an offset, over the size of the path.
fn relative_misfit(robot: &Robot, commands: &Series, seen: &Seen, offset: f64, shortest: f64) -> Option<f64> {
    let span = commands.span();
    let lo = seen.t_s.partition_point(|t| t + offset < span.start);
    let hi = seen.t_s.partition_point(|t| t + offset <= span.end);
    if hi <= lo + 3 || seen.t_s[hi - 1] - seen.t_s[lo] < 0.9 * OVERLAP * shortest {
        return None;
    }
    let stride = ((hi - lo) / POINTS).max(1);
    let (mut q, mut rate) = (vec![0.0; commands.channels()], vec![0.0; commands.channels()]);
    let mut pairs = Vec::with_capacity(POINTS + 1);
    for k in (lo..hi).step_by(stride) {
        if commands.at(seen.t_s[k] + offset, &mut q, &mut rate) {
            pairs.push((robot.tcp_m(&q), seen.at_m[k], 1.0));
        }
    }
    let fit = rigid::fit(pairs.iter().copied(), false)?;
    let squares = pairs.iter().map(|(p, y, _)| (y - fit.rotation * p - fit.translation).norm_squared());
    let size = fit.spread.iter().sum::<f64>();
    (size > 0.0).then(|| (squares.sum::<f64>() / (pairs.len() as f64 * size)).sqrt())
}

/// Peaks of the normalised cross-correlation of the speeds: offset and correlation, the highest first.
fn correlation(robot: &Robot, commands: &Series, seen: &Seen, range: [f64; 2]) -> Vec<(f64, f64)> {
    let span = commands.span();
    let (first, last) = (seen.t_s[0], seen.t_s[seen.t_s.len() - 1]);
    let total = (span.end - span.start) + (last - first);
    let dt = (total / LONGEST as f64).max(0.01);
    let (mut q, mut rate) = (vec![0.0; commands.channels()], vec![0.0; commands.channels()]);
    let mut columns = vec![Vector3::zeros(); commands.channels()];
    let ours: Vec<f64> = (0..((span.end - span.start) / dt) as usize)
        .map(|i| {
            commands.at(span.start + dt * i as f64, &mut q, &mut rate);
            robot.chain().position_and_jacobian(&q, &mut columns);
            columns.iter().zip(&rate).map(|(c, r)| c * *r).sum::<Vector3<f64>>().norm()
        })
        .collect();
    let theirs: Vec<f64> = (0..((last - first) / dt) as usize)
        .map(|i| {
            let t = first + dt * i as f64;
            let (a, b) = ((t - BASE_S).max(first), (t + BASE_S).min(last));
            (point(seen, b) - point(seen, a)).norm() / (b - a).max(dt)
        })
        .collect();
    let sums = correlate(&ours, &theirs);
    let n = sums.len();
    // index k of the circular correlation: the tracker's first row meets row k of the controller
    let value = |k: i64| sums[k.rem_euclid(n as i64) as usize];
    let offset_of = |k: i64| span.start + dt * k as f64 - first;
    let (lo, hi) = (-(theirs.len() as i64) + 1, ours.len() as i64 - 1);
    let mut peaks: Vec<(f64, f64)> = (lo + 1..hi)
        .filter(|&k| value(k) > value(k - 1) && value(k) >= value(k + 1))
        .map(|k| (offset_of(k), value(k)))
        .filter(|p| (range[0]..=range[1]).contains(&p.0))
        .collect();
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    peaks.truncate(PEAKS);
    peaks
}

/// Circular correlation of two zero-mean series, over the product of their norms.
fn correlate(a: &[f64], b: &[f64]) -> Vec<f64> {
    let n = (a.len() + b.len()).next_power_of_two();
    let forward = Fourier::forward(n);
    let spectrum = |v: &[f64]| {
        let mean = v.iter().sum::<f64>() / v.len().max(1) as f64;
        let mut out = vec![Complex::new(0.0, 0.0); n];
        for (to, from) in out.iter_mut().zip(v) {
            to.re = from - mean;
        }
        let norm = out.iter().map(|c| c.re * c.re).sum::<f64>().sqrt();
        forward.apply(&mut out);
        (out, norm)
    };
    let (mut fa, na) = spectrum(a);
    let (fb, nb) = spectrum(b);
    for (x, y) in fa.iter_mut().zip(&fb) {
        *x *= y.conj();
    }
    Fourier::inverse(n).apply(&mut fa);
    let scale = (na * nb * n as f64).max(f64::MIN_POSITIVE);
    fa.iter().map(|c| c.re / scale).collect()
}

/// Position at a time, on the straight line between two readings.
fn point(seen: &Seen, t: f64) -> Vector3<f64> {
    let k = seen.t_s.partition_point(|v| *v <= t).clamp(1, seen.t_s.len() - 1);
    let (a, b) = (seen.t_s[k - 1], seen.t_s[k]);
    let x = if b > a { ((t - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
    seen.at_m[k - 1] * (1.0 - x) + seen.at_m[k] * x
}
