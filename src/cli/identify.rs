//! `lostmotion identify`: one file per way to find gaps.

pub mod common;
pub mod deadzone;
pub mod machine;
pub mod screw;
pub mod static_;

use crate::cli::exit::bad;
use crate::error::Place;
use anyhow::Result;
use clap::Subcommand;
use std::path::PathBuf;

/// Find half gaps and friction of the joints in measurement logs.
///
/// Without a subcommand all logs of a machine are fitted together: bidirectional dwells, paths, excitation, any number of
/// each. Every joint's half gap over position, its friction (which builds up over travel after a reversal and is worked off by
/// the servo), its wind-up, the geometry, the tracker's frame and the lags are estimated at once, with their covariance. The
/// subcommands evaluate one kind of test alone.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:
  lostmotion identify --robot robot.yaml --log static_A1.csv --log static_A2.csv --log circle.csv --log excitation.csv --output machine.yaml
  lostmotion identify static --robot robot.yaml --log axis1.csv --output gaps.yaml"
)]
pub struct Args {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE", required = true)]
    pub robot: Option<PathBuf>,
    #[command(flatten)]
    pub input: common::LogArgs,
    #[command(flatten)]
    pub result: common::ResultArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Static(static_::Args),
    Path(Box<super::identify_path::Args>),
    Deadzone(deadzone::Args),
    Screw(screw::Args),
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    match (args.command, args.robot) {
        (Some(Command::Static(a)), _) => static_::run(a),
        (Some(Command::Path(a)), _) => super::identify_path::run(*a),
        (Some(Command::Deadzone(a)), _) => deadzone::run(a),
        (Some(Command::Screw(a)), _) => screw::run(a),
        (None, Some(robot)) => machine::run(machine::Args { robot, input: args.input, result: args.result }),
        (None, None) => Err(bad(Place::file("--robot"), "no robot and no log", "--robot FILE --log FILE")),
    }
}
