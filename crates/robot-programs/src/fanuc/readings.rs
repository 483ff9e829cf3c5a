//! Whether an instruction reads where the robot stands: `PR[5]=LPOS`, `PR[10]=PR[2]+LPOS`, `R[1]=$SCR_GRP[1].$MCH_POS_X`.
//!
//! What stands in brackets does not count, as a register may be named so (`PR[5:LPOS]`). A difference of the place to itself is no reading:
//! `PR[1]=LPOS-LPOS` is the usual way to set a register to zero.

use super::instruction::macro_name;
use super::statement::has;
use crate::script::Text;
use std::ops::Range;

/// The place in the words of the language.
const PLACES: [&[u8]; 2] = [b"LPOS", b"JPOS"];
/// ... and in system variables: the first word is the start of a name.
const VARIABLES: [&[u8]; 3] = [b"$MCH_POS", b"$MCH_ANG", b"$CURRENT_ANG"];

/// Whether a statement takes down where the robot stands, wherever that is in it.
///
/// `reading = ... ("LPOS" | "JPOS" | "$MCH_POS" axis | "$MCH_ANG" | "$CURRENT_ANG") ...`
pub(super) fn reads_place(text: &Text, words: &[Range<usize>]) -> bool {
    let Some(first) = words.first().map(|w| text.slice(w.clone())) else { return false };
    if first.starts_with(b"!") || first.starts_with(b"//") {
        return false;
    }
    // nearly every statement has no such word
    let named = |w: &Range<usize>| [&b"POS"[..], b"_ANG"].iter().any(|part| has(text.slice(w.clone()), part));
    if !words.iter().any(named) {
        return false;
    }
    let all: Vec<Vec<u8>> = words.iter().map(|w| outside(&text.slice(w.clone()).to_ascii_uppercase())).collect();
    let variable = |w: &[u8]| VARIABLES.iter().any(|name| has(w, name));
    if all.iter().any(|w| variable(w)) {
        return true;
    }
    // a program or a macro may have the word in its name
    let calls =
        |at: usize| all.get(at).is_some_and(|w| [&b"CALL"[..], b"AUFRUF", b"RUN"].iter().any(|c| w.ends_with(c)));
    let place = |(k, w): (usize, &Vec<u8>)| {
        let named = k == 0 && !w.iter().any(|b| b"=(".contains(b)) || k.checked_sub(1).is_some_and(calls);
        !named && PLACES.iter().any(|name| !terms(w, name).is_empty())
    };
    all.iter().enumerate().any(place) && !cancels(&all.join(&b' ')) && macro_name(text, words).is_none()
}

/// A word without what stands in its brackets.
fn outside(word: &[u8]) -> Vec<u8> {
    let mut depth = 0_usize;
    let keep = |b: &&u8| {
        match **b {
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0
    };
    word.iter().filter(keep).copied().collect()
}

/// Where a name stands in an expression as a separate word.
fn terms(expression: &[u8], name: &[u8]) -> Vec<usize> {
    let part = |b: Option<&u8>| b.is_some_and(|b| b.is_ascii_alphanumeric() || b"_$".contains(b));
    let alone = |at: &usize| {
        let before = at.checked_sub(1).and_then(|k| expression.get(k));
        !part(before) && !part(expression.get(at + name.len()))
    };
    memchr::memmem::find_iter(expression, name).filter(alone).collect()
}

/// Whether every place in a sum is taken away again.
///
/// `sum = ... "=" term {("+" | "-") term}`
fn cancels(statement: &[u8]) -> bool {
    let Some(sign) = memchr::memchr(b'=', statement) else { return false };
    let sum = &statement[sign + 1..];
    let plain = |b: &u8| b.is_ascii_alphanumeric() || b"+-_]. ".contains(b);
    let count = |name: &&[u8]| {
        let signs = terms(sum, name).into_iter().map(|at| match sum[..at].trim_ascii_end().last() {
            Some(b'-') => -1,
            _ => 1,
        });
        signs.sum::<i32>() == 0
    };
    sum.iter().all(plain) && PLACES.iter().all(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fanuc::statement::{Statement, words};

    fn reads(line: &str) -> bool {
        let text = Text::new("p.ls", line.as_bytes().to_vec());
        let whole = std::iter::once(0..line.len()).collect();
        reads_place(&text, &words(&text, &Statement { pieces: whole, ..Statement::default() }))
    }

    #[test]
    fn the_place_is_read_wherever_it_stands_in_an_expression() {
        for line in [
            "PR[10]=LPOS",
            "P[9] = JPOS",
            "PR[10]=PR[2]+LPOS",
            "PR[10]=PR[2] - LPOS",
            "PR[10]=LPOS-P[1]",
            "PR[10]=LPOS-LPOS+LPOS",
            "PR[10]=LPOS-JPOS",
            "IF R[1]=1,PR[10]=LPOS",
            "R[1]=(R[2]*LPOS)",
            "FOR R[1]=1 TO LPOS",
            "R[1]=$SCR_GRP[1].$MCH_POS_X",
            "PR[100,3]=$SCR_GRP[1].$MCH_POS_Z+R[103]",
            "IF $SCR_GRP[1].$MCH_POS_Z>=100,JMP LBL[1]",
            "R[1]=$SCR_GRP[1].$MCH_ANG[2]",
            "R[1]=$MOR_GRP[1].$CURRENT_ANG[1]",
        ] {
            assert!(reads(line), "{line}");
        }
    }

    #[test]
    fn a_name_and_a_difference_of_the_place_to_itself_read_nothing() {
        for line in [
            "PR[1]=LPOS-LPOS",
            "PR[1]=JPOS-JPOS+PR[2]",
            "PR[3] = LPOS - LPOS",
            "PR[10,3:Home Lpos]=R[5:LPOS]",
            "R[1:JPOS]=PR[4,1:Home Jpos]",
            "CALL LPOS",
            "CALL GET_LPOS(1)",
            "IF R[1]=1,CALL LPOS",
            "SET LPOS",
            "//PR[1]=LPOS",
            "!LPOS",
            "R[1]=$SCR_GRP[1].$MCH_STATE",
        ] {
            assert!(!reads(line), "{line}");
        }
    }
}
