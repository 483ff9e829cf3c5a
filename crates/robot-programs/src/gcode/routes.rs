//! What the reader finds of the order of blocks: lines that steer it ([`order`](super::order)), programs and their calls, and the modes
//! that a subprogram of the text leaves.
//!
//! Modes of words (G90 and G91, G20 and G21, the plane) that one place of the text alone sets are known everywhere. Of others those after a
//! call are what the subprogram sets last, or what was on before if it sets none; at its start those on which all of its calls agree.

use super::assignments::Assignments;
use super::lex::{self, Block, Word};
use super::order::{Around, Entry, Line};
use super::programs::{Effect, Modes};
use super::read::Reader;
use super::survey::Survey;
use std::collections::BTreeMap;

/// Words that compare two values.
const COMPARES: [&str; 6] = ["EQ", "NE", "GT", "GE", "LT", "LE"];
impl Survey {
    /// Nothing jumps, every line is followed, and the numbers of an axis count from one origin all along.
    pub(super) fn goes_by_its_text(&self) -> bool {
        !self.jumps && self.labels.is_empty() && !self.hidden && self.macros == 0 && !self.frames()
    }

    /// What the order of the blocks depends on.
    pub(super) fn around(&self) -> Around<'_> {
        let calls = self.whole.then(|| self.programs.call_count());
        Around { called: &self.called, repeats: self.repeats, by_text: self.goes_by_its_text(), calls }
    }

    /// The only work frame that the text names is this one, or it names none.
    fn has_frame(&self, frame: Option<u32>) -> bool {
        self.codes.range(540..600).all(|c| Some(*c) == frame.or(Some(540)))
    }

    /// The same, and all that is called stands in the text.
    fn calls_its_text(&self) -> bool {
        self.whole && !self.siemens && !self.lathe && self.goes_by_its_text()
    }
}

impl Reader<'_> {
    /// How a line steers the order of blocks, as far as that can be said before it runs; `None`: it does not, or a program is meant.
    ///
    /// `line = "WHILE" condition "DO" number | "DO" number | "END" number | "IF" condition "THEN" "#" ... | "O" label word [condition]`,
    /// `word = "IF" | "ELSEIF" | "ELSE" | "ENDIF" | "WHILE" | "ENDWHILE" | "DO" | "REPEAT" | "ENDREPEAT"`
    pub(super) fn line_of_flow(&self, k: usize, block: &Block) -> Option<Line> {
        let line = || Assignments::compact(self.text.line(k));
        if let Some(flow) = block.flow.as_deref() {
            return self.line_of_label(flow, block, &line());
        }
        let keyword = block.keyword.as_deref()?;
        let line = line();
        let rest = after(&line, keyword);
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            digits.then(|| format!("do{text}"))
        };
        let end = lex::expression_end(rest.as_bytes()).filter(|end| rest.is_char_boundary(*end)).unwrap_or(0);
        let (condition, then) = rest.split_at(end);
        Some(match keyword {
            "WHILE" => {
                let label = then.strip_prefix("DO").and_then(number);
                label.map_or(Line::Away, |label| Line::Loop { label, entered: self.holds(condition) })
            }
            "DO" => number(rest).map_or(Line::Away, |label| Line::Loop { label, entered: true }),
            "END" => number(rest).map_or(Line::Away, |label| Line::EndLoop { label }),
            "IF" if then.starts_with("THEN#") => Line::GoesOn,
            "IF" | "THEN" => Line::Away,
            w if w.contains("GOTO") => Line::Away,
            _ => return None,
        })
    }

    /// `line = "O" label ("IF" | "ELSEIF" | "ELSE" | "ENDIF" | "WHILE" | "ENDWHILE" | "DO" | "REPEAT" | "ENDREPEAT") [condition]`
    fn line_of_label(&self, flow: &str, block: &Block, line: &str) -> Option<Line> {
        let label = block.label.clone();
        let condition = after(line, flow);
        let count = || self.variables.fold(condition.as_bytes()).map_or(0.0, |v| v.0);
        Some(match flow {
            "" | "SUB" | "ENDSUB" | "CALL" => return None,
            _ if label.contains(['#', '[']) => Line::Away,
            "WHILE" => Line::Loop { entered: self.holds(condition), label },
            "REPEAT" => Line::Loop { entered: count() >= 1.0, label },
            "DO" => Line::Do { label },
            "ENDWHILE" | "ENDREPEAT" => Line::EndLoop { label },
            "IF" => Line::If { label },
            "ELSEIF" | "ELSE" => Line::Else { label, whole: flow == "ELSE" },
            "ENDIF" => Line::EndIf { label },
            _ => Line::Away,
        })
    }

    /// Whether a condition of known numbers holds.
    ///
    /// `condition = "[" expression ("EQ" | "NE" | "GT" | "GE" | "LT" | "LE") expression "]"`
    fn holds(&self, condition: &str) -> bool {
        let inner = condition.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or_default();
        let found = COMPARES.iter().find_map(|word| Some((*word, inner.split_once(word)?)));
        let Some((word, (left, right))) = found else { return false };
        let value = |side: &str| self.variables.fold(format!("[{side}]").as_bytes()).map(|v| v.0);
        let (Some(left), Some(right)) = (value(left), value(right)) else { return false };
        match word {
            "EQ" => left == right,
            "NE" => left != right,
            "GT" => left > right,
            "GE" => left >= right,
            "LT" => left < right,
            _ => left <= right,
        }
    }

    /// Takes a line that steers the order of blocks, after its step.
    pub(super) fn route(&mut self, block: &Block, line: Option<Line>) {
        if block.optional {
            self.order.is_unknown();
        }
        if let (Some(line), Some(at)) = (line, self.script.steps.len().checked_sub(1)) {
            self.keeps_frame();
            self.order.line(line, at, &self.script);
        }
    }

    /// A line from which control may go elsewhere: a work frame that is named after it would be another one on the way back there. In a
    /// definition it is that of its calls.
    fn keeps_frame(&mut self) {
        if !self.order.is_in_definition() && !self.survey.has_frame(self.frame) {
            self.order.is_unknown();
        }
    }

    /// A block that an operator may switch off.
    pub(super) fn route_optional(&mut self, block: &Block) {
        let steers = |w: &Word| w.letter == b'M' && w.value.is_none_or(|v| [2.0, 30.0, 98.0, 99.0].contains(&v.0));
        if block.words.iter().any(steers) {
            self.order.is_unknown();
        }
    }

    /// The end of a block with M99 (`returns`).
    pub(super) fn route_return(&mut self, returns: bool) {
        if let Some(at) = self.script.steps.len().checked_sub(1).filter(|_| returns) {
            self.order.returns(at);
        }
    }

    /// Takes `%`, after its step.
    pub(super) fn route_tape(&mut self) {
        if let Some(at) = self.script.steps.len().checked_sub(1) {
            self.order.tape(at, &self.survey.called, &self.script);
        }
    }

    /// Takes the number of a program, a definition or its end, after its step.
    ///
    /// `program = "O" number | "O" label ("SUB" | "ENDSUB")`
    pub(super) fn route_program(&mut self, block: &Block, before: (Modes, Option<u32>)) {
        let Some(at) = self.script.steps.len().checked_sub(1) else { return };
        match block.flow.as_deref() {
            Some("") => self.order.program(&block.label, at, &self.survey.called, &self.script),
            Some("SUB") => {
                self.order.sub(&block.label, at, &self.script);
                self.around = Some(before);
            }
            Some("ENDSUB") => {
                self.order.end_sub(&block.label, at);
                if let Some((modes, frame)) = self.around.take().filter(|_| self.survey.goes_by_its_text()) {
                    // the program around the definition has not run it
                    (self.absolute, self.inch, self.plane) = modes;
                    self.frame = frame;
                }
                return;
            }
            _ => return self.order.is_unknown(),
        }
        if !self.survey.calls_its_text() {
            return;
        }
        let count = self.survey.programs.calls.get(&block.label).copied().unwrap_or_default();
        let all =
            |calls: &'_ BTreeMap<String, Vec<Modes>>| calls.get(&block.label).filter(|c| c.len() == count).cloned();
        let above = all(&self.called_in);
        self.precedes_calls |= above.is_none() && count > 0;
        let calls = above.or_else(|| all(&self.foreseen)).unwrap_or_default();
        if let Some(first) = calls.first().filter(|first| calls.iter().all(|modes| modes == *first)) {
            (self.absolute, self.inch, self.plane) = *first;
        }
    }

    /// The modes of words, before a step that may end what is known of them.
    pub(super) fn modes_before(&self) -> Modes {
        (self.absolute, self.inch, self.plane)
    }

    /// Takes a call of a program of the text, after its step; `before`: the modes before it.
    ///
    /// `plane = "G17" | "G18" | "G19"`
    pub(super) fn route_call(&mut self, entry: &Entry, before: Modes) {
        let Some(at) = self.script.steps.len().checked_sub(1) else { return };
        self.keeps_frame();
        self.order.called(at, entry);
        // of a second run the modes at the start are those at the end of the first
        let at_start = if entry.certain && entry.once { before } else { Modes::default() };
        self.called_in.entry(entry.name.clone()).or_default().push(at_start);
        let effects = self.survey.programs.effects.get(&entry.name);
        let Some([distance, unit, plane]) = effects.copied().filter(|_| entry.certain) else { return };
        if !self.survey.calls_its_text() {
            return;
        }
        self.absolute = of(distance, before.0, self.absolute, |c| c == 900);
        self.inch = of(unit, before.1, self.inch, |c| c == 200);
        self.plane = of(plane, before.2, self.plane, |c| match c {
            170 => [b'X', b'Y', b'Z'],
            180 => [b'Z', b'X', b'Y'],
            _ => [b'Y', b'Z', b'X'],
        });
    }
}

/// A mode after a call: as it was before, by the last word in the subprogram, or as it is known otherwise.
fn of<T>(effect: Effect, before: Option<T>, otherwise: Option<T>, sets: impl Fn(u32) -> T) -> Option<T> {
    match effect {
        Effect::Keeps => before,
        Effect::Sets(c) => Some(sets(c)),
        Effect::Unsure => otherwise,
    }
}

/// What stands after a word in a line in capitals without blanks.
fn after<'a>(line: &'a str, word: &str) -> &'a str {
    line.find(word).and_then(|at| line.get(at + word.len()..)).unwrap_or_default()
}
