//! One program from file to file: what to compensate, what to check before anything is put in place, what was done.

use super::stream::golden::{Difference, Golden, explain};
use super::stream::guard::{self, Named, Note};
use super::stream::sink::{File, Nowhere, Sink};
use super::stream::{Done, Passage, Preview, pass};
use super::{Account, Engine, LimitKind, Options, Origin};
use crate::compensator::{Compensator, FrictionShape, JointCompensator};
use crate::effect::Decay;
use crate::error::{Error, Place, Result, is_stdio, shown};
use crate::io::output::Output;
use crate::program::csv::{Reader, Style};
use crate::program::lines::Lines;
use crate::robot::Robot;
use std::path::Path;

/// A token's last digit is coarse where it is more than this share of the smallest half gap.
const COARSE: f64 = 0.05;
/// Decimals that the rule above asks for at most.
const MOST_DECIMALS: u8 = 9;
/// Decimals of a joint that is corrected at every point: 1e-6 deg is 0.05 um at a lever of 3 m.
const STATIC_DECIMALS: u8 = 6;
/// The dead band is this many of a column's last digits: rounding to even and odd digits is no movement.
const DEADBAND_DIGITS: f64 = 1.5;
/// Smallest dead band, rad or m.
const LEAST_DEADBAND: f64 = 1e-9;
/// Violations that are listed.
const LISTED: usize = 20;

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
    /// The SHA-256 of the input is wanted in any case.
    pub hash: bool,
    pub threads: bool,
}

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
    pub account: Account,
    pub lines: Lines,
    pub sha256_in: Option<String>,
    pub sha256_out: Option<String>,
    /// No byte differs.
    pub unchanged: bool,
    /// Fewest decimals with which numbers of each axis were written.
    pub written: Vec<Option<u8>>,
    /// Why the answer is no: limits, or a golden file that differs. Then nothing was written.
    pub refusal: Option<String>,
}

/// A program that has been taken through and whose output is whole, but not in place; dropped, it leaves nothing.
pub struct Ready {
    pub outcome: Outcome,
    program: Option<File>,
    note: Option<Output>,
}

impl Ready {
    fn without_output(outcome: Outcome) -> Self {
        Self { outcome, program: None, note: None }
    }

    /// Puts the program in place, then its note.
    pub fn commit(self) -> Result<Outcome> {
        self.program.map_or(Ok(()), File::commit)?;
        self.note.map_or(Ok(()), Output::commit)?;
        Ok(self.outcome)
    }
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

    /// Takes one program through; nothing is written where the answer is no.
    pub fn run(&self, input: &Path, target: Target, progress: &(dyn Fn(u64) + Sync)) -> Result<Outcome> {
        self.prepare(input, target, progress)?.commit()
    }

    /// Takes one program through, up to where its output has only to be put in place.
    pub fn prepare(&self, input: &Path, target: Target, progress: &(dyn Fn(u64) + Sync)) -> Result<Ready> {
        let notes = if self.force { Vec::new() } else { guard::rewritten_beside(input) };
        let reader = Reader::open(input, self.robot)?;
        let name = shown(input);
        let passage = Passage {
            style: Style { forced: self.decimals, least: self.least_decimals()? },
            threads: self.threads,
            hash: self.hash || !notes.is_empty(),
        };
        let make = |p: &Preview| self.engine(&name, p);
        let outcome = |done: Done<()>, output: Option<&Path>| {
            let unchanged = done.account.inserted == 0 && done.written.iter().all(Option::is_none);
            Outcome {
                input: name.clone(),
                output: output.map(shown),
                points: done.points,
                refusal: self.violations(&name, &done.account, &done.lines),
                account: done.account,
                lines: done.lines,
                sha256_in: done.sha256_in,
                sha256_out: None,
                unchanged,
                written: done.written,
            }
        };
        match target {
            Target::DryRun => {
                let (done, _) = split(pass(self.robot, reader, &passage, make, Nowhere, progress)?);
                self.refuse_known(&name, &notes, &done.sha256_in)?;
                Ok(Ready::without_output(outcome(done, None)))
            }
            Target::Check(golden) => {
                let header = reader.header().clone();
                let (done, sink) = split(pass(self.robot, reader, &passage, make, Golden::open(golden)?, progress)?);
                self.refuse_known(&name, &notes, &done.sha256_in)?;
                let mut result = outcome(done, None);
                let difference: Option<Difference> = sink.finish()?;
                if let Some(d) = difference {
                    let text = explain(&d, &shown(golden), &header, self.robot);
                    result.refusal = Some(result.refusal.map_or(text.clone(), |r| format!("{r}\n{text}")));
                }
                Ok(Ready::without_output(result))
            }
            Target::File(path) => {
                let (done, mut sink) = split(pass(self.robot, reader, &passage, make, File::create(path)?, progress)?);
                self.refuse_known(&name, &notes, &done.sha256_in)?;
                let mut result = outcome(done, Some(path));
                if result.refusal.is_some() {
                    result.output = None;
                    return Ok(Ready::without_output(result));
                }
                let sha256_out = sink.sha256();
                // a full disk shows here, while neither the program nor its note is in place
                sink.prepare()?;
                let note = if result.unchanged {
                    None
                } else {
                    prepare_note(path, &self.note(input, path, &result, &sha256_out))?
                };
                result.sha256_out = Some(sha256_out);
                Ok(Ready { outcome: result, program: Some(sink), note })
            }
        }
    }

    fn engine(&self, name: &str, preview: &Preview) -> Result<Engine<'_>> {
        let mut options = self.options.clone();
        options.deadband = self.deadbands(&preview.decimals);
        if !self.force && guard::looks_rewritten(preview.q, self.robot.dof(), self.compensator, &options) {
            return Err(guard::already(name, "its reversals carry the steps of this compensator"));
        }
        let seconds = |j: &JointCompensator| {
            j.friction.is_some_and(|f| f.gain != 0.0 && matches!(f.shape, FrictionShape::Decay(Decay::Time(_))))
        };
        if !preview.has_times
            && options.tcp_speed_m_s.is_none()
            && let Some(j) = self.compensator.joints.iter().find(|j| seconds(j))
        {
            return Err(Error::bad(
                Place::file(name),
                format!("no column t_s, and an offset of {} that fades in seconds", self.robot.axis(j.axis).name),
                "a TCP speed: --speed-mm-s",
            ));
        }
        Engine::new(self.robot, self.compensator, options)
    }

    /// What was asked for, else 1.5 last digits of each column, at most the smallest half gap.
    fn deadbands(&self, decimals: &[u8]) -> Vec<f64> {
        let axes = self.robot.axis_joints().zip(decimals).enumerate();
        axes.map(|(a, (joint, &d))| {
            if let Some(chosen) = self.deadband.get(a).copied().flatten() {
                return chosen;
            }
            let digits = DEADBAND_DIGITS * 10f64.powi(-i32::from(d)) * joint.kind.si();
            let gap = self.compensator.on(a).and_then(smallest).unwrap_or(f64::INFINITY);
            digits.min(gap).max(LEAST_DEADBAND)
        })
        .collect()
    }

    /// Decimals that each axis needs so that the last digit is no more than 5 % of its smallest half gap.
    fn least_decimals(&self) -> Result<Vec<u8>> {
        let mut least = Vec::new();
        for (a, joint) in self.robot.axis_joints().enumerate() {
            let fine = if self.options.statics.as_ref().is_some_and(|s| s.changes(a)) { STATIC_DECIMALS } else { 0 };
            let Some(gap) = self.compensator.on(a).and_then(smallest) else {
                least.push(fine);
                continue;
            };
            let gap = joint.kind.to_edge(gap * self.options.gain);
            if let Some(n) = self.decimals
                && 10f64.powi(-i32::from(n)) > gap
                && gap > 0.0
            {
                return Err(Error::bad(
                    Place::file("--decimals"),
                    format!("{n} decimals for an offset of {gap:.6} {} of {}", joint.kind.unit(), joint.name),
                    "decimals that can hold the offset",
                ));
            }
            let digits = (0..MOST_DECIMALS).find(|&d| 10f64.powi(-i32::from(d)) <= COARSE * gap);
            least.push(digits.unwrap_or(MOST_DECIMALS).max(fine));
        }
        Ok(least)
    }

    fn refuse_known(&self, name: &str, notes: &[String], sha256: &Option<String>) -> Result<()> {
        match sha256 {
            Some(s) if notes.contains(s) => Err(guard::already(name, "its note lies beside it")),
            _ => Ok(()),
        }
    }

    fn note(&self, input: &Path, output: &Path, result: &Outcome, sha256_out: &str) -> Note {
        let name = |p: &Path| p.file_name().map_or_else(|| shown(p), |n| n.to_string_lossy().into_owned());
        Note {
            schema: guard::SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            input: name(input),
            output: name(output),
            sha256_in: result.sha256_in.clone(),
            sha256_out: sha256_out.into(),
            robot: Named { name: self.robot.name.clone(), sha256: self.robot.fingerprint() },
            compensator: self.source.clone(),
            options: self.said.clone(),
        }
    }

    /// The places where a limit would be exceeded, one a line.
    fn violations(&self, name: &str, account: &Account, lines: &Lines) -> Option<String> {
        if account.violations_total == 0 && account.violations.is_empty() {
            return None;
        }
        let total = account.violations_total.max(account.violations.len() as u64);
        let mut text =
            vec![format!("{name}: a limit would be exceeded after compensation, {total} times; nothing was written")];
        for v in account.violations.iter().take(LISTED) {
            let (point, added) = match v.origin {
                Origin::Point(n) => (n, ""),
                Origin::Inserted { after, .. } => (after, " (point added behind it)"),
            };
            let place = match lines.line(point) {
                Some(line) => format!("{name}:{line}"),
                None => format!("{name}: point {}", point + 1),
            };
            let joint = self.robot.axis(v.axis);
            let (what, unit) = match v.what {
                LimitKind::Range => ("position", joint.kind.unit().to_string()),
                LimitKind::Speed => ("speed", format!("{}/s", joint.kind.unit())),
                LimitKind::Acceleration => ("acceleration", format!("{}/s2", joint.kind.unit())),
            };
            let edge = |x: f64| joint.kind.to_edge(x);
            text.push(format!(
                "  {place}{added}: {} {what} {:.6} {unit}, limit {:.6} {unit}",
                joint.name,
                edge(v.value),
                edge(v.limit)
            ));
        }
        if total > LISTED as u64 {
            text.push(format!("  and {} more", total - LISTED as u64));
        }
        Some(text.join("\n"))
    }
}

/// The note of `file`, whole but not in place; `None`: standard output, a FIFO and the like have none.
fn prepare_note(file: &Path, note: &Note) -> Result<Option<Output>> {
    if is_stdio(file) || std::fs::metadata(file).is_ok_and(|m| !m.is_file()) {
        return Ok(None);
    }
    let text = serde_json::to_string_pretty(note)
        .map_err(|e| Error::bad(Place::default(), e.to_string(), "values that JSON can hold"))?;
    let mut output = Output::create(&guard::note_path(file))?;
    output.put((text + "\n").as_bytes())?;
    Ok(Some(output))
}

/// The sink apart from the rest.
fn split<S: Sink>(done: Done<S>) -> (Done<()>, S) {
    let Done { account, points, lines, sha256_in, written, sink } = done;
    (Done { account, points, lines, sha256_in, written, sink: () }, sink)
}

/// Smallest half gap of a joint that is above 0, rad or m; of a joint with friction alone, its gain.
fn smallest(joint: &JointCompensator) -> Option<f64> {
    let curves = joint.backlash.iter().flat_map(|b| [&b.positive, &b.negative]);
    let gaps = curves.map(|c| if c.smallest() > 0.0 { c.smallest() } else { c.largest() });
    let least = gaps.filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { Some(least) } else { joint.friction.map(|f| f.gain.abs()).filter(|g| *g > 0.0) }
}
