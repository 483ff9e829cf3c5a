//! Input that cannot be used: each case is a folder of files, one of which is wrong, and what the message must say.
//!
//! A case runs twice: through the library (the reading layer alone), and through the built command that reads such a file.
//! Asked of both: exit code 2; one line, which names the file, and line and field where there are some; standard output empty;
//! no output file and no leftover beside it.

mod accepted;
mod damage;
mod documents;
mod inputs;
mod outputs;
mod programs;
mod system;
mod usage;

use crate::support::{self, WorkFolder};
use lostmotion::compensator::Compensator;
use lostmotion::error::Error;
use lostmotion::gaps::Gaps;
use lostmotion::log::{ColumnMap, Log, plausibility};
use lostmotion::model::Model;
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Which file of the folder is the bad one, and so which reader meets it.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Bad {
    Robot,
    Model,
    Log,
    Map,
    Gaps,
    Compensator,
    Program,
}

use Bad::{Compensator as C, Gaps as G, Log as L, Map as M, Model as D, Program as P, Robot as R};

const ALL: [Bad; 7] = [R, D, L, M, G, C, P];

impl Bad {
    fn file(self) -> &'static str {
        match self {
            Self::Robot => "robot.yaml",
            Self::Model => "model.yaml",
            Self::Log => "log.csv",
            Self::Map => "map.yaml",
            Self::Gaps => "gaps.yaml",
            Self::Compensator => "comp.yaml",
            Self::Program => "program.csv",
        }
    }
}

/// A planar arm of two joints and a slide: small enough to read, and every kind of joint is there.
const ROBOT: &str = "schema: lostmotion/robot/1
name: arm
joints:
  - {name: J1, kind: revolute, a_mm: 400, limits_deg: [-170, 170], max_speed_deg_s: 100}
  - {name: J2, kind: revolute, a_mm: 300, alpha_deg: 60, limits_deg: [-150, 150]}
  - {name: Z, kind: prismatic, d_mm: 50, limits_mm: [-500, 500]}
";
const MODEL: &str = "schema: lostmotion/model/1
robot: robot.yaml
effects:
  - {effect: backlash, joint: J1, half_gap_deg: 0.003}
";
const MAP: &str = "schema: lostmotion/columns/1
columns: {}
";
const HEAD: &str = "t_s,cmd_J1_deg,cmd_J2_deg,cmd_Z_mm,x_mm,y_mm,z_mm\n";

/// A log of the arm in a turned frame; `edit` changes a row before it is written.
fn log_of(rows: usize, edit: impl Fn(usize, &mut [f64; 7])) -> String {
    let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 1.1);
    let mut text = String::from(HEAD);
    for i in 0..rows {
        let s = i as f64 * 0.05;
        let (j1, j2, z) = (40.0 * s.sin(), 30.0 + 50.0 * (1.7 * s).cos(), 80.0 * (0.6 * s).sin());
        let p = turn * robot.tcp_m(&[j1.to_radians(), j2.to_radians(), z * 1e-3]) * 1e3;
        let mut row = [i as f64 * 0.02, j1, j2, z, p.x + 2000.0, p.y - 100.0, p.z + 3.0];
        edit(i, &mut row);
        let cells: Vec<String> = row.iter().map(|v| format!("{v:.8}")).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

fn good_log() -> String {
    log_of(300, |_, _| {})
}

/// The good log with one line changed (line 1 is the header).
fn with_line(line: usize, change: impl Fn(&str) -> String) -> Vec<u8> {
    let text = good_log();
    let lines: Vec<String> =
        text.lines().enumerate().map(|(i, l)| if i + 1 == line { change(l) } else { l.to_string() }).collect();
    (lines.join("\n") + "\n").into_bytes()
}

/// The good log with one cell changed.
fn with_cell(line: usize, field: usize, cell: &str) -> Vec<u8> {
    with_line(line, |l| {
        let mut cells: Vec<&str> = l.split(',').collect();
        cells[field - 1] = cell;
        cells.join(",")
    })
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn utf16(text: &str, mark: bool) -> Vec<u8> {
    let mark: &[u8] = if mark { b"\xff\xfe" } else { b"" };
    mark.iter().copied().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
}

struct Case {
    name: &'static str,
    bad: Bad,
    bytes: Vec<u8>,
    says: &'static [&'static str],
}

/// name, which file, its bytes, what the message says.
fn case(name: &'static str, bad: Bad, bytes: impl Into<Vec<u8>>, says: &'static [&'static str]) -> Case {
    Case { name, bad, bytes: bytes.into(), says }
}

/// The robot, model or map with a piece replaced.
fn swapped(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

fn robot(from: &str, to: &str) -> String {
    swapped(ROBOT, from, to)
}

fn model(from: &str, to: &str) -> String {
    swapped(MODEL, from, to)
}

fn map(columns: &str) -> String {
    swapped(MAP, "{}", columns)
}

fn cases() -> Vec<Case> {
    [inputs::cases(), documents::cases(), programs::cases()].into_iter().flatten().collect()
}

fn folder_of(case: &Case) -> WorkFolder {
    let folder = WorkFolder::new();
    for bad in ALL {
        std::fs::write(folder.join(bad.file()), good_file(bad)).unwrap();
    }
    std::fs::write(folder.join(case.bad.file()), &case.bytes).unwrap();
    folder
}

fn good_file(bad: Bad) -> String {
    match bad {
        R => ROBOT.into(),
        D => MODEL.into(),
        L => good_log(),
        M => MAP.into(),
        G => documents::gaps(),
        C => documents::compensator(),
        P => programs::good(),
    }
}

/// A folder in which every file is good.
fn good_folder() -> WorkFolder {
    folder_of(&case("good", R, ROBOT, &[]))
}

/// What the library says to the bad file.
fn read(bad: Bad, folder: &Path) -> Result<(), Error> {
    let at = |b: Bad| folder.join(b.file());
    match bad {
        R => Robot::load(&at(R)).map(drop),
        D => Model::load(&at(D)).map(drop),
        L | M => {
            let robot = Robot::load(&at(R))?;
            let map = if bad == M { Some(ColumnMap::load(&at(M))?) } else { None };
            let log = Log::load_with(&at(L), &robot, map.as_ref())?;
            plausibility::check(&log, &robot).map(drop)
        }
        G => Gaps::load(&at(G), &Robot::load(&at(R))?).map(drop),
        C => Compensator::load(&at(C), &Robot::load(&at(R))?).map(drop),
        P => Program::load(&at(P), &Robot::load(&at(R))?).map(drop),
    }
}

#[test]
fn the_library_names_what_is_wrong_and_where() {
    let mut wrong = Vec::new();
    for case in cases() {
        let folder = folder_of(&case);
        match read(case.bad, folder.path()) {
            Ok(()) => wrong.push(format!("{}: accepted", case.name)),
            Err(e) => {
                let text = e.to_string();
                if lostmotion::cli::exit::code_of(&e) != 2 || text.lines().count() != 1 || text.chars().count() > 900 {
                    wrong.push(format!("{}: exit {}: {text}", case.name, lostmotion::cli::exit::code_of(&e)));
                }
                for part in case.says {
                    if !text.contains(part) {
                        wrong.push(format!("{}: no `{part}` in: {text}", case.name));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn the_suite_is_as_large_as_it_says_and_its_good_files_are_good() {
    let cases = cases();
    assert!(cases.len() >= 190, "{}", cases.len());
    let mut names: Vec<&str> = cases.iter().map(|c| c.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), cases.len(), "names differ");
    for bad in ALL {
        read(bad, good_folder().path()).unwrap();
    }
    // every command line that the suite runs succeeds where its files are good; only the arm's log is no circle and no static test
    for line in ALL
        .iter()
        .flat_map(|b| command_lines(*b))
        .filter(|l| !l.starts_with("assess circle") && !l.starts_with("identify static"))
    {
        let folder = good_folder();
        let out = support::run(folder.path(), line);
        assert!(out.succeeded(), "{line}: {}", out.stderr);
    }
}

/// The command lines that read such a file, in a folder that holds it.
fn command_lines(bad: Bad) -> &'static [&'static str] {
    match bad {
        R => &[
            "identify static --robot robot.yaml --log log.csv --output out.yaml",
            "identify path --robot robot.yaml --log log.csv --output out.yaml",
            "fit --robot robot.yaml --gaps gaps.yaml --output out.yaml",
            "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv",
            "assess circle --robot robot.yaml --nominal program.csv --before log.csv",
            "assess impact --robot robot.yaml --pose 1,2,3 --half-gap J1=0.1",
        ],
        L => &[
            "identify static --robot robot.yaml --log log.csv --output out.yaml",
            "identify path --robot robot.yaml --log log.csv --output out.yaml",
            "assess circle --robot robot.yaml --nominal program.csv --before log.csv",
        ],
        M => &[
            "identify static --robot robot.yaml --log log.csv --columns map.yaml --output out.yaml",
            "identify path --robot robot.yaml --log log.csv --columns map.yaml --output out.yaml",
            "assess circle --robot robot.yaml --nominal program.csv --before log.csv --columns map.yaml",
        ],
        D => &[
            "simulate --model model.yaml --input log.csv --output out.csv",
            "rewrite --model model.yaml program.csv --output out.csv",
            "assess impact --model model.yaml --pose 1,2,3",
        ],
        G => &[
            "fit --robot robot.yaml --gaps gaps.yaml --output out.yaml",
            "identify path --robot robot.yaml --log log.csv --known gaps.yaml --output out.yaml",
        ],
        C => &[
            "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv",
            "rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run",
        ],
        P => &[
            "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv",
            "rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run",
            "simulate --model model.yaml --input program.csv --output out.csv",
            "assess circle --robot robot.yaml --nominal program.csv --before log.csv",
            "assess impact --model model.yaml --program program.csv",
            "fit --robot robot.yaml --gaps gaps.yaml --form poses --program program.csv --speed-mm-s 5 --output out.yaml",
        ],
    }
}

#[test]
fn the_command_line_refuses_in_one_line_and_leaves_nothing() {
    let mut wrong = Vec::new();
    for bad in ALL {
        for line in command_lines(bad) {
            for case in cases().iter().filter(|c| c.bad == bad) {
                wrong.extend(run(case, line).into_iter().map(|w| format!("{}: {line}: {w}", case.name)));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// What is wrong with the answer of a command line to a case.
fn run(case: &Case, line: &str) -> Vec<String> {
    let folder = folder_of(case);
    let before = listing(folder.path());
    let out = support::run(folder.path(), line);
    let text = out.stderr;
    let mut wrong = Vec::new();
    if out.code != Some(2) || text.lines().count() != 1 || !out.stdout.is_empty() {
        wrong.push(format!("{:?}, {} bytes on stdout, says: {text}", out.code, out.stdout.len()));
    }
    wrong.extend(case.says.iter().filter(|p| !text.contains(**p)).map(|p| format!("no `{p}` in: {text}")));
    if listing(folder.path()) != before {
        wrong.push(format!("left {:?}", listing(folder.path())));
    }
    wrong
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}
