//! Verdicts on the programs of a folder: the same as on each alone, and the same when the folder is taken up again.

use crate::support::{WorkFolder, bundled};
use serde_json::Value;

const MODEL: &str = "samples/models/kuka-figure5.model.yaml";

/// The lines of a summary by the file name of their program.
fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn every_program_of_a_folder_has_the_verdict_that_it_has_alone() {
    let folder = WorkFolder::new();
    std::fs::create_dir(folder.join("cell")).unwrap();
    std::fs::copy(bundled("samples/circle/circle_program.csv"), folder.join("cell/circle.csv")).unwrap();
    // three rows with one reversal far from every other point: the step is spread over a long move
    let rows = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n0,-90,90,0,30,0\n5,-90,90,0,30,0\n-5,-90,90,0,30,0\n";
    std::fs::write(folder.join("cell/coarse.csv"), rows).unwrap();
    std::fs::write(folder.join("cell/still.csv"), "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n0,-90,90,0,30,0\n")
        .unwrap();
    let model = bundled(MODEL);
    let model = model.to_str().unwrap();
    let line = |what: &str| format!("rewrite --model {model} --speed-mm-s 10 {what}");
    let plain = line("cell --output-dir plain --summary plain.jsonl");
    folder.run(&plain).success();
    folder.run(&line("cell --output-dir done --verdict --summary first.jsonl")).success();
    folder.run(&line("cell --output-dir done --verdict --summary again.jsonl")).success();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("first.jsonl"), read("again.jsonl"), "of programs that stood there");
    assert!(!read("plain.jsonl").contains("path_error"), "not asked for");
    for (verdict, of) in lines(&read("first.jsonl")).iter().map(|l| (&l["path_error"], l["input"].as_str().unwrap())) {
        let name = of.rsplit('/').next().unwrap();
        assert_eq!(
            std::fs::read(folder.join(format!("plain/{name}"))).unwrap(),
            std::fs::read(folder.join(format!("done/{name}"))).unwrap()
        );
        let alone: Value = folder.run(&line(&format!("cell/{name} --output alone-{name} --json"))).success().json();
        let alone = &alone["path_error"];
        assert_eq!(verdict["verdict"], alone["verdict"], "{name}: {verdict} {alone}");
        if name == "still.csv" {
            assert!(verdict.is_null(), "nothing was changed: {verdict}");
            continue;
        }
        for figure in ["rms_um", "largest_um"] {
            for side in ["before", "after"] {
                let of = |v: &Value| v[figure][side].as_f64().unwrap();
                assert!((of(verdict) - of(alone)).abs() < 0.06, "{name} {figure}: {verdict} {alone}");
            }
        }
    }
}

#[test]
fn the_page_of_a_folder_says_which_programs_get_worse() {
    let folder = WorkFolder::new();
    std::fs::create_dir(folder.join("cell")).unwrap();
    std::fs::copy(bundled("samples/circle/circle_program.csv"), folder.join("cell/circle.csv")).unwrap();
    let model = bundled(MODEL);
    let model = model.to_str().unwrap();
    let run = folder.run(&format!("rewrite --model {model} --speed-mm-s 10 cell --output-dir done --report page.html"));
    let said = run.success().stderr;
    assert!(said.contains("verdicts: 1 better, 0 unchanged, 0 worse, 0 not computed"), "{said}");
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("1 of 1 get better, 0 worse") && page.contains("rms path error"), "{page}");
}
