//! URDF files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::robot::urdf;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = urdf::read("arm.urdf", text, None);
    }
});
