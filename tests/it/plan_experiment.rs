//! `plan-experiment`: programs that a robot can run, and what is asked of them.
//!
//! Parts:
//! - [`telling_apart`]: promises that noisy logs keep, and a plain no where nothing separates.

mod telling_apart;

use crate::support::{self, WorkFolder};
use lostmotion::plan::motions;
use lostmotion::plan::path::{Envelope, EnvelopeOptions};
use lostmotion::program::Program;
use lostmotion::robot::Robot;
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
    // the alternative without its own size is as large as the one that was found
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
