//! Joint-space CSV: `a1_deg,a2_deg,...` and optionally `t_s` or `dt_s`; other columns pass through.
//!
//! Modules:
//! - [`header`]: which column is what; the dialects that are refused. [`clock`]: columns of times and durations.
//! - [`number`]: bytes to a number and its style.
//! - [`record`]: a row that is not plain: quotes, spaces, exponents.
//! - [`reader`]: the file in pieces of whole rows; [`parser`]: their numbers; [`fast`]: rows of plain numbers; [`shape`]: rows like the one
//!   before; [`piece`]: pieces that are parsed side by side and put in their places.
//! - [`mod@print`]: a number in the style of the one it replaces.
//! - [`again`]: printed rows, read again; [`same`]: rows of short numbers alone among them.
//! - [`edit`]: new values in, rows out; [`slot`]: one changed number; [`plain`]: rows of plain numbers alone, which nearly all are.
//!
//! Reference: Y. Shafranovich, RFC 4180 (2005), with blanks around cells and lines of `#` comments.
//!
//! `docs/program-csv.md` has what is kept and what may change.
//!
//! # Example
//!
//! A program of two axes, of which one is given in mm and one in degrees.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::{Block, csv::Reader};
//!
//! let axes = Axes::new("arm", vec![Axis::new("A1", JointKind::Revolute), Axis::new("X", JointKind::Prismatic)]);
//! let rows = b"A1_deg,X_mm,t_s\n0,100,0\n90,250.5,1.5\n";
//! let mut reader = Reader::new(Box::new(&rows[..]), "program.csv", &axes)?;
//! let mut block = Block::default();
//! assert!(reader.next(&mut block)?);
//! // row after row, in rad and m
//! assert_eq!(block.q, [0.0, 0.1, 90f64.to_radians(), 0.2505]);
//! assert_eq!(block.t_s, [0.0, 1.5]);
//! # Ok::<(), robot_programs::Error>(())
//! ```

pub mod again;
pub mod clock;
pub mod edit;
mod fast;
pub mod header;
pub mod number;
pub mod parser;
pub mod piece;
mod plain;
pub mod print;
pub mod reader;
pub mod record;
mod same;
mod shape;
mod slot;

pub use again::{Again, Meant};
pub use edit::{Clock, Edits, Style};
pub use parser::Parser;
pub use piece::{Piece, Placing};
pub use reader::{Reader, Source};
pub use slot::TIME_LEAST;
