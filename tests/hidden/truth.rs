//! Draws effects of the catalogue and gives them their size in minimal detectable biases of the log.

use crate::effects::Effect;
use crate::kinematics::{Pose, frames, gravity_load};
use crate::noise::{MDB, Metric};
use crate::outside::Outside;
use crate::physics::{Grid, Machine, STEP_S};
use crate::robots::Robot;
use nalgebra::{DMatrix, DVector, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// All effects that can be named.
pub const NAMES: [&str; 16] = [
    "servo_lag",
    "stiction",
    "encoder_scale",
    "transmission_error",
    "backlash",
    "backlash_position",
    "backlash_speed",
    "hysteresis",
    "joint_zero_offset",
    "axis_coupling",
    "gravity_compliance",
    "link_error",
    "tool_error",
    "thermal_drift",
    "vibration",
    "time_offset",
];

/// Effects of the catalogue that the mixed set does not draw: they are asked for by their own kind.
pub const FURTHER: [&str; 11] = [
    "bearing_wobble",
    "tracker_scale",
    "tracker_frame",
    "base_tilt",
    "coupled_play",
    "loaded_play",
    "thermal_growth",
    "torque_windup",
    "torque_hysteresis",
    "process_force",
    "tracker_refraction",
];

/// One log of one machine, as far as sizes and alternatives need it.
pub struct Setting<'a> {
    pub robot: &'a Robot,
    pub registration: Pose,
    pub grid: &'a Grid,
    pub rows: &'a [usize],
    pub metric: &'a Metric,
    pub known: &'a [Effect],
    pub moving: &'a [usize],
    pub rate_hz: f64,
}

impl Setting<'_> {
    /// TCP of the machine with these effects and faults beside the known ones (m).
    pub fn run(&self, effects: &[Effect], outside: &[Outside]) -> Vec<Vector3<f64>> {
        let effects = self.known.iter().chain(effects).cloned().collect();
        Machine { robot: self.robot, registration: self.registration, effects, outside: outside.to_vec() }
            .run(self.grid, self.rows)
    }

    /// What effects add to the log, whitened and off the frame.
    pub fn sensitivity(&self, clean: &[Vector3<f64>], effects: &[Effect], outside: &[Outside]) -> DVector<f64> {
        let with = self.run(effects, outside);
        let course: Vec<_> = with.iter().zip(clean).map(|(a, b)| a - b).collect();
        self.metric.whiten(&course)
    }

    /// Scales a draw until it is `multiple` minimal detectable biases large; none where that would be no physical size.
    pub fn sized(&self, clean: &[Vector3<f64>], draw: &Effect, multiple: f64) -> Option<Effect> {
        let (mut factor, goal) = (1.0, multiple * MDB);
        for _ in 0..12 {
            let now = self.sensitivity(clean, &[draw.scaled(factor)], &[]).norm();
            if (now / goal - 1.0).abs() < 2e-3 {
                let e = draw.scaled(factor).printed();
                return physical(&e).then_some(e);
            }
            factor *= (goal / now.max(1e-12)).clamp(1e-3, 1e3);
            if !physical(&draw.scaled(factor * 0.5)) {
                return None;
            }
        }
        None
    }

    /// Size of each effect beside all others, in minimal detectable biases.
    pub fn conditional(&self, clean: &[Vector3<f64>], effects: &[Effect]) -> Vec<f64> {
        let all: Vec<DVector<f64>> =
            effects.iter().map(|e| self.sensitivity(clean, std::slice::from_ref(e), &[])).collect();
        (0..all.len())
            .map(|k| {
                let others: Vec<_> = (0..all.len()).filter(|i| *i != k).map(|i| all[i].clone()).collect();
                left_after(&all[k], &others).norm() / MDB
            })
            .collect()
    }

    /// One effect of this name with a target and shape that suit the log, of a common size.
    pub fn draw(&self, name: &str, rng: &mut ChaCha8Rng) -> Effect {
        let r = self.robot;
        let any = self.moving[rng.random_range(0..self.moving.len())];
        let joint = &r.joints[any];
        let (x, length) = (joint.suffix(), if joint.revolute { 1.0 } else { 15.0 });
        let key = |stem: &str| format!("{stem}_{x}");
        let q = &self.grid.joints[any];
        let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |s, v| (s.0.min(*v), s.1.max(*v)));
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let direction = |rng: &mut ChaCha8Rng| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize();
        let on = |values: &[(&str, f64)]| Effect::new(name, &joint.name, values);
        match name {
            "servo_lag" => on(&[("lag_s", 0.004)]),
            "stiction" => on(&[(&key("spike"), 0.002 * length), ("decay_s", rng.random_range(0.25..3.0))]),
            "encoder_scale" => on(&[("scale_ppm", sign * 40.0)]),
            "transmission_error" => {
                let cycles = if joint.revolute {
                    if rng.random_bool(0.2) { rng.random_range(1..4) } else { rng.random_range(30..161) }
                } else {
                    rng.random_range(1..3)
                };
                let phase = rng.random_range(-180.0..180.0);
                on(&[(&key("amplitude"), 0.0005 * length), ("cycles_per_rev", f64::from(cycles)), ("phase_deg", phase)])
            }
            "backlash" => on(&[(&key("half_gap"), 0.0005 * length)]),
            "backlash_position" => {
                let mut e = on(&[]);
                let n = rng.random_range(3..6);
                e.knots = (0..n)
                    .map(|k| {
                        let p = low + (high - low) * (0.04 + 0.92 * f64::from(k) / f64::from(n - 1));
                        [p / joint.unit(), 0.0005 * length * rng.random_range(0.15..1.85)]
                    })
                    .collect();
                e
            }
            "backlash_speed" => {
                let slope = if joint.revolute { "slope_deg_per_mm_s" } else { "slope_mm_per_mm_s" };
                let typical = rng.random_range(0.6..2.0) / 120.0;
                on(&[(&key("half_gap"), 0.0003 * length), (slope, 0.0003 * length * typical)])
            }
            "hysteresis" => {
                let far = (high - low) / joint.unit() * rng.random_range(0.02..0.1);
                on(&[(&key("half_width"), 0.0006 * length), (&key("presliding"), far)])
            }
            "joint_zero_offset" => {
                let j = &r.joints[rng.random_range(0..r.joints.len())];
                let size = if j.revolute { 0.003 } else { 0.05 };
                Effect::new(name, &j.name, &[(&format!("offset_{}", j.suffix()), sign * size)])
            }
            "axis_coupling" => {
                let same: Vec<_> =
                    (0..r.joints.len()).filter(|&i| i != any && r.joints[i].revolute == joint.revolute).collect();
                let to = if same.is_empty() { any } else { same[rng.random_range(0..same.len())] };
                Effect::new(name, &format!("{}<-{}", r.joints[to].name, joint.name), &[("ratio", sign * 4e-5)])
            }
            "gravity_compliance" => {
                let j = rng.random_range(0..r.joints.len());
                let stem = if r.joints[j].revolute { "compliance_deg_per_nm" } else { "compliance_mm_per_n" };
                // A hundredth of a degree (millimetre) under the load at home.
                let home: Vec<f64> = r.joints.iter().map(|j| j.home).collect();
                let load = gravity_load(r, &frames(r, &r.tool(), &home), j).abs().max(0.5);
                Effect::new(name, &r.joints[j].name, &[(stem, 0.01 / load)])
            }
            "link_error" => {
                let j = rng.random_range(0..r.joints.len());
                let parameter = ["a", "d", "alpha"][rng.random_range(0..3)];
                let (k, v) = if parameter == "alpha" { ("delta_deg", 0.005) } else { ("delta_mm", 0.06) };
                Effect::new(name, &format!("{}.{parameter}", r.joints[j].name), &[(k, sign * v)])
            }
            "tool_error" => {
                let d = direction(rng) * 0.06;
                Effect::new(name, "tool", &[("x_mm", d.x), ("y_mm", d.y), ("z_mm", d.z)])
            }
            "thermal_drift" => {
                let d = direction(rng) * 0.02;
                let end_s = self.rows.last().map_or(0.0, |k| *k as f64 * STEP_S);
                let tau = end_s * rng.random_range(0.15..0.8);
                Effect::new(name, "tcp", &[("x_mm", d.x), ("y_mm", d.y), ("z_mm", d.z), ("tau_s", tau)])
            }
            "vibration" => {
                let f = self.rate_hz * rng.random_range(0.04..0.42);
                let phase = rng.random_range(-180.0..180.0);
                let mut e =
                    Effect::new(name, "tcp", &[("amplitude_um", 4.0), ("frequency_hz", f), ("phase_deg", phase)]);
                e.direction = Some(direction(rng).into());
                e
            }
            "time_offset" => Effect::new("time_offset", "log", &[("offset_s", sign * 0.003)]),
            _ => self.draw_further(name, any, rng),
        }
        .printed()
    }
}

impl Setting<'_> {
    /// One of the further effects, on the joint `any` or where it acts.
    fn draw_further(&self, name: &str, any: usize, rng: &mut ChaCha8Rng) -> Effect {
        let r = self.robot;
        let (joint, q) = (&r.joints[any], &self.grid.joints[any]);
        let key = |stem: &str| format!("{stem}_{}", joint.suffix());
        let length = if joint.revolute { 1.0 } else { 15.0 };
        let on = |values: &[(&str, f64)]| Effect::new(name, &joint.name, values);
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let end_s = self.rows.last().map_or(0.0, |k| *k as f64 * STEP_S);
        match name {
            "bearing_wobble" => {
                let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |s, v| (s.0.min(*v), s.1.max(*v)));
                let turn = if joint.revolute { std::f64::consts::TAU } else { joint.lead_m };
                // three to eight periods over the travel
                let cycles = (rng.random_range(3.0..8.0) * turn / (high - low)).ceil();
                let phase = rng.random_range(-180.0..180.0);
                let mut e = on(&[("amplitude_deg", 0.001), ("cycles_per_rev", cycles), ("phase_deg", phase)]);
                let about: f64 = rng.random_range(0.0..std::f64::consts::TAU);
                e.direction = Some([about.cos(), about.sin(), 0.0]);
                e
            }
            "tracker_scale" => Effect::new(name, "log", &[("scale_ppm", sign * 8.0)]),
            "tracker_frame" => {
                let d = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize() * 20.0;
                let t_s = end_s * rng.random_range(0.25..0.75);
                Effect::new(name, "log", &[("x_um", d.x), ("y_um", d.y), ("z_um", d.z), ("t_s", t_s)])
            }
            "base_tilt" => Effect::new(name, "base", &[("x_rad_per_nm", 1e-8), ("y_rad_per_nm", 1.5e-8)]),
            "coupled_play" => {
                let pair = |&j: &usize| {
                    j > 0 && self.moving.contains(&(j - 1)) && r.joints[j].revolute == r.joints[j - 1].revolute
                };
                let all: Vec<usize> = self.moving.iter().copied().filter(pair).collect();
                let to = if all.is_empty() { any } else { all[rng.random_range(0..all.len())] };
                let target = format!("{}<-{}", r.joints[to].name, r.joints[to.saturating_sub(1)].name);
                let key = format!("half_gap_{}", r.joints[to].suffix());
                Effect::new(
                    name,
                    &target,
                    &[(&key, 0.001 * if r.joints[to].revolute { 1.0 } else { 15.0 }), ("ratio", sign)],
                )
            }
            "loaded_play" => {
                let loads: Vec<f64> = q
                    .iter()
                    .enumerate()
                    .step_by(500)
                    .map(|(k, _)| {
                        let pose: Vec<f64> = self.grid.joints.iter().map(|q| q[k]).collect();
                        gravity_load(r, &frames(r, &r.tool(), &pose), any).abs()
                    })
                    .collect();
                let most = loads.iter().fold(1e-3_f64, |m, v| m.max(*v));
                let torque = if joint.revolute { "torque_nm" } else { "force_n" };
                on(&[(&key("half_gap"), 0.001 * length), (torque, most * rng.random_range(0.1..0.4))])
            }
            "thermal_growth" => {
                let per = 3600.0 / end_s.max(1.0);
                let lengths: Vec<usize> = (0..r.joints.len()).filter(|&j| r.joints[j].a_m.abs() > 0.05).collect();
                if lengths.is_empty() || rng.random_bool(0.5) {
                    return on(&[(&key("per_hour"), sign * 0.001 * length * per)]);
                }
                let j = lengths[rng.random_range(0..lengths.len())];
                Effect::new(name, &format!("{}.a", r.joints[j].name), &[("per_hour_mm", sign * 0.03 * per)])
            }
            "tracker_refraction" => Effect::new(name, "log", &[("gradient_k_per_m", sign * 0.5)]),
            "torque_windup" | "process_force" => {
                let stem = if joint.revolute { "compliance_deg_per_nm" } else { "compliance_mm_per_n" };
                on(&[(stem, 2e-5 * length)])
            }
            _ => {
                let held: Vec<usize> = (0..r.joints.len()).filter(|j| !self.moving.contains(j)).collect();
                let joint = held.get(rng.random_range(0..held.len().max(1))).map_or(joint, |&j| &r.joints[j]);
                let (torque, length) = if joint.revolute { ("torque_nm", 1.0) } else { ("force_n", 15.0) };
                let half_width = format!("half_width_{}", joint.suffix());
                Effect::new(name, &joint.name, &[(&half_width, 0.001 * length), (torque, rng.random_range(5.0..30.0))])
            }
        }
    }

    /// A hysteresis of two or three elements: from a hundredth of the travel to a tenth.
    pub fn draw_elements(&self, rng: &mut ChaCha8Rng) -> Effect {
        let any = self.moving[rng.random_range(0..self.moving.len())];
        let joint = &self.robot.joints[any];
        let q = &self.grid.joints[any];
        let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |s, v| (s.0.min(*v), s.1.max(*v)));
        let travel = (high - low) / joint.unit();
        let count = rng.random_range(2..4);
        let mut e = Effect::new("hysteresis", &joint.name, &[]);
        e.knots = (0..count)
            .map(|k| {
                let share = 0.004 * 25f64.powf(f64::from(k) / f64::from(count - 1)) * rng.random_range(0.8..1.25);
                [travel * share, 0.0004 * if joint.revolute { 1.0 } else { 15.0 } * rng.random_range(0.6..1.6)]
            })
            .collect();
        e.printed()
    }
}

/// What remains of a course after the best mixture of others.
pub fn left_after(course: &DVector<f64>, others: &[DVector<f64>]) -> DVector<f64> {
    let useful: Vec<_> = others.iter().filter(|o| o.norm() > 1e-9).map(|o| o / o.norm()).collect();
    if useful.is_empty() {
        return course.clone();
    }
    let q = DMatrix::from_columns(&useful).qr().q();
    course - &q * (q.transpose() * course)
}

/// A size that a machine could have and that the log's noise could not hide alone.
fn physical(e: &Effect) -> bool {
    let below = |v: f64, most: f64| v.abs() <= most;
    let metric = e.values.iter().any(|(k, _)| k.ends_with("_mm"));
    let play = if metric { 1.0 } else { 0.06 };
    match e.name.as_str() {
        "servo_lag" => below(e.get("lag_s"), 0.1),
        "time_offset" => below(e.get("offset_s"), 0.1),
        "stiction" => below(e.of("spike"), play),
        "encoder_scale" => below(e.get("scale_ppm"), 5e3),
        "transmission_error" => {
            below(e.of("amplitude"), play) && below(e.of("amplitude") * e.get("cycles_per_rev"), 10.0)
        }
        "backlash" | "backlash_speed" => below(e.of("half_gap"), play),
        "backlash_position" => e.knots.iter().all(|k| below(k[1], 0.06 * if k[1] > 0.06 { 20.0 } else { 1.0 })),
        "hysteresis" => below(e.of("half_width"), 2.0 * play),
        "joint_zero_offset" => below(e.of("offset"), if metric { 5.0 } else { 0.3 }),
        "axis_coupling" => below(e.get("ratio"), 5e-3),
        "gravity_compliance" => below(e.of("compliance_deg_per_nm").max(e.get("compliance_deg_per_nm")), 0.02),
        "link_error" => below(e.get("delta_mm"), 5.0) && below(e.get("delta_deg"), 0.3),
        "vibration" => below(e.get("amplitude_um"), 300.0),
        "bearing_wobble" => below(e.get("amplitude_deg"), 0.1),
        "tracker_scale" => below(e.get("scale_ppm"), 900.0),
        "tracker_frame" => ["x_um", "y_um", "z_um"].iter().all(|k| below(e.get(k), 5e3)),
        "base_tilt" => below(e.get("y_rad_per_nm"), 5e-5),
        "coupled_play" | "loaded_play" => below(e.of("half_gap"), play),
        "tracker_refraction" => below(e.get("gradient_k_per_m"), 1.8),
        "torque_windup" | "process_force" => below(e.get("compliance_deg_per_nm"), 0.02),
        "torque_hysteresis" => below(e.of("half_width"), play),
        "thermal_growth" => below(e.get("per_hour_mm"), 90.0) && below(e.get("per_hour_deg"), 5.0),
        _ => ["x_mm", "y_mm", "z_mm"].iter().all(|k| below(e.get(k), 5.0)),
    }
}
