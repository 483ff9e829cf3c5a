//! `lostmotion completions`: shell completions and man pages.
//!
//! Method: `clap_mangen` renders title, name, description and options. Synopsis and examples are rendered here: `clap_mangen` derives the
//! synopsis from the options one by one, which shows required options as optional ones, and names the page instead of the command.

use super::help;
use crate::cli::exit::bad;
use crate::error::{Error, Place};
use crate::io::output::write_whole;
use anyhow::Result;
use clap::Command;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Print shell completions or the man page, or write all man pages to a folder.
///
/// Examples:
///   lostmotion completions bash > /etc/bash_completion.d/lostmotion
///   lostmotion completions man > lostmotion.1
///   lostmotion completions man --output-dir ~/.local/share/man/man1
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// What to print
    #[arg(value_enum)]
    pub what: What,
    /// With `man`, write one page for each command to this folder instead of printing the page of the program
    #[arg(long, value_name = "FOLDER")]
    pub output_dir: Option<PathBuf>,
}

/// A shell, or the man page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum What {
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
    Man,
}

/// Prints to standard output, or writes the pages.
pub fn run(args: Args) -> Result<()> {
    use clap_complete::Shell;
    if args.output_dir.is_some() && args.what != What::Man {
        return Err(bad(
            Place::file("--output-dir"),
            "completions of a shell",
            "`man`; completions go to standard output",
        ));
    }
    let mut command = help::command();
    let shell = match args.what {
        What::Bash => Shell::Bash,
        What::Elvish => Shell::Elvish,
        What::Fish => Shell::Fish,
        What::Powershell => Shell::PowerShell,
        What::Zsh => Shell::Zsh,
        What::Man => return man(&command, args.output_dir.as_deref()),
    };
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command, "lostmotion", &mut text);
    print(&text)
}

/// The page of the program on standard output, or the pages of all commands in a folder.
fn man(command: &Command, folder: Option<&Path>) -> Result<()> {
    let Some(folder) = folder else {
        return print(&page(command, &["lostmotion"]).map_err(|e| Error::io("standard output", "write", e))?);
    };
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "make", e))?;
    let mut waiting = vec![(command, vec!["lostmotion"])];
    while let Some((command, path)) = waiting.pop() {
        let file = folder.join(format!("{}.1", path.join("-")));
        let text = page(command, &path).map_err(|e| Error::io(&file, "write", e))?;
        write_whole(&file, &text)?;
        waiting.extend(command.get_subcommands().map(|sub| (sub, [&path[..], &[sub.get_name()]].concat())));
    }
    Ok(())
}

/// One page; `path`: the words of the command line that name the command.
fn page(command: &Command, path: &[&str]) -> std::io::Result<Vec<u8>> {
    let is_program = path.len() == 1;
    let named = command.clone().name(path.join("-")).bin_name(path.join(" "));
    // the words of a usage line are not those of a page's name
    let usage = named.clone().display_name(path.join(" ")).render_usage().to_string();
    let examples = named.get_after_help().map(ToString::to_string);
    let pages = clap_mangen::Man::new(named.version(env!("CARGO_PKG_VERSION")));
    let mut out = Vec::new();
    pages.render_title(&mut out)?;
    pages.render_name_section(&mut out)?;
    let usages: Vec<&str> =
        usage.trim_start_matches("Usage:").lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    out.extend(section("SYNOPSIS", &usages).into_bytes());
    pages.render_description_section(&mut out)?;
    pages.render_options_section(&mut out)?;
    if command.has_subcommands() {
        pages.render_subcommands_section(&mut out)?;
    }
    if let Some(text) = examples {
        let text = text.trim_start_matches("Examples:");
        out.extend(section("EXAMPLES", &text.trim_matches('\n').lines().collect::<Vec<_>>()).into_bytes());
    }
    if is_program {
        pages.render_version_section(&mut out)?;
    }
    Ok(out)
}

/// A section of lines that are printed as they stand.
fn section(heading: &str, lines: &[&str]) -> String {
    let mut out = format!(".SH {heading}\n.nf\n");
    for line in lines {
        let plain = line.replace('\\', "\\e").replace('-', "\\-");
        let _ = writeln!(out, "{}{plain}", if plain.starts_with(['.', '\'']) { "\\&" } else { "" });
    }
    out + ".fi\n"
}

fn print(text: &[u8]) -> Result<()> {
    std::io::stdout().lock().write_all(text).map_err(|e| Error::io("standard output", "write", e)).map_err(Into::into)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text_of(path: &[&str]) -> String {
        let all = help::command();
        let command = path[1..].iter().fold(&all, |at, name| at.find_subcommand(name).unwrap());
        String::from_utf8(page(command, path).unwrap()).unwrap()
    }

    #[test]
    fn a_page_names_the_command_and_shows_required_options_as_required() {
        let text = text_of(&["lostmotion", "rewrite"]);
        assert!(text.contains(r"lostmotion rewrite [OPTIONS] \-\-robot <FILE> \-\-compensator <FILE>"), "{text}");
        assert!(!text.contains(r"lostmotion\-rewrite [") && !text.contains(".SH EXTRA"), "{text}");
        assert!(!text.contains(".SH VERSION"));
        let nested = text_of(&["lostmotion", "identify", "path"]);
        assert!(nested.contains("lostmotion identify path") && nested.contains(".SH EXAMPLES"), "{nested}");
        let whole = text_of(&["lostmotion"]);
        assert!(whole.contains(".SH VERSION") && whole.contains(env!("CARGO_PKG_VERSION")));
        assert_eq!(whole.matches(".TH ").count(), 1);
    }
}
