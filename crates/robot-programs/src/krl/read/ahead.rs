//! A look over the whole text before it is read: what may be in force where control comes from elsewhere.

use crate::krl::data::Data;
use crate::krl::going::{Going, Turning};
use crate::krl::lex::{Kind, begins_with, first_word, in_upper, tokens, upper};
use crate::krl::lists::Lists;
use crate::krl::motion;
use crate::krl::outside::Outside;
use crate::krl::settings::Settings;
use crate::krl::statement::{assignment, is_routine};
use crate::script::Text;
use crate::script::cursor::strip_word;
use crate::script::pose::Frame;
use std::collections::BTreeSet;

/// What holds after a branch, a label or a call.
pub(super) struct Ahead {
    /// How the tool may turn.
    pub(super) turning: Turning,
    /// What the text sets in the lists of the controller.
    pub(super) lists: Lists,
    /// Lines at which `$BASE` and `$TOOL` are passed to a routine.
    pub(super) passed: [BTreeSet<u64>; 2],
}

impl Ahead {
    /// Of the program's text; `outside`: what the routines of other files do that it calls.
    pub(super) fn of(text: &Text, data: &Data, going: &Going, outside: &Outside) -> Self {
        let mut lists = lists(text, data);
        lists.add(&outside.lists);
        let turning = turning(text, going).max(outside.turning);
        Self { turning, lists, passed: passed(text) }
    }
}

/// Frame data that the program changes (`FP1.BASE_NO=3`): which base and tool they name is not certain.
///
/// `assignment = name ["." field] "=" value`
pub(super) fn changed_frame_data(text: &Text, data: &mut Data) {
    if data.numbers.is_empty() {
        return;
    }
    let mut line = Vec::new();
    for k in text.lines_with(b"=") {
        tokens(text, k, &mut line);
        let Some(first) = line.first().filter(|_| assignment(&line).is_some()) else { continue };
        if let Some(numbers) = data.numbers.get_mut(in_upper(text, first).as_ref()) {
            *numbers = [None, None];
        }
    }
}

/// What the text sets in BASE_DATA and TOOL_DATA, wherever it stands.
///
/// `assignment = ("BASE_DATA" | "TOOL_DATA") "[" number "]" "=" value`
fn lists(text: &Text, data: &Data) -> Lists {
    let mut all = Lists::default();
    let (mut line, mut routine) = (Vec::new(), 0);
    for k in 0..text.line_count() {
        if !begins_with(text, k, b"BTDG") {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let word = line.first().map(|t| in_upper(text, t)).unwrap_or_default();
        routine += usize::from(is_routine(&word, &line.get(1).map(|t| upper(text, t)).unwrap_or_default()));
        if let Some(sign) = assignment(&line).filter(|_| matches!(&*word, "BASE_DATA" | "TOOL_DATA")) {
            let mut set = Settings::default();
            set.assign(text, &line, sign, &word, data, routine);
            all.add(&set.lists);
        }
    }
    all
}

/// The least certain way in which the text lets the tool turn.
///
/// `setting = ("$ORI_TYPE" | "LDAT_ACT") ... "=" value`
fn turning(text: &Text, going: &Going) -> Turning {
    let (mut turning, mut line) = (Turning::Evenly, Vec::new());
    for k in (0..text.line_count()).filter(|k| begins_with(text, *k, b"$L")) {
        if !matches!(first_word(text, k), [b'$', b'O' | b'o', ..] | [b'L' | b'l', b'D' | b'd', ..]) {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let Some(first) = line.first() else { continue };
        turning = turning.max(going.turning(text, &line, &upper(text, first)).unwrap_or_default());
    }
    turning
}

/// `$BASE` and `$TOOL`, of which a routine may make others to which they are passed themselves.
const FRAMES: [&str; 2] = ["$BASE", "$TOOL"];

pub(super) fn by_a_routine(list: usize) -> Frame {
    Frame::Computed(format!("{} as a routine sets it", FRAMES[list]))
}

/// Lines at which each of them is an argument.
///
/// `argument = ("(" | ",") ("$BASE" | "$TOOL") (")" | ",")`
pub(super) fn passed(text: &Text) -> [BTreeSet<u64>; 2] {
    let argument = |at: usize, name: &str| {
        let (before, rest) = text.bytes.split_at(at);
        let Some(after) = strip_word(rest, name.as_bytes()) else { return false };
        matches!(before.trim_ascii_end().last(), Some(b'(' | b','))
            && matches!(after.trim_ascii_start().first(), Some(b')' | b','))
    };
    FRAMES.map(|name| {
        let all = memchr::memchr_iter(b'$', &text.bytes).filter(|at| argument(*at, name));
        all.map(|at| text.line_of(at)).collect()
    })
}

/// Begins of the names of where the robot stands.
#[rustfmt::skip]
const PLACES: [&[u8]; 10] = [
    b"$POS_ACT", b"$AXIS_ACT", b"$POS_INT", b"$AXIS_INT", b"$POS_FOR", b"$AXIS_FOR", b"$POS_RET", b"$AXIS_RET", b"$POS_BACK", b"$AXIS_BACK",
];

/// Whether a word is the name of where the robot stands.
pub(super) fn is_place(word: &str) -> bool {
    PLACES.iter().any(|place| strip_word(word.as_bytes(), place).is_some())
}

/// Lines that take on where the robot stands, from 0: `HERE=$POS_ACT`, `IF $AXIS_ACT.A1>5 THEN`. Messages take nothing on, nor does what
/// declares an interrupt; what a [trigger](super::triggers) reads is another place.
///
/// `reading = name "=" {any} place | ("IF" | "WHILE" | "UNTIL" | "SWITCH" | "WAIT" | "RETURN" | name "(") {any} place`,
/// `place = "$" ("POS" | "AXIS") "_" ("ACT" | "INT" | "FOR" | "RET" | "BACK")`
pub(super) fn reads_place(text: &Text) -> BTreeSet<usize> {
    const NONE: [&str; 7] = ["INTERRUPT", "GLOBAL", "TRIGGER", "DECL", "CWRITE", "SWRITE", "SIGNAL"];
    let is = |at: usize| {
        let rest = text.bytes.get(at..).unwrap_or_default();
        PLACES.iter().any(|place| strip_word(rest, place).is_some())
    };
    let mut line = Vec::new();
    // the line that was read last, and what of it takes on
    let (mut last, mut value) = (0, 0..0);
    let takes_on = |at: usize| {
        let k = text.line_of(at);
        if k != last {
            tokens(text, k as usize - 1, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let first = line.first().map(|t| upper(text, t)).unwrap_or_default();
            let quiet = motion::word(&first).is_some() || NONE.contains(&first.as_str()) || first.contains("MSG");
            // what stands before the sign is set
            let from = assignment(&line).and_then(|sign| line.get(sign)).map_or(0, |t| t.start + 1);
            let end = line.last().map_or(0, |t| t.end);
            (last, value) = (k, if quiet { end..end } else { from..end });
        }
        value.contains(&at).then_some(k as usize - 1)
    };
    memchr::memchr_iter(b'$', &text.bytes).filter(|at| is(*at)).filter_map(takes_on).collect()
}

/// Whether a text sets `$ORI_TYPE` or `$CIRC_TYPE`.
///
/// `setting = ... ("$ORI_TYPE" | "$CIRC_TYPE") ...`
pub(super) fn steers_arcs(text: &Text) -> bool {
    memchr::memchr_iter(b'$', &text.bytes).any(|at| {
        let rest = text.bytes.get(at..).unwrap_or_default();
        [&b"$ORI_TYPE"[..], b"$CIRC_TYPE"].iter().any(|word| strip_word(rest, word).is_some())
    })
}
