//! Writing: a file appears whole or not at all.
//!
//! Method: bytes go to a temporary file beside the target, which [`Output::prepare`] flushes to disk and [`Output::commit`] renames; a
//! dropped output leaves nothing, an interrupted process neither ([`discard`]). Standard output is held back in the same
//! way (in memory up to 16 MiB, then on disk), so
//! that a pipe never receives the first half of a program whose second half was refused.

use crate::error::{Error, Result, is_stdio};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{NamedTempFile, SpooledTempFile};

const IN_MEMORY: usize = 16 << 20;
const BUFFER: usize = 1 << 18;
const SMALL: usize = 1 << 14;
/// Files up to this size are forced to disk before the rename; beyond it that costs more than writing them.
const SYNC_UP_TO: u64 = 64 << 20;

enum Sink {
    Stdout(SpooledTempFile),
    File {
        temp: BufWriter<NamedTempFile>,
        target: PathBuf,
        /// Held for its end.
        _open: Open,
    },
    /// A target that is no regular file (a FIFO, `/dev/null`): held back like standard output, then written.
    Special {
        held: SpooledTempFile,
        target: PathBuf,
    },
}

/// Temporary files that are not in place.
static OPEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn open_files() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file in the list.
struct Open(PathBuf);

impl Open {
    fn new(path: &Path) -> Self {
        open_files().insert(path.to_path_buf());
        Self(path.to_path_buf())
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        open_files().remove(&self.0);
    }
}

/// Takes away what is not in place: for a process that is told to stop.
pub fn discard() {
    for path in open_files().iter() {
        let _ = std::fs::remove_file(path);
    }
}

/// An output that is not there until it is committed.
pub struct Output {
    sink: Sink,
    shown: String,
    prepared: bool,
    manner: Manner,
}

/// How a file comes to its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Manner {
    /// On disk before it is in place: it outlives a loss of power.
    #[default]
    Safe,
    /// In place whole, on disk when the system writes it: thousands of small files. The temporary file has the name of its
    /// target, so that a run that was killed leaves nothing that the next one does not replace.
    Swift,
}

impl Output {
    /// Prepares an output; fails early where the folder is missing or the target cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        Self::create_as(path, Manner::Safe)
    }

    /// The same in a manner of one's own.
    pub fn create_as(path: &Path, manner: Manner) -> Result<Self> {
        let shown = if is_stdio(path) { "standard output".into() } else { path.display().to_string() };
        if is_stdio(path) {
            return Ok(Self { sink: Sink::Stdout(SpooledTempFile::new(IN_MEMORY)), shown, prepared: false, manner });
        }
        // of thousands of new files none need be asked for twice
        let nothing = std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == io::ErrorKind::NotFound);
        let target = match std::fs::canonicalize(path) {
            _ if nothing => path.to_path_buf(),
            Ok(real) => real, // a link stays a link: what it points to is replaced
            Err(_) => path.to_path_buf(),
        };
        let there = if nothing { None } else { std::fs::metadata(&target).ok() };
        if let Some(meta) = &there {
            if meta.is_dir() {
                return Err(Error::bad(crate::error::Place::file(&shown), "a folder", "a file to write"));
            }
            if !meta.is_file() {
                return Ok(Self {
                    sink: Sink::Special { held: SpooledTempFile::new(IN_MEMORY), target },
                    shown,
                    prepared: false,
                    manner,
                });
            }
            if meta.permissions().readonly() {
                return Err(Error::io(path, "write", io::Error::from(io::ErrorKind::PermissionDenied)));
            }
            OpenOptions::new().append(true).open(&target).map_err(|e| Error::io(path, "write", e))?;
        }
        let folder = match target.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        let own = target.file_name().map(|n| format!(".{}.lostmotion", n.to_string_lossy())).unwrap_or_default();
        match manner {
            Manner::Safe => builder.prefix(".lostmotion-").suffix(".part"),
            Manner::Swift => builder.prefix(&own).suffix(".part").rand_bytes(0),
        };
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // the mode of the file it replaces, else what the umask leaves of 0666
            let mode = there.map_or(0o666, |m| m.permissions().mode() & 0o7777);
            builder.permissions(std::fs::Permissions::from_mode(mode));
        }
        let size = if manner == Manner::Safe { BUFFER } else { SMALL };
        let temp = builder.tempfile_in(folder).or_else(|e| match e.kind() {
            // left by a run that was killed
            io::ErrorKind::AlreadyExists if manner == Manner::Swift => {
                std::fs::remove_file(folder.join(format!("{own}.part"))).and_then(|()| builder.tempfile_in(folder))
            }
            io::ErrorKind::NotFound => Err(io::Error::new(e.kind(), "the folder is not there")),
            _ => Err(e),
        });
        let temp = temp.map_err(|e| Error::io(path, "write", e))?;
        let _open = Open::new(temp.path());
        Ok(Self {
            sink: Sink::File { temp: BufWriter::with_capacity(size, temp), target, _open },
            shown,
            prepared: false,
            manner,
        })
    }

    /// Writes the last of the output.
    pub fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.write_all(bytes).map_err(|e| Error::io(&self.shown, "write", e))?;
        self.prepare()
    }

    /// Brings all bytes to where [`Output::commit`] has only to put them in place: a full disk shows here, while nothing of
    /// this output, nor of those that belong to it, is in place.
    pub fn prepare(&mut self) -> Result<()> {
        self.flush().map_err(|e| Error::io(&self.shown, "write", e))?;
        if let Sink::File { temp, .. } = &self.sink
            && self.manner == Manner::Safe
        {
            let file = temp.get_ref().as_file();
            if file.metadata().is_ok_and(|m| m.len() <= SYNC_UP_TO) {
                file.sync_data().or_else(ignore_unsupported).map_err(|e| Error::io(&self.shown, "write", e))?;
            }
        }
        self.prepared = true;
        Ok(())
    }

    /// Puts the output in place.
    pub fn commit(mut self) -> Result<()> {
        if !self.prepared {
            self.prepare()?;
        }
        let shown = self.shown;
        match self.sink {
            Sink::Stdout(mut held) => {
                let mut out = io::stdout().lock();
                held.seek(SeekFrom::Start(0))
                    .and_then(|_| io::copy(&mut held, &mut out))
                    .and_then(|_| out.flush())
                    .map_err(|e| Error::io(&shown, "write", e))
            }
            Sink::Special { mut held, target } => {
                let mut out = OpenOptions::new().write(true).open(&target).map_err(|e| Error::io(&shown, "open", e))?;
                held.seek(SeekFrom::Start(0))
                    .and_then(|_| io::copy(&mut held, &mut out))
                    .and_then(|_| out.flush())
                    .map_err(|e| Error::io(&shown, "write", e))
            }
            Sink::File { temp, target, _open } => {
                let temp = temp.into_inner().map_err(|e| Error::io(&shown, "write", e.into_error()))?;
                temp.persist(&target).map(|_: File| ()).map_err(|e| Error::io(&shown, "replace", e.error))
            }
        }
    }
}

/// Some file systems know no sync; that is no failure of the write.
fn ignore_unsupported(e: io::Error) -> io::Result<()> {
    if matches!(e.kind(), io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput) { Ok(()) } else { Err(e) }
}

impl Write for Output {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        self.prepared = false;
        match &mut self.sink {
            Sink::Stdout(held) | Sink::Special { held, .. } => held.write(buf),
            Sink::File { temp, .. } => temp.write(buf),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Stdout(held) | Sink::Special { held, .. } => held.flush(),
            Sink::File { temp, .. } => temp.flush(),
        }
    }
}

/// Prepares an output where one is asked for.
pub fn create(path: Option<&Path>) -> Result<Option<Output>> {
    path.map(Output::create).transpose()
}

/// Puts outputs that belong together in place, in this order; none before all are known to be whole.
pub fn commit<const N: usize>(mut outputs: [Option<Output>; N]) -> Result<()> {
    outputs.iter_mut().flatten().try_for_each(Output::prepare)?;
    outputs.into_iter().flatten().try_for_each(Output::commit)
}

/// Writes one whole text.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut out = Output::create(path)?;
    out.write_all(bytes).map_err(|e| Error::io(path, "write", e))?;
    out.commit()
}
