//! Text to rows: targets and their places, with every refusal.
//!
//! A row that is plain throughout takes the fast way ([`fast`](super::fast)); any other is cut into cells
//! ([`record`](super::record)). A parser counts lines and points from wherever it stands, so that pieces of a program can be
//! parsed side by side ([`Parser::fresh`]) and be put in their places afterwards ([`piece`](super::piece)).

use super::super::{Block, RowSpan, Slot, Token, lines::Lines};
use super::fast::Scratch;
use super::header::{Column, Header, quote_error};
use super::number;
use super::record::{Record, Seen, content};
use super::shape::MOST_PURE;
use crate::axes::Axes;
use crate::error::{Error, Place, Result, in_few_digits};

/// A row that is longer is refused.
pub(super) const LONGEST_ROW: usize = 8 << 20;

/// Parses the rows of a program.
#[derive(Debug, Clone)]
pub struct Parser {
    pub(super) name: String,
    pub(super) header: Header,
    /// Edge unit to SI, per axis; the number of axes.
    pub(super) si: Vec<f64>,
    /// Unit of the times, s.
    pub(super) time_s: f64,
    /// Where the numbers of a row go, if the columns hold nothing else: axis (`None`: the time) and unit to SI.
    pub(super) pure: Vec<(Option<usize>, f64)>,
    /// Memory for rows of short numbers alone.
    pub(super) scratch: Scratch,
    pub(super) record: Record,
    /// No text follows.
    pub(super) ended: bool,
    pub(super) line: u64,
    pub(super) point: u64,
    pub(super) last_t_s: Option<f64>,
    pub(super) lines: Lines,
}

pub(super) enum Aside {
    /// A comment or a blank line; the next line starts here.
    Line(usize),
    Cut,
    Row,
}

impl Parser {
    /// Before the header is known.
    pub(super) fn new(name: &str, robot: &Axes) -> Self {
        Self {
            name: name.into(),
            header: Header { columns: Vec::new(), slots: Vec::new(), names: Vec::new() },
            si: robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect(),
            time_s: 1.0,
            pure: Vec::new(),
            scratch: Scratch::default(),
            record: Record::default(),
            ended: false,
            line: 1,
            point: 0,
            last_t_s: None,
            lines: Lines::default(),
        }
    }

    /// For the same columns, at no place in particular: line 0, point 0.
    pub fn fresh(&self) -> Self {
        Self { line: 0, point: 0, last_t_s: None, lines: Lines::default(), ..self.clone() }
    }

    pub(super) fn set_header(&mut self, header: Header) {
        let slots = &header.slots;
        let unit = slots.iter().find_map(|s| if let Slot::Time(per_s) = *s { Some(f64::from(per_s)) } else { None });
        self.time_s = unit.map_or(1.0, |per_s| 1.0 / per_s);
        let durations = slots.contains(&Slot::Duration);
        if slots.len() == header.columns.len() && slots.len() <= MOST_PURE && !durations {
            let target = |slot: &Slot| match *slot {
                Slot::Axis(axis) => (Some(axis), self.si[axis]),
                Slot::Time(_) | Slot::Duration => (None, self.time_s),
            };
            self.pure = slots.iter().map(target).collect();
        }
        self.header = header;
    }

    /// The message for a row that does not end.
    pub(super) fn endless(&self) -> Error {
        Error::bad(
            Place::line(&self.name, self.line),
            format!("a line of more than {} MB, or a quote that is not closed", LONGEST_ROW >> 20),
            "rows of a program",
        )
    }

    pub(super) fn has_times(&self) -> bool {
        self.header.slots.iter().any(|s| matches!(s, Slot::Time(_)))
    }

    /// Reads the rows that begin between `at` and `end` as far as they are whole; gives the place after the last.
    ///
    /// `rows = {row | {blank} ["#" comment] newline}`
    pub(super) fn rows(&mut self, text: &[u8], mut at: usize, end: usize, block: &mut Block) -> Result<usize> {
        block.first_point = self.point;
        block.decimals.resize(self.header.slots.len(), 0);
        if !self.pure.is_empty() {
            // memory for rows of this length; more where they become shorter
            let rows = text.len() / (3 * self.pure.len());
            block.tokens.reserve(rows / 2 * self.pure.len());
            block.mantissas.reserve(rows / 2 * self.pure.len());
            block.q.reserve(rows / 2 * self.si.len());
            block.rows.reserve(rows / 2);
        }
        while let Some(&byte) = text.get(at).filter(|_| at < end) {
            if !self.pure.is_empty() {
                let next = self.pure_rows(text, at, end, block)?;
                if next > at {
                    at = next;
                    continue;
                }
            }
            if matches!(byte, b'#' | b'\n' | b'\r' | b' ' | b'\t') {
                match self.aside(text, at) {
                    Aside::Line(next) => {
                        at = next;
                        continue;
                    }
                    Aside::Cut => break,
                    Aside::Row => {}
                }
            }
            let next = match self.plain_row(text, at, block) {
                Some(next) => {
                    self.lines.note(self.point, self.line);
                    self.line += 1;
                    next
                }
                None => match self.any_row(text, at, block)? {
                    Some(next) => next,
                    None => break,
                },
            };
            if let Some(&t) = block.t_s.last() {
                self.check_time(t)?;
            }
            block.rows.push(RowSpan { start: at as u32, end: next as u32 });
            self.point += 1;
            at = next;
        }
        Ok(at)
    }

    /// Any row; `None`: it is cut.
    ///
    /// `row = cell {"," cell} newline`
    fn any_row(&mut self, text: &[u8], start: usize, block: &mut Block) -> Result<Option<usize>> {
        let mut record = std::mem::take(&mut self.record);
        let seen = record.find(text, start, self.ended);
        if seen == Seen::Cut {
            self.record = record;
            return Ok(None);
        }
        if let Seen::Quote(cell) = seen {
            return Err(quote_error(&self.name, self.line, cell));
        }
        let columns = self.header.columns.len();
        if record.cells.len() != columns {
            let found = format!("{} cells", record.cells.len());
            let mut expected = format!("{columns} cells, as in the header");
            if text[start..record.end].contains(&b';') || record.cells.len() > columns {
                expected.push_str(" (commas between cells, decimal points in numbers)");
            }
            return Err(Error::bad(Place::line(&self.name, self.line), found, expected));
        }
        let base = block.q.len();
        block.q.resize(base + self.si.len(), 0.0);
        for (k, column) in self.header.columns.iter().enumerate() {
            let Column::Slot(slot) = *column else { continue };
            let (s, e) = content(text, record.cells[k]);
            let body = &text[s..e];
            let number = number::any(body).filter(|_| body.len() <= usize::from(u16::MAX));
            let number = number.ok_or_else(|| self.no_number(k, body))?;
            let exponent = body.iter().any(|b| matches!(b, b'e' | b'E'));
            let plain = number::is_plain(body) && !exponent && (s, e) == record.cells[k];
            block.tokens.push(Token { start: s as u32, len: (e - s) as u16, decimals: number.decimals, plain });
            block.mantissas.push(number.mantissa);
            block.decimals[slot] = block.decimals[slot].max(number.decimals);
            match self.header.slots[slot] {
                Slot::Axis(axis) => block.q[base + axis] = number.value * self.si[axis],
                Slot::Time(_) => block.t_s.push(number.value * self.time_s),
                Slot::Duration => block.durations.push(number.value),
            }
        }
        self.lines.note(self.point, self.line);
        self.line += 1 + record.breaks;
        let end = record.end;
        self.record = record;
        Ok(Some(end))
    }

    fn no_number(&self, column: usize, body: &[u8]) -> Error {
        let head = &self.header.names[column];
        let text = String::from_utf8_lossy(body);
        let found = match () {
            () if body.is_empty() => format!("an empty cell in column `{head}`"),
            () if body.contains(&b',') => format!("a decimal comma, `{text}`, in column `{head}`"),
            () => format!("`{text}` in column `{head}`"),
        };
        let place = Place::field(&self.name, self.line, column as u64 + 1);
        Error::bad(place, found, "a finite number with a decimal point")
    }

    pub(super) fn check_time(&mut self, t: f64) -> Result<()> {
        if let Some(before) = self.last_t_s
            && t <= before
        {
            let slot = self.header.slots.iter().position(|s| matches!(s, Slot::Time(_))).unwrap_or(0);
            // the line counter already stands after this row
            let line = self.lines.line(self.point).unwrap_or(self.line);
            let place = Place::field(&self.name, line, self.header.column_of(slot));
            let found = format!("time {} s after {} s", in_few_digits(t), in_few_digits(before));
            return Err(Error::bad(place, found, "times that strictly increase"));
        }
        self.last_t_s = Some(t);
        Ok(())
    }

    /// Whether the line at `at` is a comment or blank.
    ///
    /// `aside = {blank} ["#" comment] newline`
    pub(super) fn aside(&mut self, text: &[u8], at: usize) -> Aside {
        let first = at + text[at..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
        match text.get(first) {
            Some(b'#' | b'\n' | b'\r') => {}
            Some(_) => return Aside::Row,
            None if self.ended && first > at => return Aside::Line(first),
            None if self.ended => return Aside::Row,
            None => return Aside::Cut,
        }
        let next = match memchr::memchr2(b'\n', b'\r', &text[first..]).map(|k| first + k) {
            None if self.ended => text.len(),
            None => return Aside::Cut,
            Some(k) if text[k] == b'\n' => k + 1,
            Some(k) => match text.get(k + 1) {
                None if !self.ended => return Aside::Cut,
                next => k + 1 + usize::from(next == Some(&b'\n')),
            },
        };
        self.line += 1;
        Aside::Line(next)
    }
}
