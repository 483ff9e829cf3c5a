//! `lostmotion simulate`: model + program or log -> predicted log.
//!
//! - `note`: what a user should know

mod note;

use crate::cli::exit::bad;
use crate::cli::{page, paths};
use crate::effects::{Idle, WhyIdle, entry};
use crate::error::{Place, counted, is_stdio, shown};
use crate::gaps::file::NameAndHash;
use crate::io::bag::TopicChoice;
use crate::io::input;
use crate::io::output::{self, Output};
use crate::log::ColumnMap;
use crate::log::Log;
use crate::log::text::LogText;
use crate::model::Model;
use crate::program::{Program, ScriptPath};
use crate::rewrite::script::path::Reading;
use crate::robot::Robot;
use crate::robot::frames::Frames;
use crate::simulate::{Motion, Note as OfLog, Options, Timing, Written, predicted};
use anyhow::Result;
use note::Note;
use std::path::{Path, PathBuf};

/// Run a program, or the commands of a log, on a modelled machine and write the log that a tracker would record.
///
/// A program runs with linear joint motion between its points, and along its straight lines and arcs where it has Cartesian targets:
/// at its own times or speeds if it has them, otherwise at a constant TCP speed. A log keeps its rows, times and commands; its measured
/// columns are replaced by predictions. Without --noise-um the result has no noise. With --robot the TCP is that of the robot file, without
/// errors.
///
/// Examples:
///   lostmotion simulate --model machine.yaml --input circle.csv --output circle_log.csv
///   lostmotion simulate --model machine.yaml --input circle.csv --rate-hz 250 --noise-um 11 -o log.csv
///   lostmotion simulate --model machine.yaml --input measured.csv.gz --output predicted.csv
///   lostmotion simulate --robot robot.yaml --input tracker.csv --columns map.yaml --output nominal.csv
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Model file (YAML): the robot and its known effects
    #[arg(long, value_name = "MODEL.yaml", required_unless_present = "robot", conflicts_with = "robot")]
    pub model: Option<PathBuf>,
    /// Robot file (YAML) instead of a model: a robot without errors, the TCP in the frame of the robot file
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: Option<PathBuf>,
    /// Program or log to run (CSV, or .csv.gz); `-` for standard input
    #[arg(long, value_name = "PROGRAM_OR_LOG")]
    pub input: PathBuf,
    /// Column map for a log with other names or units; the predicted log keeps them
    #[arg(long, value_name = "MAP.yaml")]
    pub columns: Option<PathBuf>,
    /// Frames and tools of a program's Cartesian targets by the controller's names (YAML, or the controller's own file)
    #[arg(long, value_name = "FRAMES.yaml")]
    pub frames: Option<PathBuf>,
    /// Write the predicted log to this file; `-` for standard output
    #[arg(long, short, value_name = "LOG.csv", default_value = "-")]
    pub output: PathBuf,
    /// Standard deviation of the white noise added to each coordinate, um [default: no noise]
    #[arg(long, value_name = "UM", value_parser = not_negative)]
    pub noise_um: Option<f64>,
    /// Seed of the noise; the same seed gives the same log
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Rows per second of the predicted log of a program, Hz [default: 25]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub rate_hz: Option<f64>,
    /// TCP speed of a program, mm/s; overrides the program's own times [default: its own times and speeds, otherwise 1.5]
    #[arg(long, value_name = "MM_S", value_parser = above_zero)]
    pub speed_mm_s: Option<f64>,
    /// Write the TCP in the frame of the robot file instead of the tracker's frame
    #[arg(long)]
    pub base_frame: bool,
    /// Print a summary of the log as one JSON document on standard output; needs --output FILE
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Add encoder columns (enc_A1_deg, ...): the motor side of each joint
    #[arg(long)]
    pub encoders: bool,
    /// Add screw columns (screw_Z_deg, ...): the screw, between the gaps of coupling and nut
    #[arg(long)]
    pub screws: bool,
}

fn finite(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| "expected a number with a decimal point".into())
}

fn not_negative(text: &str) -> std::result::Result<f64, String> {
    finite(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("expected 0 or more".into()) })
}

fn above_zero(text: &str) -> std::result::Result<f64, String> {
    finite(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("expected more than 0".into()) })
}

fn rate(text: &str) -> std::result::Result<f64, String> {
    above_zero(text).and_then(|v| if v <= 1e5 { Ok(v) } else { Err("expected at most 100000 Hz".into()) })
}

/// What was written, and what to say of it.
struct Run {
    rows: usize,
    notes: Vec<Note>,
    /// The rows are settled poses.
    settled: bool,
}

impl Run {
    fn of(written: Written, settled: bool) -> Self {
        Self { rows: written.rows, notes: written.notes.into_iter().map(Note::Log).collect(), settled }
    }
}

/// A log whose measurement is replaced by the model's.
fn again(args: &Args, model: &Model, options: &mut Options, text: &LogText, out: &mut Output) -> Result<Run> {
    let log = text.log(&model.robot)?;
    options.encoders |= log.enc.iter().any(Option::is_some);
    let motion = Motion::of_log(model, &log);
    let mapped = args.columns.is_some() || text.is_recording;
    let mut run = Run::of(predicted::write_log_again(model, &motion, options, text, mapped, out)?, log.poses);
    if args.rate_hz.is_some() || args.speed_mm_s.is_some() {
        run.notes.push(Note::KeepsRows);
    }
    if log.poses {
        run.notes.push(OfLog::SettledPoses.into());
    }
    Ok(run)
}

/// The machine: of a model file, or of a robot file alone.
fn machine(args: &Args) -> Result<Model> {
    let mut model = match (&args.model, &args.robot) {
        (Some(path), _) => Model::load(path)?,
        (None, Some(path)) => Model::ideal(Robot::load(path)?),
        (None, None) => return Err(bad(Place::default(), "no machine", "--model MODEL.yaml or --robot ROBOT.yaml")),
    };
    if args.base_frame {
        model.registration = None;
    }
    Ok(model)
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--model", args.model.as_deref()),
        ("--robot", args.robot.as_deref()),
        ("--input", Some(args.input.as_path())),
        ("--columns", args.columns.as_deref()),
        ("--frames", args.frames.as_deref()),
    ];
    paths::refuse_shared(&inputs, &[("--output", Some(args.output.as_path())), ("--report", args.report.as_deref())])?;
    paths::refuse_program_ending("--output", Some(&args.output))?;
    if args.json && is_stdio(&args.output) {
        let expected = "a file, because standard output contains the document";
        return Err(bad(Place::file("--output"), "standard output with --json", expected));
    }
    let mut out = Output::create(&args.output)?;
    let mut report = output::create(args.report.as_deref())?;
    let model = machine(&args)?;
    let map = args.columns.as_deref().map(ColumnMap::load).transpose()?;
    let text = LogText::of(input::read(&args.input)?, &model.robot, map.as_ref(), TopicChoice::Any)?;
    let input = &text.input;
    let from = page::simulate::From { name: input.name.clone(), sha256: input.sha256.clone() };
    let mut options = options_of(&args);
    let mut run = if map.is_some() || text.is_recording || predicted::is_log(input, &model) {
        again(&args, &model, &mut options, &text, &mut out)?
    } else {
        of_program(&args, &model, &options, text.input, &mut out)?
    };
    for e in &model.effects {
        if let Some(why) = e.effect.idle(&e.site(&model.robot), run.settled) {
            let target = e.target_text(&model.robot);
            run.notes.push(Note::Log(OfLog::Idle(Idle { effect: e.effect.name(), target, why: WhyIdle::Here(why) })));
        }
    }
    // with the columns of a map the log is theirs, and not drawn
    let log = match report.is_some() && map.is_none() {
        true => {
            let bytes = input::from_bytes(shown(&args.output), out.contents()?)?;
            Log::parse(bytes, &model.robot).ok().filter(|l| !l.is_empty())
        }
        false => None,
    };
    let notes = || run.notes.iter().map(Note::to_string).collect();
    page::write(&mut report, || page::simulate::of_run(&model, &from, run.rows, notes(), log.as_ref()))?;
    let mut document = args.json.then(|| Output::create(Path::new("-"))).transpose()?;
    if let Some(document) = &mut document {
        let text = serde_json::to_string_pretty(&summary(&model, &from, &args, &run)).unwrap_or_default();
        document.put((text + "\n").as_bytes())?;
    }
    output::commit([Some(out), report, document])?;
    for note in &run.notes {
        eprintln!("note: {note}");
    }
    eprintln!("{}", counted(run.rows, "row"));
    Ok(())
}

/// Runs the program of `input` on the machine.
fn of_program(args: &Args, model: &Model, options: &Options, input: input::Input, out: &mut Output) -> Result<Run> {
    let frames = args.frames.as_deref().map(Frames::load).transpose()?.unwrap_or_default();
    let reading = Reading::new(&model.robot, &frames, args.speed_mm_s);
    let program = reading.load(&args.input, input)?;
    let (t_s, notes) = times(args, model, &program, options);
    let motion = Motion::of_program(model, &program, &t_s, options.rate_hz)?;
    let mut run = Run::of(predicted::write_program_log(model, &motion, options, &program.name, out)?, false);
    run.notes.extend(notes);
    Ok(run)
}

/// Options of the run in SI.
fn options_of(args: &Args) -> Options {
    let defaults = Options::default();
    Options {
        rate_hz: args.rate_hz.unwrap_or(defaults.rate_hz),
        speed_m_s: args.speed_mm_s.map_or(defaults.speed_m_s, |v| v * 1e-3),
        noise_m: args.noise_um.unwrap_or(0.0) * 1e-6,
        seed: args.seed,
        encoders: args.encoders,
        screws: args.screws,
    }
}

/// What `--json` prints; the log itself is in `--output`.
#[derive(serde::Serialize)]
struct Summary<'a> {
    schema: &'static str,
    input: NameAndHash,
    output: String,
    robot: NameAndHash,
    effects: Vec<serde_yaml::Value>,
    rows: usize,
    noise_um: f64,
    seed: u64,
    notes: &'a [Note],
}

fn summary<'a>(model: &Model, from: &page::simulate::From, args: &Args, run: &'a Run) -> Summary<'a> {
    Summary {
        schema: "lostmotion/simulation/1",
        input: NameAndHash { name: from.name.clone(), sha256: from.sha256.clone() },
        output: shown(&args.output),
        robot: NameAndHash::of_robot(&model.robot),
        effects: model.effects.iter().map(|e| entry::write(e, &model.robot)).collect(),
        rows: run.rows,
        noise_um: args.noise_um.unwrap_or(0.0),
        seed: args.seed,
        notes: &run.notes,
    }
}

/// Times of the program's points, with what a user should know about them.
fn times(args: &Args, model: &Model, program: &Program, options: &Options) -> (Vec<f64>, Vec<Note>) {
    let left = program.script.as_ref().map(ScriptPath::left).unwrap_or_default();
    let mut notes: Vec<Note> = left.into_iter().map(|note| Note::Log(note.into())).collect();
    if let (Some(t_s), None) = (&program.t_s, args.speed_mm_s) {
        return (t_s.clone(), notes);
    }
    let timing = Timing::at_speed(&model.robot, program, options.speed_m_s);
    let speed_m_s = options.speed_m_s;
    if program.t_s.is_some() {
        notes.push(Note::TimesIgnored { speed_m_s });
    } else if args.speed_mm_s.is_none() {
        notes.push(Note::NoTimes { speed_m_s });
    }
    if timing.held_by_a_joint > 0 {
        notes.push(OfLog::HeldByJoint { segments: timing.held_by_a_joint }.into());
    }
    if timing.unknown_speed > 0 {
        notes.push(OfLog::UnknownSpeed { segments: timing.unknown_speed }.into());
    }
    (timing.t_s, notes)
}
