//! What lies in a folder: names as bytes, and what they are. An error at any step is an error, never a panic (closing a folder
//! of the standard library panics where the system reports an error there).

use std::ffi::OsString;
use std::io;
use std::path::Path;

/// What a name stands for; a link is `Other`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// Anything else: a pipe, a device, a broken link.
    Other,
}

/// The entries of a folder, in the order of the system, without `.` and `..`.
#[cfg(unix)]
pub fn list(folder: &Path) -> io::Result<Vec<(OsString, Kind)>> {
    use rustix::fs::{CWD, Dir, FileType, Mode, OFlags, openat};
    use std::os::unix::ffi::OsStringExt;
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let opened = openat(CWD, folder, flags, Mode::empty())?;
    let mut found = Vec::new();
    for entry in Dir::new(opened)? {
        let entry = entry?;
        let name = entry.file_name().to_bytes();
        if name == b"." || name == b".." {
            continue;
        }
        let name = OsString::from_vec(name.to_vec());
        let kind = match entry.file_type() {
            FileType::RegularFile => Kind::File,
            FileType::Directory => Kind::Folder,
            FileType::Unknown => kind_of(&std::fs::symlink_metadata(folder.join(&name))?),
            _ => Kind::Other,
        };
        found.push((name, kind));
    }
    Ok(found)
}

#[cfg(not(unix))]
pub fn list(folder: &Path) -> io::Result<Vec<(OsString, Kind)>> {
    let entry = |e: io::Result<std::fs::DirEntry>| {
        let e = e?;
        Ok((e.file_name(), kind_of(&e.metadata()?)))
    };
    std::fs::read_dir(folder)?.map(entry).collect()
}

fn kind_of(meta: &std::fs::Metadata) -> Kind {
    match meta.file_type() {
        t if t.is_file() => Kind::File,
        t if t.is_dir() => Kind::Folder,
        _ => Kind::Other,
    }
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Some file systems know no sync; that is no failure of the write.
pub(super) fn ignore_unsupported(e: io::Error) -> io::Result<()> {
    if matches!(e.kind(), io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput) { Ok(()) } else { Err(e) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_kinds_come_as_they_are() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("sub")).unwrap();
        std::fs::write(dir.path().join("a.csv"), "").unwrap();
        let mut found = list(dir.path()).unwrap();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(found, [("a.csv".into(), Kind::File), ("sub".into(), Kind::Folder)]);
        assert_eq!(list(&dir.path().join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
