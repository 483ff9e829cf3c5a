//! `lostmotion status`: how far a job with a manifest has come.

use crate::cli::exit::{bad, no};
use crate::error::{Place, counted};
use crate::io::address;
use crate::io::output;
use crate::rewrite::manifest::{Merged, load};
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Count the programs of a job that are done, refused, failed and left.
///
/// A shard writes its summary when it ends. Give --output-dir to count also the results of shards that are still running.
///
/// Example:
///   lostmotion status --manifest manifest.jsonl part-*.jsonl --output-dir done/
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Summaries written so far by `rewrite --manifest`
    #[arg(value_name = "SUMMARY")]
    pub summaries: Vec<PathBuf>,

    /// Manifest of the job
    #[arg(long, value_name = "FILE.jsonl")]
    pub manifest: PathBuf,

    /// Folder with the rewritten programs
    #[arg(long, value_name = "FOLDER")]
    pub output_dir: Option<PathBuf>,

    /// Print the counts as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    address::refuse("--output-dir", args.output_dir.as_deref())?;
    let entries = load(&args.manifest, &|_| true)?;
    let merged = Merged::read(&entries, &args.summaries)?;
    let counts = merged.counts(&entries, args.output_dir.as_deref());
    let text = if args.json {
        serde_json::to_string_pretty(&counts).map_err(|e| bad(Place::default(), e.to_string(), "counts"))?
    } else {
        format!(
            "{}: {} done, {} refused, {} failed, {} left",
            counted(counts.programs, "program"),
            counts.done,
            counts.refused,
            counts.failed,
            counts.left
        )
    };
    output::write_whole(Path::new("-"), (text + "\n").as_bytes())?;
    merged.require_one_job(&entries, args.output_dir.as_deref()).map_err(|e| no(e.to_string()))
}
