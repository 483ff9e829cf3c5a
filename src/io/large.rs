//! The bytes of a file on their way to disk; those of a large file past the page cache.
//!
//! Method: the first [`SMALL_FILE`] bytes are written as any file's. What follows goes in aligned pieces to a thread that writes them
//! with `O_DIRECT`, while the caller makes the next one: no copy is made by the kernel, nothing is evicted from its cache, and
//! little is left for the sync at the end. Where the file system takes no such writes, or no thread can be had, the
//! pieces are written as before.

use std::fs::File;
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Bytes up to which a file is written through the page cache, where it is likely to be read again soon.
const SMALL_FILE: u64 = 32 << 20;
/// Bytes that are written in one go.
const PIECE: usize = 1 << 20;
/// Pieces between the caller and the thread.
const PIECES: usize = 3;
/// What places in memory and in the file are multiples of.
const ALIGNMENT: usize = 4096;

/// Writes a file from its start to its end.
pub(super) struct Writer {
    file: File,
    buffer: Vec<u8>,
    /// Bytes of the file, without those of the buffer and the present piece.
    written: u64,
    /// Whether a large file may go past the page cache.
    direct: bool,
    pieces: Option<Pieces>,
}

/// Pieces on their way.
struct Pieces {
    present: Piece,
    full: SyncSender<Piece>,
    empty: Receiver<Piece>,
    thread: JoinHandle<io::Result<()>>,
}

/// Memory for [`PIECE`] bytes at an aligned place.
struct Piece {
    memory: Vec<u8>,
    from: usize,
    len: usize,
}

impl Piece {
    fn new() -> Self {
        let memory = vec![0; PIECE + ALIGNMENT];
        let from = memory.as_ptr().align_offset(ALIGNMENT);
        // an offset that cannot be told is only slower: the file system refuses the place
        let from = if from < ALIGNMENT { from } else { 0 };
        Self { memory, from, len: 0 }
    }

    fn bytes(&self) -> &[u8] {
        &self.memory[self.from..self.from + self.len]
    }

    /// Takes as many of `bytes` as there is room for.
    fn take(&mut self, bytes: &[u8]) -> usize {
        let count = bytes.len().min(PIECE - self.len);
        let at = self.from + self.len;
        self.memory[at..at + count].copy_from_slice(&bytes[..count]);
        self.len += count;
        count
    }
}

impl Writer {
    /// For a new file; `direct`: it may go past the page cache once it is large.
    pub(super) fn new(file: File, buffer: usize, direct: bool) -> Self {
        Self { file, buffer: Vec::with_capacity(buffer), written: 0, direct, pieces: None }
    }

    /// The file, whose last bytes are written by [`Write::flush`].
    pub(super) fn file(&self) -> &File {
        &self.file
    }

    fn write_buffer(&mut self) -> io::Result<()> {
        let written = self.file.write_all(&self.buffer);
        self.written += self.buffer.len() as u64;
        self.buffer.clear();
        written
    }

    /// From here on in pieces, if the place in the file is aligned.
    fn begin_pieces(&mut self) {
        if !self.direct || self.written < SMALL_FILE || !self.written.is_multiple_of(ALIGNMENT as u64) {
            return;
        }
        // tried once
        self.direct = false;
        let Ok(file) = self.file.try_clone() else { return };
        let (full, filled) = sync_channel::<Piece>(PIECES);
        let (emptied, empty) = sync_channel(PIECES);
        for _ in 1..PIECES {
            // there is room for all of them
            let _ = emptied.send(Piece::new());
        }
        let write = move || {
            let mut file = Past::new(file);
            for mut piece in filled {
                file.write_all(piece.bytes())?;
                piece.len = 0;
                // a caller that has no more to write takes none back
                let _ = emptied.send(piece);
            }
            file.end()
        };
        if let Ok(thread) = std::thread::Builder::new().spawn(write) {
            self.pieces = Some(Pieces { present: Piece::new(), full, empty, thread });
        }
    }

    /// Waits until all pieces are written.
    fn end_pieces(&mut self) -> io::Result<()> {
        let Some(Pieces { present, full, empty, thread }) = self.pieces.take() else { return Ok(()) };
        drop((full, empty));
        thread.join().unwrap_or_else(|_| Err(io::Error::other("the thread that writes stopped")))?;
        self.file.write_all(present.bytes())?;
        self.written += present.len as u64;
        Ok(())
    }
}

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(pieces) = &mut self.pieces {
            let count = pieces.present.take(bytes);
            if pieces.present.len == PIECE {
                // the thread hangs up where it fails; why is told when it is joined
                let Ok(next) = pieces.empty.recv() else {
                    return Err(self.end_pieces().err().unwrap_or_else(|| io::ErrorKind::WriteZero.into()));
                };
                let piece = std::mem::replace(&mut pieces.present, next);
                if pieces.full.send(piece).is_err() {
                    return Err(self.end_pieces().err().unwrap_or_else(|| io::ErrorKind::WriteZero.into()));
                }
                self.written += PIECE as u64;
            }
            return Ok(count);
        }
        if self.buffer.is_empty() && bytes.len() >= self.buffer.capacity() && !self.direct {
            let count = self.file.write(bytes)?;
            self.written += count as u64;
            return Ok(count);
        }
        let count = bytes.len().min(self.buffer.capacity() - self.buffer.len());
        self.buffer.extend_from_slice(&bytes[..count]);
        if self.buffer.len() == self.buffer.capacity() {
            self.write_buffer()?;
            self.begin_pieces();
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.end_pieces()?;
        self.write_buffer()
    }
}

/// A file that is written past the page cache as long as it takes that.
struct Past {
    file: File,
    direct: bool,
}

impl Past {
    fn new(file: File) -> Self {
        let direct = set_direct(&file, true).is_ok();
        Self { file, direct }
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.file.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => rest = &rest[count..],
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                // the file system takes no such writes, or not at this place
                Err(e)
                    if self.direct && matches!(e.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) =>
                {
                    self.direct = false;
                    set_direct(&self.file, false)?;
                }
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// The last bytes of a file are no whole piece.
    fn end(self) -> io::Result<()> {
        if self.direct { set_direct(&self.file, false) } else { Ok(()) }
    }
}

#[cfg(any(target_os = "linux", target_os = "android"))]
fn set_direct(file: &File, on: bool) -> io::Result<()> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    let mut flags = fcntl_getfl(file)?;
    flags.set(OFlags::DIRECT, on);
    Ok(fcntl_setfl(file, flags)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android")))]
fn set_direct(_: &File, on: bool) -> io::Result<()> {
    if on { Err(io::ErrorKind::Unsupported.into()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes whose place is seen from their value.
    fn numbers(count: usize) -> Vec<u8> {
        (0..count as u64 / 8).flat_map(|k| k.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_le_bytes()).collect()
    }

    #[test]
    fn a_large_file_is_the_bytes_that_were_written_whatever_their_pieces() {
        let bytes = numbers((SMALL_FILE as usize) + 5 * PIECE + 8);
        for (step, direct) in [(1 << 18, true), (300_001, true), (3 * PIECE + 17, true), (300_001, false)] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("large");
            let mut writer = Writer::new(File::create(&path).unwrap(), 1 << 18, direct);
            for part in bytes.chunks(step) {
                writer.write_all(part).unwrap();
            }
            assert_eq!(writer.pieces.is_some(), direct);
            writer.flush().unwrap();
            // more may follow
            writer.write_all(b"end").unwrap();
            writer.flush().unwrap();
            let found = std::fs::read(&path).unwrap();
            assert!(found[..bytes.len()] == bytes[..] && &found[bytes.len()..] == b"end", "steps of {step}");
            assert_eq!(writer.written, found.len() as u64);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_disk_that_is_full_is_an_error_of_the_write_or_of_the_flush() {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut writer = Writer::new(full, 1 << 18, true);
        // as if the first part had been written
        writer.written = SMALL_FILE;
        writer.begin_pieces();
        assert!(writer.pieces.is_some());
        let bytes = vec![b'x'; 8 * PIECE];
        let error = writer.write_all(&bytes).and_then(|()| writer.flush()).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
