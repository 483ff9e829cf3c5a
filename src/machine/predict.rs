//! The whole chain: servo, gear, link, geometry, TCP, measurement.
//!
//! Link effects add to what the gear gives. Geometry effects change the robot. Drift and vibration move every reflector in the
//! frame that forward kinematics gives, before the registration; their time counts from the first row. A time offset shows
//! the robot at `t + offset`: its joints by the cubic of [`crate::effects::smooth`] over the rows' TCP, straight on beyond the
//! first and last row for at most [`BEYOND`] intervals; drift and vibration exactly. Sensors of joints are shown
//! with the same offset, encoders are not: they share the clock of the commands.
//!
//! Settled poses have no time: no drift, no vibration, no time offset.

use super::CommandTrajectory;
use super::parts::{self, Scene};
use crate::effects::smooth::{self, Samples};
use crate::effects::{Clock, Effect, EffectInstance, Geometry, Stage};
use crate::model::Model;
use crate::numerics::parallel::{self, ParMap};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Rows that one thread takes at a time.
const BLOCK: usize = 4096;

/// Row intervals beyond the ends over which a motion is drawn out straight.
const BEYOND: f64 = 2.0;

/// What the machine does at the rows.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Motor side, `[axis][row]`, rad or m.
    pub servo: Vec<Vec<f64>>,
    /// After gear and link stage as a joint sensor shows it, `[axis][row]`, rad or m.
    pub joint: Vec<Vec<f64>>,
    /// Reflectors in the tracker frame (the base frame where the model has no registration), `[reflector][row]`, m. The first is the
    /// TCP.
    pub points_m: Vec<Vec<Vector3<f64>>>,
}

/// Robot with the `link_error` and `tool_error` effects applied to its DH parameters and tool. A tool error moves the TCP;
/// further reflectors stay where the robot file has them.
pub fn geometry(robot: &Robot, effects: &[EffectInstance]) -> Robot {
    if effects.iter().all(|e| e.effect.stage() != Stage::Geometry) {
        return robot.clone();
    }
    let mut geometry = Geometry { joints: robot.joints.clone(), tool: robot.tool };
    for placed in effects {
        placed.effect.change_geometry(placed.target, &mut geometry);
    }
    robot.with_geometry(geometry.joints, geometry.tool)
}

/// Runs the whole chain.
pub fn predict(model: &Model, trajectory: &CommandTrajectory) -> Prediction {
    let (servo, joint): (Vec<_>, Vec<_>) =
        (0..model.robot.dof()).par_map(|a| axis(model, trajectory, a)).into_iter().unzip();
    let robot = geometry(&model.robot, &model.effects);
    let mut chains = vec![robot.chain().clone()];
    chains.extend(robot.reflectors_m.iter().map(|p| robot.chain_to(p)));
    let clock = clock(model, trajectory);
    let columns: Vec<&[f64]> = joint.iter().map(Vec::as_slice).collect();
    let points_m = chains
        .iter()
        .map(|chain| {
            let registration = model.registration.as_ref();
            points(model, &Scene { trajectory, chain, joint: &columns, registration, clock })
        })
        .collect();
    let joint = joint.iter().map(|j| parts::number_in_time(trajectory, clock, j).into_owned()).collect();
    Prediction { servo, joint, points_m }
}

/// The TCP alone, row by row, as [`predict`] gives it, m: neither motors nor sensors are kept.
pub fn tcp(model: &Model, trajectory: &CommandTrajectory) -> Vec<Vector3<f64>> {
    let joint = (0..model.robot.dof()).par_map(|axis| after_link(model, trajectory, axis, &effects_on(model, axis)));
    let columns: Vec<&[f64]> = joint.iter().map(Vec::as_slice).collect();
    let robot = geometry(&model.robot, &model.effects);
    let registration = model.registration.as_ref();
    let clock = clock(model, trajectory);
    points(model, &Scene { trajectory, chain: robot.chain(), joint: &columns, registration, clock })
}

/// The clock of what is measured.
fn clock(model: &Model, trajectory: &CommandTrajectory) -> Clock {
    if trajectory.settled() { Clock::default() } else { parts::clock(&model.effects) }
}

/// Effects of one axis, and the side of its gap on which it starts.
fn effects_on(model: &Model, axis: usize) -> (Vec<&Effect>, i8) {
    (model.effects_on(axis).collect(), model.initial_gap_side.get(axis).copied().unwrap_or(0))
}

/// One axis after its link stage.
fn after_link(
    model: &Model,
    trajectory: &CommandTrajectory,
    axis: usize,
    (effects, initial_gap_side): &(Vec<&Effect>, i8),
) -> Vec<f64> {
    let mut joint = trajectory.gear(axis, effects, *initial_gap_side);
    for placed in model.effects.iter().filter(|e| e.axis() == Some(axis)) {
        parts::add_link(trajectory, placed, &mut joint);
    }
    joint
}

/// One axis: motor side, and after the link stage.
fn axis(model: &Model, trajectory: &CommandTrajectory, axis: usize) -> (Vec<f64>, Vec<f64>) {
    let own = effects_on(model, axis);
    (trajectory.servo(axis, &own.0, own.1), after_link(model, trajectory, axis, &own))
}

/// One reflector over the rows.
fn points(model: &Model, scene: &Scene) -> Vec<Vector3<f64>> {
    let rows = scene.trajectory.rows();
    let blocks = rows.div_ceil(BLOCK);
    let range = |b: usize| b * BLOCK..((b + 1) * BLOCK).min(rows);
    let mut points: Vec<Vector3<f64>> = (0..blocks)
        .par_map(|b| {
            let mut q = vec![0.0; scene.joint.len()];
            range(b).map(move |row| {
                for (v, column) in q.iter_mut().zip(scene.joint) {
                    *v = column[row];
                }
                scene.chain.position(&q)
            })
        })
        .into_iter()
        .flatten()
        .collect();
    parts::displace_by_pose(scene, &model.effects, &mut points);
    let t_s = scene.trajectory.t_s();
    if !scene.clock.is_right() && rows > 1 {
        points = (0..blocks)
            .par_map(|b| range(b).map(|row| at_time(t_s, &points, scene.clock.at(t_s[row], t_s[0]))))
            .into_iter()
            .flatten()
            .collect();
    }
    parts::displace_at_tcp(scene, &model.effects, &mut points);
    if let Some(frame) = &model.registration {
        let place = |p: &mut Vector3<f64>| *p = frame.rotation * *p + frame.translation.vector;
        parallel::change_pieces(&mut points, BLOCK, |_, piece| piece.iter_mut().for_each(place));
    }
    points
}

/// One coordinate of a path.
struct Coordinate<'a> {
    t_s: &'a [f64],
    points: &'a [Vector3<f64>],
    c: usize,
}

impl Samples for Coordinate<'_> {
    fn len(&self) -> usize {
        self.t_s.len()
    }
    fn t_s(&self, i: usize) -> f64 {
        self.t_s[i]
    }
    fn p(&self, i: usize) -> f64 {
        self.points[i][self.c]
    }
}

/// A path of two or more rows at any time.
pub(super) fn at_time(t_s: &[f64], points: &[Vector3<f64>], t: f64) -> Vector3<f64> {
    let last = t_s.len() - 1;
    let i = t_s.partition_point(|&x| x <= t).saturating_sub(1).min(last - 1);
    let h = t_s[i + 1] - t_s[i];
    let x = (t - t_s[i]).clamp(-BEYOND * h, (1.0 + BEYOND) * h);
    let inside = x.clamp(0.0, h);
    Vector3::from_fn(|c, _| {
        let coordinate = Coordinate { t_s, points, c };
        let k = smooth::cubic(&coordinate, i);
        let slope = k[0] + inside * (2.0 * k[1] + 3.0 * k[2] * inside);
        smooth::value(points[i][c], &k, inside) + slope * (x - inside)
    })
}
