//! A machine whose kinematics differs from its robot file (tendons, links, homing): its gaps are found, compensated, and gone; faults
//! of units are still seen.

use crate::support::{self, Outcome, WorkFolder, bundled, root};
use lostmotion::compensator::Compensator;
use lostmotion::effects::{GapCurve, TransmissionError};
use lostmotion::model::Model;
use lostmotion::robot::Robot;
use serde_json::Value;
use std::path::Path;
use std::sync::LazyLock;

const ROBOT: &str = "configs/micro-iges-4dof.yaml";
const MODEL: &str = "samples/instrument/stretched.model.yaml";
const SHIPPED: &str = "samples/instrument/compensator.yaml";

/// Runs a command line in `work`, the names of bundled files made absolute.
fn run(work: &Path, line: &str) -> Outcome {
    let whole = |a: &str| {
        let bundled = a.starts_with("configs/") || a.starts_with("samples/");
        if bundled { root().join(a).to_str().unwrap().to_string() } else { a.to_string() }
    };
    let args = line.split_whitespace().map(whole);
    support::run_args(work, args)
}

/// Standard output and standard error.
fn done(work: &Path, line: &str) -> (String, String) {
    let out = run(work, line).success();
    (out.text(), out.stderr)
}

/// The chain of the sample's head: the growing sine on the instrument, its gaps, their compensator.
static CHAIN: LazyLock<(WorkFolder, String)> = LazyLock::new(|| {
    let work = WorkFolder::new();
    let w = work.path();
    let simulate = "--rate-hz 5 --noise-um 100 --seed 1";
    done(
        w,
        &format!("simulate --model {MODEL} --input samples/instrument/growing_sine.csv {simulate} --output sweep.csv"),
    );
    let (_, says) = done(w, &format!("identify deadzone --robot {ROBOT} --log sweep.csv --output gaps.yaml"));
    done(w, &format!("fit --robot {ROBOT} --gaps gaps.yaml --output compensator.yaml"));
    (work, says)
});

fn robot() -> Robot {
    Robot::load(&bundled(ROBOT)).unwrap()
}

/// Half gap of command at places of each joint, deg.
fn curve(file: &Path) -> Vec<Vec<f64>> {
    let compensator = Compensator::load(file, &robot()).unwrap();
    assert_eq!(compensator.joints.len(), 4);
    let at = |c: &GapCurve| (-3..=3).map(|k| c.at(f64::from(k) * 10f64.to_radians()).to_degrees()).collect();
    compensator.joints.iter().map(|j| at(&j.backlash.as_ref().unwrap().positive)).collect()
}

#[test]
fn the_shipped_compensator_is_what_the_chain_gives() {
    let (work, _) = &*CHAIN;
    let (ours, shipped) = (curve(&work.join("compensator.yaml")), curve(&bundled(SHIPPED)));
    for (a, b) in ours.iter().flatten().zip(shipped.iter().flatten()) {
        // the last digits may differ from machine to machine
        assert!((a - b).abs() < 1e-4, "{ours:?} {shipped:?}: run the chain of samples/instrument/README.md again");
    }
}

#[test]
fn gaps_behind_a_stretch_are_found_at_the_scale_of_the_commands() {
    let (work, says) = &*CHAIN;
    assert!(says.contains("does not match the path computed with the robot file"), "the difference is noted: {says}");
    let model = Model::load(&bundled(MODEL)).unwrap();
    let found = curve(&work.join("compensator.yaml"));
    for (axis, found) in found.iter().enumerate() {
        // the play stands behind a stretch of 0.75 and a ripple: a gap of b is one of b / (0.75 + ripple') of command
        let (mut gap, mut ripple) = (None, 0.0);
        for e in model.effects.iter().filter(|e| e.axis() == Some(axis)) {
            gap = e.effect.half_gap().or(gap);
            ripple = e.effect.get::<TransmissionError>().map_or(ripple, |t| t.amplitude);
        }
        let gap = gap.unwrap();
        let truth: Vec<f64> = (-3..=3)
            .map(|k| {
                let at = f64::from(k) * 10f64.to_radians();
                // phase 180: -sin(5 q), whose slope is -5 cos(5 q)
                gap.at(at * 0.75).to_degrees() / (0.75 - 5.0 * ripple * (5.0 * at).cos())
            })
            .collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        assert!((mean(found) / mean(&truth) - 1.0).abs() < 0.07, "axis {axis}: {found:?} for {truth:?}");
        // the slope changes within a gap of several degrees, and YAW is noisy: no map of it is significant
        assert!(
            found.iter().zip(&truth).all(|(b, t)| (b / t - 1.0).abs() < 0.2),
            "axis {axis}: {found:?} for {truth:?}"
        );
    }
}

#[test]
fn the_deadzones_of_another_motion_are_gone_with_it() {
    let w = CHAIN.0.path();
    let program = "samples/instrument/random.csv";
    done(w, &format!("rewrite --robot {ROBOT} --compensator compensator.yaml {program} --output out.csv"));
    for (input, log) in [(program, "before.csv"), ("out.csv", "after.csv")] {
        done(
            w,
            &format!("simulate --model {MODEL} --input {input} --rate-hz 5 --noise-um 100 --seed 7 --output {log}"),
        );
    }
    let line =
        format!("assess deadzone --robot {ROBOT} --nominal {program} --before before.csv --after after.csv --json");
    let doc: Value = serde_json::from_str(&done(w, &line).0).unwrap();
    for j in doc["joints"].as_array().unwrap() {
        let r = j["reduction"].as_f64().unwrap();
        assert!((0.9..1.1).contains(&r), "{}: {r}", j["joint"]);
    }
    // compensated twice: nothing to take away is no reduction
    let line =
        format!("assess deadzone --robot {ROBOT} --nominal {program} --before after.csv --after after.csv --json");
    let doc: Value = serde_json::from_str(&done(w, &line).0).unwrap();
    for j in doc["joints"].as_array().unwrap() {
        let holds_zero = j["before"]["ci95"][0].as_f64().unwrap() <= 0.0;
        assert_eq!(j["reduction"].is_null(), holds_zero, "{j}");
    }
    // a log of another motion, and the same motion on another clock
    for other in ["samples/instrument/growing_sine.csv", "samples/instrument/exponential.csv"] {
        let out = run(w, &format!("assess deadzone --robot {ROBOT} --nominal {other} --before before.csv"));
        let says = out.stderr;
        assert!(out.code == Some(2) && says.contains("before.csv: found commands that are"), "{other}: {says}");
    }
}

/// The sweep with columns changed; `cells` starts with t_s.
fn changed(name: &str, change: impl Fn(&mut Vec<f64>)) -> String {
    let text = std::fs::read_to_string(CHAIN.0.path().join("sweep.csv")).unwrap();
    let mut out = String::new();
    for line in text.lines() {
        let cells: Option<Vec<f64>> = line.split(',').map(|c| c.parse().ok()).collect();
        match cells {
            Some(mut cells) => {
                change(&mut cells);
                out += &cells.iter().map(|v| format!("{v:.9}")).collect::<Vec<_>>().join(",");
            }
            None => out += line,
        }
        out.push('\n');
    }
    std::fs::write(CHAIN.0.path().join(name), out).unwrap();
    name.into()
}

#[test]
fn units_are_refused_and_signs_are_noted_where_the_kinematics_is_not_known() {
    let w = CHAIN.0.path();
    let header = std::fs::read_to_string(w.join("sweep.csv")).unwrap();
    let header = header.lines().find(|l| !l.starts_with('#')).unwrap().to_string();
    assert!(header.starts_with("t_s,cmd_E1_deg,cmd_E2_deg,cmd_PITCH_deg,cmd_YAW_deg,x_mm,y_mm,z_mm"), "{header}");
    type Change = fn(&mut Vec<f64>);
    let cases: [(&str, Change, &str); 4] = [
        ("m.csv", |c| c[5..8].iter_mut().for_each(|v| *v *= 1e-3), "x, y and z are in metres"),
        ("um.csv", |c| c[5..8].iter_mut().for_each(|v| *v *= 1e3), "in micrometres"),
        ("in.csv", |c| c[5..8].iter_mut().for_each(|v| *v /= 25.4), "x, y and z are in inches"),
        ("rad.csv", |c| c[1..5].iter_mut().for_each(|v| *v = v.to_radians()), "the commands are in radians"),
    ];
    for (name, change, says) in cases {
        let log = changed(name, change);
        for command in ["identify deadzone", "learn --hidden 2 --output k.yaml"] {
            let out = run(w, &format!("{command} --robot {ROBOT} --log {log}"));
            let said = out.stderr;
            assert!(out.code == Some(2) && said.contains(says), "{command} {name}: {said}");
        }
    }
    let mirrored = changed("mirrored.csv", |c| c[5] = -c[5]);
    let (_, said) = done(w, &format!("identify deadzone --robot {ROBOT} --log {mirrored}"));
    assert!(said.contains("note: mirrored.csv: "), "{said}");
}
