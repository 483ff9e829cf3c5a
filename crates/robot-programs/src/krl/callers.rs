//! Whether another program of the folder calls a KRL program.

use super::outside;
use crate::files::{Folders, of_folder};
use crate::script::Text;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most files of a folder that is looked through.
const MOST_BESIDE: usize = 10_000;

/// Whether another program of the folder calls the first routine of the one at `path`. What a project has elsewhere is its context.
pub(super) fn is_called(path: &Path, own: &Text, seen: &Folders) -> bool {
    let is_program =
        |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("src") || e.eq_ignore_ascii_case("sub"));
    let programs = |folder: &Path| of_folder(folder, MOST_BESIDE).into_iter().filter(is_program).collect();
    outside::first_routine(own).is_some_and(|name| seen.calls(("krl", path), &[name], programs, callees))
}

/// Names before a bracket in upper case; comments, declarations and the heads of routines call nothing.
///
/// `call = name "("`
fn callees(bytes: &[u8]) -> BTreeSet<String> {
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || b"_$".contains(b);
    let mut found = BTreeSet::new();
    for line in bytes.split(|b| matches!(b, b'\n' | b'\r')) {
        let code = line.split(|b| *b == b';').next().unwrap_or_default().to_ascii_uppercase();
        let mut words = code.split(|b| !is_word(b)).filter(|w| !w.is_empty());
        let first = words.next().unwrap_or_default();
        let declares = outside::declares_routine(first) || matches!(first, b"DEF" | b"DEFFCT" | b"DECL");
        // `GLOBAL INTERRUPT DECL 3 WHEN .. DO pick()` calls
        if declares || first == b"GLOBAL" && words.next() != Some(b"INTERRUPT") {
            continue;
        }
        for at in memchr::memchr_iter(b'(', &code) {
            let before = code[..at].trim_ascii_end();
            let length = before.iter().rev().take_while(|b| is_word(b)).count();
            found.insert(before[before.len() - length..].iter().map(|b| char::from(*b)).collect());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_stand_before_brackets_and_declarations_are_none() {
        let found =
            callees(b"&ACCESS RVP\nDEF main()\nEXT pick()\n pick ()\n;place()\nIF $IN[1] THEN lay(2) ENDIF\nEND\n");
        let has = |name: &str| found.contains(name);
        assert!(has("PICK") && has("LAY") && !has("PLACE") && !has("MAIN"), "{found:?}");
        let found = callees(b"GLOBAL INTERRUPT DECL 3 WHEN $IN[1] DO stop1()\ndefrost()\nGLOBAL DEF lay()\nEXTP p()\n");
        assert!(found.contains("STOP1") && found.contains("DEFROST"), "{found:?}");
        assert!(!found.contains("LAY") && !found.contains("P"), "{found:?}");
        assert!(callees(b"EXT pick()\n").is_empty());
    }
}
