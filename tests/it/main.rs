//! Integration tests, one module a room. Names that begin with `val_` compare with truth from outside the crate.

mod bench;
mod gaps_file;
mod identify_static;
mod identify_static_bench;
mod registration;
mod stats;
