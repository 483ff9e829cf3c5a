//! One program from file to file: what to compensate, what to check before anything is put in place, what was done.

use super::guard::{self, Named, Note, Notes};
use super::outcome::{Outcome, Ready, Target};
use super::script::Choices;
use super::script::context::{self, Contexts, LARGEST_SCRIPT};
use super::summary::{Line, RewrittenBy};
use super::{LimitKind, Options, Origin, RewriteStats, sizes};
use crate::compensator::{Compensator, JointCompensator};
use crate::error::{Error, Place, Result, is_stdio, shown};
use crate::io::name::text_of_name;
use crate::io::notice::{self, Notice};
use crate::io::output::{Durability, Output};
use crate::io::{input, links, memory};
use crate::program::csv::Reader;
use crate::program::files::Files;
use crate::program::formats::{self, Recognised};
use crate::program::open_rows;
use crate::program::script::Text;
use crate::robot::Robot;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes at the start of a program by which its format is recognised.
const HEAD: u64 = 1 << 16;
/// Bytes of memory that a byte of a vendor program takes at most: joint targets 13 to 21 (benches/vendor.py), Cartesian ones 36.
const SCRIPT_PER_BYTE: u64 = 45;
/// Violations that are listed.
const LISTED: usize = 20;

/// Bytes of memory that a vendor program of `bytes` takes at most; the verdict asks for its own.
fn script_memory(bytes: u64) -> u64 {
    bytes.saturating_mul(SCRIPT_PER_BYTE)
}

/// What is the same for all programs of one call.
pub struct Job<'a> {
    pub robot: &'a Robot,
    pub compensator: &'a Compensator,
    /// What stands in the notes: name of the compensator file and its SHA-256.
    pub source: Named,
    /// `deadband` is filled in from each program, except where [`Job::deadband`] says otherwise.
    pub options: Options,
    pub deadband: Vec<Option<f64>>,
    pub decimals: Option<u8>,
    /// The options as they stand in the note.
    pub said: Vec<String>,
    pub force: bool,
    /// Files that stand where results go are replaced also where they are no results of an earlier run, or were changed.
    pub replace: bool,
    /// The SHA-256 of the input is wanted in any case.
    pub hash: bool,
    pub threads: bool,
    /// Of a vendor program every change is wanted, not the first ones alone.
    pub all_changes: bool,
    /// The format that was asked for; else it is recognised.
    pub format: Option<Recognised>,
    /// What concerns vendor programs alone.
    pub choices: Choices,
    /// Of a check: largest difference of two numbers, in the unit of the program; `None`: every byte counts.
    pub tolerance: Option<f64>,
    pub durability: Durability,
    /// Where the files are looked for that belong to a program.
    pub files: Files,
    /// What is looked up beside programs.
    pub contexts: Contexts,
    /// What notes say, folder by folder.
    pub notes: Notes,
}

/// The note of a result on its way.
#[derive(Default)]
pub(super) struct NoteBeside {
    /// What is put in place.
    pub(super) new: Option<Output>,
    /// The note of an earlier result that goes.
    pub(super) stale: Option<PathBuf>,
}

impl Job<'_> {
    /// Refuses a compensator of another robot.
    pub fn check_robot(&self, compensator_file: &str) -> Result<()> {
        let ours = self.robot.fingerprint();
        if self.compensator.robot_sha256 == ours {
            return Ok(());
        }
        let short = |s: &str| s.chars().take(12).collect::<String>();
        Err(Error::bad(
            Place::file(compensator_file),
            format!(
                "a compensator of robot `{}` ({})",
                self.compensator.robot_name,
                short(&self.compensator.robot_sha256)
            ),
            format!("one of `{}` ({}): same lengths, angles, base and tool", self.robot.name, short(&ours)),
        ))
    }

    /// Refuses offsets that no lost motion explains, unless they are forced.
    pub fn check_sizes(&self, compensator_file: &str) -> Result<()> {
        let found = sizes::implausible(self.robot, self.compensator);
        if self.force || found.is_empty() {
            return Ok(());
        }
        let expected = "offsets of a size that lost motion can have (check the units)";
        Err(Error::bad(Place::file(compensator_file), found.join("; "), expected).mended_by(&["force"]))
    }

    /// Takes one program through; nothing is written where the answer is no.
    pub fn run(&self, input: &Path, target: Target, progress: &(dyn Fn(u64) + Sync)) -> Result<Outcome> {
        self.prepare(input, target, progress)?.commit()
    }

    /// Takes one program through, up to where its output has only to be put in place.
    pub fn prepare(&self, input: &Path, target: Target, progress: &(dyn Fn(u64) + Sync)) -> Result<Ready> {
        if formats::ending(input).is_some_and(|e| e == "csv") && self.format.is_none() {
            return self.prepare_rows(input, open_rows(input, self.robot)?, target, progress);
        }
        let mut stream = input::open(input)?;
        let mut head = Vec::with_capacity(HEAD as usize);
        stream.by_ref().take(HEAD).read_to_end(&mut head).map_err(|e| Error::io(input, "read", e))?;
        match self.format.unwrap_or_else(|| formats::recognise(input, &head)) {
            Recognised::Csv => {
                let reader = Reader::new(Box::new(Cursor::new(head).chain(stream)), &shown(input), self.robot.axes())?;
                self.prepare_rows(input, reader, target, progress)
            }
            Recognised::Script(format) => {
                memory::require_for_file(input, &shown(input), LARGEST_SCRIPT, script_memory)?;
                head.extend(input::read_within(&shown(input), stream, LARGEST_SCRIPT)?);
                self.prepare_script(format, input, head, target)
            }
        }
    }

    /// SHA-256 of the files that declare what a program uses, and of whether another one calls it; `None`: neither, or it cannot be read.
    pub(super) fn context_sum(&self, input: &Path) -> Option<String> {
        let mut head = Vec::with_capacity(HEAD as usize);
        let mut stream = input::open(input).ok()?;
        stream.by_ref().take(HEAD).read_to_end(&mut head).ok()?;
        match self.format.unwrap_or_else(|| formats::recognise(input, &head)) {
            Recognised::Csv => None,
            Recognised::Script(format) => {
                let context = self.contexts.of(format, input, self.robot.axes());
                // names of its routines may stand anywhere in it
                stream.take(LARGEST_SCRIPT).read_to_end(&mut head).ok()?;
                let own = Text::new(shown(input), head);
                context::sum_of(self.contexts.is_called(format, input, &own), context.iter())
            }
        }
    }

    /// What becomes of the note beside the result `output` of `input`, whose files have the SHA-256 `written`.
    ///
    /// A rewritten program has a note. One that needed no change has one in a folder of results, so that the copy is known there as
    /// untouched. Elsewhere it has none, and that of an earlier result goes. A note by which these very files are a rewritten program
    /// stays: it alone may have their original.
    pub(super) fn note_beside(
        &self,
        input: &Path,
        output: &Path,
        outcome: &Outcome,
        written: &[String],
        note: impl FnOnce() -> Result<Note>,
    ) -> Result<NoteBeside> {
        if !outcome.unchanged {
            return Ok(NoteBeside { new: self.prepare_note(output, &note()?)?, stale: None });
        }
        if is_stdio(output) {
            return Ok(NoteBeside::default());
        }
        // of a packed input the bytes differ
        let same_bytes = outcome.sha256_in.as_ref() == written.first();
        let in_folder = self.durability == Durability::RenameOnly && same_bytes && !links::same(input, output);
        let (keeps, stale) = match guard::read_note(output) {
            Ok(None) => (false, false),
            Ok(Some(n)) if n.result() != guard::together(written.iter()) => (false, true),
            Ok(Some(n)) => (!in_folder || !n.is_of_copy(), false),
            // a damaged one may still have the original of a program in place
            Err(e) if e.is_bad_input() && self.force => (true, false),
            // in a folder of results a loss of power damages notes
            Err(e) if e.is_bad_input() && self.durability == Durability::RenameOnly => (false, true),
            Err(e) if e.is_bad_input() => return Err(e.mended_by(&["force"])),
            Err(e) => return Err(e),
        };
        if in_folder && !keeps {
            let new = self.prepare_note(output, &note()?)?;
            // one of an earlier version may stand beside a link
            let linked = stale.then(|| guard::find_note(output)).filter(|n| *n != guard::note_path(output));
            return Ok(NoteBeside { new, stale: linked });
        }
        Ok(NoteBeside { new: None, stale: stale.then(|| guard::find_note(output)) })
    }

    /// SHA-256 of programs that are known to be rewritten, beside `input`; where that is forced, of none but the result that `input`
    /// is itself, if it would be replaced.
    pub(super) fn known(&self, input: &Path, target: &Target) -> Result<Arc<Vec<String>>> {
        if self.force {
            return Ok(Arc::new(own_result(input, target).into_iter().collect()));
        }
        if !is_stdio(input) {
            // a damaged one might have shown that it is a result
            guard::read_note(input).map_err(|e| if e.is_bad_input() { e.mended_by(&["force"]) } else { e })?;
        }
        self.notes.beside(input)
    }

    pub(super) fn refuse_known(&self, input: &Path, notes: &[String], sha256: &Option<String>) -> Result<()> {
        let name = &shown(input);
        match sha256 {
            Some(s) if notes.contains(s) && self.force => Err(Error::bad(
                Place::file(name),
                "a program that has been rewritten already and would be replaced by a second rewrite; its original would be lost",
                "the original program (`undo` restores it)",
            )),
            Some(s) if notes.contains(s) => Err(guard::already(name, "its note is in the same folder")),
            Some(s) if self.force && self.notes.beside(input).is_ok_and(|known| known.contains(s)) => {
                notice::report(Notice::RewrittenAgain(name));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// What decides how its programs are rewritten.
    pub fn rewritten_by(&self) -> RewrittenBy {
        RewrittenBy::of(&self.robot.fingerprint(), &self.source.sha256, &self.said)
    }

    /// The note of a result, but for the original's bytes.
    pub(super) fn note(&self, input: &Path, output: &Path, result: &Outcome) -> Note {
        let line = Line::of(result);
        let name = |p: &Path| p.file_name().map_or_else(|| shown(p), text_of_name);
        Note {
            schema: guard::SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            input: name(input),
            output: name(output),
            sha256_in: result.sha256_in.clone(),
            sha256_out: result.sha256_out.clone().unwrap_or_default(),
            robot: Named { name: self.robot.name.clone(), sha256: self.robot.fingerprint() },
            compensator: self.source.clone(),
            options: self.said.clone(),
            moves: line.moves,
            editable: line.editable,
            edited_as_joints: line.edited_as_joints,
            edited_as_poses: line.edited_as_poses,
            reversals: line.reversals,
            inserted: line.inserted,
            ..Note::default()
        }
    }

    /// The note of `file`, whole but not in place; `None`: standard output, a FIFO and the like have none.
    pub(super) fn prepare_note(&self, file: &Path, note: &Note) -> Result<Option<Output>> {
        if is_stdio(file) || std::fs::metadata(file).is_ok_and(|m| !m.is_file()) {
            return Ok(None);
        }
        let text = guard::note_text(note)?;
        let path = guard::note_path(file);
        if std::fs::metadata(&path).is_ok_and(|m| !m.is_file()) {
            let expected = "a place for the note of the program (remove it, or give another output)";
            return Err(Error::bad(Place::file(shown(&path)), "no regular file", expected));
        }
        let mut output = Output::create_as(&path, self.durability)?;
        output.put(text.as_bytes())?;
        Ok(Some(output))
    }

    /// Largest offset that an axis is given, rad or m; `None` where offsets other than the compensator's are added.
    fn largest(&self, axis: usize) -> Option<f64> {
        let others = self.options.statics.as_ref().is_some_and(|s| s.changes(axis));
        (!others).then(|| self.compensator.on(axis).map_or(0.0, |j| most(j) * self.options.gain) + 1e-9)
    }

    /// The places where a limit would be exceeded, one a line.
    pub(super) fn violations(
        &self,
        name: &str,
        stats: &RewriteStats,
        line: &dyn Fn(u64) -> Option<u64>,
    ) -> Option<String> {
        if stats.violations_total == 0 && stats.violations.is_empty() {
            return None;
        }
        let total = stats.violations_total.max(stats.violations.len() as u64);
        let often = if total == 1 { "once".into() } else { format!("{total} times") };
        let mut text = vec![format!("{name}: a limit would be exceeded {often}; nothing was written")];
        for v in stats.violations.iter().take(LISTED) {
            let (point, added) = match v.origin {
                Origin::Point(n) => (n, ""),
                Origin::Inserted { after, .. } => (after, " (point added after it)"),
            };
            let place = match line(point) {
                Some(line) => format!("{name}:{line}"),
                None => format!("{name}: point {}", point + 1),
            };
            let joint = self.robot.axis(v.axis);
            let (what, unit) = match v.what {
                LimitKind::Range => ("position", joint.kind.unit().to_string()),
                LimitKind::Speed => ("speed", format!("{}/s", joint.kind.unit())),
                LimitKind::Acceleration => ("acceleration", format!("{}/s2", joint.kind.unit())),
            };
            let edge = |x: f64| joint.kind.to_user_unit(x);
            text.push(format!(
                "  {place}{added}: {} {what} {} {unit}, limit {} {unit}{}",
                joint.name,
                figure(edge(v.value)),
                figure(edge(v.limit)),
                if v.what == LimitKind::Range && self.largest(v.axis).is_some_and(|m| (v.value - v.limit).abs() > m) {
                    " (the program itself exceeds it)"
                } else {
                    ""
                }
            ));
        }
        if total > LISTED as u64 {
            text.push(format!("  and {} more", total - LISTED as u64));
        }
        Some(text.join("\n"))
    }
}

/// SHA-256 of the result that `input` is by its note, where `target` is the same file: its original stands nowhere else.
fn own_result(input: &Path, target: &Target) -> Option<String> {
    let in_place = |output: &Path| !is_stdio(input) && !is_stdio(output) && links::same(input, output);
    let Target::File(output) = target else { return None };
    // a damaged one is ignored where that is forced
    let note = in_place(output).then(|| guard::read_note(output).ok().flatten()).flatten()?;
    Some(note.result()).filter(|_| !note.is_of_copy())
}

/// A number to six decimals, in powers of ten where it has many digits.
fn figure(value: f64) -> String {
    if value.abs() < 1e9 { format!("{value:.6}") } else { format!("{value:.3e}") }
}

/// Largest offset that a joint may be given, rad or m.
fn most(joint: &JointCompensator) -> f64 {
    let gap = joint.backlash.as_ref().map_or(0.0, |b| b.positive.largest().max(b.negative.largest()));
    gap + joint.friction.map_or(0.0, |f| f.gain.abs())
}
