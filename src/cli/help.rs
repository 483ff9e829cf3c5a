//! Help texts that wrap where the terminal ends: paragraphs flow, examples keep their lines.
//!
//! A doc comment of a command holds paragraphs with hard line ends, because source lines end somewhere, and indented examples.
//! clap wraps every line by itself, which leaves ragged paragraphs and splits an example in the middle of a word's option.
//! [`flowing`] joins the lines of a paragraph and breaks a long example before an option, with the shell's `\`.

use clap::{Command, CommandFactory};
use std::any::TypeId;
use std::ffi::OsString;
use std::num::NonZeroUsize;

/// Widest line of a help text, columns.
pub const WIDTH: usize = 100;
/// Widest line of an example: the narrowest terminal that people use shows it whole, columns.
const EXAMPLE_WIDTH: usize = 80;
/// Indentation of the continued lines of an example, columns.
const CONTINUED: usize = 6;

/// The command line with flowing help texts, for the parser, the man page and the completions.
pub fn command() -> Command {
    with_negative_numbers(with_flowing_help(super::Cli::command()))
}

/// Options that expect a number take a negative one as their value: the refusal is then about the number, not about an option `-1`.
fn with_negative_numbers(command: Command) -> Command {
    let numbers = [
        TypeId::of::<f64>(),
        TypeId::of::<u8>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
        TypeId::of::<NonZeroUsize>(),
    ];
    let mut command = command.mut_args(|arg| {
        let is_number = numbers.iter().any(|n| arg.get_value_parser().type_id() == *n);
        if is_number { arg.allow_negative_numbers(true) } else { arg }
    });
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_string()).collect();
    for name in names {
        command = command.mut_subcommand(name, with_negative_numbers);
    }
    command
}

/// `help --help` as `help help`: the parser knows no options of its own command.
pub fn of_help(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let is_help = |a: &OsString| a == "--help" || a == "-h";
    if arguments.get(1).is_some_and(|a| a == "help") && arguments.iter().skip(2).any(is_help) {
        arguments.retain(|a| !is_help(a));
        if arguments.len() == 2 {
            arguments.push("help".into());
        }
    }
    arguments
}

fn with_flowing_help(mut command: Command) -> Command {
    if let Some(text) = command.get_about().map(ToString::to_string) {
        // one line of a list of commands
        command = command.about(flowing(&text).trim_end_matches('.').to_string());
    }
    if let Some(text) = command.get_long_about().map(ToString::to_string) {
        command = command.long_about(flowing(&text));
    }
    if let Some(text) = command.get_after_help().map(ToString::to_string) {
        command = command.after_help(flowing(&text));
    }
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_string()).collect();
    for name in names {
        command = command.mut_subcommand(name, with_flowing_help);
    }
    command
}

/// Joins the lines of each paragraph; keeps indented lines and headings before them; breaks indented lines beyond [`EXAMPLE_WIDTH`].
pub fn flowing(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let indented = |l: &str| l.starts_with(' ');
    let mut out = String::new();
    for (i, line) in lines.iter().enumerate() {
        if indented(line) {
            out.push_str(&broken(line));
        } else {
            out.push_str(line.trim_end());
        }
        let Some(next) = lines.get(i + 1) else { break };
        let flows = !line.is_empty() && !next.is_empty() && !indented(line) && !indented(next);
        out.push(if flows { ' ' } else { '\n' });
    }
    out
}

/// An example line in pieces of at most [`EXAMPLE_WIDTH`] columns, broken before options.
fn broken(line: &str) -> String {
    let mut out = String::new();
    let mut rest = line.trim_end();
    let mut indent = 0;
    loop {
        let width = indent + rest.chars().count();
        let at =
            if width <= EXAMPLE_WIDTH { None } else { break_point(rest, EXAMPLE_WIDTH.saturating_sub(indent + 2)) };
        out.push_str(&" ".repeat(indent));
        let Some(at) = at else {
            out.push_str(rest);
            return out;
        };
        out.push_str(rest[..at].trim_end());
        out.push_str(" \\\n");
        rest = rest[at..].trim_start();
        indent = CONTINUED;
    }
}

/// Byte of the last ` -` (an option) within `width` columns, after the command's own words.
fn break_point(line: &str, width: usize) -> Option<usize> {
    let end = line.char_indices().nth(width).map_or(line.len(), |(i, _)| i);
    line[..end].rfind(" -").filter(|&at| !line[..at].trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_of_help_is_help() {
        let of = |words: &str| of_help(words.split(' ').map(OsString::from).collect()).join(" ".as_ref());
        assert_eq!(of("lostmotion help --help"), "lostmotion help help");
        assert_eq!(of("lostmotion help -h"), "lostmotion help help");
        assert_eq!(of("lostmotion help rewrite --help"), "lostmotion help rewrite");
        assert_eq!(of("lostmotion rewrite --help"), "lostmotion rewrite --help");
    }

    #[test]
    fn paragraphs_flow_and_examples_stay() {
        let text = "One line\nand its end.\n\nExamples:\n  a b\n  c d";
        assert_eq!(flowing(text), "One line and its end.\n\nExamples:\n  a b\n  c d");
    }

    #[test]
    fn a_long_example_is_broken_before_an_option() {
        let long =
            format!("  lostmotion rewrite {} --summary summary.jsonl", "--model machine.yaml ".repeat(4).trim_end());
        let shown = flowing(&long);
        assert!(shown.lines().all(|l| l.chars().count() <= EXAMPLE_WIDTH), "{shown}");
        assert!(shown.contains(" \\\n      --"), "{shown}");
        assert_eq!(shown.replace(" \\\n     ", ""), long);
    }

    /// Every help text at the full width: no line of a paragraph ends early, no line is too long.
    #[test]
    fn no_help_text_is_ragged() {
        fn walk(command: &mut Command) {
            // clap prints a form of a usage on one line, whatever its length
            let help = command.render_long_help().to_string();
            let usage = |l: &&str| l.starts_with("Usage:") || l.starts_with("       lostmotion ");
            for line in help.lines().filter(|l| !usage(l)) {
                assert!(line.chars().count() <= WIDTH, "{}: {line}", command.get_name());
            }
            let about = command.get_long_about().map(ToString::to_string).unwrap_or_default();
            for pair in about.lines().collect::<Vec<_>>().windows(2) {
                let [a, b] = pair else { continue };
                let both_flow = |l: &str| !l.is_empty() && !l.starts_with(' ');
                assert!(!(both_flow(a) && both_flow(b)), "{}: {a} / {b}", command.get_name());
            }
            for sub in command.get_subcommands_mut() {
                walk(sub);
            }
        }
        let mut all = command();
        all.build();
        walk(&mut all);
    }
}
