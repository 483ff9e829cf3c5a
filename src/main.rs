//! `lostmotion`: parse, run, map the error to an exit code.
#![forbid(unsafe_code)]

use clap::Parser;
use lostmotion::cli::{Cli, run};
use lostmotion::error::Error;
use std::process::ExitCode;

/// As a shell tells it.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    let cli = Cli::parse();
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
