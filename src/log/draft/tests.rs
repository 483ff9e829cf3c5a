//! Headers of recordings, and the maps that are drafted from them.

use super::*;
use crate::log::Log;
use crate::log::columns::Meaning;
use crate::log::recording::Recording;

fn arm() -> Robot {
    let joints: String = (1..=3).map(|n| format!("  - {{name: J{n}, kind: revolute, a_mm: 300}}\n")).collect();
    Robot::parse("robot.yaml", &format!("schema: lostmotion/robot/1\njoints:\n{joints}")).unwrap()
}

fn names(header: &str, separator: char) -> Vec<String> {
    header.split(separator).map(String::from).collect()
}

#[test]
fn a_german_header_becomes_a_map_that_reads_the_file() {
    let header = "Zeit [ms];Achse 1 [Grad];Achse 2 [Grad];Achse 3 [Grad];Pos. X [m];Pos. Y [m];Pos. Z [m];Override";
    let found = draft(&names(header, ';'), &[], b';', b',', &arm());
    assert!(found.missing.is_empty() && found.shipped.is_none(), "{found:?}");
    assert!(found.text.contains("#  \"Override\": {to: ?}"), "{}", found.text);
    let map = ColumnMap::parse("map.yaml", &found.text).unwrap();
    let text = format!("{header}\n250;1,5;2;3;0,5;1;2;100\n500;1,5;2;3;0,5;1;2;100\n");
    let input = Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() };
    let log = Log::parse_with(input, &arm(), Some(&map)).unwrap();
    assert_eq!(log.t_s, [0.25, 0.5]);
    assert!((log.command(0)[0] - 1.5f64.to_radians()).abs() < 1e-12);
    assert_eq!(log.tcp_m[0].unwrap().x, 0.5);
}

#[test]
fn commands_and_encoders_are_told_apart_and_zero_counts_as_the_first() {
    let header = "timestamp target_q_0 target_q_1 target_q_2 actual_q_0 actual_q_1 actual_q_2 actual_qd_0";
    let found = draft(&names(header, ' '), &[], b' ', b'.', &arm());
    assert_eq!(found.shipped, Some("rtde"));
    assert!(found.found.contains(&"cmd_J1_deg".into()) && found.found.contains(&"enc_J3_deg".into()), "{found:?}");
    assert!(found.text.contains("no unit in the name"), "{}", found.text);
    assert!(found.text.contains("#  \"actual_qd_0\": {to: ?}"), "{}", found.text);
}

#[test]
fn measured_values_are_no_commands_and_nominal_ones_no_measurements() {
    let header = "Zeit [s];Istposition A1 [Grad];Sollposition A1 [Grad];Nominal X [mm];Measured X [mm];Soll Y [mm];Ist Y [mm];Z [ft]";
    let found = draft(&names(header, ';'), &[], b';', b',', &arm());
    for line in [
        "\"Istposition A1 [Grad]\": enc_J1_deg",
        "\"Sollposition A1 [Grad]\": cmd_J1_deg",
        "\"Measured X [mm]\": x_mm",
        "\"Ist Y [mm]\": y_mm",
        "\"Z [ft]\": z_mm   # unit not known",
        "#  \"Nominal X [mm]\": {to: ?, unit: mm}\n#  \"Soll Y [mm]\": {to: ?, unit: mm}",
    ] {
        assert!(found.text.contains(line), "{line} in\n{}", found.text);
    }
    // an analog input A0 beside joints counted from 1
    let found = draft(&names("Zeit;Achse 1;Achse 2;Achse 3;A0", ';'), &[], b';', b',', &arm());
    assert!(found.text.contains("\"Achse 1\": cmd_J1_deg") && found.missing.is_empty(), "{}", found.text);
}

#[test]
fn the_side_may_stand_after_the_joint_and_coordinates_may_have_a_word_more() {
    let header = "Messzeit (ms);J1 Soll (Grad);J2_soll;J3 Sollwert;J1 Ist;X-Koordinate (m);PosY;z_pos [mm];Kraft X";
    let found = draft(&names(header, ';'), &[], b';', b',', &arm());
    for line in [
        "\"Messzeit (ms)\": {to: t_s, unit: ms}",
        "\"J1 Soll (Grad)\": cmd_J1_deg",
        "\"J2_soll\": cmd_J2_deg",
        "\"J3 Sollwert\": cmd_J3_deg",
        "\"J1 Ist\": enc_J1_deg",
        "\"X-Koordinate (m)\": {to: x_mm, unit: m}",
        "\"PosY\": y_mm",
        "\"z_pos [mm]\": z_mm",
        "#  \"Kraft X\": {to: ?}",
    ] {
        assert!(found.text.contains(line), "{line} in\n{}", found.text);
    }
    assert!(found.missing.is_empty(), "{:?}", found.missing);
    assert!(ColumnMap::parse("map.yaml", &found.text).is_ok(), "{}", found.text);
}

#[test]
fn a_file_in_which_nothing_is_recognised_needs_times_and_commands_or_coordinates() {
    let found = draft(&names("Spalte (ms);Wert 17 (m)", ';'), &[], b';', b',', &arm());
    assert!(found.text.contains("#  \"Spalte (ms)\": {to: ?, unit: ms}"), "{}", found.text);
    for ours in ["t_s", "cmd_J2_deg", "x_mm", "z_mm"] {
        assert!(found.missing.contains(&ours.to_string()), "{:?}", found.missing);
    }
    // of a tracker's file no commands are missed
    let tracker = draft(&names("Zeit;X;Y", ';'), &[], b';', b',', &arm());
    assert_eq!(tracker.missing, ["z_mm"]);
}

#[test]
fn what_a_log_needs_and_no_column_has_is_named() {
    let found = draft(&names("Time,J1,J3,Speed", ','), &[], b',', b'.', &arm());
    assert_eq!(found.missing, ["cmd_J2_deg"]);
    let tracker = draft(&names("Time;X;Y;Z", ';'), &[], b';', b',', &arm());
    assert_eq!((tracker.missing.len(), tracker.shipped), (0, Some("tracker")));
}

#[test]
fn times_of_day_and_dates_are_found_by_their_cells() {
    let rows = [
        ("Uhrzeit;X;Y;Z", "23:59:59,900;1,5;2;3\n00:00:00,100;1,5;2;3\n", "\"Uhrzeit\": {to: t_s, unit: hms}"),
        ("Time;X;Y;Z", "12.11.2025 10:00:00,0;1,5;2;3\n12.11.2025 10:00:00,2;1,5;2;3\n", "unit: dmy_hms"),
        ("Time;X;Y;Z", "11/13/2025 10:00:00.0 AM;1.5;2;3\n11/13/2025 10:00:00.2 AM;1.5;2;3\n", "unit: mdy_hms"),
        ("Spalte 1;X;Y;Z", "10:00:00,0;1,5;2;3\n10:00:00,2;1,5;2;3\n", "\"Spalte 1\": {to: t_s, unit: hms}"),
    ];
    for (header, body, entry) in rows {
        let text = format!("{header}\n{body}");
        let input = || Input { name: "tracker.csv".into(), bytes: text.clone().into(), sha256: String::new() };
        let found = of_file(input(), &arm()).unwrap();
        assert!(found.text.contains(entry) && found.missing.is_empty(), "{header}: {}", found.text);
        assert_eq!(found.shipped, None, "the map `tracker` reads seconds");
        let map = ColumnMap::parse("map.yaml", &found.text).unwrap();
        let read = Recording::parse(input(), &arm(), Some(&map), TopicChoice::Places).unwrap();
        let t_s = read.values(Meaning::Time).unwrap();
        assert!(t_s[0] == 0.0 && (t_s[1] - 0.2).abs() < 1e-12, "{header}: {t_s:?}");
    }
}

#[test]
fn a_time_of_day_read_as_seconds_names_the_unit_that_reads_it() {
    let read = |unit: &str, cell: &str| {
        let map = format!(
            "schema: {SCHEMA}\nseparator: \";\"\ndecimal: \",\"\ncolumns: {{T: {{to: t_s, unit: {unit}}}}}\npartial: true\n"
        );
        let map = ColumnMap::parse("map.yaml", &map).unwrap();
        let input = Input { name: "t.csv".into(), bytes: format!("T;x_mm\n{cell};1\n").into(), sha256: String::new() };
        Recording::parse(input, &arm(), Some(&map), TopicChoice::Places).unwrap_err().to_string()
    };
    let words = read("s", "10:00:00,000");
    assert!(words.contains("a number of seconds; a column map with `unit: hms`"), "{words}");
    let words = read("iso8601", "10:00:00,000");
    assert!(words.contains("a date and time, e.g. 2025") && words.contains("`unit: hms`"), "{words}");
    assert!(!read("s", "soon").contains("unit:"));
}
