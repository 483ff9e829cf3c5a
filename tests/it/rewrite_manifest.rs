//! A job that many machines share: manifest, shards, kills, status, merge.

use crate::support::{self, WorkFolder, bundled};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

struct Desk {
    dir: WorkFolder,
}

impl Desk {
    fn new(programs: usize) -> Self {
        Self::of(0..programs)
    }

    /// Three programs that are rewritten.
    fn three() -> Self {
        Self::of([1, 3, 5])
    }

    fn of(programs: impl IntoIterator<Item = usize>) -> Self {
        let dir = WorkFolder::new();
        let robot = bundled("configs/gantry-xyz-ballscrew.yaml");
        let model = format!(
            "schema: lostmotion/model/1\nrobot: {}\neffects:\n  - {{effect: backlash, joint: X, half_gap_mm: 0.05}}\n",
            robot.display()
        );
        std::fs::write(dir.join("model.yaml"), model).unwrap();
        let desk = Self { dir };
        programs.into_iter().for_each(|k| desk.program(k));
        desk
    }

    /// Program `k`: CSV or G-code, some with a target that is no number.
    fn program(&self, k: usize) {
        let x = |j: usize| 500.0 + 100.0 * ((j * (k % 7 + 3)) as f64 * 0.21).sin();
        let folder = self.path(&format!("cell/line{}", k % 5));
        std::fs::create_dir_all(&folder).unwrap();
        let (name, text) = match k % 3 {
            0 => ("nc", (0..30).map(|j| format!("G1 G90 G21 X{:.4} Y400. Z-10. F1000\n", x(j))).collect::<String>()),
            _ => ("csv", (0..30).map(|j| format!("{:.4},400.0,-10.0\n", x(j))).collect::<String>()),
        };
        let head = if name == "csv" { "x_mm,y_mm,z_mm\n" } else { "" };
        let tail = if k % 50 == 7 && name == "csv" { "one,400.0,-10.0\n" } else { "" };
        std::fs::write(folder.join(format!("p{k:04}.{name}")), format!("{head}{text}{tail}")).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.join(name)
    }

    fn run(&self, line: &str) -> assert_cmd::assert::Assert {
        let mut command = support::command();
        command.current_dir(self.dir.path()).args(line.split_whitespace()).assert()
    }

    fn shard(&self, k: usize, n: usize, out: &str, summary: &str) -> String {
        format!(
            "rewrite --model model.yaml cell --manifest m.jsonl --shard {k}/{n} --output-dir {out} --summary {summary} \
             --fail-on none"
        )
    }

    /// Every file below a folder with its bytes; locks are no result.
    fn tree(&self, folder: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let (root, mut found) = (self.path(folder), BTreeMap::new());
        let mut open = vec![root.clone()];
        while let Some(here) = open.pop() {
            for entry in std::fs::read_dir(&here).unwrap().map(Result::unwrap) {
                let path = entry.path();
                if path.is_dir() {
                    open.push(path);
                } else if !entry.file_name().to_string_lossy().starts_with(".lostmotion") {
                    found.insert(path.strip_prefix(&root).unwrap().to_path_buf(), std::fs::read(&path).unwrap());
                }
            }
        }
        found
    }
}

#[test]
fn shards_that_are_killed_and_started_again_give_the_tree_of_an_undisturbed_run() {
    let desk = Desk::new(400);
    desk.run("manifest cell --output m.jsonl").success();
    desk.run("rewrite --model model.yaml cell --output-dir whole --summary whole.jsonl --fail-on none").success();
    for (n, wait_ms) in [3, 8, 15, 25, 60].into_iter().enumerate() {
        let line = desk.shard(n % 3 + 1, 3, "done", "killed.jsonl");
        let mut run = support::process()
            .current_dir(desk.dir.path())
            .args(line.split_whitespace())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait_ms));
        run.kill().unwrap();
        run.wait().unwrap();
    }
    for k in 1..=3 {
        desk.run(&desk.shard(k, 3, "done", &format!("part{k}.jsonl"))).success();
    }
    assert_eq!(desk.tree("done"), desk.tree("whole"));
    let merged = desk.run("merge --manifest m.jsonl part3.jsonl part1.jsonl part2.jsonl --output all.jsonl").success();
    // of k % 50 == 7 and k % 3 != 0 below 400: five programs with a cell that is no number
    let told = String::from_utf8_lossy(&merged.get_output().stderr).into_owned();
    let bad = (0..400).filter(|k| k % 50 == 7 && k % 3 != 0).count();
    assert!(told.contains("400 programs: ") && told.contains(&format!(", {bad} failed")), "{told}");
    let keys = |file: &str| -> Vec<String> {
        let text = std::fs::read_to_string(desk.path(file)).unwrap();
        let key = |l: &str| serde_json::from_str::<serde_json::Value>(l).unwrap()["key"].as_str().unwrap().to_string();
        text.lines().map(key).collect()
    };
    assert_eq!(keys("all.jsonl"), keys("m.jsonl"));
}

#[test]
fn gaps_and_doubles_of_summaries_are_refused_and_status_counts_what_is_left() {
    let desk = Desk::new(60);
    desk.run("manifest cell --output m.jsonl").success();
    desk.run(&desk.shard(1, 2, "done", "one.jsonl")).success();
    let gap = desk.run("merge --manifest m.jsonl one.jsonl --output all.jsonl").code(1);
    assert!(String::from_utf8_lossy(&gap.get_output().stderr).contains("in no summary"));
    let double = desk.run("merge --manifest m.jsonl one.jsonl one.jsonl --output all.jsonl").code(2);
    assert!(String::from_utf8_lossy(&double.get_output().stderr).contains("twice"));
    assert!(!desk.path("all.jsonl").exists());
    let status = desk.run("status --manifest m.jsonl one.jsonl --json").success();
    let counts: serde_json::Value = serde_json::from_slice(&status.get_output().stdout).unwrap();
    let lines = std::fs::read_to_string(desk.path("one.jsonl")).unwrap().lines().count() as u64;
    assert!(lines > 0 && lines < 60, "{lines}");
    assert_eq!(counts["left"].as_u64(), Some(60 - lines));
    // the results alone tell it, too, but for those that failed
    let status = desk.run("status --manifest m.jsonl --output-dir done --json").success();
    let by_results: serde_json::Value = serde_json::from_slice(&status.get_output().stdout).unwrap();
    assert_eq!(by_results["done"], counts["done"]);
}

#[test]
fn a_program_that_is_added_changes_no_other_and_one_that_is_changed_fails_until_it_is_listed_anew() {
    let desk = Desk::new(60);
    desk.run("manifest cell --output m.jsonl").success();
    for k in 1..=2 {
        desk.run(&desk.shard(k, 2, "done", &format!("a{k}.jsonl"))).success();
    }
    let before = desk.tree("done");
    desk.program(60);
    std::fs::write(desk.path("cell/line1/p0001.csv"), "x_mm,y_mm,z_mm\n1,2,-3\n2,2,-3\n1,2,-3\n").unwrap();
    desk.run(&desk.shard(1, 1, "done", "b.jsonl")).success();
    let text = std::fs::read_to_string(desk.path("b.jsonl")).unwrap();
    let line = text.lines().find(|l| l.contains("line1/p0001.csv")).unwrap();
    assert!(line.contains("\"failed\"") && line.contains("content that differs from the manifest"), "{line}");
    assert_eq!(desk.tree("done"), before);
    desk.run("manifest cell --output m.jsonl").success();
    desk.run(&desk.shard(1, 1, "done", "c.jsonl")).success();
    let after = desk.tree("done");
    let differ = |p: &PathBuf| before.get(p) != after.get(p);
    let changed: Vec<&PathBuf> = after.keys().filter(|p| differ(p)).collect();
    let ours = |p: &&PathBuf| ["p0001.csv", "p0060.nc"].iter().any(|n| p.to_string_lossy().contains(n));
    assert!(changed.len() == 4 && changed.iter().all(ours), "{changed:?}");
}

/// Counts of `status --json`.
fn counts(desk: &Desk, line: &str) -> [u64; 3] {
    let status = desk.run(&format!("status --manifest m.jsonl --json {line}")).success();
    let counts: serde_json::Value = serde_json::from_slice(&status.get_output().stdout).unwrap();
    ["done", "failed", "left"].map(|k| counts[k].as_u64().unwrap())
}

fn words(assert: &assert_cmd::assert::Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

#[test]
fn summaries_of_a_former_content_and_of_dry_runs_are_not_merged_and_are_left_in_the_status() {
    let desk = Desk::three();
    desk.run("manifest cell --output m.jsonl").success();
    desk.run(&format!("{} --dry-run", desk.shard(1, 1, "done", "dry.jsonl"))).success();
    let merge = |summary: &str| desk.run(&format!("merge --manifest m.jsonl {summary} --output all.jsonl"));
    let refused = words(&merge("dry.jsonl").code(2));
    assert!(refused.starts_with("lostmotion: dry.jsonl:1: ") && refused.contains("would be written"), "{refused}");
    assert_eq!(counts(&desk, "dry.jsonl"), [0, 0, 3]);
    desk.run(&desk.shard(1, 1, "done", "s.jsonl")).success();
    assert_eq!(counts(&desk, "s.jsonl"), [3, 0, 0]);
    // the second of three programs changes, and is listed anew
    std::fs::write(desk.path("cell/line1/p0001.csv"), "x_mm,y_mm,z_mm\n1,2,-3\n2,2,-3\n1,2,-3\n").unwrap();
    desk.run("manifest cell --output m.jsonl").success();
    let refused = words(&merge("s.jsonl").code(2));
    assert!(refused.contains("s.jsonl:2: ") && refused.contains("another `sha256_in`"), "{refused}");
    assert!(!desk.path("all.jsonl").exists());
    assert_eq!(counts(&desk, "s.jsonl"), [2, 0, 1]);
    // one that fails because it changed after it was listed is of this job
    std::fs::write(desk.path("cell/line1/p0001.csv"), "x_mm,y_mm,z_mm\n1,2,-3\n3,2,-3\n1,2,-3\n").unwrap();
    desk.run(&desk.shard(1, 1, "done", "t.jsonl")).success();
    assert!(words(&merge("t.jsonl").success()).contains("2 done, 0 refused, 1 failed"));
    assert_eq!(counts(&desk, "t.jsonl"), [2, 1, 0]);
}

#[test]
fn shards_of_different_compensators_are_not_merged_and_named_by_the_status() {
    let desk = Desk::three();
    desk.run("manifest cell --output m.jsonl").success();
    let model = std::fs::read_to_string(desk.path("model.yaml")).unwrap();
    std::fs::write(desk.path("other.yaml"), model.replace("half_gap_mm: 0.05", "half_gap_mm: 0.06")).unwrap();
    let shard = |k: usize, out: &str, with: &str| {
        desk.run(&format!(
            "rewrite --model {with} cell --manifest m.jsonl --shard {k}/2 --output-dir {out} --summary {out}-{k}.jsonl"
        ))
        .success();
    };
    // three programs: each shard has one at least
    for (out, second, part) in [
        ("one", "model.yaml", None),
        ("two", "other.yaml", Some("compensator")),
        ("three", "model.yaml --gain 0.9", Some("options")),
    ] {
        shard(1, out, "model.yaml");
        shard(2, out, second);
        let merge = desk.run(&format!("merge --manifest m.jsonl {out}-1.jsonl {out}-2.jsonl --output {out}.jsonl"));
        let status = format!("status --manifest m.jsonl {out}-1.jsonl");
        let with_both = desk.run(&format!("{status} {out}-2.jsonl --output-dir {out}"));
        // the second shard is still running: its notes tell
        let with_one = desk.run(&format!("{status} --output-dir {out}"));
        match part {
            None => {
                merge.success();
                with_both.success();
                with_one.success();
            }
            Some(part) => {
                let merge = merge.code(2);
                assert!(words(&merge).contains(part), "{}", words(&merge));
                assert!(!desk.path(&format!("{out}.jsonl")).exists());
                let (both, one) = (with_both.code(1), with_one.code(1));
                assert!(words(&both).contains(part) && words(&one).contains(part), "{}{}", words(&both), words(&one));
            }
        }
    }
}

#[test]
fn a_result_that_is_cut_short_or_gone_is_left_in_the_status() {
    let desk = Desk::three();
    desk.run("manifest cell --output m.jsonl").success();
    desk.run(&desk.shard(1, 1, "done", "s.jsonl")).success();
    for summary in ["", "s.jsonl "] {
        assert_eq!(counts(&desk, &format!("{summary}--output-dir done")), [3, 0, 0]);
    }
    std::fs::write(desk.path("done/line1/p0001.csv"), "").unwrap();
    std::fs::remove_file(desk.path("done/line3/p0003.nc")).unwrap();
    for summary in ["", "s.jsonl "] {
        assert_eq!(counts(&desk, &format!("{summary}--output-dir done")), [1, 0, 2], "{summary}");
    }
}

#[test]
fn one_program_under_two_spellings_is_refused_and_its_key_has_one_spelling() {
    let desk = Desk::three();
    for other in ["line1/p0001.csv", "line1//p0001.csv", "line1/./p0001.csv", "./line1/p0001.csv"] {
        std::fs::write(desk.path("list.txt"), format!("line1/p0001.csv\n{other}\n")).unwrap();
        let refused = words(&desk.run("manifest list.txt --root cell --output m.jsonl").code(2));
        assert!(refused.contains("list.txt: found `line1/p0001.csv` twice"), "{other}: {refused}");
        std::fs::write(desk.path("list.txt"), format!("{other}\n")).unwrap();
        desk.run("manifest list.txt --root cell --output m.jsonl").success();
        let text = std::fs::read_to_string(desk.path("m.jsonl")).unwrap();
        assert!(text.starts_with("{\"key\":\"line1/p0001.csv\","), "{other}: {text}");
        // a manifest that was edited
        let edited = text.replace("line1/p0001.csv", other);
        std::fs::write(desk.path("e.jsonl"), &edited).unwrap();
        let code = if edited == text { 0 } else { 2 };
        desk.run("rewrite --model model.yaml cell --manifest e.jsonl --output-dir done").code(code);
    }
}

#[test]
fn results_inside_the_folder_of_the_programs_are_not_listed() {
    let desk = Desk::three();
    desk.run("rewrite --model model.yaml cell --output-dir cell/done").success();
    let said = words(&desk.run("manifest cell --output m.jsonl").success());
    assert!(said.contains("3 programs in cell/done are results of an earlier rewrite and are left out"), "{said}");
    let keys = std::fs::read_to_string(desk.path("m.jsonl")).unwrap();
    assert!(keys.lines().count() == 3 && !keys.contains("done/"), "{keys}");
    desk.run("rewrite --model model.yaml cell --manifest m.jsonl --output-dir cell/done").success();
    assert!(!desk.path("cell/done/done").exists());
}

#[test]
fn a_hash_that_was_taken_out_of_a_manifest_and_a_wrong_size_are_no_longer_passed() {
    let desk = Desk::three();
    desk.run("manifest cell --output m.jsonl").success();
    let whole = std::fs::read_to_string(desk.path("m.jsonl")).unwrap();
    let mut lines: Vec<serde_json::Value> = whole.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let write = |lines: &[serde_json::Value]| {
        let text: String = lines.iter().map(|l| format!("{l}\n")).collect();
        std::fs::write(desk.path("m.jsonl"), text).unwrap();
    };
    let sha256 = lines[1]["sha256"].take();
    write(&lines);
    let refused = words(&desk.run(&desk.shard(1, 1, "done", "s.jsonl")).code(2));
    assert!(refused.contains("m.jsonl:2: ") && refused.contains("without its `sha256`"), "{refused}");
    lines[1]["sha256"] = sha256;
    lines[1]["size"] = 7.into();
    write(&lines);
    desk.run(&desk.shard(1, 1, "done", "s.jsonl")).success();
    let summary = std::fs::read_to_string(desk.path("s.jsonl")).unwrap();
    let failed: Vec<&str> = summary.lines().filter(|l| l.contains("\"failed\"")).collect();
    assert!(failed.len() == 1 && failed[0].contains("content that differs from the manifest"), "{summary}");
    assert!(!desk.path("done/line1/p0001.csv").exists());
    // one that could not be read when it was listed has no known content, either
    let unreadable = serde_json::json!({"key": "line1/p0001.csv", "size": 0, "sha256": null, "format": null,
        "state": "unreadable", "reason": "it was away"});
    write(&[unreadable]);
    desk.run(&desk.shard(1, 1, "done", "s.jsonl")).success();
    assert!(std::fs::read_to_string(desk.path("s.jsonl")).unwrap().contains("\"failed\""));
}

/// A list has paths as `ls` prints them: also with bytes that are no text, and with backslashes.
#[test]
#[cfg(target_os = "linux")]
fn a_list_holds_paths_by_their_bytes_or_escaped() {
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::three();
    let program = std::fs::read(desk.path("cell/line1/p0001.csv")).unwrap();
    let names: [&[u8]; 2] = [b"L\xe4ngs.csv", b"back\\slash.csv"];
    for name in names {
        std::fs::write(desk.path("cell").join(std::ffi::OsStr::from_bytes(name)), &program).unwrap();
    }
    let keys = |list: &[u8]| -> Vec<serde_json::Value> {
        std::fs::write(desk.path("list.txt"), list).unwrap();
        desk.run("manifest list.txt --root cell --output m.jsonl").success();
        let text = std::fs::read_to_string(desk.path("m.jsonl")).unwrap();
        let lines = text.lines().map(|l| serde_json::from_str::<serde_json::Value>(l).unwrap());
        lines.filter(|l| l["key"].is_string()).map(|l| [l["key"].clone(), l["state"].clone()].into()).collect()
    };
    let raw = keys(&names.join(&b"\r\n"[..]));
    let ready = |key: &str| serde_json::json!([key, "ready"]);
    assert_eq!(raw, [ready("L\\xE4ngs.csv"), ready("back\\\\slash.csv")]);
    assert_eq!(keys(b"L\\xE4ngs.csv\nback\\\\slash.csv\n"), raw);
}

#[test]
fn a_manifest_that_leads_out_of_its_folder_is_refused() {
    let desk = Desk::three();
    let entry = "{\"key\":\"../model.yaml\",\"size\":1,\"sha256\":null,\"format\":null,\"state\":\"ready\"}\n";
    std::fs::write(desk.path("m.jsonl"), entry).unwrap();
    let refused = desk.run(&desk.shard(1, 1, "done", "s.jsonl")).code(2);
    assert!(String::from_utf8_lossy(&refused.get_output().stderr).contains("without `..`"));
}

#[test]
#[cfg(not(feature = "cloud"))]
fn an_address_of_an_object_store_is_refused_by_a_build_that_reads_none() {
    let desk = Desk::three();
    desk.run("manifest cell --output m.jsonl").success();
    for line in [
        "manifest s3://cells/line-4 --output n.jsonl",
        "rewrite --model model.yaml s3://cells/line-4 --manifest m.jsonl --output-dir done",
        "rewrite --model model.yaml cell --manifest m.jsonl --output-dir s3://cells/done",
    ] {
        let refused = desk.run(line).code(2);
        let words = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(words.contains("made without the feature `cloud`"), "{words}");
    }
    assert!(!desk.path("done").exists() && !desk.path("s3:").exists());
}
