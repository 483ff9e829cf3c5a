//! Programs whose notes are lost are known by their Cartesian targets, and programs as they were are not taken for rewritten.

use super::cartesian_circle::{FRAMES, MODEL, circle, written};
use super::vendor_circle::robot;
use crate::support::{self, WorkFolder};
use lostmotion::robot::Robot;
use std::path::Path;

const LANGUAGES: [&str; 5] = ["krl", "rapid", "urscript", "fanuc", "inform"];
/// The gaps of [`MODEL`], and friction after a reversal.
const STICTION: &str = "  - {effect: stiction, joint: A1, spike_deg: 0.0034, decay_s: 5.2}\n  - {effect: stiction, joint: A3, spike_deg: 0.0017, decay_s: 5.2}\n";

/// Exit code and messages of a rewrite of `program` by `model`.
fn rewrite(folder: &Path, model: &str, program: &str, out: &str, more: &[&str]) -> (i32, String) {
    let line = ["rewrite", "--model", model, "--frames", "frames.yaml", program, "--output", out];
    let done = support::run_args(folder, line.iter().chain(more));
    (done.code.unwrap(), done.stderr)
}

fn bench(model: &str) -> (WorkFolder, Robot) {
    let folder = WorkFolder::new();
    std::fs::write(folder.join("robot.yaml"), robot()).unwrap();
    std::fs::write(folder.join("model.yaml"), model).unwrap();
    std::fs::write(folder.join("other.yaml"), model.replace("0.0028", "0.0008").replace("0.0037", "0.0011")).unwrap();
    std::fs::write(folder.join("frames.yaml"), FRAMES).unwrap();
    (folder, Robot::parse("robot.yaml", &robot()).unwrap())
}

fn is_known(folder: &Path, name: &str, more: &[&str]) -> bool {
    let out = format!("out-{name}");
    let (code, said) = rewrite(folder, "model.yaml", name, &out, more);
    assert_eq!(code, 0, "{name} as it was: {said}");
    std::fs::remove_file(folder.join(format!("{out}.lostmotion.json"))).unwrap();
    let (code, said) = rewrite(folder, "model.yaml", &out, &format!("twice-{name}"), more);
    assert!(code == 0 || code == 2 && said.contains("rewritten"), "{name}: {said}");
    code == 2
}

#[test]
fn circles_in_every_language_are_known_without_their_notes() {
    for friction in ["", STICTION] {
        let (folder, arm) = bench(&format!("{MODEL}{friction}"));
        let points = circle(&arm);
        for language in LANGUAGES {
            let (name, text) = written(language, &arm, &points);
            std::fs::write(folder.join(&name), text).unwrap();
            assert!(is_known(folder.path(), &name, &[]), "{language}{friction}");
        }
    }
}

/// No point is added: what is known are orientations that were the same, and heights that were.
#[test]
fn targets_that_shared_their_numbers_are_known_by_them() {
    let (folder, arm) = bench(MODEL);
    let points: Vec<[f64; 6]> = circle(&arm).into_iter().step_by(9).collect();
    for language in LANGUAGES {
        let (name, text) = written(language, &arm, &points);
        std::fs::write(folder.join(&name), text).unwrap();
        assert!(is_known(folder.path(), &name, &["--max-added", "0"]), "{language}");
    }
}

/// A compensator of a third of the size makes other targets: the result of one is no result of the other.
#[test]
fn the_result_of_another_compensator_is_not_taken_for_ones_own() {
    let (folder, arm) = bench(MODEL);
    let (name, text) = written("krl", &arm, &circle(&arm));
    std::fs::write(folder.join(&name), text).unwrap();
    let (code, said) = rewrite(folder.path(), "other.yaml", &name, "small.src", &[]);
    assert_eq!(code, 0, "{said}");
    std::fs::remove_file(folder.join("small.src.lostmotion.json")).unwrap();
    let (code, said) = rewrite(folder.path(), "model.yaml", "small.src", "twice.src", &[]);
    assert_eq!(code, 0, "{said}");
}
