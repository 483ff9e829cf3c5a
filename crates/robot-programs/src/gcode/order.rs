//! From where control comes to subprograms, to what stands after their calls, to loops and to conditions, as a text shows it.
//!
//! A subprogram that stands in the text is entered from its calls, and what stands after a call is reached from its M99 or `endsub` alone
//! (NIST RS274NGC has none; Fanuc, Series 15i, operator's manual B-63324EN/03, subprogram: M98 calls, M99 returns to the calling program;
//! LinuxCNC, O codes: `sub`, `endsub`, `call`). The program around a definition passes it. The condition of a loop is looked at where the
//! machine stands. [`Routines`] puts calls and ends together.
//!
//! Nothing is known in a text in which something may lead elsewhere: jumps and labels, `return`, `break`, `continue`, a block that an
//! operator may switch off with one of these words, M99 or M30 within a loop or a condition, a program that runs into the next one, lines
//! that are not followed, several work frames, G52, G92 and G10, because places are counted in the order of the text. Of the start of a
//! subprogram nothing is known where a call repeats it (L3).

use crate::script::joins::through_still;
use crate::script::routines::Routines;
use crate::script::{Break, Join, Round, Script, StepKind};
use std::collections::BTreeSet;

/// What a line is that steers the order of blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Line {
    /// `WHILE [..] DO1`, `o1 while [..]`, `o1 repeat [3]`; `entered`: it certainly is.
    Loop { label: String, entered: bool },
    /// `o1 do`.
    Do { label: String },
    /// The end of a loop.
    EndLoop { label: String },
    /// `o1 if [..]`.
    If { label: String },
    /// `o1 elseif [..]`, `o1 else` (`whole`).
    Else { label: String, whole: bool },
    /// `o1 endif`.
    EndIf { label: String },
    /// `IF [..] THEN #1=2`.
    GoesOn,
    /// What leads elsewhere.
    Away,
}

/// A call of a program of the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) name: String,
    /// It is certainly run, and is that of the text.
    pub(super) certain: bool,
    /// It is run once.
    pub(super) once: bool,
}

/// A loop or a condition that is open.
#[derive(Debug)]
struct Open {
    label: String,
    /// Step of its break.
    at: usize,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Loop {
        entered: bool,
    },
    Do,
    /// Steps of the breaks of its further branches, and whether one of all is taken.
    If {
        ends: Vec<usize>,
        whole: bool,
    },
}

/// What is gathered while a text is read.
#[derive(Default)]
pub(super) struct Order {
    routines: Routines,
    /// Programs and definitions so far.
    count: usize,
    /// The name of what is read.
    current: String,
    /// Names of definitions so far.
    defined: BTreeSet<String>,
    /// Step of the definition that is read.
    sub: Option<usize>,
    /// Nothing leads to what is read.
    dead: bool,
    /// Where the program starts, if nothing before it moves.
    entry: Option<usize>,
    /// The program has begun.
    begun: bool,
    /// From here on it is not known yet whether it has.
    from: usize,
    joins: Vec<Join>,
    rounds: Vec<Round>,
    open: Vec<Open>,
    /// Calls so far.
    calls: usize,
    unknown: bool,
}

impl Order {
    /// Something may lead elsewhere.
    pub(super) fn is_unknown(&mut self) {
        self.unknown = true;
    }

    /// Whether the program has begun before a step.
    fn look(&mut self, at: usize, script: &Script) {
        let still = |(k, kind): (usize, &StepKind)| match kind {
            StepKind::Break(Break::Start) => k == 0,
            StepKind::Break(kind) => kind.is_frame(),
            StepKind::Move(_) => false,
            _ => true,
        };
        let steps = script.steps.iter().map(|s| &s.kind).enumerate();
        self.begun |= !steps.take(at).skip(self.from).all(still);
        self.from = at + 1;
    }

    /// The program may start at a step.
    fn starts(&mut self, at: usize) {
        if !self.begun {
            self.entry = Some(at);
        }
    }

    /// `%` at a step; `called`: what is read may be called.
    pub(super) fn tape(&mut self, at: usize, called: &BTreeSet<String>, script: &Script) {
        self.look(at, script);
        self.starts(at);
        if self.begun || self.count > 0 {
            self.stops(called);
            self.ends();
        }
    }

    /// What is read has no end of its own.
    fn stops(&mut self, called: &BTreeSet<String>) {
        self.unknown |= !self.dead && called.contains(&self.current);
    }

    /// A program with a number begins at a step: `O100`.
    pub(super) fn program(&mut self, label: &str, at: usize, called: &BTreeSet<String>, script: &Script) {
        self.look(at, script);
        let runs_on = !self.dead && (self.begun || self.count > 0);
        self.unknown |= runs_on || !self.open.is_empty() || self.sub.is_some();
        match called.contains(label) {
            true => self.begun = true,
            false => self.starts(at),
        }
        // nothing leads from the one before to its end
        self.routines.is_reached(false);
        self.begin(label, at);
    }

    /// `o100 sub`.
    pub(super) fn sub(&mut self, label: &str, at: usize, script: &Script) {
        self.look(at, script);
        self.unknown |= self.dead || !self.open.is_empty() || self.sub.is_some();
        self.sub = Some(at);
        self.begin(label, at);
        self.defined.insert(label.into());
    }

    fn begin(&mut self, label: &str, at: usize) {
        self.count += 1;
        self.routines.start(self.count, label.into(), at);
        self.routines.all_calls_are_here(true);
        (self.current, self.dead) = (label.into(), false);
    }

    /// `o100 endsub`: the program around it goes on from before the `sub`.
    pub(super) fn end_sub(&mut self, label: &str, at: usize) {
        let sub = self.sub.take().filter(|_| self.open.is_empty() && !self.dead && self.current == label);
        let Some(sub) = sub else {
            (self.unknown, self.begun) = (true, true);
            return;
        };
        self.routines.start(0, String::new(), at);
        self.joins.push(Join { at, from: vec![sub] });
        self.current.clear();
        self.from = at + 1;
        self.starts(at);
    }

    /// M99 in the block of the break at a step.
    pub(super) fn returns(&mut self, at: usize) {
        self.routines.returns(at);
        self.ends();
    }

    /// M30, or what ends as it does: nothing leads to what follows.
    pub(super) fn ends(&mut self) {
        self.unknown |= !self.open.is_empty() || self.sub.is_some();
        self.routines.is_reached(false);
        self.dead = true;
    }

    /// Whether a definition of this name stands above.
    pub(super) fn is_defined(&self, label: &str) -> bool {
        self.defined.contains(label)
    }

    /// What is read stands between `sub` and `endsub`.
    pub(super) fn is_in_definition(&self) -> bool {
        self.sub.is_some()
    }

    /// The break of a step is a call.
    pub(super) fn called(&mut self, at: usize, entry: &Entry) {
        self.calls += 1;
        if !(entry.certain && entry.once) {
            self.routines.called_otherwise(entry.name.clone());
        }
        if entry.certain {
            self.routines.called(at, entry.name.clone());
        }
    }

    /// A line that steers the order of blocks, with the step of its break.
    pub(super) fn line(&mut self, line: Line, at: usize, script: &Script) {
        match line {
            Line::Loop { label, .. } if self.is_do(&label) => self.close(&label, at, script),
            Line::Loop { label, entered } => self.open.push(Open { label, at, kind: Kind::Loop { entered } }),
            Line::Do { label } => self.open.push(Open { label, at, kind: Kind::Do }),
            Line::If { label } => {
                self.joins.push(Join { at, from: vec![at] });
                self.open.push(Open { label, at, kind: Kind::If { ends: Vec::new(), whole: false } });
            }
            Line::Else { label, whole: last } => match self.open.last_mut() {
                Some(Open { label: own, at: first, kind: Kind::If { ends, whole } }) if *own == label && !*whole => {
                    self.joins.push(Join { at, from: vec![*first] });
                    ends.push(at);
                    *whole = last;
                }
                _ => self.unknown = true,
            },
            Line::EndLoop { label } | Line::EndIf { label } => self.close(&label, at, script),
            Line::GoesOn => self.joins.push(Join { at, from: vec![at] }),
            Line::Away => self.unknown = true,
        }
    }

    /// The innermost block is a `do` of this label.
    fn is_do(&self, label: &str) -> bool {
        self.open.last().is_some_and(|open| open.label == label && matches!(open.kind, Kind::Do))
    }

    /// The end of the innermost loop or condition.
    fn close(&mut self, label: &str, at: usize, script: &Script) {
        let Some(Open { at: open, kind, .. }) = self.open.pop().filter(|open| open.label == label) else {
            self.unknown = true;
            return;
        };
        let breaks = |k: usize| matches!(script.steps.get(k).map(|s| &s.kind), Some(StepKind::Break(_)));
        let entered = match kind {
            Kind::Loop { entered } => entered,
            Kind::Do => true,
            Kind::If { ends, whole } => {
                let from = ends.into_iter().chain([at]).chain((!whole).then_some(open)).collect();
                self.joins.push(Join { at, from });
                return;
            }
        };
        if entered && !(open + 1..at).any(breaks) {
            self.rounds.push(Round { open, close: at, goes_on: true });
        }
        self.joins.push(Join { at: open, from: vec![open, at] });
        self.joins.push(Join { at, from: if entered { vec![at] } else { vec![open, at] } });
    }

    /// Gives what is known to a script; see [`Around`].
    pub(super) fn settle(mut self, around: &Around, script: &mut Script) {
        script.entry = self.entry.filter(|_| !around.repeats);
        self.stops(around.called);
        if self.unknown || self.sub.is_some() || !self.open.is_empty() || !around.by_text {
            return;
        }
        let mut joins = self.joins;
        // a call that stands beside another word of its kind may not be here
        if around.calls == Some(self.calls) {
            joins.extend(self.routines.entered());
            joins.extend(self.routines.joins(script.steps.len()));
        }
        self.rounds.sort_by_key(|r| r.open);
        (script.rounds, script.joins) = (self.rounds, joins);
        through_still(script);
    }
}

/// What a look over the text finds that the order depends on.
pub(super) struct Around<'a> {
    /// Programs that are called.
    pub(super) called: &'a BTreeSet<String>,
    /// The text may run again from its start.
    pub(super) repeats: bool,
    /// Nothing leads elsewhere than the text says.
    pub(super) by_text: bool,
    /// How many calls of its programs the text has, where all that it calls stands in it.
    pub(super) calls: Option<usize>,
}
