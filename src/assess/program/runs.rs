//! One run: what was commanded, where the TCP was, and its error along the reference path.

use super::frame;
use super::path::{Reference, SLACK_M, lengths};
use super::source::{Options, REST, Source};
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::model::Model;
use crate::numerics::reversal::{Movement, ReversalDetector};
use crate::program::Program;
use crate::simulate::{Motion, Timing};
use nalgebra::Vector3;

/// Rows of a simulated run: fine enough for a step at a reversal, few enough for any program.
const ROWS: [f64; 2] = [2_000.0, 200_000.0];
/// Length of path between two rows, m.
const STEP_M: f64 = 0.1e-3;
/// Difference in length of two paths for which the nearest point is looked for further away, m: more is another path.
const MOST_SLACK_M: f64 = 20e-3;
/// Length of path on which lengths drift apart by [`SLACK_M`] at most, m.
const DRIFTS_M: f64 = 5.0;
/// Rows of a stretch at least.
const LEAST_ROWS: f64 = 20.0;
/// Longest path between two rows where the program is fastest, m.
const LONGEST_STEP_M: f64 = 0.5e-3;
/// Rate of a log, and the largest rate for which a program may have more rows than the most of [`ROWS`], Hz.
const FASTEST_HZ: f64 = 250.0;
/// Rows that a program has for this rate at most: memory and time grow with them, and between rows that are millimetres apart the
/// reference is bent ([`Reference::bent`]).
const LONG_ROWS: f64 = 500_000.0;
/// Measured positions are averaged over this time, s.
const SMOOTHING_S: f64 = 0.5;

/// A reversal of a joint's command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningPoint {
    pub axis: usize,
    pub at_s: f64,
    pub command: f64,
    pub direction: i8,
}

/// Where a machine was, row by row.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The path of the TCP, with its corners, and the times of its points, m and s.
    pub path_m: Vec<Vector3<f64>>,
    pub path_s: Vec<f64>,
    /// Length of the commanded path of the nominal robot up to each of its points, m.
    pub along_m: Vec<f64>,
    /// Those of its points that are rows, evenly in time.
    pub rows: Vec<usize>,
    /// Whether the path is smooth at each of its points, which a point of the program is not. Empty: the points are so close that chords
    /// do.
    pub smooth: Vec<bool>,
    /// How far the TCP is from where the nominal robot has it, at the requested points, m.
    pub deviations_m: Vec<Vector3<f64>>,
    pub turns: Vec<TurningPoint>,
    /// Points of the program (rows of a log), stops among them, and duration.
    pub points: usize,
    pub stops: usize,
    pub cycle_s: f64,
}

impl Measured {
    /// Takes the path out, as the reference for other runs; reversals and deviations stay.
    pub fn become_reference(&mut self) -> Reference {
        (self.along_m, self.rows) = Default::default();
        let (points, t_s) = (std::mem::take(&mut self.path_m), std::mem::take(&mut self.path_s));
        Reference::new(points, t_s).bent(std::mem::take(&mut self.smooth))
    }
}

/// A run against the reference.
#[derive(Debug, Clone, Default)]
pub struct Run {
    pub name: String,
    /// Length of the commanded path, m.
    pub length_m: f64,
    /// Error of each row, and the time of the reference where it is nearest.
    pub errors_m: Vec<f64>,
    pub reference_s: Vec<f64>,
    /// Largest error at a corner between rows, m.
    corners_m: f64,
    pub rms_m: f64,
    pub mean_m: f64,
    pub largest_m: f64,
    pub points: usize,
    pub stops: usize,
    pub cycle_s: f64,
}

impl Run {
    pub fn new(name: &str, measured: &Measured, reference: &Reference) -> Self {
        let along = &measured.along_m;
        let length_m = along.last().copied().unwrap_or(0.0);
        // offsets make the commanded path a little longer: its length is scaled onto the reference's
        let scale = if length_m > 0.0 { reference.length_m() / length_m } else { 1.0 };
        let slack = slack_m(length_m, reference);
        let passed: Vec<[f64; 2]> =
            reference.follow(&measured.path_m, along, scale, slack).map(|near| [near.off_m, near.t_s]).collect();
        let (errors_m, reference_s) = measured.rows.iter().map(|&row| passed[row].into()).unzip();
        let mut run = Self {
            name: name.into(),
            length_m,
            errors_m,
            reference_s,
            corners_m: passed.iter().map(|[off, _]| *off).fold(0.0, f64::max),
            points: measured.points,
            stops: measured.stops,
            cycle_s: measured.cycle_s,
            ..Self::default()
        };
        run.total();
        run
    }

    /// The figures over all rows.
    pub(super) fn total(&mut self) {
        let n = self.errors_m.len().max(1) as f64;
        self.rms_m = (self.errors_m.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        self.mean_m = self.errors_m.iter().sum::<f64>() / n;
        self.largest_m = self.errors_m.iter().copied().fold(self.corners_m, f64::max);
    }

    /// Another run follows; the figures over all rows come with [`Self::total`].
    pub(super) fn append(&mut self, other: Self) {
        self.length_m += other.length_m;
        self.errors_m.extend(other.errors_m);
        self.reference_s.extend(other.reference_s);
        self.corners_m = self.corners_m.max(other.corners_m);
        self.points += other.points;
        self.stops += other.stops;
        self.cycle_s += other.cycle_s;
    }
}

/// Times of a program's points.
fn times(model: &Model, program: &Program, options: &Options) -> Vec<f64> {
    match &program.t_s {
        Some(t) if !options.at_speed => t.clone(),
        _ => Timing::at_speed(&model.robot, program, options.speed_m_s).t_s,
    }
}

/// How many rows a run has.
#[derive(Debug, Clone, Copy)]
pub struct Rows {
    least: f64,
    most: f64,
    /// The most where [`FASTEST_HZ`] asks for more than `most`.
    most_at_full_rate: f64,
}

impl Rows {
    /// Of a whole program.
    pub fn whole() -> Self {
        Self::share(1.0)
    }

    /// Of a stretch that is this share of a program.
    pub fn share(share: f64) -> Self {
        let [least, most, most_at_full_rate] = [ROWS[0], ROWS[1], LONG_ROWS].map(|rows| (rows * share).max(LEAST_ROWS));
        Self { least, most, most_at_full_rate }
    }
}

/// How both runs are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    pub rate_hz: f64,
    /// The path has the program's points beside its rows: a corner between two rows would be cut.
    pub corners: bool,
    /// Rows and points of a run, about.
    pub rows: f64,
}

impl Sampling {
    /// Bytes of memory that both runs and the reference take at most.
    pub fn memory(&self) -> u64 {
        // measured: 190 MB of 520,000 rows, 365 each
        const PER_ROW: f64 = 400.0;
        (PER_ROW * self.rows) as u64
    }
}

/// Rows that stand near enough everywhere.
const FINE: Sampling = Sampling { rate_hz: FASTEST_HZ, corners: false, rows: 0.0 };

/// How the runs of a program, and of what it became, are sampled.
pub fn sampling(model: &Model, source: &Source, options: &Options, of_run: Rows) -> Sampling {
    let Source::Program(program) = source else { return FINE };
    let t = times(model, program, options);
    let duration = t.last().copied().unwrap_or(0.0) - t.first().copied().unwrap_or(0.0);
    if duration <= 0.0 {
        return FINE;
    }
    let mut q = vec![0.0; model.robot.dof()];
    let path: Vec<Vector3<f64>> = (0..program.len())
        .map(|i| {
            program.point_into(i, &mut q);
            model.robot.tcp_m(&q)
        })
        .collect();
    let along = lengths(path);
    let length = along.last().copied().unwrap_or(0.0);
    let rows = (length / STEP_M).clamp(of_run.least, of_run.most);
    // where a program is fast its rows stand further apart, but not so far that an arc between them is lost
    let speed = |k: usize| (along[k] - along[k - 1]) / (t[k] - t[k - 1]).max(f64::MIN_POSITIVE);
    let moving = (1..along.len()).filter(|&k| along[k] - along[k - 1] > REST).map(speed);
    let fast = moving.fold(0.0, f64::max) / LONGEST_STEP_M;
    let most_hz = FASTEST_HZ.min(of_run.most_at_full_rate / duration).max(of_run.most / duration);
    let rate_hz = (rows / duration).max(fast).min(most_hz);
    // rows of two runs stand at other places near a corner: where points are further apart than rows, they belong to the path
    let (points, rows) = (program.len() as f64, rate_hz * duration);
    Sampling { rate_hz, corners: fast > most_hz || points < rows, rows: points + rows }
}

/// A program, or the commands of a log, on a modelled machine; `at`: points of the program whose deviation is requested, increasing.
pub fn simulated(
    model: &Model,
    source: &Source,
    options: &Options,
    sampling: Sampling,
    at: &[usize],
) -> Result<Measured> {
    let ((trajectory, tcp_m), points, stops) = match source {
        Source::Program(program) => {
            let t_s = times(model, program, options);
            let corners: Vec<usize> = if sampling.corners { (0..program.len()).collect() } else { at.to_vec() };
            let run = Motion::tcp_of_program_at(model, program, &t_s, sampling.rate_hz, &corners)?;
            (run, program.len(), stops(&program.q))
        }
        Source::Log(log) => {
            refuse_poses(log)?;
            (Motion::tcp_of_log(model, log), log.len(), stops(&log.cmd))
        }
    };
    let (mut plain, mut smooth) = (vec![true; trajectory.rows()], vec![sampling.corners; trajectory.rows()]);
    for &(row, own) in trajectory.rows_of_points() {
        (plain[row], smooth[row]) = (!own, false);
    }
    let rows: Vec<usize> = (0..trajectory.rows()).filter(|&row| plain[row]).collect();
    let of_points = trajectory.rows_of_points();
    let asked: Vec<usize> = match sampling.corners {
        true => at.iter().filter_map(|&k| of_points.get(k)).map(|p| p.0).collect(),
        false => of_points.iter().map(|p| p.0).collect(),
    };
    let command = |axis: usize, row: usize| trajectory.command(axis)[row];
    let nominal = commanded(model, &asked, command);
    let deviations_m = nominal.zip(&asked).map(|(nominal, &row)| tcp_m[row] - nominal).collect();
    let path: Vec<usize> = if sampling.corners { (0..trajectory.rows()).collect() } else { rows.clone() };
    let t_s = trajectory.t_s();
    let duration_s = rows.first().zip(rows.last()).map(|(&first, &last)| t_s[last] - t_s[first]);
    Ok(Measured {
        path_m: path.iter().map(|&row| tcp_m[row]).collect(),
        path_s: path.iter().map(|&row| t_s[row]).collect(),
        along_m: lengths(commanded(model, &path, command)),
        deviations_m,
        turns: turning_points(model.robot.dof(), &rows, command, t_s),
        rows: if sampling.corners { rows } else { (0..path.len()).collect() },
        smooth: if sampling.corners { smooth } else { Vec::new() },
        points,
        stops,
        cycle_s: duration_s.unwrap_or(0.0),
    })
}

/// Length of path on either side within which the nearest point is looked for, m: what was added makes one part of a long path longer and
/// another shorter, so that lengths drift apart between its ends, too.
fn slack_m(length_m: f64, reference: &Reference) -> f64 {
    SLACK_M * (length_m / DRIFTS_M).max(1.0) + (length_m - reference.length_m()).abs().min(MOST_SLACK_M)
}

/// What a log measured, fitted rigidly onto the reference and averaged over [`SMOOTHING_S`].
pub fn measured(model: &Model, log: &Log, reference: &Reference) -> Result<Measured> {
    refuse_poses(log)?;
    let rows: Vec<usize> = (0..log.len()).filter(|&r| log.tcp_m.get(r).is_some_and(Option::is_some)).collect();
    if rows.len() < 3 {
        let expected = "`x_mm,y_mm,z_mm` of the TCP; or programs, which are run on the model";
        return Err(Error::bad(Place::file(&log.name), format!("{} rows with a TCP", rows.len()), expected));
    }
    let t_s: Vec<f64> = rows.iter().map(|&r| log.t_s[r]).collect();
    let command = |axis: usize, row: usize| log.cmd[axis][row];
    let along_m = lengths(commanded(model, &rows, command));
    let total = along_m.last().copied().unwrap_or(0.0);
    let scale = if total > 0.0 { reference.length_m() / total } else { 1.0 };
    let seen: Vec<Vector3<f64>> = rows.iter().filter_map(|&r| log.tcp_m[r]).collect();
    let along: Vec<f64> = along_m.iter().map(|a| a * scale).collect();
    let slack = slack_m(total, reference);
    let Some(frame) = frame::across(&seen, &along, reference, slack) else {
        let expected = "a path whose points do not lie on one line, so that the frame can be determined";
        return Err(Error::bad(Place::file(&log.name), "measured points on one line", expected));
    };
    let placed: Vec<Vector3<f64>> = seen.iter().map(|p| frame.rotation * p + frame.translation.vector).collect();
    // what is averaged is the deviation across the path, not the path; one along it would be cut short at corners
    let nearest = |(p, a): (&Vector3<f64>, &f64)| reference.nearest(p, *a, slack).at;
    let near: Vec<Vector3<f64>> = placed.iter().zip(&along).map(nearest).collect();
    let off: Vec<Vector3<f64>> = placed.iter().zip(&near).map(|(p, n)| p - n).collect();
    let points_m: Vec<Vector3<f64>> = near.iter().zip(averaged(&t_s, &off)).map(|(n, o)| n + o).collect();
    Ok(Measured {
        along_m,
        rows: (0..points_m.len()).collect(),
        smooth: Vec::new(),
        path_m: points_m,
        deviations_m: Vec::new(),
        turns: turning_points(log.cmd.len(), &rows, command, &log.t_s),
        path_s: t_s,
        points: log.len(),
        stops: stops(&log.cmd),
        cycle_s: log.t_s.last().copied().unwrap_or(0.0) - log.t_s.first().copied().unwrap_or(0.0),
    })
}

fn refuse_poses(log: &Log) -> Result<()> {
    if log.poses {
        return Err(Error::bad(Place::line(&log.name, 1), "no `t_s`", "a log of a motion, with `t_s`; or a program"));
    }
    Ok(())
}

/// Mean over the rows within half of [`SMOOTHING_S`] on either side.
fn averaged(t_s: &[f64], values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros()];
    for v in values {
        sums.push(sums[sums.len() - 1] + v);
    }
    t_s.iter()
        .map(|t| {
            let from = t_s.partition_point(|x| *x < t - 0.5 * SMOOTHING_S);
            let to = t_s.partition_point(|x| *x <= t + 0.5 * SMOOTHING_S).max(from + 1);
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// Where the nominal robot has the TCP in some rows of commands, m.
fn commanded<'a>(
    model: &'a Model,
    rows: &'a [usize],
    command: impl Fn(usize, usize) -> f64 + 'a,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let mut q = vec![0.0; model.robot.dof()];
    rows.iter().map(move |&row| {
        q.iter_mut().enumerate().for_each(|(axis, v)| *v = command(axis, row));
        model.robot.tcp_m(&q)
    })
}

/// Reversals of every joint in some rows, in the order of time.
fn turning_points(dof: usize, rows: &[usize], command: impl Fn(usize, usize) -> f64, t_s: &[f64]) -> Vec<TurningPoint> {
    let mut out = Vec::new();
    for axis in 0..dof {
        let mut detector = ReversalDetector::new(REST, 0);
        for (i, &row) in rows.iter().enumerate() {
            if let Movement::Reversed { at, extreme } = detector.take(i, command(axis, row)) {
                out.push(TurningPoint { axis, at_s: t_s[rows[at]], command: extreme, direction: detector.direction() });
            }
        }
    }
    out.sort_by(|a, b| a.at_s.total_cmp(&b.at_s).then(a.axis.cmp(&b.axis)));
    out
}

/// Stretches in which no joint moves from one point to the next.
fn stops(q: &[Vec<f64>]) -> usize {
    let n = q.first().map_or(0, Vec::len);
    let rests = |i: usize| q.iter().all(|c| (c[i] - c[i - 1]).abs() <= REST);
    (1..n).filter(|&i| rests(i) && !(i > 1 && rests(i - 1))).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    /// An arm of one joint that turns a TCP on 1 m to and fro by 100 deg, at 1 m/s.
    fn sampled(moves: usize) -> Sampling {
        let text = "schema: lostmotion/robot/1\nname: arm\nconvention: dh-standard\njoints:\n  - {name: A, kind: revolute, theta_deg: 0, \
             d_mm: 0, a_mm: 1000, alpha_deg: 0, direction: 1}\n";
        let robot = Robot::parse("arm.yaml", text).unwrap();
        let rows: String = (0..=moves).map(|k| format!("{}\n", 100 * (k % 2))).collect();
        let input = crate::io::input::from_bytes("p.csv".into(), format!("A_deg\n{rows}").into_bytes()).unwrap();
        let program = Program::parse(input, &robot).unwrap();
        let model = Model::ideal(robot);
        let options = Options { speed_m_s: 1.0, at_speed: true };
        sampling(&model, &Source::Program(&program), &options, Rows::whole())
    }

    #[test]
    fn a_program_of_any_length_has_a_bounded_number_of_rows() {
        // 1.5 m in 1.5 s each: as many rows as a run may have, then 250 a second, then fewer
        let [short, medium, long] = [50, 600, 20_000].map(sampled);
        assert!((short.rows - ROWS[1] - 51.0).abs() < 2.0, "{short:?}");
        assert!((medium.rate_hz - 250.0).abs() < 1e-9 && medium.corners, "{medium:?}");
        assert!(long.rate_hz < 20.0 && (long.rows - LONG_ROWS - 20_001.0).abs() < 2.0, "{long:?}");
        assert!(long.memory() < 220 << 20, "{}", long.memory());
    }
}
