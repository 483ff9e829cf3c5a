//! Files of readings that users have: other columns, units and orders, missing readings, and files that are refused.

use super::{Folder, GANTRY, command, found, play, refused};
use serde_json::Value;

#[test]
fn directions_units_order_and_a_column_map_make_no_difference() {
    let folder = Folder::new();
    let plain = play(|x| 4.0 + 0.01 * x, 4);
    let (want, _) = found(&[&folder.write("plain.csv", &plain)]);
    let body = || plain.lines().skip(1);
    let turned: String = body()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            let error: f64 = c[3].parse().unwrap();
            let (word, reading) = (if c[1] == "+1" { "Forward" } else { "backward" }, error * 1e-3);
            let position: f64 = c[0].parse().unwrap();
            format!("{},{word},{},{:.7}\n", c[2], position, position + reading)
        })
        .collect();
    let reading = folder.write("reading.csv", &format!("repetition,dir,position_mm,reading_mm\n{turned}"));
    let mm: String = body()
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .map(|l| l.replace("+1", "+").replace("-1,", "-,") + "\n")
        .collect();
    let mm = folder.write("reversed.csv", &format!("# turned round\nposition_mm,direction,repeat,error_um\n{mm}"));
    let foreign: String = body()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            let (error, x): (f64, f64) = (c[3].parse().unwrap(), c[0].parse().unwrap());
            format!("{};{};{};{};x\n", x * 1e-3, c[1], c[2], -error * 1e-3).replace('.', ",")
        })
        .collect();
    let foreign = folder.write("foreign.csv", &format!("Soll;Richtung;Lauf;Abweichung;Bemerkung\n{foreign}"));
    let map = folder.write(
        "map.yaml",
        "schema: lostmotion/columns/1\nseparator: \";\"\ndecimal: \",\"\ncolumns:\n  Soll: {to: position_mm, unit: m}\n  \
         Richtung: direction\n  Lauf: repeat\n  Abweichung: {to: error_um, unit: mm, sign: -1}\n  Bemerkung: ignore\n",
    );
    for args in [vec![reading.as_str()], vec![mm.as_str()], vec![foreign.as_str(), "--columns", &map]] {
        let (doc, _) = found(&args);
        for (a, b) in doc["poses"].as_array().unwrap().iter().zip(want["poses"].as_array().unwrap()) {
            for key in ["position_mm", "backlash_um", "repeatability_bidirectional_um"] {
                let (a, b) = (a[key].as_f64().unwrap(), b[key].as_f64().unwrap());
                assert!((a - b).abs() < 1e-3, "{args:?} {key}: {a} {b}");
            }
        }
        assert_eq!(doc["model"]["degree"], want["model"]["degree"], "{args:?}");
    }
}

#[test]
fn missing_readings_and_unequal_repeats_are_used_as_far_as_they_go_and_said() {
    let folder = Folder::new();
    let mut lines: Vec<String> = play(|_| 5.0, 5).lines().map(str::to_string).collect();
    lines[1] = "0,+1,1,".into();
    lines[4] = "0,-1,2,NaN".into();
    lines.retain(|l| !l.starts_with("600,-1"));
    let (doc, notes) = found(&[&folder.write("lost.csv", &(lines.join("\n") + "\n"))]);
    let poses = doc["poses"].as_array().unwrap();
    assert_eq!((&poses[0]["pairs"], &poses[0]["repeats_forward"]), (&3.into(), &4.into()));
    assert!(poses[4]["backlash_um"].is_null() && poses[4]["repeatability_forward_um"].is_number());
    assert_eq!(doc["model"]["lack_of_fit"][0]["dof"], serde_json::json!([2, 18 - 4]));
    for says in ["2 of 45 readings are missing", "without a partner", "only one direction, so no backlash: 600 mm"] {
        assert!(notes.contains(says), "{says}: {notes}");
    }
}

#[test]
fn one_repeat_has_no_pure_error_and_is_not_given_a_degree() {
    let folder = Folder::new();
    let file = folder.write("once.csv", &play(|x| 5.0 + 0.01 * x, 1));
    let (doc, notes) = found(&[&file]);
    assert!(doc["model"].is_null() && doc["poses"][0]["backlash_um"].is_number());
    assert!(doc["poses"][0]["repeatability_bidirectional_um"].is_null());
    assert!(notes.contains("no pure error"), "{notes}");
    let (doc, _) = found(&[&file, "--degree", "1"]);
    assert!(doc["model"]["adequate"].is_null() && doc["model"]["ci95"][1][0].is_number());
    let says = refused(&[&file, "--robot", GANTRY, "--joint", "X", "--output", &folder.text("g.yaml")], 2);
    assert!(says.contains("no curve (one repeat only)") && !folder.path("g.yaml").exists(), "{says}");
}

#[test]
fn a_file_without_repeats_by_name_pairs_by_order_and_standard_input_is_a_file() {
    let plain = play(|x| 4.0 + 0.01 * x, 4);
    let unnamed: String = plain
        .lines()
        .map(|l| {
            let c: Vec<&str> = l.split(',').collect();
            format!("{},{},{}\n", c[0], c[1], c[3])
        })
        .collect();
    let folder = Folder::new();
    let (want, _) = found(&[&folder.write("named.csv", &plain)]);
    let out = command(&["-", "--json"]).write_stdin(unnamed).output().unwrap();
    let doc: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(doc["poses"], want["poses"]);
    assert!(String::from_utf8_lossy(&out.stderr).contains("paired by their order"));
}

#[test]
fn a_line_of_one_or_two_poses_is_still_assessed() {
    let folder = Folder::new();
    let rows = play(|_| 5.0, 4);
    for (poses, degree) in [(1, 0), (2, 0), (3, 1)] {
        let kept: Vec<&str> = rows.lines().take(1 + 8 * poses).collect();
        let (doc, _) = found(&[&folder.write("few.csv", &(kept.join("\n") + "\n"))]);
        assert_eq!(doc["model"]["degree"], degree, "{poses} poses");
    }
}

#[test]
fn every_wrong_file_is_refused_with_its_place() {
    let folder = Folder::new();
    let head = "position_mm,direction,repeat,error_um\n";
    let cases = [
        (String::new(), "an empty file"),
        (head.to_string(), "a header and no rows"),
        ("position_mm,direction,repeat\n0,1,1\n".into(), "no column `error_um`"),
        ("x,direction,repeat,error_um\n0,1,1,1\n".into(), "no column `position_mm`"),
        (format!("{head}0,0,1,5\n"), ":2:2: found `0` in column `direction`"),
        (format!("{head}0,1,1,5\n0,sideways,1,5\n"), ":3:2: found `sideways` in column `direction`"),
        (format!("{head}0,1,1,5\n,-1,1,5\n"), ":3:1: found an empty cell without a position"),
        (format!("{head}0,1,1,5\n0,-1,1,five\n"), ":3:4: found `five` in column `error_um`"),
        (format!("{head}0,1,1,5\n0,-1,1,1e99\n"), "at most 10,000,000 mm"),
        (format!("{head}0,1,1,5\n0,-1,1\n"), ":3: found 3 fields"),
        (format!("{head}0,1,1,5\n0,1,2,5\n"), "readings in the forward direction only"),
        (format!("{head}0,1,1,5\n0,-1,1,\n"), "readings in the forward direction only"),
        (format!("{head}0,1,1,\n0,-1,1,\n"), "every cell of the error is empty"),
        (
            format!("{head}0,1,1,5\n0,-1,1,5\n0,1,1,6\n"),
            ":4: found a second reading of position 0 mm, forward, repeat 1",
        ),
        ("position_mm;direction;repeat;error_um\n0;1;1;5\n".into(), "fields separated by `;`"),
        ("position_mm,direction,repeat,reading_mm\n0,1,1,0.5\n1,-1,1,900\n2,1,1,1800\n".into(), "check the units"),
        ("position_mm,direction,repeat,error_um,speed\n0,1,1,5,\n".into(), ":2:5: found an empty cell without a state"),
        ("position_mm,direction,repeat,error_um,error_mm\n0,1,1,5,5\n".into(), "a second column for `error_mm`"),
        ("position_mm,direction,repeat,error_um,reading_mm\n0,1,1,5,5\n".into(), "both an error and a reading"),
        (
            "position_mm,direction,repeat,error_um,speed\n0,1,1,5,1\n0,-1,1,5,2\n".into(),
            "no pose with a repeat in both",
        ),
    ];
    for (text, says) in cases {
        let error = refused(&[&folder.write("bad.csv", &text)], 2);
        assert!(error.contains(says), "{text:?}: {error}");
    }
    let mut many = String::from("position_mm,direction,repeat,error_um,humidity\n");
    for i in 0..40 {
        many += &format!("{},{},1,5,{}\n", i / 2, if i % 2 == 0 { 1 } else { -1 }, 40.0 + f64::from(i) / 100.0);
    }
    let many = folder.write("many.csv", &many);
    assert!(refused(&[&many], 2).contains("40 different values in column `humidity`"));
    assert!(refused(&[&folder.text("absent.csv")], 2).contains("cannot open"));
}

#[test]
fn readings_in_metres_are_refused_and_a_short_line_is_noted() {
    let folder = Folder::new();
    let scaled = |text: &str, column: usize, factor: f64| -> String {
        let row = |line: &str| {
            let cell = |(k, c): (usize, &str)| match c.parse::<f64>() {
                Ok(v) if k == column => format!("{:.12}", v * factor),
                _ => c.to_string(),
            };
            line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n"
        };
        text.lines().map(row).collect()
    };
    let good = play(|_| 40.0, 5);
    for (name, factor) in [("error_um", 1e-6), ("error_mm", 1e-6), ("error_um", 1e-3)] {
        let text = scaled(&good, 3, factor).replace("error_um", name);
        let file = folder.write("readings.csv", &text);
        let says = refused(&[&file], 2);
        assert!(says.contains(&format!("in column `{name}`")) && says.contains("0.1 um and more"), "{says}");
    }
    // the same figures where they belong
    let file = folder.write("readings.csv", &scaled(&good, 3, 1e-3).replace("error_um", "error_mm"));
    let (_, notes) = found(&[&file]);
    assert!(notes.is_empty(), "{notes}");
    // readings in metres at positions in mm: off by half the line in the median
    let reading = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let measured = |x: f64, e: f64| format!("{:.9}", (x + e * 1e-3) * 1e-3);
        let last = cells[0].parse().map_or("reading_mm".into(), |x: f64| measured(x, cells[3].parse().unwrap()));
        format!("{},{},{},{last}\n", cells[0], cells[1], cells[2])
    };
    let file = folder.write("readings.csv", &good.lines().map(reading).collect::<String>());
    assert!(refused(&[&file], 2).contains("check the units"));
    // positions in metres; errors are far below the line still
    let file = folder.write("readings.csv", &scaled(&good, 0, 1e-3));
    let (_, notes) = found(&[&file]);
    assert!(notes.contains("the line is 0.6000 mm long"), "{notes}");
}
