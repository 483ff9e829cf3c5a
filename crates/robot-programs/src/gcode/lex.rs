//! A line to words: letter and number, with or without spaces; comments, expressions and the words of flow control are
//! recognised and not evaluated.

use crate::error::{Error, Result};
use crate::script::Text;
use crate::script::number::{self, Style};
use std::ops::Range;

/// A letter and what follows it. Small, as a block has several.
#[derive(Debug, Clone)]
pub(super) struct Word {
    /// `None`: an expression, a variable or a text.
    pub value: Option<(f64, Style)>,
    /// First byte of the letter, first byte of the number, byte after it.
    from: u32,
    number: u32,
    to: u32,
    /// Upper case.
    pub letter: u8,
}

impl Word {
    /// Letter and number.
    pub fn span(&self) -> Range<usize> {
        self.from as usize..self.to as usize
    }

    /// Number alone.
    pub fn number(&self) -> Range<usize> {
        self.number as usize..self.to as usize
    }
}

/// A line.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    pub words: Vec<Word>,
    pub comments: Vec<Range<usize>>,
    /// `/` in front: an operator may switch the block off.
    pub optional: bool,
    pub percent: bool,
    /// `O` word: what stands after it, upper case.
    pub flow: Option<String>,
    /// The `O` word's number without leading zeros, or its name, lower case.
    pub label: String,
    /// `IF`, `GOTO`, `WHILE`, ...: several letters; the rest of the line is not read.
    pub keyword: Option<String>,
    /// `#1=...`.
    pub assignment: bool,
    /// The value of an expression was put in its place.
    pub folded: bool,
    /// `,C2` or `*71`: chamfers, checksums.
    pub special: Option<&'static str>,
}

/// Words of a block for which memory is reserved at once.
const ROOM: usize = 8;
/// What some editors put before UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads line `k` (from 0).
///
/// # Errors
/// Bad input where a byte begins no word, a word has no number, or a comment has no end.
///
/// `block = ["/" [digit]] ["N" number] {word | comment | "," word} [text]`,
/// `comment = "(" {any} ")" | ";" {any}`
pub(super) fn block(text: &Text, k: usize) -> Result<Block> {
    let (base, line) = (text.line_span(k).start, text.line(k));
    let mut block = Block { words: Vec::with_capacity(ROOM), ..Block::default() };
    let mut at = if k == 0 && line.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    while let Some(&b) = line.get(at) {
        match b {
            b' ' | b'\t' | b'\r' | 0x0c | 0x1a | 0 => at += 1,
            b'%' if block.words.is_empty() => return Ok(Block { percent: true, ..block }),
            b'(' => match line[at..].iter().position(|&b| b == b')') {
                Some(len) => {
                    block.comments.push(base + at..base + at + len + 1);
                    at += len + 1;
                }
                None if block.words.last().is_some_and(is_message) => return Ok(block),
                None => return Err(text.bad(base + at, "a comment without its end", "`)`")),
            },
            b';' => {
                block.comments.push(base + at..base + line.len());
                at = line.len();
            }
            b'/' if block.words.iter().all(|w| w.letter == b'N') => {
                block.optional = true;
                at += 1;
                // `/2`: which switch
                at += line[at..].iter().take_while(|b| b.is_ascii_digit()).count();
            }
            b'#' if block.words.iter().all(|w| w.letter == b'N') => return Ok(Block { assignment: true, ..block }),
            b'*' => return Ok(Block { special: Some("a checksum"), ..block }),
            b',' => {
                block.special = Some("a chamfer or corner");
                at += 1;
            }
            b'@' | b'^' => {
                block.special = Some("polar coordinates");
                at = word(text, base, line, at, &mut block)?;
            }
            // after an M or S word: which spindle
            b'$' if block.words.iter().any(|w| matches!(w.letter, b'M' | b'S'))
                && line.get(at + 1).is_some_and(u8::is_ascii_digit) =>
            {
                at += 1 + line[at + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
            }
            b'$' => return Ok(Block { keyword: Some("$".into()), ..block }),
            b'O' | b'o' if block.words.iter().all(|w| w.letter == b'N') => {
                at = flow(text, base, line, at, &mut block)?;
            }
            _ if b.is_ascii_alphabetic() => {
                block.keyword = keyword(&line[at..]);
                if block.keyword.is_some() {
                    return Ok(block);
                }
                at = word(text, base, line, at, &mut block)?;
            }
            _ if block.words.last().is_some_and(is_message) => at = line.len(),
            _ => return Err(no_word(text, base, line, at)),
        }
    }
    Ok(block)
}

fn no_word(text: &Text, base: usize, line: &[u8], at: usize) -> Error {
    let found = format!("`{}`", String::from_utf8_lossy(&line[at..(at + 12).min(line.len())]));
    text.bad(base + at, found, "a word: a letter and a number")
}

/// An `O` word; returns where reading goes on.
///
/// `flow = "O" (number | "<" name ">" | "#" ... | "[" ... "]") [keyword ...]`
fn flow(text: &Text, base: usize, line: &[u8], at: usize, block: &mut Block) -> Result<usize> {
    let rest = &line[at + 1..];
    let blank = rest.iter().take_while(|b| **b == b' ').count();
    let name = match rest.get(blank) {
        Some(b'<') => rest.iter().position(|&b| b == b'>').map(|k| k + 1),
        Some(b'#' | b'[') => Some(rest.len()),
        _ => Some(blank + rest[blank..].iter().take_while(|b| b.is_ascii_digit()).count()).filter(|&n| n > blank),
    };
    let Some(len) = name else {
        let found = String::from_utf8_lossy(line.get(at..).unwrap_or_default()).chars().take(12).collect::<String>();
        return Err(text.bad(base + at, format!("`{found}`"), "a number or `<name>` after `O`"));
    };
    let after = rest[len..].trim_ascii_start();
    let letters = after.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    let word = String::from_utf8_lossy(&after[..letters]).to_ascii_uppercase();
    let single = letters <= 1;
    block.label = String::from_utf8_lossy(rest[..len].trim_ascii()).trim_start_matches('0').to_ascii_lowercase();
    block.flow = Some(if single { String::new() } else { word });
    // `O1000 (TITLE)` goes on after the number; `o100 call [1]` does not
    Ok(if single { at + 1 + len } else { line.len() })
}

/// More letters than one: a word of a language.
///
/// `keyword = letter letter {letter}`
fn keyword(line: &[u8]) -> Option<String> {
    let letters = line.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    (letters > 1).then(|| String::from_utf8_lossy(&line[..letters]).to_ascii_uppercase())
}

/// After the bracket that closes the one at `k`.
///
/// `expression = "[" {any | expression} "]"`
pub(super) fn expression_end(line: &[u8], mut k: usize) -> Option<usize> {
    let mut depth = 0i32;
    loop {
        match line.get(k)? {
            b'[' => depth += 1,
            b']' => depth -= 1,
            _ => {}
        }
        k += 1;
        if depth == 0 {
            return Some(k);
        }
    }
}

/// A variable, `-#1`, `#<name>`, `-[...]`: to the end of what belongs to it.
///
/// `variable = {"+" | "-" | "#" | digit | "_" | "." | "[" {any} "]" | "<" {any} ">"}`
fn variable_end(line: &[u8], mut k: usize) -> usize {
    let mut depth = 0i32;
    while let Some(&b) = line.get(k) {
        match b {
            b'[' | b'<' => depth += 1,
            b']' | b'>' => depth -= 1,
            b'#' | b'+' | b'-' | b'0'..=b'9' | b'_' | b'.' => {}
            _ if depth > 0 => {}
            _ => break,
        }
        k += 1;
    }
    k
}

/// Letters of a function's name before its bracket, more than one.
///
/// `function = letter letter {letter} "["`
fn function(line: &[u8]) -> Option<usize> {
    let letters = line.iter().take_while(|b| b.is_ascii_alphabetic()).count();
    (letters > 1 && line.get(letters) == Some(&b'[')).then_some(letters)
}

/// A letter and what follows; returns where reading goes on.
///
/// `word = letter {blank} (number | expression | variable | function expression | text | "=" {any})`,
/// `number = ["+" | "-"] {digit | "."}`
fn word(text: &Text, base: usize, line: &[u8], at: usize, block: &mut Block) -> Result<usize> {
    let mut k = at + 1;
    while matches!(line.get(k), Some(b' ' | b'\t')) {
        k += 1;
    }
    let from = k;
    let bad = |found: &[u8]| {
        let found = String::from_utf8_lossy(found.get(..12).unwrap_or(found)).into_owned();
        text.bad(base + at, format!("`{found}`"), format!("a number after `{}`", line[at] as char))
    };
    let mut value = None;
    match line.get(k) {
        Some(b'[') => k = expression_end(line, k).ok_or_else(|| bad(&line[at..]))?,
        Some(b'#' | b'-' | b'+')
            if line[k..].iter().find(|b| !b"+-".contains(b)).is_some_and(|b| b"#[".contains(b)) =>
        {
            k = variable_end(line, k);
        }
        Some(b'"') => {
            let Some(len) = line[k + 1..].iter().position(|&b| b == b'"') else { return Err(bad(&line[at..])) };
            k += len + 2;
        }
        // a function: `X EXISTS[#1]`
        Some(b) if b.is_ascii_alphabetic() && function(&line[k..]).is_some() => {
            let letters = function(&line[k..]).unwrap_or_default();
            k = expression_end(line, k + letters).ok_or_else(|| bad(&line[at..]))?;
        }
        Some(b'=') => k += line[k..].iter().take_while(|b| !b.is_ascii_whitespace()).count(),
        _ => {
            k += usize::from(matches!(line.get(k), Some(b'+' | b'-')));
            k += line[k..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
            value = number::read(&line[from..k]);
            if value.is_none() {
                k = match line.get(from).copied() {
                    // `G28 X Y`: axes to be homed
                    next if next.is_none_or(|b| b.is_ascii_alphabetic() || b";(\r".contains(&b)) && flags(block) => {
                        at + 1
                    }
                    // `M115 U3.8.1`, `M104 S{temperature}`
                    Some(_) if block.words.iter().any(is_firmware) => {
                        let rest = &line[from..];
                        from + rest.iter().position(|&b| b.is_ascii_whitespace() || b == b';').unwrap_or(rest.len())
                    }
                    _ => return Err(bad(&line[at..])),
                };
            }
        }
    }
    let from = from.min(k);
    block.words.push(Word {
        letter: line[at].to_ascii_uppercase(),
        value,
        from: (base + at) as u32,
        number: (base + from) as u32,
        to: (base + k) as u32,
    });
    Ok(k)
}

/// An M word of printer firmware, whose words are its own.
pub(super) fn is_firmware(w: &Word) -> bool {
    w.letter == b'M' && w.value.is_some_and(|v| matches!(v.0, 17.0 | 18.0 | 84.0 | 92.0) || v.0 >= 100.0)
}

/// `M117 Layer 1 (of 5)`.
pub(super) fn is_message(w: &Word) -> bool {
    w.letter == b'M' && w.value.is_some_and(|v| matches!(v.0, 117.0 | 118.0))
}

/// M words after which a text for the operator may stand.
pub(super) fn takes_text(w: &Word) -> bool {
    is_message(w) || w.letter == b'M' && w.value.is_some_and(|v| matches!(v.0, 0.0 | 1.0 | 486.0))
}

/// Whether letters without a number may stand in a block: homing and firmware words name axes by them.
fn flags(block: &Block) -> bool {
    let homing = |w: &Word| w.letter == b'G' && w.value.is_some_and(|v| matches!(v.0, 28.0 | 29.0 | 161.0 | 162.0));
    block.words.iter().any(|w| is_firmware(w) || homing(w))
}
