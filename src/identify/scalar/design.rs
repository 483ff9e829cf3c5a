//! Readings of a log and the columns that explain them.

use crate::effects::{Backlash, Decay, Effect, Stiction};
use crate::identify::machine::readings::Readings;
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::machine::{CommandTrajectory, slopes};
use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;

/// Prior standard deviations: spike (deg, 0.1 mm), lag (s), zero offset (deg, 0.1 mm), nuisance of the instrument (m, rad).
pub const SPIKE: f64 = 0.01;
pub const LAG_S: f64 = 0.02;
pub const ZERO: f64 = 0.1;
pub const INSTRUMENT: f64 = 0.5;
/// The same of the scale of a joint sensor.
const SCALE: f64 = 1e-3;
/// Prior standard deviation of the centre of a ballbar that tells differences to its length, about the centre of the commanded
/// circle, m. Across the plane of the circle such readings hardly see the centre, and a ballbar is set up to some millimetres.
const SET_UP_M: f64 = 5e-3;
/// Decay of the spike, s: a column of this pace takes up what is faster or slower well enough.
const DECAY_S: f64 = 1.5;
/// Size at which the play's column is taken at first: rad, m.
const START: [f64; 2] = [2e-5, 2e-6];

/// What a column stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Gap,
    Spike,
    Lag,
    Zero,
    /// Number `axis` of the instrument's own, of a log.
    Instrument {
        log: usize,
    },
}

/// The columns of a fit.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    pub columns: Vec<(Kind, usize)>,
    /// Prior standard deviation of each; infinite: free.
    pub priors: Vec<f64>,
}

impl Layout {
    pub fn new(robot: &Robot, tracks: &[Track], reversing: &[usize]) -> Self {
        let mut layout = Self::default();
        let mut add = |kind: Kind, axis: usize, prior: f64| {
            layout.columns.push((kind, axis));
            layout.priors.push(prior);
        };
        for &a in reversing {
            add(Kind::Gap, a, f64::INFINITY);
            add(Kind::Spike, a, SPIKE * prior_unit(robot.axis(a).kind));
        }
        for a in (0..robot.dof()).filter(|a| tracks.iter().any(|t| t.moves(*a))) {
            add(Kind::Lag, a, LAG_S);
            add(Kind::Zero, a, ZERO * prior_unit(robot.axis(a).kind));
        }
        for (log, track) in tracks.iter().enumerate() {
            for n in track.own() {
                add(Kind::Instrument { log }, n, track.own_prior(n));
            }
        }
        layout
    }

    pub fn place(&self, kind: Kind, axis: usize) -> Option<usize> {
        self.columns.iter().position(|c| *c == (kind, axis))
    }
}

/// Unit of the priors: a degree, or 0.1 mm.
pub(crate) fn prior_unit(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => kind.si_per_user_unit(),
        JointKind::Prismatic => 0.1 * kind.si_per_user_unit(),
    }
}

/// A log with its readings.
pub struct Track {
    pub instrument: Instrument,
    /// Rows with a reading.
    pub rows: Vec<usize>,
    pub readings: Vec<f64>,
    /// Whole distances, not differences.
    pub whole: bool,
    /// The centre of a ballbar is fitted.
    free_centre: bool,
    /// How far the centre has been moved from where it was looked for first.
    moved_m: Vector3<f64>,
    /// Metres at the TCP of a unit of a joint sensor (rad, m).
    lever: f64,
    trajectory: CommandTrajectory,
    speeds: Vec<Vec<f64>>,
    turns: Vec<usize>,
}

impl Track {
    pub fn new(robot: &Robot, log: &Log, instrument: Instrument, free_centre: bool) -> Self {
        let trajectory = CommandTrajectory::of_log(robot, log);
        let (lever, column) = match instrument {
            Instrument::Joint { axis } => {
                let readings = Readings::of_sensor(robot, log, axis);
                let lever = readings.map_or(1.0, |r| r.lever);
                (lever, sensed(log, axis, lever))
            }
            _ => (1.0, log.instruments.scalar().unwrap_or_default().to_vec()),
        };
        let (rows, readings) = column.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?))).unzip();
        let speeds = (0..robot.dof()).map(|a| slopes(trajectory.t_s(), trajectory.command(a))).collect();
        let turns = (0..robot.dof()).map(|a| trajectory.turns(a).len()).collect();
        Self {
            instrument,
            rows,
            readings,
            whole: log.instruments.distance_m.is_some(),
            free_centre,
            moved_m: Vector3::zeros(),
            lever,
            trajectory,
            speeds,
            turns,
        }
    }

    pub fn reverses(&self, axis: usize) -> bool {
        self.sees(axis) && self.turns[axis] > 0
    }

    pub fn moves(&self, axis: usize) -> bool {
        self.sees(axis) && !self.trajectory.is_stationary(axis)
    }

    /// Whether the readings can change with an axis: a joint sensor sees its own joint alone.
    fn sees(&self, axis: usize) -> bool {
        !matches!(self.instrument, Instrument::Joint { axis: sensed } if sensed != axis)
    }

    /// Numbers of the instrument's own parameters that are fitted.
    pub fn own(&self) -> Vec<usize> {
        match self.instrument {
            Instrument::Distance { .. } if self.whole => (0..if self.free_centre { 3 } else { 0 }).collect(),
            Instrument::Distance { .. } => (if self.free_centre { 0 } else { 3 }..4).collect(),
            Instrument::Joint { .. } => vec![0, 1],
            _ => (0..3).collect(),
        }
    }

    /// Prior standard deviation of such a parameter.
    fn own_prior(&self, n: usize) -> f64 {
        match self.instrument {
            Instrument::Distance { .. } if !self.whole && n < 3 => SET_UP_M,
            Instrument::Joint { .. } if n == 1 => SCALE,
            _ => INSTRUMENT,
        }
    }

    /// Value about which the prior of a parameter of the instrument stands: what is left of it since the centre has moved.
    pub fn own_about(&self, n: usize) -> f64 {
        if self.free_centre && n < 3 { -self.moved_m[n] } else { 0.0 }
    }

    /// Joint errors row by row of a unit of a joint effect.
    fn shape(&self, axis: usize, effect: &Effect, size: f64) -> Vec<f64> {
        let out = self.trajectory.gear(axis, &[effect], 0);
        let command = self.trajectory.command(axis);
        self.rows.iter().map(|&r| (out[r] - command[r]) / size).collect()
    }

    /// Reading without any error, and the columns, one value per row, for the parameters as they are now.
    pub fn design(&self, robot: &Robot, layout: &Layout, log: usize, values: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let dof = robot.dof();
        let n = self.rows.len();
        let (mut readings, mut own) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut sensitivity = vec![Vec::with_capacity(n); dof];
        let (mut q, mut columns) = (vec![0.0; dof], vec![Vector3::zeros(); dof]);
        for &row in &self.rows {
            self.trajectory.command_into(row, &mut q);
            let p = robot.chain().position_and_jacobian(&q, &mut columns);
            if let Instrument::Joint { axis } = self.instrument {
                // the zero of the sensor, and its scale
                own.push(vec![[1.0, 0.0, 0.0], [self.lever * q[axis], 0.0, 0.0]]);
                readings.push(self.lever * q[axis]);
                (0..dof).for_each(|a| sensitivity[a].push(if a == axis { self.lever } else { 0.0 }));
                continue;
            }
            own.push(self.instrument.nuisances(&p));
            readings.push(self.instrument.reading(&p).unwrap_or(0.0));
            for (s, c) in sensitivity.iter_mut().zip(&columns) {
                s.push(self.instrument.sensitivity(&p, c)[0]);
            }
        }
        let design = layout
            .columns
            .iter()
            .zip(values)
            .map(|((kind, axis), value)| match kind {
                Kind::Instrument { log: of } if *of == log => own.iter().map(|o| o[*axis][0]).collect(),
                Kind::Instrument { .. } => vec![0.0; n],
                _ => {
                    let shape = self.joint_shape(robot, *kind, *axis, *value);
                    shape.iter().zip(&sensitivity[*axis]).map(|(a, b)| a * b).collect()
                }
            })
            .collect();
        (readings, design)
    }

    fn joint_shape(&self, robot: &Robot, kind: Kind, axis: usize, value: f64) -> Vec<f64> {
        let start = START[usize::from(robot.axis(axis).kind == JointKind::Prismatic)];
        let size = value.abs().max(start);
        match kind {
            Kind::Gap => self.shape(axis, &Backlash::constant(size).into(), size),
            Kind::Spike => self.shape(axis, &Stiction { spike: size, decay: Decay::Time(DECAY_S) }.into(), size),
            Kind::Lag => self.rows.iter().map(|&r| -self.speeds[axis][r]).collect(),
            Kind::Zero | Kind::Instrument { .. } => vec![1.0; self.rows.len()],
        }
    }

    /// Moves the centre of a ballbar by what was found, and takes it out of the parameters.
    pub fn take_centre(&mut self, layout: &Layout, log: usize, values: &mut [f64]) {
        let Instrument::Distance { centre_m } = &mut self.instrument else { return };
        if !self.free_centre {
            return;
        }
        for axis in 0..3 {
            if let Some(k) = layout.place(Kind::Instrument { log }, axis) {
                centre_m[axis] += values[k];
                self.moved_m[axis] += values[k];
                values[k] = 0.0;
            }
        }
    }
}

/// Readings of a joint sensor at a lever, m, about the commands: its zero is not known.
fn sensed(log: &Log, axis: usize, lever: f64) -> Vec<Option<f64>> {
    let Some(Some(column)) = log.meas.get(axis) else { return Vec::new() };
    let off: Vec<f64> = column.iter().zip(&log.cmd[axis]).filter_map(|(m, c)| Some((*m)? - c)).collect();
    let zero = off.iter().sum::<f64>() / off.len().max(1) as f64;
    column.iter().map(|m| m.map(|m| lever * (m - zero))).collect()
}
