//! Golden files: `rewrite --check` on programs and folders, with a tolerance, and the shipped hook and Action.

use crate::support::{self, WorkFolder, bundled, root};
use predicates::prelude::*;
use std::path::PathBuf;

/// A repository of programs: robot.yaml, compensator.yaml, sources in `src` and their rewritten form in `programs`.
struct Repository {
    dir: WorkFolder,
}

impl Repository {
    fn new() -> Self {
        let dir = WorkFolder::new();
        let here = dir.path();
        std::fs::copy(bundled("configs/kuka-kr120-r2500-pro.yaml"), here.join("robot.yaml")).unwrap();
        let robot = lostmotion::robot::Robot::load(&here.join("robot.yaml")).unwrap();
        let compensator = format!(
            "schema: lostmotion/compensator/1\nrobot: {{name: {}, sha256: {}}}\njoints:\n  A1: {{backlash: {{half_gap_deg: 0.0125}}}}\n",
            robot.name,
            robot.fingerprint()
        );
        std::fs::write(here.join("compensator.yaml"), compensator).unwrap();
        std::fs::create_dir_all(here.join("src/cell")).unwrap();
        std::fs::write(here.join("src/weld.src"), weld()).unwrap();
        std::fs::write(here.join("src/cell/turns.csv"), turns()).unwrap();
        let this = Self { dir };
        this.run("rewrite --robot robot.yaml --compensator compensator.yaml src --output-dir programs").success();
        assert_ne!(this.read("programs/weld.src"), weld(), "the offsets are written");
        this
    }

    fn run(&self, line: &str) -> assert_cmd::assert::Assert {
        self.run_words(line.split_whitespace().map(String::from).collect())
    }

    fn run_words(&self, words: Vec<String>) -> assert_cmd::assert::Assert {
        support::command().current_dir(self.dir.path()).args(words).assert()
    }

    fn check(&self, rest: &str) -> assert_cmd::assert::Assert {
        self.run(&format!("rewrite --robot robot.yaml --compensator compensator.yaml {rest}"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }
}

/// A program with two reversals of A1.
fn weld() -> String {
    let mut text = String::from("DEF weld( )\n");
    for a1 in ["0.0", "10.0", "-5.0", "12.0"] {
        text += &format!("PTP {{A1 {a1}, A2 -90.0, A3 90.0, A4 0.0, A5 30.0, A6 0.0}}\n");
    }
    text + "END\n"
}

fn turns() -> String {
    let mut text = String::from("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    for k in [0, 5, 10, 5, 0, 5, 10] {
        text += &format!("{k}.0000,-90.0000,90.0000,0.0000,30.0000,0.0000\n");
    }
    text
}

/// The words of `line` as a shell without expansions reads them.
fn shell_words(line: &str) -> Vec<String> {
    let out = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\n' {line}")]).output().unwrap();
    String::from_utf8(out.stdout).unwrap().lines().map(String::from).collect()
}

/// The entry of a shipped hook, and the arguments that the page documents for it.
fn hook(id: &str) -> (Vec<String>, Vec<String>) {
    let read = |name: &str| std::fs::read_to_string(root().join(name)).unwrap();
    let hooks: serde_yaml::Value = serde_yaml::from_str(&read(".pre-commit-hooks.yaml")).unwrap();
    let hook = hooks.as_sequence().unwrap().iter().find(|h| h["id"].as_str() == Some(id)).unwrap();
    let page = read("docs/golden-files.md");
    let block = page.split("```yaml\n").nth(1).unwrap().split("```").next().unwrap();
    let config: serde_yaml::Value = serde_yaml::from_str(block).unwrap();
    let uses = config["repos"][0]["hooks"].as_sequence().unwrap();
    let used = uses.iter().find(|h| h["id"].as_str() == Some(id)).unwrap();
    let args = used.get("args").and_then(|a| a.as_sequence()).cloned().unwrap_or_default();
    let args = args.iter().map(|a| a.as_str().unwrap().to_string()).collect();
    (shell_words(hook["entry"].as_str().unwrap()), args)
}

/// Runs a hook as pre-commit does: entry, arguments, then the files.
#[cfg(unix)]
fn run_hook(repository: &Repository, id: &str, files: &[&str]) -> std::process::Output {
    let (entry, args) = hook(id);
    let binary = support::binary().parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap();
    let path = std::env::join_paths(std::iter::once(binary).chain(std::env::split_paths(&path))).unwrap();
    std::process::Command::new(&entry[0])
        .args(&entry[1..])
        .args(args)
        .args(files)
        .env("PATH", path)
        .current_dir(repository.dir.path())
        .output()
        .unwrap()
}

#[cfg(unix)]
#[test]
fn the_shipped_hooks_pass_on_a_repository_in_order_and_fail_on_a_change() {
    let r = Repository::new();
    let words = |out: &std::process::Output| String::from_utf8_lossy(&out.stderr).into_owned();
    let out = run_hook(&r, "lostmotion-check", &[]);
    assert_eq!(out.status.code(), Some(0), "{}", words(&out));
    r.write("programs/weld.src", &r.read("programs/weld.src").replace("A5 30.0", "A5 31.0"));
    let out = run_hook(&r, "lostmotion-check", &[]);
    assert_eq!(out.status.code(), Some(1), "{}", words(&out));
    assert!(words(&out).contains("programs/weld.src:2: the output differs"), "{}", words(&out));

    let out = run_hook(&r, "lostmotion-robot", &["robot.yaml"]);
    assert_eq!(out.status.code(), Some(0), "{}", words(&out));
    r.write("robot.yaml", "schema: lostmotion/robot/1\n");
    assert_ne!(run_hook(&r, "lostmotion-robot", &["robot.yaml"]).status.code(), Some(0));
}

#[test]
fn the_arguments_that_the_action_documents_run() {
    let r = Repository::new();
    let read = |name: &str| std::fs::read_to_string(root().join(name)).unwrap();
    let action: serde_yaml::Value = serde_yaml::from_str(&read("action.yml")).unwrap();
    let described = action["inputs"]["arguments"]["description"].as_str().unwrap();
    let page = read("docs/golden-files.md");
    let shown = page.lines().find_map(|l| l.trim().strip_prefix("arguments: ")).unwrap();
    for line in [described.split_once(": ").unwrap().1, shown] {
        r.run(line).success();
    }
}

#[test]
fn a_folder_is_checked_against_the_folder_of_its_results() {
    let r = Repository::new();
    r.check("src --check programs").success().stderr("2 of 2 programs as in programs\n");
    r.write("programs/old.src", &weld());
    r.check("src --check programs")
        .success()
        .stderr(predicate::str::contains("note: programs/old.src: no program of src"));
    std::fs::remove_file(r.path("programs/cell/turns.csv")).unwrap();
    let missing = predicate::str::contains("programs/cell/turns.csv: found no file; expected the rewritten program")
        .and(predicate::str::contains("1 of 2 programs is not as in programs"));
    r.check("src --check programs").code(1).stderr(missing);
    r.check("src --check nowhere").code(2).stderr(predicate::str::contains("which does not exist"));
    assert_eq!(r.read("src/weld.src"), weld(), "nothing is written");
}

#[test]
fn a_check_says_in_two_lines_that_programs_are_alike_and_puts_the_difference_first() {
    let r = Repository::new();
    let alike = r.check("src/weld.src --check programs/weld.src").success();
    let words = String::from_utf8_lossy(&alike.get_output().stderr).into_owned();
    assert!(words.starts_with("programs/weld.src: as rewritten now\n") && words.lines().count() == 2, "{words}");
    r.write("programs/weld.src", &r.read("programs/weld.src").replace("A5 30.0", "A5 31.0"));
    let differs = r.check("src/weld.src --check programs/weld.src").code(1);
    let words = String::from_utf8_lossy(&differs.get_output().stderr).into_owned();
    assert!(words.starts_with("lostmotion: programs/weld.src:2: the output differs"), "{words}");
    assert!(words.lines().last().unwrap().contains("4 moves") && words.lines().count() <= 4, "{words}");
}

#[test]
fn a_tolerance_accepts_numbers_that_differ_by_no_more() {
    let r = Repository::new();
    let was = [r.read("programs/weld.src"), r.read("programs/cell/turns.csv")];
    let other = was.clone().map(|t| t.replace("30.0", "30.001"));
    for (name, text) in ["programs/weld.src", "programs/cell/turns.csv"].iter().zip(&other) {
        r.write(name, text);
    }
    r.check("src --check programs").code(1);
    r.check("src --check programs --tolerance 0.0005").code(1);
    r.check("src --check programs --tolerance 0.002").success().stderr(predicate::str::contains("within 0.002"));
    r.check("src/cell/turns.csv --check programs/cell/turns.csv --tolerance 0.002").success();
    let differs = predicate::str::contains("turns.csv:2: the output differs");
    r.check("src/cell/turns.csv --check programs/cell/turns.csv --tolerance 0.0005").code(1).stderr(differs);
    // text is text, whatever the tolerance
    r.write("programs/weld.src", &was[0].replace("A5 30.0", "A4 30.0"));
    r.check("src/weld.src --check programs/weld.src --tolerance 90").code(1);
    // a file that ends early, or goes on
    let short = was[1].trim_end().rsplit_once('\n').unwrap().0.to_string() + "\n";
    r.write("programs/cell/turns.csv", &short);
    let ends = predicate::str::contains("the golden file ends");
    r.check("src/cell/turns.csv --check programs/cell/turns.csv --tolerance 1").code(1).stderr(ends);
    r.write("programs/cell/turns.csv", &(was[1].clone() + "0,0,0,0,0,0\n"));
    let ends = predicate::str::contains("the output ends");
    r.check("src/cell/turns.csv --check programs/cell/turns.csv --tolerance 1").code(1).stderr(ends);
}

#[test]
fn an_output_beside_a_check_is_refused_and_beside_a_dry_run_is_named() {
    let r = Repository::new();
    let both = "src/weld.src --check programs/weld.src -o z.src";
    r.check(both).code(2).stderr(predicate::str::contains("cannot be used with"));
    r.check("src/weld.src --dry-run -o z.src")
        .success()
        .stderr(predicate::str::contains("note: z.src: not written (--dry-run)"));
    r.check("src --dry-run --output-dir z")
        .success()
        .stderr(predicate::str::contains("note: z: not written (--dry-run)"));
    assert!(!r.path("z.src").exists() && !r.path("z").exists());
}
