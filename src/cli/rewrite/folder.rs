//! `rewrite` on a folder: every program by itself, a line of JSON for each.

use super::args::{LawArg, usage};
use super::job::Source;
use super::proof::{self, Proof};
use super::{Args, FailOn, printed, style, summarise};
use crate::cli::console::{say, shows_progress};
use crate::cli::exit::{Finished, InPlace, REPLACE, bad, code, no, words};
use crate::cli::{page, paths};
use crate::error::{Error, Place, counted, shown};
use crate::io::journal::{self, Towards};
use crate::io::name::text_of;
use crate::io::output::{self, Output};
use crate::program::files::Files;
use crate::program::formats::{self, Recognised};
use crate::rewrite::batch::{self, Judge, Judged, Results, Texts};
use crate::rewrite::earlier::leave_out;
use crate::rewrite::guard::{note_name, note_path};
use crate::rewrite::job::Job;
use crate::rewrite::manifest::{self, Entry, shard_of};
use crate::rewrite::refusal::REMEDY;
use crate::rewrite::summary::{BeforeAfter, Line, PathErrors, Status};
use crate::robot::frames::Missing;
use anyhow::Result;
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};

/// Runs the command on a folder of programs.
pub(super) fn run(args: &Args, source: &Source, mut job: Job) -> Result<Finished> {
    let results = results_of(args)?;
    let output = match results {
        Results::Folder(output) => Some(output),
        Results::Check(_) | Results::DryRun => None,
    };
    if let Some(output) = output.filter(|_| !args.force) {
        refuse_in_place(&args.input, output)?;
    }
    let part = args.shard.as_deref().map(shard).transpose()?;
    if let Some(folder) = output {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "make", e))?;
    }
    let _claim = output.map(|folder| batch::claim(folder, part)).transpose()?;
    let Planned { programs, files, unreadable, entries } = match &args.manifest {
        Some(file) => of_manifest(file, part)?,
        None => of_tree(args, results, part, job.format)?,
    };
    job.files = files;
    if let (Some(output), Some(_)) = (output, part) {
        batch::refuse_busy_below(output, &programs)?;
    }
    refuse_programs(args, output, &programs, &job.files)?;
    let outputs = Outputs::create(args)?;
    let bar = bar(programs.len());
    let judge = |original: &Path, points: u64, texts: &mut dyn FnMut() -> crate::error::Result<Texts>| {
        judged(args, proof::of_texts(args, source, &job, (original, points), texts)?, original)
    };
    let judge: Option<&Judge> = asks_verdict(args).then_some(&judge);
    let mut lines = match &entries {
        None => batch::run(&job, &args.input, &programs, results, judge, &|| bar.inc(1)),
        Some(entries) => run_entries(&job, &args.input, (entries, &programs), results, judge, &|| bar.inc(1)),
    };
    bar.finish_and_clear();
    lines.extend(unreadable);
    outputs.finish(args, &job, results, &programs, &lines)
}

/// A bar over the programs, on a terminal.
pub(super) fn bar(programs: usize) -> ProgressBar {
    match shows_progress() {
        true => ProgressBar::new(programs as u64).with_style(style("{wide_bar} {pos}/{len} programs")),
        false => ProgressBar::hidden(),
    }
}

/// What is written of a job on many programs besides them.
pub(super) struct Outputs {
    summary: Option<Output>,
    report: Option<Output>,
}

impl Outputs {
    /// Prepares them: what cannot be written is refused before the work.
    pub(super) fn create(args: &Args) -> Result<Self> {
        let [summary, report] = super::beside(args)?;
        Ok(Self { summary, report })
    }

    /// Writes them, and says what became of the programs: also where they cannot be written, as the results are in place.
    pub(super) fn finish(
        self,
        args: &Args,
        job: &Job,
        results: Results,
        programs: &[PathBuf],
        lines: &[Line],
    ) -> Result<Finished> {
        if args.list_frames {
            super::list_frames(lines.iter().filter_map(|l| l.missing.as_ref()))?;
            return Ok(Finished::Done);
        }
        let written = self.write(args, job, results, lines);
        let ended = match results {
            Results::Check(golden) => conclude_check(args, golden, programs, lines),
            _ => conclude(args, lines),
        };
        let in_place = lines.iter().filter(|l| l.status == Status::Written).count();
        match written {
            Err(e) if in_place > 0 && code(&e) != 0 => Err(InPlace { why: words(&e), programs: in_place }.into()),
            Err(e) => Err(e),
            Ok(()) => ended,
        }
    }

    fn write(mut self, args: &Args, job: &Job, results: Results, lines: &[Line]) -> Result<()> {
        summarise(&mut self.summary, lines)?;
        let document = Batch { schema: "lostmotion/rewrite-batch/1", programs: lines };
        let json = args.json.then(|| printed(&document)).transpose()?;
        page::write(&mut self.report, || {
            let what = match results {
                Results::Folder(_) => "rewritten",
                Results::Check(_) => "as checked in",
                Results::DryRun => "would be rewritten",
            };
            page::rewrite::of_folder(job.robot, job.compensator, &shown(&args.input), lines, what)
        })?;
        Ok(output::commit([self.summary, self.report, json])?)
    }
}

/// Whether every program of the folder gets a verdict.
pub(super) fn asks_verdict(args: &Args) -> bool {
    args.verdict || args.report.is_some()
}

/// The verdict of a program, as a line has it. A program that leaves its path, or whose error grows, is refused as a single one is.
pub(super) fn judged(args: &Args, proof: Proof, original: &Path) -> Option<Judged> {
    let minds = !args.force && matches!(args.law, LawArg::SymmetricHalfGap);
    Some(Judged {
        path_error: proof.of_line(),
        refused: proof.refused(&shown(original), args.goes_aside()).filter(|_| minds),
    })
}

/// What `--json` prints of a folder.
#[derive(serde::Serialize)]
struct Batch<'a> {
    schema: &'static str,
    programs: &'a [Line],
}

/// Where the results go, or what they are compared with.
pub(super) fn results_of(args: &Args) -> Result<Results<'_>> {
    if args.output.is_some() {
        return Err(usage("a folder as IN with --output", "--output-dir"));
    }
    match (&args.check, &args.output_dir) {
        _ if args.dry_run || args.list_frames => Ok(Results::DryRun),
        (Some(golden), _) if !golden.is_dir() => {
            let found = if golden.exists() { "a file" } else { "no such folder" };
            Err(usage(
                &format!("a folder as IN with --check {}: {found}", shown(golden)),
                "the folder of the rewritten programs",
            ))
        }
        (Some(golden), _) => Ok(Results::Check(golden)),
        (None, Some(folder)) => Ok(Results::Folder(folder)),
        (None, None) => Err(usage("a folder as IN without --output-dir or --check", "one of them")),
    }
}

/// Prints what refused and failed programs came to.
fn print_reasons(lines: &[Line]) {
    for l in lines.iter().filter(|l| matches!(l.status, Status::Refused | Status::Failed)) {
        let reason = l.reason.as_deref().unwrap_or("");
        let option = if reason.ends_with(REMEDY) { format!(" ({REPLACE})") } else { String::new() };
        // most reasons begin with the place, which is in this program
        match reason.strip_prefix(l.input.as_str()).is_some_and(|rest| rest.starts_with(':')) {
            true => say(format_args!("{reason}{option}"), true),
            false => say(format_args!("{}: {reason}{option}", l.input), true),
        }
    }
}

/// Names what programs call and no file contains, once for all of them, where moves wait for it.
fn print_unknown_calls(lines: &[Line]) {
    let mut missing = Missing::default();
    lines.iter().filter_map(|l| l.missing.as_ref()).for_each(|m| missing.add(m));
    for (name, moves) in &missing.calls {
        eprintln!("{}", super::text::unknown_call(name, *moves));
    }
}

/// Names the programs of whose rewritten path the verdict is `worse`.
fn print_worse(lines: &[Line]) {
    let um = |p: Option<BeforeAfter>| p.map_or(String::new(), |p| format!("{:.1} -> {:.1} um", p.before, p.after));
    for (line, p) in lines.iter().filter_map(|l| l.path_error.as_ref().filter(|p| p.worse).map(|p| (l, p))) {
        let (rms, largest) = (um(p.rms_um), um(p.largest_um));
        eprintln!("{}: worse: rms {rms}, largest {largest} (`assess program` shows where)", line.input);
    }
    let known: Vec<&PathErrors> = lines.iter().filter_map(|l| l.path_error.as_ref()).collect();
    if known.is_empty() {
        return;
    }
    let count = |what: &str| known.iter().filter(|p| p.verdict == Some(what)).count();
    let unknown = known.iter().filter(|p| p.verdict.is_none()).count();
    let [better, same, worse] = ["better", "unchanged", "worse"].map(count);
    eprintln!("verdicts: {better} better, {same} unchanged, {worse} worse, {unknown} not computed");
}

/// Of a check: an error where a program differs from its golden file.
fn conclude_check(args: &Args, golden: &Path, programs: &[PathBuf], lines: &[Line]) -> Result<Finished> {
    print_reasons(lines);
    if args.shard.is_none() && args.manifest.is_none() {
        note_unmatched(args, golden, programs);
    }
    let differ = lines.iter().filter(|l| matches!(l.status, Status::Refused | Status::Failed)).count();
    if differ > 0 && args.fail_on != FailOn::None {
        let are = if differ == 1 { "is" } else { "are" };
        return Err(no(format!("{differ} of {} {are} not as in {}", counted(lines.len(), "program"), shown(golden))));
    }
    let same = lines.len() - differ;
    eprintln!("{same} of {} as in {}{}", counted(lines.len(), "program"), shown(golden), super::within(args));
    Ok(super::finished(args, lines.iter().any(|l| l.status == Status::WouldBeWritten)))
}

/// Names programs of the golden folder that come from no program of the input.
fn note_unmatched(args: &Args, golden: &Path, programs: &[PathBuf]) {
    let Ok(tree) = batch::tree(golden, Path::new(""), None) else { return };
    for program in tree.programs.iter().filter(|p| !programs.contains(p)) {
        let (here, from) = (shown(&golden.join(program)), shown(&args.input));
        eprintln!("note: {here}: no program of {from} has this name");
    }
}

/// Prints what became of the programs; an error where some are refused or failed.
fn conclude(args: &Args, lines: &[Line]) -> Result<Finished> {
    let count = |s: Status| lines.iter().filter(|l| l.status == s).count();
    let (refused, failed) = (count(Status::Refused), count(Status::Failed));
    print_reasons(lines);
    let (written, would) = match args.dry_run {
        true => (count(Status::WouldBeWritten), " would be"),
        false => (count(Status::Written), ""),
    };
    eprintln!(
        "{}: {written}{would} written, {} unchanged, {refused} refused, {failed} failed",
        counted(lines.len(), "program"),
        count(Status::Unchanged)
    );
    print_unknown_calls(lines);
    print_worse(lines);
    let bad = match args.fail_on {
        FailOn::Refused => refused + failed,
        FailOn::Failed => failed,
        FailOn::None => 0,
    };
    if bad > 0 {
        let could = match (args.dry_run, bad) {
            (true, _) => "could not be",
            (false, 1) => "was not",
            (false, _) => "were not",
        };
        return Err(no(format!("{bad} of {} {could} rewritten", counted(lines.len(), "program"))));
    }
    Ok(super::finished(args, written > 0))
}

/// What is to be done.
pub(super) struct Planned {
    pub(super) programs: Vec<PathBuf>,
    files: Files,
    /// Lines of what cannot be read.
    unreadable: Vec<Line>,
    /// Those of the manifest, one for each program.
    pub(super) entries: Option<Vec<Entry>>,
}

/// Every program of the folder.
fn of_tree(args: &Args, results: Results, part: Option<(usize, usize)>, format: Option<Recognised>) -> Result<Planned> {
    let but = match results {
        Results::DryRun => Path::new(""),
        Results::Folder(folder) | Results::Check(folder) => folder,
    };
    let mut tree = batch::tree(&args.input, but, format)?;
    if matches!(results, Results::Folder(_)) {
        tree.interrupted.iter().try_for_each(|folder| journal::finish(folder, Towards::Before))?;
    }
    let unreadable: Vec<Line> = batch::unreadable_lines(&tree).collect();
    let (mut programs, files) = (std::mem::take(&mut tree.programs), tree.files);
    leave_out(&args.input, &mut programs, &files);
    if let Some((k, n)) = part {
        programs.retain(|p| shard_of(&text_of(p), n) == k);
    }
    Ok(Planned { programs, files, unreadable, entries: None })
}

/// The programs of a manifest, or those of them that belong to a shard; the others are not kept in memory.
pub(super) fn of_manifest(file: &Path, part: Option<(usize, usize)>) -> Result<Planned> {
    let entries = manifest::load(file, &|e| part.is_none_or(|(k, n)| shard_of(&e.key, n) == k))?;
    let programs = entries.iter().filter_map(|e| manifest::below(&e.key)).collect();
    Ok(Planned { programs, files: Files::Disk, unreadable: Vec::new(), entries: Some(entries) })
}

/// Rewrites the programs of a manifest that still are what it says; the others fail. Lines carry the keys.
pub(super) fn run_entries(
    job: &Job,
    folder: &Path,
    (entries, programs): (&[Entry], &[PathBuf]),
    results: Results,
    judge: Option<&Judge>,
    done: &(dyn Fn() + Sync),
) -> Vec<Line> {
    let mut changed = manifest::changed(folder, entries);
    let same = entries.iter().zip(programs).filter(|(e, _)| !changed.contains_key(&e.key));
    let same: Vec<PathBuf> = same.map(|(_, p)| p.clone()).collect();
    let mut lines = batch::run(job, folder, &same, results, judge, done).into_iter();
    let line = |e: &Entry| {
        let line = changed.remove(&e.key).or_else(|| lines.next())?;
        let rewritten_by = matches!(line.status, Status::Written | Status::Unchanged).then(|| job.rewritten_by());
        Some(Line { key: Some(e.key.clone()), rewritten_by, ..line })
    };
    entries.iter().filter_map(line).collect()
}

/// Refuses a summary and a page that would go over a program, or over a result.
fn refuse_programs(args: &Args, output: Option<&Path>, programs: &[PathBuf], files: &Files) -> Result<()> {
    let beside = output.or(args.check.as_deref());
    for (option, file) in [("--summary", &args.summary), ("--report", &args.report)] {
        if let Some(file) = file {
            refuse_program(option, file, &args.input, beside, programs, files)?;
        }
    }
    Ok(())
}

/// Refuses a file that would go over a program, or over a result.
fn refuse_program(
    option: &str,
    summary: &Path,
    input: &Path,
    output: Option<&Path>,
    programs: &[PathBuf],
    files: &Files,
) -> Result<()> {
    // one file has one name, but for links
    let linked = |p: &Path| std::fs::symlink_metadata(p).is_ok_and(|m| m.is_symlink());
    let summary_linked = linked(summary);
    let same =
        |p: &Path| (summary_linked || p.file_name() == summary.file_name() || linked(p)) && paths::same(summary, p);
    for program in programs {
        let from = input.join(program);
        let mut ours = formats::companions(&from, files);
        if let Some(to) = output.map(|o| o.join(program)) {
            let beside: Vec<_> = ours.iter().filter_map(|c| c.extension()).map(|e| to.with_extension(e)).collect();
            ours.extend(beside);
            ours.push(to);
        }
        if let Some(note) = notes_of(&from, output.map(|o| o.join(program))).iter().find(|p| same(p)) {
            let found = format!("the same file as the note of a program, {}", shown(note));
            return Err(bad(Place::file(option), found, "a separate file"));
        }
        ours.push(from);
        if let Some(other) = ours.iter().find(|p| same(p)) {
            let found = format!("the same file as the program {}", shown(other));
            return Err(bad(Place::file(option), found, "a separate file"));
        }
    }
    Ok(())
}

/// Where the notes of a program and of its result are, or will be.
fn notes_of(from: &Path, to: Option<PathBuf>) -> Vec<PathBuf> {
    let files = [Some(from), to.as_deref()];
    files.into_iter().flatten().flat_map(|f| [note_path(f), note_name(f)]).collect()
}

/// `K/N`.
pub(super) fn shard(text: &str) -> Result<(usize, usize)> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
    match parts {
        Some((k, n)) if (1..=n).contains(&k) => Ok((k, n)),
        _ => Err(usage(&format!("--shard {text}"), "K/N with K from 1 to N, such as 3/8")),
    }
}

/// Refuses an output folder that is the input folder, or holds it: results would stand where programs are. An output
/// folder inside the input folder replaces nothing; it is left out of the programs.
fn refuse_in_place(input: &Path, output: &Path) -> Result<()> {
    let (Ok(from), Ok(to)) = (std::fs::canonicalize(input), std::fs::canonicalize(output)) else { return Ok(()) };
    if !from.starts_with(&to) {
        return Ok(());
    }
    let found = if from == to { "the folder of the programs" } else { "a folder that contains the programs" };
    let expected = "another folder: the original programs could be lost (--force replaces them)";
    Err(bad(Place::file("--output-dir"), found, expected))
}
