//! `identify screw` against two plays in series that `tests/oracle/screw.py` steps in time (its truth: `screw.json`), and the whole
//! chain through the command line.
//!
//! Parts:
//! - [`changed_logs`]: logs whose columns were changed.
//! - [`chain`]: document, compensator, programs, page.

mod chain;
mod changed_logs;

use crate::support::{WorkFolder, bundled, run_from_root};
use lostmotion::error::Error;
use lostmotion::identify::screw::flanks::{Flanks, Known};
use lostmotion::identify::screw::start::Start;
use lostmotion::identify::screw::{Found, Series, document, identify};
use lostmotion::io::input::Input;
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::path::PathBuf;

const ROBOT: &str = "configs/gantry-xyz-ballscrew.yaml";
const SAMPLE: &str = "samples/screw/gantry2015_z.csv.gz";
const TWO_GAPS: &str = "samples/models/gantry-2015-two-gaps.model.yaml";
/// Gantry (2015): figure 7 (coupling) and figure 9 (nut), mm.
const COUPLING_MM: f64 = 0.05;
const NUT_MM: f64 = 0.1825;
const Z: usize = 2;

fn gantry() -> Robot {
    Robot::load(&bundled(ROBOT)).unwrap()
}

fn file(name: &str) -> PathBuf {
    bundled(&format!("tests/data/screw/{name}.csv.gz"))
}

fn log(name: &str) -> Log {
    Log::load_lone(&file(name), &gantry(), None).unwrap()
}

fn found(name: &str) -> Found {
    identify(&gantry(), &[log(name)], None).unwrap()
}

fn one(found: &Found) -> &Series {
    assert_eq!(found.series.len(), 1);
    &found.series[0]
}

fn notes(found: &Found) -> String {
    found.gaps.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn truth(name: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("../oracle/screw.json")).unwrap();
    all[name].clone()
}

/// `c_l` and `c_r` of a gap, mm.
fn sides(case: &Value, gap: &str) -> [f64; 2] {
    [0, 1].map(|k| case[gap][k].as_f64().unwrap())
}

fn total(case: &Value, gap: &str) -> f64 {
    let [l, r] = sides(case, gap);
    r - l
}

/// The interval holds a truth in mm (or of no unit, with `per` 1).
fn holds(known: Known, truth: f64, per: f64, what: &str) {
    let [lo, hi] = known.ci95.map(|v| v * per);
    assert!(lo <= truth && truth <= hi, "{what}: {truth} outside {lo} .. {hi}");
}

fn within(flanks: &Flanks, mm: f64, share: f64, what: &str) {
    let is = flanks.total.value * 1e3;
    assert!((is / mm - 1.0).abs() <= share, "{what}: {is} for {mm}");
}

#[test]
fn val_the_figures_of_seed_003_are_found_within_two_percent_through_the_command_line() {
    let work = WorkFolder::new();
    let line = format!(
        "identify screw --robot {ROBOT} --log {SAMPLE} --joint z --json --output {{}}/g.yaml --report {{}}/g.html"
    );
    let doc: Value = run_from_root(work.path(), &line).success().json();
    let z = &doc["series"][0];
    let near = |v: &Value, want: f64| {
        let is = v.as_f64().unwrap();
        assert!((is / want - 1.0).abs() <= 0.02, "{is} for {want}");
    };
    near(&z["coupling"]["total_gap_deg"], 1.8);
    near(&z["coupling"]["total_gap_rad"], 0.0314);
    near(&z["coupling"]["total_gap_mm"], COUPLING_MM);
    near(&z["nut"]["total_gap_mm"], NUT_MM);
    near(&z["both"]["half_gap_mm"], 0.5 * (COUPLING_MM + NUT_MM));
    near(&z["both"]["m_mm_per_rad"], 10.0 / std::f64::consts::TAU);
    assert_eq!(z["separated"], true);
    // figure 4: after the start of the test first
    assert_eq!(z["preload"]["side"], -1);
    assert_eq!(z["preload"]["how"], "move");
    let page = std::fs::read_to_string(work.join("g.html")).unwrap();
    assert!(page.contains("Screw against motor") && page.contains("Carriage against screw"));
    // the file holds what was printed
    let text = std::fs::read_to_string(work.join("g.yaml")).unwrap();
    let file: Value = serde_yaml::from_str(&text).unwrap();
    assert_eq!(file["series"][0]["nut"]["total_gap_mm"], z["nut"]["total_gap_mm"]);
}

#[test]
fn val_left_and_right_and_the_slope_are_those_of_the_stepped_plays() {
    let case = truth("asymmetric");
    let found = found("asymmetric");
    let z = one(&found);
    let (coupling, nut, both) = (z.coupling.as_ref().unwrap(), z.nut.as_ref().unwrap(), z.both.as_ref().unwrap());
    for (flanks, key) in [(coupling, "coupling_mm"), (nut, "nut_mm")] {
        let [l, r] = sides(&case, key);
        holds(flanks.c_l, l, 1e3, key);
        holds(flanks.c_r, r, 1e3, key);
        within(flanks, r - l, 0.02, key);
    }
    holds(nut.slope, case["m_nut"].as_f64().unwrap(), 1.0, "slope");
    let sum = |k: usize| sides(&case, "coupling_mm")[k] + sides(&case, "nut_mm")[k];
    holds(both.c_l, sum(0), 1e3, "c_l of both");
    holds(both.c_r, sum(1), 1e3, "c_r of both");
    let joint = &found.gaps.joints[0];
    let given = joint.sides.expect("the sides differ by more than is known of them");
    assert!((given.positive * 1e3 - sum(1)).abs() < 0.006 && (given.negative * 1e3 + sum(0)).abs() < 0.006);
    assert!(notes(&found).contains("ppm"), "a note reports a slope that is not 1");
}

#[test]
fn val_without_noise_the_gaps_are_exact() {
    let found = found("clean");
    let z = one(&found);
    for (flanks, mm) in [(&z.coupling, COUPLING_MM), (&z.nut, NUT_MM), (&z.both, COUPLING_MM + NUT_MM)] {
        let is = flanks.as_ref().unwrap().total.value * 1e3;
        // the files' last digits are 0.0001 mm and 0.001 deg
        assert!((is - mm).abs() < 1e-4, "{is} for {mm}");
    }
    assert!(found.gaps.joints[0].sides.is_none(), "the sides are alike");
}

/// Noise and vibration as large as the gap, other seeds each time; a few rows are gross errors.
#[test]
fn val_intervals_hold_the_truth_at_the_papers_noise_over_many_seeds() {
    const SEEDS: u64 = 80;
    let robot = gantry();
    let clean = log("clean");
    let mut held = [0; 4];
    let mut near = [0; 2];
    for seed in 0..SEEDS {
        let mut g = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = |sigma: f64| sigma * Distribution::<f64>::sample(&StandardNormal, &mut g);
        let mut log = clean.clone();
        let angle = 0.1 / 360.0 * 0.01;
        for column in [&mut log.enc[Z], &mut log.screw[Z]] {
            column.iter_mut().flatten().for_each(|v| *v = v.map(|v| v + normal(angle)));
        }
        let mut phase = [normal(6.0), normal(6.0)];
        for (i, v) in log.meas[Z].iter_mut().flatten().enumerate() {
            let swing = |f: f64, p: f64| (std::f64::consts::TAU * f * clean.t_s[i] + p).sin();
            let shaken = 60e-6 * swing(12.3, phase[0]) + 25e-6 * swing(31.0, phase[1]) + normal(30e-6);
            phase.iter_mut().for_each(|p| *p += normal(0.15));
            *v = v.map(|v| v + shaken);
        }
        let rows = log.len();
        for _ in 0..10 {
            let row = g.random_range(0..rows);
            if let Some(column) = &mut log.meas[Z] {
                column[row] = column[row].map(|v| v + 0.02);
            }
        }
        let found = identify(&robot, &[log], None).unwrap();
        let z = one(&found);
        let (coupling, nut, both) = (z.coupling.as_ref().unwrap(), z.nut.as_ref().unwrap(), z.both.as_ref().unwrap());
        let totals = [(coupling, COUPLING_MM), (nut, NUT_MM), (both, COUPLING_MM + NUT_MM)];
        for (k, (flanks, mm)) in totals.into_iter().enumerate() {
            held[k] += i32::from(!flanks.total.excludes(mm * 1e-3));
            if k < 2 {
                near[k] += i32::from((flanks.total.value * 1e3 / mm - 1.0).abs() <= 0.02);
            }
        }
        held[3] += i32::from(!both.slope.excludes(1.0));
    }
    // of 80 intervals of 95 %, fewer than 70 hold by chance once in 1000 tries
    assert!(held.iter().all(|h| *h >= 70), "{held:?} of {SEEDS}");
    assert!(near.iter().all(|n| *n >= 78), "within 2 %: {near:?} of {SEEDS}");
}

#[test]
fn without_the_sensor_between_only_the_sum_is_given_and_that_is_said() {
    let found = found("no_screw");
    let z = one(&found);
    assert!(z.coupling.is_none() && z.nut.is_none());
    let both = z.both.as_ref().unwrap();
    within(both, COUPLING_MM + NUT_MM, 0.02, "sum");
    holds(both.total, COUPLING_MM + NUT_MM, 1e3, "sum");
    assert!(notes(&found).contains("cannot be separated, so only their sum is reported"), "{}", notes(&found));
    let doc = document::document(&found, &gantry());
    assert!(doc["series"][0]["coupling"].is_null() && doc["series"][0]["separated"] == false);
}

#[test]
fn one_coordinate_along_the_joint_is_enough_and_other_commands_still_want_three() {
    let found = found("lone_z");
    let z = one(&found);
    holds(z.both.as_ref().unwrap().total, COUPLING_MM + NUT_MM, 1e3, "sum");
    assert!(notes(&found).contains("the tracker has no zero"));
    let work = WorkFolder::new();
    let out =
        run_from_root(work.path(), &format!("identify static --robot {ROBOT} --log tests/data/screw/lone_z.csv.gz"));
    assert_eq!(out.code, Some(2));
    assert!(out.stderr.contains("x, y and z of every reflector"));
}

#[test]
fn val_a_servo_that_trails_by_more_than_the_gap_is_no_gap() {
    // 30 ms at 10 mm/s are 0.3 mm each way, more than the 0.2325 mm of the gaps
    let found = found("servo_lag");
    let both = one(&found).both.as_ref().unwrap();
    holds(both.total, COUPLING_MM + NUT_MM, 1e3, "sum");
    let lag = both.lag_s.unwrap();
    holds(lag, truth("servo_lag")["lag_s"].as_f64().unwrap(), 1.0, "lag");
    assert!((both.total.value * 1e3 - 0.2325).abs() < 0.025);
}

#[test]
fn one_cycle_without_a_preload_gives_the_gaps_and_says_what_it_cannot_tell() {
    let found = found("one_cycle");
    let z = one(&found);
    within(z.coupling.as_ref().unwrap(), COUPLING_MM, 0.02, "coupling");
    holds(z.nut.as_ref().unwrap().total, NUT_MM, 1e3, "nut");
    assert_eq!(z.start, Start::Unknown);
    let said = notes(&found);
    assert!(said.contains("but not the repeatability"), "{said}");
    assert!(said.contains("no preload before the first stroke: the side on which it starts is unknown"), "{said}");
}

#[test]
fn a_log_that_starts_on_a_flank_says_which() {
    let robot = gantry();
    let mut log = log("clean");
    // cut after the preload: the carriage has been pushed upwards to where it stands
    let start = log.t_s.iter().position(|t| *t > 2.6).unwrap();
    let stands = log.cmd[Z][start] * 1e3;
    assert!((stands + 200.0).abs() < 1e-3, "{stands}");
    let cut = |c: &mut Vec<f64>| drop(c.drain(..start));
    cut(&mut log.t_s);
    log.cmd.iter_mut().for_each(cut);
    for columns in [&mut log.enc, &mut log.screw, &mut log.meas] {
        columns.iter_mut().flatten().for_each(|c| drop(c.drain(..start)));
    }
    let found = identify(&robot, &[log], Some(Z)).unwrap();
    assert_eq!(one(&found).start, Start::Flank(1));
}

#[test]
fn strokes_that_never_cross_the_gap_give_its_least_size_and_no_figure() {
    let work = WorkFolder::new();
    let line = format!("identify screw --robot {ROBOT} --log tests/data/screw/short.csv.gz --json");
    let out = run_from_root(work.path(), &line);
    assert!(out.succeeded());
    let doc: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!((doc["series"][0]["at_least_mm"].as_f64().unwrap() - 0.15).abs() < 1e-9);
    assert!(doc["series"][0]["both"].is_null() && doc["joints"].as_array().unwrap().is_empty());
    let said = out.stderr;
    assert!(said.contains("no stroke crossed the gap"), "{said}");
    // the coupling alone was crossed
    let found = found("short");
    holds(one(&found).coupling.as_ref().unwrap().total, COUPLING_MM, 1e3, "coupling");
}

#[test]
fn strokes_a_little_longer_than_the_gap_are_enough_where_noise_is_small() {
    let found = found("little_more");
    let z = one(&found);
    holds(z.coupling.as_ref().unwrap().total, COUPLING_MM, 1e3, "coupling");
    holds(z.nut.as_ref().unwrap().total, NUT_MM, 1e3, "nut");
    within(z.both.as_ref().unwrap(), COUPLING_MM + NUT_MM, 0.02, "both");
    assert!(found.gaps.joints[0].sides.is_none(), "the zero lies 200 mm outside these strokes");
}

#[test]
fn val_three_joints_under_a_tracker_in_a_frame_of_its_own() {
    let case = truth("gantry");
    let found = found("gantry_tracker");
    assert_eq!(found.series.len(), 3);
    for (s, name) in found.series.iter().zip(["X", "Y", "Z"]) {
        let of = &case["joints"][name];
        let both = s.both.as_ref().unwrap();
        holds(both.total, total(of, "coupling_mm") + total(of, "nut_mm"), 1e3, name);
        assert!(both.rms < 13e-6, "{name}: the tracker's noise is 11 um, found {}", both.rms * 1e6);
    }
    holds(found.series[2].both.as_ref().unwrap().slope, 1.0005, 1.0, "slope of Z");
}

fn text_of(name: &str) -> String {
    use std::io::Read;
    let mut text = String::new();
    let bytes = std::fs::File::open(file(name)).unwrap();
    flate2::read::GzDecoder::new(bytes).read_to_string(&mut text).unwrap();
    text
}

fn read(text: &str, robot: &Robot) -> Result<Log, Error> {
    Log::parse(Input { name: "z.csv".into(), bytes: text.as_bytes().to_vec(), sha256: "0".into() }, robot)
}

/// Columns of a log by name.
fn columns(text: &str) -> std::collections::BTreeMap<String, Vec<f64>> {
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let names: Vec<String> = lines.next().unwrap().split(',').map(str::to_string).collect();
    let mut out: std::collections::BTreeMap<String, Vec<f64>> = names.iter().map(|n| (n.clone(), Vec::new())).collect();
    for line in lines {
        for (name, cell) in names.iter().zip(line.split(',')) {
            out.get_mut(name).unwrap().push(cell.parse().unwrap());
        }
    }
    out
}
