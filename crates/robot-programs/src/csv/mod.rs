//! Joint-space CSV: `a1_deg,a2_deg,...` and optionally `t_s`; other columns pass through.
//!
//! Modules:
//! - [`header`]: which column is what; the dialects that are refused.
//! - [`number`]: bytes to a number and its style.
//! - [`record`]: a row that is not plain: quotes, spaces, exponents.
//! - [`reader`]: the file in pieces of whole rows; [`parser`]: their numbers; [`fast`]: rows of plain numbers; [`piece`]: pieces
//!   that are parsed side by side and put in their places.
//! - [`mod@print`]: a number in the style of the one it replaces.
//! - [`edit`]: new values in, rows out; [`slot`]: one changed number; [`plain`]: rows of plain numbers alone, which nearly all are.
//!
//! Reference: Y. Shafranovich, RFC 4180 (2005), with blanks around cells and lines of `#` comments.
//!
//! `docs/program-csv.md` has what is kept and what may change.

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
mod slot;

pub use edit::{Edits, Style};
pub use parser::Parser;
pub use piece::{Piece, Placing};
pub use reader::{Reader, Source};
