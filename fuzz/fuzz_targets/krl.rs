//! KUKA KRL: reading never panics, and what is rewritten reads as it was meant.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::robot::Robot;
use lostmotion_fuzz::{KUKA, rewrite_and_check, robot};
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(KUKA));

fuzz_target!(|data: &[u8]| {
    rewrite_and_check(&robot_programs::krl::Krl, &ROBOT, data);
});
