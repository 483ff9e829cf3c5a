//! Programs that cannot be used, for every command that reads one.

use super::{Case, P, ROBOT, case, good_folder, gzip, listing, utf16};
use crate::support::{self, WorkFolder};
use lostmotion::program::Program;
use lostmotion::robot::Robot;

/// An arc about the first joint, there and back: 0.5 deg a row, lines 2 to 302.
pub fn good() -> String {
    let mut text = String::from("t_s,J1_deg,J2_deg,Z_mm\n");
    for i in 0..=300 {
        let j1 = 40.0 - 0.5 * f64::from((i - 150_i32).abs());
        text.push_str(&format!("{:.2},{j1:.4},30.0000,5.0000\n", f64::from(i) * 0.5));
    }
    text
}

fn with_line(line: usize, change: impl Fn(&str) -> String) -> String {
    let text = good();
    let lines: Vec<String> =
        text.lines().enumerate().map(|(i, l)| if i + 1 == line { change(l) } else { l.to_string() }).collect();
    lines.join("\n") + "\n"
}

fn with_cell(line: usize, field: usize, cell: &str) -> String {
    with_line(line, |l| {
        let mut cells: Vec<&str> = l.split(',').collect();
        cells[field - 1] = cell;
        cells.join(",")
    })
}

fn header(to: &str) -> String {
    good().replacen("t_s,J1_deg,J2_deg,Z_mm", to, 1)
}

#[rustfmt::skip]
pub fn cases() -> Vec<Case> {
    let good = good();
    vec![
        case("program empty", P, "", &["program.csv", "empty"]),
        case("program of blanks", P, "\r\n \r\n", &["program.csv", "no header"]),
        case("program of comments", P, "# a\n# b\n", &["program.csv", "no header"]),
        case("program header only", P, "t_s,J1_deg,J2_deg,Z_mm\n", &["program.csv", "no rows"]),
        case("program without header", P, "0,1,2,3\n1,1,2,3\n", &["program.csv:1", "a header row"]),
        case("program in UTF-16", P, utf16(&good, true), &["program.csv", "UTF-16"]),
        case("program in UTF-16 without mark", P, utf16(&good, false), &["program.csv", "no text"]),
        case("program is a picture", P, b"\x89PNG\x00\x00 and so on".to_vec(), &["program.csv", "no text"]),
        case("program cut short", P, &good.as_bytes()[..good.len() - 10], &["program.csv:302", "cells"]),
        case("program with semicolons", P, good.replace(',', ";"), &["program.csv:1", "semicolons"]),
        case("program with semicolons and decimal commas", P, good.replace(',', ";").replace('.', ","), &["program.csv:1", "semicolons"]),
        case("program with tabs", P, good.replace(',', "\t"), &["program.csv:1", "tabs"]),
        case("program with decimal commas", P, good.replace('.', ","), &["program.csv:2", "decimal points"]),
        case("program with a quoted decimal comma", P, with_cell(9, 2, "\"1,5\""), &["program.csv:9:2", "decimal comma"]),
        case("program missing an axis", P, header("t_s,J1_deg,other,Z_mm"), &["program.csv:1", "no column j2_deg"]),
        case("program of another robot", P, header("t_s,a1_deg,a2_deg,a3_deg"), &["program.csv:1", "j1_deg, j2_deg, z_mm"]),
        case("program in radians", P, header("t_s,J1_rad,J2_deg,Z_mm"), &["program.csv:1:2", "J1_rad", "in deg"]),
        case("program with a slide in degrees", P, header("t_s,J1_deg,J2_deg,Z_deg"), &["program.csv:1:4", "Z_deg", "in mm"]),
        case("program with a column twice", P, header("t_s,J1_deg,j1_DEG,Z_mm"), &["program.csv:1:3", "second column"]),
        case("program with the time twice", P, header("t_s,J1_deg,J2_deg,T_S"), &["program.csv:1:4", "second column"]),
        case("program row short", P, with_line(7, |l| l.rsplit_once(',').unwrap().0.into()), &["program.csv:7", "3 cells", "4 cells"]),
        case("program row long", P, with_line(7, |l| format!("{l},1")), &["program.csv:7", "5 cells"]),
        case("program cell of text", P, with_cell(9, 3, "fast"), &["program.csv:9:3", "`fast`", "J2_deg"]),
        case("program cell NaN", P, with_cell(9, 2, "NaN"), &["program.csv:9:2", "`NaN`"]),
        case("program cell infinite", P, with_cell(9, 4, "-inf"), &["program.csv:9:4", "`-inf`"]),
        case("program cell beyond floats", P, with_cell(9, 2, "1e400"), &["program.csv:9:2", "`1e400`"]),
        case("program cell hexadecimal", P, with_cell(9, 2, "0x1F"), &["program.csv:9:2", "`0x1F`"]),
        case("program cell empty", P, with_cell(9, 2, ""), &["program.csv:9:2", "empty cell"]),
        case("program time empty", P, with_cell(9, 1, " "), &["program.csv:9:1", "empty cell"]),
        case("program time twice", P, with_cell(9, 1, "3.00"), &["program.csv:9:1", "after 3 s", "strictly"]),
        case("program time back", P, with_cell(9, 1, "0.01"), &["program.csv:9:1", "after 3 s"]),
        case("program quote not closed", P, with_cell(9, 2, "\"1"), &["program.csv:9:2", "quote"]),
        case("program line counts comments", P, good.replacen('\n', "\n# one\r\n\n", 1).replace("\n1.00,", "\n1.00,x"), &["program.csv:6:2", "`x"]),
    ]
}

#[test]
fn a_packed_program_is_refused_where_its_text_stays_and_read_where_only_numbers_count() {
    let folder = good_folder();
    std::fs::write(folder.join("program.csv.gz"), gzip(good().as_bytes())).unwrap();
    let before = listing(folder.path());
    let run = |line: &str| support::run(folder.path(), line);
    let out = run("rewrite --robot robot.yaml --compensator comp.yaml program.csv.gz --output out.csv");
    let says = out.stderr;
    assert!(out.code == Some(2) && says.contains("program.csv.gz: found a gzip file"), "{says}");
    assert_eq!((out.stdout.len(), says.lines().count(), listing(folder.path())), (0, 1, before));
    for line in ["simulate --model model.yaml --input", "assess impact --json --model model.yaml --program"] {
        let plain = run(&format!("{line} program.csv"));
        let packed = run(&format!("{line} program.csv.gz"));
        assert!(plain.succeeded() && packed.succeeded(), "{}", packed.stderr);
        let text = String::from_utf8(packed.stdout).unwrap().replace("program.csv.gz", "program.csv");
        assert_eq!(text.into_bytes(), plain.stdout);
    }
}

#[test]
fn a_log_is_no_program_and_says_so() {
    let folder = good_folder();
    for line in [
        "rewrite --robot robot.yaml --compensator comp.yaml log.csv --output out.csv",
        "assess circle --robot robot.yaml --nominal log.csv --before log.csv",
        "assess impact --model model.yaml --program log.csv",
    ] {
        let out = support::run(folder.path(), line);
        let says = out.stderr;
        assert!(out.code == Some(2) && out.stdout.is_empty() && says.contains("log.csv:1:2"), "{line}: {says}");
        assert!(says.contains("measurement log") && says.lines().count() == 1, "{says}");
    }
}

/// Programs that a careful eye calls odd and that are read all the same, with the numbers and lines of the plain one.
#[test]
fn line_endings_marks_comments_and_quotes_change_no_number() {
    let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
    let folder = WorkFolder::new();
    let path = folder.join("p");
    let load = |text: &[u8]| {
        std::fs::write(&path, text).unwrap();
        Program::load(&path, &robot).unwrap()
    };
    let plain = load(good().as_bytes());
    assert_eq!((plain.len(), plain.line(0), plain.line(300)), (301, Some(2), Some(302)));
    let text = good();
    for (odd, last_line) in [
        (text.replace('\n', "\r\n"), 302),
        (text.replace('\n', "\r"), 302),
        (format!("\u{feff}{text}"), 302),
        (format!("# made by hand\n\n{text}"), 304),
        (text.trim_end().to_string(), 302),
        (text.replacen("40.0000", "\"40.0000\"", 1), 302),
        (text.replacen("40.0000", " +4.0E1 ", 1), 302),
        (text.replace("\n3.00", "\n# half way\n3.00"), 303),
        (text.to_uppercase(), 302),
    ] {
        let found = load(odd.as_bytes());
        assert_eq!((&found.q, &found.t_s), (&plain.q, &plain.t_s), "{}", &odd[..60]);
        assert_eq!(found.line(300), Some(last_line), "{}", &odd[..60]);
    }
    let packed = load(&gzip(text.as_bytes()));
    assert_eq!(packed.q, plain.q);
}
