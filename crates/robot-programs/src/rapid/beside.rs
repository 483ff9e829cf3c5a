//! Whether another module of the folder names the procedures of a module that has no `main`.

use super::project::is_module;
use crate::files::{ANY, Folders, of_folder};
use crate::script::Text;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most files of a folder that is looked through.
const MOST_BESIDE: usize = 10_000;

/// Whether another module of the folder calls a procedure of the module at `path`, perhaps by a name in quotes; `main` is called by none.
pub(super) fn is_called(path: &Path, own: &Text, seen: &Folders) -> bool {
    let own = procedures(&own.bytes);
    let modules = |folder: &Path| -> Vec<PathBuf> {
        of_folder(folder, MOST_BESIDE).into_iter().filter(|p| is_module(p)).collect()
    };
    !own.is_empty() && !own.iter().any(|name| name == "MAIN") && seen.calls(("rapid", path), &own, modules, named)
}

/// Words of a line in upper case, comments left out; those in quotes, too.
///
/// `word = letter {letter | digit | "_"}`
fn words(line: &[u8]) -> Vec<String> {
    let code = line.split(|b| *b == b'!').next().unwrap_or_default();
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    let words = code.split(|b| !is_word(b)).filter(|w| w.first().is_some_and(u8::is_ascii_alphabetic));
    words.map(|w| w.iter().map(|b| char::from(b.to_ascii_uppercase())).collect()).collect()
}

/// Names of the procedures of a module that other modules see, in upper case.
///
/// `procedure = "PROC" name`
fn procedures(bytes: &[u8]) -> Vec<String> {
    let name = |line: &[u8]| match words(line).as_slice() {
        [proc, name, ..] if proc == "PROC" => Some(name.clone()),
        _ => None,
    };
    bytes.split(|b| matches!(b, b'\n' | b'\r')).filter_map(name).collect()
}

/// Whether a line calls a procedure by a name that is computed: `%s1%;`, `CallByVar "pick",n;`.
///
/// `call = "%" expression "%" | "CallByVar" ...`
fn computes_name(line: &[u8]) -> bool {
    let code = line.split(|b| *b == b'!').next().unwrap_or_default().trim_ascii();
    let late = code.strip_prefix(b"%").is_some_and(|rest| !rest.starts_with(b"%") && !is_quoted(rest));
    late || words(code).iter().any(|word| word == "CALLBYVAR")
}

/// Whether one name in quotes stands before the closing `%`.
///
/// `name = '"' ... '"' "%"`
fn is_quoted(rest: &[u8]) -> bool {
    let name = rest.split(|b| *b == b'%').next().unwrap_or_default().trim_ascii();
    name.len() > 1
        && name.starts_with(b"\"")
        && name.ends_with(b"\"")
        && name.iter().filter(|b| **b == b'"').count() == 2
}

/// What a module names besides its own routines; [`ANY`]: it calls by a name that is computed.
///
/// `routine = ["LOCAL"] ("PROC" | "FUNC" type | "TRAP") name`
fn named(bytes: &[u8]) -> BTreeSet<String> {
    let lines = || bytes.split(|b| matches!(b, b'\n' | b'\r'));
    let any = lines().any(computes_name).then(|| ANY.to_string());
    let lines: Vec<Vec<String>> = lines().map(words).collect();
    let declares = |line: &[String]| {
        let from = usize::from(line.first().is_some_and(|w| w == "LOCAL"));
        match (line.get(from).map(String::as_str), line.get(from + 1), line.get(from + 2)) {
            (Some("PROC" | "TRAP"), Some(name), _) | (Some("FUNC"), _, Some(name)) => Some(name.clone()),
            _ => None,
        }
    };
    let own: BTreeSet<String> = lines.iter().filter_map(|line| declares(line)).collect();
    lines.into_iter().flatten().filter(|word| !own.contains(word)).chain(any).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_names_what_it_calls_and_not_its_own_routines() {
        let text = b"MODULE M\nPROC main()\n pick; ! place\n %\"put\"%;\nENDPROC\nLOCAL PROC lay()\n lay;\nENDPROC\nENDMODULE\n";
        let found = named(text);
        assert!(found.contains("PICK") && found.contains("PUT"), "{found:?}");
        assert!(!found.contains("PLACE") && !found.contains("LAY") && !found.contains("MAIN"), "{found:?}");
        assert_eq!(procedures(text), ["MAIN"]);
        assert!(!found.contains(ANY));
        for line in ["%s1%;", "  %\"pi\"+\"ck\"%;", "CallByVar \"pick\",n;"] {
            assert!(named(line.as_bytes()).contains(ANY), "{line}");
        }
        assert!(!named(b"%%%\n  VERSION:1\n%%%\n! %s1%;\n").contains(ANY));
    }
}
