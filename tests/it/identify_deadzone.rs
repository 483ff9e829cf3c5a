//! `identify deadzone` on an independent oracle's logs (`tests/oracle/deadzone.py`) and on the simulated instrument.

use crate::bench::{parse, robot};
use crate::support::bundled;
use lostmotion::effects::{GapCurve, Target};
use lostmotion::error::Error;
use lostmotion::gaps::Gaps;
use lostmotion::identify::deadzone::{Deadzone, Found, Options, as_printed, document, identify};
use lostmotion::io::input::{Input, sha256};
use lostmotion::log::Log;
use lostmotion::model::Model;
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use lostmotion::simulate::{Motion, Options as Run, predicted};
use serde_json::Value;

const RATE_HZ: f64 = 5.0;

fn instrument() -> Model {
    Model::load(&bundled("samples/instrument/instrument.model.yaml")).unwrap()
}

fn coupled() -> Robot {
    Robot::load(&bundled("tests/data/robots/coupled-elbows.yaml")).unwrap()
}

fn oracle(name: &str, robot: &Robot) -> (Log, Value) {
    let folder = bundled("tests/data/deadzone");
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("truth.json")).unwrap()).unwrap();
    (Log::load(&folder.join(format!("{name}_log.csv.gz")), robot).unwrap(), truth[name].clone())
}

/// A program's run on a model.
fn run(model: &Model, program: &Program, noise_um: f64, seed: u64) -> Log {
    let motion = Motion::of_program(model, program, program.t_s.as_ref().unwrap(), RATE_HZ).unwrap();
    let options = Run { rate_hz: RATE_HZ, noise_m: noise_um * 1e-6, seed, ..Run::default() };
    let mut bytes = Vec::new();
    predicted::write_program_log(model, &motion, &options, "run", &mut bytes).unwrap();
    let input = Input { name: "run.csv".into(), sha256: sha256(&bytes), bytes };
    Log::parse(input, &model.robot).unwrap()
}

fn program(text: String, robot: &Robot) -> Program {
    Program::parse(Input { name: "p.csv".into(), sha256: sha256(text.as_bytes()), bytes: text.into() }, robot).unwrap()
}

fn sample(motion: &str, robot: &Robot) -> Program {
    Program::load(&bundled(&format!("samples/instrument/{motion}.csv")), robot).unwrap()
}

/// E1 alone, degrees over time, a point every 0.2 s.
fn elbow(points: usize, angle: impl Fn(f64) -> f64, robot: &Robot) -> Program {
    let mut text = String::from("t_s,e1_deg,e2_deg,pitch_deg,yaw_deg\n");
    for i in 0..points {
        let t = 0.2 * i as f64;
        text += &format!("{t:.1},{:.4},0,0,0\n", angle(t));
    }
    program(text, robot)
}

fn growing(t: f64) -> f64 {
    30.0 * t / 200.0 * (std::f64::consts::TAU * t / 20.0).sin()
}

fn holds(ci95: [f64; 2], truth: f64) -> bool {
    (ci95[0]..=ci95[1]).contains(&truth)
}

/// The deadzones that the oracle knows, by where they begin (deg).
fn of_oracle(truth: &Value, d: &Deadzone) -> f64 {
    let zones: Vec<[f64; 2]> = serde_json::from_value(truth["deadzones"].clone()).unwrap();
    let from = d.from.to_degrees();
    let near = zones.iter().min_by(|a, b| (a[0] - from).abs().total_cmp(&(b[0] - from).abs())).unwrap();
    assert!((near[0] - from).abs() < 0.02, "a deadzone at {from} that is not there; the nearest begins at {}", near[0]);
    (near[1] - near[0]).abs()
}

/// Held intervals and all; also checks that the map lies within twice its band plus `slack_deg`.
fn against_oracle(found: &Found, robot: &Robot, truth: &Value, slack_deg: f64) -> (usize, usize) {
    let (mut held, mut all) = (0, 0);
    for (j, gap) in found.joints.iter().zip(&found.gaps.joints) {
        let of = &truth[&robot.axis(j.axis).name];
        for d in &j.deadzones {
            held += usize::from((d.size.to_degrees() - of_oracle(of, d)).abs() <= 1.96 * d.sigma.to_degrees());
            all += 1;
        }
        let at: Vec<f64> = serde_json::from_value(of["at"].clone()).unwrap();
        let want: Vec<f64> = serde_json::from_value(of["half_gap"].clone()).unwrap();
        for (p, b) in at.iter().zip(want) {
            let is = gap.schedule.as_ref().map_or(gap.half_gap, |c| c.at(p.to_radians())).to_degrees();
            assert!((is - b).abs() < slack_deg, "{} at {p}: {is} for {b}", robot.axis(j.axis).name);
        }
    }
    (held, all)
}

#[test]
fn val_deadzones_of_an_independent_instrument_are_found_with_honest_intervals_and_their_map() {
    let robot = robot("micro-iges-4dof.yaml");
    let (log, truth) = oracle("instrument", &robot);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    assert_eq!(found.joints.len(), 4);
    let (held, all) = against_oracle(&found, &robot, &truth, 0.09);
    assert!(all >= 88, "{all} of the 95 deadzones");
    assert!(held as f64 >= 0.9 * all as f64, "truth inside {held} of {all} intervals of 95 %");
    let shape: Vec<bool> = found.gaps.joints.iter().map(|j| j.schedule.is_some()).collect();
    assert_eq!(shape, [true, true, true, false], "YAW alone has a constant gap");
    for j in &found.joints {
        assert!((j.noise_m * 1e6 / 50.0 - 1.0).abs() < 0.05, "the oracle's noise is 50 um, found {}", j.noise_m * 1e6);
    }
    let yaw = &found.gaps.joints[3];
    assert!(holds(yaw.ci95, 2.2_f64.to_radians()), "{:?}", yaw.ci95.map(f64::to_degrees));
}

#[test]
fn val_coupled_elbows_are_found_through_their_drivers_although_the_tracker_drops_out() {
    let robot = coupled();
    let (log, truth) = oracle("coupled", &robot);
    assert!(log.tcp_m.iter().any(Option::is_none));
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    // beyond the last deadzone the map is constant: 0.07 deg at the ends of E1
    let (held, all) = against_oracle(&found, &robot, &truth, 0.08);
    assert!(all >= 40 && held as f64 >= 0.9 * all as f64, "{held} of {all}");
    let names: Vec<&str> = found.joints.iter().map(|j| robot.axis(j.axis).name.as_str()).collect();
    assert_eq!(names, ["E1", "E2"]);
    assert!(found.joints.iter().any(|j| j.unseen > 0), "a turn without the tracker is left out");
    assert!(holds(found.gaps.joints[1].ci95, 2f64.to_radians()));
}

/// True size of a deadzone that begins at `from`: `b` where it begins and where it ends.
fn of_model(model: &Model, d: &Deadzone) -> f64 {
    let curve = |e: &&lostmotion::effects::EffectInstance| e.target == Target::Joint(d.axis);
    let Some(gap) = model.effects.iter().find(curve).and_then(|e| e.effect.half_gap()) else { return 0.0 };
    let dir = (d.to - d.from).signum();
    let mut to = d.to;
    for _ in 0..100 {
        to = d.from + dir * (gap.at(d.from) + gap.at(to));
    }
    (to - d.from).abs()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn val_intervals_hold_the_truth_at_every_level_of_noise() {
    let model = instrument();
    let sweep = sample("growing_sine", &model.robot);
    for (noise_um, least) in [(10.0, 180), (50.0, 175), (100.0, 165), (200.0, 145)] {
        let (mut held, mut all, mut z2) = (0, 0, 0.0);
        for seed in 1..=3 {
            let found = identify(&model.robot, &[run(&model, &sweep, noise_um, seed)], &Options::default()).unwrap();
            let zones: Vec<&Deadzone> = found.joints.iter().flat_map(|j| &j.deadzones).collect();
            assert!(zones.len() >= least, "{} deadzones at {noise_um} um", zones.len());
            for d in zones {
                let z = (d.size - of_model(&model, d)) / d.sigma;
                held += usize::from(z.abs() <= 1.96);
                z2 += z * z;
                all += 1;
            }
        }
        let (share, rms) = (held as f64 / all as f64, (z2 / all as f64).sqrt());
        assert!((0.91..=0.98).contains(&share), "{noise_um} um: truth inside {held} of {all}");
        assert!((0.85..1.15).contains(&rms), "{noise_um} um: standard errors off by {rms}");
    }
}

#[test]
fn no_gap_is_no_gap_at_any_noise() {
    let mut model = instrument();
    model.effects.clear();
    let sweep = elbow(1001, growing, &model.robot);
    for (noise_um, seed) in [(1.0, 1), (20.0, 2), (100.0, 3), (100.0, 4)] {
        let found = identify(&model.robot, &[run(&model, &sweep, noise_um, seed)], &Options::default()).unwrap();
        let e1 = &found.gaps.joints[0];
        assert!(!e1.significant && e1.schedule.is_none(), "{noise_um} um: {:?}", e1.ci95.map(f64::to_degrees));
    }
}

#[test]
fn noise_does_not_shatter_a_deadzone_though_the_printed_algorithm_does() {
    let model = instrument();
    let sweep = sample("growing_sine", &model.robot);
    let clean = run(&model, &sweep, 0.0, 1);
    let noisy = run(&model, &sweep, 100.0, 1);
    // thresholds that suit the noise-free log: 0.05 deg/s of the motor, 0.02 mm/s of the tip
    let printed = |log: &Log| {
        let found = identify(&model.robot, std::slice::from_ref(log), &Options::default()).unwrap();
        let sizes = as_printed(&model.robot, std::slice::from_ref(log), &Options::default(), &found, 0.05, 2e-5);
        (found, sizes)
    };
    let (found, sizes) = printed(&clean);
    for (j, (_, s)) in found.joints.iter().zip(&sizes) {
        let mean = |v: Vec<f64>| v.iter().sum::<f64>() / v.len() as f64;
        let ours = mean(j.deadzones.iter().map(|d| d.size).collect());
        // both know the deadzones of a log without noise, the printed one to a row
        assert!((s.len() as i64 - j.deadzones.len() as i64).abs() <= 6, "{} for {}", s.len(), j.deadzones.len());
        let theirs = mean(s.iter().copied().filter(|v| *v > 0.5 * ours).collect());
        assert!((theirs / ours - 1.0).abs() < 0.15, "{theirs} for {ours}");
    }
    let (found, sizes) = printed(&noisy);
    for (j, (_, s)) in found.joints.iter().zip(&sizes) {
        assert!(j.deadzones.len() >= 40, "{}", j.deadzones.len());
        // rows of a tracker with 100 um at 5 Hz seem to move at 0.7 mm/s: next to nothing is at rest for two rows together
        let mean = s.iter().sum::<f64>() / s.len().max(1) as f64;
        let ours = j.deadzones.iter().map(|d| d.size).sum::<f64>() / j.deadzones.len() as f64;
        assert!(s.is_empty() || mean < 0.5 * ours, "as printed: {} deadzones of mean {mean}", s.len());
    }
    // a threshold above the noise finds rests everywhere, many for each deadzone
    let all = as_printed(&model.robot, &[noisy], &Options::default(), &found, 0.05, 6e-4);
    for (j, (_, s)) in found.joints.iter().zip(all) {
        let ours = j.deadzones.len();
        assert!(2 * s.len() > 3 * ours, "{} deadzones as printed, {ours} ours", s.len());
    }
}

/// Each place's interval, the other way: rows of two logs give what the whole log gives.
#[test]
fn several_logs_count_together_and_one_log_counts_once() {
    let model = instrument();
    let robot = &model.robot;
    let whole = identify(robot, &[run(&model, &elbow(1001, growing, robot), 50.0, 1)], &Options::default()).unwrap();
    let logs: Vec<Log> = (1..=2).map(|seed| run(&model, &elbow(1001, growing, robot), 50.0, seed)).collect();
    let both = identify(robot, &logs, &Options::default()).unwrap();
    assert_eq!(both.joints[0].deadzones.len(), 2 * whole.joints[0].deadzones.len());
    let width = |f: &Found| f.gaps.joints[0].ci95[1] - f.gaps.joints[0].ci95[0];
    assert!((width(&both) / width(&whole) * 2f64.sqrt() - 1.0).abs() < 0.15);
    let twice = identify(robot, &[logs[0].clone(), logs[0].clone()], &Options::default());
    assert!(matches!(twice, Err(Error::BadInput(e)) if e.found.contains("given before")));
}

#[test]
fn a_fifth_of_the_rows_may_be_missing() {
    let model = instrument();
    let mut log = run(&model, &elbow(1001, growing, &model.robot), 50.0, 1);
    let full = identify(&model.robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    let mut state = 7u64;
    for p in &mut log.tcp_m {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        if (state >> 33).is_multiple_of(5) {
            *p = None;
        }
    }
    let found = identify(&model.robot, &[log], &Options::default()).unwrap();
    let (a, b) = (&full.joints[0], &found.joints[0]);
    assert!(b.deadzones.len() + 2 >= a.deadzones.len(), "{} of {}", b.deadzones.len(), a.deadzones.len());
    let z = b.deadzones.iter().map(|d| ((d.size - of_model(&model, d)) / d.sigma).abs());
    assert!(z.filter(|z| *z > 1.96).count() <= 3);
}

#[test]
fn outliers_of_the_tracker_are_left_out() {
    let model = instrument();
    let mut log = run(&model, &elbow(1001, growing, &model.robot), 50.0, 1);
    for p in log.tcp_m.iter_mut().skip(13).step_by(97).flatten() {
        p.x += 0.02;
    }
    let found = identify(&model.robot, &[log], &Options::default()).unwrap();
    let j = &found.joints[0];
    assert!(j.outliers > 0 && j.deadzones.len() >= 15, "{} outliers, {}", j.outliers, j.deadzones.len());
    let far = j.deadzones.iter().filter(|d| ((d.size - of_model(&model, d)) / d.sigma).abs() > 4.0).count();
    assert!(far <= 1, "{far} sizes were moved by outliers");
}

#[test]
fn given_thresholds_are_used() {
    let model = instrument();
    let log = run(&model, &elbow(1001, growing, &model.robot), 50.0, 1);
    let options = Options { rest_m: Some(2e-3), ..Options::default() };
    let wide = identify(&model.robot, std::slice::from_ref(&log), &options).unwrap();
    let own = identify(&model.robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    assert_eq!(wide.joints[0].radius_m, 2e-3);
    assert!((own.joints[0].radius_m * 1e6 / 250.0 - 1.0).abs() < 0.15, "5 sigma of 50 um");
    assert!(wide.joints[0].deadzones.len() < own.joints[0].deadzones.len(), "short strokes are no longer read");
    // a dead band above the whole motion leaves no turn
    let deaf = Options { deadband: vec![Some(2.0); 4], ..Options::default() };
    assert!(matches!(identify(&model.robot, &[log], &deaf), Err(Error::BadInput(_))));
}

/// An encoder in the place of a command turns by its noise all the time; the dead band comes from the log.
#[test]
fn a_noisy_motor_position_makes_no_turns_of_its_own() {
    let model = instrument();
    let mut log = run(&model, &elbow(1001, growing, &model.robot), 50.0, 1);
    let turns = identify(&model.robot, std::slice::from_ref(&log), &Options::default()).unwrap().joints[0].turns;
    let mut state = 3u64;
    for v in &mut log.cmd[0] {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        *v += 2e-4 * ((state >> 33) as f64 / f64::from(u32::MAX >> 1) - 0.5);
    }
    let found = identify(&model.robot, &[log], &Options::default()).unwrap();
    assert!(found.joints[0].turns.abs_diff(turns) <= 2, "{} turns for {turns}", found.joints[0].turns);
}

fn message(result: lostmotion::error::Result<Found>) -> String {
    match result {
        Err(Error::BadInput(e)) => e.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_motion_that_is_no_sweep_is_refused_with_what_it_is() {
    let model = instrument();
    let of = |points: usize, angle: &dyn Fn(f64) -> f64| {
        message(identify(
            &model.robot,
            &[run(&model, &elbow(points, angle, &model.robot), 50.0, 1)],
            &Options::default(),
        ))
    };
    assert!(of(300, &|t| 0.5 * t).contains("a motion without reversals"));
    assert!(of(300, &|_| 0.0).contains("commands that do not move"));
    let small = of(600, &|t| (std::f64::consts::TAU * t / 20.0).sin());
    assert!(small.contains("the strokes are smaller than the gap") && small.contains("2.0000 deg"), "{small}");
    let kuka = crate::bench::kuka();
    let circle = Log::load(&bundled("samples/circle/circle_uncompensated_table3.csv.gz"), &kuka).unwrap();
    let together = message(identify(&kuka, &[circle], &Options::default()));
    assert!(
        together.contains("a motion of A1, A2, A3 together") && together.contains("one joint at a time"),
        "{together}"
    );
    let poses = parse(
        "cmd_e1_deg,cmd_e2_deg,cmd_pitch_deg,cmd_yaw_deg,x_mm,y_mm,z_mm\n0,0,0,0,0,0,45\n1,0,0,0,1,0,45\n",
        &model.robot,
    );
    assert!(message(identify(&model.robot, &[poses], &Options::default())).contains("identify static"));
    let log = run(&model, &elbow(1001, growing, &model.robot), 50.0, 1);
    let yaw = Options { axes: vec![3], ..Options::default() };
    assert!(message(identify(&model.robot, &[log], &yaw)).contains("no movement of YAW alone"));
}

#[test]
fn a_sine_that_does_not_grow_gives_its_two_places_and_says_so() {
    let model = instrument();
    let steady = elbow(601, |t| 20.0 * (std::f64::consts::TAU * t / 20.0).sin(), &model.robot);
    let found = identify(&model.robot, &[run(&model, &steady, 50.0, 1)], &Options::default()).unwrap();
    assert!(
        found.gaps.notes.iter().any(|n| n.to_string().contains("the sweep does not grow")),
        "{:?}",
        found.gaps.notes
    );
    assert!(found.joints[0].deadzones.len() >= 10);
}

#[test]
fn the_document_is_one_that_fit_reads() {
    let model = instrument();
    let log = run(&model, &sample("growing_sine", &model.robot), 50.0, 1);
    let found = identify(&model.robot, &[log], &Options::default()).unwrap();
    let doc = document::document(&found, &model.robot);
    assert_eq!(doc["schema"], "lostmotion/gaps/1");
    let text = lostmotion::gaps::file::to_yaml(&doc).unwrap();
    let gaps = Gaps::parse("gaps.yaml", &text, &model.robot).unwrap();
    assert_eq!(gaps.points.len(), found.gaps.points.len());
    let Some(GapCurve::Pchip(curve)) = &gaps.joints[2].schedule else { panic!("PITCH varies") };
    assert_eq!(curve.knots().len(), doc["joints"][2]["band_deg"].as_array().unwrap().len());
    let p = &doc["points"][0];
    let size = (p["to_deg"].as_f64().unwrap() - p["from_deg"].as_f64().unwrap()).abs();
    assert!((size / 2.0 - p["half_gap_deg"].as_f64().unwrap()).abs() < 1e-8);
}

#[test]
fn one_joint_in_radians_is_refused_by_the_path_on_which_it_moves_alone() {
    use lostmotion::log::plausibility::{Kinematics, check_for};
    let robot = Robot::load(&bundled("configs/micro-iges-4dof.yaml")).unwrap();
    let log = Log::load(&bundled("samples/instrument/growing_sine_log.csv.gz"), &robot).unwrap();
    assert!(check_for(&log, &robot, Kinematics::Unknown).is_ok());
    // of YAW, which stands near the TCP, this path tells too little
    for axis in 0..robot.dof() - 1 {
        let mut wrong = log.clone();
        for v in &mut wrong.cmd[axis] {
            *v = ((*v * 1e6).round() / 1e6).to_radians(); // the number of radians, read as degrees
        }
        let Err(Error::BadInput(why)) = check_for(&wrong, &robot, Kinematics::Unknown) else { panic!("axis {axis}") };
        let name = &robot.axis(axis).name;
        assert!(why.to_string().contains(name.as_str()) && why.to_string().contains("radians"), "{why}");
    }
}
