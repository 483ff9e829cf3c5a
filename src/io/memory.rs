//! What fits into memory: a file that does not is refused with a message before it is read, instead of an abort.
//!
//! Method: the smallest of what the system has available (`/proc/meminfo`), what the control group may still use, and the limit on
//! the address space of the process. Where none of these can be determined (another system), nothing is refused here.

use crate::error::{Error, Place, Result};
use std::path::Path;

const KIB: u64 = 1 << 10;
const MIB: u64 = 1 << 20;
/// Up to this size nothing is checked: the process itself holds more, and thousands of small files need no look at the system each.
const SMALL: u64 = 8 * MIB;

/// Bytes that the process may still take, where the system reports them.
pub fn available() -> Option<u64> {
    [system(), group(), limit()].into_iter().flatten().min()
}

/// Refuses what needs more memory than there is; `name` is the file that it is about, `what` needs it (`a file`).
pub fn require(name: &str, what: &str, bytes: u64) -> Result<()> {
    if bytes <= SMALL {
        return Ok(());
    }
    match available() {
        Some(there) if there < bytes => Err(Error::bad(
            Place::file(name),
            format!("{what} that needs about {} MB of memory", bytes.div_ceil(MIB)),
            format!("{what} that fits into the {} MB that are available (out of memory otherwise)", there / MIB),
        )),
        _ => Ok(()),
    }
}

/// Refuses a file larger than `most` bytes, or than there is memory for, before it is read; `need` makes bytes of memory of its size.
pub fn require_for_file(path: &Path, name: &str, most: u64, need: impl Fn(u64) -> u64) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(meta) if meta.is_file() => {
            require_size(name, meta.len(), most)?;
            require(name, "a file", need(meta.len()))
        }
        _ => Ok(()), // the size of a pipe is known only when it has been read
    }
}

/// Refuses more than `most` bytes.
pub fn require_size(name: &str, bytes: u64, most: u64) -> Result<()> {
    if bytes <= most {
        return Ok(());
    }
    let mb = |b: u64| b.div_ceil(MIB);
    Err(Error::bad(Place::file(name), format!("{} MB", mb(bytes)), format!("at most {} MB", mb(most))))
}

fn system() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? * KIB)
}

/// Of the control group (version 2, as containers see it).
fn group() -> Option<u64> {
    let number =
        |file: &str| std::fs::read_to_string(Path::new("/sys/fs/cgroup").join(file)).ok()?.trim().parse::<u64>().ok();
    Some(number("memory.max")?.saturating_sub(number("memory.current").unwrap_or(0)))
}

/// Of the address space (`ulimit -v`), less what is used.
fn limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    let most: u64 = line.split_whitespace().next()?.parse().ok()?;
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split_whitespace().next()?.parse().ok()?;
    Some(most.saturating_sub(pages * 4 * KIB))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_in_words() {
        let refused = require("big.src", "a file", u64::MAX);
        assert!(available().is_none() || refused.unwrap_err().to_string().contains("out of memory"));
        assert!(require("small.src", "a file", 1).is_ok());
    }

    #[test]
    fn a_file_that_is_too_large_is_refused_before_it_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sparse");
        std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = require_for_file(&path, "sparse", 1 << 30, |bytes| bytes).unwrap_err().to_string();
        assert!(refused.contains("at most 1024 MB"), "{refused}");
    }
}
