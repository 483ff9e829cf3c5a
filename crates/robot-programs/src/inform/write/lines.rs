//! New lines of the list, after the last of their kind and under the right headers, and its counts.

use super::{Form, NewLine, Writer};
use crate::error::Result;
use crate::inform::job::{KINDS, Kind, Meaning, Section};
use crate::script::Patch;
use std::collections::BTreeMap;

impl Writer<'_> {
    /// A new line like `model` with other numbers; its name.
    pub(super) fn add(&mut self, step: usize, model: usize, form: &Form) -> Result<String> {
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
        let digits = usize::from(position.digits);
        let name = format!("{}{number:0digits$}", position.kind.word());
        if name.len() > position.kind.word().len() + digits {
            return Err(self.refused(step, format!("no number is left for a new {} position", position.kind.word())));
        }
        let line = text.line_span(position.line());
        let mut bytes = name.clone().into_bytes();
        let equals = text.slice(line.clone()).iter().position(|&b| b == b'=').unwrap_or(0);
        let start = line.start + equals;
        let numbers = job.positions.numbers(model);
        let end = numbers.last().map_or(start, |span| span.end());
        let changed = numbers.iter().enumerate().filter_map(|(n, span)| Some((span.range(), form.get(n)?)));
        bytes.extend(text.substituted(start..end, changed));
        self.new.push(NewLine { kind: position.kind, number, section: position.section.clone(), text: bytes, model });
        Ok(name)
    }

    /// New lines after the last of their kind, under the right headers.
    pub(super) fn lines(&mut self) {
        let text = &self.job.script.texts[0];
        let mut by_kind: BTreeMap<Kind, Vec<&NewLine>> = BTreeMap::new();
        for line in &self.new {
            by_kind.entry(line.kind).or_default().push(line);
        }
        for (kind, mut lines) in by_kind {
            lines.sort_by_key(|l| l.number);
            let Some(last) = self.job.positions.iter().rfind(|p| p.kind == kind) else { continue };
            let at = text.line_span(last.line());
            let ending = text.ending(at.start);
            let mut bytes = Vec::new();
            let mut now = *last.section;
            for line in &lines {
                let joints = matches!(line.section.meaning, Meaning::Pulse | Meaning::Angle);
                self.headers(&mut bytes, &mut now, *line.section, !joints, ending);
                // what the model line has after its numbers is its own
                debug_assert_eq!(self.job.positions[line.model].kind, kind);
                bytes.extend_from_slice(&line.text);
                bytes.extend_from_slice(ending);
            }
            if self.job.positions.iter().any(|p| p.line > last.line) {
                self.headers(&mut bytes, &mut now, *last.section, true, ending);
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

    pub(super) fn counts(&mut self) {
        let text = &self.job.script.texts[0];
        for (k, (kind, _)) in KINDS.iter().enumerate() {
            let more = self.new.iter().filter(|l| l.kind == *kind).count();
            let Some(span) = self.job.counts.get(k).filter(|_| more > 0) else { continue };
            let own = String::from_utf8_lossy(text.slice(span.clone())).parse::<usize>().unwrap_or(0);
            self.patches.push(Patch::new(0, span.clone(), (own + more).to_string()));
        }
    }
}
