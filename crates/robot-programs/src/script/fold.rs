//! Expressions of plain numbers: `0.1 + 2 * 0.05`, `-d2r(90)`, `30.5 - (depth / 2)`.
//!
//! Only what has one value whatever runs is folded: numbers, names that the caller knows for certain, the four operations,
//! brackets, and functions of one number that the caller knows. All languages with expressions bind `*` and `/` before `+` and
//! `-`, and a sign before both.

use super::lex::{Kind, Token};
use super::{Text, number};

/// A part of an expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A number as it is written.
    Number(f64),
    /// A name: a variable or a function.
    Name(String),
    /// `+`, `-`, `*`, `/`, `(`, `)`.
    Mark(u8),
}

/// Tokens of an expression; `None`: one of them is no part of such an expression.
pub fn parts(text: &Text, tokens: &[Token]) -> Option<Vec<Part>> {
    let part = |t: &Token| {
        let bytes = text.slice(t.start()..t.end());
        match t.kind {
            Kind::Number => number::read(bytes).map(|v| Part::Number(v.0)),
            Kind::Word => Some(Part::Name(String::from_utf8_lossy(bytes).into_owned())),
            Kind::Mark(m) if b"+-*/()".contains(&m) => Some(Part::Mark(m)),
            _ => None,
        }
    };
    tokens.iter().map(part).collect()
}

/// Deepest nesting that is read.
const DEEPEST: usize = 32;

/// What names and functions of one number are; `None`: not certain.
pub trait Known {
    /// The value of a variable.
    fn name(&self, name: &str) -> Option<f64>;
    /// The value of a function of one number.
    fn call(&self, name: &str, value: f64) -> Option<f64>;
}

/// The value of an expression; `None`: it is none of plain numbers.
pub fn fold(parts: &[Part], known: &dyn Known) -> Option<f64> {
    let mut at = Reader { parts, k: 0, known };
    let value = at.sum(0)?;
    (at.k == parts.len() && value.is_finite()).then_some(value)
}

/// Decimals of a number that takes the place of a product or a quotient.
const DECIMALS: u8 = 3;

/// What can take the place of an expression of plain numbers, as fine as its finest number, which has so many decimals; `None`: it is none.
pub fn plain(parts: &[Part], finest: u8) -> Option<(f64, number::Style)> {
    let value = fold(parts, &NoNames)?;
    let scales = parts.iter().any(|part| matches!(part, Part::Mark(b'*' | b'/')));
    let decimals = if scales { finest.max(DECIMALS) } else { finest };
    Some((value, number::Style { decimals, point: decimals > 0, ..number::Style::default() }))
}

/// No names.
struct NoNames;

impl Known for NoNames {
    fn name(&self, _name: &str) -> Option<f64> {
        None
    }

    fn call(&self, _name: &str, _value: f64) -> Option<f64> {
        None
    }
}

/// The value of one operand: a number, a name, a function, an expression in brackets; `None`: it is another expression.
pub fn operand(parts: &[Part], known: &dyn Known) -> Option<f64> {
    let mut at = Reader { parts, k: 0, known };
    let value = at.one(0)?;
    (at.k == parts.len() && value.is_finite()).then_some(value)
}

struct Reader<'a> {
    parts: &'a [Part],
    k: usize,
    known: &'a dyn Known,
}

impl Reader<'_> {
    fn mark(&mut self, marks: &[u8]) -> Option<u8> {
        match self.parts.get(self.k) {
            Some(Part::Mark(m)) if marks.contains(m) => {
                self.k += 1;
                Some(*m)
            }
            _ => None,
        }
    }

    fn sum(&mut self, depth: usize) -> Option<f64> {
        let mut value = self.product(depth)?;
        while let Some(m) = self.mark(b"+-") {
            let next = self.product(depth)?;
            value = if m == b'+' { value + next } else { value - next };
        }
        Some(value)
    }

    fn product(&mut self, depth: usize) -> Option<f64> {
        let mut value = self.one(depth)?;
        while let Some(m) = self.mark(b"*/") {
            let next = self.one(depth)?;
            value = if m == b'*' { value * next } else { value / next };
        }
        Some(value)
    }

    fn one(&mut self, depth: usize) -> Option<f64> {
        if depth > DEEPEST {
            return None;
        }
        if let Some(m) = self.mark(b"+-") {
            let value = self.one(depth + 1)?;
            return Some(if m == b'-' { -value } else { value });
        }
        if self.mark(b"(").is_some() {
            let value = self.sum(depth + 1)?;
            return self.mark(b")").map(|_| value);
        }
        let part = self.parts.get(self.k)?.clone();
        self.k += 1;
        match part {
            Part::Number(v) => Some(v),
            Part::Name(name) if self.mark(b"(").is_some() => {
                let value = self.sum(depth + 1)?;
                self.mark(b")")?;
                self.known.call(&name, value)
            }
            Part::Name(name) => self.known.name(&name),
            Part::Mark(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Two;

    impl Known for Two {
        fn name(&self, name: &str) -> Option<f64> {
            (name == "two").then_some(2.0)
        }

        fn call(&self, name: &str, value: f64) -> Option<f64> {
            (name == "half").then_some(value / 2.0)
        }
    }

    fn parts(text: &str) -> Vec<Part> {
        let part = |w: &str| match (w.parse(), w.as_bytes()) {
            (Ok(v), _) => Part::Number(v),
            (_, [m]) if b"+-*/()".contains(m) => Part::Mark(*m),
            _ => Part::Name(w.into()),
        };
        text.split(' ').map(part).collect()
    }

    #[test]
    fn products_go_before_sums_and_signs_before_both() {
        for (text, value) in [
            ("1 + 2 * 3", 7.0),
            ("( 1 + 2 ) * 3", 9.0),
            ("- 2 * - two", 4.0),
            ("8 / 4 / 2 - 1", 0.0),
            ("10 - half ( 3 + 1 ) - 1", 7.0),
        ] {
            assert_eq!(fold(&parts(text), &Two), Some(value), "{text}");
        }
    }

    #[test]
    fn a_number_for_an_expression_is_as_fine_as_its_finest_and_a_product_has_three_decimals() {
        for (text, finest, value, decimals) in
            [("1500 + 94.851", 3, 1594.851, 3), ("20 + 5", 0, 25.0, 0), ("2 * 3", 0, 6.0, 3), ("1 / 8", 4, 0.125, 4)]
        {
            let (folded, style) = plain(&parts(text), finest).unwrap();
            assert_eq!((folded, style.decimals, style.point), (value, decimals, decimals > 0), "{text}");
        }
        assert!(plain(&parts("two + 1"), 0).is_none());
    }

    #[test]
    fn what_is_not_certain_has_no_value() {
        for text in ["three", "sin ( 1 )", "1 +", "1 2", "( 1", "1 / 0", ""] {
            assert_eq!(fold(&parts(text), &Two), None, "{text}");
        }
        let deep = "( ".repeat(100) + "1" + &" )".repeat(100);
        assert_eq!(fold(&parts(&deep), &Two), None);
    }
}
