//! How a block calls, and what.

use super::labels::{is_code, is_conditional_call, local_labels, whole};
use super::lex::Block;

/// How a block calls, and what: numbers that are not computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Called {
    /// `M97 P100`, `M98 H100`: a part of the text.
    Block,
    /// `M98 P1000`, of the memory of the control.
    Subprogram(Option<u32>),
    /// `G65 P1000`, with arguments.
    Macro(Option<u32>),
    /// `M198 P1000`, of a folder of the control, which may hold another one of the same number.
    OfFolder(Option<u32>),
    /// `L1000`.
    Numbered(Option<u32>),
}

/// The call of a block.
///
/// `call = "M98" ("P" | "H" | "Q") number | ("M198" | "G65" | "G66" | "G66.1") "P" number | "L" number | ("M96" | "M97") "P" number`
pub(super) fn called_by(block: &Block) -> Option<Called> {
    let has = |letter: u8, numbers: &[f64]| block.words.iter().any(|w| is_code(w, letter, numbers));
    let number = |letter: u8| block.words.iter().find(|w| w.letter == letter).and_then(whole);
    let named = block.words.iter().any(|w| w.letter == b'P');
    // `M98 P9100 Q5` begins at a block of that program
    if has(b'M', &[97.0]) || is_conditional_call(block) || !named && local_labels(block).next().is_some() {
        return Some(Called::Block);
    }
    if is_numbered_call(block) {
        return Some(Called::Numbered(number(b'L')));
    }
    if has(b'M', &[198.0]) {
        return Some(Called::OfFolder(number(b'P')));
    }
    if has(b'G', &[65.0, 66.0, 66.1]) {
        return Some(Called::Macro(number(b'P')));
    }
    has(b'M', &[98.0]).then(|| Called::Subprogram(number(b'P')))
}

impl Called {
    /// The number of a subprogram that is certainly the one of this number in the text, if it has one: `P31000` calls O1000 three times on
    /// some controls.
    pub(super) fn in_text(self) -> Option<u32> {
        match self {
            Self::Subprogram(number) => number.filter(|n| (1..10_000).contains(n)),
            _ => None,
        }
    }
}

/// Whether a block does nothing but call a subprogram by its number, as Siemens controls do.
///
/// `call = ["N" number] "L" number ["P" number]`
pub(super) fn is_numbered_call(block: &Block) -> bool {
    let called = block.words.iter().any(|w| w.letter == b'L' && w.value.is_some());
    called && block.words.iter().all(|w| b"NLP".contains(&w.letter))
}
