//! `lostmotion rewrite`: program and compensator in, program with reversal points and offsets out.

mod folder;
mod job;
mod proof;
mod text;

use crate::cli::exit::Finished;
use crate::cli::exit::{bad, no};
use crate::cli::{page, paths};
use crate::compensator::file::is_past;
use crate::error::{Error, Place, is_stdio, shown};
use crate::io::console::shows_progress;
use crate::io::journal::{self, Towards};
use crate::io::output::{self, Output};
use crate::program::files::Files;
use crate::program::formats;
use crate::rewrite::equation2::Law;
use crate::rewrite::guard::note_path;
use crate::rewrite::job::Job;
use crate::rewrite::outcome::{Outcome, Target};
use crate::rewrite::summary::{Line, document};
use crate::rewrite::{LimitKind, Refine};
use crate::robot::JointKind;
use crate::robot::frames::Missing;
use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use job::Source;
use proof::Proof;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use text::{Verbosity, format_text};

/// Put reversal points and offsets into a robot program.
///
/// After every reversal of a joint the command jumps by its gap, so that the joint itself does not stand still; a friction
/// offset is added and fades. Only the numbers of motion targets change and points are added; every other byte of the
/// program stays as it is. Nothing is written where a joint limit would be exceeded. Programs are joint-space CSV, Yaskawa
/// INFORM, ABB RAPID, KUKA KRL, FANUC TP, URScript, ROS trajectories, or G-code.
///
/// Examples:
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run
///   lostmotion rewrite --model machine.yaml program.csv --output out.csv --speed-mm-s 10
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml cell/ --output-dir done/ --summary summary.jsonl
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Program (joint-space CSV: a1_deg,a2_deg,... and perhaps t_s; or a vendor's), `-` for standard input, or a folder of programs
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    /// Robot file; its fingerprint must be that of the compensator's robot
    #[arg(long, value_name = "FILE", required_unless_present = "model", requires = "compensator")]
    pub robot: Option<PathBuf>,

    /// Compensator file, as `fit` writes it
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub compensator: Option<PathBuf>,

    /// Model file: compensate every effect in it that an offset can, instead of --robot and --compensator
    #[arg(long, value_name = "FILE", conflicts_with_all = ["robot", "compensator"])]
    pub model: Option<PathBuf>,

    /// Where the rewritten program goes; `-` for standard output. A note FILE.lostmotion.json is left beside it
    #[arg(long, short, value_name = "FILE", required_unless_present_any = ["dry_run", "check", "output_dir", "list_frames"])]
    pub output: Option<PathBuf>,

    /// Format of the program instead of the one that its ending and content show (csv, inform, rapid, krl, fanuc, urscript,
    /// trajectory, gcode)
    #[arg(long, value_name = "NAME")]
    pub format: Option<String>,

    /// How the control reads G-code before a program says so: G90 or G91, G20 or G21, such as G21,G90 [default: `control` of the
    /// robot file]
    #[arg(long, value_name = "WORD,...")]
    pub assume: Option<String>,

    /// Where the rewritten programs of a folder go, under their own names. Programs that stand there finished are not done again
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "check"])]
    pub output_dir: Option<PathBuf>,

    /// Write a line of JSON for each program to this file (status, reason, moves, reversals, hashes)
    #[arg(long, value_name = "FILE")]
    pub summary: Option<PathBuf>,

    /// Of a folder, do part K of N alone: for job arrays
    #[arg(long, value_name = "K/N", requires = "output_dir")]
    pub shard: Option<String>,

    /// Of a folder, do the programs of this manifest alone (`lostmotion manifest`), if they still are what it says; lines of the
    /// summary carry their keys
    #[arg(long, value_name = "FILE.jsonl", requires = "output_dir")]
    pub manifest: Option<PathBuf>,

    /// Of a folder, which programs make the exit code 1: those that were refused and those that failed, failed ones alone, or none (the
    /// summary tells in any case)
    #[arg(long, value_enum, default_value_t = FailOn::Refused)]
    pub fail_on: FailOn,

    /// Exit code 3 where no program needed a change
    #[arg(long)]
    pub exit_code: bool,

    /// Share of the moves that must have joint targets that can be edited, such as 100%; else exit code 1 and nothing is written
    #[arg(long, value_name = "PERCENT")]
    pub require_coverage: Option<String>,

    /// Write straight Cartesian moves between joint moves as joint moves that stay within this distance of the line, um
    /// [without a value: 20]
    #[arg(long, value_name = "UM", num_args = 0..=1, require_equals = true, default_missing_value = "20")]
    pub solve_cartesian: Option<f64>,

    /// Frames and tools by the controller's names (lostmotion/frames/1), besides those of the robot file: Cartesian targets in others
    /// stay as they are
    #[arg(long, value_name = "FILE")]
    pub frames: Option<PathBuf>,

    /// Write nothing but a file for --frames on standard output, to fill in: every frame and tool that is not known, with the
    /// number of moves that wait for it
    #[arg(long, conflicts_with_all = ["output", "check", "json"])]
    pub list_frames: bool,

    /// Leave Cartesian targets as they are
    #[arg(long)]
    pub leave_cartesian: bool,

    /// Most points that are added to a program; where there would be more, steps are spread over whole moves
    #[arg(long, value_name = "N")]
    pub max_added: Option<u64>,

    /// Add no points while a process (welding, dispensing) is on; its targets are edited
    #[arg(long)]
    pub leave_process: bool,

    /// Reach every target at which the robot stops from one side: + or - for all joints, or signs of single ones, such as A1=+,A2=-.
    /// A point is added before a target that a joint would reach from the other side, no further away than its gap needs
    /// (vendor programs)
    #[arg(long, value_name = "+|-|JOINT=SIGN,...", allow_hyphen_values = true)]
    pub approach_from: Option<String>,

    /// Leave moves as they are while a process (welding, dispensing) is on
    #[arg(long)]
    pub exclude_process: bool,

    /// Joints that are not compensated, such as A4,A6
    #[arg(long, value_name = "JOINT,...")]
    pub leave_out: Option<String>,

    /// Compensate joints whose gap is not significant, too (its 95 % interval holds zero)
    #[arg(long)]
    pub insignificant: bool,

    /// Of joint-space CSV, how turning points between program points are found: not at all, on a cubic through the joints, on arcs
    /// of the TCP path (vendor programs: their targets are the turning points)
    #[arg(long, value_enum)]
    pub refine: Option<RefineArg>,

    /// Law of the offsets: equation 16 of Zhang (2023) (half a gap either way), or equation 2 of Cursi (2022), to compare with: the whole
    /// deadzone at the sample of a reversal, as printed, or held from there on (no points added, no friction)
    #[arg(long, value_enum, default_value_t = LawArg::Equation16, conflicts_with_all = ["step_fraction", "ramp_deg", "ramp_mm"])]
    pub law: LawArg,

    /// Share of the segment after a reversal at which the point stands that carries the step; 1: the next point carries it
    /// [default: 0.1, nearer where the joint would lag until then]
    #[arg(long, value_name = "0..1", allow_negative_numbers = true)]
    pub step_fraction: Option<f64>,

    /// Spread the step of a revolute joint over this travel after the reversal, degrees
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub ramp_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub ramp_mm: Option<f64>,

    /// Directions in which joints were moved before the first point, such as A1=+,A2=-; else that of their first movement
    #[arg(long, value_name = "JOINT=SIGN,...", allow_hyphen_values = true)]
    pub initial_direction: Option<String>,

    /// Share of every offset that is applied, 0 to 1 (over-compensation does more harm than a rest)
    #[arg(long, value_name = "0..1", default_value_t = 1.0, allow_negative_numbers = true)]
    pub gain: f64,

    /// TCP speed of a program without t_s, or of moves with joint speeds, mm/s: turns a decay in seconds into points [default: that
    /// of the compensator's log]
    #[arg(long, value_name = "MM_S", allow_negative_numbers = true)]
    pub speed_mm_s: Option<f64>,

    /// With --refine cartesian: largest distance between the path and its chords, um [default: 2]
    #[arg(long, value_name = "UM")]
    pub chord_um: Option<f64>,

    /// Movement of a revolute joint that is number noise and no reversal, degrees [default: 1.5 last digits of its column]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub deadband_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub deadband_mm: Option<f64>,

    /// Write changed numbers with this many decimals [default: as they are, more where the gap needs them]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=12))]
    pub decimals: Option<u8>,

    /// Say what would be done and write nothing
    #[arg(long, conflicts_with = "check")]
    pub dry_run: bool,

    /// Compare with this file instead of writing; exit code 1 and the first difference where they differ
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

/// `--law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LawArg {
    /// Half a gap in the direction of the movement
    #[value(name = "equation-16")]
    Equation16,
    /// The whole deadzone at the sample where the direction changes
    #[value(name = "equation-2")]
    Equation2,
    /// The whole deadzone from there on
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

/// Which programs of a folder make the exit code 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FailOn {
    /// Those that were refused and those that failed.
    Refused,
    /// Those that failed alone.
    Failed,
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
    if args.report.is_some() && folder {
        return Err(usage("--report with a folder as IN", "a single program; a folder has --summary"));
    }
    if args.json && args.output.as_deref() == Some(Path::new("-")) {
        return Err(usage("--json with --output -", "one of them: both go to standard output"));
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
    let proof = proof::of(args, source, &mut ready);
    page::write(&mut report, || {
        let verdict = proof.as_ref().and_then(Proof::verdict);
        page::rewrite::of_outcome(&source.robot, &source.compensator, &ready.outcome, verdict)
    })?;
    let json =
        args.json.then(|| printed(&account_with_proof(&ready.outcome, &source.robot, proof.as_ref()))).transpose()?;
    let outcome = ready.commit_with([summary, report, json].into_iter().flatten().collect())?;
    if !args.json {
        eprint!("{}", format_text(&outcome, &source.robot, verbosity(args, &outcome)));
        if let Some(proof) = &proof {
            eprint!("{}", proof.words(args.model.is_some()));
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

/// What the account is about: what was done, or what would be.
fn verbosity(args: &Args, outcome: &Outcome) -> Verbosity {
    let writes = matches!(target(args), Target::File(_));
    match args.dry_run {
        true => Verbosity::Plan,
        false if !writes || outcome.refusal.is_some() => Verbosity::Check,
        false => Verbosity::Done,
    }
}

/// The account of a rewrite with the verdict on what the program does on the machine, where there is one.
fn account_with_proof(outcome: &Outcome, robot: &crate::robot::Robot, proof: Option<&Proof>) -> serde_json::Value {
    let mut account = document(outcome, robot);
    if let Some(proof) = proof {
        account["path_error"] = proof.document();
    }
    account
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
        outcome.account.violations.iter().any(|v| v.what != LimitKind::Range && joint(v.axis) == kind)
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
fn printed(document: &serde_json::Value) -> Result<Output> {
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
