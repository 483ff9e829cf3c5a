//! A log as the joint identification sees it: rows for the joints' laws, bins of some tenths of a second for everything measured.
//!
//! Laws run over every row of the command; measurements and columns are averaged over bins, which keeps all that friction and
//! play do (they take longer) and makes the fit fast. Rows without a measurement are left out of their bin; a bin without any
//! is missing.

use super::corners;
use super::law::JointRows;
use super::readings::{Readings, moving};
use super::spline::Spline;
use crate::identify::following::rates;
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::robot::{Chain, Robot};
use nalgebra::Vector3;

/// Bins a second, at most; fewer where all logs together would have more than [`MOST_BINS`], but not fewer than the friction needs.
const BINS_PER_S: f64 = 10.0;
const FEWEST_PER_S: f64 = 4.0;
const MOST_BINS: f64 = 60_000.0;

/// A log in rows and bins.
#[derive(Debug, Clone)]
pub struct BinnedLog {
    pub name: String,
    /// Axes that move, with their rows.
    pub moving: Vec<(usize, JointRows)>,
    /// Rows of each bin, first to one past the last.
    pub bins: Vec<(usize, usize)>,
    /// Rows with a measurement.
    pub good: Vec<bool>,
    pub t_s: Vec<f64>,
    /// Mean command per bin and axis.
    pub q: Vec<Vec<f64>>,
    /// Mean velocity and acceleration of the command per bin and axis, rad/s or m/s.
    pub speed: Vec<Vec<f64>>,
    pub acceleration: Vec<Vec<f64>>,
    /// Axes whose commands have corners, with what servos add to a lag there ([`corners`]): per time constant and bin, rad/s or m/s.
    pub servos: Vec<(usize, Vec<Vec<f64>>)>,
    /// Mean nominal TCP, and its derivative by each axis.
    pub tcp_m: Vec<Vector3<f64>>,
    pub jacobian: Vec<Vec<Vector3<f64>>>,
    /// What was read, and the derivative of the readings by each axis: of a tracker that of the TCP.
    pub instrument: Instrument,
    pub sensitivity: Vec<Vec<Vector3<f64>>>,
    /// Whether the centre or the zero of the instrument is known.
    pub given: bool,
    pub whole: bool,
    /// Readings less those of the nominal TCP; of a tracker in the base frame.
    pub deviation_m: Vec<Vector3<f64>>,
    /// No measurement, or one that does not count.
    pub missing: Vec<bool>,
    /// TCP speed where it moves, m/s.
    pub speed_m_s: Option<f64>,
}

impl BinnedLog {
    pub fn len(&self) -> usize {
        self.bins.len()
    }

    /// What the readings of a bin see of a movement of the TCP.
    pub fn seen(&self, bin: usize, movement: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from(self.instrument.sensitivity(&self.tcp_m[bin], movement))
    }

    /// A column of rows as means over the bins.
    pub fn average(&self, rows: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(self.bins.iter().map(|&(from, to)| {
            let (mut s, mut n) = (0.0, 0.0);
            for i in from..to {
                if self.good[i] {
                    s += rows[i];
                    n += 1.0;
                }
            }
            if n > 0.0 { s / n } else { rows[from..to].iter().sum::<f64>() / (to - from).max(1) as f64 }
        }));
    }
}

/// Bins a second for logs that are fitted together.
pub fn per_second(logs: &[&Log]) -> f64 {
    let length = |l: &&Log| l.t_s.last().zip(l.t_s.first()).map_or(0.0, |(end, start)| end - start);
    (MOST_BINS / logs.iter().map(length).sum::<f64>()).clamp(FEWEST_PER_S, BINS_PER_S)
}

/// Bins what an instrument read of a log.
pub fn bin(readings: &Readings, robot: &Robot, splines: &[Spline], bins_per_s: f64) -> BinnedLog {
    let (log, good) = (readings.log(), readings.good());
    // a sensor of one joint sees nothing of the others
    let seen = |a: &usize| readings.sensed().is_none_or(|sensed| sensed == *a);
    let bins = edges(log, bins_per_s);
    let mut out = BinnedLog {
        name: log.name.clone(),
        moving: moving(log, robot)
            .into_iter()
            .filter(seen)
            .map(|a| (a, JointRows::new(&log.t_s, &log.cmd[a], &splines[a])))
            .collect(),
        bins,
        good,
        t_s: Vec::new(),
        q: Vec::new(),
        speed: Vec::new(),
        acceleration: Vec::new(),
        servos: Vec::new(),
        tcp_m: Vec::new(),
        jacobian: Vec::new(),
        instrument: readings.instrument,
        sensitivity: Vec::new(),
        given: readings.given,
        whole: readings.whole,
        deviation_m: Vec::new(),
        missing: Vec::new(),
        speed_m_s: None,
    };
    let rates: Vec<(Vec<f64>, Vec<f64>)> = log.cmd.iter().map(|x| rates(&log.t_s, x)).collect();
    let mut column = Vec::new();
    out.average(&log.t_s, &mut column);
    out.t_s = column.clone();
    let per_axis = |pick: &dyn Fn(usize) -> Vec<f64>, out: &BinnedLog| -> Vec<Vec<f64>> {
        let mut column = Vec::new();
        let mut rows = vec![vec![0.0; robot.dof()]; out.bins.len()];
        for a in 0..robot.dof() {
            out.average(&pick(a), &mut column);
            rows.iter_mut().zip(&column).for_each(|(r, v)| r[a] = *v);
        }
        rows
    };
    out.q = per_axis(&|a| log.cmd[a].clone(), &out);
    out.speed = per_axis(&|a| rates[a].0.clone(), &out);
    out.acceleration = per_axis(&|a| rates[a].1.clone(), &out);
    measured(log, robot.chain(), readings, &mut out);
    corners::take_out(log, &mut out);
    out
}

/// Bins by time: whole rows, none longer than the rate allows unless the rows are farther apart.
fn edges(log: &Log, bins_per_s: f64) -> Vec<(usize, usize)> {
    let n = log.len();
    let span = log.t_s[n - 1] - log.t_s[0];
    let rate = if span > 0.0 { (n - 1) as f64 / span } else { 1.0 };
    let each = ((rate / bins_per_s).round() as usize).max(1);
    (0..n / each).map(|b| (b * each, ((b + 1) * each).min(n))).collect()
}

/// Readings less those of the nominal TCP, bin by bin: each row against its own command.
fn measured(log: &Log, chain: &Chain, readings: &Readings, out: &mut BinnedLog) {
    let columns: Vec<&[f64]> = log.cmd.iter().map(Vec::as_slice).collect();
    let mut nominal = vec![Vector3::zeros(); log.len()];
    chain.positions(&columns, 0, &mut nominal);
    let mut speeds = Vec::new();
    for (b, &(from, to)) in out.bins.clone().iter().enumerate() {
        let (mut want, mut off, mut n) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for i in from..to {
            if let Some(deviation) = readings.deviation(i, &nominal[i]) {
                want += nominal[i];
                off += deviation;
                n += 1.0;
            }
        }
        out.missing.push(n == 0.0);
        let n = f64::max(n, 1.0);
        let mut jacobian = vec![Vector3::zeros(); log.cmd.len()];
        let at = chain.position_and_jacobian(&out.q[b], &mut jacobian);
        out.tcp_m.push(if out.missing[b] { at } else { want / n });
        out.deviation_m.push(off / n);
        let velocity: Vector3<f64> = jacobian.iter().zip(&out.speed[b]).map(|(j, v)| j * *v).sum();
        speeds.push(velocity.norm());
        let seen = match readings.sensed() {
            Some(sensed) => (0..jacobian.len())
                .map(|a| if a == sensed { Vector3::x() * readings.lever } else { Vector3::zeros() })
                .collect(),
            None => jacobian.iter().map(|j| out.seen(b, j)).collect(),
        };
        out.sensitivity.push(seen);
        out.jacobian.push(jacobian);
    }
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let mut moving: Vec<f64> = speeds.into_iter().filter(|v| *v > 0.05 * fastest).collect();
    out.speed_m_s = crate::numerics::robust::median_of(&mut moving).filter(|v| *v > 0.0);
}
