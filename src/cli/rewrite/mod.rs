//! `lostmotion rewrite`: program and compensator in, program with reversal points and offsets out.
//!
//! Files, in the order of the work: `args` (arguments and help), `job` (what is read and checked), this one (one program), `folder` (many),
//! `remote` (many in an object store), `proof` (the page before and after), `text` (the summary in words).

mod args;
mod folder;
mod job;
mod proof;
#[cfg(feature = "cloud")]
mod remote;
mod text;

use crate::cli::console::shows_progress;
use crate::cli::exit::Finished;
use crate::cli::exit::{bad, no};
use crate::cli::{page, paths};
use crate::compensator::file::is_past;
use crate::error::{Error, Place, is_stdio, shown};
use crate::io::address;
use crate::io::journal::{self, Towards};
use crate::io::kind::Kind;
use crate::io::links;
use crate::io::output::{self, Output};
use crate::program::files::Files;
use crate::program::formats;
use crate::rewrite::LimitKind;
use crate::rewrite::guard::note_path;
use crate::rewrite::job::Job;
use crate::rewrite::outcome::{Outcome, Target};
use crate::rewrite::summary::{Document, Line, document};
use crate::robot::JointKind;
use crate::robot::frames::Missing;
use anyhow::Result;
use args::usage;
pub use args::{Args, FailOn};
use indicatif::{ProgressBar, ProgressStyle};
use job::Source;
use proof::Proof;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use text::{Verbosity, format_text};

/// Runs the command.
pub fn run(args: Args) -> Result<Finished> {
    let remote = is_remote(&args)?;
    let folder = args.input != Path::new("-") && args.input.is_dir();
    refuse_ignored(&args, remote || folder)?;
    refuse_shared(&args)?;
    paths::refuse_missing_folders(&[
        ("--output", args.output.as_deref().filter(|_| !args.dry_run && args.check.is_none())),
        ("--summary", args.summary.as_deref().filter(|s| !is_in_new_folder(&args, s))),
        ("--report", args.report.as_deref().filter(|r| !is_in_new_folder(&args, r))),
    ])?;
    refuse_missing_golden(&args)?;
    let source = Source::load(&args)?;
    let job = job::of(&args, &source)?;
    job.check_robot(&source.file)?;
    job.check_sizes(&source.file)?;
    note_age(&source);
    for line in &source.left {
        eprintln!("note: not compensated: {line}");
    }
    if let Some(output) = args.output_dir.as_ref().filter(|_| args.dry_run && !args.json) {
        eprintln!("note: {}: not written (--dry-run)", shown(output));
    }
    if remote {
        #[cfg(feature = "cloud")]
        return remote::run(&args, &source, job);
    }
    if folder {
        return folder::run(&args, &source, job);
    }
    if args.manifest.is_some() {
        return Err(usage("--manifest with a single program", "the folder of its programs as IN"));
    }
    if args.output_dir.is_some() {
        return Err(usage("--output-dir with a single program", "a folder as IN, or --output"));
    }
    single(&args, &source, &job)
}

/// Whether a file goes into the output folder, which the run makes.
fn is_in_new_folder(args: &Args, file: &Path) -> bool {
    let made = args.output_dir.as_deref().filter(|_| args.input.is_dir() && !args.dry_run && !args.list_frames);
    let named = !file.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    made.is_some_and(|folder| named && file.parent() == Some(folder))
}

/// Whether programs or results are in an object store; refuses an address where a path on disk is needed.
fn is_remote(args: &Args) -> Result<bool> {
    for (option, path) in [
        ("--output", &args.output),
        ("--check", &args.check),
        ("--summary", &args.summary),
        ("--report", &args.report),
        ("--manifest", &args.manifest),
    ] {
        address::refuse(option, path.as_deref())?;
    }
    let stores = [Some(&args.input), args.output_dir.as_ref()].into_iter().flatten();
    let stores: Vec<&PathBuf> = stores.filter(|p| address::is_address(p)).collect();
    #[cfg(not(feature = "cloud"))]
    stores.iter().try_for_each(|p| address::refuse_all(p))?;
    Ok(!stores.is_empty())
}

/// Refuses options that have no effect beside the others, or on a single program.
fn refuse_ignored(args: &Args, many: bool) -> Result<()> {
    let one = !many;
    for (ignored, found, expected) in [
        (args.list_frames && args.summary.is_some(), "--summary with --list-frames", "one of them"),
        (args.list_frames && args.report.is_some(), "--report with --list-frames", "one of them"),
        (args.list_frames && args.verdict, "--verdict with --list-frames", "one of them"),
        (args.verdict && args.check.is_some(), "--verdict with --check", "--verdict with --output-dir"),
        (args.verdict && args.dry_run, "--verdict with --dry-run", "--verdict with a run that writes"),
        (
            one && args.verdict,
            "--verdict with a single program",
            "no --verdict: a single program always gets its verdict",
        ),
        (one && args.shard.is_some(), "--shard with a single program", "a folder as IN"),
        (one && args.fail_on != FailOn::Refused, "--fail-on with a single program", "a folder as IN"),
    ] {
        if ignored {
            return Err(usage(found, expected));
        }
    }
    Ok(())
}

/// Refuses a golden file or folder that is not there.
fn refuse_missing_golden(args: &Args) -> Result<()> {
    let missing = args.check.as_deref().filter(|g| !is_stdio(g) && !g.exists());
    missing.map_or(Ok(()), |golden| {
        let found = format!("{}, which does not exist", shown(golden));
        let of_folder = args.input.is_dir();
        let what = if of_folder { "the folder of the rewritten programs" } else { "the rewritten program" };
        let make = if of_folder { "--output-dir" } else { "--output" };
        Err(bad(Place::file("--check"), found, format!("{what} to compare with; {make} writes it")))
    })
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
        folders.iter().flatten().try_for_each(|f| journal::finish(&links::home_of(f), Towards::Before))?;
    }
    if args.list_frames {
        let ready = job.prepare(&args.input, Target::DryRun, &|_| {})?;
        list_frames(ready.outcome.vendor.iter().map(|v| &v.missing))?;
        return Ok(Finished::Done);
    }
    let [mut summary, mut report] = beside(args)?;
    let bar = bytes_bar(&args.input);
    let result = job.prepare(&args.input, target, &|bytes| bar.set_position(bytes));
    bar.finish_and_clear();
    let mut ready = match result {
        Ok(ready) => ready,
        Err(e) => {
            summarise(&mut summary, &[Line::failed(shown(&args.input), &e, None)])?;
            output::commit([summary])?;
            return Err(crate::cli::columns::with_program_hint(e).into());
        }
    };
    suggest_ramp(args, source, &mut ready.outcome);
    let proof = match args.dry_run {
        true => proof::of_plan(args, source, job, &ready.outcome),
        false => proof::of(args, source, job, &mut ready),
    };
    if let Some(why) =
        proof.as_ref().filter(|_| minds_path(args)).and_then(|p| p.refused(&shown(&args.input), args.goes_aside()))
    {
        ready.refuse(why);
    }
    summarise(&mut summary, &[Line::of(&ready.outcome)])?;
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
    tell(args, source, &outcome, proof.as_ref());
    let changed = !outcome.unchanged;
    refusal(outcome)?;
    Ok(finished(args, changed))
}

/// Says on standard error what was done.
fn tell(args: &Args, source: &Source, outcome: &Outcome, proof: Option<&Proof>) {
    if !args.json {
        eprint!("{}", format_text(outcome, &source.robot, verbosity(args, outcome)));
        if let Some(proof) = proof {
            eprint!(
                "{}",
                proof.words(args.model.is_some(), outcome.vendor.is_some(), outcome.stats.duration_s.is_some())
            );
        }
    }
    if outcome.vendor.is_none() && (args.solve_cartesian.is_some() || args.exclude_process) {
        eprintln!(
            "note: --solve-cartesian and --exclude-process are for vendor programs: joint-space CSV has no Cartesian targets and \
             no processes"
        );
    }
}

/// Whether a program that leaves its path is refused: not where that is asked for, nor under a law that jumps. A program in place needs
/// `--force` in any case, so there it asks for nothing.
fn minds_path(args: &Args) -> bool {
    let in_place = args.output.as_deref().is_some_and(|o| paths::same(o, &args.input));
    (!args.force || in_place) && matches!(args.law, args::LawArg::SymmetricHalfGap)
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
    if (Missing { calls: Default::default(), ..missing }).is_empty() {
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
            "\n  if the step at a reversal exceeds it, {} may help: it spreads the step over a travel",
            helps.join(" and ")
        );
    }
}

/// The refusal of an outcome as the command's error.
fn refusal(outcome: Outcome) -> Result<()> {
    outcome.refusal.map_or(Ok(()), |r| Err(no(r)))
}

/// Refuses files that are named twice, and a program that would be replaced by its own result.
fn refuse_shared(args: &Args) -> Result<()> {
    let writes = args.output.as_deref().filter(|_| !args.dry_run && args.check.is_none());
    let in_place = writes.is_some_and(|o| paths::same(o, &args.input));
    if in_place && !args.force {
        let expected = "another file: the original program would be lost (--force replaces it)";
        return Err(bad(Place::file("--output"), "the program itself", expected));
    }
    let note = writes.filter(|o| !is_stdio(o)).map(note_path);
    let inputs = [
        ("--robot", args.robot.as_deref()),
        ("--compensator", args.compensator.as_deref()),
        ("--model", args.model.as_deref()),
        ("--check", args.check.as_deref()),
        ("--manifest", args.manifest.as_deref()),
        ("IN", Some(args.input.as_path()).filter(|_| !in_place)),
    ];
    let frames = args.frames.iter().map(|path| ("--frames", Some(path.as_path())));
    let inputs: Vec<_> = inputs.into_iter().chain(frames).collect();
    let outputs = [
        ("--json", Some(Path::new("-")).filter(|_| args.json)),
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
            return Err(bad(Place::file(option), format!("a file of the program, {}", shown(file)), "a separate file"));
        }
    }
    Ok(())
}

/// Summary and page, which do not replace a file of another kind: known before the work is done.
fn beside(args: &Args) -> Result<[Option<Output>; 2]> {
    let both = [output::create(args.summary.as_deref())?, output::create(args.report.as_deref())?];
    for (output, kind) in both.iter().zip([Kind::Summary, Kind::Page]) {
        output.as_ref().map_or(Ok(()), |o| o.expect(&kind))?;
    }
    Ok(both)
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
