//! A motion instruction: `PTP XP1 C_PTP`, `SPTP {A1 5} WITH $VEL_AXIS[1]=SVEL_JOINT(50)`, `CIRC XAUX, XP2, CA 180`.

use super::lex::{Kind, Token};
use crate::script::lex::outside;
use crate::script::{PathKind, Span, Text};

/// Where a motion stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    /// Its line, from 0.
    pub line: u32,
    pub keyword: Span,
    /// Name, aggregate or product of its goal.
    pub goal: Span,
    /// The factor of the goal whose numbers are edited; the goal itself where it is no product.
    pub point: Span,
    /// Of an arc that may be split: the point on its way.
    pub via: Option<Span>,
    /// From after the goal to the end of the statement.
    pub tail: Span,
    pub spline: bool,
    /// First line of the fold of an inline form around it, from 0.
    pub fold: Option<u32>,
}

impl Motion {
    /// Its line, from 0.
    pub fn line(&self) -> usize {
        self.line as usize
    }

    /// First line of the fold of an inline form around it, from 0.
    pub fn fold(&self) -> Option<usize> {
        self.fold.map(|k| k as usize)
    }
}

/// A word that moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Word {
    pub path: PathKind,
    pub spline: bool,
    pub relative: bool,
    pub arc: bool,
}

/// The motion that a keyword begins.
///
/// `keyword = ("PTP" | "SPTP" | "LIN" | "SLIN" | "CIRC" | "SCIRC" | "SPL") ["_REL"]`
pub(super) fn word(upper: &str) -> Option<Word> {
    let (base, relative) = upper.strip_suffix("_REL").map_or((upper, false), |b| (b, true));
    let (path, spline, arc) = match base {
        "PTP" => (PathKind::Joint, false, false),
        "SPTP" => (PathKind::Joint, true, false),
        "LIN" => (PathKind::Linear, false, false),
        "SLIN" => (PathKind::Linear, true, false),
        "CIRC" => (PathKind::Curve, false, true),
        "SCIRC" => (PathKind::Curve, true, true),
        "SPL" => (PathKind::Curve, true, false),
        _ => return None,
    };
    Some(Word { path, spline, relative, arc })
}

/// Token of the goal of a motion, where that is a name alone.
///
/// `motion = keyword [via ","] name [index] tail`
pub(super) fn goal_word(text: &Text, line: &[Token]) -> Option<usize> {
    let w = word(&super::lex::in_upper(text, line.first()?))?;
    let at = if w.arc { second(line)? } else { 1 };
    let named = line.get(at).is_some_and(|t| t.kind == Kind::Word);
    let next = super::lex::index(text, line, at + 1).map_or(at + 1, |(_, next)| next);
    (named && !w.relative && ends(text, line, next)).then_some(at)
}

/// Whether a motion leads to where the robot stands: `PTP $POS_ACT`, `PTP $AXIS_ACT`.
///
/// `motion = keyword ("$POS_ACT" | "$AXIS_ACT") tail`
pub(super) fn stands(text: &Text, line: &[Token]) -> bool {
    let goal = line.get(1).map(|t| super::lex::in_upper(text, t)).unwrap_or_default();
    matches!(&*goal, "$POS_ACT" | "$AXIS_ACT") && ends(text, line, 2)
}

/// The token after the first comma outside of brackets.
///
/// `motion = keyword via "," goal`
pub(super) fn second(line: &[Token]) -> Option<usize> {
    outside(0..line.len(), |k| line[k].mark()).find(|k| line[*k].is(b',')).map(|k| k + 1)
}

/// Whether the goal ends before token `at`: nothing follows but `C_PTP`, `WITH` or `, CA`.
///
/// `tail = ["," ... | "C_..." ... | "WITH" ...]`
pub(super) fn ends(text: &Text, line: &[Token], at: usize) -> bool {
    line.get(at).is_none_or(|t| {
        t.is(b',')
            || t.kind == Kind::Comment
            || t.kind == Kind::Word && {
                let w = super::lex::in_upper(text, t);
                w.starts_with("C_") || w == "WITH"
            }
    })
}
