//! `assess bidirectional` through the command line: the sample, the files that users have, what is refused, what is written.

use crate::support::{self, WorkFolder};
use assert_cmd::Command;
use lostmotion::assess::bidirectional::{Options, Readings, assess};
use lostmotion::cli::page::bidirectional::curves;
use lostmotion::effects::{BacklashPosition, BacklashSpeed};
use lostmotion::gaps::Gaps;
use lostmotion::model::Model;
use lostmotion::report::plots::backlash_line;
use lostmotion::robot::Robot;
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

/// Readings of a play: forward reads `half` low, backward as much high; a little scatter of its own for each repeat.
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
fn directions_units_order_and_a_column_map_make_no_difference() {
    let folder = Folder::new();
    let plain = play(|x| 4.0 + 0.01 * x, 4);
    let (want, _) = found(&[&folder.write("plain.csv", &plain)]);
    let body = || plain.lines().skip(1);
    let turned: String = body()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            let error: f64 = c[3].parse().unwrap();
            let (word, reading) = (if c[1] == "+1" { "Forward" } else { "backward" }, error * 1e-3);
            let position: f64 = c[0].parse().unwrap();
            format!("{},{word},{},{:.7}\n", c[2], position, position + reading)
        })
        .collect();
    let reading = folder.write("reading.csv", &format!("repetition,dir,position_mm,reading_mm\n{turned}"));
    let mm: String = body()
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .map(|l| l.replace("+1", "+").replace("-1,", "-,") + "\n")
        .collect();
    let mm = folder.write("reversed.csv", &format!("# turned round\nposition_mm,direction,repeat,error_um\n{mm}"));
    let foreign: String = body()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            let (error, x): (f64, f64) = (c[3].parse().unwrap(), c[0].parse().unwrap());
            format!("{};{};{};{};x\n", x * 1e-3, c[1], c[2], -error * 1e-3).replace('.', ",")
        })
        .collect();
    let foreign = folder.write("foreign.csv", &format!("Soll;Richtung;Lauf;Abweichung;Bemerkung\n{foreign}"));
    let map = folder.write(
        "map.yaml",
        "schema: lostmotion/columns/1\nseparator: \";\"\ndecimal: \",\"\ncolumns:\n  Soll: {to: position_mm, unit: m}\n  \
         Richtung: direction\n  Lauf: repeat\n  Abweichung: {to: error_um, unit: mm, sign: -1}\n  Bemerkung: ignore\n",
    );
    for args in [vec![reading.as_str()], vec![mm.as_str()], vec![foreign.as_str(), "--columns", &map]] {
        let (doc, _) = found(&args);
        for (a, b) in doc["poses"].as_array().unwrap().iter().zip(want["poses"].as_array().unwrap()) {
            for key in ["position_mm", "backlash_um", "repeatability_bidirectional_um"] {
                let (a, b) = (a[key].as_f64().unwrap(), b[key].as_f64().unwrap());
                assert!((a - b).abs() < 1e-3, "{args:?} {key}: {a} {b}");
            }
        }
        assert_eq!(doc["model"]["degree"], want["model"]["degree"], "{args:?}");
    }
}

#[test]
fn missing_readings_and_unequal_repeats_are_used_as_far_as_they_go_and_said() {
    let folder = Folder::new();
    let mut lines: Vec<String> = play(|_| 5.0, 5).lines().map(str::to_string).collect();
    lines[1] = "0,+1,1,".into();
    lines[4] = "0,-1,2,NaN".into();
    lines.retain(|l| !l.starts_with("600,-1"));
    let (doc, notes) = found(&[&folder.write("lost.csv", &(lines.join("\n") + "\n"))]);
    let poses = doc["poses"].as_array().unwrap();
    assert_eq!((&poses[0]["pairs"], &poses[0]["repeats_forward"]), (&3.into(), &4.into()));
    assert!(poses[4]["backlash_um"].is_null() && poses[4]["repeatability_forward_um"].is_number());
    assert_eq!(doc["model"]["lack_of_fit"][0]["dof"], serde_json::json!([2, 18 - 4]));
    for says in ["2 of 45 readings are missing", "without a partner", "only one direction, so no backlash: 600 mm"] {
        assert!(notes.contains(says), "{says}: {notes}");
    }
}

#[test]
fn one_repeat_has_no_pure_error_and_is_not_given_a_degree() {
    let folder = Folder::new();
    let file = folder.write("once.csv", &play(|x| 5.0 + 0.01 * x, 1));
    let (doc, notes) = found(&[&file]);
    assert!(doc["model"].is_null() && doc["poses"][0]["backlash_um"].is_number());
    assert!(doc["poses"][0]["repeatability_bidirectional_um"].is_null());
    assert!(notes.contains("no pure error"), "{notes}");
    let (doc, _) = found(&[&file, "--degree", "1"]);
    assert!(doc["model"]["adequate"].is_null() && doc["model"]["ci95"][1][0].is_number());
    let says = refused(&[&file, "--robot", GANTRY, "--joint", "X", "--output", &folder.text("g.yaml")], 2);
    assert!(says.contains("no curve (one repeat only)") && !folder.path("g.yaml").exists(), "{says}");
}

#[test]
fn a_file_without_repeats_by_name_pairs_by_order_and_standard_input_is_a_file() {
    let plain = play(|x| 4.0 + 0.01 * x, 4);
    let unnamed: String = plain
        .lines()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            format!("{},{},{}\n", c[0], c[1], c[3])
        })
        .collect();
    let folder = Folder::new();
    let (want, _) = found(&[&folder.write("named.csv", &plain)]);
    let out = command(&["-", "--json"]).write_stdin(unnamed).output().unwrap();
    let doc: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(doc["poses"], want["poses"]);
    assert!(String::from_utf8_lossy(&out.stderr).contains("paired by their order"));
}

#[test]
fn a_line_of_one_or_two_poses_is_still_assessed() {
    let folder = Folder::new();
    let rows = play(|_| 5.0, 4);
    for (poses, degree) in [(1, 0), (2, 0), (3, 1)] {
        let kept: Vec<&str> = rows.lines().take(1 + 8 * poses).collect();
        let (doc, _) = found(&[&folder.write("few.csv", &(kept.join("\n") + "\n"))]);
        assert_eq!(doc["model"]["degree"], degree, "{poses} poses");
    }
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
fn every_wrong_file_is_refused_with_its_place() {
    let folder = Folder::new();
    let head = "position_mm,direction,repeat,error_um\n";
    let cases = [
        (String::new(), "an empty file"),
        (head.to_string(), "a header and no rows"),
        ("position_mm,direction,repeat\n0,1,1\n".into(), "no column `error_um`"),
        ("x,direction,repeat,error_um\n0,1,1,1\n".into(), "no column `position_mm`"),
        (format!("{head}0,0,1,5\n"), ":2:2: found `0` in column `direction`"),
        (format!("{head}0,1,1,5\n0,sideways,1,5\n"), ":3:2: found `sideways` in column `direction`"),
        (format!("{head}0,1,1,5\n,-1,1,5\n"), ":3:1: found an empty cell without a position"),
        (format!("{head}0,1,1,5\n0,-1,1,five\n"), ":3:4: found `five` in column `error_um`"),
        (format!("{head}0,1,1,5\n0,-1,1,1e99\n"), "at most 10,000,000 mm"),
        (format!("{head}0,1,1,5\n0,-1,1\n"), ":3: found 3 fields"),
        (format!("{head}0,1,1,5\n0,1,2,5\n"), "readings in the forward direction only"),
        (format!("{head}0,1,1,5\n0,-1,1,\n"), "readings in the forward direction only"),
        (format!("{head}0,1,1,\n0,-1,1,\n"), "every cell of the error is empty"),
        (
            format!("{head}0,1,1,5\n0,-1,1,5\n0,1,1,6\n"),
            ":4: found a second reading of position 0 mm, forward, repeat 1",
        ),
        ("position_mm;direction;repeat;error_um\n0;1;1;5\n".into(), "fields separated by `;`"),
        ("position_mm,direction,repeat,reading_mm\n0,1,1,0.5\n1,-1,1,900\n2,1,1,1800\n".into(), "check the units"),
        ("position_mm,direction,repeat,error_um,speed\n0,1,1,5,\n".into(), ":2:5: found an empty cell without a state"),
        ("position_mm,direction,repeat,error_um,error_mm\n0,1,1,5,5\n".into(), "a second column for `error_mm`"),
        ("position_mm,direction,repeat,error_um,reading_mm\n0,1,1,5,5\n".into(), "both an error and a reading"),
        (
            "position_mm,direction,repeat,error_um,speed\n0,1,1,5,1\n0,-1,1,5,2\n".into(),
            "no pose with a repeat in both",
        ),
    ];
    for (text, says) in cases {
        let error = refused(&[&folder.write("bad.csv", &text)], 2);
        assert!(error.contains(says), "{text:?}: {error}");
    }
    let mut many = String::from("position_mm,direction,repeat,error_um,humidity\n");
    for i in 0..40 {
        many += &format!("{},{},1,5,{}\n", i / 2, if i % 2 == 0 { 1 } else { -1 }, 40.0 + f64::from(i) / 100.0);
    }
    let many = folder.write("many.csv", &many);
    assert!(refused(&[&many], 2).contains("40 different values in column `humidity`"));
    assert!(refused(&[&folder.text("absent.csv")], 2).contains("cannot open"));
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
fn the_curve_goes_through_gaps_and_fit_into_a_compensator_and_back_to_the_true_half_gap() {
    let folder = Folder::new();
    let half = |x: f64| 4.0 + 0.02 * x - 2e-5 * x * x;
    let readings = folder.write("readings.csv", &play(half, 6));
    let (gaps, model) = (folder.text("gaps.yaml"), folder.text("model.yaml"));
    let joint = ["--robot", GANTRY, "--joint", "X"];
    let mut args = vec![readings.as_str()];
    args.extend(joint);
    args.extend(["--origin", "50", "--output", &gaps, "--model-out", &model]);
    let (doc, _) = found(&args);
    assert_eq!(doc["model"]["degree"], 2);
    let robot = Robot::load(Path::new(GANTRY)).unwrap();
    let read = Gaps::load(&folder.path("gaps.yaml"), &robot).unwrap();
    let schedule = read.joints[0].schedule.as_ref().unwrap();
    let machine = Model::load(&folder.path("model.yaml")).unwrap();
    assert_eq!(machine.effects[0].effect.name(), "backlash_position");
    let b = machine.effects[0].effect.get::<BacklashPosition>().unwrap();
    for x in [0.0, 130.0, 333.0, 600.0] {
        let joint_m = (x + 50.0) * 1e-3;
        for found in [schedule.at(joint_m), b.half_gap.at(joint_m)] {
            assert!((found * 1e6 - half(x)).abs() < 0.6, "{x}: {}", found * 1e6);
        }
    }
    assert_eq!(read.points.len(), 5);
    assert!((read.points[1].at - 0.15).abs() < 1e-9 && read.points[1].cycles == 6);
    let compensator = folder.text("compensator.yaml");
    let fit = ["fit", "--robot", GANTRY, "--gaps", &gaps, "--output", &compensator];
    support::command().args(fit).assert().success();
    let text = std::fs::read_to_string(&compensator).unwrap();
    assert!(text.contains("X:") && text.contains("schedule"), "{text}");
}

/// A polynomial of degree 5 about joint position 0 would need 20 digits here.
#[test]
fn a_short_line_far_out_on_a_long_axis_keeps_its_schedule() {
    let folder = Folder::new();
    let half = |x: f64| 20.0 + 8.0 * (x / 130.0).sin();
    let mut text = String::from("position_mm,direction,repeat,error_um\n");
    for x in (0..=16).map(|k| f64::from(k) * 50.0) {
        for r in 0..4 {
            let [up, down] = [7, 5].map(|m| 0.1 * f64::from((r * m + x as i32 / 50 * 3) % 5 - 2));
            text += &format!("{x},+1,{r},{}\n{x},-1,{r},{}\n", up - half(x), down + half(x));
        }
    }
    let readings = folder.write("readings.csv", &text);
    let long = std::fs::read_to_string(GANTRY).unwrap().replacen("limits_mm: [0, 1000]", "limits_mm: [0, 60000]", 1);
    let robot = folder.write("long.yaml", &long);
    let (gaps, compensator) = (folder.text("gaps.yaml"), folder.text("compensator.yaml"));
    for origin in ["0", "5000", "30000", "50000"] {
        let joint = ["--robot", &robot, "--joint", "X", "--origin", origin, "--degree", "5", "--output", &gaps];
        found(&[&[readings.as_str()], joint.as_slice()].concat());
        let loaded = Robot::load(Path::new(&robot)).unwrap();
        let read = Gaps::load(&folder.path("gaps.yaml"), &loaded).unwrap();
        let schedule = read.joints[0].schedule.as_ref().unwrap();
        for x in [0.0, 130.0, 333.0, 600.0, 800.0] {
            let at = (x + origin.parse::<f64>().unwrap()) * 1e-3;
            assert!((schedule.at(at) * 1e6 - half(x)).abs() < 0.6, "{origin}, {x}: {}", schedule.at(at) * 1e6);
        }
        let fit = ["fit", "--robot", &robot, "--gaps", &gaps, "--output", &compensator, "--force"];
        support::command().args(fit).assert().success();
    }
}

#[test]
fn a_revolute_joint_takes_its_lever_arm() {
    let folder = Folder::new();
    let readings = folder.write("readings.csv", &play(|x| 10.0 + 0.02 * x, 6));
    let gaps = folder.text("gaps.yaml");
    for (lever, turned) in [("1000", false), ("-1000", true)] {
        found(&[&readings, "--robot", KUKA, "--joint", "A1", "--lever-mm", lever, "--output", &gaps]);
        let robot = Robot::load(Path::new(KUKA)).unwrap();
        let read = Gaps::load(&folder.path("gaps.yaml"), &robot).unwrap();
        let schedule = read.joints[0].schedule.as_ref().unwrap();
        // 300 mm on a lever of 1 m is 0.3 rad; 16 um are 16 urad
        let at = if turned { -0.3 } else { 0.3 };
        assert!((schedule.at(at) - 16e-6).abs() < 0.6e-6, "{lever}: {}", schedule.at(at));
    }
}

#[test]
fn speeds_become_a_backlash_speed_with_the_true_slope() {
    let folder = Folder::new();
    let mut text = String::from("position_mm,direction,repeat,error_um,speed_mm_s\n");
    for speed in [10.0, 200.0, 500.0] {
        for line in play(|_| 6.0 + 0.01 * speed, 5).lines().skip(1) {
            text += &format!("{line},{speed}\n");
        }
    }
    let readings = folder.write("speeds.csv", &text);
    let model = folder.text("model.yaml");
    found(&[&readings, "--robot", GANTRY, "--joint", "X", "--model-out", &model, "--effect", "backlash-speed"]);
    let machine = Model::load(&folder.path("model.yaml")).unwrap();
    let b = machine.effects[0].effect.get::<BacklashSpeed>().unwrap();
    assert!((b.half_gap * 1e6 - 6.0).abs() < 0.3 && (b.slope * 1e6 - 10.0).abs() < 0.5, "{b:?}");
    // the same speeds without an effect: the answer is no
    let flat = text.lines().take(51).chain(text.lines().skip(1).take(50)).collect::<Vec<_>>();
    let flat: String = flat
        .iter()
        .enumerate()
        .map(|(i, l)| if i > 50 { l.replace(",10", ",500") } else { l.to_string() } + "\n")
        .collect();
    let flat = folder.write("flat.csv", &flat);
    let no =
        refused(&[&flat, "--robot", GANTRY, "--joint", "X", "--model-out", &model, "--effect", "backlash_speed"], 1);
    assert!(no.contains("no speed changes the backlash"), "{no}");
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
fn readings_in_metres_are_refused_and_a_short_line_is_noted() {
    let folder = Folder::new();
    let scaled = |text: &str, column: usize, factor: f64| -> String {
        let row = |line: &str| {
            let cell = |(k, c): (usize, &str)| match c.parse::<f64>() {
                Ok(v) if k == column => format!("{:.12}", v * factor),
                _ => c.to_string(),
            };
            line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n"
        };
        text.lines().map(row).collect()
    };
    let good = play(|_| 40.0, 5);
    for (name, factor) in [("error_um", 1e-6), ("error_mm", 1e-6), ("error_um", 1e-3)] {
        let text = scaled(&good, 3, factor).replace("error_um", name);
        let file = folder.write("readings.csv", &text);
        let says = refused(&[&file], 2);
        assert!(says.contains(&format!("in column `{name}`")) && says.contains("0.1 um and more"), "{says}");
    }
    // the same figures where they belong
    let file = folder.write("readings.csv", &scaled(&good, 3, 1e-3).replace("error_um", "error_mm"));
    let (_, notes) = found(&[&file]);
    assert!(notes.is_empty(), "{notes}");
    // readings in metres at positions in mm: off by half the line in the median
    let reading = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let measured = |x: f64, e: f64| format!("{:.9}", (x + e * 1e-3) * 1e-3);
        let last = cells[0].parse().map_or("reading_mm".into(), |x: f64| measured(x, cells[3].parse().unwrap()));
        format!("{},{},{},{last}\n", cells[0], cells[1], cells[2])
    };
    let file = folder.write("readings.csv", &good.lines().map(reading).collect::<String>());
    assert!(refused(&[&file], 2).contains("check the units"));
    // positions in metres; errors are far below the line still
    let file = folder.write("readings.csv", &scaled(&good, 0, 1e-3));
    let (_, notes) = found(&[&file]);
    assert!(notes.contains("the line is 0.6000 mm long"), "{notes}");
}

#[test]
fn a_line_outside_the_joint_s_limits_is_refused_and_one_that_reaches_beyond_them_is_noted() {
    let folder = Folder::new();
    let (file, gaps) = (folder.write("readings.csv", &play(|_| 40.0, 5)), folder.text("gaps.yaml"));
    // X goes from 0 to 1000 mm, the line from 0 to 600
    let with = |origin: &str| {
        vec![
            file.clone(),
            "--robot".into(),
            GANTRY.into(),
            "--joint".into(),
            "X".into(),
            "--origin".into(),
            origin.into(),
        ]
    };
    let args = |origin: &str| [with(origin), vec!["--output".into(), gaps.clone()]].concat();
    let line = |origin: &str| command(&args(origin).iter().map(String::as_str).collect::<Vec<_>>()).output().unwrap();
    for (origin, code, says) in [
        ("400", 0, ""),
        ("500", 0, "a line from 500 to 1100 mm of X reaches beyond its limits 0 to 1000 mm"),
        ("1001", 2, "found a line from 1001 to 1601 mm of X; expected a line within its limits 0 to 1000 mm"),
        ("-700", 2, "found a line from -700 to -100 mm of X"),
    ] {
        let out = line(origin);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(code) && said.contains(says), "{origin}: {said}");
        assert_eq!(said.contains("limits"), origin != "400", "{said}");
        assert_eq!(folder.path("gaps.yaml").exists(), code == 0);
        let _ = std::fs::remove_file(folder.path("gaps.yaml"));
    }
}

#[test]
fn the_page_counts_positions_and_states_apart() {
    let folder = Folder::new();
    let page = folder.text("page.html");
    command(&[SAMPLE, "--report", &page]).assert().success();
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.contains("300 readings at 5 positions in 3 states."));
}
