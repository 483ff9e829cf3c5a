//! The command line in this process.

use crate::errors::{bad, raised};
use clap::FromArgMatches;
use lostmotion::cli::{Cli, exit, help};
use lostmotion::error::Error;
use pyo3::prelude::*;

/// The program `lostmotion`: prints, and returns the exit code.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| {
        let parsed = help::command().try_get_matches_from(arguments).and_then(|m| Cli::from_arg_matches(&m));
        let cli = match parsed {
            Ok(cli) => cli,
            Err(e) => {
                let _ = e.print();
                return u8::try_from(e.exit_code()).unwrap_or(2);
            }
        };
        lostmotion::io::interrupt::listen();
        match lostmotion::cli::run(cli) {
            Ok(finished) => finished.code(),
            Err(Error::ClosedPipe) => 0,
            Err(e) => {
                lostmotion::io::console::say(format_args!("lostmotion: {e}"), true);
                exit::code(&e)
            }
        }
    })
}

/// One command, without the program's name; a refusal is an exception.
#[pyfunction]
pub fn run(py: Python<'_>, arguments: Vec<String>) -> PyResult<()> {
    let all = std::iter::once("lostmotion".to_string()).chain(arguments);
    let parsed = help::command().try_get_matches_from(all).and_then(|m| Cli::from_arg_matches(&m));
    let cli = parsed.map_err(|e| bad(e.to_string()))?;
    py.detach(|| lostmotion::cli::run(cli)).map(|_| ()).map_err(raised)
}
