//! Integration tests: one binary, a module per room.

mod assess_circle;
mod assess_impact;
mod bad_input;
mod log;
mod report;
mod rewrite_engine;
mod robot;
mod simulate;
mod val_job;
