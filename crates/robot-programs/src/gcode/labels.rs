//! Blocks of a text that others call or jump to by their number: `M97 P100` and `M96 P100` (Haas), `M98 H100` and `M98 Q100` (Fanuc).

use super::lex::{Block, Word};

/// Whether a word is one of these.
pub(super) fn is_code(w: &Word, letter: u8, numbers: &[f64]) -> bool {
    w.letter == letter && w.value.is_some_and(|v| numbers.contains(&v.0))
}

/// A whole number that is not negative.
pub(super) fn whole(w: &Word) -> Option<u32> {
    let (v, _) = w.value?;
    (v.fract() == 0.0 && (0.0..1e9).contains(&v)).then_some(v as u32)
}

/// Numbers of blocks of the text that a block jumps to or calls; `None`: a computed one.
///
/// `call = ("M96" | "M97") "P" number | "M98" ("H" | "Q") number`
pub(super) fn local_labels(block: &Block) -> impl Iterator<Item = Option<u32>> {
    let has = |numbers: &[f64]| block.words.iter().any(|w| is_code(w, b'M', numbers));
    let letters: &[u8] = match () {
        () if has(&[96.0, 97.0]) => b"P",
        () if has(&[98.0]) => b"HQ",
        () => b"",
    };
    block.words.iter().filter(|w| letters.contains(&w.letter)).map(whole)
}

/// `M96 P10` jumps, or calls at any time.
pub(super) fn is_conditional_call(block: &Block) -> bool {
    block.words.iter().any(|w| is_code(w, b'M', &[96.0])) && block.words.iter().any(|w| w.letter == b'P')
}
