//! Programs that a program calls: whether they move the robot, as far as the files beside it tell, or the user.
//!
//! A program moves nothing where nothing in it does and all that it calls is there and moves nothing either; programs that call each other
//! in a circle move what one of them moves. What is loaded on the controller under a name is taken to be the file beside it, and a note
//! says so. Of a name that no file has the user may say that it moves nothing ([`NoMotion`]); a file goes before that.

use super::{At, Note, Script};
use crate::no_motion::NoMotion;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;

/// What a program does besides what it calls.
#[derive(Debug, Clone, Default)]
pub struct Does {
    /// As others call it.
    pub name: String,
    /// Name of its file without the ending, in upper case.
    pub file: String,
    /// It moves the robot, or may.
    pub moves: bool,
    /// It holds a relative move.
    pub counts: bool,
    /// It reads where the robot stands.
    pub reads: bool,
    /// It waits.
    pub waits: bool,
    /// What it calls.
    pub calls: BTreeSet<String>,
    /// Instructions that are not known, by their names: macros.
    pub macros: BTreeSet<String>,
}

/// Name of the file of a text without its ending, in upper case.
pub fn stem_of(text: &super::Text) -> String {
    let stem = std::path::Path::new(&text.name).file_stem();
    stem.map(|s| s.to_string_lossy().to_ascii_uppercase()).unwrap_or_default()
}

/// Programs that move nothing, whether they wait; and those that may begin with a relative move.
#[derive(Debug, Default)]
pub struct Called {
    waits: BTreeMap<String, bool>,
    counts: BTreeSet<String>,
    reads: BTreeSet<String>,
    needs: Needs,
}

impl Called {
    /// Of what all the programs beside one do; `own`: names of this one; `declared`: names that move nothing where no file has them.
    pub fn of(all: &[impl Deref<Target = Does>], own: &[String], declared: &NoMotion) -> Self {
        let mut by_name: BTreeMap<&str, Option<&Does>> = BTreeMap::new();
        let mut needs = Needs::new(declared);
        for name in own.iter().chain(all.iter().map(|d| &d.file)) {
            needs.is_there(name);
        }
        for does in all {
            // two files of one name: which is loaded is not known
            by_name.entry(&does.name).and_modify(|d| *d = None).or_insert((!does.moves).then_some(does));
            needs.add(&does.name, does.moves, does.calls.iter().chain(&does.macros).cloned());
        }
        let mut still: BTreeMap<&str, &Does> = by_name.iter().filter_map(|(name, d)| Some((*name, (*d)?))).collect();
        loop {
            // what is left of those that move nothing themselves calls nothing else in the end
            let settled = |c: &String| still.contains_key(c.as_str()) || needs.is_declared(c);
            let rests = |d: &Does| d.calls.iter().all(settled) && d.macros.iter().all(|m| needs.is_declared(m));
            let next: BTreeMap<&str, &Does> = still.iter().filter(|(_, d)| rests(d)).map(|(n, d)| (*n, *d)).collect();
            if next.len() == still.len() {
                break;
            }
            still = next;
        }
        // one that the user declares may wait
        let waits = held(&still.values().copied().collect::<Vec<_>>(), |d| {
            d.waits || !d.macros.is_empty() || d.calls.iter().any(|c| !still.contains_key(c.as_str()))
        });
        let waits = still.keys().map(|name| ((*name).to_string(), waits.contains(*name))).collect();
        let (counts, reads) = (holding(all, |d| d.counts), holding(all, |d| d.reads));
        Self { waits, counts, reads, needs }
    }

    /// Whether the program of this name moves nothing, and then whether it waits.
    pub fn waits(&self, name: &str) -> Option<bool> {
        self.waits.get(name).copied().or_else(|| self.needs.is_declared(name).then_some(true))
    }

    /// Whether a macro moves nothing: the user says so, and no file has its name.
    pub fn is_still_macro(&self, name: &str) -> bool {
        self.needs.is_declared(name)
    }

    /// Whether the program of this name may begin with a relative move.
    pub fn counts(&self, name: &str) -> bool {
        self.counts.contains(name)
    }

    /// Whether the program of this name may read where the robot stands before it moves.
    pub fn reads(&self, name: &str) -> bool {
        self.reads.contains(name)
    }

    /// What has to be known of the programs to tell what moves nothing.
    pub fn needs(&self) -> &Needs {
        &self.needs
    }
}

/// What routines call, and which of that has no text among the files.
#[derive(Debug, Default)]
pub struct Needs {
    declared: NoMotion,
    /// Names that count letter by letter.
    exactly: bool,
    routines: BTreeMap<String, Need>,
    /// Further names that are among the files.
    there: BTreeSet<String>,
}

/// A routine of the files: it moves whatever it calls; what it calls.
#[derive(Debug, Default)]
struct Need {
    moves: bool,
    calls: BTreeSet<String>,
}

impl Needs {
    /// Of a language in which case does not count.
    pub fn new(declared: &NoMotion) -> Self {
        Self { declared: declared.clone(), ..Self::default() }
    }

    /// Of one in which it does.
    pub fn exactly(declared: &NoMotion) -> Self {
        Self { exactly: true, ..Self::new(declared) }
    }

    /// A routine of the files; several of one name count as one that does what each of them does.
    pub fn add(&mut self, name: &str, moves: bool, calls: impl IntoIterator<Item = String>) {
        let need = self.routines.entry(name.to_string()).or_default();
        need.moves |= moves;
        need.calls.extend(calls);
    }

    /// A name that a file has.
    pub fn is_there(&mut self, name: &str) {
        self.there.insert(name.to_string());
    }

    fn has_text(&self, name: &str) -> bool {
        // a macro may run the program of its name, written with `_`
        let joined = || name.split_whitespace().collect::<Vec<_>>().join("_");
        let there = |name: &str| self.routines.contains_key(name) || self.there.contains(name);
        there(name) || name.contains(' ') && there(&joined())
    }

    fn says(&self, name: &str) -> bool {
        if self.exactly { self.declared.has_exactly(name) } else { self.declared.has(name) }
    }

    /// Whether the user says that a name moves nothing, and no file has it.
    pub fn is_declared(&self, name: &str) -> bool {
        !self.declared.is_empty() && self.says(name) && !self.has_text(name)
    }

    /// Whether the user says that a name moves nothing, and a file has it: that counts.
    pub fn is_overruled(&self, name: &str) -> bool {
        !self.declared.is_empty() && self.says(name) && self.has_text(name)
    }

    /// Names without a text that a call of this one leads to, itself among them; `None`: it moves whatever they do.
    fn leads_to(&self, name: &str) -> Option<BTreeSet<String>> {
        let (mut open, mut seen, mut found) = (vec![name], BTreeSet::new(), BTreeSet::new());
        while let Some(name) = open.pop() {
            if !seen.insert(name) {
                continue;
            }
            match self.routines.get(name) {
                Some(need) if need.moves => return None,
                Some(need) => open.extend(need.calls.iter().map(String::as_str)),
                None if self.has_text(name) => return None,
                None => drop(found.insert(name.to_string())),
            }
        }
        Some(found)
    }

    /// Names that would have to move nothing, so that a call of this one moved nothing; none: that would not be enough.
    pub fn of(&self, name: &str) -> BTreeSet<String> {
        let mut found = self.leads_to(name).unwrap_or_default();
        found.retain(|n| !self.is_declared(n));
        found
    }

    /// Names on which it rests that a call of this one moves nothing.
    pub fn relies_on(&self, name: &str) -> BTreeSet<String> {
        if self.declared.is_empty() {
            return BTreeSet::new();
        }
        let mut found = self.leads_to(name).unwrap_or_default();
        found.retain(|n| self.is_declared(n));
        found
    }
}

/// Calls as a reader meets them, whose text is not among the files, or counts although the user says otherwise.
#[derive(Debug, Default)]
pub struct NamedCalls {
    /// With the line where each is first.
    declared: BTreeMap<String, u64>,
    overruled: BTreeMap<String, u64>,
    unknown: BTreeMap<At, BTreeSet<String>>,
    /// Lines that may move whatever is declared of names.
    moving: BTreeSet<At>,
    /// What a name needs that was met before.
    needed: BTreeMap<String, BTreeSet<String>>,
}

impl NamedCalls {
    /// A call that moves nothing, as the user says of what it rests on.
    pub fn still(&mut self, needs: &Needs, name: &str, line: u64) {
        for name in needs.relies_on(name) {
            self.declared.entry(name).or_insert(line);
        }
    }

    /// A call that may move.
    pub fn moving(&mut self, needs: &Needs, name: &str, at: At) {
        if needs.is_overruled(name) {
            self.overruled.entry(name.to_string()).or_insert(at.line);
        }
        if !self.needed.contains_key(name) {
            self.needed.insert(name.to_string(), needs.of(name));
        }
        match self.needed.get(name).filter(|names| !names.is_empty()) {
            None => drop(self.moving.insert(at)),
            Some(names) => self.unknown.entry(at).or_default().extend(names.iter().cloned()),
        }
    }

    /// Gives it to the script.
    pub fn report_to(self, script: &mut Script) {
        let note = |line: u64, text: String| Note { place: At { file: 0, line }, text };
        for (name, line) in &self.declared {
            let text = format!(
                "{name} moves nothing and leaves frames and tools as they are, as declared (no_motion): what the controller runs under this name must do so"
            );
            script.notes.push(note(*line, text));
        }
        for (name, line) in &self.overruled {
            let text = format!(
                "{name} is declared to move nothing (no_motion), but a file has this name, and by that it may move the robot: the file counts"
            );
            script.notes.push(note(*line, text));
        }
        let Self { mut unknown, moving, .. } = self;
        unknown.retain(|at, _| !moving.contains(at));
        script.unknown_calls.extend(unknown);
    }
}

/// Programs that hold something, or call one that does.
fn holding(all: &[impl Deref<Target = Does>], it: impl Fn(&Does) -> bool) -> BTreeSet<String> {
    held(&all.iter().map(|d| &**d).collect::<Vec<_>>(), it)
}

fn held(all: &[&Does], it: impl Fn(&Does) -> bool) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = all.iter().filter(|d| it(d)).map(|d| d.name.clone()).collect();
    loop {
        let calls = |d: &&&Does| !found.contains(&d.name) && d.calls.iter().any(|c| found.contains(c));
        let Some(next) = all.iter().find(calls).map(|d| d.name.clone()) else { return found };
        found.insert(next);
    }
}

/// Says that a routine which may move the robot runs whenever it strikes: a thread, or what an interrupt calls.
pub fn strikes(at: At, name: &str) -> Note {
    let text = format!(
        "{name} may move the robot while the program waits or moves: targets after that may be reached from other sides than their offsets are for"
    );
    Note { place: at, text }
}

/// Says which calls end nothing that is known of the joints; `met`: what is called so, and the line where it is first; `what` it is, and
/// the files that tell it of one and of several.
pub fn note(met: &BTreeMap<String, u64>, what: &str, [by_one, by_all]: [&str; 2]) -> Option<Note> {
    let line = met.values().min().copied()?;
    let names: Vec<&str> = met.keys().map(String::as_str).collect();
    let text = match names.as_slice() {
        [one] => format!("the {what} {one} that it calls moves nothing, by {by_one}"),
        all => format!("the {what}s {} that it calls move nothing, by {by_all}", all.join(", ")),
    };
    Some(Note { place: At { file: 0, line }, text })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What `P` tells of programs, each with its name, what it does (`m`oves, `w`aits) and what it calls.
    fn called(all: &[(&str, &str, &[&str])]) -> Called {
        let does = |(name, does, calls): &(&str, &str, &[&str])| Does {
            name: (*name).into(),
            file: (*name).into(),
            moves: does.contains('m'),
            waits: does.contains('w'),
            calls: calls.iter().map(|c| (*c).to_string()).collect(),
            ..Does::default()
        };
        Called::of(&all.iter().map(does).map(Box::new).collect::<Vec<_>>(), &["P".into()], &NoMotion::default())
    }

    #[test]
    fn programs_that_call_each_other_in_a_circle_move_what_one_of_them_moves() {
        let still = called(&[("A", "", &["B"]), ("B", "", &["C", "A"]), ("C", "", &[]), ("D", "", &["D"])]);
        assert_eq!(["A", "B", "C", "D"].map(|n| still.waits(n)), [Some(false); 4]);
        let waiting = called(&[("A", "", &["B"]), ("B", "w", &["A"]), ("C", "", &[])]);
        assert_eq!(["A", "B", "C"].map(|n| waiting.waits(n)), [Some(true), Some(true), Some(false)]);
        // one of them moves, calls what is not there, or the program itself
        for (does, call) in [("m", "C"), ("", "ABSENT"), ("", "P")] {
            let moving = called(&[("A", "", &["B"]), ("B", does, &["A", call]), ("C", "", &[]), ("E", "", &["A"])]);
            assert_eq!(["A", "B", "C", "E"].map(|n| moving.waits(n)), [None, None, Some(false), None]);
        }
    }
}
