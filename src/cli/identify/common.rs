//! What all four identifications take and give: logs in; a document, a table and a page out.

use crate::cli::exit::bad;
use crate::cli::plan_recording::three;
use crate::cli::{page, paths};
use crate::error::{Place, is_stdio};
use crate::gaps::file::{to_json, to_yaml};
use crate::identify::scalar::Setup;
use crate::io::output::{self, Output, write_whole};
use crate::report::Page;
use anyhow::Result;
use nalgebra::Unit;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Logs, and how they are read.
#[derive(Debug, clap::Args)]
pub struct LogArgs {
    /// Measurement log (CSV, or .csv.gz), `-` for standard input; repeat the option for several logs
    #[arg(long = "log", value_name = "FILE", required = true)]
    pub logs: Vec<PathBuf>,
    /// Column map (YAML): translates other column names, units and separators of a log
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
}

/// What is known of an instrument with one reading a row.
#[derive(Debug, Clone, clap::Args)]
pub struct SetupArgs {
    /// Centre of the ballbar (columns r_mm, r_um) in the robot's world frame, mm [default: estimated from the log]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub centre: Option<String>,
    /// Direction in the robot's world frame in which the dial gauge's reading (dial_um) increases
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub direction: Option<String>,
}

impl SetupArgs {
    /// The values, checked.
    pub fn checked(&self) -> Result<Setup> {
        let centre_m = self.centre.as_deref().map(|t| three("--centre", t)).transpose()?.map(|mm| mm * 1e-3);
        let direction = self.direction.as_deref().map(|t| three("--direction", t)).transpose()?;
        let direction = match direction {
            Some(d) if d.norm() > 0.0 => Some(Unit::new_normalize(d)),
            Some(_) => return Err(bad(Place::file("--direction"), "0,0,0", "a direction, such as 0,0,1")),
            None => None,
        };
        Ok(Setup { centre_m, direction })
    }
}

/// Where the result goes.
#[derive(Debug, clap::Args)]
pub struct ResultArgs {
    /// Write the result to this file (YAML, or JSON if the name ends in .json); `-` for standard output
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Print the result as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// A result as people and programs read it.
pub struct Shown<'a> {
    pub document: &'a Value,
    pub table: &'a str,
    pub notes: &'a [String],
}

/// The files of a result, opened and not yet in place.
pub struct Opened {
    output: Option<Output>,
    report: Option<Output>,
}

impl ResultArgs {
    fn to_stdout(&self) -> bool {
        self.output.as_deref().is_some_and(is_stdio)
    }

    /// Opens the outputs before any work is done; refuses two documents on standard output, and a file that is an input as well.
    pub fn open<'a>(&'a self, logs: &'a LogArgs, others: &[paths::Named<'a>]) -> Result<Opened> {
        if self.json && self.to_stdout() {
            let expected = "one document on standard output";
            return Err(bad(Place::file("--output"), "`-` and --json", expected));
        }
        let mut inputs = others.to_vec();
        inputs.push(("--columns", logs.columns.as_deref()));
        inputs.extend(logs.logs.iter().map(|p| ("--log", Some(p.as_path()))));
        let outputs = [("--output", self.output.as_deref()), ("--report", self.report.as_deref())];
        paths::refuse_shared(&inputs, &outputs)?;
        let output = output::create(self.output.as_deref())?;
        Ok(Opened { output, report: output::create(self.report.as_deref())? })
    }

    /// Writes document, page and table; says the notes.
    pub fn finish(&self, opened: Opened, shown: &Shown, page: impl FnOnce() -> Page) -> Result<()> {
        let Opened { mut output, mut report } = opened;
        if let (Some(path), Some(out)) = (&self.output, &mut output) {
            let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
            let text = if json { to_json(shown.document)? } else { to_yaml(shown.document)? };
            out.put(text.as_bytes())?;
        }
        page::write(&mut report, page)?;
        output::commit([output, report])?;
        if self.json {
            write_whole(Path::new("-"), to_json(shown.document)?.as_bytes())?;
        } else if self.to_stdout() {
            eprint!("{}", shown.table);
        } else {
            write_whole(Path::new("-"), shown.table.as_bytes())?;
        }
        for note in shown.notes {
            eprintln!("note: {note}");
        }
        Ok(())
    }
}
