//! Rows of short numbers, compared with what was meant as they are read: nothing of them is kept.
//!
//! What this way does not take for the same is left to [`again`](super::again), which reads any row and decides.

use super::super::Token;
use super::again::{LAST_DIGITS, Meant};
use super::fast::pure_row;
use super::shape::{LONGEST, Shape};
use crate::decimal::POW10;
use crate::decimal::read::Packed;

/// Rows that are compared together: what is known of them stays in the processor's nearest memory.
const CHUNK: usize = 32;

/// Memory for rows that are read and not yet compared.
#[derive(Debug, Default)]
pub(super) struct SameRows {
    shape: Shape,
    /// Of the first row of a chunk.
    tokens: Vec<Token>,
    mantissas: Vec<Packed>,
    /// For every number of a chunk: its last digit, what it may miss, and what it is meant to be; rad, m or s.
    digit: Vec<f64>,
    within: Vec<f64>,
    meant: Vec<f64>,
}

impl SameRows {
    /// Whether `text` from place `at` on holds rows of short numbers alone, and those that were meant: the numbers of a row go to
    /// `columns` (axis, `None`: the time; unit in SI). No: it may be the same all the same. The text stays as it is.
    pub(super) fn are_all(
        &mut self,
        text: &mut Vec<u8>,
        at: usize,
        columns: &[(Option<usize>, f64)],
        meant: Meant,
    ) -> bool {
        let times = columns.iter().filter(|c| c.0.is_none()).count();
        let rows = meant.q.len() / meant.axes.max(1);
        // every axis and every time is read, once
        if columns.len() != meant.axes + times || times > 1 || meant.t_s.len() != rows * times {
            return false;
        }
        let size = CHUNK * columns.len();
        if self.digit.len() != size {
            let (none, zeros) = (vec![Packed::NONE; size], vec![0.0; size]);
            *self = Self {
                shape: Shape::default(),
                tokens: vec![Token::default(); columns.len()],
                mantissas: none,
                digit: zeros.clone(),
                within: zeros.clone(),
                meant: zeros,
            };
        }
        let end = text.len();
        // a row is looked at in words that go beyond its end
        text.resize(end + LONGEST + size_of::<u128>(), 0);
        let all = pulp::Arch::new().dispatch(Pass {
            same: self,
            text,
            at,
            end,
            columns,
            meant,
            rows,
            last_s: f64::NEG_INFINITY,
        });
        text.truncate(end);
        all
    }

    /// Takes over of what decimals the numbers of the first row of a chunk are.
    fn measure(&mut self, columns: &[(Option<usize>, f64)]) {
        for (row, within) in self.digit.chunks_exact_mut(columns.len()).zip(self.within.chunks_exact_mut(columns.len()))
        {
            for (((digit, within), token), (_, unit)) in row.iter_mut().zip(within).zip(&self.tokens).zip(columns) {
                *digit = unit / POW10[usize::from(token.decimals & 7)];
                *within = LAST_DIGITS * *digit;
            }
        }
    }
}

/// One pass through a text.
struct Pass<'a> {
    same: &'a mut SameRows,
    text: &'a [u8],
    at: usize,
    end: usize,
    columns: &'a [(Option<usize>, f64)],
    meant: Meant<'a>,
    rows: usize,
    /// Of the row before those that are held.
    last_s: f64,
}

impl pulp::NullaryFnOnce for Pass<'_> {
    type Output = bool;

    // inlined, so that it is compiled for the instructions that there are
    #[inline(always)]
    fn call(mut self) -> bool {
        let n = self.columns.len();
        let (mut done, mut held) = (0, 0);
        while self.at < self.end {
            if held == CHUNK {
                if !self.compare(done, held) {
                    return false;
                }
                (done, held) = (done + held, 0);
            }
            let place = held * n..(held + 1) * n;
            let SameRows { shape, mantissas, .. } = &mut *self.same;
            let Some(numbers) = mantissas.get_mut(place) else { return false };
            if let Some(end) = shape.numbers(self.text, self.at, numbers) {
                self.at = end;
                held += 1;
                continue;
            }
            // a row of another shape begins a chunk
            if held > 0 && !self.compare(done, held) {
                return false;
            }
            (done, held) = (done + held, 1);
            let SameRows { shape, tokens, mantissas, .. } = &mut *self.same;
            let Some(numbers) = mantissas.get_mut(..n) else { return false };
            let Some(end) = pure_row(self.text, self.at, tokens, numbers) else { return false };
            shape.take(self.text, tokens, self.at, end);
            self.at = end;
            self.same.measure(self.columns);
        }
        self.at == self.end && done + held == self.rows && self.compare(done, held)
    }
}

impl Pass<'_> {
    /// Whether the rows that are held, of which the first is the row `done`, are those that were meant.
    #[inline(always)]
    fn compare(&mut self, done: usize, held: usize) -> bool {
        let (n, axes) = (self.columns.len(), self.meant.axes);
        let Some(q) = self.meant.q.get(done * axes..(done + held) * axes) else { return false };
        let meant = if self.columns.iter().enumerate().all(|(k, c)| c.0 == Some(k)) {
            q
        } else {
            for (i, row) in self.same.meant.chunks_exact_mut(n).take(held).enumerate() {
                for (meant, (axis, _)) in row.iter_mut().zip(self.columns) {
                    let value = axis.map_or(self.meant.t_s.get(done + i), |axis| q.get(i * axes + axis));
                    *meant = value.copied().unwrap_or(f64::NAN);
                }
            }
            &self.same.meant[..held * n]
        };
        let numbers = self.same.mantissas.iter().zip(&self.same.digit).zip(&self.same.within);
        let mut same = true;
        for (((mantissa, digit), within), meant) in numbers.zip(meant) {
            same &= (mantissa.times(*digit) - meant).abs() <= *within;
        }
        same && self.times_increase(held)
    }

    /// Whether each of the times that are held is later than the one before it.
    #[inline(always)]
    fn times_increase(&mut self, held: usize) -> bool {
        let n = self.columns.len();
        let Some(k) = self.columns.iter().position(|c| c.0.is_none()) else { return true };
        let Some(digit) = self.same.digit.get(k) else { return false };
        // in a chunk all times have the same decimals; of what stood before it half a digit makes up for the rounding
        let mut before = f64::NEG_INFINITY;
        let mut later = true;
        for row in self.same.mantissas.chunks_exact(n).take(held) {
            let time = row[k].times(1.0);
            later &= time > before;
            before = time;
        }
        let first = self.same.mantissas.get(k).map_or(f64::NAN, |time| time.times(*digit));
        later &= first - self.last_s > 0.5 * digit;
        self.last_s = before * digit;
        later
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Again, Reader};
    use super::*;
    use crate::axes::{Axes, Axis, JointKind};
    use proptest::prelude::*;

    /// Two axes and times, in an order that is not that of the robot.
    const HEAD: &str = "x_mm,t_s,a_deg\n";

    fn again(head: &str) -> Again {
        let axes = Axes::new("two", vec![Axis::new("A", JointKind::Revolute), Axis::new("X", JointKind::Prismatic)]);
        let text = format!("{head}1.0,0.0,1.0\n");
        let (_, parser, _) = Reader::new(Box::new(std::io::Cursor::new(text)), "p.csv", &axes).unwrap().split();
        Again::new(&parser)
    }

    /// What the fast way says of rows, and what the general way finds.
    fn found(rows: &str, q: &[f64], t_s: &[f64]) -> (bool, Option<usize>) {
        let mut again = again(HEAD);
        let mut text = format!("{HEAD}{rows}").into_bytes();
        let meant = Meant { axes: 2, q, t_s };
        let fast = again.rows.are_all(&mut text, HEAD.len(), &again.parser.pure, meant);
        assert_eq!(text, format!("{HEAD}{rows}").into_bytes());
        (fast, again.first_difference_of_any(&mut text, HEAD.len(), meant))
    }

    fn meant(rows: &[(i32, i32)]) -> (String, Vec<f64>, Vec<f64>) {
        let mut text = String::new();
        let (mut q, mut t_s) = (Vec::new(), Vec::new());
        for (i, (a, x)) in rows.iter().enumerate() {
            let (a, x, t) = (f64::from(*a) / 1e4, f64::from(*x) / 1e3, i as f64 * 0.004);
            // some rows have fewer digits
            text += &if i % 50 == 49 { format!("{x:.2},{t:.3},{a:.4}\n") } else { format!("{x:.3},{t:.3},{a:.4}\n") };
            q.extend([a.to_radians(), x / 1e3]);
            t_s.push(t);
        }
        (text, q, t_s)
    }

    proptest! {
        #[test]
        fn rows_that_are_meant_are_the_same_and_others_are_not(
            rows in prop::collection::vec((-1_800_000i32..1_800_000, -900_000i32..900_000), 1..120),
            by in 2.5..30.0f64, place in any::<prop::sample::Index>(), which in 0usize..3
        ) {
            let (text, mut q, mut t_s) = meant(&rows);
            prop_assert_eq!(found(&text, &q, &t_s), (true, None));
            let row = place.index(rows.len());
            let digits = if row % 50 == 49 { 10.0 } else { 1.0 };
            match which {
                0 => q[2 * row] += by * 1e-4f64.to_radians(),
                1 => q[2 * row + 1] -= by * digits * 1e-6,
                _ => t_s[row] += by * 1e-3,
            }
            prop_assert_eq!(found(&text, &q, &t_s), (false, Some(row)));
        }

        #[test]
        fn what_is_taken_for_the_same_is_found_the_same_by_the_general_way(
            rows in prop::collection::vec((-1_800_000i32..1_800_000, -900_000i32..900_000), 1..80),
            place in any::<prop::sample::Index>(), byte in "[-0-9.,\n# e+]"
        ) {
            let (text, q, t_s) = meant(&rows);
            let mut bytes = text.into_bytes();
            let place = place.index(bytes.len());
            bytes[place] = byte.as_bytes()[0];
            let (fast, any) = found(&String::from_utf8(bytes).unwrap(), &q, &t_s);
            prop_assert!(!fast || any.is_none(), "{:?}", any);
        }
    }

    #[test]
    fn times_that_do_not_increase_are_not_taken_for_the_same() {
        for i in [1, CHUNK - 1, CHUNK, CHUNK + 1, 2 * CHUNK] {
            let rows: Vec<(i32, i32)> = (0..100).map(|k| (k, -k)).collect();
            let (text, q, mut t_s) = meant(&rows);
            let mut lines: Vec<&str> = text.lines().collect();
            let (before, own) = (lines[i - 1].to_string(), lines[i].to_string());
            let time = |line: &str| line.split(',').nth(1).unwrap().to_string();
            // the time of the row before, and what is meant lies within a digit of both
            let twice = own.replace(&format!(",{},", time(&own)), &format!(",{},", time(&before)));
            lines[i] = &twice;
            t_s[i] = t_s[i - 1] + 0.0005;
            let (fast, any) = found(&(lines.join("\n") + "\n"), &q, &t_s);
            assert!(!fast && any.is_some(), "row {i}");
        }
    }
}
