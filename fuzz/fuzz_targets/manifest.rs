//! Manifests: no entry leads out of the folder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::rewrite::manifest::{below, parse};

fuzz_target!(|data: &[u8]| {
    if let Ok(entries) = parse("manifest.jsonl", data, &|_| true) {
        assert!(entries.iter().all(|e| below(&e.key).is_some()), "a path out of the folder");
    }
});
