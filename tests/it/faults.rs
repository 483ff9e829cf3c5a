//! Nothing is lost whatever happens: kills, failing system calls, notes that are damaged, times that leave no room.
//!
//! Parts:
//! - [`folders`]: other runs in the same folder, odd names, what a killed run left, parts of a job.

mod folders;

use crate::support::{self, WorkFolder, root};
use assert_cmd::Command;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder with the circle program, a pair of KRL files, and a compensator of the KUKA.
struct Bench(WorkFolder);

const GAP: &str = "0.0028";

impl Bench {
    fn new() -> Self {
        let bench = Self(WorkFolder::new());
        let root = root();
        let copy = |from: &str, to: &str| std::fs::copy(root.join(from), bench.path(to)).map(|_| ()).unwrap();
        copy("configs/kuka-kr120-r2500-pro.yaml", "robot.yaml");
        copy("samples/circle/circle_program.csv", "p.csv");
        copy("samples/programs/krl/points.src", "points.src");
        copy("samples/programs/krl/points.DAT", "points.DAT");
        bench.compensator("comp.yaml", GAP);
        bench.compensator("other.yaml", "0.0128");
        bench
    }

    /// A model of the robot with a gap on its first joint: it needs no fingerprint.
    fn compensator(&self, name: &str, half_gap: &str) {
        let effect = format!("{{effect: backlash, joint: A1, half_gap_deg: {half_gap}}}");
        self.write(name, &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n"));
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: impl AsRef<Path>, text: &str) {
        std::fs::create_dir_all(self.path(&name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: impl AsRef<Path>) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn run(&self, args: &str) -> Command {
        let mut command = support::command();
        command.current_dir(self.0.path()).args(args.split(' ')).env("RUST_BACKTRACE", "0");
        command
    }

    /// Under strace with one system call answered as `inject` says.
    fn injected(&self, inject: &str, args: &str) -> std::process::Output {
        let mut strace = std::process::Command::new("strace");
        strace.args(["-f", "-qq", "-o", "/dev/null", "-e", &format!("inject={inject}")]);
        strace.arg(support::binary()).args(args.split(' ')).current_dir(self.0.path());
        strace.output().expect("strace is needed")
    }

    /// Names of files that are no results.
    fn leftovers(&self, folder: &str) -> Vec<String> {
        let names = std::fs::read_dir(self.path(folder)).unwrap().map(|e| e.unwrap().file_name());
        names.filter_map(|n| n.into_string().ok()).filter(|n| n.starts_with(".lostmotion")).collect()
    }
}

const REWRITE: &str = "rewrite --model comp.yaml";

#[cfg(target_os = "linux")]
#[test]
fn standard_error_that_cannot_be_written_changes_no_exit_code() {
    let bench = Bench::new();
    let mut command = support::process();
    let full = File::options().write(true).open("/dev/full").unwrap();
    command.current_dir(bench.0.path()).args("rewrite --model comp.yaml p.csv --output o.csv".split(' '));
    assert_eq!(command.stderr(full).status().unwrap().code(), Some(0));
    assert!(bench.path("o.csv").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn where_no_thread_is_left_a_program_is_rewritten_on_the_one_there_is() {
    let bench = Bench::new();
    bench.run(&format!("{REWRITE} p.csv --output many.csv")).assert().success();
    let done = bench.injected("clone,clone3:error=EAGAIN", &format!("{REWRITE} p.csv --output one.csv"));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(bench.read("many.csv") == bench.read("one.csv"));
}

/// A program of the KUKA that goes to and fro, with a time for each point.
fn timed(t_s: impl Fn(u32) -> f64) -> String {
    let row = |k: u32| {
        format!(
            "{:?},{}.0000,-90.0000,90.0000,0.0000,10.0000,0.0000\n",
            t_s(k),
            [0, 1, 2, 3, 2, 1, 0, 1, 2][k as usize]
        )
    };
    let rows: String = (0..9).map(row).collect();
    format!("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n{rows}")
}

#[test]
fn times_too_near_or_too_large_for_a_new_point_are_refused_in_words() {
    let bench = Bench::new();
    let refused = |t_s: &dyn Fn(u32) -> f64, code: i32, words: &str| {
        bench.write("t.csv", &timed(t_s));
        let done = bench.run("rewrite --model comp.yaml t.csv --output out.csv").assert().code(code);
        let said = String::from_utf8(done.get_output().stderr.clone()).unwrap();
        assert!(said.contains(words) && !said.contains("panicked"), "{said}");
        assert!(!bench.path("out.csv").exists());
    };
    refused(&|k| f64::from(k) * 1e-100, 1, "limit 136.000000 deg/s");
    refused(&|k| 1e15 + 0.5 * f64::from(k), 1, "t.csv: point ");
    refused(&|k| 1e15 + 0.01 * f64::from(k), 2, "strictly increase");
}

#[test]
fn a_damaged_note_is_an_error() {
    let bench = Bench::new();
    bench.run("rewrite --model comp.yaml p.csv --output o.csv").assert().success();
    let note = String::from_utf8(bench.read("o.csv.lostmotion.json")).unwrap();
    let hash = note.find("sha256_out").unwrap() + 14;
    let flipped = if &note[hash..=hash] == "0" { "1" } else { "0" };
    let damages = [note[..note.len() / 2].to_string(), format!("{}{flipped}{}", &note[..hash], &note[hash + 1..])];
    for damaged in damages {
        bench.write("o.csv.lostmotion.json", &damaged);
        for command in ["rewrite --model comp.yaml o.csv --output twice.csv", "undo o.csv --output back.csv"] {
            let run = bench.run(command).assert().code(2);
            let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
            assert!(said.contains("damaged"), "{command}: {said}");
        }
        assert!(!bench.path("twice.csv").exists() && !bench.path("back.csv").exists());
    }
}

/// NFS without its service for locks.
#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(strace), ignore = "strace is absent: it makes system calls fail")]
fn fault_injection_a_file_system_without_a_service_for_locks_keeps_no_run_from_its_work() {
    let bench = Bench::new();
    bench.write("in/a.csv", &String::from_utf8(bench.read("p.csv")).unwrap());
    for (line, folder) in
        [("p.csv --output o.csv", "."), ("in --output-dir out", "out"), ("in --output-dir part --shard 1/1", "part")]
    {
        let run = bench.injected("flock:error=ENOLCK", &format!("{REWRITE} {line}"));
        assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
        assert_eq!(bench.leftovers(folder), Vec::<String>::new(), "{line}");
    }
}

/// The states of a set of files: all as before, or all as after.
#[allow(clippy::type_complexity)] // name, bytes before, bytes after
fn assert_whole(bench: &Bench, files: &[(&str, Option<Vec<u8>>, Vec<u8>)], context: &str) -> bool {
    let now = |name: &str| std::fs::read(bench.path(name)).ok();
    let new = files.iter().all(|(name, _, after)| now(name).as_ref() == Some(after));
    let old = files.iter().all(|(name, before, _)| now(name) == *before);
    assert!(new || old, "{context}: neither as before nor as after");
    new
}

/// A pair is rewritten over an earlier result while each rename fails, or ends the process: the files are all old or all new once
/// the next command has run, an error means that nothing was written, and `undo` brings the original back.
#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(strace), ignore = "strace is absent: it makes system calls fail")]
fn fault_injection_a_pair_is_never_torn_by_a_rename_that_fails_or_a_kill_between_two() {
    let bench = Bench::new();
    // a point of this program alone: a global one may be set by programs that are not here
    let own = String::from_utf8(bench.read("points.DAT")).unwrap().replace("DECL GLOBAL ", "DECL ");
    bench.write("points.DAT", &own);
    // the program as it was goes where no rewrite looks for declarations
    for folder in ["o", "back"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    let names = ["o/points.src", "o/points.DAT", "o/points.src.lostmotion.json"];
    let rewrite = |model: &str| format!("rewrite --model {model} points.src --output o/points.src");
    let state = || names.map(|n| std::fs::read(bench.path(n)).ok());
    let reset = || bench.run(&rewrite("comp.yaml")).assert().success();
    reset();
    let before = state();
    bench.run(&rewrite("other.yaml")).assert().success();
    let after = state();
    assert_ne!(before, after);
    let files: Vec<_> = (0..3).map(|k| (names[k], before[k].clone(), after[k].clone().unwrap())).collect();
    for call in ["renameat", "linkat", "unlink", "fsync", "openat"] {
        for when in 1..=if call == "openat" { 45 } else { 12 } {
            let context = format!("{call} {when}");
            reset();
            let failed = bench.injected(&format!("{call}:error=EIO:when={when}"), &rewrite("other.yaml"));
            if failed.status.code() == Some(127) {
                continue; // the loader of the system failed
            }
            let new = assert_whole(&bench, &files, &context);
            assert_eq!(failed.status.code(), Some(if new { 0 } else { 2 }), "{context}");
            reset();
            bench.injected(&format!("{call}:signal=SIGKILL:when={when}"), &rewrite("other.yaml"));
            bench.run("undo o/points.src --output back/points.src").assert().success();
            assert_whole(&bench, &files, &context);
            // and the next rewrite is one of the original
            bench.run(&rewrite("other.yaml")).assert().success();
            assert!(assert_whole(&bench, &files, &context), "{context}");
            assert_eq!(bench.read("back/points.src"), bench.read("points.src"), "{context}");
            assert_eq!(bench.read("back/points.DAT"), bench.read("points.DAT"), "{context}");
            assert_eq!(bench.leftovers("o"), Vec::<String>::new(), "{context}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(strace), ignore = "strace is absent: it makes system calls fail")]
fn fault_injection_a_program_in_place_is_never_lost() {
    let bench = Bench::new();
    let original = bench.read("p.csv");
    for call in ["renameat", "linkat", "unlink", "write", "fsync"] {
        for when in 1..=8 {
            for answer in ["error=EIO", "signal=SIGKILL"] {
                std::fs::write(bench.path("p.csv"), &original).unwrap();
                let _ = std::fs::remove_file(bench.path("p.csv.lostmotion.json"));
                let args = format!("{REWRITE} p.csv --output p.csv --force");
                let run = bench.injected(&format!("{call}:{answer}:when={when}"), &args);
                let context = format!("{call} {answer} {when}");
                if run.status.code() == Some(2) {
                    assert_eq!(bench.read("p.csv"), original, "{context}: an error means that nothing was written");
                }
                let noted = bench.path("p.csv.lostmotion.json").exists();
                assert!(noted || bench.read("p.csv") == original, "{context}: a result without its note");
                if noted || run.status.code() != Some(2) {
                    // whatever a kill left, `undo` goes back to the original, where there is anything to go back from
                    let undo = bench.run("undo p.csv --in-place").output().unwrap();
                    assert!(undo.status.success() || bench.read("p.csv") == original, "{context}");
                }
                assert_eq!(bench.read("p.csv"), original, "{context}");
            }
        }
    }
}

/// A command that was killed half way is repeated: the program is rewritten once, not twice.
#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(strace), ignore = "strace is absent: it makes system calls fail")]
fn fault_injection_a_repeated_command_rewrites_a_program_in_place_once() {
    let bench = Bench::new();
    bench.run("rewrite --model comp.yaml p.csv --output once.csv").assert().success();
    let original = bench.read("p.csv");
    for when in 1..=2 {
        std::fs::write(bench.path("p.csv"), &original).unwrap();
        let args = format!("{REWRITE} p.csv --output p.csv --force");
        let killed = bench.injected(&format!("renameat:signal=SIGKILL:when={when}"), &args);
        assert_eq!(killed.status.code(), None, "{when}");
        bench.run(&args).assert().success();
        assert_eq!(bench.read("p.csv"), bench.read("once.csv"), "{when}");
        bench.run("undo p.csv --in-place").assert().success();
        assert_eq!(bench.read("p.csv"), original, "{when}");
    }
}

/// `lostmotion` that heeds signals, even where the tests run in the background of a shell, which ignores some for all its children.
pub fn by_default_signals() -> std::process::Command {
    let binary = support::binary();
    if cfg!(target_os = "linux") {
        let mut command = std::process::Command::new("env");
        command.arg("--default-signal=INT,HUP").arg(binary);
        command
    } else {
        std::process::Command::new(binary)
    }
}

/// A signal in the middle of a long run: its own exit code, and nothing is left.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_run_with_its_own_exit_code_and_leaves_nothing() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("o")).unwrap();
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let mut command = by_default_signals();
        command.current_dir(bench.0.path()).args("rewrite --model comp.yaml - --output o/out.csv".split(' '));
        let mut run = command.stdin(std::process::Stdio::piped()).stderr(std::process::Stdio::null()).spawn().unwrap();
        let mut stdin = run.stdin.take().unwrap();
        stdin.write_all(b"a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n").unwrap();
        std::thread::sleep(std::time::Duration::from_millis(500));
        std::process::Command::new("kill").args(["-s", signal, &run.id().to_string()]).status().unwrap();
        assert_eq!(run.wait().unwrap().code(), Some(code), "{signal}");
        assert_eq!(bench.leftovers("o"), Vec::<String>::new());
    }
}

/// Where the spacing of a program jumps, a cubic through its points would swing far out of them.
#[test]
fn a_refined_path_stays_near_the_points_of_the_program_and_says_how_near() {
    let bench = Bench::new();
    let robot = "schema: lostmotion/robot/1\nname: t\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: Z, kind: prismatic, \
                 d_mm: 0}\n";
    bench.write("two.yaml", robot);
    let effect = "{effect: backlash, joint: Z, half_gap_mm: 0.02}";
    bench.write("z.yaml", &format!("schema: lostmotion/model/1\nrobot: two.yaml\neffects:\n  - {effect}\n"));
    let rows =
        [(99.416, 0.8), (95.456, 0.9), (91.677, 1.0), (88.230, 1.101), (88.780, 5.2), (92.293, 5.3), (96.113, 5.4)];
    let text: String = rows.iter().map(|(z, t)| format!("0,{z:.3},{t:.3}\n")).collect();
    bench.write("jump.csv", &format!("a1_deg,z_mm,t_s\n{text}"));
    for refine in ["none", "cubic", "cartesian"] {
        let run =
            bench.run(&format!("rewrite --model z.yaml jump.csv --refine {refine} --output out_{refine}.csv --json"));
        let run = { run }.assert().success();
        let said: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
        // against the straight path through the points of the program, at the times of the result
        let at = |t: f64| {
            let k = rows.windows(2).position(|w| t <= w[1].1).unwrap();
            let ((z0, t0), (z1, t1)) = (rows[k], rows[k + 1]);
            z0 + (t - t0) / (t1 - t0) * (z1 - z0)
        };
        let out = String::from_utf8(bench.read(format!("out_{refine}.csv"))).unwrap();
        let departure = |line: &str| {
            let v: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            (v[1] - at(v[2])).abs()
        };
        let worst = out.lines().skip(1).map(departure).fold(0.0, f64::max);
        let told = said["largest_change_um"].as_f64().unwrap();
        assert!(worst < 0.05, "{refine}: {worst} mm");
        assert!(told + 1.0 >= 1000.0 * worst, "{refine}: {worst} mm, but {told} um are reported");
    }
}
