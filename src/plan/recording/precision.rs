//! The precision to expect of every half gap.
//!
//! Static test: a half gap is half the difference of two dwells' means, so its standard deviation is
//! `sigma / (S sqrt(2 n))` with `n` rows a dwell and the sensitivity `S`; over places and cycles it falls with their root.
//!
//! Motion: linear least squares of all half gaps at once, with the instrument's unknowns, a lag and a decaying spike of every joint,
//! and zero offsets of the joints beside them (weak priors: [`LAG_S`], [`SPIKE`], [`ZERO`]); covariance by Cholesky. White noise;
//! slow noise widens what an identification then finds.
//!
//! Not in it: scatter of the gap itself, creep within short dwells, geometry errors beyond zero offsets.

use super::motions::{Rows, StaticTest};
use super::note::Reason;
use super::options::Options;
use crate::identify::scalar::prior_unit;
use crate::machine::measurement::{Instrument, MOST_READINGS};
use crate::numerics::normal_equations::scaled_inverse;
use crate::robot::Robot;
use nalgebra::{DMatrix, Vector3};

/// Prior standard deviations: lag, s; spike and zero offset, deg or 0.1 mm.
const LAG_S: f64 = 0.02;
const SPIKE: f64 = 0.01;
const ZERO: f64 = 0.1;
/// Decay of the spike beside the gap, s.
const DECAY_S: f64 = 1.5;
/// Prior of a half gap, deg or 0.1 mm: far wider than any.
const GAP: f64 = 1.0;
/// Half gap as robots have it, deg or mm: a standard deviation above a third of it is of no use.
const TYPICAL: [f64; 2] = [0.003, 0.005];
/// Smallest sensitivity that counts, m per rad or per m.
const LEAST: f64 = 1e-3;
/// Rows that a motion is thinned to.
const MOST_ROWS: usize = 6000;
/// First part of a dwell that is left to the servo, s.
const SETTLE_S: f64 = 0.2;

/// What to expect of a joint; rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct Precision {
    pub axis: usize,
    /// Standard deviation of the half gap.
    pub sigma: Option<f64>,
    /// The same at one place of a static test.
    pub sigma_at_a_place: Option<f64>,
    /// Reversals, or places, that it is based on.
    pub reversals: usize,
    /// Mean sensitivity of the reading, m per rad or m per m.
    pub sensitivity_m: f64,
    /// Why nothing, or little, can be determined.
    pub reason: Option<Reason>,
}

/// Of a static test.
pub fn of_static(robot: &Robot, test: &StaticTest, options: &Options) -> Vec<Precision> {
    let mut columns = vec![Vector3::zeros(); robot.dof()];
    // the joint tested moves, the others stand at the pose in which the program starts
    let pose = test.rows.first().map_or_else(|| vec![0.0; robot.dof()], |r| r.1.clone());
    let rows = ((options.dwell_s - SETTLE_S.min(options.dwell_s / 3.0)) * options.rate_hz).floor().max(1.0);
    (0..robot.dof())
        .map(|axis| {
            let squares: Vec<f64> = test.places[axis]
                .iter()
                .map(|at| {
                    let mut q = pose.clone();
                    q[axis] = *at;
                    let p = robot.chain().position_and_jacobian(&q, &mut columns);
                    let s = options.instrument.sensitivity(&p, &columns[axis]);
                    s.iter().map(|v| v * v).sum()
                })
                .collect();
            let n = squares.len().max(1) as f64;
            let of = |s2: f64| options.noise_m / (s2.max(1e-300) * 2.0 * rows * options.cycles as f64).sqrt();
            let seen: Vec<f64> = squares.iter().copied().filter(|s| s.sqrt() > LEAST).collect();
            let mean = seen.iter().map(|s| of(*s).powi(2)).sum::<f64>().sqrt() / seen.len().max(1) as f64;
            let typical =
                if seen.is_empty() { 0.0 } else { seen.iter().map(|s| of(*s)).sum::<f64>() / seen.len() as f64 };
            let sensitivity_m = (squares.iter().sum::<f64>() / n).sqrt();
            finished(
                robot,
                axis,
                Some(mean).filter(|_| !seen.is_empty()),
                Some(typical),
                seen.len(),
                sensitivity_m,
                options,
            )
        })
        .collect()
}

/// Of a motion of all joints.
pub fn of_motion(robot: &Robot, rows: &Rows, options: &Options) -> Vec<Precision> {
    let dof = robot.dof();
    let every = (rows.len() / MOST_ROWS).max(1);
    let (signs, since, reversals) = directions(rows, dof);
    let nuisances = options.instrument.nuisances(&Vector3::zeros()).len();
    let k = 4 * dof + nuisances;
    let mut normal = DMatrix::<f64>::zeros(k, k);
    let mut columns = vec![Vector3::zeros(); dof];
    let mut squares = vec![0.0; dof];
    let mut count = 0.0;
    for i in (1..rows.len().saturating_sub(1)).step_by(every) {
        let q = &rows[i].1;
        let p = robot.chain().position_and_jacobian(q, &mut columns);
        let span_s = rows[i + 1].0 - rows[i - 1].0;
        let mut design = vec![[0.0; MOST_READINGS]; k];
        for a in 0..dof {
            let s = options.instrument.sensitivity(&p, &columns[a]);
            squares[a] += s.iter().map(|v| v * v).sum::<f64>();
            let speed = (rows[i + 1].1[a] - rows[i - 1].1[a]) / span_s;
            let sign = f64::from(signs[a][i]);
            let fading = sign * (-since[a][i] / DECAY_S).exp();
            for (group, factor) in [-sign, -fading, -speed, 1.0].into_iter().enumerate() {
                design[group * dof + a] = s.map(|v| v * factor);
            }
        }
        for (n, row) in options.instrument.nuisances(&p).into_iter().enumerate() {
            design[4 * dof + n] = row;
        }
        for x in 0..k {
            for y in x..k {
                normal[(x, y)] += (0..MOST_READINGS).map(|r| design[x][r] * design[y][r]).sum::<f64>();
            }
        }
        count += 1.0;
    }
    normal.fill_lower_triangle_with_upper_triangle();
    // rows of the log, of which some were left out here
    let duration = rows.last().map_or(0.0, |r| r.0);
    let weight = duration * options.rate_hz / f64::max(count, 1.0) / (options.noise_m * options.noise_m);
    normal *= weight;
    for a in 0..dof {
        let size = prior_unit(robot.axis(a).kind);
        for (group, prior) in [GAP * size, SPIKE * size, LAG_S, ZERO * size].into_iter().enumerate() {
            normal[(group * dof + a, group * dof + a)] += 1.0 / (prior * prior);
        }
    }
    for n in 0..nuisances {
        normal[(4 * dof + n, 4 * dof + n)] += 1e-6 * weight;
    }
    let variance = scaled_inverse(&normal, 0.0).map(|found| found.inverse.diagonal());
    (0..dof)
        .map(|a| {
            let sigma = variance.as_ref().map(|v| v[a].max(0.0).sqrt());
            let sensitivity_m = (squares[a] / f64::max(count, 1.0)).sqrt();
            finished(robot, a, sigma, None, reversals[a], sensitivity_m, options)
        })
        .collect()
}

/// Direction of every joint in every row (0 before its first movement), seconds since its last reversal, and reversals.
fn directions(rows: &Rows, dof: usize) -> (Vec<Vec<i8>>, Vec<Vec<f64>>, Vec<usize>) {
    let mut signs = vec![Vec::with_capacity(rows.len()); dof];
    let mut since = vec![Vec::with_capacity(rows.len()); dof];
    let mut reversals = vec![0; dof];
    for a in 0..dof {
        let (mut dir, mut turned) = (0i8, f64::NEG_INFINITY);
        for (i, row) in rows.iter().enumerate() {
            let step = if i > 0 { row.1[a] - rows[i - 1].1[a] } else { 0.0 };
            let now = if step > 0.0 {
                1
            } else if step < 0.0 {
                -1
            } else {
                dir
            };
            if now != dir {
                if dir != 0 {
                    turned = row.0;
                    reversals[a] += 1;
                }
                dir = now;
            }
            signs[a].push(dir);
            since[a].push(row.0 - turned);
        }
    }
    (signs, since, reversals)
}

fn finished(
    robot: &Robot,
    axis: usize,
    sigma: Option<f64>,
    sigma_at_a_place: Option<f64>,
    reversals: usize,
    sensitivity_m: f64,
    options: &Options,
) -> Precision {
    let joint = robot.axis(axis);
    let typical = joint.kind.pick(TYPICAL) * joint.kind.si_per_user_unit();
    let kind = joint.kind;
    let reason = if sensitivity_m < LEAST {
        let tcp = matches!(options.instrument, Instrument::Tcp);
        Some(Reason::HardlySeen { kind, tcp, sensitivity_m })
    } else if reversals == 0 {
        Some(Reason::NoReversal)
    } else {
        sigma.map(|s| 3.0 * s).filter(|h| *h > typical).map(|half_gap| Reason::SmallGaps { kind, half_gap })
    };
    let told = sensitivity_m >= LEAST && reversals > 0;
    Precision {
        axis,
        sigma: sigma.filter(|_| told),
        sigma_at_a_place: sigma_at_a_place.filter(|s| told && *s > 0.0),
        reversals,
        sensitivity_m,
        reason,
    }
}
