//! The command line in this process.

use crate::errors::{bad, of_exit};
use clap::FromArgMatches;
use lostmotion::cli::{Cli, exit, help, process};
use pyo3::prelude::*;

/// The program `lostmotion`: prints, and returns the exit code.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| process::main(arguments.into_iter().map(Into::into).collect()))
}

/// One command, without the program's name; a refusal is an exception.
#[pyfunction]
pub fn run(py: Python<'_>, arguments: Vec<String>) -> PyResult<()> {
    let all = std::iter::once("lostmotion".to_string()).chain(arguments);
    let parsed = help::command().try_get_matches_from(all).and_then(|m| Cli::from_arg_matches(&m));
    let cli = parsed.map_err(|e| bad(e.to_string()))?;
    py.detach(|| lostmotion::cli::run(cli)).map(|_| ()).map_err(|e| of_exit(exit::code(&e), exit::words(&e)))
}
