//! A tip beside a usage error: how this command takes a file that was given the way another one takes it.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};
use std::ffi::OsString;

/// Options that take the file a command works on, the first one that a command has before the others.
const FILES: [&str; 7] = ["gaps", "log", "input", "controller", "before", "path", "program"];
/// Options by which other commands take such a file.
const ELSEWHERE: [&str; 4] = ["--input", "--program", "--log", "--file"];

/// The error with a tip where a file was given without its option, or by an option where its name alone is expected.
pub fn with_tip(mut error: Error, command: &Command, arguments: &[OsString]) -> Error {
    let found = [ContextKind::InvalidArg, ContextKind::InvalidSubcommand].into_iter().find_map(|k| error.get(k));
    let Some(ContextValue::String(found)) = found else { return error };
    let found = found.clone();
    // clap offers to pass an unknown option as a value
    let as_value = |s: &StyledStr| s.to_string().contains("as a value");
    if matches!(error.get(ContextKind::Suggested), Some(ContextValue::StyledStrs(all)) if all.iter().any(as_value)) {
        error.remove(ContextKind::Suggested);
    }
    let command = deepest(command, arguments);
    if let Some(tip) = of_list(command, arguments, &found) {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
        return error;
    }
    let file = found.contains(['.', '/', '\\']) && !found.starts_with('-') && found.parse::<f64>().is_err();
    let positional = command.get_positionals().next();
    let tip = if file {
        let options: Vec<&Arg> = command.get_opts().collect();
        let named = |name: &&str| options.iter().any(|o| o.get_long() == Some(name));
        let on_line = |name: &&&str| arguments.iter().any(|a| a.to_str() == Some(&format!("--{name}")));
        let known: Vec<&&str> = FILES.iter().filter(|n| named(n)).collect();
        let name = known.iter().copied().find(|n| on_line(n)).or(known.first().copied());
        name.map(|name| format!("give the file with '--{name} FILE'"))
    } else {
        let elsewhere = ELSEWHERE.contains(&found.split([' ', '=']).next().unwrap_or_default());
        positional.filter(|_| elsewhere).map(|p| format!("{} is given without an option", value_of(p)))
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
    }
    error
}

/// The tip on a list of numbers that is written with blanks: `--pose 0 -90 90`.
fn of_list(command: &Command, arguments: &[OsString], found: &str) -> Option<String> {
    let words: Vec<&str> = arguments.iter().map(|a| a.to_str().unwrap_or_default()).collect();
    // clap names of `-90` the first letter alone
    let at = words.iter().position(|w| w.parse::<f64>().is_ok() && w.starts_with(found))?;
    let (first, before) = words[..at].split_last()?;
    let flag = before.last()?.strip_prefix("--")?;
    let takes_list = |a: &Arg| a.get_value_names().is_some_and(|names| names.iter().any(|n| n.contains(',')));
    let option = command.get_opts().find(|a| a.get_long() == Some(flag)).filter(|a| takes_list(a))?;
    let rest = words[at..].iter().take_while(|w| w.parse::<f64>().is_ok());
    let list = std::iter::once(first).chain(rest).copied().collect::<Vec<_>>().join(",");
    option.get_long().map(|name| format!("separate the numbers by commas, without blanks: --{name} {list}"))
}

/// What the parser says of a number that is none, in words for people.
pub fn readable(text: &str) -> String {
    text.replace("invalid float literal", "expected a number, with a point before the decimals, such as 0.8")
        .replace("invalid digit found in string", "expected a whole number")
        .replace("cannot parse integer from empty string", "expected a whole number")
        .replace("cannot parse float from empty string", "expected a number")
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
