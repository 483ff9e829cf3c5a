//! The command as a process: arguments in, exit code out. The binary and the Python module run the same.

use super::exit::{self, Finished};
use super::{Cli, global, help, run, streams, usage};
use crate::cli::console::say;
use clap::{ColorChoice, FromArgMatches};
use std::ffi::OsString;
use std::io::IsTerminal;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Parses, runs, prints what went wrong, and returns the exit code. The first argument is the program's name.
pub fn main(arguments: Vec<OsString>) -> u8 {
    let arguments = streams::as_dash(help::of_help(arguments));
    let color = global::color_of(arguments.iter().cloned());
    let parsed = help::command().color(color).try_get_matches_from(arguments.iter());
    let cli = match parsed.and_then(|m| Cli::from_arg_matches(&m)) {
        Ok(cli) => cli,
        Err(e) => return print_usage(&usage::with_tip(e, &help::command(), &arguments), color),
    };
    crate::io::notice::handle_with(super::console::print);
    super::signals::listen();
    ended(|| run(cli))
}

/// Runs a command, prints what went wrong, and returns the exit code: that of an internal error where it panics.
fn ended(command: impl FnOnce() -> anyhow::Result<Finished>) -> u8 {
    let Ok(finished) = catch_unwind(AssertUnwindSafe(command)) else {
        // the panic has printed its place
        say(format_args!("lostmotion: {}", exit::PANICKED), true);
        return exit::INTERNAL;
    };
    match finished {
        Ok(finished) => finished.code(),
        Err(e) => {
            let code = exit::code(&e);
            if code != 0 {
                say(format_args!("lostmotion: {}", exit::words(&e)), true);
            }
            code
        }
    }
}

/// Prints help, or what is wrong with a command line, under the one prefix of all errors.
fn print_usage(error: &clap::Error, color: ColorChoice) -> u8 {
    if !error.use_stderr() {
        let _ = error.print(); // a reader that has gone
        return 0;
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
    let text = usage::readable(&text.replacen("error:", "lostmotion:", 1));
    // not through `say`, which takes the escapes of colours for what comes from outside
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
    2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_with_the_exit_code_of_an_internal_error() {
        assert_eq!(ended(|| panic!("a mistake of the program itself")), 70);
        assert_eq!(ended(|| Ok(Finished::Done)), 0);
    }
}
