//! A log of a problem: what it holds, and its axes at the motor side and after the gear under some effects.

use crate::diagnose::problem::fine::Fine;
use crate::diagnose::problem::orientation::{self, Orientation};
use crate::diagnose::problem::reading::Reading;
use crate::effects::Effect;
use crate::log::Log;
use crate::machine::CommandTrajectory;
use nalgebra::Vector3;
use std::sync::{Arc, OnceLock};

/// One log, prepared.
#[derive(Debug)]
pub struct LogData {
    pub log: Log,
    /// What drives the gears: the commands, or the encoders of the axes that `driven` marks.
    pub trajectory: CommandTrajectory,
    /// The commands, where `trajectory` does not hold them.
    pub commands: Option<CommandTrajectory>,
    /// The commands between the rows of a thinned log.
    pub fine: Option<Fine>,
    /// Axes whose gear is driven by the encoder: servo effects lie before it and show there alone.
    pub driven: Vec<bool>,
    /// Axes whose encoder shows what the servo makes of the command.
    pub motors: Vec<bool>,
    /// Frame (index into [`super::Hypothesis::frames`]) in which its points were measured.
    pub frame: usize,
    /// Rows averaged into one observation.
    pub block: usize,
    /// Rows left out as outliers, per reflector.
    pub left_out: Vec<Vec<bool>>,
    /// Readings of a ballbar or a dial, where the log has no points.
    pub reading: Option<Arc<Reading>>,
    /// Orientations of the tool beside its points.
    pub orientation: Option<Arc<Orientation>>,
    /// Derivatives of the points at the first hypothesis: effects are far too small to change them.
    pub jacobian: OnceLock<Arc<Jacobian>>,
    /// Derivatives of the points by a tilt of each axis, at the first hypothesis that asks for them.
    pub tilts: OnceLock<Arc<Tilts>>,
}

/// Derivatives of points by a tilt of an axis about its x and y, `[reflector][axis][row]`, m/rad.
pub type Tilts = Vec<Vec<Vec<[Vector3<f64>; 2]>>>;

/// Derivatives of points by joints, `[reflector][axis][row]`, m/rad or m/m.
pub type Jacobian = Vec<Vec<Vec<Vector3<f64>>>>;

impl LogData {
    /// Measured point of a reflector in a row, tracker frame.
    pub fn measured(&self, reflector: usize, row: usize) -> Option<Vector3<f64>> {
        let column = if reflector == 0 { &self.log.tcp_m } else { self.log.reflectors_m.get(reflector - 1)? };
        if self.is_left_out(reflector, row) {
            return None;
        }
        column.get(row).copied().flatten()
    }

    /// Is what was measured of a point in a row an outlier?
    pub fn is_left_out(&self, point: usize, row: usize) -> bool {
        self.left_out.get(point).is_some_and(|l| l.get(row).copied().unwrap_or(false))
    }

    /// The commands, which the servo follows.
    pub fn commands(&self) -> &CommandTrajectory {
        self.commands.as_ref().unwrap_or(&self.trajectory)
    }

    /// Is the gear of an axis driven by its encoder?
    pub fn is_driven(&self, axis: usize) -> bool {
        self.driven.get(axis).copied().unwrap_or(false)
    }

    /// After the gear of an axis under some effects, row by row.
    pub(super) fn gear(&self, axis: usize, effects: &[&Effect], initial_gap_side: i8) -> Vec<f64> {
        match &self.fine {
            Some(fine) if self.commands.is_none() && !effects.is_empty() => {
                fine.gear(&self.trajectory, axis, effects, initial_gap_side)
            }
            _ => self.trajectory.gear(axis, effects, initial_gap_side),
        }
    }

    /// Motor side of an axis under some effects, row by row.
    pub(super) fn servo(&self, axis: usize, effects: &[&Effect], initial_gap_side: i8) -> Vec<f64> {
        let commands = self.commands();
        match &self.fine {
            Some(fine) if !effects.is_empty() => fine.servo(commands, axis, effects, initial_gap_side),
            _ => commands.servo(axis, effects, initial_gap_side),
        }
    }

    /// Number of points of the tool that the log tells something of: reflectors with columns, those of an orientation, or the TCP that
    /// a ballbar or a dial reads.
    pub fn reflectors(&self) -> usize {
        match (self.is_tracked(), &self.orientation) {
            (true, None) => 1 + self.log.reflectors_m.len(),
            (_, Some(_)) => orientation::POINTS.end,
            (false, None) => usize::from(self.reading.is_some()),
        }
    }

    /// Whether the coordinates of the TCP were measured.
    pub fn is_tracked(&self) -> bool {
        !self.log.tcp_m.is_empty()
    }
}

impl LogData {
    pub(super) fn copy(&self) -> Self {
        Self {
            log: self.log.clone(),
            trajectory: self.trajectory.clone(),
            commands: self.commands.clone(),
            fine: self.fine.clone(),
            driven: self.driven.clone(),
            motors: self.motors.clone(),
            frame: self.frame,
            block: self.block,
            left_out: self.left_out.clone(),
            reading: self.reading.clone(),
            orientation: self.orientation.clone(),
            jacobian: self.jacobian.clone(),
            tilts: self.tilts.clone(),
        }
    }
}
