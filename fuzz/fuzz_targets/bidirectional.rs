//! Readings of positions reached from both sides.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::assess::bidirectional::readings::Readings;
use lostmotion::io::input::from_bytes;

fuzz_target!(|data: &[u8]| {
    if let Ok(input) = from_bytes("readings.csv".into(), data.to_vec()) {
        let _ = Readings::parse(input, None, None);
    }
});
