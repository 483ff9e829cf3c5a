//! The command line: one file per command, each `arguments -> load -> call -> write`, no mathematics.
//!
//! Read in this order:
//! - [`process`]: arguments in, exit code out; [`global`]: options of every command; [`help`]: help that wraps; [`usage`]: tips
//!   beside usage errors; `streams`: names of standard input and output; [`exit`]: errors as they are printed, and their exit codes;
//!   [`signals`]: what ends a run early;
//!   [`console`]: standard error, [`print`]: standard output; [`progress`]: that a long run is alive.
//! - [`paths`], [`logs`]: what is checked before anything is read; logs, read and found plausible.
//! - The job: [`identify`] with [`identify_path`], [`fit`], [`rewrite`], [`undo`]; [`simulate`] and [`assess`] show what remains;
//!   [`demo`] runs all of it.
//! - Many programs on many machines: [`manifest`], [`merge`], [`status`].
//! - A machine to learn more about: [`diagnose`], [`plan_experiment`] with [`plan_recording`], [`learn`], [`track`].
//! - Files: [`robot`], [`columns`], [`join`], [`schema`], [`show`]; [`page`]: results as pages; [`completions`].

#![warn(missing_docs)]
// doc comments of arguments are help texts, with <placeholders>
#![allow(rustdoc::invalid_html_tags)]

// first: its macros `eprint!` and `eprintln!` replace those of the standard library
#[macro_use]
pub mod console;
pub(crate) mod assess;
pub(crate) mod columns;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub mod exit;
pub(crate) mod fit;
pub(crate) mod global;
pub mod help;
pub(crate) mod identify;
pub(crate) mod identify_path;
pub(crate) mod join;
pub(crate) mod learn;
pub(crate) mod logs;
pub(crate) mod manifest;
pub(crate) mod merge;
pub mod page;
pub(crate) mod paths;
pub(crate) mod plan_experiment;
pub(crate) mod plan_recording;
pub(crate) mod print;
pub mod process;
pub(crate) mod progress;
pub(crate) mod rewrite;
pub(crate) mod robot;
pub(crate) mod schema;
pub(crate) mod show;
mod signals;
pub(crate) mod simulate;
pub(crate) mod status;
mod streams;
pub(crate) mod track;
pub(crate) mod undo;
mod usage;

use anyhow::Result;
use clap::{Parser, Subcommand};
use exit::Finished;

/// Takes lost motion (backlash, stiction) out of robot programs before they reach the controller.
///
/// The job has four steps: `identify` estimates the half gap of each joint from laser-tracker logs, `fit` turns the gaps
/// into a compensator, `rewrite` adds reversal points and offsets to a program, and `simulate` and `assess` show the error
/// that remains.
#[derive(Debug, Parser)]
#[command(name = "lostmotion", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Examples:
  lostmotion demo
  lostmotion identify static --robot robot.yaml --log axis1.csv --log axis2.csv --output gaps.yaml
  lostmotion fit --robot robot.yaml --gaps gaps.yaml --output compensator.yaml
  lostmotion rewrite --robot robot.yaml --compensator compensator.yaml program.csv --output out.csv

Exit codes: 0: done; 1: the answer is no (a joint limit would be exceeded, or a check found a difference); 2: wrong usage or input, and nothing was written.")]
pub struct Cli {
    #[allow(missing_docs)]
    #[command(subcommand)]
    pub command: Command,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub global: global::Args,
}

#[derive(Debug, Subcommand)]
// a doc comment here would be printed as help: the help of each command stands with its arguments
#[allow(missing_docs)]
pub enum Command {
    Identify(identify::Args),
    Fit(fit::Args),
    Rewrite(Box<rewrite::Args>),
    Undo(undo::Args),
    Manifest(manifest::Args),
    Merge(merge::Args),
    Status(status::Args),
    Simulate(simulate::Args),
    Assess(assess::Args),
    Diagnose(diagnose::Args),
    PlanExperiment(plan_experiment::Args),
    Learn(learn::Args),
    Track(track::Args),
    Robot(robot::Args),
    Join(join::Args),
    Columns(columns::Args),
    Show(show::Args),
    Schema(schema::Args),
    Demo(demo::Args),
    Completions(completions::Args),
}

/// Runs a parsed command line.
pub fn run(cli: Cli) -> Result<Finished> {
    cli.global.apply();
    let started = std::time::Instant::now();
    let finished = dispatch(cli.command);
    global::print_cost(started.elapsed());
    finished
}

fn dispatch(command: Command) -> Result<Finished> {
    let done = match command {
        Command::Identify(a) => identify::run(a),
        Command::Fit(a) => fit::run(a),
        Command::Rewrite(a) => return rewrite::run(*a),
        Command::Undo(a) => undo::run(a),
        Command::Manifest(a) => manifest::run(a),
        Command::Merge(a) => merge::run(a),
        Command::Status(a) => status::run(a),
        Command::Simulate(a) => simulate::run(a),
        Command::Assess(a) => assess::run(a),
        Command::Diagnose(a) => diagnose::run(a),
        Command::PlanExperiment(a) => plan_experiment::run(a),
        Command::Learn(a) => learn::run(a),
        Command::Track(a) => track::run(a),
        Command::Robot(a) => robot::run(a),
        Command::Join(a) => join::run(a),
        Command::Columns(a) => columns::run(a),
        Command::Show(a) => show::run(a),
        Command::Schema(a) => schema::run(a),
        Command::Demo(a) => demo::run(a),
        Command::Completions(a) => completions::run(a),
    };
    done.map(|()| Finished::Done)
}
