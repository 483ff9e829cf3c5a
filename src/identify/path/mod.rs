//! `identify path`: half gaps and stiction of the joints from reversals in continuous motion (Zhang (2023) sections 3 and 5).
//!
//! The story: a log becomes bins ([`prepare`] with running `medians`, [`bins`]); every joint that reverses gets the error chain of the
//! effect catalogue with exact derivatives ([`chain`]); the tracker's frame and rigid errors of the links are projected out
//! ([`nuisance`], [`problem`], `reduced`) instead of being fitted first, because a lag on a path that goes round in one direction looks
//! like a turned frame; gaps, spikes and decays are fitted together ([`solve`]); tests say which of them the data ask for ([`select`]);
//! intervals ([`interval`]), the gap at each reversal ([`reversal`]) and error traces ([`trace`]) follow. `joints` and `frame`
//! turn the fit into entries of the document.
//!
//! Assumes a joint command that is followed up to lag, play and rigid errors; noise with a correlation of less than some
//! seconds. Drift of the tracker over minutes breaks the intervals (they cover the truth about half the time at a correlation of
//! 60 s); an inflation above [`ALARM`] is reported, above [`MISTRUST`] the log is tried in a mirrored frame ([`mirror`]). A joint that
//! never reverses cannot be judged and is named so.

pub(crate) mod bins;
pub(crate) mod chain;
mod frame;
pub(crate) mod interval;
mod joints;
mod medians;
mod mirror;
pub(crate) mod nuisance;
pub(crate) mod prepare;
pub(crate) mod problem;
mod reduced;
pub(crate) mod reversal;
pub(crate) mod select;
pub(crate) mod solve;
pub(crate) mod trace;

use crate::compensator::Compensator;
use crate::effects::GapCurve;
use crate::error::{Error, Place, Result};
use crate::gaps::note::machine;
use crate::gaps::note::path::Note;
use crate::gaps::{self, Distrust, GapPoint, Gaps, JointGap};
use crate::identify::LEAST_LEVER;
use crate::identify::commands::cleaned;
use crate::identify::gears::geared;
use crate::identify::machine::clock;
use crate::log::Log;
use crate::model::Model;
use crate::numerics::student;
use crate::robot::Robot;
use interval::StictionInterval;
use problem::Problem;
pub use reversal::Reversal;
use select::Selected;
use std::borrow::Cow;
pub use trace::Trace;

/// Inflation from which the residuals say that the model does not hold (a gap that varies, a moved tracker).
pub const ALARM: f64 = 5.0;
/// Inflation from which gaps are significant only if they are `MISTRUST_MARGIN` half intervals or more.
pub const MISTRUST: f64 = 10.0;
/// Residual over the noise of a row, and residual in m, from which a model does not describe a log.
const GROSS: f64 = 10.0;
const GROSS_M: f64 = 1e-4;

/// What a user may choose.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Axes that are reported; empty: all that move. The lost motion of every joint that reverses is fitted in any case.
    pub free: Vec<usize>,
    /// Half gaps that are known (from a static test) and held.
    pub known: Vec<Known>,
}

/// A half gap that is held.
#[derive(Debug, Clone)]
pub struct Known {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Half gap that is held, rad or m over position.
    pub half_gap: GapCurve,
    /// 95 % interval of its mean, where it has one.
    pub ci95: Option<[f64; 2]>,
}

impl Options {
    /// Holds the half gaps and schedules of a gaps document.
    pub fn hold_gaps(&mut self, gaps: &Gaps) {
        for j in &gaps.joints {
            self.hold(j.axis, j.schedule.clone().unwrap_or(GapCurve::Constant(j.half_gap)), Some(j.ci95));
        }
    }

    /// Holds the gaps of a model of the same robot; two plays on a joint count with their sum.
    pub fn hold_model(&mut self, model: &Model, robot: &Robot) -> Result<()> {
        if model.robot.fingerprint() != robot.fingerprint() {
            let found = format!("a model of another robot, `{}`", model.robot.name);
            return Err(Error::setting("model", found, format!("a model of `{}`", robot.name)));
        }
        for j in Compensator::from_model(model)?.joints {
            if let Some(b) = j.backlash {
                self.hold(j.axis, b.positive, None);
            }
        }
        Ok(())
    }

    /// The axis is one of those that are reported.
    fn reports(&self, axis: usize) -> bool {
        self.free.is_empty() || self.free.contains(&axis)
    }

    fn hold(&mut self, axis: usize, half_gap: GapCurve, ci95: Option<[f64; 2]>) {
        self.known.retain(|k| k.axis != axis);
        self.known.push(Known { axis, half_gap, ci95 });
    }
}

/// The document, and what reports want beyond it.
#[derive(Debug, Clone)]
pub struct PathFound {
    /// Half gaps of the joints, for a compensator.
    pub gaps: Gaps,
    /// What was found of each joint, with intervals.
    pub details: Vec<JointDetail>,
    /// Every reversal of the logs.
    pub reversals: Vec<Reversal>,
    /// Error of each joint over time, for pictures.
    pub traces: Vec<Trace>,
    /// Noise of a coordinate of a row, m; inflation of the variance by correlated residuals.
    pub sigma_m: f64,
    /// Factor on variances for residuals that are correlated over time.
    pub inflation: f64,
    /// Rigid errors of the links were fitted beside the frame.
    pub links: bool,
}

/// More about a joint.
#[derive(Debug, Clone)]
pub struct JointDetail {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// F of the test for stiction.
    pub stiction_f: Option<f64>,
    /// Stiction with its interval; none where the log shows none.
    pub stiction: Option<StictionInterval>,
    /// The decay is one for all joints.
    pub shared_decay: bool,
    /// Whether the half gap was given and not fitted.
    pub held: bool,
}

/// Identifies from one or more logs of one robot, by gears where gears turn by sums of axes.
pub fn identify(robot: &Robot, logs: &[Log], options: &Options) -> Result<PathFound> {
    let by_gears = geared(robot, logs);
    let cleaned = cleaned(&by_gears.robot, &by_gears.logs);
    // where this is not possible the log is refused below, for what it lacks
    let (aligned, shifts) = clock::aligned(&by_gears.robot, &cleaned.logs).unwrap_or_default();
    let aligned: Vec<Log> =
        if shifts.is_empty() { Vec::new() } else { aligned.into_iter().map(Cow::into_owned).collect() };
    let used = if shifts.is_empty() { &cleaned.logs[..] } else { &aligned[..] };
    let mut found = of_axes(&by_gears.robot, used, options)?;
    let shifted = |(log, by_s): &(usize, f64)| machine::Note::ClocksApart { log: logs[*log].name.clone(), by_s: *by_s };
    found.gaps.notes.splice(0..0, shifts.iter().map(|s| shifted(s).into()));
    found.gaps.notes.extend(cleaned.notes(&by_gears.robot));
    cleaned.doubt(&by_gears.robot, &mut found.gaps);
    found.gaps.robot_sha256 = robot.fingerprint();
    found.gaps.notes.extend(by_gears.notes);
    found.gaps.doubt_robot_file(robot, logs);
    Ok(found)
}

/// The same where every gear turns by its own axis.
fn of_axes(robot: &Robot, logs: &[Log], options: &Options) -> Result<PathFound> {
    refuse_repeated(logs)?;
    let mut notes = Vec::new();
    let binned = logs.iter().map(|log| binned(robot, log, options, &mut notes)).collect::<Result<Vec<_>>>()?;
    let held: Vec<(usize, GapCurve)> = options.known.iter().map(|k| (k.axis, k.half_gap.clone())).collect();
    let mut problem = Problem::new(binned, &held);
    refuse_without_reversal(&problem, logs, options)?;
    let selected = select::select(&mut problem);
    refuse_unconverged(&selected, logs)?;
    let distrust = distrust(&problem, &selected, &held)?;
    let first = about_residuals(&distrust, selected.inflation);
    let variance = selected.cost / selected.dof * selected.inflation;
    let t95 = student::factor(0.95, selected.dof);
    let (reversals, alike) = reversal::reversals(&problem, &selected.values, &selected.form.sticky, variance)
        .unwrap_or_else(|| {
            notes.push(Note::TooManyReversals);
            (Vec::new(), Vec::new())
        });
    let reversals: Vec<Reversal> =
        reversals.into_iter().filter(|r| options.reports(problem.joints[r.joint].axis)).collect();
    let estimates = joints::estimates(&problem, &selected, variance, options);
    for estimate in &estimates {
        estimate.notes(robot, &alike, &selected.widened, &mut notes);
    }
    let (joints, details): (Vec<JointGap>, Vec<JointDetail>) = estimates.into_iter().map(|e| (e.gap, e.detail)).unzip();
    if selected.inflation > ALARM && selected.inflation <= MISTRUST {
        notes.push(Note::ResidualsCorrelated { inflation: selected.inflation });
    }
    if details.iter().any(|d| d.shared_decay) {
        notes.push(Note::SharedDecay);
    }
    notes.push(if problem.with.links { Note::LinkErrors } else { Note::NoLinkErrors });
    if problem.logs().len() > 1 {
        notes.push(Note::SeveralFrames { logs: problem.logs().len() });
    }
    let rms_m = frame::rms_m(&problem, &selected);
    let mut speeds: Vec<f64> = problem.logs().filter_map(|l| l.speed_m_s).collect();
    let gaps = Gaps {
        registration: frame::registration(&problem, &selected, rms_m, variance),
        points: reversals.iter().map(|r| point(r, &problem, t95)).collect(),
        joints,
        tcp_speed_m_s: crate::numerics::robust::median_of(&mut speeds),
        distrust,
        notes: first.into_iter().chain(notes.into_iter().map(Into::into)).collect(),
        ..Gaps::new(robot, logs)
    };
    let traces = trace::traces(&problem, &selected.values).into_iter().filter(|t| options.reports(t.axis)).collect();
    let (inflation, links) = (selected.inflation, problem.with.links);
    Ok(PathFound { gaps, details, traces, reversals, sigma_m: rms_m, inflation, links })
}

/// A log that was given twice would count twice.
fn refuse_repeated(logs: &[Log]) -> Result<()> {
    for (k, log) in logs.iter().enumerate() {
        // a log that was not read from bytes has no hash
        if !log.sha256.is_empty() && logs[..k].iter().any(|l| l.sha256 == log.sha256) {
            let expected = "each log once: its reversals would count twice";
            return Err(Error::bad(Place::file(&log.name), "a log that was given before (same SHA-256)", expected));
        }
    }
    Ok(())
}

/// The bins of a log, for every joint that moves.
fn binned(robot: &Robot, log: &Log, options: &Options, notes: &mut Vec<Note>) -> Result<prepare::Binned> {
    let moving = prepare::moving(log, robot);
    let free: Vec<usize> = moving.iter().copied().filter(|&a| options.reports(a)).collect();
    if free.is_empty() {
        let names = |axes: &[usize]| axes.iter().map(|&a| robot.axis(a).name.as_str()).collect::<Vec<_>>().join(", ");
        let found = if moving.is_empty() { "no joint".into() } else { names(&moving) };
        let expected = match options.free.as_slice() {
            [] => "a joint that moves".into(),
            free => format!("movement of {}", names(free)),
        };
        return Err(Error::bad(Place::file(&log.name), format!("movement of {found}"), expected));
    }
    // a joint that reverses has lost motion whether it is asked for or not: left out, it would bend the gaps of the others
    let mut binned = prepare::prepare(log, robot, &moving)?;
    let (seen, unseen) = binned.joints.into_iter().partition(|j| j.lever_m() >= LEAST_LEVER);
    binned.joints = seen;
    for j in unseen.iter().filter(|j| free.contains(&j.axis)) {
        let joint = robot.axis(j.axis);
        notes.push(Note::HardlyMoves {
            log: log.name.clone(),
            joint: joint.name.clone(),
            kind: joint.kind,
            least_lever: LEAST_LEVER,
        });
    }
    for j in binned.joints.iter().filter(|j| !j.reverses() && free.contains(&j.axis)) {
        notes.push(Note::NeverReverses { log: log.name.clone(), joint: robot.axis(j.axis).name.clone() });
    }
    if binned.outliers + binned.lost > 0 {
        let (lost, outliers) = (binned.lost, binned.outliers);
        notes.push(Note::RowsLeftOut { log: log.name.clone(), lost, rows: log.len(), outliers });
    }
    Ok(binned)
}

/// A path on which no joint of interest turns round tells nothing.
fn refuse_without_reversal(problem: &Problem, logs: &[Log], options: &Options) -> Result<()> {
    match logs.first() {
        Some(log) if !problem.joints.iter().any(|j| options.reports(j.axis)) => {
            let expected = "a path on which a joint of interest reverses at least once and moves the TCP";
            Err(Error::bad(Place::file(&log.name), "no joint that reverses", expected))
        }
        _ => Ok(()),
    }
}

/// Intervals of a fit that did not converge mean nothing.
fn refuse_unconverged(selected: &Selected, logs: &[Log]) -> Result<()> {
    if selected.reason.converged() {
        return Ok(());
    }
    let expected = "a path that determines the gaps: shorter logs, fewer joints, or a start nearer to the truth";
    let found = format!("a fit that did not converge ({})", selected.reason.text());
    Err(Error::bad(Place::file(logs.first().map_or("logs", |l| &l.name)), found, expected))
}

/// Whether the gaps can be trusted, where the residuals are correlated strongly. Correlation widens intervals; a residual of
/// another order than the noise shows that the model is that of something else.
fn distrust(problem: &Problem, selected: &Selected, held: &[(usize, GapCurve)]) -> Result<Option<Distrust>> {
    let inflation = selected.inflation;
    if inflation <= MISTRUST {
        return Ok(None);
    }
    mirror::refuse(problem, selected, held)?;
    let gaps_held = !held.is_empty();
    Ok(gross(problem, selected).then_some(Distrust::ModelDoesNotDescribeLog { inflation, gaps_held }))
}

/// The note that comes first: what residuals that are correlated strongly mean.
fn about_residuals(distrust: &Option<Distrust>, inflation: f64) -> Option<gaps::Note> {
    match distrust {
        Some(why) => Some(gaps::Note::Distrust(why.clone())),
        None => (inflation > MISTRUST).then(|| Note::IntervalsWidened { inflation }.into()),
    }
}

/// The residual of a log is of another order than its noise: no colour of noise explains that.
fn gross(problem: &Problem, selected: &Selected) -> bool {
    problem.logs().enumerate().any(|(l, log)| {
        let scale = problem.scale(l);
        let rows: f64 = log.rows.iter().sum();
        let rest: f64 = problem.residual(l, &selected.values).iter().map(|r| r.norm_squared()).sum();
        let rms_m = (rest / (3.0 * rows.max(1.0))).sqrt() / scale;
        rms_m > GROSS * log.sigma_m && rms_m > GROSS_M
    })
}

/// The gap at one reversal.
fn point(r: &Reversal, problem: &Problem, t95: f64) -> GapPoint {
    GapPoint {
        axis: problem.joints[r.joint].axis,
        at: r.at,
        half_gap: r.half_gap,
        ci95: [r.half_gap - t95 * r.sigma, r.half_gap + t95 * r.sigma],
        cycles: 1,
        per_cycle: vec![r.half_gap],
    }
}
