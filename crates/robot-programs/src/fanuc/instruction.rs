//! Instructions that are no motion: which of them stop, jump, call, or change frames.

use super::motion;
use super::statement::{has, name_of};
use crate::script::held::Event;
use crate::script::lex::text_of;
use crate::script::{Break, StepKind, Text, number};
use std::ops::Range;

/// Registers, inputs and outputs. They are written with their index; without a bracket the word begins a macro's name
/// (`GO HOME`, `R HOME`), and macros move.
const INDEXED: [&[u8]; 29] = [
    b"DO", b"DI", b"RO", b"RI", b"GO", b"GI", b"AO", b"AI", b"SO", b"SI", b"UO", b"UI", b"WO", b"WI", b"R", b"SR",
    b"PR", b"P", b"PL", b"F", b"M", b"AR", b"TIMER", b"PAYLOAD", b"MESSAGE", b"UALM", b"SPOT",
    // in German: an output, the load
    b"A", b"TRAGLST",
];

/// Settings that neither move nor jump: with `=` or an index after them.
const SETTINGS: [&[u8]; 6] =
    [b"OVERRIDE", b"RSR", b"ERROR_PROG", b"RESUME_PROG", b"JOINT_MAX_SPEED", b"LINEAR_MAX_SPEED"];

/// A statement that is no motion: what it means for the joints' directions.
///
/// `instruction = wait | "PAUSE" | jump | block | "CALL" ... | frame | process | signal | setting | macro`,
/// `wait = ("WAIT" | "WARTE") (seconds | condition)`
pub(super) fn read(text: &Text, words: &[Range<usize>]) -> Option<StepKind> {
    let first = text.slice(words.first()?.clone()).to_ascii_uppercase();
    let name = name_of(&first);
    let second = words.get(1).map(|w| text.slice(w.clone()).to_ascii_uppercase()).unwrap_or_default();
    let on = |kind| Some(StepKind::Break(kind));
    if let Some(process) = motion::process(&first).or_else(|| motion::process(&second).filter(|_| words.len() == 2)) {
        return Some(StepKind::Process(process));
    }
    match name {
        b"WAIT" | b"WARTE" if waits_for(&second) => Some(StepKind::Dwell(seconds(text, words))),
        b"PAUSE" if words.len() == 1 => Some(StepKind::Dwell(None)),
        b"LBL" | b"MRK" | b"JMP" | b"SPRUNG" | b"IF" | b"WENN" | b"ELSE" | b"ENDIF" | b"SELECT" | b"END" | b"ABORT" => {
            on(Break::Jump)
        }
        b"FOR" | b"ENDFOR" => on(Break::Loop),
        b"CALL" | b"RUN" | b"AUFRUF" => on(Break::Call),
        b"MONITOR" => on(Break::Interrupt),
        // positions name the frame and the tool for which they are taught, and no others may be selected on the way to them
        b"UFRAME_NUM" | b"UTOOL_NUM" | b"BENUTZER_NUM" | b"WKZ_NUM" => None,
        b"UFRAME" | b"UTOOL" | b"OFFSET" | b"TOOL_OFFSET" => on(Break::Frame),
        b"COL" if second.starts_with(b"DETECT") || second.starts_with(b"GUARD") => None,
        b"SKIP" if second.starts_with(b"CONDITION") => None,
        b"" if first.starts_with(b"$") && ["FRAME", "TOOL"].iter().any(|n| has(&first, n.as_bytes())) => {
            on(Break::Frame)
        }
        b"" if first.starts_with(b"$") => None,
        b"STOP_TRACKING" if words.len() == 1 => on(Break::Frame),
        b"" => on(Break::Jump),
        _ if quiet(name, &first[name.len()..], &second, words.len()) && !jumps(text, words) => None,
        _ => on(Break::Call),
    }
}

/// Whether a statement gives an output or a register a value: `DO[1]=ON`, `R[2]=R[2]+1`; upper case.
///
/// `assignment = register "[" index "]" "=" value`
pub(super) fn assigns(statement: &[u8]) -> bool {
    let name = &statement[..memchr::memchr(b'[', statement).unwrap_or(0)];
    let more = [&b"LBL["[..], b"MRK[", b"CALL", b"AUFRUF"].iter().any(|l| has(statement, l));
    INDEXED.contains(&name) && memchr::memchr(b'=', statement).is_some() && !more
}

/// Whether a position register is added to a goal anywhere.
///
/// `offset = "OFFSET" ["," | blank] "PR" "[" ...`
pub(super) fn has_offsets(text: &Text) -> bool {
    const WORDS: [&[u8]; 2] = [b"OFFSET,PR", b"OFFSET PR"];
    let ends = |at: usize| {
        let before = at.checked_sub(WORDS[0].len()).and_then(|from| text.bytes.get(from..at));
        before.is_some_and(|b| WORDS.iter().any(|word| b.eq_ignore_ascii_case(word)))
    };
    memchr::memchr_iter(b'[', &text.bytes).any(ends)
}

/// The position register that a statement gives a value, `pr[5` of `PR[5,1]=PR[5,1]+50`; `pr`: any of them. Offsets are made of it.
///
/// `setting = ... "PR" "[" index ["," index] "]" "=" ...`
pub(super) fn register_set(text: &Text, words: &[Range<usize>]) -> Option<String> {
    let whole: Vec<u8> = words.iter().flat_map(|w| text.slice(w.clone())).map(u8::to_ascii_uppercase).collect();
    let sets = |at: usize| {
        let inside = whole.get(at..)?;
        // the index may be a register itself
        let mut depth = 0_usize;
        let closes = |b: &u8| {
            depth = match b {
                b'[' => depth + 1,
                b']' => depth.saturating_sub(1),
                _ => depth,
            };
            *b == b']' && depth == 0
        };
        let end = inside.iter().position(closes)?;
        (inside.get(end + 1) == Some(&b'=')).then_some(inside)
    };
    let first = memchr::memmem::find_iter(&whole, b"PR[").find_map(sets)?;
    let digits: Vec<u8> = first.iter().skip(3).take_while(|b| b.is_ascii_digit()).copied().collect();
    Some(if digits.is_empty() { "pr".into() } else { format!("pr[{}", text_of(&digits)) })
}

/// Whether an instruction neither moves nor jumps: its first word, what stands after it in that word, the second word, and
/// how many words there are.
///
/// `quiet = ("LOCK" | "UNLOCK") "PREG" | "TC_ONLINE" ("(" ... | "ENABLE" | "DISABLE") | "WEAVE" ("[" ... | "END") | register "[" ... | setting ("[" | "=") ...`
fn quiet(name: &[u8], rest: &[u8], second: &[u8], words: usize) -> bool {
    let after = rest.first().or(second.first()).copied();
    match name {
        b"LOCK" | b"UNLOCK" => second == b"PREG" && words == 2,
        b"TC_ONLINE" => second.starts_with(b"(") || matches!(second, b"ENABLE" | b"DISABLE"),
        b"WEAVE" => second.contains(&b'[') || second == b"END" && words == 2,
        _ if INDEXED.contains(&name) => after == Some(b'['),
        _ => SETTINGS.contains(&name) && matches!(after, Some(b'[' | b'=')),
    }
}

/// The name of the macro that a statement may be, one blank between its words; upper case. A macro has a name of any words: the statement
/// is known by none of its own, holds no index and gives nothing a value.
///
/// `macro = word {word} ["(" arguments ")"]`
pub(super) fn macro_name(text: &Text, words: &[Range<usize>]) -> Option<String> {
    let whole: Vec<Vec<u8>> = words.iter().map(|w| text.slice(w.clone()).to_ascii_uppercase()).collect();
    let whole = whole.join(&b' ');
    let open = memchr::memchr(b'(', &whole).unwrap_or(whole.len());
    let (name, arguments) = (whole[..open].trim_ascii(), whole[open..].trim_ascii());
    let first = name.split(|b| *b == b' ').next().unwrap_or_default();
    let known = matches!(first, b"CALL" | b"AUFRUF" | b"RUN" | b"MONITOR");
    let plain = |b: &u8| b.is_ascii_alphanumeric() || b" _-.".contains(b) || !b.is_ascii();
    let is_name = name.first().is_some_and(|b| b.is_ascii_alphabetic() || !b.is_ascii()) && name.iter().all(plain);
    let whole_call = arguments.is_empty() || arguments.ends_with(b")");
    let call = matches!(read(text, words), Some(StepKind::Break(Break::Call)));
    (is_name && whole_call && !known && call).then(|| text_of(name).into_owned())
}

/// What a WAIT waits for: a time, a signal, a condition. Another word is part of a macro's name (`WAIT HOME`).
///
/// `condition = signal "[" ... | number | "." ... | "(" ... | "$" ... | "!" ...`
fn waits_for(second: &[u8]) -> bool {
    second.contains(&b'[') || second.first().is_some_and(|b| b.is_ascii_digit() || b".($!".contains(b))
}

/// What leads the robot away from its positions, by the word that begins it.
const LEADS: [(&str, &str); 5] = [
    ("TOUCH", "the offset of a touched part"),
    ("WEAVE", "a weaving pattern"),
    ("TRACK", "a seam that is tracked"),
    ("SOFTFLOAT", "a soft servo"),
    ("MP", "the offset of a pass"),
];

/// The first of the things, as bits, that lead the robot.
pub(super) fn led_by(bits: u32) -> Option<&'static str> {
    LEADS.iter().enumerate().find(|(k, _)| bits & 1 << k != 0).map(|(_, lead)| lead.1)
}

/// Whether an instruction begins (`On`) or ends (`Off`) to lead the robot away from its positions, and by what.
///
/// `lead = ("WEAVE" | "TRACK" | "SOFTFLOAT" | "MP") ("[" ... | {word} "END" ["[" ...] | {word} "{" ...)`
pub(super) fn leads(text: &Text, words: &[Range<usize>]) -> Option<Event> {
    let mut all = words.iter().map(|w| text.slice(w.clone()).to_ascii_uppercase());
    let first = all.next()?;
    let name = &first[..memchr::memchr(b'[', &first).unwrap_or(first.len())];
    let bit = 1 << LEADS.iter().position(|lead| lead.0.as_bytes() == name)?;
    let rest: Vec<Vec<u8>> = all.collect();
    // a macro may be called `Track part`
    let named = first.len() > name.len() || rest.iter().any(|w| w.contains(&b'[') || w.starts_with(b"{"));
    let ends = rest.last().is_some_and(|w| w == b"END" || w.starts_with(b"END["));
    (named || ends).then_some(if ends { Event::Off(bit) } else { Event::On(bit) })
}

/// An action at the end of an instruction that does not move may jump or call: `PR[1]=LPOS,JMP LBL[1]` is none, but costs nothing to see.
fn jumps(text: &Text, words: &[Range<usize>]) -> bool {
    words.iter().any(|w| ["LBL[", "MRK[", ",CALL", ",AUFRUF"].iter().any(|l| has(text.slice(w.clone()), l.as_bytes())))
}

/// `WAIT   .50(sec)`.
///
/// `seconds = number ("(sec)" | "sec" | "(sek)" | "sek")`
fn seconds(text: &Text, words: &[Range<usize>]) -> Option<f64> {
    let word = String::from_utf8_lossy(text.slice(words.get(1)?.clone())).to_ascii_lowercase();
    let value = ["(sec)", "sec", "(sek)", "sek"].iter().find_map(|unit| word.strip_suffix(unit))?;
    number::read(value.as_bytes()).map(|v| v.0).filter(|v| *v >= 0.0)
}
