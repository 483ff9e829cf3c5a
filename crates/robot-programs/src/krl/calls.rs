//! What a line calls, and whether that may move the robot.

use super::lex::{Kind, Token, upper};
use crate::script::Text;

/// Functions and procedures that neither move the robot nor change what they are given.
const QUIET: [&str; 34] = [
    "BAS",
    "SET_CD_PARAMS",
    "SIN",
    "COS",
    "TAN",
    "ACOS",
    "ATAN2",
    "ABS",
    "SQRT",
    "INVERSE",
    "FORWARD",
    "INV_POS",
    // frames of kinematics
    "EK",
    "EB",
    "ESYS",
    "STRLEN",
    "STRCOMP",
    "STRFIND",
    "VARSTATE",
    "PULSE",
    "IR_STOPM",
    "CAST_TO",
    "ROUND",
    "SVEL_JOINT",
    "STOOL2",
    "SBASE",
    "SIPO_MODE",
    "SLOAD",
    "SACC_JOINT",
    "SAPO_PTP",
    "SGEAR_JERK",
    "USE_CM_PRO_VALUES",
    "B_AND",
    // opens, closes and checks a gripper (KUKA.GripperTech, `SET ... State=` of its inline forms)
    "H50",
];

/// Names of the list that a line calls: a routine of the program may have one of them.
pub(super) fn quiet<'a>(text: &'a Text, line: &'a [Token]) -> impl Iterator<Item = String> + 'a {
    let called = line.windows(2).filter(|w| w[0].kind == Kind::Word && w[1].is(b'(')).map(|w| upper(text, &w[0]));
    called.filter(|n| QUIET.contains(&n.as_str()))
}

/// Whether a name is one of the list.
pub(super) fn is_quiet(name: &str) -> bool {
    QUIET.contains(&name)
}

/// Words before a bracket that is no call's.
pub(super) const KEYWORDS: [&str; 16] = [
    "IF", "AND", "OR", "NOT", "EXOR", "WHEN", "FOR", "WHILE", "UNTIL", "SWITCH", "CASE", "RETURN", "DO", "TO", "SEC",
    "DELAY",
];

/// Routines that a line calls and that may move the robot, in upper case.
///
/// `call = name "(" ...`
pub(super) fn calls(text: &Text, line: &[Token]) -> Vec<String> {
    line.windows(2)
        .filter(|w| w[0].kind == Kind::Word && w[1].is(b'('))
        .map(|w| upper(text, &w[0]))
        .filter(|n| !QUIET.contains(&n.as_str()) && !KEYWORDS.contains(&n.as_str()))
        .collect()
}

/// ArcTech's `ArcMainNG(#ArcOnBeforeMoveStd, ...)`: on before the motion to the seam, off after the motion to its end.
///
/// `arc = "ARCMAINNG" "(" "#" ("ARCON..." | "ARCOFFAFTER...") ...`
pub(super) fn arc(text: &Text, line: &[Token], word: &str) -> Option<bool> {
    let state = arc_state(text, line).filter(|_| word == "ARCMAINNG")?;
    if state.starts_with("ARCON") { Some(true) } else { state.starts_with("ARCOFFAFTER").then_some(false) }
}

/// The state that ArcTech's `ArcMainNG(#ArcOnBeforeMoveStd, ...)` names first, in upper case.
///
/// `call = name "(" "#" state ...`
pub(super) fn arc_state(text: &Text, line: &[Token]) -> Option<String> {
    line.get(3).filter(|_| line[2].is(b'#')).map(|t| upper(text, t))
}
