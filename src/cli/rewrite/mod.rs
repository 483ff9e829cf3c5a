//! `lostmotion rewrite`: program and compensator in, program with reversal points and offsets out.

mod folder;
mod job;
mod proof;
mod text;

use crate::cli::console::shows_progress;
use crate::cli::exit::Finished;
use crate::cli::exit::{bad, no};
use crate::cli::{page, paths};
use crate::compensator::file::is_past;
use crate::error::{Error, Place, is_stdio, shown};
use crate::io::journal::{self, Towards};
use crate::io::output::{self, Output};
use crate::program::files::Files;
use crate::program::formats;
use crate::rewrite::equation2::Law;
use crate::rewrite::guard::note_path;
use crate::rewrite::job::Job;
use crate::rewrite::outcome::{Outcome, Target};
use crate::rewrite::summary::{Document, Line, document};
use crate::rewrite::{LimitKind, Refine};
use crate::robot::JointKind;
use crate::robot::frames::Missing;
use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use job::Source;
use proof::Proof;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use text::{Verbosity, format_text};

/// Add reversal points and offsets to a robot program.
///
/// After each reversal of a joint, its command steps across the gap, so that the joint itself keeps moving; a friction
/// offset is added and fades. Only the numbers of motion targets are changed, and points are added; every other byte of the
/// program stays as it is. If a joint limit would be exceeded, nothing is written. Programs can be joint-space CSV, Yaskawa
/// INFORM, ABB RAPID, KUKA KRL, FANUC TP, URScript, ROS trajectories, or G-code.
///
/// Examples:
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run
///   lostmotion rewrite --model machine.yaml program.csv --output out.csv --speed-mm-s 10
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml cell/ --output-dir done/ --summary summary.jsonl
#[derive(Debug, clap::Args)]
#[command(
    verbatim_doc_comment,
    override_usage = "lostmotion rewrite [OPTIONS] --robot <FILE> --compensator <FILE> --output <FILE> <IN>\n       lostmotion rewrite [OPTIONS] --robot <FILE> --compensator <FILE> --output-dir <FOLDER> <IN_FOLDER>\n       lostmotion rewrite [OPTIONS] --model <FILE> <--output <FILE>|--output-dir <FOLDER>> <IN>\n       lostmotion rewrite [OPTIONS] ... <--check <GOLDEN>|--dry-run> <IN>"
)]
pub struct Args {
    /// Program (joint-space CSV with a1_deg,a2_deg,... and optionally t_s, or a vendor program), `-` for standard input, or
    /// a folder of programs
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    /// Robot file (YAML); it must describe the robot for which the compensator was made
    #[arg(long, value_name = "FILE", required_unless_present = "model", requires = "compensator")]
    pub robot: Option<PathBuf>,

    /// Compensator file (YAML) from `fit`
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub compensator: Option<PathBuf>,

    /// Model file (YAML): compensate every effect in it that joint offsets can undo; instead of --robot and --compensator
    #[arg(long, value_name = "FILE", conflicts_with_all = ["robot", "compensator"])]
    pub model: Option<PathBuf>,

    /// Write the rewritten program to this file; `-` for standard output. The note FILE.lostmotion.json, which `undo` needs,
    /// is written next to it
    #[arg(long, short, value_name = "FILE", conflicts_with = "check", required_unless_present_any = ["dry_run", "check", "output_dir", "list_frames"])]
    pub output: Option<PathBuf>,

    /// Format of the program: csv, inform, rapid, krl, fanuc, urscript, trajectory or gcode [default: recognised from the
    /// file's extension and content]
    #[arg(long, value_name = "NAME")]
    pub format: Option<String>,

    /// Modes in which the control reads G-code until the program sets them: G90 or G91, G20 or G21; for example G21,G90
    /// [default: `control` in the robot file]
    #[arg(long, value_name = "WORD,...")]
    pub assume: Option<String>,

    /// Write the rewritten programs of a folder to this folder, under the same names. Programs that are already finished
    /// there are skipped
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "check"])]
    pub output_dir: Option<PathBuf>,

    /// Write one line of JSON for each program to this file (status, reason, moves, reversals, hashes)
    #[arg(long, value_name = "FILE")]
    pub summary: Option<PathBuf>,

    /// Rewrite only part K of N of a folder, for job arrays; for example 3/16
    #[arg(long, value_name = "K/N", requires = "output_dir")]
    pub shard: Option<String>,

    /// Rewrite only those programs of a folder that this manifest (from `lostmotion manifest`) lists and whose size and
    /// SHA-256 are still as listed. Each line of the summary contains the key of its program
    #[arg(long, value_name = "FILE.jsonl", requires = "output_dir")]
    pub manifest: Option<PathBuf>,

    /// Which programs of a folder set the exit code to 1; the summary lists all of them in any case
    #[arg(long, value_enum, default_value_t = FailOn::Refused)]
    pub fail_on: FailOn,

    /// Exit with code 3 if no program needed a change
    #[arg(long)]
    pub exit_code: bool,

    /// Minimum share of the moves whose joint targets can be edited, such as 100%. Below it nothing is written and the exit
    /// code is 1
    #[arg(long, value_name = "PERCENT")]
    pub require_coverage: Option<String>,

    /// Replace straight Cartesian moves between joint moves by joint moves that stay within this distance of the line, um
    /// [without a value: 20]
    #[arg(long, value_name = "UM", num_args = 0..=1, require_equals = true, default_missing_value = "20")]
    pub solve_cartesian: Option<f64>,

    /// File of the controller's frames and tools by name (lostmotion/frames/1), in addition to those of the robot file.
    /// Cartesian targets in other frames stay as they are
    #[arg(long, value_name = "FILE")]
    pub frames: Option<PathBuf>,

    /// Print only a template for --frames on standard output: every unknown frame and tool, with the number of moves that
    /// need it
    #[arg(long, conflicts_with_all = ["output", "check", "json"])]
    pub list_frames: bool,

    /// Leave Cartesian targets as they are
    #[arg(long)]
    pub leave_cartesian: bool,

    /// Maximum number of points added to a program. If more were needed, steps are spread over whole moves instead
    #[arg(long, value_name = "N")]
    pub max_added: Option<u64>,

    /// Add no points while a process (welding, dispensing) is on; the targets of the process are still edited
    #[arg(long)]
    pub leave_process: bool,

    /// Approach every target at which the robot stops from one side: + or - for all joints, or signs for single joints, such
    /// as A1=+,A2=-. A point is added before each target that a joint would reach from the other side, only as far away as
    /// the gap requires (vendor programs only)
    #[arg(long, value_name = "+|-|JOINT=SIGN,...", allow_hyphen_values = true)]
    pub approach_from: Option<String>,

    /// Leave moves as they are while a process (welding, dispensing) is on
    #[arg(long)]
    pub exclude_process: bool,

    /// Joints to leave uncompensated, such as A4,A6
    #[arg(long, value_name = "JOINT,...")]
    pub leave_out: Option<String>,

    /// With --model, compensate only lost motion (gaps and friction), not errors that depend only on the joint position
    #[arg(long, requires = "model")]
    pub lost_motion_only: bool,

    /// Compensate also the joints whose gap is not significant (its 95 % interval contains zero)
    #[arg(long)]
    pub insignificant: bool,

    /// How to find turning points between the points of a joint-space CSV [default: none] (in vendor programs the targets are
    /// the turning points)
    #[arg(long, value_enum)]
    pub refine: Option<RefineArg>,

    /// Law of the offsets: equation 16 of Zhang (2023), or, for comparison, equation 2 of Cursi (2022), which adds no points
    /// and no friction term
    #[arg(long, value_enum, default_value_t = LawArg::Equation16, conflicts_with_all = ["step_fraction", "ramp_deg", "ramp_mm"])]
    pub law: LawArg,

    /// Position of the added point that carries the step, as a share of the segment after the reversal; with 1 the next
    /// point of the program carries the step [default: 0.1, or less if the joint would lag until then]
    #[arg(long, value_name = "0..1", allow_negative_numbers = true)]
    pub step_fraction: Option<f64>,

    /// Spread the step of a revolute joint over this travel after the reversal, deg
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub ramp_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub ramp_mm: Option<f64>,

    /// Directions in which the joints moved before the first point, such as A1=+,A2=- [default: the direction of their first
    /// movement]
    #[arg(long, value_name = "JOINT=SIGN,...", allow_hyphen_values = true)]
    pub initial_direction: Option<String>,

    /// Factor from 0 to 1 by which every offset is multiplied (too much compensation does more harm than too little)
    #[arg(long, value_name = "0..1", default_value_t = 1.0, allow_negative_numbers = true)]
    pub gain: f64,

    /// TCP speed of a program without t_s, or of moves with joint speeds, mm/s; it converts a decay in seconds into points
    /// [default: the speed of the log from which the compensator was made]
    #[arg(long, value_name = "MM_S", allow_negative_numbers = true)]
    pub speed_mm_s: Option<f64>,

    /// With --refine cartesian: largest distance between the path and its chords, um [default: 2]
    #[arg(long, value_name = "UM")]
    pub chord_um: Option<f64>,

    /// Largest movement of a revolute joint that counts as rounding and not as a reversal, deg [default: 1.5 units of the
    /// last digit of its column]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub deadband_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub deadband_mm: Option<f64>,

    /// Write changed numbers with this many decimals [default: as in the program, or more if the gap needs them]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=12))]
    pub decimals: Option<u8>,

    /// Report what would be done, and write nothing
    #[arg(long, conflicts_with = "check")]
    pub dry_run: bool,

    /// Compare the result with this file instead of writing it; with a folder as IN, compare every program with the file of
    /// the same name in this folder. If they differ, print the first difference and exit with code 1
    #[arg(long, value_name = "GOLDEN")]
    pub check: Option<PathBuf>,

    /// With --check, accept numbers that differ by at most this much, in the unit of the program (deg, mm, pulses); all other
    /// text must be equal [default: every byte must be equal]
    #[arg(long, value_name = "N", requires = "check", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,

    /// Rewrite a program even if it has already been rewritten
    #[arg(long)]
    pub force: bool,

    /// Print what was done as one JSON document on standard output
    #[arg(long)]
    pub json: bool,

    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `--law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LawArg {
    /// Half a gap in the direction of movement
    #[value(name = "equation-16")]
    Equation16,
    /// The whole deadzone at the sample where the direction changes, as printed
    #[value(name = "equation-2")]
    Equation2,
    /// The whole deadzone from that sample on
    #[value(name = "equation-2-held")]
    Equation2Held,
}

impl From<LawArg> for Law {
    fn from(l: LawArg) -> Self {
        match l {
            LawArg::Equation16 => Self::Equation16,
            LawArg::Equation2 => Self::Equation2,
            LawArg::Equation2Held => Self::Equation2Held,
        }
    }
}

/// `--refine`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum RefineArg {
    /// Use only the points of the program
    None,
    /// Find turning points on a local cubic through the joint values
    Cubic,
    /// Find turning points on arcs through the TCP path, and add points until the chords follow the arcs
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

/// Which programs of a folder make the exit code 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FailOn {
    /// Programs that were refused or that failed
    Refused,
    /// Only programs that failed
    Failed,
    /// No program
    None,
}

/// Runs the command.
pub fn run(args: Args) -> Result<Finished> {
    refuse_shared(&args)?;
    paths::refuse_missing_folders(&[
        ("--output", args.output.as_deref().filter(|_| !args.dry_run && args.check.is_none())),
        ("--summary", args.summary.as_deref()),
        ("--report", args.report.as_deref()),
    ])?;
    let source = Source::load(&args)?;
    let job = job::of(&args, &source)?;
    job.check_robot(&source.file)?;
    job.check_sizes(&source.file)?;
    note_age(&source);
    for line in &source.left {
        eprintln!("note: not compensated: {line}");
    }
    let folder = args.input != Path::new("-") && args.input.is_dir();
    if args.json && args.output.as_deref() == Some(Path::new("-")) {
        return Err(usage("--json with --output -", "one of them: both go to standard output"));
    }
    let unused = args.output.as_ref().or(args.output_dir.as_ref());
    if let Some(output) = unused.filter(|_| args.dry_run && !args.json) {
        eprintln!("note: {}: not written (--dry-run)", shown(output));
    }
    if folder {
        return folder::run(&args, job);
    }
    if args.manifest.is_some() {
        return Err(usage("--manifest with a single program", "the folder of its programs as IN"));
    }
    if args.output_dir.is_some() {
        return Err(usage("--output-dir with a single program", "a folder as IN, or --output"));
    }
    single(&args, &source, &job)
}

/// Where the result of a single program goes.
fn target(args: &Args) -> Target<'_> {
    match (&args.check, args.dry_run, &args.output) {
        (Some(golden), ..) => Target::Check(golden),
        (None, false, Some(path)) => Target::File(path),
        _ => Target::DryRun,
    }
}

/// A single program: prepare, summarise, prove, write everything together.
fn single(args: &Args, source: &Source, job: &Job) -> Result<Finished> {
    let target = target(args);
    if let Target::File(output) = target
        && !is_stdio(output)
    {
        // what an interrupted run left, before anything is read
        let folders = [Some(output), Some(args.input.as_path()).filter(|i| !is_stdio(i))];
        folders.iter().flatten().filter_map(|f| f.parent()).try_for_each(|f| journal::finish(f, Towards::Before))?;
    }
    if args.list_frames {
        let ready = job.prepare(&args.input, Target::DryRun, &|_| {})?;
        list_frames(ready.outcome.vendor.iter().map(|v| &v.missing))?;
        return Ok(Finished::Done);
    }
    let mut summary = output::create(args.summary.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let bar = bytes_bar(&args.input);
    let result = job.prepare(&args.input, target, &|bytes| bar.set_position(bytes));
    bar.finish_and_clear();
    let mut ready = match result {
        Ok(ready) => ready,
        Err(e) => {
            summarise(&mut summary, &[Line::failed(shown(&args.input), &e, None)])?;
            output::commit([summary])?;
            return Err(e.into());
        }
    };
    suggest_ramp(args, source, &mut ready.outcome);
    summarise(&mut summary, &[Line::of(&ready.outcome)])?;
    let proof = proof::of(args, source, job, &mut ready);
    page::write(&mut report, || {
        let shown = proof.as_ref().and_then(|p| p.shown(args.model.is_some()));
        page::rewrite::of_outcome(&source.robot, &source.compensator, &ready.outcome, shown.as_ref())
    })?;
    let json = args
        .json
        .then(|| {
            printed(&Report {
                rewrite: document(&ready.outcome, &source.robot),
                path_error: proof.as_ref().map(Proof::document),
            })
        })
        .transpose()?;
    let outcome = ready.commit_with([summary, report, json].into_iter().flatten().collect())?;
    if args.check.is_some() {
        return conclude_check(args, outcome);
    }
    if args.dry_run
        && let Some(output) = &args.output
    {
        eprintln!("note: {}: not written (--dry-run)", shown(output));
    }
    if !args.json {
        eprint!("{}", format_text(&outcome, &source.robot, verbosity(args, &outcome)));
        if let Some(proof) = &proof {
            eprint!("{}", proof.words(args.model.is_some(), outcome.vendor.is_some()));
        }
    }
    if outcome.vendor.is_none() && (args.solve_cartesian.is_some() || args.exclude_process) {
        eprintln!(
            "note: --solve-cartesian and --exclude-process are for vendor programs: joint-space CSV has no Cartesian targets and \
             no processes"
        );
    }
    let changed = !outcome.unchanged;
    refusal(outcome)?;
    Ok(finished(args, changed))
}

/// Of a check: one line where both are alike; else the difference, and the line after it.
fn conclude_check(args: &Args, outcome: Outcome) -> Result<Finished> {
    let summary = text::summary_line(&outcome);
    match outcome.refusal {
        Some(why) => Err(no(format!("{why}\n  {summary}"))),
        None => {
            let golden = args.check.as_deref().map(shown).unwrap_or_default();
            eprintln!("{golden}: as rewritten now{}\n  {summary}", within(args));
            Ok(finished(args, !outcome.unchanged))
        }
    }
}

/// The tolerance of a check, in words.
fn within(args: &Args) -> String {
    args.tolerance.map_or_else(String::new, |t| format!(", within {t}"))
}

/// Whether the report is of what was done, or of what would be done.
fn verbosity(args: &Args, outcome: &Outcome) -> Verbosity {
    let writes = matches!(target(args), Target::File(_));
    match args.dry_run {
        true => Verbosity::Plan,
        false if !writes || outcome.refusal.is_some() => Verbosity::Check,
        false => Verbosity::Done,
    }
}

/// The report of a rewrite, with the verdict of the simulation if there is one.
#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    rewrite: Document,
    #[serde(skip_serializing_if = "Option::is_none")]
    path_error: Option<proof::PathError>,
}

/// `--list-frames`: a frames file to fill in.
fn list_frames<'a>(all: impl Iterator<Item = &'a Missing>) -> Result<()> {
    let mut missing = Missing::default();
    all.for_each(|m| missing.add(m));
    output::write_whole(Path::new("-"), missing.template().as_bytes())?;
    if missing.is_empty() {
        eprintln!("no move waits for a frame or a tool");
    }
    Ok(())
}

/// `--exit-code`: whether a program needed a change.
fn finished(args: &Args, changed: bool) -> Finished {
    if args.exit_code && !changed { Finished::NothingChanged } else { Finished::Done }
}

/// Says so where the last day of the compensator has passed: gaps grow with wear.
fn note_age(source: &Source) {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let past = |day: &&String| is_past(day, (seconds / 86_400) as i64);
    if let Some(day) = source.compensator.evidence.valid_until.as_ref().filter(past) {
        eprintln!("note: {}: valid until {day}; identify again", source.file);
    }
}

/// Says what may help where a joint would be too fast: a step that is spread.
fn suggest_ramp(args: &Args, source: &Source, outcome: &mut Outcome) {
    let fast = |kind: JointKind| {
        let joint = |axis: usize| source.robot.axis(axis).kind;
        outcome.stats.violations.iter().any(|v| v.what != LimitKind::Range && joint(v.axis) == kind)
    };
    let options =
        [(JointKind::Revolute, args.ramp_deg, "--ramp-deg 2"), (JointKind::Prismatic, args.ramp_mm, "--ramp-mm 5")];
    let helps: Vec<&str> = options.iter().filter(|(k, given, _)| given.is_none() && fast(*k)).map(|o| o.2).collect();
    if let Some(refusal) = outcome.refusal.as_mut().filter(|_| !helps.is_empty()) {
        *refusal += &format!(
            "\n  where it is the step at a reversal, {} may help: it is spread over that travel",
            helps.join(" and ")
        );
    }
}

/// The refusal of an outcome as the command's error.
fn refusal(outcome: Outcome) -> Result<()> {
    outcome.refusal.map_or(Ok(()), |r| Err(no(r)))
}

fn usage(found: &str, expected: &str) -> anyhow::Error {
    bad(Place::file("command line"), found, expected)
}

/// Refuses files that are named twice, and a program that would be replaced by its own result.
fn refuse_shared(args: &Args) -> Result<()> {
    let writes = args.output.as_deref().filter(|_| !args.dry_run && args.check.is_none());
    let in_place = writes.is_some_and(|o| paths::same(o, &args.input));
    if in_place && !args.force {
        let expected = "another file: the program as it is would be lost (--force replaces it)";
        return Err(bad(Place::file("--output"), "the program itself", expected));
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
    paths::refuse_shared(&inputs, &outputs)?;
    // files that belong to the program, read or written
    let of_output = |o: &Path| -> Vec<PathBuf> {
        let ours = formats::companions(&args.input, &Files::Disk);
        ours.iter().filter_map(|c| c.extension()).map(|e| o.with_extension(e)).collect()
    };
    let mut theirs = formats::companions(&args.input, &Files::Disk);
    theirs.extend(writes.map(of_output).unwrap_or_default());
    let words = [("--summary", args.summary.as_deref()), ("--report", args.report.as_deref())];
    for (option, path) in words.iter().filter_map(|(o, p)| p.map(|p| (*o, p))) {
        if let Some(file) = theirs.iter().find(|t| paths::same(t, path)) {
            return Err(bad(
                Place::file(option),
                format!("a file of the program, {}", shown(file)),
                "a file of its own",
            ));
        }
    }
    Ok(())
}

fn summarise(summary: &mut Option<Output>, lines: &[Line]) -> Result<()> {
    let Some(out) = summary else { return Ok(()) };
    let text: String = lines.iter().map(|l| l.json() + "\n").collect();
    out.put(text.as_bytes()).map_err(Into::into)
}

/// A document for standard output.
fn printed(document: &impl Serialize) -> Result<Output> {
    let text = serde_json::to_string_pretty(document).map_err(|e| Error::internal("write JSON", e))?;
    let mut out = Output::create(Path::new("-"))?;
    out.put((text + "\n").as_bytes())?;
    Ok(out)
}

/// A bar over the bytes of a large file, on a terminal.
fn bytes_bar(input: &Path) -> ProgressBar {
    const LARGE: u64 = 32 << 20;
    match std::fs::metadata(input) {
        Ok(m) if m.is_file() && m.len() > LARGE && shows_progress() => {
            ProgressBar::new(m.len()).with_style(style("{wide_bar} {bytes}/{total_bytes} {eta}"))
        }
        _ => ProgressBar::hidden(),
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
