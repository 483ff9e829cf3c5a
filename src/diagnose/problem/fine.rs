//! Commands between the rows of a thinned log: what moves a joint is averaged over a run as its measurement is.
//!
//! A gap remembers where it was last, and what it lets through is no mean of the rows: at one place of a run it is crossed, at the
//! next it is not. Computed at several places of every run and averaged, it is what the mean of the measured rows shows.

use crate::effects::Effect;
use crate::machine::CommandTrajectory;

/// Commands of a log at several places of each run of rows that one row of the thinned log stands for.
#[derive(Debug, Clone)]
pub struct Fine {
    trajectory: CommandTrajectory,
    /// First place of each run, and one after the last.
    starts: Vec<u32>,
    /// Rows that each place stands for.
    weights: Vec<f64>,
    /// When the log began, s.
    began_s: f64,
}

impl Fine {
    pub fn new(trajectory: CommandTrajectory, starts: Vec<u32>, weights: Vec<f64>, began_s: f64) -> Self {
        Self { trajectory, starts, weights, began_s }
    }

    /// The commands of the thinned log, which know that they stand for means.
    pub fn marked_as_means(&self, coarse: CommandTrajectory) -> CommandTrajectory {
        match coarse.t_s() {
            [first, .., last] => {
                let mean_over_s = (last - first) / (coarse.rows() - 1) as f64;
                coarse.with_means_over(mean_over_s, self.began_s)
            }
            _ => coarse,
        }
    }

    /// After the gear of an axis: the commands of the thinned log (`coarse`) and the mean of what the effects add over each run.
    pub fn gear(&self, coarse: &CommandTrajectory, axis: usize, effects: &[&Effect], initial_gap_side: i8) -> Vec<f64> {
        self.averaged(coarse.command(axis), axis, &self.trajectory.gear(axis, effects, initial_gap_side))
    }

    /// The same for the motor side.
    pub fn servo(
        &self,
        coarse: &CommandTrajectory,
        axis: usize,
        effects: &[&Effect],
        initial_gap_side: i8,
    ) -> Vec<f64> {
        self.averaged(coarse.command(axis), axis, &self.trajectory.servo(axis, effects, initial_gap_side))
    }

    fn averaged(&self, coarse: &[f64], axis: usize, fine: &[f64]) -> Vec<f64> {
        let commands = self.trajectory.command(axis);
        let mut moved = coarse.to_vec();
        for (p, run) in moved.iter_mut().zip(self.starts.windows(2)) {
            let range = run[0] as usize..run[1] as usize;
            let rows: f64 = self.weights[range.clone()].iter().sum();
            *p += range.map(|i| self.weights[i] * (fine[i] - commands[i])).sum::<f64>() / rows.max(1.0);
        }
        moved
    }
}
