//! `plan-experiment static|path|excitation`: programs that a robot can run, and gaps found within the precision that was told.
//!
//! Parts:
//! - [`scalar`]: programs for ballbars and dial gauges.

mod scalar;

use crate::support::{WorkFolder, bundled, run_args};
use lostmotion::effects::{Backlash, EffectInstance, Target};
use lostmotion::gaps::Gaps;
use lostmotion::identify::{path, static_test};
use lostmotion::io::input::Input;
use lostmotion::log::Log;
use lostmotion::machine::measurement::Instrument;
use lostmotion::model::Model;
use lostmotion::plan::recording::{Kind, Options, Recording, document, plan};
use lostmotion::program::Program;
use lostmotion::robot::{JointKind, Robot};
use lostmotion::simulate::Motion;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::fmt::Write;

pub fn options() -> Options {
    Options {
        pose: None,
        tracker_m: None,
        acceptance_rad: 30f64.to_radians(),
        instrument: Instrument::Tcp,
        bar_m: None,
        noise_m: 10e-6,
        rate_hz: 20.0,
        speed_m_s: 20e-3,
        travel_rad: 30f64.to_radians(),
        travel_m: 0.15,
        duration_s: 240.0,
        dwell_s: 2.0,
        cycles: 3,
        places: 4,
    }
}

fn robot(name: &str) -> Robot {
    Robot::load(&bundled("configs").join(name)).unwrap()
}

/// A machine with a gap of each joint: 0.003 deg or 10 um, a little more from joint to joint.
fn machine(robot: &Robot) -> (Model, Vec<f64>) {
    let mut model = Model::ideal(robot.clone());
    let gaps: Vec<f64> = robot
        .axis_joints()
        .enumerate()
        .map(|(a, j)| {
            let size = if j.kind == JointKind::Revolute { 0.003 } else { 0.010 };
            (1.0 + 0.1 * a as f64) * size * j.kind.si_per_user_unit()
        })
        .collect();
    for (axis, gap) in gaps.iter().enumerate() {
        let effect = Backlash::constant(*gap).into();
        model.effects.push(EffectInstance { target: Target::Joint(axis), effect });
    }
    (model, gaps)
}

/// Runs the written program on the machine and records it.
fn recorded(model: &Model, recording: &Recording, options: &Options, seed: u64) -> Log {
    let bytes = document::program(recording, &model.robot);
    let program =
        Program::parse(Input { name: "plan.csv".into(), bytes, sha256: String::new() }, &model.robot).unwrap();
    let times = program.t_s.clone().unwrap();
    let motion = Motion::of_program(model, &program, &times, options.rate_hz).unwrap();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, options.noise_m).unwrap();
    let mut noise = || normal.sample(&mut rng);
    let mut text = String::from("t_s");
    for joint in model.robot.axis_joints() {
        let _ = write!(text, ",cmd_{}_{}", joint.name, joint.kind.unit());
    }
    text.push_str(match options.instrument {
        Instrument::Tcp => ",x_mm,y_mm,z_mm\n",
        Instrument::Distance { .. } => ",r_um\n",
        _ => ",dial_um\n",
    });
    for row in 0..motion.len() {
        let _ = write!(text, "{:.4}", motion.trajectory.t_s()[row]);
        for (a, joint) in model.robot.axis_joints().enumerate() {
            let _ = write!(text, ",{:.6}", joint.kind.to_user_unit(motion.trajectory.command(a)[row]));
        }
        let p = motion.point_m(0, row);
        let _ = match options.instrument.reading(&p) {
            None => {
                let p = p + Vector3::new(noise(), noise(), noise());
                writeln!(text, ",{:.5},{:.5},{:.5}", p.x * 1e3, p.y * 1e3, p.z * 1e3)
            }
            Some(r) => writeln!(text, ",{:.3}", (r - 0.3 + noise()) * 1e6),
        };
    }
    Log::parse(Input { name: "run.csv".into(), bytes: text.into(), sha256: String::new() }, &model.robot).unwrap()
}

/// Errors of the gaps that were found over the standard deviations that were told.
fn ratios(gaps: &Gaps, recording: &Recording, truth: &[f64]) -> Vec<(usize, f64)> {
    let told = recording.precision.iter().filter_map(|p| Some((p.axis, p.sigma?)));
    told.filter_map(|(axis, sigma)| {
        let j = gaps.joints.iter().find(|j| j.axis == axis)?;
        Some((axis, (j.half_gap - truth[axis]).abs() / sigma))
    })
    .collect()
}

fn keeps_limits(recording: &Recording, robot: &Robot) {
    for w in recording.rows.windows(2) {
        for (a, joint) in robot.axis_joints().enumerate() {
            let (from, to, time) = (w[0].1[a], w[1].1[a], w[1].0 - w[0].0);
            assert!(time > 0.0);
            if let Some([lo, hi]) = joint.limits {
                assert!((lo..=hi).contains(&to), "{} at {to}", joint.name);
            }
            if let Some(v) = joint.max_speed {
                assert!((to - from).abs() / time <= v, "{}", joint.name);
            }
        }
    }
}

#[test]
fn val_a_static_program_finds_the_gaps_within_the_precision_that_was_told() {
    for name in ["kuka-kr120-r2500-pro.yaml", "abb-irb1600-6-145.yaml", "gantry-xyz-ballscrew.yaml"] {
        let robot = robot(name);
        let options = options();
        let recording = plan(&robot, Kind::Static, &options).unwrap();
        keeps_limits(&recording, &robot);
        let (model, truth) = machine(&robot);
        for seed in 1..=3 {
            let log = recorded(&model, &recording, &options, seed);
            let found = static_test::identify(&robot, &[log], &static_test::Options::default()).unwrap();
            let ratios = ratios(&found.gaps, &recording, &truth);
            assert!(ratios.iter().all(|r| r.1 < 4.0), "{name}, seed {seed}: {ratios:?}");
            // a joint that is not found is one whose gap the plan says cannot be seen, and why
            for p in &recording.precision {
                let found = ratios.iter().any(|r| r.0 == p.axis);
                assert_eq!(found, p.sigma.is_some(), "{name}, seed {seed}: {p:?}");
                assert!(found || p.reason.is_some(), "{name}: {p:?}");
            }
        }
    }
}

#[test]
fn val_a_path_and_an_excitation_find_the_gaps_within_the_precision_that_was_told() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    for (kind, speed) in [(Kind::Path, 10e-3), (Kind::Excitation, 60e-3)] {
        let options = Options { speed_m_s: speed, ..options() };
        let recording = plan(&robot, kind, &options).unwrap();
        keeps_limits(&recording, &robot);
        assert!((recording.duration_s - 240.0).abs() < 60.0, "{}", recording.duration_s);
        let (model, truth) = machine(&robot);
        let log = recorded(&model, &recording, &options, 2);
        let found = path::identify(&robot, &[log], &path::Options::default()).unwrap();
        let ratios = ratios(&found.gaps, &recording, &truth);
        assert!(ratios.len() >= 3, "{kind:?}: {ratios:?}");
        assert!(ratios.iter().all(|r| r.1 < 4.0), "{kind:?}: {ratios:?}");
    }
}

#[test]
fn a_tracker_on_one_side_keeps_the_reflector_within_its_acceptance() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let tracker = Vector3::new(4.0, -2.0, 1.0);
    let options = Options { tracker_m: Some(tracker), ..options() };
    let recording = plan(&robot, Kind::Static, &options).unwrap();
    let facing = |q: &[f64]| {
        let at = robot.forward(q);
        at.rotation.inverse() * (tracker - at.position).normalize()
    };
    let first = facing(&recording.pose);
    for (t, q) in &recording.rows {
        let angle = facing(q).angle(&first);
        assert!(angle < 31f64.to_radians(), "{} deg after {t} s", angle.to_degrees());
    }
}

/// The speed that the user gives is used: a motion of a hundredth of it visits one place of each gap.
#[test]
fn a_planned_motion_moves_at_the_speed_that_it_may() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    for (kind, least) in [(Kind::Path, 0.5), (Kind::Excitation, 0.4)] {
        let recording = plan(&robot, kind, &options()).unwrap();
        let mut levers = vec![Vector3::zeros(); robot.dof()];
        robot.chain().position_and_jacobian(&recording.pose, &mut levers);
        for (axis, lever) in levers.iter().enumerate() {
            let speed = recording.rows.windows(2).map(|w| (w[1].1[axis] - w[0].1[axis]).abs() / (w[1].0 - w[0].0));
            // a joint near the TCP's line may turn no faster than as if it were 0.1 m away; its window may end before
            let of_all = speed.fold(0.0, f64::max) * lever.norm().max(0.1) / options().speed_m_s;
            let travel = recording.rows.iter().map(|r| r.1[axis]).fold(f64::NEG_INFINITY, f64::max)
                - recording.rows.iter().map(|r| r.1[axis]).fold(f64::INFINITY, f64::min);
            assert!(
                of_all > least || travel > 0.9 * 2.0 * options().travel_rad,
                "{kind:?} axis {axis}: {of_all:.3} of the speed"
            );
        }
    }
}

/// Each language's own reader takes the program back; every place where the plan stands is a target at which the robot stops, in order.
#[test]
fn a_static_test_in_the_language_of_the_robot_reads_back_as_the_plan() {
    use lostmotion::plan::recording::vendor::{self, Language};
    for (name, language, file) in [
        ("fanuc-m20ia.yaml", Language::Fanuc, "static.ls"),
        ("abb-irb1600-6-145.yaml", Language::Rapid, "static.mod"),
        ("kuka-kr120-r2500-pro.yaml", Language::Krl, "static.src"),
        ("universal-robots-ur10e.yaml", Language::UrScript, "static.script"),
        ("gantry-xyz-ballscrew.yaml", Language::Gcode, "static.nc"),
    ] {
        let robot = robot(name);
        let recording = plan(&robot, Kind::Static, &options()).unwrap();
        let bytes = vendor::program(&recording, &robot, language, "static test 1").unwrap();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let program = Program::parse(Input { name: file.into(), bytes, sha256: String::new() }, &robot)
            .unwrap_or_else(|e| panic!("{name}: {e}\n{}", &text[..600]));
        let mut goal = 0;
        let mut dwells = 0;
        for w in recording.rows.windows(2) {
            if w[1].0 - w[0].0 < 1.9 || w[0].1 != w[1].1 {
                continue;
            }
            dwells += 1;
            let near = |k: usize| {
                let apart = |a: usize| {
                    (program.q[a][program.goals[k]] - w[1].1[a]).abs() / robot.axis(a).kind.si_per_user_unit()
                };
                (0..robot.dof()).all(|a| apart(a) < 6e-4)
            };
            goal += 1
                + (goal..program.goals.len())
                    .position(near)
                    .unwrap_or_else(|| panic!("{name}: no target for the dwell at {:?}", w[1]));
        }
        assert!(dwells >= 4 * 3 * 2, "{name}: {dwells} dwells");
        let (waits, stops) = match language {
            Language::Fanuc => ("WAIT", " FINE"),
            Language::Rapid => ("WaitTime", ",fine,"),
            Language::Krl => ("WAIT SEC", "PTP {"),
            Language::UrScript => ("sleep(", "movej(["),
            _ => ("G4 P", "G1 "),
        };
        let lines = |begins: &str| text.lines().filter(|l| !l.starts_with('(') && l.contains(begins)).count();
        assert_eq!(lines(waits), dwells, "{name}");
        assert_eq!(lines(stops), program.goals.len(), "{name}");
    }
}

#[test]
fn a_static_test_for_a_lathe_writes_diameters_where_its_robot_file_says_so() {
    use lostmotion::plan::recording::vendor::{self, Language};
    let gantry = robot("gantry-xyz-ballscrew.yaml");
    let mut lathe = robot("gantry-xyz-ballscrew.yaml");
    lathe.assume(lostmotion::program::gcode::Control::of_words(["diameter"]).unwrap());
    let recording = plan(&gantry, Kind::Static, &options()).unwrap();
    let [written, of_lathe] = [&gantry, &lathe].map(|robot| {
        let bytes = vendor::program(&recording, robot, Language::Gcode, "static test 1").unwrap();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        (text, Program::parse(Input { name: "static.nc".into(), bytes, sha256: String::new() }, robot).unwrap())
    });
    assert!(of_lathe.0.contains("(X words are diameters)") && !written.0.contains("diameters"));
    for (a, b) in written.1.q[0].iter().zip(&of_lathe.1.q[0]) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_language_that_cannot_move_the_robot_or_run_the_plan_is_refused_with_what_to_do() {
    use lostmotion::plan::recording::vendor::{self, Language};
    let gantry = robot("gantry-xyz-ballscrew.yaml");
    let recording = plan(&gantry, Kind::Static, &options()).unwrap();
    let refused = vendor::program(&recording, &gantry, Language::Rapid, "t").unwrap_err().to_string();
    assert!(refused.contains("X, which slides, in RAPID") && refused.contains(".csv"), "{refused}");
    let arm = robot("motoman-gp12.yaml");
    let recording = plan(&arm, Kind::Static, &options()).unwrap();
    let refused = vendor::program(&recording, &arm, Language::Inform, "t").unwrap_err().to_string();
    assert!(refused.contains("pulses_per_deg"), "{refused}");
    let path = plan(&arm, Kind::Path, &Options { speed_m_s: 10e-3, ..options() }).unwrap();
    let refused = vendor::program(&path, &arm, Language::Fanuc, "t").unwrap_err().to_string();
    assert!(refused.contains("the path program"), "{refused}");
}

#[test]
fn a_test_is_recorded_where_the_programs_work() {
    let desk = WorkFolder::new();
    let robot = bundled("configs/kuka-kr120-r2500-pro.yaml");
    let header = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n";
    let work = |a1: f64| format!("{header}{a1},-80,95,10,40,-20\n{},-70,85,10,50,-20\n", a1 + 10.0);
    std::fs::write(desk.join("weld one.csv"), work(20.0)).unwrap();
    std::fs::write(desk.join("two.csv"), work(40.0)).unwrap();
    std::fs::write(desk.join("beyond.csv"), work(300.0)).unwrap();
    std::fs::write(desk.join("empty.csv"), header).unwrap();
    let plan = |rest: &[&str]| {
        let mut line = vec!["plan-experiment", "static", "--robot", robot.to_str().unwrap(), "--json"];
        line.extend(rest);
        run_args(desk.path(), &line)
    };
    let both = plan(&["--program", "weld one.csv", "--program", "two.csv"]).success();
    let document: serde_json::Value = serde_json::from_slice(&both.stdout).unwrap();
    let pose: Vec<f64> = document["pose"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    for (found, expected) in pose.iter().zip([35.0, -75.0, 90.0, 10.0, 45.0, -20.0]) {
        assert!((found - expected).abs() < 0.11, "{pose:?}");
    }
    assert!(both.stderr.contains("A1 35.0 deg"), "{}", both.stderr);
    // what cannot be recorded there, or says two things
    for (line, expected) in [
        (&["--program", "beyond.csv"][..], "within the limits"),
        (&["--program", "empty.csv"], "empty.csv"),
        (&["--program", "two.csv", "--pose", "0,0,0,0,0,0"], "cannot be used with"),
        (&["--frames", "none.yaml", "--pose", "0,0,0,0,0,0"], "cannot be used with"),
    ] {
        let refused = plan(line);
        assert_eq!(refused.code, Some(2), "{line:?}");
        assert!(refused.stderr.contains(expected), "{line:?}: {}", refused.stderr);
    }
}

#[test]
fn a_motion_of_all_joints_is_narrowed_until_the_tracker_sees_all_of_it() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    for kind in [Kind::Path, Kind::Excitation] {
        let options = Options { tracker_m: Some(Vector3::new(3.2, -0.4, 0.9)), duration_s: 120.0, ..options() };
        let recording = plan(&robot, kind, &options).unwrap();
        assert!(!recording.notes.iter().any(|n| n.to_string().contains("interrupted")), "{:?}", recording.notes);
    }
}
