//! Summaries of shards, merged: the line of each program, what is left to do, and whether all of them are of one job.

use super::{Entry, below};
use crate::error::{BadInput, Error, Place, Result, shown};
use crate::io::input;
use crate::numerics::parallel::ParMap;
use crate::rewrite::batch;
use crate::rewrite::guard::read_note;
use crate::rewrite::refusal::Refusal;
use crate::rewrite::summary::{RewrittenBy, Status};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Keys that a message lists.
const LISTED: usize = 5;

/// A line of a summary, as far as merging needs it.
#[derive(Deserialize)]
struct Summed {
    key: Option<String>,
    status: Status,
    sha256_in: Option<String>,
    sha256_out: Option<String>,
    /// Summaries of earlier versions lack it.
    #[serde(default)]
    rewritten_by: Option<RewrittenBy>,
}

impl Summed {
    /// Why the line says nothing about the job: found and expected.
    fn fault(&self, entry: &Entry) -> Option<[String; 2]> {
        let key = &entry.key;
        match self.status {
            Status::WouldBeWritten => {
                let expected = "a summary of a run that writes (not of a dry run or a check)";
                Some([format!("`{key}` that would be written"), expected.into()])
            }
            // one that failed may have changed since it was listed: that is why
            Status::Failed => None,
            _ if self.sha256_in == entry.sha256 => None,
            _ => Some([
                format!("`{key}` with another `sha256_in` than the manifest"),
                "a summary of this manifest".into(),
            ]),
        }
    }
}

/// The line of a program in a summary.
#[derive(Debug, Clone)]
pub struct SummaryLine {
    /// The line itself.
    pub text: String,
    /// `None`: it is of a former content of the program, or of a run that wrote nothing.
    pub status: Option<Status>,
    sha256_out: Option<String>,
}

/// What is known of the programs of a manifest, in their order.
#[derive(Debug, Default)]
pub struct Merged {
    /// Lines of the summaries; `None`: no summary holds the program.
    pub lines: Vec<Option<SummaryLine>>,
    /// The first line that is not of this job.
    fault: Option<BadInput>,
    /// By what the first program was rewritten, and where that stands.
    by: Option<(RewrittenBy, String)>,
    /// The first line of a program that was rewritten by something else.
    mixed: Option<BadInput>,
}

/// Counts of the programs of a manifest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Number of programs in the manifest.
    pub programs: usize,
    /// Written or unchanged.
    pub done: usize,
    /// Number of programs that were refused.
    pub refused: usize,
    /// Number of programs that failed.
    pub failed: usize,
    /// Number of programs that are left to do.
    pub left: usize,
}

impl Merged {
    /// Reads summaries of shards.
    ///
    /// # Errors
    /// Bad input where a line has no key, a key that the manifest does not have, or one that came before.
    pub fn read(entries: &[Entry], summaries: &[PathBuf]) -> Result<Self> {
        let opened = summaries.iter().map(|path| Ok((path.as_path(), BufReader::new(input::open(path)?))));
        Self::merge(entries, opened)
    }

    /// Reads one summary of that name; errors as those of [`Merged::read`].
    pub fn parse(entries: &[Entry], name: &str, lines: impl BufRead) -> Result<Self> {
        Self::merge(entries, std::iter::once(Ok((Path::new(name), lines))))
    }

    fn merge<'a, R: BufRead>(
        entries: &[Entry],
        summaries: impl Iterator<Item = Result<(&'a Path, R)>>,
    ) -> Result<Self> {
        let places: HashMap<&str, usize> = entries.iter().enumerate().map(|(k, e)| (e.key.as_str(), k)).collect();
        let mut lines: Vec<Option<SummaryLine>> = vec![None; entries.len()];
        let (mut fault, mut by, mut mixed) = (None, None, None);
        for summary in summaries {
            let (path, text) = summary?;
            let name = shown(path);
            for (k, line) in text.lines().enumerate() {
                let line = line.map_err(|e| Error::io(path, "read", e))?;
                let at = || Place::line(&name, k as u64 + 1);
                let expected = "a line of a summary of a shard";
                let summed: Summed =
                    serde_json::from_str(&line).map_err(|e| Error::bad(at(), e.to_string(), expected))?;
                let key = summed.key.as_deref().ok_or_else(|| Error::bad(at(), "no key", expected))?;
                let place = places.get(key).copied();
                let place = place.ok_or_else(|| Error::bad(at(), format!("`{key}`"), "a program of the manifest"))?;
                if lines[place].is_some() {
                    return Err(Error::bad(at(), format!("`{key}` twice"), "each program in one summary"));
                }
                let other = summed.fault(&entries[place]);
                let status = other.is_none().then_some(summed.status);
                if let (Some([found, expected]), None) = (other, &fault) {
                    fault = Some(BadInput { place: at(), found, expected });
                }
                if let (Some(one), None) = (&summed.rewritten_by, &mixed) {
                    mixed = differs(&mut by, one, &name).map(|found| BadInput {
                        place: at(),
                        found: format!("`{key}`, rewritten by {found}"),
                        expected: ONE_JOB.into(),
                    });
                }
                lines[place] = Some(SummaryLine { text: line, status, sha256_out: summed.sha256_out });
            }
        }
        Ok(Self { lines, fault, by, mixed })
    }

    /// Refuses programs of one job that were rewritten by different compensators, robot files or options. With the folder of the results
    /// those are asked, too, of which there is no line yet.
    ///
    /// # Errors
    /// Bad input, with the first line or result that differs.
    pub fn require_one_job(&self, entries: &[Entry], results: Option<&Path>) -> Result<()> {
        if let Some(mixed) = &self.mixed {
            return Err(Error::BadInput(mixed.clone()));
        }
        let Some(results) = results else { return Ok(()) };
        let mut by = self.by.clone();
        for (entry, _) in entries.iter().zip(&self.lines).filter(|(_, line)| line.is_none()) {
            let Some(path) = below(&entry.key).map(|key| results.join(key)).filter(|p| stands(entry, p)) else {
                continue;
            };
            let Some(note) = read_note(&path).ok().flatten() else { continue };
            let one = RewrittenBy::of(&note.robot.sha256, &note.compensator.sha256, &note.options);
            if let Some(found) = differs(&mut by, &one, &shown(&path)) {
                return Err(Error::bad(Place::file(shown(&path)), format!("a program rewritten by {found}"), ONE_JOB));
            }
        }
        Ok(())
    }

    /// Refuses summaries that are not of this job, and those in which programs are missing.
    ///
    /// # Errors
    /// Bad input where a line is of a former content of its program, or of a run that wrote nothing; a refusal where programs are missing.
    pub fn require_all(&self, entries: &[Entry]) -> Result<()> {
        if let Some(fault) = &self.fault {
            return Err(Error::BadInput(fault.clone()));
        }
        let missing = || entries.iter().zip(&self.lines).filter(|(_, l)| l.is_none()).map(|(e, _)| e.key.as_str());
        let count = missing().count();
        if count == 0 {
            return Ok(());
        }
        let first: Vec<&str> = missing().take(LISTED).collect();
        let more = if count > LISTED { ", ..." } else { "" };
        Err(Refusal::Missing { missing: count, programs: entries.len(), first: first.join(", ") + more }.into())
    }

    /// Counts. With the folder of the results, every result is read: a program is done if its result is the one that its line of a
    /// summary or its note says, and of the listed content. A line of a former content, or of a run that wrote nothing, does not count.
    pub fn counts(&self, entries: &[Entry], results: Option<&Path>) -> Counts {
        let status = |(entry, told): (&Entry, &Option<SummaryLine>)| {
            let path = || Some(results?.join(below(&entry.key)?));
            match told.as_ref().and_then(|t| Some((t, t.status?))) {
                Some((told, status @ (Status::Written | Status::Unchanged))) => match path() {
                    Some(path) => {
                        (told.sha256_out.is_some() && batch::hash(&path) == told.sha256_out).then_some(status)
                    }
                    None => Some(status),
                },
                Some((_, status)) => Some(status),
                None => path().filter(|p| stands(entry, p)).map(|_| Status::Written),
            }
        };
        let all = (0..entries.len().min(self.lines.len())).par_map(|k| status((&entries[k], &self.lines[k])));
        let mut counts = Counts { programs: entries.len(), ..Counts::default() };
        for status in all {
            let count = match status {
                None => &mut counts.left,
                Some(Status::Refused) => &mut counts.refused,
                Some(Status::Failed) => &mut counts.failed,
                Some(Status::Written | Status::WouldBeWritten | Status::Unchanged) => &mut counts.done,
            };
            *count += 1;
        }
        counts
    }
}

/// What is expected where the programs of a job differ in what rewrote them.
const ONE_JOB: &str =
    "all programs of a job rewritten by one compensator, robot file and set of options: rewrite them again";

/// In what a program differs from the first one, which is kept with the place where that stands.
fn differs(first: &mut Option<(RewrittenBy, String)>, one: &RewrittenBy, place: &str) -> Option<String> {
    match first {
        None => {
            *first = Some((one.clone(), place.into()));
            None
        }
        Some((first, named)) => one.differs(first).map(|part| format!("another {part} than the programs in {named}")),
    }
}

/// Whether a result of the listed content stands at `path` as its note says.
fn stands(entry: &Entry, path: &Path) -> bool {
    let note = read_note(path).ok().flatten().filter(|n| n.sha256_in.is_some() && n.sha256_in == entry.sha256);
    note.is_some_and(|n| batch::hash(path).as_ref() == Some(&n.sha256_out))
}
