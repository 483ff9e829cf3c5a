//! `assess bidirectional` through the command line: the sample, its options, and the page.
//!
//! Parts:
//! - [`readings`]: the files that users have, and what is refused of them.
//! - [`results`]: gaps and models that are written for a joint.

mod readings;
mod results;

use crate::support::{self, WorkFolder};
use assert_cmd::Command;
use lostmotion::assess::bidirectional::{Options, Readings, assess};
use lostmotion::cli::page::bidirectional::curves;
use lostmotion::report::plots::backlash_line;
use maud::html;
use serde_json::Value;
use std::path::{Path, PathBuf};

const SAMPLE: &str = "samples/bidirectional/irb1600_z.csv";
const GANTRY: &str = "configs/gantry-xyz-ballscrew.yaml";
const KUKA: &str = "configs/kuka-kr120-r2500-pro.yaml";

fn command(args: &[&str]) -> Command {
    let mut command = support::command();
    command.args(["assess", "bidirectional", "--readings"]).args(args);
    command
}

/// Document and notes.
fn found(args: &[&str]) -> (Value, String) {
    let out = command(args).arg("--json").output().unwrap();
    let notes = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.success(), "{args:?}: {notes}");
    (serde_json::from_slice(&out.stdout).unwrap(), notes)
}

fn refused(args: &[&str], code: i32) -> String {
    let assert = command(args).assert().code(code);
    let out = assert.get_output();
    assert!(out.stdout.is_empty(), "{args:?}");
    String::from_utf8_lossy(&out.stderr).into_owned()
}

/// A folder for the files of a test.
struct Folder(WorkFolder);

impl Folder {
    fn new() -> Self {
        Self(WorkFolder::new())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_string()
    }

    fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.path(name), text).unwrap();
        self.text(name)
    }
}

/// Readings of a play: forward reads `half` low, backward as much high; a little scatter for each repeat.
fn play(half_um: impl Fn(f64) -> f64, repeats: usize) -> String {
    let mut text = String::from("position_mm,direction,repeat,error_um\n");
    for x in [0.0, 100.0, 250.0, 400.0, 600.0] {
        for r in 0..repeats {
            let scatter = 0.3 * f64::from([0, 2, -1, 1, -2, 3, -3][(r + x as usize / 50) % 7]);
            let other = 0.3 * f64::from([1, -1, 2, -2, 0, -3, 3][(r + x as usize / 50) % 7]);
            text += &format!("{x},+1,{},{}\n{x},-1,{},{}\n", r + 1, scatter - half_um(x), r + 1, other + half_um(x));
        }
    }
    text
}

#[test]
fn the_sample_gives_the_papers_decisions_and_the_contracts_fields() {
    let (doc, _) = found(&[SAMPLE]);
    assert_eq!(doc["schema"], "lostmotion/bidirectional/1");
    assert_eq!(doc["poses"].as_array().unwrap().len(), 15);
    for pose in doc["poses"].as_array().unwrap() {
        for key in [
            "position_mm",
            "backlash_um",
            "repeatability_forward_um",
            "repeatability_backward_um",
            "repeatability_bidirectional_um",
        ] {
            assert!(pose[key].is_number(), "{key}: {pose}");
        }
    }
    let model = &doc["model"];
    assert_eq!((&model["degree"], model["coefficients"].as_array().unwrap().len()), (&2.into(), 3));
    assert_eq!(model["lack_of_fit"][0]["degree"], 1);
    assert_eq!(model["lack_of_fit"][0]["dof"], serde_json::json!([3, 45]));
    assert!(model["lack_of_fit"][0]["p_value"].as_f64().unwrap() < 0.05);
    let states: Vec<(&str, u64, bool)> = (model["states"].as_array().unwrap().iter())
        .map(|s| (s["name"].as_str().unwrap(), s["order"].as_u64().unwrap(), s["significant"].as_bool().unwrap()))
        .collect();
    assert_eq!(
        states,
        [("payload_kg=6", 0, false), ("speed_mm_s=6000", 0, true), ("speed_mm_s=6000", 1, false)],
        "offset of the speed, no slope; nothing of the payload"
    );
    // the printed t values have these degrees of freedom: 10 means, 4 and 5 coefficients
    let critical: Vec<f64> =
        model["states"].as_array().unwrap().iter().map(|s| s["t_critical"].as_f64().unwrap()).collect();
    assert!((critical[1] - 2.447).abs() < 5e-4 && (critical[2] - 2.571).abs() < 5e-4, "{critical:?}");
    for (k, truth) in [33.83, -0.0914, 0.0001].iter().enumerate() {
        // the sample is one draw: its bow lies on the edge of its interval
        let [c, lo, hi] =
            [&model["coefficients"][k], &model["ci95"][k][0], &model["ci95"][k][1]].map(|v| v.as_f64().unwrap());
        assert!((c - truth).abs() < 0.75 * (hi - lo), "{k}: {c} in {lo} to {hi}");
    }
    let equation = model["equation"].as_str().unwrap();
    assert!(equation.starts_with("ŷ = ") && equation.contains("x² + ") && equation.ends_with('D'), "{equation}");
    assert_eq!(model["indicators"][0]["name"], "speed_mm_s=6000");
}

#[test]
fn no_sum_of_squares_is_negative_and_they_add_up_as_in_table_i() {
    let (doc, _) = found(&[SAMPLE]);
    for t in doc["model"]["lack_of_fit"].as_array().unwrap() {
        let part = |group: &str, key: &str| t[group][key].as_f64().unwrap();
        let (lack, pure) = (part("sum_squares_um2", "lack_of_fit"), part("sum_squares_um2", "pure_error"));
        assert!(lack >= 0.0 && pure > 0.0);
        assert!((lack + pure - part("sum_squares_um2", "residual")).abs() < 1e-6 * pure);
        let f = part("mean_squares_um2", "lack_of_fit") / part("mean_squares_um2", "pure_error");
        assert!((f - t["F"].as_f64().unwrap()).abs() < 1e-6 * f);
    }
}

#[test]
fn the_tables_print_the_equation_and_the_same_run_prints_the_same_bytes() {
    let run = || command(&[SAMPLE]).output().unwrap().stdout;
    let text = String::from_utf8(run()).unwrap();
    assert!(text.contains("D = 1 where speed_mm_s=6000, else 0") && text.contains("ŷ = "), "{text}");
    assert!(text.contains("State speed_mm_s=10, payload_kg=2.23 (reference)"), "{text}");
    assert_eq!(text.into_bytes(), run());
}

#[test]
fn a_speed_that_turns_the_curve_about_its_middle_is_named_in_a_note() {
    let folder = Folder::new();
    let mut text = String::from("position_mm,direction,repeat,error_um,speed_mm_s\n");
    for (speed, slope) in [(10, 0.0), (500, 0.02)] {
        for line in play(|x| 5.0 + slope * (x - 270.0), 5).lines().skip(1) {
            text += &format!("{line},{speed}\n");
        }
    }
    let (doc, notes) = found(&[&folder.write("turn.csv", &text)]);
    assert_eq!(doc["model"]["states"].as_array().unwrap().len(), 1);
    assert!(notes.contains("its slope would be significant"), "{notes}");
}

#[test]
fn options_that_cannot_be_meant_are_refused() {
    let out = Folder::new();
    let gaps = out.text("gaps.yaml");
    for (args, says) in [
        (vec!["--level", "0.05"], "--level"),
        (vec!["--min-degree", "3", "--max-degree", "2"], "--max-degree"),
        (vec!["--degree", "5"], "degree 5 for 5 poses"),
        (vec!["--reference", "speed_mm_s=20"], "speed_mm_s of 10, 6000"),
        (vec!["--reference", "speed_mm_s"], "NAME=VALUE"),
        (vec!["--states", "humidity"], "no column `humidity`"),
        (vec!["--output", &gaps], "--robot"),
        (vec!["--robot", GANTRY, "--joint", "Q", "--output", &gaps], "joint `Q`"),
        (vec!["--robot", KUKA, "--joint", "A1", "--output", &gaps], "--lever-mm"),
        (vec!["--robot", GANTRY, "--joint", "X", "--lever-mm", "9", "--output", &gaps], "a prismatic joint"),
        (vec!["--json", "--robot", GANTRY, "--joint", "X", "--output", "-"], "`-` and --json"),
        (vec!["--report", SAMPLE], "the same file as --readings"),
    ] {
        let all: Vec<&str> = std::iter::once(SAMPLE).chain(args.iter().copied()).collect();
        let error = refused(&all, 2);
        assert!(error.contains(says), "{args:?}: {error}");
    }
    // the backlash of the sample is positive: no play, unless a sign is turned
    let no = refused(&[SAMPLE, "--robot", GANTRY, "--joint", "X", "--output", &gaps], 1);
    assert!(no.contains("--reversed") && !out.path("gaps.yaml").exists(), "{no}");
}

#[test]
fn the_page_shows_both_directions_and_the_curves() {
    let folder = Folder::new();
    let page = folder.text("page.html");
    command(&[SAMPLE, "--report", &page]).assert().success();
    let html = std::fs::read_to_string(&page).unwrap();
    for says in
        ["Reading of each direction at each pose", "Backlash over position", "Student", "ŷ = ", "speed_mm_s=6000"]
    {
        assert!(html.contains(says), "{says}");
    }
    assert!(!html.contains("NaN") && html.matches("<svg").count() >= 4);
}

/// The picture of docs/assess-bidirectional.md.
fn picture() -> String {
    const STYLE: &str = "text{font:11px system-ui,sans-serif;fill:#57616c}.grid{stroke:#dde2e7}.zero{stroke:#8a949e}.axis{stroke:#57616c}\
path,line,circle{fill:none}.j5{--c:#1a1f26}.j0{--c:#009e73}.j1{--c:#e69f00}.half{fill:var(--c);fill-opacity:.16}\
.line{stroke:var(--c);stroke-width:1.6}.mark{stroke:var(--c);stroke-width:1.5}.glyph{fill:var(--c);stroke:#fff}\
@media(prefers-color-scheme:dark){text{fill:#a3adb8}.grid{stroke:#2e363f}.j5{--c:#e6e9ec}}";
    let readings = Readings::load(Path::new(SAMPLE), None, None).unwrap();
    let view = curves(&assess(readings, &[], &Options::default()).unwrap());
    let frame = backlash_line::curves_frame(&view).unwrap();
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(frame.size.view_box()) width="540" height="300" role="img" aria-label="Backlash over position in three states" {
            style { (maud::PreEscaped(STYLE)) }
            (backlash_line::curves_content(&view, &frame))
        }
    };
    markup.into_string() + "\n"
}

#[test]
fn the_picture_of_the_docs_is_not_stale() {
    const PATH: &str = "docs/assess-bidirectional.svg";
    let want = picture();
    roxmltree::Document::parse(&want).unwrap();
    if std::env::var_os("LOSTMOTION_WRITE_DOCS").is_some() {
        std::fs::write(PATH, &want).unwrap();
    }
    let found = std::fs::read_to_string(PATH).unwrap_or_default();
    assert!(found == want, "{PATH} is stale: run this test with LOSTMOTION_WRITE_DOCS=1");
}

#[test]
fn the_page_counts_positions_and_states_apart() {
    let folder = Folder::new();
    let page = folder.text("page.html");
    command(&[SAMPLE, "--report", &page]).assert().success();
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.contains("300 readings at 5 positions in 3 states."));
}
