//! A look over the whole text before it is read: what may be in force where control comes from elsewhere.

use crate::krl::calls::calls;
use crate::krl::data::Data;
use crate::krl::going::{Going, Turning};
use crate::krl::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper};
use crate::krl::lists::Lists;
use crate::krl::motion;
use crate::krl::outside::Outside;
use crate::krl::reason::MovesBase;
use crate::krl::settings::Settings;
use crate::krl::statement::{assignment, is_label, is_routine};
use crate::script::Text;
use crate::script::cursor::strip_word;
use crate::script::pose::Frame;
use std::collections::BTreeSet;

/// What holds after a branch, a label or a call.
pub(super) struct Ahead {
    /// $BASE and $TOOL, where that is certain.
    pub(super) later: [Option<Frame>; 2],
    /// How the tool may turn.
    pub(super) turning: Turning,
    /// What may make any base mean something else.
    pub(super) carried: Option<MovesBase>,
    pub(super) moved: Option<MovesBase>,
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
        let (mut later, turning) = later(text, data, going, &lists);
        let turning = turning.max(outside.turning);
        let (carried, moved) = carried(text, data);
        let (carried, moved) = (carried.or(outside.carried), moved.or(outside.moved));
        let passed = passed(text);
        for list in (0..2).filter(|list| !passed[*list].is_empty() || outside.frames[*list]) {
            later[list] = Some(by_a_routine(list));
        }
        Self { later, turning, carried, moved, lists, passed }
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
    for k in 0..text.line_count() {
        if memchr::memchr(b'=', text.line(k)).is_none() {
            continue;
        }
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

/// Whether control may come to a line from elsewhere than from the line before: by a label or the start of a routine (`true`: nothing
/// above it may have run), after a call or at a loop.
///
/// `join = name ":" | routine | "LOOP" | "FOR" | "WHILE" | "REPEAT" | ... call ...`
fn joins(text: &Text, line: &[Token], word: &str, second: &str) -> Option<bool> {
    let more = || matches!(word, "LOOP" | "FOR" | "WHILE" | "REPEAT") || !calls(text, line).is_empty();
    (is_label(line) || is_routine(word, second)).then_some(true).or_else(|| more().then_some(false))
}

/// $BASE and $TOOL after a branch, a label or a call: known where the file sets none, or always the same.
///
/// `setting = "BAS" "(" ... ")" | assignment`
fn later(text: &Text, data: &Data, going: &Going, lists: &Lists) -> ([Option<Frame>; 2], Turning) {
    let mut set = Settings::default();
    let mut turning = Turning::Evenly;
    let mut found: [Vec<Frame>; 2] = Default::default();
    let mut signs = memchr::memchr_iter(b'=', &text.bytes).peekable();
    let mut line = Vec::new();
    let mut routine = 0;
    for k in 0..text.line_count() {
        // a routine, BAS or an assignment
        let span = text.line_span(k);
        while signs.next_if(|at| *at < span.start).is_some() {}
        if lists.is_empty() && !begins_with(text, k, b"BDG") && signs.peek().is_none_or(|at| *at >= span.end) {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let Some(first) = line.first() else { continue };
        let (word, second) = (upper(text, first), line.get(1).map(|t| upper(text, t)).unwrap_or_default());
        routine += usize::from(is_routine(&word, &second));
        if let Some(unset) = joins(text, &line, &word, &second).filter(|_| !lists.is_empty()) {
            set.lists.merge_all(lists, unset);
        }
        turning = turning.max(going.turning(text, &line, &word).unwrap_or_default());
        if word == "BAS" {
            set.bas(text, &line);
        } else if let Some(sign) = assignment(&line) {
            set.assign(text, &line, sign, &word, data, routine);
        } else {
            continue;
        }
        for (all, now) in found.iter_mut().zip([&set.base, &set.tool]) {
            if let Some(now) = now.as_ref().filter(|now| !all.contains(now)) {
                all.push(now.clone());
            }
        }
    }
    let frames = found.map(|all| match all.as_slice() {
        [] => None,
        [one] => Some(one.clone()),
        // which is in force is not certain
        all => Some(Frame::Any(all.to_vec())),
    });
    (frames, turning)
}

/// What may make any base mean something else after a branch, a label or a call: `$IPO_MODE`, `$WORLD`.
///
/// `assignment = ("$IPO_MODE" | "$WORLD" | ...) "=" value`
fn carried(text: &Text, data: &Data) -> (Option<MovesBase>, Option<MovesBase>) {
    let (mut carried, mut moved) = (None, None);
    let mut line = Vec::new();
    for k in 0..text.line_count() {
        if !begins_with(text, k, b"$") {
            continue;
        }
        if !matches!(first_word(text, k), [b'$', b'I' | b'i' | b'W' | b'w' | b'R' | b'r', ..]) {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let (Some(first), Some(sign)) = (line.first(), assignment(&line)) else { continue };
        let mut set = Settings::default();
        set.assign(text, &line, sign, &upper(text, first), data, 0);
        (carried, moved) = (carried.or(set.carried), moved.or(set.moved));
    }
    (carried, moved)
}

/// `$BASE` and `$TOOL`, of which a routine may make others to which they are passed themselves.
const FRAMES: [&str; 2] = ["$BASE", "$TOOL"];

pub(super) fn by_a_routine(list: usize) -> Frame {
    Frame::Computed(format!("{} as a routine sets it", FRAMES[list]))
}

/// Lines at which each of them is an argument.
///
/// `argument = ("(" | ",") ("$BASE" | "$TOOL") (")" | ",")`
fn passed(text: &Text) -> [BTreeSet<u64>; 2] {
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

/// Lines that assign where the robot stands to a variable: `HERE=$POS_ACT`.
///
/// `reading = name "=" {any} ("$POS_ACT" | "$AXIS_ACT" | "$POS_INT" | "$AXIS_INT" | "$POS_FOR" | "$AXIS_FOR" | "$POS_RET" | "$AXIS_RET")`
pub(super) fn reads_place(text: &Text) -> BTreeSet<u64> {
    const PLACES: [&[u8]; 8] =
        [b"$POS_ACT", b"$AXIS_ACT", b"$POS_INT", b"$AXIS_INT", b"$POS_FOR", b"$AXIS_FOR", b"$POS_RET", b"$AXIS_RET"];
    let is = |at: usize| {
        let rest = text.bytes.get(at..).unwrap_or_default();
        PLACES.iter().any(|place| strip_word(rest, place).is_some())
    };
    let mut line = Vec::new();
    // the line that was read last, and what it assigns
    let (mut last, mut value) = (0, 0..0);
    let assigns = |at: usize| {
        let k = text.line_of(at);
        if k != last {
            tokens(text, k as usize - 1, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let first = line.first().map(|t| upper(text, t)).unwrap_or_default();
            let sign = assignment(&line).filter(|_| motion::word(&first).is_none());
            let sign = sign.and_then(|sign| line.get(sign)).map(|t| t.start + 1);
            (last, value) = (k, sign.unwrap_or(usize::MAX)..line.last().map_or(0, |t| t.end));
        }
        value.contains(&at).then_some(k)
    };
    memchr::memchr_iter(b'$', &text.bytes).filter(|at| is(*at)).filter_map(assigns).collect()
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
