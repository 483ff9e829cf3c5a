//! `lostmotion`: parse, run, map the error to an exit code.
#![forbid(unsafe_code)]

use clap::{ColorChoice, FromArgMatches};
use lostmotion::cli::{Cli, exit, global, help, run};
use lostmotion::error::Error;
use lostmotion::io::console::say;
use std::io::IsTerminal;
use std::process::ExitCode;

fn main() -> ExitCode {
    let color = global::color_of(std::env::args_os());
    let parsed = help::command().color(color).try_get_matches().and_then(|m| Cli::from_arg_matches(&m));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(e) => return usage(&e, color),
    };
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

/// Prints help, or what is wrong with a command line, under the one prefix of all errors.
fn usage(error: &clap::Error, color: ColorChoice) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print(); // a reader that has gone
        return ExitCode::SUCCESS;
    }
    let colored = match color {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
        }
    };
    let rendered = error.render();
    let text = if colored { rendered.ansi().to_string() } else { rendered.to_string() };
    let text = text.replacen("error:", "lostmotion:", 1);
    // not through `say`, which takes the escapes of colours for what comes from outside
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
    ExitCode::from(2)
}
