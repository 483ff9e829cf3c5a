//! `identify static` on the simulator's logs: truth and statistics worked out by `tests/oracle/static_test.py`.

use crate::bench::{kuka, parse};
use crate::support::{self, WorkFolder, bundled, root};
use assert_cmd::Command;
use lostmotion::effects::GapCurve;
use lostmotion::gaps::Gaps;
use lostmotion::identify::static_test::{Found, Options, identify};
use lostmotion::log::Log;
use lostmotion::log::dwells::{DwellOptions, dwells};
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::PathBuf;

const JOINTS: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];

fn sample(joint: &str) -> PathBuf {
    bundled(&format!("samples/static/single_axis_{joint}.csv.gz"))
}

pub fn logs(robot: &Robot) -> Vec<Log> {
    JOINTS.iter().map(|j| Log::load(&sample(j), robot).unwrap()).collect()
}

fn truth() -> Value {
    serde_json::from_str(include_str!("../oracle/static_test.json")).unwrap()
}

fn list(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
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
        // what decides also allows for creep that these dwells of a second cannot exclude: never a smaller probability
        let plain = (2.0 * gate.p_any_shape.min(gate.p_slope_and_bow.unwrap())).min(1.0);
        assert!(gate.p_value >= 0.999 * plain, "{:e} for {plain:e}", gate.p_value);
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
        let track = lostmotion::effects::Track::new(&log.t_s, &log.cmd[axis], 0.0);
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

// --- the document and the command ---

fn command() -> Command {
    let mut c = support::command();
    c.current_dir(root()).args(["identify", "static", "--robot", "configs/kuka-kr120-r2500-pro.yaml"]);
    c
}

#[test]
fn the_command_prints_json_writes_yaml_and_is_the_same_on_one_thread() {
    let folder = WorkFolder::new();
    let yaml = folder.join("gaps.yaml");
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
