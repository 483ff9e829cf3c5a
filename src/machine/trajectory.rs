//! Commands of all axes, prepared once for running them through servo and gear many times.
//!
//! Per axis: the samples (rows, and what must stand between them: the corners of a program, the turning points of a log),
//! directions and turning points. A movement of at most [`NO_MOVEMENT`] (deg or mm) is the rounding of arithmetic and no
//! reversal; a step of the last written digit is a command and may be one. An axis at rest has one sample.
//!
//! A play after a lagging servo turns where the lagged joint does, between the samples of the command; those points
//! are worked out and added where both stand on one axis ([`crate::effects::EffectType::turning_points`]). A stiction that a lag
//! filters gets finer samples until it comes loose.
//!
//! Parts:
//! - [`samples`]: the samples of one axis, and columns of a log without their gaps.
//! - [`chain`]: the trajectory through the stages of an axis, after its servo and after its gear.

mod chain;
mod samples;

use super::gravity::Gravity;
use super::{grid::Grid, speed, turns};
use crate::effects::{Between, Track, Turn};
use crate::error::{Error, Place, Result, counted};
use crate::log::Log;
use crate::numerics::parallel::ParMap;
use crate::program::Program;
use crate::robot::{Chain, Robot};
use nalgebra::Vector3;
use samples::{at_rest, carried, deadband, force, from_first, measured_torque, with_turning_points};
use std::sync::OnceLock;

/// Movement in the edge unit (deg or mm) up to which nothing has moved.
pub const NO_MOVEMENT: f64 = 1e-9;

/// Rows beyond which a rate is surely a mistake.
const MOST_ROWS: f64 = 5e7;

/// Seconds between two settled poses: long enough for any servo to have worked its error off.
const SETTLED_S: f64 = 1e6;

/// Parts of an interval in which a stuck joint may come loose before a servo lag, and the intervals so divided after a turn at most.
const SUBSAMPLES: u8 = 16;
const MOST_STUCK: usize = 64;

/// Where the samples of an axis stand.
#[derive(Debug, Clone)]
pub(super) enum Samples {
    /// The axis does not move: one sample.
    Rest,
    /// The rows.
    Rows,
    /// The grid of a program.
    Grid { p: Vec<f64> },
    /// The rows and turning points between them; `rows` are the samples that are rows.
    Own { t_s: Vec<f64>, p: Vec<f64>, rows: Vec<u32> },
}

#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) samples: Samples,
    pub(super) dir: Vec<i8>,
    pub(super) turns: Vec<Turn>,
    pub(super) rev: f64,
    /// Movement that counts as none, rad or m.
    pub(super) deadband: f64,
    /// TCP speed at own samples, computed on demand.
    pub(super) speed: OnceLock<Vec<f64>>,
    /// Torque of gravity at own samples, computed on demand.
    pub(super) load: OnceLock<Vec<f64>>,
    /// Direction of the last movement and speed at the rows, computed on demand.
    pub(super) direction: OnceLock<Vec<f64>>,
    pub(super) command_speed: OnceLock<Vec<f64>>,
    /// Cubics between the rows, computed on demand.
    pub(super) cubics: OnceLock<Vec<[f64; 3]>>,
}

/// Commands of all axes over rows: a log's, or those at which a program is sampled.
#[derive(Debug, Clone)]
pub struct CommandTrajectory {
    pub(super) between: Between,
    pub(super) t_s: Vec<f64>,
    /// Times of settled poses, far apart.
    pub(super) spaced_s: Vec<f64>,
    pub(super) cmd: Vec<Vec<f64>>,
    pub(super) grid: Option<Grid>,
    pub(super) axes: Vec<Axis>,
    pub(super) chain: Chain,
    pub(super) gravity: Gravity,
    pub(super) payload_kg: Option<Vec<f64>>,
    pub(super) speed: OnceLock<Vec<f64>>,
    pub(super) torque: OnceLock<Vec<Vec<f64>>>,
    /// Levers of gravity, `[axis * joints + joint]`, computed on demand.
    pub(super) levers: Vec<OnceLock<Vec<[f64; 2]>>>,
    pub(super) overturning: OnceLock<Vec<Vector3<f64>>>,
    /// Logged: torque of the drives by axis, temperature.
    pub(super) measured_torque: Vec<Option<Vec<f64>>>,
    pub(super) temp_c: Option<Vec<f64>>,
    /// Logged force on the tool, N, world frame; its torques about the axes, computed on demand.
    pub(super) force_n: Option<Vec<Vector3<f64>>>,
    pub(super) process_torque: OnceLock<Vec<Vec<f64>>>,
    /// Time over which what was measured at each row is a mean, s.
    pub(super) mean_over_s: f64,
    /// When the first of them began, s; `None`: at the first row.
    pub(super) began_s: Option<f64>,
    pub(super) g_m_s2: Vector3<f64>,
    pub(super) base_m: Vector3<f64>,
}

impl CommandTrajectory {
    /// The rows of a log. Settled poses have no time: what fades in seconds has faded at each of them. Their TCP speed is that
    /// of the column `speed_mm_s`, with which they were reached.
    pub fn of_log(robot: &Robot, log: &Log) -> Self {
        let payload = log.payload_kg.as_ref().map(|p| carried(p));
        let trajectory = Self::of_columns(robot, log.t_s.clone(), log.cmd.clone(), payload, log.poses)
            .with_temperature(log.temp_c.as_ref().map(|t| from_first(t)))
            .with_measured_torque(measured_torque(log))
            .with_force(force(log));
        if let (true, Some(speed)) = (log.poses, &log.speed_m_s) {
            // it has not been needed yet
            let _ = trajectory.speed.set(carried(speed));
        }
        trajectory
    }

    /// The rows of a log with other columns (rad or m) instead of its commands, of which a movement of at most `deadbands[axis]`
    /// is noise.
    pub fn of_log_by(robot: &Robot, log: &Log, columns: Vec<Vec<f64>>, deadbands: &[f64]) -> Self {
        let payload = log.payload_kg.as_ref().map(|p| carried(p));
        Self::of_sensors(robot, log.t_s.clone(), columns, payload, log.poses, deadbands)
            .with_temperature(log.temp_c.as_ref().map(|t| from_first(t)))
            .with_measured_torque(measured_torque(log))
            .with_force(force(log))
    }

    /// Rows given by their columns: times (s, strictly rising; of settled poses any), commands `cmd[axis][row]` (rad or m).
    pub fn of_columns(
        robot: &Robot,
        t_s: Vec<f64>,
        cmd: Vec<Vec<f64>>,
        payload_kg: Option<Vec<f64>>,
        settled_poses: bool,
    ) -> Self {
        let deadbands: Vec<f64> = (0..cmd.len()).map(|axis| deadband(robot, axis)).collect();
        Self::of_sensors(robot, t_s, cmd, payload_kg, settled_poses, &deadbands)
    }

    /// The same for columns that were measured: a movement of at most `deadbands[axis]` (rad or m) is their noise and no reversal.
    pub fn of_sensors(
        robot: &Robot,
        t_s: Vec<f64>,
        cmd: Vec<Vec<f64>>,
        payload_kg: Option<Vec<f64>>,
        settled_poses: bool,
        deadbands: &[f64],
    ) -> Self {
        let deadband = |axis: usize| deadbands.get(axis).copied().unwrap_or(0.0).max(deadband(robot, axis));
        let rows = cmd.first().map_or(0, Vec::len);
        let spaced_s: Vec<f64> =
            if settled_poses { (0..rows).map(|i| i as f64 * SETTLED_S).collect() } else { Vec::new() };
        let times = if settled_poses { &spaced_s } else { &t_s };
        let axes = (0..cmd.len()).par_map(|axis| {
            let p = &cmd[axis];
            let found =
                if settled_poses || at_rest(p) { Vec::new() } else { turns::between_rows(times, p, deadband(axis)) };
            let samples = match found.is_empty() {
                _ if at_rest(p) => Samples::Rest,
                true => Samples::Rows,
                false => with_turning_points(times, p, found),
            };
            Axis::new(robot, axis, samples, times, p, deadband(axis))
        });
        let between = if settled_poses { Between::Settled } else { Between::Smooth };
        Self { t_s, spaced_s, cmd, payload_kg, ..Self::with_axes(robot, between, axes) }
    }

    /// A program whose points stand at `t_s` (one per point, not decreasing), straight in the joints between them, sampled at
    /// `rate_hz` from the first.
    pub fn of_program(robot: &Robot, program: &Program, t_s: &[f64], rate_hz: f64) -> Result<Self> {
        Self::of_program_at(robot, program, t_s, rate_hz, &[])
    }

    /// The same with rows at some of its points, too ([`Self::rows_of_points`]); `at`: which, increasing.
    pub fn of_program_at(robot: &Robot, program: &Program, t_s: &[f64], rate_hz: f64, at: &[usize]) -> Result<Self> {
        let &[first, .., last] = t_s else {
            let found = format!("a program of {}", counted(t_s.len(), "point"));
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
        let grid = Grid::new(t_s, rows as usize, rate_hz, at);
        let (axes, cmd): (Vec<Axis>, Vec<Vec<f64>>) = (0..robot.dof())
            .par_map(|axis| {
                let p = grid.interpolate(t_s, &program.q[axis]);
                let rows: Vec<f64> = grid.keep.iter().map(|&i| p[i as usize]).collect();
                let samples = if at_rest(&p) { Samples::Rest } else { Samples::Grid { p } };
                (Axis::new(robot, axis, samples, &grid.t_s, &rows, deadband(robot, axis)), rows)
            })
            .into_iter()
            .unzip();
        let times = grid.keep.iter().map(|&i| grid.t_s[i as usize]).collect();
        Ok(Self { t_s: times, cmd, grid: Some(grid), ..Self::with_axes(robot, Between::Straight, axes) })
    }

    /// Rows of the requested points, and whether each row stands there for its point alone.
    pub fn rows_of_points(&self) -> &[(usize, bool)] {
        self.grid.as_ref().map_or(&[], |g| &g.points)
    }

    fn with_axes(robot: &Robot, between: Between, axes: Vec<Axis>) -> Self {
        Self {
            between,
            t_s: Vec::new(),
            spaced_s: Vec::new(),
            cmd: Vec::new(),
            grid: None,
            axes,
            chain: robot.chain().clone(),
            gravity: Gravity::new(robot),
            payload_kg: None,
            speed: OnceLock::new(),
            torque: OnceLock::new(),
            levers: vec![OnceLock::new(); robot.dof() * robot.joints.len()],
            overturning: OnceLock::new(),
            measured_torque: Vec::new(),
            temp_c: None,
            force_n: None,
            process_torque: OnceLock::new(),
            mean_over_s: 0.0,
            began_s: None,
            g_m_s2: robot.gravity_m_s2,
            base_m: robot.base.translation.vector,
        }
    }

    /// The same with the torques of the drives as logged, `torque_nm[axis][row]`, Nm or N.
    pub fn with_measured_torque(mut self, torque_nm: Vec<Option<Vec<f64>>>) -> Self {
        self.measured_torque = torque_nm;
        self
    }

    /// The same with the force on the tool, row by row, N, in the robot's world frame.
    pub fn with_force(mut self, force_n: Option<Vec<Vector3<f64>>>) -> Self {
        self.force_n = force_n;
        self
    }

    /// The same for rows that stand for means over this time, of which the first began at `began_s`.
    pub fn with_means_over(mut self, mean_over_s: f64, began_s: f64) -> Self {
        self.mean_over_s = mean_over_s;
        self.began_s = Some(began_s);
        self
    }

    /// When the log began, s: effects count their time from there.
    pub fn began_s(&self) -> f64 {
        self.began_s.or(self.t_s.first().copied()).unwrap_or(0.0)
    }

    /// The same with a temperature, row by row.
    pub fn with_temperature(mut self, temp_c: Option<Vec<f64>>) -> Self {
        self.temp_c = temp_c;
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.cmd.first().map_or(0, Vec::len)
    }

    /// Number of axes.
    pub fn dof(&self) -> usize {
        self.axes.len()
    }

    /// Times of the rows, s; of settled poses what the log has.
    pub fn t_s(&self) -> &[f64] {
        &self.t_s
    }

    /// The rows are settled poses.
    pub fn settled(&self) -> bool {
        self.between == Between::Settled
    }

    /// Command of an axis, row by row, rad or m.
    pub fn command(&self, axis: usize) -> &[f64] {
        &self.cmd[axis]
    }

    /// Commands of one row.
    pub fn command_into(&self, row: usize, q: &mut [f64]) {
        for (v, column) in q.iter_mut().zip(&self.cmd) {
            *v = column[row];
        }
    }

    /// Movement of an axis that counts as none, rad or m.
    pub fn deadband(&self, axis: usize) -> f64 {
        self.axes[axis].deadband
    }

    /// The axis stands still over all rows.
    pub fn is_stationary(&self, axis: usize) -> bool {
        matches!(self.axes[axis].samples, Samples::Rest)
    }

    /// Command of an axis with its directions and turning points; one sample where the axis is stationary.
    pub fn track(&self, axis: usize) -> Track<'_> {
        let a = &self.axes[axis];
        let (t_s, p, rows) = self.samples(axis);
        let mut track = Track::known(t_s, p, &a.dir[..], &a.turns[..]);
        track.between = self.between;
        track.rows = rows;
        track.rev = a.rev;
        track
    }

    /// Times, positions, and which samples are rows (`None`: all; of an axis at rest: it has one sample).
    pub(super) fn samples(&self, axis: usize) -> (&[f64], &[f64], Option<&[u32]>) {
        let clock = self.clock();
        match (&self.axes[axis].samples, &self.grid) {
            (Samples::Rest, _) => (&clock[..clock.len().min(1)], &self.cmd[axis][..self.rows().min(1)], None),
            (Samples::Grid { p }, Some(grid)) => (&grid.t_s, p, Some(&grid.keep)),
            (Samples::Own { t_s, p, rows }, _) => (t_s, p, Some(rows)),
            _ => (clock, &self.cmd[axis], None),
        }
    }

    /// Times by which things fade.
    fn clock(&self) -> &[f64] {
        if self.settled() { &self.spaced_s } else { &self.t_s }
    }

    /// Commanded TCP speed at each row, m/s: the derivative of the commanded TCP, of second order.
    pub fn tcp_speed_m_s(&self) -> &[f64] {
        self.speed.get_or_init(|| match &self.grid {
            _ if self.settled() => vec![0.0; self.rows()],
            Some(grid) => {
                let all = self.grid_speed(grid);
                grid.keep.iter().map(|&i| all[i as usize]).collect()
            }
            None => speed::along(&self.chain, &self.t_s, |axis, i| self.cmd[axis][i]),
        })
    }

    fn grid_speed(&self, grid: &Grid) -> Vec<f64> {
        speed::along(&self.chain, &grid.t_s, |axis, i| match &self.axes[axis].samples {
            Samples::Grid { p } => p[i],
            _ => self.cmd[axis][0],
        })
    }

    /// The same at the samples of an axis.
    fn sample_speed(&self, axis: usize) -> &[f64] {
        let a = &self.axes[axis];
        match (&a.samples, &self.grid) {
            (Samples::Own { t_s, rows, .. }, _) => {
                a.speed.get_or_init(|| speed::between(self.tcp_speed_m_s(), rows, t_s))
            }
            (Samples::Grid { .. }, Some(grid)) => a.speed.get_or_init(|| self.grid_speed(grid)),
            _ => self.tcp_speed_m_s(),
        }
    }

    /// Torque of gravity at the samples of an axis; straight in time between rows.
    fn sample_load(&self, axis: usize) -> &[f64] {
        let (rows, a) = (self.gravity_torque(axis), &self.axes[axis]);
        match (&a.samples, &self.grid) {
            (Samples::Own { t_s, rows: places, .. }, _) => a.load.get_or_init(|| speed::between(rows, places, t_s)),
            (Samples::Grid { .. }, Some(grid)) => a.load.get_or_init(|| speed::between(rows, &grid.keep, &grid.t_s)),
            _ => rows,
        }
    }

    /// Gravity's torque about an axis at the commanded pose of each row, Nm (N for a prismatic one); positive turns it
    /// positive. Zeros where the robot file has no `links`.
    pub fn gravity_torque(&self, axis: usize) -> &[f64] {
        let all = self.torque.get_or_init(|| self.gravity.over(&self.chain, &self.cmd, self.payload_kg.as_deref()));
        &all[axis]
    }

    /// Torque of the logged force on the tool about an axis at the commanded pose of each row, Nm (N for a prismatic one); positive turns
    /// it positive. `None` where no force was logged.
    pub fn process_torque(&self, axis: usize) -> Option<&[f64]> {
        let force_n = self.force_n.as_ref()?;
        let all = self.process_torque.get_or_init(|| {
            let mut all = vec![Vec::with_capacity(force_n.len()); self.dof()];
            let (mut q, mut line) = (vec![0.0; self.dof()], vec![Vector3::zeros(); self.dof()]);
            for (row, force) in force_n.iter().enumerate() {
                self.command_into(row, &mut q);
                self.chain.position_and_jacobian(&q, &mut line);
                // virtual work: what a turn of the axis moves the TCP along the force
                all.iter_mut().zip(&line).for_each(|(t, lever)| t.push(lever.dot(force)));
            }
            all
        });
        all.get(axis).map(Vec::as_slice)
    }

    /// Reversals of an axis: time (s), position, new direction.
    pub fn turns(&self, axis: usize) -> Vec<(f64, f64, i8)> {
        let time = |t: &Turn| {
            if self.settled() { self.t_s.get(t.index).copied().unwrap_or(0.0) } else { t.t_s }
        };
        self.axes[axis].turns.iter().map(|t| (time(t), t.p, t.dir)).collect()
    }
}
