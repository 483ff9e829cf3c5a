//! The command line: one file per command, each `arguments -> load -> call -> write`, no mathematics.

// doc comments of arguments are help texts, with <placeholders>
#![allow(rustdoc::invalid_html_tags)]

// first: its macros `eprint!` and `eprintln!` replace those of the standard library
#[macro_use]
pub mod console;
pub mod assess;
pub mod completions;
pub mod demo;
pub mod diagnose;
pub mod exit;
pub mod fit;
pub mod global;
pub mod help;
pub mod identify;
pub mod identify_path;
pub mod join;
pub mod learn;
pub mod logs;
pub mod manifest;
pub mod merge;
pub mod page;
pub mod paths;
pub mod plan_experiment;
pub mod plan_recording;
pub mod process;
pub mod progress;
pub mod rewrite;
pub mod robot;
pub mod schema;
pub mod show;
pub mod simulate;
pub mod status;
pub mod track;
pub mod undo;

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
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub global: global::Args,
}

#[derive(Debug, Subcommand)]
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
        Command::Show(a) => show::run(a),
        Command::Schema(a) => schema::run(a),
        Command::Demo(a) => demo::run(a),
        Command::Completions(a) => completions::run(a),
    };
    done.map(|()| Finished::Done)
}
