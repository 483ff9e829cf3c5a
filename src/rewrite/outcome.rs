//! What was done with a program, and what is ready to be put in place.

use super::RewriteStats;
use super::script::cause::Cause;
use super::script::change::Change;
use super::script::coverage::{Coverage, Reason};
use super::script::run::Gap;
use super::script::unplaced::Unplaced;
use super::script::verify::Written;
use super::sink::File;
use crate::error::Result;
use crate::io::output::Output;
use crate::io::transaction::Transaction;
use crate::program::script::Note;
use crate::robot::frames::Missing;
use std::path::{Path, PathBuf};

/// Where the result goes.
pub enum Target<'a> {
    File(&'a Path),
    DryRun,
    Check(&'a Path),
}

/// What was done with a program.
#[derive(Debug)]
pub struct Outcome {
    pub input: String,
    /// `None`: a dry run, or a check.
    pub output: Option<String>,
    pub points: u64,
    pub stats: RewriteStats,
    pub sha256_in: Option<String>,
    pub sha256_out: Option<String>,
    /// No byte differs.
    pub unchanged: bool,
    /// Fewest decimals with which numbers of each axis were written.
    pub written: Vec<Option<u8>>,
    /// Why the answer is no: limits, or a golden file that differs. Then nothing was written.
    pub refusal: Option<String>,
    /// What is to be reported of a vendor program.
    pub vendor: Option<Vendor>,
}

/// A program that has been taken through and whose output is whole, but not in place; dropped, it leaves nothing.
pub struct Ready {
    pub outcome: Outcome,
    pub(super) files: Vec<File>,
    pub(super) note: Option<Output>,
    /// The note of an earlier result instead of a program that stays as it was.
    pub(super) stale_note: Option<PathBuf>,
}

impl Ready {
    pub(super) fn without_output(outcome: Outcome) -> Self {
        Self { outcome, files: Vec::new(), note: None, stale_note: None }
    }

    /// The answer is no after all: nothing will be put in place.
    pub fn refuse(&mut self, why: String) {
        self.files.clear();
        (self.note, self.stale_note) = (None, None);
        self.outcome.output = None;
        self.outcome.sha256_out = None;
        self.outcome.refusal = Some(match self.outcome.refusal.take() {
            Some(before) => format!("{before}\n{why}"),
            None => why,
        });
    }

    /// Whether all files of the program go to regular files.
    pub fn is_regular(&self) -> bool {
        self.files.iter().all(File::is_regular)
    }

    /// Names and bytes of the program and the files that belong to it, as they are about to be put in place.
    pub fn texts(&mut self) -> Result<Vec<(String, Vec<u8>)>> {
        self.files.iter_mut().map(|f| Ok((f.shown().to_string(), f.contents()?))).collect()
    }

    /// Puts the note in place, then the program with the files that belong to it: all of them or none.
    pub fn commit(self) -> Result<Outcome> {
        self.commit_with(Vec::new())
    }

    /// The same, with further outputs after them.
    pub fn commit_with(self, further: Vec<Output>) -> Result<Outcome> {
        let mut all = Transaction::default();
        if let Some(note) = self.note {
            all.put(note);
        }
        // the file that was named comes last: once it is there, the others are
        for file in self.files.into_iter().rev() {
            all.put(file.into_output());
        }
        further.into_iter().for_each(|o| all.put(o));
        if let Some(note) = self.stale_note {
            all.remove(note);
        }
        all.commit()?;
        Ok(self.outcome)
    }
}

/// What the report of a vendor program contains in addition to that of every program.
#[derive(Debug, Clone)]
pub struct Vendor {
    pub format: &'static str,
    pub title: &'static str,
    pub coverage: Coverage,
    /// Frames and tools that moves wait for.
    pub missing: Missing,
    /// Where directions are lost because a target could not be followed.
    pub gaps: Vec<Gap>,
    pub unplaced: Unplaced,
    pub written: Written,
    /// The first of them, and how many there are.
    pub changes: Vec<Change>,
    pub changes_total: usize,
    pub notes: Vec<Note>,
    /// Stretches with known directions.
    pub runs: usize,
    /// Of them those that do not start with the program.
    pub anew: usize,
}

impl Vendor {
    /// What becomes of directions at the moves that stay for a reason: empty, or words after the reason.
    pub fn lost_at(&self, reason: &Reason) -> &'static str {
        let lost = |line: &u64| self.gaps.iter().any(|g| g.at.file == reason.file && g.at.line == *line);
        match reason.lines.iter().filter(|line| lost(line)).count() {
            0 => "",
            n if n == reason.lines.len() => "; directions are lost there",
            _ => "; directions are lost at some of them",
        }
    }

    /// Where directions are lost at moves that are not among those listed as not edited: the reason, and its lines.
    pub fn lost_elsewhere(&self) -> Vec<(String, Vec<u64>)> {
        let reasons = &self.coverage.reasons;
        let listed = |g: &Gap| {
            // a reason lists the first of its lines
            matches!(g.why, Cause::Undetermined | Cause::Curve)
                || reasons.iter().any(|r| r.why == g.why || r.file == g.at.file && r.lines.contains(&g.at.line))
        };
        let mut found: Vec<(String, Vec<u64>)> = Vec::new();
        for g in self.gaps.iter().filter(|g| !listed(g)) {
            let why = g.why.to_string();
            match found.iter_mut().find(|(other, _)| *other == why) {
                Some((_, lines)) => lines.push(g.at.line),
                None => found.push((why, vec![g.at.line])),
            }
        }
        found
    }
}
