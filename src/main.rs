//! `lostmotion`: parse, run, map the error to an exit code.
#![forbid(unsafe_code)]

use clap::Parser;
use lostmotion::cli::{Cli, run};
use lostmotion::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::ClosedPipe) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("lostmotion: {e}");
            ExitCode::from(e.exit_code())
        }
    }
}
