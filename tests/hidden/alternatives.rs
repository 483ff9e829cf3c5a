//! Effects of other names that do the same to this log: the `also_right` of a truth.
//!
//! Every name on every target is fitted to the course of the true one, whitened and with the frame projected off where it is
//! estimated. One that leaves less than the log could show (2 ln L within 4) is as right as the truth. This covers what
//! the catalogue lists as told apart only under conditions: the zero of the first joint against the frame, of the last one
//! against the tool, `d` of parallel axes, plays whose transition is not sampled, one-sided and one-speed logs.

use crate::effects::Effect;
use crate::truth::{Setting, left_after};
use nalgebra::{DVector, Vector3};
use serde_json::{Value, json};

/// A name on a target, as one or more courses that may be mixed freely.
struct Candidate {
    name: String,
    target: String,
    parts: Vec<Effect>,
}

/// 2 ln L within which an alternative is as good as the truth.
const AS_GOOD: f64 = 4.0;

fn candidates(s: &Setting) -> Vec<Candidate> {
    let mut list = Vec::new();
    let mut add = |name: &str, target: &str, parts: Vec<Vec<(String, f64)>>| {
        let parts = parts
            .into_iter()
            .map(|values| Effect::new(name, target, &values.iter().map(|(k, v)| (k.as_str(), *v)).collect::<Vec<_>>()))
            .collect();
        list.push(Candidate { name: name.into(), target: target.into(), parts });
    };
    let one = |k: &str, v: f64| vec![(k.to_string(), v)];
    let end_s = s.rows.last().map_or(100.0, |k| *k as f64 * crate::physics::STEP_S);
    for (index, j) in s.robot.joints.iter().enumerate() {
        let (x, n) = (j.suffix(), &j.name);
        let size = if j.revolute { 1e-3 } else { 0.015 };
        let compliance = if j.revolute { "compliance_deg_per_nm" } else { "compliance_mm_per_n" };
        add("joint_zero_offset", n, vec![one(&format!("offset_{x}"), size)]);
        add("gravity_compliance", n, vec![one(compliance, 1e-5)]);
        for (p, k, v) in [("a", "delta_mm", 0.02), ("d", "delta_mm", 0.02), ("alpha", "delta_deg", 1e-3)] {
            add("link_error", &format!("{n}.{p}"), vec![one(k, v)]);
        }
        for &from in s.moving.iter().filter(|&&i| i != index && s.robot.joints[i].revolute == j.revolute) {
            add("axis_coupling", &format!("{n}<-{}", s.robot.joints[from].name), vec![one("ratio", 1e-5)]);
        }
        if !s.moving.contains(&index) {
            continue;
        }
        add("servo_lag", n, vec![one("lag_s", 1e-3)]);
        add("encoder_scale", n, vec![one("scale_ppm", 10.0)]);
        add("backlash", n, vec![one(&format!("half_gap_{x}"), size)]);
        for decay in [0.2, 0.5, 1.0, 2.0, 4.0] {
            let mut v = one(&format!("spike_{x}"), size);
            v.push(("decay_s".into(), decay));
            add("stiction", n, vec![v]);
        }
        for presliding in [0.2, 0.5, 1.0, 2.0, 4.0, 8.0] {
            let mut v = one(&format!("half_width_{x}"), size);
            v.push((format!("presliding_{x}"), presliding * if j.revolute { 1.0 } else { 10.0 }));
            add("hysteresis", n, vec![v]);
        }
        for cycles in [1.0, 2.0] {
            let wave = |phase: f64| {
                let mut v = one(&format!("amplitude_{x}"), size);
                v.extend([("cycles_per_rev".to_string(), cycles), ("phase_deg".to_string(), phase)]);
                v
            };
            add("transmission_error", n, vec![wave(0.0), wave(90.0)]);
        }
    }
    let axes = ["x_mm", "y_mm", "z_mm"];
    add("tool_error", "tool", axes.iter().map(|k| one(k, 0.02)).collect());
    for tau in [0.1, 0.3, 0.8] {
        let part = |k: &&str| vec![(k.to_string(), 0.02), ("tau_s".to_string(), tau * end_s)];
        add("thermal_drift", "tcp", axes.iter().map(part).collect());
    }
    add("time_offset", "log", vec![one("offset_s", 1e-3)]);
    list
}

/// Squared length that the best of a candidate leaves of a course.
fn left(s: &Setting, clean: &[Vector3<f64>], c: &Candidate, course: &DVector<f64>) -> f64 {
    let part = |e: &Effect| s.sensitivity(clean, std::slice::from_ref(e), &[]);
    let mut parts: Vec<DVector<f64>> = c.parts.iter().map(part).collect();
    if let [only] = parts.as_slice() {
        let scale = only.dot(course) / only.norm_squared().max(1e-30);
        let cannot =
            ["backlash", "stiction", "hysteresis", "servo_lag", "gravity_compliance"].contains(&c.name.as_str());
        if cannot && scale <= 0.0 {
            return course.norm_squared();
        }
        // Not linear in its size: once more, at the size that fits.
        parts = vec![part(&c.parts[0].scaled(scale))];
    }
    left_after(course, &parts).norm_squared()
}

/// Names and targets that explain the log as well as this effect does.
pub fn find(s: &Setting, clean: &[Vector3<f64>], truth: &Effect) -> Vec<(String, String)> {
    let course = s.sensitivity(clean, std::slice::from_ref(truth), &[]);
    let mut found: Vec<(String, String)> = Vec::new();
    for c in candidates(s) {
        let key = (c.name.clone(), c.target.clone());
        let itself = c.name == truth.name && c.target == truth.target;
        if !itself && !found.contains(&key) && left(s, clean, &c, &course) < AS_GOOD {
            found.push(key);
        }
    }
    found
}

/// Length of what the best single effect leaves of a course.
pub fn least_left(s: &Setting, clean: &[Vector3<f64>], course: &DVector<f64>) -> f64 {
    candidates(s).iter().map(|c| left(s, clean, c, course)).fold(f64::MAX, f64::min).sqrt()
}

pub fn json(alternatives: &[(String, String)]) -> Value {
    alternatives.iter().map(|(name, target)| json!({"effect": name, "target": target})).collect()
}
