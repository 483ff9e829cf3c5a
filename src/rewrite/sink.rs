//! Where the bytes of a rewritten program go: a file, nowhere, memory, or against a golden file.

use crate::error::{Error, Result, is_stdio, shown};
use crate::io::input::hex;
use crate::io::output::{Durability, Output};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::Path;

/// Takes the output piece by piece, in order.
pub trait Sink: Send {
    /// Takes the next bytes of the output.
    fn take(&mut self, bytes: &[u8]) -> Result<()>;

    /// Whether there is any use in making the bytes.
    fn wants_bytes(&self) -> bool {
        true
    }

    /// Gives the hash of the bytes so far to a caller that goes on with it while the sink takes bytes; `None`: no hash is wanted.
    fn lend_hash(&mut self) -> Option<Sha256> {
        None
    }

    /// Takes the hash back.
    fn return_hash(&mut self, _: Sha256) {}
}

/// Nothing is kept: a dry run.
pub struct NullSink;

impl Sink for NullSink {
    fn take(&mut self, _: &[u8]) -> Result<()> {
        Ok(())
    }

    fn wants_bytes(&self) -> bool {
        false
    }
}

/// In memory.
impl Sink for Vec<u8> {
    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        self.extend_from_slice(bytes);
        Ok(())
    }
}

/// A file (or standard output) that is not there until it is committed, with the SHA-256 of its bytes.
pub struct File {
    output: Output,
    /// `None` while it is lent.
    hash: Option<Sha256>,
    shown: String,
}

impl File {
    /// Fails early where the target cannot be written.
    pub fn create(path: &Path, durability: Durability) -> Result<Self> {
        let shown = if is_stdio(path) { "standard output".into() } else { shown(path) };
        Ok(Self { output: Output::create_as(path, durability)?, hash: Some(Sha256::new()), shown })
    }

    /// SHA-256 of the bytes so far.
    pub fn sha256(&self) -> String {
        hex(&self.hash.clone().unwrap_or_default().finalize())
    }

    /// Brings all bytes to disk, beside the target.
    pub fn prepare(&mut self) -> Result<()> {
        self.output.prepare()
    }

    /// Name of the target, as messages show it.
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// Everything that was written so far.
    pub fn contents(&mut self) -> Result<Vec<u8>> {
        self.output.contents()
    }

    /// Whether a file holds the beginning of what was written so far and ends within a line of it.
    pub fn is_cut_short(&mut self, file: &Path) -> bool {
        self.output.is_cut_short(file).unwrap_or(false) // one that cannot be read is nobody's beginning
    }

    /// Lets it replace a file of another kind.
    pub fn replace_any_kind(&mut self) {
        self.output.replace_any_kind();
    }

    /// Whether it goes to a regular file, which can be read again.
    pub fn is_regular(&self) -> bool {
        self.output.is_regular()
    }

    /// As an output, to be put in place.
    pub fn into_output(self) -> Output {
        self.output
    }
}

impl Sink for File {
    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        if let Some(hash) = &mut self.hash {
            hash.update(bytes);
        }
        self.output.write_all(bytes).map_err(|e| Error::io_of(&self.shown, "write", e))
    }

    fn lend_hash(&mut self) -> Option<Sha256> {
        self.hash.take()
    }

    fn return_hash(&mut self, hash: Sha256) {
        self.hash = Some(hash);
    }
}
