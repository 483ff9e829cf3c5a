//! Integration tests: one binary, a module per room.

mod assess_circle;
mod assess_impact;
mod bad_input;
mod bench;
mod catalogue;
mod fit;
mod gaps_file;
mod identify_path;
mod identify_static;
mod identify_static_bench;
mod job;
mod log;
mod path_bench;
mod plan_experiment;
mod program;
mod registration;
mod report;
mod rewrite_engine;
mod rewrite_printed;
mod rewrite_stream;
mod robot;
mod simulate;
mod stats;
mod val_job;
