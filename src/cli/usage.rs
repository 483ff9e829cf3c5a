//! A tip beside a usage error: how this command takes a file that was given the way another one takes it.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};
use std::ffi::OsString;

/// Options that take the file a command works on, the first one that a command has before the others.
const FILES: [&str; 5] = ["gaps", "log", "input", "controller", "before"];
/// Options by which other commands take such a file.
const ELSEWHERE: [&str; 4] = ["--input", "--program", "--log", "--file"];

/// The error with a tip where a file was given without its option, or by an option where its name alone is expected.
pub fn with_tip(mut error: Error, command: &Command, arguments: &[OsString]) -> Error {
    let found = [ContextKind::InvalidArg, ContextKind::InvalidSubcommand].into_iter().find_map(|k| error.get(k));
    let Some(ContextValue::String(found)) = found else { return error };
    let command = deepest(command, arguments);
    let file = found.contains(['.', '/', '\\']) && !found.starts_with('-');
    let positional = command.get_positionals().next();
    let tip = if file {
        let options: Vec<&Arg> = command.get_opts().collect();
        let named = |name: &&str| options.iter().any(|o| o.get_long() == Some(name));
        FILES.iter().find(|n| named(n)).map(|name| format!("a file is given with its option: '--{name} FILE'"))
    } else {
        let elsewhere = ELSEWHERE.iter().any(|o| found.starts_with(o));
        positional.filter(|_| elsewhere).map(|p| format!("{} is given without an option", value_of(p)))
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
    }
    error
}

/// The subcommand that the arguments lead to.
fn deepest<'a>(command: &'a Command, arguments: &[OsString]) -> &'a Command {
    let words = arguments.iter().skip(1).filter_map(|a| a.to_str());
    words.fold(command, |at, word| at.find_subcommand(word).unwrap_or(at))
}

/// A positional argument as usage shows it.
fn value_of(positional: &Arg) -> String {
    let names = positional.get_value_names().and_then(|names| names.first());
    names.map_or_else(|| positional.get_id().to_string(), |name| format!("<{name}>"))
}
