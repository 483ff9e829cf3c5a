//! Long outputs go to disk while they are written, so that the last sync finds little to do.

use std::fs::File;
use std::io;
use std::thread::JoinHandle;

/// Bytes between two syncs.
const STRIDE: u64 = 64 << 20;

/// Syncs of an output that is being written, one at a time, each on its own thread.
#[derive(Default)]
pub(super) struct Ahead {
    since: u64,
    running: Option<JoinHandle<io::Result<()>>>,
    failed: Option<io::Error>,
}

impl Ahead {
    /// So many bytes more were written. Where no thread can be had, the last sync does everything.
    pub(super) fn written(&mut self, bytes: usize, file: &File) {
        self.since += bytes as u64;
        if self.since < STRIDE || self.running.as_ref().is_some_and(|r| !r.is_finished()) {
            return;
        }
        self.since = 0;
        self.wait();
        if let Ok(file) = file.try_clone() {
            self.running = std::thread::Builder::new().spawn(move || file.sync_data()).ok();
        }
    }

    /// The first failure of a sync: the system reports it once, to the first caller.
    pub(super) fn finish(&mut self) -> io::Result<()> {
        self.wait();
        self.failed.take().map_or(Ok(()), Err)
    }

    fn wait(&mut self) {
        let done = self.running.take().map(JoinHandle::join);
        if let Some(Ok(Err(e))) = done {
            self.failed.get_or_insert(e);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_failure_on_the_way_is_told_at_the_end() {
        let mut ahead = Ahead { failed: Some(io::Error::from(io::ErrorKind::StorageFull)), ..Ahead::default() };
        assert_eq!(ahead.finish().unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert!(ahead.finish().is_ok());
    }

    #[test]
    fn a_long_file_is_synced_on_the_way() {
        let mut file = tempfile::tempfile().unwrap();
        let mut ahead = Ahead::default();
        file.write_all(b"1").unwrap();
        ahead.written(1, &file);
        assert!(ahead.running.is_none());
        ahead.written(STRIDE as usize, &file);
        assert!(ahead.running.is_some());
        ahead.finish().unwrap();
    }
}
