//! States: what was the same for a whole run, such as a speed and a payload, and their order.
//!
//! A state is a combination of the values of all state columns. The reference is state 1 of the paper (D = 0): of each column
//! the smallest number, or the first text; or what the user names. The others follow in rising order.

use crate::error::{Error, Place, Result};
use std::cmp::Ordering;

/// One value of a state column: a number, however it is written, or a text.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Numbers in one form, so that `10` and `10.0` are one state.
    pub text: String,
    pub number: Option<f64>,
}

impl Level {
    /// The value of a cell.
    pub fn new(cell: &str, decimal: u8) -> Self {
        let cell = cell.trim();
        let plain = match decimal {
            b'.' => cell.to_string(),
            _ if cell.contains('.') => return Self { text: cell.into(), number: None },
            d => cell.replace(d as char, "."),
        };
        let number = plain.parse::<f64>().ok().filter(|v| v.is_finite());
        match number {
            Some(v) => Self { text: format!("{}", v + 0.0), number },
            None => Self { text: cell.into(), number: None },
        }
    }

    fn order(&self, other: &Self) -> Ordering {
        match (self.number, other.number) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => Ordering::Equal,
        }
    }
}

/// All states of a file.
#[derive(Debug, Clone, Default)]
pub struct States {
    /// Names of the state columns.
    pub names: Vec<String>,
    /// One combination each, in the order of the file until [`States::sorted`].
    pub all: Vec<Vec<Level>>,
}

impl States {
    pub(super) fn new(names: Vec<String>) -> Self {
        Self { names, all: Vec::new() }
    }

    /// Number of a combination; a new one is put at the end.
    pub(super) fn number(&mut self, levels: Vec<Level>) -> usize {
        match self.all.iter().position(|s| *s == levels) {
            Some(k) => k,
            None => {
                self.all.push(levels);
                self.all.len() - 1
            }
        }
    }

    /// Different values of column `k`, in the order of the file.
    pub fn levels(&self, k: usize) -> Vec<&Level> {
        let mut levels: Vec<&Level> = Vec::new();
        for state in &self.all {
            if !levels.contains(&&state[k]) {
                levels.push(&state[k]);
            }
        }
        levels
    }

    /// Columns that have more than one value.
    pub fn varying(&self) -> Vec<usize> {
        (0..self.names.len()).filter(|k| self.levels(*k).len() > 1).collect()
    }

    /// The order in which states are reported, the reference first. `asked`: the user's `column=value` pairs that choose the reference.
    pub(super) fn sorted(&self, asked: &[(String, String)], file: &str) -> Result<Vec<usize>> {
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        let compare = |a: &usize, b: &usize| {
            let each = self.all[*a].iter().zip(&self.all[*b]).map(|(a, b)| a.order(b));
            each.fold(Ordering::Equal, Ordering::then)
        };
        order.sort_by(compare); // stable: texts keep the order of the file
        let reference = if asked.is_empty() { order.first().copied() } else { Some(self.named(asked, &order, file)?) };
        order.sort_by_key(|k| Some(*k) != reference);
        Ok(order)
    }

    /// The first state, in the given order, that has the requested values.
    pub fn named(&self, asked: &[(String, String)], order: &[usize], file: &str) -> Result<usize> {
        let mut wanted = Vec::new();
        for (name, value) in asked {
            let Some(k) = self.names.iter().position(|n| n.eq_ignore_ascii_case(name)) else {
                let known = if self.names.is_empty() { "no state column".into() } else { self.names.join(", ") };
                return Err(Error::bad(
                    Place::file(file),
                    format!("no state column `{name}` (there is {known})"),
                    "a state column of the file, as column=value",
                ));
            };
            let level = Level::new(value, b'.');
            if !self.levels(k).contains(&&level) {
                let values: Vec<&str> = self.levels(k).iter().map(|l| l.text.as_str()).collect();
                return Err(Error::bad(
                    Place::file(file),
                    format!("no reading with {name}={value}"),
                    format!("{name} of {}", values.join(", ")),
                ));
            }
            wanted.push((k, level));
        }
        let fits = |s: &usize| wanted.iter().all(|(k, level)| self.all[*s][*k] == *level);
        order.iter().copied().find(fits).ok_or_else(|| {
            let text: Vec<String> = asked.iter().map(|(n, v)| format!("{n}={v}")).collect();
            Error::bad(
                Place::file(file),
                format!("no reading with the combination {}", text.join(", ")),
                "a combination of values that occurs",
            )
        })
    }

    /// A state in words, by the columns that vary: `speed_mm_s=10, payload_kg=2.23`.
    pub fn text(&self, state: usize) -> String {
        self.join(state, self.varying(), ", ")
    }

    /// What a state has that the reference has not: `speed_mm_s=6000`.
    pub fn difference(&self, state: usize, reference: usize) -> String {
        let differs = |k: &usize| self.all[state][*k] != self.all[reference][*k];
        self.join(state, (0..self.names.len()).filter(differs).collect(), ",")
    }

    fn join(&self, state: usize, columns: Vec<usize>, between: &str) -> String {
        let parts: Vec<String> =
            columns.into_iter().map(|k| format!("{}={}", self.names[k], self.all[state][k].text)).collect();
        parts.join(between)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn states(rows: &[[&str; 2]]) -> States {
        let mut s = States::new(vec!["speed_mm_s".into(), "tool".into()]);
        for row in rows {
            s.number(row.iter().map(|c| Level::new(c, b'.')).collect());
        }
        s
    }

    #[test]
    fn the_reference_is_the_smallest_number_and_the_first_text_unless_named() {
        let s = states(&[["6000", "b"], ["10", "b"], ["10.0", "b"], ["1000", "a"]]);
        assert_eq!(s.all.len(), 3);
        assert_eq!(s.sorted(&[], "f").unwrap(), [1, 2, 0]);
        let asked = [("SPEED_mm_s".to_string(), "1000.0".to_string())];
        assert_eq!(s.sorted(&asked, "f").unwrap(), [2, 1, 0]);
        assert_eq!(s.difference(0, 1), "speed_mm_s=6000");
        assert_eq!(s.difference(2, 1), "speed_mm_s=1000,tool=a");
    }

    #[test]
    fn a_reference_that_is_not_there_is_refused_with_what_is() {
        let s = states(&[["6000", "b"], ["10", "a"]]);
        for (name, value, says) in
            [("speed_mm_s", "20", "speed_mm_s of 6000, 10"), ("payload_kg", "2", "no state column `payload_kg`")]
        {
            let e = s.sorted(&[(name.into(), value.into())], "f").unwrap_err().to_string();
            assert!(e.contains(says), "{e}");
        }
        let both = [("speed_mm_s".to_string(), "10".to_string()), ("tool".to_string(), "b".to_string())];
        assert!(s.sorted(&both, "f").unwrap_err().to_string().contains("no reading with the combination"));
    }
}
