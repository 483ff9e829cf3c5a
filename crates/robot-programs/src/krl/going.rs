//! How the robot goes to a Cartesian point beyond what the motion says: how the tool turns on the way (`$ORI_TYPE`), whether the
//! robot holds the part (`IPO_FRAME #TCP`).
//!
//! A motion of `#CONSTANT` keeps its orientation whatever its point says; of `#JOINT` the wrist's axes go as in a PTP. Both are
//! said by `$ORI_TYPE`, by the motion data of inline forms (`LDAT_ACT=LCPDAT1`), or by `WITH` for one motion. Motion data come into force
//! with `BAS(#CP_PARAMS,...)` or `BAS(#CP_DAT)`, which set `$ORI_TYPE` to what `LDAT_ACT` says, whatever was set since; up to there the
//! motion may turn either way.

use super::lex::{Kind, Token, tokens, upper};
use crate::script::Text;
use std::collections::{HashMap, HashSet};

/// How the tool turns on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Turning {
    /// Evenly, to the orientation of the point.
    #[default]
    Evenly,
    /// Axis by axis.
    Wrist,
    /// Not at all, or in a way that is computed.
    Otherwise,
}

fn turning(word: &str) -> Turning {
    match word {
        "VAR" => Turning::Evenly,
        "JOINT" => Turning::Wrist,
        _ => Turning::Otherwise,
    }
}

/// The word after `#` that follows the word `name`.
///
/// `choice = name [token] "#" word`
fn choice(text: &Text, line: &[Token], name: &str) -> Option<String> {
    let at = line.iter().position(|t| t.kind == Kind::Word && upper(text, t) == name)?;
    let hash = (at + 1..line.len().min(at + 3)).find(|&i| line[i].is(b'#'))?;
    line.get(hash + 1).map(|t| upper(text, t))
}

/// Where a word stands, in upper or lower case; its fourth letter is `_`.
fn in_any_case<'a>(bytes: &'a [u8], word: &'static str) -> impl Iterator<Item = usize> + 'a {
    memchr::memchr_iter(b'_', bytes).filter_map(move |k| {
        let at = k.checked_sub(3)?;
        bytes.get(at..at + word.len())?.eq_ignore_ascii_case(word.as_bytes()).then_some(at)
    })
}

/// What the text has said so far.
#[derive(Default)]
pub(super) struct Going {
    /// Motion data and how they turn, where that is not evenly.
    data: HashMap<String, Turning>,
    /// Frame data with which the robot holds the part.
    held: HashSet<String>,
}

impl Going {
    /// Motion data and frame data of the program, its data list and those that all modules share.
    pub fn of(texts: &[Text]) -> Self {
        let mut going = Self::default();
        let mut line = Vec::new();
        for text in texts {
            for word in ["ORI_TYP", "IPO_FRAME"] {
                for at in in_any_case(&text.bytes, word) {
                    tokens(text, text.line_of(at) as usize - 1, &mut line);
                    going.declared(text, &line);
                }
            }
        }
        going
    }

    /// `DECL LDAT LCPDAT1={...,ORI_TYP #CONSTANT}`, `DECL FDAT FP1={...,IPO_FRAME #TCP,...}`: the program's own come first.
    fn declared(&mut self, text: &Text, line: &[Token]) {
        let brace = line.iter().position(|t| t.is(b'{'));
        let Some(name) = brace.and_then(|b| b.checked_sub(2)).and_then(|n| line.get(n)) else { return };
        let name = upper(text, name);
        if let Some(kind) = choice(text, line, "ORI_TYP") {
            self.data.entry(name).or_insert(turning(&kind));
        } else if choice(text, line, "IPO_FRAME").is_some_and(|f| f == "TCP") {
            self.held.insert(name);
        }
    }

    /// How a statement says that the tool turns from there on; `word`: its first word.
    ///
    /// `statement = "$ORI_TYPE" "=" ["#"] word | "LDAT_ACT" "=" (name | aggregate) | "LDAT_ACT" "." "ORI_TYP" "=" ["#"] word`
    pub fn turning(&self, text: &Text, line: &[Token], word: &str) -> Option<Turning> {
        match word {
            "$ORI_TYPE" => Some(choice(text, line, "$ORI_TYPE").map_or(Turning::Otherwise, |k| turning(&k))),
            "LDAT_ACT" => {
                let name = line.get(2).map(|t| upper(text, t)).unwrap_or_default();
                let own = choice(text, line, "ORI_TYP").map(|k| turning(&k));
                let part = line.get(1).is_some_and(|t| t.is(b'.'));
                own.or_else(|| (!part).then(|| self.data.get(&name).copied().unwrap_or_default()))
            }
            _ => None,
        }
    }

    /// Whether frame data that come into force say that the robot holds the part.
    pub fn holds_part(&self, text: &Text, line: &[Token]) -> bool {
        choice(text, line, "IPO_FRAME").is_some_and(|f| f == "TCP")
            || line.iter().any(|t| t.kind == Kind::Word && self.held.contains(&upper(text, t)))
    }

    /// How the tool turns on the way of a motion, of which `tail` stands after its goal.
    pub fn of_motion(&self, now: Turning, text: &Text, tail: &[Token]) -> Turning {
        if tail.is_empty() || !tail.iter().any(|t| upper(text, t) == "$ORI_TYPE") {
            return now;
        }
        // `WITH $ORI_TYPE=SORI_TYP(LCPDAT1)`
        let named = tail.iter().find_map(|t| self.data.get(&upper(text, t)).copied());
        let computed = tail.iter().any(|t| upper(text, t) == "SORI_TYP");
        match choice(text, tail, "$ORI_TYPE") {
            Some(kind) => turning(&kind),
            None if computed => named.unwrap_or_default(),
            None => Turning::Otherwise,
        }
    }
}
