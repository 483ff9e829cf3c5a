//! Single stages of the chain, for callers that evaluate the chain piece by piece: `diagnose` computes what one effect changes.

use super::CommandTrajectory;
use super::predict::at_time;
use crate::effects::{Clock, Effect, EffectInstance, Row, Stage};
use crate::model::Model;
use crate::numerics::parallel;
use crate::robot::Chain;
use nalgebra::{Isometry3, Vector3};

/// Rows that one thread takes at a time.
const BLOCK: usize = 4096;

/// Adds what a link effect adds to its axis, row by row, rad or m.
pub fn add_link(trajectory: &CommandTrajectory, placed: &EffectInstance, joint: &mut [f64]) {
    placed.effect.add_to_joint(placed.target, trajectory, joint);
}

/// Between the two gaps of a drive (coupling and nut, Gantry (2015)), row by row, rad or m: after what the model lists before the
/// last play of the axis. With one play or none that is the motor side.
pub fn between_gaps(model: &Model, trajectory: &CommandTrajectory, axis: usize) -> Vec<f64> {
    let effects: Vec<&Effect> = model.effects_on(axis).collect();
    let play = |e: &&Effect| e.is_play();
    let initial_gap_side = model.initial_gap_side.get(axis).copied().unwrap_or(0);
    match effects.iter().rposition(play) {
        Some(last) if effects.iter().filter(|e| play(e)).count() > 1 => {
            // servo effects stand where they like in the file and act first all the same
            let servo = effects[last..].iter().filter(|e| e.stage() == Stage::Servo);
            let before: Vec<&Effect> = effects[..last].iter().chain(servo).copied().collect();
            trajectory.gear(axis, &before, initial_gap_side)
        }
        _ => trajectory.servo(axis, &effects, initial_gap_side),
    }
}

/// How the clock of the measurement stands to that of the commands, all effects together.
pub fn clock(effects: &[EffectInstance]) -> Clock {
    effects.iter().map(|p| p.effect.clock()).fold(Clock::default(), |a, b| a.plus(&b))
}

/// Where the points are that effects after the kinematics move.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The commands.
    pub trajectory: &'a CommandTrajectory,
    /// The chain with its geometry effects, and the joints' positions `[axis][row]`, rad or m.
    pub chain: &'a Chain,
    /// Joint positions, `[axis][row]`, rad or m.
    pub joint: &'a [&'a [f64]],
    /// Base frame -> tracker frame, where it is known.
    pub registration: Option<&'a Isometry3<f64>>,
    /// The tracker's clock.
    pub clock: Clock,
}

/// Moves points of the base frame by the effects that depend on the pose; those of TCP and measurement come after the shift
/// in time: [`displace_at_tcp`].
pub fn displace_by_pose(scene: &Scene, effects: &[EffectInstance], points: &mut [Vector3<f64>]) {
    displace(scene, effects.iter().filter(|p| p.effect.stage() < Stage::Tcp), points);
}

/// Moves points of the base frame by the effects of the TCP and of the measurement.
pub fn displace_at_tcp(scene: &Scene, effects: &[EffectInstance], points: &mut [Vector3<f64>]) {
    displace(scene, effects.iter().filter(|p| p.effect.stage() >= Stage::Tcp), points);
}

fn displace<'a>(scene: &Scene, effects: impl Iterator<Item = &'a EffectInstance>, points: &mut [Vector3<f64>]) {
    each_point(scene, effects, points, |point, row, effects| {
        for placed in effects {
            *point += placed.effect.displacement_m(placed.target, row, point);
        }
    });
}

/// How far effects move points of the base frame, all stages together, m.
pub fn displacements_m(scene: &Scene, effects: &[EffectInstance], points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    if effects.iter().all(|p| !p.effect.displaces()) {
        return vec![Vector3::zeros(); points.len()];
    }
    let mut moved = points.to_vec();
    each_point(scene, effects.iter(), &mut moved, |point, row, effects| {
        let at = *point;
        *point = effects.iter().map(|p| p.effect.displacement_m(p.target, row, &at)).sum();
    });
    moved
}

fn each_point<'a>(
    scene: &Scene,
    effects: impl Iterator<Item = &'a EffectInstance>,
    points: &mut [Vector3<f64>],
    change: impl Fn(&mut Vector3<f64>, &Row, &[&EffectInstance]) + Sync,
) {
    let effects: Vec<&EffectInstance> = effects.filter(|p| p.effect.displaces()).collect();
    if effects.is_empty() {
        return;
    }
    let (t_s, settled) = (scene.trajectory.t_s(), scene.trajectory.settled());
    let start = scene.trajectory.began_s();
    let uses_frames = effects.iter().any(|p| p.effect.uses_frames());
    let station_m = scene.registration.map_or(Vector3::zeros(), |r| r.inverse().translation.vector);
    parallel::change_pieces(points, BLOCK, |block, points| {
        let (mut q, mut frames) = (vec![0.0; scene.joint.len()], Vec::new());
        for (i, point) in points.iter_mut().enumerate() {
            let index = block * BLOCK + i;
            if uses_frames {
                q.iter_mut().zip(scene.joint).for_each(|(v, column)| *v = column[index]);
                scene.chain.joint_frames(&q, &mut frames);
            }
            let measured_s = t_s.get(index).map_or(0.0, |t| t - start);
            let t_s = scene.clock.at(measured_s, 0.0);
            let row = Row { index, t_s, measured_s, settled, inputs: scene.trajectory, frames: &frames, station_m };
            change(point, &row, &effects);
        }
    });
}

/// The path as another clock sees it. Settled poses stay.
pub fn shift_in_time(trajectory: &CommandTrajectory, clock: Clock, points: &mut Vec<Vector3<f64>>) {
    if clock.is_right() || trajectory.settled() || points.len() < 2 {
        return;
    }
    let t_s = trajectory.t_s();
    let old = std::mem::take(points);
    points.extend(t_s.iter().map(|t| at_time(t_s, &old, clock.at(*t, t_s[0]))));
}

/// A number per row as another clock sees it. Settled poses stay.
pub fn number_in_time<'a>(
    trajectory: &CommandTrajectory,
    clock: Clock,
    values: &'a [f64],
) -> std::borrow::Cow<'a, [f64]> {
    if clock.is_right() || trajectory.settled() || values.len() < 2 {
        return values.into();
    }
    let t_s = trajectory.t_s();
    let points: Vec<Vector3<f64>> = values.iter().map(|v| Vector3::new(*v, 0.0, 0.0)).collect();
    t_s.iter().map(|t| at_time(t_s, &points, clock.at(*t, t_s[0])).x).collect::<Vec<f64>>().into()
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
