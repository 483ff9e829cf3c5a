//! Words for standard error: a stream that cannot be written stops nothing, and what comes from outside commands no terminal.
//!
//! The macros `eprint!` and `eprintln!` of this crate stand in for those of the standard library, which panic where standard
//! error is full or closed, after a program may have been written. They print nothing after [`choose`]`(Words::Errors)`; refusals,
//! which [`say`] writes, are always printed.

use crate::io::name::printable;
use crate::io::notice::Notice;
use std::fmt::Arguments;
use std::io::Write;
use std::sync::atomic::{AtomicU8, Ordering};

/// How much is written to standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Words {
    /// Errors and refusals.
    Errors = 0,
    /// Results in words and notes, too.
    Notes = 1,
    /// What is read and how long it took, too.
    Details = 2,
}

static WORDS: AtomicU8 = AtomicU8::new(Words::Notes as u8);

/// Sets how much is written, for the whole process.
pub fn choose(words: Words) {
    WORDS.store(words as u8, Ordering::Relaxed);
}

fn asked_for(words: Words) -> bool {
    WORDS.load(Ordering::Relaxed) >= words as u8
}

/// Writes a note to standard error, unless only errors are asked for.
pub fn note(text: Arguments, end_of_line: bool) {
    if asked_for(Words::Notes) {
        say(text, end_of_line);
    }
}

/// Writes a line to standard error where details are asked for.
pub fn detail(text: Arguments) {
    if asked_for(Words::Details) {
        say(text, true);
    }
}

/// Prints a notice of the library, as far as the user asked for it.
pub fn print(notice: Notice) {
    if notice.is_detail() {
        detail(format_args!("{notice}"));
    } else if notice.is_headed() {
        note(format_args!("{notice}"), true);
    } else {
        note(format_args!("note: {notice}"), true);
    }
}

/// Whether a progress line may be drawn.
pub fn shows_progress() -> bool {
    use std::io::IsTerminal;
    asked_for(Words::Notes) && std::io::stderr().is_terminal()
}

/// Writes to standard error; a failure is none of the command's.
pub fn say(text: Arguments, end_of_line: bool) {
    let text = text.to_string();
    let mut out = printable(&text).into_owned();
    if end_of_line {
        out.push('\n');
    }
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(out.as_bytes()).and_then(|()| stderr.flush());
}

/// As the macro of the standard library, but it never panics.
macro_rules! eprintln {
    ($($arg:tt)*) => { $crate::cli::console::note(format_args!($($arg)*), true) };
}

/// As [`eprintln!`], without the end of the line.
macro_rules! eprint {
    ($($arg:tt)*) => { $crate::cli::console::note(format_args!($($arg)*), false) };
}
