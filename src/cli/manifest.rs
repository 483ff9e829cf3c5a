//! `lostmotion manifest`: the programs of a job that many machines share.

use crate::cli::exit::bad;
use crate::cli::paths;
use crate::error::{Place, counted, shown};
use crate::io::{address, input, output};
use crate::program::format_named;
use crate::program::formats::Recognised;
use crate::rewrite::manifest::{Entry, State, of_folder, of_list, text};
use anyhow::Result;
use std::path::{Path, PathBuf};

/// List the programs of a folder with their size, SHA-256 and format.
///
/// `rewrite --manifest` reads the list, or a shard of it, and rewrites only programs that still have the listed size and
/// SHA-256. The list is sorted by path, so the same folder always gives the same bytes.
///
/// Examples:
///   lostmotion manifest cell/ --output manifest.jsonl
///   lostmotion manifest changed.txt --root cell/ --output manifest.jsonl
///   lostmotion manifest s3://cells/line-4 --output manifest.jsonl
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Folder of programs, a text file with one path on each line, or s3://BUCKET/PREFIX (in builds with the feature `cloud`)
    #[arg(value_name = "FOLDER|LIST|ADDRESS")]
    pub input: PathBuf,

    /// Folder to which the paths of a list are relative
    #[arg(long, value_name = "FOLDER")]
    pub root: Option<PathBuf>,

    /// Write the manifest to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE.jsonl")]
    pub output: PathBuf,

    /// Format of all programs [default: recognised from each file's extension and content]
    #[arg(long, value_name = "NAME")]
    pub format: Option<String>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let format = args.format.as_deref().map(format_named).transpose()?;
    let usage = |found: &str, expected: &str| Err(bad(Place::file("manifest"), found, expected));
    address::refuse("--root", args.root.as_deref())?;
    address::refuse("--output", Some(&args.output))?;
    paths::refuse_shared(&[("LIST", Some(&args.input))], &[("--output", Some(&args.output))])?;
    if address::is_address(&args.input) {
        if args.root.is_some() {
            return usage("--root with an address of an object store", "--root with a list of paths");
        }
        return write(&args, &of_store(&args.input, format)?);
    }
    let entries: Vec<Entry> = match (args.input.is_dir(), &args.root) {
        (true, None) => of_folder(&args.input, format)?,
        (true, Some(_)) => return usage("--root with a folder", "--root with a list of paths"),
        (false, None) => return usage("a list without --root", "--root FOLDER, below which its paths stand"),
        (false, Some(root)) => {
            let list = input::read(&args.input)?.bytes;
            input::refuse_utf16(&shown(&args.input), &list)?;
            of_list(&shown(&args.input), list.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&list), root, format)?
        }
    };
    write(&args, &entries)
}

/// The programs of an object store.
#[cfg(feature = "cloud")]
fn of_store(address: &Path, format: Option<Recognised>) -> Result<Vec<Entry>> {
    Ok(crate::rewrite::remote::entries(&crate::io::store::Store::open(address)?, format)?)
}

#[cfg(not(feature = "cloud"))]
fn of_store(address: &Path, _format: Option<Recognised>) -> Result<Vec<Entry>> {
    address::refuse_all(address)?;
    Ok(Vec::new())
}

fn write(args: &Args, entries: &[Entry]) -> Result<()> {
    output::write_whole(&args.output, text(entries).as_bytes())?;
    let unreadable = entries.iter().filter(|e| e.state == State::Unreadable).count();
    let programs = counted(entries.len(), "program");
    match unreadable {
        0 => eprintln!("{programs}"),
        k if k == entries.len() => eprintln!("{programs}; none can be read"),
        k => eprintln!("{programs}; {k} of them cannot be read"),
    }
    Ok(())
}
