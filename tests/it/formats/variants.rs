//! Other ways to write the same program: line endings, a Latin-1 byte in a comment, the end of the file, a byte order mark.

use super::samples::Sample;
use lostmotion::program::script::Text;

/// A comment of the format with a byte that is no UTF-8, to be put at the end of the text; `None`: it has none that
/// can stand there.
fn comment(format: &str, path: &str) -> Option<&'static [u8]> {
    match format {
        "krl" => Some(b"; Gr\xFC\xDFe"),
        "rapid" => Some(b"! Gr\xFC\xDFe"),
        "urscript" => Some(b"# Gr\xFC\xDFe"),
        "gcode" => Some(b"(Gr\xFC\xDFe)"),
        "trajectory" if !path.ends_with("json") => Some(b"# Gr\xFC\xDFe"),
        // comments of INFORM and TP are instructions within the program
        _ => None,
    }
}

fn lines_end_with(bytes: &[u8], ending: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len() + 64);
    for line in bytes.split_inclusive(|&b| b == b'\n') {
        match line.strip_suffix(b"\n") {
            Some(body) => {
                out.extend_from_slice(body.strip_suffix(b"\r").unwrap_or(body));
                out.extend_from_slice(ending);
            }
            None => out.extend_from_slice(line),
        }
    }
    out
}

fn unended(bytes: &[u8]) -> &[u8] {
    let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    bytes.strip_suffix(b"\r").unwrap_or(bytes)
}

/// The sample as it is, and its variants.
pub fn of(s: &Sample) -> Vec<(&'static str, Sample)> {
    let path = s.path.to_string_lossy().to_lowercase();
    let each = |change: &dyn Fn(&[u8]) -> Vec<u8>| {
        s.with(s.texts.iter().map(|t| Text::new(t.name.as_str(), change(&t.bytes))).collect())
    };
    let ending: &[u8] = if s.texts[0].bytes.windows(2).any(|w| w == b"\r\n") { b"\r\n" } else { b"\n" };
    let mut variants = vec![
        ("as it is", s.clone()),
        ("with LF", each(&|b| lines_end_with(b, b"\n"))),
        ("with CRLF", each(&|b| lines_end_with(b, b"\r\n"))),
        ("without a last line ending", each(&|b| unended(b).to_vec())),
        ("with a last line ending", each(&|b| [unended(b), ending].concat())),
        ("with a byte order mark", each(&|b| [b"\xEF\xBB\xBF", b].concat())),
    ];
    if let Some(comment) = comment(s.format.name(), &path) {
        variants.push(("with a Latin-1 comment", each(&|b| [unended(b), ending, comment, ending].concat())));
    }
    variants
}
