//! Standard output, FIFOs and devices receive what was held back for them, once the files are in place.
//!
//! Method: a reader may keep a writer waiting for ever. A thread of its own writes, so that a signal ends the run all the same: the
//! caller hears of it, and takes the files back. A reader that has gone is no failure: it has read what it wanted.

use super::interrupt;
use super::output::Sink;
use crate::error::{Error, Result};
use std::io;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Streams and their names.
pub(super) type Streams = Vec<(Sink, String)>;

/// Between two looks whether the process is to end.
const AGAIN: Duration = Duration::from_millis(20);

/// Hands everything on, in order.
///
/// # Errors
/// A stream cannot be written, or the process is to end.
pub(super) fn release(streams: Streams) -> Result<()> {
    for (stream, name) in streams {
        match hand_on(stream) {
            Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {}
            done => done.map_err(|e| Error::io_of(&name, "write", e))?,
        }
    }
    Ok(())
}

fn hand_on(stream: Sink) -> io::Result<()> {
    let (done, hears) = channel();
    let stream = Arc::new(Mutex::new(stream));
    let write = |stream: &Mutex<Sink>| stream.lock().unwrap_or_else(PoisonError::into_inner).release();
    let theirs = Arc::clone(&stream);
    let thread = std::thread::Builder::new().name("stream".into()).spawn(move || {
        let _ = done.send(write(&theirs)); // nobody hears of it where the process ends
    });
    if thread.is_err() {
        return write(&stream);
    }
    loop {
        match hears.recv_timeout(AGAIN) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) if interrupt::is_ending() => return Err(io::ErrorKind::Interrupted.into()),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(io::Error::other("the thread that writes has ended")),
        }
    }
}
