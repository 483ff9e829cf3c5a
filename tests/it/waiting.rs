//! Nothing keeps a run waiting or stops it that need not: FIFOs under our names, readers that have gone or do not read, and what a loss
//! of power left.

#![cfg(unix)]

use crate::originals::{Cell, FOREIGN_JOURNAL, REWRITE, program};
use crate::support;
use std::process::{Command, Stdio};

#[test]
fn fifos_and_folders_under_our_names_keep_no_run_waiting_and_stop_no_program() {
    let cell = Cell::new();
    cell.write("top/in/w.csv", &program(0));
    cell.fifo("top/in/other.csv.lostmotion.json");
    cell.fifo("top/in/.lostmotion-aaaaaaaaaa.part");
    cell.fifo("top/.lostmotion.lock");
    cell.link("nowhere", "top/in/l.csv.lostmotion.json");
    std::fs::create_dir(cell.path("top/in/d.csv.lostmotion.json")).unwrap();
    cell.rewrite("top/in/w.csv --output top/in/o.csv").success();
    cell.write("top/v/w.csv", &program(0));
    cell.fifo("top/v/other.csv.lostmotion.json");
    cell.fifo("top/out/.lostmotion-aaaaaaaaaa.part");
    cell.rewrite("top/v --output-dir top/out").success();
    // a note has no other place
    cell.fifo("p.csv.lostmotion.json");
    let run = cell.rewrite("w.csv --output p.csv").ends_with(2);
    assert!(run.stderr.contains("p.csv.lostmotion.json"), "{}", run.stderr);
    assert!(!cell.has("p.csv"));
}

#[test]
fn results_and_notes_that_a_loss_of_power_damaged_are_written_again() {
    let cell = Cell::new();
    cell.write("in/w.csv", &program(0));
    cell.krl("in/");
    cell.rewrite("in --output-dir out").success();
    let names = ["w.csv", "w.csv.lostmotion.json", "points.src", "points.DAT", "points.src.lostmotion.json"];
    let whole = names.map(|n| std::fs::read(cell.path("out").join(n)).unwrap());
    for (name, good) in names.iter().zip(&whole) {
        let file = cell.path("out").join(name);
        let half = good.len() / 2;
        let torn = [&good[..half], &vec![0; good.len() - half]].concat();
        for damaged in [vec![0; good.len()], torn, good[..half].to_vec(), Vec::new()] {
            // cut without zeros, a file beside the one that was named may be anybody's
            if *name == "points.DAT" && !damaged.is_empty() && !damaged.contains(&0) {
                continue;
            }
            std::fs::write(&file, damaged).unwrap();
            cell.rewrite("in --output-dir out").success();
            let now = names.map(|n| std::fs::read(cell.path("out").join(n)).unwrap());
            assert!(now == whole, "{name}");
        }
    }
    // what is no remains of ours stays
    std::fs::write(cell.path("out/w.csv"), b"\x7fELF\0\x01\0rest").unwrap();
    cell.rewrite("in --output-dir out").ends_with(1);
    assert_eq!(std::fs::read(cell.path("out/w.csv")).unwrap(), b"\x7fELF\0\x01\0rest");
}

#[test]
fn a_damaged_note_beside_a_program_that_stays_as_it_is_stops_no_folder() {
    let cell = Cell::new();
    cell.write("in/w.csv", &program(0));
    cell.write("out/w.csv.lostmotion.json", "{");
    cell.run("rewrite --model still.yaml in --output-dir out").success();
    assert_eq!(cell.read("out/w.csv"), program(0));
    // whole again: it shows that the copy is untouched
    assert!(cell.read("out/w.csv.lostmotion.json").contains("sha256_out"));
}

#[test]
fn a_no_stays_a_no_where_the_reader_of_the_document_has_gone() {
    let cell = Cell::new();
    cell.write("in/w.csv", &program(0));
    cell.write("in/bad.csv", "a1_deg\nnothing\n");
    cell.write("far.csv", &program(183));
    for line in [
        "w.csv --check w.csv --json",
        "in --check in --json",
        "in --output-dir out --json",
        "far.csv --output o.csv --json",
    ] {
        let run = cell.rewrite_unread(line);
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(1) && said.contains("lostmotion:"), "{line}: {:?} {said}", run.status);
    }
    let run = cell.rewrite_unread("w.csv --output whole.csv --json");
    assert_eq!(run.status.code(), Some(0));
    assert!(cell.has("whole.csv") && cell.leftovers("") == Vec::<String>::new());
}

/// Starts a run, sends TERM once it waits, and returns its exit code.
#[cfg(target_os = "linux")]
fn ended(cell: &Cell, line: &str, waits: &dyn Fn() -> bool) -> Option<i32> {
    use std::time::{Duration, Instant};
    let mut command = crate::faults::by_default_signals();
    command.current_dir(cell.path("")).args(format!("{REWRITE} {line}").split(' '));
    let mut run = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let begun = Instant::now();
    while !waits() && begun.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(500));
    Command::new("kill").args(["-s", "TERM", &run.id().to_string()]).status().unwrap();
    let told = Instant::now();
    while told.elapsed() < Duration::from_secs(20) {
        if let Some(status) = run.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    None
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_run_that_waits_for_a_reader_and_what_it_put_in_place_is_taken_back() {
    let cell = Cell::new();
    cell.fifo("o/f");
    let at_once = || true;
    assert_eq!(ended(&cell, "w.csv --output o/f", &at_once), Some(143));
    cell.write("o/s.jsonl", "{\"input\":\"before\",\"output\":null,\"status\":\"failed\",\"reason\":\"x\"}\n");
    assert_eq!(ended(&cell, "w.csv --output o/f --summary o/s.jsonl --report o/r.html", &at_once), Some(143));
    assert_eq!(
        cell.read("o/s.jsonl"),
        "{\"input\":\"before\",\"output\":null,\"status\":\"failed\",\"reason\":\"x\"}\n"
    );
    assert!(!cell.has("o/r.html"));
    assert_eq!(cell.leftovers("o"), Vec::<String>::new());
    // more than a pipe holds
    let rows = program(0).lines().skip(1).map(|l| format!("{l}\n")).collect::<String>().repeat(1000);
    cell.write("long.csv", &format!("{}\n{rows}", program(0).lines().next().unwrap()));
    assert_eq!(ended(&cell, "long.csv --output - --summary o/t.jsonl", &at_once), Some(143));
    assert!(!cell.has("o/t.jsonl"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_leaves_no_lock_in_a_folder_of_results() {
    let cell = Cell::new();
    let programs = 400;
    (0..programs).for_each(|k| cell.write(&format!("in/{k}.csv"), &program(k % 90)));
    let last = || std::fs::read_dir(cell.path("out")).is_ok_and(|d| d.count() > 2 * programs as usize);
    // the document is more than a pipe holds, so the run still has the folder
    assert_eq!(ended(&cell, "in --output-dir out --json", &last), Some(143));
    assert_eq!(cell.leftovers("out"), Vec::<String>::new());
}

#[cfg(target_os = "linux")]
#[test]
fn where_the_folder_for_temporary_files_cannot_be_written_it_is_named() {
    let cell = Cell::new();
    let rows = program(0).lines().skip(1).map(|l| format!("{l}\n")).collect::<String>().repeat(45_000);
    cell.write("long.csv", &format!("{}\n{rows}", program(0).lines().next().unwrap()));
    let mut command = support::process();
    command
        .current_dir(cell.path(""))
        .env("TMPDIR", "/nowhere")
        .args(format!("{REWRITE} long.csv --output -").split(' '));
    let run = command.stdout(Stdio::null()).output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(
        said.contains("standard output") && said.contains("/nowhere") && !said.contains("standard input"),
        "{said}"
    );
}

#[test]
#[cfg_attr(superuser, ignore = "the superuser reads every file")]
fn unreadable_journal_is_not_called_damaged() {
    use std::os::unix::fs::PermissionsExt;
    let cell = Cell::new();
    let journal = "o/.lostmotion-abcdefghij.journal";
    cell.write(journal, FOREIGN_JOURNAL);
    std::fs::set_permissions(cell.path(journal), std::fs::Permissions::from_mode(0o000)).unwrap();
    let run = cell.rewrite("w.csv --output o/o.csv").ends_with(2);
    assert!(run.stderr.contains("permission denied") && !run.stderr.contains("damaged"), "{}", run.stderr);
}
