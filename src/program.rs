//! Robot programs: the crate `robot-programs`, whose readers and writers know bytes and axes alone, on top of this crate's files.
//!
//! [`Program`] is a program wholly in memory, for jobs that need no text; [`open_rows`] a CSV program that is read in blocks.

#![warn(missing_docs)]

pub mod note;

pub use robot_programs::{
    Block, RowSpan, Slot, Token, csv, fanuc, files, formats, gcode, inform, joint_path, krl, lines, no_motion, rapid,
    script, trajectory, urscript,
};

use crate::error::{Error, Place, Result, shown};
use crate::io::input::{self, Input};
use crate::robot::Robot;
use files::Files;
use formats::Recognised;
use lines::Lines;
use note::{Note, Waiting};
use serde::Serialize;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

/// Goals of a vendor program at which the robot stops, by the rules of its language: no `C_PTP` or `C_DIS`, `fine`, `FINE`, `PL=0`, no
/// blend.
pub fn exact_stops(document: &dyn script::Document) -> usize {
    if document.passes_points() {
        return 0;
    }
    document.script().moves().filter(|(_, m)| m.blend_m == Some(0.0)).count()
}

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
    /// Points that are goals of a vendor program's moves, increasing; none of rows of joints.
    pub goals: Vec<usize>,
    /// What a vendor program tells besides; `None` of rows of joints.
    pub script: Option<ScriptPath>,
}

/// What a vendor program tells of its path besides the points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScriptPath {
    /// Points at which the path starts anew, as the way to them from the point before is not known; increasing, without 0.
    pub starts: Vec<usize>,
    /// How many of its moves are in the path.
    pub moves: Moves,
    /// Goals at which the robot stops, by the rules of the language.
    pub exact_stops: usize,
    /// Frames and tools that moves wait for, in words: "tool `tGun` (3 moves)".
    pub waits_for: Vec<String>,
    /// At which speed moves of unknown speed run.
    pub assumed: Assumed,
}

/// The TCP speed of moves whose speed the text does not tell, m/s.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Assumed {
    /// The speed that was asked for.
    Requested(f64),
    /// The middle one of the speeds that the program states.
    OfProgram(f64),
    /// No speed is known: the fastest that a robot may move in manual mode ([`MANUAL_M_S`]).
    #[default]
    Manual,
}

/// The fastest TCP speed of a robot in manual mode, m/s (ISO 10218-1:2011, 5.6.2).
pub const MANUAL_M_S: f64 = 0.25;

impl Assumed {
    /// The speed, m/s.
    pub fn m_s(self) -> f64 {
        match self {
            Self::Requested(v) | Self::OfProgram(v) => v,
            Self::Manual => MANUAL_M_S,
        }
    }
}

impl std::fmt::Display for Assumed {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let why = match self {
            Self::Requested(_) => "as asked",
            Self::OfProgram(_) => "the middle one of the speeds that the program states",
            Self::Manual => "no other speed is given",
        };
        write!(f, "{} mm/s ({why})", self.m_s() * 1e3)
    }
}

impl ScriptPath {
    /// What has to be given for the moves that are not in the path; `None`: nothing that a name stands for.
    pub fn waiting(&self) -> Option<Waiting> {
        (!self.waits_for.is_empty()).then(|| Waiting(self.waits_for.clone()))
    }

    /// What is not in the path, and what was assumed: for those who draw or run it.
    pub fn left(&self) -> Vec<Note> {
        let Moves { all, known, unknown_start, unknown_speed } = self.moves;
        let mut notes = Vec::new();
        if all > known + unknown_start {
            notes.push(Note::LeftOut { left: all - known - unknown_start, all });
            notes.extend(self.waiting().map(Note::Waiting));
        }
        if !self.starts.is_empty() {
            notes.push(Note::UnknownStart { ways: self.starts.len() });
        }
        if unknown_speed > 0 && !matches!(self.assumed, Assumed::Requested(_)) {
            notes.push(Note::UnknownSpeed { moves: unknown_speed, assumed: self.assumed });
        }
        notes
    }
}

/// How many moves of a program are in its path.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Moves {
    /// Moves of the text.
    pub all: usize,
    /// Those whose start, way and goal are known.
    pub known: usize,
    /// Those whose goal is known, but not the place from which they start or the way that they take.
    pub unknown_start: usize,
    /// Of the known ones those whose speed the text does not tell, in a path that has times.
    pub unknown_speed: usize,
}

impl Program {
    /// Reads a program (`-`: standard input), packed or not.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        Self::parse(input::read(path)?, robot)
    }

    /// The same program as what the gears of `robot` turn by ([`crate::robot::gap_of`]).
    pub fn by_gears(&self, robot: &Robot) -> Self {
        let mut program = self.clone();
        let mut q = vec![0.0; robot.dof()];
        for point in 0..program.len() {
            program.point_into(point, &mut q);
            robot.to_gears(&mut q);
            for (column, v) in program.q.iter_mut().zip(&q) {
                column[point] = *v;
            }
        }
        program
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
        Self::of_document(format.parse(texts, robot.axes())?.as_ref(), sha256, robot)
    }

    /// The joint targets of a vendor program that has been read.
    pub fn of_document(document: &dyn script::Document, sha256: String, robot: &Robot) -> Result<Self> {
        let path = joint_path::of_document(document, robot.axes(), None)?;
        Ok(Self::of_joint_path(document, sha256, path))
    }

    /// The joint targets of a vendor program, at the times that `duration` gives its moves.
    pub fn of_document_timed(
        document: &dyn script::Document,
        sha256: String,
        robot: &Robot,
        duration: joint_path::Duration,
    ) -> Result<Self> {
        let path = joint_path::of_document(document, robot.axes(), Some(duration))?;
        Ok(Self::of_joint_path(document, sha256, path))
    }

    fn of_joint_path(document: &dyn script::Document, sha256: String, path: joint_path::JointPath) -> Self {
        // several points may stand on one line: the lines of a script are those of its steps
        let all = document.script().moves().count();
        // it is not known from where the robot comes to the first one
        let moves = Moves { all, known: all.saturating_sub(1), unknown_start: all.min(1), unknown_speed: 0 };
        let told = ScriptPath { moves, exact_stops: exact_stops(document), ..ScriptPath::default() };
        Self { goals: path.goals, ..Self::of_path(path.name, sha256, path.q, path.t_s, told) }
    }

    /// A path of a vendor program: `q[axis][point]`, rad or m.
    pub fn of_path(name: String, sha256: String, q: Vec<Vec<f64>>, t_s: Option<Vec<f64>>, told: ScriptPath) -> Self {
        Self { name, sha256, q, t_s, lines: Lines::default(), goals: Vec::new(), script: Some(told) }
    }

    /// Points of each stretch whose ways are known: one of rows of joints.
    pub fn stretches(&self) -> Vec<Range<usize>> {
        let starts = self.script.as_ref().map_or(&[][..], |s| s.starts.as_slice());
        let from = std::iter::once(0).chain(starts.iter().copied());
        from.zip(starts.iter().copied().chain([self.len()])).map(|(from, to)| from..to).collect()
    }

    /// One stretch as a separate program.
    pub fn stretch(&self, points: Range<usize>) -> Self {
        Self {
            name: self.name.clone(),
            sha256: self.sha256.clone(),
            q: self.q.iter().map(|c| c[points.clone()].to_vec()).collect(),
            t_s: self.t_s.as_ref().map(|t| t[points.clone()].to_vec()),
            lines: Lines::default(),
            goals: self.goals.iter().filter(|g| points.contains(g)).map(|g| g - points.start).collect(),
            script: None,
        }
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
        let (name, sha256) = (input.name, input.sha256);
        Ok(Self { name, sha256, q, t_s, lines: reader.into_lines(), goals: Vec::new(), script: None })
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
