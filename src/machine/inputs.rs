//! What effects look at that act row by row: commands, torques, levers, times, directions, each computed on demand.

use super::gravity::levers;
use super::trajectory::{CommandTrajectory, NO_MOVEMENT};
use super::turns;
use crate::effects::{Inputs, Track};
use nalgebra::Vector3;
use std::borrow::Cow;

impl Inputs for CommandTrajectory {
    fn mean_over_s(&self) -> f64 {
        self.mean_over_s
    }

    fn command(&self, axis: usize) -> &[f64] {
        CommandTrajectory::command(self, axis)
    }

    fn gravity_torque(&self, axis: usize) -> &[f64] {
        CommandTrajectory::gravity_torque(self, axis)
    }

    fn gravity_levers(&self, axis: usize, joint: usize) -> Cow<'_, [[f64; 2]]> {
        let joints = self.levers.len() / self.dof().max(1);
        let Some(known) = self.levers.get(axis * joints + joint) else { return Cow::Borrowed(&[]) };
        let of_row = |row: usize| {
            let (mut q, mut frames) = (vec![0.0; self.dof()], Vec::new());
            self.command_into(row, &mut q);
            levers(&self.chain, &self.g_m_s2, &q, axis, joint, &mut frames)
        };
        // row by row: a thread of the pool that waits in here would take up work that waits for this very value
        known.get_or_init(|| (0..self.rows()).map(of_row).collect()).as_slice().into()
    }

    fn measured_torque(&self, axis: usize) -> Option<&[f64]> {
        self.measured_torque.get(axis)?.as_deref()
    }

    fn process_torque(&self, axis: usize) -> Option<&[f64]> {
        CommandTrajectory::process_torque(self, axis)
    }

    fn t_s(&self) -> &[f64] {
        if self.settled() { &[] } else { &self.t_s }
    }

    fn temp_c(&self) -> Option<&[f64]> {
        self.temp_c.as_deref()
    }

    fn direction(&self, axis: usize) -> &[f64] {
        self.axes[axis].direction.get_or_init(|| {
            if self.is_stationary(axis) {
                return vec![0.0; self.rows()];
            }
            let (dir, rows) = (&self.axes[axis].dir, self.samples(axis).2);
            match rows {
                Some(rows) => rows.iter().map(|&r| f64::from(dir[r as usize])).collect(),
                None => dir.iter().map(|&d| f64::from(d)).collect(),
            }
        })
    }

    fn speed(&self, axis: usize) -> &[f64] {
        self.axes[axis].command_speed.get_or_init(|| match self.settled() {
            true => vec![0.0; self.rows()],
            false => {
                let track = Track::known(&self.t_s, &self.cmd[axis], &[][..], &[][..]);
                (0..self.rows()).map(|row| track.speed_at(row)).collect()
            }
        })
    }

    fn overturning(&self, row: usize) -> (Vector3<f64>, Vector3<f64>) {
        let origin = self.base_m;
        let of_row = |row: usize| {
            let mut q = vec![0.0; self.dof()];
            self.command_into(row, &mut q);
            let payload = self.payload_kg.as_deref().and_then(|p| p.get(row)).copied().unwrap_or(0.0);
            self.gravity.moment_about(&self.chain, &q, payload, &origin)
        };
        let all = self.overturning.get_or_init(|| (0..self.rows()).map(of_row).collect());
        (all.get(row).copied().unwrap_or_default(), origin)
    }

    fn rev(&self, axis: usize) -> f64 {
        self.axes[axis].rev
    }

    fn turning_points(&self, series: &[f64]) -> Vec<(usize, f64, f64)> {
        match self.settled() {
            true => Vec::new(),
            false => turns::between_rows(&self.t_s, series, 1e-3 * NO_MOVEMENT),
        }
    }
}
