//! Frames and tools: a file of ours, or one of a controller.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::robot::frames::Frames;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = Frames::parse("frames.yaml", text);
    }
});
