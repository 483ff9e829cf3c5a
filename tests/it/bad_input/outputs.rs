//! Outputs that cannot be written, must not be written, or already stand there.

use super::{good_folder, listing};
use crate::support::{self, Outcome, run};

/// Commands up to their output.
const WRITERS: [&str; 5] = [
    "identify path --robot robot.yaml --log log.csv --output",
    "fit --robot robot.yaml --gaps gaps.yaml --output",
    "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output",
    "simulate --model model.yaml --input program.csv --output",
    "simulate --model model.yaml --input log.csv --output",
];
const REWRITE: &str = "rewrite --robot robot.yaml --compensator comp.yaml";

fn refused_in_one_line(out: &Outcome, what: &str) {
    let text = &out.stderr;
    assert!(out.code == Some(2) && text.contains(what) && text.lines().count() == 1, "{text}");
    assert!(out.stdout.is_empty());
}

#[cfg(unix)]
#[test]
fn a_read_only_target_keeps_what_it_holds() {
    use std::os::unix::fs::PermissionsExt;
    let folder = good_folder();
    let kept = folder.join("kept");
    std::fs::write(&kept, "old").unwrap();
    std::fs::set_permissions(&kept, std::fs::Permissions::from_mode(0o444)).unwrap();
    let before = listing(folder.path());
    for line in WRITERS {
        refused_in_one_line(&run(folder.path(), &format!("{line} kept")), "kept: cannot write");
        assert_eq!(std::fs::read(&kept).unwrap(), b"old");
        assert_eq!(listing(folder.path()), before, "{line}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_refused_by_every_writer() {
    let folder = good_folder();
    let before = listing(folder.path());
    for line in WRITERS {
        refused_in_one_line(&run(folder.path(), &format!("{line} /dev/full")), "/dev/full: cannot write");
        assert_eq!(listing(folder.path()), before, "{line}");
    }
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for line in WRITERS.map(|l| format!("{l} -")).iter().chain(&PRINTERS.map(str::to_string)) {
        let mut command = support::process();
        let out = command.current_dir(folder.path()).args(line.split_whitespace()).stdout(full()).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr);
        let last = text.lines().last().unwrap_or_default();
        assert!(out.status.code() == Some(2) && last.contains("standard output: cannot write"), "{line}: {text}");
    }
}

/// Commands that print what they found.
const PRINTERS: [&str; 4] = [
    "assess impact --model model.yaml --pose 1,2,3",
    "assess impact --model model.yaml --program program.csv --json",
    "rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run --json",
    "fit --robot robot.yaml --gaps gaps.yaml --json",
];

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_failure_of_any_command() {
    use std::process::Stdio;
    let folder = good_folder();
    for line in WRITERS.map(|l| format!("{l} -")).iter().chain(&PRINTERS.map(str::to_string)) {
        let mut command = support::process();
        command.current_dir(folder.path()).args(line.split_whitespace());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let out = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.success() && !text.contains("pipe") && !text.contains("panicked"), "{line}: {text}");
    }
}

#[test]
fn its_own_output_is_refused_without_force_under_whatever_name() {
    let folder = good_folder();
    let at = |name: &str| folder.join(name);
    assert!(run(folder.path(), &format!("{REWRITE} program.csv --output out.csv")).succeeded());
    std::fs::rename(at("out.csv"), at("renamed.csv")).unwrap();
    let before = listing(folder.path());
    let again = run(folder.path(), &format!("{REWRITE} renamed.csv --output again.csv"));
    refused_in_one_line(&again, "renamed.csv: found a program that has been rewritten already");
    assert_eq!(listing(folder.path()), before);
    assert!(run(folder.path(), &format!("{REWRITE} renamed.csv --output again.csv --force")).succeeded());
    assert_ne!(std::fs::read(at("again.csv")).unwrap(), std::fs::read(at("renamed.csv")).unwrap());
    // the original may be rewritten any number of times, also over the last output
    assert!(run(folder.path(), &format!("{REWRITE} program.csv --output again.csv")).succeeded());
    assert_eq!(std::fs::read(at("again.csv")).unwrap(), std::fs::read(at("renamed.csv")).unwrap());
}

#[test]
fn a_limit_that_would_be_exceeded_is_listed_and_nothing_is_written() {
    let folder = good_folder();
    let mut text = String::from("# to the limit of J1\nt_s,J1_deg,J2_deg,Z_mm\n");
    for i in 0..=20 {
        text.push_str(&format!("{i},{:.3},0,5\n", 160.0 + f64::from(10 - (i - 10_i32).abs())));
    }
    std::fs::write(folder.join("limit.csv"), text).unwrap();
    let before = listing(folder.path());
    let out = run(folder.path(), &format!("{REWRITE} limit.csv --output out.csv"));
    let text = out.stderr;
    assert_eq!(out.code, Some(1), "{text}");
    assert!(text.contains("limit.csv: a limit would be exceeded"), "{text}");
    assert!(text.contains("limit.csv:13: J1 position 170.00") && text.contains("limit 170.000000 deg"), "{text}");
    assert!(out.stdout.is_empty() && !text.contains("points added"), "{text}");
    assert_eq!(listing(folder.path()), before);
    let json = run(folder.path(), &format!("{REWRITE} limit.csv --output out.csv --json"));
    let v: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((json.code, v["status"].as_str(), v["output"].as_str()), (Some(1), Some("refused"), None));
    assert!(v["limits_exceeded"].as_u64().unwrap() > 0);
    assert_eq!(listing(folder.path()), before);
    // a program that is beyond a limit by itself is refused as such
    assert!(!text.contains("the program itself"), "{text}");
    let beyond = std::fs::read_to_string(folder.join("limit.csv")).unwrap().replace("170.000", "170.500");
    std::fs::write(folder.join("limit.csv"), beyond).unwrap();
    let text = run(folder.path(), &format!("{REWRITE} limit.csv --output out.csv")).stderr;
    assert!(text.contains("limit 170.000000 deg (the program itself exceeds it)"), "{text}");
}

#[test]
fn a_check_is_0_where_equal_and_1_with_degrees_and_micrometres_where_not() {
    let folder = good_folder();
    let at = |name: &str| folder.join(name);
    assert!(run(folder.path(), &format!("{REWRITE} program.csv --output golden.csv")).succeeded());
    let before = listing(folder.path());
    let same = run(folder.path(), &format!("{REWRITE} program.csv --check golden.csv"));
    assert!(same.succeeded() && same.stdout.is_empty(), "{}", same.stderr);
    let golden = std::fs::read_to_string(at("golden.csv")).unwrap();
    let line = golden.lines().nth(20).unwrap();
    let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
    cells[1] = format!("{:.4}", cells[1].parse::<f64>().unwrap() + 0.001);
    std::fs::write(at("golden.csv"), golden.replace(line, &cells.join(","))).unwrap();
    let other = run(folder.path(), &format!("{REWRITE} program.csv --check golden.csv"));
    let text = other.stderr;
    assert!(other.code == Some(1) && other.stdout.is_empty(), "{text}");
    // 0.001 deg at the reach of the arm: some 12 um
    let um: f64 = text.rsplit("at the TCP ").next().unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(text.contains("golden.csv:21: the output differs") && (9.0..13.0).contains(&um), "{text}");
    assert!(text.contains("J1_deg") && text.contains("-0.001000 deg"), "{text}");
    assert_eq!(listing(folder.path()), before);
}

#[test]
fn a_file_of_another_kind_is_not_replaced_and_one_of_the_same_kind_is_named() {
    let folder = good_folder();
    let at = |name: &str| folder.join(name);
    std::fs::write(at("weld.src"), "DEF weld( )\nEND\n").unwrap();
    let before = listing(folder.path());
    for (line, there) in [
        ("show robot.yaml -o model.yaml", "a model document"),
        ("show robot.yaml -o weld.src", "a program (krl)"),
        ("identify path --robot robot.yaml --log log.csv -o model.yaml", "a model document"),
        ("rewrite --robot robot.yaml --compensator comp.yaml program.csv -o gaps.yaml", "a gaps document"),
    ] {
        refused_in_one_line(&run(folder.path(), line), &format!("found {there}, which"));
        assert_eq!(listing(folder.path()), before, "{line}");
    }
    // what a script runs again replaces what it wrote
    std::fs::write(at("empty"), "").unwrap();
    for (line, name) in [
        ("identify path --robot robot.yaml --log log.csv -o", "new.yaml"),
        ("simulate --model model.yaml --input program.csv -o", "new.csv"),
        ("show robot.yaml -o", "new.html"),
        ("rewrite --robot robot.yaml --compensator comp.yaml program.csv -o", "out.csv"),
        ("show robot.yaml -o", "empty"),
    ] {
        let first = run(folder.path(), &format!("{line} {name}"));
        assert!(first.succeeded(), "{line}: {}", first.stderr);
        assert_eq!(first.stderr.contains("replaced: "), name == "empty", "{line}: {}", first.stderr);
        let bytes = std::fs::read(at(name)).unwrap();
        let again = run(folder.path(), &format!("{line} {name}"));
        assert!(again.succeeded() && again.stderr.contains(&format!("replaced: {name}")), "{}", again.stderr);
        assert_eq!(std::fs::read(at(name)).unwrap(), bytes, "{line}");
    }
}

#[test]
fn a_mistaken_name_replaces_no_program_no_notes_no_other_table_and_no_file_of_the_job() {
    let folder = good_folder();
    let at = |name: &str| folder.join(name);
    std::fs::create_dir(at("cell")).unwrap();
    std::fs::copy(at("program.csv"), at("cell/program.csv")).unwrap();
    for (name, text) in [
        ("weld.src", "DEF weld( )\nPTP {A1 0}\nEND\n"),
        ("notes.txt", "milk, eggs and 2 loaves.\n"),
        ("people.csv", "name,mail\nA,B\n"),
        ("list.txt", "program.csv\n"),
    ] {
        std::fs::write(at(name), text).unwrap();
    }
    let manifest = "manifest cell --output m.jsonl";
    let part = format!("{REWRITE} cell --manifest m.jsonl --output-dir done --summary s.jsonl");
    let merge = "merge --manifest m.jsonl s.jsonl --output all.jsonl";
    for line in [manifest, &part, merge, &format!("{REWRITE} program.csv --output out.csv")] {
        run(folder.path(), line).success();
    }
    let before = listing(folder.path());
    for (line, file) in [
        ("manifest cell --output weld.src".into(), "weld.src"),
        ("manifest cell --output s.jsonl".into(), "s.jsonl"),
        ("manifest list.txt --root cell --output list.txt".into(), "list.txt"),
        ("merge --manifest m.jsonl s.jsonl --output m.jsonl".into(), "m.jsonl"),
        ("merge --manifest m.jsonl s.jsonl --output s.jsonl".into(), "s.jsonl"),
        ("undo out.csv -o people.csv".into(), "people.csv"),
        (format!("{REWRITE} program.csv --output people.csv"), "people.csv"),
        (format!("{REWRITE} program.csv --output notes.txt"), "notes.txt"),
        (format!("{REWRITE} program.csv --output z.csv --summary weld.src"), "weld.src"),
        (format!("{REWRITE} cell --output-dir z --summary weld.src"), "weld.src"),
        (format!("{REWRITE} cell --manifest m.jsonl --output-dir z --summary m.jsonl"), "m.jsonl"),
        (format!("{REWRITE} cell --manifest m.jsonl --output-dir z --report m.jsonl"), "m.jsonl"),
    ] {
        let kept = std::fs::read(at(file)).unwrap();
        let out = run(folder.path(), &line).ends_with(2);
        assert_eq!(std::fs::read(at(file)).unwrap(), kept, "{line}: {}", out.stderr);
        assert!(!at("z.csv").exists() && !at("z/program.csv").exists(), "{line}: {}", out.stderr);
    }
    // what a job runs again replaces what it wrote
    for line in [manifest, &part, merge] {
        assert!(run(folder.path(), line).success().stderr.contains("replaced: "), "{line}");
    }
    let after: Vec<_> = listing(folder.path()).into_iter().filter(|p| !p.ends_with("z")).collect();
    assert_eq!(after, before);
}
