//! Long logs: means over runs of rows, and the commands within a run for what remembers the way.
//!
//! Method: a run of rows becomes one row, its measurement the mean over the run. What moves a joint is computed at several places
//! of every run and averaged as the measurement is: a gap that is crossed within a run looks like wind-up otherwise.

use super::{GROSS, orientation};
use crate::diagnose::noise::LEAST_POINT_SIGMA;
use crate::diagnose::problem::fine::Fine;
use crate::identify::scalar::{self, Setup};
use crate::log::{Log, registration};
use crate::machine::CommandTrajectory;
use crate::model::Model;
use crate::numerics::robust::{SIGMA_PER_MAD, median, median_of};
use nalgebra::{Isometry3, Vector3};

/// Rows of a log that is taken as it is.
const MOST_ROWS: usize = 8000;
/// Rows to which a longer one is thinned.
const THINNED_ROWS: usize = 4000;
/// Rows at which its joints are computed.
const FINE_ROWS: usize = 16_000;
/// Pairs used for a frame that is good enough to take differences.
const PAIRS: usize = 3000;

/// A log as it is, or thinned, with the commands within each run.
pub(super) fn whole(model: &Model, log: &Log) -> (Log, Option<Fine>) {
    if log.poses || log.len() <= MOST_ROWS {
        return (log.clone(), None);
    }
    let step = log.len().div_ceil(FINE_ROWS);
    let per_run = log.len().div_ceil(step * THINNED_ROWS);
    let run = step * per_run;
    let places = places(log, step);
    let rows: Vec<usize> = places.iter().map(|p| p.0).collect();
    let first = |k: usize| places.partition_point(|p| p.0 < k * run) as u32;
    let starts: Vec<u32> = (0..=log.len().div_ceil(run)).map(first).collect();
    let weights = places.iter().map(|p| p.1).collect();
    let trajectory = CommandTrajectory::of_log(&model.robot, &commands_at(log, &rows));
    let fine = Fine::new(trajectory, starts, weights, log.t_s[0]);
    (thinned(model, log, run), Some(fine))
}

/// Rows that stand for each run of `step`, and for how many of its rows: those where a joint turns for themselves, the middle one
/// for the others.
fn places(log: &Log, step: usize) -> Vec<(usize, f64)> {
    let n = log.len();
    let mut turns = vec![false; n];
    for p in &log.cmd {
        let mut dir = 0.0;
        for r in 1..n {
            let change = p[r] - p[r - 1];
            turns[r - 1] |= change * dir < 0.0;
            if change != 0.0 {
                dir = change;
            }
        }
    }
    // commands that dither turn everywhere, and no row of them stands for more than another
    if turns.iter().filter(|t| **t).count() > n / (2 * step) {
        turns.fill(false);
    }
    let of_run = |from: usize| {
        let run = from..(from + step).min(n);
        let others = run.clone().filter(|&r| !turns[r]).count();
        // of the rows at which nothing turns, the one in their middle
        let middle = run.clone().filter(|&r| !turns[r]).nth(others / 2);
        run.filter(|&r| turns[r] || Some(r) == middle)
            .map(|r| (r, if turns[r] { 1.0 } else { others as f64 }))
            .collect::<Vec<_>>()
    };
    (0..n).step_by(step).flat_map(of_run).collect()
}

/// Times, commands and what acts on the joints at some rows of a log.
fn commands_at(log: &Log, rows: &[usize]) -> Log {
    let numbers = |c: &[Option<f64>]| rows.iter().map(|&r| c[r]).collect();
    Log {
        name: log.name.clone(),
        sha256: log.sha256.clone(),
        line: Vec::new(),
        t_s: rows.iter().map(|&r| log.t_s[r]).collect(),
        poses: false,
        cmd: log.cmd.iter().map(|c| rows.iter().map(|&r| c[r]).collect()).collect(),
        cmd_decimals: log.cmd_decimals.clone(),
        tcp_m: Vec::new(),
        reflectors_m: Vec::new(),
        lone_m: [const { None }; 3],
        enc: vec![None; log.cmd.len()],
        screw: vec![None; log.cmd.len()],
        meas: vec![None; log.cmd.len()],
        trigger: None,
        cycle: None,
        speed_m_s: None,
        payload_kg: log.payload_kg.as_deref().map(numbers),
        temp_c: log.temp_c.as_deref().map(numbers),
        instruments: crate::log::Instruments {
            torque_nm: log.instruments.torque_nm.iter().map(|t| t.as_deref().map(numbers)).collect(),
            force_n: log.instruments.force_n.as_ref().map(|f| rows.iter().map(|&r| f[r]).collect()),
            ..crate::log::Instruments::default()
        },
    }
}

/// The row that stands for a run of rows.
fn middle(run: &std::ops::Range<usize>) -> usize {
    (run.start + run.end) / 2
}

/// Mean of the vectors that are there.
fn mean_of(run: &[Option<Vector3<f64>>]) -> Option<Vector3<f64>> {
    let count = run.iter().flatten().count();
    (count > 0).then(|| run.iter().flatten().sum::<Vector3<f64>>() / count as f64)
}

/// A joint's sensor in each run: the command in its middle plus the mean of sensor minus command.
fn thinned_joint(sensor: &[Option<f64>], cmd: &[f64], runs: &[std::ops::Range<usize>]) -> Vec<Option<f64>> {
    runs.iter()
        .map(|r| {
            let mut off: Vec<f64> = r.clone().filter_map(|i| sensor[i].map(|v| v - cmd[i])).collect();
            let n = off.len() as f64;
            let _ = median_of(&mut off)?;
            Some(off.iter().sum::<f64>() / n + cmd[middle(r)])
        })
        .collect()
}

/// The same of the sensors of all joints that have one.
fn thinned_joints(
    columns: &[Option<Vec<Option<f64>>>],
    cmd: &[Vec<f64>],
    runs: &[std::ops::Range<usize>],
) -> Vec<Option<Vec<Option<f64>>>> {
    columns.iter().zip(cmd).map(|(c, cmd)| Some(thinned_joint(c.as_ref()?, cmd, runs))).collect()
}

/// Readings of a ballbar or a dial in each run: the one of the command in its middle plus the mean of read minus computed.
fn thinned_reading(
    model: &Model,
    log: &Log,
    column: &[Option<f64>],
    runs: &[std::ops::Range<usize>],
) -> Vec<Option<f64>> {
    // an instrument of which too little is known is refused later, with the reason
    let instrument = scalar::instrument(&model.robot, log, &Setup::of(log)).ok();
    let computed = |row: usize| -> f64 {
        let tcp = model.robot.tcp_m(&log.command(row));
        instrument.as_ref().and_then(|i| i.reading(&tcp)).unwrap_or(0.0)
    };
    let of_run = |run: &std::ops::Range<usize>| {
        let off: Vec<f64> = run.clone().filter_map(|row| Some(column[row]? - computed(row))).collect();
        (!off.is_empty()).then(|| off.iter().sum::<f64>() / off.len() as f64 + computed(middle(run)))
    };
    runs.iter().map(of_run).collect()
}

/// A log of at most `most_rows` rows: of each run of rows the middle one, its measurement replaced by the prediction of
/// the commands there plus the mean of measured minus predicted over the run. What is slower than a run is kept, its
/// noise averaged; gross errors of single rows, which their neighbours contradict, are left out. The mean is a plain one: where a
/// gap is crossed within a run, most rows of it would outvote the others.
pub(super) fn to_at_most(model: &Model, log: &Log, most_rows: usize) -> Log {
    thinned(model, log, log.len().div_ceil(most_rows.max(1)))
}

fn thinned(model: &Model, log: &Log, run: usize) -> Log {
    if run <= 1 || log.poses {
        return log.clone();
    }
    let runs: Vec<std::ops::Range<usize>> = (0..log.len()).step_by(run).map(|s| s..(s + run).min(log.len())).collect();
    let numbers = |c: &Option<Vec<Option<f64>>>| c.as_ref().map(|c| runs.iter().map(|r| c[middle(r)]).collect());
    let mut q = vec![0.0; model.robot.dof()];
    let frame = frame_of(model, log);
    let mut expected = |row: usize| {
        log.command_into(row, &mut q);
        frame.transform_point(&model.robot.tcp_m(&q).into()).coords
    };
    let mut points = |column: &[Option<Vector3<f64>>]| -> Vec<Option<Vector3<f64>>> {
        if column.is_empty() {
            return Vec::new();
        }
        let mut off: Vec<Option<Vector3<f64>>> =
            column.iter().enumerate().map(|(row, m)| m.map(|m| m - expected(row))).collect();
        leave_gross_out(&mut off);
        runs.iter()
            .map(|r| {
                let there = || off[r.clone()].iter().flatten();
                let count = there().count();
                (count > 0).then(|| there().sum::<Vector3<f64>>() / count as f64 + expected(middle(r)))
            })
            .collect()
    };
    let single = |column: &Option<Vec<Option<f64>>>| Some(thinned_reading(model, log, column.as_ref()?, &runs));
    let joints = |columns: &[Option<Vec<Option<f64>>>]| thinned_joints(columns, &log.cmd, &runs);
    Log {
        name: log.name.clone(),
        sha256: log.sha256.clone(),
        line: runs.iter().map(|r| log.line.get(middle(r)).copied().unwrap_or(0)).collect(),
        t_s: runs.iter().map(|r| log.t_s[r.clone()].iter().sum::<f64>() / r.len() as f64).collect(),
        poses: false,
        cmd: log.cmd.iter().map(|c| runs.iter().map(|r| c[middle(r)]).collect()).collect(),
        cmd_decimals: log.cmd_decimals.clone(),
        tcp_m: points(&log.tcp_m),
        reflectors_m: log.reflectors_m.iter().map(|c| points(c)).collect(),
        lone_m: [const { None }; 3],
        enc: joints(&log.enc),
        screw: vec![None; log.cmd.len()],
        meas: joints(&log.meas),
        trigger: None,
        cycle: None,
        speed_m_s: numbers(&log.speed_m_s),
        payload_kg: numbers(&log.payload_kg),
        temp_c: numbers(&log.temp_c),
        instruments: crate::log::Instruments {
            torque_nm: log.instruments.torque_nm.iter().map(numbers).collect(),
            force_n: log.instruments.force_n.as_ref().map(|f| runs.iter().map(|r| mean_of(&f[r.clone()])).collect()),
            distance_m: single(&log.instruments.distance_m),
            distance_off_m: single(&log.instruments.distance_off_m),
            dial_m: single(&log.instruments.dial_m),
            orientation: orientation::thinned(model, log, &frame, &runs),
            centre_m: log.instruments.centre_m,
            direction: log.instruments.direction,
        },
    }
}

/// Leaves out rows that disagree with their two neighbours on either side: far from the median, coordinate by coordinate, and
/// farther than the two neighbours in the middle are from each other, as where a gap is crossed.
fn leave_gross_out(off: &mut [Option<Vector3<f64>>]) {
    let present: Vec<usize> = (0..off.len()).filter(|&r| off[r].is_some()).collect();
    let points: Vec<Vector3<f64>> = off.iter().flatten().copied().collect();
    let disagreement = |p: &[Vector3<f64>]| {
        let middle = |c: usize| {
            let mut near = [p[0][c], p[1][c], p[3][c], p[4][c]];
            near.sort_unstable_by(f64::total_cmp);
            [near[1], near[2]]
        };
        let (least, most) = (Vector3::from_fn(|c, _| middle(c)[0]), Vector3::from_fn(|c, _| middle(c)[1]));
        ((p[2] - (least + most) * 0.5).norm(), (most - least).norm())
    };
    let all: Vec<(f64, f64)> = points.windows(5).map(disagreement).collect();
    let scale = SIGMA_PER_MAD * median(&all.iter().map(|d| d.0).collect::<Vec<_>>()).max(LEAST_POINT_SIGMA);
    for (&row, (d, apart)) in present.iter().skip(2).zip(&all) {
        if *d > GROSS * scale && d > apart {
            off[row] = None;
        }
    }
}

/// The model's frame, or the one that fits the commands: good enough to take differences over a fraction of a second.
fn frame_of(model: &Model, log: &Log) -> Isometry3<f64> {
    if let Some(frame) = model.registration {
        return frame;
    }
    let thin = (log.len() / PAIRS).max(1);
    let pairs: Vec<registration::Pair> = (0..log.len())
        .step_by(thin)
        .filter_map(|r| {
            let m = log.tcp_m.get(r).copied().flatten()?;
            Some(registration::Pair { base_m: model.robot.tcp_m(&log.command(r)), tracker_m: m })
        })
        .collect();
    registration::register_line(&pairs).map_or_else(|_| Isometry3::identity(), |r| r.found.frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::problem::forward::{Hypothesis, Problem};
    use crate::effects::{Backlash, Effect, EffectInstance};
    use crate::robot::Robot;

    const GAP_M: f64 = 2e-5;

    fn gap(axis: usize) -> EffectInstance {
        EffectInstance::on_axis(axis, Effect::new(Backlash::constant(GAP_M)))
    }

    /// A log of many rows in which a gap is crossed slowly, measured without noise but for one gross error; each row as its own
    /// commands say.
    fn long_log(robot: &Robot) -> Log {
        let t_s: Vec<f64> = (0..16_000).map(|i| f64::from(i) * 0.01).collect();
        let cmd: Vec<Vec<f64>> =
            (0..3).map(|a| t_s.iter().map(|t| 2e-3 * (t * (0.3 + 0.05 * f64::from(a))).sin()).collect()).collect();
        let trajectory = CommandTrajectory::of_columns(robot, t_s.clone(), cmd.clone(), None, false);
        let effect = Effect::new(Backlash::constant(GAP_M));
        let joints: Vec<Vec<f64>> =
            (0..3).map(|a| if a == 1 { trajectory.gear(a, &[&effect], 0) } else { cmd[a].clone() }).collect();
        let mut tcp_m: Vec<Option<Vector3<f64>>> =
            (0..t_s.len()).map(|r| Some(robot.tcp_m(&[joints[0][r], joints[1][r], joints[2][r]]))).collect();
        tcp_m[9000] = tcp_m[9000].map(|p| p + Vector3::new(0.0, 0.0, 5e-3));
        let all: Vec<usize> = (0..t_s.len()).collect();
        let bare = Log {
            name: "long.csv".into(),
            sha256: String::new(),
            line: Vec::new(),
            t_s,
            poses: false,
            cmd_decimals: vec![6; 3],
            cmd,
            tcp_m: Vec::new(),
            reflectors_m: Vec::new(),
            lone_m: [const { None }; 3],
            enc: vec![None; 3],
            screw: vec![None; 3],
            meas: vec![None; 3],
            trigger: None,
            cycle: None,
            speed_m_s: None,
            payload_kg: None,
            temp_c: None,
            instruments: crate::log::Instruments::default(),
        };
        Log { tcp_m, ..commands_at(&bare, &all) }
    }

    fn largest(problem: &Problem, h: &Hypothesis) -> f64 {
        problem.evaluate(h).residual.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
    }

    #[test]
    fn a_gap_that_is_crossed_within_runs_is_averaged_as_its_measurement_is() {
        let robot = Robot::load(std::path::Path::new("configs/gantry-xyz-ballscrew.yaml")).unwrap();
        let model = Model { registration: Some(Isometry3::identity()), ..Model::ideal(robot) };
        let log = long_log(&model.robot);
        let (problem, mut h) = super::super::problem(&model, std::slice::from_ref(&log)).unwrap();
        assert!(problem.logs[0].log.len() <= THINNED_ROWS && problem.logs[0].fine.is_some());
        assert!(largest(&problem, &h) > 0.99 * GAP_M);
        h.effects.push(gap(1));
        let averaged = largest(&problem, &h);
        assert!(averaged < 0.01 * GAP_M, "{averaged}");
        // at one place of each run it is not
        let mut coarse = problem;
        coarse.logs[0].fine = None;
        let sampled = largest(&coarse, &h);
        assert!(sampled > 10.0 * averaged, "{sampled} {averaged}");
    }
}
