//! The library of motions: one function per motion, each from rest at the pose to rest at the pose.
//!
//! What a motion is good for follows from how effects differ: gaps and friction need reversals, slow ones with many rows
//! inside the transition; lag and clock need speed; gear and geometry need travel; drift needs one pose again and again;
//! compliance needs two loads. A motion that does not fit into the time or the joints' windows is left out.
//!
//! Parts:
//! - [`several`]: motions of several joints at once.

mod several;

use super::path::{Envelope, Path};
use crate::robot::{InverseOptions, Stop, Target};
use nalgebra::Vector3;
use several::three_best;
pub use several::{all_joints, back_to_one_pose, poses, stand_still, wrist};
use std::f64::consts::TAU;

/// One motion as a program runs it.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Name by which it is listed.
    pub name: String,
    /// What it does, in one line.
    pub does: String,
    /// `rows[row][axis]`, one [`Envelope::step_s`] apart, rad or m.
    pub rows: Vec<Vec<f64>>,
    /// Run twice: without and with the payload.
    pub two_payloads: bool,
}

/// What the library collects: motions that fit.
#[derive(Default)]
struct Library(Vec<Motion>);

impl Library {
    fn add(&mut self, name: impl Into<String>, does: &str, rows: Option<Vec<Vec<f64>>>) {
        self.add_for(false, name, does, rows);
    }

    fn add_for(&mut self, two_payloads: bool, name: impl Into<String>, does: &str, rows: Option<Vec<Vec<f64>>>) {
        if let Some(rows) = rows {
            self.0.push(Motion { name: name.into(), does: does.into(), rows, two_payloads });
        }
    }
}

/// All motions for a question about `axes`; `payload`: two loads can be compared.
pub fn library(envelope: &Envelope, axes: &[usize], payload: bool) -> Vec<Motion> {
    let mut list = Library::default();
    for &a in axes {
        of_one_joint(&mut list, envelope, a);
    }
    of_all_joints(&mut list, envelope);
    if payload {
        of_two_payloads(&mut list, &envelope.of_duration(0.5 * envelope.duration_s), axes);
    }
    list.0
}

fn of_one_joint(list: &mut Library, envelope: &Envelope, a: usize) {
    const SOFT: &str = "reverses so slowly that many rows are inside the transition";
    const FINE: &str = "stairs of growing steps after each reversal, with dwells";
    const TWO: &str = "sweeps in both directions at the working speed and at a quarter of it";
    let joint = &envelope.robot.axis(a).name;
    let named = |name: &str| format!("{name} {joint}");
    list.add(named("sweep"), "sweeps both ways at the working speed", sweep(envelope, a));
    list.add(named("two speeds"), TWO, two_speeds(envelope, a));
    list.add(named("speed ladder"), "reverses at one place at four speeds", speed_ladder(envelope, a));
    list.add(named("soft reversals"), SOFT, soft_reversals(envelope, a));
    list.add(named("stairs"), "stairs up and down with dwells", stairs(envelope, a));
    list.add(named("fine stairs"), FINE, fine_stairs(envelope, a));
    list.add(named("reversals along the range"), "reverses at seven positions", zigzag(envelope, a));
    list.add(named("reverse and wait"), "reverses fast and slowly, then stands still", reverse_and_wait(envelope, a));
}

fn of_all_joints(list: &mut Library, envelope: &Envelope) {
    let all: Vec<usize> = (0..envelope.robot.dof()).collect();
    list.add("one joint at a time", "each joint alone, both ways, at two speeds", one_at_a_time(envelope, &all));
    list.add("stairs of all joints", "each joint alone by stairs with dwells, up and down", stairs_of(envelope, &all));
    for (plane, [u, v]) in [("XY", [0, 1]), ("YZ", [1, 2]), ("XZ", [0, 2])] {
        let does = "a circle of the TCP in both directions, at the working speed and at half of it";
        list.add(format!("circle {plane}"), does, circle(envelope, u, v));
    }
    list.add("all joints", "all joints at once through their ranges, in both directions", all_joints(envelope));
    list.add("poses", "poses over the whole range with dwells", poses(envelope));
    list.add("wrist", "the last three joints over wide angles while the arm stands still", wrist(envelope));
    let back = "returns to one pose repeatedly and waits there";
    list.add("back to one pose", back, back_to_one_pose(envelope));
    list.add("stand still", "stands still after one short move", stand_still(envelope));
}

/// Motions that run twice, each of half the duration.
fn of_two_payloads(list: &mut Library, half: &Envelope, axes: &[usize]) {
    list.add_for(true, "poses, two payloads", "the poses without and with the payload", poses(half));
    let does = "all joints at once, without and with the payload";
    list.add_for(true, "all joints, two payloads", does, all_joints(half));
    for &a in axes {
        let name = format!("sweep {}, two payloads", half.robot.axis(a).name);
        list.add_for(true, name, "sweeps in both directions, without and with the payload", sweep(half, a));
    }
}

/// Ends of a sweep about the pose that takes about `time_s` both ways.
fn stretch(envelope: &Envelope, axis: usize, pace: f64, time_s: f64) -> [f64; 2] {
    let way = (0.45 * pace * envelope.fast[axis] * time_s).min(envelope.span(axis));
    let [least, most] = envelope.window[axis];
    let lo = (envelope.pose[axis] - 0.5 * way).max(least).min(most - way);
    [lo, lo + way]
}

/// Sweeps of one axis both ways at the working speed.
pub fn sweep(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    let [lo, hi] = stretch(envelope, axis, 1.0, 0.9 * envelope.duration_s);
    Path::new(envelope).repeat(|p| {
        p.axis_to(axis, hi, 1.0);
        p.axis_to(axis, lo, 1.0);
        p.home();
    })
}

/// Sweeps of one axis both ways at two speeds, by turns.
pub fn two_speeds(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    both_ways(envelope, axis, stretch(envelope, axis, 0.25, 0.6 * envelope.duration_s), &[1.0, 0.25])
}

/// Reversals of one axis over a short way at four speeds.
pub fn speed_ladder(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    both_ways(envelope, axis, stretch(envelope, axis, 0.125, 0.2 * envelope.duration_s), &[1.0, 0.5, 0.25, 0.125])
}

/// One axis up, down and back to the pose at each pace in turn, again and again.
fn both_ways(envelope: &Envelope, axis: usize, [lo, hi]: [f64; 2], paces: &[f64]) -> Option<Vec<Vec<f64>>> {
    Path::new(envelope).repeat(|p| {
        for &pace in paces {
            [hi, lo, envelope.pose[axis]].into_iter().for_each(|to| p.axis_to(axis, to, pace));
        }
    })
}

/// Reversals as wide parabolas: half a transition takes a second, the turn itself much longer.
pub fn soft_reversals(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    const TURN_S: f64 = 6.0;
    let [least, most] = envelope.window[axis];
    let way = (6.0 * envelope.transition[axis]).min(0.9 * (most - least));
    // a triangle of speed: speed-up over half the way in half the time
    let accel = 4.0 * way / (TURN_S * TURN_S);
    let middle = envelope.pose[axis].clamp(least + 0.5 * way, most - 0.5 * way);
    Path::new(envelope).repeat(|p| {
        for to in [middle + 0.5 * way, middle - 0.5 * way, envelope.pose[axis]] {
            let mut q = p.at();
            q[axis] = to;
            p.go_softly(&q, 1.0, accel);
        }
    })
}

const DWELL_S: f64 = 0.8;

fn steps(p: &mut Path, axis: usize, to: f64, count: usize, dwell_s: f64) {
    let from = p.at()[axis];
    for k in 1..=count {
        p.axis_to(axis, from + (to - from) * k as f64 / count as f64, 1.0);
        p.stand(dwell_s);
    }
}

/// Stairs over the window, up and down.
pub fn stairs(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    [10, 6, 4].into_iter().find_map(|count| {
        let [lo, hi] = stretch(envelope, axis, 1.0, 0.4 * envelope.duration_s);
        Path::new(envelope).repeat(|p| {
            steps(p, axis, hi, count / 2, DWELL_S);
            steps(p, axis, lo, count, DWELL_S);
            steps(p, axis, envelope.pose[axis], count / 2, DWELL_S);
        })
    })
}

/// After each reversal stairs that begin far inside the transition and double.
pub fn fine_stairs(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    const STEPS: i32 = 8;
    let [least, most] = envelope.window[axis];
    let first = 0.06 * envelope.transition[axis];
    let way = first * (2f64.powi(STEPS) - 1.0);
    let (first, way) = if way > most - least { (first * (most - least) / way, most - least) } else { (first, way) };
    let middle = envelope.pose[axis].clamp(least + 0.5 * way, most - 0.5 * way);
    Path::new(envelope).repeat(|p| {
        p.axis_to(axis, middle - 0.5 * way, 1.0);
        for dir in [1.0, -1.0] {
            p.stand(DWELL_S);
            let from = p.at()[axis];
            for k in 1..=STEPS {
                p.axis_to(axis, from + dir * first * (2f64.powi(k) - 1.0), 1.0);
                p.stand(DWELL_S);
            }
        }
        p.home();
    })
}

/// Reversals at seven positions over the window: three steps on, one back.
pub fn zigzag(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    const PLACES: usize = 7;
    let [lo, hi] = stretch(envelope, axis, 1.0, 0.45 * envelope.duration_s);
    let step = (hi - lo) / PLACES as f64;
    Path::new(envelope).repeat(|p| {
        p.axis_to(axis, lo, 1.0);
        for k in 1..=PLACES {
            p.axis_to(axis, lo + step * k as f64, 1.0);
            p.axis_to(axis, lo + step * (k as f64 - 0.5), 1.0);
        }
        p.axis_to(axis, hi, 1.0);
        p.home();
    })
}

/// A fast and a slow reversal, each with a short way and a long wait after it.
pub fn reverse_and_wait(envelope: &Envelope, axis: usize) -> Option<Vec<Vec<f64>>> {
    let wait_s = (0.1 * envelope.duration_s).clamp(2.0, 10.0);
    let [lo, hi] = stretch(envelope, axis, 0.25, 0.15 * envelope.duration_s);
    let on = (2.0 * envelope.transition[axis]).min(0.5 * (hi - lo));
    Path::new(envelope).repeat(|p| {
        for pace in [1.0, 0.25] {
            p.axis_to(axis, hi, pace);
            p.axis_to(axis, hi - on, pace);
            p.stand(wait_s);
            p.axis_to(axis, lo, pace);
            p.axis_to(axis, lo + on, pace);
            p.stand(wait_s);
        }
        p.home();
    })
}

/// Each of the axes alone, both ways, at two speeds.
pub fn one_at_a_time(envelope: &Envelope, axes: &[usize]) -> Option<Vec<Vec<f64>>> {
    let each_s = envelope.duration_s / axes.len() as f64;
    Path::new(envelope).repeat(|p| {
        for &axis in axes {
            for (pace, time_s) in [(1.0, 0.35 * each_s), (0.3, 0.35 * each_s)] {
                let [lo, hi] = stretch(envelope, axis, pace, time_s);
                p.axis_to(axis, hi, pace);
                p.axis_to(axis, lo, pace);
                p.axis_to(axis, envelope.pose[axis], pace);
            }
        }
    })
}

/// Each of the axes alone by stairs.
pub fn stairs_of(envelope: &Envelope, axes: &[usize]) -> Option<Vec<Vec<f64>>> {
    let each_s = envelope.duration_s / axes.len() as f64;
    [0.6, 0.4, 0.25].into_iter().find_map(|dwell_s| {
        Path::new(envelope).repeat(|p| {
            for &axis in axes {
                let [lo, hi] = stretch(envelope, axis, 1.0, 0.3 * each_s);
                for (to, count) in [(hi, 2), (lo, 4), (envelope.pose[axis], 2)] {
                    steps(p, axis, to, count, dwell_s);
                }
            }
        })
    })
}

/// A circle of the TCP through the pose in a plane of the base frame (`u`, `v`: its axes), both ways at two speeds, moved by
/// the three joints that move the TCP best.
pub fn circle(envelope: &Envelope, u: usize, v: usize) -> Option<Vec<Vec<f64>>> {
    let free = three_best(envelope)?;
    let start = envelope.robot.tcp_m(&envelope.pose);
    let reach = start.norm().max(0.05);
    let (u, v) = (Vector3::ith(u, 1.0), Vector3::ith(v, 1.0));
    [0.15, -0.15, 0.08, -0.08, 0.04, -0.04, 0.02, -0.02].into_iter().find_map(|share| {
        let radius = share * reach;
        let point = |phi: f64| start + u * (radius * (1.0 - phi.cos())) + v * (radius.abs() * phi.sin());
        let mut rows = Vec::new();
        for pace in [1.0, 0.5] {
            let there = turn(envelope, TAU * radius.abs() / (pace * envelope.speed_m_s), &free, &point)?;
            rows.push(there.clone());
            rows.push(there.iter().rev().skip(1).cloned().chain([envelope.pose.clone()]).collect());
        }
        Path::new(envelope).repeat(|p| rows.iter().for_each(|r| p.follow(r.iter().cloned())))
    })
}

/// Joint vectors once round, from rest to rest; `None` where the inverse does not reach.
fn turn(
    envelope: &Envelope,
    time_s: f64,
    free: &[usize],
    point: &dyn Fn(f64) -> Vector3<f64>,
) -> Option<Vec<Vec<f64>>> {
    if time_s > envelope.duration_s {
        return None;
    }
    let options = InverseOptions { free: free.to_vec(), within_limits: true, ..InverseOptions::default() };
    let up_s = (0.2 * time_s).clamp(0.2, 2.0);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let n = ((time_s + up_s) / envelope.step_s).ceil() as usize;
    let mut q = envelope.pose.clone();
    for i in 1..=n {
        let phi = TAU * warp(i as f64 / n as f64, up_s / (time_s + up_s));
        let found = envelope.robot.inverse(&Target::Position(point(phi)), &q, &options);
        if found.error_m > 1e-8 || found.stop == Stop::NotFinite {
            return None;
        }
        q = found.q;
        if q.iter().zip(&envelope.window).any(|(x, [lo, hi])| x < lo || x > hi) {
            return None;
        }
        rows.push(q.clone());
    }
    // the last digit of the inverse is not that of the pose
    let last = rows.last_mut()?;
    if last.iter().zip(&envelope.pose).any(|(x, y)| (x - y).abs() > 1e-6) {
        return None;
    }
    last.copy_from_slice(&envelope.pose);
    Some(rows)
}

/// 0 to 1 with a speed-up and a slow-down that take the part `up` each.
fn warp(x: f64, up: f64) -> f64 {
    let top = 1.0 / (1.0 - up);
    if x < up {
        0.5 * top * x * x / up
    } else if x > 1.0 - up {
        1.0 - 0.5 * top * (1.0 - x) * (1.0 - x) / up
    } else {
        top * (x - 0.5 * up)
    }
}
