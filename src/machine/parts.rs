//! Single stages of the chain, for whoever evaluates the chain piece by piece: `diagnose` asks what one effect changes.

use super::CommandTrajectory;
use super::predict::at_time;
use crate::effects::{Effect, EffectInstance, Stage, Target};
use crate::model::Model;
use nalgebra::Vector3;

/// Adds what a link effect adds to its axis, row by row, rad or m.
pub fn add_link(drive: &CommandTrajectory, placed: &EffectInstance, joint: &mut [f64]) {
    match (&placed.effect, placed.target) {
        (Effect::JointZeroOffset(e), _) => joint.iter_mut().for_each(|q| *q += e.offset),
        (Effect::AxisCoupling(e), Target::Coupled { from, .. }) => {
            joint.iter_mut().zip(drive.command(from)).for_each(|(q, p)| *q += e.ratio * p);
        }
        (Effect::GravityCompliance(e), Target::Joint(axis)) => {
            joint.iter_mut().zip(drive.gravity_torque(axis)).for_each(|(q, t)| *q += e.compliance * t);
        }
        _ => {}
    }
}

/// Between the two gaps of a drive (coupling and nut, seed 003), row by row, rad or m: behind what the model lists before the
/// last play of the axis. With one play or none that is the motor side.
pub fn between_gaps(model: &Model, drive: &CommandTrajectory, axis: usize) -> Vec<f64> {
    let effects: Vec<&Effect> = model.effects_on(axis).collect();
    let play = |e: &&Effect| matches!(e, Effect::Backlash(_) | Effect::BacklashSpeed(_));
    let initial_gap_side = model.initial_gap_side.get(axis).copied().unwrap_or(0);
    match effects.iter().rposition(play) {
        Some(last) if effects.iter().filter(|e| play(e)).count() > 1 => {
            // servo effects stand where they like in the file and act first all the same
            let servo = effects[last..].iter().filter(|e| e.stage() == Stage::Servo);
            let before: Vec<&Effect> = effects[..last].iter().chain(servo).copied().collect();
            drive.gear(axis, &before, initial_gap_side)
        }
        _ => drive.servo(axis, &effects, initial_gap_side),
    }
}

/// Sum of the clock offsets, s.
pub fn time_offset_s(effects: &[EffectInstance]) -> f64 {
    effects.iter().map(|p| if let Effect::TimeOffset(e) = &p.effect { e.offset_s } else { 0.0 }).sum()
}

/// Adds drift and vibration to points in the base frame, at the rows' times plus `offset_s`. Settled poses have no time.
pub fn add_tcp(drive: &CommandTrajectory, effects: &[EffectInstance], offset_s: f64, points: &mut [Vector3<f64>]) {
    let start = drive.t_s().first().copied().unwrap_or(0.0);
    if drive.settled() {
        return;
    }
    for placed in effects {
        let mut add = |value: &dyn Fn(f64) -> Vector3<f64>| {
            for (p, t) in points.iter_mut().zip(drive.t_s()) {
                *p += value(t + offset_s - start);
            }
        };
        match &placed.effect {
            Effect::ThermalDrift(e) => add(&|t| e.at(t)),
            Effect::Vibration(e) => add(&|t| e.at(t)),
            _ => {}
        }
    }
}

/// The path as it is `offset_s` later. Settled poses stay.
pub fn shift_in_time(drive: &CommandTrajectory, offset_s: f64, points: &mut Vec<Vector3<f64>>) {
    if offset_s == 0.0 || drive.settled() || points.len() < 2 {
        return;
    }
    let t_s = drive.t_s();
    let old = std::mem::take(points);
    points.extend(t_s.iter().map(|t| at_time(t_s, &old, t + offset_s)));
}

/// A number per row as it is `offset_s` later. Settled poses stay.
pub fn number_in_time<'a>(drive: &CommandTrajectory, offset_s: f64, values: &'a [f64]) -> std::borrow::Cow<'a, [f64]> {
    if offset_s == 0.0 || drive.settled() || values.len() < 2 {
        return values.into();
    }
    let t_s = drive.t_s();
    let points: Vec<Vector3<f64>> = values.iter().map(|v| Vector3::new(*v, 0.0, 0.0)).collect();
    t_s.iter().map(|t| at_time(t_s, &points, t + offset_s).x).collect::<Vec<f64>>().into()
}

/// Derivative of a series at each of its times: the slope of the parabola through a sample and its neighbours.
pub fn slopes(t_s: &[f64], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    if n < 3 {
        return vec![0.0; n];
    }
    let between = |i: usize| (values[i + 1] - values[i]) / (t_s[i + 1] - t_s[i]);
    (0..n)
        .map(|i| {
            if i == 0 {
                between(0)
            } else if i + 1 == n {
                between(n - 2)
            } else {
                let (h0, h1) = (t_s[i] - t_s[i - 1], t_s[i + 1] - t_s[i]);
                (between(i - 1) * h1 + between(i) * h0) / (h0 + h1)
            }
        })
        .collect()
}
