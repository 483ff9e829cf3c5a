//! Integration tests: one binary, one module per room.

mod assess_circle;
mod assess_impact;
mod simulate;
