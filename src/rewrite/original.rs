//! The bytes of a program as it was, kept in the note beside its rewritten form: zlib, base64. `undo` brings them back.

use crate::error::{Error, Place, Result};
use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::cell::RefCell;
use std::io::{Read, Write};

/// A program of more bytes is not kept: its note would be as large as itself.
pub const KEPT_UP_TO: u64 = 4 << 20;

/// Bytes as they stand in a note; the same bytes give the same text.
pub fn pack(bytes: &[u8]) -> Option<String> {
    if bytes.len() as u64 > KEPT_UP_TO {
        return None;
    }
    thread_local! {
        // its tables cost more to make than a small program to pack
        static ENCODER: RefCell<ZlibEncoder<Vec<u8>>> = RefCell::new(ZlibEncoder::new(Vec::new(), Compression::fast()));
    }
    ENCODER.with_borrow_mut(|encoder| {
        let written = encoder.write_all(bytes);
        let packed = encoder.reset(Vec::new()).ok()?;
        written.ok().map(|()| STANDARD.encode(packed))
    })
}

/// The bytes of a note's text; `name` stands in messages.
pub fn unpack(name: &str, text: &str) -> Result<Vec<u8>> {
    let damaged = || Error::bad(Place::file(name), "an `original` that is damaged", "a note as `rewrite` wrote it");
    let packed = STANDARD.decode(text).map_err(|_| damaged())?;
    let mut bytes = Vec::new();
    let most = KEPT_UP_TO + 1;
    ZlibDecoder::new(packed.as_slice()).take(most).read_to_end(&mut bytes).map_err(|_| damaged())?;
    if bytes.len() as u64 >= most {
        return Err(damaged());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        let all = [Vec::new(), b"PTP {A1 0}\r\n".repeat(9), (0..=255).collect::<Vec<u8>>()];
        let packed: Vec<String> = all.iter().map(|b| pack(b).unwrap()).collect();
        for (bytes, packed) in all.iter().zip(&packed).rev() {
            assert_eq!(&unpack("note", packed).unwrap(), bytes);
            assert_eq!(&pack(bytes).unwrap(), packed, "whatever was packed before");
        }
        assert!(unpack("note", "no base64!").is_err());
        assert!(unpack("note", "aGVsbG8=").is_err());
    }
}
