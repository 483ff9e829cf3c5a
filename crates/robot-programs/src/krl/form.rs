//! Inline forms: the settings that a form writes before its motion, and where its fold names its point.

use super::calls::calls;
use super::lex::{Kind, Token, tokens, upper};
use super::motion;
use super::statement::assignment;
use crate::script::Text;
use std::ops::Range;

/// Variables that a form sets for its motion.
const SET: [&str; 6] = ["$BWDSTART", "$H_POS", "PDAT_ACT", "LDAT_ACT", "CPDAT_ACT", "FDAT_ACT"];

/// Routines that a form calls for its motion.
const CALLED: [&str; 2] = ["BAS", "SET_CD_PARAMS"];

/// Whether a statement is one of a form's own settings: running it twice is running it once. Whatever else stands in a fold
/// was typed there by hand and may count, switch, or wait.
///
/// `setting = ("BAS" | "SET_CD_PARAMS") "(" ... | variable "=" value`
pub(super) fn setting(text: &Text, line: &[Token]) -> bool {
    let Some(first) = line.first() else { return false };
    let word = upper(text, first);
    let whole = if line.get(1).is_some_and(|t| t.is(b'(')) {
        CALLED.contains(&word.as_str())
    } else {
        SET.contains(&word.as_str()) && assignment(line) == Some(1)
    };
    whole && calls(text, line).is_empty()
}

/// A word of a form that stands for its point.
pub(super) struct Reference {
    pub span: Range<usize>,
    /// The letter before the point's name in the words of KRL: `X` of the point, `F` of its frame data.
    pub head: Option<u8>,
}

/// Where the fold from line `fold` to the motion on line `to` means the point `name` (without its `X`): in the fold's text
/// and parameters, in the form's settings, in the motion. Tools and bases may have the same name.
///
/// `form = ";" fold {setting} motion`
pub(super) fn references(text: &Text, fold: usize, to: usize, name: &str) -> Vec<Reference> {
    let mut out = Vec::new();
    let mut line = Vec::new();
    for k in fold..=to {
        tokens(text, k, &mut line);
        let comment = line.iter().position(|t| t.kind == Kind::Comment);
        let code = &line[..comment.unwrap_or(line.len())];
        if k == to || setting(text, code) {
            for t in code.iter().filter(|t| t.kind == Kind::Word) {
                if let [head @ (b'X' | b'x' | b'F' | b'f'), rest @ ..] = text.slice(t.span())
                    && rest.eq_ignore_ascii_case(name.as_bytes())
                {
                    out.push(Reference { span: t.span(), head: Some(*head) });
                }
            }
        } else if let (Some(t), true) = (line.first(), code.is_empty()) {
            let named = named(text.slice(t.span())).into_iter().map(|w| t.start + w.start..t.start + w.end);
            let own = named.filter(|w| text.slice(w.clone()).eq_ignore_ascii_case(name.as_bytes()));
            out.extend(own.map(|span| Reference { span, head: None }));
        }
    }
    out
}

/// Words of a comment that name the form's point: after the motion (`;FOLD PTP P1 ...`), in the form's second field
/// (`%P 1:PTP, 2:P1, ...`), and as a parameter (`Kuka.PointName=P1;`).
///
/// `fold = ";FOLD" keyword name ... ["%P " ... "2:" name ...]`,
/// `parameter = "POINTNAME=" name`
fn named(comment: &[u8]) -> Vec<Range<usize>> {
    let word =
        |at: usize| at..at + comment[at..].iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
    let upper = comment.to_ascii_uppercase();
    let mut at = 0;
    let words = upper.split(|b| b.is_ascii_whitespace() || *b == b';').map(|w| {
        at += w.len() + 1;
        (at - w.len() - 1, w)
    });
    let mut words = words.filter(|(_, w)| !w.is_empty());
    let mut out = Vec::new();
    if words.next().is_some_and(|(_, w)| w == b"FOLD")
        && words.next().is_some_and(|(_, w)| motion::word(&String::from_utf8_lossy(w)).is_some())
        && let Some((at, _)) = words.next()
    {
        out.push(word(at));
    }
    if let Some(fields) = memchr::memmem::find(&upper, b"%P ") {
        let second = memchr::memmem::find_iter(&upper[fields..], b"2:").map(|n| fields + n);
        out.extend(second.filter(|at| b" ,".contains(&upper[at - 1])).map(|at| word(at + 2)).take(1));
    }
    out.extend(memchr::memmem::find_iter(&upper, b"POINTNAME=").map(|at| word(at + b"POINTNAME=".len())));
    out.retain(|w| !w.is_empty());
    out
}
