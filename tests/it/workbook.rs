//! Logs as a spreadsheet saves them: the same log as its CSV (`tests/oracle/workbook.py` wrote both).

use assert_cmd::Command;
use lostmotion::log::{ColumnMap, Log};
use lostmotion::robot::Robot;
use std::path::{Path, PathBuf};

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/workbook").join(file)
}

fn gantry() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/gantry-xyz-ballscrew.yaml")
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
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.xlsx");
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
    let mut command = Command::cargo_bin("lostmotion").unwrap();
    command.args(["identify", "static", "--robot"]).arg(gantry()).arg("--log").arg(&path);
    let out = command.assert().code(2);
    let words = String::from_utf8_lossy(&out.get_output().stderr).to_string();
    assert!(words.contains("damaged or cut short"), "{words}");
}

#[test]
fn simulate_and_show_take_a_sheet_as_its_csv() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("log.html");
    let mut show = Command::cargo_bin("lostmotion").unwrap();
    show.arg("show").arg(data("log.xlsx")).arg("--robot").arg(gantry()).arg("--output").arg(&page).assert().success();
    assert!(std::fs::read_to_string(&page).unwrap().contains("log.xlsx"));
}
