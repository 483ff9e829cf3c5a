//! `lostmotion columns`: a column map drafted from the header of a recording; and the hint to one where a header cannot be read.

use crate::cli::paths;
use crate::error::{BadInput, Error, is_stdio};
use crate::io::input;
use crate::io::output::Output;
use crate::log::draft;
use crate::robot::Robot;
use crate::schemas;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Draft a column map from the header of a recording.
///
/// The map gives separator, decimal sign, and for each column that is recognised our name and its unit. Names in English and
/// German, the names of the joints, and numbers of joints (axis 1, Achse 1, q_0) are recognised. Read the draft before you use it: a unit
/// that the header does not name is marked. Use it with --columns, or with --controller-columns and --tracker-columns of `join`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion columns export.csv --robot robot.yaml --output map.yaml
  lostmotion columns controller.xlsx --robot robot.yaml")]
pub struct Args {
    /// Recording of a controller or a tracker, or a log (CSV, .csv.gz, .xlsx)
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Write the map to this file; `-` for standard output
    #[arg(long, short, value_name = "MAP.yaml", default_value = "-")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [("FILE", Some(args.file.as_path())), ("--robot", Some(args.robot.as_path()))];
    paths::refuse_shared(&inputs, &[("--output", Some(args.output.as_path()))])?;
    let mut out = Output::create(&args.output)?;
    let robot = Robot::load(&args.robot)?;
    let draft = draft::of_file(input::read(&args.file)?, &robot)?;
    out.put((schemas::editor_line(&args.output, "columns") + &draft.text).as_bytes())?;
    out.commit()?;
    if let Some(name) = draft.shipped {
        eprintln!("note: the map `{name}`, which ships with lostmotion, reads this header, too");
    }
    if !draft.missing.is_empty() {
        eprintln!("note: no column was recognised for {}: complete the map by hand", draft.missing.join(", "));
        if !draft.found.iter().any(|f| f != "t_s") {
            eprintln!("note: a controller's file needs the commands of all joints, a tracker's x, y and z");
        }
    }
    Ok(())
}

/// The error of a file read as a program, with the command that helps where it is a recording in another form of CSV.
pub fn with_program_hint(error: Error) -> Error {
    match error {
        Error::BadInput(bad) if bad.found.contains("semicolons between the columns") => Error::BadInput(BadInput {
            expected: bad.expected
                + "; if the file is a recording, `lostmotion columns` drafts a column map that reads it",
            ..bad
        }),
        other => other,
    }
}

/// The same error, with the map that would help: where a file was read without one, and its header has other names than ours. `option`
/// is the one that takes a map.
pub fn with_hint(error: Error, file: &Path, map: Option<&Path>, robot: &Robot, option: &str) -> Error {
    let Error::UnknownHeader(bad) = error else { return error };
    let draft = (map.is_none() && !is_stdio(file))
        .then(|| input::read(file).and_then(|i| draft::of_file(i, robot)).ok())
        .flatten();
    let hint = match draft {
        Some(d) if d.shipped.is_some() => format!("; {option} {} reads this header", d.shipped.unwrap_or_default()),
        Some(d) if !d.found.is_empty() => "; `lostmotion columns` drafts a column map".to_string(),
        _ => String::new(),
    };
    Error::UnknownHeader(BadInput { expected: bad.expected + &hint, ..bad })
}
