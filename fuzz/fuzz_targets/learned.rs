//! Files of learned kinematics: what is read predicts a place.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::learn::Learned;
use lostmotion::robot::Robot;
use lostmotion_fuzz::robot;
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(include_str!("../../configs/micro-iges-4dof.yaml")));

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data)
        && let Ok(learned) = Learned::parse("kinematics.yaml", text, &ROBOT)
    {
        let _ = learned.position_m(&vec![0.0; ROBOT.dof()]);
    }
});
