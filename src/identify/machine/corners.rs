//! Corners of commands: rows at which a joint changes its speed at once, between the ramps of a test with dwells or the points of a
//! program.
//!
//! What a servo makes of a corner lies between two rows and lasts for some of its time constants, so bins with a corner are left out. That
//! is not possible where corners follow each other closely: a program that is run linearly between points a few tenths of a second apart
//! has one in most bins, and nothing would be left. There the corners at which a joint passes on stay in: a bin that holds a whole corner
//! has the mean speed and acceleration of that corner, by which lag and response to acceleration describe it to second order.
//!
//! After a stop a lag still moves the joint for some tenths of a second, which friction does, too. Each joint with corners therefore gets
//! what a servo of first order adds to a lag at its corners, for the time constants [`SERVOS_S`]: their mixtures follow any such servo
//! between them (Ljung 1999, Laguerre and Kautz models), and all of them end long before the friction's shortest decay does.

use super::bins::BinnedLog;
use crate::identify::following::rates;
use crate::log::Log;
use crate::numerics::robust::median_of;

/// A corner: a change of speed that a lag of [`SERVO_S`] turns into more than [`CORNER_M`] at the TCP, and that is [`CORNER_TIMES`] times
/// that of the rows around it.
const SERVO_S: f64 = 0.01;
const CORNER_M: f64 = 3e-6;
const CORNER_TIMES: f64 = 5.0;
const CORNER_NEAR: usize = 5;
/// Share of the faster speed at a corner below which the joint stops or starts there.
const STANDS: f64 = 1e-3;
/// Share of the bins of a moving joint with corners from which they are too close to be left out.
const DENSE: f64 = 1.0 / 3.0;
/// Time constants of servos, s.
const SERVOS_S: [f64; 3] = [0.02, 0.05, 0.12];

/// A row at which a command has a corner, and whether the joint moves on in the same direction.
struct Corner {
    row: usize,
    passes: bool,
}

/// Corners of an axis whose largest lever is `lever` (m per rad or m).
fn corners(t: &[f64], x: &[f64], lever: f64) -> Vec<Corner> {
    let speed: Vec<f64> = (1..x.len()).map(|i| (x[i] - x[i - 1]) / (t[i] - t[i - 1])).collect();
    let change: Vec<f64> = speed.windows(2).map(|v| (v[1] - v[0]).abs()).collect();
    let mut out = Vec::new();
    for (k, &c) in change.iter().enumerate().filter(|(_, c)| **c * lever * SERVO_S > CORNER_M) {
        let near = k.saturating_sub(CORNER_NEAR)..(k + CORNER_NEAR + 1).min(change.len());
        let mut others: Vec<f64> = near.filter(|i| i.abs_diff(k) > 1).map(|i| change[i]).collect();
        if c > CORNER_TIMES * median_of(&mut others).unwrap_or(0.0) {
            let slower = speed[k].abs().min(speed[k + 1].abs());
            let passes = speed[k] * speed[k + 1] > 0.0 && slower > STANDS * speed[k].abs().max(speed[k + 1].abs());
            out.push(Corner { row: k, passes });
        }
    }
    out
}

/// Bins to leave out for corners of some axes (commands, and largest lever in m per rad or m), and which axes have corners. `bins` are the
/// rows of each bin, first to one past the last; `moves` tells of a bin whether a joint moves in it.
pub(crate) fn left_out(
    t_s: &[f64],
    axes: &[(&[f64], f64)],
    bins: &[(usize, usize)],
    moves: &dyn Fn(usize) -> bool,
) -> (Vec<bool>, Vec<bool>) {
    let mut at = [vec![false; bins.len()], vec![false; bins.len()]];
    let mut with = Vec::new();
    for (command, lever) in axes {
        let found = corners(t_s, command, *lever);
        for corner in &found {
            let first = bins.partition_point(|b| b.1 <= corner.row);
            let last = bins.partition_point(|b| b.0 < corner.row + 3).max(first);
            at[usize::from(corner.passes)][first..last].fill(true);
        }
        with.push(!found.is_empty());
    }
    let [abrupt, passed] = at;
    let moving = (0..bins.len()).filter(|b| moves(*b)).count();
    let dense = passed.iter().filter(|p| **p).count() as f64 > DENSE * moving as f64;
    (abrupt.into_iter().zip(passed).map(|(abrupt, passed)| abrupt || (passed && !dense)).collect(), with)
}

/// Marks bins with corners as missing, and gives the joints that have corners what servos add to a lag there.
pub fn take_out(log: &Log, out: &mut BinnedLog) {
    let axes: Vec<usize> = out.moving.iter().map(|m| m.0).collect();
    let lever = |axis: usize| out.jacobian.iter().map(|j| j[axis].norm()).fold(0.0, f64::max);
    let commands: Vec<(&[f64], f64)> = axes.iter().map(|a| (log.cmd[*a].as_slice(), lever(*a))).collect();
    let moves = |b: usize| axes.iter().any(|a| out.speed[b][*a] != 0.0);
    let (corner, with) = left_out(&log.t_s, &commands, &out.bins, &moves);
    for (axis, _) in axes.iter().zip(with).filter(|(_, with)| *with) {
        let servos = servos(&log.t_s, &log.cmd[*axis], out);
        out.servos.push((*axis, servos));
    }
    out.missing.iter_mut().zip(corner).for_each(|(missing, corner)| *missing |= corner);
}

/// Error of a servo of first order in units of its lag, less that of a lag alone, bin by bin for each of [`SERVOS_S`]; rad/s or m/s.
fn servos(t: &[f64], x: &[f64], bins: &BinnedLog) -> Vec<Vec<f64>> {
    let speed = rates(t, x).0;
    let over = |tau: f64| {
        let mut delayed = 0.0;
        let mut rows = vec![0.0; x.len()];
        for i in 1..x.len() {
            let step = t[i] - t[i - 1];
            let now = (x[i] - x[i - 1]) / step;
            delayed = now + (delayed - now) * (-step / tau).exp();
            rows[i] = delayed - speed[i];
        }
        let mut out = Vec::new();
        bins.average(&rows, &mut out);
        out
    };
    SERVOS_S.map(over).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of rows 20 ms apart, and a sine of 6 deg that is run linearly between points `each` rows apart.
    fn polyline(each: usize) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..2000).map(|i| 0.02 * f64::from(i)).collect();
        let at = |t: f64| 0.1 * (0.5 * t).sin();
        let x = (0..t.len())
            .map(|i| {
                let (from, share) = (i / each * each, (i % each) as f64 / each as f64);
                let (a, b) = (at(0.02 * from as f64), at(0.02 * (from + each) as f64));
                a + share * (b - a)
            })
            .collect();
        (t, x)
    }

    #[test]
    fn points_of_a_program_are_corners_that_pass_and_stops_are_not() {
        let (t, x) = polyline(10);
        let found = corners(&t, &x, 2.0);
        assert!(found.len() > 150, "{}", found.len());
        assert!(found.iter().filter(|c| !c.passes).count() < 10, "reversals alone");
        let ramp: Vec<f64> = t.iter().map(|t| (0.1 * t).min(1.0) - (0.1 * (t - 20.0)).max(0.0)).collect();
        let found = corners(&t, &ramp, 2.0);
        assert!(!found.is_empty() && found.iter().all(|c| !c.passes));
    }
}
