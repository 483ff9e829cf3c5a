//! A motion instruction: `J P[1] 100% FINE`, `L P[2:name] 100mm/sec CNT50 ACC80 TB .10sec,DO[1]=ON`, `C P[3] P[4] ...`.

use super::reason::Reason;
use super::statement::{Statement, has, index, is_position, is_register};
use super::triggers::{self, Action, Start};
use crate::script::cursor::strip_word;
use crate::script::{self, EndTrigger, Few, PathKind, Span, Speed, Text};
use std::ops::Range;

/// Where a motion stands and what it says besides its goal.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// The line on which it starts, its colon and its number.
    pub start: usize,
    pub colon: usize,
    pub number: Option<u64>,
    /// From after the colon to the goal.
    pub lead: Span,
    /// Digits of the goal's index.
    pub digits: Span,
    /// `FINE`, `CNT50`, `CNT R[1]`: from after the goal to its end; speed included.
    pub speed_and_end: Span,
    pub end_type: Span,
    /// `FINE`.
    pub exact: bool,
    /// Options that a copy of the motion repeats.
    pub kept: Few<Span>,
    /// Blanks and `;` at the end of the statement.
    pub tail: Span,
}

/// What a motion says.
pub(super) struct MotionInstruction {
    pub motion: Option<Motion>,
    pub path: PathKind,
    pub speed: Speed,
    pub blend_m: Option<f64>,
    /// Index of the goal's position; why it cannot be determined.
    pub goal: Result<u64, script::Reason>,
    /// Its goal is this position register.
    pub register: Option<u64>,
    /// It calls a program on its way.
    pub calls: bool,
    /// What it runs near its end.
    pub actions: Vec<Action>,
    /// What it starts before its end, where its way tells how far before.
    pub end_trigger: Option<EndTrigger>,
    /// The register of its offset.
    pub offset_by: Option<u64>,
    /// Positions of the statement whose numbers it needs as they are: the point on the way of an arc, and a goal that is
    /// moved by an offset or an increment.
    pub via: Vec<u64>,
    /// An offset of a position register is added to the goal, along the axes of the tool or not: its words.
    pub offset: Option<(bool, String)>,
    /// One of its positions is known only while the program runs: it may be any.
    pub any: bool,
    /// Its goal counts from where the motion before ends.
    pub relative: bool,
    pub closed: Option<script::Reason>,
    /// Welding goes on or off at the goal.
    pub process: Option<bool>,
    /// It may end before its goal, elsewhere in the program.
    pub skips: bool,
    /// Its way is straight for a part that another group moves.
    pub coordinated: bool,
    /// The wrist turns joint by joint on a straight way or an arc.
    pub wrist: bool,
}

/// The goal of a motion: the digits of its index where it is a position of the program.
///
/// `goal = "P[" index "]"`
fn read_goal(text: &Text, target: &Range<usize>, said: &mut MotionInstruction) -> Option<Range<usize>> {
    if is_register(text.slice(target.clone())) {
        said.goal = Err(Reason::Register.into());
        said.register = index(text, target.clone()).map(|i| i.1);
        return None;
    }
    if is_of_pallet(text.slice(target.clone())) {
        said.goal = Err(Reason::OfPallet.into());
        return None;
    }
    if !is_position(text.slice(target.clone())) {
        said.goal = Err(Reason::NoPosition.into());
        return None;
    }
    let found = index(text, target.clone());
    said.any |= found.is_none();
    said.goal = found.as_ref().map(|i| i.1).ok_or_else(|| Reason::IndexComputed.into());
    found.map(|i| i.0)
}

/// `PAL_3[A_1]`, `PAL_3[BTM]`, `PAL_3[R_1]`: a point of palletizing.
///
/// `pallet = "PAL_" number "[" ...`
fn is_of_pallet(word: &[u8]) -> bool {
    strip_word(word, b"PAL_").is_some_and(|rest| {
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        digits > 0 && rest.get(digits) == Some(&b'[')
    })
}

/// FINE, CNT, CD or CR.
///
/// `termination = "FINE" | "CNT..." | "CD..." | "CR..."`
fn is_termination(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"FINE")
        || [&b"CNT"[..], b"CD", b"CR"].iter().any(|named| strip_word(word, named).is_some())
}

impl MotionInstruction {
    /// Whether the goal cannot be determined for no other reason than that it is a register.
    pub fn is_register(&self, why: &script::Reason) -> bool {
        self.register.is_some() && matches!(why, script::Reason::Fanuc(why) if **why == Reason::Register)
    }

    /// A motion of which nothing is read yet.
    fn new() -> Self {
        Self {
            motion: None,
            path: PathKind::Curve,
            speed: Speed::Unknown,
            blend_m: None,
            goal: Err(script::Reason::NoGoal),
            register: None,
            calls: false,
            actions: Vec::new(),
            end_trigger: None,
            offset_by: None,
            via: Vec::new(),
            offset: None,
            any: false,
            relative: false,
            closed: None,
            process: None,
            skips: false,
            coordinated: false,
            wrist: false,
        }
    }
}

/// Reads a statement as a motion; `None`: it is none.
///
/// `motion = ("J" | "L" | "A" | "C" via) goal speed termination {option} ";"`, `goal = position | register | pallet`
pub(super) fn read(text: &Text, statement: &Statement, words: &[Range<usize>]) -> Option<MotionInstruction> {
    let word = |k: usize| words.get(k).map_or(&[][..], |w| text.slice(w.clone()));
    let named = matches!(word(0), [b] if b.is_ascii_alphabetic() || !b.is_ascii());
    if !named || !(is_position(word(1)) || is_register(word(1)) || is_of_pallet(word(1))) {
        return None;
    }
    let mut said = MotionInstruction::new();
    let Some(goal) = read_path(text, words, &mut said) else { return Some(said) };
    let target = words[goal].clone();
    let digits = read_goal(text, &target, &mut said);
    said.speed = speed(word(goal + 1), said.path);
    let end = read_termination(text, words, goal, &mut said);
    if matches!(said.speed, Speed::Seconds(_)) {
        close(&mut said, Reason::Duration);
    }
    let mut kept = Vec::new();
    let own = said.goal.as_ref().ok().copied();
    read_options(text, words, end.next, &mut said, &mut kept);
    read_triggers(text, words, end.next, &mut said);
    said.via.extend(own.filter(|_| said.goal.is_err() || said.offset.is_some()));
    if let (Some(digits), Some(last)) = (digits, statement.pieces.last()) {
        let used = words.last().map_or(last.start, |w| w.end);
        let line_end = text.line_span(text.line_of(last.start) as usize - 1);
        let content = text.slice(line_end.clone()).trim_ascii_end().len() + line_end.start;
        said.motion = Some(Motion {
            start: statement.start,
            colon: statement.colon,
            number: statement.number,
            lead: (statement.colon + 1..target.start).into(),
            digits: digits.into(),
            speed_and_end: (target.end..end.span.end).into(),
            end_type: end.span.into(),
            exact: end.exact,
            kept: kept.into_iter().map(Span::from).collect(),
            tail: (used..content.max(used)).into(),
        });
    }
    Some(said)
}

/// The path by the motion's letter, and the word of its goal; `None`: the letter is not known, or there is no goal.
///
/// `path = "J" | "L" | "A" | "C" via`
fn read_path(text: &Text, words: &[Range<usize>], said: &mut MotionInstruction) -> Option<usize> {
    let letter = words.first().map_or(&[][..], |w| text.slice(w.clone()));
    let mut goal = 1;
    match letter.to_ascii_uppercase().as_slice() {
        b"J" => said.path = PathKind::Joint,
        b"L" => said.path = PathKind::Linear,
        b"A" => close(said, script::Reason::ThreePoints),
        b"C" => {
            close(said, script::Reason::ThreePoints);
            passes(text, &words[1], said);
            goal = 2;
        }
        _ => {
            said.goal = Err(Reason::UnknownMotion(String::from_utf8_lossy(letter).into()).into());
            words.iter().filter(|w| is_position(text.slice((*w).clone()))).for_each(|w| passes(text, w, said));
            return None;
        }
    }
    if goal >= words.len() {
        said.goal = Err(script::Reason::NoGoal);
        return None;
    }
    Some(goal)
}

/// How a motion ends, and the word after that.
struct Termination {
    span: Range<usize>,
    exact: bool,
    next: usize,
}

/// `termination = "FINE" | "CNT" (number | " R[" index "]") | "CD" number | "CR" number`
fn read_termination(text: &Text, words: &[Range<usize>], goal: usize, said: &mut MotionInstruction) -> Termination {
    let word = |k: usize| words.get(k).map_or(&[][..], |w| text.slice(w.clone()));
    let Some(k) = (goal + 1..words.len()).take(4).find(|&k| is_termination(word(k))) else {
        close(said, Reason::UnknownEnd);
        let after = words[goal].end;
        return Termination { span: after..after, exact: false, next: goal + 2 };
    };
    let exact = word(k).eq_ignore_ascii_case(b"FINE");
    let zero = word(k).eq_ignore_ascii_case(b"CNT0");
    let bare = word(k).iter().all(u8::is_ascii_alphabetic) && !exact;
    let last = if bare && word(k + 1).contains(&b'[') { k + 1 } else { k };
    said.blend_m = (exact || zero).then_some(0.0);
    Termination { span: words[k].start..words[last].end, exact, next: last + 1 }
}

/// A position that a motion needs besides its goal.
///
/// `via = "P[" index "]"`
fn passes(text: &Text, word: &Range<usize>, said: &mut MotionInstruction) {
    if is_position(text.slice(word.clone())) {
        match index(text, word.clone()) {
            Some((_, n)) => said.via.push(n),
            None => said.any = true,
        }
    }
}

fn close(said: &mut MotionInstruction, why: impl Into<script::Reason>) {
    said.closed.get_or_insert_with(|| why.into());
}

/// Words that end a motion line and neither move its goal nor are repeated by a copy.
const PLAIN: [&str; 9] = ["PTH", "MPTH", "LDC", "BREAK", "TA", "TB", "DB", "PSPI", "INDEP"];

/// What an option says where the robot ends elsewhere than at its goal, or does not go straight to it.
///
/// `option = "MROT" | "RTCP" | "SEARCH[" ...`
fn otherwise(upper: &[u8], path: PathKind) -> Option<Reason> {
    match upper {
        b"MROT" => Some(Reason::ShorterTurn),
        b"RTCP" if path != PathKind::Joint => Some(Reason::RemoteTool),
        _ if upper.starts_with(b"SEARCH[") => Some(Reason::Search),
        _ => None,
    }
}

/// Options after the end type. An offset or an increment moves the goal; an unknown word might.
///
/// `option = "INC" | "COORD" | "MROT" | "RTCP" | "WJNT" | offset | "SKIP..." | ("ACC" | "PSPD") (number | " R[" index "]")`,
/// `option = "CALL" name | word with a digit, bracket, "=" or "," | "BREAK" | "PTH" | "TA" | "TB" | "DB" | ...`
fn read_options(
    text: &Text,
    words: &[Range<usize>],
    from: usize,
    said: &mut MotionInstruction,
    kept: &mut Vec<Range<usize>>,
) {
    let mut k = from;
    while let Some(span) = words.get(k) {
        let word = text.slice(span.clone());
        let upper = word.to_ascii_uppercase();
        let next = words.get(k + 1).map(|w| text.slice(w.clone()).to_ascii_uppercase()).unwrap_or_default();
        let next_bracket = next.contains(&b'[');
        if let Some(process) = process(&upper) {
            said.process = Some(process);
        }
        if let Some(why) = otherwise(&upper, said.path) {
            said.goal = Err(why.into());
            said.skips |= upper.starts_with(b"SEARCH");
        } else if upper == b"COORD" {
            said.coordinated = true;
            close(said, Reason::Coordinated);
        } else if upper == b"INC" {
            said.goal = Err(Reason::Increment.into());
            said.relative = true;
        } else if has(&upper, b"OFFSET") && !has(&upper, b"VOFFSET") && !has(&upper, b"VR[") {
            let from = said.offset.is_none();
            k += usize::from(read_offset(&upper, &next, said));
            said.offset_by = said.offset.as_ref().filter(|_| from).and_then(|(_, text)| register_of(text));
        } else if has(&upper, b"PR[") || has(&upper, b"VR[") || has(&upper, b"VOFFSET") {
            said.goal = Err(Reason::Offset.into());
        } else if upper.starts_with(b"SKIP") {
            said.skips = true;
            close(said, Reason::Skip);
        } else if upper.starts_with(b"ACC") || upper.starts_with(b"PSPD") {
            let computed = matches!(upper.as_slice(), b"ACC" | b"PSPD") && next_bracket;
            kept.push(span.start..words.get(k + usize::from(computed)).map_or(span.end, |w| w.end));
            k += usize::from(computed);
        } else if upper == b"WJNT" || upper == b"RTCP" {
            if said.path != PathKind::Joint {
                said.wrist = upper == b"WJNT";
                close(said, Reason::WristByJoint);
            }
            kept.push(span.clone());
        } else if upper == b"CALL" || upper.ends_with(b",CALL") || upper == b"AUFRUF" || upper.ends_with(b",AUFRUF") {
            said.calls = true;
            k += 1;
        } else if matches!((upper.as_slice(), next.as_slice()), (b"ZEIT", b"VOR" | b"NACH") | (b"WEG", b"VOR")) {
            // TB, TA, DB in German
            k += 1;
        } else if !(PLAIN.iter().any(|p| p.as_bytes() == upper) || next_bracket || parameter(&upper)) {
            said.goal = Err(Reason::UnknownOption(String::from_utf8_lossy(word).into()).into());
        }
        k += 1;
    }
}

/// What it runs near its end. A new point stands before that where the way or the time tells how far before the end it starts; else none
/// may be added.
///
/// `option = ("TA" | "TB" | "DB") ...`
fn read_triggers(text: &Text, words: &[Range<usize>], from: usize, said: &mut MotionInstruction) {
    let found = triggers::read(text, words, from);
    said.actions = found.actions;
    let straight = said.path == PathKind::Linear;
    for start in found.starts {
        let (way_m, time_s) = match (start.way_m(said.speed).filter(|_| straight), start) {
            (Some(way_m), _) => (way_m, 0.0),
            (None, Start::Time(s)) => (0.0, s),
            _ => {
                close(said, Reason::StartsBeforeEnd);
                continue;
            }
        };
        let before = said.end_trigger.as_ref().map_or((0.0, 0.0), |known| (known.way_m, known.time_s));
        let [way_m, time_s] = [f64::max(way_m, before.0), f64::max(time_s, before.1)];
        said.end_trigger = Some(EndTrigger { way_m, time_s, why: Reason::StartsBeforeEnd.into() });
    }
}

/// An offset; whether its register stands in the next word. By a register the position stands in its own frame.
///
/// `offset = ["TOOL_"] "OFFSET" [",PR[" index "]"]`
fn read_offset(upper: &[u8], next: &[u8], said: &mut MotionInstruction) -> bool {
    let register = next.strip_prefix(b",").unwrap_or(next).starts_with(b"PR[") && !has(upper, b"PR[");
    let mut text = String::from_utf8_lossy(upper).into_owned();
    if register {
        text.push_str(&String::from_utf8_lossy(next));
    }
    // its register may have any word for a comment
    let word = upper.split(|b| matches!(b, b'[' | b',')).next().unwrap_or(upper);
    said.offset = Some((has(word, b"TOOL"), text));
    close(said, Reason::Offset);
    register
}

/// The number of the register of an offset, `OFFSET,PR[3:UP]`; `None`: it is computed, or there is none.
///
/// `offset = ... "PR" "[" number [":" name] "]"`
fn register_of(offset: &str) -> Option<u64> {
    let inside = offset.split_once("PR[")?.1.strip_suffix(']')?;
    let digits = inside.split(':').next()?.trim();
    (!inside.contains('[')).then(|| digits.parse().ok()).flatten()
}

/// A word with digits, brackets or signs belongs to an option: `.10sec,DO[1]=ON`, `EV50%`.
fn parameter(word: &[u8]) -> bool {
    word.iter().any(|b| b.is_ascii_digit() || b"[]=,".contains(b))
}

/// `Start[1]` of `Arc Start[1]`, `Weld Start[1,2]`, `Lichtbogen Start[1]`; `End[1]`, `Ende[1]`.
///
/// `process = ... ("START" | "END" | "ENDE") "[" ...`
pub(super) fn process(upper: &[u8]) -> Option<bool> {
    let name = &upper[..memchr::memchr(b'[', upper)?];
    if name.ends_with(b"START") {
        Some(true)
    } else {
        (name.ends_with(b"END") || name.ends_with(b"ENDE")).then_some(false)
    }
}

/// `100%`, `250mm/sec`, `60cm/min`, `20inch/min`, `30deg/sec`, `2.0sec`, `200msec`.
///
/// `speed = number ("%" | "mm/sec" | "cm/min" | "inch/min" | "deg/sec" | "sec" | "msec")`
fn speed(word: &[u8], path: PathKind) -> Speed {
    let digits = word.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let Some(value) = std::str::from_utf8(&word[..digits]).ok().and_then(|d| d.parse::<f64>().ok()) else {
        return Speed::Unknown;
    };
    match word[digits..].to_ascii_lowercase().as_slice() {
        b"%" => Speed::Share(value / 100.0),
        b"mm/sec" => Speed::Tcp(value * 1e-3),
        b"cm/min" => Speed::Tcp(value * 1e-2 / 60.0),
        b"inch/min" => Speed::Tcp(value * 0.0254 / 60.0),
        b"deg/sec" if path == PathKind::Joint => Speed::Joint(value.to_radians()),
        b"sec" => Speed::Seconds(value),
        b"msec" => Speed::Seconds(value * 1e-3),
        _ => Speed::Unknown,
    }
}
