//! `lostmotion assess`: what lost motion costs at the TCP; one file per subcommand.
//!
//! Computed: [`impact`] (of a gap), [`program`] (a program before and after it was changed). Measured: [`circle`], [`deadzone`], both on
//! the logs that `runs` reads, and [`bidirectional`].

pub(crate) mod bidirectional;
pub(crate) mod circle;
pub(crate) mod deadzone;
pub(crate) mod impact;
pub(crate) mod program;
mod runs;

use anyhow::Result;

/// Assess the effect of lost motion at the TCP: on a measured circle, along a line from both sides, after the reversals of a
/// motion, or computed at a pose or over a program; and tell whether a changed program is better.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub what: What,
}

#[derive(Debug, clap::Subcommand)]
pub enum What {
    Bidirectional(Box<bidirectional::Args>),
    Circle(circle::Args),
    Deadzone(deadzone::Args),
    Impact(impact::Args),
    Program(program::Args),
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    match args.what {
        What::Bidirectional(a) => bidirectional::run(*a),
        What::Circle(a) => circle::run(a),
        What::Deadzone(a) => deadzone::run(a),
        What::Impact(a) => impact::run(a),
        What::Program(a) => program::run(a),
    }
}
