//! Command tracks to joint positions behind the gears.
//!
//! The track of an axis holds every program point and every row. A movement of at most [`NO_MOVEMENT`] (deg or mm) is the
//! rounding of arithmetic and no reversal; a step of the last written digit is a command and may be one. Axes are
//! independent, so they run in parallel.

use super::turns;
use crate::effect::{Stage, Track, joint_output};
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::model::Model;
use crate::program::Program;
use rayon::prelude::*;

/// Movement in the edge unit (deg or mm) up to which nothing has moved.
const NO_MOVEMENT: f64 = 1e-9;

/// Rows beyond which a rate is surely a mistake.
const MOST_ROWS: f64 = 5e7;

/// Seconds between two settled poses: long enough for any servo to have worked its error off.
const SETTLED_S: f64 = 1e6;

/// Values of an axis over the rows, rad or m.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// The axis does not move.
    Constant(f64),
    Rows(Vec<f64>),
}

impl Column {
    /// Value of a row.
    #[inline]
    pub fn at(&self, row: usize) -> f64 {
        match self {
            Self::Constant(v) => *v,
            Self::Rows(v) => v[row],
        }
    }
}

/// What the machine does at the rows of the log.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Time of each row, s.
    pub t_s: Vec<f64>,
    pub cmd: Vec<Column>,
    /// Motor side; empty where it was not asked for.
    pub servo: Vec<Column>,
    /// Behind the gear.
    pub joint: Vec<Column>,
}

impl Motion {
    /// Runs a program whose points stand at `t_s` (one per point, not decreasing), sampled at `rate_hz` from the first.
    pub fn of_program(model: &Model, program: &Program, t_s: &[f64], rate_hz: f64, servo: bool) -> Result<Self> {
        let &[first, .., last] = t_s else {
            let found = format!("a program of {} points", t_s.len());
            return Err(Error::bad(Place::file(&program.name), found, "at least two points"));
        };
        let duration = last - first;
        let rows = (duration * rate_hz).floor() + 1.0;
        if !rows.is_finite() || rows > MOST_ROWS {
            return Err(Error::bad(
                Place::file(&program.name),
                format!("{rows:.0} rows: {duration:.3} s at {rate_hz} Hz"),
                format!("at most {MOST_ROWS:.0} rows; a lower rate, or a higher speed"),
            ));
        }
        let grid = Grid::new(t_s, rows as usize, rate_hz);
        let axes = (0..model.robot.dof())
            .into_par_iter()
            .map(|axis| {
                let p = grid.interpolate(t_s, &program.q[axis]);
                drive(model, axis, &grid.t_s, &p, Some(&grid.keep), servo)
            })
            .collect();
        let times = grid.keep.iter().map(|&i| grid.t_s[i as usize]).collect();
        Ok(Self::collect(times, axes))
    }

    /// Runs the rows of a log. Settled poses have no time: what decays in seconds has decayed at each of them.
    pub fn of_log(model: &Model, log: &Log, servo: bool) -> Self {
        let spaced: Vec<f64>;
        let times = if log.poses {
            spaced = (0..log.len()).map(|i| i as f64 * SETTLED_S).collect();
            &spaced
        } else {
            &log.t_s
        };
        let axes = (0..model.robot.dof())
            .into_par_iter()
            .map(|axis| {
                let cmd = &log.cmd[axis];
                let found = if log.poses { Vec::new() } else { turns::between_rows(times, cmd, deadband(model, axis)) };
                if found.is_empty() {
                    return drive(model, axis, times, cmd, None, servo);
                }
                let (mut t_s, mut p, mut keep) = (Vec::new(), Vec::new(), Vec::new());
                let mut next = found.into_iter().peekable();
                for (row, (&t, &q)) in times.iter().zip(cmd).enumerate() {
                    keep.push(t_s.len() as u32);
                    t_s.push(t);
                    p.push(q);
                    while let Some((_, t, q)) = next.next_if(|turn| turn.0 == row) {
                        t_s.push(t);
                        p.push(q);
                    }
                }
                drive(model, axis, &t_s, &p, Some(&keep), servo)
            })
            .collect();
        Self::collect(log.t_s.clone(), axes)
    }

    fn collect(t_s: Vec<f64>, axes: Vec<Driven>) -> Self {
        let mut motion = Self { t_s, cmd: Vec::new(), servo: Vec::new(), joint: Vec::new() };
        for axis in axes {
            motion.cmd.push(axis.cmd);
            motion.servo.extend(axis.servo);
            motion.joint.push(axis.joint);
        }
        motion
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Joint positions behind the gears in a row.
    pub fn joint_into(&self, row: usize, q: &mut [f64]) {
        for (v, column) in q.iter_mut().zip(&self.joint) {
            *v = column.at(row);
        }
    }
}

/// Movement that is none, rad or m.
fn deadband(model: &Model, axis: usize) -> f64 {
    NO_MOVEMENT * model.robot.axis(axis).kind.si()
}

struct Driven {
    cmd: Column,
    servo: Option<Column>,
    joint: Column,
}

/// One axis: command track to the values at `keep` (all samples where `None`).
fn drive(model: &Model, axis: usize, t_s: &[f64], p: &[f64], keep: Option<&[u32]>, servo: bool) -> Driven {
    // an axis at rest needs one sample
    let n = if p.windows(2).all(|w| w[0] == w[1]) { p.len().min(1) } else { p.len() };
    let (t_s, p) = (&t_s[..n], &p[..n]);
    let column = |values: Vec<f64>| match (n, keep) {
        (0 | 1, _) => Column::Constant(values.first().copied().unwrap_or(0.0)),
        (_, Some(keep)) => Column::Rows(keep.iter().map(|&i| values[i as usize]).collect()),
        (_, None) => Column::Rows(values),
    };
    let track = Track::new(t_s, p, deadband(model, axis)).with_preload(model.preload[axis]);
    let servo =
        servo.then(|| column(joint_output(&track, model.effects_on(axis).filter(|e| e.stage() == Stage::Servo))));
    Driven { cmd: column(p.to_vec()), servo, joint: column(model.joint_output(axis, &track)) }
}

/// All program points and all rows in the order of time.
struct Grid {
    t_s: Vec<f64>,
    /// Program point at or before each grid time; its segment.
    segment: Vec<u32>,
    /// Grid index of each row.
    keep: Vec<u32>,
}

impl Grid {
    fn new(points_t_s: &[f64], rows: usize, rate_hz: f64) -> Self {
        let n = points_t_s.len() + rows;
        let mut grid =
            Self { t_s: Vec::with_capacity(n), segment: Vec::with_capacity(n), keep: Vec::with_capacity(rows) };
        let first = points_t_s[0];
        let row_time = |k: usize| first + k as f64 / rate_hz;
        let mut row = 0;
        for (i, &t) in points_t_s.iter().enumerate() {
            while row < rows && row_time(row) < t {
                grid.keep.push(grid.t_s.len() as u32);
                grid.t_s.push(row_time(row));
                grid.segment.push(i.saturating_sub(1) as u32);
                row += 1;
            }
            while row < rows && row_time(row) == t {
                grid.keep.push(grid.t_s.len() as u32);
                row += 1;
            }
            grid.t_s.push(t);
            grid.segment.push(i as u32);
        }
        // a last row that rounding puts behind the last point stands on it
        while row < rows {
            grid.keep.push(grid.t_s.len() as u32 - 1);
            row += 1;
        }
        grid
    }

    /// A command over the grid, linear between points.
    fn interpolate(&self, points_t_s: &[f64], q: &[f64]) -> Vec<f64> {
        let at = |(&t, &segment): (&f64, &u32)| {
            let i = segment as usize;
            let (t0, q0) = (points_t_s[i], q[i]);
            match q.get(i + 1) {
                Some(&q1) if t > t0 => q0 + (q1 - q0) * ((t - t0) / (points_t_s[i + 1] - t0)),
                _ => q0,
            }
        };
        self.t_s.iter().zip(&self.segment).map(at).collect()
    }
}
