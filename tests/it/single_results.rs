//! What a rewrite of a single program replaces, and where its output may go.

use crate::folder_results::{desk, model};

const ALONE: &str = "rewrite --model model.yaml cell/pair.src --output out.src";

#[test]
fn an_edited_result_of_a_single_program_stays_unless_its_replacement_is_allowed() {
    let desk = desk();
    let read = |name: &str| std::fs::read_to_string(desk.join(name)).unwrap();
    desk.run(ALONE).success();
    for name in ["out.src", "out.dat"] {
        let whole = read(name);
        let edited = whole.replacen("-90.0000", "-89.0000", 1);
        assert_ne!(edited, whole);
        std::fs::write(desk.join(name), &edited).unwrap();
        let out = desk.run(ALONE).ends_with(1);
        let told = format!("{name}: changed since `rewrite` wrote it; nothing was written");
        assert!(out.stderr.contains(&told) && out.stderr.contains("--replace"), "{}", out.stderr);
        assert_eq!(read(name), edited);
        desk.run(&format!("{ALONE} --replace")).success();
        assert_eq!(read(name), whole);
    }
    // an untouched one is replaced, and so is a data list that equals that of the input
    model(&desk, 0.0128);
    desk.run(ALONE).success();
    std::fs::remove_file(desk.join("out.src.lostmotion.json")).unwrap();
    std::fs::copy(desk.join("cell/pair.dat"), desk.join("out.dat")).unwrap();
    desk.run(ALONE).success();
    // without a note a data list is nobody's
    std::fs::remove_file(desk.join("out.src.lostmotion.json")).unwrap();
    let other = read("out.dat").replace("-90.0000", "-89.0000");
    std::fs::write(desk.join("out.dat"), &other).unwrap();
    let out = desk.run(ALONE).ends_with(1);
    assert!(out.stderr.contains("out.dat: no note shows that it belongs to this program"), "{}", out.stderr);
    assert_eq!(read("out.dat"), other);
}

#[test]
fn force_replaces_no_file_of_the_program_that_is_read_and_gives_no_two_files_one_name() {
    let desk = desk();
    let files = ["pair.src", "pair.dat"].map(|n| desk.join("cell").join(n));
    let before = files.each_ref().map(|f| std::fs::read(f).unwrap());
    for (output, told) in [
        ("cell/pair.txt", "cell/pair.dat: found a file of the program that is read"),
        ("cell/pair.dat", "cell/pair.dat: found "),
        ("x.dat", "x.dat: found two files of the program for one name"),
    ] {
        let out = desk.run(&format!("rewrite --model model.yaml cell/pair.src --output {output} --force")).ends_with(2);
        assert!(out.stderr.contains(told), "{}", out.stderr);
        assert_eq!(files.each_ref().map(|f| std::fs::read(f).unwrap()), before);
    }
    assert!(!desk.join("x.dat").exists() && !desk.join("cell/pair.txt").exists());
    // in place each file goes over itself
    desk.run("rewrite --model model.yaml cell/pair.src --output cell/pair.src --force").success();
    assert_ne!(std::fs::read(&files[1]).unwrap(), before[1]);
}

#[test]
fn a_result_that_is_rewritten_by_force_is_named() {
    let desk = desk();
    desk.run("rewrite --model model.yaml cell/turns.csv --output c2/turns.csv").ends_with(2);
    std::fs::create_dir(desk.join("c2")).unwrap();
    desk.run("rewrite --model model.yaml cell/turns.csv --output c2/turns.csv").success();
    desk.run("rewrite --model model.yaml c2 --output-dir c2d --replace").ends_with(1);
    let out = desk.run("rewrite --model model.yaml c2 --output-dir c2d --force").success();
    assert!(out.stderr.contains("note: c2/turns.csv: rewritten already"), "{}", out.stderr);
}

/// Outputs that the shell gives as names of descriptors, and a standard error that is a pipe.
#[cfg(target_os = "linux")]
#[test]
fn an_output_may_be_a_pipe_under_the_name_of_its_descriptor() {
    let desk = desk();
    desk.run("rewrite --model model.yaml cell/turns.csv --output whole.csv").success();
    let shell = |line: &str| {
        let mut bash = std::process::Command::new("bash");
        bash.args(["-c", line]).env("LM", crate::support::binary()).current_dir(desk.path());
        let out = bash.output().expect("bash is there");
        (out.status.code(), String::from_utf8_lossy(&[out.stdout, out.stderr].concat()).into_owned())
    };
    let rewrite = "$LM -q rewrite --model model.yaml cell/turns.csv";
    let lines = format!("{}\n", std::fs::read_to_string(desk.join("whole.csv")).unwrap().lines().count());
    assert_eq!(shell(&format!("set -o pipefail; {{ {rewrite} --output >(wc -l); }} | cat")), (Some(0), lines));
    let (code, summary) =
        shell("$LM -q rewrite --model model.yaml cell --output-dir d --summary /dev/stderr 2>&1 | cat");
    assert!(code == Some(0) && summary.lines().filter(|l| l.contains("\"status\"")).count() == 3, "{summary}");
    let (code, both) =
        shell(&format!("{rewrite} --output >(cat > a.csv) --summary >(cat > b.jsonl); sleep 1; cat b.jsonl"));
    assert!(code == Some(0) && both.contains("\"status\""), "{both}");
}

#[test]
fn standard_output_has_no_verdict_and_the_report_says_so() {
    let desk = desk();
    let out = desk.run("rewrite --model model.yaml cell/turns.csv --output -").success();
    let told = "verdict: not computed (the program goes to standard output or a pipe)";
    assert!(out.stderr.contains(told), "{}", out.stderr);
}
