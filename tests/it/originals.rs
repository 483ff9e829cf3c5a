//! The program that was there before is not lost: links, standard input, a second run in place, notes.

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

pub const REWRITE: &str = "rewrite --model model.yaml";

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

    /// A program in KRL and its data list, whose points are its own.
    pub fn krl(&self, folder: &str) {
        let sample = |name: &str| std::fs::read_to_string(root().join("samples/programs/krl").join(name)).unwrap();
        self.write(&format!("{folder}points.src"), &sample("points.src"));
        self.write(&format!("{folder}points.DAT"), &sample("points.DAT").replace("DECL GLOBAL ", "DECL "));
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
    pub fn rewrite_unread(&self, line: &str) -> std::process::Output {
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

pub const FOREIGN_JOURNAL: &str = r#"{"schema":"lostmotion/journal/1","back":true,"files":[
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
    cell.krl("");
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
