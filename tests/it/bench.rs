//! A bench that makes static tests with the crate's own kinematics: for the plumbing, not for figures.

use crate::support::bundled;
use lostmotion::io::input::{Input, sha256};
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

pub fn robot(name: &str) -> Robot {
    Robot::load(&bundled("configs").join(name)).unwrap()
}

pub fn kuka() -> Robot {
    robot("kuka-kr120-r2500-pro.yaml")
}

pub fn parse(text: &str, robot: &Robot) -> Log {
    let input = Input { name: "log.csv".into(), bytes: text.into(), sha256: sha256(text.as_bytes()) };
    Log::parse(input, robot).unwrap()
}

/// A machine with known gaps and a tracker somewhere.
pub struct Bench {
    pub robot: Robot,
    pub frame: Isometry3<f64>,
    pub noise_m: f64,
    pub rng: ChaCha8Rng,
}

/// One row of a log: commands in rad or m, measured point, where the play stands.
pub struct Row {
    pub cmd: Vec<f64>,
    pub point: Option<Vector3<f64>>,
    pub meas: f64,
    pub dwell: bool,
}

impl Bench {
    pub fn new(robot: Robot, noise_m: f64) -> Self {
        let frame = Isometry3::new(Vector3::new(1.2, -3.4, 0.6), Vector3::new(1.1, -0.4, 2.0));
        Self { robot, frame, noise_m, rng: ChaCha8Rng::seed_from_u64(1) }
    }

    pub fn row(&mut self, cmd: &[f64], axis: usize, error: f64, dwell: bool) -> Row {
        let mut q = cmd.to_vec();
        q[axis] += error;
        let noise = Normal::new(0.0, self.noise_m).unwrap();
        let p = (self.frame * Point3::from(self.robot.tcp_m(&q))).coords;
        let point = Some(p + Vector3::from_fn(|_, _| noise.sample(&mut self.rng)));
        Row { cmd: cmd.to_vec(), point, meas: q[axis], dwell }
    }

    /// The static test of one axis: places and overshoot in rad or m, a gap for each place.
    pub fn rows(
        &mut self,
        axis: usize,
        fixed: &[f64],
        places: &[f64],
        past: f64,
        cycles: usize,
        gap: impl Fn(f64) -> f64,
    ) -> Vec<Row> {
        let mut rows = Vec::new();
        let at = |p: f64| {
            let mut q = fixed.to_vec();
            q[axis] = p;
            q
        };
        for &p in places {
            rows.push(self.row(&at(p - past), axis, 0.0, false));
            for _ in 0..cycles {
                for side in [-1.0, 1.0] {
                    rows.push(self.row(&at(p + side * past), axis, 0.0, false));
                    for _ in 0..10 {
                        rows.push(self.row(&at(p), axis, side * gap(p), true));
                    }
                }
            }
        }
        rows
    }

    /// 10 Hz, no trigger.
    pub fn log(&self, rows: &[Row]) -> Log {
        parse(&self.text(rows, None), &self.robot)
    }

    pub fn text(&self, rows: &[Row], meas: Option<usize>) -> String {
        let mut text = String::from("t_s");
        for j in self.robot.axis_joints() {
            text += &format!(",cmd_{}_{}", j.name, j.kind.unit());
        }
        if let Some(axis) = meas {
            let j = self.robot.axis(axis);
            text += &format!(",meas_{}_{}", j.name, j.kind.unit());
        } else {
            text += ",x_mm,y_mm,z_mm";
        }
        for (i, row) in rows.iter().enumerate() {
            text += &format!("\n{:.1}", 0.1 * i as f64);
            for (j, v) in self.robot.axis_joints().zip(&row.cmd) {
                text += &format!(",{:.6}", j.kind.to_user_unit(*v));
            }
            match (meas, row.point) {
                (Some(axis), _) => text += &format!(",{:.7}", self.robot.axis(axis).kind.to_user_unit(row.meas)),
                (None, Some(p)) => text += &format!(",{:.4},{:.4},{:.4}", p.x * 1e3, p.y * 1e3, p.z * 1e3),
                (None, None) => text += ",,,",
            }
        }
        text + "\n"
    }
}
