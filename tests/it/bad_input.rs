//! Input that cannot be used: each case is a folder of files, one of which is wrong, and what the message must say.
//!
//! A case runs twice: through the library (the reading layer alone), and through the built command that reads such a file.
//! Asked of both: exit code 2; one line, which names the file, and line and field where there are some; standard output empty;
//! no output file and no leftover beside it.

mod accepted;
mod documents;
mod outputs;
mod programs;
mod usage;

use assert_cmd::Command;
use lostmotion::compensator::Compensator;
use lostmotion::error::Error;
use lostmotion::gaps::Gaps;
use lostmotion::log::{ColumnMap, Log, hygiene};
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
    [first_cases(), documents::cases(), programs::cases()].into_iter().flatten().collect()
}

#[rustfmt::skip]
fn first_cases() -> Vec<Case> {
    let good = good_log();
    let tenth = &good.as_bytes()[..good.len() / 10];
    let packed = gzip(good.as_bytes());
    let effects = "  - {effect: backlash, joint: J1, half_gap_deg: 0.003}";
    vec![
        // robot: the file as text
        case("robot empty", R, "", &["robot.yaml", "empty"]),
        case("robot of blanks", R, "\n  \n", &["robot.yaml", "empty"]),
        case("robot no YAML", R, "{joints: [", &["robot.yaml:2"]),
        case("robot in UTF-16", R, utf16(ROBOT, true), &["robot.yaml", "UTF-16"]),
        case("robot not UTF-8", R, b"schema: \xff\xe9\n".to_vec(), &["robot.yaml:1", "0xFF", "UTF-8"]),
        case("robot is a list", R, "- 1\n- 2\n", &["robot.yaml", "robot file"]),
        case("a model for a robot", R, MODEL, &["robot.yaml:1", "lostmotion/model/1", "lostmotion/robot/1"]),
        case("robot of another schema", R, robot("robot/1", "robot/9"), &["robot.yaml:1", "robot/9"]),
        case("robot without schema", R, robot("schema: lostmotion/robot/1\n", ""), &["robot.yaml", "schema"]),
        case("robot without joints", R, "schema: lostmotion/robot/1\njoints: []\n", &["robot.yaml:2", "no joints"]),
        case("robot with an unknown key", R, robot("name: arm", "nmae: arm"), &["robot.yaml", "nmae"]),
        case("joint with an unknown key", R, robot("a_mm: 400", "a_m: 0.4"), &["robot.yaml", "a_m"]),
        case("base with an unknown key", R, ROBOT.to_string() + "base: {xyz_m: [0, 0, 0]}\n", &["robot.yaml:7", "xyz_m"]),
        // robot: its numbers
        case("limits reversed", R, robot("[-170, 170]", "[170, -170]"), &["robot.yaml:4", "limits", "J1"]),
        case("limits in mm of a revolute joint", R, robot("limits_deg: [-170, 170]", "limits_mm: [-170, 170]"), &["robot.yaml:4", "wrong unit"]),
        case("limits not numbers", R, robot("[-170, 170]", "[a, b]"), &["robot.yaml", "expected"]),
        case("limits NaN", R, robot("[-170, 170]", "[-170, .nan]"), &["robot.yaml:4", "limits"]),
        case("direction 0", R, robot("a_mm: 400", "a_mm: 400, direction: 0"), &["robot.yaml:4", "direction 0"]),
        case("direction a half", R, robot("a_mm: 400", "a_mm: 400, direction: 0.5"), &["robot.yaml:4", "1 or -1"]),
        case("length NaN", R, robot("a_mm: 400", "a_mm: .nan"), &["robot.yaml:4", "a_mm NaN"]),
        case("length infinite", R, robot("a_mm: 400", "a_mm: .inf"), &["robot.yaml:4", "a_mm inf"]),
        case("length as text", R, robot("a_mm: 400", "a_mm: long"), &["robot.yaml"]),
        case("angle NaN", R, robot("alpha_deg: 60", "alpha_deg: .nan"), &["robot.yaml:5", "alpha_deg"]),
        case("tool NaN", R, ROBOT.to_string() + "tool: {xyz_mm: [0, .nan, 0]}\n", &["robot.yaml:7", "xyz_mm NaN"]),
        case("tool of two numbers", R, ROBOT.to_string() + "tool: {xyz_mm: [0, 1]}\n", &["robot.yaml:7"]),
        case("speed 0", R, robot("max_speed_deg_s: 100", "max_speed_deg_s: 0"), &["robot.yaml:4", "max_speed 0"]),
        case("speed negative", R, robot("max_speed_deg_s: 100", "max_speed_deg_s: -1"), &["robot.yaml:4", "max_speed"]),
        case("gravity infinite", R, ROBOT.to_string() + "gravity_m_s2: [0, 0, -.inf]\n", &["robot.yaml:7", "gravity"]),
        case("links too few", R, ROBOT.to_string() + "links: [{mass_kg: 1, com_mm: [0, 0, 0]}]\n", &["robot.yaml:7", "1 links for 3 joints"]),
        // robot: its joints
        case("unknown kind", R, robot("kind: prismatic", "kind: sliding"), &["robot.yaml:6", "sliding"]),
        case("unknown convention", R, robot("name: arm", "convention: dh-classic"), &["robot.yaml:2", "dh-classic"]),
        case("a joint twice", R, robot("name: J2", "name: j1"), &["robot.yaml:5", "second joint", "j1"]),
        case("a joint without name", R, robot("name: J2", "name: ''"), &["robot.yaml", "joint name"]),
        case("follows a missing joint", R, robot("alpha_deg: 60", "alpha_deg: 60, follows: {joint: J9, ratio: 1}"), &["robot.yaml:5", "J9"]),
        case("follows itself", R, robot("alpha_deg: 60", "follows: {joint: J2, ratio: 1}"), &["robot.yaml:5", "J2 follows"]),
        case("follows another kind", R, robot("alpha_deg: 60", "follows: {joint: Z, ratio: 1}"), &["robot.yaml:5", "same kind"]),
        case("follows with ratio NaN", R, robot("alpha_deg: 60", "follows: {joint: J1, ratio: .nan}"), &["robot.yaml:5", "ratio"]),
        // model
        case("model empty", D, "", &["model.yaml", "empty"]),
        case("a robot for a model", D, ROBOT, &["model.yaml:1", "lostmotion/robot/1", "lostmotion/model/1"]),
        case("model of another schema", D, model("model/1", "robot/1"), &["model.yaml:1", "robot/1"]),
        case("model with an unknown key", D, model("effects:", "efects:"), &["model.yaml", "efects"]),
        case("model with a missing robot", D, model("robot.yaml", "no.yaml"), &["no.yaml", "cannot open"]),
        case("model with half a robot inline", D, model("robot: robot.yaml", "robot: {schema: lostmotion/robot/1}"), &["model.yaml:2", "joints"]),
        case("registration not finite", D, model("effects:", "registration: {xyz_mm: [0, .inf, 0]}\neffects:"), &["model.yaml:3", "finite"]),
        case("registration of text", D, model("effects:", "registration: near\neffects:"), &["model.yaml:3"]),
        case("unknown effect", D, model("backlash", "backlsh"), &["model.yaml:4", "backlsh", "stiction"]),
        case("effect without name", D, model("effect: backlash, ", ""), &["model.yaml", "effect"]),
        case("effect without joint", D, model("joint: J1, ", ""), &["model.yaml:4", "joint"]),
        case("effect on an unknown joint", D, model("J1", "A7"), &["model.yaml:4", "A7", "J1, J2, Z"]),
        case("effect that is no mapping", D, model(effects, "  - backlash"), &["model.yaml", "backlash"]),
        case("gap negative", D, model("0.003", "-0.003"), &["model.yaml:4", "-0.003"]),
        case("gap NaN", D, model("0.003", ".nan"), &["model.yaml:4", "half_gap_deg"]),
        case("gap as text", D, model("0.003", "small"), &["model.yaml:4", "small"]),
        case("gap missing", D, model(", half_gap_deg: 0.003", ""), &["model.yaml:4", "half_gap_deg"]),
        case("gap in the other unit", D, model("half_gap_deg", "half_gap_mm"), &["model.yaml:4", "half_gap"]),
        case("effect with an unknown key", D, model("0.003", "0.003, colour: red"), &["model.yaml:4", "colour"]),
        case("two decays", D, model(effects, "  - {effect: stiction, joint: J1, spike_deg: 0.003, decay_s: 1, decay_deg: 1}"), &["model.yaml:4", "decay"]),
        case("no decay", D, model(effects, "  - {effect: stiction, joint: J1, spike_deg: 0.003}"), &["model.yaml:4", "decay"]),
        case("decay 0", D, model(effects, "  - {effect: stiction, joint: J1, spike_deg: 0.003, decay_s: 0}"), &["model.yaml:4", "decay"]),
        case("knots not rising", D, model(effects, "  - {effect: backlash_position, joint: J1, knots: [[5, 0.1], [5, 0.2]]}"), &["model.yaml:4", "knots"]),
        case("knots of one number", D, model(effects, "  - {effect: backlash_position, joint: J1, knots: [1, 2]}"), &["model.yaml:4", "knots"]),
        case("knots with a gap below 0", D, model(effects, "  - {effect: backlash_position, joint: J1, knots: [[0, 0.1], [5, -0.2]]}"), &["model.yaml:4", "knots"]),
        case("preload of an unknown joint", D, model("effects:", "preload: {A1: 1}\neffects:"), &["model.yaml:3", "A1"]),
        case("preload of 2", D, model("effects:", "preload: {J1: 2}\neffects:"), &["model.yaml:3", "-1, 0 or +1"]),
        // log: the file
        case("log empty", L, "", &["log.csv", "empty"]),
        case("log of blanks", L, "\r\n\r\n", &["log.csv", "empty"]),
        case("log of comments", L, "# a\n# b\n", &["log.csv", "comments"]),
        case("log header only", L, HEAD, &["log.csv", "no rows"]),
        case("log without header", L, "0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n", &["log.csv:1", "row of numbers"]),
        case("log in UTF-16", L, utf16(&good, true), &["log.csv:1", "UTF-16"]),
        case("log in UTF-16 without mark", L, utf16(&good, false), &["log.csv:1", "UTF-16"]),
        case("log with a header not UTF-8", L, [b"t_s,cmd_J1_deg,cmd_J2_deg,cmd_Z_mm,\xe9\n", tenth].concat(), &["log.csv:1", "UTF-8"]),
        case("log is a workbook", L, b"PK\x03\x04 and so on".to_vec(), &["log.csv", "workbook"]),
        case("log cut short", L, &good.as_bytes()[..good.len() - 30], &["log.csv:301", "cut short", "7 fields"]),
        case("log gzip cut short", L, &packed[..packed.len() / 2], &["log.csv", "cut short"]),
        case("log gzip damaged", L, b"\x1f\x8b\x08\x00nothing of the sort".to_vec(), &["log.csv", "gzip"]),
        case("log with semicolons", L, good.replace(',', ";"), &["log.csv:1", "separated by `;`", "column map"]),
        case("log with tabs", L, good.replace(',', "\t"), &["log.csv:1", "separated by `tab`", "column map"]),
        // log: its header
        case("log missing a command", L, good.replacen("cmd_J2_deg", "other", 1), &["log.csv:1", "cmd_J2_deg", "J1, J2, Z"]),
        case("log missing a coordinate", L, good.replacen("y_mm", "other", 1), &["log.csv:1", "y_mm"]),
        case("log with an unknown joint", L, good.replacen("x_mm", "cmd_B1_deg", 1), &["log.csv:1:5", "cmd_B1_deg", "J1, J2, Z"]),
        case("log with an unknown encoder", L, good.replacen("x_mm", "enc_B1_deg", 1), &["log.csv:1:5", "enc_B1_deg"]),
        case("log with a joint in radians by name", L, good.replacen("cmd_J2_deg", "cmd_J2_rad", 1), &["log.csv:1:3", "cmd_J2_rad", "cmd_J2_deg"]),
        case("log with a slide in degrees", L, good.replacen("cmd_Z_mm", "cmd_Z_deg", 1), &["log.csv:1:4", "cmd_Z_mm"]),
        case("log with a column twice", L, good.replacen("x_mm", "CMD_j1_DEG", 1), &["log.csv:1:5", "second column", "cmd_J1_deg"]),
        case("log with the time twice", L, good.replacen("x_mm", "t_s", 1), &["log.csv:1:5", "second column", "t_s"]),
        case("log of another robot", L, good.replace("J1", "A1").replace("J2", "A2"), &["log.csv:1:2", "cmd_A1_deg"]),
        case("log with a third reflector and no second", L, good.replacen("x_mm,y_mm,z_mm", "x3_mm,y3_mm,z3_mm", 1), &["log.csv:1", "x2_mm"]),
        // log: its rows
        case("log row short", L, with_line(7, |l| l.rsplit_once(',').unwrap().0.into()), &["log.csv:7", "6 fields", "7 fields"]),
        case("log row long", L, with_line(7, |l| format!("{l},1")), &["log.csv:7", "8 fields"]),
        case("log cell of text", L, with_cell(9, 3, "fast"), &["log.csv:9:3", "`fast`", "cmd_J2_deg"]),
        case("log cell NaN", L, with_cell(9, 2, "NaN"), &["log.csv:9:2", "`NaN`"]),
        case("log cell infinite", L, with_cell(9, 5, "-inf"), &["log.csv:9:5", "`-inf`", "x_mm"]),
        case("log cell beyond floats", L, with_cell(9, 2, "1e400"), &["log.csv:9:2", "`1e400`"]),
        case("log cell beyond any joint", L, with_cell(9, 2, "1e15"), &["log.csv:9:2", "10,000,000"]),
        case("log cell beyond integers", L, with_cell(9, 2, "123456789012345678901234567890"), &["log.csv:9:2", "10,000,000"]),
        case("log cell hexadecimal", L, with_cell(9, 2, "0x1F"), &["log.csv:9:2", "`0x1F`"]),
        case("log cell quoted text", L, with_cell(9, 2, "\"one\""), &["log.csv:9:2", "`one`"]),
        case("log command empty", L, with_cell(9, 2, ""), &["log.csv:9:2", "empty cell"]),
        case("log time empty", L, with_cell(9, 1, " "), &["log.csv:9:1", "empty cell"]),
        case("log time twice", L, with_cell(9, 1, "0.12"), &["log.csv:9:1", "twice", "strictly increase"]),
        case("log time back", L, with_cell(9, 1, "0.01"), &["log.csv:9:1", "after 0.12 s"]),
        case("log decimal commas", L, good.replace('.', ","), &["log.csv:2", "fields"]),
        case("log trigger 2", L, "t_s,cmd_J1_deg,cmd_J2_deg,cmd_Z_mm,trigger\n0,1,2,3,0\n1,1,2,3,2\n", &["log.csv:3:5", "1, -1 or 0"]),
        case("log cycle a half", L, "t_s,cmd_J1_deg,cmd_J2_deg,cmd_Z_mm,cycle\n0,1,2,3,0.5\n", &["log.csv:2:5", "whole number"]),
        case("log cycle negative", L, "t_s,cmd_J1_deg,cmd_J2_deg,cmd_Z_mm,cycle\n0,1,2,3,-1\n", &["log.csv:2:5", "whole number"]),
        // log: units, axes, clocks
        case("radians as degrees", L, log_of(300, |_, r| { r[1] = r[1].to_radians(); r[2] = r[2].to_radians() }), &["log.csv", "radians"]),
        case("one joint in radians", L, log_of(300, |_, r| r[2] = r[2].to_radians()), &["log.csv", "J2 are in radians"]),
        case("metres as millimetres", L, log_of(300, |_, r| for v in &mut r[4..] { *v *= 1e-3 }), &["log.csv", "in metres"]),
        case("micrometres as millimetres", L, log_of(300, |_, r| for v in &mut r[4..] { *v *= 1e3 }), &["log.csv", "micrometres"]),
        case("inches as millimetres", L, log_of(300, |_, r| for v in &mut r[4..] { *v /= 25.4 }), &["log.csv", "inches"]),
        case("slide in metres", L, log_of(300, |_, r| r[3] *= 1e-3), &["log.csv", "in metres"]),
        case("TCP axis of the wrong sign", L, log_of(300, |_, r| r[5] = -r[5]), &["log.csv", "mirrored"]),
        case("TCP axes swapped", L, log_of(300, |_, r| r.swap(4, 6)), &["log.csv", "mirrored"]),
        case("commands swapped", L, log_of(300, |_, r| r.swap(1, 2)), &["log.csv", "J1 and J2 are swapped"]),
        case("command of the wrong sign", L, log_of(300, |_, r| r[2] = -r[2]), &["log.csv", "J2", "wrong sign"]),
        // column map
        case("map empty", M, "", &["map.yaml", "empty"]),
        case("map of another schema", M, "schema: lostmotion/robot/1\n", &["map.yaml:1", "robot/1"]),
        case("map with an unknown key", M, MAP.to_string() + "seperator: ';'\n", &["map.yaml", "seperator"]),
        case("map with a long separator", M, MAP.to_string() + "separator: '::'\n", &["map.yaml:3", "::"]),
        case("map with commas for both", M, MAP.to_string() + "decimal: ','\n", &["map.yaml:3", "comma"]),
        case("map with an unknown unit", M, map("{x_mm: {to: x_mm, unit: furlong}}"), &["map.yaml:2", "furlong", "rad"]),
        case("map with a unit of another kind", M, map("{x_mm: {to: x_mm, unit: rad}}"), &["map.yaml", "rad", "mm"]),
        case("map with an unknown target", M, map("{x_mm: cmd_A9_deg}"), &["map.yaml", "cmd_A9_deg", "cmd_J1_deg"]),
        case("map without target", M, map("{x_mm: {unit: m}}"), &["map.yaml:2", "no `to`"]),
        case("map with sign 2", M, map("{x_mm: {to: x_mm, sign: 2}}"), &["map.yaml:2", "1 or -1"]),
        case("map with scale NaN", M, map("{x_mm: {to: x_mm, scale: .nan}}"), &["map.yaml:2", "above 0"]),
        case("map naming a column that is not there", M, map("{Zeit: t_s}"), &["log.csv:1", "Zeit", "map.yaml"]),
        case("map of two columns to one", M, map("{x_mm: cmd_J1_deg}"), &["log.csv:1:5", "second column"]),
    ]
}

fn folder_of(case: &Case) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for bad in ALL {
        std::fs::write(folder.path().join(bad.file()), good_file(bad)).unwrap();
    }
    std::fs::write(folder.path().join(case.bad.file()), &case.bytes).unwrap();
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
fn good_folder() -> tempfile::TempDir {
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
            hygiene::check(&log, &robot).map(drop)
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
                if e.exit_code() != 2 || text.lines().count() != 1 || text.chars().count() > 900 {
                    wrong.push(format!("{}: exit {}: {text}", case.name, e.exit_code()));
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
        let out = lostmotion().current_dir(folder.path()).args(line.split_whitespace()).output().unwrap();
        assert!(out.status.success(), "{line}: {}", String::from_utf8_lossy(&out.stderr));
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

fn lostmotion() -> Command {
    Command::cargo_bin("lostmotion").unwrap()
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
    let out = lostmotion().current_dir(folder.path()).args(line.split_whitespace()).output().unwrap();
    let text = String::from_utf8_lossy(&out.stderr).into_owned();
    let mut wrong = Vec::new();
    if out.status.code() != Some(2) || text.lines().count() != 1 || !out.stdout.is_empty() {
        wrong.push(format!("{:?}, {} bytes on stdout, says: {text}", out.status, out.stdout.len()));
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

/// Files that are not there, are folders, or have names that are hard to say.
#[test]
fn paths_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (path, says) in [
        ("none.yaml", "cannot open"),
        (".", "a folder"),
        ("none/robot.yaml", "cannot open"),
        ("with blanks.yaml", "cannot open"),
    ] {
        let e = Robot::load(&folder.path().join(path)).unwrap_err();
        assert_eq!(e.exit_code(), 2);
        assert!(e.to_string().contains(says) && e.to_string().contains(path), "{e}");
    }
}

#[cfg(unix)]
#[test]
fn a_name_that_is_not_utf8_is_read_and_shown() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(std::ffi::OsStr::from_bytes(b"robot \xff.yaml"));
    let missing = Robot::load(&path).unwrap_err().to_string();
    assert!(missing.contains("robot \u{fffd}.yaml"), "{missing}");
    std::fs::write(&path, ROBOT).unwrap();
    assert_eq!(Robot::load(&path).unwrap().dof(), 3);
}

#[cfg(unix)]
#[test]
fn an_output_that_cannot_be_written_leaves_what_was_there() {
    use lostmotion::io::output::write_whole;
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("kept.yaml");
    std::fs::write(&kept, "old").unwrap();
    std::fs::set_permissions(&kept, std::fs::Permissions::from_mode(0o444)).unwrap();
    let e = write_whole(&kept, b"new").unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("kept.yaml: cannot write"), "{e}");
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), "old");
    let e = write_whole(folder.path(), b"new").unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("a folder"), "{e}");
    let e = write_whole(&folder.path().join("none/out.yaml"), b"new").unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("out.yaml: cannot write"), "{e}");
    assert_eq!(listing(folder.path()), [kept], "no leftovers");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_no_success() {
    let e = lostmotion::io::output::write_whole(Path::new("/dev/full"), &[b'x'; 4096]).unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("/dev/full: cannot write"), "{e}");
    // standard output on a full disk
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("lostmotion"));
    let out = command.args(["completions", "bash"]).stdout(full).output().unwrap();
    assert_eq!(out.status.code(), Some(2), "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(String::from_utf8_lossy(&out.stderr).lines().count(), 1);
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_quiet_and_no_failure() {
    use std::process::{Command as Process, Stdio};
    let mut command = Process::new(assert_cmd::cargo::cargo_bin("lostmotion"));
    let mut child = command.args(["completions", "zsh"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let out = child.wait_with_output().unwrap();
    assert!(out.status.success() && out.stderr.is_empty(), "{:?} {}", out.status, String::from_utf8_lossy(&out.stderr));
}

#[test]
fn an_unknown_flag_is_bad_usage() {
    let out = lostmotion().args(["rewrite", "--no-such-flag"]).output().unwrap();
    assert_eq!(out.status.code(), Some(2));
    assert!(out.stdout.is_empty());
}

/// Whatever the bytes, a reader answers; a log that is accepted is whole and finite.
fn answer(bad: Bad, bytes: Vec<u8>) {
    use lostmotion::io::input::{Input, decode};
    let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
    let text = || decode("file", bytes.clone());
    match bad {
        R | D => drop(text().and_then(|t| Robot::parse("robot.yaml", &t))),
        M => drop(text().and_then(|t| ColumnMap::parse("map.yaml", &t))),
        G => drop(text().and_then(|t| Gaps::parse("gaps.yaml", &t, &robot))),
        C => drop(text().and_then(|t| Compensator::parse("comp.yaml", &t, &robot))),
        P => {
            let input = Input { name: "program.csv".into(), bytes, sha256: String::new() };
            let Ok(program) = Program::parse(input, &robot) else { return };
            assert!(program.q.iter().all(|q| q.len() == program.len() && q.iter().all(|v| v.is_finite())));
            assert!((0..program.len()).all(|i| program.line(i).is_some()));
        }
        L => {
            let Ok(log) = Log::parse(Input { name: "log.csv".into(), bytes, sha256: String::new() }, &robot) else {
                return;
            };
            assert!(log.cmd.iter().all(|c| c.len() == log.len() && c.iter().all(|v| v.is_finite())));
            assert!(log.tcp_m.is_empty() || log.tcp_m.len() == log.len());
            assert!(log.tcp_m.iter().flatten().all(|p| p.iter().all(|v| v.is_finite())));
            drop(hygiene::check(&log, &robot));
        }
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..200)) {
        for bad in ALL {
            answer(bad, bytes.clone());
        }
    }

    #[test]
    fn no_damage_to_a_good_file_makes_a_reader_panic(
        hits in proptest::collection::vec((0.0..1.0_f64, "[-0-9.,;:#\"\\[\\]{}&*!|>%@\n\r\t eNn\u{0}\u{e9}]{0,4}"), 1..6),
        cut in 0.0..1.5_f64,
    ) {
        let map = map("{x_mm: {to: x_mm, unit: m, sign: -1, scale: 2}}");
        for (bad, good) in [(R, ROBOT.to_string()), (M, map), (L, log_of(20, |_, _| {})), (G, documents::gaps()),
            (C, documents::compensator()), (P, programs::good())]
        {
            let mut text: Vec<char> = good.chars().collect();
            for (at, new) in &hits {
                let at = (at * text.len() as f64) as usize;
                let end = (at + 2).min(text.len());
                text.splice(at..end, new.chars());
            }
            text.truncate((cut * text.len() as f64) as usize);
            answer(bad, text.into_iter().collect::<String>().into_bytes());
        }
    }
}
