//! What a rewrite of a single program replaces, and where its output may go.

use crate::folder_results::desk;

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
