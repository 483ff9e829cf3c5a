//! Faults that no effect of the catalogue describes.

use crate::physics::STEP_S;
use crate::robots::Robot;
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::f64::consts::TAU;

pub const KINDS: [&str; 11] = [
    "notch",
    "acceleration",
    "speed_squared",
    "slip",
    "product_of_two_joints",
    "random_walk",
    "growing_one_sided_play",
    "sawtooth",
    "ringing_after_reversals",
    "kink",
    "slow_speed_sag",
];

/// One such fault: a kind, a joint, a size (rad or m), shape numbers (SI), and a course where it is random.
#[derive(Clone, Debug)]
pub struct Outside {
    pub kind: String,
    pub joint: usize,
    pub other: usize,
    pub size: f64,
    pub shape: [f64; 2],
    /// Of the random walk: a value every second (times `size`).
    pub walk: Vec<Vector3<f64>>,
}

impl Outside {
    /// A fault of a kind at unit size, with shape numbers that suit the path.
    pub fn draw(kind: &str, joints: &[Vec<f64>], moving: &[usize], rng: &mut ChaCha8Rng) -> Outside {
        let joint = moving[rng.random_range(0..moving.len())];
        let others: Vec<usize> = moving.iter().copied().filter(|j| *j != joint).collect();
        let other = if others.is_empty() { joint } else { others[rng.random_range(0..others.len())] };
        let q = &joints[joint];
        let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |s, v| (s.0.min(*v), s.1.max(*v)));
        let range = high - low;
        let end_s = q.len() as f64 * STEP_S;
        let shape = match kind {
            "notch" => [low + range * rng.random_range(0.2..0.8), range * rng.random_range(0.02..0.06)],
            "slip" => [end_s * rng.random_range(0.25..0.75), 0.0],
            "product_of_two_joints" => [mean(q), mean(&joints[other])],
            "growing_one_sided_play" => [rng.random_range(0.05..0.2), 0.0],
            "sawtooth" => [TAU * rng.random_range(5.0..25.0) / range, rng.random_range(0.0..1.0)],
            "ringing_after_reversals" => [rng.random_range(1.2..3.0), rng.random_range(0.6..1.5)],
            "kink" => [low + range * rng.random_range(0.35..0.65), 0.0],
            "slow_speed_sag" => [range * rng.random_range(0.01..0.03), 0.0],
            _ => [0.0; 2],
        };
        let mut at = Vector3::zeros();
        let walk = (0..(end_s as usize + 3))
            .map(|_| {
                at += Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal)) * 0.1;
                at
            })
            .collect();
        Outside { kind: kind.into(), joint, other, size: 1e-5, shape, walk }
    }

    /// Adds what it does to the joint.
    pub fn gear(&self, command: &[Vec<f64>], joints: &mut [Cow<[f64]>]) {
        let p = &command[self.joint];
        let n = p.len();
        let dp = |k: usize| if k == 0 { 0.0 } else { p[k] - p[k - 1] };
        let [s0, s1] = self.shape;
        let mut add = vec![0.0; n];
        match self.kind.as_str() {
            "notch" => (0..n).for_each(|k| add[k] = -self.size * (-0.5 * ((p[k] - s0) / s1).powi(2)).exp()),
            "acceleration" => {
                // Over 20 ms, as a drive feels it.
                (10..n - 10).for_each(|k| {
                    add[k] = self.size * (p[k + 10] - 2.0 * p[k] + p[k - 10]) / (100.0 * STEP_S * STEP_S)
                });
            }
            "speed_squared" => (0..n).for_each(|k| add[k] = self.size * (dp(k) / STEP_S).powi(2)),
            "slip" => (0..n).filter(|k| *k as f64 * STEP_S > s0).for_each(|k| add[k] = self.size),
            "product_of_two_joints" => {
                (0..n).for_each(|k| add[k] = self.size * (p[k] - s0) * (command[self.other][k] - s1));
            }
            "growing_one_sided_play" => {
                let (mut out, mut b, mut dir) = (p[0], self.size, 0.0);
                for (k, a) in add.iter_mut().enumerate() {
                    if dp(k).abs() > 1e-10 {
                        if dir * dp(k) < 0.0 {
                            b += self.size * s0;
                        }
                        dir = dp(k).signum();
                    }
                    out = f64::clamp(out, p[k] - b, p[k]);
                    *a = out - p[k];
                }
            }
            "sawtooth" => (0..n).for_each(|k| add[k] = self.size * ((p[k] * s0 / TAU + s1).rem_euclid(1.0) - 0.5)),
            "ringing_after_reversals" => {
                let (mut since, mut dir) = (None, 0.0);
                for (k, a) in add.iter_mut().enumerate() {
                    if dp(k).abs() > 1e-10 {
                        if dir * dp(k) < 0.0 {
                            since = Some(k);
                        }
                        dir = dp(k).signum();
                    }
                    if let Some(k0) = since {
                        let t = (k - k0) as f64 * STEP_S;
                        *a = dir * self.size * (-t / s1).exp() * (TAU * s0 * t).sin();
                    }
                }
            }
            "kink" => (0..n).for_each(|k| add[k] = self.size * (p[k] - s0).abs()),
            "slow_speed_sag" => (0..n).for_each(|k| add[k] = self.size * (-(dp(k) / STEP_S / s0).abs()).exp()),
            _ => return,
        }
        for (q, a) in joints[self.joint].to_mut().iter_mut().zip(add) {
            *q += a;
        }
    }

    /// What it does to the TCP in the base (m).
    pub fn tcp(&self, t_s: f64) -> Vector3<f64> {
        if self.kind != "random_walk" {
            return Vector3::zeros();
        }
        let k = (t_s as usize).min(self.walk.len() - 2);
        (self.walk[k] + (self.walk[k + 1] - self.walk[k]) * (t_s - k as f64)) * self.size
    }

    pub fn json(&self, robot: &Robot) -> Value {
        json!({"kind": self.kind, "joint": robot.joints[self.joint].name, "other_joint": robot.joints[self.other].name,
               "size_si": self.size, "shape_si": self.shape})
    }
}

fn mean(q: &[f64]) -> f64 {
    q.iter().sum::<f64>() / q.len() as f64
}
