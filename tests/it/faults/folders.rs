//! Folders of programs: other runs in the same folder, odd names, what a killed run left, parts of a job.

use super::Bench;
use crate::support;
use std::fs::File;
use std::io::Write;
use std::path::Path;

#[test]
fn a_second_run_into_one_folder_is_refused_by_the_name_of_the_first() {
    let bench = Bench::new();
    bench.write("in/a.csv", &String::from_utf8(bench.read("p.csv")).unwrap());
    std::fs::create_dir(bench.path("out")).unwrap();
    let first = File::create(bench.path("out/.lostmotion.lock")).unwrap();
    (&first).write_all(b"process 4711\n").unwrap();
    first.lock().unwrap();
    let run = bench.run("rewrite --model comp.yaml in --output-dir out").assert().code(2);
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(said.contains("another run of lostmotion") && said.contains("process 4711"), "{said}");
    assert!(!bench.path("out/a.csv").exists());
    // stale as soon as its process has ended
    drop(first);
    let run = bench.run("rewrite --model comp.yaml in --output-dir out").assert().success();
    assert!(String::from_utf8_lossy(&run.get_output().stderr).contains("process 4711"), "taken over");
    assert_eq!(bench.leftovers("out"), Vec::<String>::new());
}

#[test]
fn two_runs_into_one_folder_at_once_leave_every_program_whole() {
    let bench = Bench::new();
    let program = String::from_utf8(bench.read("p.csv")).unwrap();
    for k in 0..40 {
        bench.write(format!("in/{k}.csv"), &program);
    }
    bench.run("rewrite --model comp.yaml p.csv --output whole.csv").assert().success();
    let args = ["rewrite", "--model", "comp.yaml", "in", "--output-dir", "out"];
    let start = || {
        let mut command = support::process();
        command.args(args).current_dir(bench.0.path()).stderr(std::process::Stdio::null()).spawn().unwrap()
    };
    let mut runs = [start(), start(), start()];
    let codes: Vec<_> = runs.iter_mut().map(|r| r.wait().unwrap().code().unwrap()).collect();
    assert!(codes.contains(&0) && codes.iter().all(|c| [0, 2].contains(c)), "{codes:?}");
    for k in 0..40 {
        assert_eq!(bench.read(format!("out/{k}.csv")), bench.read("whole.csv"));
    }
}

#[cfg(unix)]
#[test]
fn names_that_differ_only_in_bytes_that_are_not_utf8_keep_their_programs_apart() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::new();
    let names: Vec<&[u8]> = vec![b"L\xe4ngs.csv", b"L\xf6ngs.csv", b"L\xfcngs.csv", b"L\\xE4ngs.csv"];
    let head = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n";
    for (k, name) in names.iter().enumerate() {
        let program = format!("{head}{k}.0,-90.0,90.0,0.0,10.0,0.0\n5{k}.0,-90.0,90.0,0.0,10.0,0.0\n");
        bench.write(Path::new("in").join(OsStr::from_bytes(name)), &program);
    }
    bench.run("rewrite --model comp.yaml in --output-dir out --summary s.jsonl").assert().success();
    let summary = String::from_utf8(bench.read("s.jsonl")).unwrap();
    for (k, name) in names.iter().enumerate() {
        let out = bench.read(Path::new("out").join(OsStr::from_bytes(name)));
        assert!(out.starts_with(format!("{head}{k}.0028").as_bytes()), "{}", String::from_utf8_lossy(&out));
        // the summary gives the very name back
        let named = summary.lines().any(|line| {
            let line: serde_json::Value = serde_json::from_str(line).unwrap();
            let path = lostmotion::io::name::path_of(line["input"].as_str().unwrap()).unwrap();
            path.as_os_str().as_bytes() == [b"in/", *name].concat()
        });
        assert!(named, "{summary}");
    }
    // each is known as done, and comes back
    bench.run("rewrite --model comp.yaml in --output-dir out").assert().success();
    let mut undo = bench.run("undo");
    undo.arg(Path::new("out").join(OsStr::from_bytes(names[0]))).args(["--output", "back.csv"]).assert().success();
    assert_eq!(bench.read("back.csv"), bench.read(Path::new("in").join(OsStr::from_bytes(names[0]))));
}

#[test]
fn names_that_a_terminal_would_obey_are_spelt_out() {
    let bench = Bench::new();
    bench.write("in/a\u{1b}[31m\n\u{202e}b.csv", "no program\n");
    let run = bench.run("rewrite --model comp.yaml in --output-dir out --summary s.jsonl").assert().code(1);
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(said.contains("a\\x1B[31m\\n\\u{202E}b.csv"), "{said}");
    assert!(!said.contains('\u{1b}') && !said.contains('\u{202e}'), "{said}");
    assert_eq!(bench.read("s.jsonl").iter().filter(|b| **b == b'\n').count(), 1);
}

#[cfg(unix)]
#[test]
#[cfg_attr(superuser, ignore = "the superuser writes to every file")]
fn a_lock_file_that_a_killed_run_of_another_user_left_is_taken_away() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    bench.write("in/a.csv", &String::from_utf8(bench.read("p.csv")).unwrap());
    bench.write("out/.lostmotion.lock", "process 4711\n");
    let read_only = std::fs::Permissions::from_mode(0o444);
    std::fs::set_permissions(bench.path("out/.lostmotion.lock"), read_only).unwrap();
    bench.run("rewrite --model comp.yaml in --output-dir out").assert().success();
    assert_eq!(bench.leftovers("out"), Vec::<String>::new());
}

#[test]
fn what_a_killed_run_left_is_taken_away_by_the_next() {
    let bench = Bench::new();
    bench.write(".lostmotion-0123456789.part", "half");
    bench.run("rewrite --model comp.yaml p.csv --output o.csv").assert().success();
    assert_eq!(bench.leftovers("."), Vec::<String>::new());
}

#[cfg(unix)]
#[test]
#[cfg_attr(superuser, ignore = "the superuser reads every folder")]
fn unreadable_folder_stops_no_other_program() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    bench.write("in/a.csv", &String::from_utf8(bench.read("p.csv")).unwrap());
    bench.write("in/closed/b.csv", "");
    let closed =
        |mode| std::fs::set_permissions(bench.path("in/closed"), std::fs::Permissions::from_mode(mode)).unwrap();
    closed(0o000);
    bench.run("rewrite --model comp.yaml in --output-dir out --summary s.jsonl").assert().code(1);
    closed(0o755);
    assert!(bench.path("out/a.csv").exists());
    let summary = String::from_utf8(bench.read("s.jsonl")).unwrap();
    assert!(summary.lines().any(|l| l.contains("in/closed") && l.contains("\"failed\"")), "{summary}");
}

#[test]
fn a_refused_program_fails_a_job_only_where_that_is_asked() {
    let bench = Bench::new();
    bench.write("in/good.csv", &String::from_utf8(bench.read("p.csv")).unwrap());
    bench.run("rewrite --model comp.yaml p.csv --output in/done.csv").assert().success();
    let run =
        |more: &str, out: &str| bench.run(&format!("rewrite --model comp.yaml in --output-dir {out}{more}")).assert();
    run("", "a").code(1);
    run(" --fail-on failed", "b").code(0);
    bench.write("in/bad.csv", "a1_deg\nnothing\n");
    run(" --fail-on failed", "c").code(1);
    run(" --fail-on none", "d").code(0);
}

#[test]
fn a_program_that_is_added_moves_no_other_to_another_part() {
    let bench = Bench::new();
    let program = String::from_utf8(bench.read("p.csv")).unwrap();
    (0..8).for_each(|k| bench.write(format!("in/{k}.csv"), &program));
    let part = |k: usize, out: &str| -> Vec<String> {
        let out = format!("{out}{k}");
        bench.run(&format!("rewrite --model comp.yaml in --output-dir {out} --shard {k}/2")).assert().success();
        let names = std::fs::read_dir(bench.path(out)).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|n| n.ends_with(".csv")).collect();
        names.sort();
        names
    };
    let before = [part(1, "a"), part(2, "a")];
    assert_eq!(before[0].len() + before[1].len(), 8);
    bench.write("in/3b.csv", &program);
    let after = [part(1, "b"), part(2, "b")];
    for (a, b) in before.iter().zip(&after) {
        assert!(a.iter().all(|n| b.contains(n)), "{before:?} {after:?}");
    }
}
