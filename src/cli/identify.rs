//! `lostmotion identify`: one file per way to find gaps.
//!
//! [`common`] has the arguments and results of all of them; [`machine`] takes all logs together. Of one kind of test each: [`static_`],
//! [`identify_path`](super::identify_path), [`deadzone`], [`screw`].

pub(crate) mod common;
pub(crate) mod deadzone;
pub(crate) mod machine;
pub(crate) mod screw;
pub(crate) mod static_;

use crate::cli::exit::bad;
use crate::error::Place;
use anyhow::Result;
use clap::Subcommand;
use std::path::PathBuf;

/// Estimate the half gaps and the friction of the joints from measurement logs.
///
/// Without a subcommand, all logs of a machine are fitted together: any number of bidirectional dwell tests, paths and
/// excitation motions, with the TCP of a tracker, the distance of a ballbar (r_mm, r_um) or the reading of a dial gauge
/// (dial_um). The fit estimates the half gap of every joint over its position, its friction (which builds up with
/// travel after a reversal, until the servo corrects it), its wind-up, the geometry, the tracker's frame and the time lags,
/// all with their covariance. Each subcommand evaluates one kind of test alone.
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
    pub setups: common::SetupsArgs,
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
        (None, Some(robot)) => {
            machine::run(machine::Args { robot, input: args.input, setups: args.setups, result: args.result })
        }
        (None, None) => Err(bad(Place::file("--robot"), "no robot and no log", "--robot FILE --log FILE")),
    }
}
