//! One joint-space CSV from file to file, in constant memory.

use super::golden::{Difference, Golden, explain};
use super::{Done, Passage, Preview, pass};
use crate::compensator::JointCompensator;
use crate::error::{Error, Place, Result, is_stdio, shown};
use crate::io::input;
use crate::program::csv::{Reader, Style};
use crate::rewrite::deadband::deadbands;
use crate::rewrite::foreign::{self, PendingFile};
use crate::rewrite::job::Job;
use crate::rewrite::outcome::{Outcome, Ready, Target};
use crate::rewrite::rewritten::{Digits, Evidence, Rows};
use crate::rewrite::sink::{File, NullSink, Sink};
use crate::rewrite::{Engine, Refusal, guard, original};
use std::path::Path;

impl Job<'_> {
    /// Takes one joint-space CSV through, from its `reader`.
    pub(in super::super) fn prepare_rows(
        &self,
        input: &Path,
        reader: Reader,
        target: Target,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Ready> {
        let notes = self.known(input, &target)?;
        let name = shown(input);
        let passage = Passage {
            style: Style { forced: self.decimals, least: self.least_decimals()? },
            threads: self.threads,
            // a note beside the result names its original
            hash: self.hash || !notes.is_empty() || matches!(target, Target::File(path) if !is_stdio(path)),
        };
        let make = |p: &Preview| self.engine(&name, p);
        let placed = |e| placed(&name, e);
        let outcome = |done: Done<()>, output: Option<&Path>| {
            let unchanged = done.stats.inserted == 0 && done.written.iter().all(Option::is_none);
            Outcome {
                input: name.clone(),
                output: output.map(shown),
                points: done.points,
                refusal: self.violations(&name, &done.stats, &|n| done.lines.line(n)),
                stats: done.stats,
                sha256_in: done.sha256_in,
                sha256_out: None,
                unchanged,
                written: done.written,
                vendor: None,
            }
        };
        match target {
            Target::DryRun => {
                let (done, _) = split(pass(self.robot, reader, &passage, make, NullSink, progress).map_err(placed)?);
                self.refuse_known(input, &notes, &done.sha256_in)?;
                Ok(Ready::without_output(outcome(done, None)))
            }
            Target::Check(golden) => {
                let header = reader.header().clone();
                let golden_file = Golden::open(golden, self.tolerance)?;
                let (done, sink) =
                    split(pass(self.robot, reader, &passage, make, golden_file, progress).map_err(placed)?);
                self.refuse_known(input, &notes, &done.sha256_in)?;
                let mut result = outcome(done, None);
                let difference: Option<Difference> = sink.finish()?;
                if let Some(d) = difference {
                    let text = explain(&d, &shown(golden), &header, self.robot);
                    result.refusal = Some(result.refusal.map_or(text.clone(), |r| format!("{r}\n{text}")));
                }
                Ok(Ready::without_output(result))
            }
            Target::File(path) => {
                let sink = File::create(path, self.durability)?;
                let done = pass(self.robot, reader, &passage, make, sink, progress).map_err(placed)?;
                let (done, mut sink) = split(done);
                self.refuse_known(input, &notes, &done.sha256_in)?;
                let mut result = outcome(done, Some(path));
                if result.refusal.is_some() {
                    result.output = None;
                    return Ok(Ready::without_output(result));
                }
                let sha256_out = sink.sha256();
                // a full disk shows here, while neither the program nor its note is in place
                sink.prepare()?;
                let sha256_in = result.sha256_in.as_deref();
                let placed = PendingFile { path, sha256_in, sha256_out: &sha256_out };
                foreign::refuse(self, std::slice::from_mut(&mut sink), &[placed])?;
                let written = [sha256_out];
                result.sha256_out = written.first().cloned();
                let note = self.note_beside(input, path, &result, &written, || {
                    let mut note = self.note(input, path, &result);
                    if !result.unchanged {
                        note.original = kept(input, note.sha256_in.as_deref())?;
                    }
                    Ok(note)
                })?;
                Ok(Ready { outcome: result, files: vec![sink], note: note.new, stale_note: note.stale })
            }
        }
    }

    fn engine(&self, name: &str, preview: &Preview) -> Result<Engine<'_>> {
        let mut options = self.options.clone();
        if !self.force && self.looks_rewritten(preview) {
            return Err(guard::already(name, "its reversals carry the steps of this compensator"));
        }
        options.deadband = self.deadbands(&preview.decimals);
        let seconds = |j: &JointCompensator| j.friction.is_some_and(|f| f.needs_clock());
        if !preview.has_times
            && options.tcp_speed_m_s.is_none()
            && let Some(j) = self.compensator.joints.iter().find(|j| seconds(j))
        {
            return Err(Error::bad(
                Place::file(name),
                format!("no column t_s, and an offset of {} that fades in seconds", self.robot.axis(j.axis).name),
                "a TCP speed",
            )
            .mended_by(&["speed_mm_s"]));
        }
        Engine::new(self.robot, self.compensator, options)
    }

    /// By the numbers of its first block.
    fn looks_rewritten(&self, preview: &Preview) -> bool {
        let joints = self.robot.axis_joints().zip(&preview.decimals);
        let digits = joints.map(|(joint, &d)| {
            let unit = joint.kind.si_per_user_unit();
            Digits { last: 10f64.powi(-i32::from(d)) * unit, unit }
        });
        let digits: Vec<Digits> = digits.collect();
        let axes = self.robot.dof();
        let mut q = preview.q.to_vec();
        if self.robot.has_sums() {
            q.chunks_exact_mut(axes).for_each(|row| self.robot.to_gears(row));
        }
        let rows = Rows { q: &q, straight: &[], axes };
        let mut evidence = Evidence::default();
        evidence.add(rows, &digits, self.compensator, self.options.step_fraction);
        evidence.is_rewritten()
    }

    /// Dead bands for columns of so many decimals.
    fn deadbands(&self, decimals: &[u8]) -> Vec<f64> {
        let units: Vec<f64> = self.robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
        let last_digit = |a: usize| 10f64.powi(-i32::from(decimals[a])) * units[a];
        deadbands(&self.deadband, self.compensator, self.robot.dof(), last_digit)
    }
}

/// The refusal of a point with the name of its program.
fn placed(name: &str, e: Error) -> Error {
    if let Error::Refused(why) = &e
        && let Some(Refusal::NoTime { place }) = why.downcast_ref::<Refusal>()
    {
        return Refusal::NoTime { place: format!("{name}: {place}") }.into();
    }
    e
}

/// The sink apart from the rest.
fn split<S: Sink>(done: Done<S>) -> (Done<()>, S) {
    let Done { stats, points, lines, sha256_in, written, sink } = done;
    (Done { stats, points, lines, sha256_in, written, sink: () }, sink)
}

/// The bytes of the program at `input` for its note, where it is a small file: read again, and still what was read.
fn kept(input: &Path, sha256: Option<&str>) -> Result<Option<String>> {
    // without a hash there is no note: the result goes to a pipe
    let Some(sha256) = sha256.filter(|_| !is_stdio(input)) else { return Ok(None) };
    let meta = std::fs::metadata(input).map_err(|e| Error::io(input, "read again", e))?;
    if !meta.is_file() || meta.len() > original::KEPT_UP_TO {
        return Ok(None);
    }
    let bytes = std::fs::read(input).map_err(|e| Error::io(input, "read again", e))?;
    if sha256 != input::sha256(&bytes) {
        let expected = "a program that does not change while it is rewritten; nothing was written";
        return Err(Error::bad(Place::file(shown(input)), "a program that changed while it was read", expected));
    }
    Ok(original::pack(&bytes))
}
