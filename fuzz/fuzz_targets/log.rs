//! Measurement logs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::input::from_bytes;
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use lostmotion_fuzz::{KUKA, robot};
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(KUKA));

fuzz_target!(|data: &[u8]| {
    if let Ok(input) = from_bytes("log.csv".into(), data.to_vec()) {
        let _ = Log::parse(input, &ROBOT);
    }
});
