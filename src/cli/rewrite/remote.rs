//! `rewrite --manifest` on programs of an object store, or with results in one.
//!
//! Programs are copied to disk in parts, rewritten there as in a folder, and results put into the store part by part. The summary comes
//! last.

use super::Args;
use super::args::usage;
use super::folder::{self, Outputs, Planned};
use super::job::Source;
use super::proof;
use crate::cli::exit::Finished;
use crate::error::{Error, Place};
use crate::io::address::is_address;
use crate::io::store::Store;
use crate::program::files::Files;
use crate::program::formats::Recognised;
use crate::rewrite::batch::{self, Judge, Results, Texts};
use crate::rewrite::guard::Notes;
use crate::rewrite::job::Job;
use crate::rewrite::manifest::{Entry, below};
use crate::rewrite::remote::{self, Staged};
use crate::rewrite::script::context::Contexts;
use crate::rewrite::summary::Line;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Programs and bytes that are on disk at once; a single program may be larger.
const PROGRAMS: usize = 2048;
const BYTES: u64 = 1 << 30;

/// Runs the command on the programs of a manifest.
pub(super) fn run(args: &Args, model: &Source, mut job: Job) -> Result<Finished> {
    let results = folder::results_of(args)?;
    let open = |path: &Path| is_address(path).then(|| Store::open(path)).transpose();
    let source = open(&args.input)?;
    let target = match results {
        Results::Folder(output) => open(output)?,
        Results::Check(_) | Results::DryRun => None,
    };
    let Some(manifest) = &args.manifest else {
        return Err(usage("an object store without --manifest", "--manifest FILE, from `lostmotion manifest`"));
    };
    if source.is_none() && !args.input.is_dir() {
        return Err(usage("--manifest with a single program", "the folder of its programs as IN"));
    }
    if let (Some(source), Some(target)) = (&source, &target)
        && source.overlaps(target)
    {
        return Err(usage("--output-dir at, above or below the programs", "another prefix"));
    }
    let part = args.shard.as_deref().map(folder::shard).transpose()?;
    let Planned { programs, entries, .. } = folder::of_manifest(manifest, part)?;
    let entries = entries.unwrap_or_default();
    let on_disk = match results {
        Results::Folder(output) if target.is_none() => Some(output),
        _ => None,
    };
    if let Some(folder) = on_disk {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "make", e))?;
    }
    let _claim = on_disk.map(|folder| batch::claim(folder, part)).transpose()?;
    if let (Some(output), Some(_)) = (on_disk, part) {
        batch::refuse_busy_below(output, &programs)?;
    }
    (job.files, job.threads, job.hash) = (Files::Disk, false, true);
    let outputs = Outputs::create(args)?;
    let bar = folder::bar(entries.len());
    let mut lines = Vec::with_capacity(entries.len());
    for entries in parts(&entries) {
        // what was found beside the programs of another part is on disk no more
        (job.contexts, job.notes) = (Contexts::default(), Notes::default());
        lines.extend(Part { args, model, job: &job, source: source.as_ref(), results }.run(target.as_ref(), entries)?);
        bar.inc(entries.len() as u64);
    }
    bar.finish_and_clear();
    outputs.finish(args, &job, results, &programs, &lines)
}

/// Programs that are brought to disk together.
fn parts(entries: &[Entry]) -> Vec<&[Entry]> {
    let (mut parts, mut start, mut bytes) = (Vec::new(), 0, 0u64);
    for (k, entry) in entries.iter().enumerate() {
        bytes = bytes.saturating_add(entry.size);
        if k > start && (k - start >= PROGRAMS || bytes > BYTES) {
            parts.push(&entries[start..k]);
            (start, bytes) = (k, entry.size);
        }
    }
    if start < entries.len() {
        parts.push(&entries[start..]);
    }
    parts
}

/// How a part of the programs is done.
struct Part<'a> {
    args: &'a Args,
    /// What verdicts are reckoned with.
    model: &'a Source,
    job: &'a Job<'a>,
    source: Option<&'a Store>,
    results: Results<'a>,
}

impl Part<'_> {
    /// Rewrites the programs of `entries`; the lines are in their order.
    fn run(&self, target: Option<&Store>, entries: &[Entry]) -> Result<Vec<Line>> {
        let programs: Vec<PathBuf> = entries.iter().filter_map(|e| below(&e.key)).collect();
        let staged = self.source.map(|s| Ok::<_, Error>((s, Staged::of(s, &self.formats(entries))?))).transpose()?;
        let input = staged.as_ref().map_or(self.args.input.as_path(), |(_, staged)| staged.folder());
        let put = target.map(|t| Ok::<_, Error>((t, remote::Results::of(t, &programs, input)?))).transpose()?;
        let results = put.as_ref().map_or(self.results, |(_, put)| Results::Folder(put.folder()));
        let missing = |p: &PathBuf| staged.as_ref().and_then(|(_, s)| s.missing(p));
        let there: Vec<(&Entry, &PathBuf)> =
            entries.iter().zip(&programs).filter(|(_, p)| missing(p).is_none()).collect();
        let (known, paths): (Vec<Entry>, Vec<PathBuf>) =
            there.iter().map(|(e, p)| ((*e).clone(), (*p).clone())).unzip();
        let judge = |original: &Path, points: u64, texts: &mut dyn FnMut() -> crate::error::Result<Texts>| {
            let proof = proof::of_texts(self.args, self.model, self.job, (original, points), texts)?;
            folder::judged(self.args, proof, original)
        };
        let judge: Option<&Judge> = folder::asks_verdict(self.args).then_some(&judge);
        let mut done = folder::run_entries(self.job, input, (&known, &paths), results, judge, &|| {}).into_iter();
        let mut lines = Vec::with_capacity(entries.len());
        for (entry, program) in entries.iter().zip(&programs) {
            let line = match missing(program) {
                Some(why) => Some(self.absent(entry, program, why)),
                None => done.next(),
            };
            lines.extend(line.map(|l| self.in_words(l, staged.as_ref(), put.as_ref())));
        }
        if let Some((target, put)) = put {
            put.put(target)?;
        }
        Ok(lines)
    }

    /// The programs of a store with the formats in which they are read.
    fn formats<'e>(&self, entries: &'e [Entry]) -> Vec<(PathBuf, &'e str)> {
        let asked = match self.job.format {
            Some(Recognised::Script(f)) => Some(f.name()),
            Some(Recognised::Csv) => Some("csv"),
            None => None,
        };
        let format = |e: &'e Entry| asked.or(e.format.as_deref()).unwrap_or("csv");
        entries.iter().filter_map(|e| Some((below(&e.key)?, format(e)))).collect()
    }

    /// The line of a program that the store does not have.
    fn absent(&self, entry: &Entry, program: &Path, why: &str) -> Line {
        let location = self.source.and_then(|s| Some(s.name_of(&s.location(program)?)));
        let name = location.unwrap_or_else(|| entry.key.clone());
        let error = Error::bad(Place::file(&name), why, "the object that the manifest lists");
        Line { key: Some(entry.key.clone()), ..Line::failed(name, &error, None) }
    }

    /// A line with names of objects where it has those of their copies.
    fn in_words(&self, line: Line, staged: Option<&(&Store, Staged)>, put: Option<&(&Store, remote::Results)>) -> Line {
        let words = |text: String| {
            let text = staged.map_or_else(|| text.clone(), |(store, staged)| staged.in_words(store, &text));
            put.map_or_else(|| text.clone(), |(store, put)| put.in_words(store, &text))
        };
        Line { input: words(line.input), output: line.output.map(words), reason: line.reason.map(words), ..line }
    }
}
