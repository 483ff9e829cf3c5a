//! Position variables whose value stands in the job's list and nowhere else: which may be edited there.
//!
//! P variables are the controller's, shared by all its jobs: loading a job sets those of its list. The value of the list is the one
//! in force where no instruction sets another. So a variable may be edited where this job does not set it, no job beside it
//! names it, and every job that any of them runs stands there; it is then known as well as a C position.

use super::job::Kind;
use super::reason::Uncertain;
use super::words::{PlainMoves, STARTS, is_known, upper_words};
use crate::files::{self, ANY, Folders, of_folder};
use crate::script::Text;
use crate::script::called::stem_of;
use crate::script::cursor::strip_word;
use crate::script::lex::text_of;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The other jobs of the folder of the job at `path`, where that moves to a position variable, or is a relative job: all of them, however
/// many there are, as any may set it, or call it in a frame. Else those that it calls, itself or by others.
pub(super) fn files(path: &Path, seen: &Folders) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let own = std::fs::read(path).unwrap_or_default();
    if !moves_to_variables(&own) && !is_relative(&own) {
        return files::called(path, called(&own), called, || seen.of("inform", folder, || jobs(folder, usize::MAX)));
    }
    let is_job = |p: &PathBuf| p.extension().is_some_and(|e| ["jbi", "jbr"].iter().any(|j| e.eq_ignore_ascii_case(j)));
    let own = path.file_name();
    let here = of_folder(folder, usize::MAX);
    // a folder that cannot be looked through stands for itself: it is none that can be read
    if here.is_empty() {
        return vec![folder.to_path_buf()];
    }
    here.into_iter().filter(|p| is_job(p) && p.file_name() != own).collect()
}

/// Most jobs of a folder that is looked through for callers.
const MOST_BESIDE: usize = 10_000;

/// The jobs of a folder; none where it has more than `most` files.
fn jobs(folder: &Path, most: usize) -> Vec<PathBuf> {
    let is_job = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("jbi"));
    of_folder(folder, most).into_iter().filter(is_job).collect()
}

/// Whether another job of the folder calls the one at `path`, goes over to it, or starts it.
pub(super) fn is_called(path: &Path, own: &Text, seen: &Folders) -> bool {
    let names: Vec<String> = [Some(stem_of(own)), job_name(own)].into_iter().flatten().collect();
    seen.calls(("inform", path), &names, |folder| jobs(folder, MOST_BESIDE), callees)
}

/// What a job calls, goes over to or starts, in upper case; [`ANY`]: one whose name is computed. Comments call nothing.
///
/// `line = "'" ... | ... ("CALL" | "JUMP") ("JOB:" (name | "S" number) | "IND" ... | "IG#" ...)`
fn callees(bytes: &[u8]) -> BTreeSet<String> {
    let lines = bytes.split(|b| matches!(b, b'\n' | b'\r')).map(|line| line.trim_ascii().to_ascii_uppercase());
    let mut found = BTreeSet::new();
    for line in lines.filter(|line| !line.starts_with(b"'")) {
        let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
        let computed = |w: &[&[u8]]| {
            let of = w[1].strip_prefix(b"JOB:S").is_some_and(|n| !n.is_empty() && n.iter().all(u8::is_ascii_digit));
            matches!(w[0], b"CALL" | b"JUMP") && (of || w[1].starts_with(b"IG#") || w[1] == b"IND")
        };
        if words.windows(2).any(computed) {
            found.insert(ANY.into());
        }
        found.extend(called(&line));
    }
    found
}

/// Longest name of a job.
const LONGEST: usize = 32;

/// Names after `CALL JOB:`, and instructions that are not known: a macro runs a job. In upper case.
///
/// `call = "JOB:" name ["(" ...] | word ...`
fn called(bytes: &[u8]) -> BTreeSet<String> {
    let bytes = bytes.to_ascii_uppercase();
    let first = |l: &[u8]| {
        let word = l.trim_ascii().split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let name = word.first().is_some_and(u8::is_ascii_alphabetic) && word.len() <= LONGEST;
        let name = name && word.iter().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(b));
        name.then(|| text_of(word).into_owned()).filter(|w| !is_known(w))
    };
    let macros: BTreeSet<String> = bytes.split(|b| matches!(b, b'\n' | b'\r')).filter_map(first).collect();
    let name = |at: usize| {
        let rest = &bytes[at + b"JOB:".len()..];
        let end = rest.iter().position(|b| b.is_ascii_whitespace() || *b == b'(').unwrap_or(rest.len());
        text_of(&rest[..end]).into_owned()
    };
    memchr::memmem::find_iter(&bytes, b"JOB:").map(name).chain(macros).collect()
}

/// Whether a job is a relative one: its positions count in the user frame in which it is called.
///
/// `attributes = "///ATTR" word {"," word}`
fn is_relative(bytes: &[u8]) -> bool {
    let words = |l: &[u8]| l.trim_ascii().strip_prefix(b"///ATTR").map(|rest| text_of(rest).to_ascii_uppercase());
    let mut lines = bytes.split(|b| matches!(b, b'\n' | b'\r')).filter_map(words);
    lines.any(|attributes| attributes.split([',', ' ']).any(|word| word == "RJ"))
}

/// Whether the job is a relative one that another job calls, or goes over to, in a user frame.
///
/// `call = ("CALL" | "JUMP") "JOB:" name "UF#" "(" number ")" ...`
pub(super) fn is_led_elsewhere(text: &Text, beside: &[Text]) -> bool {
    let own = [Some(stem_of(text)), job_name(text)];
    let leads = |other: &Text, k: usize| {
        let words = upper_words(other, k);
        let name = words.iter().find_map(|w| w.strip_prefix("JOB:"));
        name.is_some_and(|name| own.iter().flatten().any(|own| own == name))
            && words.iter().any(|w| w.starts_with("UF#"))
    };
    is_relative(&text.bytes) && beside.iter().any(|other| (0..other.line_count()).any(|k| leads(other, k)))
}

/// Whether an instruction may move to `P001`.
///
/// `move = ... "MOV" ... "P" digit ...`
fn moves_to_variables(bytes: &[u8]) -> bool {
    let variable = |w: &[u8]| matches!(w, [b'P' | b'p', digit, ..] if digit.is_ascii_digit());
    let moves = |l: &[u8]| l.to_ascii_uppercase().windows(3).any(|w| w == b"MOV");
    let mut lines = bytes.split(|b| matches!(b, b'\n' | b'\r'));
    lines.any(|l| l.split(u8::is_ascii_whitespace).any(variable) && moves(l))
}

/// What the jobs beside this one say of its position variables.
#[derive(Default)]
pub(super) struct Shared {
    /// Numbers that other jobs name, and the name of one such job.
    named: BTreeSet<u32>,
    /// Why no variable is certain.
    open: Option<Uncertain>,
}

impl Shared {
    /// Looks over a job (its instructions from line `begin`) and those beside it.
    pub(super) fn of(text: &Text, begin: usize, beside: &[Text]) -> Self {
        let mut shared = Self::default();
        let mut there: BTreeSet<String> = beside.iter().filter_map(job_name).collect();
        there.extend(job_name(text));
        for (other, from) in std::iter::once((text, begin)).chain(beside.iter().map(|t| (t, 0))) {
            let own = std::ptr::eq(other, text);
            // what cannot be read comes without a line
            if other.line_count() == 0 {
                shared.open(Uncertain::Unread(other.name.as_str().into()));
            }
            // any job may be the one that runs this one
            let plain = PlainMoves::of(other);
            for k in (from..other.line_count()).filter(|k| !plain.has_indented(*k)) {
                shared.line(other, k, own, &there);
            }
        }
        shared
    }

    fn open(&mut self, why: Uncertain) {
        self.open.get_or_insert(why);
    }

    /// One line; `there`: names of the jobs that stand here.
    ///
    /// `line = "/" ... | "'" comment | position "=" ... | {label} word {word}`
    fn line(&mut self, text: &Text, k: usize, own: bool, there: &BTreeSet<String>) {
        let line = text.line(k).trim_ascii();
        if line.starts_with(b"/") || line.starts_with(b"'") {
            return;
        }
        // a line of the list names its variable, too
        let head = line.split(|&b| b == b'=').next().unwrap_or_default().trim_ascii();
        if !own && let Some((Kind::P, n, _)) = Kind::read(head) {
            self.named.insert(n);
        }
        let words = upper_words(text, k);
        // an instruction may stand after a label
        let first = words.iter().find(|w| !w.starts_with('*'));
        let Some(first) = first.map(String::as_str) else { return };
        // the list of a job that stands beside comes before its instructions
        if !is_known(first) && !first.contains('=') {
            self.open(Uncertain::Unknown(first.into()));
        }
        if let Some(job) = runs(&words, there) {
            self.open(job);
        }
        if clears_positions(&words) {
            self.open(Uncertain::Clear);
        }
        let moves = first.contains("MOV");
        for word in words.iter().filter(|w| !w.starts_with("JOB:")) {
            let (numbers, any) = variables(word);
            // a move sets none
            if any && !moves {
                self.open(Uncertain::Any(word.as_str().into()));
            }
            if !own {
                self.named.extend(numbers);
            }
        }
    }

    /// Why the value of a variable may be another than that of the list.
    pub(super) fn uncertain(&self, number: u32) -> Option<Uncertain> {
        if self.named.contains(&number) { Some(Uncertain::Named) } else { self.open.clone() }
    }
}

/// What a line runs or goes to that does not stand here, wherever in the line it is ordered.
///
/// `run = ("JUMP" | "CALL" | "PSTART") ("JOB:" name | word) ...`
fn runs(words: &[String], there: &BTreeSet<String>) -> Option<Uncertain> {
    let mut jobs = words.iter().filter_map(|w| w.split_once("JOB:").map(|(_, job)| job)).peekable();
    let jump = words.windows(2).any(|w| w[0] == "JUMP" && !w[1].starts_with('*'));
    let runs = jump || words.iter().any(|w| STARTS.contains(&w.as_str()));
    if runs && jobs.peek().is_none() {
        return Some(Uncertain::CallComputed);
    }
    let gone = jobs.find(|job| !there.contains(*job))?;
    Some(Uncertain::CallsAbsent(gone.into()))
}

/// `CLEAR P100 10`, `CLEAR ALL`: position variables that are not named one by one.
///
/// `clear = "CLEAR" (variable | "ALL") ...`
pub(super) fn clears_positions(words: &[String]) -> bool {
    let positions = |w: &String| {
        let (numbers, any) = variables(w);
        any || !numbers.is_empty() || w.starts_with("ALL")
    };
    words.windows(2).any(|w| w[0] == "CLEAR" && positions(&w[1]))
}

/// Numbers of the position variables that a word names, whatever is glued to them (`P105(3)`, `P105,P001`; `PX001` is P001 with its
/// base axes), and whether it names one by a number that is not written (`P[I000]`).
///
/// `variable = "P" ["X"] (digit {digit} | "[" ...)`
pub(super) fn variables(word: &str) -> (Vec<u32>, bool) {
    let bytes = word.as_bytes();
    let (mut numbers, mut any) = (Vec::new(), false);
    for k in (0..bytes.len()).filter(|&k| bytes[k].eq_ignore_ascii_case(&b'P')) {
        // `LP000`, `BP000` and `$PX000` are others
        let before = k.checked_sub(1).map(|i| bytes[i]);
        if before.is_some_and(|b| b.is_ascii_alphanumeric() || matches!(b, b'$' | b'_')) {
            continue;
        }
        let rest = &bytes[k + 1..];
        let rest = if rest.first().is_some_and(|b| b.eq_ignore_ascii_case(&b'X')) { &rest[1..] } else { rest };
        match rest.first() {
            // the bracket may stand after a blank
            None | Some(b'[') => any = true,
            Some(digit) if digit.is_ascii_digit() => {
                let digits = rest.iter().take_while(|b| b.is_ascii_digit());
                numbers.push(digits.fold(0u32, |n, d| n.saturating_mul(10).saturating_add(u32::from(d - b'0'))));
            }
            Some(_) => {}
        }
    }
    (numbers, any)
}

/// `//NAME TEST`.
///
/// `name = "//NAME" name`
pub(super) fn job_name(text: &Text) -> Option<String> {
    let line = (0..text.line_count().min(8)).find_map(|k| strip_word(text.line(k).trim_ascii(), b"//NAME"))?;
    Some(text_of(line.trim_ascii()).to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(name: &str, list: &str, lines: &str) -> Text {
        Text::new(name, format!("/JOB\r\n//NAME {name}\r\n//POS\r\n{list}//INST\r\n{lines}END\r\n").into_bytes())
    }

    fn uncertain(own: &str, beside: &[Text]) -> Option<Uncertain> {
        let text = job("MAIN", "P00105=1,2,3,0,0,0\r\n", own);
        Shared::of(&text, 4, beside).uncertain(105)
    }

    #[test]
    fn only_a_job_that_moves_to_variables_looks_at_those_beside_it() {
        let folder = std::env::temp_dir().join(format!("lostmotion-inform-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = |name: &str| folder.join(name);
        for (name, line) in [("A.JBI", "MOVJ P105 VJ=10.00"), ("b.jbi", "MOVJ C00001 VJ=10.00"), ("c.txt", "MOVJ P105")]
        {
            std::fs::write(path(name), format!("NOP\r\n{line}\r\nEND\r\n")).unwrap();
        }
        let files = |name: &str| files(&path(name), &Folders::default());
        assert_eq!(files("A.JBI"), [path("b.jbi")]);
        assert!(files("b.jbi").is_empty() && files("gone.jbi").is_empty());
        // a job that calls others looks at these
        std::fs::write(path("d.JBI"), "NOP\r\nCALL JOB:B IF B000=1\r\nEND\r\n").unwrap();
        assert_eq!(files("d.JBI"), [path("b.jbi")]);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_relative_job_that_another_one_calls_in_a_user_frame_leads_elsewhere() {
        let relative = job("A", "///USER 1\r\n", "///ATTR SC,RW,RJ\r\n////FRAME USER 1\r\nMOVL C00000 V=10.0\r\n");
        let caller = |line: &str| job("MAIN", "", &format!("///ATTR SC,RW\r\n{line}\r\n"));
        let led = |line: &str| is_led_elsewhere(&relative, &[caller("NOP"), caller(line)]);
        assert!(led("CALL JOB:A UF#(3)") && led("JUMP JOB:A UF#(2) IF IN#(1)=ON"));
        assert!(!led("CALL JOB:A") && !led("CALL JOB:B UF#(3)") && !is_led_elsewhere(&relative, &[]));
        let plain = job("A", "", "///ATTR SC,RW\r\nMOVL C00000 V=10.0\r\n");
        assert!(!is_led_elsewhere(&plain, &[caller("CALL JOB:A UF#(3)")]));
    }

    #[test]
    fn a_variable_is_certain_where_no_job_beside_names_it_and_every_called_job_is_there() {
        let quiet = job("SUB", "C00000=1\r\nP00106=1,2,3,0,0,0\r\n", "MOVL P106 V=10.0\r\n'P105\r\n");
        assert_eq!(uncertain("MOVJ P105 VJ=10.00\r\n", &[]), None);
        assert_eq!(uncertain("CALL JOB:SUB\r\n", std::slice::from_ref(&quiet)), None);
        for (own, beside, why) in [
            ("CALL JOB:SUB\r\n", vec![], "job SUB is called"),
            ("CALL JOB:SUB IF B000=1\r\n", vec![], "job SUB is called"),
            ("CALL I001\r\n", vec![quiet], "named at run time"),
            ("FINDPART 1\r\n", vec![], "FINDPART is not known"),
            ("SET P[I000] P001\r\n", vec![], "`P[I000]` may be any"),
            ("NOP\r\n", vec![job("SUB", "", "GETS PX105 $PX000\r\n")], "another job"),
            ("NOP\r\n", vec![job("SUB", "", "SETE P105 (3) 100\r\n")], "another job"),
            ("NOP\r\n", vec![job("SUB", "P00105=0,0,0,0,0,0\r\n", "")], "another job"),
        ] {
            let found = uncertain(own, &beside).map(|why| why.to_string()).unwrap_or_default();
            assert!(found.contains(why), "{own}: {found}");
        }
    }

    #[test]
    fn a_job_beside_that_runs_one_that_is_not_there_leaves_no_variable_certain() {
        let master = |line: &str| vec![job("MASTER", "", &format!("{line}\r\nCALL JOB:MAIN\r\n"))];
        assert_eq!(uncertain("NOP\r\n", &master("CALL JOB:MASTER")), None);
        for line in ["CALL JOB:SETTER", "PSTART SUB1 JOB:GONE", "*L1 CALL JOB:GONE", "FINDPART 1", "JUMP JOB:GONE"] {
            assert!(uncertain("NOP\r\n", &master(line)).is_some(), "{line}");
        }
        // what could not be read may set any
        assert!(uncertain("NOP\r\n", &[Text::new("B.JBI", Vec::new())]).is_some());
    }

    #[test]
    fn a_job_is_run_from_anywhere_in_a_line() {
        for line in [
            "JUMP JOB:GONE",
            "JUMP JOB:GONE IF IN#(1)=ON",
            "JUMP I001",
            "*L1 CALL JOB:GONE",
            "IF B000=1 CALL JOB:GONE",
            "*L1 FINDPART 1",
        ] {
            assert!(uncertain(&format!("{line}\r\n"), &[]).is_some(), "{line}");
        }
        for line in ["JUMP *L1", "JUMP *L1 IF B000=1", "*L1", "*L1 CALL JOB:MAIN"] {
            assert_eq!(uncertain(&format!("{line}\r\n"), &[]), None, "{line}");
        }
    }

    #[test]
    fn a_variable_with_something_glued_to_it_is_named() {
        for line in [
            "SETE P105(3) D000",
            "SET P105,P001",
            "SET P001,P105",
            "GETS PX105//x",
            "GETS PX105,$PX000",
            "SETE P [I000] (1) 5",
            "CLEAR P100 10",
            "CLEAR P100,10",
            "CLEAR ALL",
        ] {
            let beside = [job("SUB", "", &format!("{line}\r\n"))];
            assert!(uncertain("NOP\r\n", &beside).is_some(), "{line}");
        }
        for line in ["CLEAR B000 10", "SET LP105 P001", "GETS PX001 $PX105", "CLEAR STACK"] {
            assert_eq!(uncertain("NOP\r\n", &[job("SUB", "", &format!("{line}\r\n"))]), None, "{line}");
        }
    }
}
