//! `lostmotion assess`: what lost motion costs at the TCP; one file per subcommand.
//!
//! Computed: [`impact`] (of a gap), [`program`] (a program before and after it was changed). Measured: [`circle`], [`deadzone`], both on
//! the logs that `runs` reads, and [`bidirectional`].

pub(crate) mod bidirectional;
pub(crate) mod circle;
pub(crate) mod deadzone;
pub(crate) mod impact;
pub(crate) mod program;
mod runs;

use anyhow::Result;

/// Assess the effect of lost motion at the TCP: on a measured circle, along a line from both sides, after the reversals of a
/// motion, or computed at a pose or over a program; and tell whether a changed program is better.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub what: What,
}

#[derive(Debug, clap::Subcommand)]
pub enum What {
    Bidirectional(Box<bidirectional::Args>),
    Circle(circle::Args),
    Deadzone(deadzone::Args),
    Impact(impact::Args),
    Program(program::Args),
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    match args.what {
        What::Bidirectional(a) => bidirectional::run(*a),
        What::Circle(a) => circle::run(a),
        What::Deadzone(a) => deadzone::run(a),
        What::Impact(a) => impact::run(a),
        What::Program(a) => program::run(a),
    }
}

/// Prints a result on standard output.
fn print(text: &str) -> Result<()> {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|e| crate::error::Error::io("standard output", "write", e))
        .map_err(Into::into)
}

/// One JSON document with a last newline.
fn print_json(document: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(document).map_err(|e| crate::error::Error::internal("write JSON", e))?;
    print(&(text + "\n"))
}

/// An empty table: numbers to the right, one line below the header.
pub(super) fn table(header: &[&str]) -> comfy_table::Table {
    use comfy_table::{TableComponent, presets};
    let mut table = comfy_table::Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    for line in [TableComponent::HeaderLines, TableComponent::MiddleHeaderIntersections] {
        table.set_style(line, '─');
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    table
}
