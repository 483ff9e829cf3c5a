//! Routines of the program and of its project that move nothing: a call of one ends nothing that is known of the joints.
//!
//! `DEF name(...)` ... `END` and `DEFFCT type name(...)` ... `ENDFCT`, with what stands between them. A routine moves nothing where it has
//! no motion word, no interrupt or trigger, gives no value to a variable of the controller but those of outputs, flags and timers (frames,
//! speeds and orientations are of them), and calls only built-in functions and routines of which the same holds. A name that
//! several routines have is still where all of them are.
//!
//! A routine that sets speeds, frames, loads and orientations besides leaves the robot where it stands, but not what points mean.

use super::calls::{calls, is_quiet, quiet};
use super::lex::{Kind, Token, begins_with, first_word, in_upper, tokens};
use super::motion;
use super::project::is_read;
use super::statement::{assignment, is_routine, routine_name};
use crate::no_motion::NoMotion;
use crate::script::Text;
use crate::script::called::{Needs, stem_of};
use std::collections::{BTreeMap, BTreeSet};

/// Variables of the controller that steer neither the arm nor what points mean.
const PLAIN: [&str; 11] = [
    "$OUT",
    "$FLAG",
    "$CYCFLAG",
    "$TIMER",
    "$TIMER_STOP",
    "$TIMER_FLAG",
    "$ANOUT",
    "$ADVANCE",
    "$MSG_T",
    "$LOOP_MSG",
    "$OV_PRO",
];

/// Variables of the controller that a routine may set where the robot stays: speeds, frames, loads, and how it goes to its points.
const SETTINGS: [&str; 18] = [
    "$VEL",
    "$VEL_AXIS",
    "$VEL_EXTAX",
    "$ACC",
    "$ACC_AXIS",
    "$ACC_EXTAX",
    "$APO",
    "$BASE",
    "$TOOL",
    "$LOAD",
    "$IPO_MODE",
    "$ORI_TYPE",
    "$CIRC_TYPE",
    "FDAT_ACT",
    "LDAT_ACT",
    "PDAT_ACT",
    "BASE_DATA",
    "TOOL_DATA",
];

/// What a routine does.
#[derive(Debug, Clone, Default)]
struct Does {
    name: String,
    moves: bool,
    /// It sets what points mean, or how the robot goes to them.
    sets: bool,
    waits: bool,
    calls: BTreeSet<String>,
}

/// The routines of a text.
#[derive(Debug, Default)]
struct Routines(Vec<Does>);

impl Routines {
    /// Reads what the routines of a text do.
    ///
    /// `routine = ["GLOBAL"] ("DEF" | "DEFFCT") ... name "(" ... {statement}`
    fn of(text: &Text) -> Self {
        let mut all: Vec<Does> = Vec::new();
        let mut line = Vec::new();
        for k in 0..text.line_count() {
            // of a routine that moves nothing else counts, nor what stands before the first one
            let counts = all.last().is_some_and(|routine| !routine.moves);
            if !(counts || begins_with(text, k, b"DG") && may_begin_routine(first_word(text, k))) {
                continue;
            }
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let Some(first) = line.first() else { continue };
            let (word, second) = (in_upper(text, first), line.get(1).map(|t| in_upper(text, t)).unwrap_or_default());
            if is_routine(&word, &second) {
                all.push(Does { name: routine_name(text, &line), ..Does::default() });
            } else if let Some(routine) = all.last_mut() {
                match sets(&line, &word) {
                    true => routine.sets = true,
                    false => routine.moves |= acts(text, &line, &word, &second),
                }
                routine.waits |= matches!(&*word, "WAIT" | "HALT");
                routine.calls.extend(calls(text, &line));
            }
        }
        Self(all)
    }
}

/// Whether a line that begins with this word may begin a routine.
pub(super) fn may_begin_routine(word: &[u8]) -> bool {
    ["DEF", "DEFFCT", "GLOBAL"].iter().any(|w| word.eq_ignore_ascii_case(w.as_bytes()))
}

/// Words that begin statements which move nothing themselves.
const STILL: [&str; 46] = [
    "IF",
    "ELSE",
    "ENDIF",
    "SWITCH",
    "CASE",
    "DEFAULT",
    "ENDSWITCH",
    "GOTO",
    "EXIT",
    "RETURN",
    "END",
    "ENDFCT",
    "LOOP",
    "ENDLOOP",
    "FOR",
    "ENDFOR",
    "WHILE",
    "ENDWHILE",
    "REPEAT",
    "UNTIL",
    "WAIT",
    "HALT",
    "DECL",
    "CONST",
    "INT",
    "REAL",
    "BOOL",
    "CHAR",
    "E6AXIS",
    "AXIS",
    "E6POS",
    "POS",
    "FRAME",
    "FDAT",
    "PDAT",
    "LDAT",
    "STRUC",
    "ENUM",
    "SIGNAL",
    "EXT",
    "EXTP",
    "EXTFCT",
    "IMPORT",
    "CONTINUE",
    "ON_ERROR_PROCEED",
    "GLOBAL",
];

/// Whether a statement sets what points mean, or how the robot goes to them, and does nothing else besides what it calls.
///
/// `setting = ("$VEL" | "$BASE" | ...) ... "=" ... | "BAS" ...`
fn sets(line: &[Token], word: &str) -> bool {
    word == "BAS" || assignment(line).is_some() && SETTINGS.contains(&word)
}

/// Whether a statement may move the arm, or what its points mean, besides what it calls.
///
/// `statement = assignment | name ":" | name "(" ... | "BAS" ... | motion | ... "CONVEYOR" ... | word ...`
fn acts(text: &Text, line: &[Token], word: &str, second: &str) -> bool {
    let unknown = || {
        let label = line.len() == 2 && line[1].is(b':');
        let call = line.get(1).is_some_and(|t| t.is(b'('));
        !(label || call || STILL.contains(&word)) || word == "GLOBAL" && second == "INTERRUPT"
    };
    if assignment(line).is_some() {
        let data = ["BASE_DATA", "TOOL_DATA", "FDAT_ACT", "LDAT_ACT", "PDAT_ACT"].contains(&word);
        return data || word.starts_with('$') && !PLAIN.contains(&word);
    }
    // RSI_ON is a function: what it returns is assigned, and it is none that is known
    let calls = |name: &str| line.iter().any(|t| in_upper(text, t) == name);
    word == "BAS" || motion::word(word).is_some() || calls("CONVEYOR") || unknown()
}

/// Names of routines that move nothing; whether they wait.
#[derive(Debug, Default)]
pub(super) struct Still {
    names: BTreeMap<String, bool>,
    /// Those that set what points mean besides.
    sets: BTreeSet<String>,
    /// Routines of the program that may move, under the name of a function that does not.
    hidden: BTreeSet<String>,
    /// What they call, and what the user says of names without a text.
    needs: Needs,
}

impl Still {
    pub(super) fn of(texts: &[Text], declared: &NoMotion) -> Self {
        let known: Vec<_> = texts.iter().map(|t| t.known(Routines::of)).collect();
        let mut by_name: BTreeMap<&str, Vec<&Does>> = BTreeMap::new();
        for does in known.iter().flat_map(|r| &r.0) {
            by_name.entry(&does.name).or_default().push(does);
        }
        let mut needs = Needs::new(declared);
        for does in by_name.values().flatten() {
            needs.add(&does.name, does.moves, does.calls.iter().cloned());
        }
        // a file that cannot be read counts more than what is declared of its name
        texts.iter().filter(|t| t.context && !is_read(t)).for_each(|t| needs.is_there(&stem_of(t)));
        by_name.retain(|_, all| all.iter().all(|d| !d.moves));
        let mut still: BTreeMap<String, bool> = BTreeMap::new();
        loop {
            let before = still.len();
            for (name, all) in &by_name {
                let is_still = |c: &String| still.contains_key(c) || needs.is_declared(c);
                let settled = all.iter().flat_map(|d| &d.calls).all(is_still);
                if settled && !still.contains_key(*name) {
                    // one that the user declares may wait
                    let waits = |c: &String| still.get(c).copied().unwrap_or(true);
                    let waits = all.iter().any(|d| d.waits || d.calls.iter().any(waits));
                    still.insert((*name).to_string(), waits);
                }
            }
            if still.len() == before {
                break;
            }
        }
        // a routine of the program that has the name of a function is called in its place
        let own = known.first().map(|r| r.0.as_slice()).unwrap_or_default();
        let hides = |d: &&Does| is_quiet(&d.name) && !still.contains_key(&d.name);
        let hidden: BTreeSet<String> = own.iter().filter(hides).map(|d| d.name.clone()).collect();
        if !hidden.is_empty() {
            return Self { hidden, ..Self::default() };
        }
        let mut sets = setting(by_name.values().flatten().copied().collect());
        // one that calls what may move does not leave the robot where it stands
        sets.retain(|name| still.contains_key(name));
        still.retain(|name, _| !sets.contains(name));
        Self { names: still, sets, hidden, needs }
    }

    /// Whether a line calls a routine of the program that may move, under the name of a function that does not.
    pub(super) fn hides(&self, text: &Text, line: &[Token]) -> bool {
        !self.hidden.is_empty() && quiet(text, line).any(|name| self.hidden.contains(&name))
    }

    /// Whether the routine of this name leaves the robot where it stands, but sets what points mean, or how it goes to them.
    pub(super) fn sets(&self, name: &str) -> bool {
        self.sets.contains(name)
    }

    /// Whether the routine of this name moves nothing, sets nothing, and then whether it waits.
    pub(super) fn waits(&self, name: &str) -> Option<bool> {
        self.names.get(name).copied().or_else(|| self.needs.is_declared(name).then_some(true))
    }

    /// What has to be known of the routines to tell what moves nothing.
    pub(super) fn needs(&self) -> &Needs {
        &self.needs
    }
}

/// Those of the routines that set what points mean, themselves or by what they call.
fn setting(routines: Vec<&Does>) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = routines.iter().filter(|d| d.sets).map(|d| d.name.clone()).collect();
    loop {
        let calls = |d: &&&Does| !found.contains(&d.name) && d.calls.iter().any(|c| found.contains(c));
        let Some(next) = routines.iter().find(calls).map(|d| d.name.clone()) else { return found };
        found.insert(next);
    }
}
