//! A look over the whole text before it is read: which codes there are, how numbers are written, what may be jumped to.

use super::lex;
use crate::error::Result;
use crate::program::script::Text;
use std::collections::BTreeSet;

/// Letters of axes.
pub(super) const AXES: &[u8] = b"XYZABCUVW";
/// What a look over the whole text tells.
#[derive(Default)]
pub(super) struct Survey {
    /// All G words, times ten.
    pub(super) codes: BTreeSet<u32>,
    /// Numbers with a point and nothing behind it: a control on which `X10` may be 10 increments.
    pub(super) points: bool,
    /// Numbers other than 0 without a point.
    pub(super) bare: bool,
    /// Line numbers may be jumped to.
    pub(super) jumps: bool,
    /// Firmware of a printer: it heats, or counts filament.
    pub(super) printer: bool,
}

impl Survey {
    pub(super) fn of(text: &Text) -> Result<Self> {
        let mut survey = Self::default();
        let (mut extrudes, mut counts) = (false, false);
        for k in 0..text.line_count() {
            let block = lex::block(text, k)?;
            survey.jumps |=
                block.keyword.is_some() && text.line(k).to_ascii_uppercase().windows(4).any(|w| w == b"GOTO");
            let has = |l: u8| block.words.iter().any(|w| w.letter == l);
            extrudes |= has(b'E');
            for w in &block.words {
                let Some((v, style)) = w.value else { continue };
                survey.points |=
                    style.point && style.decimals == 0 && (AXES.contains(&w.letter) || b"IJKR".contains(&w.letter));
                survey.bare |= !style.point && v != 0.0 && (AXES.contains(&w.letter) || b"IJKR".contains(&w.letter));
                survey.jumps |= w.letter == b'M' && v == 99.0 && block.words.iter().any(|w| w.letter == b'P');
                let m = if w.letter == b'M' { v } else { -1.0 };
                counts |= m == 82.0 || m == 83.0;
                survey.printer |= [104.0, 109.0, 140.0, 190.0].contains(&m) && (has(b'S') || has(b'R'));
                if w.letter == b'G' {
                    survey.codes.insert(code(v));
                }
            }
        }
        survey.printer |= extrudes && counts;
        Ok(survey)
    }

    /// At most one of these codes is in the text.
    pub(super) fn single(&self, codes: &[u32]) -> bool {
        codes.iter().filter(|c| self.codes.contains(c)).count() <= 1
    }

    pub(super) fn frames(&self) -> bool {
        let many = self.codes.range(540..600).count() + usize::from(self.codes.contains(&541));
        many > 1 || [520, 920, 921, 922, 923, 100].iter().any(|c| self.codes.contains(c))
    }
}

/// A G word times ten; what is no such word becomes one that nobody knows.
pub(super) fn code(v: f64) -> u32 {
    let tenths = (v * 10.0).round();
    if (v * 10.0 - tenths).abs() < 1e-6 && (0.0..99_990.0).contains(&tenths) { tenths as u32 } else { 99_999 }
}

pub(super) fn code_text(code: u32) -> String {
    if code.is_multiple_of(10) { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}
