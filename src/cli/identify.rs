//! `lostmotion identify`: one file per way to find gaps.

pub mod common;
pub mod deadzone;
pub mod screw;
pub mod static_;

use crate::error::Result;
use clap::Subcommand;

/// Find half gaps (and stiction) of the joints in measurement logs.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
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
    match args.command {
        Command::Static(a) => static_::run(a),
        Command::Path(a) => super::identify_path::run(*a),
        Command::Deadzone(a) => deadzone::run(a),
        Command::Screw(a) => screw::run(a),
    }
}
