//! File names: every name comes back from its text, which commands no terminal.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::name::{path_of, text_of};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let path = Path::new(OsStr::from_bytes(data));
    let text = text_of(path);
    assert!(!text.chars().any(robot_programs::error::is_obeyed));
    assert_eq!(path_of(&text).as_deref(), Some(path));
});
