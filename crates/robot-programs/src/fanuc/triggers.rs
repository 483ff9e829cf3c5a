//! What a motion runs near its end: `TB .10sec,CALL GRIP`, `TA .20sec,DO[1]=ON`, `DB 50.0mm,P-SPS`.
//!
//! TB runs it a time before the motion ends, TA a time after, DB within a distance of the goal. FANUC's manuals call a program that runs
//! so one without a motion group; what it sets holds after the motion all the same, as after a call on a separate line.

use crate::script::{Speed, Text};
use std::ops::Range;

/// An instruction that a motion runs near its end.
#[derive(Debug, Clone)]
pub(super) struct Action {
    /// Its words, as those of a statement.
    pub words: Vec<Range<usize>>,
    /// It runs after the motion has ended.
    pub after: bool,
}

/// How far before the end of a motion something starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Start {
    /// s.
    Time(f64),
    /// m.
    Distance(f64),
    Unknown,
}

impl Start {
    /// The way of the TCP that is left then at most, m, by the speed of the motion; `None`: not certain.
    pub fn way_m(self, speed: Speed) -> Option<f64> {
        match (self, speed) {
            (Self::Distance(m), _) => Some(m),
            (Self::Time(s), Speed::Tcp(v)) => Some(s * v),
            _ => None,
        }
    }
}

/// What a motion runs near its end, and how far before its end; what starts at its end or later is not among the latter.
#[derive(Debug, Default)]
pub(super) struct Triggers {
    pub actions: Vec<Action>,
    pub starts: Vec<Start>,
}

/// Words that are read one after the other.
struct Words<'a> {
    text: &'a Text,
    words: &'a [Range<usize>],
    next: usize,
}

impl<'a> Words<'a> {
    fn upper(&self, ahead: usize) -> Vec<u8> {
        self.words.get(self.next + ahead).map(|w| self.text.slice(w.clone()).to_ascii_uppercase()).unwrap_or_default()
    }

    fn take(&mut self) -> Option<Range<usize>> {
        let word = self.words.get(self.next).cloned();
        self.next += 1;
        word
    }

    fn bytes(&self, word: &Range<usize>) -> &'a [u8] {
        self.text.slice(word.clone())
    }

    /// The part of the next word in which the time or the distance of a trigger stands; `None`: no trigger begins here. Says whether it is
    /// after the end.
    ///
    /// `trigger = "TA" | "TB" | "DB" | "ZEIT" ("VOR" | "NACH") | "WEG" "VOR"`
    fn trigger(&mut self) -> Option<(Range<usize>, bool)> {
        let (word, second) = (self.upper(0), self.upper(1));
        let joined = || word.get(2).is_some_and(|b| b.is_ascii_digit() || *b == b'.');
        let (heads, after) = match (word.as_slice(), second.as_slice()) {
            (b"TB" | b"DB", _) => (1, false),
            (b"TA", _) => (1, true),
            (b"ZEIT" | b"WEG", b"VOR") => (2, false),
            (b"ZEIT", b"NACH") => (2, true),
            ([b'T', b'B', ..] | [b'D', b'B', ..], _) if joined() => (0, false),
            ([b'T', b'A', ..], _) if joined() => (0, true),
            _ => return None,
        };
        self.next += heads;
        let value = self.take()?;
        Some((value.start + if heads == 0 { 2 } else { 0 }..value.end, after))
    }

    /// What stands after the comma that follows a time or a distance.
    ///
    /// `action = "," instruction`
    fn action(&mut self, value: &Range<usize>) -> Vec<Range<usize>> {
        let after = |word: &Range<usize>, bytes: &[u8]| {
            let comma = memchr::memchr(b',', bytes)?;
            Some(word.start + comma + 1..word.end)
        };
        let mut first = after(value, self.bytes(value));
        if first.is_none() && self.upper(0).starts_with(b",") {
            first = self.take().and_then(|word| after(&word, self.bytes(&word)));
        }
        match first {
            Some(first) if first.is_empty() => self.take().map_or_else(Vec::new, |first| self.instruction(first)),
            Some(first) => self.instruction(first),
            None => Vec::new(),
        }
    }

    /// The words of an instruction that begins with one.
    ///
    /// `instruction = ("CALL" | "AUFRUF") name ["(" arguments ")"] | word ["[" ...] | word word`
    fn instruction(&mut self, first: Range<usize>) -> Vec<Range<usize>> {
        let bytes = self.bytes(&first);
        let (call, whole) = (calls(bytes), bytes.iter().any(|b| b"[=(".contains(b)) || point_logic(bytes));
        let mut words = vec![first];
        if !whole {
            words.extend(self.take().filter(|w| w.end > w.start));
        }
        let depth = |depth: usize, word: &Range<usize>| {
            self.bytes(word).iter().fold(depth, |depth, b| match b {
                b'(' => depth + 1,
                b')' => depth.saturating_sub(1),
                _ => depth,
            })
        };
        let (mut open, mut end) = (words.iter().fold(0, depth), self.next);
        while let Some(word) = self.words.get(end).filter(|w| call && (open > 0 || self.bytes(w).starts_with(b"("))) {
            open = depth(open, word);
            words.push(word.clone());
            end += 1;
        }
        self.next = end;
        words
    }
}

fn calls(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"CALL") || word.eq_ignore_ascii_case(b"AUFRUF")
}

/// Point logic: its lines follow the motion.
fn point_logic(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"P-SPS") || word.eq_ignore_ascii_case(b"POINT_LOGIC")
}

/// How far before the end, by what stands before the comma.
///
/// `start = number ("sec" | "sek" | "msec" | "mm")`
fn start(value: &[u8]) -> Start {
    let value = value.split(|b| *b == b',').next().unwrap_or_default();
    let digits = value.iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let (number, unit) = value.split_at(digits);
    let Some(number) = std::str::from_utf8(number).ok().and_then(|n| n.parse::<f64>().ok()) else {
        return Start::Unknown;
    };
    match unit.to_ascii_lowercase().as_slice() {
        b"sec" | b"sek" => Start::Time(number),
        b"msec" => Start::Time(number * 1e-3),
        b"mm" => Start::Distance(number * 1e-3),
        _ if number == 0.0 => Start::Time(0.0),
        _ => Start::Unknown,
    }
}

/// Reads what a motion runs near its end among its words from one on.
///
/// `option = trigger (time | distance) "," instruction | ("CALL" | ... ",CALL") name`
pub(super) fn read(text: &Text, words: &[Range<usize>], from: usize) -> Triggers {
    let mut found = Triggers::default();
    let mut all = Words { text, words, next: from };
    while let Some(word) = words.get(all.next) {
        if let Some((value, after)) = all.trigger() {
            let starts = start(all.bytes(&value));
            if !after && !matches!(starts, Start::Time(s) | Start::Distance(s) if s == 0.0) {
                found.starts.push(starts);
            }
            let words = all.action(&value);
            if words.first().is_some_and(|w| !point_logic(all.bytes(w))) {
                found.actions.push(Action { words, after });
            }
            continue;
        }
        all.next += 1;
        let bytes = all.bytes(word);
        let last = memchr::memrchr(b',', bytes).map_or(0, |comma| comma + 1);
        if calls(bytes.get(last..).unwrap_or_default()) {
            let words = all.instruction(word.start + last..word.end);
            found.actions.push(Action { words, after: true });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fanuc::statement::{Statement, words};

    /// Actions and starts of the options of a motion.
    fn of(options: &str) -> (Vec<(String, bool)>, Vec<Start>) {
        let text = Text::new("p.ls", options.as_bytes().to_vec());
        let whole = std::iter::once(0..options.len()).collect();
        let words = words(&text, &Statement { pieces: whole, ..Statement::default() });
        let found = read(&text, &words, 0);
        let said = |a: &Action| {
            let all: Vec<_> =
                a.words.iter().map(|w| String::from_utf8_lossy(text.slice(w.clone())).into_owned()).collect();
            (all.join(" "), a.after)
        };
        (found.actions.iter().map(said).collect(), found.starts)
    }

    #[test]
    fn what_a_motion_runs_is_read_with_its_time_or_its_distance() {
        let one = |action: &str, after: bool| vec![(action.to_string(), after)];
        let (time, distance) = (|s| vec![Start::Time(s)], |m| vec![Start::Distance(m)]);
        for (options, actions, starts) in [
            ("ACC80 TB .10sec,CALL GRIP Offset,PR[1]", one("CALL GRIP", false), time(0.1)),
            ("TB 0.00sec,CALL GRIP(1, R[2]) ACC80", one("CALL GRIP(1, R[2])", false), vec![]),
            ("TA 1.00sec,CALL R[1]", one("CALL R[1]", true), vec![]),
            ("DB 200mm,DO[1]=ON", one("DO[1]=ON", false), distance(0.2)),
            ("DB 0.0mm,P-SPS RTCP", vec![], vec![]),
            ("TB 2.00sec,P-SPS", vec![], time(2.0)),
            ("ZEIT VOR .10sek,AUFRUF A", one("AUFRUF A", false), time(0.1)),
            ("WEG VOR 5.0mm,A[1]=AN", one("A[1]=AN", false), distance(0.005)),
            ("TB.50sec, CALL A", one("CALL A", false), time(0.5)),
            ("TB R[1]sec,SOFTFLOAT[1]", one("SOFTFLOAT[1]", false), vec![Start::Unknown]),
            ("TB .20sec,SOFTFLOAT END", one("SOFTFLOAT END", false), time(0.2)),
            ("CALL A", one("CALL A", true), vec![]),
            ("ACC80 Skip,LBL[1]", vec![], vec![]),
            ("TB", vec![], vec![]),
        ] {
            assert_eq!(of(options), (actions, starts), "{options}");
        }
    }
}
