//! A machine on which everything is wrong, from an independent simulator (`tests/data/diagnose/machine`): the parts are named
//! together, and the model with them predicts another path.

use crate::support::{WorkFolder, run};
use serde_json::Value;
use std::io::Read;

const MACHINE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/diagnose/machine");

/// Measured or predicted points of a log, mm.
fn points(text: &str) -> Vec<[f64; 3]> {
    let mut lines = text.lines().filter(|l| !l.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = ["x_mm", "y_mm", "z_mm"].map(|name| header.iter().position(|h| *h == name).unwrap());
    lines
        .map(|l| {
            let cells: Vec<&str> = l.split(',').collect();
            at.map(|k| cells[k].parse().unwrap())
        })
        .collect()
}

/// rms per coordinate of the difference, um.
fn rms_um(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let squares: f64 = a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).powi(2))).sum();
    1e3 * (squares / (3 * a.len()) as f64).sqrt()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn the_parts_of_a_whole_machine_are_named_together_and_predict_another_path() {
    let desk = WorkFolder::new();
    let path = |name: &str| desk.join(name);
    for name in ["robot.yaml", "excitation.csv.gz", "unseen.csv.gz"] {
        std::fs::copy(format!("{MACHINE}/{name}"), path(name)).unwrap();
    }
    let truth: Value = serde_json::from_slice(&std::fs::read(format!("{MACHINE}/truth.json")).unwrap()).unwrap();
    let out = run(
        desk.path(),
        "diagnose --robot robot.yaml --log excitation.csv.gz --model-out found.yaml --json --report page.html",
    )
    .success()
    .stdout;
    let d: Value = serde_json::from_slice(&out).unwrap();
    // gaps and wind-up that the log does not tell apart are a set
    assert!(d["verdict"] == "named" || d["verdict"] == "named_set", "{d:#}");
    let rounds = d["rounds"].as_array().unwrap();
    for r in rounds.iter().filter(|r| r["set"].as_array().unwrap().len() > 1) {
        assert!(r["effect"].as_str().unwrap().starts_with("backlash") && r["set"][1]["effect"] == "hysteresis", "{r}");
    }
    let found = |effect: &str, joint: &str, key: &str| {
        let round = rounds.iter().find(|r| r["effect"] == effect && r["target"] == joint)?;
        round["parameters"][key]["value"].as_f64()
    };
    for joint in ["X", "Y", "Z"] {
        let (lag, apparent) = (found("servo_lag", joint, "lag_s").unwrap(), truth["lag_s"][joint].as_f64().unwrap());
        assert!((lag - apparent).abs() < 0.15 * apparent + 3e-4, "{joint}: {lag} {apparent}");
    }
    // a gap stands for its friction's wind-up, too
    for part in truth["contributions"].as_array().unwrap().iter().filter(|p| p["part"] == "gap") {
        let joint = part["joint"].as_str().unwrap();
        if part["rms_um"].as_f64().unwrap() > 3.0 {
            let named =
                rounds.iter().any(|r| r["effect"].as_str().unwrap().starts_with("backlash") && r["target"] == joint);
            assert!(named, "{joint}: {d:#}");
        }
    }
    // the largest first, with what is left falling to the end
    let left: Vec<f64> = rounds.iter().map(|r| r["rms_after_um"].as_f64().unwrap()).collect();
    assert!(left.last().unwrap() < &(0.3 * d["gap"]["nuisance_only_rms_um"].as_f64().unwrap()), "{left:?}");
    run(desk.path(), "simulate --model found.yaml --input unseen.csv.gz --output predicted.csv").success();
    let mut text = String::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path("unseen.csv.gz")).unwrap())
        .read_to_string(&mut text)
        .unwrap();
    let predicted = points(&std::fs::read_to_string(path("predicted.csv")).unwrap());
    let error = rms_um(&points(&text), &predicted);
    assert!(error < 8.0, "{error} um on a path that was not fitted");
    assert!(std::fs::metadata(path("page.html")).unwrap().len() > 10_000);
}
