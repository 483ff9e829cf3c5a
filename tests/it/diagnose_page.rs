//! The page of `diagnose`: well-formed, self-contained, complete for every verdict, also where only joints were measured.

use crate::bench::{Bench, kuka};
use crate::diagnose_cli::{BACKLASH, BACKLASH_RUN, NOTCH_RUN, diagnose, log_text};
use crate::report::{draws_only_numbers, named, with_elements};
use crate::support::{self, WorkFolder};
use std::path::Path;

/// Largest page, bytes.
const LARGEST: usize = 1_000_000;

fn titles(html: &str) -> Vec<String> {
    let mut out = Vec::new();
    with_elements(html, |all| out = named(all, "h2").iter().map(|n| n.text().unwrap_or("").to_string()).collect());
    out
}

fn holds(html: &str, sections: &[&str]) {
    let titles = titles(html);
    for s in sections {
        assert!(titles.iter().any(|t| t.contains(s)), "no section `{s}` in {titles:?}");
    }
}

/// Drawings of a kind: those whose name starts so.
fn drawings(html: &str, start: &str) -> usize {
    let mut count = 0;
    with_elements(html, |all| {
        count = named(all, "svg")
            .iter()
            .filter(|n| n.attribute("aria-label").is_some_and(|l| l.starts_with(start)))
            .count();
    });
    count
}

fn sound(html: &str) {
    draws_only_numbers(html);
    assert!(html.len() < LARGEST, "{} bytes", html.len());
    // `url(#name)` is a place in the page itself
    let elsewhere = html.replace("url(#", "");
    for outside in ["http://", "https://", "src=", "@import", "url("] {
        assert!(!elsewhere.contains(outside), "{outside}");
    }
}

#[test]
fn a_named_effect_has_its_verdict_its_action_and_all_drawings() {
    let html = &BACKLASH_RUN.page;
    sound(html);
    assert!(html.contains("Missing: backlash J1. What remains is noise."));
    assert!(html.contains("remove the gap"));
    holds(
        html,
        &[
            "What to do next",
            "The gap falls from",
            "parts that were not fitted",
            "The gap along the path",
            "Gap along the path in space",
            "Each joint alone",
            "What was found",
            "Alternatives",
            "cannot be detected in this log",
            "Test without the catalogue",
            "Noise of",
        ],
    );
    assert_eq!(drawings(html, "gap at the TCP in µm over time"), 1);
    assert_eq!(drawings(html, "Path in space"), 2);
    // J1 without the effects found on it and with it, two others; three joints rest
    assert_eq!(drawings(html, "Error of joint"), 4);
    assert!(html.contains("not visible at any size"), "the frame is free: a zero offset of J1 is a turned frame");
}

#[test]
fn what_is_unknown_stands_first_with_its_place_and_what_to_record() {
    let html = &NOTCH_RUN.page;
    sound(html);
    let titles = titles(html);
    let at =
        |words: &str| titles.iter().position(|t| t.contains(words)).unwrap_or_else(|| panic!("{words}: {titles:?}"));
    // what only stood in for the unknown is put aside, so there is no fall to show
    assert!(at("The remaining structure depends on") < at("The gap along the path"));
    assert!(at("Replaced hypotheses") > 0);
    assert!(html.contains("Unknown: ") && html.contains("to find the rest"));
    assert!(html.contains("The nearest effect of the catalogue"));
}

#[test]
fn several_logs_have_a_strip_each() {
    let folder = WorkFolder::new();
    let text = log_text(BACKLASH);
    let rows: Vec<&str> = text.lines().collect();
    let part = |name: &str, from: usize, to: usize| {
        let path = folder.join(name);
        std::fs::write(&path, format!("{}\n{}\n", rows[0], rows[from..to].join("\n"))).unwrap();
        path
    };
    let (a, b, page) = (part("a.csv", 1, 700), part("b.csv", 700, 1400), folder.join("r.html"));
    let mut command = support::command();
    command.args(["diagnose", "--model", &format!("{BACKLASH}/model.yaml"), "--log"]).arg(a).arg("--log").arg(b);
    command.arg("--report").arg(&page).assert().success();
    let html = std::fs::read_to_string(page).unwrap();
    sound(&html);
    assert_eq!(drawings(&html, "gap at the TCP in µm over time"), 2);
    assert_eq!(drawings(&html, "Path in space"), 4);
}

#[test]
fn settled_poses_are_counted_and_drawn_as_dots() {
    let folder = WorkFolder::new();
    let (log, page) = (folder.join("poses.csv"), folder.join("r.html"));
    let text = log_text(BACKLASH);
    let poses: Vec<&str> = text
        .lines()
        .enumerate()
        .filter(|(i, _)| *i == 0 || i % 15 == 1)
        .map(|(_, l)| l.split_once(',').unwrap().1)
        .collect();
    std::fs::write(&log, poses.join("\n") + "\n").unwrap();
    let mut command = support::command();
    command.args(["diagnose", "--model", &format!("{BACKLASH}/model.yaml"), "--log"]).arg(log);
    command.arg("--report").arg(&page).assert().success();
    let html = std::fs::read_to_string(page).unwrap();
    sound(&html);
    assert_eq!(drawings(&html, "gap at the TCP in µm over pose"), 1);
    assert!(html.contains("class=\"heat dot\""));
}

/// A log of one joint measured behind its gear, with a gap and a little noise.
fn joint_log(path: &Path) {
    let mut bench = Bench::new(kuka(), 0.0);
    let places: Vec<f64> = (-4..=4).map(|k| 0.2 * f64::from(k)).collect();
    let mut rows = bench.rows(1, &[0.1, -0.8, 1.2, 0.0, 0.5, 0.0], &places, 0.05, 3, |_| 1e-4);
    for (i, r) in rows.iter_mut().enumerate() {
        // two incommensurable waves: noise of 2 urad that no effect knows
        r.meas += 2e-6 * ((i as f64 * 12.9898).sin() * 43_758.545_3).fract();
    }
    std::fs::write(path, bench.text(&rows, Some(1))).unwrap();
}

#[test]
fn a_log_of_joints_alone_is_told_in_degrees() {
    let folder = WorkFolder::new();
    let (log, page, model) = (folder.join("joint.csv"), folder.join("r.html"), folder.join("model.yaml"));
    joint_log(&log);
    let robot = std::fs::canonicalize("configs/kuka-kr120-r2500-pro.yaml").unwrap();
    std::fs::write(&model, format!("schema: lostmotion/model/1\nrobot: {}\neffects: []\n", robot.display())).unwrap();
    let mut command = support::command();
    command.arg("diagnose").arg("--model").arg(&model).arg("--log").arg(&log).arg("--report").arg(&page);
    let output = command.assert().success();
    let story = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(story.contains("backlash A2") && story.contains(" deg rms before the diagnosis"), "{story}");
    assert!(!story.contains(" um"), "{story}");
    let html = std::fs::read_to_string(page).unwrap();
    sound(&html);
    assert_eq!(drawings(&html, "gap of the joints in mdeg"), 1);
    assert_eq!(drawings(&html, "Path in space"), 0);
    assert_eq!(drawings(&html, "Error of joint A2"), 2);
}

#[test]
fn the_model_may_be_printed_and_the_words_go_elsewhere() {
    let output = diagnose(BACKLASH).args(["--model-out", "-"]).assert().success();
    let model = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(model.starts_with("schema: lostmotion/model/1") && model.contains("backlash"), "{model}");
    assert!(String::from_utf8_lossy(&output.get_output().stderr).contains("Missing: backlash J1."));
}
