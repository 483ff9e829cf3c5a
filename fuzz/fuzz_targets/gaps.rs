//! Documents of `identify`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::gaps::Gaps;
use lostmotion::robot::Robot;
use lostmotion_fuzz::{KUKA, robot};
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(KUKA));

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = Gaps::parse("gaps.yaml", text, &ROBOT);
    }
});
