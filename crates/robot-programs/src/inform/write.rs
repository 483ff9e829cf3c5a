//! Edits to patches.
//!
//! A position is changed in place where all moves that lead to it want the same. Else the first wish keeps the line (or, where
//! one move stays as it was, the line stays), and every other request gets its own line. New lines take the next free
//! numbers and stand after the last line of their kind, under the headers of the line that they were copied from: these are
//! repeated where others are in force there, as controllers do themselves, and those in force before are repeated after the new
//! lines where positions follow. A header cannot be taken back: a line that lacks one which is in force there is not copied. So no number
//! that stands anywhere changes its meaning, the numbers rise through the list, and `///NPOS` grows.

use super::read::ANGLE_DECIMALS;
use super::{Job, Kind, Meaning, Section, Statement, ends};
use crate::error::{Error, Result};
use crate::script::{EditRef, Edits, NewPoint, Patch, Patches, PathKind, StepKind, number};
use std::collections::BTreeMap;

/// Corner of each position level, m, as the factory sets it.
const LEVELS_M: [f64; 9] = [0.0, 0.0125, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5];
/// Smallest corner radius `CR=`, mm.
const LEAST_CR_MM: f64 = 1.0;

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
    section: Section,
    text: Vec<u8>,
    /// The line that it was copied from.
    model: usize,
}

/// Edited moves to a position variable whose moves want different values: no other number of a variable is this job's own.
pub(super) fn unwritable(job: &Job, edits: &Edits) -> Vec<(usize, String)> {
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
        let why =
            format!("position variable P{:03}: its moves need different values, and it has but one", position.number);
        found.extend(uses.into_iter().filter(|u| !u.1.0.is_empty()).map(|u| (u.0, why.clone())));
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
        }
    }

    fn refused(&self, step: usize, why: &str) -> Error {
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
                return Err(self.refused(k, &format!("no point can be added: {why}")));
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
        let Some(t) = self.target(step) else { return Ok(forms) };
        for (axis, (line, n)) in job.numbers[t].iter().enumerate() {
            let Some(&q) = q.get(axis) else { continue };
            let (line, n) = (line as usize, n as usize);
            let Some(target) = job.script.targets.get(t) else { continue };
            let Some(value) = target.values.get(axis) else { continue };
            if target.pose.is_some() {
                if let Some(text) = target.pose_number(axis, q, self.edits) {
                    of_line(&mut forms, line).insert(n, text);
                }
                continue;
            }
            let (written, decimals) = if job.positions[line].section.meaning == Meaning::Pulse {
                (q * job.pulses[axis].unwrap_or(0.0), 0)
            } else {
                let unit = job.unit[axis];
                let digit = self.edits.digit.get(axis).copied().unwrap_or(0.0) / unit;
                let most = value.style.decimals.max(ANGLE_DECIMALS);
                (q / unit, number::decimals_for(value.style, digit, most))
            };
            if !written.is_finite() || written.abs() >= f64::from(i32::MAX) {
                return Err(self.refused(step, &format!("axis {} would be {written}, which no job holds", axis + 1)));
            }
            let text = number::write(written, value.style, decimals);
            let own = job.script.texts[0].slice(value.span());
            if number::read(text.as_bytes()).map(|v| v.0) != number::read(own).map(|v| v.0) {
                of_line(&mut forms, line).insert(n, text);
            }
        }
        Ok(forms)
    }

    /// Every use of a line, with its step: by line, then in the order of the program.
    fn references(&self) -> Vec<(usize, usize)> {
        let mut all: Vec<(usize, usize)> = Vec::with_capacity(self.job.script.steps.len());
        for (step, statement) in self.job.statements.iter() {
            all.extend(statement.references.iter().map(|r| (r.position(), step)));
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
            let placed = self.wishes(references).and_then(|(line, uses)| self.place(line, &uses));
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
        let spans = &self.job.positions[line].numbers;
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
            let reference = self.statement(*step).and_then(|s| s.references.iter().find(|r| r.position() == line));
            if let Some(r) = reference {
                self.patches.push(Patch::new(0, r.span, name));
            }
        }
        Ok(())
    }

    /// A new line like `model` with other numbers; its name.
    fn add(&mut self, step: usize, model: usize, form: &Form) -> Result<String> {
        let job = self.job;
        let text = &job.script.texts[0];
        let position = &job.positions[model];
        if let Some(header) = self.ends.get(&position.kind).and_then(|end| position.section.lacks(end)) {
            let why = format!("no {header} before its position, which a new one after the others would get");
            return Err(self.refused(step, &why));
        }
        let of_kind = job.positions.iter().filter(|p| p.kind == position.kind);
        let next = self.next.entry(position.kind);
        let number = *next.and_modify(|n| *n += 1).or_insert_with(|| of_kind.map(|p| p.number).max().unwrap_or(0) + 1);
        let name = format!("{}{number:0w$}", position.kind.word(), w = position.digits);
        if name.len() > position.kind.word().len() + position.digits {
            return Err(self.refused(step, &format!("no number is left for a new {} position", position.kind.word())));
        }
        let line = text.line_span(position.line);
        let mut bytes = name.clone().into_bytes();
        let equals = text.slice(line.clone()).iter().position(|&b| b == b'=').unwrap_or(0);
        let mut at = line.start + equals;
        for (n, span) in position.numbers.iter().enumerate() {
            bytes.extend_from_slice(text.slice(at..span.start()));
            bytes.extend_from_slice(form.get(n).map_or(text.slice(*span), str::as_bytes));
            at = span.end();
        }
        self.new.push(NewLine { kind: position.kind, number, section: position.section, text: bytes, model });
        Ok(name)
    }

    /// The new moves before a step.
    fn points(&mut self, step: usize, edit: EditRef) -> Result<()> {
        let Some(statement) = self.statement(step) else { return Ok(()) };
        let text = &self.job.script.texts[0];
        for point in edit.before {
            let mut forms = self.forms(step, &point.q)?;
            let mut line = text.slice(statement.indent.start()..statement.word.end()).to_vec();
            for r in &statement.references {
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

    /// Speed and the like of a new point, with the finest corner that fits. Where the move gives no corner, neither does the new
    /// point: the controller's own choice holds for both.
    fn tags(&self, step: usize, statement: &Statement, point: &NewPoint) -> String {
        let mut out = String::new();
        // a copy of an exact stop stops, but a straight TCP move is not stopped on its way
        let kind = self.job.script.steps.get(step).map(|s| &s.kind);
        let straight = matches!(kind, Some(StepKind::Move(m)) if m.path == PathKind::Linear);
        let corner = |stops: bool| {
            if stops && !straight {
                "PL=0".into()
            } else if point.clearance_m >= LEVELS_M[1] {
                "PL=1".into()
            } else if straight && self.knows_radii() {
                radius("", point.clearance_m)
            } else {
                "PL=0".to_string()
            }
        };
        for tag in &statement.tags {
            let word = String::from_utf8_lossy(self.job.script.texts[0].slice(tag.span)).into_owned();
            out.push(' ');
            match tag.key {
                "PL" => out.push_str(&corner(level(&word) == Some(0))),
                "CR" => out.push_str(&radius(&word, point.clearance_m)),
                _ => out.push_str(&word),
            }
        }
        out
    }

    /// Corner radii are written on a controller only if the job has some: older ones do not know them.
    fn knows_radii(&self) -> bool {
        self.job.statements.values().flat_map(|s| &s.tags).any(|t| t.key == "CR")
    }

    /// Narrows the corner at a move's own goal. A move that gives none keeps none: no size may be chosen for it.
    fn blend(&mut self, step: usize, edit: EditRef) {
        let (Some(at_most), Some(statement)) = (edit.blend_at_most_m, self.statement(step)) else { return };
        let text = &self.job.script.texts[0];
        let fits = LEVELS_M.iter().rposition(|&r| r <= at_most).unwrap_or(0);
        let Some(tag) = statement.tags.iter().find(|t| t.key == "PL" || t.key == "CR") else { return };
        let word = String::from_utf8_lossy(text.slice(tag.span)).into_owned();
        // a size that is computed stays: any number in its place may be a wider corner
        if word.split_once('=').is_none_or(|w| w.1.parse::<f64>().is_err()) {
            return;
        }
        let new = match (tag.key, level(&word)) {
            ("CR", _) => radius(&word, at_most),
            (_, Some(own)) if own <= fits => word.clone(),
            _ => format!("PL={fits}"),
        };
        if new != word {
            self.patches.push(Patch::new(0, tag.span, new));
        }
    }

    /// New lines after the last of their kind, under the right headers.
    fn lines(&mut self) {
        let text = &self.job.script.texts[0];
        let mut by_kind: BTreeMap<Kind, Vec<&NewLine>> = BTreeMap::new();
        for line in &self.new {
            by_kind.entry(line.kind).or_default().push(line);
        }
        for (kind, mut lines) in by_kind {
            lines.sort_by_key(|l| l.number);
            let Some(last) = self.job.positions.iter().rfind(|p| p.kind == kind) else { continue };
            let at = text.line_span(last.line);
            let ending = text.ending(at.start);
            let mut bytes = Vec::new();
            let mut now = last.section;
            for line in &lines {
                let joints = matches!(line.section.meaning, Meaning::Pulse | Meaning::Angle);
                self.headers(&mut bytes, &mut now, line.section, !joints, ending);
                // what the model line has after its numbers is its own
                debug_assert_eq!(self.job.positions[line.model].kind, kind);
                bytes.extend_from_slice(&line.text);
                bytes.extend_from_slice(ending);
            }
            if self.job.positions.iter().any(|p| p.line > last.line) {
                self.headers(&mut bytes, &mut now, last.section, true, ending);
            }
            self.patches.push(Patch::new(0, at.end..at.end, bytes));
        }
    }

    /// Headers that lead from the section `now` to another; `pose`: also those that joint values do not need.
    fn headers(&self, bytes: &mut Vec<u8>, now: &mut Section, to: Section, pose: bool, ending: &[u8]) {
        let text = &self.job.script.texts[0];
        let words = |line: Option<u32>| line.map(|k| text.line(k as usize).trim_ascii());
        let mut say = |line: Option<u32>| {
            if let Some(k) = line {
                bytes.extend_from_slice(text.line(k as usize).trim_ascii());
                bytes.extend_from_slice(ending);
            }
        };
        let joints = matches!(to.meaning, Meaning::Pulse | Meaning::Angle);
        let postype = words(now.postype) != words(to.postype) || words(now.form) != words(to.form);
        if pose && words(now.user) != words(to.user) {
            say(to.user);
            now.user = to.user;
        }
        if words(now.tool) != words(to.tool) {
            say(to.tool);
            now.tool = to.tool;
        }
        if postype {
            say(to.postype);
            say(to.form);
            (now.meaning, now.postype, now.form) = (to.meaning, to.postype, to.form);
        }
        if pose && ((postype && !joints) || words(now.rconf) != words(to.rconf)) {
            say(to.rconf);
            now.rconf = to.rconf;
        }
    }

    fn counts(&mut self) {
        let text = &self.job.script.texts[0];
        for (k, (kind, _)) in super::KINDS.iter().enumerate() {
            let more = self.new.iter().filter(|l| l.kind == *kind).count();
            let Some(span) = self.job.counts.get(k).filter(|_| more > 0) else { continue };
            let own = String::from_utf8_lossy(text.slice(span.clone())).parse::<usize>().unwrap_or(0);
            self.patches.push(Patch::new(0, span.clone(), (own + more).to_string()));
        }
    }
}

/// `PL=2`.
fn level(word: &str) -> Option<usize> {
    word.split_once('=')?.1.parse().ok()
}

/// `CR=` no wider than `at_most_m`; an exact stop where that is less than the least.
fn radius(word: &str, at_most_m: f64) -> String {
    let own = word.split_once('=').and_then(|w| w.1.parse::<f64>().ok()).unwrap_or(f64::INFINITY);
    let fits = (at_most_m * 1e4).floor() * 0.1;
    if own <= fits {
        word.to_string()
    } else if fits < LEAST_CR_MM {
        "PL=0".into()
    } else {
        format!("CR={fits:.1}")
    }
}
