//! What a loss of power leaves of a file whose bytes had not all come to disk: its beginning, or nothing, and zeros to its end.

use super::kind::Kind;
use super::regular;
use std::io::{BufReader, Read};
use std::path::Path;

/// Bytes before the zeros that tell the kind.
const HEAD: usize = 1 << 16;

/// The bytes before the zeros at the end; `None`: there are none at the end, or some elsewhere, too.
pub fn before_zeros(bytes: &[u8]) -> Option<&[u8]> {
    let first = bytes.iter().position(|b| *b == 0)?;
    let (before, after) = bytes.split_at(first);
    after.iter().all(|b| *b == 0).then_some(before)
}

/// The kind of what stands before the zeros at the end of a file; `None`: it is no such file.
pub fn kind_of(path: &Path) -> Option<Kind> {
    let mut file = BufReader::new(regular::open(path).ok()?);
    let mut piece = vec![0; HEAD];
    let mut head = Vec::new();
    let mut zeros = false;
    loop {
        let read = file.read(&mut piece).ok()?;
        let Some(read) = piece.get(..read).filter(|p| !p.is_empty()) else { break };
        let before = match (zeros, before_zeros(read)) {
            (true, _) => read.iter().all(|b| *b == 0).then_some(&[][..])?,
            (false, Some(before)) => {
                zeros = true;
                before
            }
            (false, None) if read.contains(&0) => return None,
            (false, None) => read,
        };
        let room = HEAD - head.len();
        head.extend_from_slice(&before[..before.len().min(room)]);
    }
    zeros.then(|| Kind::of(&head))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_is_that_of_the_beginning_and_zeros_elsewhere_are_binary() {
        let dir = tempfile::tempdir().unwrap();
        let kind = |bytes: &[u8]| {
            std::fs::write(dir.path().join("f"), bytes).unwrap();
            kind_of(&dir.path().join("f"))
        };
        let long = [b"1,2\n".repeat(100_000), vec![0; 300_000]].concat();
        assert_eq!(kind(&[0; 200_000]), Some(Kind::Empty));
        assert_eq!(kind(b"a1_deg,a2_deg\n1,2\n\0\0\0"), Some(Kind::Joints));
        assert_eq!(kind(&long), Some(Kind::Text));
        for other in [&b""[..], b"text\n", b"a\0b", b"\0\0b", &[&long[..], b"x"].concat()] {
            assert_eq!(kind(other), None);
        }
        assert_eq!(kind_of(dir.path()), None);
    }
}
