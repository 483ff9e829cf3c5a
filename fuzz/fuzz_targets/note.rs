//! Notes beside rewritten programs: a text that is taken for one is one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::rewrite::original::unpack;
use lostmotion::rewrite::guard::parse_note;

fuzz_target!(|data: &[u8]| {
    if let Some(note) = parse_note(data) {
        assert_eq!(note.sha256_out.len(), 64);
        let _ = note.original.map(|text| unpack("note", &text));
    }
});
