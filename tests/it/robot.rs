//! Kinematics against independent truth, against themselves, and the robot file there and back.

use crate::support::{WorkFolder, bundled, root};
use lostmotion::robot::inverse::rotation_vector;
use lostmotion::robot::{InverseOptions, Robot, Stop, Target};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use serde_json::Value;
use std::path::Path;
use std::sync::LazyLock;

const FILES: [&str; 6] = [
    "configs/kuka-kr120-r2500-pro.yaml",
    "configs/abb-irb1600-6-145.yaml",
    "configs/gantry-xyz-ballscrew.yaml",
    "configs/micro-iges-4dof.yaml",
    "tests/data/robots/modified-with-slide.yaml",
    "tests/data/robots/coupled-elbows.yaml",
];

static ROBOTS: LazyLock<Vec<Robot>> = LazyLock::new(|| FILES.iter().map(|f| load(f)).collect());

fn load(file: &str) -> Robot {
    Robot::load(&root().join(file)).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Largest distance of positions (m) and of rotation entries from the oracle, over robots and poses.
#[test]
fn poses_agree_with_the_oracle_within_a_nanometre() {
    let oracle: Value =
        serde_json::from_slice(&std::fs::read(bundled("tests/oracle/kinematics.json")).unwrap()).unwrap();
    let mut compared = 0;
    for case in oracle.as_array().unwrap() {
        let file = case["robot"].as_str().unwrap();
        let robot = load(file);
        for pose in case["poses"].as_array().unwrap() {
            let q: Vec<f64> = numbers(&pose["command"])
                .iter()
                .zip(robot.axis_joints())
                .map(|(v, j)| v * j.kind.si_per_user_unit())
                .collect();
            let found = robot.forward(&q);
            let want = Vector3::from_vec(numbers(&pose["xyz_mm"])) * 1e-3;
            let turn = Matrix3::from_row_slice(&numbers(&pose["rotation"]));
            assert!((found.position - want).norm() < 1e-9, "{file} {q:?}: {} against {want}", found.position);
            assert!((found.rotation.matrix() - turn).amax() < 1e-11, "{file} {q:?}");
            assert!((robot.tcp_m(&q) - found.position).norm() < 1e-15);
            compared += 1;
        }
    }
    assert_eq!(compared, 150);
}

#[test]
fn the_kuka_flange_stands_where_its_drawing_says() {
    let mut robot = load(FILES[0]);
    robot = Robot::new(robot.name, robot.convention, robot.joints, robot.base, nalgebra::Isometry3::identity());
    let q = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0].map(f64::to_radians);
    assert!((robot.tcp_m(&q) - Vector3::new(1.565, 0.0, 1.784)).norm() < 1e-12);
}

/// Commands of a robot inside its limits from numbers between 0 and 1.
fn inside(robot: &Robot, u: &[f64]) -> Vec<f64> {
    robot
        .axis_joints()
        .zip(u)
        .map(|(j, u)| {
            let [lo, hi] = j.limits.unwrap_or([-1.0, 1.0]);
            lo + (hi - lo) * u
        })
        .collect()
}

fn units() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.0..1.0_f64, 6)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn the_jacobian_is_the_slope_at_two_step_sizes(which in 0..FILES.len(), u in units()) {
        let robot = &ROBOTS[which];
        let q = inside(robot, &u);
        let (pose, full) = robot.chain().jacobian(&q);
        let mut columns = vec![Vector3::zeros(); robot.dof()];
        let p = robot.chain().position_and_jacobian(&q, &mut columns);
        prop_assert!((p - pose.position).norm() < 1e-15);
        for axis in 0..robot.dof() {
            let slope = |h: f64| {
                let at = |s: f64| { let mut x = q.clone(); x[axis] += s * h; robot.forward(&x) };
                let (a, b) = (at(-1.0), at(1.0));
                let turned = rotation_vector(&(b.rotation.matrix() * a.rotation.matrix().transpose()));
                ((b.position - a.position) / (2.0 * h), turned / (2.0 * h))
            };
            // truncation h^2/6 of at most 4 m of arm, rounding 1e-15/h
            for (h, bound) in [(1e-4, 2e-8), (1e-5, 2e-9)] {
                let (v, w) = slope(h);
                prop_assert!((columns[axis] - v).norm() < bound, "axis {axis}, h {h}: {} against {v}", columns[axis]);
                for k in 0..3 {
                    prop_assert!((full[(k, axis)] - columns[axis][k]).abs() < 1e-14);
                    prop_assert!((full[(k + 3, axis)] - w[k]).abs() < bound, "axis {axis}, h {h}");
                }
            }
        }
    }

    #[test]
    fn the_rotation_stays_a_rotation(which in 0..FILES.len(), u in units()) {
        let robot = &ROBOTS[which];
        let r = *robot.forward(&inside(robot, &u)).rotation.matrix();
        prop_assert!((r * r.transpose() - Matrix3::identity()).amax() < 4e-15);
        prop_assert!((r.determinant() - 1.0).abs() < 4e-15);
    }

    #[test]
    fn the_inverse_brings_the_tcp_to_the_target(which in 0..FILES.len(), u in units(), step in units(), mask in 1_u32..64, pose: bool) {
        let robot = &ROBOTS[which];
        // away from the limits, where wrists stretch; the seed is a tenth of a radian or 20 mm off, in the free axes only
        let q = inside(robot, &u);
        let free: Vec<usize> = (0..robot.dof()).filter(|a| mask & (1 << a) != 0).collect();
        prop_assume!(!free.is_empty());
        let mut seed = q.clone();
        for &a in &free {
            let reach = match robot.axis(a).kind { lostmotion::robot::JointKind::Revolute => 0.1, _ => 0.02 };
            seed[a] += reach * (2.0 * step[a] - 1.0);
        }
        let there = robot.forward(&q);
        let target = if pose { Target::Pose(there) } else { Target::Position(there.position) };
        let options = InverseOptions { free: free.clone(), ..InverseOptions::default() };
        let found = robot.inverse(&target, &seed, &options);
        prop_assert!(found.q.iter().all(|v| v.is_finite()));
        for a in (0..robot.dof()).filter(|a| !free.contains(a)) {
            prop_assert_eq!(found.q[a], q[a]);
        }
        let again = robot.forward(&found.q);
        prop_assert!(((again.position - there.position).norm() - found.error_m).abs() < 1e-12);
        if found.converged() {
            prop_assert!((again.position - there.position).norm() <= 1e-10);
            if pose {
                let turn = again.rotation.matrix() * there.rotation.matrix().transpose();
                prop_assert!((turn - Matrix3::identity()).amax() < 1e-9);
            }
        } else {
            // only where the joints that may move lose a direction at the target or on the way there
            prop_assert!(nearly_singular(robot, &q, &seed, &found.q, &free, pose), "{:?} from {seed:?} to {q:?}", found);
        }
    }

    #[test]
    fn a_target_out_of_reach_is_no_progress_and_no_nan(which in 0..FILES.len(), u in units(), far in 10.0..1e6_f64) {
        let robot = &ROBOTS[which];
        prop_assume!(which != 2); // a gantry without limits reaches everything
        let mut options = InverseOptions { max_iterations: 2000, ..InverseOptions::default() };
        options.within_limits = true;
        let found = robot.inverse(&Target::Position(Vector3::new(far, -far, far)), &inside(robot, &u), &options);
        prop_assert!(found.stop == Stop::NoProgress || found.stop == Stop::IterationLimit, "{:?}", found.stop);
        prop_assert!(found.q.iter().all(|v| v.is_finite()) && found.error_m.is_finite());
    }
}

/// Ratio of the singular values below 1e-3 at one of the joint vectors.
fn nearly_singular(robot: &Robot, a: &[f64], b: &[f64], c: &[f64], free: &[usize], pose: bool) -> bool {
    [a, b, c].iter().any(|q| {
        let (_, full) = robot.chain().jacobian(q);
        let rows = if pose { 6 } else { 3 };
        let jac = nalgebra::DMatrix::from_fn(rows, free.len(), |r, k| full[(r, free[k])]);
        let s = jac.singular_values();
        s.min() < 1e-2 * s.max()
    })
}

#[test]
fn the_inverse_says_when_target_or_seed_is_not_finite() {
    let robot = &ROBOTS[0];
    let options = InverseOptions::default();
    let nan = robot.inverse(&Target::Position(Vector3::new(f64::NAN, 0.0, 0.0)), &[0.0; 6], &options);
    assert_eq!(nan.stop, Stop::NotFinite);
    let inf = robot.inverse(&Target::Position(Vector3::zeros()), &[f64::INFINITY; 6], &options);
    assert_eq!(inf.stop, Stop::NotFinite);
}

#[test]
fn a_robot_written_and_read_is_the_same_robot() {
    for (file, robot) in FILES.iter().zip(ROBOTS.iter()) {
        let text = robot.to_yaml().unwrap();
        let again = Robot::parse("written", &text).unwrap();
        assert_eq!(robot.joints, again.joints, "{file}: joints to the last bit");
        assert_eq!(robot.fingerprint(), again.fingerprint(), "{file}\n{text}");
        assert_eq!(robot.reflectors_m, again.reflectors_m);
        assert_eq!(robot.gravity_m_s2, again.gravity_m_s2);
        assert_eq!(text, again.to_yaml().unwrap(), "{file}: writing twice gives the same bytes");
        assert!(
            text.lines().all(|l| !l.contains("0000000") && !l.contains("99999999")),
            "{file}: digits of rounding\n{text}"
        );
    }
}

#[test]
fn a_robot_stands_inline_in_a_model() {
    let folder = WorkFolder::new();
    let robot = &ROBOTS[4];
    let mut model = String::from("schema: lostmotion/model/1\nrobot:\n");
    for line in robot.to_yaml().unwrap().lines() {
        model.push_str(&format!("  {line}\n"));
    }
    let path = folder.join("model.yaml");
    std::fs::write(&path, model).unwrap();
    let read = lostmotion::model::Model::load(Path::new(&path)).unwrap();
    assert_eq!(read.robot.fingerprint(), robot.fingerprint());
}

#[test]
fn a_fingerprint_ignores_limits_and_feels_every_length() {
    let robot = &ROBOTS[0];
    let mut other = robot.clone();
    other.joints[0].limits = None;
    assert_eq!(robot.fingerprint(), other.fingerprint());
    other.joints[3].d_m += 1e-6;
    assert_ne!(robot.fingerprint(), other.fingerprint());
}

#[test]
fn the_robot_file_puts_the_flange_where_the_makers_table_does() {
    let tcp = load("configs/universal-robots-ur10.yaml").tcp_m(&[0.0; 6]);
    // alpha 90, 0, 0, 90, -90, 0: -(a2 + a3) along -x, d4 + d6 along -y, d1 - d5 up
    assert!((tcp - Vector3::new(-1.1843, -0.256141, 0.0116)).norm() < 1e-12, "{tcp}");
}

#[test]
fn the_robot_file_keeps_the_forearm_level_while_j2_moves() {
    let robot = load("configs/fanuc-m10ia.yaml");
    assert_eq!(robot.dof(), 6);
    let at = robot.tcp_m(&[0.0; 6]);
    assert!((at - Vector3::new(0.890, 0.0, 0.800)).norm() < 1e-12, "{at}");
    // J2 alone: the elbow moves on its circle, the forearm stays level
    let at = robot.tcp_m(&[0.0, 30_f64.to_radians(), 0.0, 0.0, 0.0, 0.0]);
    let elbow = Vector3::new(0.150 + 0.300 + 0.740, 0.0, 0.600 * 30_f64.to_radians().cos() + 0.200);
    assert!((at - elbow).norm() < 1e-12, "{at}");
    // positive J3 lifts the forearm
    assert!(robot.tcp_m(&[0.0, 0.0, 0.1, 0.0, 0.0, 0.0]).z > 0.85);
}

/// The published axes and offsets (github.com/rpiRobotics/dx200_motion_progam_exec), as a product of exponentials. Its last frame has x
/// down at zero; Yaskawa's flange has x up (a tool that hangs down before the arm reads 180, 0, 0 on the pendant).
#[test]
fn the_ma2010_stands_where_its_published_axes_put_it() {
    use nalgebra::{Unit, UnitQuaternion};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    let axes = [[0, 0, 1], [0, 1, 0], [0, -1, 0], [-1, 0, 0], [0, -1, 0], [-1, 0, 0]];
    let steps = [[150, 0, 0], [0, 0, 760], [0, 0, 200], [1082, 0, 0], [100, 0, 0], [0, 0, 0]];
    let vector = |v: [i32; 3]| Vector3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    let robot = load("configs/motoman-ma2010.yaml");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..50 {
        let q: Vec<f64> = (0..6).map(|_| rng.random_range(-1.5..1.5)).collect();
        let (mut turn, mut at) = (UnitQuaternion::identity(), Vector3::zeros());
        for k in 0..6 {
            turn *= UnitQuaternion::from_axis_angle(&Unit::new_normalize(vector(axes[k])), q[k]);
            at += turn * (vector(steps[k]) * 1e-3);
        }
        let turn = turn * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
        let turn = turn * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
        let pose = robot.forward(&q);
        assert!((pose.position - at).norm() < 1e-12);
        let difference = pose.rotation.matrix() - turn.to_rotation_matrix().matrix();
        assert!(difference.norm() < 1e-12, "{difference}");
    }
}
