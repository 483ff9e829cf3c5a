//! From a hypothesis (effects and frames) to the residual of every observation, and to the sensitivity of every parameter.
//!
//! Method: the whole chain is evaluated exactly, nothing is linearised in the residual. Measured points are taken into the
//! base frame by the inverse registration, so that sensitivities do not turn with the frame. A sensitivity is the derivative
//! of the prediction by one parameter: joint effects by a difference of joint positions times the Jacobian's column,
//! geometry by a difference of kinematics, the rest in closed form.
//!
//! Parts:
//! - [`change`]: what a change of the hypothesis does to the observations.
//! - [`log_data`]: what the problem knows of a log.

mod change;
mod log_data;

use crate::diagnose::note::Note;
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::diagnose::problem::orientation;
use crate::effects::{Clock, Effect, EffectInstance, Stage, Target};
use crate::machine::{self, parts, parts::Scene};
use crate::numerics::parallel::{self, ParMap};
use crate::robot::{Chain, Robot};
pub use log_data::{Jacobian, LogData, Tilts};
use nalgebra::{Isometry3, Vector3};
use std::sync::{Arc, OnceLock};

/// Rows that one thread takes at a time.
const CHUNK: usize = 4096;

/// Everything that does not change while hypotheses are tried.
#[derive(Debug)]
pub struct Problem {
    pub robot: Robot,
    pub initial_gap_side: Vec<i8>,
    pub logs: Vec<LogData>,
    pub groups: Vec<Group>,
    /// Length of the long vector.
    pub n: usize,
    /// The frames are estimated; else they are given.
    pub frames_free: bool,
    /// The places of the second and further reflectors in the flange are estimated.
    pub points_free: bool,
    /// What a reader should know about the channels.
    pub notes: Vec<Note>,
    /// Most cycles over the travel that the places of each axis tell from fewer, and the travel, rad or m.
    pub determined: OnceLock<Vec<(f64, f64)>>,
}

/// What is supposed to be wrong with the machine, and where it stands.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// Known effects first, then found ones.
    pub effects: Vec<EffectInstance>,
    /// Base frame -> tracker frame, one per group of logs.
    pub frames: Vec<Isometry3<f64>>,
    /// Where the second and further reflectors stand beside the robot file, flange frame, m.
    pub points_m: Vec<Vector3<f64>>,
    /// Zero of each joint sensor and own quantities of each ballbar or dial, rad or m, in the order of their groups.
    pub zeros: Vec<f64>,
}

/// Prediction for one log.
#[derive(Debug, Clone)]
pub struct LogState {
    /// Motor side, after the gear, and joint positions, `[axis][row]`.
    pub servo: Vec<Vec<f64>>,
    pub gear: Vec<Arc<Vec<f64>>>,
    pub joint: Vec<Arc<Vec<f64>>>,
    /// Points of the chain alone, base frame `[reflector][row]`, m.
    pub chain_m: Vec<Arc<Vec<Vector3<f64>>>>,
    /// Points in the base frame `[reflector][row]`, m.
    pub points_m: Vec<Arc<Vec<Vector3<f64>>>>,
    pub jacobian: Arc<Jacobian>,
}

/// Prediction of a hypothesis and what it leaves.
#[derive(Debug, Clone)]
pub struct State {
    pub logs: Vec<LogState>,
    /// Measured minus predicted, the long vector (m and rad).
    pub residual: Vec<f64>,
    pub(in crate::diagnose) geometry: Robot,
}

impl Problem {
    /// A copy, which may leave out other samples.
    pub fn copy(&self) -> Self {
        Self {
            robot: self.robot.clone(),
            initial_gap_side: self.initial_gap_side.clone(),
            logs: self.logs.iter().map(LogData::copy).collect(),
            groups: self.groups.clone(),
            n: self.n,
            frames_free: self.frames_free,
            points_free: self.points_free,
            notes: self.notes.clone(),
            determined: self.determined.clone(),
        }
    }

    /// Index of every observation group of one log.
    pub fn groups_of(&self, log: usize) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(move |g| g.log == log)
    }

    /// Own quantities of the sensor of a group that are estimated.
    pub fn unknowns(&self, group: &Group) -> usize {
        match group.sensor {
            Sensor::Reflector(_) | Sensor::Orientation => 0,
            Sensor::Motor(_) | Sensor::Joint(_) => 1,
            Sensor::Reading => self.logs[group.log].reading.as_ref().map_or(0, |r| r.unknowns()),
        }
    }

    /// Adds to `out`, the long vector, what a group measures of a movement of one of its points; nothing of a joint sensor.
    pub fn add_movement(&self, group: &Group, point: usize, out: &mut [f64], movement: impl Fn(usize) -> Vector3<f64>) {
        let log = &self.logs[group.log];
        match (group.sensor, &log.reading, &log.orientation) {
            (Sensor::Reflector(_), ..) => group.add_points(out, movement),
            (Sensor::Reading, Some(reading), _) => group.add_numbers(out, |r| reading.seen(r, &movement(r))),
            (Sensor::Orientation, _, Some(turned)) => group.add_points(out, |r| turned.seen(r, point, &movement(r))),
            _ => {}
        }
    }

    /// What a turn about a joint, or its slide, moves of what a group with three coordinates measures, per rad or m of the joint.
    pub fn lever(&self, group: &Group, along: &dyn Fn(usize) -> Vector3<f64>, row: usize) -> Vector3<f64> {
        match (group.sensor, &self.logs[group.log].orientation) {
            (Sensor::Orientation, Some(turned)) => orientation::POINTS.map(|k| turned.seen(row, k, &along(k))).sum(),
            (sensor, _) => along(sensor.point().unwrap_or(0)),
        }
    }

    /// Whether the orientation of the tool was measured.
    pub fn is_turned(&self) -> bool {
        self.logs.iter().any(|l| l.orientation.is_some())
    }

    fn chains(&self, geometry: &Robot, log: &LogData) -> Vec<Chain> {
        (0..log.reflectors())
            .map(|k| match k {
                0 => geometry.chain().clone(),
                _ => {
                    geometry.reflectors_m.get(k - 1).map_or_else(|| geometry.chain().clone(), |p| geometry.chain_to(p))
                }
            })
            .collect()
    }

    /// Evaluates a hypothesis.
    pub fn evaluate(&self, h: &Hypothesis) -> State {
        let mut geometry = machine::geometry(&self.robot, &h.effects);
        for (p, d) in geometry.reflectors_m.iter_mut().zip(&h.points_m) {
            *p += d;
        }
        let logs: Vec<LogState> = (0..self.logs.len()).map(|l| self.evaluate_log(h, &geometry, l)).collect();
        let mut residual = vec![0.0; self.n];
        let clock = parts::clock(&h.effects);
        let mut zeros = h.zeros.as_slice();
        for g in &self.groups {
            let (own, others) = zeros.split_at(self.unknowns(g).min(zeros.len()));
            zeros = others;
            let zero = own.first().copied().unwrap_or(0.0);
            let (log, state) = (&self.logs[g.log], &logs[g.log]);
            match g.sensor {
                Sensor::Reflector(k) => {
                    let back = h.frames[log.frame].inverse();
                    let points = &state.points_m[k];
                    g.add_points(&mut residual, |r| match log.measured(k, r) {
                        Some(m) => back.transform_point(&m.into()).coords - points[r],
                        None => Vector3::zeros(),
                    });
                }
                Sensor::Orientation => {
                    if let Some(turned) = &log.orientation {
                        let back = h.frames[log.frame].rotation.inverse();
                        g.add_points(&mut residual, |r| turned.residual(r, &back, |k| state.points_m[k][r]));
                    }
                }
                Sensor::Motor(a) => {
                    g.add_numbers(&mut residual, |r| sensed(&log.log.enc, a, r) - state.servo[a][r] - zero);
                }
                Sensor::Reading => {
                    if let Some(reading) = &log.reading {
                        g.add_numbers(&mut residual, |r| reading.residual(r, &state.points_m[0][r], own));
                    }
                }
                Sensor::Joint(a) => {
                    let joint = parts::number_in_time(&log.trajectory, clock, &state.joint[a]);
                    g.add_numbers(&mut residual, |r| sensed(&log.log.meas, a, r) - joint[r] - zero);
                }
            }
        }
        State { logs, residual, geometry }
    }

    fn evaluate_log(&self, h: &Hypothesis, geometry: &Robot, l: usize) -> LogState {
        let dof = self.robot.dof();
        let log = &self.logs[l];
        let here: Vec<EffectInstance> = h.effects.iter().map(|p| in_log(p, l)).collect();
        let on = |axis: usize| -> Vec<&Effect> {
            here.iter().filter(|p| p.target == Target::Joint(axis)).map(|p| &p.effect).collect()
        };
        let servo: Vec<Vec<f64>> = (0..dof)
            .map(|a| {
                let seen = self.groups_of(l).any(|g| g.sensor == Sensor::Motor(a));
                if seen { log.servo(a, &on(a), self.initial_gap_side[a]) } else { Vec::new() }
            })
            .collect();
        let gear: Vec<Arc<Vec<f64>>> = (0..dof)
            .par_map(|a| Arc::new(log.gear(a, &behind_encoder(on(a), log.is_driven(a)), self.initial_gap_side[a])));
        let mut joint = gear.clone();
        for p in h.effects.iter().filter(|p| p.effect.stage() == Stage::Link) {
            if let Some(axis) = p.axis() {
                parts::add_link(&log.trajectory, p, Arc::make_mut(&mut joint[axis]).as_mut_slice());
            }
        }
        let rows = log.trajectory.rows();
        let chains = self.chains(geometry, log);
        let chain_m: Vec<Arc<Vec<Vector3<f64>>>> = chains.iter().map(|c| Arc::new(along(c, &joint, rows))).collect();
        let mut points_m = chain_m.clone();
        let clock = parts::clock(&h.effects);
        if !clock.is_right() || here.iter().any(|p| p.effect.displaces()) {
            let columns: Vec<&[f64]> = joint.iter().map(|j| j.as_slice()).collect();
            for (points, chain) in points_m.iter_mut().zip(&chains) {
                let scene = self.scene(h, log, chain, &columns, clock);
                let points = Arc::make_mut(points);
                parts::displace_by_pose(&scene, &here, points);
                parts::shift_in_time(&log.trajectory, clock, points);
                parts::displace_at_tcp(&scene, &here, points);
            }
        }
        let jacobian = log.jacobian.get_or_init(|| Arc::new(chains.iter().map(|c| derivatives(c, &joint)).collect()));
        LogState { servo, gear, jacobian: jacobian.clone(), joint, chain_m, points_m }
    }

    /// Derivatives of the points of a log by a tilt of each axis.
    pub fn tilts(&self, state: &State, l: usize) -> Arc<Tilts> {
        let (log, s) = (&self.logs[l], &state.logs[l]);
        let of = |(k, chain): (usize, &Chain)| tilts(chain, &s.joint, &s.chain_m[k]);
        log.tilts
            .get_or_init(|| Arc::new(self.chains(&state.geometry, log).iter().enumerate().map(of).collect()))
            .clone()
    }

    /// Where the points of a log stand, for the effects that move them.
    fn scene<'a>(
        &self,
        h: &'a Hypothesis,
        log: &'a LogData,
        chain: &'a Chain,
        joint: &'a [&'a [f64]],
        clock: Clock,
    ) -> Scene<'a> {
        Scene { trajectory: &log.trajectory, chain, joint, registration: h.frames.get(log.frame), clock }
    }
}

/// An effect as it is in one log.
fn in_log(placed: &EffectInstance, log: usize) -> EffectInstance {
    match placed.effect.in_log(log) {
        Some(effect) => EffectInstance { target: placed.target, effect },
        None => placed.clone(),
    }
}

/// Effects after the encoder, where that drives the gear.
fn behind_encoder(mut effects: Vec<&Effect>, driven: bool) -> Vec<&Effect> {
    if driven {
        effects.retain(|e| e.stage() != Stage::Servo);
    }
    effects
}

/// Points of a chain, row by row.
fn along(chain: &Chain, joint: &[Arc<Vec<f64>>], rows: usize) -> Vec<Vector3<f64>> {
    let mut points = vec![Vector3::zeros(); rows];
    let columns: Vec<&[f64]> = joint.iter().map(|j| j.as_slice()).collect();
    parallel::change_pieces(&mut points, CHUNK, |k, points| chain.positions(&columns, k * CHUNK, points));
    points
}

fn derivatives(chain: &Chain, joint: &[Arc<Vec<f64>>]) -> Vec<Vec<Vector3<f64>>> {
    let (dof, rows) = (joint.len(), joint.first().map_or(0, |j| j.len()));
    let mut columns = vec![vec![Vector3::zeros(); rows]; dof];
    let (mut q, mut line) = (vec![0.0; dof], vec![Vector3::zeros(); dof]);
    for r in 0..rows {
        for (v, j) in q.iter_mut().zip(joint) {
            *v = j[r];
        }
        chain.position_and_jacobian(&q, &mut line);
        for (c, v) in columns.iter_mut().zip(&line) {
            c[r] = *v;
        }
    }
    columns
}

/// What a tilt of each axis about its x and y, before its own turn, does to the points of a chain.
fn tilts(chain: &Chain, joint: &[Arc<Vec<f64>>], points: &[Vector3<f64>]) -> Vec<Vec<[Vector3<f64>; 2]>> {
    let mut all = vec![vec![[Vector3::zeros(); 2]; points.len()]; joint.len()];
    let (mut q, mut frames) = (vec![0.0; joint.len()], Vec::new());
    for (r, point) in points.iter().enumerate() {
        q.iter_mut().zip(joint).for_each(|(v, column)| *v = column[r]);
        chain.joint_frames(&q, &mut frames);
        for (axis, tilts) in all.iter_mut().enumerate() {
            if let Some(f) = frames.iter().find(|f| f.axis == axis) {
                let arm = point - f.origin_m;
                tilts[r] = [f.fixed_x.cross(&arm), f.fixed_y.cross(&arm)];
            }
        }
    }
    all
}

fn sensed(columns: &[Option<Vec<Option<f64>>>], axis: usize, row: usize) -> f64 {
    columns.get(axis).and_then(|c| c.as_ref()).and_then(|c| c[row]).unwrap_or(0.0)
}
