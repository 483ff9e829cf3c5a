//! One vendor program from file to file, with the files that belong to it.

use super::change;
use super::context::{Contexts, LARGEST_SCRIPT, sum_of};
use super::{Done, Task, rewrite};
use crate::error::{Error, Place, Result, is_stdio, shown};
use crate::io::name::text_of_name;
use crate::io::{input, memory};
use crate::program::files::Files;
use crate::program::script::{Format, Text};
use crate::rewrite::Refine;
use crate::rewrite::foreign::{self, PendingFile};
use crate::rewrite::guard::{self, Companion, Note};
use crate::rewrite::job::Job;
use crate::rewrite::original;
use crate::rewrite::outcome::{Outcome, Ready, Target, Vendor};
use crate::rewrite::sink::{File, Sink};
use crate::robot::Axes;
use std::path::{Path, PathBuf};

/// Changes that are kept where not all are asked for.
const LISTED: usize = 1000;

/// A program and the files that are rewritten with it, and the hashes of all.
#[derive(Clone, Copy)]
struct Source<'a> {
    input: &'a Path,
    companions: &'a [PathBuf],
    hashes: &'a [String],
}

impl Job<'_> {
    /// The note of a written program: what it was, with its companions.
    fn note_of(
        &self,
        source: Source,
        path: &Path,
        paths: &[PathBuf],
        originals: &[Text],
        sums: &[String],
        outcome: &Outcome,
    ) -> Note {
        let named = |p: &Path| p.file_name().map_or_else(|| shown(p), text_of_name);
        let mut note = self.note(source.input, path, outcome);
        note.context = sum_of(originals.first().is_some_and(|own| own.called), originals.iter().filter(|t| t.context));
        let original = |t: &Text| if outcome.unchanged { None } else { original::pack(&t.bytes) };
        note.original = originals.first().and_then(original);
        note.companions = (1..paths.len())
            .map(|k| Companion {
                input: named(&source.companions[k - 1]),
                output: named(&paths[k]),
                sha256_in: source.hashes[k].clone(),
                sha256_out: sums[k].clone(),
                original: original(&originals[k]),
            })
            .collect();
        note
    }

    /// Writes the texts beside where they will be, with the note.
    fn prepare_files(&self, source: Source, path: &Path, done: &Done, mut outcome: Outcome) -> Result<Ready> {
        let Source { input, companions, .. } = source;
        let paths = outputs(path, companions)?;
        refuse_shared(input, companions, &paths, self.force)?;
        outcome.output = Some(shown(path));
        let mut files = Vec::with_capacity(paths.len());
        let mut sums = Vec::with_capacity(paths.len());
        for (path, text) in paths.iter().zip(&done.texts) {
            let mut file = File::create(path, self.durability)?;
            file.take(&text.bytes)?;
            file.prepare()?;
            sums.push(file.sha256());
            files.push(file);
        }
        let placed = |k: usize, path| PendingFile {
            path,
            sha256_in: source.hashes.get(k).map(String::as_str),
            sha256_out: &sums[k],
        };
        let placed: Vec<PendingFile> =
            paths.iter().enumerate().take(sums.len()).map(|(k, path)| placed(k, path)).collect();
        foreign::refuse(self, &mut files, &placed)?;
        outcome.sha256_out = sums.first().cloned();
        let note = self.note_beside(input, path, &outcome, &sums, || {
            Ok(self.note_of(source, path, &paths, &done.originals, &sums, &outcome))
        })?;
        Ok(Ready { outcome, files, note: note.new, stale_note: note.stale })
    }

    /// Takes a vendor program through; `bytes` are those of `input`.
    pub(in super::super) fn prepare_script(
        &self,
        format: &dyn Format,
        input: &Path,
        bytes: Vec<u8>,
        target: Target,
    ) -> Result<Ready> {
        let name = shown(input);
        if self.options.refine != Refine::None {
            return Err(Error::setting(
                "refine",
                format!("{name}, a program in {}", format.title()),
                "joint-space CSV (in this program the robot moves from target to target, so the targets are the turning points; those on straight lines and arcs are found without a finer path)",
            ));
        }
        let (texts, companions) = texts(format, input, bytes, &self.files, &self.contexts, self.robot.axes())?;
        let hashes: Vec<String> = texts.iter().filter(|t| !t.context).map(|t| input::sha256(&t.bytes)).collect();
        self.refuse_known(input, &self.known(input, &target)?, &Some(guard::together(hashes.iter())))?;
        let digit = self.last_digits()?;
        let task = Task {
            robot: self.robot,
            compensator: self.compensator,
            options: &self.options,
            choices: &self.choices,
            deadband: &self.deadband,
            digit: &digit,
            pose_digit: self.pose_digits(),
            listed: if self.all_changes { usize::MAX } else { LISTED },
        };
        let done = rewrite(format, texts, &task)?;
        if !self.force && done.report.looks_rewritten {
            return Err(guard::already(&name, "its reversals carry the steps of this compensator"));
        }
        let mut outcome = self.outcome(format, &name, &hashes, &done);
        match target {
            Target::DryRun => Ok(Ready::without_output(outcome)),
            Target::Check(golden) => {
                let (mut theirs, _) = self::texts(
                    format,
                    golden,
                    input::read(golden)?.bytes,
                    &Files::Disk,
                    &Contexts::default(),
                    self.robot.axes(),
                )?;
                theirs.retain(|t| !t.context);
                let ours: Vec<Text> =
                    theirs.iter().zip(&done.texts).map(|(t, own)| own.clone().named(t.name.clone())).collect();
                let missing = hashes.len() != theirs.len();
                let text = match missing {
                    true => Some(format!("{}: a file that belongs to the program is missing", shown(golden))),
                    false => change::against(format, &ours, &theirs, self.robot, self.tolerance)?,
                };
                if let Some(text) = text {
                    outcome.refusal = Some(outcome.refusal.map_or(text.clone(), |r| format!("{r}\n{text}")));
                }
                Ok(Ready::without_output(outcome))
            }
            Target::File(_) if outcome.refusal.is_some() => Ok(Ready::without_output(outcome)),
            Target::File(path) => {
                self.prepare_files(Source { input, companions: &companions, hashes: &hashes }, path, &done, outcome)
            }
        }
    }

    fn outcome(&self, format: &dyn Format, name: &str, hashes: &[String], done: &Done) -> Outcome {
        let line = |n: u64| done.report.lines.get(&n).map(|at| at.line);
        Outcome {
            input: name.into(),
            output: None,
            points: done.coverage.moves,
            refusal: self.violations(name, &done.stats, &line),
            stats: done.stats.clone(),
            sha256_in: hashes.first().cloned(),
            sha256_out: None,
            unchanged: done.unchanged(),
            written: vec![None; self.robot.dof()],
            vendor: Some(Vendor {
                format: format.name(),
                title: format.title(),
                coverage: done.coverage.clone(),
                missing: done.report.missing.clone(),
                gaps: done.report.gaps.clone(),
                unplaced: done.report.unplaced.clone(),
                written: done.written.clone(),
                changes: done.report.changes.clone(),
                changes_total: done.report.changes_total,
                notes: done.notes.clone(),
                runs: done.report.runs,
                anew: done.report.anew,
            }),
        }
    }
}

/// The texts of a program with its context, and the paths of its companions that are there.
pub(super) fn texts(
    format: &dyn Format,
    input: &Path,
    bytes: Vec<u8>,
    there: &Files,
    contexts: &Contexts,
    robot: &Axes,
) -> Result<(Vec<Text>, Vec<PathBuf>)> {
    let name = shown(input);
    memory::require_size(&name, bytes.len() as u64, LARGEST_SCRIPT)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err(Error::bad(Place::file(&name), "a gzip file", "a program as the controller reads it"));
    }
    input::refuse_utf16(&name, &bytes)?;
    let mut all = vec![Text::new(name, bytes)];
    let mut companions = Vec::new();
    if is_stdio(input) {
        if format.minds_unread() {
            all.push(Text::unread("what stands beside it"));
        }
    } else {
        for path in format.companions(input, there) {
            memory::require_for_file(&path, &shown(&path), LARGEST_SCRIPT, |bytes| 2 * bytes)?;
            all.push(Text::new(shown(&path), std::fs::read(&path).map_err(|e| Error::io(&path, "read", e))?));
            companions.push(path);
        }
        all.extend(contexts.of(format, input, robot));
        if let Some(own) = all.first_mut() {
            own.called = contexts.is_called(format, input, own);
        }
    }
    Ok((all, companions))
}

/// Where the texts go: the program to `path`, companions beside it under its stem with their own endings.
fn outputs(path: &Path, companions: &[PathBuf]) -> Result<Vec<PathBuf>> {
    if is_stdio(path) && !companions.is_empty() {
        let found = format!("a program of {} files for standard output", companions.len() + 1);
        return Err(Error::setting("output", found, "a file (the others are written next to it)"));
    }
    let mut all = vec![path.to_path_buf()];
    all.extend(companions.iter().map(|c| match c.extension() {
        Some(ending) => path.with_extension(ending),
        None => path.with_extension("dat"),
    }));
    Ok(all)
}

/// Refuses two files of a result for one name, and a file of the program that is read, unless each file of the program is replaced by
/// its own result and that is forced.
fn refuse_shared(input: &Path, companions: &[PathBuf], paths: &[PathBuf], force: bool) -> Result<()> {
    if paths.first().is_some_and(|p| is_stdio(p)) {
        return Ok(());
    }
    let same = |a: &Path, b: &Path| {
        a == b || std::fs::canonicalize(a).ok().is_some_and(|a| std::fs::canonicalize(b).ok() == Some(a))
    };
    let in_place = force && paths.first().is_some_and(|p| same(input, p));
    for (k, path) in paths.iter().enumerate() {
        let refuse = |found: &str| {
            let e = Error::bad(Place::file(shown(path)), found, "another name for the output");
            Err(e.mended_by(&["output"]))
        };
        if paths[..k].iter().any(|other| same(path, other)) {
            return refuse("two files of the program for one name");
        }
        if std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == std::io::ErrorKind::NotFound) {
            continue; // nothing stands there
        }
        let mut read = std::iter::once(input).chain(companions.iter().map(PathBuf::as_path)).enumerate();
        if read.any(|(j, own)| same(path, own) && !(in_place && j == k)) {
            return refuse("a file of the program that is read");
        }
    }
    Ok(())
}
