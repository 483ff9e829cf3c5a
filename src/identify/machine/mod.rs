//! `identify`: one model of lost motion for a machine, fitted to all its logs together.
//!
//! Read in this order:
//! - `spline`, [`law`]: what a joint does to its command, with derivatives.
//! - [`frame`]: where the tracker stands, for all logs or one; [`readings`]: what a log's instrument reads; [`bins`]: a log in rows and
//!   bins; [`corners`]: changes of speed at once.
//! - [`clock`]: clocks of commands and measurement that are far apart, put together first.
//! - [`nuisance`]: geometry, frame, lag, drift, load and ripple as linear columns with weak priors.
//! - [`noise`]: autoregressive noise in the principal directions of a log.
//! - [`problem`], [`prior`], [`solve`]: all of it as one least-squares problem, solved by Gauss-Newton steps.
//! - [`ripple`]: periods of the gears.
//! - [`rest`]: friction in logs of dwells apart from friction in motion, where they differ.
//! - [`jump`]: a frame of the tracker that jumped while a log was recorded.
//! - [`views`]: the estimate between a fit with correlated and one with uncorrelated noise.
//! - [`evidence`]: covariance, single reversals, what is left on parts that were not fitted; [`folds`]: which parts those are.
//! - [`unseen`]: joints of which single readings tell nothing.
//! - [`predict`]: what compensation will leave, without the noise of the instrument.
//! - [`estimate`]: the document; [`trust`]: whether a joint is compensated.
//! - [`update`]: a compensator corrected by runs of its own programs; `carried`: are they that; [`crossed`]: does a correction help strokes
//!   that did not see it;
//!   [`measured`]: has the last correction helped.
//!
//! Assumes command trajectories that are exact to their rounding, and a machine that does the same at the same place. What the
//! model lacks ends up in the noise, which widens intervals; it is never a reason to refuse.

pub(crate) mod bins;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
mod carried;
pub(crate) mod clock;
pub(crate) mod corners;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod crossed;
pub(crate) mod estimate;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod evidence;
pub(crate) mod folds;
pub(crate) mod frame;
pub(crate) mod jump;
pub(crate) mod law;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod measured;
pub(crate) mod noise;
pub(crate) mod nuisance;
pub(crate) mod predict;
mod prior;
pub(crate) mod problem;
pub(crate) mod readings;
pub(crate) mod rest;
pub(crate) mod ripple;
pub(crate) mod solve;
pub(crate) mod spline;
mod trust;
pub(crate) mod unseen;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod update;
pub(crate) mod views;

use crate::error::{Error, Place, Result};
use crate::gaps::estimate::JointEstimate;
use crate::gaps::note::machine::Note;
use crate::gaps::{self, Gaps};
use crate::identify::commands::cleaned;
use crate::identify::gears::geared;
use crate::identify::scalar::Setup;
use crate::log::Log;
use crate::numerics::robust::median_of;
use crate::robot::Robot;
use evidence::Evidence;
use problem::Problem;
use readings::Readings;
use solve::FixedLaws;
use spline::Spline;

/// Knots of a gap over the travel of its joint.
const KNOTS: usize = 7;
/// Rounds of fitting, each with noise estimated from the residuals of the one before.
const ROUNDS: usize = 3;

/// Identifies a machine from its logs, by gears where gears turn by sums of axes; `setups` says of each log what is known of a ballbar
/// or a dial (none given: what the logs say themselves).
///
/// # Errors
/// Where a log has no readings or no time, or no joint reverses.
pub fn identify(robot: &Robot, logs: &[Log], setups: &[Setup]) -> Result<Gaps> {
    let by_gears = geared(robot, logs);
    let cleaned = cleaned(&by_gears.robot, &by_gears.logs);
    let mut gaps = of_axes(&by_gears.robot, &cleaned.logs, setups)?;
    gaps.notes.extend(cleaned.notes(&by_gears.robot));
    cleaned.doubt(&by_gears.robot, &mut gaps);
    gaps.robot_sha256 = robot.fingerprint();
    gaps.notes.extend(by_gears.notes);
    gaps.doubt_robot_file(robot, logs);
    Ok(gaps)
}

/// The same where every gear turns by its own axis.
fn of_axes(robot: &Robot, logs: &[Log], setups: &[Setup]) -> Result<Gaps> {
    let (aligned, shifts) = clock::aligned(robot, logs)?;
    let aligned: Vec<&Log> = aligned.iter().map(|l| l.as_ref()).collect();
    let registered = frame::frame(robot, &aligned)?;
    let mut readings = Vec::new();
    for (k, log) in aligned.iter().enumerate() {
        let setup = setups.get(k).copied().unwrap_or_else(|| Setup::of(log));
        readings.extend(Readings::of_log(robot, log, &setup, registered.as_ref())?);
    }
    let Solved { problem, evidence, varies, apart } = solved(robot, &aligned, &readings)?;
    let shifted = |(log, by_s): &(usize, f64)| Note::ClocksApart { log: logs[*log].name.clone(), by_s: *by_s };
    let first: Vec<gaps::Note> =
        shifts.iter().map(|s| shifted(s).into()).chain(readings.iter().filter_map(Readings::note)).collect();
    let mut notes = Vec::new();
    let mut gaps = Gaps {
        registration: registered,
        tcp_speed_m_s: median_of(&mut problem.logs.iter().filter_map(|l| l.speed_m_s).collect::<Vec<_>>()),
        ..Gaps::new(robot, logs)
    };
    let (mut estimates, undetermined) = (Vec::new(), unseen::undetermined(&problem));
    for (axis, p) in varies.into_iter().enumerate() {
        if let Some((_, sigma)) = undetermined.iter().find(|u| u.0 == axis) {
            notes.push(unseen::note(&problem, axis, *sigma));
            continue;
        }
        match estimate::joint(&problem, &evidence, axis, p) {
            Some((gap, estimate, points)) => {
                gaps.joints.push(gap);
                gaps.points.extend(points);
                estimates.push(estimate);
            }
            None => notes.push(Note::NeverReverses { joint: robot.axis(axis).name.clone() }),
        }
    }
    if estimates.is_empty() {
        let name = logs.first().map_or(String::new(), |l| l.name.clone());
        let (found, expected) = if undetermined.is_empty() {
            ("no joint that reverses", "logs in which joints reverse")
        } else {
            ("readings that determine no joint's gap", "readings along which joints move the TCP as they reverse")
        };
        return Err(Error::bad(Place::file(name), found, expected));
    }
    let whole = estimate::whole(&problem, &evidence, estimates);
    notes.extend(whole.joints.iter().map(|j| trust_note(robot, j)));
    notes.extend(whole.joints.iter().filter_map(|j| disagreement(robot, j)));
    for (log, before_m, after_m) in &whole.predicted {
        notes.push(Note::OffPath { log: log.clone(), before_m: *before_m, after_m: *after_m });
    }
    notes.extend(apart.iter().filter_map(|axis| rest::note(&problem, *axis)));
    if rest::only_dwells(&problem) {
        notes.push(Note::OnlyDwells);
    }
    notes.extend(jump::notes(&problem));
    gaps.estimate = Some(whole);
    gaps.notes = first.into_iter().chain(notes.into_iter().map(Into::into)).collect();
    Ok(gaps)
}

fn trust_note(robot: &Robot, joint: &JointEstimate) -> Note {
    Note::Trusted { joint: robot.axis(joint.axis).name.clone(), trust: joint.trust.clone() }
}

/// What to say where the single reversals of a joint do not agree with the fit of all logs.
fn disagreement(robot: &Robot, joint: &JointEstimate) -> Option<Note> {
    let agreement = joint.agreement.filter(|a| !a.agree)?;
    let joint = robot.axis(joint.axis);
    Some(Note::Disagree { joint: joint.name.clone(), kind: joint.kind, agreement })
}

/// A machine's problem, solved.
struct Solved<'a> {
    problem: Problem<'a>,
    evidence: Evidence,
    /// For each axis, how likely a constant gap would vary as much as this one.
    varies: Vec<Option<f64>>,
    /// Axes whose friction differs between logs of dwells and logs of motion.
    apart: Vec<usize>,
}

/// Fits, decides which frictions are apart and which gaps vary with position, and fits once more.
fn solved<'a>(robot: &'a Robot, logs: &[&Log], readings: &[Readings]) -> Result<Solved<'a>> {
    let splines: Vec<Spline> = (0..robot.dof()).map(|a| Spline::over_travel(logs.iter().copied(), a, KNOTS)).collect();
    let bins_per_s = bins::per_second(logs);
    let bins = readings.iter().map(|r| bins::bin(r, robot, &splines, bins_per_s)).collect();
    let mut problem = Problem::new(robot, bins, splines);
    let mut ripples = Vec::new();
    for k in 0..ROUNDS {
        solve::round(&mut problem, if k == 0 { FixedLaws::Friction } else { FixedLaws::Nothing });
        solve::refresh_unused(&mut problem);
        solve::refresh_noise(&mut problem);
        if k > 0 {
            solve::other_valleys(&mut problem);
        }
        if k == 1 {
            let found = ripple::search(&problem, &ripples);
            problem.add_ripples(&found, ripples.len());
            ripples.extend(found);
        }
    }
    let apart = rest::apart(&mut problem);
    solve::round(&mut problem, FixedLaws::Nothing);
    let open = || {
        let name = logs.first().map_or(String::new(), |l| l.name.clone());
        Error::bad(Place::file(name), "logs that do not determine the estimate", "finite measurements of moving joints")
    };
    let within = evidence::covariances(&problem).ok_or_else(open)?[1].clone();
    let varies = estimate::constant_axes(&problem, &within);
    problem.constant = varies.iter().map(|v| v.0).collect();
    solve::round(&mut problem, FixedLaws::Nothing);
    let half = views::middle(&mut problem);
    let mut evidence = evidence::evaluate(&problem).ok_or_else(open)?;
    evidence.covariance += &half * half.transpose();
    Ok(Solved { problem, evidence, varies: varies.into_iter().map(|v| v.1).collect(), apart })
}
