//! What the fuzz targets share: robots, and what must hold of every input.

use lostmotion::compensator::{BacklashOffset, Compensator, Evidence, JointCompensator};
use lostmotion::effects::GapCurve;
use lostmotion::rewrite::Options;
use lostmotion::rewrite::script::{Choices, Task, rewrite};
use lostmotion::robot::Robot;
use robot_programs::script::{Format, Text};

/// The robot of a configuration, whose text is part of the target.
pub fn robot(text: &str) -> Robot {
    Robot::parse("robot.yaml", text).expect("a robot file of the repository")
}

pub const KUKA: &str = include_str!("../../configs/kuka-kr120-r2500-pro.yaml");
pub const ABB: &str = include_str!("../../configs/abb-irb1600-6-145.yaml");
pub const FANUC: &str = include_str!("../../configs/fanuc-m10ia.yaml");
pub const MOTOMAN: &str = include_str!("../../configs/motoman-ma2010.yaml");
pub const UR: &str = include_str!("../../configs/universal-robots-ur10.yaml");
pub const GANTRY: &str = include_str!("../../configs/gantry-xyz-ballscrew.yaml");

/// The same half gap on every axis: 0.02 deg or mm, times `scale`.
pub fn compensator(robot: &Robot, scale: f64) -> Compensator {
    let joints = robot.axis_joints().enumerate().map(|(axis, joint)| {
        let gap = GapCurve::Constant(0.02 * scale * joint.kind.si_per_user_unit());
        JointCompensator { axis, backlash: Some(BacklashOffset { positive: gap.clone(), negative: gap }), friction: None }
    });
    Compensator {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        joints: joints.collect(),
        evidence: Evidence::default(),
    }
}

/// Reads a program and rewrites it. A zero compensator must give the same bytes; with gaps the result must read as it was meant, which
/// `rewrite` checks itself: its refusal names a fault, and that is one.
pub fn rewrite_and_check(format: &dyn Format, robot: &Robot, bytes: &[u8]) {
    let texts = || vec![Text::new("program", bytes.to_vec())];
    for scale in [0.0, 1.0] {
        let compensator = compensator(robot, scale);
        let options = Options::new(robot.dof());
        let none = vec![None; robot.dof()];
        let digit: Vec<f64> = robot.axis_joints().map(|j| 1e-3 * j.kind.si_per_user_unit()).collect();
        let task = Task {
            robot,
            compensator: &compensator,
            options: &options,
            choices: &Choices::default(),
            deadband: &none,
            digit: &digit,
            pose_digit: [1e-7, 1.75e-6],
            listed: 10,
        };
        match rewrite(format, texts(), &task) {
            Ok(done) if scale == 0.0 => assert!(done.unchanged(), "a zero compensator changes bytes"),
            Ok(_) => {}
            Err(e) => assert!(!e.to_string().contains("This is a fault"), "{e}"),
        }
    }
}
