//! Programs of the demo: rewritten, executed on the bundled machine, assessed.

use crate::assess::circle::joints::NominalJoints;
use crate::assess::circle::{Measured, Nominal};
use crate::cli::exit::no;
use crate::compensator::Compensator;
use crate::identify::path::PathFound;
use crate::io::output::{Durability, Output, write_whole};
use crate::log::Log;
use crate::model::Model;
use crate::program::Program;
use crate::program::files::Files;
use crate::rewrite::guard::{Named, Notes};
use crate::rewrite::job::Job;
use crate::rewrite::outcome::Target;
use crate::rewrite::script::Choices;
use crate::rewrite::script::context::Contexts;
use crate::rewrite::{Options, Points, printed};
use crate::robot::Robot;
use crate::simulate::{self, Motion, Timing, predicted};
use anyhow::Result;
use std::fmt::Write;
use std::path::Path;

/// Noise of a laser tracker 3 m away (Zhang (2023) section 3.1: 22 um at two sigma).
const NOISE_M: f64 = 11e-6;

/// Rewrites one file into another, as the command does.
pub fn rewrite(robot: &Robot, compensator: &Compensator, options: Options, from: &Path, to: &Path) -> Result<()> {
    let job = Job {
        files: Files::Disk,
        contexts: Contexts::default(),
        format: None,
        choices: Choices::default(),
        tolerance: None,
        durability: Durability::Synced,
        notes: Notes::default(),
        robot,
        compensator,
        source: Named { name: "compensator.yaml".into(), sha256: String::new() },
        deadband: vec![None; robot.dof()],
        decimals: None,
        said: Vec::new(),
        options,
        // the folder may hold an earlier demo
        force: true,
        replace: false,
        hash: false,
        threads: true,
        all_changes: false,
    };
    job.run(from, Target::File(to), &|_| ())?.refusal.map_or(Ok(()), |r| Err(no(r)))
}

/// Rewrites with the equations as printed.
pub fn rewrite_as_printed(robot: &Robot, compensator: &Compensator, from: &Path, to: &Path) -> Result<()> {
    let program = program(robot, from)?;
    let mut points = Points { axes: robot.dof(), ..Points::default() };
    let mut q = vec![0.0; robot.dof()];
    for i in 0..program.len() {
        program.point_into(i, &mut q);
        points.q.extend_from_slice(&q);
    }
    let out = printed::rewrite(&points, compensator, 0.1);
    let joints: Vec<_> = robot.axis_joints().collect();
    let names: Vec<String> = joints.iter().map(|j| format!("{}_{}", j.name.to_lowercase(), j.kind.unit())).collect();
    let mut text = names.join(",") + "\n";
    for i in 0..out.len() {
        let row: Vec<String> =
            out.row(i).iter().zip(&joints).map(|(v, j)| format!("{:.6}", j.kind.to_user_unit(*v))).collect();
        let _ = writeln!(text, "{}", row.join(","));
    }
    write_whole(to, text.as_bytes()).map_err(Into::into)
}

fn program(robot: &Robot, path: &Path) -> Result<Program> {
    Program::load(path, robot).map_err(Into::into)
}

/// Executes a program on the machine and writes its log.
pub fn run(machine: &Model, from: &Path, to: &Path) -> Result<Log> {
    let options = simulate::Options { noise_m: NOISE_M, ..simulate::Options::default() };
    let program = program(&machine.robot, from)?;
    let timing = Timing::at_speed(&machine.robot, &program, options.speed_m_s);
    let motion = Motion::of_program(machine, &program, &timing.t_s, options.rate_hz)?;
    let mut out = Output::create(to)?;
    let name = from.file_name().map(crate::io::name::text_of_name).unwrap_or_default();
    predicted::write_program_log(machine, &motion, &options, &name, &mut out)?;
    out.commit()?;
    log(&machine.robot, to)
}

/// Reads a log that [`run`] wrote.
pub fn log(robot: &Robot, path: &Path) -> Result<Log> {
    Log::load(path, robot).map_err(Into::into)
}

/// Points of the program, errors of its log against the nominal circle, and that circle.
pub fn assess(robot: &Robot, nominal: &Path, from: &Path, log: &Log) -> Result<(usize, Measured, Nominal)> {
    let plan = Nominal::new(robot, &program(robot, nominal)?)?;
    let measured = Measured::new(robot, &plan, log)?;
    Ok((program(robot, from)?.len(), measured, plan))
}

/// Turns the joint errors of a compensated run into those against the nominal program at the same place.
pub fn against_nominal(robot: &Robot, plan: &Nominal, nominal: &Path, found: &mut PathFound) -> Result<()> {
    let wanted = NominalJoints::new(robot, plan, &program(robot, nominal)?);
    let Some(rows) = found.traces.iter().map(|t| t.t_s.len()).min() else { return Ok(()) };
    let mut q = wanted.first().to_vec();
    let tcp: Vec<_> = (0..rows)
        .map(|i| {
            for t in &found.traces {
                q[t.axis] = t.command[i] + t.error[i];
            }
            robot.tcp_m(&q)
        })
        .collect();
    let phases = plan.phases_deg(&tcp);
    for t in &mut found.traces {
        for (i, phase) in phases.iter().enumerate() {
            let by = wanted.at(t.axis, *phase).map_or(f64::NAN, |n| t.command[i] - n);
            t.error[i] += by;
        }
        t.fitted.clear();
    }
    Ok(())
}
