//! Where a data list ends: at its first `ENDDAT`. What stands behind that in the file is no part of the list.

use super::lex::{begins_with, first_word};
use crate::script::{At, Note, Text};

/// The line of `ENDDAT`, from 0.
pub(super) fn end_of_list(text: &Text) -> Option<usize> {
    (0..text.line_count()).find(|k| begins_with(text, *k, b"E") && first_word(text, *k).eq_ignore_ascii_case(b"ENDDAT"))
}

/// Reports where something besides blanks and comments stands after the end of the program's own lists.
pub(super) fn notes(texts: &[Text]) -> impl Iterator<Item = Note> {
    let own = texts.iter().enumerate().skip(1).filter(|(_, text)| !text.context);
    own.filter_map(|(file, text)| {
        let says = |k: &usize| !matches!(text.line(*k).trim_ascii_start().first(), None | Some(b';'));
        let k = (end_of_list(text)? + 1..text.line_count()).find(says)?;
        let text = "what stands after ENDDAT is no part of the data list: it is not read".to_string();
        Some(Note { place: At { file, line: k as u64 + 1 }, text })
    })
}
