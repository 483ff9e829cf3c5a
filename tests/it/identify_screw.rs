//! `identify screw` against two plays in series that `tests/oracle/screw.py` steps in time (its truth: `screw.json`), and the whole
//! chain through the command line.

use crate::support::{WorkFolder, bundled, root, run_from_root};
use lostmotion::error::Error;
use lostmotion::gaps::Gaps;
use lostmotion::identify::screw::flanks::{Flanks, Known};
use lostmotion::identify::screw::start::Start;
use lostmotion::identify::screw::{Found, Series, document, identify};
use lostmotion::io::input::Input;
use lostmotion::log::{Log, plausibility};
use lostmotion::robot::Robot;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::path::{Path, PathBuf};

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

/// The log with one column changed.
fn changed(name: &str, column: &str, change: impl Fn(f64) -> f64) -> String {
    let text = text_of(name);
    let mut lines = text.lines();
    let (comment, head) = (lines.next().unwrap(), lines.next().unwrap());
    let k = head.split(',').position(|c| c == column).unwrap();
    let row = |line: &str| {
        let cell = |(i, c): (usize, &str)| {
            if i == k { format!("{:.7}", change(c.parse().unwrap())) } else { c.into() }
        };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",")
    };
    [comment.to_string(), head.to_string()].into_iter().chain(lines.map(row)).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn units_and_scales_that_cannot_be_right_are_refused() {
    let robot = gantry();
    let refused = |text: &str, robot: &Robot| -> String {
        let log = read(text, robot).unwrap();
        let error = match plausibility::check(&log, robot) {
            Err(e) => e,
            Ok(_) => identify(robot, &[log], None).map(|_| ()).unwrap_err(),
        };
        assert_eq!(lostmotion::cli::exit::code_of(&error), 2);
        error.to_string()
    };
    let degrees = 1f64.to_radians();
    let said = refused(&changed("clean", "enc_Z_deg", |v| v * degrees), &robot);
    assert!(said.contains("values in radians in column `enc_Z_deg"), "{said}");
    let said = refused(&changed("clean", "screw_Z_deg", |v| v / 360.0), &robot);
    assert!(said.contains("values in revolutions in column `screw_Z_deg"), "{said}");
    let said = refused(&changed("clean", "meas_Z_mm", |v| v * 1e-3), &robot);
    assert!(said.contains("values in metres"), "{said}");
    let said = refused(&changed("clean", "meas_Z_mm", |v| -v), &robot);
    assert!(said.contains("the carriage of Z moves by -1.0"), "{said}");
    let said = refused(&changed("clean", "screw_Z_deg", |v| 2.0 * v), &robot);
    assert!(said.contains("`screw_Z` moves by 2.0"), "{said}");
    // a lead of 5 mm in the robot file
    let yaml = std::fs::read_to_string(bundled(ROBOT)).unwrap();
    let other = Robot::parse("r.yaml", &yaml.replace("lead_mm_per_rev: 10", "lead_mm_per_rev: 5")).unwrap();
    let said = refused(&text_of("clean"), &other);
    assert!(said.contains("`enc_Z` moves by 0.5") && said.contains("lead_mm_per_rev"), "{said}");
    // an angle without a lead has no meaning
    let none = Robot::parse("r.yaml", &yaml.replace(", lead_mm_per_rev: 10", "")).unwrap();
    let said = read(&text_of("clean"), &none).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("`enc_Z_deg`: Z in deg") && said.contains("lead_mm_per_rev"), "{said}");
}

#[test]
fn a_dead_sensor_is_no_gap_and_a_log_without_sensors_is_refused() {
    let robot = gantry();
    let log = read(&changed("clean", "meas_Z_mm", |_| -150.0), &robot).unwrap();
    let found = identify(&robot, &[log], None).unwrap();
    assert!(one(&found).both.is_none() && one(&found).at_least.is_none());
    assert!(
        notes(&found).contains("check that this is the sensor of this joint and that it works"),
        "{}",
        notes(&found)
    );
    let bare = text_of("clean").lines().map(|l| l.split(',').take(4).collect::<Vec<_>>().join(",")).collect::<Vec<_>>();
    let log = read(&bare.join("\n"), &robot).unwrap();
    let said = identify(&robot, &[log], None).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("no measurement column"), "{said}");
}

#[test]
fn angles_and_millimetres_of_the_motor_side_say_the_same() {
    let robot = gantry();
    let angle = read(&text_of("clean"), &robot).unwrap();
    let text = changed("clean", "enc_Z_deg", |v| v / 36.0).replace("enc_Z_deg", "enc_Z_mm");
    let way = read(&text, &robot).unwrap();
    let pairs = angle.enc[Z].iter().flatten().zip(way.enc[Z].iter().flatten());
    assert!(pairs.map(|(a, b)| (a.unwrap() - b.unwrap()).abs()).fold(0.0, f64::max) < 1e-9);
    let twice = text_of("clean").replacen("screw_Z_deg", "enc_Z_mm", 1);
    let said = read(&twice, &robot).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("a second column for `enc_Z_mm`"), "{said}");
}

#[test]
fn sides_that_differ_go_through_the_document_into_the_compensator() {
    let robot = gantry();
    let found = found("asymmetric");
    let text = lostmotion::gaps::file::to_yaml(&document::document(&found, &robot)).unwrap();
    let back = Gaps::parse("g.yaml", &text, &robot).unwrap();
    let (a, b) = (back.joints[0].sides.unwrap(), found.gaps.joints[0].sides.unwrap());
    assert!((a.positive - b.positive).abs() < 1e-12 && (a.negative_ci95[1] - b.negative_ci95[1]).abs() < 1e-12);
    let fitted = lostmotion::fit::fit(&robot, &[back], lostmotion::fit::Form::Decay).unwrap();
    let offset = fitted.joints[0].backlash.clone().unwrap();
    assert!((offset.positive.constant().unwrap() - b.positive).abs() < 1e-12);
    assert!((offset.negative.constant().unwrap() - b.negative).abs() < 1e-12);
    let bad = text.replacen("positive_mm: ", "positive_mm: -", 1);
    let said = Gaps::parse("g.yaml", &bad, &robot).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("both, each 0 or more"), "{said}");
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

#[test]
fn val_simulate_puts_the_screw_between_the_two_gaps_as_the_stepped_plays_do() {
    let work = WorkFolder::new();
    let input = work.join("clean.csv");
    std::fs::write(&input, text_of("clean")).unwrap();
    run_from_root(work.path(), &format!("simulate --model {TWO_GAPS} --input {{}}/clean.csv --output {{}}/out.csv"))
        .success();
    let predicted = columns(&std::fs::read_to_string(work.join("out.csv")).unwrap());
    let truth = columns(&text_of("clean"));
    for (name, most) in [("enc_Z_deg", 3e-3), ("screw_Z_deg", 3e-3), ("meas_Z_mm", 1.5e-4)] {
        let off = predicted[name].iter().zip(&truth[name]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < most, "{name}: {off}");
    }
}

/// Distance of a point from a polyline, mm.
fn distance(p: [f64; 3], line: &[[f64; 3]]) -> f64 {
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    line.windows(2)
        .map(|w| {
            let (d, r) = (sub(w[1], w[0]), sub(p, w[0]));
            let s = (dot(r, d) / dot(d, d)).clamp(0.0, 1.0);
            let off = sub(r, d.map(|v| v * s));
            dot(off, off).sqrt()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Lost motion that is left on the path: how far the carriage stands off it, twice (both directions), over the whole gap. The first
/// second is left out: the carriage starts in the middle of its gaps and has to cross them once.
fn left_over(log: &Path, program: &[[f64; 3]]) -> f64 {
    let c = columns(&std::fs::read_to_string(log).unwrap());
    let worst = (0..c["x_mm"].len())
        .filter(|&i| c["t_s"][i] > 1.0)
        .map(|i| distance([c["x_mm"][i], c["y_mm"][i], c["z_mm"][i]], program))
        .fold(0.0, f64::max);
    2.0 * worst / (COUPLING_MM + NUT_MM)
}

#[test]
fn val_from_strokes_to_a_compensated_gantry_program_five_percent_of_the_gap_are_left() {
    let work = WorkFolder::new();
    let at = work.path();
    // the machine without its vibration, to see what the compensation leaves
    let model = std::fs::read_to_string(root().join(TWO_GAPS)).unwrap();
    let still: String = model
        .lines()
        .filter(|l| !l.contains("vibration,"))
        .map(|l| l.replace("../../configs", bundled("configs").to_str().unwrap()) + "\n")
        .collect();
    std::fs::write(at.join("still.yaml"), still).unwrap();
    let program = "samples/screw/gantry_program.csv";
    run_from_root(at, &format!(
            "simulate --model {TWO_GAPS} --input samples/screw/strokes_program.csv --encoders --screws --noise-um 30 --rate-hz 50 \
             --output {{}}/strokes.csv"
        )).success();
    let doc: Value = run_from_root(
        at,
        &format!("identify screw --robot {ROBOT} --log {{}}/strokes.csv --output {{}}/gaps.yaml --json"),
    )
    .success()
    .json();
    for s in doc["series"].as_array().unwrap() {
        for (gap, mm) in [("coupling", COUPLING_MM), ("nut", NUT_MM)] {
            let is = s[gap]["total_gap_mm"].as_f64().unwrap();
            assert!((is / mm - 1.0).abs() < 0.05, "{}: {gap} {is}", s["joint"]);
        }
    }
    run_from_root(at, &format!("fit --robot {ROBOT} --gaps {{}}/gaps.yaml --output {{}}/comp.yaml")).success();
    run_from_root(at, &format!("rewrite --robot {ROBOT} --compensator {{}}/comp.yaml {program} --output {{}}/out.csv"))
        .success();
    for (input, log) in [(program, "before.csv"), ("{}/out.csv", "after.csv")] {
        let line = format!(
            "simulate --model {{}}/still.yaml --input {input} --speed-mm-s 10 --rate-hz 50 --output {{}}/{log}"
        );
        run_from_root(at, &line).success();
    }
    let nominal = columns(&std::fs::read_to_string(root().join(program)).unwrap());
    let points: Vec<[f64; 3]> =
        (0..nominal["x_mm"].len()).map(|i| ["x_mm", "y_mm", "z_mm"].map(|k| nominal[k][i])).collect();
    let (before, after) = (left_over(&at.join("before.csv"), &points), left_over(&at.join("after.csv"), &points));
    assert!(before > 0.9, "{before}");
    assert!(after <= 0.05, "{after} of the gap is left ({before} before)");
}

#[test]
fn settled_strokes_have_no_lag_and_no_word_of_one() {
    let robot = gantry();
    // neither times nor encoder: the command stands for the motor, and nothing trails
    let strip = |text: &str| -> String {
        let keep = |line: &str| {
            line.split(',').enumerate().filter(|(k, _)| *k != 0 && *k != 4).map(|c| c.1).collect::<Vec<_>>().join(",")
        };
        text.lines().map(|l| if l.starts_with('#') { l.to_string() } else { keep(l) } + "\n").collect()
    };
    let text = text_of("clean");
    let head: Vec<&str> = text.lines().find(|l| !l.starts_with('#')).unwrap().split(',').collect();
    assert_eq!((head[0], head[4]), ("t_s", "enc_Z_deg"));
    let log = read(&strip(&text), &robot).unwrap();
    assert!(log.poses && log.enc[Z].is_none());
    let found = identify(&robot, &[log], None).unwrap();
    assert!(one(&found).both.as_ref().unwrap().total_per_lag.is_none());
    assert!(!notes(&found).contains("millisecond"), "{}", notes(&found));
}

#[test]
fn an_encoder_that_stands_still_is_said_to_do_so() {
    let robot = gantry();
    let log = read(&changed("clean", "enc_Z_deg", |_| -90.0), &robot).unwrap();
    let said = identify(&robot, &[log], None).map(|_| ()).unwrap_err();
    assert_eq!(lostmotion::cli::exit::code_of(&said), 2);
    assert!(said.to_string().contains("`enc_Z` stands still while Z moves"), "{said}");
}

#[test]
fn a_negative_gap_of_swapped_columns_is_not_significant() {
    let robot = gantry();
    let text = text_of("clean").replacen("enc_Z_deg", "?", 1).replacen("screw_Z_deg", "enc_Z_deg", 1).replacen(
        '?',
        "screw_Z_deg",
        1,
    );
    let found = identify(&robot, &[read(&text, &robot).unwrap()], None).unwrap();
    let coupling = one(&found).coupling.as_ref().unwrap();
    assert!(coupling.total.ci95[1] < 0.0 && !coupling.significant(), "{coupling:?}");
    assert!(notes(&found).contains("swapped?"), "{}", notes(&found));
    let doc = document::document(&found, &robot);
    assert_eq!(doc["series"][0]["coupling"]["significant"], false);
    assert_eq!(doc["series"][0]["nut"]["significant"], true);
}

#[test]
fn the_page_gives_a_gap_as_an_angle_of_the_screw() {
    let work = WorkFolder::new();
    run_from_root(work.path(), &format!("identify screw --robot {ROBOT} --log {SAMPLE} --report {{}}/g.html"))
        .success();
    let page = std::fs::read_to_string(work.join("g.html")).unwrap();
    // 1.803 deg of the coupling at a lead of 10 mm
    assert!(page.contains("as an angle, deg") && page.contains("1.80"), "no angle");
}
