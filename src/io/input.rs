//! Reading: a path or `-`, gzip recognised by its first bytes, SHA-256 of the bytes as they were stored.

use super::memory;
use super::notice::{self, Notice};
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
    /// Its bytes, unpacked.
    pub bytes: Vec<u8>,
    /// Of the stored bytes (for a gzip file: of the compressed ones), lower-case hex.
    pub sha256: String,
}

/// An input that is read whole has at most so many bytes, packed or not.
pub const LARGEST: u64 = 2 << 30;
/// A gzip file unpacks to at most so many times its size: logs and programs reach some 30 times.
const MOST_RATIO: u64 = 100;
/// Up to this size, bytes, it unpacks whatever the ratio is.
const ANY_RATIO: u64 = 256 << 20;
/// Bytes of memory that a byte of an input takes, at least, once it is read.
const PER_BYTE: u64 = 2;
/// Bytes that are read before memory for more is requested.
const PIECE: u64 = 32 << 20;

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
    let name = shown(path);
    memory::require_for_file(path, &name, LARGEST, |bytes| bytes.saturating_mul(PER_BYTE))?;
    let bytes = read_within(&name, open(path)?, LARGEST)?;
    from_bytes(name, bytes)
}

/// Reads a stream of at most `most` bytes whole; memory is requested as it grows, so that what does not fit is refused with a message.
pub fn read_within(name: &str, stream: impl Read, most: u64) -> Result<Vec<u8>> {
    let mut stream = stream;
    let mut bytes = Vec::new();
    loop {
        let before = bytes.len() as u64;
        if before >= PIECE {
            // a vector grows by doubling
            memory::require(name, "a file", PER_BYTE * before)?;
        }
        (&mut stream).take(PIECE).read_to_end(&mut bytes).map_err(|e| Error::io_of(name, "read", e))?;
        memory::require_size(name, bytes.len() as u64, most)?;
        if bytes.len() as u64 - before < PIECE {
            return Ok(bytes);
        }
    }
}

/// Takes stored bytes for an input, unpacking gzip; `name` stands in messages.
pub fn from_bytes(name: String, mut bytes: Vec<u8>) -> Result<Input> {
    let sha256 = hex(&Sha256::digest(&bytes));
    notice::report(Notice::Read { name: &name, bytes: bytes.len(), sha256: &sha256 });
    if bytes.starts_with(&[0x1f, 0x8b]) {
        bytes = unpacked(&name, &bytes, largest_unpacked(bytes.len() as u64)).map_err(|e| match e {
            Error::Io { source, .. } => Error::bad(
                Place::file(&name),
                format!("a gzip file that is damaged or cut short ({source})"),
                "a whole gzip file",
            ),
            Error::BadInput(bad) => {
                Error::bad(bad.place, format!("a gzip file that unpacks to {}", bad.found), bad.expected)
            }
            other => other,
        })?;
    }
    Ok(Input { name, bytes, sha256 })
}

/// Bytes to which a gzip file of `packed` bytes may unpack.
fn largest_unpacked(packed: u64) -> u64 {
    packed.saturating_mul(MOST_RATIO).clamp(ANY_RATIO, LARGEST)
}

/// The content of a gzip file. What is large is counted before it is held, so that a small file that unpacks to too much does not fill the memory.
fn unpacked(name: &str, packed: &[u8], most: u64) -> Result<Vec<u8>> {
    let failed = |e| Error::io_of(name, "unpack", e);
    let mut stream = MultiGzDecoder::new(packed);
    let mut bytes = Vec::new();
    stream.by_ref().take(PIECE).read_to_end(&mut bytes).map_err(failed)?;
    if (bytes.len() as u64) < PIECE {
        memory::require_size(name, bytes.len() as u64, most)?;
        return Ok(bytes);
    }
    let rest =
        std::io::copy(&mut stream.take((most + 1).saturating_sub(PIECE)), &mut std::io::sink()).map_err(failed)?;
    let whole = PIECE + rest;
    if whole > most && most < LARGEST {
        let found = format!("more than {} MB, {MOST_RATIO} times its size", most >> 20);
        return Err(Error::bad(Place::file(name), found, "no more than that of a packed file (unpack it first)"));
    }
    memory::require_size(name, whole, most)?;
    memory::require(name, "a file", whole)?;
    bytes.reserve_exact(usize::try_from(rest).unwrap_or_default());
    let mut again = MultiGzDecoder::new(packed);
    bytes.clear();
    again.by_ref().take(whole).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
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

/// Refuses a CSV text without a row of any kind: empty, or comments alone.
pub fn refuse_no_rows(name: &str, text: &str, expected: &str) -> Result<()> {
    let rows = text.lines().map(str::trim).filter(|l| !l.is_empty());
    let found = match rows.map(|l| l.starts_with('#')).reduce(|a, b| a && b) {
        None => "an empty file",
        Some(true) => "only comments",
        Some(false) => return Ok(()),
    };
    Err(Error::bad(Place::file(name), found, expected))
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_stream_beyond_the_limit_is_refused_before_it_is_read_to_its_end() {
        let endless = std::io::repeat(b'0');
        let refused = read_within("bomb.csv.gz", endless, 100 << 20).unwrap_err().to_string();
        assert!(refused.contains("at most 100 MB"), "{refused}");
        assert_eq!(read_within("p.csv", &b"a\n1\n"[..], 10).unwrap(), b"a\n1\n");
    }

    #[test]
    fn a_small_file_that_unpacks_to_too_much_is_refused_while_it_is_counted() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        let rows = b"0,0,0,0,0\n".repeat(100_000);
        for _ in 0..300 {
            packed.write_all(&rows).unwrap();
        }
        let packed = packed.finish().unwrap();
        let refused = from_bytes("bomb.csv.gz".into(), packed).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains("unpacks to more than"), "{refused}");
        assert!(refused.contains("100 times its size"), "{refused}");
        assert_eq!((largest_unpacked(1 << 20), largest_unpacked(10 << 20)), (256 << 20, 1000 << 20));
        assert_eq!(largest_unpacked(1 << 30), LARGEST);
    }

    #[test]
    fn what_is_counted_before_it_is_held_comes_back_whole() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        let rows = b"0,0,0,0,0\n".repeat(100_000);
        (0..40).for_each(|_| packed.write_all(&rows).unwrap());
        let packed = packed.finish().unwrap();
        let whole = unpacked("rows.csv.gz", &packed, LARGEST).unwrap();
        assert!(whole.len() == 40 * rows.len() && whole.chunks(rows.len()).all(|piece| piece == rows));
        assert!(unpacked("rows.csv.gz", &packed, (whole.len() - 1) as u64).is_err());
        assert!(unpacked("rows.csv.gz", &packed[..packed.len() - 3], LARGEST).is_err());
    }

    #[test]
    fn a_packed_input_comes_back_and_a_damaged_one_is_named() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(b"t_s\n0\n").unwrap();
        let packed = packed.finish().unwrap();
        assert_eq!(from_bytes("a.csv.gz".into(), packed.clone()).unwrap().bytes, b"t_s\n0\n");
        let damaged = packed[..packed.len() - 3].to_vec();
        assert!(from_bytes("a.csv.gz".into(), damaged).unwrap_err().to_string().contains("damaged or cut short"));
    }
}
