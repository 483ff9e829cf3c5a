//! Limits of sizes, memory and times. Kills, failing system calls and simultaneous runs: `faults`.

use crate::support::{self, bundled};
use crate::vendor_rewrite::Desk;
use lostmotion::rewrite::manifest::shard_of;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::io::Write as _;

fn said(done: &std::process::Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

/// The command, after others such as `strace ...`.
fn after(desk: &Desk, before: &[&str], line: &str) -> std::process::Output {
    let lostmotion = support::binary();
    let (program, more) = before.split_first().unwrap();
    let mut command = std::process::Command::new(program);
    command.args(more).arg(lostmotion).args(line.split(' ')).current_dir(desk.folder.path()).env("RUST_BACKTRACE", "0");
    command.output().unwrap()
}

/// A desk with the circle program and a KRL program.
fn desk() -> Desk {
    let desk = Desk::new(0.003);
    let circle = bundled("samples/circle/circle_program.csv");
    std::fs::copy(circle, desk.path("p.csv")).unwrap();
    desk
}

#[test]
fn half_gaps_beyond_anything_real_are_refused_unless_forced() {
    let desk = Desk::new(28.0);
    let wide = String::from_utf8(desk.read("robot.yaml")).unwrap();
    desk.write("robot.yaml", &wide);
    let refused = desk.run("rewrite --model model.yaml part.src --output out.src").code(2);
    let text = said(refused.get_output());
    assert!(text.contains("28.000000 deg for A1") && text.contains("--force"), "{text}");
    assert!(!desk.path("out.src").exists());
    // ten times the worst of real robots, which have a tenth of a degree, is still taken
    let desk = Desk::new(0.1);
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
}

#[test]
fn rates_that_cannot_be_checked_are_reported() {
    let desk = desk();
    // the circle has no times
    let done = desk.run("rewrite --model model.yaml p.csv --output out.csv").success();
    let text = said(done.get_output());
    assert!(text.contains("limits of speed and acceleration were not checked everywhere"), "{text}");
    let done = desk.run("rewrite --model model.yaml p.csv --output timed.csv --speed-mm-s 100").success();
    let text = said(done.get_output());
    assert!(!text.contains("were not checked"), "{text}");
}

/// The verdict reads the program again, and a named pipe would wait for another writer for ever.
#[cfg(target_os = "linux")]
#[test]
fn a_program_from_a_named_pipe_is_read_once() {
    let desk = desk();
    let made = std::process::Command::new("mkfifo").arg(desk.path("pipe.csv")).status().unwrap();
    assert!(made.success());
    let (pipe, program) = (desk.path("pipe.csv"), desk.read("p.csv"));
    let writer = std::thread::spawn(move || std::fs::write(pipe, program).unwrap());
    let done = after(&desk, &["timeout", "60"], "rewrite --model model.yaml pipe.csv --output out.csv");
    assert!(done.status.success(), "{:?} {}", done.status, said(&done));
    writer.join().unwrap();
    desk.run("rewrite --model model.yaml p.csv --output own.csv").success();
    assert_eq!(desk.read("out.csv"), desk.read("own.csv"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_that_unpacks_beyond_the_memory_is_refused_by_name() {
    let desk = desk();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(b"t_s,cmd_A1_deg,x_mm,y_mm,z_mm\n").unwrap();
    let rows = "0,0,0,0,0\n".repeat(100_000);
    (0..200).for_each(|_| packed.write_all(rows.as_bytes()).unwrap());
    std::fs::write(desk.path("log.csv.gz"), packed.finish().unwrap()).unwrap();
    // 200 MB of text, far more as numbers, where 400 MB may be had
    let little = ["sh", "-c", "ulimit -v 400000; exec \"$0\" \"$@\""];
    let done = after(&desk, &little, "identify path --robot robot.yaml --log log.csv.gz");
    let text = said(&done);
    assert_eq!(done.status.code(), Some(2), "{text}");
    assert!(text.contains("log.csv.gz") && text.contains("memory"), "{text}");
}

/// 1 MB of gzip that unpacks to 300 MB, where 400 MB of addresses may be had: it is counted, not held.
#[test]
fn a_log_that_unpacks_to_more_than_its_size_allows_is_refused_in_little_memory() {
    let desk = desk();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(b"t_s,cmd_A1_deg,x_mm,y_mm,z_mm\n").unwrap();
    let rows = "0,0,0,0,0\n".repeat(100_000);
    (0..300).for_each(|_| packed.write_all(rows.as_bytes()).unwrap());
    std::fs::write(desk.path("log.csv.gz"), packed.finish().unwrap()).unwrap();
    let little = ["sh", "-c", "ulimit -v 400000; exec \"$0\" \"$@\""];
    let done = after(&desk, &little, "identify path --robot robot.yaml --log log.csv.gz");
    let text = said(&done);
    assert_eq!(done.status.code(), Some(2), "{text}");
    assert!(text.contains("log.csv.gz") && text.contains("100 times its size"), "{text}");
}

/// Whatever a document was given for.
#[test]
fn a_document_nested_too_deep_is_refused_at_once_by_every_command() {
    let desk = desk();
    let deep = |open: &str, close: &str| format!("schema: x\na: {}1{}\n", open.repeat(40_000), close.repeat(40_000));
    desk.write("nest.yaml", &deep("[", "]"));
    desk.write("braces.yaml", &deep("{a: ", "}"));
    let lines = [
        "robot check NEST",
        "fit --gaps NEST --robot robot.yaml --output c.yaml",
        "rewrite --model NEST p.csv --output out.csv",
        "rewrite --robot NEST --compensator c.yaml p.csv --output out.csv",
        "rewrite --robot robot.yaml --compensator NEST p.csv --output out.csv",
        "rewrite --model model.yaml --frames NEST part.src --output out.src",
        "simulate --model NEST --input p.csv --output log.csv",
        "diagnose --model NEST --log p.csv",
        "identify path --robot NEST --log p.csv",
        "identify path --robot robot.yaml --columns NEST --log p.csv",
        "assess program --model NEST --before p.csv --after p.csv",
    ];
    for line in lines.iter().flat_map(|l| [l.replace("NEST", "nest.yaml"), l.replace("NEST", "braces.yaml")]) {
        let start = std::time::Instant::now();
        let done = after(&desk, &["env"], &line);
        let text = said(&done);
        assert!(done.status.code() == Some(2) && text.contains("64 levels"), "{line}: {text}");
        assert!(start.elapsed().as_secs_f64() < 2.0, "{line}: {:?}", start.elapsed());
    }
}

/// Times next to zero, as a broken clock gives them.
#[test]
fn diagnose_names_times_too_close_to_distinguish_in_few_digits() {
    let desk = desk();
    desk.write("log.csv", "t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm\n0,0,0,0,0,0,0,0,0,0\n1e-305,1,0,0,0,0,0,0,0,0\n2e-305,2,0,0,0,0,0,0,0,0\n");
    let done = after(&desk, &["env"], "diagnose --model model.yaml --log log.csv --json");
    let text = said(&done);
    assert_eq!(done.status.code(), Some(2), "{text}");
    assert!(text.contains("log.csv:3:1") && text.contains("times 0 s and 1e-305 s, which are too close"), "{text}");
}

#[test]
fn simulate_writes_finite_numbers_for_extreme_times_and_positions() {
    let desk = desk();
    let programs = [
        "0,0\n1e-300,10\n2e-300,5",
        "0,0\n1,1e7\n2,-1e7",
        "0,0\n1e-100,1e-300\n1,5",
        "0,0\n0.1,1e300\n0.2,0",
        "0,1e308\n0.1,-1e308\n0.2,1e308",
        "0,0\n1e15,1\n2e15,0",
    ];
    for effect in ["{effect: backlash, joint: A1, half_gap_deg: 0.01}", "{effect: servo_lag, joint: A1, lag_s: 1e-200}"]
    {
        let model = format!(
            "schema: lostmotion/model/1\nrobot: robot.yaml\nregistration: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}\neffects:\n  - {effect}\n"
        );
        desk.write("any.yaml", &model);
        for rows in programs {
            let rows = rows.replace('\n', ",-90,90,0,0,0\n") + ",-90,90,0,0,0\n";
            desk.write("t.csv", &format!("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n{rows}"));
            let done = desk.run("simulate --model any.yaml --input t.csv --output s.csv");
            let code = done.get_output().status.code();
            assert!(matches!(code, Some(0..=2)), "{code:?}: {rows}{}", said(done.get_output()));
            if code == Some(0) {
                let log = String::from_utf8(desk.read("s.csv")).unwrap();
                let numbers = log.lines().skip(1).flat_map(|l| l.split(',')).filter(|cell| !cell.is_empty());
                let odd: Vec<&str> = numbers.filter(|c| c.parse::<f64>().is_ok_and(|v| !v.is_finite())).collect();
                assert_eq!(odd, [""; 0], "{rows}");
            }
        }
    }
}

/// Largest memory of a run that the command reports, bytes.
fn memory(desk: &Desk, line: &str) -> f64 {
    let done = desk.run(&format!("--verbose {line}")).success();
    let text = said(done.get_output());
    let mb = text.split("at most ").nth(1).and_then(|rest| rest.split(" MB of memory").next());
    mb.and_then(|mb| mb.parse::<f64>().ok()).unwrap_or_else(|| panic!("{text}")) * 1e6
}

#[cfg(target_os = "linux")]
#[test]
fn a_worker_takes_no_more_memory_for_a_manifest_a_thousand_times_as_long() {
    const SHARDS: usize = 100;
    let desk = desk();
    let program = desk.read("part.src");
    let sum = Sha256::digest(&program).iter().fold(String::new(), |text, b| text + &format!("{b:02x}"));
    let size = program.len();
    let entry = |key: &str| {
        format!("{{\"key\":\"{key}\",\"size\":{size},\"sha256\":\"{sum}\",\"format\":\"krl\",\"state\":\"ready\"}}\n")
    };
    // the programs of the first part are there; those of the others are only named
    let (mut short, mut long, mut ours) = (String::new(), String::new(), 0);
    for k in 0..100_000 {
        let key = format!("cell/p{k:06}.src");
        let own = shard_of(&key, SHARDS) == 1;
        if own && ours == 100 {
            continue;
        }
        write!(long, "{}", entry(&key)).unwrap();
        if own {
            ours += 1;
            write!(short, "{}", entry(&key)).unwrap();
            desk.write(&format!("in/{key}"), crate::vendor_rewrite::PROGRAM);
        }
    }
    assert_eq!(ours, 100);
    desk.write("short.jsonl", &short);
    desk.write("long.jsonl", &long);
    let of = |manifest: &str| {
        let line =
            "rewrite --model model.yaml in --output-dir out-{} --manifest {}.jsonl --shard 1/100 --summary {}-s.jsonl";
        memory(&desk, &line.replace("{}", manifest))
    };
    let [short, long] = ["short", "long"].map(of);
    // 14 MB of text, 25 MB and more as entries
    assert!(long < short + 4e6, "{short} bytes with 100 programs, {long} with 100,000");
    assert_eq!(std::fs::read_dir(desk.path("out-long/cell")).unwrap().count(), 200);
}
