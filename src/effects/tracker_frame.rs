//! `tracker_frame`: the tracker's frame steps where its beam was locked again, or creeps.
//!
//! From `t_s` on (or from the row `at_row`, for poses without a clock) every point is moved by `(x, y, z)` and turned by small angles
//! `(rx, ry, rz)` about the tracker's station, in the axes of the base; with `over_s` the movement builds up in proportion over that
//! time. Reference: ISO 10360-10:2021 (two-face and drift tests); Nasr, Forbes, Sun, Lewis (2012), NPL Report ENG 36.
//!
//! Parameters: at most 10 mm and 0.01 rad either way; typical 5 to 50 um. The time of a step is held, not fitted: a diagnosis finds it
//! where the level of what is left jumps (`diagnose::candidates::steps`). It acts in every log, or in the one that `log` names. Action:
//! fix the tripod, wait for the tracker to warm up, measure fixed nests before and after.

use super::common::*;
use super::site::within;
use nalgebra::{UnitQuaternion, Vector3};
use serde_yaml::{Mapping, Value};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "tracker_frame",
    heading: "tracker frame",
    stage: Stage::Measurement,
    family: Family::Tracker,
    acts_on: ActsOn::Log,
    adds: "the tracker's frame jumps or drifts",
    equation: "from t_s on: point translated by (x, y, z) and rotated by (rx, ry, rz) about the station; linearly over over_s",
    reference: "ISO 10360-10:2021",
    parameters: &[
        ("x_um, y_um, z_um", "translation, within 10 mm; coordinates that are left out are 0"),
        ("rx_urad, ry_urad, rz_urad", "rotation about the station, within 10,000 urad"),
        ("t_s or at_row", "time since the first row, or the row, at which the effect begins"),
        ("over_s", "time over which it builds up; without it, a step"),
        ("log", "number of the log in which it acts, from 1; without it, in every log"),
    ],
    confused_with: &["thermal_drift", "thermal_growth"],
    decide_by: "measure a fixed nest before, during and after; a drift of the robot does not move it",
    action: "secure the tripod, let the tracker warm up, register again after a lost beam",
    undone: "nothing: it is an error of the measurement",
    special: Special::NONE,
    example: ("{effect: tracker_frame, x_um: 30, z_um: -20, t_s: 9}", View::TcpOverTime),
    read,
    typical: |size| {
        let mut keys: Vec<(String, Value)> = ["x_um", "y_um", "z_um"].map(|k| (k.into(), 20.0.into())).to_vec();
        if !size.has("t_s") && !size.has("at_row") {
            keys.push(("t_s".into(), (0.5 * size.duration_s).into()));
        }
        keys
    },
    // the place of a step is found by a search: [`step`]
    candidates: |survey, list| {
        if let Some((_, length_s)) = survey.clock.filter(|_| survey.points) {
            list.push(drift(survey.robot, length_s));
        }
    },
};

/// From where on it acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum From {
    /// s since the first row.
    Time(f64),
    /// Number of the row.
    Row(f64),
}

/// Movement in m, turn in rad; from when, over which time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerFrame {
    /// Movement of the tracker's frame, m.
    pub translation_m: Vector3<f64>,
    /// Rotation of the tracker's frame, rad.
    pub rotation_rad: Vector3<f64>,
    /// The turn is a parameter of a fit.
    pub turns: bool,
    /// From when on it acts.
    pub from: From,
    /// Time over which it grows, s; `None`: a step.
    pub over_s: Option<f64>,
    /// The one log in which it acts, from 0; `None`: in all.
    pub only_log: Option<usize>,
}

const UM: [&str; 3] = ["x_um", "y_um", "z_um"];
const URAD: [&str; 3] = ["rx_urad", "ry_urad", "rz_urad"];

fn read(f: &mut Fields) -> Result<Effect> {
    let vector = |f: &mut Fields, keys: [&str; 3]| -> Result<(Vector3<f64>, bool)> {
        let (mut v, mut any) = (Vector3::zeros(), false);
        for (c, key) in v.iter_mut().zip(keys) {
            if let Some(x) = f.number(key, f64::NEG_INFINITY)? {
                *c = x * 1e-6;
                any = true;
            }
        }
        Ok((v, any))
    };
    let (translation_m, moves) = vector(f, UM)?;
    let (rotation_rad, turns) = vector(f, URAD)?;
    if !moves && !turns {
        return Err(f.bad(
            "x_um",
            "no movement and no turn",
            "`x_um`, `y_um`, `z_um`, `rx_urad`, `ry_urad` or `rz_urad`",
        ));
    }
    let from = match (f.number("t_s", 0.0)?, f.number("at_row", 0.0)?) {
        (Some(t), None) => From::Time(t),
        (None, Some(row)) => From::Row(row),
        _ => return Err(f.bad("t_s", "no time, or two", "either `t_s` or `at_row`")),
    };
    let over_s = f.number("over_s", f64::MIN_POSITIVE)?;
    let only_log = f.number("log", 1.0)?.map(|log| log as usize - 1);
    Ok(TrackerFrame { translation_m, rotation_rad, turns, from, over_s, only_log }.into())
}

/// A step of the frame in one log, at a time or row.
pub fn step(robot: &crate::robot::Robot, from: From, log: usize) -> Candidate {
    Candidate::of_vector(robot, Target::Log, 1e-6, move |translation_m| TrackerFrame {
        translation_m,
        rotation_rad: Vector3::zeros(),
        turns: false,
        from,
        over_s: None,
        only_log: Some(log),
    })
    .with_shape(1)
}

/// Drift of the frame over the whole of the longest log: three movements and three rotations.
fn drift(robot: &crate::robot::Robot, length_s: f64) -> Candidate {
    Candidate::of_sizes(robot, Target::Log, &[1e-6; 6], move |c| TrackerFrame {
        rotation_rad: Vector3::new(c[3], c[4], c[5]),
        turns: true,
        ..TrackerFrame::moving(Vector3::new(c[0], c[1], c[2]), length_s)
    })
    .with_form("drift")
}

impl TrackerFrame {
    /// Movement in proportion to time, which ends at `translation_m` after `length_s`.
    pub fn moving(translation_m: Vector3<f64>, length_s: f64) -> Self {
        let rotation_rad = Vector3::zeros();
        Self {
            translation_m,
            rotation_rad,
            turns: false,
            from: From::Time(0.0),
            over_s: Some(length_s),
            only_log: None,
        }
    }

    /// What it does and from when on, in words.
    pub fn describe(&self) -> String {
        let does = if self.over_s.is_none() { "jumps" } else { "drifts" };
        format!("{}: the frame of the tracker {does}", self.when())
    }

    /// From when on it acts, and in which log.
    pub fn when(&self) -> String {
        let log = self.only_log.map_or(String::new(), |log| format!(" in log {}", log + 1));
        let from = match self.from {
            From::Time(t) => format!("{t:.2} s"),
            From::Row(row) => format!("row {}", row as usize + 1),
        };
        match self.over_s {
            None => format!("from {from} on{log}"),
            Some(over) => format!("from {from} on, over {over:.0} s{log}"),
        }
    }
}

impl EffectType for TrackerFrame {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    /// Movement, then the turn where it has one.
    fn values(&self) -> Vec<f64> {
        let turn = self.rotation_rad.iter().filter(|_| self.turns);
        self.translation_m.iter().chain(turn).copied().collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let rotation_rad = if self.turns { Vector3::new(v[3], v[4], v[5]) } else { self.rotation_rad };
        Self { translation_m: Vector3::new(v[0], v[1], v[2]), rotation_rad, ..*self }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let moves = UM.map(|key| Parameter::new(key, 1e6, within(0.01), 20e-6));
        let turns = URAD.map(|key| Parameter::new(key, 1e6, within(0.01), 10e-6));
        moves.into_iter().chain(turns.into_iter().filter(|_| self.turns)).collect()
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        for (p, v) in self.parameters(site).into_iter().zip(self.values()) {
            entry.insert(p.key.into(), (v * p.user_units_per_si).into());
        }
        let (key, value) = match self.from {
            From::Time(t) => ("t_s", t),
            From::Row(row) => ("at_row", row),
        };
        entry.insert(key.into(), value.into());
        if let Some(over) = self.over_s {
            entry.insert("over_s".into(), over.into());
        }
        if let Some(log) = self.only_log {
            entry.insert("log".into(), (log + 1).into());
        }
    }

    fn in_log(&self, log: usize) -> Option<Effect> {
        let elsewhere = self.only_log.is_some_and(|own| own != log);
        elsewhere.then(|| Self { translation_m: Vector3::zeros(), rotation_rad: Vector3::zeros(), ..*self }.into())
    }

    /// What happened while one log was recorded does not happen in the next.
    fn of_its_logs_alone(&self) -> bool {
        self.only_log.is_some()
    }

    fn displacement_m(&self, _target: Target, row: &Row, point_m: &Vector3<f64>) -> Vector3<f64> {
        let share = match (self.from, self.over_s) {
            (From::Row(at), _) => f64::from(row.index as f64 >= at),
            (From::Time(t), Some(over)) => ((row.measured_s - t) / over).clamp(0.0, 1.0),
            (From::Time(t), None) => f64::from(row.measured_s >= t),
        };
        if share == 0.0 {
            return Vector3::zeros();
        }
        let arm = point_m - row.station_m;
        let turned = UnitQuaternion::from_scaled_axis(self.rotation_rad * share) * arm - arm;
        turned + self.translation_m * share
    }

    fn displaces(&self) -> bool {
        true
    }

    fn magnitude(&self) -> f64 {
        self.translation_m.amax()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is an error of the measurement")
    }
}
