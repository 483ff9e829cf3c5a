//! `lostmotion`: the command line as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(lostmotion::cli::process::main(std::env::args_os().collect()))
}
