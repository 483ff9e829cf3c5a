//! File names as text: what a message, a page or a JSON document shows, and back to the very bytes.
//!
//! A name is bytes on Unix; a text is not. Three things are escaped, and nothing else: the backslash itself (`\\`), bytes that are
//! not UTF-8 (`\xE4`), and characters that a terminal or a page obeys instead of showing (control characters `\x1B`, `\n`, `\r`,
//! `\t`; line separators and marks that turn the direction of the text, `\u{202E}`). So two names never share a text, and
//! [`path_of`] gives back the name. On Windows the backslash separates folders and stays as it is.

use robot_programs::error::is_obeyed;
use std::ffi::{OsStr, OsString};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A path as text.
pub fn text_of(path: &Path) -> String {
    text_of_name(path.as_os_str())
}

/// A name as text.
pub fn text_of_name(name: &OsStr) -> String {
    let bytes = name.as_encoded_bytes();
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                '\\' if cfg!(not(windows)) => out.push_str("\\\\"),
                '\n' => out.push_str("\\n"),
                '\r' => out.push_str("\\r"),
                '\t' => out.push_str("\\t"),
                c if c.is_ascii_control() => {
                    let _ = write!(out, "\\x{:02X}", u32::from(c));
                }
                c if is_obeyed(c) => {
                    let _ = write!(out, "\\u{{{:X}}}", u32::from(c));
                }
                c => out.push(c),
            }
        }
        for b in chunk.invalid() {
            let _ = write!(out, "\\x{b:02X}");
        }
    }
    out
}

/// The path of a text that [`text_of`] made; `None`: it made none such.
#[cfg(unix)]
pub fn path_of(text: &str) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        if c != '\\' {
            out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
            continue;
        }
        match rest.next()? {
            '\\' => out.push(b'\\'),
            'n' => out.push(b'\n'),
            'r' => out.push(b'\r'),
            't' => out.push(b'\t'),
            'x' => {
                let high = rest.next()?.to_digit(16)?;
                let low = rest.next()?.to_digit(16)?;
                out.push(u8::try_from(16 * high + low).ok()?);
            }
            'u' => {
                let (inside, after) = rest.as_str().strip_prefix('{')?.split_once('}')?;
                let c = char::from_u32(u32::from_str_radix(inside, 16).ok()?)?;
                out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
                rest = after.chars();
            }
            _ => return None,
        }
    }
    Some(PathBuf::from(OsString::from_vec(out)))
}

/// The path of a text that [`text_of`] made.
#[cfg(not(unix))]
pub fn path_of(text: &str) -> Option<PathBuf> {
    Some(PathBuf::from(OsString::from(text)))
}

/// A text on its way to a terminal: what is obeyed instead of shown is escaped, but for the line's end and the tab.
pub fn printable(text: &str) -> std::borrow::Cow<'_, str> {
    let plain = |c: char| matches!(c, '\n' | '\t') || !is_obeyed(c);
    if text.chars().all(plain) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if plain(c) {
            out.push(c);
        } else {
            let _ = write!(out, "\\u{{{:X}}}", u32::from(c));
        }
    }
    out.into()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::os::unix::ffi::{OsStrExt, OsStringExt};

    #[test]
    fn names_that_differ_in_bytes_that_are_no_text_differ_as_text() {
        let name = |bytes: &[u8]| text_of(Path::new(OsStr::from_bytes(bytes)));
        assert_eq!(name(b"L\xe4ngs.csv"), "L\\xE4ngs.csv");
        assert_ne!(name(b"L\xe4ngs.csv"), name(b"L\xf6ngs.csv"));
        assert_ne!(name(b"L\xe4ngs.csv"), name(b"L\\xE4ngs.csv"), "nor is it one that is spelt so");
        assert_eq!(name("Länge.csv".as_bytes()), "Länge.csv");
    }

    #[test]
    fn what_a_terminal_obeys_is_escaped() {
        let text = text_of(Path::new("a\u{1b}[31m\n\u{202e}b\u{85}.csv"));
        assert_eq!(text, "a\\x1B[31m\\n\\u{202E}b\\u{85}.csv");
        assert_eq!(printable("a\u{1b}[0m\n\tb"), "a\\u{1B}[0m\n\tb");
    }

    proptest! {
        #[test]
        fn every_name_comes_back(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let path = PathBuf::from(OsString::from_vec(bytes));
            let text = text_of(&path);
            prop_assert!(!text.chars().any(is_obeyed));
            prop_assert_eq!(path_of(&text), Some(path));
        }
    }
}
