//! `lostmotion completions`: shell completions and the man page, on standard output.

use super::help;
use crate::error::Error;
use anyhow::Result;
use std::io::Write;

/// Print shell completions or the man page.
///
/// Examples:
///   lostmotion completions bash > /etc/bash_completion.d/lostmotion
///   lostmotion completions man > lostmotion.1
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// What to print
    #[arg(value_enum)]
    pub what: What,
}

/// A shell, or the man page.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum What {
    Bash,
    Elvish,
    Fish,
    Powershell,
    Zsh,
    Man,
}

/// Prints to standard output.
pub fn run(args: Args) -> Result<()> {
    use clap_complete::Shell;
    let mut command = help::command();
    let mut text = Vec::new();
    let shell = match args.what {
        What::Bash => Shell::Bash,
        What::Elvish => Shell::Elvish,
        What::Fish => Shell::Fish,
        What::Powershell => Shell::PowerShell,
        What::Zsh => Shell::Zsh,
        What::Man => {
            man(&command, &mut text).map_err(|e| Error::io("standard output", "write", e))?;
            return print(&text);
        }
    };
    clap_complete::generate(shell, &mut command, "lostmotion", &mut text);
    print(&text)
}

/// The page of the program, then one for each command below it.
fn man(command: &clap::Command, out: &mut Vec<u8>) -> std::io::Result<()> {
    clap_mangen::Man::new(command.clone()).render(out)?;
    for sub in command.get_subcommands() {
        let name = format!("{}-{}", command.get_name(), sub.get_name());
        man(&sub.clone().name(name), out)?;
    }
    Ok(())
}

fn print(text: &[u8]) -> Result<()> {
    std::io::stdout().lock().write_all(text).map_err(|e| Error::io("standard output", "write", e)).map_err(Into::into)
}
