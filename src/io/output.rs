//! Writing: a file appears whole or not at all.
//!
//! Method: bytes go to a [`Temporary`] file beside the target, which [`Output::prepare`] forces to disk and a
//! [`Transaction`] renames; a dropped output leaves nothing. Standard output, and a target that is no regular file, are held back in
//! the same way (in memory up to 16 MiB, then on disk), so that a pipe never receives the first half of a program whose second
//! half was refused.

use super::ahead::Ahead;
use super::folder::ignore_unsupported;
use super::kind::Kind;
use super::links;
use super::remains;
use super::temporary::Temporary;
use super::transaction::Transaction;
use crate::error::{Error, Result, is_stdio, shown};
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::SpooledTempFile;

const IN_MEMORY: usize = 16 << 20;
/// What comes in larger pieces, as rewritten programs do, is not copied into a buffer first.
const BUFFER: usize = 1 << 16;
const SMALL: usize = 1 << 14;
/// End of the name of a note beside a program.
const NOTE: &str = ".lostmotion.json";

pub(super) enum Sink {
    Stdout(SpooledTempFile),
    File(Box<InFile>),
    /// A target that is no regular file (a FIFO, `/dev/null`): held back like standard output, then written.
    Special {
        held: SpooledTempFile,
        target: PathBuf,
    },
}

/// An output on its way to a regular file.
pub(super) struct InFile {
    pub(super) writer: BufWriter<File>,
    pub(super) temporary: Temporary,
    /// As it was named, and where that leads.
    pub(super) named: PathBuf,
    pub(super) target: PathBuf,
    /// A file stands there.
    pub(super) replaces: bool,
    pub(super) bytes: u64,
    /// It replaces a file of whatever kind.
    any_kind: bool,
    ahead: Ahead,
}

/// An output that is not there until it is committed.
pub struct Output {
    pub(super) sink: Sink,
    pub(super) shown: String,
    prepared: bool,
    pub(super) durability: Durability,
}

/// How a file comes to its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Durability {
    /// On disk before it is in place, and its folder after it: it outlives a loss of power.
    #[default]
    Synced,
    /// In place whole, on disk when the system writes it: thousands of small files of a run that holds their folder
    /// ([`super::lock`]) and finds out by their hashes what is left to do.
    RenameOnly,
}

impl Output {
    /// Prepares an output; fails early where the folder is missing or the target cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        Self::create_as(path, Durability::Synced)
    }

    /// The same, as durable as requested.
    pub fn create_as(path: &Path, durability: Durability) -> Result<Self> {
        let made = |sink, shown| Self { sink, shown, prepared: false, durability };
        if is_stdio(path) {
            return Ok(made(Sink::Stdout(SpooledTempFile::new(IN_MEMORY)), "standard output".into()));
        }
        let shown = shown(path);
        // a new file needs no second look: there may be thousands
        let nothing = std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
        // first what the name stands for: one of a descriptor (`/dev/fd/63`) leads to no other name
        let there = if nothing { None } else { std::fs::metadata(path).ok() };
        // a link stays a link: what it points to is replaced, or made
        let target = if nothing { path.to_path_buf() } else { links::target_of(path) };
        if let Some(meta) = &there {
            if meta.is_dir() {
                return Err(Error::bad(crate::error::Place::file(&shown), "a folder", "a file to write"));
            }
            if !meta.is_file() || std::fs::metadata(&target).is_err() {
                let target = path.to_path_buf();
                return Ok(made(Sink::Special { held: SpooledTempFile::new(IN_MEMORY), target }, shown));
            }
            if meta.permissions().readonly() {
                return Err(Error::io(path, "write", io::Error::from(io::ErrorKind::PermissionDenied)));
            }
            OpenOptions::new().append(true).open(&target).map_err(|e| Error::io(path, "write", e))?;
        }
        let folder = super::folder::folder_of(&target);
        if durability == Durability::Synced {
            super::temporary::clean(folder);
        }
        let small = if durability == Durability::Synced { BUFFER } else { SMALL };
        // the mode of the file it replaces, else what the umask leaves of 0666
        let mode = Some(there.as_ref().map_or(0o666, mode_of));
        let (file, temporary) = Temporary::create(folder, mode).map_err(|e| match e.kind() {
            io::ErrorKind::NotFound => Error::io(path, "write", io::Error::new(e.kind(), "the folder does not exist")),
            _ => Error::io(path, "write", e),
        })?;
        let writer = BufWriter::with_capacity(small, file);
        let (named, replaces) = (path.to_path_buf(), there.is_some());
        Ok(made(
            Sink::File(Box::new(InFile {
                writer,
                temporary,
                named,
                target,
                replaces,
                bytes: 0,
                any_kind: false,
                ahead: Ahead::default(),
            })),
            shown,
        ))
    }

    /// Writes the last of the output.
    pub fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.write_all(bytes).map_err(|e| Error::io_of(&self.shown, "write", e))?;
        self.prepare()
    }

    /// Everything that was written so far to an output that goes to a regular file; empty for others.
    pub fn contents(&mut self) -> Result<Vec<u8>> {
        self.flush().map_err(|e| Error::io_of(&self.shown, "write", e))?;
        match &self.sink {
            Sink::File(file) => std::fs::read(file.temporary.path()).map_err(|e| Error::io_of(&self.shown, "read", e)),
            _ => Ok(Vec::new()),
        }
    }

    /// Whether a file holds the beginning of what was written so far to an output that goes to a regular file, and ends within a line
    /// of it: a loss of power hardly ever cuts a file at the end of a line, and a person who takes lines away does.
    pub fn is_cut_short(&mut self, file: &Path) -> io::Result<bool> {
        self.flush()?;
        let Sink::File(ours) = &self.sink else { return Ok(false) };
        let mut there = BufReader::with_capacity(BUFFER, File::open(file)?);
        let mut ours = BufReader::with_capacity(BUFFER, File::open(ours.temporary.path())?);
        let within_line = |byte: Option<&u8>| byte.is_some_and(|b| !matches!(b, b'\n' | b'\r'));
        let mut last = None;
        loop {
            let (a, b) = (there.fill_buf()?, ours.fill_buf()?);
            if a.is_empty() {
                return Ok(within_line(last.as_ref()) && within_line(b.first()));
            }
            let shared = a.len().min(b.len());
            if shared == 0 || a[..shared] != b[..shared] {
                return Ok(false);
            }
            last = a[..shared].last().copied();
            there.consume(shared);
            ours.consume(shared);
        }
    }

    /// Brings all bytes to where they have only to be put in place: a full disk shows here, while nothing of this output, nor of
    /// those that belong to it, is in place.
    pub fn prepare(&mut self) -> Result<()> {
        if self.prepared {
            return Ok(());
        }
        let flushed = self.flush();
        let synced = flushed.and_then(|()| match &mut self.sink {
            Sink::File(file) => {
                file.bytes = file.writer.get_ref().metadata()?.len();
                match self.durability {
                    Durability::Synced => {
                        let ahead = file.ahead.finish().or_else(ignore_unsupported);
                        ahead.and_then(|()| file.writer.get_ref().sync_all().or_else(ignore_unsupported))
                    }
                    Durability::RenameOnly => Ok(()),
                }
            }
            _ => Ok(()),
        });
        synced.map_err(|e| Error::io_of(&self.shown, "write", e))?;
        self.prepared = true;
        Ok(())
    }

    /// Looks again whether a file stands at the target: one may have come since the output was made. Where a run holds the folder,
    /// none does.
    pub(super) fn look_again(&mut self) {
        if let Sink::File(file) = &mut self.sink
            && self.durability == Durability::Synced
        {
            file.replaces |= std::fs::symlink_metadata(&file.target).is_ok();
        }
    }

    /// Lets it replace a file of another kind: its caller knows what stands there.
    pub fn replace_any_kind(&mut self) {
        if let Sink::File(file) = &mut self.sink {
            file.any_kind = true;
        }
    }

    /// Whether it goes to a regular file.
    pub fn is_regular(&self) -> bool {
        matches!(self.sink, Sink::File(_))
    }

    /// Refuses to replace a file of another kind: a mistaken name.
    pub(super) fn refuse_other_kind(&self) -> Result<()> {
        match &self.sink {
            Sink::File(file) if file.replaces && !file.any_kind => {
                Kind::of_file(file.temporary.path()).map_or(Ok(()), |k| self.expect(&k))
            }
            _ => Ok(()),
        }
    }

    /// The same before anything is written to it, of what will be of this kind.
    pub fn expect(&self, ours: &Kind) -> Result<()> {
        let Sink::File(file) = &self.sink else { return Ok(()) };
        let there = Kind::of_file(&file.target).filter(|_| file.replaces);
        let other = |t: &Kind| !ours.replaces(t, &file.target) && !self.replaces_remains(file, ours);
        let Some(there) = there.filter(other) else { return Ok(()) };
        let found = match (&there, ours) {
            (Kind::Table(_), Kind::Table(_)) => "a table with other columns than the one that would replace it".into(),
            _ => format!("{}, which {} would replace", there.name(), ours.name()),
        };
        Err(Error::bad(crate::error::Place::file(&self.shown), found, "another name, or remove the file first"))
    }

    /// Whether what stands there is what a loss of power left of an output that was not forced to disk: a note that is damaged
    /// somehow, or a file that ends in zeros.
    fn replaces_remains(&self, file: &InFile, ours: &Kind) -> bool {
        self.durability == Durability::RenameOnly
            && (is_note(&file.named) || remains::kind_of(&file.target).is_some_and(|k| ours.replaces(&k, &file.target)))
    }

    /// A file that a person named, and that was there.
    pub(super) fn tells_replaced(&self) -> bool {
        let Sink::File(file) = &self.sink else { return false };
        file.replaces && self.durability == Durability::Synced && !is_note(&file.named)
    }

    /// Puts the output in place.
    pub fn commit(self) -> Result<()> {
        let mut alone = Transaction::default();
        alone.put(self);
        alone.commit()
    }
}

impl Sink {
    /// Hands on what was held back; of a regular file nothing is.
    pub(super) fn release(&mut self) -> io::Result<()> {
        match self {
            Self::File(_) => Ok(()),
            Self::Stdout(held) => copy_out(held, &mut io::stdout().lock()),
            Self::Special { held, target } => copy_out(held, &mut OpenOptions::new().write(true).open(target)?),
        }
    }
}

/// An error of what is held back on disk, with the folder where that is.
fn of_temporary_folder(e: io::Error) -> io::Error {
    let folder = shown(&std::env::temp_dir());
    io::Error::new(e.kind(), format!("in the folder for temporary files, {folder}: {}", e.kind()))
}

fn is_note(path: &Path) -> bool {
    path.as_os_str().as_encoded_bytes().ends_with(NOTE.as_bytes())
}

fn copy_out(held: &mut SpooledTempFile, out: &mut impl Write) -> io::Result<()> {
    held.seek(SeekFrom::Start(0))?;
    io::copy(held, out)?;
    out.flush()
}

#[cfg(unix)]
fn mode_of(meta: &std::fs::Metadata) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    meta.permissions().mode() & 0o7777
}

#[cfg(not(unix))]
fn mode_of(_: &std::fs::Metadata) -> u32 {
    0o666
}

impl Write for Output {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        self.prepared = false;
        match &mut self.sink {
            Sink::Stdout(held) | Sink::Special { held, .. } => held.write(buf).map_err(of_temporary_folder),
            Sink::File(file) => {
                let taken = file.writer.write(buf)?;
                if self.durability == Durability::Synced {
                    file.ahead.written(taken, file.writer.get_ref());
                }
                Ok(taken)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Stdout(held) | Sink::Special { held, .. } => held.flush().map_err(of_temporary_folder),
            Sink::File(file) => file.writer.flush(),
        }
    }
}

/// Prepares an output where one is requested.
pub fn create(path: Option<&Path>) -> Result<Option<Output>> {
    path.map(Output::create).transpose()
}

/// Puts outputs that belong together in place, all or none.
pub fn commit<const N: usize>(outputs: [Option<Output>; N]) -> Result<()> {
    let mut together = Transaction::default();
    outputs.into_iter().flatten().for_each(|o| together.put(o));
    together.commit()
}

/// Writes one whole text.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut out = Output::create(path)?;
    out.write_all(bytes).map_err(|e| Error::io(path, "write", e))?;
    out.commit()
}
