//! Robot programs as text with places: every motion target keeps the bytes it was written with, so that an edit touches its
//! digits and nothing else. Eight languages: joint-space CSV, Yaskawa INFORM, ABB RAPID, KUKA KRL, FANUC TP, URScript, ROS
//! trajectories and G-code. The crate knows [`axes`], units and limits; it computes no motion and no compensation.
//!
//! A vendor program is read whole: a [`script::Format`] turns texts into a [`script::Document`], which shows what moves
//! ([`script::Script`]) and turns [`script::Edits`] into patches of bytes. Joint-space CSV is read in [`Block`]s of whole rows,
//! so that a program of any length passes in constant memory.
//!
//! # Example
//!
//! Move the third joint of a KUKA program's goal by a hundredth of a degree; no other byte changes.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Edit, Edits, Format, Goal, Text, text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("A{i}"), JointKind::Revolute)).collect());
//! let source = b"DEF demo()\n  PTP {A1 10, A2 -90.0, A3 90.000, A4 0, A5 0, A6 0} ; home\nEND\n".to_vec();
//! let document = robot_programs::krl::Krl.parse(vec![Text::new("demo.src", source)], &axes)?;
//!
//! let script = document.script();
//! let (step, goal) = script.moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let there = script.targets.get(target).expect("the target of a move");
//! let mut q: Vec<f64> = there.values.iter().map(|v| v.map_or(0.0, |v| v.si)).collect();
//! q[2] += 0.01_f64.to_radians();
//!
//! // the last digit of a changed number may weigh 0.001 deg
//! let digit = vec![0.001_f64.to_radians(); 6];
//! let mut edits = Edits { digit, ..Edits::default() };
//! edits.steps.insert(step, Edit { goal: Some(q), ..Edit::default() });
//! let out = text::apply(&script.texts, &document.patches(&edits)?)?;
//! assert_eq!(
//!     String::from_utf8_lossy(&out[0]),
//!     "DEF demo()\n  PTP {A1 10, A2 -90.0, A3 90.010, A4 0, A5 0, A6 0} ; home\nEND\n"
//! );
//! # Ok::<(), robot_programs::Error>(())
//! ```
//!
//! # Modules, in the order in which to read them
//! - [`axes`]: what is known of the robot; [`no_motion`]: routines that move nothing, as the user says; [`registers`], [`bases`]: what the
//!   controller holds; [`control`]: what it takes for granted; [`error`]: what reading and editing can fail with.
//! - [`script`]: vendor programs: the interface that each of their formats fills. One module each: [`inform`] (Yaskawa),
//!   [`rapid`] (ABB), [`krl`] (KUKA), [`fanuc`], [`urscript`] (Universal Robots), [`trajectory`] (ROS), [`gcode`].
//! - [`decimal`]: a number in decimal notation, exactly: read, compared, offset and printed in integers.
//! - [`csv`]: joint-space CSV: header, cells, rows in; numbers and rows out; [`lines`]: point -> line of the file.
//! - [`formats`]: the list of formats, and which one a program is written in; [`files`]: what lies beside it.
//! - [`joint_path`]: a vendor program as a list of joint targets.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod axes;
pub mod bases;
pub mod control;
pub mod csv;
pub mod decimal;
pub mod error;
pub mod fanuc;
pub mod files;
#[cfg(test)]
mod fixtures;
pub mod formats;
pub mod gcode;
pub mod inform;
pub mod joint_path;
pub mod krl;
pub mod lines;
pub mod no_motion;
pub mod rapid;
pub mod registers;
pub mod script;
pub mod trajectory;
pub mod urscript;

pub use error::{Error, Result};

/// What a number of a row means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// Target of an axis.
    Axis(usize),
    /// Time of a row, `t_s`, or in another unit: so many of it are one second.
    Time(u32),
    /// Time from the row before to this one, such as `dt_s`, whatever its unit.
    Duration,
}

/// Where a number stands in its block and how it is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Token {
    /// First byte of the number in [`Block::text`], sign included.
    pub start: u32,
    /// Bytes of the number.
    pub len: u16,
    /// Digits after the point; of a number with an exponent those of its last digit's weight.
    pub decimals: u8,
    /// `-123.4567`, and nothing unusual about it.
    pub plain: bool,
}

/// Bytes of a row in its block, line ending included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowSpan {
    /// First byte of the row.
    pub start: u32,
    /// Byte after the row, its line ending included.
    pub end: u32,
}

/// Whole rows of a program. What stands between rows (comments, blank lines, the header) belongs to no row.
#[derive(Debug, Clone, Default)]
pub struct Block {
    /// Bytes of whole rows.
    pub text: Vec<u8>,
    /// Where each row stands in `text`.
    pub rows: Vec<RowSpan>,
    /// `tokens[row * slots + slot]`, slots in the order in which they stand in a row.
    pub tokens: Vec<Token>,
    /// Digits of each token, where they are few.
    pub mantissas: Vec<decimal::read::Packed>,
    /// `q[row * axes + axis]`, rad or m.
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
    /// Empty, or one per row: [`Slot::Duration`], in the unit of its column.
    pub durations: Vec<f64>,
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
        self.mantissas.clear();
        self.q.clear();
        self.t_s.clear();
        self.durations.clear();
        self.decimals.clear();
        self.pure = 0;
    }

    /// Bytes of a span.
    pub fn bytes(&self, start: usize, end: usize) -> &[u8] {
        self.text.get(start..end).unwrap_or_default()
    }
}
