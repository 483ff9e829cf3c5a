//! Logs whose columns were changed: other units, dead sensors, swapped columns.

use super::{ROBOT, Z, gantry, notes, one, read, text_of};
use crate::support::bundled;
use lostmotion::identify::screw::{document, identify};
use lostmotion::log::plausibility;
use lostmotion::robot::Robot;

/// The log with one column changed.
fn changed(name: &str, column: &str, change: impl Fn(f64) -> f64) -> String {
    let text = text_of(name);
    let mut lines = text.lines();
    let (comment, head) = (lines.next().unwrap(), lines.next().unwrap());
    let k = head.split(',').position(|c| c == column).unwrap();
    let row = |line: &str| {
        let cell = |(i, c): (usize, &str)| {
            if i == k { format!("{:.7}", change(c.parse().unwrap())) } else { c.into() }
        };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",")
    };
    [comment.to_string(), head.to_string()].into_iter().chain(lines.map(row)).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn units_and_scales_that_cannot_be_right_are_refused() {
    let robot = gantry();
    let refused = |text: &str, robot: &Robot| -> String {
        let log = read(text, robot).unwrap();
        let error = match plausibility::check(&log, robot) {
            Err(e) => e,
            Ok(_) => identify(robot, &[log], None).map(|_| ()).unwrap_err(),
        };
        assert_eq!(lostmotion::cli::exit::code_of(&error), 2);
        error.to_string()
    };
    let degrees = 1f64.to_radians();
    let said = refused(&changed("clean", "enc_Z_deg", |v| v * degrees), &robot);
    assert!(said.contains("values in radians in column `enc_Z_deg"), "{said}");
    let said = refused(&changed("clean", "screw_Z_deg", |v| v / 360.0), &robot);
    assert!(said.contains("values in revolutions in column `screw_Z_deg"), "{said}");
    let said = refused(&changed("clean", "meas_Z_mm", |v| v * 1e-3), &robot);
    assert!(said.contains("values in metres"), "{said}");
    let said = refused(&changed("clean", "meas_Z_mm", |v| -v), &robot);
    assert!(said.contains("the carriage of Z moves by -1.0"), "{said}");
    let said = refused(&changed("clean", "screw_Z_deg", |v| 2.0 * v), &robot);
    assert!(said.contains("`screw_Z` moves by 2.0"), "{said}");
    // a lead of 5 mm in the robot file
    let yaml = std::fs::read_to_string(bundled(ROBOT)).unwrap();
    let other = Robot::parse("r.yaml", &yaml.replace("lead_mm_per_rev: 10", "lead_mm_per_rev: 5")).unwrap();
    let said = refused(&text_of("clean"), &other);
    assert!(said.contains("`enc_Z` moves by 0.5") && said.contains("lead_mm_per_rev"), "{said}");
    // an angle without a lead has no meaning
    let none = Robot::parse("r.yaml", &yaml.replace(", lead_mm_per_rev: 10", "")).unwrap();
    let said = read(&text_of("clean"), &none).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("`enc_Z_deg`: Z in deg") && said.contains("lead_mm_per_rev"), "{said}");
}

#[test]
fn a_dead_sensor_is_no_gap_and_a_log_without_sensors_is_refused() {
    let robot = gantry();
    let log = read(&changed("clean", "meas_Z_mm", |_| -150.0), &robot).unwrap();
    let found = identify(&robot, &[log], None).unwrap();
    assert!(one(&found).both.is_none() && one(&found).at_least.is_none());
    assert!(
        notes(&found).contains("check that this is the sensor of this joint and that it works"),
        "{}",
        notes(&found)
    );
    let bare = text_of("clean").lines().map(|l| l.split(',').take(4).collect::<Vec<_>>().join(",")).collect::<Vec<_>>();
    let log = read(&bare.join("\n"), &robot).unwrap();
    let said = identify(&robot, &[log], None).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("no measurement column"), "{said}");
}

#[test]
fn angles_and_millimetres_of_the_motor_side_say_the_same() {
    let robot = gantry();
    let angle = read(&text_of("clean"), &robot).unwrap();
    let text = changed("clean", "enc_Z_deg", |v| v / 36.0).replace("enc_Z_deg", "enc_Z_mm");
    let way = read(&text, &robot).unwrap();
    let pairs = angle.enc[Z].iter().flatten().zip(way.enc[Z].iter().flatten());
    assert!(pairs.map(|(a, b)| (a.unwrap() - b.unwrap()).abs()).fold(0.0, f64::max) < 1e-9);
    let twice = text_of("clean").replacen("screw_Z_deg", "enc_Z_mm", 1);
    let said = read(&twice, &robot).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("a second column for `enc_Z_mm`"), "{said}");
}

#[test]
fn settled_strokes_have_no_lag_and_no_word_of_one() {
    let robot = gantry();
    // neither times nor encoder: the command stands for the motor, and nothing trails
    let strip = |text: &str| -> String {
        let keep = |line: &str| {
            line.split(',').enumerate().filter(|(k, _)| *k != 0 && *k != 4).map(|c| c.1).collect::<Vec<_>>().join(",")
        };
        text.lines().map(|l| if l.starts_with('#') { l.to_string() } else { keep(l) } + "\n").collect()
    };
    let text = text_of("clean");
    let head: Vec<&str> = text.lines().find(|l| !l.starts_with('#')).unwrap().split(',').collect();
    assert_eq!((head[0], head[4]), ("t_s", "enc_Z_deg"));
    let log = read(&strip(&text), &robot).unwrap();
    assert!(log.poses && log.enc[Z].is_none());
    let found = identify(&robot, &[log], None).unwrap();
    assert!(one(&found).both.as_ref().unwrap().total_per_lag.is_none());
    assert!(!notes(&found).contains("millisecond"), "{}", notes(&found));
}

#[test]
fn an_encoder_that_stands_still_is_said_to_do_so() {
    let robot = gantry();
    let log = read(&changed("clean", "enc_Z_deg", |_| -90.0), &robot).unwrap();
    let said = identify(&robot, &[log], None).map(|_| ()).unwrap_err();
    assert_eq!(lostmotion::cli::exit::code_of(&said), 2);
    assert!(said.to_string().contains("`enc_Z` stands still while Z moves"), "{said}");
}

#[test]
fn a_negative_gap_of_swapped_columns_is_not_significant() {
    let robot = gantry();
    let text = text_of("clean").replacen("enc_Z_deg", "?", 1).replacen("screw_Z_deg", "enc_Z_deg", 1).replacen(
        '?',
        "screw_Z_deg",
        1,
    );
    let found = identify(&robot, &[read(&text, &robot).unwrap()], None).unwrap();
    let coupling = one(&found).coupling.as_ref().unwrap();
    assert!(coupling.total.ci95[1] < 0.0 && !coupling.significant(), "{coupling:?}");
    assert!(notes(&found).contains("swapped?"), "{}", notes(&found));
    let doc = document::document(&found, &robot);
    assert_eq!(doc["series"][0]["coupling"]["significant"], false);
    assert_eq!(doc["series"][0]["nut"]["significant"], true);
}
