//! Pages of commands through the binary: a verdict, a figure, and nothing that is not there.

use crate::support::{WorkFolder, bundled, root, run_args, run_from_root};
use std::path::Path;

/// The page of a command that succeeds.
fn page(args: &[&str], at: &Path) -> String {
    let out = run_args(root(), args);
    assert!(out.succeeded(), "{args:?}: {}", out.stderr);
    let text = std::fs::read_to_string(at).unwrap();
    assert!(text.contains("class=\"verdict") && text.contains("<svg"), "{args:?}");
    text
}

const KUKA: &str = "configs/kuka-kr120-r2500-pro.yaml";
const MODEL: &str = "samples/models/kuka-figure5.model.yaml";
const PROGRAM: &str = "samples/circle/circle_program.csv";

#[test]
fn a_folder_has_a_page_with_its_programs_and_why_some_are_refused() {
    let work = WorkFolder::new();
    let path = |name: &str| work.join(name);
    std::fs::create_dir_all(path("in")).unwrap();
    std::fs::copy(bundled(PROGRAM), path("in/circle.csv")).unwrap();
    std::fs::write(path("in/broken.csv"), "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n1,2,x,4,5,6\n").unwrap();
    let (input, output, report) = (path("in"), path("done"), path("page.html"));
    let [input, output, name] = [&input, &output, &report].map(|p| p.to_str().unwrap().to_string());
    let args = [
        "rewrite",
        "--model",
        MODEL,
        &input,
        "--speed-mm-s",
        "1.5",
        "--output-dir",
        &output,
        "--fail-on",
        "none",
        "--report",
        &name,
    ];
    let text = page(&args, &report);
    assert!(text.contains("1 of 2 programs rewritten, 0 unchanged, 0 refused, 1 failed."), "{text}");
    assert!(text.contains("circle.csv") && text.contains("Refused and failed") && text.contains("broken.csv:2:3"));
    // a page does not go over a program
    let over = path("done/circle.csv");
    let args = ["rewrite", "--model", MODEL, &input, "--speed-mm-s", "1.5", "--output-dir", &output, "--report"];
    let out = run_args(root(), &[&args[..], &[over.to_str().unwrap()]].concat());
    assert_eq!(out.code, Some(2), "{}", out.stderr);
}

#[test]
fn a_simulation_shows_its_path_and_a_fit_its_offsets() {
    let work = WorkFolder::new();
    let path = |name: &str| work.join(name).to_str().unwrap().to_string();
    let (log, gaps, compensator, report) = (path("log.csv"), path("gaps.yaml"), path("comp.yaml"), path("page.html"));
    let args =
        ["simulate", "--model", MODEL, "--input", PROGRAM, "--speed-mm-s", "50", "--output", &log, "--report", &report];
    let text = page(&args, Path::new(&report));
    assert!(text.contains("Path of the TCP") && text.contains("off the commanded path"));
    run_args(
        root(),
        &["identify", "static", "--robot", KUKA, "--log", "samples/static/single_axis_A1.csv.gz", "--output", &gaps],
    );
    let args = ["fit", "--robot", KUKA, "--gaps", &gaps, "--output", &compensator, "--report", &report];
    assert!(page(&args, Path::new(&report)).contains("Largest offset of each joint"));
    let args = ["show", &gaps, "--robot", KUKA, "--output", &report];
    assert!(page(&args, Path::new(&report)).contains("<h1>Half gaps of the joints</h1>"));
}

#[test]
fn a_page_without_errors_has_no_scale_for_them() {
    let work = WorkFolder::new();
    let report = work.join("page.html");
    let name = report.to_str().unwrap();
    let robot = page(&["show", KUKA, "--output", name], &report);
    assert!(!robot.contains("Errors drawn") && !robot.contains("error 5") && !robot.contains("0 effects"), "{robot}");
    let caption = robot.split("from the base to the TCP at ").nth(1).and_then(|t| t.split(" mm").next()).unwrap();
    assert!(caption.split(", ").count() == 3 && !caption.contains("-0.0"), "{caption}");
    assert!(robot.contains("class=\"nominal arm\"") && robot.contains("class=\"elbow\""));
    let program = page(&["show", PROGRAM, "--robot", KUKA, "--output", name], &report);
    assert!(!program.contains("Errors drawn") && program.contains("swatch model"));
}

/// A page is sent to others; the folders of the machine that made it are none of its content.
#[test]
fn no_page_names_the_working_folder() {
    let work = WorkFolder::new();
    let log = bundled("tests/data/diagnose/one-backlash/train.csv.gz");
    let model = bundled("tests/data/diagnose/one-backlash/model.yaml");
    for name in ["train.csv.gz", "model.yaml", "kuka.yaml", "program.csv"] {
        let from = match name {
            "train.csv.gz" => log.clone(),
            "model.yaml" => model.clone(),
            "kuka.yaml" => bundled(KUKA),
            _ => bundled(PROGRAM),
        };
        std::fs::copy(from, work.join(name)).unwrap();
    }
    let robot = model.with_file_name("robot.yaml");
    if robot.exists() {
        std::fs::copy(robot, work.join("robot.yaml")).unwrap();
    }
    let lines = [
        "diagnose --robot {}/robot.yaml --log {}/train.csv.gz --report {}/page.html",
        "identify path --robot {}/robot.yaml --log {}/train.csv.gz --report {}/page.html",
        "show {}/program.csv --robot {}/kuka.yaml --output {}/page.html",
    ];
    let folder = work.path().to_str().unwrap();
    for line in lines {
        let out = run_from_root(work.path(), line);
        if !out.succeeded() {
            assert!(line.starts_with("identify"), "{line}: {}", out.stderr);
            continue;
        }
        let text = std::fs::read_to_string(work.join("page.html")).unwrap();
        assert!(!text.contains(folder), "{line}: the page names {folder}");
    }
}

#[test]
fn a_table_is_not_written_under_the_name_of_a_vendor_s_program() {
    let work = WorkFolder::new();
    let file = work.join("plan.mod");
    let out = run_args(root(), &["plan-experiment", "path", "--robot", KUKA, "--output", file.to_str().unwrap()]);
    assert!(out.code == Some(2) && !file.exists(), "{}", out.stderr);
    assert!(out.stderr.contains("a table (.csv)"));
}

#[test]
fn show_names_the_command_that_reads_a_recording() {
    let work = WorkFolder::new();
    std::fs::write(work.join("bag.db3"), b"SQLite format 3\0\x10\x00\x01\x01").unwrap();
    std::fs::write(work.join("export.csv"), "Time;X;Y;Z\n10:00:00,0;1,5;2;3\n").unwrap();
    let said = |file: &str, words: &str| {
        let line = format!("show {file} --robot {KUKA} --output {{}}/page.html");
        let out = run_from_root(work.path(), &line);
        assert!(out.code == Some(2) && out.stderr.contains(words), "{file}: {}", out.stderr);
        assert!(!out.stderr.contains('\0') && !work.join("page.html").exists());
    };
    said("samples/join/tracker_2.csv.gz", "`lostmotion join` makes one of it");
    said("{}/export.csv", "`lostmotion join` makes one of it");
    said("samples/bidirectional/irb1600_y.csv", "`lostmotion assess bidirectional --readings FILE");
    said("{}/bag.db3", "`ros2 bag convert` writes it");
    let out = run_from_root(
        work.path(),
        &format!("join --robot {KUKA} --controller {{}}/bag.db3 --tracker samples/join/tracker_2.csv.gz"),
    );
    assert!(out.code == Some(2) && out.stderr.contains("a recording in SQLite (.db3)"), "{}", out.stderr);
}
