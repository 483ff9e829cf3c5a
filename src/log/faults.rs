//! What may be wrong with the units, signs and order of a log's columns, and the path with that put right: for plausibility checks.
//!
//! Each fault is tried alone, over some hundred rows with a measured TCP. How it fails: two faults at once are neither.

use super::Log;
use super::note::Mistake;
use super::shape::{Fit, fit, spread};
use crate::numerics::robust;
use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;

/// Rows compared: enough to average noise, few enough to try dozens of faults in milliseconds.
const ROWS: usize = 600;
/// A zero offset of a joint is smaller than this, rad or m.
const OFFSET: f64 = 0.17;

/// Rows with a measured TCP, evenly spread over what the joints travel.
pub(super) struct Sample {
    pub rows: Vec<usize>,
    pub commands: Vec<Vec<f64>>,
    pub measured: Vec<Vector3<f64>>,
}

impl Sample {
    pub fn take(log: &Log) -> Self {
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

    /// Rows of the stretch on which `axis` travels farthest while no other joint moves.
    pub fn of_joint_alone(log: &Log, axis: usize) -> Self {
        let rests = |i: usize| log.cmd.iter().enumerate().all(|(a, c)| a == axis || c[i] == c[i - 1]);
        let (mut best, mut most, mut from) = (0..0, 0.0, 0);
        for i in 1..=log.len() {
            if i < log.len() && rests(i) {
                continue;
            }
            let travelled = travel(&log.cmd[axis][from..i]);
            if travelled > most {
                (best, most) = (from..i, travelled);
            }
            from = i;
        }
        let step = (best.len() / ROWS).max(1);
        let mut sample = Self { rows: Vec::new(), commands: Vec::new(), measured: Vec::new() };
        for row in best.step_by(step) {
            if let Some(p) = log.tcp_m.get(row).copied().flatten() {
                sample.rows.push(row);
                sample.commands.push(log.command(row));
                sample.measured.push(p);
            }
        }
        sample
    }

    pub fn computed(&self, robot: &Robot) -> Vec<Vector3<f64>> {
        self.commands.iter().map(|q| robot.tcp_m(q)).collect()
    }
}

/// Largest value less the smallest.
fn travel(values: &[f64]) -> f64 {
    robust::spread(values.iter().copied())
}

/// One thing that may be wrong with the file.
#[derive(Clone, Copy)]
pub(crate) enum Fault {
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
    /// and only on joints that move or that it would turn by more than a zero offset may: a small offset of a
    /// stationary joint looks like many things.
    pub fn all(robot: &Robot, commands: &[Vec<f64>]) -> Vec<Self> {
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
        let moves = |axis: usize| travel(&commands[axis]) > 0.01 * OFFSET;
        if (0..robot.dof()).filter(|&a| moves(a)).count() < 2 {
            return faults;
        }
        for a in 0..robot.dof() {
            let rest = commands[a].first().map_or(0.0, |v| v.abs());
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
        let mean = |a: usize| commands[a].iter().sum::<f64>() / commands[a].len().max(1) as f64;
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
    pub(super) fn corrected(self, robot: &Robot, sample: &Sample, computed: &[Vector3<f64>]) -> Fit {
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
            Self::Command { .. } | Self::Sign(_) | Self::Swapped(..) => commands(&|q| self.put_right(robot, q)),
        }
    }

    /// Puts a joint vector right.
    pub fn put_right(self, robot: &Robot, q: &mut [f64]) {
        match self {
            Self::Command { axis, kind, factor, .. } => {
                for (a, v) in q.iter_mut().enumerate() {
                    if axis.is_none_or(|x| x == a) && robot.axis(a).kind == kind {
                        *v *= factor;
                    }
                }
            }
            Self::Sign(a) => q[a] = -q[a],
            Self::Swapped(a, b) => q.swap(a, b),
            Self::Tcp { .. } | Self::Mirrored => {}
        }
    }

    /// A measured point put right, in a frame that may be mirrored.
    pub fn put_point_right(self, p: Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Tcp { factor, .. } => p / factor,
            Self::Mirrored => Vector3::new(-p.x, p.y, p.z),
            Self::Command { .. } | Self::Sign(_) | Self::Swapped(..) => p,
        }
    }

    /// The commands are wrong, not the measured points.
    pub fn is_of_commands(self) -> bool {
        matches!(self, Self::Command { .. } | Self::Sign(_) | Self::Swapped(..))
    }

    /// The fault is that of one joint's unit.
    pub fn is_of_one_joint(self) -> bool {
        matches!(self, Self::Command { axis: Some(_), .. })
    }

    /// A unit is wrong, which no kinematics explains. One of a joint at rest may be.
    pub fn is_of_units(self, log: &Log) -> bool {
        match self {
            Self::Tcp { .. } => true,
            Self::Command { axis, .. } => axis.is_none_or(|a| log.travel(a) > 0.01 * OFFSET),
            Self::Mirrored | Self::Sign(_) | Self::Swapped(..) => false,
        }
    }

    /// The same of joint `axis` of this kind; `None`: the fault is not one of this joint's unit.
    pub fn of_joint(self, axis: usize, kind: JointKind) -> Option<Self> {
        match self {
            Self::Command { axis: Some(a), kind: of, factor, unit } if a == axis && of == kind => {
                Some(Self::Command { axis: Some(a), kind, factor, unit })
            }
            _ => None,
        }
    }

    /// Size of the measured path over that of the computed one, with the fault put right; `None` where a fault is no matter of size.
    /// Of a single joint's unit it says something on a path on which no other joint moves.
    pub(super) fn ratio(self, robot: &Robot, sample: &Sample, computed: &[Vector3<f64>]) -> Option<f64> {
        let measured = spread(&sample.measured);
        match self {
            Self::Tcp { factor, .. } => Some(measured / factor / spread(computed)),
            Self::Command { .. } => {
                let right = |q: &Vec<f64>| {
                    let mut q = q.clone();
                    self.put_right(robot, &mut q);
                    robot.tcp_m(&q)
                };
                Some(measured / spread(&sample.commands.iter().map(right).collect::<Vec<_>>()))
            }
            _ => None,
        }
    }

    /// Measured coordinates a thousand times too large.
    pub fn is_thousandfold(self) -> bool {
        matches!(self, Self::Tcp { unit: "micrometres", .. })
    }

    /// The entry of a column map that puts the fault right; `None`: no single entry does.
    pub fn mended(self, robot: &Robot) -> Option<String> {
        let of = |axis: usize, kind: JointKind, what: &str| {
            let column = format!("cmd_{}_{}", robot.axis(axis).name, kind.unit());
            format!("{column}: {{to: {column}, {what}}}")
        };
        let short = |unit: &str| match unit {
            "metres" => "unit: m",
            "micrometres" => "unit: um",
            "inches" => "unit: in",
            _ => "unit: rad",
        };
        match self {
            Self::Tcp { unit, .. } => Some(format!("x_mm: {{to: x_mm, {}}}, the same for y and z", short(unit))),
            Self::Command { axis: Some(a), kind, unit, .. } => Some(of(a, kind, short(unit))),
            Self::Command { axis: None, kind, unit, .. } => {
                let first = (0..robot.dof()).find(|&a| robot.axis(a).kind == kind)?;
                Some(format!("{}, the same for the others", of(first, kind, short(unit))))
            }
            Self::Sign(a) => Some(of(a, robot.axis(a).kind, "sign: -1")),
            Self::Mirrored | Self::Swapped(..) => None,
        }
    }

    pub fn named(self, robot: &Robot) -> Mistake {
        let name = |a: usize| robot.axis(a).name.clone();
        match self {
            Self::Tcp { unit: "micrometres", .. } => Mistake::Thousandfold,
            Self::Tcp { unit, .. } => Mistake::TcpUnit { unit },
            Self::Mirrored => Mistake::Mirrored,
            Self::Command { axis: None, unit, .. } => Mistake::CommandUnit { unit },
            Self::Command { axis: Some(a), unit, .. } => Mistake::JointUnit { joint: name(a), unit },
            Self::Sign(a) => Mistake::Sign { joint: name(a) },
            Self::Swapped(a, b) => Mistake::Swapped { joints: [name(a), name(b)] },
        }
    }
}
