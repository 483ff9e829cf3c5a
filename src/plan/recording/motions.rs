//! The programs: dwells from both sides, slow and fast motion of all joints.

use super::note::Note;
use super::options::{Kind, Options};
use crate::error::{Error, Result};
use crate::plan::path::{Envelope, Path};
use std::f64::consts::TAU;

/// A place is passed by this before it is reached from the other side: rad, m. Far more than a gap and its wind-up.
const PASS: [f64; 2] = [0.035, 8e-3];
/// Turns of the sines over the whole time, joint by joint: none a multiple of another that moves with it.
const CYCLES: [f64; 8] = [4.0, 5.0, 7.0, 9.0, 11.0, 13.0, 17.0, 19.0];
/// Further sines of an excitation, times the first: pace and size.
const FURTHER: [[f64; 2]; 2] = [[2.3, 0.45], [5.1, 0.2]];
/// Share of the time in which a motion speeds up, and slows down.
const UP: f64 = 0.05;
/// Places of the pauses of an excitation, as shares of its time, and their half width.
const PAUSES: [f64; 2] = [0.35, 0.7];
const PAUSE: f64 = 0.02;
/// Difference to a straight line that a row may have to be left out, rad or m.
const STRAIGHT: f64 = 1e-10;

/// Times and joint vectors.
pub type Rows = Vec<(f64, Vec<f64>)>;

/// A static test as it is planned.
#[derive(Debug, Clone)]
pub struct StaticTest {
    pub rows: Rows,
    /// Tested places of each axis, rad or m; empty: the axis is not tested.
    pub places: Vec<Vec<f64>>,
}

/// Bidirectional dwells of one joint after another.
pub fn static_test(envelope: &Envelope, options: &Options, notes: &mut Vec<Note>) -> Result<StaticTest> {
    let mut path = Path::new(envelope);
    let mut places = vec![Vec::new(); envelope.pose.len()];
    for (axis, joint) in envelope.robot.axis_joints().enumerate() {
        let full = joint.kind.pick(PASS);
        let pass = full.min(0.2 * envelope.span(axis));
        if envelope.span(axis) <= 1e-4 * full {
            notes.push(Note::NoSpace { joint: joint.name.clone() });
            continue;
        }
        let [lo, hi] = [envelope.window[axis][0] + pass, envelope.window[axis][1] - pass];
        let n = options.places.max(1);
        for k in 0..n {
            let share = if n == 1 { 0.5 } else { k as f64 / (n - 1) as f64 };
            let at = crate::plan::path::rounded(joint.kind, lo + share * (hi - lo));
            places[axis].push(at);
            for _ in 0..options.cycles.max(1) {
                path.axis_to(axis, at - pass, 1.0);
                path.axis_to(axis, at, 1.0);
                path.stand(options.dwell_s);
                path.axis_to(axis, at + pass, 1.0);
                path.axis_to(axis, at, 1.0);
                path.stand(options.dwell_s);
            }
        }
        path.home();
    }
    Ok(StaticTest { rows: timed(path, "places")?, places })
}

/// All joints at once, each through its window: one sine each (path), three with pauses (excitation).
pub fn all_joints(envelope: &Envelope, kind: Kind) -> Result<Rows> {
    let mut path = Path::new(envelope);
    let middle: Vec<f64> = envelope.window.iter().map(|[lo, hi]| 0.5 * (lo + hi)).collect();
    path.go(&middle, 1.0);
    let time_s = envelope.duration_s - 2.0 * path.length_s() - 1.0;
    let n = (time_s / envelope.step_s).floor();
    if n < 100.0 {
        let expected = "a longer time, so that all joints can move there and back";
        return Err(Error::setting("duration_s", format!("{} s", envelope.duration_s), expected));
    }
    let n = n as usize;
    let sines: Vec<[f64; 2]> = match kind {
        Kind::Excitation => std::iter::once([1.0, 1.0]).chain(FURTHER).collect(),
        _ => vec![[1.0, 1.0]],
    };
    let paces = paces(n, kind);
    let total: f64 = paces.iter().sum();
    let wave = |axis: usize, s: f64| -> f64 {
        let cycles = CYCLES[axis % CYCLES.len()];
        // sines that begin and end at nothing, shifted from joint to joint so that not all turn at once
        let start = 0.37 * axis as f64;
        sines.iter().map(|[pace, size]| size * ((TAU * pace * cycles * s + start).sin() - start.sin())).sum()
    };
    let mut shapes: Vec<Vec<f64>> = vec![Vec::with_capacity(n); middle.len()];
    let mut along = 0.0;
    for pace in &paces {
        along += pace / total;
        for (axis, shape) in shapes.iter_mut().enumerate() {
            // in and out softly, so that the sines start and end at the middle
            shape.push(wave(axis, along) * soft(along.min(1.0 - along) / UP));
        }
    }
    let amplitudes: Vec<f64> = (0..middle.len()).map(|axis| amplitude(envelope, axis, &shapes[axis])).collect();
    path.follow((0..n).map(|i| (0..middle.len()).map(|a| middle[a] + amplitudes[a] * shapes[a][i]).collect()));
    path.home();
    timed(path, "duration_s")
}

/// Pace of the motion over its steps: it speeds up, slows down, and stands still in the pauses.
fn paces(n: usize, kind: Kind) -> Vec<f64> {
    (0..n)
        .map(|i| {
            let s = i as f64 / n as f64;
            let mut pace = soft(s.min(1.0 - s) / UP);
            if kind == Kind::Excitation {
                for at in PAUSES {
                    pace *= soft((s - at).abs() / PAUSE - 1.0);
                }
            }
            pace
        })
        .collect()
}

/// From 0 to 1 and level at both: a kink would be an acceleration without bounds, which leaves no travel.
fn soft(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Largest amplitude that keeps the window, the working speed and the acceleration.
fn amplitude(envelope: &Envelope, axis: usize, shape: &[f64]) -> f64 {
    let h = envelope.step_s;
    let most = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let reach = most(&mut shape.iter().copied());
    let speed = most(&mut shape.windows(2).map(|w| (w[1] - w[0]) / h));
    let accel = most(&mut shape.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]) / (h * h)));
    let limits = [
        (0.49 * envelope.span(axis), reach),
        (0.95 * envelope.fast[axis], speed),
        (0.95 * envelope.accel[axis], accel),
    ];
    limits.iter().filter(|(_, value)| *value > 0.0).map(|(limit, value)| limit / value).fold(f64::INFINITY, f64::min)
}

/// Rows with their times; refused where a limit is not kept.
fn timed(path: Path, setting: &'static str) -> Result<Rows> {
    let step_s = path.envelope.step_s;
    let rows = path.finish().ok_or_else(|| {
        Error::setting(
            setting,
            "a motion that exceeds the ranges or limits of the joints",
            "another pose, a smaller travel, or a longer time",
        )
        .mended_by(&["travel_deg", "travel_mm"])
    })?;
    Ok(rows.into_iter().enumerate().map(|(i, q)| (i as f64 * step_s, q)).collect())
}

/// Leaves out rows that lie on the straight line between their neighbours: dwells and steady motion need two rows.
pub fn without_straight_rows(rows: Rows) -> Rows {
    let mut out: Rows = Vec::new();
    let mut pending: Option<(f64, Vec<f64>)> = None;
    for row in rows {
        if let Some(middle) = pending.take() {
            let straight = out.last().is_some_and(|first| {
                let share = (middle.0 - first.0) / (row.0 - first.0);
                (0..row.1.len()).all(|a| (first.1[a] + share * (row.1[a] - first.1[a]) - middle.1[a]).abs() < STRAIGHT)
            });
            if !straight {
                out.push(middle);
            }
        }
        if out.is_empty() {
            out.push(row);
        } else {
            pending = Some(row);
        }
    }
    out.extend(pending);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_ramp_have_no_kink() {
        let speed = |x: f64| (soft(x + 1e-6) - soft(x - 1e-6)) / 2e-6;
        assert!(speed(0.0) < 1e-5 && speed(1.0) < 1e-5 && (speed(0.5) - 1.5).abs() < 1e-6);
    }

    #[test]
    fn a_dwell_keeps_its_two_ends_and_a_curve_all_its_rows() {
        let q = |t: f64| vec![if t < 2.0 { 1.0 } else { 1.0 + (t - 2.0).powi(2) }];
        let rows: Rows = (0..40).map(|i| f64::from(i) * 0.1).map(|t| (t, q(t))).collect();
        let out = without_straight_rows(rows.clone());
        assert_eq!(out.first(), rows.first());
        assert_eq!(out.last(), rows.last());
        assert_eq!(out.len(), 21, "19 rows of the dwell are left out");
    }
}
