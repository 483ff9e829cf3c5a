//! Options of `rewrite`: what has no effect, or names one stream twice, is refused and nothing is written.

use crate::support::{Outcome, WorkFolder, bundled};

/// A folder with a robot of three axes, a model, a program and a folder of programs.
struct Bench(WorkFolder);

impl Bench {
    fn new() -> Self {
        let folder = WorkFolder::new();
        std::fs::copy(bundled("configs/gantry-xyz-ballscrew.yaml"), folder.join("robot.yaml")).unwrap();
        let effect = "{effect: backlash, joint: X, half_gap_mm: 0.05}";
        let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n");
        std::fs::write(folder.join("model.yaml"), model).unwrap();
        std::fs::create_dir(folder.join("cell")).unwrap();
        let rows: String = (0..30).map(|j| format!("{:.4},400.0,-10.0\n", 500.0 + f64::from(j % 7))).collect();
        for name in ["p.csv", "cell/p.csv"] {
            std::fs::write(folder.join(name), format!("x_mm,y_mm,z_mm\n{rows}")).unwrap();
        }
        Self(folder)
    }

    /// `rewrite` with words that hold no spaces; `''` is an empty one.
    fn rewrite(&self, line: &str) -> Outcome {
        let words = line.split_whitespace().map(|w| if w == "''" { "" } else { w });
        crate::support::run_args(self.0.path(), ["rewrite", "--model", "model.yaml"].into_iter().chain(words))
    }

    fn has(&self, name: &str) -> bool {
        self.0.join(name).exists()
    }

    /// The line is refused in one line that holds `words`, and writes none of the files that it may name.
    fn refuses(&self, line: &str, words: &str) {
        let out = self.rewrite(line).ends_with(2);
        assert!(out.stderr.contains(words) && out.stderr.lines().count() == 1, "{line}: {}", out.stderr);
        assert!(out.stdout.is_empty(), "{line}: {}", out.text());
        assert!(["o.csv", "s.jsonl", "r.html", "done", "new"].iter().all(|f| !self.has(f)), "{line}");
    }
}

#[test]
fn options_without_an_effect_are_refused() {
    let bench = Bench::new();
    std::fs::copy(bench.0.join("p.csv"), bench.0.join("golden.csv")).unwrap();
    for (line, words) in [
        ("p.csv --output o.csv --shard 9/3", "--shard with a single program"),
        ("p.csv --output o.csv --shard 1/3", "--shard with a single program"),
        ("p.csv --check golden.csv --shard 9/3", "--shard with a single program"),
        ("p.csv --output o.csv --verdict", "--verdict with a single program"),
        ("p.csv --check golden.csv --verdict", "--verdict with"),
        ("cell --check cell --verdict", "--verdict with --check"),
        ("cell --dry-run --output-dir done --verdict", "--verdict with --dry-run"),
        ("p.csv --list-frames --summary s.jsonl", "--summary with --list-frames"),
        ("cell --list-frames --report r.html", "--report with --list-frames"),
        ("p.csv --output o.csv --fail-on none", "--fail-on with a single program"),
        ("p.csv --output o.csv --fail-on failed", "--fail-on with a single program"),
        ("p.csv --output o.csv --leave-out ''", "--leave-out without a joint"),
        ("p.csv --output o.csv --leave-out ,", "--leave-out without a joint"),
        ("p.csv --output o.csv --initial-direction ''", "--initial-direction without a joint"),
        ("p.csv --output o.csv --approach-from ''", "--approach-from without a joint"),
        ("cell --output-dir done --shard 9/3", "--shard 9/3"),
        ("cell --output-dir done --shard -5/8", "found --shard -5/8; expected K/N"),
        ("p.csv --output o.csv --require-coverage -5%", "--require-coverage -5%"),
        ("p.csv --output o.csv --chord-um -2", "--chord-um -2"),
        ("p.csv --output new/", "--output: found new/, the name of a folder"),
    ] {
        bench.refuses(line, words);
    }
    bench.rewrite("p.csv --output o.csv --fail-on refused").success();
}

#[test]
fn a_number_below_zero_is_refused_as_a_number() {
    let bench = Bench::new();
    for (line, words) in [
        ("--jobs -1", "a number of threads is a whole number from 1 to 1024"),
        ("-j -1", "a number of threads is a whole number from 1 to 1024"),
        ("--max-added -1", "'-1' for '--max-added <N>'"),
        ("--decimals -1", "'-1' for '--decimals <N>'"),
    ] {
        let out = bench.rewrite(&format!("p.csv --output o.csv {line}")).ends_with(2);
        assert!(out.stderr.contains(words) && !out.stderr.contains("Usage"), "{line}: {}", out.stderr);
    }
}

#[test]
fn standard_output_takes_one_document() {
    let bench = Bench::new();
    for line in [
        "p.csv --output o.csv --json --summary -",
        "p.csv --output o.csv --json --report -",
        "p.csv --output - --json",
        "p.csv --output /dev/stdout --json",
        "cell --output-dir done --json --summary -",
    ] {
        bench.refuses(line, "standard output, which --json uses");
    }
    bench.refuses("p.csv --output - --summary -", "standard output, which --output uses");
    let out = bench.rewrite("p.csv --output o.csv --summary -").success();
    assert!(out.text().starts_with("{\"input\":\"p.csv\""), "{}", out.text());
    let document: serde_json::Value = bench.rewrite("p.csv --output o.csv --json").success().json();
    assert_eq!(document["status"], "written");
}

/// `/dev/stdout` is standard output also where that is a file.
#[cfg(target_os = "linux")]
#[test]
fn the_names_of_standard_streams_are_those_streams() {
    use std::fs::File;
    let bench = Bench::new();
    bench.rewrite("p.csv --output o.csv").success();
    let whole = std::fs::read(bench.0.join("o.csv")).unwrap();
    for (input, output) in [("p.csv", "/dev/stdout"), ("/dev/stdin", "/proc/self/fd/1"), ("-", "/dev/fd/1")] {
        let target = bench.0.join("redirected.csv");
        let mut command = crate::support::process();
        command.current_dir(bench.0.path()).args(["rewrite", "--model", "model.yaml", input, "--output", output]);
        command.stdin(File::open(bench.0.join("p.csv")).unwrap()).stdout(File::create(&target).unwrap());
        let out = command.output().unwrap();
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.success() && !said.contains("replaced"), "{output}: {said}");
        assert_eq!(std::fs::read(&target).unwrap(), whole, "{output}");
        assert!(!std::path::Path::new(&format!("{output}.lostmotion.json")).exists(), "{output}");
    }
}

#[test]
fn messages_name_their_file_and_agree_in_number() {
    let bench = Bench::new();
    bench.rewrite("cell --output-dir golden").success();
    std::fs::write(bench.0.join("golden/p.csv"), "x_mm,y_mm,z_mm\n1,2,-3\n").unwrap();
    let out = bench.rewrite("cell --check golden").ends_with(1);
    assert!(out.stderr.contains("1 of 1 program is not as in golden"), "{}", out.stderr);
    // a stream whose original is in no note
    let program = std::fs::read(bench.0.join("p.csv")).unwrap();
    let mut command = crate::support::command();
    command.current_dir(bench.0.path()).args(["rewrite", "--model", "model.yaml", "-", "--output", "o.csv"]);
    crate::support::outcome(command.write_stdin(program)).success();
    let out = bench.0.run("undo o.csv --output back.csv").ends_with(1);
    assert!(out.stderr.contains("the bytes of standard input (a stream"), "{}", out.stderr);
}

/// The verdict starts the machine on the side that the option states: the first target is right with it, and would be off by a gap without.
#[test]
fn the_verdict_knows_from_which_side_a_joint_comes() {
    let bench = Bench::new();
    let rows: String = (0..6).map(|j| format!("{}.0000,400.0000,-10.0000\n", 500 + 10 * j)).collect();
    std::fs::write(bench.0.join("p.csv"), format!("x_mm,y_mm,z_mm\n{rows}")).unwrap();
    let out = bench.rewrite("p.csv --output o.csv --initial-direction X=-").ends_with(0);
    assert!(out.stderr.contains("unchanged: path error"), "{}", out.stderr);
    assert!(std::fs::read_to_string(bench.0.join("o.csv")).unwrap().contains("499.9500"));
}
