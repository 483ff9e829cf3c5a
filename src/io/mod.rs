//! Files at the edges: whole or not at all, `-` for standard streams, `.gz` read as it is.
//!
//! Modules, in reading order:
//! - [`mod@name`]: file names as text and back; [`notice`]: what the library reports besides its results.
//! - [`input`]: bytes of a path, of standard input, of a gzip file; their SHA-256; [`memory`]: what fits into memory.
//! - [`bag`]: a topic of a ROS 2 recording (MCAP) as CSV.
//! - [`workbook`]: the first sheet of a workbook (`.xlsx`, `.ods`, `.xls`) as CSV.
//! - [`address`]: what names an object store; `store` reads and writes it (feature `cloud`).
//! - [`temporary`]: files that are not in place yet, and those that a killed run left.
//! - [`folder`]: what lies in a folder.
//! - [`output`]: one output, in a temporary file until it is committed; [`ahead`]: a long one goes to disk while it is written.
//! - [`kind`]: an output replaces a file of its own kind only.
//! - [`links`]: where a name leads; [`regular`]: names that anybody may have made are opened as regular files alone.
//! - [`remains`]: what a loss of power leaves of a file.
//! - [`lock`]: one run at a time writes into a folder.
//! - [`transaction`]: outputs that belong together come into place together; [`journal`] finishes what was interrupted.
//! - `streams`: what was held back for standard output, FIFOs and devices.
//! - [`interrupt`]: whoever ends the process on a signal waits until no output is partly in place.
//! - [`threads`]: as many as there are.
//! - [`keyed`]: an entry of a document whose key carries a unit.
//! - [`rounded`]: numbers of documents.
//! - `words`: values that documents hold in words.
//! - [`yaml`]: YAML documents with the line of every refusal.
//!
//! # Example
//!
//! A file is known by its SHA-256 (that of `abc` is an example of FIPS 180-4), and comes into place whole.
//!
//! ```
//! use lostmotion::io::{input, output};
//!
//! let folder = tempfile::tempdir().expect("a folder to work in");
//! let path = folder.path().join("abc.txt");
//! output::write_whole(&path, b"abc")?;
//! let read = input::read(&path)?;
//! assert_eq!(read.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod address;
mod ahead;
pub mod bag;
pub mod folder;
pub mod input;
pub mod interrupt;
pub mod journal;
pub mod keyed;
pub mod kind;
pub mod links;
pub mod lock;
pub mod memory;
pub mod names;
pub mod notice;
pub mod output;
pub mod regular;
pub mod remains;
pub mod rounded;
#[cfg(feature = "cloud")]
pub mod store;
mod streams;
pub mod temporary;
pub mod threads;
pub mod transaction;
mod words;
pub mod workbook;
pub mod yaml;

pub use crate::name;
pub(crate) use words::in_words;
