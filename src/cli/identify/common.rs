//! What all four identifications take and give: logs in; a document, a table and a page out.

use crate::cli::exit::bad;
use crate::cli::plan_recording::three;
use crate::cli::{page, paths};
use crate::error::{Place, is_stdio};
use crate::gaps::Note;
use crate::gaps::file::{to_json, to_yaml};
use crate::identify::scalar::Setup;
use crate::io::output::{self, Output, write_whole};
use crate::log::Log;
use crate::report::Page;
use crate::schemas;
use anyhow::Result;
use nalgebra::{Unit, Vector3};
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
        Ok(Setup {
            centre_m: self.centre.as_deref().map(centre).transpose()?,
            direction: self.direction.as_deref().map(direction).transpose()?,
        })
    }
}

/// The same for logs of several such instruments.
#[derive(Debug, Clone, clap::Args)]
pub struct SetupsArgs {
    /// Centre of the ballbar (columns r_mm, r_um) in the robot's world frame, mm; one for all its logs, or one for each in their
    /// order [default: estimated from each log]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub centre: Vec<String>,
    /// Direction in the robot's world frame in which the dial gauge's reading (dial_um) increases; one for all its logs, or one
    /// for each in their order
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub direction: Vec<String>,
}

impl SetupsArgs {
    /// Tells the logs what is known of their instruments.
    pub fn tell(&self, logs: &mut [Log]) -> Result<()> {
        let setups = self.of_each(logs)?;
        for (log, setup) in logs.iter_mut().zip(setups) {
            (log.instruments.centre_m, log.instruments.direction) = (setup.centre_m, setup.direction);
        }
        Ok(())
    }

    /// The values of each log, checked.
    pub fn of_each(&self, logs: &[Log]) -> Result<Vec<Setup>> {
        let centres = self.centre.iter().map(|t| centre(t)).collect::<Result<Vec<_>>>()?;
        let directions = self.direction.iter().map(|t| direction(t)).collect::<Result<Vec<_>>>()?;
        let single = |log: &&Log| log.tcp_m.is_empty();
        let ballbar = |log: &Log| log.instruments.distance_m.is_some() || log.instruments.distance_off_m.is_some();
        let dial = |log: &Log| !ballbar(log) && log.instruments.dial_m.is_some();
        let count = |of: &dyn Fn(&Log) -> bool| logs.iter().filter(single).filter(|l| of(l)).count();
        for (flag, given, there, what) in [
            ("--centre", centres.len(), count(&ballbar), "log of a ballbar"),
            ("--direction", directions.len(), count(&dial), "log of a dial"),
        ] {
            if given > 0 && there == 0 {
                return Err(bad(
                    Place::file(flag),
                    "no log that it is for",
                    format!("a {what} without a measured TCP"),
                ));
            }
            if given > 1 && given != there {
                let found = format!("{given} times, and {} {there}", if there == 1 { "there is" } else { "there are" });
                return Err(bad(Place::file(flag), found, format!("once, or once for each {what}")));
            }
        }
        let (mut bars, mut dials) = (0, 0);
        let nth = |k: usize, given: usize| if given > 1 { k } else { 0 };
        let of = |log: &Log| {
            let mut setup = Setup::default();
            if !log.tcp_m.is_empty() {
                return setup;
            }
            if ballbar(log) {
                setup.centre_m = centres.get(nth(bars, centres.len())).copied();
                bars += 1;
            } else if dial(log) {
                setup.direction = directions.get(nth(dials, directions.len())).copied();
                dials += 1;
            }
            setup
        };
        Ok(logs.iter().map(of).collect())
    }
}

/// A centre in the world frame, m.
fn centre(text: &str) -> Result<Vector3<f64>> {
    Ok(three("--centre", text)? * 1e-3)
}

fn direction(text: &str) -> Result<Unit<Vector3<f64>>> {
    let along = three("--direction", text)?;
    if along.norm() > 0.0 {
        Ok(Unit::new_normalize(along))
    } else {
        Err(bad(Place::file("--direction"), "0,0,0", "a direction, such as 0,0,1"))
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
    pub notes: &'a [Note],
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
            let line = if json { String::new() } else { schemas::editor_line(path, "gaps") };
            out.put((line + &text).as_bytes())?;
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
