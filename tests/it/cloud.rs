//! Programs and results in an object store: a store on disk (`file://`) needs no server. `benches/s3.py` does the same with one.

use crate::support::{self, Outcome, WorkFolder, bundled};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

struct Desk {
    dir: WorkFolder,
}

const XHOME: &str = "DEFDAT $CONFIG\nE6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";

/// Joint targets that turn back and forth.
fn targets(seed: usize) -> impl Iterator<Item = [f64; 6]> {
    (0..8).map(move |j| {
        let x = (j * (seed % 5 + 2)) as f64;
        [10.0 * (0.7 * x).sin(), -90.0 + 5.0 * (0.5 * x).cos(), 90.0 + 3.0 * (0.9 * x).sin(), x, 10.0, -x]
    })
}

impl Desk {
    /// A cell with a KRL project, program and system modules of RAPID, FANUC, INFORM, CSV, what is no program, and odd names.
    fn new() -> Self {
        let desk = Self { dir: WorkFolder::new() };
        let robot = bundled("configs/kuka-kr120-r2500-pro.yaml");
        let mut model = format!("schema: lostmotion/model/1\nrobot: {}\neffects:\n", robot.display());
        for k in 1..=6 {
            let _ = writeln!(model, "  - {{effect: backlash, joint: A{k}, half_gap_deg: 0.005}}");
        }
        desk.write("model.yaml", &model);
        desk.write("cell/R1/System/$config.dat", XHOME);
        for k in 0..6 {
            desk.krl(&format!("cell/R1/Program/p{k}"), k);
            desk.write(&format!("cell/R1/Program/p{k}.dat"), &format!("DEFDAT p{k}\nDECL INT n={k}\nENDDAT\n"));
            let rows = targets(k).fold("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n".to_string(), |all, r| {
                all + &r.map(|v| format!("{v:.4}")).join(",") + "\n"
            });
            desk.write(&format!("cell/rows/row {k}%20#.csv"), &rows);
        }
        for (k, name) in ["PROGMOD/main.mod", "PROGMOD/other.mod", "SYSMOD/user.sys"].iter().enumerate() {
            let external = "[9E9,9E9,9E9,9E9,9E9,9E9]";
            let moves = targets(k).fold(String::new(), |all, r| {
                all + &format!(
                    "  MoveAbsJ [[{}],{external}],v500,fine,tool0;\n",
                    r.map(|v| format!("{v:.4}")).join(",")
                )
            });
            desk.write(
                &format!("cell/abb/{name}"),
                &format!("MODULE m{k}\n PROC r{k}()\n{moves} ENDPROC\nENDMODULE\n"),
            );
        }
        desk.write("cell/abb/picture.png", "no program");
        desk.write("cell/list.json", "{\"joint_names\": 1}\n");
        desk.write("cell/broken.csv", "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n1,2,3,4,5,six\n");
        desk
    }

    fn krl(&self, path: &str, seed: usize) {
        let moves = targets(seed).fold("PTP XHOME\n".to_string(), |all, [a, b, c, d, e, f]| {
            all + &format!("PTP {{A1 {a:.4},A2 {b:.4},A3 {c:.4},A4 {d:.4},A5 {e:.4},A6 {f:.4}}}\n")
        });
        self.write(&format!("{path}.src"), &format!("DEF p{seed}( )\n{moves}END\n"));
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.dir.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    fn address(&self, name: &str) -> String {
        format!("file://{}", self.dir.join(name).display())
    }

    fn run(&self, line: &str) -> Outcome {
        self.dir.run(line)
    }

    /// Shards 1 and 2 of the programs at `input`, with results at `output`; their lines.
    fn shards(&self, input: &str, output: &str) -> Vec<Value> {
        let mut all = Vec::new();
        for k in 1..=2 {
            self.shard(k, input, output).success();
            let text = std::fs::read_to_string(self.dir.join("part.jsonl")).unwrap();
            all.extend(text.lines().map(|l| serde_json::from_str::<Value>(l).unwrap()));
        }
        all
    }

    fn shard(&self, k: usize, input: &str, output: &str) -> Outcome {
        self.run(&format!(
            "rewrite --model model.yaml {input} --manifest m.jsonl --shard {k}/2 --output-dir {output} --summary part.jsonl \
             --fail-on none"
        ))
    }

    /// Every file below a folder with its bytes; locks are no result.
    fn tree(&self, folder: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let (root, mut found) = (self.dir.join(folder), BTreeMap::new());
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

/// Lines without the names of files, which differ.
fn bare(lines: &[Value]) -> Vec<Value> {
    let bare = |l: &Value| {
        let mut l = l.clone();
        for name in ["input", "output", "reason"] {
            l.as_object_mut().unwrap().remove(name);
        }
        l
    };
    lines.iter().map(bare).collect()
}

#[test]
fn a_store_gives_the_manifest_and_the_results_of_the_same_folder() {
    let desk = Desk::new();
    let cell = desk.address("cell");
    desk.run("manifest cell --output folder.jsonl").success();
    desk.run(&format!("manifest {cell} --output m.jsonl")).success();
    assert_eq!(std::fs::read(desk.dir.join("m.jsonl")).unwrap(), std::fs::read(desk.dir.join("folder.jsonl")).unwrap());
    let folder = desk.shards("cell", "of-folder");
    let wanted = desk.tree("of-folder");
    assert!(wanted.len() > 30, "{}", wanted.len());
    // from the store to disk, from the store to a store, from disk to a store
    std::fs::create_dir(desk.dir.join("to-store")).unwrap();
    std::fs::create_dir(desk.dir.join("from-disk")).unwrap();
    for (input, output, at) in [
        (&cell, "to-disk".to_string(), "to-disk"),
        (&cell, desk.address("to-store"), "to-store"),
        (&"cell".to_string(), desk.address("from-disk"), "from-disk"),
    ] {
        let lines = desk.shards(input, &output);
        assert_eq!(bare(&lines), bare(&folder), "{at}");
        assert_eq!(desk.tree(at), wanted, "{at}");
        let line = lines.iter().find(|l| l["key"] == "R1/Program/p0.src").unwrap();
        assert_eq!(line["input"], format!("{input}/R1/Program/p0.src"));
        assert_eq!(line["output"], format!("{output}/R1/Program/p0.src"));
        let broken = lines.iter().find(|l| l["key"] == "broken.csv").unwrap();
        assert!(broken["reason"].as_str().unwrap().starts_with(&format!("{input}/broken.csv:2")), "{broken}");
    }
    // what stands beside programs counts: without `$config.dat` the first move of each KRL program is not known
    let known = |lines: &[Value]| lines.iter().find(|l| l["key"] == "R1/Program/p0.src").unwrap()["editable"].clone();
    std::fs::remove_file(desk.dir.join("cell/R1/System/$config.dat")).unwrap();
    std::fs::create_dir(desk.dir.join("without")).unwrap();
    assert_ne!(known(&desk.shards(&cell, &desk.address("without"))), known(&folder));
}

#[test]
fn results_in_a_store_are_skipped_by_their_hashes_and_what_is_missing_or_damaged_is_put_again() {
    let desk = Desk::new();
    let (cell, done) = (desk.address("cell"), desk.address("done"));
    std::fs::create_dir(desk.dir.join("done")).unwrap();
    desk.run(&format!("manifest {cell} --output m.jsonl")).success();
    let first = desk.shards(&cell, &done);
    let whole = desk.tree("done");
    let age = |name: &str| std::fs::metadata(desk.dir.join("done").join(name)).unwrap().modified().unwrap();
    let before = age("R1/Program/p1.src");
    std::fs::remove_file(desk.dir.join("done/R1/Program/p2.src")).unwrap();
    std::fs::write(desk.dir.join("done/R1/Program/p3.src"), "").unwrap();
    std::fs::remove_file(desk.dir.join("done/rows/row 2%20#.csv.lostmotion.json")).unwrap();
    assert_eq!(desk.shards(&cell, &done), first);
    assert_eq!(desk.tree("done"), whole);
    assert_eq!(age("R1/Program/p1.src"), before, "a finished program was put once more");
}

#[test]
fn an_object_that_changed_since_it_was_listed_fails_and_so_does_one_that_is_gone() {
    let desk = Desk::new();
    let cell = desk.address("cell");
    desk.run(&format!("manifest {cell} --output m.jsonl")).success();
    desk.krl("cell/R1/Program/p1", 4);
    std::fs::remove_file(desk.dir.join("cell/R1/Program/p2.src")).unwrap();
    let lines = desk.shards(&cell, "done");
    for (key, why) in [("p1", "content that differs from the manifest"), ("p2", "there is no such object")] {
        let line = lines.iter().find(|l| l["key"] == format!("R1/Program/{key}.src")).unwrap();
        assert_eq!(line["status"], "failed");
        let reason = line["reason"].as_str().unwrap();
        assert!(reason.contains(why) && reason.starts_with(&cell), "{reason}");
        assert!(!desk.dir.join(format!("done/R1/Program/{key}.src")).exists());
    }
}

#[test]
fn a_store_that_cannot_be_used_is_refused_with_exit_code_2_and_no_summary() {
    let desk = Desk::new();
    let cell = desk.address("cell");
    desk.run(&format!("manifest {cell} --output m.jsonl")).success();
    let rewrite = |rest: &str| desk.run(&format!("rewrite --model model.yaml {rest} --summary part.jsonl"));
    let cases = [
        (format!("{cell} --output-dir done"), "--manifest"),
        (format!("{cell} --manifest m.jsonl --output-dir {cell}/done"), "another prefix"),
        (format!("{cell} --manifest m.jsonl --output-dir {}", desk.address("model.yaml/done")), "Not a directory"),
        ("s3:///cell --manifest m.jsonl --output-dir done".into(), "without a bucket"),
        ("file://cell --manifest m.jsonl --output-dir done".into(), "without a folder"),
        (format!("{cell}//R1 --manifest m.jsonl --output-dir done"), "one `/`"),
    ];
    for (line, words) in &cases {
        let outcome = rewrite(line).ends_with(2);
        assert!(outcome.stderr.contains(words), "{line}: {}", outcome.stderr);
        assert!(!desk.dir.join("part.jsonl").exists(), "{line}");
    }
    let nothing = desk.run(&format!("manifest {} --output n.jsonl", desk.address("nothing"))).ends_with(2);
    assert!(nothing.stderr.contains("no program") && !desk.dir.join("n.jsonl").exists(), "{}", nothing.stderr);
    let status = desk.run(&format!("status --manifest m.jsonl --output-dir {cell}")).ends_with(2);
    assert!(status.stderr.contains("a path on disk"), "{}", status.stderr);
    // an endpoint on this machine at which nobody listens
    let mut command = support::command();
    command.current_dir(desk.dir.path()).args(["manifest", "s3://cell/a", "--output", "n.jsonl"]);
    command
        .env("AWS_ENDPOINT_URL", "ftp://127.0.0.1:9")
        .env("AWS_ACCESS_KEY_ID", "a")
        .env("AWS_SECRET_ACCESS_KEY", "b");
    let refused = support::outcome(&mut command).ends_with(2);
    assert!(refused.stderr.contains("s3://cell/a: cannot list"), "{}", refused.stderr);
}
