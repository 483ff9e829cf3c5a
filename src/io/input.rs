//! Reading: a path or `-`, gzip recognised by its first bytes, SHA-256 of the bytes as they were stored.

use crate::error::{Error, Place, Result, is_stdio, shown};
use flate2::read::MultiGzDecoder;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The bytes of an input and where they came from.
#[derive(Debug, Clone)]
pub struct Input {
    /// As messages show it.
    pub name: String,
    pub bytes: Vec<u8>,
    /// Of the stored bytes (for a gzip file: of the compressed ones), lower-case hex.
    pub sha256: String,
}

/// Opens a path or standard input for streaming.
pub fn open(path: &Path) -> Result<Box<dyn Read + Send>> {
    if is_stdio(path) {
        return Ok(Box::new(std::io::stdin()));
    }
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Error::bad(Place::file(shown(path)), "a folder", "a file"));
    }
    Ok(Box::new(file))
}

/// Reads a whole input, unpacking gzip.
pub fn read(path: &Path) -> Result<Input> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    from_bytes(shown(path), bytes)
}

/// Takes stored bytes for an input, unpacking gzip; `name` stands in messages.
pub fn from_bytes(name: String, mut bytes: Vec<u8>) -> Result<Input> {
    let sha256 = hex(&Sha256::digest(&bytes));
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut plain = Vec::new();
        MultiGzDecoder::new(bytes.as_slice()).read_to_end(&mut plain).map_err(|e| {
            Error::bad(
                Place::file(&name),
                format!("a gzip file that is damaged or cut short ({e})"),
                "a whole gzip file",
            )
        })?;
        bytes = plain;
    }
    Ok(Input { name, bytes, sha256 })
}

/// Reads a whole input as UTF-8 text; a byte order mark is dropped, UTF-16 is named.
pub fn read_text(path: &Path) -> Result<(String, Input)> {
    let mut input = read(path)?;
    let text = decode(&input.name, std::mem::take(&mut input.bytes))?;
    Ok((text, input))
}

/// UTF-8 text of bytes, or what they are instead.
pub fn decode(name: &str, bytes: Vec<u8>) -> Result<String> {
    refuse_utf16(name, &bytes)?;
    let bytes = if bytes.starts_with(b"\xef\xbb\xbf") { bytes[3..].to_vec() } else { bytes };
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let line = e.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count() as u64 + 1;
        Error::bad(
            Place::line(name, line),
            format!("byte 0x{:02X}, which is not UTF-8", e.as_bytes()[at]),
            "UTF-8 text",
        )
    })
}

/// Names UTF-16 by its byte order mark, or by the zero bytes that Latin letters have in it.
pub fn refuse_utf16(name: &str, bytes: &[u8]) -> Result<()> {
    let zeros = |from: usize| bytes.len() >= 8 && bytes.iter().take(64).skip(from).step_by(2).all(|&b| b == 0);
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) || zeros(0) || zeros(1) {
        return Err(Error::bad(Place::line(name, 1), "UTF-16 text", "UTF-8 text"));
    }
    Ok(())
}

/// Lower-case hex.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 of bytes, lower-case hex.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}
