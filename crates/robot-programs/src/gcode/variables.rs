//! Variables `#1`, `#<name>` and expressions `[#1*2+3]` that have one value whatever runs.
//!
//! A variable is known after a block that assigns it an expression of known things, until the next label, loop, condition or
//! call. Across labels, loops and conditions only those stay that one block of the whole text assigns, and that before the
//! first of these: control cannot come by without it. Parameters from `#1000` on belong to the control and are never known.
//!
//! Angles are in degrees. Reference: NISTIR 6556, 3.3.2; the Fanuc custom macro writes the same expressions.

use super::assignments::Assignments;
use crate::script::Text;
use crate::script::number::{self, Style};
use std::collections::{BTreeMap, BTreeSet};

/// Deepest nesting that is read.
const DEEPEST: usize = 32;
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
        let from = line.iter().position(|&b| b == b'=')? + 1;
        let mut read = Reader { line, at: from, known: self, depth: 0 };
        let value = read.sum().filter(|v| v.is_finite())?;
        let rest = line.get(read.at..)?.trim_ascii_start();
        matches!(rest.first(), None | Some(b';' | b'(')).then_some(value)
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
        let mut read = Reader { line: expression, at: 0, known: self, depth: 0 };
        let value = read.one()?;
        read.blanks();
        if read.at < expression.len() || !value.is_finite() {
            return None;
        }
        let off = |d: u8| (value - (value * 10f64.powi(d.into())).round() / 10f64.powi(d.into())).abs();
        let decimals = DECIMALS.clone().find(|&d| off(d) < 1e-9).unwrap_or(*DECIMALS.end());
        // the noise of sums is none of the program's
        let rounded =
            if off(decimals) < 1e-9 { number::write(value, Style::default(), decimals).parse().ok()? } else { value };
        Some((rounded, Style { decimals, point: true, ..Style::default() }))
    }
}

/// The name of a variable at a `#`, and where it ends; `None`: it is computed.
///
/// `name = "#" ("<" {any} ">" | digit {digit})`
fn name(line: &[u8], hash: usize) -> Option<(String, usize)> {
    let rest = &line[hash + 1..];
    match rest.first()? {
        b'<' => {
            let len = rest.iter().position(|&b| b == b'>')?;
            let own = rest[1..len].iter().filter(|b| !b.is_ascii_whitespace()).map(|b| b.to_ascii_lowercase());
            Some((format!("#<{}>", String::from_utf8_lossy(&own.collect::<Vec<u8>>())), hash + len + 2))
        }
        b'0'..=b'9' => {
            let len = rest.iter().take_while(|b| b.is_ascii_digit()).count();
            let n: u32 = std::str::from_utf8(&rest[..len]).ok()?.parse().ok()?;
            Some((format!("#{n}"), hash + 1 + len))
        }
        _ => None,
    }
}

/// An expression while it is read.
struct Reader<'a> {
    line: &'a [u8],
    at: usize,
    known: &'a Variables,
    depth: usize,
}

impl Reader<'_> {
    fn blanks(&mut self) {
        while matches!(self.line.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    fn mark(&mut self, marks: &[u8]) -> Option<u8> {
        self.blanks();
        let mark = *self.line.get(self.at).filter(|b| marks.contains(b))?;
        // `**` is a power, which is not read
        if mark == b'*' && self.line.get(self.at + 1) == Some(&b'*') {
            return None;
        }
        self.at += 1;
        Some(mark)
    }

    /// `sum = product {("+" | "-") product}`
    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        while let Some(m) = self.mark(b"+-") {
            let next = self.product()?;
            value = if m == b'+' { value + next } else { value - next };
        }
        Some(value)
    }

    /// `product = one {("*" | "/") one}`
    fn product(&mut self) -> Option<f64> {
        let mut value = self.one()?;
        while let Some(m) = self.mark(b"*/") {
            let next = self.one()?;
            value = if m == b'*' { value * next } else { value / next };
        }
        Some(value)
    }

    /// `bracket = "[" sum "]"`
    fn bracket(&mut self) -> Option<f64> {
        self.mark(b"[")?;
        let value = self.sum()?;
        self.mark(b"]")?;
        Some(value)
    }

    /// An operand.
    ///
    /// `one = ("+" | "-") one | bracket | name | number | function`
    fn one(&mut self) -> Option<f64> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return None;
        }
        self.blanks();
        let value = match *self.line.get(self.at)? {
            m @ (b'+' | b'-') => {
                self.at += 1;
                let value = self.one()?;
                Some(if m == b'-' { -value } else { value })
            }
            b'[' => self.bracket(),
            b'#' => {
                let (name, end) = name(self.line, self.at)?;
                self.at = end;
                self.known.values.get(&name).copied()
            }
            b'0'..=b'9' | b'.' => {
                let rest = &self.line[self.at..];
                let len = rest.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                self.at += len;
                number::read(&rest[..len]).map(|v| v.0)
            }
            b if b.is_ascii_alphabetic() => self.function(),
            _ => None,
        };
        self.depth -= 1;
        value
    }

    /// A function and its value.
    ///
    /// `function = ("SIN" | "COS" | "TAN" | "ABS" | "SQRT") bracket`
    fn function(&mut self) -> Option<f64> {
        let rest = &self.line[self.at..];
        let len = rest.iter().take_while(|b| b.is_ascii_alphabetic()).count();
        let name = String::from_utf8_lossy(&rest[..len]).to_ascii_uppercase();
        self.at += len;
        let value = self.bracket()?;
        match name.as_str() {
            "SIN" => Some(value.to_radians().sin()),
            "COS" => Some(value.to_radians().cos()),
            "TAN" => Some(value.to_radians().tan()),
            "ABS" => Some(value.abs()),
            "SQRT" if value >= 0.0 => Some(value.sqrt()),
            _ => None,
        }
    }
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
