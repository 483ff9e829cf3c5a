//! Integration tests: one binary, a module per room.

mod assess_circle;
mod assess_impact;
mod report;
mod rewrite_engine;
mod simulate;
mod val_job;
