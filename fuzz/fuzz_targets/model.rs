//! Model files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::model::Model;
use lostmotion_fuzz::{KUKA, robot};

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = Model::parse("model.yaml", text, &|_| Ok(robot(KUKA)));
    }
});
