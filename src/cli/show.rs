//! `lostmotion show`: any file as a page.

use crate::cli::exit::bad;
use crate::cli::{columns, page, paths};
use crate::compensator::{self, Compensator};
use crate::error::Place;
use crate::gaps::{self, Gaps};
use crate::io::input::{self, Input};
use crate::io::output::Output;
use crate::io::yaml::Document;
use crate::io::{bag, workbook};
use crate::log::{ColumnMap, Log, draft, plausibility};
use crate::model::{self, Model};
use crate::report::Page;
use crate::rewrite::script::path::Reading;
use crate::robot::frames::Frames;
use crate::robot::{self, Robot};
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Show a file as a self-contained HTML page: a log, a program, a robot, a model, gaps or a compensator.
///
/// The kind of the file is detected from its content. Logs, programs, gaps and compensators also need --robot.
///
/// Examples:
///   lostmotion show robot.yaml --output robot.html
///   lostmotion show log.csv --robot robot.yaml --output log.html
///   lostmotion show gaps.yaml --robot robot.yaml --output gaps.html
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// File to show
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Robot file (YAML); not needed for a robot or a model
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: Option<PathBuf>,
    /// Column map of a log: a file, or the built-in rtde, rws, rsi or tracker
    #[arg(long, value_name = "MAP")]
    pub columns: Option<PathBuf>,
    /// Frames and tools of a program's Cartesian targets by the controller's names (YAML, or the controller's own file)
    #[arg(long, value_name = "FRAMES.yaml")]
    pub frames: Option<PathBuf>,
    /// Write the page to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE.html")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs =
        [("FILE", Some(args.file.as_path())), ("--robot", args.robot.as_deref()), ("--frames", args.frames.as_deref())];
    paths::refuse_shared(&inputs, &[("--output", Some(args.output.as_path()))])?;
    let mut out = Output::create(&args.output)?;
    let (input, _) = workbook::unpacked(input::read(&args.file)?)?;
    let page = of(&args, input)?;
    out.put(page.render().as_bytes())?;
    out.commit().map_err(Into::into)
}

fn of(args: &Args, input: Input) -> Result<Page> {
    let file = (input.name.clone(), input.sha256.clone());
    let mut page = match schema_of(&input).as_deref() {
        Some(robot::file::SCHEMA) => {
            page::show::of_model(&Model::ideal(Robot::parse(&input.name.clone(), &text_of(input)?)?))
        }
        Some(model::SCHEMA) => {
            // a robot named in a model of standard input is looked for in the working folder
            let model = Model::parse(&input.name.clone(), &text_of(input)?, &|robot| {
                Robot::load(&args.file.parent().unwrap_or(Path::new("")).join(robot))
            })?;
            page::show::of_model(&model)
        }
        Some(gaps::file::SCHEMA) => {
            let robot = robot_of(args)?;
            page::machine::of_document(&robot, &Gaps::parse(&input.name.clone(), &text_of(input)?, &robot)?)
        }
        Some(compensator::file::SCHEMA) => {
            let robot = robot_of(args)?;
            page::compensator::of_fit(&robot, &Compensator::parse(&input.name.clone(), &text_of(input)?, &robot)?)
        }
        Some(other) => {
            return Err(bad(
                Place::file(&input.name),
                format!("a document `{other}`"),
                "a log, a program, a robot, a model, gaps or a compensator",
            ));
        }
        None => {
            let robot = robot_of(args)?;
            let map = args.columns.as_deref().map(ColumnMap::load).transpose()?;
            if map.is_some() || bag::is_one(&input.bytes) || is_log(&input) {
                let log = Log::parse_with(input, &robot, map.as_ref())?;
                plausibility::check_for(&log, &robot, plausibility::Kinematics::OfFile)?;
                page::show::of_log(&robot, &log)
            } else {
                refuse_recording(&input, &robot)?;
                let frames = args.frames.as_deref().map(Frames::load).transpose()?.unwrap_or_default();
                let reading = Reading { robot: &robot, frames: &frames, tcp_speed_m_s: None, format: None };
                let program = reading.load(&args.file, input).map_err(columns::with_program_hint)?;
                page::show::of_program(&robot, &program)
            }
        }
    };
    page.command = "show".into();
    if page.files.is_empty() {
        page.file("file", file.0, file.1);
    }
    Ok(page)
}

/// The text of a document.
fn text_of(input: Input) -> Result<String> {
    input::decode(&input.name, input.bytes).map_err(Into::into)
}

fn robot_of(args: &Args) -> Result<Robot> {
    let path = args.robot.as_deref();
    let path = path.ok_or_else(|| bad(Place::file("--robot"), "no robot", "--robot ROBOT.yaml for this file"))?;
    Robot::load(path).map_err(Into::into)
}

/// Refuses a recording that is no log yet, with the command that reads it: a program has no coordinates, and a log has joints and
/// coordinates under our names.
fn refuse_recording(input: &Input, robot: &Robot) -> Result<()> {
    bag::refuse_sqlite(input)?;
    let Some(header) = header(input) else { return Ok(()) };
    let place = || Place::file(&input.name);
    let has = |names: &[&str]| names.iter().all(|n| header.contains(n));
    if has(&["position_mm", "error_um"]) {
        let expected =
            "a log or a program; `lostmotion assess bidirectional --readings FILE --report PAGE.html` draws readings";
        return Err(bad(place(), "readings of a line from both sides", expected));
    }
    let copy = Input { name: input.name.clone(), bytes: input.bytes.clone(), sha256: input.sha256.clone() };
    // our own program has joints under bare names, which a draft takes for commands: only other names make a recording
    let names = robot.axis_joints().map(|j| format!("{}_{}", j.name, j.kind.unit()).to_lowercase());
    if names.into_iter().any(|n| header.contains(n.as_str())) {
        return Ok(());
    }
    let Ok(draft) = draft::of_file(copy, robot) else { return Ok(()) };
    let found = |name: &str| draft.found.iter().any(|f| f == name);
    if !found("t_s") {
        return Ok(());
    }
    if ["x_mm", "y_mm", "z_mm"].into_iter().all(found) && !draft.found.iter().any(|f| f.starts_with("cmd_")) {
        let expected = "a log: `lostmotion join` makes one of it and of the controller's recording (`lostmotion columns` drafts a column map that it may need)";
        return Err(bad(place(), "a recording of a tracker, without joints", expected));
    }
    if draft.missing.is_empty() {
        let expected = "a log under our names, or --columns MAP (`lostmotion columns` drafts a map; with a tracker's recording of the same \
                        motion, `lostmotion join` makes a log)";
        return Err(bad(place(), "a recording of a controller", expected));
    }
    Ok(())
}

/// The first line of a text that is no comment, in small letters.
fn header(input: &Input) -> Option<String> {
    let head: Vec<u8> = input.bytes.iter().copied().take(1 << 16).collect();
    let text = String::from_utf8_lossy(&head).to_lowercase();
    text.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with('#')).map(str::to_string)
}

/// The `schema:` of a YAML or JSON document.
fn schema_of(input: &Input) -> Option<String> {
    let text = std::str::from_utf8(&input.bytes).ok()?;
    if !text.contains("lostmotion/") {
        return None;
    }
    let doc = Document { name: &input.name, text };
    let value: serde_yaml::Value = doc.parse("a document").ok()?;
    value.get("schema")?.as_str().map(str::to_string)
}

/// A header with commands under the log's names.
fn is_log(input: &Input) -> bool {
    header(input).is_some_and(|l| l.contains("cmd_"))
}
