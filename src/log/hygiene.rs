//! Units, axes and clocks that cannot be right: found before anything is computed from a log.
//!
//! Method: the path computed from the commands and the measured one are compared in shape (any rigid frame). Only where
//! they differ by more than 1 in 500 of their size are faults tried, one at a time: TCP in metres, micrometres or inches;
//! commands in radians (all, or one joint's), in metres or inches; a mirrored frame (a TCP axis swapped or of the wrong
//! sign); a command column of the wrong sign, or two of them swapped; clocks apart. A fault is reported where it explains
//! the difference to a seventh or less, which a wrong guess does not do by chance. A path that no fault explains, and no
//! other TCP in the flange either, is of another robot. Figures on 1,400 changed logs: `docs/log.md`.
//!
//! Assumptions: the lost motion sought is far smaller than the path. What a log cannot tell, it is not asked: a short
//! travel in noise, one joint turning on a circle (its mirror image is the same circle), the unit of one joint where no
//! other moves. Then nothing is said.
//!
//! How it fails: two faults at once may be reported as a path of another robot.

use super::Log;
use super::oddities;
use super::shape::{Fit, fit, fit_with_free_tool, spread};
use crate::error::{Error, Place, Result};
use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;

/// Rows compared: enough to average noise, few enough to try dozens of faults in milliseconds.
const ROWS: usize = 600;
/// Fewest places visited that say something about a shape.
const FEWEST: usize = 10;
/// Part of the path's size (2 mm of 1 m) below which a difference is the business of the effects, not of hygiene.
const BENIGN: f64 = 0.002;
/// A fault explains a difference where this part of it is left, or less.
const EXPLAINED: f64 = 0.15;
/// Part of the path's size above which an unexplained difference means another robot.
const FOREIGN: f64 = 0.25;
/// Size below which a path is not called another robot's, metres.
const SMALLEST_PATH_M: f64 = 0.005;
/// A zero offset of a joint is smaller than this, rad or m.
const OFFSET: f64 = 0.17;
/// Clocks this far apart are two recordings that were not joined; less is an effect (`time_offset`), seconds.
const APART_S: f64 = 0.5;

/// What was found to be in order, and what a reader should know.
#[derive(Debug, Clone, Default)]
pub struct Hygiene {
    /// 75th percentile of the distance between measured and computed path after a rigid fit, metres; `None` where the
    /// log has no TCP columns or too few places.
    pub misfit_m: Option<f64>,
    /// 75th percentile of the distance from the path's centre, metres.
    pub spread_m: f64,
    /// Suspicions that do not stop the work, one sentence each.
    pub notes: Vec<String>,
}

/// Refuses a log whose units, axes or clocks cannot be right for this robot; says what else looks odd.
pub fn check(log: &Log, robot: &Robot) -> Result<Hygiene> {
    let mut found = Hygiene::default();
    oddities::sensors(log, robot, &mut found.notes)?;
    oddities::times(log, robot, &mut found.notes)?;
    oddities::limits(log, robot, &mut found.notes);
    let sample = Sample::take(log);
    if sample.commands.len() >= FEWEST {
        shape(log, robot, &sample, &mut found)?;
    }
    Ok(found)
}

/// Rows with a measured TCP, evenly spread over what the joints travel.
struct Sample {
    rows: Vec<usize>,
    commands: Vec<Vec<f64>>,
    measured: Vec<Vector3<f64>>,
}

impl Sample {
    fn take(log: &Log) -> Self {
        let step = |i: usize| -> f64 { log.cmd.iter().map(|c| (c[i] - c[i - 1]).abs()).sum() };
        let total: f64 = (1..log.len()).map(step).sum();
        let mut sample = Self { rows: Vec::new(), commands: Vec::new(), measured: Vec::new() };
        let (mut travelled, mut due) = (0.0, 0.0);
        for (i, p) in log.tcp_m.iter().enumerate() {
            if i > 0 {
                travelled += step(i);
            }
            if let Some(p) = p
                && travelled >= due
            {
                sample.rows.push(i);
                sample.commands.push(log.command(i));
                sample.measured.push(*p);
                due = travelled + total / ROWS as f64;
                if total == 0.0 {
                    break;
                }
            }
        }
        sample
    }

    fn computed(&self, robot: &Robot) -> Vec<Vector3<f64>> {
        self.commands.iter().map(|q| robot.tcp_m(q)).collect()
    }
}

/// One thing that may be wrong with the file.
#[derive(Clone, Copy)]
enum Fault {
    /// Measured coordinates are `factor` of what they should be.
    Tcp {
        factor: f64,
        unit: &'static str,
    },
    Mirrored,
    /// Commands of all joints of a kind (`axis: None`) or of one, times `factor`.
    Command {
        axis: Option<usize>,
        kind: JointKind,
        factor: f64,
        unit: &'static str,
    },
    Sign(usize),
    Swapped(usize, usize),
}

impl Fault {
    /// What is worth trying, the commonest first. A fault of single joints is tried only where two joints or more move,
    /// and only on joints that move or that it would turn by more than a zero offset may: a small offset of a joint at
    /// rest looks like many things.
    fn all(robot: &Robot, log: &Log) -> Vec<Self> {
        use JointKind::{Prismatic, Revolute};
        let mut faults = vec![
            Self::Tcp { factor: 1e-3, unit: "metres" },
            Self::Tcp { factor: 1e3, unit: "micrometres" },
            Self::Tcp { factor: 1.0 / 25.4, unit: "inches" },
        ];
        let wrong_units = [
            (Revolute, 1_f64.to_degrees(), "radians"),
            (Prismatic, 1e3, "metres"),
            (Prismatic, 25.4, "inches"),
            (Prismatic, 1e-3, "micrometres"),
        ];
        for (kind, factor, unit) in wrong_units {
            if robot.axis_joints().any(|j| j.kind == kind) {
                faults.push(Self::Command { axis: None, kind, factor, unit });
            }
        }
        faults.push(Self::Mirrored);
        let moves = |axis: usize| log.travel(axis) > 0.01 * OFFSET;
        if (0..robot.dof()).filter(|&a| moves(a)).count() < 2 {
            return faults;
        }
        for a in 0..robot.dof() {
            let rest = log.cmd[a].first().map_or(0.0, |v| v.abs());
            let tells = |factor: f64| moves(a) || rest * (factor - 1.0).abs() > OFFSET;
            if tells(-1.0) {
                faults.push(Self::Sign(a));
            }
            for (kind, factor, unit) in wrong_units {
                if robot.axis(a).kind == kind && tells(factor) {
                    faults.push(Self::Command { axis: Some(a), kind, factor, unit });
                }
            }
        }
        let mean = |a: usize| log.cmd[a].iter().sum::<f64>() / log.len().max(1) as f64;
        for a in 0..robot.dof() {
            for b in a + 1..robot.dof() {
                let apart = (mean(a) - mean(b)).abs() > OFFSET && (moves(a) || moves(b));
                if robot.axis(a).kind == robot.axis(b).kind && (apart || moves(a) && moves(b)) {
                    faults.push(Self::Swapped(a, b));
                }
            }
        }
        faults
    }

    /// Fit of the paths with the fault put right.
    fn corrected(self, robot: &Robot, sample: &Sample, computed: &[Vector3<f64>]) -> Fit {
        let commands = |put_right: &dyn Fn(&mut [f64])| {
            let path: Vec<Vector3<f64>> = sample
                .commands
                .iter()
                .map(|q| {
                    let mut q = q.clone();
                    put_right(&mut q);
                    robot.tcp_m(&q)
                })
                .collect();
            fit(&path, &sample.measured, false)
        };
        match self {
            Self::Tcp { factor, .. } => {
                let to: Vec<Vector3<f64>> = sample.measured.iter().map(|p| p / factor).collect();
                let f = fit(computed, &to, false);
                // distances are compared as measured
                Fit { misfit_m: f.misfit_m * factor, ..f }
            }
            Self::Mirrored => fit(computed, &sample.measured, true),
            Self::Command { axis, kind, factor, .. } => commands(&|q| {
                for (a, v) in q.iter_mut().enumerate() {
                    if axis.is_none_or(|x| x == a) && robot.axis(a).kind == kind {
                        *v *= factor;
                    }
                }
            }),
            Self::Sign(a) => commands(&|q| q[a] = -q[a]),
            Self::Swapped(a, b) => commands(&|q| q.swap(a, b)),
        }
    }

    fn said(self, robot: &Robot) -> String {
        let name = |a: usize| robot.axis(a).name.as_str();
        match self {
            Self::Tcp { unit: "micrometres", .. } => {
                "x, y and z are in micrometres, or the lengths of the robot file in metres".into()
            }
            Self::Tcp { unit, .. } => format!("x, y and z are in {unit}"),
            Self::Mirrored => {
                "the measured frame is mirrored: two of x, y and z are swapped, or one has the wrong sign".into()
            }
            Self::Command { axis: None, unit, .. } => format!("the commands are in {unit}"),
            Self::Command { axis: Some(a), unit, .. } => format!("the commands of {} are in {unit}", name(a)),
            Self::Sign(a) => format!("the commands of {} have the wrong sign", name(a)),
            Self::Swapped(a, b) => format!("the commands of {} and {} are swapped", name(a), name(b)),
        }
    }
}

fn shape(log: &Log, robot: &Robot, sample: &Sample, found: &mut Hygiene) -> Result<()> {
    let computed = sample.computed(robot);
    let as_read = fit(&computed, &sample.measured, false);
    let size = spread(&sample.measured).max(spread(&computed));
    found.misfit_m = Some(as_read.misfit_m);
    found.spread_m = size;
    if as_read.misfit_m.is_nan() || as_read.misfit_m <= BENIGN * size {
        return Ok(());
    }
    let moving = log.moving_axes();
    let tried: Vec<(Fault, f64)> =
        Fault::all(robot, log).into_iter().map(|f| (f, f.corrected(robot, sample, &computed).misfit_m)).collect();
    let least = tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
    let fits = "the path that the robot file gives for the commands";
    if least <= EXPLAINED * as_read.misfit_m {
        let alike: Vec<String> = tried.iter().filter(|t| t.1 <= 1.5 * least).take(3).map(|t| t.0.said(robot)).collect();
        let text = format!(
            "a measured path that fits only if {} ({} instead of {} of misfit)",
            alike.join("; or if "),
            millimetres(least),
            millimetres(as_read.misfit_m)
        );
        return Err(Error::bad(Place::file(&log.name), text, fits));
    }
    if let Some((shift_s, left)) = clock(log, robot, sample)
        && left <= EXPLAINED * as_read.misfit_m
    {
        let text = format!(
            "measured positions about {:.2} s {} the commands",
            shift_s.abs(),
            if shift_s > 0.0 { "ahead of" } else { "behind" }
        );
        if shift_s.abs() > APART_S {
            return Err(Error::bad(Place::file(&log.name), text, "one clock for commands and measurement"));
        }
        found.notes.push(text);
        return Ok(());
    }
    if as_read.misfit_m <= FOREIGN * size || moving.len() < 2 || spread(&sample.measured) < SMALLEST_PATH_M {
        return Ok(());
    }
    let frames: Vec<_> = sample.commands.iter().map(|q| robot.forward(q).rotation).collect();
    let (free, offset) = fit_with_free_tool(&computed, &frames, &sample.measured);
    if free.misfit_m <= 0.5 * FOREIGN * size {
        let o = offset * 1e3;
        found.notes.push(format!(
            "the measured point stands {:.1}, {:.1}, {:.1} mm from the robot file's `tool` (in the axes of the tool): check `tool`",
            o.x, o.y, o.z
        ));
        return Ok(());
    }
    let text = format!(
        "a measured path of another shape ({} of misfit on a path of {})",
        millimetres(free.misfit_m),
        millimetres(size)
    );
    Err(Error::bad(
        Place::file(&log.name),
        text,
        format!("{fits}: check robot file, units, order and clock of the columns"),
    ))
}

fn millimetres(m: f64) -> String {
    if m >= 0.01 { format!("{:.0} mm", m * 1e3) } else { format!("{:.3} mm", m * 1e3) }
}

/// Shift in s of the commands that fits the measurement best, and the misfit it leaves; a grid, then halving.
fn clock(log: &Log, robot: &Robot, sample: &Sample) -> Option<(f64, f64)> {
    const STEPS: i32 = 100;
    const LONGEST_S: f64 = 10.0;
    if log.poses {
        return None;
    }
    let t0 = log.t_s.first()?;
    let reach = (0.1 * (log.t_s.last()? - t0)).min(LONGEST_S);
    let thin = (sample.rows.len() / 200).max(1);
    let mut q = vec![0.0; robot.dof()];
    let mut left = |shift: f64| -> f64 {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for (&row, p) in sample.rows.iter().zip(&sample.measured).step_by(thin) {
            let t = log.t_s[row] + shift;
            let k = log.t_s.partition_point(|v| *v <= t).clamp(1, log.len() - 1);
            let w = ((t - log.t_s[k - 1]) / (log.t_s[k] - log.t_s[k - 1])).clamp(0.0, 1.0);
            for (v, c) in q.iter_mut().zip(&log.cmd) {
                *v = c[k - 1] + w * (c[k] - c[k - 1]);
            }
            from.push(robot.tcp_m(&q));
            to.push(*p);
        }
        fit(&from, &to, false).misfit_m
    };
    let mut step = reach / f64::from(STEPS);
    let mut best = (0.0, left(0.0));
    for k in (-STEPS..=STEPS).map(f64::from) {
        let m = left(k * step);
        if m < best.1 {
            best = (k * step, m);
        }
    }
    for _ in 0..12 {
        step *= 0.5;
        let centre = best.0;
        for shift in [centre - step, centre + step] {
            let m = left(shift);
            if m < best.1 {
                best = (shift, m);
            }
        }
    }
    Some(best)
}
