//! `lostmotion schema`: JSON Schemas of the documents, for editors and checks.

use crate::cli::exit::bad;
use crate::error::{Error, Place};
use crate::io::output::Output;
use crate::io::transaction::Transaction;
use crate::schemas;
use anyhow::Result;
use std::path::PathBuf;

/// Print the JSON Schema of a document.
///
/// An editor can complete and check a YAML file if its first line names the schema:
///   # yaml-language-server: $schema=robot.schema.json
/// Commands that write such a file put this line there if its schema stands in the same folder.
/// Without a document name, the command lists the documents that have a schema.
///
/// Examples:
///   lostmotion schema
///   lostmotion schema robot --output robot.schema.json
///   lostmotion schema --output-dir .
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Name of the document
    #[arg(value_name = "DOCUMENT", help = document_help())]
    pub document: Option<String>,
    /// Write the schema to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE.json", default_value = "-")]
    pub output: PathBuf,
    /// Write every schema to this folder, as DOCUMENT.schema.json. The folder is made if it does not exist
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["document", "output"])]
    pub output_dir: Option<PathBuf>,
}

/// The help of the argument, with every name.
fn document_help() -> String {
    let names: Vec<&str> = schemas::NAMES.iter().map(|n| n.0).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    format!("Name of the document: {} or {last}", others.join(", "))
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    if let Some(folder) = &args.output_dir {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "make", e))?;
        let mut all = Transaction::default();
        for (name, _) in schemas::NAMES {
            let mut out = Output::create(&folder.join(format!("{name}.schema.json")))?;
            out.put(format!("{:#}\n", schemas::of(name).unwrap_or_default()).as_bytes())?;
            all.put(out);
        }
        return all.commit().map_err(Into::into);
    }
    let text = match &args.document {
        None => schemas::NAMES.iter().map(|(name, what)| format!("{name:12} {what}\n")).collect(),
        Some(name) => {
            let found = schemas::of(name).ok_or_else(|| {
                let names: Vec<&str> = schemas::NAMES.iter().map(|n| n.0).collect();
                bad(Place::file("schema"), format!("document `{name}`"), format!("one of {}", names.join(", ")))
            })?;
            format!("{found:#}\n")
        }
    };
    let mut out = Output::create(&args.output)?;
    out.put(text.as_bytes())?;
    out.commit().map_err(Into::into)
}
