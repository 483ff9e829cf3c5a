//! Files at the edges: whole or not at all, `-` for standard streams, `.gz` read as it is.
//!
//! Rooms:
//! - [`input`]: bytes of a path, of standard input, of a gzip file; their SHA-256.
//! - [`output`]: temporary file, then rename; standard output only once everything is right.
//! - [`yaml`]: YAML documents with the line of every refusal.

pub mod input;
pub mod output;
pub mod yaml;
