//! Paths: what the joints are commanded over time, on the fine grid, starting at rest and within the limits.
//!
//! `fourier` runs a periodic sum of harmonics at several speeds, with a pause at times; `circle` and `raster` move the TCP
//! with three joints (numerical inverse); `stairs` and `sweeps` move one joint at a time; `mixed` is a fourier path and
//! then a circle.

use crate::kinematics::{forward, reach};
use crate::physics::STEP_S;
use crate::robots::Robot;
use nalgebra::Vector3;
use rand::Rng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

pub const KINDS: [&str; 6] = ["fourier", "circle", "stairs", "sweeps", "raster", "mixed"];

/// Joint by joint (rad or m), `steps` of the fine grid; drawn again until the limits hold.
pub fn draw(kind: &str, robot: &Robot, steps: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let home: Vec<f64> = robot.joints.iter().map(|j| j.home).collect();
    let mut gentle = 1.0;
    loop {
        let q = match kind {
            "fourier" => Some(fourier(robot, &home, steps, gentle, rng)),
            "circle" => circle(robot, &home, steps, gentle, rng),
            "raster" => raster(robot, &home, steps, gentle, rng),
            "stairs" => Some(one_by_one(robot, &home, steps, gentle, true, rng)),
            "sweeps" => Some(one_by_one(robot, &home, steps, gentle, false, rng)),
            _ => mixed(robot, &home, steps, gentle, rng),
        };
        if let Some(q) = q.filter(|q| within_limits(robot, q)) {
            return q;
        }
        gentle *= 0.9;
    }
}

/// Joints that move at all.
pub fn moving(joints: &[Vec<f64>]) -> Vec<usize> {
    (0..joints.len()).filter(|&j| joints[j].iter().any(|p| (p - joints[j][0]).abs() > 1e-4)).collect()
}

fn within_limits(robot: &Robot, joints: &[Vec<f64>]) -> bool {
    robot.joints.iter().zip(joints).all(|(j, q)| {
        let inside = q.iter().all(|p| *p >= j.limits[0] && *p <= j.limits[1]);
        let slow = q.windows(2).all(|w| (w[1] - w[0]).abs() / STEP_S < 0.9 * j.max_speed);
        // Over 20 ms, as the ramps of a controller are.
        let soft = (10..q.len().saturating_sub(10))
            .step_by(5)
            .all(|k| (q[k + 10] - 2.0 * q[k] + q[k - 10]).abs() / (20.0 * STEP_S * 5.0 * STEP_S) < 0.9 * j.max_accel);
        inside && slow && soft
    })
}

/// Phase that runs through `(duration, rate)` segments from rest, with cosine ramps between the rates; stops at the end.
fn phase(segments: &[(f64, f64)], steps: usize, ramp_s: f64) -> Vec<f64> {
    let (mut out, mut at, mut k0, mut before) = (Vec::with_capacity(steps), 0.0, 0usize, 0.0);
    for &(duration, rate) in segments.iter().chain(&[(1e9, 0.0)]) {
        let n = ((duration / STEP_S) as usize).min(steps - k0);
        for k in 0..n {
            let u = (k as f64 * STEP_S / ramp_s).min(1.0);
            let r = before + (rate - before) * 0.5 * (1.0 - (PI * u).cos());
            out.push(at);
            at += r * STEP_S;
        }
        k0 += n;
        before = rate;
        if k0 >= steps {
            break;
        }
    }
    out
}

/// Speeds of a path over its time: two to four segments, a pause among them in a third of the draws.
fn schedule(total_s: f64, base: f64, rng: &mut ChaCha8Rng) -> Vec<(f64, f64)> {
    let n = rng.random_range(2..5);
    let weights: Vec<f64> = (0..n).map(|_| rng.random_range(0.6..1.4)).collect();
    let sum: f64 = weights.iter().sum();
    let mut segments: Vec<(f64, f64)> =
        weights.iter().map(|w| (w / sum * total_s, base * rng.random_range(0.5..2.4))).collect();
    if rng.random_bool(0.33) {
        let pause = rng.random_range(0.12..0.2) * total_s;
        segments.iter_mut().for_each(|s| s.0 *= 1.0 - pause / total_s);
        segments.insert(1, (pause, 0.0));
    }
    segments
}

/// The periodic course of each joint: harmonics one to five, scaled to a swing about the home position.
struct Harmonics {
    terms: Vec<Vec<(f64, f64)>>,
    middle: Vec<f64>,
    scale: Vec<f64>,
    home: Vec<f64>,
}

impl Harmonics {
    fn draw(robot: &Robot, home: &[f64], gentle: f64, rng: &mut ChaCha8Rng) -> Harmonics {
        let mut h = Harmonics { terms: vec![], middle: vec![], scale: vec![], home: home.to_vec() };
        for joint in &robot.joints {
            let terms: Vec<(f64, f64)> =
                (1..=5).map(|k| (rng.random_range(0.2..1.0) / f64::from(k), rng.random_range(0.0..TAU))).collect();
            let course: Vec<f64> = (0..400).map(|k| sum(&terms, k as f64 / 400.0)).collect();
            let (low, high) = course.iter().fold((f64::MAX, f64::MIN), |s, v| (s.0.min(*v), s.1.max(*v)));
            h.middle.push(0.5 * (low + high));
            h.scale.push(joint.swing * gentle * rng.random_range(0.85..1.12) / (high - low));
            h.terms.push(terms);
        }
        h
    }

    fn at(&self, j: usize, s: f64) -> f64 {
        self.home[j] + self.scale[j] * (sum(&self.terms[j], s) - self.middle[j])
    }
}

fn sum(terms: &[(f64, f64)], s: f64) -> f64 {
    terms.iter().zip(1..).map(|((a, p), k)| a * (TAU * f64::from(k) * s + p).sin()).sum()
}

fn fourier(robot: &Robot, home: &[f64], steps: usize, gentle: f64, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let h = Harmonics::draw(robot, home, gentle, rng);
    let base = gentle / rng.random_range(26.0..60.0);
    let s = phase(&schedule(steps as f64 * STEP_S, base, rng), steps, 1.0);
    (0..robot.joints.len()).map(|j| s.iter().map(|s| h.at(j, *s)).collect()).collect()
}

/// Two directions across each other, at random.
fn plane(rng: &mut ChaCha8Rng) -> (Vector3<f64>, Vector3<f64>) {
    let n = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize();
    let u = n.cross(&Vector3::new(0.31, 0.77, 0.55)).normalize();
    (u, n.cross(&u))
}

/// Joint course that takes the TCP along `target`, from `start`.
fn follow(robot: &Robot, start: &[f64], target: impl Iterator<Item = Vector3<f64>>) -> Option<Vec<Vec<f64>>> {
    let tool = robot.tool();
    let mut q = start.to_vec();
    let mut out: Vec<Vec<f64>> = vec![Vec::new(); q.len()];
    let mut before = None;
    for p in target {
        // A TCP at rest leaves the joints exactly at rest.
        if before != Some(p) && !reach(robot, &tool, &mut q, &p) {
            return None;
        }
        before = Some(p);
        out.iter_mut().zip(&q).for_each(|(c, v)| c.push(*v));
    }
    Some(out)
}

fn circle(robot: &Robot, start: &[f64], steps: usize, gentle: f64, rng: &mut ChaCha8Rng) -> Option<Vec<Vec<f64>>> {
    let radius = rng.random_range(0.1..0.24) * gentle;
    let (u, v) = plane(rng);
    let p0 = forward(robot, &robot.tool(), start);
    let centre = p0 - u * radius;
    let (mut segments, mut used, mut sign) = (Vec::new(), 0.0, 1.0);
    while used < steps as f64 * STEP_S {
        let rate = gentle * rng.random_range(0.025..0.08) / radius;
        let laps = if rng.random_bool(0.4) { 2.0 } else { 1.0 };
        segments.push((TAU * laps / rate, sign * rate));
        used += TAU * laps / rate;
        if rng.random_bool(0.5) {
            sign = -sign;
        }
        if rng.random_bool(0.2) {
            segments.push((2.0, 0.0));
            used += 2.0;
        }
    }
    let a = phase(&segments, steps, 1.5);
    follow(robot, start, a.into_iter().map(|a| centre + u * radius * a.cos() + v * radius * a.sin()))
}

/// Share of a move done at the time share `x`, with ramps of share `r` at both ends (speed is a smooth trapezium).
fn trapezium(x: f64, r: f64) -> f64 {
    let r = r.min(0.5);
    let ramp = |x: f64| 0.5 * x - r / TAU * (PI * x / r).sin();
    let top = 1.0 / (1.0 - r);
    match () {
        () if x < r => top * ramp(x),
        () if x > 1.0 - r => 1.0 - top * ramp(1.0 - x),
        () => top * (0.5 * r + (x - r)),
    }
}

/// Courses through a list of `(place, seconds to get there, seconds to stay)`, from the first place.
fn script<const N: usize>(places: &[([f64; N], f64, f64)], steps: usize) -> Vec<[f64; N]> {
    let mut out = Vec::with_capacity(steps);
    let mut at = places[0].0;
    for &(to, move_s, stay_s) in places {
        let n = (move_s / STEP_S) as usize;
        for k in 0..n {
            let x = trapezium(k as f64 / n as f64, 0.4 / move_s);
            out.push(std::array::from_fn(|i| if to[i] == at[i] { at[i] } else { at[i] + (to[i] - at[i]) * x }));
        }
        out.extend(std::iter::repeat_n(to, (stay_s / STEP_S) as usize));
        at = to;
        if out.len() >= steps {
            break;
        }
    }
    out.resize(steps, at);
    out
}

fn raster(robot: &Robot, start: &[f64], steps: usize, gentle: f64, rng: &mut ChaCha8Rng) -> Option<Vec<Vec<f64>>> {
    let (u, v) = plane(rng);
    let (length, over, lines) =
        (rng.random_range(0.15..0.34) * gentle, rng.random_range(0.02..0.045) * gentle, rng.random_range(4..9));
    let mut places = vec![([0.0, 0.0], 0.0, 0.5)];
    let mut used = 0.0;
    let (mut x, mut y, mut down) = (0.0, 0.0, false);
    while used < steps as f64 * STEP_S {
        let speed = gentle * rng.random_range(0.02..0.06);
        for line in 0..lines {
            x = if x == 0.0 { length } else { 0.0 };
            places.push(([x, y], (length / speed).max(1.0), 0.2));
            if line + 1 < lines {
                y += if down { -over } else { over };
                places.push(([x, y], (over / speed).max(1.0), 0.2));
            }
            used += (length + over) / speed;
        }
        down = !down;
    }
    let p0 = forward(robot, &robot.tool(), start);
    follow(robot, start, script(&places, steps).into_iter().map(|c| p0 + u * c[0] + v * c[1]))
}

/// One joint after the other: up and down in steps with dwells, or in sweeps.
fn one_by_one(
    robot: &Robot,
    home: &[f64],
    steps: usize,
    gentle: f64,
    stairs: bool,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<f64>> {
    let total_s = steps as f64 * STEP_S;
    let n = robot.joints.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.shuffle(rng);
    order.truncate(n.min(if total_s > 180.0 { rng.random_range(4..6) } else { 4 }));
    let share_s = total_s / order.len() as f64;
    let mut out: Vec<Vec<f64>> = home.iter().map(|h| vec![*h; steps]).collect();
    let mut k0 = 0;
    for &j in &order {
        let (swing, middle) = (robot.joints[j].swing * gentle, home[j]);
        let mut places = vec![([middle], 0.0, 0.5)];
        let (mut at, mut used, mut up) = (middle, 0.5, rng.random_bool(0.5));
        while used < share_s {
            let speed = swing * rng.random_range(0.06..0.22);
            let reach = 0.5 * swing * rng.random_range(0.4..1.0);
            for _ in 0..2 {
                let to = if up { middle + reach } else { middle - reach };
                let treads = if stairs { rng.random_range(3..7) } else { 1 };
                let (from, rise) = (at, (to - at) / f64::from(treads));
                for t in 1..=treads {
                    at = from + rise * f64::from(t);
                    let move_s = (rise.abs() / speed).max(0.8);
                    let stay_s = if stairs { 0.6 } else { 0.1 };
                    places.push(([at], move_s, stay_s));
                    used += move_s + stay_s;
                }
                up = !up;
            }
        }
        let n = ((share_s / STEP_S) as usize).min(steps - k0);
        let course = script(&places, n);
        let end = course.last().map_or(middle, |c| c[0]);
        for (k, value) in out[j].iter_mut().enumerate().skip(k0) {
            *value = course.get(k - k0).map_or(end, |c| c[0]);
        }
        k0 += n;
    }
    // A joint that is cut in the middle of a move would stop dead: the last half second of each share runs out smoothly.
    for q in &mut out {
        soften(q);
    }
    out
}

/// Replaces a dead stop by a stop over 0.3 s: the course is averaged over that time where it would leap in speed.
fn soften(q: &mut [f64]) {
    let half = 75;
    let jump = |q: &[f64], k: usize| (q[k + 1] - 2.0 * q[k] + q[k - 1]).abs() / (STEP_S * STEP_S);
    let scale = q.iter().fold(0.0f64, |m, v| m.max((v - q[0]).abs()));
    let stops: Vec<usize> = (1..q.len() - 1).filter(|&k| jump(q, k) > 200.0 * scale.max(1e-9)).collect();
    for k in stops {
        let (a, b) = (k.saturating_sub(2 * half), (k + 2 * half).min(q.len() - 1));
        // A cubic with the slopes of both ends.
        let (n, va, vb) = ((b - a) as f64, q[a + 1] - q[a], q[b] - q[b - 1]);
        let (ya, yb) = (q[a], q[b]);
        for (i, value) in q[a..=b].iter_mut().enumerate() {
            let u = i as f64 / n;
            let (u2, u3) = (u * u, u * u * u);
            *value = ya * (2. * u3 - 3. * u2 + 1.)
                + va * n * (u3 - 2. * u2 + u)
                + yb * (3. * u2 - 2. * u3)
                + vb * n * (u3 - u2);
        }
    }
}

fn mixed(robot: &Robot, home: &[f64], steps: usize, gentle: f64, rng: &mut ChaCha8Rng) -> Option<Vec<Vec<f64>>> {
    let first = (steps as f64 * rng.random_range(0.5..0.7)) as usize;
    let h = Harmonics::draw(robot, home, gentle, rng);
    let base = gentle / rng.random_range(26.0..60.0);
    let free_s = first as f64 * STEP_S - 2.0;
    let s = phase(&schedule(free_s, base, rng), first, 1.0);
    let mut out: Vec<Vec<f64>> = (0..robot.joints.len()).map(|j| s.iter().map(|s| h.at(j, *s)).collect()).collect();
    let start: Vec<f64> = out.iter().map(|c: &Vec<f64>| c[first - 1]).collect();
    let rest = circle(robot, &start, steps - first, gentle, rng)?;
    out.iter_mut().zip(rest).for_each(|(c, r)| c.extend(r));
    Some(out)
}
