//! The words of a block that lead from one place to another, and how they are put into the text.

use super::lex::Word;
use super::statements::{Statement, canonical, most};
use super::write::{SAME, Writer, without_loss};
use crate::script::Patch;
use crate::script::number::{self, Own};

/// New words of a block, by axis.
pub(super) struct Leg {
    pub(super) words: Vec<Option<String>>,
    /// Where the axes stand after it.
    pub(super) to: Vec<Option<f64>>,
}

impl Writer<'_> {
    /// The words that lead from where the axes stand to `want`. `own`: those of the block itself.
    pub(super) fn leg(&mut self, s: &Statement, want: &[Option<f64>], own: bool) -> Leg {
        let dof = want.len();
        let mut leg = Leg { words: vec![None; dof], to: self.now.clone() };
        for a in 0..dof {
            let Some(want) = want[a] else { continue };
            let word = s.axis_word(a);
            let style = self.style(s, a);
            let most = most(self.kind(a), s.unit[a]).max(style.decimals);
            let digit = self.edits.digit.get(a).copied().unwrap_or(0.0) / self.program.si[a] / s.unit[a];
            let mut decimals = number::decimals_for(style, digit, most);
            let from = self.now[a];
            let base = if s.absolute {
                s.shift[a]
            } else {
                // what was changed more finely before must be taken back as finely
                decimals = decimals.max(self.decimals[a].min(most));
                from.unwrap_or(0.0)
            };
            let value = (want - base) / s.unit[a];
            // an axis that no edit moves loses no digit
            if s.goal[a].is_some_and(|g| (g - want).abs() <= SAME) {
                decimals = without_loss(value, s.unit[a], decimals);
            }
            // digits that stand there are added to, not written anew
            let there = word.and_then(|w| Some((self.text(w), w.value?)));
            let mut text = match there {
                Some((text, (value_there, _))) => {
                    let there = Own { text, value: value_there, style };
                    number::write_moved(there, value, style, decimals)
                }
                None => number::write(value, style, decimals),
            };
            let written = number::read(text.as_bytes()).map_or(value, |n| n.0);
            let half = 0.5 * number::last_digit(decimals);
            let stays = from.is_some_and(|f| {
                (f - want).abs() <= (half * s.unit[a]).min(SAME.max(0.5 * number::last_digit(most) * s.unit[a]))
            });
            match word {
                Some(w) if own => {
                    let before = w.value.map_or(0.0, |v| v.0);
                    if written == before && (before - value).abs() * s.unit[a] <= self.keep(s, a, want, before, base) {
                        text.clear();
                    }
                }
                // nor a word that leads where the axis stands
                None if stays || from.is_some_and(|f| (f - canonical(base + written * s.unit[a])).abs() <= SAME) => {
                    continue;
                }
                _ => {}
            }
            if !text.is_empty() {
                self.decimals[a] = if s.absolute { decimals } else { self.decimals[a].max(decimals) };
            } else if s.absolute {
                self.decimals[a] = 0;
            }
            leg.to[a] = Some(canonical(base + written * s.unit[a]));
            leg.words[a] = Some(text);
        }
        leg
    }

    /// Bytes of a word's number.
    pub(super) fn text(&self, word: &Word) -> &[u8] {
        self.program.script.texts.first().map(|t| t.slice(word.number())).unwrap_or_default()
    }

    /// How far a word that is kept may be from what is wanted: not at all where the goal is the old one.
    pub(super) fn keep(&self, s: &Statement, axis: usize, want: f64, before: f64, base: f64) -> f64 {
        let stands = base + before * s.unit[axis];
        let old = s.goal[axis].is_some_and(|g| (g - want).abs() <= SAME);
        if old && (stands - want).abs() > SAME { -1.0 } else { f64::INFINITY }
    }

    /// Puts changed numbers into the block, and words that it does not have after its axis words.
    pub(super) fn replace(&mut self, s: &Statement, words: Vec<Option<String>>) {
        let mut added = String::new();
        for (a, text) in words.into_iter().enumerate() {
            let Some(text) = text.filter(|t| !t.is_empty()) else { continue };
            match s.axis_word(a) {
                Some(w) => self.patches.push(Patch::new(0, w.number(), text)),
                None => added.push_str(&format!(" {}{text}", self.letter(s, a))),
            }
        }
        if !added.is_empty() {
            let at = self.behind_axes(s);
            self.patches.push(Patch::new(0, at..at, added));
        }
    }

    /// After the last axis word, else after the last G or N word, else before the first word.
    pub(super) fn behind_axes(&self, s: &Statement) -> usize {
        let axis = s.axis_words.iter().flatten().max().and_then(|&i| s.words.get(i as usize));
        let head = || s.words.iter().rev().find(|w| matches!(w.letter, b'G' | b'N'));
        axis.or_else(head).map_or_else(|| s.words.first().map_or(0, |w| w.span().start), |w| w.span().end)
    }

    /// Lower case where the block is.
    pub(super) fn cased(&self, s: &Statement, text: String) -> String {
        let first = s.words.first().and_then(|w| self.program.script.texts[0].bytes.get(w.span().start));
        if first.is_some_and(u8::is_ascii_lowercase) { text.to_ascii_lowercase() } else { text }
    }

    pub(super) fn letter(&self, s: &Statement, axis: usize) -> String {
        self.cased(s, (self.program.letters[axis] as char).to_string())
    }

    /// `G1` in the digits of the block's own word: `G01`.
    pub(super) fn motion(&self, s: &Statement, motion: u8) -> String {
        let own = s.motion_word.and_then(|i| s.words.get(i));
        if let Some(w) = own.filter(|_| motion == s.motion) {
            return String::from_utf8_lossy(self.program.script.texts[0].slice(w.span())).into_owned();
        }
        let two = own.is_some_and(|w| w.number().len() == 2);
        self.cased(s, if two { format!("G0{motion}") } else { format!("G{motion}") })
    }

    /// A new block before this one.
    pub(super) fn insert(&mut self, s: &Statement, leg: &Leg, motion: u8, centre: Option<String>) {
        let text = &self.program.script.texts[0];
        let line = text.line_span(s.line);
        let indent = text
            .slice(line.clone())
            .iter()
            .take_while(|b| b.is_ascii_whitespace() && **b != b'\n' && **b != b'\r')
            .count();
        let mut words: Vec<String> = Vec::new();
        let shown = |w: &Word| String::from_utf8_lossy(text.slice(w.span())).into_owned();
        words.extend(s.copied(b'G').map(shown));
        if centre.is_some() || s.arc.is_some() || s.motion_word.is_some() {
            words.push(self.motion(s, motion));
        }
        let axes =
            leg.words.iter().enumerate().filter_map(|(a, t)| Some(format!("{}{}", self.letter(s, a), t.as_ref()?)));
        words.extend(axes);
        words.extend(centre);
        words.extend(s.copied(b'F').map(shown));
        let mut bytes = text.slice(line.start..line.start + indent).to_vec();
        bytes.extend_from_slice(words.join(" ").as_bytes());
        bytes.extend_from_slice(text.ending(line.start));
        self.patches.push(Patch::new(0, line.start..line.start, bytes));
    }
}
