//! Robot files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::robot::Robot;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(robot) = Robot::parse("robot.yaml", text) {
        let p = robot.tcp_m(&vec![0.0; robot.dof()]);
        assert!(p.iter().all(|v| v.is_finite()), "a robot that stands nowhere");
    }
});
