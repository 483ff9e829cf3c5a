//! `lostmotion assess program`.

use crate::assess::program::document::{Document, MovesShown};
use crate::assess::program::text::{TextDifference, difference};
use crate::assess::program::{Assessment, Note, Options, Source, Verdict, assess};
use crate::cli::exit::{bad, no};
use crate::cli::print::{print, print_json, table};
use crate::cli::{page, paths};
use crate::error::{Place, counted};
use crate::io::input::{self, Input};
use crate::io::output;
use crate::io::workbook;
use crate::log::{ColumnMap, Log};
use crate::model::Model;
use crate::program::{Program, ScriptPath};
use crate::rewrite::script::path::Reading;
use crate::robot::Robot;
use crate::robot::frames::Frames;
use crate::simulate::predicted;
use anyhow::Result;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Compare the path error of a program before and after a change: better or worse.
///
/// Both programs run on the modelled machine. The error of a point is its distance from the path of the original program on
/// the same machine without gaps, friction and the other joint errors that an offset can undo. You can give logs of both
/// runs instead of the programs; their measured TCP is fitted onto that path.
///
/// A program is worse if its rms or largest error grows, or if its error after any reversal grows by more than 5 um. The
/// exit code is then 1. The targets of a vendor program, where it stops or is taught, are judged separately from the path between
/// them, and the verdict reports both.
///
/// Examples:
///   lostmotion assess program --model machine.yaml --before job.csv --after job.done.csv --speed-mm-s 10
///   lostmotion assess program --model machine.yaml --before job.mod --after done/job.mod --report proof.html
///   lostmotion assess program --model machine.yaml --before before.log.csv --after after.log.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Model file (YAML): the robot and its known effects
    #[arg(long, value_name = "MODEL.yaml")]
    pub model: PathBuf,
    /// Original program (joint-space CSV or a vendor program), or the log of its run
    #[arg(long, value_name = "PROGRAM_OR_LOG")]
    pub before: PathBuf,
    /// Changed program, or the log of its run
    #[arg(long, value_name = "PROGRAM_OR_LOG")]
    pub after: PathBuf,
    /// TCP speed of the programs, mm/s; overrides their own times [default: their own times and speeds, otherwise 1.5]
    #[arg(long, value_name = "MM_S")]
    pub speed_mm_s: Option<f64>,
    /// Column map (YAML): translates other column names, units and separators of the logs
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Frames and tools of Cartesian targets by the controller's names (YAML, or the controller's own file)
    #[arg(long, value_name = "FRAMES.yaml")]
    pub frames: Option<PathBuf>,
    /// Print the result as one JSON document (lostmotion/program-assessment/1) instead of the tables
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// A program or a log as it was read.
enum Loaded {
    Program(Box<Program>),
    Log(Box<Log>),
}

impl Loaded {
    fn source(&self) -> Source<'_> {
        match self {
            Self::Program(p) => Source::Program(p),
            Self::Log(l) => Source::Log(l),
        }
    }
}

/// The document, and how the texts of two programs differ; null of logs.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    assessment: Document,
    text_lines: Option<TextDifference>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--model", Some(args.model.as_path())),
        ("--before", Some(args.before.as_path())),
        ("--after", Some(args.after.as_path())),
        ("--columns", args.columns.as_deref()),
        ("--frames", args.frames.as_deref()),
    ];
    paths::refuse_shared(&inputs, &[("--report", args.report.as_deref())])?;
    if let Some(v) = args.speed_mm_s
        && !(v.is_finite() && v > 0.0)
    {
        return Err(bad(Place::file("--speed-mm-s"), v.to_string(), "a speed above 0"));
    }
    let mut report = output::create(args.report.as_deref())?;
    let model = Model::load(&args.model)?;
    let map = args.columns.as_deref().map(ColumnMap::load).transpose()?;
    let text = |path: &Path| -> Result<Input> { Ok(workbook::unpacked(input::read(path)?)?.0) };
    let texts = [text(&args.before)?, text(&args.after)?];
    let default = crate::simulate::Options::default().speed_m_s;
    let options =
        Options { speed_m_s: args.speed_mm_s.map_or(default, |v| v * 1e-3), at_speed: args.speed_mm_s.is_some() };
    let frames = args.frames.as_deref().map(Frames::load).transpose()?.unwrap_or_default();
    let reading = Reading::new(&model.robot, &frames, args.speed_mm_s);
    let before = load(&texts[0], &model, map.as_ref(), &args.before, &reading)?;
    let after = load(&texts[1], &model, map.as_ref(), &args.after, &reading)?;
    let mut result = assess(&model, &before.source(), &after.source(), &options)?;
    for loaded in [&before, &after] {
        if let Loaded::Program(program) = loaded
            && let Some(waiting) = program.script.as_ref().and_then(ScriptPath::waiting)
        {
            let note = Note::Waiting { program: program.name.clone(), waiting };
            if !result.notes.contains(&note) {
                result.notes.push(note);
            }
        }
    }
    let text = matches!((&before, &after), (Loaded::Program(_), Loaded::Program(_)))
        .then(|| difference(&texts[0].bytes, &texts[1].bytes));
    page::write(&mut report, || page::program::of_assessment(&model.robot, &result))?;
    output::commit([report])?;
    if args.json {
        print_json(&Printed { assessment: result.document(&model.robot), text_lines: text })?;
    } else {
        print(&tables(&result, text, &model.robot))?;
    }
    for note in &result.notes {
        eprintln!("note: {note}");
    }
    match result.verdict {
        Verdict::Worse => Err(no(format!(
            "{}: {}; the error after one reversal grows by {:.1} um",
            result.after.name,
            result.figures.sentence(),
            result.figures.worst_reversal_growth_m * 1e6
        ))),
        _ => Ok(()),
    }
}

fn load(text: &Input, model: &Model, map: Option<&ColumnMap>, path: &Path, reading: &Reading) -> Result<Loaded> {
    if let Some(map) = map {
        return Ok(Loaded::Log(Box::new(Log::load_with(path, &model.robot, Some(map))?)));
    }
    if predicted::is_log(text, model) {
        return Ok(Loaded::Log(Box::new(Log::parse(text.clone(), &model.robot)?)));
    }
    reading.load(path, text.clone()).map(|p| Loaded::Program(Box::new(p))).map_err(Into::into)
}

/// Figures of the path, then the reversals.
fn tables(result: &Assessment, text: Option<TextDifference>, robot: &Robot) -> String {
    let f = &result.figures;
    let mut out = format!("{} -> {}: {}\n\n", result.before.name, result.after.name, f.sentence());
    let mut whole = table(&["along the path", "before", "after"]);
    let mut errors = vec![("rms, um", f.rms_m), ("mean, um", f.mean_m), ("largest, um", f.largest_m)];
    if let Some(t) = &f.at_targets {
        errors.extend([("rms at the targets, um", t.rms_m), ("largest at the targets, um", t.largest_m)]);
    }
    for (name, pair) in errors {
        whole.add_row([name.to_string(), format!("{:.1}", pair[0] * 1e6), format!("{:.1}", pair[1] * 1e6)]);
    }
    whole.add_row(["cycle time, s".to_string(), format!("{:.2}", f.cycle_s[0]), format!("{:.2}", f.cycle_s[1])]);
    whole.add_row(["points".to_string(), f.points[0].to_string(), f.points[1].to_string()]);
    whole.add_row(["stops".to_string(), f.stops[0].to_string(), f.stops[1].to_string()]);
    let _ = writeln!(out, "{whole}");
    if let Some(moves) = result.moves.map(MovesShown::of) {
        let _ = writeln!(out, "moves: {}", moves.text());
    }
    if let Some(t) = text {
        let _ = writeln!(
            out,
            "text: {} unchanged, {} changed, {} added, {} removed",
            counted(t.unchanged, "line"),
            t.changed,
            t.added,
            t.removed
        );
    }
    if result.reversals.is_empty() {
        return out;
    }
    let mut reversals = table(&["reversal", "at s", "command", "turns", "before um", "after um"]);
    for r in &result.reversals {
        let joint = robot.axis(r.axis);
        reversals.add_row([
            joint.name.clone(),
            format!("{:.2}", r.at_s),
            format!("{:.4} {}", joint.kind.to_user_unit(r.command), joint.kind.unit()),
            if r.direction > 0 { "up" } else { "down" }.to_string(),
            format!("{:.1}", r.before_m * 1e6),
            format!("{:.1}", r.after_m * 1e6),
        ]);
    }
    let _ = writeln!(out, "\n{reversals}");
    out
}
