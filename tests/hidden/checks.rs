//! Checks of the generator and of the scorer themselves.

use crate::case::{self, Kind};
use crate::diagnose::Diagnosed;
use crate::effects::Effect;
use crate::kinematics::{Pose, apply, forward, frames, gravity_load, rigid_fit, rpy, translation};
use crate::noise::{MDB, Metric, Noise, Spoiled};
use crate::physics::{Grid, Machine, Pchip, STEP_S};
use crate::replay::Folder;
use crate::robots::{self, Joint, Link, Robot};
use crate::{files, outside, paths, score, table};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

fn joint(name: &str, revolute: bool, dh: [f64; 4]) -> Joint {
    Joint {
        name: name.into(),
        revolute,
        theta_rad: dh[0].to_radians(),
        d_m: dh[1],
        a_m: dh[2],
        alpha_rad: dh[3].to_radians(),
        direction: 1.0,
        limits: [-3.0, 3.0],
        max_speed: 3.0,
        max_accel: 10.0,
        lead_m: 0.02,
        home: 0.0,
        swing: 1.0,
    }
}

fn robot(modified: bool, joints: Vec<Joint>, tool_xyz_m: [f64; 3]) -> Robot {
    let links = joints.iter().map(|_| Link { mass_kg: 0.0, com_m: Vector3::zeros() }).collect();
    Robot { name: "check".into(), modified, joints, links, tool_xyz_m, tool_rpy_rad: [0.0; 3], arm: [0, 1, 2] }
}

/// A shoulder that lifts: the TCP by hand is (0, 0.5 + 0.4 cos 30, 0.1 - 0.4 sin 30).
fn shoulder(modified: bool) -> Robot {
    if modified {
        let joints = vec![joint("A1", true, [0.0, 0.1, 0.0, 0.0]), joint("A2", true, [0.0, 0.0, 0.5, -90.0])];
        robot(true, joints, [0.4, 0.0, 0.0])
    } else {
        let joints = vec![joint("A1", true, [0.0, 0.1, 0.5, -90.0]), joint("A2", true, [0.0, 0.0, 0.4, 0.0])];
        robot(false, joints, [0.0; 3])
    }
}

#[test]
fn forward_kinematics_stand_where_a_hand_computed_pose_stands_in_both_conventions() {
    let q = [90f64.to_radians(), 30f64.to_radians()];
    let by_hand = Vector3::new(0.0, 0.5 + 0.4 * 30f64.to_radians().cos(), 0.1 - 0.2);
    for modified in [false, true] {
        let r = shoulder(modified);
        assert!((forward(&r, &r.tool(), &q) - by_hand).norm() < 1e-12);
        let mut turned = r.clone();
        turned.joints[1].direction = -1.0;
        assert!((forward(&turned, &r.tool(), &[q[0], -q[1]]) - by_hand).norm() < 1e-12);
    }
    let slide = robot(false, vec![joint("X", false, [0.0, 0.3, 0.2, 0.0])], [0.0; 3]);
    assert!((forward(&slide, &slide.tool(), &[0.25]) - Vector3::new(0.2, 0.0, 0.55)).norm() < 1e-12);
}

#[test]
fn gravity_turns_an_outstretched_arm_down() {
    let mut r = shoulder(false);
    r.links[1].mass_kg = 10.0;
    let q = [90f64.to_radians(), 30f64.to_radians()];
    let f = frames(&r, &r.tool(), &q);
    // Positive A2 lowers the arm; the mass stands 0.4 cos 30 m out.
    let by_hand = 10.0 * 9.80665 * 0.4 * 30f64.to_radians().cos();
    assert!((gravity_load(&r, &f, 1) - by_hand).abs() < 1e-9);
    assert!(gravity_load(&r, &f, 0).abs() < 1e-9);
}

#[test]
fn a_rigid_fit_gives_back_the_transform() {
    let from: Vec<Vector3<f64>> =
        (0..40).map(|k| Vector3::new((k as f64).sin(), (1.7 * k as f64).cos(), 0.1 * k as f64)).collect();
    let pose: Pose = translation([1.0, -2.0, 0.5]) * rpy([0.1, -0.2, 2.0]);
    let to: Vec<_> = from.iter().enumerate().map(|(k, p)| (k % 7 != 0).then(|| apply(&pose, p))).collect();
    assert!((rigid_fit(&from, &to) - pose).norm() < 1e-12);
}

/// One revolute joint of 1 m under a command, with one effect: the joint's angle (rad) seen at the TCP.
fn angle(command: &[f64], effect: Effect) -> Vec<f64> {
    let r = robot(false, vec![joint("A1", true, [0.0, 0.0, 1.0, 0.0])], [0.0; 3]);
    let grid = Grid::new(vec![command.to_vec()]);
    let rows: Vec<usize> = (0..command.len()).collect();
    let machine = Machine { robot: &r, registration: Pose::identity(), effects: vec![effect], outside: vec![] };
    machine.run(&grid, &rows).iter().map(|p| p.y.atan2(p.x)).collect()
}

/// 0 up to 0.1 rad in 1 s, back down in 1 s.
fn up_and_down() -> Vec<f64> {
    (0..=1000).map(|k| if k <= 500 { k as f64 * 2e-4 } else { 0.2 - k as f64 * 2e-4 }).collect()
}

#[test]
fn backlash_follows_at_half_a_gap_and_stands_still_at_a_reversal() {
    let deg = 1f64.to_radians();
    let q = angle(&up_and_down(), Effect::new("backlash", "A1", &[("half_gap_deg", 0.1)]));
    assert!((q[400] - (0.08 - 0.1 * deg)).abs() < 1e-12);
    assert!((q[505] - (0.1 - 0.1 * deg)).abs() < 1e-12, "still inside the gap");
    assert!((q[900] - (0.02 + 0.1 * deg)).abs() < 1e-12);
}

#[test]
fn stiction_holds_the_joint_at_its_turning_point_and_then_decays() {
    let deg = 1f64.to_radians();
    let q = angle(&up_and_down(), Effect::new("stiction", "A1", &[("spike_deg", 0.1), ("decay_s", 0.5)]));
    assert!((q[400] - 0.08).abs() < 1e-12, "nothing before the first reversal");
    assert!((q[504] - 0.1).abs() < 1e-12, "stands still");
    assert!((q[900] - (0.02 + 0.1 * deg * (-0.8f64 / 0.5).exp())).abs() < 1e-12);
}

#[test]
fn a_lag_trails_a_ramp_by_its_time_and_an_offset_of_the_clock_leads() {
    let ramp: Vec<f64> = (0..=1000).map(|k| k as f64 * 2e-4).collect();
    let lagged = angle(&ramp, Effect::new("servo_lag", "A1", &[("lag_s", 0.03)]));
    assert!((lagged[900] - (0.18 - 0.03 * 0.1)).abs() < 1e-12);
    let led = angle(&ramp, Effect::new("time_offset", "log", &[("offset_s", 0.013)]));
    assert!((led[500] - (0.1 + 0.0013)).abs() < 1e-12);
}

#[test]
fn hysteresis_builds_up_over_its_travel() {
    let deg = 1f64.to_radians();
    let effect = Effect::new("hysteresis", "A1", &[("half_width_deg", 0.1), ("presliding_deg", 1.0)]);
    let q = angle(&up_and_down(), effect);
    let z = 1.0 - (-0.02 / deg).exp();
    assert!((q[100] - (0.02 - 0.1 * deg * z)).abs() < 1e-12);
    let top = 1.0 - (-0.1 / deg).exp();
    let down = -1.0 + (top + 1.0) * (-0.02 / deg).exp();
    assert!((q[600] - (0.08 - 0.1 * deg * down)).abs() < 1e-12);
}

#[test]
fn elements_slip_one_after_another_and_together_lose_the_sum_of_their_halves() {
    let deg = 1f64.to_radians();
    let mut effect = Effect::new("hysteresis", "A1", &[]);
    effect.knots = vec![[0.5, 0.1], [2.0, 0.2]];
    let q = angle(&up_and_down(), effect);
    // 0.0035 rad up (0.2 deg): the first is at 0.4, the second at 0.1 of its half
    let at = 0.0002 * 18.0 / deg;
    assert!((q[18] - (0.0036 - deg * (0.1 * at / 0.5 + 0.2 * at / 2.0))).abs() < 1e-12);
    assert!((q[400] - (0.08 - 0.3 * deg)).abs() < 1e-12, "both have slipped");
    // 1.146 deg after the turn: the first has turned over, the second by 1.146 of 4 deg
    let back = 0.02 / deg;
    assert!((q[600] - (0.08 - deg * (-0.1 + 0.2 * (1.0 - back / 2.0)))).abs() < 1e-12);
}

#[test]
fn the_monotone_cubic_goes_where_scipy_goes() {
    // scipy.interpolate.PchipInterpolator([0, 1, 3, 4], [1, 2, 1.5, 4])
    let curve = Pchip::new(&[[0.0, 1.0], [1.0, 2.0], [3.0, 1.5], [4.0, 4.0]]);
    for (x, y) in SCIPY {
        assert!((curve.at(x) - y).abs() < 1e-12, "{x}: {} for {y}", curve.at(x));
    }
    assert_eq!((curve.at(-1.0), curve.at(9.0)), (1.0, 4.0));
}

const SCIPY: [(f64, f64); 4] =
    [(0.5, 1.6770833333333333), (1.7, 1.8591250000000001), (3.2, 1.650666666666667), (3.9, 3.6532499999999994)];

#[test]
fn noise_has_its_size_and_memory_and_whitens_to_unit_normals() {
    let noise = Noise {
        sigma_um: 10.0,
        ar1: 0.6,
        ar_share: 0.5,
        outlier_share: 0.0,
        dropout_share: 0.0,
        missing_rows: 0,
        round_um: 0.0,
    };
    let n = 60_000;
    let course = noise.course(n, &mut ChaCha8Rng::seed_from_u64(7));
    let correlation = |c: &[f64], lag: usize| {
        c.iter().zip(&c[lag..]).map(|(a, b)| a * b).sum::<f64>() / c.iter().map(|a| a * a).sum::<f64>()
    };
    for axis in 0..3 {
        let c: Vec<f64> = course.iter().map(|v| v[axis]).collect();
        let sigma = (c.iter().map(|v| v * v).sum::<f64>() / n as f64).sqrt();
        assert!((sigma * 1e6 - 10.0).abs() < 0.15, "{sigma}");
        assert!((correlation(&c, 1) - 0.3).abs() < 0.015);
        assert!((correlation(&c, 2) - 0.18).abs() < 0.015);
    }
    let ticks: Vec<usize> = (0..n).collect();
    let white = Metric::new(&noise, &ticks, &course, true).whiten(&course);
    assert!((white.norm_squared() / (3 * n) as f64 - 1.0).abs() < 0.01);
    let x: Vec<f64> = white.iter().step_by(3).copied().collect();
    assert!(correlation(&x, 1).abs() < 0.015);
}

#[test]
fn outliers_and_lost_rows_have_their_shares() {
    let noise = Noise {
        sigma_um: 10.0,
        ar1: 0.0,
        ar_share: 0.5,
        outlier_share: 0.01,
        dropout_share: 0.02,
        missing_rows: 4,
        round_um: 0.0,
    };
    let Spoiled { outliers, empty, missing } = noise.spoil(40_000, &mut ChaCha8Rng::seed_from_u64(3));
    assert!((outliers.len() as f64 / 400.0 - 1.0).abs() < 0.15);
    assert!(outliers.iter().all(|(_, d)| d.norm() > 70e-6));
    let lost = empty.iter().filter(|e| **e).count() as f64;
    assert!((0.015..=0.02).contains(&(lost / 40_000.0)));
    assert_eq!(missing.iter().filter(|m| **m).count(), 4);
}

/// The whole way through the files: the likelihood of the log without the effect against with it is (4.13 k)^2 on average.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn an_effect_of_k_detectable_biases_has_a_likelihood_ratio_of_k_squared() {
    for (kind, k) in [(Kind::Single(10.0, 4), 10.0), (Kind::Single(10.0, 10), 10.0), (Kind::Single(3.0, 13), 3.0)] {
        let mut ratios = Vec::new();
        for seed in 0..3 {
            let case = case::make(kind, 2, seed);
            let dir = tempfile::tempdir().expect("a folder");
            files::write(&case, dir.path());
            let f = Folder::read(dir.path());
            let log = f.log("train.csv");
            let noise = Noise::parse(&f.truth["noise"]);
            let rate = f.truth["train"]["rate_hz"].as_f64().expect("a rate");
            let (model, truth) = (f.predict(&log, &[]), f.predict(&log, &f.effects));
            let kept = crate::replay::without_outliers(&truth, &log.measured);
            let there: Vec<usize> = (0..kept.len()).filter(|k| kept[*k].is_some()).collect();
            let ticks: Vec<usize> = there.iter().map(|&k| (log.log.t_s[k] * rate).round() as usize).collect();
            let at: Vec<_> = there.iter().map(|&k| model[k]).collect();
            let metric = Metric::new(&noise, &ticks, &at, f.given);
            let chi2 = |p: &[Vector3<f64>]| {
                let gap: Vec<_> = there.iter().map(|&k| kept[k].expect("kept") - p[k]).collect();
                metric.whiten(&gap).norm_squared()
            };
            let per_value = chi2(&truth) / (3 * there.len()) as f64;
            assert!((per_value - 1.0).abs() < 0.06, "{per_value}");
            ratios.push(chi2(&model) - chi2(&truth));
        }
        let mean = ratios.iter().sum::<f64>() / 3.0;
        let expected = (k * MDB).powi(2);
        // Spread of one ratio is 2 k 4.13; lost rows take 2 %.
        let spread = 2.0 * k * MDB / 3f64.sqrt();
        assert!((mean - expected).abs() < 3.0 * spread + 0.04 * expected, "{mean} for {expected}");
    }
}

#[test]
fn every_path_on_every_robot_starts_at_rest_and_moves() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for r in robots::each(&mut rng) {
        for kind in paths::KINDS {
            let q = paths::draw(kind, &r, 60_000, &mut rng);
            assert!(!paths::moving(&q).is_empty(), "{kind} on {}", r.name);
            for (j, c) in r.joints.iter().zip(&q) {
                assert_eq!(c.len(), 60_000);
                assert!((c[1] - c[0]).abs() / STEP_S < 1e-3 * j.max_speed, "{kind} on {}", r.name);
                assert!(c.iter().all(|p| (j.limits[0]..=j.limits[1]).contains(p)));
            }
        }
    }
}

#[test]
fn a_robot_file_says_what_the_physics_runs() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for r in robots::each(&mut rng) {
        let again = Robot::parse(&r.yaml());
        let q: Vec<f64> = r.joints.iter().map(|j| j.home + 0.1 * j.swing).collect();
        assert!((forward(&r, &r.tool(), &q) - forward(&again, &again.tool(), &q)).norm() < 1e-12, "{}", r.name);
        assert_eq!(r.links.len(), again.links.len());
    }
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn the_same_seed_makes_the_same_files() {
    for kind in [Kind::Pair, Kind::Bad(9)] {
        let (a, b) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        files::write(&case::make(kind, 5, 9), a.path());
        files::write(&case::make(kind, 5, 9), b.path());
        for name in ["robot.yaml", "model.yaml", "train.csv", "test.csv", "truth.json"] {
            let read = |d: &tempfile::TempDir| std::fs::read(d.path().join(name)).expect("written");
            assert!(read(&a) == read(&b), "{name}");
        }
    }
    assert_ne!(case::make(Kind::Pair, 5, 10).truth, case::make(Kind::Pair, 5, 9).truth);
}

#[test]
fn faults_outside_the_catalogue_are_no_effect_of_it() {
    for kind in outside::KINDS {
        assert!(!crate::truth::NAMES.contains(&kind));
    }
    let case = case::make(Kind::Outside(0), 3, 4);
    assert!(case.truth["train"]["gap_noise_free_rms_um"].as_f64().expect("a number") > 0.0);
    assert_eq!(case.truth["right_verdict"], json!(["unknown"]));
}

fn said(document: Value) -> Diagnosed {
    Diagnosed { document: Some(document), exit: 0, stderr: String::new(), seconds: 0.1 }
}

fn round(effect: &str, target: &str, set: &[(&str, &str)], value: f64, ci95: [f64; 2]) -> Value {
    let set: Vec<Value> = set.iter().map(|(e, t)| json!({"effect": e, "target": t, "probability": 0.5})).collect();
    json!({"effect": effect, "target": target, "set": set, "parameters": {"half_gap_deg": {"value": value, "ci95": ci95}}})
}

fn pair() -> Value {
    json!({"kind": "pair", "right_verdict": ["named", "named_set"], "effects": [
        {"effect": "backlash", "target": "A1", "half_gap_deg": 0.002, "mdb_multiple": 20.0, "also_right": []},
        {"effect": "joint_zero_offset", "target": "A6", "offset_deg": 0.01, "mdb_multiple": 9.0,
         "also_right": [{"effect": "tool_error", "target": "tool"}]}]})
}

#[test]
fn a_diagnosis_that_is_right_scores_right_also_by_an_equal_name() {
    let rounds = json!([
        round("backlash", "A1", &[("backlash", "A1")], 0.0021, [0.0019, 0.0023]),
        round("tool_error", "tool", &[("tool_error", "tool")], 0.0, [0.0, 0.0])
    ]);
    let s = score::judge(&pair(), &said(json!({"verdict": "named", "effects": rounds, "rounds": rounds})));
    assert!(s.verdict_right && s.false_alarms.is_empty() && s.effects.iter().all(|e| e.first && e.right));
    assert_eq!(s.effects[0].inside, (1, 1));
    assert!((s.effects[0].size.expect("a size") - 1.05).abs() < 1e-9);
    assert_eq!(table::f1(&[s], "pair"), (1.0, 1.0));
}

#[test]
fn a_name_that_stands_second_in_a_set_is_right_but_not_first() {
    let rounds = json!([
        round("hysteresis", "A1", &[("hysteresis", "A1"), ("backlash", "a1")], 0.0, [0.0, 0.0]),
        round("stiction", "A3", &[("stiction", "A3")], 0.0, [0.0, 0.0])
    ]);
    let s = score::judge(&pair(), &said(json!({"verdict": "named_set", "effects": rounds, "rounds": rounds})));
    assert!(s.effects[0].right && !s.effects[0].first);
    assert!(!s.effects[1].right);
    assert_eq!(s.false_alarms, ["stiction a3"]);
    assert_eq!(s.effects[1].named, Some(("stiction".into(), "a3".into())));
    let (first, set) = table::f1(&[s], "pair");
    assert!(first == 0.0 && (set - 0.5).abs() < 1e-12);
}

#[test]
fn a_round_that_was_replaced_does_not_count() {
    let rounds = json!([
        round("encoder_scale", "A2", &[("encoder_scale", "A2")], 0.0, [0.0, 0.0]),
        round("backlash", "A1", &[("backlash", "A1")], 0.0025, [0.0024, 0.0026])
    ]);
    let s = score::judge(&pair(), &said(json!({"verdict": "named", "effects": [rounds[1]], "rounds": rounds})));
    assert!(s.effects[0].first && s.false_alarms.is_empty());
    assert_eq!(s.effects[0].inside, (0, 1));
}

#[test]
fn a_name_where_nothing_is_missing_and_a_bad_file_that_passes_score_wrong() {
    let null = json!({"kind": "null", "right_verdict": ["none", "not_observable"], "effects": []});
    let rounds = json!([round("backlash", "A1", &[("backlash", "A1")], 0.1, [0.0, 0.2])]);
    let s = score::judge(&null, &said(json!({"verdict": "named", "effects": rounds, "rounds": rounds})));
    assert!(!s.verdict_right && s.false_alarms == ["backlash a1"]);
    let bad = json!({"kind": "bad", "right_verdict": ["bad_data"], "effects": []});
    let refused = |exit, stderr: &str| Diagnosed { document: None, exit, stderr: stderr.into(), seconds: 0.1 };
    assert!(!score::judge(&bad, &said(json!({"verdict": "named", "rounds": []}))).verdict_right);
    assert!(score::judge(&bad, &refused(2, "train.csv: cmd_A1_deg looks like radians")).verdict_right);
    assert!(!score::judge(&bad, &refused(2, "error: unexpected argument; try '--help'")).verdict_right);
    assert!(!score::judge(&bad, &refused(101, "panicked")).verdict_right);
}

/// Through the program's `simulate`: a found model that is the truth closes the whole gap, the known model none of it.
#[test]
fn a_found_model_that_is_the_truth_closes_the_gap_on_the_second_log() {
    for index in [2, 3] {
        let case = case::make(Kind::Large(4), index, 3);
        let dir = tempfile::tempdir().expect("a folder");
        files::write(&case, dir.path());
        let f = Folder::read(dir.path());
        let found = dir.path().join("found.yaml");
        let all: Vec<Effect> = f.known.iter().chain(&f.effects).cloned().collect();
        let list: String = all.iter().map(|e| format!("  - {}\n", e.yaml())).collect();
        let head = case.model_yaml.split("effects:").next().expect("a head");
        std::fs::write(&found, format!("{head}effects:\n{list}")).expect("written");
        let mut s = score::Score::default();
        score::closure(&f, &found, dir.path(), &mut s);
        assert!(s.closed.expect("simulates") > 0.99 && s.closed_exact.expect("simulates") > 0.97, "{s:?}");
        let mut s = score::Score::default();
        score::closure(&f, &dir.path().join("model.yaml"), dir.path(), &mut s);
        assert!(s.closed.expect("simulates").abs() < 0.02 && s.closed_exact.expect("simulates").abs() < 0.02, "{s:?}");
    }
}
