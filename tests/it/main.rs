//! Integration tests, one module a room. Names that begin with `val_` compare with truth from outside the crate.

mod identify_static;
mod registration;
mod stats;
