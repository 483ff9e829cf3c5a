//! Gears that turn by sums of axes (`gap_of`, FANUC's J3): recordings are planned, simulated and identified by gears.
//!
//! Truth: the same arm written with a command for each motor, whose J3 is the pendant's J2 + J3, and backlash on its motors.

use lostmotion::effects::{Backlash, EffectInstance, Target};
use lostmotion::gaps::Gaps;
use lostmotion::identify::{machine, path, static_test};
use lostmotion::io::input::Input;
use lostmotion::log::Log;
use lostmotion::machine::measurement::Instrument;
use lostmotion::model::Model;
use lostmotion::plan::recording::{Kind, Options, document, plan};
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use lostmotion::simulate::Motion;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::fmt::Write;

const FIRST: &str = "schema: lostmotion/robot/1
convention: dh-standard
joints:
  - {name: J1, kind: revolute, d_mm: 500, a_mm: 150, alpha_deg: -90, limits_deg: [-170, 170], max_speed_deg_s: 180}
  - {name: J2, kind: revolute, theta_deg: -90, a_mm: 790, alpha_deg: 180, limits_deg: [-90, 150], max_speed_deg_s: 180}
";
const ELBOW: &str = "  - {name: J3, kind: revolute, a_mm: 900, limits_deg: [-180, 270], max_speed_deg_s: 180}\n";

/// As the pendant shows it: J2 alone leaves the forearm level.
fn pendant() -> Robot {
    let follower = "  - {name: J23, kind: revolute, follows: {joint: J2, ratio: 1}}\n";
    Robot::parse("robot.yaml", &format!("{FIRST}{follower}{ELBOW}gap_of: {{J3: J2 + J3}}\n")).unwrap()
}

/// As its motors turn.
fn motors() -> Robot {
    Robot::parse("motors.yaml", &format!("{FIRST}{ELBOW}")).unwrap()
}

const HALF_GAPS_DEG: [f64; 3] = [0.004, 0.003, 0.005];

fn machine_of(robot: Robot) -> Model {
    let mut model = Model::ideal(robot);
    for (axis, gap) in HALF_GAPS_DEG.iter().enumerate() {
        let effect = Backlash::constant(gap.to_radians()).into();
        model.effects.push(EffectInstance { target: Target::Joint(axis), effect });
    }
    model
}

fn options(speed_m_s: f64) -> Options {
    Options {
        pose: Some([10f64, 20.0, -30.0].map(f64::to_radians).to_vec()),
        tracker_m: None,
        acceptance_rad: 30f64.to_radians(),
        instrument: Instrument::Tcp,
        bar_m: None,
        noise_m: 10e-6,
        rate_hz: 20.0,
        speed_m_s,
        travel_rad: 20f64.to_radians(),
        travel_m: 0.15,
        duration_s: 240.0,
        dwell_s: 2.0,
        cycles: 3,
        places: 3,
    }
}

fn input(name: &str, bytes: Vec<u8>) -> Input {
    Input { name: name.into(), bytes, sha256: String::new() }
}

/// The commands of the motors.
fn of_motors(program: &Program) -> Program {
    let mut program = program.clone();
    let j2 = program.q[1].clone();
    program.q[2].iter_mut().zip(j2).for_each(|(j3, j2)| *j3 += j2);
    program
}

/// A run on the arm of motors, logged in the pendant's joints.
fn run(program: &Program) -> (Motion, Log) {
    let motion =
        Motion::of_program(&machine_of(motors()), &of_motors(program), &program.t_s.clone().unwrap(), 20.0).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let normal = Normal::new(0.0, 10e-6).unwrap();
    let mut text = String::from("t_s,cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,x_mm,y_mm,z_mm\n");
    for row in 0..motion.len() {
        let q = [0, 1, 2].map(|a| motion.trajectory.command(a)[row].to_degrees());
        let mut noise = || normal.sample(&mut rng);
        let p = (motion.point_m(0, row) + Vector3::new(noise(), noise(), noise())) * 1e3;
        let _ = write!(text, "{:.4},{:.6},{:.6},{:.6}", motion.trajectory.t_s()[row], q[0], q[1], q[2] - q[1]);
        let _ = writeln!(text, ",{:.5},{:.5},{:.5}", p.x, p.y, p.z);
    }
    let log = Log::parse(input("run.csv", text.into()), &pendant()).unwrap();
    (motion, log)
}

fn planned(kind: Kind, speed_m_s: f64) -> Program {
    let recording = plan(&pendant(), kind, &options(speed_m_s)).unwrap();
    Program::parse(input("plan.csv", document::program(&recording, &pendant())), &pendant()).unwrap()
}

/// Largest difference of the gaps to the truth, as a share of it; all joints must be there.
fn largest_error(gaps: &Gaps) -> f64 {
    assert_eq!(gaps.robot_sha256, pendant().fingerprint(), "a compensator is for the robot as its programs know it");
    let of = |axis: usize| gaps.joints.iter().find(|j| j.axis == axis).unwrap().half_gap.to_degrees();
    (0..3).map(|a| (of(a) / HALF_GAPS_DEG[a] - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn a_static_test_moves_one_gear_at_a_time_and_gives_every_gap() {
    let program = planned(Kind::Static, 50e-3);
    let gears = of_motors(&program);
    for i in 1..program.len() {
        let moved = gears.q.iter().filter(|c| (c[i] - c[i - 1]).abs() > 1e-7).count();
        let home = gears.q.iter().all(|c| (c[i] - c[0]).abs() < 0.4);
        assert!(moved <= 1 || home, "row {i}: {moved} gears move");
    }
    let (_, log) = run(&program);
    let found = static_test::identify(&pendant(), &[log], &static_test::Options::default()).unwrap();
    assert!(largest_error(&found.gaps) < 0.05, "{:?}", found.gaps.joints);
}

#[test]
fn a_path_on_which_the_axes_of_a_sum_move_together_gives_every_gap() {
    let program = planned(Kind::Path, 10e-3);
    let (_, log) = run(&program);
    let found = path::identify(&pendant(), std::slice::from_ref(&log), &path::Options::default()).unwrap();
    assert!(largest_error(&found.gaps) < 0.05, "{:?}", found.gaps.joints);
    let together = machine::identify(&pendant(), &[log], &[]).unwrap();
    assert!(largest_error(&together) < 0.15, "{:?}", together.joints);
}

#[test]
fn a_simulated_elbow_reverses_where_its_motor_does() {
    let program = planned(Kind::Path, 10e-3);
    let (truth, _) = run(&program);
    let ours = Motion::of_program(&machine_of(pendant()), &program, &program.t_s.clone().unwrap(), 20.0).unwrap();
    assert_eq!(ours.len(), truth.len());
    for row in 0..truth.len() {
        let apart = (ours.point_m(0, row) - truth.point_m(0, row)).norm();
        assert!(apart < 1e-9, "row {row}: {apart} m apart");
    }
    // an encoder shows the pendant's joint
    let shown = &ours.prediction.servo;
    let last = truth.len() - 1;
    assert!((shown[2][last] + shown[1][last] - truth.prediction.servo[2][last]).abs() < 1e-12);
}

/// J2 of the pendant alone turns two gears: what it shows is not the gap of J2.
#[test]
fn a_dwell_to_which_two_gears_moved_is_left_out() {
    let mut text = String::from("cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,x_mm,y_mm,z_mm\n");
    let robot = pendant();
    for _ in 0..3 {
        for j2 in [18.0, 20.0, 22.0, 20.0] {
            let p = robot.tcp_m(&[0.2, f64::to_radians(j2), -0.5]) * 1e3;
            let _ = writeln!(
                text,
                "{:.6},{j2},{:.6},{:.4},{:.4},{:.4}",
                0.2f64.to_degrees(),
                (-0.5f64).to_degrees(),
                p.x,
                p.y,
                p.z
            );
        }
    }
    let log = Log::parse(input("run.csv", text.into()), &robot).unwrap();
    let refused = static_test::identify(&robot, &[log], &static_test::Options::default()).unwrap_err().to_string();
    assert!(refused.contains("none of them reached by one joint alone"), "{refused}");
}

/// The programs that `plan-experiment static` writes move one gear after the other: what is left out to judge the estimate must not be
/// all that a log tells of a gear.
#[test]
fn dwells_of_one_gear_after_the_other_in_one_log_are_trusted() {
    let (_, log) = run(&planned(Kind::Static, 50e-3));
    let found = machine::identify(&pendant(), &[log], &[]).unwrap();
    assert!(largest_error(&found) < 0.15, "{:?}", found.joints);
    for joint in found.estimate.unwrap().joints {
        let trust = &joint.trust;
        assert!(trust.compensate, "gear {}: {trust:?}", joint.axis);
        assert!(trust.reversals >= 15 && trust.after_m < 0.1 * trust.before_m, "gear {}: {trust:?}", joint.axis);
    }
}
