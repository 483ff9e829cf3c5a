use super::*;
use crate::robot::{Robot, Target};
use proptest::prelude::*;

const ARMS: &[(&str, &str)] = &[
    ("abb", include_str!("../../../configs/abb-irb1600-6-145.yaml")),
    ("fanuc", include_str!("../../../configs/fanuc-m10ia.yaml")),
    ("kuka", include_str!("../../../configs/kuka-kr120-r2500-pro.yaml")),
    ("motoman", include_str!("../../../configs/motoman-ma2010.yaml")),
    ("ur10", include_str!("../../../configs/universal-robots-ur10.yaml")),
];

fn arm(k: usize) -> (Robot, Arm) {
    let robot = Robot::parse(ARMS[k].0, ARMS[k].1).unwrap();
    let arm = Arm::of(&robot).unwrap();
    (robot, arm)
}

/// Every axis within its limits by shares from 0 to 1.
fn within(robot: &Robot, shares: &[f64]) -> Vec<f64> {
    let q = robot.axis_joints().zip(shares);
    q.map(|(j, s)| j.limits.map_or(s * 6.0 - 3.0, |[lo, hi]| lo + s * (hi - lo))).collect()
}

#[test]
fn each_maker_s_arm_has_its_closed_form() {
    for (k, (name, _)) in ARMS.iter().enumerate() {
        let form = arm(k).1.form();
        assert!(
            if *name == "ur10" { matches!(form, Form::Parallel(_)) } else { matches!(form, Form::Spherical(_)) },
            "{name}"
        );
    }
    let gantry = Robot::parse("g", include_str!("../../../configs/gantry-xyz-ballscrew.yaml")).unwrap();
    assert!(Arm::of(&gantry).is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_joints_are_among_the_solutions_of_their_own_pose(k in 0..ARMS.len(), shares in prop::collection::vec(0.0..1.0f64, 6)) {
        let (robot, arm) = arm(k);
        let q = within(&robot, &shares);
        let pose = robot.forward(&q);
        let found = arm.solutions(&robot, &pose, &q);
        let miss = |s: &Vec<f64>| s.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let best = found.iter().map(miss).fold(f64::INFINITY, f64::min);
        // near a singularity joints are known less well than the pose
        let (_, jacobian) = robot.chain().jacobian(&q);
        let worst = jacobian.singular_values().min();
        prop_assume!(worst > 1e-3);
        prop_assert!(best < 1e-8 / worst, "{} {q:?}: {found:?}", ARMS[k].0);
        prop_assert!(found.len() <= 8);
        for s in &found {
            let is = robot.forward(s);
            prop_assert!((is.position - pose.position).norm() <= REACHED_M);
            let turned = rotation_vector(&(pose.rotation.matrix() * is.rotation.matrix().transpose()));
            prop_assert!(turned.norm() <= REACHED_RAD);
        }
    }

    /// The nearest solution alone is the nearest of all.
    #[test]
    fn the_nearest_solution_is_the_nearest_of_all(k in 0..ARMS.len(), shares in prop::collection::vec(0.05..0.95f64, 6), by in prop::collection::vec(-0.3..0.3f64, 6)) {
        let (robot, arm) = arm(k);
        let q = within(&robot, &shares);
        let near: Vec<f64> = q.iter().zip(&by).map(|(a, b)| a + b).collect();
        let pose = robot.forward(&q);
        let far = |s: &[f64]| s.iter().zip(&near).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let all = arm.solutions(&robot, &pose, &near);
        let least = all.iter().map(|s| far(s)).fold(f64::INFINITY, f64::min);
        let found = arm.nearest(&robot, &pose, &near).unwrap();
        prop_assert!((far(&found) - least).abs() < 1e-9, "{}: {found:?} of {all:?}", ARMS[k].0);
    }

    /// The numerical inverse shares no code with the closed forms: what it finds from anywhere is among them.
    #[test]
    fn what_the_numerical_inverse_finds_is_among_the_solutions(k in 0..ARMS.len(), shares in prop::collection::vec(0.05..0.95f64, 6), other in prop::collection::vec(0.05..0.95f64, 6)) {
        let (robot, arm) = arm(k);
        let pose = robot.forward(&within(&robot, &shares));
        let seed = within(&robot, &other);
        let found = robot.inverse(&Target::Pose(pose), &seed, &InverseOptions::default());
        prop_assume!(found.converged());
        let (_, jacobian) = robot.chain().jacobian(&found.q);
        prop_assume!(jacobian.singular_values().min() > 1e-2);
        let all = arm.solutions(&robot, &pose, &found.q);
        let close = |s: &Vec<f64>| s.iter().zip(&found.q).all(|(a, b)| (a - b).abs() < 1e-6);
        prop_assert!(all.iter().any(close), "{}: {:?} is not among {all:?}", ARMS[k].0, found.q);
    }
}

#[test]
fn eight_postures_reach_a_pose_well_inside_the_work_space() {
    for (k, (name, _)) in ARMS.iter().enumerate() {
        let (robot, arm) = arm(k);
        let q = if *name == "kuka" { [0.2, -1.2, 1.5, 0.3, 0.8, 0.1] } else { [0.2, 0.3, 0.2, 0.3, 0.8, 0.1] };
        let q = if *name == "ur10" { [0.2, -1.0, 1.2, 0.4, 0.8, 0.1] } else { q };
        let found = arm.solutions(&robot, &robot.forward(&q), &q);
        assert!(found.len() == 8 || found.len() == 4, "{name}: {}", found.len());
    }
}

/// A UR10 with its maker's calibration differs by tenths of a millimetre and mrad: the closed form is a start only.
#[test]
fn a_calibrated_arm_is_solved_on_its_own_geometry() {
    let text =
        ARMS[4].1.replace("d_mm: 163.941, a_mm: 0, alpha_deg: 90", "d_mm: 163.941, a_mm: 0.21, alpha_deg: 90.05");
    let text = text.replace("a_mm: -612, alpha_deg: 0", "a_mm: -612.4, alpha_deg: 0.03");
    let robot = Robot::parse("ur10", &text).unwrap();
    let arm = Arm::of(&robot).unwrap();
    let q = [0.3, -1.1, 1.4, 0.2, 0.9, -0.4];
    let found = arm.solutions(&robot, &robot.forward(&q), &q);
    assert!(found.iter().any(|s| s.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-7)), "{found:?}");
}

/// KUKA (0, -90, 90, 0, 0, 0) is singular: axis 4 on axis 6. The free angle is that of the joints before.
#[test]
fn at_a_wrist_singularity_the_free_angle_is_that_of_the_joints_before() {
    let (robot, arm) = arm(2);
    let q = [0.0, -90f64.to_radians(), 90f64.to_radians(), 0.4, 0.0, 0.3];
    let found = arm.solutions(&robot, &robot.forward(&q), &q);
    assert!(found.iter().any(|s| s.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e-7)), "{found:?}");
}

#[test]
fn a_pose_out_of_reach_has_no_solution() {
    for k in 0..ARMS.len() {
        let (robot, arm) = arm(k);
        let mut pose = robot.forward(&[0.1; 6]);
        pose.position += Vector3::new(9.0, 0.0, 0.0);
        assert!(arm.solutions(&robot, &pose, &[0.1; 6]).is_empty());
    }
}
