//! `lostmotion undo`: a rewritten program back to what it was, byte for byte.

use crate::cli::exit::{bad, no};
use crate::cli::paths;
use crate::error::{Error, Place, is_stdio, shown};
use crate::io::input;
use crate::io::journal::{self, Towards};
use crate::io::links;
use crate::io::name::path_of;
use crate::io::output::Output;
use crate::io::transaction::Transaction;
use crate::rewrite::guard::{Companion, Note, find_note, read_note};
use crate::rewrite::original::{KEPT_UP_TO, unpack};
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Restore the original of a rewritten program, byte for byte.
///
/// The note FILE.lostmotion.json, which `rewrite` writes next to the program, contains the bytes of the original and their
/// SHA-256. A program that was changed after `rewrite` wrote it is left alone. For a program larger than 4 MB the note
/// contains only the SHA-256; then name the original file with --original, and it is checked.
///
/// Examples:
///   lostmotion undo out.src --output original.src
///   lostmotion undo out.src --in-place
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(override_usage = "lostmotion undo [OPTIONS] <--output <FILE>|--in-place> <FILE>")]
pub struct Args {
    /// Rewritten program, with its note in the same folder
    #[arg(value_name = "FILE")]
    pub input: PathBuf,

    /// Write the original to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE", required_unless_present = "in_place", conflicts_with = "in_place")]
    pub output: Option<PathBuf>,

    /// Replace the rewritten program by the original and delete the note
    #[arg(long)]
    pub in_place: bool,

    /// Original file of a program that is too large for its note
    #[arg(long, value_name = "FILE")]
    pub original: Option<PathBuf>,

    /// Print what was restored as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// A further file of the program as it was, and where it goes.
fn companion(args: &Args, c: &Companion, name: &str, target: &Path) -> Result<(PathBuf, Vec<u8>)> {
    let rewritten = beside(&args.input, &c.output);
    let bytes = match (unchanged(&rewritten, &c.sha256_out, Some(&c.sha256_in))?, &c.original) {
        (Some(bytes), _) => bytes,
        (None, Some(text)) => checked(name, unpack(name, text)?, &c.sha256_in)?,
        (None, None) => return Err(too_large(name, &c.input)),
    };
    if is_stdio(target) {
        return Err(bad(Place::file("--output"), "standard output for several files", "a file"));
    }
    let ending = Path::new(&c.output).extension().unwrap_or_default();
    let to = if args.in_place { rewritten.clone() } else { target.with_extension(ending) };
    if !args.in_place && (paths::same(&to, &rewritten) || paths::same(&to, &args.input) || to == target) {
        let found = format!("a name with which {} would replace {}", c.input, shown(&to));
        return Err(bad(Place::file("--output"), found, "another name or folder (or --in-place)"));
    }
    Ok((to, bytes))
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Undone<'a> {
    schema: &'static str,
    original: &'a str,
    files: Vec<UndoneFile>,
}

/// A file that was written, as it was before the rewriting.
#[derive(serde::Serialize)]
struct UndoneFile {
    output: String,
    bytes: usize,
    sha256: String,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    if !args.input.is_file() {
        return Err(bad(Place::file(shown(&args.input)), "no file", "a program that `rewrite` wrote"));
    }
    journal::finish(&links::home_of(&args.input), Towards::Result)?;
    let note_file = find_note(&args.input);
    let name = shown(&note_file);
    let Some(note) = read_note(&args.input)? else {
        return Err(bad(Place::file(&name), "no note of `rewrite`", "the note next to a rewritten program"));
    };
    let target = args.output.clone().unwrap_or_else(|| args.input.clone());
    paths::refuse_missing_folders(&[("--output", args.output.as_deref())])?;
    if !args.in_place {
        let found = |path: &Path| Err(bad(Place::file("--output"), shown(path), "another file (or --in-place)"));
        for path in [&args.input, &note_file].into_iter().chain(args.original.as_ref()) {
            if !is_stdio(&target) && paths::same(&target, path) {
                return found(path);
            }
        }
    }
    if args.json && is_stdio(&target) {
        let expected = "a file, because standard output contains the document";
        return Err(bad(Place::file("--output"), "standard output with --json", expected));
    }
    let mut files = vec![(target.clone(), original_of(&args, &note, &name)?)];
    for c in &note.companions {
        files.push(companion(&args, c, &name, &target)?);
    }
    let mut all = Transaction::default();
    for (path, bytes) in files.iter().rev() {
        let mut output = Output::create(path)?;
        output.put(bytes)?;
        all.put(output);
    }
    if args.in_place {
        all.remove(note_file);
    }
    if args.json {
        let files = files.iter().map(|(path, bytes)| UndoneFile {
            output: shown(path),
            bytes: bytes.len(),
            sha256: input::sha256(bytes),
        });
        let document = Undone { schema: "lostmotion/undone/1", original: &note.input, files: files.collect() };
        let text = serde_json::to_string_pretty(&document).unwrap_or_default() + "\n";
        let mut document = Output::create(Path::new("-"))?;
        document.put(text.as_bytes())?;
        all.put(document);
        return all.commit().map_err(Into::into);
    }
    all.commit()?;
    let to = if is_stdio(&target) { "standard output".into() } else { shown(&target) };
    eprintln!("{to}: original of {} restored, {} bytes", named(&note.input), files[0].1.len());
    Ok(())
}

/// The original's bytes, checked.
fn original_of(args: &Args, note: &Note, name: &str) -> Result<Vec<u8>> {
    if let Some(bytes) = unchanged(&args.input, &note.sha256_out, note.sha256_in.as_deref())? {
        return Ok(bytes);
    }
    let Some(sha256) = &note.sha256_in else {
        return Err(bad(Place::file(name), "no SHA-256 of the original", "a note that contains it"));
    };
    match (&args.original, &note.original) {
        (Some(path), _) => {
            let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
            checked(&shown(path), bytes, sha256)
        }
        (None, Some(text)) => checked(name, unpack(name, text)?, sha256),
        (None, None) => Err(too_large(name, &note.input)),
    }
}

fn too_large(name: &str, original: &str) -> anyhow::Error {
    no(format!(
        "{name}: the note does not contain the bytes of {} (a stream, or more than {} MB): give the file with --original",
        named(original),
        KEPT_UP_TO >> 20
    ))
}

/// The original as messages name it.
fn named(original: &str) -> &str {
    if original == "-" { "standard input" } else { original }
}

fn checked(name: &str, bytes: Vec<u8>, sha256: &str) -> Result<Vec<u8>> {
    let found = input::sha256(&bytes);
    if found == sha256 {
        return Ok(bytes);
    }
    Err(bad(Place::file(name), format!("bytes with SHA-256 {found}"), format!("the original's: {sha256}")))
}

/// The rewritten file is still what was written; or it is the original, whose bytes are given: a rewrite that ended before its program
/// came into place, or one that changed nothing.
fn unchanged(file: &Path, rewritten: &str, original: Option<&str>) -> Result<Option<Vec<u8>>> {
    let bytes = std::fs::read(file).map_err(|e| Error::io(file, "read", e))?;
    let found = input::sha256(&bytes);
    if original == Some(found.as_str()) {
        return Ok(Some(bytes));
    }
    if found == rewritten {
        return Ok(None);
    }
    Err(no(format!(
        "{}: changed since `rewrite` wrote it: the changes would be lost; nothing was written",
        shown(file)
    )))
}

/// A file in the folder of `file`; a name that a note gives leads nowhere else.
fn beside(file: &Path, name: &str) -> PathBuf {
    let named = path_of(name).unwrap_or_default();
    file.with_file_name(named.file_name().unwrap_or_default())
}
