//! `lostmotion rewrite` from the outside: guard, check, dry run, folders, exit codes.

use crate::support::{self, WorkFolder, bundled};
use assert_cmd::Command;
use predicates::prelude::*;
use std::path::PathBuf;

/// A folder with a model of the gantry (half gaps of X and Y) and a program.
struct Bench {
    dir: WorkFolder,
}

impl Bench {
    fn new() -> Self {
        let dir = WorkFolder::new();
        let robot = bundled("configs/gantry-xyz-ballscrew.yaml");
        for (name, gap) in [("model.yaml", 0.05), ("zero.yaml", 0.0)] {
            let model = format!(
                "schema: lostmotion/model/1\nrobot: {}\neffects:\n  - {{effect: backlash, joint: X, half_gap_mm: {gap}}}\n  \
                 - {{effect: backlash, joint: Y, half_gap_mm: {gap}}}\n",
                robot.display()
            );
            std::fs::write(dir.join(name), model).unwrap();
        }
        let bench = Self { dir };
        bench.write("program.csv", &circle(0.0));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// `lostmotion rewrite ...` in the folder.
    fn rewrite(&self, args: &[&str]) -> Command {
        let mut command = support::command();
        command.current_dir(self.dir.path()).arg("rewrite").args(args);
        command
    }
}

/// Three turns of a circle of 100 points in X and Y; with a half gap (mm), as a rewrite leaves it.
fn circle(half_gap: f64) -> String {
    let at = |i: f64| [500.0 + 100.0 * (i * 0.0628 + 0.01).cos(), 400.0 + 100.0 * (i * 0.0628 + 0.01).sin()];
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    let mut dir = [-1.0, 1.0];
    for i in 0..300 {
        let (p, next) = (at(f64::from(i)), at(f64::from(i + 1)));
        let row = |f: f64, d: [f64; 2]| {
            let v = |k: usize| p[k] + f * (next[k] - p[k]) + d[k] * half_gap;
            format!("{:.4},{:.4},-10.0000\n", v(0), v(1))
        };
        text += &row(0.0, dir);
        let to = [0, 1].map(|k| (next[k] - p[k]).signum());
        if to != dir {
            dir = to;
            if half_gap > 0.0 {
                text += &row(0.1, dir);
            }
        }
    }
    text
}

#[test]
fn a_compensator_of_zeros_returns_the_input_byte_for_byte_and_leaves_no_note() {
    let b = Bench::new();
    for refine in ["none", "cubic", "cartesian"] {
        b.rewrite(&["--model", "zero.yaml", "program.csv", "--output", "out.csv", "--refine", refine])
            .assert()
            .success();
        assert_eq!(b.read("out.csv"), b.read("program.csv"), "{refine}");
    }
    assert!(!b.path("out.csv.lostmotion.json").exists());
    let piped =
        b.rewrite(&["--model", "zero.yaml", "-", "--output", "-"]).write_stdin(b.read("program.csv")).output().unwrap();
    assert_eq!(piped.stdout, b.read("program.csv"));
}

#[test]
fn refuses_a_program_whose_reversals_carry_the_steps_of_the_compensator() {
    let b = Bench::new();
    b.write("done.csv", &circle(0.05));
    let refused = predicate::str::contains("done.csv: found a program that has been rewritten already");
    b.rewrite(&["--model", "model.yaml", "done.csv", "--output", "again.csv"]).assert().code(2).stderr(refused);
    assert!(!b.path("again.csv").exists());
    b.rewrite(&["--model", "model.yaml", "done.csv", "--output", "again.csv", "--force"]).assert().success();
    b.rewrite(&["--model", "model.yaml", "program.csv", "--output", "fresh.csv"]).assert().success();
}

#[test]
fn refuses_a_file_whose_hash_stands_in_a_note_of_its_folder_under_whatever_name() {
    use lostmotion::rewrite::guard::{Named, Note, SCHEMA, note_text};
    let b = Bench::new();
    let named = || Named { name: "c".into(), sha256: "0".into() };
    let note = Note {
        schema: SCHEMA.into(),
        version: "0".into(),
        input: "a.csv".into(),
        output: "b.csv".into(),
        sha256_in: None,
        sha256_out: lostmotion::io::input::sha256(&b.read("program.csv")),
        robot: named(),
        compensator: named(),
        ..Note::default()
    };
    b.write("b.csv.lostmotion.json", &note_text(&note).unwrap());
    let run = |extra: &[&str]| {
        let args = [&["--model", "model.yaml", "program.csv", "--output", "out.csv"], extra].concat();
        b.rewrite(&args).assert()
    };
    run(&[]).code(2).stderr(predicate::str::contains("its note is in the same folder"));
    assert!(!b.path("out.csv").exists());
    run(&["--force"]).success();
}

#[test]
fn a_check_against_the_same_output_passes_and_a_difference_is_told_in_millimetres_and_micrometres() {
    let b = Bench::new();
    b.rewrite(&["--model", "zero.yaml", "program.csv", "--check", "program.csv"]).assert().success();
    // the first row begins with 599.9950
    b.write("golden.csv", &circle(0.0).replacen("\n59", "\n58", 1));
    b.rewrite(&["--model", "zero.yaml", "program.csv", "--check", "golden.csv"]).assert().code(1).stderr(
        predicate::str::contains("golden.csv:2: the output differs")
            .and(predicate::str::contains("+10.000000 mm"))
            .and(predicate::str::contains("at the TCP 10000.00 um")),
    );
    let short = circle(0.0);
    b.write("short.csv", &short[..short.len() - 30]);
    b.rewrite(&["--model", "zero.yaml", "program.csv", "--check", "short.csv"]).assert().code(1);
    b.write("long.csv", &(short + "1,2,3\n"));
    let ends = predicate::str::contains("the output ends");
    b.rewrite(&["--model", "zero.yaml", "program.csv", "--check", "long.csv"]).assert().code(1).stderr(ends);
}

#[test]
fn a_dry_run_writes_nothing_and_says_what_would_be_done_as_json() {
    let b = Bench::new();
    let out = b
        .rewrite(&["--model", "model.yaml", "program.csv", "--output", "out.csv", "--dry-run", "--json"])
        .assert()
        .success();
    assert!(!b.path("out.csv").exists() && !b.path("out.csv.lostmotion.json").exists());
    let v: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
    assert_eq!((v["schema"].as_str(), v["moves"].as_u64()), (Some("lostmotion/rewrite/1"), Some(300)));
    assert_eq!(v["sha256_in"].as_str().unwrap().len(), 64);
    assert!(v["joints"][0]["largest_offset_mm"].is_number());
}

#[test]
fn a_folder_is_rewritten_program_by_program_and_a_bad_one_stops_nothing() {
    let b = Bench::new();
    b.write("cell/a/one.csv", &circle(0.0));
    b.write("cell/bad.csv", "x_mm,y_mm,z_mm\n1,2,oops\n");
    b.write("cell/done.csv", &circle(0.05));
    b.write("cell/readme.txt", "no program");
    b.write("cell/z.CSV", &circle(0.0));
    let args = ["--model", "model.yaml", "cell", "--output-dir", "cell/out", "--summary", "summary.jsonl"];
    let mut first = None;
    for _ in 0..2 {
        b.rewrite(&args)
            .assert()
            .code(1)
            .stderr(predicate::str::contains("cell/bad.csv:2:3: found `oops`"))
            .stderr(predicate::str::contains("cell/bad.csv: cell/bad.csv").not());
        let summary = String::from_utf8(b.read("summary.jsonl")).unwrap();
        assert_eq!(*first.get_or_insert(summary.clone()), summary);
    }
    let lines: Vec<serde_json::Value> = first.unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let names: Vec<_> = lines.iter().map(|l| l["input"].as_str().unwrap()).collect();
    assert_eq!(names, ["cell/a/one.csv", "cell/bad.csv", "cell/done.csv", "cell/z.CSV"]);
    let keys: Vec<_> = lines[0].as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        [
            "input",
            "output",
            "status",
            "reason",
            "moves",
            "editable",
            "reversals",
            "inserted",
            "sha256_in",
            "sha256_out"
        ]
    );
    let status: Vec<_> = lines.iter().map(|l| l["status"].as_str().unwrap()).collect();
    assert_eq!((status[1], status[2]), ("failed", "refused"));
    assert!(["written", "unchanged"].contains(&status[0]) && status[0] == status[3]);
    assert!(b.path("cell/out/a/one.csv").exists() && b.path("cell/out/z.CSV").exists());
    assert!(!b.path("cell/out/bad.csv").exists() && !b.path("cell/out/done.csv").exists());
}

#[test]
fn mistakes_on_the_command_line_are_exit_code_2_and_write_nothing() {
    let b = Bench::new();
    let cases: &[&[&str]] = &[
        &["--model", "model.yaml", "program.csv"],
        &["program.csv", "--output", "out.csv"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--gain", "1.5"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--step-fraction", "0"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--initial-direction", "Q=+"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--initial-direction", "X"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--decimals", "0"],
        &["--model", "model.yaml", "program.csv", "--output", "out.csv", "--speed-mm-s", "0"],
        &["--model", "model.yaml", "program.csv", "--output-dir", "out.csv"],
        &["--model", "model.yaml", ".", "--output", "out.csv"],
        &["--model", "model.yaml", "missing.csv", "--output", "out.csv"],
        &["--model", "model.yaml", "program.csv", "--output", "-", "--json"],
    ];
    for args in cases {
        b.rewrite(args).assert().code(2).stdout("");
        assert!(!b.path("out.csv").exists(), "{args:?}");
    }
    b.rewrite(&["--model", "model.yaml", "program.csv", "--output", "out.csv", "--initial-direction", "X=+,Y=-"])
        .assert()
        .success();
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing() {
    use std::io::Write;
    let bench = Bench::new();
    let files = || std::fs::read_dir(bench.dir.path()).unwrap().count();
    let before = files();
    let mut run = crate::faults::by_default_signals()
        .current_dir(bench.dir.path())
        .args(["rewrite", "--model", "model.yaml", "-", "--output", "out.csv"])
        .stdin(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = run.stdin.take().unwrap();
    // the output's temporary file is there, the input goes on
    let (all, rows) = (circle(0.0), 60);
    let body = &all[all.find('\n').unwrap() + 1..];
    stdin.write_all((all.clone() + &body.repeat(rows)).as_bytes()).unwrap();
    for _ in 0..500 {
        if files() > before {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(files() > before, "no temporary file");
    let kill = std::process::Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    assert_eq!(files(), before);
}

/// A program as a person types it: seven targets with times, wrists in whole degrees. Several joints turn at one target and need
/// times of their own for their steps.
#[test]
fn a_coarse_program_with_times_keeps_its_limits_and_added_rows_do_not_take_over_its_coarse_digits() {
    let dir = WorkFolder::new();
    let robot = bundled("configs/kuka-kr120-r2500-pro.yaml");
    let gap =
        |joint: &str, half_gap: f64| format!("  - {{effect: backlash, joint: {joint}, half_gap_deg: {half_gap}}}\n");
    let model = format!(
        "schema: lostmotion/model/1\nrobot: {}\neffects:\n{}{}{}",
        robot.display(),
        gap("A1", 0.0028),
        gap("A2", 0.0037),
        gap("A3", 0.0022)
    );
    std::fs::write(dir.join("model.yaml"), model).unwrap();
    let program = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg,t_s\n0,-90,90,0,0,0,0\n20,-80,100,10,20,0,1\n25,-70,95,12,25,5,2\n\
                   22,-75,97,8,20,3,3\n26,-72,93,14,22,6,4\n10,-85,95,0,10,0,5\n0,-90,90,0,0,0,6\n";
    std::fs::write(dir.join("weld.csv"), program).unwrap();
    let mut command = support::command();
    command
        .current_dir(dir.path())
        .args(["rewrite", "--model", "model.yaml", "weld.csv", "-o", "out.csv"])
        .assert()
        .success();
    let rows = |text: &str| -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split(',').map(|v| v.parse().unwrap()).collect()).collect()
    };
    let given = rows(program);
    let out = rows(&std::fs::read_to_string(dir.join("out.csv")).unwrap());
    assert!(out.len() > given.len(), "steps need points of their own");
    for row in &out {
        let k = given.iter().rposition(|g| g[6] <= row[6]).unwrap();
        let (a, b) = (&given[k], &given[(k + 1).min(given.len() - 1)]);
        let share = if b[6] > a[6] { (row[6] - a[6]) / (b[6] - a[6]) } else { 0.0 };
        for joint in 0..6 {
            let own = a[joint] + share * (b[joint] - a[joint]);
            let most = [0.0029, 0.0038, 0.0023, 1e-4, 1e-4, 1e-4][joint];
            assert!((row[joint] - own).abs() <= most, "joint {joint} at {} s: {} for {own}", row[6], row[joint]);
        }
    }
    assert!(out.windows(2).all(|w| w[1][6] - w[0][6] >= 0.0039), "points nearer than an interpolation cycle: {out:?}");
}
