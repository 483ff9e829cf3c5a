//! Robot programs: the crate `robot-programs`, whose readers and writers know bytes and axes alone, on top of this crate's files.
//!
//! [`Program`] is a program wholly in memory, for jobs that need no text; [`open_rows`] a CSV program that is read in blocks.

#![warn(missing_docs)]

pub use robot_programs::{
    Block, RowSpan, Slot, Token, csv, fanuc, files, formats, gcode, inform, joint_path, krl, lines, rapid, script,
    trajectory, urscript,
};

use crate::error::{Error, Place, Result, shown};
use crate::io::input::{self, Input};
use crate::robot::Robot;
use files::Files;
use formats::Recognised;
use lines::Lines;
use std::io::Cursor;
use std::path::Path;

/// The format that a user names with `--format`.
pub fn format_named(name: &str) -> Result<Recognised> {
    formats::named(name).ok_or_else(|| {
        let expected = format!("one of {}", formats::names().join(", "));
        Error::setting("format", format!("`{name}`"), expected)
    })
}

/// Opens a CSV program (`-`: standard input) and reads its header.
pub fn open_rows(path: &Path, robot: &Robot) -> Result<csv::Reader> {
    Ok(csv::Reader::new(input::open(path)?, &shown(path), robot.axes())?)
}

/// A program that is wholly in memory, for jobs that need no text.
#[derive(Debug, Clone)]
pub struct Program {
    /// As messages show it, and SHA-256 of the stored bytes.
    pub name: String,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
    /// `q[axis][point]`, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Times in s where the program has them.
    pub t_s: Option<Vec<f64>>,
    /// Line of each point.
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
                Self::of_script(format, texts, sha256, robot)
            }
        }
    }

    /// Parses a program that is in memory with the files that belong to it: name and bytes of each, its own first.
    pub fn of_texts(texts: Vec<(String, Vec<u8>)>, robot: &Robot) -> Result<Self> {
        let mut texts = texts.into_iter();
        let Some((name, bytes)) = texts.next() else {
            return Err(Error::bad(Place::file("program"), "no text", "a program"));
        };
        let input = input::from_bytes(name, bytes)?;
        match formats::recognise(Path::new(&input.name), &input.bytes) {
            Recognised::Csv => Self::of_rows(input, robot),
            Recognised::Script(format) => {
                let own = script::Text::new(&input.name, input.bytes);
                let all = std::iter::once(own).chain(texts.map(|(name, bytes)| script::Text::new(name, bytes)));
                Self::of_script(format, all.collect(), input.sha256, robot)
            }
        }
    }

    fn of_script(format: &dyn script::Format, texts: Vec<script::Text>, sha256: String, robot: &Robot) -> Result<Self> {
        let document = format.parse(texts, robot.axes())?;
        // several points may stand on one line: the lines of a script are those of its steps
        let path = joint_path::joints(document.script(), robot.axes())?;
        Ok(Self { name: path.name, sha256, q: path.q, t_s: path.t_s, lines: Lines::default() })
    }

    fn of_rows(input: Input, robot: &Robot) -> Result<Self> {
        let mut reader = csv::Reader::new(Box::new(Cursor::new(input.bytes)), &input.name, robot.axes())?;
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

    /// Whether the program has no points.
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
