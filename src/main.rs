//! `lostmotion`: parse, run, map the error to an exit code.
#![forbid(unsafe_code)]

use clap::FromArgMatches;
use lostmotion::cli::{Cli, help, run};
use lostmotion::error::Error;
use std::process::ExitCode;

/// As a shell tells it.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    let matches = help::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    // without a handler an interrupt leaves temporary files; that is no reason not to run
    let _ = ctrlc::set_handler(|| {
        lostmotion::io::output::discard();
        std::process::exit(INTERRUPTED);
    });
    match run(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::ClosedPipe) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("lostmotion: {e}");
            ExitCode::from(e.exit_code())
        }
    }
}
