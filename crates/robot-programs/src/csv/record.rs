//! One row, cell by cell, with everything that CSV allows: quotes, doubled quotes, line breaks in quotes, spaces.

/// Cells of a row and where it ends.
#[derive(Debug, Clone, Default)]
pub struct Record {
    /// `[start, end)` of each cell, quotes and spaces included.
    pub cells: Vec<(usize, usize)>,
    /// After the line ending.
    pub end: usize,
    /// Line breaks inside quotes.
    pub breaks: u64,
}

/// How a look at a row came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// The row was read to its end.
    Whole,
    /// The text ends before the row does.
    Cut,
    /// A quote that is never closed, or text after a closing quote; the cell's number.
    Quote(usize),
}

impl Record {
    /// Finds the cells of the row at `start`; `last`: no more text follows.
    ///
    /// `row = cell {"," cell} newline`,
    /// `cell = {blank} '"' {any | '"' '"'} '"' {blank} | {any}`
    pub fn find(&mut self, text: &[u8], start: usize, last: bool) -> Seen {
        self.cells.clear();
        self.breaks = 0;
        let mut at = start;
        loop {
            let begin = at;
            at += text[at..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
            if text.get(at) == Some(&b'"') {
                at += 1;
                loop {
                    let Some(k) = memchr::memchr(b'"', &text[at..]) else {
                        return if last { Seen::Quote(self.cells.len()) } else { Seen::Cut };
                    };
                    self.breaks += memchr::memchr_iter(b'\n', &text[at..at + k]).count() as u64;
                    at += k + 1;
                    match text.get(at) {
                        Some(b'"') => at += 1,
                        None if !last => return Seen::Cut,
                        _ => break,
                    }
                }
                at += text[at..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
                if !matches!(text.get(at), None | Some(b',' | b'\n' | b'\r')) {
                    return Seen::Quote(self.cells.len());
                }
            } else {
                at = memchr::memchr3(b',', b'\n', b'\r', &text[at..]).map_or(text.len(), |k| at + k);
            }
            self.cells.push((begin, at));
            match text.get(at) {
                Some(b',') => at += 1,
                Some(b'\n') => {
                    self.end = at + 1;
                    return Seen::Whole;
                }
                Some(_) => match text.get(at + 1) {
                    None if !last => return Seen::Cut, // a line feed may follow
                    next => {
                        self.end = at + 1 + usize::from(next == Some(&b'\n'));
                        return Seen::Whole;
                    }
                },
                None => {
                    self.end = at;
                    return if last { Seen::Whole } else { Seen::Cut };
                }
            }
        }
    }
}

/// The content of a cell without the spaces and quotes around it.
///
/// `cell = {blank} ['"'] {any} ['"'] {blank}`
pub fn content(text: &[u8], (start, end): (usize, usize)) -> (usize, usize) {
    let trim = |mut s: usize, mut e: usize| {
        while s < e && matches!(text[s], b' ' | b'\t') {
            s += 1;
        }
        while e > s && matches!(text[e - 1], b' ' | b'\t') {
            e -= 1;
        }
        (s, e)
    };
    let (s, e) = trim(start, end);
    if e - s >= 2 && text[s] == b'"' && text[e - 1] == b'"' { trim(s + 1, e - 1) } else { (s, e) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Vec<&str> {
        let mut r = Record::default();
        assert_eq!(r.find(text.as_bytes(), 0, true), Seen::Whole);
        r.cells.iter().map(|&c| content(text.as_bytes(), c)).map(|(s, e)| &text[s..e]).collect()
    }

    #[test]
    fn quotes_hold_commas_and_line_breaks() {
        assert_eq!(cells("1, \"a,b\nc\" ,\"x\"\"y\"\r\nnext"), ["1", "a,b\nc", "x\"\"y"]);
        assert_eq!(cells(",,"), ["", "", ""]);
    }

    #[test]
    fn a_row_that_may_go_on_is_not_taken_for_whole() {
        let mut r = Record::default();
        for text in ["1,2", "1,2\r", "1,\"a", "1,\"a\""] {
            assert_eq!(r.find(text.as_bytes(), 0, false), Seen::Cut, "{text:?}");
        }
        assert_eq!(r.find(b"1,\"a\"b\n", 0, false), Seen::Quote(1));
        assert_eq!(r.find(b"1,\"a", 0, true), Seen::Quote(1));
    }
}
