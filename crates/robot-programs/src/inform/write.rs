//! Edits to patches.
//!
//! A position is changed in place where all moves that lead to it want the same. Else the first wish keeps the line (or, where
//! one move stays as it was, the line stays), and every other request gets its own line. New lines take the next free
//! numbers and stand after the last line of their kind, under the headers of the line that they were copied from: these are
//! repeated where others are in force there, as controllers do themselves, and those in force before are repeated after the new
//! lines where positions follow. A header cannot be taken back: a line that lacks one which is in force there is not copied. So no number
//! that stands anywhere changes its meaning, the numbers rise through the list, and `///NPOS` grows.
//!
//! Files: `lines` the new lines of the list and of the instructions; `corners` corners beside new points.

mod corners;
mod lines;

use super::job::{ANGLE_DECIMALS, Job, Kind, Meaning, Numbers, Section, Statement, ends};
use super::reason::Reason;
use crate::error::{Error, Result};
use crate::script::number::{self, Own};
use crate::script::{self, EditRef, Edits, Patch, Patches, StepKind, Text, Value};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::Arc;

/// New texts of a line's numbers; what is not named stays.
#[derive(Debug, Clone, Default, PartialEq)]
struct Form(Vec<(usize, String)>);

impl Form {
    /// Sorted, as they are written.
    fn insert(&mut self, n: usize, text: String) {
        let at = self.0.partition_point(|f| f.0 < n);
        match self.0.get_mut(at).filter(|f| f.0 == n) {
            Some(place) => place.1 = text,
            None => self.0.insert(at, (n, text)),
        }
    }

    fn get(&self, n: usize) -> Option<&str> {
        self.0.iter().find(|f| f.0 == n).map(|f| f.1.as_str())
    }
}

/// Forms by line: few lines make a target.
type Forms = Vec<(usize, Form)>;

/// The form of a line, taken out.
fn take(forms: &mut Forms, line: usize) -> Form {
    forms.iter_mut().find(|f| f.0 == line).map(|f| std::mem::take(&mut f.1)).unwrap_or_default()
}

/// The form of a line, made where there is none.
fn of_line(forms: &mut Forms, line: usize) -> &mut Form {
    let k = forms.iter().position(|f| f.0 == line).unwrap_or_else(|| {
        forms.push((line, Form::default()));
        forms.len() - 1
    });
    &mut forms[k].1
}

pub(super) fn patches(job: &Job, edits: &Edits) -> Result<Patches> {
    let mut writer = Writer::new(job, edits);
    writer.check()?;
    writer.goals()?;
    for (step, edit) in edits.steps.iter() {
        writer.points(step, edit)?;
        writer.blend(step, edit);
    }
    writer.lines();
    writer.counts();
    Ok(writer.patches)
}

/// A new line of the list.
struct NewLine {
    kind: Kind,
    number: u32,
    section: Arc<Section>,
    text: Vec<u8>,
    /// The line that it was copied from.
    model: usize,
}

/// Edited moves to a position variable whose moves want different values: no other number of a variable is this job's own.
pub(super) fn unwritable(job: &Job, edits: &Edits) -> Vec<(usize, script::Reason)> {
    let writer = Writer::new(job, edits);
    let mut references = writer.references();
    references.retain(|r| job.positions[r.0].kind >= Kind::P);
    if references.is_empty() || writer.all_forms().is_err() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for of_line in references.chunk_by(|a, b| a.0 == b.0) {
        let Ok((line, uses)) = writer.wishes(of_line) else { continue };
        let position = &job.positions[line];
        let differ = job.pinned[line] || uses.windows(2).any(|w| w[0].1 != w[1].1);
        if !differ {
            continue;
        }
        let why = || Reason::VariableShared(position.number).into();
        found.extend(uses.into_iter().filter(|u| !u.1.0.is_empty()).map(|u| (u.0, why())));
    }
    found
}

struct Writer<'a> {
    job: &'a Job,
    edits: &'a Edits,
    /// Headers in force where new positions of each kind go.
    ends: BTreeMap<Kind, Section>,
    patches: Patches,
    new: Vec<NewLine>,
    next: BTreeMap<Kind, u32>,
    /// Where a number is put together.
    scratch: Vec<u8>,
}

impl<'a> Writer<'a> {
    fn new(job: &'a Job, edits: &'a Edits) -> Self {
        Self {
            job,
            edits,
            ends: ends(&job.positions),
            patches: Patches::with_capacity(edits.steps.likely_patches()),
            new: Vec::new(),
            next: BTreeMap::new(),
            scratch: Vec::new(),
        }
    }

    fn refused(&self, step: usize, why: impl Display) -> Error {
        let script = &self.job.script;
        let place = script.steps.get(step).map(|s| script.place(s.at).to_string()).unwrap_or_default();
        Error::Refused(format!("{place}: {why}; nothing was written"))
    }

    fn check(&self) -> Result<()> {
        for (k, edit) in self.edits.steps.iter() {
            let Some(StepKind::Move(m)) = self.job.script.steps.get(k).map(|s| &s.kind) else {
                return Err(self.refused(k, "no move stands there"));
            };
            if edit.as_joint_moves {
                return Err(self.refused(k, "a Cartesian INFORM move is not written as joint moves"));
            }
            if edit.goal.is_none() && edit.before.is_empty() {
                continue;
            }
            if let Some(why) = &m.fixed {
                return Err(self.refused(k, why));
            }
            if self.job.statements.get(k).is_none() {
                return Err(self.refused(k, "its target holds no numbers that can be written"));
            }
            if let (Some(why), false) = (&m.closed, edit.before.is_empty()) {
                return Err(self.refused(k, format!("no point can be added: {why}")));
            }
        }
        Ok(())
    }

    fn statement(&self, step: usize) -> Option<&'a Statement> {
        self.job.statements.get(step)
    }

    fn target(&self, step: usize) -> Option<usize> {
        match &self.job.script.steps.get(step)?.kind {
            StepKind::Move(m) => m.goal.target(),
            _ => None,
        }
    }

    /// Texts that joint values need in the lines of a step's target, by line.
    fn forms(&self, step: usize, q: &[f64]) -> Result<Forms> {
        let job = self.job;
        let mut forms = Forms::new();
        let (Some(t), Some(text)) = (self.target(step), job.script.texts.first()) else { return Ok(forms) };
        let mut scratch = Vec::new();
        for (axis, (line, n)) in job.numbers[t].iter().enumerate() {
            let Some(&q) = q.get(axis) else { continue };
            let (line, n) = (line as usize, n as usize);
            let Some(target) = job.script.targets.get(t) else { continue };
            let Some(value) = target.values.get(axis) else { continue };
            if target.pose.is_some() {
                if let Some(text) = target.pose_number(axis, q, self.edits, text) {
                    of_line(&mut forms, line).insert(n, text);
                }
                continue;
            }
            if self.changes(step, axis, (value, text), line, q, &mut scratch)? {
                of_line(&mut forms, line).insert(n, String::from_utf8_lossy(&scratch).into_owned());
            }
        }
        Ok(forms)
    }

    /// Whether a number of a line becomes another one for the joint value `q`: which, stands in `scratch` then.
    fn changes(
        &self,
        step: usize,
        axis: usize,
        (value, text): (Value, &Text),
        line: usize,
        q: f64,
        scratch: &mut Vec<u8>,
    ) -> Result<bool> {
        let job = self.job;
        let own = |was: f64| Own { text: text.slice(value.span()), value: was, style: value.style };
        let (own, written, decimals) = if job.positions[line].section.meaning == Meaning::Pulse {
            let pulses = job.pulses[axis].unwrap_or(0.0);
            (own(value.si * pulses), q * pulses, 0)
        } else {
            let unit = job.unit[axis];
            let digit = self.edits.digit.get(axis).copied().unwrap_or(0.0) / unit;
            let most = value.style.decimals.max(ANGLE_DECIMALS);
            (own(value.si / unit), q / unit, number::decimals_for(value.style, digit, most))
        };
        if !written.is_finite() || written.abs() >= f64::from(i32::MAX) {
            return Err(self.refused(step, format!("axis {} would be {written}, which no job holds", axis + 1)));
        }
        scratch.clear();
        number::append_moved(scratch, own, written, value.style, decimals);
        Ok(number::read(scratch).map(|v| v.0) != number::read(own.text).map(|v| v.0))
    }

    /// Writes the goal of a move that alone leads to a line and names no other, where the numbers stand; `false`: it is no such move.
    fn alone(&mut self, line: usize, step: usize) -> Result<bool> {
        let job = self.job;
        let free = job.positions[line].kind < Kind::P && !job.pinned[line];
        let one = self.statement(step).is_some_and(|s| job.parts.references(s).len() == 1);
        let Some(t) = self.target(step).filter(|_| free && one) else { return Ok(false) };
        let in_order = matches!(job.numbers.get(t), Some(Numbers::Line(of, _)) if *of as usize == line);
        let (Some(target), Some(text)) = (job.script.targets.get(t), job.script.texts.first()) else {
            return Ok(false);
        };
        if !in_order || target.pose.is_some() {
            return Ok(false);
        }
        let Some(goal) = self.edits.steps.get(step).and_then(|e| e.goal) else { return Ok(true) };
        let mut scratch = std::mem::take(&mut self.scratch);
        for (axis, (value, q)) in target.values.iter().zip(goal).enumerate() {
            let Some(value) = value else { continue };
            if self.changes(step, axis, (value, text), line, *q, &mut scratch)? {
                self.patches.put(0, value.span(), &scratch);
            }
        }
        self.scratch = scratch;
        Ok(true)
    }

    /// Every use of a line, with its step: by line, then in the order of the program.
    fn references(&self) -> Vec<(usize, usize)> {
        let mut all: Vec<(usize, usize)> = Vec::with_capacity(self.job.script.steps.len());
        for (step, statement) in self.job.statements.iter() {
            all.extend(self.job.parts.references(statement).iter().map(|r| (r.position(), step)));
        }
        all.sort_by_key(|r| r.0);
        all
    }

    /// The first form, in the order of the program, that no job holds.
    fn all_forms(&self) -> Result<()> {
        let goals = self.edits.steps.iter().filter(|e| self.statement(e.0).is_some());
        goals.filter_map(|(step, e)| Some((step, e.goal?))).try_for_each(|(step, q)| self.forms(step, q).map(drop))
    }

    /// What the uses of one line want there.
    fn wishes(&self, references: &[(usize, usize)]) -> Result<(usize, Forms)> {
        let line = references.first().map_or(0, |r| r.0);
        let mut forms = Forms::new();
        let mut last = None;
        let mut uses = Forms::with_capacity(references.len());
        for &(line, step) in references {
            // what a statement wants of a line it wants of its first word for it
            if last != Some(step) {
                let goal = self.edits.steps.get(step).and_then(|e| e.goal);
                forms = goal.map(|q| self.forms(step, q)).transpose()?.unwrap_or_default();
                last = Some(step);
            }
            uses.push((step, take(&mut forms, line)));
        }
        Ok((line, uses))
    }

    /// In place, or a separate line for each request.
    fn goals(&mut self) -> Result<()> {
        for references in self.references().chunk_by(|a, b| a.0 == b.0) {
            let alone = match references {
                [(line, step)] => self.alone(*line, *step),
                _ => Ok(false),
            };
            let placed = alone.and_then(|done| match done {
                true => Ok(()),
                false => self.wishes(references).and_then(|(line, uses)| self.place(line, &uses)),
            });
            if let Err(other) = placed {
                // a number that no job holds comes first
                return self.all_forms().and(Err(other));
            }
        }
        Ok(())
    }

    fn place(&mut self, line: usize, uses: &[(usize, Form)]) -> Result<()> {
        let stays = self.job.pinned[line] || uses.iter().any(|u| u.1.0.is_empty());
        let none = Form::default();
        let kept = if stays { &none } else { uses.first().map_or(&none, |u| &u.1) };
        let spans = self.job.positions.numbers(line);
        let numbers = kept.0.iter().filter_map(|(n, new)| Some((*spans.get(*n)?, new)));
        self.patches.extend(numbers.map(|(span, new)| Patch::new(0, span, new.as_str())));
        let mut clones: Vec<(&Form, String)> = Vec::new();
        for (step, form) in uses.iter().filter(|u| u.1 != *kept) {
            if self.job.positions[line].kind >= Kind::P {
                return Err(self.refused(*step, "a position variable has but one value"));
            }
            let known = clones.iter().find(|c| c.0 == form).map(|c| c.1.clone());
            let name = match known {
                Some(name) => name,
                None => {
                    let name = self.add(*step, line, form)?;
                    clones.push((form, name.clone()));
                    name
                }
            };
            let reference = self.statement(*step).map(|s| self.job.parts.references(s));
            let reference = reference.and_then(|all| all.iter().find(|r| r.position() == line));
            if let Some(r) = reference {
                self.patches.push(Patch::new(0, r.span, name));
            }
        }
        Ok(())
    }

    /// The new moves before a step.
    fn points(&mut self, step: usize, edit: EditRef) -> Result<()> {
        let Some(statement) = self.statement(step) else { return Ok(()) };
        let text = &self.job.script.texts[0];
        for point in edit.before {
            let mut forms = self.forms(step, &point.q)?;
            let mut line = text.slice(statement.indent.start()..statement.word.end()).to_vec();
            for r in self.job.parts.references(statement) {
                let form = take(&mut forms, r.position());
                let name = self.add(step, r.position(), &form)?;
                line.push(b' ');
                line.extend_from_slice(name.as_bytes());
            }
            line.extend_from_slice(self.tags(step, statement, point).as_bytes());
            line.extend_from_slice(text.ending(statement.word.start()));
            let at = statement.indent.start();
            self.patches.push(Patch::new(0, at..at, line));
        }
        Ok(())
    }
}
