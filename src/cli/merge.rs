//! `lostmotion merge`: one summary of the summaries of all shards.

use crate::cli::paths::{Named, refuse_shared};
use crate::error::counted;
use crate::io::output::Output;
use crate::rewrite::manifest::{Merged, load};
use anyhow::Result;
use std::path::PathBuf;

/// Merge the summaries of the shards of a job.
///
/// Every program of the manifest must appear in exactly one summary; missing and repeated programs are refused. The lines
/// are in the order of the manifest, whatever the number of shards.
///
/// Example:
///   lostmotion merge --manifest manifest.jsonl part-*.jsonl --output summary.jsonl
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Summaries written by `rewrite --manifest`
    #[arg(value_name = "SUMMARY", required = true)]
    pub summaries: Vec<PathBuf>,

    /// Manifest of the job
    #[arg(long, value_name = "FILE.jsonl")]
    pub manifest: PathBuf,

    /// Write the merged summary to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE.jsonl")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let summaries = args.summaries.iter().map(|s| ("SUMMARY", Some(s.as_path())));
    let inputs: Vec<Named> = summaries.chain([("--manifest", Some(args.manifest.as_path()))]).collect();
    refuse_shared(&inputs, &[("--output", Some(&args.output))])?;
    let entries = load(&args.manifest, &|_| true)?;
    let merged = Merged::read(&entries, &args.summaries)?;
    merged.require_all(&entries)?;
    merged.require_one_job(&entries, None)?;
    let mut output = Output::create(&args.output)?;
    let text: String = merged.lines.iter().flatten().flat_map(|told| [told.text.as_str(), "\n"]).collect();
    output.put(text.as_bytes())?;
    output.commit()?;
    let counts = merged.counts(&entries, None);
    eprintln!(
        "{}: {} done, {} refused, {} failed",
        counted(counts.programs, "program"),
        counts.done,
        counts.refused,
        counts.failed
    );
    Ok(())
}
