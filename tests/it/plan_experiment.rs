//! `plan-experiment`: programs that a robot can run, promises that noisy logs keep, and a plain no where nothing separates.

use crate::support::{self, WorkFolder};
use lostmotion::diagnose::noise::Noise;
use lostmotion::diagnose::problem::synthetic::{self, Channels};
use lostmotion::diagnose::search::fit;
use lostmotion::model::Model;
use lostmotion::plan::path::{Envelope, EnvelopeOptions};
use lostmotion::plan::question;
use lostmotion::plan::separate::{self, Experiment};
use lostmotion::plan::sizes::Scale;
use lostmotion::plan::{axes_of, motions};
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::path::{Path, PathBuf};

const KUKA: &str = "configs/kuka-kr120-r2500-pro.yaml";
const GANTRY: &str = "configs/gantry-xyz-ballscrew.yaml";
const ARM: &str = "tests/data/catalogue/arm.yaml";

struct Desk {
    folder: WorkFolder,
}

impl Desk {
    fn new() -> Self {
        Self { folder: WorkFolder::new() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// A model file of a robot of this repository.
    fn model(&self, name: &str, robot: &str, rest: &str) -> PathBuf {
        let robot = std::fs::canonicalize(robot).unwrap();
        let path = self.path(name);
        std::fs::write(&path, format!("schema: lostmotion/model/1\nrobot: {}\n{rest}", robot.display())).unwrap();
        path
    }

    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let out = support::run_args(self.folder.path(), args);
        (out.code.unwrap(), out.text(), out.stderr)
    }

    fn plan(&self, args: &[&str]) -> Value {
        let (code, out, err) = self.run(&[&["plan-experiment", "--json"], args].concat());
        assert_eq!(code, 0, "{err}");
        serde_json::from_str(&out).unwrap()
    }
}

/// Range, speed, acceleration and rest at both ends of a written program.
fn can_be_run(program: &Path, robot: &str, pose: Option<&[f64]>) {
    let robot = Robot::load(Path::new(robot)).unwrap();
    let p = Program::load(program, &robot).unwrap();
    let t = p.t_s.clone().unwrap();
    assert_eq!(t[0], 0.0);
    for axis in 0..robot.dof() {
        let (q, joint) = (&p.q[axis], robot.axis(axis));
        let [lo, hi] = joint.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        assert!(q.iter().all(|v| (lo..=hi).contains(v)), "{} leaves its range", joint.name);
        let speed: Vec<f64> = (1..q.len()).map(|i| (q[i] - q[i - 1]) / (t[i] - t[i - 1])).collect();
        let fastest = speed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(fastest <= joint.max_speed.unwrap_or(f64::INFINITY), "{} runs at {fastest}", joint.name);
        let hardest = speed.windows(2).map(|w| (w[1] - w[0]).abs() / (t[1] - t[0])).fold(0.0, f64::max);
        let most = joint.max_accel.unwrap_or(f64::INFINITY);
        assert!(hardest <= most, "{} speeds up at {hardest}", joint.name);
        // from rest to rest: the first and the last step are those of a speed-up
        let step = t[1] - t[0];
        for end in [speed[0], speed[speed.len() - 1]] {
            assert!(end.abs() <= most.min(1e3) * step, "{} does not rest: {end}", joint.name);
        }
        assert_eq!(q[0], q[q.len() - 1], "{} does not come back", joint.name);
        if let Some(pose) = pose {
            assert!((q[0] - pose[axis] * joint.kind.si_per_user_unit()).abs() < 1e-9);
        }
    }
}

#[test]
fn a_program_keeps_the_limits_and_starts_and_ends_at_rest_at_the_pose() {
    let desk = Desk::new();
    let kuka = desk.model("kuka.yaml", KUKA, "effects: []\n");
    let gantry = desk.model("gantry.yaml", GANTRY, "effects: []\n");
    let pose = [40.0, -80.0, 95.0, 10.0, 35.0, -20.0];
    let asked = pose.map(|v| v.to_string()).join(",");
    let kuka = kuka.to_str().unwrap();
    for (k, between) in
        ["backlash:A1,hysteresis:A1", "stiction:A6,backlash:A6", "servo_lag:A3,time_offset"].iter().enumerate()
    {
        let out = desk.path(&format!("p{k}.csv"));
        desk.plan(&[
            "--model",
            kuka,
            "--between",
            between,
            "--pose",
            &asked,
            "--output",
            out.to_str().unwrap(),
            "--duration-s",
            "60",
            "--speed-mm-s",
            "250",
        ]);
        can_be_run(&out, KUKA, Some(&pose));
    }
    let out = desk.path("g.csv");
    let model = gantry.to_str().unwrap();
    desk.plan(&[
        "--model",
        model,
        "--between",
        "backlash:X,stiction:X",
        "--output",
        out.to_str().unwrap(),
        "--rate-hz",
        "10",
    ]);
    can_be_run(&out, GANTRY, None);
}

#[test]
fn every_motion_of_the_library_can_be_run() {
    for (robot, speed_m_s) in [(KUKA, 1.5), (KUKA, 0.02), (GANTRY, 0.3)] {
        let robot = Robot::load(Path::new(robot)).unwrap();
        let options =
            EnvelopeOptions { pose: None, duration_s: 90.0, rate_hz: 25.0, speed_m_s, travel_rad: 0.6, travel_m: 0.2 };
        let envelope = Envelope::new(&robot, &options);
        let axes: Vec<usize> = (0..robot.dof()).collect();
        let library = motions::library(&envelope, &axes, false);
        assert!(library.len() > 4 * robot.dof(), "{} motions", library.len());
        for m in &library {
            assert_eq!(m.rows.first(), m.rows.last(), "{}", m.name);
            assert!((m.rows.len() - 1) as f64 * envelope.step_s <= options.duration_s + 1e-6, "{}", m.name);
            for (axis, [lo, hi]) in envelope.window.iter().enumerate() {
                let joint = robot.axis(axis);
                let inside = |v: f64| v >= lo - 1e-7 && v <= hi + 1e-7;
                assert!(m.rows.iter().all(|r| inside(r[axis])), "{} leaves the window of {}", m.name, joint.name);
                let way = |a: &[f64], b: &[f64]| (b[axis] - a[axis]).abs();
                let fast = m.rows.windows(2).map(|w| way(&w[0], &w[1])).fold(0.0, f64::max) / envelope.step_s;
                assert!(fast <= joint.max_speed.unwrap(), "{}: {} at {fast}", m.name, joint.name);
            }
        }
    }
}

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
#[ignore = "takes long: .ci/run runs it"]
fn a_page_shows_the_motion_and_every_other_one() {
    let desk = Desk::new();
    let model = desk.model("kuka.yaml", KUKA, "effects: []\n");
    let model = model.to_str().unwrap();
    for between in [&["--between", "backlash:A2,hysteresis:A2"][..], &[]] {
        let plan = desk.plan(&[&["--model", model, "--report", "plan.html"], between].concat());
        let page = std::fs::read_to_string(desk.path("plan.html")).unwrap();
        crate::report::draws_only_numbers(&page);
        for motion in plan["motions"].as_array().unwrap() {
            assert!(page.contains(motion["motion"].as_str().unwrap()), "{motion}");
        }
        let moves = if between.is_empty() { 6 } else { 1 };
        crate::report::with_elements(&page, |all| {
            let titles =
                all.iter().filter(|n| n.tag_name().name() == "h3" && n.text().is_some_and(|t| t.starts_with('A')));
            assert_eq!(titles.count(), moves);
        });
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
fn sets_sizes_and_noise_come_from_a_diagnosis() {
    let desk = Desk::new();
    let model = desk.model("kuka.yaml", KUKA, "effects: []\n");
    let document = |set: &str| {
        format!(
            r#"{{"schema": "lostmotion/diagnosis/1", "verdict": "named_set", "noise": {{"sigma_um": 20.0, "phi": 0.5, "share": 0.3}},
            "rounds": [{{"effect": "backlash", "target": "A3", "set": [{set}]}}],
            "effects": [{{"effect": "backlash", "target": "A3", "joint": "A3", "half_gap_deg": 0.0041}},
                        {{"effect": "time_offset", "target": "log", "offset_s": 0.004}}]}}"#
        )
    };
    let two = r#"{"effect": "backlash", "target": "A3", "probability": 0.6}, {"effect": "hysteresis", "target": "A3", "probability": 0.4}"#;
    std::fs::write(desk.path("d.json"), document(two)).unwrap();
    let args = ["--model", model.to_str().unwrap(), "--diagnosis", "d.json", "--output", "p.csv"];
    let plan = desk.plan(&args);
    assert_eq!((plan["question"].as_str(), plan["noise_um"].as_f64()), (Some("diagnosis"), Some(20.0)));
    let set = &plan["sets"][0];
    assert_eq!(set["rivals"][0]["effects"][0]["half_gap_deg"], 0.0041);
    // the alternative without a size of its own is as large as the one that was found
    assert_eq!(set["rivals"][1]["effects"][0]["half_width_deg"], 0.0041);
    assert_eq!(set["beside"][0]["effect"], "time_offset");
    assert_eq!(plan["verdict"], "separable");
    can_be_run(&desk.path("p.csv"), KUKA, None);
    // the same question, the same bytes
    let before = std::fs::read(desk.path("p.csv")).unwrap();
    assert_eq!(desk.plan(&args), plan);
    assert_eq!(std::fs::read(desk.path("p.csv")).unwrap(), before);
    // nothing to decide
    std::fs::write(desk.path("one.json"), document(r#"{"effect": "backlash", "target": "A3", "probability": 1.0}"#))
        .unwrap();
    let plan = desk.plan(&["--model", model.to_str().unwrap(), "--diagnosis", "one.json"]);
    assert_eq!(plan["verdict"], "nothing_to_decide");
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

#[test]
fn two_payloads_are_two_runs_of_one_program() {
    let desk = Desk::new();
    let model = desk.model("arm.yaml", ARM, "effects: []\n");
    let pose = "10,-50,60,20,30,10";
    let args = ["--model", model.to_str().unwrap(), "--pose", pose, "--payload-kg", "30", "--duration-s", "60"];
    let plan = desk.plan(&[&args[..], &["--between", "gravity_compliance:A2,encoder_scale:A2"]].concat());
    let motions = plan["motions"].as_array().unwrap();
    let find = |name: &str| motions.iter().find(|m| m["motion"] == name).unwrap();
    let evidence = |m: &Value| m["evidence"]["expected_2lnl"].as_f64().unwrap();
    let twice = find("sweep A2, two payloads");
    let loads: Vec<f64> = twice["runs"].as_array().unwrap().iter().map(|r| r["payload_kg"].as_f64().unwrap()).collect();
    assert_eq!(loads, [0.0, 30.0]);
    // another load moves the compliance and not the gear
    assert!(evidence(twice) > 2.0 * evidence(find("sweep A2")), "{} {}", evidence(twice), evidence(find("sweep A2")));
    // without masses in the robot file there is no compliance to see, and no such motion
    let kuka = desk.model("kuka.yaml", KUKA, "effects: []\n");
    let plan =
        desk.plan(&["--model", kuka.to_str().unwrap(), "--between", "backlash:A2,stiction:A2", "--duration-s", "60"]);
    assert!(plan["motions"].as_array().unwrap().iter().all(|m| m["runs"].as_array().unwrap().len() == 1));
}

#[test]
fn without_a_question_the_plan_shows_the_whole_catalogue() {
    let desk = Desk::new();
    let model = desk.model("gantry.yaml", GANTRY, "effects: []\n");
    let plan = desk.plan(&["--model", model.to_str().unwrap(), "--output", "p.csv", "--duration-s", "60"]);
    assert_eq!(plan["question"], "catalogue");
    let best = &plan["best"];
    let detectable = best["detectable"].as_array().unwrap();
    let has = |effect: &str, target: &str| detectable.iter().any(|d| d["effect"] == effect && d["target"] == target);
    for axis in ["X", "Y", "Z"] {
        for effect in
            ["backlash", "backlash_position", "backlash_speed", "stiction", "hysteresis", "servo_lag", "encoder_scale"]
        {
            assert!(has(effect, axis), "{effect} {axis}");
        }
    }
    assert!(has("vibration", "tcp") && has("thermal_drift", "tcp") && has("time_offset", "log"));
    let worst = best["worst_ratio"].as_f64().unwrap();
    assert!(plan["motions"].as_array().unwrap().iter().all(|m| m["worst_ratio"].as_f64().unwrap() <= worst));
    assert!(worst > 0.1, "{worst}");
    can_be_run(&desk.path("p.csv"), GANTRY, None);
}

#[test]
fn a_question_that_cannot_be_asked_is_refused() {
    let desk = Desk::new();
    let model = desk.model("gantry.yaml", GANTRY, "effects: []\n");
    let model = model.to_str().unwrap();
    std::fs::write(desk.path("log.json"), "{\"schema\": \"lostmotion/gaps/1\"}").unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&["--between", "backlash:X"], "two alternatives or more"),
        (&["--between", "backlash:X,backlash:X"], "every alternative once"),
        (&["--between", "backlash:X,wobble:X"], "effect `wobble`"),
        (&["--between", "backlash:X,backlash:Q"], "joint `Q`"),
        (&["--between", "backlash:X:half_gap_deg=1,stiction:X"], "half_gap_deg"),
        (&["--between", "backlash:X:half_gap_mm=100,stiction:X"], "no machine has"),
        (&["--pose", "1,2"], "3 numbers"),
        (&["--pose", "1,2,3000"], "Z at 3000 mm"),
        (&["--diagnosis", "log.json"], "lostmotion/diagnosis/1"),
    ];
    for (args, says) in cases {
        let (code, _, err) = desk.run(&[&["plan-experiment", "--model", model, "--output", "p.csv"], args].concat());
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(err.contains(says), "{args:?}: {err}");
        assert!(!desk.path("p.csv").exists());
    }
}
