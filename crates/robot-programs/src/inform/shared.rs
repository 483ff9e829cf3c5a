//! Position variables whose value stands in the job's list and nowhere else: which may be edited there.
//!
//! P variables are the controller's, shared by all its jobs: loading a job sets those of its list. The value of the list is the one
//! in force where no instruction sets another. So a variable may be edited where this job does not set it, no job beside it
//! names it, and every job that is called stands beside it; it is then known as well as a C position.

use super::Kind;
use super::read::{STARTS, is_known, upper, words};
use crate::files::of_folder;
use crate::script::Text;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The other jobs of the folder of the job at `path`, where that moves to a position variable: all of them, however many there are, as any
/// may set it.
pub(super) fn files(path: &Path) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    if !std::fs::read(path).is_ok_and(|bytes| moves_to_variables(&bytes)) {
        return Vec::new();
    }
    let is_job = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("jbi"));
    let own = path.file_name();
    of_folder(folder, usize::MAX).into_iter().filter(|p| is_job(p) && p.file_name() != own).collect()
}

/// Whether an instruction may move to `P001`.
fn moves_to_variables(bytes: &[u8]) -> bool {
    let variable = |w: &[u8]| matches!(w, [b'P' | b'p', digit, ..] if digit.is_ascii_digit());
    let moves = |l: &[u8]| l.to_ascii_uppercase().windows(3).any(|w| w == b"MOV");
    let mut lines = bytes.split(|b| matches!(b, b'\n' | b'\r'));
    lines.any(|l| moves(l) && l.split(u8::is_ascii_whitespace).any(variable))
}

/// What the jobs beside this one say of its position variables.
#[derive(Default)]
pub(super) struct Shared {
    /// Numbers that other jobs name, and the name of one such job.
    named: BTreeSet<u32>,
    /// Why no variable is certain.
    open: Option<String>,
}

impl Shared {
    /// Looks over a job (its instructions from line `begin`) and those beside it.
    pub(super) fn of(text: &Text, begin: usize, beside: &[Text]) -> Self {
        let mut shared = Self::default();
        let calls = |k: usize| words(text, k).first().is_some_and(|w| STARTS.contains(&upper(text, w).as_str()));
        let any_runs = (begin..text.line_count()).any(calls);
        let mut there: BTreeSet<String> = beside.iter().filter_map(job_name).collect();
        there.extend(job_name(text));
        for (other, from) in std::iter::once((text, begin)).chain(beside.iter().map(|t| (t, 0))) {
            let own = std::ptr::eq(other, text);
            for k in from..other.line_count() {
                shared.line(other, k, own, (own || any_runs).then_some(&there));
            }
        }
        shared
    }

    /// One line; `there`: names of the jobs that stand here, where this job may run.
    fn line(&mut self, text: &Text, k: usize, own: bool, there: Option<&BTreeSet<String>>) {
        let line = text.line(k).trim_ascii();
        if line.starts_with(b"/") || line.starts_with(b"'") {
            return;
        }
        // a line of the list names its variable, too
        let head = line.split(|&b| b == b'=').next().unwrap_or_default().trim_ascii();
        if !own && let Some((Kind::P, n, _)) = Kind::read(head) {
            self.named.insert(n);
        }
        let words: Vec<String> = words(text, k).iter().map(|w| upper(text, w)).collect();
        let Some(first) = words.first() else { return };
        match there {
            Some(there) if STARTS.contains(&first.as_str()) => self.call(&words, there),
            // the list of a job that stands beside comes before its instructions
            Some(_) if !is_known(first) && !first.contains('=') => {
                self.open.get_or_insert_with(|| format!("{first} is not known"));
            }
            _ => {}
        }
        for word in &words {
            // `PX001` is P001 with its base axes
            let digits = word.strip_prefix("PX").or_else(|| word.strip_prefix('P'));
            match digits {
                // a move sets none
                Some(rest) if rest.starts_with('[') && first.contains("MOV") => {}
                Some(rest) if rest.starts_with('[') => {
                    self.open.get_or_insert_with(|| format!("`{word}` may be any"));
                }
                Some(rest) if !own => self.named.extend(rest.parse::<u32>()),
                _ => {}
            }
        }
    }

    fn call(&mut self, words: &[String], there: &BTreeSet<String>) {
        let job = words.iter().find_map(|w| w.strip_prefix("JOB:"));
        match job.filter(|j| there.contains(*j)) {
            Some(_) => {}
            None => {
                let what = job.map_or("a job that is named at run time".into(), |j| format!("job {j}"));
                self.open.get_or_insert_with(|| format!("{what} is called and does not stand beside this one"));
            }
        }
    }

    /// Why the value of a variable may be another than that of the list.
    pub(super) fn uncertain(&self, number: u32) -> Option<String> {
        let why = match &self.open {
            _ if self.named.contains(&number) => "another job beside this one names it",
            Some(why) => why,
            None => return None,
        };
        Some(format!("position variable P{number:03}: its value may be changed at run time ({why})"))
    }
}

/// `//NAME TEST`.
fn job_name(text: &Text) -> Option<String> {
    let line = (0..text.line_count().min(8))
        .map(|k| text.line(k).trim_ascii())
        .find(|l| l.get(..6).is_some_and(|head| head.eq_ignore_ascii_case(b"//NAME")))?;
    Some(String::from_utf8_lossy(line[6..].trim_ascii()).to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(name: &str, list: &str, lines: &str) -> Text {
        Text::new(name, format!("/JOB\r\n//NAME {name}\r\n//POS\r\n{list}//INST\r\n{lines}END\r\n").into_bytes())
    }

    fn uncertain(own: &str, beside: &[Text]) -> Option<String> {
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
        assert_eq!(files(&path("A.JBI")), [path("b.jbi")]);
        assert!(files(&path("b.jbi")).is_empty() && files(&path("gone.jbi")).is_empty());
        std::fs::remove_dir_all(&folder).unwrap();
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
            let found = uncertain(own, &beside).unwrap_or_default();
            assert!(found.contains(why), "{own}: {found}");
        }
    }
}
