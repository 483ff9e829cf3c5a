//! `identify path`: half gaps and stiction of the joints from reversals in continuous motion (Zhang (2023) sections 3 and 5).
//!
//! The story: a log becomes bins ([`prepare`], [`bins`]); every joint that reverses gets the error chain of the effect
//! catalogue with exact derivatives ([`chain`]); the tracker's frame and rigid errors of the links are projected out
//! ([`nuisance`], [`problem`], `reduced`) instead of being fitted first, because a lag on a path that goes round in one direction looks like
//! a turned frame; gaps, spikes and decays are fitted together ([`solve`]); tests say which of them the data ask for ([`select`]);
//! intervals ([`interval`]), the gap at each reversal ([`reversal`]) and error traces ([`trace`]) follow.
//!
//! Assumes a joint command that is followed up to lag, play and rigid errors; noise with a correlation of less than some
//! seconds. Drift of the tracker over minutes breaks the intervals (they cover the truth about half the time at a correlation of
//! 60 s); an inflation above [`ALARM`] is reported, above [`MISTRUST`] the log is tried in a mirrored frame ([`mirror`]). A joint that never reverses cannot be
//! judged and is named so.

pub mod bins;
pub mod chain;
pub mod interval;
mod mirror;
pub mod nuisance;
pub mod prepare;
pub mod problem;
mod reduced;
pub mod reversal;
pub mod select;
pub mod solve;
pub mod trace;

use crate::compensator::Compensator;
use crate::effects::{Decay, GapCurve};
use crate::error::{Error, Place, Result};
use crate::gaps::{DISTRUSTED, GapPoint, Gaps, JointGap, LogRef, Registered, StictionFound};
use crate::log::Log;
use crate::model::Model;
use crate::numerics::{chi_squared, student};
use crate::robot::Robot;
use interval::{Covariance, StictionInterval};
use problem::{Name, Problem};
pub use reversal::Reversal;
use select::Selected;
pub use trace::Trace;

/// Inflation from which the residuals say that the model does not hold (a gap that varies, a moved tracker).
pub const ALARM: f64 = 5.0;
/// Inflation from which gaps are significant only if they are [`MISTRUST_MARGIN`] half intervals or more.
pub const MISTRUST: f64 = 10.0;
const MISTRUST_MARGIN: f64 = 3.0;
/// Residual over the noise of a row, and residual in m, from which a model does not describe a log.
const GROSS: f64 = 10.0;
const GROSS_M: f64 = 1e-4;
/// Standard error over spike from which spike and decay are not told apart.
const SEPARABLE: f64 = 0.5;

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
    pub axis: usize,
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
            return Err(Error::bad(Place::file("--model"), found, format!("a model of `{}`", robot.name)));
        }
        for j in Compensator::from_model(model)?.joints {
            if let Some(b) = j.backlash {
                self.hold(j.axis, b.positive, None);
            }
        }
        Ok(())
    }

    fn hold(&mut self, axis: usize, half_gap: GapCurve, ci95: Option<[f64; 2]>) {
        self.known.retain(|k| k.axis != axis);
        self.known.push(Known { axis, half_gap, ci95 });
    }
}

/// The document, and what reports want beyond it.
#[derive(Debug, Clone)]
pub struct PathFound {
    pub gaps: Gaps,
    pub details: Vec<JointDetail>,
    pub reversals: Vec<Reversal>,
    pub traces: Vec<Trace>,
    /// Noise of a coordinate of a row, m; inflation of the variance by correlated residuals.
    pub sigma_m: f64,
    pub inflation: f64,
    /// Rigid errors of the links were fitted beside the frame.
    pub links: bool,
}

/// More about a joint.
#[derive(Debug, Clone)]
pub struct JointDetail {
    pub axis: usize,
    /// F of the test for stiction.
    pub stiction_f: Option<f64>,
    pub stiction: Option<StictionInterval>,
    /// The decay is one for all joints.
    pub shared_decay: bool,
    pub held: bool,
}

/// Identifies from one or more logs of one robot.
pub fn identify(robot: &Robot, logs: &[Log], options: &Options) -> Result<PathFound> {
    for (k, log) in logs.iter().enumerate() {
        // a log that was not read from bytes has no hash
        if !log.sha256.is_empty() && logs[..k].iter().any(|l| l.sha256 == log.sha256) {
            let expected = "each log once: its reversals would count twice";
            return Err(Error::bad(Place::file(&log.name), "a log that was given before (same SHA-256)", expected));
        }
    }
    let mut binned = Vec::with_capacity(logs.len());
    let mut notes = Vec::new();
    for log in logs {
        let moving = prepare::moving(log, robot);
        let free: Vec<usize> =
            moving.iter().copied().filter(|a| options.free.is_empty() || options.free.contains(a)).collect();
        if free.is_empty() {
            let names =
                |axes: &[usize]| axes.iter().map(|&a| robot.axis(a).name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(Error::bad(
                Place::file(&log.name),
                format!("movement of {}", if moving.is_empty() { "no joint".into() } else { names(&moving) }),
                if options.free.is_empty() {
                    "a joint that moves".into()
                } else {
                    format!("movement of {}", names(&options.free))
                },
            ));
        }
        // a joint that reverses has lost motion whether it is asked for or not: left out, it would bend the gaps of the others
        let b = prepare::prepare(log, robot, &moving)?;
        for j in b.joints.iter().filter(|j| !j.reverses() && free.contains(&j.axis)) {
            notes.push(format!(
                "{}: {} never reverses: its lost motion cannot be seen",
                log.name,
                robot.axis(j.axis).name
            ));
        }
        if b.outliers + b.lost > 0 {
            notes.push(format!(
                "{}: {} of {} rows without a measurement, {} outliers left out",
                log.name,
                b.lost,
                log.len(),
                b.outliers
            ));
        }
        binned.push(b);
    }
    let held: Vec<(usize, GapCurve)> = options.known.iter().map(|k| (k.axis, k.half_gap.clone())).collect();
    let mut problem = Problem::new(binned, &held);
    let asked = |axis: usize| options.free.is_empty() || options.free.contains(&axis);
    if let Some(log) = logs.first()
        && !problem.joints.iter().any(|j| asked(j.axis))
    {
        let expected = "a path on which a joint of interest turns round at least once";
        return Err(Error::bad(Place::file(&log.name), "no joint that reverses", expected));
    }
    let selected = select::select(&mut problem);
    if !selected.reason.converged() {
        let expected = "a path that determines the gaps: shorter logs, fewer joints, or a start nearer to the truth";
        let found = format!("a fit that did not converge ({})", selected.reason.text());
        return Err(Error::bad(Place::file(logs.first().map_or("logs", |l| &l.name)), found, expected));
    }
    if selected.inflation > MISTRUST {
        mirror::refuse(&problem, &selected, &held)?;
        // correlated residuals widen intervals; a residual of another order than the noise says that the model is another's
        let note = if gross(&problem, &selected) {
            format!(
                "{DISTRUSTED} (variance inflated {:.1} times), the gaps cannot be trusted: check {}the order and sign of the x, y, z \
                 columns, units and the robot file",
                selected.inflation,
                if held.is_empty() { "" } else { "the gaps given as known, " }
            )
        } else {
            format!(
                "the residuals are correlated (variance inflated {:.1} times: a ripple, a drift, friction of another form); intervals are \
                 widened by it",
                selected.inflation
            )
        };
        notes.insert(0, note);
    }
    let unit_variance = selected.cost / selected.dof;
    let variance = unit_variance * selected.inflation;
    let cov = Covariance::new(&problem, &selected.values, &selected.form, variance);
    let t95 = student::factor(0.95, selected.dof);
    let (reversals, alike) = reversal::reversals(&problem, &selected.values, &selected.form.sticky, variance)
        .unwrap_or_else(|| {
            notes.push("too many reversals to list the gap at each of them".into());
            (Vec::new(), Vec::new())
        });
    let reversals: Vec<Reversal> = reversals.into_iter().filter(|r| asked(problem.joints[r.joint].axis)).collect();
    let mut joints = Vec::new();
    let mut details = Vec::new();
    for g in (0..problem.joints.len()).filter(|&g| asked(problem.joints[g].axis)) {
        let (mut gap, detail) = joint(g, &problem, &selected, &cov, t95);
        if let Some(ci95) = options.known.iter().find(|k| k.axis == gap.axis).and_then(|k| k.ci95) {
            // the width is that of the held document; the middle that of this path
            let wide = (ci95[1] - ci95[0]) / 2.0;
            gap.ci95 = [(gap.half_gap - wide).max(0.0), gap.half_gap + wide];
            gap.significant = gap.half_gap > wide;
        }
        if selected.inflation > MISTRUST {
            gap.significant &= gap.half_gap > MISTRUST_MARGIN * (gap.ci95[1] - gap.half_gap);
        }
        let name = &robot.axis(gap.axis).name;
        let kind = robot.axis(gap.axis).kind;
        let unit = kind.unit();
        if let Some(s) = &detail.stiction {
            notes.push(format!(
                "{name}: the lag {:.2} s behind a reversal is known best: {:.6} {unit}, 95 % {:.6} to {:.6}",
                s.best_s,
                kind.to_edge(s.lag),
                kind.to_edge(s.lag_ci95[0]),
                kind.to_edge(s.lag_ci95[1])
            ));
            if s.relative > SEPARABLE {
                notes.push(format!("{name}: spike and decay cannot be told apart with this log; trust the lag above"));
            }
        }
        if let Some(a) = alike.iter().find(|a| a.joint == g) {
            let p = chi_squared::tail(a.chi2, a.dof);
            if p < 1e-3 {
                notes.push(format!(
                    "{name}: the gaps at its reversals differ by more than their uncertainty (p = {p:.1e})"
                ));
            }
        }
        joints.push(gap);
        details.push(detail);
    }
    if selected.inflation > ALARM && selected.inflation <= MISTRUST {
        notes.push(format!(
            "the residuals hang together (variance inflated {:.1} times): a gap that varies, a drift, or another effect is not in the model; \
             intervals are too narrow",
            selected.inflation
        ));
    }
    if detail_shared(&details) {
        notes.push("the joints with stiction share one decay: the log does not tell theirs apart".into());
    }
    notes.push(if problem.links {
        "rigid errors of the links were fitted beside the tracker's frame".into()
    } else {
        "no sign of rigid errors of the links: the tracker's frame alone was fitted beside the lost motion".to_string()
    });
    let (mut within, mut rest, mut rows) = (0.0, 0.0, 0usize);
    for (l, log) in problem.logs().enumerate() {
        within += log.within_m2;
        rest += problem.residual(l, &selected.values).iter().map(|r| r.norm_squared()).sum::<f64>()
            / problem.scale(l).powi(2);
        rows += log.good;
    }
    let rms_m = ((within + rest) / (3.0 * rows.max(1) as f64)).sqrt();
    let points = reversals
        .iter()
        .map(|r| GapPoint {
            axis: problem.joints[r.joint].axis,
            at: r.at,
            half_gap: r.half_gap,
            ci95: [r.half_gap - t95 * r.sigma, r.half_gap + t95 * r.sigma],
            cycles: 1,
            per_cycle: vec![r.half_gap],
        })
        .collect();
    let mut speeds: Vec<f64> = problem.logs().filter_map(|l| l.speed_m_s).collect();
    let gaps = Gaps {
        estimate: None,
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        logs: logs.iter().map(|l| LogRef { name: l.name.clone(), sha256: l.sha256.clone() }).collect(),
        registration: registration(&problem, &selected, rms_m, variance, &mut notes),
        points,
        joints,
        tcp_speed_m_s: crate::numerics::robust::median_of(&mut speeds),
        notes,
    };
    Ok(PathFound {
        gaps,
        details,
        traces: trace::traces(&problem, &selected.values).into_iter().filter(|t| asked(t.axis)).collect(),
        reversals,
        sigma_m: rms_m,
        inflation: selected.inflation,
        links: problem.links,
    })
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

fn detail_shared(details: &[JointDetail]) -> bool {
    details.iter().any(|d| d.shared_decay)
}

/// A joint's entry of the document, and the rest.
fn joint(g: usize, problem: &Problem, s: &Selected, cov: &Covariance, t95: f64) -> (JointGap, JointDetail) {
    let j = &problem.joints[g];
    let v = &s.values[g];
    let stiction = if s.form.sticky[g] { interval::stiction(cov, g, v, t95) } else { None };
    let (half_gap, sigma, schedule) = match &j.held {
        Some(curve) => (solve::mean_gap(problem, g, v), 0.0, curve.constant().is_none().then(|| curve.clone())),
        None if v.c.len() == 1 => {
            (v.c[0], cov.place(Name::Gap { joint: g, power: 0 }).map_or(0.0, |k| cov.sigma(&[(k, 1.0)])), None)
        }
        None => {
            // mean over the travel: even powers of x only
            let weight = |k: usize| if k.is_multiple_of(2) { 1.0 / (k as f64 + 1.0) } else { 0.0 };
            let mean = v.c.iter().enumerate().map(|(k, c)| c * weight(k)).sum();
            let parts: Vec<(usize, f64)> = (0..v.c.len())
                .filter_map(|power| cov.place(Name::Gap { joint: g, power }).map(|p| (p, weight(power))))
                .collect();
            (mean, cov.sigma(&parts), Some(polynomial(&v.c, j.center, j.half)))
        }
    };
    let ci95 = [(half_gap - t95 * sigma).max(0.0), half_gap + t95 * sigma];
    let gap = JointGap {
        axis: j.axis,
        half_gap,
        ci95,
        significant: half_gap - t95 * sigma > 0.0,
        sides: None,
        schedule,
        varies_p_value: s.varies_p[g],
        stiction: stiction.map(|i| StictionFound {
            spike: v.spike,
            ci95: i.spike_ci95,
            decay: Decay::Time(v.tau_s),
            decay_ci95: i.tau_ci95_s,
        }),
        stiction_p_value: s.stiction_p[g],
    };
    let detail = JointDetail {
        axis: j.axis,
        stiction_f: s.stiction_f[g],
        stiction,
        shared_decay: s.form.shared && s.form.sticky[g],
        held: j.held.is_some(),
    };
    (gap, detail)
}

/// `sum c_k ((p - center)/half)^k` as a polynomial in `p`.
fn polynomial(c: &[f64], center: f64, half: f64) -> GapCurve {
    let mut out = vec![0.0; c.len()];
    let mut power = vec![1.0];
    for ck in c {
        for (o, x) in out.iter_mut().zip(&power) {
            *o += ck * x;
        }
        let mut next = vec![0.0; power.len() + 1];
        for (k, x) in power.iter().enumerate() {
            next[k] -= x * center / half;
            next[k + 1] += x / half;
        }
        power = next;
    }
    GapCurve::Polynomial { coefficients: out, range: [center - half, center + half] }
}

/// The frame of the first log.
fn registration(
    problem: &Problem,
    s: &Selected,
    rms_m: f64,
    variance: f64,
    notes: &mut Vec<String>,
) -> Option<Registered> {
    let log = problem.logs().next()?;
    let (_, cov) = problem.frame_error(0, &s.values);
    // the covariance is about the middle of the path; the frame's origin is elsewhere
    let centre = log.want.iter().sum::<nalgebra::Vector3<f64>>() / log.want.len().max(1) as f64;
    let arm = centre - log.frame.translation.vector;
    let turn = cov.fixed_view::<3, 3>(3, 3).into_owned();
    let cross = arm.cross_matrix();
    let mixed = cov.fixed_view::<3, 3>(0, 3) * cross.transpose();
    let shift = cov.fixed_view::<3, 3>(0, 0) + cross * turn * cross.transpose() + mixed + mixed.transpose();
    let frame = log.frame.inverse();
    // world frame -> tracker frame
    let r = frame.rotation.to_rotation_matrix();
    let shift = r.matrix() * shift * r.matrix().transpose() * variance;
    let turn = r.matrix() * turn * r.matrix().transpose() * variance;
    if problem.logs().len() > 1 {
        notes.push(format!(
            "{} logs were fitted together, each with a frame of its own; the frame given is the first log's",
            problem.logs().len()
        ));
    }
    let root = |k: usize, m: &nalgebra::Matrix3<f64>| m[(k, k)].max(0.0).sqrt();
    Some(Registered {
        frame,
        rms_m,
        samples: problem.logs().map(|l| l.good).sum(),
        sigma_m: [0, 1, 2].map(|k| root(k, &shift)),
        sigma_rad: [0, 1, 2].map(|k| root(k, &turn)),
    })
}
