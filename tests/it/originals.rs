//! The program that was there before is not lost: links, standard input, a second run in place, notes, power failures.

#![cfg(unix)]

use crate::support::{self, Outcome, WorkFolder, root};
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// A folder with a program, the robot and a model with a gap on its first joint.
pub struct Cell(WorkFolder);

/// Goes to and fro in the first joint.
const TURNS: [u32; 9] = [0, 1, 2, 3, 2, 1, 0, 1, 2];

/// The program with its first joint `from_deg` further.
pub fn program(from_deg: u32) -> String {
    let row = |turn: u32| format!("{}.0000,-90.0000,90.0000,0.0000,10.0000,0.0000\n", from_deg + turn);
    let rows: String = TURNS.into_iter().map(row).collect();
    format!("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n{rows}")
}

const REWRITE: &str = "rewrite --model model.yaml";

impl Cell {
    pub fn new() -> Self {
        let cell = Self(WorkFolder::new());
        std::fs::copy(root().join("configs/kuka-kr120-r2500-pro.yaml"), cell.path("robot.yaml")).unwrap();
        let effect = "{effect: backlash, joint: A1, half_gap_deg: 0.0028}";
        cell.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n"));
        cell.write("still.yaml", &cell.read("model.yaml").replace("joint: A1", "joint: A6"));
        cell.write("w.csv", &program(0));
        cell
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn link(&self, to: &str, name: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        symlink(to, self.path(name)).unwrap();
    }

    pub fn fifo(&self, name: &str) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        assert!(Command::new("mkfifo").arg(self.path(name)).status().unwrap().success());
    }

    pub fn read(&self, name: &str) -> String {
        String::from_utf8(std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    pub fn has(&self, name: &str) -> bool {
        std::fs::symlink_metadata(self.path(name)).is_ok()
    }

    pub fn run(&self, line: &str) -> Outcome {
        self.0.run(line)
    }

    /// `rewrite` with the model; it ends within a minute.
    pub fn rewrite(&self, line: &str) -> Outcome {
        let line = format!("60 {} {REWRITE} {line}", support::binary().display());
        support::outcome(assert_cmd::Command::new("timeout").current_dir(self.0.path()).args(line.split(' ')))
    }

    /// `rewrite` with a file as standard input.
    fn rewrite_from(&self, stdin: &str, line: &str) -> std::process::Output {
        let mut command = support::process();
        command.current_dir(self.0.path()).args(format!("{REWRITE} {line}").split(' '));
        command.stdin(std::fs::File::open(self.path(stdin)).unwrap()).output().unwrap()
    }

    /// `rewrite` whose standard output has no reader.
    fn rewrite_unread(&self, line: &str) -> std::process::Output {
        let mut command = support::process();
        command.current_dir(self.0.path()).args(format!("{REWRITE} {line}").split(' '));
        let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(run.stdout.take());
        run.wait_with_output().unwrap()
    }

    /// Names that begin as ours do.
    pub fn leftovers(&self, folder: &str) -> Vec<String> {
        let names =
            std::fs::read_dir(self.path(folder)).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        names.filter(|n| n.starts_with(".lostmotion")).collect()
    }
}

const FOREIGN_JOURNAL: &str = r#"{"schema":"lostmotion/journal/1","back":true,"files":[
    {"target":"x.csv","new":".lostmotion-q.part","bytes":0,"old":null}]}"#;

#[test]
fn a_journal_reaches_no_file_outside_its_folder_through_a_link() {
    let cell = Cell::new();
    cell.write("home/precious.csv", &program(20));
    cell.write("cell/w.csv", &program(0));
    cell.link("../home/precious.csv", "cell/x.csv");
    cell.write("cell/.lostmotion-abcdefghij.journal", FOREIGN_JOURNAL);
    for line in ["cell/w.csv --output o.csv", "cell --output-dir out"] {
        let run = cell.rewrite(line).ends_with(2);
        assert!(run.stderr.contains("a journal that is damaged"), "{}", run.stderr);
        assert_eq!(cell.read("home/precious.csv"), program(20), "{line}");
    }
}

#[test]
fn an_output_through_a_link_has_its_journal_where_its_file_is() {
    let cell = Cell::new();
    cell.write("home/keep", "");
    cell.link("../home/o.csv", "cell/o.csv");
    // through a link to nowhere the file is made, and the link stays
    cell.rewrite("w.csv --output cell/o.csv").success();
    let once = cell.read("home/o.csv");
    assert!(std::fs::symlink_metadata(cell.path("cell/o.csv")).unwrap().is_symlink());
    // and what a killed run left there is taken back before it is written again
    cell.write("home/.lostmotion-abcdefghij.journal", &FOREIGN_JOURNAL.replace("x.csv", "o.csv"));
    cell.rewrite("w.csv --output cell/o.csv").success();
    assert_eq!(cell.read("home/o.csv"), once);
    assert_eq!(cell.leftovers("home"), Vec::<String>::new());
}

#[test]
fn a_link_at_the_name_of_the_lock_destroys_and_shows_no_file() {
    let cell = Cell::new();
    cell.write("precious.csv", &program(20));
    cell.write("in/w.csv", &program(0));
    cell.link("../precious.csv", "in/.lostmotion.lock");
    cell.link("../precious.csv", "out/.lostmotion.lock");
    for line in ["in/w.csv --output o.csv", "w.csv --output out/o.csv", "in --output-dir out"] {
        let run = cell.rewrite(line).ends_with(2);
        assert!(run.stderr.contains("no lock of lostmotion") && !run.stderr.contains("a1_deg"), "{}", run.stderr);
        assert_eq!(cell.read("precious.csv"), program(20), "{line}");
    }
}

#[test]
fn a_link_in_the_output_folder_never_leads_a_result_over_a_program() {
    // as `cp -s` makes it; a link of a folder; to another program; among the programs
    for (to, link) in
        [("../in/w.csv", "w.csv"), ("../in/sub", "sub"), ("../in/v.csv", "w.csv"), ("../in/x.csv", "v.csv")]
    {
        let cell = Cell::new();
        let names = ["w.csv", "v.csv", "sub/w.csv"];
        names.iter().enumerate().for_each(|(k, n)| cell.write(&format!("in/{n}"), &program(10 * k as u32)));
        cell.link(to, &format!("out/{link}"));
        let run = cell.rewrite("in --output-dir out").ends_with(1);
        assert!(run.stderr.contains(&format!("out/{link}")) && run.stderr.contains("a link "), "{}", run.stderr);
        for (k, name) in names.iter().enumerate() {
            assert_eq!(cell.read(&format!("in/{name}")), program(10 * k as u32), "{link} -> {to}");
        }
        assert!(!cell.has("in/x.csv") && !cell.has("in/w.csv.lostmotion.json"), "{link} -> {to}");
    }
}

#[test]
fn an_input_that_is_a_link_to_its_result_is_not_replaced() {
    let cell = Cell::new();
    cell.write("out/w.csv", &program(0));
    cell.link("../out/w.csv", "in/w.csv");
    cell.rewrite("in --output-dir out").ends_with(1);
    assert_eq!(cell.read("out/w.csv"), program(0));
}

const IN_PLACE: &str = "w.csv --output w.csv --force";

#[test]
fn a_program_in_place_is_not_rewritten_twice_even_by_force() {
    let cell = Cell::new();
    cell.rewrite("w.csv --output once.csv").success();
    cell.rewrite(IN_PLACE).success();
    cell.link("w.csv", "link.csv");
    for line in [IN_PLACE, "link.csv --output w.csv --force", "w.csv --output link.csv --force"] {
        let run = cell.rewrite(line).ends_with(2);
        assert!(run.stderr.contains("rewritten already") && run.stderr.contains("undo"), "{}", run.stderr);
        assert_eq!(cell.read("w.csv"), cell.read("once.csv"), "{line}");
    }
    cell.run("undo w.csv --in-place").success();
    assert_eq!(cell.read("w.csv"), program(0));
    // elsewhere the force means what it meant
    cell.rewrite(IN_PLACE).success();
    cell.rewrite("w.csv --output twice.csv --force").success();
    assert_ne!(cell.read("twice.csv"), cell.read("once.csv"));
}

#[test]
fn a_krl_program_and_a_folder_in_place_are_not_rewritten_twice_even_by_force() {
    let cell = Cell::new();
    for name in ["points.src", "points.DAT"] {
        std::fs::copy(root().join("samples/programs/krl").join(name), cell.path(name)).unwrap();
    }
    let krl = "points.src --output points.src --force";
    cell.rewrite(krl).success();
    let once = [cell.read("points.src"), cell.read("points.DAT")];
    cell.rewrite(krl).ends_with(2);
    assert_eq!([cell.read("points.src"), cell.read("points.DAT")], once);
    cell.write("in/w.csv", &program(0));
    cell.rewrite("in --output-dir in --force").success();
    let once = cell.read("in/w.csv");
    assert_ne!(once, program(0));
    cell.rewrite("in --output-dir in --force").ends_with(1);
    assert_eq!(cell.read("in/w.csv"), once);
    cell.run("undo in/w.csv --in-place").success();
    assert_eq!(cell.read("in/w.csv"), program(0));
}

/// Killed when all names are in place, but what was kept is not yet gone.
#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(not(strace), ignore = "strace is absent: it makes system calls fail")]
fn fault_injection_a_program_in_place_that_was_killed_at_its_end_is_not_rewritten_twice() {
    let cell = Cell::new();
    cell.rewrite("w.csv --output once.csv").success();
    for when in 1..=3 {
        cell.write("w.csv", &program(0));
        let _ = std::fs::remove_file(cell.path("w.csv.lostmotion.json"));
        let mut strace = Command::new("strace");
        strace.args(["-f", "-qq", "-o", "/dev/null", "-e", &format!("inject=unlink:signal=SIGKILL:when={when}")]);
        strace.arg(support::binary()).args(format!("{REWRITE} {IN_PLACE}").split(' ')).current_dir(cell.path(""));
        strace.output().expect("strace is needed");
        let again = cell.rewrite(IN_PLACE);
        assert!(matches!(again.code, Some(0 | 2)), "{when}: {}", again.stderr);
        assert_eq!(cell.read("w.csv"), cell.read("once.csv"), "{when}");
        cell.run("undo w.csv --in-place").success();
        assert_eq!(cell.read("w.csv"), program(0), "{when}");
    }
}

#[test]
fn a_note_of_the_very_bytes_that_stand_there_stays_where_nothing_is_compensated() {
    let cell = Cell::new();
    cell.rewrite("w.csv --output o.csv").success();
    cell.write("far/copy.csv", &cell.read("o.csv"));
    let still = |line: &str| cell.run(&format!("rewrite --model still.yaml {line}"));
    // in place it is refused, and by way of a copy nothing changes
    still("o.csv --output o.csv --force").ends_with(2);
    still("far/copy.csv --output o.csv --force").success();
    assert_eq!(cell.read("o.csv"), cell.read("far/copy.csv"));
    cell.run("undo o.csv --output back.csv").success();
    assert_eq!(cell.read("back.csv"), program(0));
    // the note of other bytes goes
    still("w.csv --output o.csv --force").success();
    assert_eq!(cell.read("o.csv"), program(0));
    assert!(!cell.has("o.csv.lostmotion.json"));
}

#[test]
fn the_file_that_is_standard_input_is_not_replaced() {
    let cell = Cell::new();
    cell.link("w.csv", "link.csv");
    for line in ["- --output w.csv", "- --output link.csv --force", "- --output o.csv --summary w.csv"] {
        let run = cell.rewrite_from("w.csv", line);
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(2) && said.contains("the same file as standard input"), "{line}: {said}");
        assert_eq!(cell.read("w.csv"), program(0), "{line}");
    }
    // another file, and a page of what comes from a file
    assert!(cell.rewrite_from("w.csv", "- --output o.csv").status.success());
    let mut show = support::process();
    show.current_dir(cell.path("")).args(["simulate", "--model", "model.yaml", "--input", "-", "--output", "w.csv"]);
    let done = show.stdin(std::fs::File::open(cell.path("w.csv")).unwrap()).output().unwrap();
    assert_eq!((done.status.code(), cell.read("w.csv")), (Some(2), program(0)));
}

#[test]
fn a_summary_or_a_page_goes_over_no_note_of_a_folder() {
    let cell = Cell::new();
    cell.write("in/w.csv", &program(0));
    cell.link("out/w.csv.lostmotion.json", "link.json");
    for option in ["--summary", "--report"] {
        for file in ["out/w.csv.lostmotion.json", "in/w.csv.lostmotion.json", "link.json"] {
            std::fs::create_dir_all(cell.path("out")).unwrap();
            let run = cell.rewrite(&format!("in --output-dir out {option} {file}")).ends_with(2);
            assert!(run.stderr.contains("the note of a program"), "{option} {file}: {}", run.stderr);
            assert!(!cell.has("out/w.csv"), "{option} {file}");
        }
    }
}

#[test]
fn the_note_of_a_result_is_found_by_every_name_of_the_file() {
    let cell = Cell::new();
    cell.write("real/w.csv", &program(30));
    cell.link("../real/w.csv", "l/w.csv");
    cell.rewrite("w.csv --output l/w.csv").success();
    let once = cell.read("real/w.csv");
    assert!(cell.has("real/w.csv.lostmotion.json") && !cell.has("l/w.csv.lostmotion.json"));
    cell.link("../real/w.csv", "far/other.csv");
    for input in ["real/w.csv", "l/w.csv", "far/other.csv"] {
        let run = cell.rewrite(&format!("{input} --output two.csv")).ends_with(2);
        assert!(run.stderr.contains("rewritten already"), "{input}: {}", run.stderr);
        cell.run(&format!("undo {input} --output back.csv")).success();
        assert_eq!(cell.read("back.csv"), program(0));
    }
    cell.rewrite("far --output-dir out").ends_with(1);
    cell.run("undo l/w.csv --in-place").success();
    assert_eq!(cell.read("real/w.csv"), program(0));
    assert!(!cell.has("real/w.csv.lostmotion.json") && once != program(0));
}

#[test]
fn a_note_of_an_earlier_version_beside_a_link_is_still_found() {
    let cell = Cell::new();
    cell.write("real/w.csv", &program(30));
    cell.link("../real/w.csv", "l/w.csv");
    cell.rewrite("w.csv --output l/w.csv").success();
    std::fs::rename(cell.path("real/w.csv.lostmotion.json"), cell.path("l/w.csv.lostmotion.json")).unwrap();
    cell.rewrite("l/w.csv --output two.csv").ends_with(2);
    cell.run("undo l/w.csv --in-place").success();
    assert_eq!(cell.read("real/w.csv"), program(0));
    assert!(!cell.has("l/w.csv.lostmotion.json"));
}

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
    for name in ["points.src", "points.DAT"] {
        std::fs::copy(root().join("samples/programs/krl").join(name), cell.path("in").join(name)).unwrap();
    }
    cell.rewrite("in --output-dir out").success();
    let names = ["w.csv", "w.csv.lostmotion.json", "points.src", "points.DAT", "points.src.lostmotion.json"];
    let whole = names.map(|n| std::fs::read(cell.path("out").join(n)).unwrap());
    for (name, good) in names.iter().zip(&whole) {
        let file = cell.path("out").join(name);
        let half = good.len() / 2;
        let torn = [&good[..half], &vec![0; good.len() - half]].concat();
        for damaged in [vec![0; good.len()], torn, good[..half].to_vec(), Vec::new()] {
            // cut without zeros, a file beside the one that was named may be anybody's
            if *name == "points.DAT" && !damaged.contains(&0) {
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
    assert!(!cell.has("out/w.csv.lostmotion.json"));
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
    cell.write("o/s.jsonl", "{\"input\":\"before\"}\n");
    assert_eq!(ended(&cell, "w.csv --output o/f --summary o/s.jsonl --report o/r.html", &at_once), Some(143));
    assert_eq!(cell.read("o/s.jsonl"), "{\"input\":\"before\"}\n");
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
fn a_journal_that_may_not_be_read_is_not_called_damaged() {
    use std::os::unix::fs::PermissionsExt;
    let cell = Cell::new();
    let journal = "o/.lostmotion-abcdefghij.journal";
    cell.write(journal, FOREIGN_JOURNAL);
    std::fs::set_permissions(cell.path(journal), std::fs::Permissions::from_mode(0)).unwrap();
    let run = cell.rewrite("w.csv --output o/o.csv").ends_with(2);
    assert!(run.stderr.contains("permission denied") && !run.stderr.contains("damaged"), "{}", run.stderr);
}
