//! Integration tests, one module a room. Names that begin with `val_` compare with truth from outside the crate.

mod bench;
mod fit;
mod gaps_file;
mod identify_path;
mod identify_static;
mod identify_static_bench;
mod path_bench;
mod registration;
mod stats;
