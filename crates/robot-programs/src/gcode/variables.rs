//! Variables `#1`, `#<name>` and expressions `[#1*2+3]` that have one value whatever runs.
//!
//! A variable is known after a block that assigns it an expression of known things, until the next label, loop, condition or
//! call. Across labels, loops and conditions only those stay that one block of the whole text assigns, and that before the
//! first of these: control cannot come by without it. Parameters from `#1000` on belong to the control and are never known.
//!
//! Angles are in degrees. Reference: NISTIR 6556, 3.3.2; the Fanuc custom macro writes the same expressions.

use super::assignments::Assignments;
use crate::script::Text;
use crate::script::cursor::{Cursor, integer};
use crate::script::fold::{self, Known, Part};
use crate::script::lex::text_of;
use crate::script::number::{self, Style};
use std::collections::{BTreeMap, BTreeSet};

/// Decimals of a folded number at least and at most.
const DECIMALS: std::ops::RangeInclusive<u8> = 4..=6;

/// What is known of the variables of a program.
#[derive(Default)]
pub(super) struct Variables {
    values: BTreeMap<String, f64>,
    /// Known whatever was jumped over.
    lasting: BTreeSet<String>,
    /// Assigned by one plain block of the text alone.
    single: BTreeSet<String>,
    /// A label, loop, condition or call came before.
    branched: bool,
}

impl Variables {
    /// A look over the whole text: which variables one block alone assigns.
    pub(super) fn of(text: &Text) -> Self {
        let mut count: BTreeMap<String, usize> = BTreeMap::new();
        for found in (0..text.line_count()).filter_map(|k| Assignments::of(text.line(k))) {
            if found.any || found.hidden {
                return Self { branched: true, ..Self::default() };
            }
            for name in found.names {
                // one that may not run, or beside another, is as good as two
                *count.entry(name).or_default() += if found.plain { 1 } else { 2 };
            }
        }
        let single = count.into_iter().filter(|(_, n)| *n == 1).map(|(name, _)| name).collect();
        Self { single, ..Self::default() }
    }

    /// Takes what a line assigns.
    pub(super) fn assign(&mut self, line: &[u8], found: &Assignments) {
        if found.any || found.hidden {
            return self.forget();
        }
        let value = if found.plain { self.value(line) } else { None };
        for name in &found.names {
            self.values.remove(name);
            self.lasting.remove(name);
        }
        if let (Some(value), [name]) = (value, found.names.as_slice()) {
            if !self.branched && self.single.contains(name) {
                self.lasting.insert(name.clone());
            }
            self.values.insert(name.clone(), value);
        }
    }

    /// The value that stands after the `=` of a line with one assignment; nothing but a comment may follow.
    ///
    /// `assignment = "#" name "=" expression [comment]`
    fn value(&self, line: &[u8]) -> Option<f64> {
        let after = line.get(memchr::memchr(b'=', line)? + 1..)?;
        let end = after.iter().position(|b| matches!(b, b';' | b'(')).unwrap_or(after.len());
        fold::fold(&parts(after.get(..end)?.trim_ascii_end())?, self)
    }

    /// Control may come from elsewhere.
    pub(super) fn join(&mut self) {
        self.branched = true;
        self.values.retain(|name, _| self.lasting.contains(name));
    }

    /// Something else runs, which may assign any.
    pub(super) fn forget(&mut self) {
        self.branched = true;
        self.values.clear();
        self.lasting.clear();
    }

    /// The value of what stands after a letter, and a style for its number.
    pub(super) fn fold(&self, expression: &[u8]) -> Option<(f64, Style)> {
        let value = fold::operand(&parts(expression)?, self)?;
        let rounded = DECIMALS.map(|d| (d, number::rounded(value, d))).find(|(_, r)| (value - r).abs() < 1e-9);
        // the noise of sums is none of the program's
        let (decimals, value) = rounded.unwrap_or((*DECIMALS.end(), value));
        Some((value, Style { decimals, point: true, ..Style::default() }))
    }
}

impl Known for Variables {
    fn name(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied()
    }

    /// `function = ("SIN" | "COS" | "TAN" | "ABS" | "SQRT") "[" expression "]"`
    fn call(&self, name: &str, value: f64) -> Option<f64> {
        match name {
            "SIN" => Some(value.to_radians().sin()),
            "COS" => Some(value.to_radians().cos()),
            "TAN" => Some(value.to_radians().tan()),
            "ABS" => Some(value.abs()),
            "SQRT" if value >= 0.0 => Some(value.sqrt()),
            _ => None,
        }
    }
}

/// The parts of an expression; `None`: one of them is none that is read.
///
/// `expression = {blank | "+" | "-" | "*" | "/" | "[" | "]" | number | name | function}`,
/// `name = "#" ("<" {any} ">" | digit {digit})`, `function = letter {letter}`
fn parts(expression: &[u8]) -> Option<Vec<Part>> {
    let mut cursor = Cursor::new(expression);
    let mut found = Vec::new();
    while let Some(b) = cursor.peek() {
        let from = cursor.at();
        cursor.skip(1);
        found.push(match b {
            b' ' | b'\t' => continue,
            b'[' => Part::Mark(b'('),
            b']' => Part::Mark(b')'),
            b'+' | b'-' | b'*' | b'/' => Part::Mark(b),
            b'#' => Part::Name(name(&mut cursor)?),
            b'0'..=b'9' | b'.' => {
                cursor.while_is(|b| b.is_ascii_digit() || b == b'.');
                Part::Number(number::read(cursor.since(from))?.0)
            }
            _ if b.is_ascii_alphabetic() => {
                cursor.letters();
                Part::Name(text_of(cursor.since(from)).to_ascii_uppercase())
            }
            _ => return None,
        });
    }
    Some(found)
}

/// The name of a variable after its `#`; `None`: it is computed.
fn name(cursor: &mut Cursor) -> Option<String> {
    let from = cursor.at();
    if cursor.eat(b'<') {
        cursor.past(b">").then_some(())?;
        let own = cursor.since(from).iter().filter(|b| !b.is_ascii_whitespace()).map(|b| b.to_ascii_lowercase());
        return Some(format!("#{}", text_of(&own.collect::<Vec<u8>>())));
    }
    let n: u32 = integer(cursor.digits())?;
    Some(format!("#{n}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assign(known: &mut Variables, line: &str) {
        let found = Assignments::of(line.as_bytes()).unwrap_or_else(|| panic!("{line}"));
        known.assign(line.as_bytes(), &found);
    }

    fn after(lines: &[&str]) -> Variables {
        let mut known = Variables::of(&Text::new("t", lines.join("\n").into_bytes()));
        lines.iter().for_each(|line| assign(&mut known, line));
        known
    }

    #[test]
    fn expressions_fold_as_a_control_counts_them() {
        let known = after(&["#1=.5", "#<side len> = [2+3*4] ; a side", "#2=#1", "#3=-[#1*2]"]);
        for (text, value) in [
            ("#1", 0.5),
            ("-#1", -0.5),
            ("[#1*53.]", 26.5),
            ("#<SideLen>", 14.0),
            ("[#3 - 1]", -2.0),
            ("[8/4/2]", 1.0),
            ("SIN[30]", 0.5),
            ("[0.1+0.2]", 0.3),
        ] {
            assert_eq!(known.fold(text.as_bytes()).map(|v| v.0), Some(value), "{text}");
        }
        for text in ["#9", "[2**3]", "#[#1]", "##1", "[1", "#5021", "EXISTS[#1]", "[1/0]", "FOO[1]"] {
            assert_eq!(known.fold(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_variable_that_one_block_assigns_before_any_branch_outlives_a_loop_and_no_call() {
        let lines = ["#1=2", "#2=3", "#2=4", "#3000=7"];
        let mut known = after(&lines);
        assert_eq!(known.fold(b"[#1*#2]").map(|v| v.0), Some(8.0));
        known.join();
        assert_eq!((known.fold(b"#1").map(|v| v.0), known.fold(b"#2")), (Some(2.0), None));
        // assigned after the branch: gone at the next
        assign(&mut known, "#7=1");
        assert!(known.fold(b"#7").is_some());
        known.join();
        assert_eq!(known.fold(b"#7"), None);
        known.forget();
        assert_eq!(known.fold(b"#1"), None);
        // a computed name may be any, and two names in a line have no certain order
        for lines in [["#1=2", "#[#4]=3"], ["#1=2", "/#1=3"], ["#2=2", "#1=2 #2=#1"], ["#1=2", "#1=3 G1 X5"]] {
            let known = after(&lines);
            assert_eq!((known.fold(b"#1"), known.fold(b"#2")), (None, None), "{lines:?}");
        }
    }
}
