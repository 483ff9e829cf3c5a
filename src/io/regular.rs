//! Regular files alone: names that anybody may have made (notes, locks, what a killed run left).
//!
//! Opening a FIFO waits for its other end, and a device may answer for ever: what is no regular file is an error here, at once.

use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file to read it; links are followed.
pub fn open(path: &Path) -> io::Result<File> {
    checked(options(false).read(true).open(path)?)
}

/// The same where the name itself has to be that of the file: no link.
pub fn open_unlinked(path: &Path) -> io::Result<File> {
    checked(options(true).read(true).open(path)?)
}

/// Opens a regular file to read and write it, and makes it where it is not there; no link.
pub fn open_or_make_unlinked(path: &Path) -> io::Result<File> {
    checked(options(true).read(true).write(true).create(true).truncate(false).open(path)?)
}

/// All bytes of a regular file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether an error says that a name stands for something else than a regular file.
pub fn is_other(error: &io::Error) -> bool {
    error.get_ref().is_some_and(|e| e.is::<NotRegular>())
}

/// The name stands for a folder, a FIFO, a device.
#[derive(Debug, thiserror::Error)]
#[error("not a regular file")]
struct NotRegular;

fn checked(file: File) -> io::Result<File> {
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::other(NotRegular)),
    }
}

/// Options with which no open waits.
#[cfg(unix)]
fn options(unlinked: bool) -> OpenOptions {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    let flags = if unlinked { OFlags::NONBLOCK | OFlags::NOFOLLOW } else { OFlags::NONBLOCK };
    let mut options = OpenOptions::new();
    options.custom_flags(flags.bits() as i32);
    options
}

#[cfg(not(unix))]
fn options(_: bool) -> OpenOptions {
    OpenOptions::new()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_fifo_a_folder_and_a_device_are_errors_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let fifo = dir.path().join("fifo");
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        for path in [fifo.as_path(), dir.path(), Path::new("/dev/zero")] {
            assert!(is_other(&read(path).unwrap_err()), "{}", path.display());
        }
        assert!(open_or_make_unlinked(&fifo).is_err());
    }

    #[test]
    fn a_link_is_followed_only_where_that_is_asked() {
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("file"), dir.path().join("link"));
        std::fs::write(&file, "text").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert_eq!(read(&link).unwrap(), b"text");
        assert!(open_unlinked(&file).is_ok() && open_unlinked(&link).is_err() && open_or_make_unlinked(&link).is_err());
        assert_eq!(std::fs::read(&file).unwrap(), b"text");
    }
}
