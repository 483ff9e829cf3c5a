//! Column maps.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::log::ColumnMap;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = ColumnMap::parse("map.yaml", text);
    }
});
