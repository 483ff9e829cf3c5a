//! `lostmotion`: parse, run, map the error to an exit code.
#![forbid(unsafe_code)]

use clap::FromArgMatches;
use lostmotion::cli::{Cli, exit, help, run};
use lostmotion::error::Error;
use lostmotion::io::console::say;
use std::process::ExitCode;

fn main() -> ExitCode {
    let matches = help::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    lostmotion::io::interrupt::listen();
    match run(cli) {
        Ok(finished) => ExitCode::from(finished.code()),
        Err(Error::ClosedPipe) => ExitCode::SUCCESS,
        Err(e) => {
            say(format_args!("lostmotion: {e}"), true);
            ExitCode::from(exit::code(&e))
        }
    }
}
