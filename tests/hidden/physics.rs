//! The machine: every effect of the catalogue, and the faults outside it, stepped in time on a fine grid.
//!
//! The commands are a function of time evaluated every 2 ms; servo and gear effects run through all of those steps, link and
//! geometry effects through those that the log samples. Written from the table of effects alone.
//!
//! Parts:
//! - [`laws`]: what servo and gear do to the positions of one joint.
//! - [`pchip`]: monotone cubics through knots.

mod laws;
mod pchip;

use crate::effects::Effect;
use crate::kinematics::{GRAVITY_M_S2, Pose, apply, forward, frames, gravity_load, jacobian, rpy, translation};
use crate::outside::Outside;
use crate::robots::Robot;
use laws::{elements, hysteresis, lag, loaded_play, play, stiction};
use nalgebra::{Rotation3, Vector3};
pub use pchip::Pchip;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Step of the fine grid (s); divides every period of the logs.
pub const STEP_S: f64 = 0.002;

/// Commands on the fine grid, joint by joint (rad or m); runs on beyond the log's last row.
pub struct Grid {
    pub joints: Vec<Vec<f64>>,
    speed_mm_s: OnceLock<Vec<f64>>,
}

impl Grid {
    pub fn new(joints: Vec<Vec<f64>>) -> Grid {
        Grid { joints, speed_mm_s: OnceLock::new() }
    }

    /// Commanded TCP speed on the grid.
    fn speed_mm_s(&self, robot: &Robot) -> &[f64] {
        self.speed_mm_s.get_or_init(|| {
            let n = self.joints[0].len();
            let tool = robot.tool();
            let at = |k: usize| forward(robot, &tool, &self.joints.iter().map(|q| q[k]).collect::<Vec<_>>());
            // Every fifth step is fine enough for a speed; between them it is linear.
            let coarse: Vec<_> = (0..n.div_ceil(5)).map(|k| at(k * 5)).collect();
            let m = coarse.len();
            let v: Vec<f64> = (0..m)
                .map(|k| {
                    let (a, b) = (k.saturating_sub(1), (k + 1).min(m - 1));
                    (coarse[b] - coarse[a]).norm() * 1e3 / ((b - a).max(1) as f64 * 5.0 * STEP_S)
                })
                .collect();
            (0..n).map(|k| v[k / 5] + (v[(k / 5 + 1).min(m - 1)] - v[k / 5]) * (k % 5) as f64 / 5.0).collect()
        })
    }
}

/// A machine: the robot and all that is wrong with it.
pub struct Machine<'a> {
    pub robot: &'a Robot,
    pub registration: Pose,
    pub effects: Vec<Effect>,
    pub outside: Vec<Outside>,
}

impl Machine<'_> {
    /// The TCP in the tracker's frame (m) at the grid's steps `rows`, without noise.
    pub fn run(&self, grid: &Grid, rows: &[usize]) -> Vec<Vector3<f64>> {
        let joints = self.gears(grid);
        let hysteresis = self.torque_loops(grid);
        let last = grid.joints[0].len() - 1;
        let offset_s: f64 = self.on("time_offset").map(|e| e.get("offset_s")).sum();
        let fixed = self.with_geometry();
        let tool = fixed.tool();
        rows.iter()
            .map(|&row| {
                let at = (row as f64 + offset_s / STEP_S).clamp(0.0, last as f64);
                let (k, u) = ((at as usize).min(last - 1), 0.0);
                let u = u + at - k as f64;
                let mut q: Vec<f64> = joints.iter().map(|c| c[k] + (c[k + 1] - c[k]) * u).collect();
                let robot = self.grown(&fixed, &mut q, at * STEP_S);
                self.links(&robot, &tool, &mut q);
                self.torques(at * STEP_S, &hysteresis, k, &mut q);
                let command: Vec<f64> = grid.joints.iter().map(|c| c[k] + (c[k + 1] - c[k]) * u).collect();
                self.pressed(at * STEP_S, &command, &mut q);
                let mut p = self.tilted(&robot, &tool, &q, &command);
                self.tcp(&mut p, at * STEP_S);
                for o in &self.outside {
                    p += o.tcp(at * STEP_S);
                }
                let scale: f64 = self.on("tracker_scale").map(|e| e.get("scale_ppm") * 1e-6).sum();
                let seen = apply(&self.registration, &p);
                seen * (1.0 + scale) + self.refracted(&seen)
            })
            .collect()
    }

    /// The robot as it has grown by a time; zeros of joints grow in `q`.
    fn grown<'r>(&self, robot: &'r Robot, q: &mut [f64], t_s: f64) -> Cow<'r, Robot> {
        let mut grown = Cow::Borrowed(robot);
        for e in self.on("thermal_growth") {
            match e.target.rsplit_once('.') {
                Some((joint, _)) => {
                    let Some(j) = self.robot.index(joint) else { continue };
                    grown.to_mut().joints[j].a_m += e.get("per_hour_mm") * 1e-3 * t_s / 3600.0;
                }
                None => {
                    let Some(j) = self.robot.index(&e.target) else { continue };
                    q[j] += e.of("per_hour") * self.robot.joints[j].unit() * t_s / 3600.0;
                }
            }
        }
        grown
    }

    /// What the torques of the drives do to the joints; `loops`: the state of each hysteresis on the fine grid.
    fn torques(&self, t_s: f64, loops: &[Vec<f64>], step: usize, q: &mut [f64]) {
        for e in self.on("torque_windup") {
            let Some(j) = self.robot.index(&e.target) else { continue };
            let joint = &self.robot.joints[j];
            let c = e.get("compliance_deg_per_nm") + e.get("compliance_mm_per_n");
            q[j] += c * joint.unit() * torque(j, t_s);
        }
        for (e, z) in self.on("torque_hysteresis").zip(loops) {
            let Some(j) = self.robot.index(&e.target) else { continue };
            q[j] -= e.of("half_width") * self.robot.joints[j].unit() * z[step];
        }
    }

    /// What the force on the tool does to the joints.
    fn pressed(&self, t_s: f64, command: &[f64], q: &mut [f64]) {
        for e in self.on("process_force") {
            let Some(j) = self.robot.index(&e.target) else { continue };
            let lever = jacobian(self.robot, &frames(self.robot, &self.robot.tool(), command))[j];
            let c = e.get("compliance_deg_per_nm") + e.get("compliance_mm_per_n");
            q[j] += c * self.robot.joints[j].unit() * lever.dot(&force(t_s));
        }
    }

    /// How far air that is warmer above raises a point that the tracker, at the origin of its frame, sees at `beam`.
    fn refracted(&self, beam: &Vector3<f64>) -> Vector3<f64> {
        let gradient: f64 = self.on("tracker_refraction").map(|e| e.get("gradient_k_per_m")).sum();
        let up = self.registration.fixed_view::<3, 3>(0, 0) * Vector3::z();
        let (length, along) = (beam.norm(), beam.normalize());
        (up - along * along.dot(&up)) * (0.5 * 0.93e-6 * gradient * length * length)
    }

    /// The state of each hysteresis over torque, step by step of the grid.
    fn torque_loops(&self, grid: &Grid) -> Vec<Vec<f64>> {
        let one = |e: &Effect| {
            let j = self.robot.index(&e.target).unwrap_or(0);
            let over = (e.get("torque_nm") + e.get("force_n")).max(1e-9);
            let (mut z, mut before) = (0.0f64, torque(j, 0.0));
            (0..grid.joints[0].len())
                .map(|k| {
                    let now = torque(j, k as f64 * STEP_S);
                    let (step, side) = (now - before, (now - before).signum());
                    before = now;
                    if step != 0.0 {
                        z = side + (z - side) * (-step.abs() / over).exp();
                    }
                    z
                })
                .collect()
        };
        self.on("torque_hysteresis").map(one).collect()
    }

    /// The TCP where axes tilt as their joints turn, and the base under the weights.
    fn tilted(&self, robot: &Robot, tool: &Pose, q: &[f64], command: &[f64]) -> Vector3<f64> {
        let f = frames(robot, tool, q);
        let mut p = f.tcp;
        let turned = |p: Vector3<f64>, about: Vector3<f64>, origin: Vector3<f64>| {
            Rotation3::from_scaled_axis(about) * (p - origin) + origin
        };
        for e in self.on("bearing_wobble") {
            let (Some(j), Some([x, y, _])) = (self.robot.index(&e.target), e.direction) else { continue };
            let joint = &self.robot.joints[j];
            let turn = if joint.revolute { TAU } else { joint.lead_m };
            let wave = TAU * e.get("cycles_per_rev") * command[j] / turn + e.get("phase_deg").to_radians();
            let tilt = e.get("amplitude_deg").to_radians() * wave.sin();
            p = turned(p, (f.across[j][0] * x + f.across[j][1] * y) * tilt, f.origin[j]);
        }
        for e in self.on("base_tilt") {
            let weight = |m: f64| Vector3::new(0.0, 0.0, -GRAVITY_M_S2 * m);
            let moment: Vector3<f64> =
                robot.links.iter().zip(&f.link).map(|(l, pose)| apply(pose, &l.com_m).cross(&weight(l.mass_kg))).sum();
            let turn = Vector3::new(e.get("x_rad_per_nm") * moment.x, e.get("y_rad_per_nm") * moment.y, 0.0);
            p = turned(p, turn, Vector3::zeros());
        }
        p
    }

    fn on<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s Effect> {
        self.effects.iter().filter(move |e| e.name == name)
    }

    /// Servo and gear of every joint, through all steps of the grid.
    fn gears<'g>(&self, grid: &'g Grid) -> Vec<Cow<'g, [f64]>> {
        let mut joints: Vec<Cow<[f64]>> = grid.joints.iter().map(|q| Cow::Borrowed(q.as_slice())).collect();
        for stage in [&["servo_lag"][..], &["stiction"], &GEAR] {
            for e in self.effects.iter().filter(|e| stage.contains(&e.name.as_str())) {
                let Some(j) = self.robot.index(&e.target) else { continue };
                let joint = &self.robot.joints[j];
                let (u, q) = (joint.unit(), joints[j].to_mut());
                match e.name.as_str() {
                    "servo_lag" => lag(q, e.get("lag_s")),
                    "stiction" => stiction(q, e.of("spike") * u, e.get("decay_s"), e.of("decay") * u),
                    "encoder_scale" => q.iter_mut().for_each(|p| *p *= 1.0 + e.get("scale_ppm") * 1e-6),
                    "transmission_error" => {
                        let turn = if joint.revolute { TAU } else { joint.lead_m };
                        let rate = e.get("cycles_per_rev") * TAU / turn;
                        let (amplitude, phase) = (e.of("amplitude") * u, e.get("phase_deg").to_radians());
                        q.iter_mut().for_each(|p| *p += amplitude * (rate * *p + phase).sin());
                    }
                    "backlash" => play(q, |_, _| e.of("half_gap") * u),
                    "loaded_play" => {
                        let load = self.load(grid, j);
                        loaded_play(q, &load, e.of("half_gap") * u, e.get("torque_nm") + e.get("force_n"));
                    }
                    "backlash_position" => {
                        let curve = Pchip::new(&e.knots.iter().map(|k| k.map(|v| v * u)).collect::<Vec<_>>());
                        play(q, |_, p| curve.at(p));
                    }
                    "backlash_speed" => {
                        let v = grid.speed_mm_s(self.robot);
                        let slope =
                            if joint.revolute { e.get("slope_deg_per_mm_s") } else { e.get("slope_mm_per_mm_s") };
                        play(q, |k, _| (e.of("half_gap") + slope * v[k]) * u);
                    }
                    _ if e.has_elements() => elements(q, &e.knots.iter().map(|k| k.map(|v| v * u)).collect::<Vec<_>>()),
                    _ => hysteresis(q, e.of("half_width") * u, e.of("presliding") * u),
                }
            }
        }
        for e in self.on("coupled_play") {
            let Some((to, from)) = e.target.split_once("<-") else { continue };
            let (Some(to), Some(from)) = (self.robot.index(to), self.robot.index(from)) else { continue };
            let driven = grid.joints[to].iter().zip(&grid.joints[from]);
            let u: Vec<f64> = driven.map(|(p, other)| p - e.get("ratio") * other).collect();
            let mut out = u.clone();
            play(&mut out, |_, _| e.of("half_gap") * self.robot.joints[to].unit());
            joints[to].to_mut().iter_mut().zip(out.iter().zip(&u)).for_each(|(q, (out, u))| *q += out - u);
        }
        for o in &self.outside {
            o.gear(&grid.joints, &mut joints);
        }
        joints
    }

    /// Torque of gravity about a joint at every 25th step.
    fn load(&self, grid: &Grid, j: usize) -> Vec<f64> {
        let tool = self.robot.tool();
        let pose = |k: usize| grid.joints.iter().map(|q| q[k]).collect::<Vec<f64>>();
        let steps = (0..grid.joints[0].len()).step_by(LOADS);
        steps.map(|k| gravity_load(self.robot, &frames(self.robot, &tool, &pose(k)), j)).collect()
    }

    /// Offsets of the links at one pose.
    fn links(&self, robot: &Robot, tool: &Pose, q: &mut [f64]) {
        let from: Vec<f64> = q.to_vec();
        let mut loads = None;
        for e in &self.effects {
            let (to, source) = e.target.split_once("<-").unwrap_or((&e.target, ""));
            let Some(j) = self.robot.index(to) else { continue };
            let u = robot.joints[j].unit();
            match e.name.as_str() {
                "joint_zero_offset" => q[j] += e.of("offset") * u,
                "axis_coupling" => {
                    if let Some(i) = self.robot.index(source) {
                        q[j] += e.get("ratio") * from[i];
                    }
                }
                "gravity_compliance" => {
                    let f = loads.get_or_insert_with(|| frames(robot, tool, &from));
                    let c = if robot.joints[j].revolute {
                        e.get("compliance_deg_per_nm")
                    } else {
                        e.get("compliance_mm_per_n")
                    };
                    q[j] += c * u * gravity_load(robot, f, j);
                }
                _ => {}
            }
        }
    }

    /// The robot with its wrong lengths and tool.
    fn with_geometry(&self) -> Robot {
        let mut robot = self.robot.clone();
        for e in self.on("link_error") {
            let Some((joint, parameter)) = e.target.rsplit_once('.') else { continue };
            let Some(j) = self.robot.index(joint) else { continue };
            let j = &mut robot.joints[j];
            match parameter {
                "a" => j.a_m += e.get("delta_mm") * 1e-3,
                "d" => j.d_m += e.get("delta_mm") * 1e-3,
                _ => j.alpha_rad += e.get("delta_deg").to_radians(),
            }
        }
        for e in self.on("tool_error") {
            for (k, key) in ["x_mm", "y_mm", "z_mm"].iter().enumerate() {
                robot.tool_xyz_m[k] += e.get(key) * 1e-3;
            }
        }
        robot
    }

    fn tcp(&self, p: &mut Vector3<f64>, t_s: f64) {
        for e in self.on("thermal_drift") {
            let full = Vector3::new(e.get("x_mm"), e.get("y_mm"), e.get("z_mm")) * 1e-3;
            *p += full * (1.0 - (-t_s / e.get("tau_s").max(1e-9)).exp());
        }
        for e in self.on("tracker_frame").filter(|e| t_s >= e.get("t_s")) {
            *p += Vector3::new(e.get("x_um"), e.get("y_um"), e.get("z_um")) * 1e-6;
        }
        for e in self.on("vibration") {
            let d = Vector3::from(e.direction.unwrap_or([1., 0., 0.])).normalize();
            let phase = TAU * e.get("frequency_hz") * t_s + e.get("phase_deg").to_radians();
            *p += d * e.get("amplitude_um") * 1e-6 * phase.sin();
        }
    }
}

/// Steps between two loads.
const LOADS: usize = 25;

/// Torque (Nm or N) of the drive of a joint at a time, as it is logged: it knows nothing of the path.
pub fn torque(joint: usize, t_s: f64) -> f64 {
    let j = joint as f64;
    40.0 * ((0.31 + 0.02 * j) * t_s + j).sin() + 25.0 * ((1.13 - 0.05 * j) * t_s + 2.0 * j).sin()
}

/// Force (N) on the tool at a time, base frame, as it is logged: it knows nothing of the path.
pub fn force(t_s: f64) -> Vector3<f64> {
    let cut = |k: f64| 120.0 * ((0.23 + 0.07 * k) * t_s + k).sin() + 60.0 * ((1.3 - 0.2 * k) * t_s + 2.0 * k).sin();
    Vector3::new(cut(0.0), cut(1.0), 80.0 + cut(2.0))
}

const GEAR: [&str; 7] = [
    "loaded_play",
    "encoder_scale",
    "transmission_error",
    "backlash",
    "backlash_position",
    "backlash_speed",
    "hysteresis",
];

/// A registration from its file numbers (mm, deg).
pub fn registration(xyz_mm: [f64; 3], rpy_deg: [f64; 3]) -> Pose {
    translation(xyz_mm.map(|v| v * 1e-3)) * rpy(rpy_deg.map(f64::to_radians))
}

/// Rms per coordinate of a difference (um), over the rows where `b` stands.
pub fn rms_um(a: &[Vector3<f64>], b: &[Option<Vector3<f64>>]) -> f64 {
    let (sum, n) = a
        .iter()
        .zip(b)
        .filter_map(|(a, b)| b.map(|b| (a - b).norm_squared()))
        .fold((0.0, 0), |s, d| (s.0 + d, s.1 + 3));
    (sum / f64::from(n.max(1))).sqrt() * 1e6
}
