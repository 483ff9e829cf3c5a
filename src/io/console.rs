//! Words for standard error: a stream that cannot be written stops nothing, and what comes from outside commands no terminal.
//!
//! The macros `eprint!` and `eprintln!` of this crate stand in for those of the standard library, which panic where standard
//! error is full or closed, after a program may have been written.

use super::name::printable;
use std::fmt::Arguments;
use std::io::Write;

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
    ($($arg:tt)*) => { $crate::io::console::say(format_args!($($arg)*), true) };
}

/// As [`eprintln!`], without the end of the line.
macro_rules! eprint {
    ($($arg:tt)*) => { $crate::io::console::say(format_args!($($arg)*), false) };
}
