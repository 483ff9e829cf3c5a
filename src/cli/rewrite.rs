//! `lostmotion rewrite`: program and compensator in, program with reversal points and offsets out.

use crate::cli::{page, paths};
use crate::compensator::{Compensator, file::is_past, from_model::not_compensated};
use crate::error::{Error, Place, Result, is_stdio, shown};
use crate::io::input;
use crate::io::output::{self, Output, write_whole};
use crate::model::Model;
use crate::rewrite::job::{Job, Outcome, Target};
use crate::rewrite::statics::Statics;
use crate::rewrite::stream::guard::{Named, note_path};
use crate::rewrite::summary::{Line, Status, document, words};
use crate::rewrite::{Options, Refine, batch};
use crate::robot::{JointKind, Robot};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

/// Put reversal points and offsets into a joint-space program.
///
/// Behind every reversal of a joint the command jumps by its gap, so that the joint itself does not stand still; a friction
/// offset is added and fades. Only the numbers of motion targets change and points are added; every other byte of the
/// program stays as it is. Nothing is written where a joint limit would be exceeded.
///
/// Examples:
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run
///   lostmotion rewrite --model machine.yaml program.csv --output out.csv --speed-mm-s 10
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml cell/ --output-dir done/ --summary summary.jsonl
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Program (joint-space CSV: a1_deg,a2_deg,... and perhaps t_s), `-` for standard input, or a folder of programs
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    /// Robot file; its fingerprint must be that of the compensator's robot
    #[arg(long, value_name = "FILE", required_unless_present = "model", requires = "compensator")]
    pub robot: Option<PathBuf>,

    /// Compensator file, as `fit` writes it
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub compensator: Option<PathBuf>,

    /// Model file: compensate every effect in it that an offset can, in place of --robot and --compensator
    #[arg(long, value_name = "FILE", conflicts_with_all = ["robot", "compensator"])]
    pub model: Option<PathBuf>,

    /// Where the rewritten program goes; `-` for standard output. A note FILE.lostmotion.json is left beside it
    #[arg(long, short, value_name = "FILE", required_unless_present_any = ["dry_run", "check", "output_dir"])]
    pub output: Option<PathBuf>,

    /// Where the rewritten programs of a folder go, under their own names
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "check"])]
    pub output_dir: Option<PathBuf>,

    /// Write a line of JSON for each program to this file (status, reason, moves, reversals, hashes)
    #[arg(long, value_name = "FILE")]
    pub summary: Option<PathBuf>,

    /// How turning points between program points are found: not at all, on a cubic through the joints, on arcs of the TCP path
    #[arg(long, value_enum)]
    pub refine: Option<RefineArg>,

    /// Share of the segment behind a reversal at which the point stands that carries the step [default: 0.1, nearer where the
    /// joint would lag until then]
    #[arg(long, value_name = "0..1")]
    pub step_fraction: Option<f64>,

    /// Spread the step of a revolute joint over this travel behind the reversal, degrees
    #[arg(long, value_name = "DEG")]
    pub ramp_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM")]
    pub ramp_mm: Option<f64>,

    /// Directions in which joints were moved before the first point, such as A1=+,A2=-; else that of their first movement
    #[arg(long, value_name = "JOINT=SIGN,...", allow_hyphen_values = true)]
    pub initial_direction: Option<String>,

    /// Share of every offset that is applied, 0 to 1 (over-compensation does more harm than a rest)
    #[arg(long, value_name = "0..1", default_value_t = 1.0)]
    pub gain: f64,

    /// TCP speed of a program without t_s, mm/s: turns a decay in seconds into points [default: that of the compensator's log]
    #[arg(long, value_name = "MM_S")]
    pub speed_mm_s: Option<f64>,

    /// With --refine cartesian: largest distance between the path and its chords, um [default: 2]
    #[arg(long, value_name = "UM")]
    pub chord_um: Option<f64>,

    /// Movement of a revolute joint that is number noise and no reversal, degrees [default: 1.5 last digits of its column]
    #[arg(long, value_name = "DEG")]
    pub deadband_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM")]
    pub deadband_mm: Option<f64>,

    /// Write changed numbers with this many decimals [default: as they are, more where the gap needs them]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=12))]
    pub decimals: Option<u8>,

    /// Say what would be done and write nothing
    #[arg(long, conflicts_with = "check")]
    pub dry_run: bool,

    /// Compare with this file in place of writing; exit code 1 and the first difference where they differ
    #[arg(long, value_name = "GOLDEN")]
    pub check: Option<PathBuf>,

    /// Rewrite a program that has been rewritten already
    #[arg(long)]
    pub force: bool,

    /// Print the account as one JSON document on standard output
    #[arg(long)]
    pub json: bool,

    /// Write a self-contained HTML page with figures and tables here
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `--refine`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum RefineArg {
    /// The program's own points are the turning points
    None,
    /// Turning points on a local cubic through the joint values
    Cubic,
    /// Arcs through the TCP path: turning points on the smooth path, and points until its chords are short
    Cartesian,
}

impl From<RefineArg> for Refine {
    fn from(r: RefineArg) -> Self {
        match r {
            RefineArg::None => Self::None,
            RefineArg::Cubic => Self::Cubic,
            RefineArg::Cartesian => Self::Cartesian,
        }
    }
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    refuse_shared(&args)?;
    let source = Source::load(&args)?;
    let job = job(&args, &source)?;
    job.check_robot(&source.file)?;
    note_age(&source);
    for line in &source.left {
        eprintln!("note: not compensated: {line}");
    }
    if args.json && args.output.as_deref() == Some(Path::new("-")) {
        return Err(usage("--json with --output -", "one of them: both go to standard output"));
    }
    if args.input != Path::new("-") && args.input.is_dir() {
        return folder(&args, &job);
    }
    if args.output_dir.is_some() {
        return Err(usage("--output-dir with a single program", "a folder as IN, or --output"));
    }
    let target = match (&args.check, args.dry_run, &args.output) {
        (Some(golden), ..) => Target::Check(golden),
        (None, false, Some(path)) => Target::File(path),
        _ => Target::DryRun,
    };
    let dry = !matches!(target, Target::File(_));
    let mut summary = output::create(args.summary.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let bar = bytes_bar(&args.input);
    let result = job.prepare(&args.input, target, &|bytes| bar.set_position(bytes));
    bar.finish_and_clear();
    let ready = match result {
        Ok(ready) => ready,
        Err(e) => {
            summarise(&mut summary, &[Line::failed(shown(&args.input), &e, None)])?;
            output::commit([summary])?;
            return Err(e);
        }
    };
    summarise(&mut summary, &[Line::of(&ready.outcome)])?;
    page::write(&mut report, || page::rewrite::of_outcome(&source.robot, &source.compensator, &ready.outcome))?;
    let outcome = ready.commit()?;
    output::commit([summary, report])?;
    if args.json {
        print(&document(&outcome, &source.robot))?;
    } else {
        eprint!("{}", words(&outcome, &source.robot, dry || outcome.refusal.is_some()));
    }
    said(outcome)
}

/// Says so where the last day of the compensator has passed: gaps grow with wear.
fn note_age(source: &Source) {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let past = |day: &&String| is_past(day, (seconds / 86_400) as i64);
    if let Some(day) = source.compensator.evidence.valid_until.as_ref().filter(past) {
        eprintln!("note: {}: valid until {day}; identify again", source.file);
    }
}

/// The refusal of an outcome as the command's error.
fn said(outcome: Outcome) -> Result<()> {
    outcome.refusal.map_or(Ok(()), |r| Err(Error::Refused(r)))
}

fn folder(args: &Args, job: &Job) -> Result<()> {
    if args.output.is_some() || args.check.is_some() {
        return Err(usage("a folder as IN with --output or --check", "--output-dir"));
    }
    let output = if args.dry_run { None } else { args.output_dir.as_deref() };
    if output.is_none() && !args.dry_run {
        return Err(usage("a folder as IN without --output-dir", "--output-dir"));
    }
    if let Some(output) = output.filter(|_| !args.force) {
        refuse_in_place(&args.input, output)?;
    }
    let programs = batch::programs(&args.input, output.unwrap_or(Path::new("")))?;
    if let Some(folder) = output {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "make", e))?;
    }
    if let Some(file) = &args.summary {
        for program in &programs {
            let ours = [Some(args.input.join(program)), output.map(|o| o.join(program))];
            if let Some(other) = ours.iter().flatten().find(|p| paths::same(file, p)) {
                let found = format!("the same file as the program {}", shown(other));
                return Err(Error::bad(Place::file("--summary"), found, "a file of its own"));
            }
        }
    }
    let mut summary = output::create(args.summary.as_deref())?;
    let bar = if std::io::stderr().is_terminal() {
        ProgressBar::new(programs.len() as u64).with_style(style("{wide_bar} {pos}/{len} programs"))
    } else {
        ProgressBar::hidden()
    };
    let lines = batch::run(job, &args.input, &programs, output, &|| bar.inc(1));
    bar.finish_and_clear();
    summarise(&mut summary, &lines)?;
    output::commit([summary])?;
    let count = |s: Status| lines.iter().filter(|l| l.status == s).count();
    let (refused, failed) = (count(Status::Refused), count(Status::Failed));
    for l in lines.iter().filter(|l| matches!(l.status, Status::Refused | Status::Failed)) {
        eprintln!("{}: {}", l.input, l.reason.as_deref().unwrap_or(""));
    }
    if args.json {
        print(&serde_json::json!({"schema": "lostmotion/rewrite-batch/1", "programs": lines}))?;
    }
    eprintln!(
        "{} programs: {} written, {} unchanged, {refused} refused, {failed} failed",
        lines.len(),
        count(Status::Written),
        count(Status::Unchanged)
    );
    if refused + failed > 0 {
        return Err(Error::Refused(format!("{} of {} programs were not rewritten", refused + failed, lines.len())));
    }
    Ok(())
}

/// Robot, compensator, and where they came from.
struct Source {
    robot: Robot,
    compensator: Compensator,
    named: Named,
    file: String,
    /// Side of its gap on which each axis starts, where a model says so.
    preload: Option<Vec<i8>>,
    /// Static joint errors of a model.
    statics: Option<Arc<Statics>>,
    /// What of a model is not compensated.
    left: Vec<String>,
}

impl Source {
    fn load(args: &Args) -> Result<Self> {
        let (mut statics, mut left) = (None, Vec::new());
        let (robot, compensator, path, preload) = match (&args.model, &args.robot, &args.compensator) {
            (Some(path), ..) => {
                let model = Model::load(path)?;
                let speed = args.speed_mm_s.map(|v| v * 1e-3);
                let compensator = Compensator::from_model_at(&model, speed.unwrap_or(0.0))?;
                statics = Statics::of_model(&model).map(Arc::new);
                left = not_compensated(&model, speed);
                (model.robot, compensator, path, Some(model.preload))
            }
            (None, Some(robot), Some(path)) => {
                let robot = Robot::load(robot)?;
                let compensator = Compensator::load(path, &robot)?;
                (robot, compensator, path, None)
            }
            _ => return Err(usage("no compensator", "--robot and --compensator, or --model")),
        };
        let sha256 = input::read(path)?.sha256;
        let name = path.file_name().map_or_else(|| shown(path), |n| n.to_string_lossy().into_owned());
        Ok(Self { robot, compensator, named: Named { name, sha256 }, file: shown(path), preload, statics, left })
    }
}

/// The job that the arguments ask for, every value checked.
fn job<'a>(args: &Args, source: &'a Source) -> Result<Job<'a>> {
    let robot = &source.robot;
    let mut options = Options::new(robot.dof());
    options.statics = source.statics.clone();
    let mut said = Vec::new();
    if let Some(r) = args.refine {
        options.refine = r.into();
        said.push(format!("refine {}", format!("{r:?}").to_lowercase()));
    }
    let number = |flag: &str, value: Option<f64>, ok: &dyn Fn(f64) -> bool, expected: &str| match value {
        Some(v) if !(v.is_finite() && ok(v)) => Err(usage(&format!("--{flag} {v}"), expected)),
        v => Ok(v),
    };
    if let Some(f) =
        number("step-fraction", args.step_fraction, &|v| v > 0.0 && v < 1.0, "a share above 0 and below 1")?
    {
        options.step_fraction = f;
        options.step_exact = true;
        said.push(format!("step_fraction {f}"));
    }
    if number("gain", Some(args.gain), &|v| (0.0..=1.0).contains(&v), "a share from 0 to 1")? != Some(1.0) {
        options.gain = args.gain;
        said.push(format!("gain {}", args.gain));
    }
    let per_axis = |deg: Option<f64>, mm: Option<f64>| -> Vec<Option<f64>> {
        let joints = robot.axis_joints().map(|j| j.kind);
        joints
            .map(|k| if k == JointKind::Revolute { deg.map(|v| v * k.si()) } else { mm.map(|v| v * k.si()) })
            .collect()
    };
    let positive: (&dyn Fn(f64) -> bool, &str) = (&|v| v >= 0.0, "a number of 0 or more");
    let ramp_deg = number("ramp-deg", args.ramp_deg, positive.0, positive.1)?;
    let ramp_mm = number("ramp-mm", args.ramp_mm, positive.0, positive.1)?;
    options.ramp = per_axis(ramp_deg, ramp_mm).into_iter().map(|v| v.unwrap_or(0.0)).collect();
    let deadband_deg = number("deadband-deg", args.deadband_deg, positive.0, positive.1)?;
    let deadband_mm = number("deadband-mm", args.deadband_mm, positive.0, positive.1)?;
    for (what, v) in [
        ("ramp_deg", ramp_deg),
        ("ramp_mm", ramp_mm),
        ("deadband_deg", deadband_deg),
        ("deadband_mm", deadband_mm),
        ("speed_mm_s", args.speed_mm_s),
        ("chord_um", args.chord_um),
        ("decimals", args.decimals.map(f64::from)),
    ] {
        said.extend(v.map(|v| format!("{what} {v}")));
    }
    if let Some(side) = &source.preload {
        options.initial_direction = side.clone();
    }
    if let Some(text) = &args.initial_direction {
        directions(text, robot, &mut options.initial_direction)?;
        said.push(format!("initial_direction {text}"));
    }
    let speed = number("speed-mm-s", args.speed_mm_s, &|v| v > 0.0, "a speed above 0")?;
    options.tcp_speed_m_s = speed.map(|v| v * 1e-3).or(source.compensator.evidence.tcp_speed_m_s);
    if let Some(c) = number("chord-um", args.chord_um, &|v| v > 0.0, "a distance above 0")? {
        options.chord_m = c * 1e-6;
    }
    Ok(Job {
        robot,
        compensator: &source.compensator,
        source: source.named.clone(),
        options,
        deadband: per_axis(deadband_deg, deadband_mm),
        decimals: args.decimals,
        said,
        force: args.force,
        hash: args.json || args.summary.is_some() || args.output_dir.is_some(),
        threads: !(args.input != Path::new("-") && args.input.is_dir()),
    })
}

/// `A1=+,A2=-` into one sign per axis.
fn directions(text: &str, robot: &Robot, into: &mut [i8]) -> Result<()> {
    for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
        let (joint, sign) = part.split_once('=').unwrap_or((part, ""));
        let sign = match sign.trim() {
            "+" | "+1" | "1" => 1,
            "-" | "-1" => -1,
            "0" => 0,
            _ => return Err(usage(&format!("--initial-direction {part}"), "JOINT=+ or JOINT=-, such as A1=+,A2=-")),
        };
        match robot.axis_named(joint.trim()) {
            Some(axis) => into[axis] = sign,
            None => {
                let expected = format!("a joint of {}", robot.axis_names().join(", "));
                return Err(usage(&format!("--initial-direction {part}"), &expected));
            }
        }
    }
    Ok(())
}

fn usage(found: &str, expected: &str) -> Error {
    Error::bad(Place::file("command line"), found, expected)
}

/// Refuses files that are named twice, and a program that would be replaced by its own result.
fn refuse_shared(args: &Args) -> Result<()> {
    let writes = args.output.as_deref().filter(|_| !args.dry_run && args.check.is_none());
    let in_place = writes.is_some_and(|o| paths::same(o, &args.input));
    if in_place && !args.force {
        let expected = "another file: the program as it is would be lost (--force replaces it)";
        return Err(Error::bad(Place::file("--output"), "the program itself", expected));
    }
    let note = writes.filter(|o| !is_stdio(o)).map(note_path);
    let inputs = [
        ("--robot", args.robot.as_deref()),
        ("--compensator", args.compensator.as_deref()),
        ("--model", args.model.as_deref()),
        ("--check", args.check.as_deref()),
        ("IN", Some(args.input.as_path()).filter(|_| !in_place)),
    ];
    let outputs = [
        ("--output", writes),
        ("the note beside --output", note.as_deref()),
        ("--summary", args.summary.as_deref()),
        ("--report", args.report.as_deref()),
    ];
    paths::refuse_shared(&inputs, &outputs)
}

/// Refuses an output folder that is the input folder, or holds it: results would stand where programs are. An output
/// folder inside the input folder replaces nothing; it is left out of the programs.
fn refuse_in_place(input: &Path, output: &Path) -> Result<()> {
    let (Ok(from), Ok(to)) = (std::fs::canonicalize(input), std::fs::canonicalize(output)) else { return Ok(()) };
    if !from.starts_with(&to) {
        return Ok(());
    }
    let found = if from == to { "the folder of the programs" } else { "a folder that holds the programs" };
    let expected = "another folder: the programs as they are could be lost (--force replaces them)";
    Err(Error::bad(Place::file("--output-dir"), found, expected))
}

fn summarise(summary: &mut Option<Output>, lines: &[Line]) -> Result<()> {
    let Some(out) = summary else { return Ok(()) };
    let text: String = lines.iter().map(|l| l.json() + "\n").collect();
    out.put(text.as_bytes())
}

fn print(document: &serde_json::Value) -> Result<()> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|e| Error::bad(Place::default(), e.to_string(), "values that JSON can hold"))?;
    write_whole(Path::new("-"), (text + "\n").as_bytes())
}

/// A bar over the bytes of a large file, on a terminal.
fn bytes_bar(input: &Path) -> ProgressBar {
    const LARGE: u64 = 32 << 20;
    match std::fs::metadata(input) {
        Ok(m) if m.is_file() && m.len() > LARGE && std::io::stderr().is_terminal() => {
            ProgressBar::new(m.len()).with_style(style("{wide_bar} {bytes}/{total_bytes} {eta}"))
        }
        _ => ProgressBar::hidden(),
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
