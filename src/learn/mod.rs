//! Learning: forward kinematics of a machine from its logs, by small networks (Cursi (2022), section IV).
//!
//! For machines whose way from motor to TCP is hard to write down (tendons, sheaths, coupled joints). Each coordinate of the TCP is one
//! network of one hidden layer over all commands. The plain one learns positions; the augmented one learns velocities as
//! well, through the exact derivative of the same network, and so has a better Jacobian, which is what `track` needs.
//!
//! Modules:
//! - [`network`]: the network, its derivatives by inputs and by weights.
//! - [`data`]: logs to rows with speeds; the split into training and test; `desired`: commands that are not those of their program.
//! - [`mod@train`]: the cost and its minimiser.
//! - [`kinematics`]: what was learned; [`mod@file`]: the document `lostmotion/kinematics/1`.
//! - [`measure`]: errors on rows, of the learned and of the nominal kinematics.
//! - [`document`]: what was done, as JSON and as a table; [`mod@note`]: what a reader should know.
//!
//! Assumptions: the TCP is a function of the commands. Lost motion is not: it is averaged over, or taken out beforehand
//! (compensated runs, with the desired commands as inputs). Outside the range of the training the networks are not valid.
//!
//! Fails on logs whose commands are not those of the program that is given for them, on logs without a measured TCP, with fewer rows than
//! weights, without times for the augmented network, and where no joint moves.

#![warn(missing_docs)]

pub mod data;
mod desired;
pub mod document;
pub mod file;
pub mod kinematics;
pub mod measure;
pub mod network;
pub mod note;
pub mod train;

pub use kinematics::{Evidence, Input, Kind, LETTERS, Learned, Rmse};
pub use note::Note;

use crate::error::{Error, Place, Result, counted};
use crate::gaps::LogRef;
use crate::log::Log;
use crate::numerics::least_squares::TerminationReason;
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::range;
use crate::program::Program;
use crate::robot::Robot;
use data::Row;
use network::Network;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use train::{Cost, Samples, Training, train};

/// Weights of the augmented cost as published (section IV-B).
pub const PUBLISHED: Cost = Cost { position: 1e-3, speed: 1.0 };
/// Share of the rows that is learned from where no test log is given (section V-B).
pub const TRAIN_SHARE: f64 = 0.8;

/// What a user may choose.
#[derive(Debug, Clone)]
pub struct Options {
    /// Plain or augmented.
    pub kind: Kind,
    /// Neurons of the hidden layer.
    pub hidden: usize,
    /// Of the split and of the first weights.
    pub seed: u64,
    /// 0, 1, 2 for x, y, z; rising.
    pub coordinates: Vec<usize>,
}

impl Default for Options {
    /// 30 neurons, as published; all three coordinates.
    fn default() -> Self {
        Self { kind: Kind::Augmented, hidden: 30, seed: 1, coordinates: vec![0, 1, 2] }
    }
}

/// A log, and the program whose commands replace the ones in the log.
pub struct Source<'a> {
    /// The log.
    pub log: &'a Log,
    /// Program with the desired commands, if those of the log are compensated.
    pub desired: Option<&'a Program>,
}

/// What came out.
#[derive(Debug, Clone)]
pub struct TrainingResult {
    /// The kinematics.
    pub learned: Learned,
    /// Per coordinate.
    pub training: Vec<Training>,
    /// Errors of the nominal kinematics in the frame that fits the training rows best, per coordinate; `None`: no frame could be found.
    pub nominal: Option<Nominal>,
    /// Distances of the test rows (of the training rows where there are none) from the learned position, m.
    pub distances_m: Vec<f64>,
    /// What a user should know about the result.
    pub notes: Vec<Note>,
}

/// Errors of the nominal kinematics.
#[derive(Debug, Clone)]
pub struct Nominal {
    /// Errors on the rows of the training, one per coordinate.
    pub train: Vec<Rmse>,
    /// Errors on the rows of the test, one per coordinate.
    pub test: Vec<Rmse>,
    /// Distance of each row of the test, m.
    pub distances_m: Vec<f64>,
}

/// The network of one coordinate, and how its training ended.
fn teach(learned: &Learned, rows: &[Row], c: usize, dof: usize, options: &Options) -> (Network, Training) {
    let cost = if options.kind == Kind::Augmented { PUBLISHED } else { Cost { position: 1.0, speed: 0.0 } };
    let mut samples = samples(learned, rows, c);
    let (mean, spread) = spread(&samples.target);
    let spread = if spread > 0.0 { spread } else { 1.0 };
    samples.target.iter_mut().for_each(|t| *t = (*t - mean) / spread);
    samples.target_speed.iter_mut().flatten().for_each(|v| *v /= spread);
    // each coordinate draws from its own stream, so that leaving one out changes no other
    let mut generator = ChaCha8Rng::seed_from_u64(options.seed);
    generator.set_stream(1 + c as u64);
    let mut network = Network::random(dof, options.hidden, 0.0, 1.0, &mut generator);
    let training = train(&mut network, &samples, cost);
    (network.rescaled(spread, mean), training)
}

/// Fewer rows than weights, or commands that never change, determine no network.
fn refuse_too_little(name: &str, rows: &[Row], dof: usize, options: &Options) -> Result<()> {
    let weights = Network::count(dof, options.hidden);
    if rows.len() < weights {
        let expected =
            format!("{weights} or more, because a network of {} neurons has this many weights", options.hidden);
        let found = format!("{} with a measurement to learn from", counted(rows.len(), "row"));
        return Err(Error::bad(Place::file(name), found, expected));
    }
    let moving = rows.iter().filter(|r| r.speed.is_some()).count();
    if options.kind == Kind::Augmented && moving < weights {
        let found = format!("{} with a velocity", counted(moving, "row"));
        let expected = format!("{weights} or more: a log with t_s and without pauses, or a plain network");
        return Err(Error::bad(Place::file(name), found, expected).mended_by(&["kind"]));
    }
    Ok(())
}

/// Learns from `logs`; the test rows are those of `tests`, or else a fifth of the logs'.
pub fn learn(robot: &Robot, logs: &[Source], tests: &[Source], options: &Options) -> Result<TrainingResult> {
    let all = |sources: &[Source]| -> Result<Vec<Row>> {
        let rows = |s: &Source| -> Result<Vec<Row>> {
            let rows = data::rows(s.log, s.desired)?;
            s.desired.map_or(Ok(()), |program| desired::check(robot, s.log, program))?;
            Ok(rows)
        };
        let each: Result<Vec<Vec<Row>>> = sources.iter().map(rows).collect();
        Ok(each?.concat())
    };
    let (train_rows, test_rows) =
        if tests.is_empty() { data::split(all(logs)?, TRAIN_SHARE, options.seed) } else { (all(logs)?, all(tests)?) };
    let name = logs.first().map_or("", |s| s.log.name.as_str());
    refuse_too_little(name, &train_rows, robot.dof(), options)?;
    let inputs = ranges(robot, &train_rows);
    if inputs.iter().all(|i| i.half_range == 0.0) {
        return Err(Error::bad(Place::file(name), "commands that never change", "a log in which joints move"));
    }
    let mut notes = Vec::from_iter(still(robot, &inputs));
    let mut learned = Learned {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        kind: options.kind,
        coordinates: options.coordinates.clone(),
        inputs,
        networks: Vec::new(),
        evidence: Evidence::default(),
        file: None,
    };
    let taught = options.coordinates.par_map(|&c| teach(&learned, &train_rows, c, robot.dof(), options));
    let (networks, training): (Vec<Network>, Vec<Training>) = taught.into_iter().unzip();
    learned.networks = networks;
    for (&c, t) in options.coordinates.iter().zip(&training) {
        if t.reason == TerminationReason::StepLimit {
            notes.push(Note::Stopped { coordinate: LETTERS[c], steps: t.steps });
        }
    }
    let of = |r: &Row| (learned.position_m(&r.q), r.speed.as_ref().map(|(dq, _)| measure::speed(&learned, &r.q, dq)));
    let at = &options.coordinates;
    let (train_rmse, _) = measure::rmse(&train_rows, at, of);
    let (test_rmse, mut distances_m) = measure::rmse(&test_rows, at, of);
    if test_rows.is_empty() {
        notes.push(Note::NoTest);
        distances_m = measure::rmse(&train_rows, at, of).1;
    }
    let nominal = measure::nominal(robot, &train_rows, &test_rows, at);
    let reference = |name: &str, sha256: &str| LogRef { name: name.into(), sha256: sha256.into() };
    learned.evidence = Evidence {
        logs: logs.iter().map(|s| reference(&s.log.name, &s.log.sha256)).collect(),
        programs: logs.iter().filter_map(|s| s.desired.map(|p| reference(&p.name, &p.sha256))).collect(),
        seed: options.seed,
        train_rows: train_rows.len(),
        test_rows: test_rows.len(),
        train: train_rmse,
        test: test_rmse,
    };
    Ok(TrainingResult { learned, training, nominal, distances_m, notes })
}

/// Range of each axis over the rows.
fn ranges(robot: &Robot, rows: &[Row]) -> Vec<Input> {
    (0..robot.dof())
        .map(|a| {
            let [lo, hi] = range(rows.iter().map(|r| r.q[a]));
            // less than the last digit of a log is no movement
            let half = 0.5 * (hi - lo);
            Input { centre: 0.5 * (hi + lo), half_range: if half > 1e-6 { half } else { 0.0 } }
        })
        .collect()
}

fn still(robot: &Robot, inputs: &[Input]) -> Option<Note> {
    let still = robot.axis_joints().zip(inputs).filter(|(_, i)| i.half_range == 0.0);
    let joints: Vec<String> = still.map(|(j, _)| j.name.clone()).collect();
    (!joints.is_empty()).then_some(Note::StandStill { joints })
}

/// Samples of one coordinate, scaled.
fn samples(learned: &Learned, rows: &[Row], coordinate: usize) -> Samples {
    let mut all = Samples { inputs: learned.inputs.len(), ..Samples::default() };
    for row in rows {
        all.u.extend(learned.scaled(&row.q));
        all.target.push(row.p_m[coordinate]);
        match &row.speed {
            Some((dq, dp)) => {
                all.du.extend(dq.iter().zip(&learned.inputs).map(|(d, i)| d * i.gain()));
                all.target_speed.push(Some(dp[coordinate]));
            }
            None => {
                all.du.extend(std::iter::repeat_n(0.0, learned.inputs.len()));
                all.target_speed.push(None);
            }
        }
    }
    all
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
}
