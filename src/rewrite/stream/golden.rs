//! `--check`: the output against a golden file, and the first difference in degrees (or mm) and micrometres.
//!
//! Without a tolerance the bytes are compared as they come. With one, lines are ([`crate::rewrite::near`]).

use crate::error::{Error, Result, shown};
use crate::io::input;
use crate::program::Slot;
use crate::program::csv::header::{Column, Header};
use crate::program::csv::number;
use crate::program::csv::record::{Record, Seen, content};
use crate::rewrite::near::same_line;
use crate::rewrite::sink::Sink;
use crate::robot::Robot;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Longest line that a message looks at.
const LONGEST: usize = 1 << 16;

/// Compares what it takes with a file.
pub struct Golden {
    file: BufReader<Box<dyn Read + Send>>,
    name: String,
    line: u64,
    /// Largest difference of two numbers; `None`: every byte counts.
    tolerance: Option<f64>,
    /// The present line as far as both agree; with a tolerance, as far as it has come.
    same: Vec<u8>,
    difference: Option<Difference>,
}

/// The first line that differs.
#[derive(Debug, Clone)]
pub struct Difference {
    pub line: u64,
    pub ours: Vec<u8>,
    pub golden: Vec<u8>,
    ours_ended: bool,
}

impl Golden {
    /// Compares with the file at `path`; numbers may differ by `tolerance`.
    pub fn open(path: &Path, tolerance: Option<f64>) -> Result<Self> {
        let file = BufReader::with_capacity(1 << 18, input::open(path)?);
        Ok(Self { file, name: shown(path), line: 1, tolerance, same: Vec::new(), difference: None })
    }

    /// The first difference, once everything has been taken.
    pub fn finish(mut self) -> Result<Option<Difference>> {
        if self.tolerance.is_some() && self.difference.is_none() && !self.same.is_empty() {
            let last = std::mem::take(&mut self.same);
            self.take_line(last)?;
        }
        if self.difference.is_none() {
            let golden = self.rest_of_line(Vec::new())?;
            if !golden.is_empty() {
                let ours = self.same.clone();
                let golden = [self.same.as_slice(), &golden].concat();
                self.difference = Some(Difference { line: self.line, ours, golden, ours_ended: true });
            }
        }
        Ok(self.difference)
    }

    /// `line` and what follows in the file up to the end of its line.
    fn rest_of_line(&mut self, mut line: Vec<u8>) -> Result<Vec<u8>> {
        if line.last() != Some(&b'\n') && line.len() < LONGEST {
            let most = (LONGEST - line.len()) as u64;
            let mut rest = (&mut self.file).take(most);
            rest.read_until(b'\n', &mut line).map_err(|e| Error::io_of(&self.name, "read", e))?;
        }
        Ok(line)
    }

    /// Compares one line within the tolerance.
    fn take_line(&mut self, ours: Vec<u8>) -> Result<()> {
        let golden = self.rest_of_line(Vec::new())?;
        if same_line(&ours, &golden, self.tolerance) {
            self.line += 1;
        } else {
            self.difference = Some(Difference { line: self.line, ours, golden, ours_ended: true });
        }
        Ok(())
    }

    /// Compares the lines that `bytes` complete, within the tolerance.
    fn take_lines(&mut self, bytes: &[u8]) -> Result<()> {
        for part in bytes.split_inclusive(|c| *c == b'\n') {
            self.same.extend_from_slice(part);
            if self.same.last() == Some(&b'\n') && self.difference.is_none() {
                let line = std::mem::take(&mut self.same);
                self.take_line(line)?;
            }
        }
        Ok(())
    }
}

impl Sink for Golden {
    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        let upto_line_end = |b: &[u8]| memchr::memchr(b'\n', b).map_or(b.len(), |k| k + 1);
        if let Some(d) = &mut self.difference {
            if !d.ours_ended {
                let k = upto_line_end(bytes).min(LONGEST);
                d.ours.extend_from_slice(&bytes[..k]);
                d.ours_ended = d.ours.last() == Some(&b'\n') || d.ours.len() >= LONGEST;
            }
            return Ok(());
        }
        if self.tolerance.is_some() {
            return self.take_lines(bytes);
        }
        let mut golden = Vec::with_capacity(bytes.len());
        (&mut self.file)
            .take(bytes.len() as u64)
            .read_to_end(&mut golden)
            .map_err(|e| Error::io_of(&self.name, "read", e))?;
        let same = bytes.iter().zip(&golden).position(|(a, b)| a != b).unwrap_or(golden.len().min(bytes.len()));
        self.line += memchr::memchr_iter(b'\n', &bytes[..same]).count() as u64;
        match memchr::memrchr(b'\n', &bytes[..same]) {
            Some(k) => self.same = bytes[k + 1..same].to_vec(),
            None => self.same.extend_from_slice(&bytes[..same]),
        }
        if same < bytes.len() {
            let rest = &bytes[same..];
            let ours = [self.same.as_slice(), &rest[..upto_line_end(rest)]].concat();
            let rest = &golden[same..];
            let theirs = [self.same.as_slice(), &rest[..upto_line_end(rest)]].concat();
            let golden = self.rest_of_line(theirs)?;
            let ours_ended = ours.last() == Some(&b'\n');
            self.difference = Some(Difference { line: self.line, ours, golden, ours_ended });
        }
        Ok(())
    }
}

/// The numbers of a line: `(column name, axis, value in deg or mm)`.
fn targets(line: &[u8], header: &Header) -> Option<Vec<(String, usize, f64)>> {
    let mut record = Record::default();
    if record.find(line, 0, true) != Seen::Whole || record.cells.len() != header.columns.len() {
        return None;
    }
    let mut found = Vec::new();
    for (k, column) in header.columns.iter().enumerate() {
        if let Column::Slot(s) = *column
            && let Slot::Axis(axis) = header.slots[s]
        {
            let (from, to) = content(line, record.cells[k]);
            found.push((header.names[k].clone(), axis, number::any(&line[from..to])?.value));
        }
    }
    Some(found)
}

/// The difference in words: which numbers, by how much, and what that moves at the TCP.
pub fn explain(d: &Difference, golden: &str, header: &Header, robot: &Robot) -> String {
    let text = |b: &[u8]| String::from_utf8_lossy(b).trim_end().to_string();
    let head = format!("{golden}:{}: the output differs", d.line);
    if d.ours.is_empty() || d.golden.is_empty() {
        let which = if d.ours.is_empty() { "the output ends" } else { "the golden file ends" };
        return format!("{head}: {which} before this line");
    }
    let (Some(ours), Some(theirs)) = (targets(&d.ours, header), targets(&d.golden, header)) else {
        return format!("{head}: `{}` instead of `{}`", text(&d.ours), text(&d.golden));
    };
    let mut q = [vec![0.0; robot.dof()], vec![0.0; robot.dof()]];
    let mut lines = vec![head];
    for ((name, axis, a), (_, _, b)) in ours.iter().zip(&theirs) {
        let kind = robot.axis(*axis).kind;
        q[0][*axis] = a * kind.si_per_user_unit();
        q[1][*axis] = b * kind.si_per_user_unit();
        if a != b {
            lines.push(format!("  {name}: {a} instead of {b}: {:+.6} {}", a - b, kind.unit()));
        }
    }
    if lines.len() == 1 {
        return format!("{}: `{}` instead of `{}`", lines[0], text(&d.ours), text(&d.golden));
    }
    let moved_um = (robot.tcp_m(&q[0]) - robot.tcp_m(&q[1])).norm() * 1e6;
    lines.push(format!("  at the TCP {moved_um:.2} um"));
    lines.join("\n")
}
