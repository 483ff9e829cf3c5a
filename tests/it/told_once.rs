//! Messages, help and man pages: each thing is said once, is true of the file at hand, and names what to do.

use crate::support::{WorkFolder, bundled, run_from_root};

const KUKA: &str = "configs/kuka-kr120-r2500-pro.yaml";
const FIGURE5: &str = "samples/models/kuka-figure5.model.yaml";

#[test]
fn a_dry_run_says_once_that_nothing_is_written() {
    let work = WorkFolder::new();
    let line = format!(
        "rewrite --model {FIGURE5} samples/circle/circle_program.csv --speed-mm-s 1.5 --output {{}}/q.csv --dry-run"
    );
    let outcome = run_from_root(work.path(), &line).success();
    assert_eq!(outcome.stderr.matches("not written (--dry-run)").count(), 1, "{}", outcome.stderr);
}

#[test]
fn what_holds_for_all_joints_is_said_once_and_only_what_is_true_of_the_program() {
    let work = WorkFolder::new();
    let line = format!("rewrite --model {FIGURE5} samples/programs/krl/folds.src --dry-run");
    let text = run_from_root(work.path(), &line).success().stderr;
    assert_eq!(text.matches("--step-fraction puts the step nearer").count(), 1, "{text}");
    assert!(text.contains("cycle time of the whole program: not known, because"), "{text}");
    assert_eq!(text.lines().filter(|l| l.trim_start().starts_with("verdict")).count(), 1, "{text}");
    let line = format!("rewrite --model {FIGURE5} samples/programs/fanuc/welding.ls --dry-run");
    let text = run_from_root(work.path(), &line).success().stderr;
    assert!(
        !text.contains("no times and no speeds")
            && text.contains("cycle time of the whole program: not known, because"),
        "{text}"
    );
}

#[test]
fn a_check_of_a_folder_parts_what_differs() {
    let work = WorkFolder::new();
    std::fs::create_dir(work.join("in")).unwrap();
    std::fs::copy(bundled("samples/circle/circle_program.csv"), work.join("in/circle.csv")).unwrap();
    let line = |more: &str| format!("rewrite --model {FIGURE5} {{}}/in --speed-mm-s 1.5 {more}");
    run_from_root(work.path(), &line("--output-dir {}/done")).success();
    let golden = std::fs::read_to_string(work.join("done/circle.csv")).unwrap();
    let mut rows: Vec<String> = golden.lines().map(String::from).collect();
    rows[10] = rows[10].replacen('1', "2", 1);
    std::fs::write(work.join("done/circle.csv"), rows.join("\n") + "\n").unwrap();
    let text = run_from_root(work.path(), &line("--check {}/done")).ends_with(1).stderr;
    assert!(text.contains("the output differs; a1_deg:") && !text.contains("   "), "{text}");
}

#[test]
fn a_recording_with_semicolons_is_sent_to_columns() {
    let work = WorkFolder::new();
    std::fs::write(work.join("g.csv"), "Zeit;X;Y;Z\n0,0;1,5;2,5;3\n1;2;3;4\n").unwrap();
    for (line, what) in [
        (format!("show {{}}/g.csv --robot {KUKA} --output {{}}/g.html"), "a recording of a tracker, without joints"),
        (format!("rewrite --model {FIGURE5} {{}}/g.csv --output {{}}/h.csv"), "semicolons"),
    ] {
        let text = run_from_root(work.path(), &line).ends_with(2).stderr;
        assert!(text.contains(what) && text.contains("`lostmotion columns` drafts a column map"), "{text}");
    }
}

#[test]
fn a_plan_in_the_language_of_another_maker_gets_a_note() {
    let work = WorkFolder::new();
    let plan = |name: &str| {
        let line = format!("plan-experiment static --robot {KUKA} --pose 0,-90,90,0,20,0 --output {{}}/{name}");
        run_from_root(work.path(), &line).success().stderr
    };
    let text = plan("plan.mod");
    assert!(
        text.contains("the program is in RAPID (.mod)") && text.contains("whose controller reads KRL (.src)"),
        "{text}"
    );
    assert!(!plan("plan.src").contains("whose controller"));
}

#[test]
fn each_command_has_a_man_page_of_its_own() {
    let work = WorkFolder::new();
    work.run("completions man --output-dir man1").success();
    let page = |name: &str| std::fs::read_to_string(work.join(format!("man1/{name}.1"))).unwrap();
    assert!(page("lostmotion-identify-path").contains("lostmotion identify path"));
    assert_eq!(page("lostmotion").matches(".TH ").count(), 1);
    assert!(std::fs::read_dir(work.join("man1")).unwrap().count() > 30);
    assert!(work.run("completions bash --output-dir man1").ends_with(2).stderr.contains("--output-dir"));
}

#[test]
fn every_document_with_a_schema_is_named_in_the_help() {
    let work = WorkFolder::new();
    let help = work.run("schema --help").success().text();
    for (name, _) in lostmotion::schemas::NAMES {
        assert!(help.contains(name), "no {name} in {help}");
    }
}
