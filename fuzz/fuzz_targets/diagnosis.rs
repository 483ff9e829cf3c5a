//! Diagnoses, as `plan-experiment` reads them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::plan::question::of_diagnosis;
use lostmotion::plan::sizes::Scale;
use lostmotion::robot::Robot;
use lostmotion_fuzz::{KUKA, robot};
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(KUKA));

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let window = vec![[-1.0, 1.0]; ROBOT.dof()];
        let lost = vec![None; ROBOT.dof()];
        let mut scale = Scale { robot: &ROBOT, window: &window, speed_m_s: 0.25, duration_s: 60.0, lost };
        let _ = of_diagnosis("diagnosis.json", text, &mut scale);
    }
});
