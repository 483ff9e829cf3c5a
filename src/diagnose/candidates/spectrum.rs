//! Frequencies of ripple (over the angle of a joint) and of vibration (over time), from the residual's spectra.
//!
//! Method: the scalar product of the residual with a sine of any frequency is a Fourier sum over the joint's angle (shared
//! out linearly to a fine grid of angles) or over time, so an FFT gives it at all frequencies; divided by the norm that the
//! sine has after whitening, it is the gain in 2 ln L (the periodogram of Lomb and Scargle, for coloured noise).
//! The norm is approximated by the noise spectrum at the local frequency and made exact at the peaks by the screening.

use crate::diagnose::candidates::basis::MOST_SPLINES;
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::{Candidate, steps};
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::diagnose::problem::recording::Recording;
use crate::effects::{
    BearingWobble, EffectInstance, Inputs, Site, Target, TransmissionError, bearing_wobble, transmission_error,
};
use crate::numerics::fourier::{Complex, Fourier};
use crate::numerics::parallel::ParMap;
use crate::robot::JointKind;
use std::f64::consts::TAU;

/// Most cycles per revolution: a motor turn of a gear of 250 with eight poles, and more.
const MOST_CYCLES: f64 = 2000.0;
/// Points per width of a peak.
const OVERSAMPLING: f64 = 3.0;
/// Peaks kept per joint, and of the vibration.
const PEAKS: usize = 3;

/// Cycles of a ripple over the travel at least: a slower one is any curve.
const LEAST_CYCLES: f64 = 2.0;

/// Does the spacing of the samples, and the travel, tell this ripple from other curves and other ripples? At least two cycles
/// over the travel; of poses at most half a cycle from one to the next. Other effects always count as distinguished.
pub fn identifiable(problem: &Problem, placed: &EffectInstance) -> bool {
    let ripple = placed.effect.get::<TransmissionError>().map(|r| r.cycles_per_rev);
    let wave = ripple.or_else(|| placed.effect.get::<BearingWobble>().map(|w| w.cycles_per_rev));
    let (Some(axis), Some(cycles)) = (placed.axis(), wave) else { return true };
    let turn = placed.site(&problem.robot).rev();
    cycles_made(problem, axis, cycles) >= LEAST_CYCLES && cycles <= most_told(problem, axis, turn)
}

/// Cycles that a wave of so many cycles per revolution makes over the travel of its joint.
fn cycles_made(problem: &Problem, axis: usize, cycles_per_rev: f64) -> f64 {
    let turn = Site { robot: &problem.robot, target: Target::Joint(axis) }.rev();
    cycles_per_rev * problem.logs.iter().map(|l| l.log.travel(axis)).fold(0.0, f64::max) / turn
}

/// Speeds, in fades, up to which a fading ripple shows.
const SHOWS: f64 = 2.0;

/// Is a ripple that fades with speed seen as a wave: does its joint go through at least a cycle while it is slow enough? Else what
/// is named is an error just after reversals. Other effects always count as seen.
pub fn is_seen(problem: &Problem, placed: &EffectInstance) -> bool {
    let (Some(axis), Some(ripple)) = (placed.axis(), placed.effect.get::<TransmissionError>()) else { return true };
    let Some(fade) = ripple.fade else { return true };
    let period = placed.site(&problem.robot).rev() / ripple.cycles_per_rev;
    problem.motions().any(|l| {
        let (p, speed) = (l.trajectory.command(axis), Inputs::speed(&l.trajectory, axis));
        let mut stretch: Option<[f64; 2]> = None;
        p.iter().zip(speed).any(|(p, v)| {
            let slow = v.abs() <= SHOWS * fade;
            stretch = slow.then(|| stretch.map_or([*p, *p], |[lo, hi]| [lo.min(*p), hi.max(*p)]));
            stretch.is_some_and(|[lo, hi]| hi - lo >= period)
        })
    })
}

/// Most cycles per revolution that the poses of an axis tell from fewer; without a bound where a motion is sampled.
fn most_told(problem: &Problem, axis: usize, turn: f64) -> f64 {
    if !problem.is_settled() {
        return f64::INFINITY;
    }
    let (cycles, travel) = problem.told_waves(axis);
    if travel > 0.0 { cycles * turn / travel } else { 0.0 }
}

/// Number of independent frequencies looked at, for the chance of the best of them.
pub fn tried(context: &ScreeningContext) -> f64 {
    let joints: f64 = (0..context.problem.robot.dof())
        .filter_map(|a| grid(context, a))
        .map(|g| (g.to - g.from) as f64 / g.fine)
        .sum();
    let time: f64 = context.problem.motions().map(|l| l.trajectory.rows() as f64 / 2.0).sum();
    joints + time + steps::tried(context.problem)
}

/// Frequencies of one joint, rad per rad (or per m) of travel: multiples `from..to` of `step`.
struct Grid {
    from: usize,
    to: usize,
    step: f64,
    /// rad per rad or per m of one cycle per revolution.
    unit: f64,
    /// Grid of angles: first one, distance, and length of the transform.
    lo: f64,
    width: f64,
    size: usize,
    /// Points per width of a peak.
    fine: f64,
}

/// Cells of the grid of angles per period of the highest frequency.
const CELLS: f64 = 8.0;

fn grid(context: &ScreeningContext, axis: usize) -> Option<Grid> {
    let joint = context.problem.robot.axis(axis);
    let unit = match joint.kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => TAU / joint.lead_m_per_rev?,
    };
    let (mut lo, mut hi, mut samples) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for l in &context.problem.logs {
        for &v in l.trajectory.command(axis) {
            lo = lo.min(v);
            hi = hi.max(v);
        }
        samples += l.trajectory.rows() / l.block;
    }
    let cycles = (hi - lo) * unit / TAU;
    if cycles.is_nan() || cycles < 2e-3 {
        return None;
    }
    let strict = context.problem.is_settled();
    let turn = TAU / unit;
    let most = MOST_CYCLES.min(0.4 * samples as f64 / cycles).max(1.5);
    let most = if strict { most.min(most_told(context.problem, axis, turn)) } else { most };
    let width = TAU / (CELLS * most * unit);
    let cells = ((hi - lo) / width).ceil() as usize + 2;
    // one cycle per revolution must stand on the grid, also where the joint turns by less
    let size = ((OVERSAMPLING * cells as f64).max(CELLS * most)).ceil() as usize;
    let size = size.next_power_of_two();
    let step = TAU / (size as f64 * width);
    // along a motion an eccentric gear shows its one cycle per turn; else a slow wave is any curve
    let least = if strict { LEAST_CYCLES / cycles } else { 1.0 };
    if least > most {
        return None;
    }
    let from = (least * unit / step).ceil() as usize;
    let to = ((most * unit / step) as usize).max(from) + 1;
    (to <= size / 2).then_some(Grid { from, to, step, unit, lo, width, size, fine: size as f64 / cells as f64 })
}

/// Candidates at the peaks of each joint's spectrum.
pub fn ripples(context: &ScreeningContext, back: &[f64]) -> Vec<Candidate> {
    (0..context.problem.robot.dof())
        .par_map(|axis| {
            let Some(g) = grid(context, axis) else { return Vec::new() };
            let at = |power: &[f64]| -> Vec<f64> {
                let places = peaks(power, g.fine.ceil() as usize).into_iter();
                places.map(|k| g.step * (g.from as f64 + k) / g.unit).collect()
            };
            let all = spectrum(context, back, axis, &g, None, Lever::Turn);
            let robot = &context.problem.robot;
            let ripple = |cycles| transmission_error::ripple(robot, axis, cycles);
            let mut found: Vec<Candidate> = at(&all).into_iter().map(ripple).collect();
            if own_phases(context.problem) {
                // without a common phase the powers add up, not the sums
                let mut sum = vec![0.0; all.len()];
                for log in 0..context.problem.logs.len() {
                    let power = spectrum(context, back, axis, &g, Some(log), Lever::Turn);
                    sum.iter_mut().zip(power).for_each(|(s, p)| *s += p);
                }
                let slow = (least_wave(context.problem, axis) / g.step).ceil() as usize;
                sum.iter_mut().take(slow.saturating_sub(g.from)).for_each(|p| *p = 0.0);
                let told = at(&sum).into_iter();
                let logs = context.problem.logs.len();
                found.extend(told.map(|cycles| transmission_error::ripple_by_log(robot, axis, cycles, logs)));
            }
            found
        })
        .into_iter()
        .flatten()
        .collect()
}

/// May the angles of each log count from its own start? Those of joint sensors do, where the recorder sets them to zero.
fn own_phases(problem: &Problem) -> bool {
    problem.logs.len() > 1 && problem.recording() == Recording::JointSensors
}

/// Slowest ripple with its own phase in each log, rad per rad or per m. The splines over the travel can follow any slower one
/// ([`MOST_SPLINES`], two a cycle), so that it cannot be distinguished from another function of the position.
fn least_wave(problem: &Problem, axis: usize) -> f64 {
    let travels = problem.logs.iter().map(|l| l.log.travel(axis)).filter(|t| *t > 0.0);
    0.5 * MOST_SPLINES as f64 * TAU / travels.fold(f64::INFINITY, f64::min)
}

/// Wobbles that are tried in one round, at most: each has four sensitivities.
const WOBBLES: usize = 2;
/// Gain in 2 ln L that a wobble must promise: more than the price of its parameters.
const PROMISED: f64 = 40.0;

/// Wobbles at the highest peaks of all joints, of at least two cycles over the travel: a slower one is any bow, of which the
/// catalogue tries a few.
pub fn wobbles(context: &ScreeningContext, back: &[f64]) -> Vec<Candidate> {
    let problem = context.problem;
    if !problem.groups.iter().any(|g| matches!(g.sensor, Sensor::Reflector(_))) {
        return Vec::new();
    }
    let highest = |axis: usize| -> Vec<(f64, usize, f64)> {
        let Some(g) = grid(context, axis) else { return Vec::new() };
        let mut power = spectrum(context, back, axis, &g, None, Lever::Tilt(0));
        let other = spectrum(context, back, axis, &g, None, Lever::Tilt(1));
        power.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        let cycles = |k: f64| g.step * (g.from as f64 + k) / g.unit;
        let slow =
            (0..power.len()).take_while(|&k| cycles_made(problem, axis, cycles(k as f64)) < LEAST_CYCLES).count();
        power[..slow].fill(0.0);
        let places = peaks(&power, g.fine.ceil() as usize).into_iter().take(1);
        places.map(|k| (power[k.round() as usize], axis, cycles(k))).filter(|p| p.0 > PROMISED).collect()
    };
    let mut all: Vec<(f64, usize, f64)> = (0..problem.robot.dof()).par_map(highest).into_iter().flatten().collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    all.into_iter()
        .take(WOBBLES)
        .map(|(_, axis, cycles)| bearing_wobble::wobble(&problem.robot, axis, cycles))
        .collect()
}

/// What a wave over the position of a joint does to a point.
#[derive(Clone, Copy)]
enum Lever {
    /// It turns about the axis of the joint.
    Turn,
    /// It tilts the axis about its x (0) or y (1).
    Tilt(usize),
}

/// Gain in 2 ln L of a sine over a joint's position, at each frequency of the grid; of one log where `only` names it.
fn spectrum(
    context: &ScreeningContext,
    back: &[f64],
    axis: usize,
    grid: &Grid,
    only: Option<usize>,
    kind: Lever,
) -> Vec<f64> {
    let mut sums = vec![Complex::new(0.0, 0.0); grid.size];
    let mut norms = vec![0.0; grid.to - grid.from];
    for g in context.problem.groups.iter().filter(|g| only.is_none_or(|l| g.log == l)) {
        let n = g.len();
        let log = &context.problem.logs[g.log];
        let p = log.trajectory.command(axis);
        let noise = &context.whitening.noise[g_index(context, g)];
        let values = &back[g.range()];
        // weight and squared lever of each block
        let lever: Vec<(f64, f64)> = match g.sensor {
            Sensor::Reflector(_) | Sensor::Orientation => {
                let jacobian = &context.state.logs[g.log].jacobian;
                let tilts =
                    if let Lever::Tilt(_) = kind { Some(context.problem.tilts(context.state, g.log)) } else { None };
                (0..n)
                    .map(|b| {
                        let row = g.middle(b);
                        let along = |k: usize| match (&tilts, kind) {
                            (Some(tilts), Lever::Tilt(about)) => tilts[k][axis][row][about],
                            _ => jacobian[k][axis][row],
                        };
                        let v = context.problem.lever(g, &along, row);
                        (v.x * values[b] + v.y * values[n + b] + v.z * values[2 * n + b], v.norm_squared())
                    })
                    .collect()
            }
            Sensor::Reading if matches!(kind, Lever::Turn) => {
                let Some(reading) = &log.reading else { continue };
                let j = &context.state.logs[g.log].jacobian[0][axis];
                let seen = |b: usize| reading.seen(g.middle(b), &j[g.middle(b)]);
                (0..n).map(|b| (seen(b) * values[b], seen(b).powi(2))).collect()
            }
            Sensor::Joint(a) if a == axis && matches!(kind, Lever::Turn) => (0..n).map(|b| (values[b], 1.0)).collect(),
            _ => continue,
        };
        let per_variance = 0.5 / (noise.sigma * noise.sigma);
        let bins = lever_by_speed(g, p, &lever);
        for (b, &(w, _)) in lever.iter().enumerate() {
            let at = (p[g.middle(b)] - grid.lo) / grid.width;
            let cell = at.floor();
            sums[cell as usize].re += w * (1.0 - (at - cell));
            sums[cell as usize + 1].re += w * (at - cell);
        }
        for (k, norm) in norms.iter_mut().enumerate() {
            let frequency = grid.step * (grid.from + k) as f64;
            *norm += per_variance * bins.iter().map(|(v, l)| l / noise.spectrum((frequency * v).min(2.5))).sum::<f64>();
        }
    }
    Fourier::forward(grid.size).apply(&mut sums);
    sums[grid.from..grid.to].iter().zip(&norms).map(|(s, n)| if *n > 0.0 { s.norm_sqr() / n } else { 0.0 }).collect()
}

fn g_index(context: &ScreeningContext, g: &Group) -> usize {
    context.problem.groups.iter().position(|x| x.offset == g.offset && x.sensor == g.sensor).unwrap_or(0)
}

/// Sums of the squared lever over 24 classes of speed (rad or m per sample).
fn lever_by_speed(g: &Group, p: &[f64], lever: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const CLASSES: usize = 24;
    let speed = |b: usize| if b == 0 { 0.0 } else { (p[g.middle(b)] - p[g.middle(b - 1)]).abs() };
    let fastest = (0..g.len()).map(speed).fold(0.0, f64::max).max(1e-300);
    let mut bins = vec![(0.0, 0.0); CLASSES];
    for (b, &(_, l)) in lever.iter().enumerate() {
        let class = ((speed(b) / fastest * CLASSES as f64) as usize).min(CLASSES - 1);
        bins[class].1 += l;
    }
    for (k, bin) in bins.iter_mut().enumerate() {
        bin.0 = fastest * (k as f64 + 0.5) / CLASSES as f64;
    }
    bins
}

/// Highest local maxima, refined by a parabola, as places on the grid.
pub(super) fn peaks(power: &[f64], apart: usize) -> Vec<f64> {
    let mut order: Vec<usize> = (0..power.len())
        .filter(|&k| {
            power[k] > 0.0 && (k == 0 || power[k - 1] <= power[k]) && (k + 1 == power.len() || power[k + 1] < power[k])
        })
        .collect();
    order.sort_by(|&a, &b| power[b].total_cmp(&power[a]).then(a.cmp(&b)));
    let mut kept: Vec<usize> = Vec::new();
    for k in order {
        if kept.len() < PEAKS && kept.iter().all(|&o| o.abs_diff(k) > apart) {
            kept.push(k);
        }
    }
    kept.iter()
        .map(|&k| {
            if k == 0 || k + 1 >= power.len() {
                return k as f64;
            }
            let (a, b, c) = (power[k - 1], power[k], power[k + 1]);
            let bend = a - 2.0 * b + c;
            k as f64 + if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 }
        })
        .collect()
}

/// Frequencies (Hz) at the peaks of the time spectrum of the reflectors.
pub fn vibrations(context: &ScreeningContext, back: &[f64]) -> Vec<f64> {
    let problem = context.problem;
    // the longest log shows the finest lines
    let Some(g) = problem
        .groups
        .iter()
        .filter(|g| g.sensor.point() == Some(0) && !problem.logs[g.log].log.poses && g.len() > 16)
        .max_by(|a, b| a.len().cmp(&b.len()).then(b.log.cmp(&a.log)))
    else {
        return Vec::new();
    };
    let t = problem.logs[g.log].trajectory.t_s();
    let rows = problem.logs[g.log].trajectory.rows();
    let step_s = (t[rows - 1] - t[0]) / (rows - 1) as f64 * problem.logs[g.log].block as f64;
    let n = g.len();
    let slots = ((t[g.middle(n - 1)] - t[0]) / step_s).round() as usize + 1;
    let size = (2 * slots).next_power_of_two();
    let noise = &context.whitening.noise[g_index(context, g)];
    let values = &back[g.range()];
    let mut power = vec![0.0; size / 2];
    let fourier = Fourier::forward(size);
    for c in 0..g.dims {
        let mut buffer = vec![Complex::new(0.0, 0.0); size];
        for b in 0..n {
            let slot = ((t[g.middle(b)] - t[0]) / step_s).round() as usize;
            buffer[slot.min(size - 1)].re += values[c * n + b];
        }
        fourier.apply(&mut buffer);
        for (p, v) in power.iter_mut().zip(&buffer) {
            *p += v.norm_sqr();
        }
    }
    let per_variance = 0.5 * n as f64 / (noise.sigma * noise.sigma);
    for (k, p) in power.iter_mut().enumerate() {
        *p /= per_variance / noise.spectrum(TAU * k as f64 / size as f64);
    }
    // slower than three periods in the log is drift
    let slowest = (3 * size).div_ceil(slots);
    power[..slowest.min(size / 2)].fill(0.0);
    let hz = 1.0 / (size as f64 * step_s);
    peaks(&power, size / slots).into_iter().map(|k| k * hz).collect()
}
