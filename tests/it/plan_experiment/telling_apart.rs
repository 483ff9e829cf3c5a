//! Alternatives that the proposed motion tells apart, as much as promised, and those that no motion separates.

use super::{Desk, GANTRY, KUKA};
use lostmotion::diagnose::noise::Noise;
use lostmotion::diagnose::problem::synthetic::{self, Channels};
use lostmotion::diagnose::search::fit;
use lostmotion::model::Model;
use lostmotion::plan::path::{Envelope, EnvelopeOptions};
use lostmotion::plan::separate::{self, Experiment};
use lostmotion::plan::sizes::Scale;
use lostmotion::plan::{axes_of, motions, question};
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::path::Path;

/// Plans, runs the truth with noise, diagnoses: the truth is named, alone.
fn is_told_apart(between: &str, truth: &str, named: (&str, &str)) {
    let desk = Desk::new();
    let known = desk.model("known.yaml", KUKA, "effects: []\n");
    let frame = "registration: {xyz_mm: [2650, 1890, -640], rpy_deg: [0.7, -1.4, 143]}";
    let real = desk.model("real.yaml", KUKA, &format!("{frame}\neffects:\n  - {truth}\n"));
    let (known, real) = (known.to_str().unwrap(), real.to_str().unwrap());
    let plan = desk.plan(&["--model", known, "--between", between, "--output", "program.csv"]);
    assert_eq!(plan["verdict"], "separable", "{between}");
    assert!(plan["best"]["evidence"]["probability_named"].as_f64().unwrap() > 0.98);
    let run = [
        "simulate",
        "--model",
        real,
        "--input",
        "program.csv",
        "--output",
        "log.csv",
        "--noise-um",
        "10",
        "--seed",
        "7",
    ];
    assert_eq!(desk.run(&run).0, 0);
    let (code, out, err) = desk.run(&["diagnose", "--model", known, "--log", "log.csv", "--json"]);
    assert_eq!(code, 0, "{err}");
    let diagnosis: Value = serde_json::from_str(&out).unwrap();
    let sets: Vec<&Value> = diagnosis["rounds"].as_array().unwrap().iter().map(|r| &r["set"]).collect();
    assert_eq!(diagnosis["verdict"], "named", "{between}, {truth}: {sets:?}");
    let first = &diagnosis["rounds"][0];
    assert_eq!((first["effect"].as_str().unwrap(), first["target"].as_str().unwrap()), named);
    assert_eq!(first["set"].as_array().unwrap().len(), 1);
}

#[test]
fn a_gap_and_a_short_presliding_are_told_apart_by_the_proposed_motion() {
    let between = "backlash:A2,hysteresis:A2";
    is_told_apart(
        between,
        "{effect: hysteresis, joint: A2, half_width_deg: 0.003, presliding_deg: 0.015}",
        ("hysteresis", "A2"),
    );
    is_told_apart(between, "{effect: backlash, joint: A2, half_gap_deg: 0.003}", ("backlash", "A2"));
}

#[test]
fn a_lag_and_a_shifted_clock_are_told_apart_by_the_proposed_motion() {
    let between = "servo_lag:A2,time_offset";
    is_told_apart(between, "{effect: servo_lag, joint: A2, lag_s: 0.01}", ("servo_lag", "A2"));
    is_told_apart(between, "{effect: time_offset, offset_s: -0.01}", ("time_offset", "log"));
}

#[test]
fn a_gap_that_grows_with_speed_is_told_from_a_constant_one_by_the_proposed_motion() {
    let truth = "{effect: backlash_speed, joint: A2, half_gap_deg: 0.0015, slope_deg_per_mm_s: 0.000015}";
    is_told_apart("backlash:A2,backlash_speed:A2", truth, ("backlash_speed", "A2"));
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn a_gear_ratio_and_a_link_length_are_told_apart_by_the_proposed_motion() {
    let between = "encoder_scale:A2,link_error:A2.a";
    is_told_apart(between, "{effect: encoder_scale, joint: A2, scale_ppm: 100}", ("encoder_scale", "A2"));
    is_told_apart(between, "{effect: link_error, target: A2.a, delta_mm: 0.1}", ("link_error", "A2.a"));
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn what_no_motion_separates_is_said_with_a_reason_and_no_program() {
    let desk = Desk::new();
    let model = desk.model("kuka.yaml", KUKA, "effects: []\n");
    let model = model.to_str().unwrap();
    for (between, why) in [
        ("backlash:A2+backlash:A2,backlash:A2", "gaps in series"),
        ("link_error:A2.d,link_error:A3.d", "parallel axes"),
    ] {
        let args = ["plan-experiment", "--model", model, "--between", between, "--output", "p.csv"];
        let (code, out, _) = desk.run(&args);
        assert_eq!(code, 0, "{between}");
        assert!(out.contains("No motion separates them") && out.contains(why), "{out}");
        assert!(!desk.path("p.csv").exists());
        let plan = desk.plan(&["--model", model, "--between", between]);
        assert_eq!((plan["verdict"].as_str(), plan["best"].is_null()), (Some("inseparable"), true));
        // every motion was tried, every channel too
        assert!(
            plan["motions"].as_array().unwrap().iter().all(|m| m["evidence"]["expected_2lnl"].as_f64().unwrap() < 1.0)
        );
        assert_eq!(plan["channels"].as_array().unwrap().len(), 4);
    }
}

#[test]
fn the_channel_that_would_separate_is_named() {
    let desk = Desk::new();
    let free = desk.model("free.yaml", KUKA, "effects: []\n");
    let fixed = desk.model("fixed.yaml", KUKA, "registration: {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}\neffects: []\n");
    let (free, fixed) = (free.to_str().unwrap(), fixed.to_str().unwrap());
    let plan = desk.plan(&["--model", free, "--between", "joint_zero_offset:A1,frame"]);
    assert_eq!(plan["verdict"], "needs_channel");
    assert_eq!(plan["needs_channel"], "the base, measured");
    assert!(plan["reason"].as_str().unwrap().contains("frame between base and tracker"));
    // with the base measured, the model has a registration: the TCP is enough
    let plan = desk.plan(&["--model", fixed, "--between", "joint_zero_offset:A1,frame"]);
    assert_eq!(plan["verdict"], "separable");
    let plan = desk.plan(&["--model", free, "--between", "joint_zero_offset:A6,tool_error"]);
    assert_eq!(plan["needs_channel"], "two more reflectors on the tool");
}

#[test]
fn noisy_logs_keep_the_promised_evidence_on_average() {
    const DRAWS: u64 = 60;
    let model = Model::ideal(Robot::load(Path::new(GANTRY)).unwrap());
    let options =
        EnvelopeOptions { pose: None, duration_s: 60.0, rate_hz: 25.0, speed_m_s: 0.1, travel_rad: 0.5, travel_m: 0.2 };
    let envelope = Envelope::new(&model.robot, &options);
    let scale =
        Scale { robot: &model.robot, window: &envelope.window, speed_m_s: 0.1, duration_s: 60.0, lost: vec![None; 3] };
    let set = question::between("the alternatives", "backlash:X,stiction:X:decay_s=4", &scale).unwrap();
    let sets = [set];
    // so noisy that the evidence is about twenty
    let sigma = 15e-6;
    let bench = Experiment {
        model: &model,
        envelope: &envelope,
        noise: Noise::white(sigma),
        payload_kg: 5.0,
        channels: Channels::default(),
    };
    let library = motions::library(&envelope, &axes_of(&sets, 3), false);
    let motion = library.iter().find(|m| m.name == "stairs X").unwrap();
    let worth = bench.worth(motion, &sets);
    let c = worth.comparisons.iter().find(|c| c.truth == 0).unwrap();
    assert!(c.evidence > 5.0 && c.evidence < 60.0, "{}", c.evidence);
    let (mut problem, start, whitening) = bench.problem(motion);
    let mut truth = start.clone();
    truth.effects.extend(sets[0].alternatives[0].effects.iter().cloned());
    let mut alternative = start.clone();
    alternative.effects.extend(c.fitted.iter().cloned());
    let (mut sum, mut right) = (0.0, 0);
    for seed in 0..DRAWS {
        synthetic::measure(&mut problem, &truth);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        for p in problem.logs[0].log.tcp_m.iter_mut().flatten() {
            *p += Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(&mut rng) }) * sigma;
        }
        let difference = fit::refit(&problem, &alternative, &[0], &whitening).cost
            - fit::refit(&problem, &truth, &[0], &whitening).cost;
        sum += difference;
        right += u64::from(difference > 0.0);
    }
    // the alternative has one parameter more, which takes one off
    let (mean, expected) = (sum / DRAWS as f64, c.evidence - 1.0);
    let spread = 2.0 * c.evidence.sqrt() / (DRAWS as f64).sqrt();
    println!("{mean} against {expected}, {right} of {DRAWS} right, {} promised", separate::right(c.evidence));
    assert!((mean - expected).abs() < 3.5 * spread, "{mean} against {expected} +- {spread}");
    let share = right as f64 / DRAWS as f64;
    assert!((share - separate::right(c.evidence)).abs() < 0.12, "{share} against {}", separate::right(c.evidence));
}
