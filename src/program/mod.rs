//! A program as text with places: every motion target keeps the bytes it was written with, so that an edit touches its
//! digits and nothing else. Knows formats, joints and units; knows nothing of compensation.
//!
//! A program is read in [`Block`]s of whole rows, so that one of any length passes in constant memory. A block holds its
//! text, the joint targets in SI, and for every target the [`Token`] (span and style) from which it was read.
//!
//! Rooms:
//! - [`csv`]: joint-space CSV: header, cells, rows in; numbers and rows out; [`lines`]: point -> line of the file.
//! - [`script`]: vendor programs, read whole: the interface that each of their formats fills. One room each: [`inform`]
//!   (Yaskawa), [`rapid`] (ABB), [`krl`] (KUKA), [`fanuc`], [`urscript`] (Universal Robots), [`trajectory`] (ROS), [`gcode`].
//! - [`formats`]: the list of formats, and which one a program is written in; [`files`]: what lies beside it.
//! - [`played`]: a vendor program as a list of joint targets.

pub mod csv;
pub mod fanuc;
pub mod files;
pub mod formats;
pub mod gcode;
pub mod inform;
pub mod krl;
pub mod lines;
pub mod played;
pub mod rapid;
pub mod script;
pub mod trajectory;
pub mod urscript;

use crate::error::{Place, Result};
use crate::io::input::{self, Input};
use crate::robot::Robot;
use files::Files;
use formats::Recognised;
use lines::Lines;
use std::io::Cursor;
use std::path::Path;

/// What a number of a row means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// Target of an axis.
    Axis(usize),
    /// `t_s`.
    Time,
}

/// Where a number stands in its block and how it is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Token {
    /// First byte of the number in [`Block::text`], sign included.
    pub start: u32,
    pub len: u16,
    /// Digits behind the point; of a number with an exponent those of its last digit's weight.
    pub decimals: u8,
    /// `-123.4567`, and nothing unusual about it.
    pub plain: bool,
}

/// Bytes of a row in its block, line ending included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowSpan {
    pub start: u32,
    pub end: u32,
}

/// Whole rows of a program. What stands between rows (comments, blank lines, the header) belongs to no row.
#[derive(Debug, Clone, Default)]
pub struct Block {
    pub text: Vec<u8>,
    pub rows: Vec<RowSpan>,
    /// `tokens[row * slots + slot]`, slots in the order in which they stand in a row.
    pub tokens: Vec<Token>,
    /// `q[row * axes + axis]`, rad or m.
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
    /// Most decimals of each slot in this block.
    pub decimals: Vec<u8>,
    /// So many of the first rows hold nothing but plain numbers with one byte between them.
    pub pure: usize,
    /// Number of the first row's point, counted from 0 over the program.
    pub first_point: u64,
}

impl Block {
    /// Empties the block and keeps its memory.
    pub fn clear(&mut self) {
        self.text.clear();
        self.rows.clear();
        self.tokens.clear();
        self.q.clear();
        self.t_s.clear();
        self.decimals.clear();
        self.pure = 0;
    }

    /// Appends rows of the same text; what they say of [`Block::pure`] is left out.
    fn append(&mut self, rows: &Block) {
        self.rows.extend_from_slice(&rows.rows);
        self.tokens.extend_from_slice(&rows.tokens);
        self.q.extend_from_slice(&rows.q);
        self.t_s.extend_from_slice(&rows.t_s);
        for (most, d) in self.decimals.iter_mut().zip(&rows.decimals) {
            *most = (*most).max(*d);
        }
    }

    /// Bytes of a span.
    pub fn bytes(&self, start: usize, end: usize) -> &[u8] {
        self.text.get(start..end).unwrap_or_default()
    }
}

/// A program that is wholly in memory, for jobs that need no text.
#[derive(Debug, Clone)]
pub struct Program {
    /// As messages show it, and SHA-256 of the stored bytes.
    pub name: String,
    pub sha256: String,
    /// `q[axis][point]`, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Times in s where the program has them.
    pub t_s: Option<Vec<f64>>,
    pub lines: Lines,
}

impl Program {
    /// Reads a program (`-`: standard input), packed or not.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        Self::parse(input::read(path)?, robot)
    }

    /// Parses the bytes of a program: joint-space CSV, or a vendor's whose moves all have joint targets.
    pub fn parse(input: Input, robot: &Robot) -> Result<Self> {
        match formats::recognise(Path::new(&input.name), &input.bytes) {
            Recognised::Csv => Self::of_rows(input, robot),
            Recognised::Script(format) => {
                let sha256 = input.sha256;
                let mut texts = vec![script::Text::new(&input.name, input.bytes)];
                for path in format.companions(Path::new(&input.name), &Files::Disk) {
                    let more = input::read(&path)?;
                    texts.push(script::Text::new(more.name, more.bytes));
                }
                let document = format.parse(texts, robot)?;
                Ok(Self { sha256, ..played::joints(document.script(), robot)?.into_program() })
            }
        }
    }

    fn of_rows(input: Input, robot: &Robot) -> Result<Self> {
        let mut reader = csv::Reader::new(Box::new(Cursor::new(input.bytes)), &input.name, robot)?;
        let mut q = vec![Vec::new(); robot.dof()];
        let mut t_s = reader.has_times().then(Vec::new);
        let mut block = Block::default();
        while reader.next(&mut block)? {
            for row in block.q.chunks_exact(robot.dof()) {
                for (axis, &v) in q.iter_mut().zip(row) {
                    axis.push(v);
                }
            }
            if let Some(times) = &mut t_s {
                times.extend_from_slice(&block.t_s);
            }
        }
        Ok(Self { name: input.name, sha256: input.sha256, q, t_s, lines: reader.into_lines() })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Joint vector of a point into `q`.
    pub fn point_into(&self, i: usize, q: &mut [f64]) {
        for (v, column) in q.iter_mut().zip(&self.q) {
            *v = column[i];
        }
    }

    /// Line of the file on which a point stands.
    pub fn line(&self, point: usize) -> Option<u64> {
        self.lines.line(point as u64)
    }

    /// Place of a point, for messages.
    pub fn place(&self, point: usize) -> Place {
        Place { file: self.name.clone(), line: self.line(point), column: None }
    }
}
