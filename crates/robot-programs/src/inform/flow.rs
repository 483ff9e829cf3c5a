//! What an instruction that is no move means for the next one: whether it goes on there, jumps away, opens a block; and jobs that move
//! nothing.
//!
//! A jump with a condition leaves the next instruction reached as before: only its label is reached from elsewhere.

use super::facts::reads_place;
use super::shared::job_name;
use super::words::{OVERLAID, PlainMoves, begin_of, is_known, sets_frame, stands, still, upper_words};
use crate::no_motion::NoMotion;
use crate::script::called::{Called, Does, stem_of};
use crate::script::held::{self, Effects, Event};
use crate::script::last;
use crate::script::{Break, Text};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Flow {
    Label(String),
    /// `label`: where it leads; `None`: out of the job.
    Jump {
        label: Option<String>,
        always: bool,
    },
    Open(Break),
    Middle,
    Close(Break),
    Call(String),
    /// A further condition of what opened the block.
    Condition,
    /// All else.
    Other,
}

/// The job that a word names: `JOB:NAME`.
///
/// `job = "JOB:" name ["(" ...]`
fn job_of(word: &str) -> Option<String> {
    let name = word.strip_prefix("JOB:")?.split('(').next()?;
    (!name.is_empty()).then(|| name.to_string())
}

/// The job that an instruction goes to, by its words in upper case.
///
/// `to = ("JUMP" | "CALL") job ...`
pub(super) fn to_job(words: &[String]) -> Option<String> {
    let [first, second, ..] = words else { return None };
    job_of(second).filter(|_| matches!(first.as_str(), "JUMP" | "CALL"))
}

/// An instruction by its words, in upper case.
///
/// `flow = label | jump | "RET" ["IF" ...] | "CALL" job ... | block`,
/// `label = "*" name`, `jump = "JUMP" (label | job) ["IF" ...]`
/// `block = ("IFTHEN" | "IFTHENEXP" | "SWITCH" | "WHILE" | "WHILEEXP" | "FOR") ... | ("ELSEIF" | "ELSEIFEXP") ... | "ELSE" | "CASE" value | "DEFAULT"`,
/// `block = "ENDIF" | "ENDSWITCH" | "ENDWHILE" | "NEXT" ... | ("ANDIF" | "ORIF") ...`
pub(super) fn read(words: &[String]) -> Flow {
    let Some(first) = words.first().map(String::as_str) else { return Flow::Other };
    let second = words.get(1).map(String::as_str).unwrap_or_default();
    let conditional = words.iter().any(|w| w == "IF");
    match first {
        label if label.starts_with('*') && words.len() == 1 => Flow::Label(label.into()),
        "JUMP" if second.starts_with('*') => Flow::Jump { label: Some(second.into()), always: !conditional },
        "JUMP" if job_of(second).is_some() => Flow::Jump { label: None, always: !conditional },
        "RET" => Flow::Jump { label: None, always: !conditional },
        "CALL" => job_of(second).map_or(Flow::Other, Flow::Call),
        "IFTHEN" | "IFTHENEXP" | "SWITCH" => Flow::Open(Break::Jump),
        "WHILE" | "WHILEEXP" | "FOR" => Flow::Open(Break::Loop),
        "ELSEIF" | "ELSEIFEXP" => Flow::Middle,
        "ELSE" | "DEFAULT" if words.len() == 1 => Flow::Middle,
        "CASE" if words.len() == 2 => Flow::Middle,
        "ENDIF" | "ENDSWITCH" if words.len() == 1 => Flow::Close(Break::Jump),
        "ENDWHILE" if words.len() == 1 => Flow::Close(Break::Loop),
        "NEXT" => Flow::Close(Break::Loop),
        "ANDIF" | "ORIF" => Flow::Condition,
        _ => Flow::Other,
    }
}

/// What a job does; one that cannot be read may do anything.
///
/// `instruction = "CALL" job ... | "JUMP" job ... | flow | word {word}`
fn does(text: &Text) -> Does {
    let (Some(name), Some(begin), false) = (job_name(text), begin_of(text), text.unread) else {
        return Does { moves: true, file: stem_of(text), ..Does::default() };
    };
    let mut does = Does { name, file: stem_of(text), ..Does::default() };
    for k in begin..text.line_count() {
        let words = upper_words(text, k);
        match read(&words) {
            _ if words.is_empty() => {}
            Flow::Call(name) => drop(does.calls.insert(name)),
            // what the other job does is done here
            Flow::Jump { label: None, .. } if words[0] == "JUMP" => {
                does.calls.extend(words.get(1).and_then(|w| job_of(w)));
            }
            Flow::Other if stands(&words[0]) => does.waits = true,
            Flow::Other if is_macro(text, k, &words) => does.macros.extend(words.into_iter().next()),
            Flow::Other => {
                does.reads |= reads_place(text.line(k));
                does.moves |= !still(text, k, &words);
                does.counts |= words[0].contains("IMOV");
            }
            _ => {}
        }
    }
    does
}

/// Whether an instruction is not known, and may be a macro, which the user may know: it sets no frame and no position by its own words.
///
/// `macro = letter {letter | digit | "_" | "-"} ...`
pub(super) fn is_macro(text: &Text, k: usize, words: &[String]) -> bool {
    let name = |w: &String| {
        w.starts_with(|c: char| c.is_alphabetic()) && w.chars().all(|c| c.is_alphanumeric() || "_-".contains(c))
    };
    words.first().is_some_and(|w| name(w) && !is_known(w)) && sets_frame(text, k).is_empty()
}

/// What the jobs beside one do; `declared`: names that move nothing, where no file has them.
pub(super) fn beside(own: &Text, texts: &[Text], declared: &NoMotion) -> Called {
    let names: Vec<String> = [Some(stem_of(own)), job_name(own)].into_iter().flatten().collect();
    Called::of(&texts.iter().map(|t| t.known(does)).collect::<Vec<_>>(), &names, declared)
}

/// The instructions of a job as what they switch on and off, and the first of them of each line from `begin` on.
///
/// `instruction = on | off | flow | "JUMP" ... | {word | label}`
fn events(text: &Text, begin: usize) -> (Vec<Event>, Vec<usize>) {
    let (mut events, mut first, plain) = (Vec::new(), Vec::new(), PlainMoves::of(text));
    for k in begin..text.line_count() {
        first.push(events.len());
        if plain.has(k) {
            events.push(Event::Other);
            continue;
        }
        let words = upper_words(text, k);
        let word = words.first().map(String::as_str).unwrap_or_default();
        let bit = |k: usize| 1 << k;
        let turned = OVERLAID.iter().enumerate().find_map(|(k, (on, off))| {
            (word == *on).then(|| Event::On(bit(k))).or_else(|| (word == *off).then(|| Event::Off(bit(k))))
        });
        let to = |word: &String| Event::Jump(Some(word.clone()));
        let event = match read(&words) {
            _ if turned.is_some() => turned.unwrap_or_default(),
            Flow::Label(name) => Event::Label(name),
            Flow::Jump { label: Some(label), .. } => to(&label),
            Flow::Jump { label: None, .. } => {
                // what the other job does is done before this one ends
                let job = words.get(1).filter(|_| word == "JUMP").and_then(|w| job_of(w));
                events.push(Event::Open(false));
                events.extend(job.map(Event::Call));
                events.push(Event::End);
                Event::Close
            }
            Flow::Open(kind) => Event::Open(kind == Break::Loop),
            Flow::Middle => Event::Middle,
            Flow::Close(_) => Event::Close,
            Flow::Call(name) if words.len() > 2 => {
                events.extend([Event::Open(false), Event::Call(name)]);
                Event::Close
            }
            Flow::Call(name) => Event::Call(name),
            // a label that is computed may be any
            Flow::Other if word == "JUMP" => Event::Jump(None),
            Flow::Other => {
                let labels = words.iter().filter(|w| w.starts_with('*'));
                events.extend(labels.flat_map(|name| [to(name), Event::Label(name.clone())]));
                Event::Other
            }
            _ => Event::Other,
        };
        events.push(event);
    }
    (events, first)
}

/// The jobs that a job runs, itself or by others, of those `beside` it.
pub(super) fn run_by<'a>(text: &Text, beside: &'a [Text]) -> Vec<&'a Text> {
    if beside.is_empty() {
        return Vec::new();
    }
    let mut open: Vec<String> = does(text).calls.into_iter().collect();
    let mut found: Vec<&Text> = Vec::new();
    while let Some(name) = open.pop() {
        for job in beside {
            let does = job.known(does);
            if does.name == name && !found.iter().any(|f| std::ptr::eq(*f, job)) {
                found.push(job);
                open.extend(does.calls.iter().cloned());
            }
        }
    }
    found
}

/// A job under its name, and what it switches on and off.
fn switches(text: &Text) -> Option<(String, Vec<Event>)> {
    Some((job_name(text)?, events(text, begin_of(text)?).0))
}

/// Overlaid motions (bits, in the order of [`OVERLAID`]) that may be on before each line, whichever way the job came there, and whatever
/// the jobs do that are `run` from it; empty: never.
pub(super) fn overlaid_before(text: &Text, begin: usize, run: &[&Text]) -> Vec<u32> {
    let named = |text: &Text, word: &str| memchr::memmem::find(&text.bytes, word.as_bytes()).is_some();
    let any = |text: &Text| OVERLAID.iter().any(|(on, off)| named(text, on) || named(text, off));
    if !any(text) && !run.iter().any(|job| any(job)) {
        return Vec::new();
    }
    let jobs: Vec<_> = run.iter().map(|t| t.known(switches)).filter_map(|job| (*job).clone()).collect();
    let (events, mut lines) = events(text, begin);
    let mut first = vec![0; begin];
    first.append(&mut lines);
    let states = held::before_each(&events, held::from_before(&events), &Effects::of(&jobs));
    first.into_iter().map(|k| states.get(k).copied().unwrap_or_default()).collect()
}

/// Lines, from 1, of the `moves` after which the job may read where the robot stands, or call one of the `jobs` that do; instructions begin
/// at line `begin`.
pub(super) fn last_before(text: &Text, begin: usize, moves: &BTreeSet<u64>, jobs: &Called) -> BTreeSet<u64> {
    let calls = |k: usize| {
        let words = upper_words(text, k);
        matches!(read(&words), Flow::Call(name) if jobs.reads(&name))
    };
    let (plain, any) = (PlainMoves::of(text), reads_place(&text.bytes));
    let reads = |k: &usize| any && reads_place(text.line(*k)) || !plain.has(*k) && calls(*k);
    let asked: Vec<usize> = (begin..text.line_count()).filter(reads).map(|k| k - begin).collect();
    if asked.is_empty() {
        return BTreeSet::new();
    }
    let place = |line: &u64| (*line as usize).checked_sub(begin + 1);
    let (events, first) = events(text, begin);
    let found = last::before(&events, &first, &moves.iter().filter_map(place).collect(), &asked);
    found.into_iter().map(|place| (place + begin + 1) as u64).collect()
}

/// The line of each label, where a job has moves with which the next instruction runs; of two with one name the first.
///
/// `label = "*" name`
pub(super) fn labels(text: &Text, begin: usize) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    if memchr::memmem::find(&text.bytes, b"NWAIT").is_none() {
        return found;
    }
    for k in (begin..text.line_count()).filter(|k| text.line(*k).trim_ascii_start().starts_with(b"*")) {
        if let Flow::Label(name) = read(&upper_words(text, k)) {
            found.entry(name).or_insert(k);
        }
    }
    found
}

/// Whether the instruction that runs after line `k` is certainly a move, over labels and jumps without a condition.
///
/// `instruction = label | jump | move | word {word}`
pub(super) fn moves_next(text: &Text, k: usize, labels: &BTreeMap<String, usize>) -> bool {
    /// Lines that are looked at.
    const MOST: usize = 64;
    let mut next = k + 1;
    for _ in 0..MOST {
        if next >= text.line_count() {
            return false;
        }
        // a line of other groups belongs to the move before it
        let line = text.line(next).trim_ascii();
        if line.is_empty() || line.starts_with(b"'") || line.starts_with(b"+") {
            next += 1;
            continue;
        }
        let words = upper_words(text, next);
        next = match read(&words) {
            Flow::Label(_) => next + 1,
            Flow::Jump { label: Some(label), always: true } => match labels.get(&label) {
                Some(at) => *at,
                None => return false,
            },
            _ => return words.first().is_some_and(|word| word.contains("MOV") && !word.starts_with('*')),
        };
    }
    false
}

/// Labels to which nothing jumps but from instructions between which and the label nothing moves, and which are reached from above, too: a
/// job that waits there comes from where it stands.
///
/// `instruction = flow | "JUMP" ... | {word | label}`
pub(super) fn labels_reached_at_rest(text: &Text, begin: usize, jobs: &Called) -> BTreeSet<String> {
    let mut stretch = 0_u64;
    // in which stretch nothing leads on from above
    let mut ended = None;
    let mut defined: BTreeMap<String, Vec<Option<u64>>> = BTreeMap::new();
    // in which stretches labels are jumped to; `None`: in one that is not known
    let mut jumps: BTreeMap<String, BTreeSet<Option<u64>>> = BTreeMap::new();
    let plain = PlainMoves::of(text);
    for k in begin..text.line_count() {
        if plain.has(k) {
            stretch += 1;
            continue;
        }
        let words = upper_words(text, k);
        let busy = match read(&words) {
            _ if words.is_empty() => false,
            Flow::Label(name) => {
                defined.entry(name).or_default().push(Some(stretch).filter(|_| ended != Some(stretch)));
                false
            }
            Flow::Jump { label, always } => {
                if always {
                    ended = Some(stretch);
                }
                if let Some(label) = label {
                    jumps.entry(label).or_default().insert(Some(stretch));
                }
                false
            }
            Flow::Call(name) => jobs.waits(&name).is_none(),
            // a label that is computed may be any
            Flow::Other if words[0] == "JUMP" => return BTreeSet::new(),
            Flow::Other => {
                for label in words.iter().filter(|w| w.starts_with('*')) {
                    jumps.entry(label.clone()).or_default().insert(None);
                }
                let declared = is_macro(text, k, &words) && jobs.is_still_macro(&words[0]);
                !(stands(&words[0]) || still(text, k, &words) || declared)
            }
            _ => true,
        };
        stretch += u64::from(busy);
    }
    let quiet = |name: &String, at: &[Option<u64>]| match at {
        [Some(at)] => jumps.get(name).is_none_or(|from| from.iter().all(|stretch| *stretch == Some(*at))),
        _ => false,
    };
    defined.iter().filter(|(name, at)| quiet(name, at)).map(|(name, _)| name.clone()).collect()
}
