//! `identify static` on the simulator's logs (truth and statistics worked out by `tests/oracle/static_test.py`), on analytic cases,
//! and on logs that lack something.

use assert_cmd::Command;
use lostmotion::effect::GapCurve;
use lostmotion::gaps::Gaps;
use lostmotion::identify::static_test::{Found, Knots, Options, document, identify};
use lostmotion::io::input::{Input, sha256};
use lostmotion::log::Log;
use lostmotion::log::dwells::{DwellOptions, dwells};
use lostmotion::robot::Robot;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::path::{Path, PathBuf};

const JOINTS: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn robot(name: &str) -> Robot {
    Robot::load(&root().join("configs").join(name)).unwrap()
}

fn kuka() -> Robot {
    robot("kuka-kr120-r2500-pro.yaml")
}

fn sample(joint: &str) -> PathBuf {
    root().join(format!("samples/static/single_axis_{joint}.csv.gz"))
}

fn logs(robot: &Robot) -> Vec<Log> {
    JOINTS.iter().map(|j| Log::load(&sample(j), robot).unwrap()).collect()
}

fn truth() -> Value {
    serde_json::from_str(include_str!("../oracle/static_test.json")).unwrap()
}

fn list(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn parse(text: &str, robot: &Robot) -> Log {
    let input = Input { name: "log.csv".into(), bytes: text.into(), sha256: sha256(text.as_bytes()) };
    Log::parse(input, robot).unwrap()
}

/// Largest error of the means over their tolerance (2 % or 0.00005 deg).
fn worst_mean(found: &Found, robot: &Robot) -> f64 {
    let truth = truth();
    let ratios = found.gaps.joints.iter().map(|j| {
        let of = list(&truth[&robot.axis(j.axis).name]["truth_deg"]);
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        (j.half_gap.to_degrees() - mean).abs() / (0.02 * mean).max(5e-5)
    });
    ratios.fold(0.0, f64::max)
}

/// Points whose interval holds the truth, and all points.
fn coverage(found: &Found, robot: &Robot) -> (usize, usize) {
    let truth = truth();
    let (mut held, mut all) = (0, 0);
    for j in &found.joints {
        let want = list(&truth[&robot.axis(j.axis).name]["truth_deg"]);
        for (angle, gap) in j.summary.angles.iter().zip(want) {
            let [lo, hi] = angle.ci95.map(f64::to_degrees);
            held += usize::from((lo..=hi).contains(&gap));
            all += 1;
        }
    }
    (held, all)
}

fn constant(found: &Found) -> Vec<bool> {
    found.gaps.joints.iter().map(|j| j.schedule.is_none()).collect()
}

#[test]
fn val_the_twins_gaps_are_found_with_their_shape() {
    let robot = kuka();
    let found = identify(&robot, &logs(&robot), &Options::default()).unwrap();
    assert!(worst_mean(&found, &robot) < 1.0, "means within 2 % or 0.00005 deg: {}", worst_mean(&found, &robot));
    assert_eq!(constant(&found), [true, false, true, true, false, true], "A2 and A5 vary with position");
    let (held, all) = coverage(&found, &robot);
    let share = held as f64 / all as f64;
    assert!((0.90..=0.99).contains(&share), "truth inside {held} of {all} intervals of 95 %");
    let truth = truth();
    for j in [1, 4] {
        let Some(GapCurve::Pchip(curve)) = &found.gaps.joints[j].schedule else { panic!("no schedule") };
        let want = &truth[JOINTS[j]];
        for (at, gap) in list(&want["at_deg"]).into_iter().zip(list(&want["truth_deg"])) {
            let is = curve.at(at.to_radians()).to_degrees();
            assert!((is - gap).abs() <= (0.05 * gap).max(1e-4), "{} at {at}: {is} for {gap}", JOINTS[j]);
        }
    }
    let rms_um = found.gaps.registration.unwrap().rms_m * 1e6;
    assert!((10.7..11.3).contains(&rms_um), "the simulator's noise is 11 um, found {rms_um}");
}

#[test]
fn val_means_and_tests_agree_with_numpy_and_scipy_through_another_kinematics() {
    let robot = kuka();
    let found = identify(&robot, &logs(&robot), &Options::default()).unwrap();
    let oracle = truth();
    for test in &found.joints {
        let want = &oracle[&robot.axis(test.axis).name];
        let means: Vec<f64> = test.summary.means().iter().map(|v| v.to_degrees()).collect();
        for (is, expected) in means.iter().zip(list(&want["half_gap_deg"])) {
            // the oracle projects once, so an error across the joint's motion scales its value by 1e-5
            assert!((is - expected).abs() < 2e-7, "{is} for {expected}");
        }
        let near = |is: f64, key: &str, relative: f64| {
            let expected = want[key].as_f64().unwrap();
            assert!((is / expected - 1.0).abs() < relative, "{key}: {is:e} for {expected:e}");
        };
        near(test.summary.noise.variance.sqrt().to_degrees(), "sigma_deg", 1e-4);
        near(test.summary.noise.dof, "dof", 1e-12);
        let gate = test.summary.gate.unwrap();
        near(gate.p_any_shape, "p_any_shape", 0.01);
        near(gate.p_slope_and_bow.unwrap(), "p_slope_and_bow", 0.01);
        let first = &test.summary.angles[0];
        near((0.5 * (first.ci95[1] - first.ci95[0])).to_degrees(), "half_width_deg", 1e-4);
        for (fit, p) in test.schedule.iter().flat_map(|s| &s.polynomials).zip(list(&want["lack_of_fit_p"])) {
            assert!((fit.p_value / p - 1.0).abs() < 0.01, "degree {}: {:e} for {p:e}", fit.degree, fit.p_value);
        }
    }
}

/// Without `trigger` and `cycle` the dwells come from the commands, and 0.2 s of each are left to the servo. The same joints vary and
/// the means hold; A5 misses the tolerance at single angles (1.5 times), as it does on most seeds of the noise.
#[test]
fn val_the_commands_alone_show_dwells_and_cycles() {
    let robot = kuka();
    let mut logs = logs(&robot);
    for log in &mut logs {
        (log.trigger, log.cycle) = (None, None);
    }
    let found = identify(&robot, &logs, &Options::default()).unwrap();
    assert!(worst_mean(&found, &robot) < 1.0);
    assert_eq!(constant(&found), [true, false, true, true, false, true]);
    assert!(found.joints.iter().all(|j| j.summary.angles.iter().all(|a| a.cycles.len() == 4)));
    let (held, all) = coverage(&found, &robot);
    assert!(held * 100 >= 90 * all, "{held} of {all}");
}

/// Settled poses only: the mean of each dwell, and the turning pose between (as a touch probe or a still tracker would log it).
#[test]
fn val_settled_poses_without_time_give_the_same_gaps() {
    let robot = kuka();
    let mut poses = Vec::new();
    for joint in ["A2", "A6"] {
        let log = Log::load(&sample(joint), &robot).unwrap();
        let axis = robot.axis_named(joint).unwrap();
        let track = lostmotion::effect::Track::new(&log.t_s, &log.cmd[axis], 0.0);
        let mut rows: Vec<(usize, Vec<f64>, Vector3<f64>)> = dwells(&log, &robot, &DwellOptions::default())
            .unwrap()
            .into_iter()
            .map(|d| (d.rows.start, d.command, d.points[0].unwrap().mean))
            .collect();
        rows.extend(track.turns.iter().map(|t| (t.index, log.command(t.index), log.tcp_m[t.index].unwrap())));
        rows.insert(0, (0, log.command(0), log.tcp_m[0].unwrap()));
        rows.sort_by_key(|r| r.0);
        let mut text =
            String::from("index,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm\n");
        for (i, (_, q, p)) in rows.iter().enumerate() {
            let q: Vec<String> = q.iter().map(|v| format!("{:.6}", v.to_degrees())).collect();
            text += &format!("{i},{},{:.5},{:.5},{:.5}\n", q.join(","), p.x * 1e3, p.y * 1e3, p.z * 1e3);
        }
        poses.push(parse(&text, &robot));
    }
    let found = identify(&robot, &poses, &Options::default()).unwrap();
    assert!(worst_mean(&found, &robot) < 1.0, "{}", worst_mean(&found, &robot));
    assert_eq!(constant(&found), [false, true]);
    let truth = truth();
    for (joint, name) in found.joints.iter().zip(["A2", "A6"]) {
        let want = list(&truth[name]["half_gap_deg"]);
        assert_eq!(joint.summary.angles.len(), want.len(), "turning poses are no places of the test");
        for (is, with_time) in joint.summary.means().iter().zip(want) {
            assert!((is.to_degrees() - with_time).abs() < 1e-6);
        }
    }
}

#[test]
fn val_one_log_that_tests_all_joints_one_after_another_gives_the_same_gaps() {
    let robot = kuka();
    let parts = logs(&robot);
    let mut whole = parts[0].clone();
    for part in &parts[1..] {
        let from = whole.t_s.last().unwrap() + 5.0;
        whole.t_s.extend(part.t_s.iter().map(|t| t + from));
        whole.line.extend(&part.line);
        whole.tcp_m.extend(&part.tcp_m);
        whole.cmd.iter_mut().zip(&part.cmd).for_each(|(w, p)| w.extend(p));
        whole.cmd_decimals.iter_mut().zip(&part.cmd_decimals).for_each(|(w, p)| *w = (*w).max(*p));
        whole.trigger.as_mut().unwrap().extend(part.trigger.as_ref().unwrap());
        whole.cycle.as_mut().unwrap().extend(part.cycle.as_ref().unwrap());
    }
    let apart = identify(&robot, &parts, &Options::default()).unwrap();
    let found = identify(&robot, &[whole], &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.len(), 6);
    for (a, b) in found.gaps.joints.iter().zip(&apart.gaps.joints) {
        assert!((a.half_gap - b.half_gap).abs() < 1e-12);
    }
}

// --- analytic cases: only the plumbing, as the crate's own kinematics makes the log ---

/// A machine with known gaps and a tracker somewhere.
struct Bench {
    robot: Robot,
    frame: Isometry3<f64>,
    noise_m: f64,
    rng: ChaCha8Rng,
}

/// One row of a log: commands in rad or m, measured point, where the play stands.
struct Row {
    cmd: Vec<f64>,
    point: Option<Vector3<f64>>,
    meas: f64,
    dwell: bool,
}

impl Bench {
    fn new(robot: Robot, noise_m: f64) -> Self {
        let frame = Isometry3::new(Vector3::new(1.2, -3.4, 0.6), Vector3::new(1.1, -0.4, 2.0));
        Self { robot, frame, noise_m, rng: ChaCha8Rng::seed_from_u64(1) }
    }

    fn row(&mut self, cmd: &[f64], axis: usize, error: f64, dwell: bool) -> Row {
        let mut q = cmd.to_vec();
        q[axis] += error;
        let noise = Normal::new(0.0, self.noise_m).unwrap();
        let p = (self.frame * Point3::from(self.robot.tcp_m(&q))).coords;
        let point = Some(p + Vector3::from_fn(|_, _| noise.sample(&mut self.rng)));
        Row { cmd: cmd.to_vec(), point, meas: q[axis], dwell }
    }

    /// The static test of one axis: places and overshoot in rad or m, a gap for each place.
    fn rows(
        &mut self,
        axis: usize,
        fixed: &[f64],
        places: &[f64],
        past: f64,
        cycles: usize,
        gap: impl Fn(f64) -> f64,
    ) -> Vec<Row> {
        let mut rows = Vec::new();
        let at = |p: f64| {
            let mut q = fixed.to_vec();
            q[axis] = p;
            q
        };
        for &p in places {
            rows.push(self.row(&at(p - past), axis, 0.0, false));
            for _ in 0..cycles {
                for side in [-1.0, 1.0] {
                    rows.push(self.row(&at(p + side * past), axis, 0.0, false));
                    for _ in 0..10 {
                        rows.push(self.row(&at(p), axis, side * gap(p), true));
                    }
                }
            }
        }
        rows
    }

    /// 10 Hz, no trigger.
    fn log(&self, rows: &[Row]) -> Log {
        parse(&self.text(rows, None), &self.robot)
    }

    fn text(&self, rows: &[Row], meas: Option<usize>) -> String {
        let mut text = String::from("t_s");
        for j in self.robot.axis_joints() {
            text += &format!(",cmd_{}_{}", j.name, j.kind.unit());
        }
        if let Some(axis) = meas {
            let j = self.robot.axis(axis);
            text += &format!(",meas_{}_{}", j.name, j.kind.unit());
        } else {
            text += ",x_mm,y_mm,z_mm";
        }
        for (i, row) in rows.iter().enumerate() {
            text += &format!("\n{:.1}", 0.1 * i as f64);
            for (j, v) in self.robot.axis_joints().zip(&row.cmd) {
                text += &format!(",{:.6}", j.kind.to_edge(*v));
            }
            match (meas, row.point) {
                (Some(axis), _) => text += &format!(",{:.7}", self.robot.axis(axis).kind.to_edge(row.meas)),
                (None, Some(p)) => text += &format!(",{:.4},{:.4},{:.4}", p.x * 1e3, p.y * 1e3, p.z * 1e3),
                (None, None) => text += ",,,",
            }
        }
        text + "\n"
    }
}

fn deg(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| v.to_radians()).collect()
}

fn a3_rows(bench: &mut Bench) -> Vec<Row> {
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 50.0, 80.0, 110.0]));
    bench.rows(2, &fixed, &places, 2f64.to_radians(), 4, |_| 0.003f64.to_radians())
}

#[test]
fn a_gap_is_found_within_its_interval_and_the_frame_too() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let j = &found.gaps.joints[0];
    assert_eq!((found.gaps.joints.len(), j.axis, j.significant), (1, 2, true));
    assert!(j.ci95[0] < 0.003f64.to_radians() && 0.003f64.to_radians() < j.ci95[1], "{:?}", j.ci95);
    let frame = found.gaps.registration.unwrap().frame;
    assert!((frame.translation.vector - bench.frame.translation.vector).norm() < 50e-6);
}

#[test]
fn a_bumped_cycle_is_left_out_and_said() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let mut rows = a3_rows(&mut bench);
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    for &i in &dwells[20..30] {
        rows[i].point = rows[i].point.map(|p| p + Vector3::new(0.0, 2e-3, 2e-3)); // the second cycle's first dwell
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let first = &found.joints[0].summary.angles[0];
    assert_eq!((first.cycles.len(), first.dropped.len()), (3, 1));
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
    assert!(found.gaps.notes.iter().any(|n| n.contains("gross errors")), "{:?}", found.gaps.notes);
}

#[test]
fn two_cycles_that_disagree_are_kept_and_flagged() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 40.0, 60.0, 80.0, 110.0]));
    let mut rows = bench.rows(2, &fixed, &places, 2f64.to_radians(), 2, |_| 0.003f64.to_radians());
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    for &i in &dwells[0..10] {
        rows[i].point = rows[i].point.map(|p| p + Vector3::new(1e-3, 1e-3, 1e-3));
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let first = &found.joints[0].summary.angles[0];
    assert_eq!((first.cycles.len(), first.flagged), (2, true));
    assert!(found.gaps.notes.iter().any(|n| n.contains("do not trust it")));
}

#[test]
fn a_missing_cycle_and_a_lost_reflector_leave_the_rest_standing() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let mut rows = a3_rows(&mut bench);
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    // third place: tracker lost for a whole dwell, and for half of another
    for &i in dwells[160..170].iter().chain(&dwells[182..187]) {
        rows[i].point = None;
    }
    // first place: the last downward dwell was cut out of the log
    let cut: Vec<usize> = dwells[70..80].to_vec();
    let mut i = 0;
    rows.retain(|_| {
        i += 1;
        !cut.contains(&(i - 1))
    });
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let cycles: Vec<usize> = found.joints[0].summary.angles.iter().map(|a| a.cycles.len()).collect();
    assert_eq!(cycles, [3, 4, 3, 4]);
    assert_eq!(found.joints[0].unpaired, 1);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
    let notes = found.gaps.notes.join("\n");
    assert!(notes.contains("without the tracker") && notes.contains("without a partner"), "{notes}");
}

#[test]
fn an_approach_from_one_side_gives_no_gap_and_says_so() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let good = a3_rows(&mut bench);
    let fixed = deg(&[0.0, -80.0, 60.0, 0.0, 20.0, 0.0]);
    let one_sided: Vec<Row> = (0..6)
        .flat_map(|k| {
            let mut q = fixed.clone();
            q[0] = (10.0 * f64::from(k)).to_radians();
            (0..10).map(|_| bench.row(&q, 0, 0.0, true)).collect::<Vec<_>>()
        })
        .collect();
    let logs = [bench.log(&good), bench.log(&one_sided)];
    let found = identify(&bench.robot, &logs, &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.len(), 1);
    assert!(
        found.gaps.notes.iter().any(|n| n.starts_with("A1:") && n.contains("one side only")),
        "{:?}",
        found.gaps.notes
    );
    let alone = identify(&bench.robot, &logs[1..], &Options::default()).unwrap();
    assert!(alone.gaps.joints.is_empty() && alone.gaps.registration.is_none());
}

#[test]
fn a_gantry_has_gaps_in_millimetres_even_from_one_axis_alone() {
    let mut bench = Bench::new(robot("gantry-xyz-ballscrew.yaml"), 2e-6);
    let places: Vec<f64> = (1..9).map(|k| 0.1 * f64::from(k)).collect();
    let rows = bench.rows(0, &[0.0, 0.4, -0.2], &places, 5e-3, 4, |_| 50e-6);
    let log = bench.log(&rows);
    let found = identify(&bench.robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    assert!((found.gaps.joints[0].half_gap - 50e-6).abs() < 0.5e-6, "{}", found.gaps.joints[0].half_gap);
    assert!(
        found.gaps.notes.iter().any(|n| n.contains("one line")),
        "the frame is open about the axis, and that is said"
    );
    let doc = document::document(&found, &bench.robot);
    let gap = doc["joints"][0]["half_gap_mm"].as_f64().unwrap();
    assert!((gap - 0.05).abs() < 0.0005);
    assert!(doc["points"][0]["at_mm"].is_number() && doc["joints"][0].get("half_gap_deg").is_none());
}

#[test]
fn other_robots_are_served_alike() {
    for (name, axis, fixed, gap_deg) in [
        ("abb-irb1600-6-145.yaml", 1, vec![20.0, 0.0, 10.0, 30.0, 40.0, 0.0], 0.004),
        ("micro-iges-4dof.yaml", 2, vec![5.0, 10.0, 0.0, -8.0], 0.4),
    ] {
        let mut bench = Bench::new(robot(name), 3e-6);
        let places = deg(&[-20.0, -10.0, 0.0, 10.0, 20.0]);
        let gap = gap_deg.to_owned() * 1f64.to_radians();
        let rows = bench.rows(axis, &deg(&fixed), &places, 3f64.to_radians(), 5, |_| gap);
        let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
        let j = &found.gaps.joints[0];
        assert_eq!(j.axis, axis, "{name}");
        assert!((j.half_gap / gap - 1.0).abs() < 0.01, "{name}: {}", j.half_gap.to_degrees());
        assert!(j.schedule.is_none());
    }
}

#[test]
fn a_log_without_noise_gives_the_gap_and_does_not_take_rounding_for_a_shape() {
    let mut bench = Bench::new(kuka(), 0.0);
    let rows = a3_rows(&mut bench);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let j = &found.gaps.joints[0];
    assert!((j.half_gap.to_degrees() - 0.003).abs() < 1e-5 && j.schedule.is_none());
    assert!(found.gaps.notes.iter().any(|n| n.contains("last digit")));
}

#[test]
fn a_secondary_encoder_needs_no_tracker() {
    let mut bench = Bench::new(kuka(), 0.0);
    let rows = a3_rows(&mut bench);
    let text = bench.text(&rows, Some(2));
    let found = identify(&bench.robot, &[parse(&text, &bench.robot)], &Options::default()).unwrap();
    assert!(found.frame.is_none() && found.joints[0].measured);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-7);
}

#[test]
fn several_logs_of_one_joint_are_pooled() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let logs = [0, 1].map(|_| {
        let rows = a3_rows(&mut bench);
        bench.log(&rows)
    });
    let found = identify(&bench.robot, &logs, &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.len(), 1);
    assert!(found.joints[0].summary.angles.iter().all(|a| a.cycles.len() == 8));
}

#[test]
fn few_places_of_a_gap_that_varies_are_joined_and_not_smoothed() {
    let mut bench = Bench::new(kuka(), 5e-6);
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 50.0, 80.0]));
    let rows = bench.rows(2, &fixed, &places, 2f64.to_radians(), 4, |p| 0.002f64.to_radians() * p);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let Some(GapCurve::Pchip(curve)) = &found.gaps.joints[0].schedule else { panic!("no schedule") };
    assert_eq!(curve.knots().len(), 3);
    assert!(found.gaps.notes.iter().any(|n| n.contains("too few to smooth")));
}

#[test]
fn a_registration_that_is_known_is_taken() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let options = Options { registration: Some(bench.frame), ..Options::default() };
    let found = identify(&bench.robot, &[bench.log(&rows)], &options).unwrap();
    assert!(found.frame.unwrap().given);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
}

#[test]
fn refuses_commands_that_do_not_explain_the_points() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let mut log = bench.log(&rows);
    log.cmd.iter_mut().for_each(|c| c.iter_mut().for_each(|v| *v = v.to_radians()));
    let error = identify(&bench.robot, &[log], &Options::default()).unwrap_err().to_string();
    assert!(error.contains("units"), "{error}");
}

#[test]
fn refuses_the_same_log_twice_and_a_log_without_dwells() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let log = bench.log(&rows);
    let twice = identify(&bench.robot, &[log.clone(), log], &Options::default()).unwrap_err().to_string();
    assert!(twice.contains("given before"), "{twice}");
    let moving: Vec<Row> =
        (0..50).map(|k| bench.row(&deg(&[f64::from(k), -90.0, 90.0, 0.0, 0.0, 0.0]), 0, 0.0, false)).collect();
    let none = identify(&bench.robot, &[bench.log(&moving)], &Options::default()).unwrap_err().to_string();
    assert!(none.contains("no dwell"), "{none}");
}

// --- the document and the command ---

#[test]
fn the_document_reads_back_as_it_was_written_in_yaml_and_json() {
    let robot = kuka();
    for knots in [Knots::All, Knots::Few] {
        let found = identify(&robot, &logs(&robot)[1..5], &Options { knots, ..Options::default() }).unwrap();
        let doc = document::document(&found, &robot);
        for text in [lostmotion::gaps::file::to_yaml(&doc).unwrap(), lostmotion::gaps::file::to_json(&doc).unwrap()] {
            let read = Gaps::parse("gaps", &text, &robot).unwrap();
            let again = lostmotion::gaps::file::document(&read, &robot);
            let first = lostmotion::gaps::file::document(&found.gaps, &robot);
            for key in ["schema", "robot", "logs", "points", "joints", "notes"] {
                assert_eq!(again[key], first[key], "{key}");
            }
            assert!(!text.contains("e-5\n") && !text.contains("NaN"));
        }
    }
}

#[test]
fn refuses_gaps_that_cannot_be_used() {
    let robot = kuka();
    let good = format!(
        "schema: lostmotion/gaps/1\nrobot: {{name: K, sha256: {}}}\nregistration: null\npoints: []\njoints:\n- joint: A1\n  half_gap_deg: 0.0028\n",
        robot.fingerprint()
    );
    assert!(Gaps::parse("g.yaml", &good, &robot).is_ok());
    for (from, to, message) in [
        ("gaps/1", "gaps/9", "schema `lostmotion/gaps/9`"),
        ("joint: A1", "joint: B1", "g.yaml:6: found joint `B1` at joints[0].joint; expected one of A1"),
        ("0.0028", ".inf", "g.yaml:7: found null, or a number that is not finite at joints[0].half_gap_deg"),
        ("0.0028", "text", "found `\"text\"` at joints[0].half_gap_deg"),
        ("half_gap_deg", "half_gap_mm", "g.yaml:6: found nothing at joints[0].half_gap_deg"),
        ("joints:\n", "joints: 3\nrest:\n", "a list"),
        (&robot.fingerprint()[..8], "00000000", "gaps of another robot"),
        ("0.0028", "0.0028\n  schedule: {kind: pchip, knots: [[1, 2], [1, 3]]}", "rising positions"),
        ("0.0028", "0.0028\n  stiction: {spike_deg: 0.003, decay_s: -1}", "decay"),
    ] {
        let error = Gaps::parse("g.yaml", &good.replace(from, to), &robot).map(|_| ()).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(message), "{error}\nlacks {message}");
    }
}

fn command() -> Command {
    let mut c = Command::cargo_bin("lostmotion").unwrap();
    c.current_dir(root()).args(["identify", "static", "--robot", "configs/kuka-kr120-r2500-pro.yaml"]);
    c
}

#[test]
fn the_command_prints_json_writes_yaml_and_is_the_same_on_one_thread() {
    let folder = tempfile::tempdir().unwrap();
    let yaml = folder.path().join("gaps.yaml");
    let args =
        ["--log", "samples/static/single_axis_A2.csv.gz", "--log", "samples/static/single_axis_A6.csv.gz", "--json"];
    let out = command().args(args).arg("--output").arg(&yaml).assert().success();
    let doc: Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
    assert_eq!(doc["schema"], "lostmotion/gaps/1");
    assert_eq!(doc["joints"][0]["joint"], "A2");
    assert_eq!(doc["joints"][0]["schedule"]["kind"], "pchip");
    assert!(doc["joints"][1]["schedule"].is_null());
    assert_eq!(doc["points"].as_array().unwrap().len(), 31);
    assert!(Gaps::load(&yaml, &kuka()).is_ok());
    let one = command().args(args).env("RAYON_NUM_THREADS", "1").assert().success();
    assert_eq!(one.get_output().stdout, out.get_output().stdout);
}

#[test]
fn the_command_shows_a_table_and_refuses_with_the_place() {
    let out = command().args(["--log", "samples/static/single_axis_A4.csv.gz"]).assert().success();
    let table = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(table.contains("A4") && table.contains("18 x 4") && table.contains("constant"), "{table}");
    let missing = command().args(["--log", "nowhere.csv"]).assert().code(2);
    assert!(String::from_utf8_lossy(&missing.get_output().stderr).contains("nowhere.csv"));
    command().args(["--log", "samples/static/single_axis_A4.csv.gz", "--min-dwell-s", "0"]).assert().code(2);
    command().args(["--log", "samples/static/single_axis_A4.csv.gz", "--json", "--output", "-"]).assert().code(2);
}
