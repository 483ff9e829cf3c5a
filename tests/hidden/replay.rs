//! A case in a folder, run again on our physics from the commands of its logs.

use crate::case::Log;
use crate::effects::Effect;
use crate::files;
use crate::kinematics::{Pose, apply, rigid_fit};
use crate::physics::{Grid, Machine, Pchip, STEP_S, registration, rms_um};
use crate::robots::Robot;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::{Path, PathBuf};

pub struct Folder {
    pub path: PathBuf,
    pub robot: Robot,
    pub truth: Value,
    pub frame: Pose,
    pub given: bool,
    pub known: Vec<Effect>,
    pub effects: Vec<Effect>,
}

impl Folder {
    pub fn read(path: &Path) -> Folder {
        let truth = files::read_truth(path);
        let three = |key: &str| [0, 1, 2].map(|k| truth["registration"][key][k].as_f64().unwrap_or(0.0));
        let list = |key: &str| truth[key].as_array().map(|a| a.iter().map(Effect::parse).collect()).unwrap_or_default();
        Folder {
            path: path.into(),
            robot: files::read_robot(path),
            frame: registration(three("xyz_mm"), three("rpy_deg")),
            given: truth["registration_given"].as_bool().unwrap_or(true),
            known: list("known_effects"),
            effects: list("effects"),
            truth,
        }
    }

    pub fn log(&self, name: &str) -> Replay {
        Replay::new(&self.robot, files::read_log(&self.path.join(name), &self.robot))
    }

    /// TCP at the rows of a log (m), with the known effects and these.
    pub fn predict(&self, log: &Replay, effects: &[Effect]) -> Vec<Vector3<f64>> {
        let effects = self.known.iter().chain(effects).cloned().collect();
        Machine { robot: &self.robot, registration: self.frame, effects, outside: vec![] }.run(&log.grid, &log.rows)
    }

    /// Rms of a gap per coordinate (um), after the best rigid fit where the frame is not given.
    pub fn gap_um(&self, from: &[Vector3<f64>], to: &[Option<Vector3<f64>>]) -> f64 {
        let fit = if self.given { Pose::identity() } else { rigid_fit(from, to) };
        let moved: Vec<_> = from.iter().map(|p| apply(&fit, p)).collect();
        rms_um(&moved, to)
    }
}

/// A log with its commands as courses on the fine grid: cubics between the rows, as the path itself is not there.
pub struct Replay {
    pub log: Log,
    pub grid: Grid,
    pub rows: Vec<usize>,
    pub measured: Vec<Option<Vector3<f64>>>,
}

impl Replay {
    pub fn new(robot: &Robot, log: Log) -> Replay {
        let rows: Vec<usize> = log.t_s.iter().map(|t| ((t - log.t_s[0]) / STEP_S).round() as usize).collect();
        let steps = rows.last().map_or(0, |k| k + 100);
        let joints = robot
            .joints
            .iter()
            .enumerate()
            .map(|(j, joint)| {
                let knots: Vec<[f64; 2]> =
                    rows.iter().zip(&log.cmd).map(|(k, c)| [*k as f64, c[j] * joint.unit()]).collect();
                let curve = Pchip::through_rows(&knots);
                (0..steps).map(|k| curve.at(k as f64)).collect()
            })
            .collect();
        let measured = log.tcp_mm.iter().map(|p| p.map(|p| Vector3::from(p) * 1e-3)).collect();
        Replay { grid: Grid::new(joints), rows, measured, log }
    }
}

/// Rows whose gap is no outlier: within 6 robust standard deviations.
pub fn without_outliers(predicted: &[Vector3<f64>], measured: &[Option<Vector3<f64>>]) -> Vec<Option<Vector3<f64>>> {
    let mut sizes: Vec<f64> = predicted.iter().zip(measured).filter_map(|(a, b)| b.map(|b| (a - b).norm())).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = 4.0 * sizes.get(sizes.len() / 2).copied().unwrap_or(f64::MAX);
    predicted.iter().zip(measured).map(|(a, b)| b.filter(|b| (a - b).norm() < limit)).collect()
}
