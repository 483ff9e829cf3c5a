//! Logs as a spreadsheet saves them: the same log as its CSV (`tests/oracle/workbook.py` wrote both).

use crate::support::{self, WorkFolder, bundled};
use lostmotion::log::{ColumnMap, Log};
use lostmotion::robot::Robot;
use std::path::PathBuf;

fn data(file: &str) -> PathBuf {
    bundled("tests/data/workbook").join(file)
}

fn gantry() -> PathBuf {
    bundled("configs/gantry-xyz-ballscrew.yaml")
}

fn load(file: &str, map: Option<&str>) -> Result<Log, String> {
    let robot = Robot::load(&gantry()).unwrap();
    let map = map.map(|text| ColumnMap::parse("map.yaml", &format!("schema: lostmotion/columns/1\n{text}")).unwrap());
    Log::load_with(&data(file), &robot, map.as_ref()).map_err(|e| e.to_string())
}

#[test]
fn a_sheet_is_the_log_that_its_csv_is() {
    let csv = load("log.csv", None).unwrap();
    for (file, first) in [("log.xlsx", 4), ("log.ods", 2)] {
        let log = load(file, None).unwrap();
        assert_eq!((&log.t_s, &log.cmd, &log.tcp_m), (&csv.t_s, &csv.cmd, &csv.tcp_m), "{file}");
        assert_eq!(log.cmd_decimals, csv.cmd_decimals, "{file}");
        assert_eq!(log.line[0], first, "{file}: the row of the sheet");
    }
}

#[test]
fn dates_of_cells_are_times_and_a_map_for_other_texts_does_not_matter() {
    let log = load("stamps.xlsx", Some("separator: \";\"\ndecimal: \",\"\ncolumns: {t_s: {to: t_s, unit: iso8601}}"))
        .unwrap();
    assert_eq!(log.t_s, [0.0, 0.5, 1.25], "across midnight and the end of a month");
    assert_eq!(log.cmd[0][2], 0.1020625);
}

#[test]
fn a_cell_that_is_no_number_is_named_by_its_row_and_column() {
    let error = load("text.xlsx", None).unwrap_err();
    assert!(error.contains("text.xlsx:7:2") && error.contains("12.5 mm"), "{error}");
    let error = load("blank.xlsx", None).unwrap_err();
    assert!(error.contains("a workbook without cells"), "{error}");
}

#[test]
fn a_damaged_workbook_is_refused_in_words() {
    let whole = std::fs::read(data("log.xlsx")).unwrap();
    let folder = WorkFolder::new();
    let path = folder.join("cut.xlsx");
    let mut cases: Vec<Vec<u8>> = [10, 100, whole.len() / 2, whole.len() - 30].map(|n| whole[..n].to_vec()).into();
    // every kind of damage that a flipped byte is, spread over the file
    cases.extend((0..60).map(|k| {
        let mut bytes = whole.clone();
        let at = 4 + k * (bytes.len() - 4) / 60;
        bytes[at] ^= 0x55;
        bytes
    }));
    let robot = Robot::load(&gantry()).unwrap();
    for bytes in cases {
        std::fs::write(&path, &bytes).unwrap();
        if let Err(error) = Log::load(&path, &robot) {
            assert!(error.to_string().contains("cut.xlsx"), "{error}");
        }
    }
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let mut command = support::command();
    command.args(["identify", "static", "--robot"]).arg(gantry()).arg("--log").arg(&path);
    let out = command.assert().code(2);
    let words = String::from_utf8_lossy(&out.get_output().stderr).to_string();
    assert!(words.contains("damaged or cut short"), "{words}");
}

#[test]
fn simulate_and_show_take_a_sheet_as_its_csv() {
    let folder = WorkFolder::new();
    let page = folder.join("log.html");
    let mut show = support::command();
    show.arg("show").arg(data("log.xlsx")).arg("--robot").arg(gantry()).arg("--output").arg(&page).assert().success();
    assert!(std::fs::read_to_string(&page).unwrap().contains("log.xlsx"));
}

/// A part of a workbook changed, packed again.
fn repacked(file: &str, part: &str, change: impl Fn(&str) -> String) -> Vec<u8> {
    use std::io::{Cursor, Read, Write};
    let mut from = zip::ZipArchive::new(Cursor::new(std::fs::read(data(file)).unwrap())).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let mut seen = false;
    for i in 0..from.len() {
        let mut entry = from.by_index(i).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if name == part {
            seen = true;
            bytes = change(std::str::from_utf8(&bytes).unwrap()).into_bytes();
        }
        to.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        to.write_all(&bytes).unwrap();
    }
    assert!(seen, "{part}");
    to.finish().unwrap().into_inner()
}

/// A few hundred bytes may ask for a table of 17,000,000,000 cells.
#[test]
fn a_small_workbook_of_a_huge_table_is_refused_before_room_is_made_for_it() {
    let far = |xml: &str| {
        let at = xml.find("</sheetData>").unwrap();
        format!("{}<row r=\"1048576\"><c r=\"XFD1048576\"><v>1</v></c></row>{}", &xml[..at], &xml[at..])
    };
    let many = |xml: &str| {
        let at = xml.find("<table:table-row").unwrap();
        let cell = "<table:table-cell table:number-columns-repeated=\"16384\" office:value-type=\"float\" \
                    office:value=\"1\"><text:p>1</text:p></table:table-cell>";
        let row = format!("<table:table-row table:number-rows-repeated=\"1048000\">{cell}</table:table-row>");
        format!("{}{row}{}", &xml[..at], &xml[at..])
    };
    let sheet = "xl/worksheets/sheet2.xml";
    let folder = WorkFolder::new();
    for (name, bytes) in
        [("far.xlsx", repacked("log.xlsx", sheet, far)), ("many.ods", repacked("log.ods", "content.xml", many))]
    {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        let out = support::command()
            .args(["identify", "path", "--robot"])
            .arg(gantry())
            .arg("--log")
            .arg(&path)
            .arg("--output")
            .arg(folder.join("gaps.yaml"))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{name}: {told}");
        assert!(told.contains(name) && told.contains("20000000 cells"), "{told}");
    }
}
