//! A line to words: letter and number, with or without spaces; comments, expressions and the words of flow control are
//! recognised and not evaluated.

use super::across::Across;
use super::codes::AXES;
use super::reason::Reason;
use crate::error::Result;
use crate::script::Text;
use crate::script::cursor::Cursor;
use crate::script::lex::text_of;
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
    pub special: Option<Reason>,
    /// `DIAMON`.
    pub across: Option<Across>,
}

/// Words of a block for which memory is reserved at once.
const ROOM: usize = 8;

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
    let mut cursor = Cursor::of_line(text, k);
    // nothing but the number of the line so far
    let mut first = true;
    while let Some(b) = cursor.peek() {
        let at = cursor.at();
        first &= block.words.last().is_none_or(|w| w.letter == b'N');
        match b {
            b' ' | b'\t' | b'\r' | 0x0c | 0x1a | 0 => cursor.skip(1),
            b'%' if block.words.is_empty() => return Ok(Block { percent: true, ..block }),
            b'(' if cursor.past(b")") => block.comments.push(base + at..base + cursor.at()),
            b'(' if block.words.last().is_some_and(is_message) => return Ok(block),
            b'(' => return Err(text.bad(base + at, "a comment without its end", "`)`")),
            b';' => {
                cursor.end();
                block.comments.push(base + at..base + line.len());
            }
            b'/' if first => {
                block.optional = true;
                cursor.skip(1);
                // `/2`: which switch
                cursor.digits();
            }
            b'#' if first => return Ok(Block { assignment: true, ..block }),
            b'*' => return Ok(Block { special: Some(Reason::Checksum), ..block }),
            b',' => {
                block.special = Some(Reason::Corner);
                cursor.skip(1);
            }
            b'@' | b'^' => {
                block.special = Some(Reason::Polar);
                word(text, base, &mut cursor, &mut block)?;
            }
            // after an M or S word: which spindle
            b'$' if block.words.iter().any(|w| matches!(w.letter, b'M' | b'S'))
                && cursor.second().is_some_and(|b| b.is_ascii_digit()) =>
            {
                cursor.skip(1);
                cursor.digits();
            }
            b'$' => return Ok(Block { keyword: Some("$".into()), ..block }),
            // `:0100`: the number of a program in ISO code
            b':' if first && cursor.second().is_some_and(|b| b.is_ascii_digit()) => {
                flow(text, base, &mut cursor, &mut block)?;
            }
            b'O' | b'o' if first => flow(text, base, &mut cursor, &mut block)?,
            _ if across(&mut cursor, &mut block) => {}
            _ if b.is_ascii_alphabetic() => {
                block.keyword = keyword(cursor.rest());
                if block.keyword.is_some() {
                    return Ok(block);
                }
                word(text, base, &mut cursor, &mut block)?;
            }
            _ if block.words.last().is_some_and(is_message) => cursor.end(),
            _ => return Err(text.bad(base + at, shown(cursor.rest()), "a word: a letter and a number")),
        }
    }
    Ok(block)
}

/// Passes `DIAMON` and its like; `false`: none stands there.
fn across(cursor: &mut Cursor, block: &mut Block) -> bool {
    let Some((across, length)) = Across::of_word(cursor.rest()) else { return false };
    block.across = Some(across);
    cursor.skip(length);
    true
}

/// The first bytes of what cannot be read.
fn shown(found: &[u8]) -> String {
    format!("`{}`", String::from_utf8_lossy(found.get(..12).unwrap_or(found)))
}

/// An `O` word.
///
/// `flow = ":" number | "O" (number | "<" name ">" | "#" ... | "[" ... "]") [keyword ...]`
fn flow(text: &Text, base: usize, cursor: &mut Cursor, block: &mut Block) -> Result<()> {
    let (at, whole) = (cursor.at(), cursor.rest());
    cursor.skip(1);
    let from = cursor.at();
    cursor.while_is(|b| b == b' ');
    let named = match cursor.peek() {
        Some(b'<') => cursor.past(b">"),
        Some(b'#' | b'[') => {
            cursor.end();
            true
        }
        _ => !cursor.digits().is_empty(),
    };
    if !named {
        let found = String::from_utf8_lossy(whole).chars().take(12).collect::<String>();
        return Err(text.bad(base + at, format!("`{found}`"), "a number or `<name>` after `O`"));
    }
    let label = cursor.since(from).trim_ascii();
    block.label = text_of(label).trim_start_matches('0').to_ascii_lowercase();
    let word = keyword(cursor.rest().trim_ascii_start());
    // `O1000 (TITLE)` goes on after the number; `o100 call [1]` does not
    if word.is_some() {
        cursor.end();
    }
    block.flow = Some(word.unwrap_or_default());
    Ok(())
}

/// More letters than one: a word of a language.
///
/// `keyword = letter letter {letter}`
fn keyword(line: &[u8]) -> Option<String> {
    let letters = Cursor::new(line).letters();
    (letters.len() > 1).then(|| String::from_utf8_lossy(letters).to_ascii_uppercase())
}

/// After the bracket that closes the one with which a text begins.
///
/// `expression = "[" {any | expression} "]"`
pub(super) fn expression_end(text: &[u8]) -> Option<usize> {
    let mut depth = 0i32;
    let closes = |b: &u8| {
        depth += i32::from(*b == b'[') - i32::from(*b == b']');
        depth == 0
    };
    Some(text.iter().position(closes)? + 1)
}

/// Passes a variable, `-#1`, `#<name>`, `-[...]`: to the end of what belongs to it.
///
/// `variable = {"+" | "-" | "#" | digit | "_" | "." | "[" {any} "]" | "<" {any} ">"}`
fn variable(cursor: &mut Cursor) {
    let mut depth = 0i32;
    cursor.while_is(|b| {
        match b {
            b'[' | b'<' => depth += 1,
            b']' | b'>' => depth -= 1,
            _ => return depth > 0 || matches!(b, b'#' | b'+' | b'-' | b'0'..=b'9' | b'_' | b'.'),
        }
        true
    });
}

/// Passes an expression in brackets; `false`: it has no end.
fn expression(cursor: &mut Cursor) -> bool {
    let end = expression_end(cursor.rest());
    cursor.skip(end.unwrap_or_default());
    end.is_some()
}

/// Passes a number; stays where there is none.
///
/// `number = ["+" | "-"] {digit | "."}`
fn plain(cursor: &mut Cursor) -> Option<(f64, Style)> {
    let from = cursor.at();
    let _ = cursor.eat(b'+') || cursor.eat(b'-');
    cursor.while_is(|b| b.is_ascii_digit() || b == b'.');
    let value = number::read(cursor.since(from));
    if value.is_none() {
        cursor.go_to(from);
    }
    value
}

/// Passes what a word may have instead of a number after the letter at `at`; `false`: a number is missing.
///
/// `rest = (letter | ";" | "(" | end) | {any}`
fn stands_alone(cursor: &mut Cursor, at: usize, block: &Block) -> bool {
    // `G28 X Y`: axes to be homed
    if cursor.peek().is_none_or(|b| b.is_ascii_alphabetic() || b";(\r".contains(&b)) && flags(block) {
        cursor.go_to(at + 1);
        return true;
    }
    // `M115 U3.8.1`, `M104 S{temperature}`
    let own = cursor.peek().is_some() && block.words.iter().any(is_firmware);
    if own {
        cursor.while_is(|b| !b.is_ascii_whitespace() && b != b';');
    }
    own
}

/// A letter and what follows.
///
/// `word = letter {blank} (number | expression | variable | function expression | text | "=" {any})`,
/// `function = letter letter {letter}`
fn word(text: &Text, base: usize, cursor: &mut Cursor, block: &mut Block) -> Result<()> {
    let (at, whole) = (cursor.at(), cursor.rest());
    let letter = cursor.peek().unwrap_or_default();
    cursor.skip(1);
    cursor.while_is(|b| matches!(b, b' ' | b'\t'));
    let (from, rest) = (cursor.at(), cursor.rest());
    let function = |rest| Some(Cursor::new(rest).letters().len()).filter(|n| *n > 1 && rest.get(*n) == Some(&b'['));
    let mut value = None;
    let ended = match cursor.peek() {
        Some(b'[') => expression(cursor),
        Some(b'#' | b'-' | b'+') if rest.iter().find(|b| !b"+-".contains(b)).is_some_and(|b| b"#[".contains(b)) => {
            variable(cursor);
            true
        }
        Some(b'"') => {
            cursor.skip(1);
            cursor.past(b"\"")
        }
        // `X EXISTS[#1]`
        Some(_) if function(rest).is_some() => {
            cursor.letters();
            expression(cursor)
        }
        Some(b'=') => {
            cursor.while_is(|b| !b.is_ascii_whitespace());
            true
        }
        _ => {
            value = plain(cursor);
            value.is_some() || stands_alone(cursor, at, block)
        }
    };
    if !ended {
        return Err(text.bad(base + at, shown(whole), format!("a number after `{}`", letter as char)));
    }
    block.words.push(Word {
        letter: letter.to_ascii_uppercase(),
        value,
        from: (base + at) as u32,
        number: (base + from.min(cursor.at())) as u32,
        to: (base + cursor.at()) as u32,
    });
    Ok(())
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

/// Whether words of a block bear one of these letters.
pub(super) fn names(block: &Block, letters: &[u8]) -> bool {
    block.words.iter().any(|w| letters.contains(&w.letter))
}

/// Whether words name axes.
pub(super) fn has_axes(block: &Block) -> bool {
    block.words.iter().any(|w| AXES.contains(&w.letter))
}
