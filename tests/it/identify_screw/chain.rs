//! What follows an identification: the document, the compensator, a simulated and a compensated program, the page.

use super::{COUPLING_MM, NUT_MM, ROBOT, SAMPLE, TWO_GAPS, columns, found, gantry, text_of};
use crate::support::{WorkFolder, bundled, root, run_from_root};
use lostmotion::gaps::Gaps;
use lostmotion::identify::screw::document;
use serde_json::Value;
use std::path::Path;

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
fn the_page_gives_a_gap_as_an_angle_of_the_screw() {
    let work = WorkFolder::new();
    run_from_root(work.path(), &format!("identify screw --robot {ROBOT} --log {SAMPLE} --report {{}}/g.html"))
        .success();
    let page = std::fs::read_to_string(work.join("g.html")).unwrap();
    // 1.803 deg of the coupling at a lead of 10 mm
    assert!(page.contains("as an angle, deg") && page.contains("1.80"), "no angle");
}
