//! Sections of a program, `/PROG` to `/END`, and what the header says of it: how many lines it has, whether it tracks a conveyor.

use crate::error::Result;
use crate::script::Text;
use crate::script::cursor::unmarked;
use std::ops::Range;

/// Lines of the sections that matter.
pub(super) struct Sections {
    pub attributes: Range<usize>,
    pub program: Range<usize>,
    pub positions: Range<usize>,
    /// First byte after the positions.
    pub end: usize,
}

/// The sections of a program, each once, up to `/END`.
///
/// `program = "/PROG" ... ["/ATTR" ...] ["/APPL" ...] "/MN" {line} ["/POS" {position}] "/END"`
pub(super) fn sections(text: &Text) -> Result<Sections> {
    let mut found: Vec<(String, usize)> = Vec::new();
    for k in 0..text.line_count() {
        let line = unmarked(text.line(k)).trim_ascii_start();
        if let [b'/', rest @ ..] = line
            && rest.first().is_some_and(u8::is_ascii_alphabetic)
        {
            let name = rest.iter().take_while(|b| b.is_ascii_alphanumeric()).map(|b| b.to_ascii_uppercase() as char);
            let name: String = name.collect();
            // some controllers write /APPL twice; nothing in it matters here
            if name != "APPL" && found.iter().any(|(n, _)| *n == name) {
                return Err(text.bad(text.line_span(k).start, format!("a second /{name}"), "each section once"));
            }
            let last = name == "END";
            found.push((name, k));
            if last {
                break;
            }
        }
    }
    let missing = |name: &str| {
        text.bad(text.bytes.len(), format!("no /{name}"), "the sections /PROG, /ATTR, /MN, /POS and /END in this order")
    };
    if found.first().is_none_or(|(n, _)| n != "PROG") {
        return Err(text.bad(0, "no /PROG at the start", "a FANUC TP program (.LS): /PROG, /ATTR, /MN, /POS, /END"));
    }
    let of = |name: &str| {
        let i = found.iter().position(|(n, _)| n == name)?;
        Some(found[i].1 + 1..found.get(i + 1).map_or(text.line_count(), |f| f.1))
    };
    let end = of("END").ok_or_else(|| missing("END"))?.start - 1;
    let program = of("MN").ok_or_else(|| missing("MN"))?;
    let positions = of("POS").unwrap_or(end..end);
    if positions.start < program.start {
        return Err(text.bad(text.line_span(positions.start).start, "/POS before /MN", "/MN before /POS"));
    }
    Ok(Sections {
        attributes: of("ATTR").unwrap_or(0..0),
        program,
        end: text.line_span(positions.end).start,
        positions,
    })
}

/// The attribute that counts the lines: by its name, else the only one with the last line's number.
///
/// `attribute = name "=" number [";"]`
pub(super) fn line_count(text: &Text, lines: Range<usize>, last: Option<u64>) -> Option<(Range<usize>, u64)> {
    let mut same = Vec::new();
    for k in lines {
        let bytes = text.line(k);
        let Some(sign) = memchr::memchr(b'=', bytes) else { continue };
        let value = &bytes[sign + 1..];
        let digits = value.trim_ascii();
        let digits = digits.strip_suffix(b";").unwrap_or(digits).trim_ascii_end();
        let Some(number) = std::str::from_utf8(digits).ok().and_then(|d| d.parse::<u32>().ok()) else { continue };
        let start = text.line_span(k).start + sign + 1 + (value.len() - value.trim_ascii_start().len());
        let found = (start..start + digits.len(), u64::from(number));
        let name = bytes[..sign].trim_ascii().to_ascii_uppercase();
        if name == b"LINE_COUNT" || name.starts_with(b"ZEILEN") {
            return Some(found);
        }
        if Some(found.1) == last {
            same.push(found);
        }
    }
    if same.len() == 1 { same.pop() } else { None }
}

/// Whether the header (`/APPL`) gives a schedule of line tracking: `LINE_TRACK_SCHEDULE_NUMBER : 1;`; 0 is none.
///
/// `tracking = "LINE_TRACK_SCHEDULE_NUMBER" (":" | "=") number [";"]`
pub(super) fn tracks(text: &Text, lines: Range<usize>) -> bool {
    lines.map(|k| text.line(k).trim_ascii().to_ascii_uppercase()).any(|line| {
        let value = line.strip_prefix(b"LINE_TRACK_SCHEDULE_NUMBER").map(|v| v.trim_ascii_start());
        let value = value.and_then(|v| v.strip_prefix(b":").or(v.strip_prefix(b"="))).map(<[u8]>::trim_ascii);
        let value = value.map(|v| v.strip_suffix(b";").unwrap_or(v).trim_ascii_end());
        value.is_some_and(|v| v.is_empty() || v.iter().any(|b| *b != b'0'))
    })
}
