//! `diagnose` from the outside: documents, the model that is written, refusals, steady bytes.

use crate::support::{self, WorkFolder};
use assert_cmd::Command;
use lostmotion::io::input;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

pub const BACKLASH: &str = "tests/data/diagnose/one-backlash";
pub const NOTCH: &str = "tests/data/diagnose/outside-the-catalogue";

pub fn diagnose(case: &str) -> Command {
    let mut command = support::command();
    command.args(["diagnose", "--model", &format!("{case}/model.yaml"), "--log", &format!("{case}/train.csv.gz")]);
    command
}

/// Everything that one run writes.
pub struct Run {
    _folder: WorkFolder,
    pub json: Value,
    pub page: String,
    pub model: PathBuf,
}

fn run(case: &str) -> Run {
    let folder = WorkFolder::new();
    let (page, model) = (folder.join("report.html"), folder.join("found.yaml"));
    let output =
        diagnose(case).arg("--json").arg("--report").arg(&page).arg("--model-out").arg(&model).assert().success();
    let json = serde_json::from_slice(&output.get_output().stdout).unwrap();
    Run { json, page: std::fs::read_to_string(page).unwrap(), model, _folder: folder }
}

pub static BACKLASH_RUN: LazyLock<Run> = LazyLock::new(|| run(BACKLASH));
pub static NOTCH_RUN: LazyLock<Run> = LazyLock::new(|| run(NOTCH));

/// The bundled log as text.
pub fn log_text(case: &str) -> String {
    String::from_utf8(input::read(Path::new(&format!("{case}/train.csv.gz"))).unwrap().bytes).unwrap()
}

fn has(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "no `{key}` in {value}");
    }
}

#[test]
fn the_document_has_every_field_of_its_contract() {
    let d = &BACKLASH_RUN.json;
    has(d, &["schema", "verdict", "samples", "noise", "gap", "rounds", "effects", "unexplained", "blind_spots"]);
    assert_eq!((d["schema"].as_str(), d["verdict"].as_str()), (Some("lostmotion/diagnosis/1"), Some("named")));
    has(&d["noise"], &["sigma_um", "source", "ar1"]);
    has(&d["gap"], &["initial_rms_um", "nuisance_only_rms_um", "final_rms_um", "initial_max_um", "final_max_um"]);
    let round = &d["rounds"][0];
    has(
        round,
        &[
            "effect",
            "target",
            "set",
            "decide_by",
            "where",
            "evidence",
            "parameters",
            "rms_before_um",
            "rms_after_um",
            "rms_after_predicted_um",
            "validation",
        ],
    );
    has(&round["where"], &["joint", "description", "t_s"]);
    has(&round["evidence"], &["statistic", "value", "p_value", "delta_bic"]);
    has(&round["validation"], &["rms_before_um", "rms_after_um"]);
    has(&round["set"][0], &["effect", "target", "probability"]);
    let ci = &round["parameters"]["half_gap_deg"]["ci95"];
    let truth = 0.002_723;
    assert!(ci[0].as_f64().unwrap() < truth && truth < ci[1].as_f64().unwrap() + 2e-5, "{ci}");
    has(&d["blind_spots"][0], &["effect", "target", "detectable_from"]);
}

#[test]
fn what_no_effect_describes_is_said_to_be_unknown() {
    let d = &NOTCH_RUN.json;
    assert_eq!(d["verdict"], "unknown");
    has(&d["unexplained"], &["rms_um", "goes_with", "nearest", "record"]);
    assert!(d["unexplained"]["rms_um"].as_f64().unwrap() > 1.0);
}

/// Truth of the independent simulator: J3 is 0.009922 deg low at 4.3252 deg, a bell of 2.2914 deg.
#[test]
fn what_has_no_name_is_described_by_a_curve_that_helps_where_it_was_not_fitted() {
    let d = &NOTCH_RUN.json;
    let rounds = d["rounds"].as_array().unwrap();
    assert!(!rounds.is_empty() && rounds.iter().all(|r| r["effect"] == "empirical"), "no physical name: {rounds:?}");
    for r in rounds {
        let left = |key: &str| r["validation"][key].as_f64().unwrap();
        assert!(left("rms_after_um") < left("rms_before_um"), "{r}");
        assert!(r["parameters"].as_object().unwrap().values().all(|p| p["ci95"][0].is_number()), "{r}");
    }
    let curve = |at_deg: f64| -> f64 {
        let of = |e: &Value| {
            assert_eq!((e["joint"].as_str(), e["over"].as_str()), (Some("J3"), Some("position")), "{e}");
            let knots: Vec<[f64; 2]> = serde_json::from_value(e["knots"].clone()).unwrap();
            let (x, y) = knots.iter().map(|k| (k[0], k[1])).unzip();
            lostmotion::effects::spline::Spline::new(x, y).unwrap().at(at_deg)
        };
        d["effects"].as_array().unwrap().iter().map(of).sum()
    };
    let (at, width, depth) = (4.3252, 2.2914, 0.009922);
    let found = 0.5 * (curve(at - 4.0 * width) + curve(at + 4.0 * width)) - curve(at);
    assert!((found / depth - 1.0).abs() < 0.1, "{found}");
    let model = std::fs::read_to_string(&NOTCH_RUN.model).unwrap();
    assert!(model.contains("empirical") && model.contains("ci95"), "{model}");
}

#[test]
fn the_written_model_leaves_nothing_to_find_in_the_same_log() {
    let mut again = support::command();
    again.arg("diagnose").arg("--model").arg(&BACKLASH_RUN.model);
    again.args(["--log", &format!("{BACKLASH}/train.csv.gz"), "--json"]);
    let output = again.assert().success();
    let d: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!((d["verdict"].as_str(), d["rounds"].as_array().map(Vec::len)), (Some("none"), Some(0)), "{d}");
}

#[test]
fn simulate_runs_the_written_model() {
    let folder = WorkFolder::new();
    let out = folder.join("predicted.csv");
    let mut simulate = support::command();
    simulate.arg("simulate").arg("--model").arg(&BACKLASH_RUN.model);
    simulate.args(["--input", &format!("{BACKLASH}/train.csv.gz"), "--output"]).arg(&out).assert().success();
    let points = |text: &str| -> Vec<[f64; 3]> {
        let mut lines = text.lines().filter(|l| !l.starts_with('#'));
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let at = ["x_mm", "y_mm", "z_mm"].map(|n| names.iter().position(|c| *c == n).unwrap());
        let cell = |row: &str, k: usize| row.split(',').nth(at[k]).and_then(|c| c.parse().ok()).unwrap_or(f64::NAN);
        lines.map(|row| [0, 1, 2].map(|k| cell(row, k))).collect()
    };
    let (measured, predicted) = (points(&log_text(BACKLASH)), points(&std::fs::read_to_string(out).unwrap()));
    assert_eq!(measured.len(), predicted.len());
    let mut errors: Vec<f64> = measured
        .iter()
        .zip(&predicted)
        .flat_map(|(m, p)| [0, 1, 2].map(|k| (m[k] - p[k]).abs()))
        .filter(|e| e.is_finite())
        .collect();
    errors.sort_by(f64::total_cmp);
    // two thirds of white noise of 8 um lie within 8 um
    let two_thirds_um = 1e3 * errors[errors.len() * 2 / 3];
    assert!(two_thirds_um > 6.0 && two_thirds_um < 10.0, "{two_thirds_um}");
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let folder = WorkFolder::new();
    let written = |threads: &str| {
        let (page, model) = (folder.join("r.html"), folder.join("m.yaml"));
        let mut command = diagnose(BACKLASH);
        command.env("RAYON_NUM_THREADS", threads).arg("--report").arg(&page).arg("--model-out").arg(&model);
        let stdout = command.assert().success().get_output().stdout.clone();
        (stdout, std::fs::read(page).unwrap(), std::fs::read(model).unwrap())
    };
    assert!(written("1") == written("2"));
}

#[test]
fn the_story_fits_a_terminal_and_says_gap_effect_size_and_gap() {
    let output = diagnose(BACKLASH).assert().success();
    let story = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(story.lines().all(|l| l.chars().count() <= 100), "{story}");
    assert!(story.contains(" -> backlash J1 -> 8.") && story.contains("half gap 0.0027"), "{story}");
    assert!(story.contains("Missing: backlash J1. What remains is noise."), "{story}");
    assert!(story.contains("backlash J1: remove the gap"), "{story}");
    assert!(story.contains("Blind to: lost motion and lag of resting J4, J5, J6;"), "{story}");
}

#[test]
fn a_log_that_is_given_twice_is_refused() {
    let folder = WorkFolder::new();
    let copy = folder.join("another name.csv.gz");
    std::fs::copy(format!("{BACKLASH}/train.csv.gz"), &copy).unwrap();
    let output = diagnose(BACKLASH).arg("--log").arg(&copy).assert().code(2);
    let words = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(words.contains("the same log as") && words.contains("every log once"), "{words}");
}

#[test]
fn a_log_in_radians_is_bad_data_with_a_document_and_nothing_written() {
    let folder = WorkFolder::new();
    let (log, page) = (folder.join("radians.csv"), folder.join("r.html"));
    let text = log_text(BACKLASH);
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    let joints: Vec<bool> = header.split(',').map(|c| c.starts_with("cmd_")).collect();
    let mut out = format!("{header}\n");
    for line in lines {
        let cells = line.split(',').zip(&joints).map(|(c, joint)| match c.parse::<f64>() {
            Ok(v) if *joint => format!("{:.8}", v.to_radians()),
            _ => c.to_string(),
        });
        out += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    std::fs::write(&log, out).unwrap();
    let mut command = support::command();
    command.args(["diagnose", "--model", &format!("{BACKLASH}/model.yaml"), "--json", "--report"]).arg(&page);
    let output = command.arg("--log").arg(&log).assert().code(2);
    let d: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(d["verdict"], "bad_data");
    assert!(d["reason"].as_str().unwrap().contains("radians.csv"), "{d}");
    assert!(!page.exists());
}

#[test]
fn paths_with_spaces_are_taken_and_two_documents_on_standard_output_are_not() {
    let folder = WorkFolder::new();
    let here = folder.join("my logs, März");
    std::fs::create_dir(&here).unwrap();
    for name in ["model.yaml", "robot.yaml", "train.csv.gz"] {
        std::fs::copy(format!("{BACKLASH}/{name}"), here.join(name)).unwrap();
    }
    let mut command = support::command();
    command.arg("diagnose").arg("--model").arg(here.join("model.yaml")).arg("--log").arg(here.join("train.csv.gz"));
    command.arg("--report").arg(here.join("a report.html")).assert().success();
    let page = std::fs::read_to_string(here.join("a report.html")).unwrap();
    assert!(page.contains("train.csv.gz") && !page.contains("my logs, März"), "a page names files, not folders");
    diagnose(BACKLASH).args(["--json", "--report", "-"]).assert().code(2);
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    use std::process::Stdio;
    let mut command = support::process();
    command.args([
        "diagnose",
        "--model",
        &format!("{BACKLASH}/model.yaml"),
        "--log",
        &format!("{BACKLASH}/train.csv.gz"),
    ]);
    let mut child = command.arg("--json").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_page_of_the_command_names_every_option_of_its_help() {
    let page = std::fs::read_to_string("docs/diagnose.md").unwrap();
    let cli = lostmotion::cli::help::command();
    let command = cli.find_subcommand("diagnose").unwrap();
    let options: Vec<&str> = command.get_arguments().filter_map(|a| a.get_long()).filter(|l| *l != "help").collect();
    assert!(options.len() >= 6, "{options:?}");
    for option in options {
        assert!(page.contains(&format!("| `--{option}` |")), "--{option}");
    }
    // a long example goes on in a second line
    let help = command.clone().render_long_help().to_string().replace(" \\\n      ", " ");
    for example in help.lines().map(str::trim).filter(|l| l.starts_with("lostmotion diagnose")) {
        assert!(page.contains(example), "{example}");
    }
}

/// The reflector is on the axis of J6: the joint moves and moves no point.
#[test]
fn a_joint_that_moves_without_moving_the_tcp_is_not_called_resting() {
    let work = WorkFolder::new();
    std::fs::copy("configs/abb-irb2400-12-155.yaml", work.join("robot.yaml")).unwrap();
    let model = "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect: backlash, joint: J1, half_gap_deg: 0.01}\n";
    std::fs::write(work.join("model.yaml"), model).unwrap();
    work.run("plan-experiment path --robot robot.yaml --pose 0,0,0,20,40,20 --duration-s 60 --output path.csv")
        .success();
    work.run("simulate --model model.yaml --input path.csv --noise-um 5 --rate-hz 10 --output log.csv").success();
    let found: Value = work.run("diagnose --robot robot.yaml --log log.csv --json").success().json();
    let of_j6 = |s: &&Value| s["target"] == "J6" && s["effect"] == "backlash";
    let spot = found["blind_spots"].as_array().unwrap().iter().find(of_j6).unwrap();
    assert_eq!(
        (spot["detectable_from"].is_null(), spot["reason"].as_str()),
        (true, Some("does_not_move_tcp")),
        "{spot}"
    );
    let story = work.run("diagnose --robot robot.yaml --log log.csv").success();
    let text = story.text().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("joints that do not move the TCP here: J6") && !text.contains("resting"), "{text}");
}
