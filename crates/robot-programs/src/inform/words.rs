//! The words of an instruction, and which instructions there are.

use crate::script::Text;
use crate::script::cursor::Cursor;
use crate::script::lex::upper_of;
use std::ops::Range;
use std::sync::Arc;

/// Instructions that do not move the robot, and do not change what positions mean.
pub(super) const STILL: &[&str] = &[
    "NOP", "DOUT", "DIN", "AOUT", "AIN", "PULSE", "GOUT", "GIN", "SET", "SETE", "GETE", "GETS", "ADD", "SUB", "MUL",
    "DIV", "INC", "DEC", "AND", "OR", "NOT", "XOR", "SQRT", "SIN", "COS", "ATAN", "CNVRT", "MSHIFT", "MULMAT",
    "INVMAT", "CLEAR", "SETFILE", "GETFILE", "SETREG", "GETREG", "GETPOS", "GETARG", "VAL2STR", "ASC", "CHR$", "MID$",
    "LEN", "CAT$", "STR$", "VAL", "MSG", "DIALOG", "ADVINIT", "ADVSTOP", "PRINT", "SETUALM", "REFP", "SPEED", "ARCSET",
    "AWELD", "VWELD", "ARATION", "ARATIOF", "PWAIT", "TSYNC", "ENDWAIT", "COMM",
];

/// Instructions at which the robot stands.
pub(super) const STANDS: &[&str] = &["WAIT", "CWAIT", "PAUSE", "HAND", "HSEN", "SPOT", "SVSPOT", "GUNCL"];

/// Branches.
pub(super) const JUMPS: &[&str] = &[
    "JUMP",
    "RET",
    "IF",
    "IFTHEN",
    "IFTHENEXP",
    "ELSEIF",
    "ELSEIFEXP",
    "ELSE",
    "ENDIF",
    "SWITCH",
    "CASE",
    "DEFAULT",
    "ENDSWITCH",
    "LABEL",
    "ANDIF",
    "ORIF",
    "ABORT",
];

pub(super) const LOOPS: &[&str] = &["WHILE", "WHILEEXP", "ENDWHILE", "FOR", "NEXT"];

pub(super) const FRAMES: &[&str] = &["SETTOOL", "MFRAME", "GETTOOL"];

/// Instructions that start another job.
pub(super) const STARTS: &[&str] = &["CALL", "PSTART"];

pub(super) const PROCESS: &[(&str, bool)] = &[
    ("ARCON", true),
    ("ARCOF", false),
    ("TOOLON", true),
    ("TOOLOF", false),
    ("SPYON", true),
    ("SPYOF", false),
    ("LASERON", true),
    ("LASEROF", false),
];

/// Instructions that lay another motion over the path until the second of them.
pub(super) const OVERLAID: &[(&str, &str)] = &[
    ("WVON", "WVOF"),
    ("COMARCON", "COMARCOF"),
    ("SFTON", "SFTOF"),
    // a conveyor, a soft servo
    ("SYSTART", "SYEND"),
    ("FLOATON", "FLOATOF"),
];

/// Whether an instruction is known, so that it sets no position variable that it does not name.
pub(super) fn is_known(word: &str) -> bool {
    let lists = [STILL, STANDS, JUMPS, LOOPS, FRAMES, STARTS];
    let pairs = PROCESS.iter().map(|p| p.0).chain(OVERLAID.iter().flat_map(|p| [p.0, p.1]));
    word.starts_with(['*', '+'])
        || word.contains("MOV")
        || matches!(word, "TIMER" | "END")
        || lists.iter().any(|list| list.contains(&word))
        || pairs.into_iter().any(|p| p == word)
}

/// The words of a line, each with its bytes; a comment (`'`, or `//` after a space) is left out.
///
/// `line = {blank | word} ["'" comment | "//" comment]`,
/// `word = {any | '"' {any} '"'}`
pub(super) fn words(text: &Text, k: usize) -> Vec<Range<usize>> {
    let start = text.line_span(k).start;
    let (mut cursor, mut found) = (Cursor::new(text.line(k)), Vec::new());
    loop {
        cursor.blanks();
        let (from, mut quoted) = (cursor.at(), false);
        if !cursor.rest().starts_with(b"//") {
            cursor.while_is(|b| {
                quoted ^= b == b'"';
                quoted || !(b == b'\'' || b.is_ascii_whitespace())
            });
        }
        if cursor.at() == from {
            return found;
        }
        found.push(start + from..start + cursor.at());
    }
}

pub(super) fn upper(text: &Text, span: &Range<usize>) -> String {
    upper_of(text.slice(span.clone())).into_owned()
}

/// Words of a line in upper case; none of a comment.
pub(super) fn upper_words(text: &Text, k: usize) -> Vec<String> {
    words(text, k).iter().map(|w| upper(text, w)).collect()
}

/// Whether a line is a move of a form that is met nearly everywhere, to a position with a `C` and its number, and names nothing else:
/// it runs nothing, sets nothing and clears nothing.
///
/// `move = ("MOVJ" | "MOVL") "C" digit {digit} {("VJ=" | "V=" | "PL=") {digit | "."}}`
fn is_plain_move(line: &[u8]) -> bool {
    let Some(rest) = [b"MOVJ C", b"MOVL C"].iter().find_map(|head| line.strip_prefix(&head[..])) else { return false };
    let mut cursor = Cursor::new(rest);
    let named = !cursor.digits().is_empty();
    let mut words = cursor.rest().split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty());
    let usual = |w: &[u8]| {
        let value = [&b"VJ="[..], b"V=", b"PL="].iter().find_map(|head| w.strip_prefix(*head));
        value.is_some_and(|v| v.iter().all(|b| b.is_ascii_digit() || *b == b'.'))
    };
    named && cursor.peek().is_none_or(|b| b.is_ascii_whitespace()) && words.all(usual)
}

/// Which lines of a text are plain moves ([`is_plain_move`]): nearly all of a large job, which is gone through for many questions.
pub(super) struct PlainMoves(Vec<Plain>);

/// What a line is.
#[derive(Clone, Copy, PartialEq)]
enum Plain {
    Not,
    /// A plain move after blanks.
    Indented,
    Move,
}

impl PlainMoves {
    /// Of a text; found once.
    pub(super) fn of(text: &Text) -> Arc<Self> {
        let of = |line: &[u8]| match is_plain_move(line.trim_ascii()) {
            false => Plain::Not,
            true if line.first().is_some_and(u8::is_ascii_whitespace) => Plain::Indented,
            true => Plain::Move,
        };
        text.known(|text| Self((0..text.line_count()).map(|k| of(text.line(k))).collect()))
    }

    /// Line `k` is one from its first byte on.
    pub(super) fn has(&self, k: usize) -> bool {
        self.0.get(k) == Some(&Plain::Move)
    }

    /// Line `k` is one, blanks before it left out.
    pub(super) fn has_indented(&self, k: usize) -> bool {
        self.0.get(k).is_some_and(|plain| *plain != Plain::Not)
    }
}

/// Whether the robot stands at an instruction that begins with this word.
pub(super) fn stands(word: &str) -> bool {
    word == "TIMER" || STANDS.contains(&word)
}

/// Whether an instruction moves nothing and changes nothing of what positions mean.
pub(super) fn still(text: &Text, k: usize, words: &[String]) -> bool {
    let known = words.first().is_some_and(|w| w == "END" || STILL.contains(&w.as_str()));
    known && sets_frame(text, k).is_empty()
}

/// The first line of a job's instructions; `None`: it has none.
///
/// `head = "//INST" {"/" ...}`
pub(super) fn begin_of(text: &Text) -> Option<usize> {
    let is = |k: &usize| text.line(*k).trim_ascii().eq_ignore_ascii_case(b"//INST");
    let begin = (0..text.line_count()).find(is)? + 1;
    Some((begin..text.line_count()).find(|k| !text.line(*k).starts_with(b"/")).unwrap_or(text.line_count()))
}

/// Words that name a user frame and a tool.
pub(super) const FRAME_WORDS: [&str; 2] = ["UF#", "TL#"];

/// Words of an instruction that sets a user frame or a tool that it names; none of any other. Those that are listed only use it.
///
/// `setting = {label} word ... ("UF#" | "TL#") ...`
pub(super) fn sets_frame(text: &Text, k: usize) -> Vec<String> {
    const USE: [&str; 9] = ["CNVRT", "MSHIFT", "SFTON", "CALL", "JUMP", "GETPOS", "GETS", "GETE", "REFP"];
    if memchr::memchr(b'#', text.line(k)).is_none() {
        return Vec::new();
    }
    let words = upper_words(text, k);
    let names = words.iter().any(|w| FRAME_WORDS.iter().any(|f| w.contains(f)));
    let first = words.iter().find(|w| !w.starts_with('*'));
    let sets = names && first.is_some_and(|f| !f.contains("MOV") && !USE.contains(&f.as_str()));
    if sets { words } else { Vec::new() }
}
