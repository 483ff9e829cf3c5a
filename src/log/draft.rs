//! A column map drafted from the header of a recording: separator, decimal sign, and what each column seems to be.
//!
//! Method: names are cut at everything that is neither letter nor digit; units come from brackets or from the end of a name
//! (`Zeit [ms]`, `j1_rad`). Times and coordinates are recognised by common words in English and German, joints by the names of the robot
//! file or by a number (`Achse 1`, `joint_0`, `A3`), counted from 0 where a 0 occurs. Where several columns show one joint, words tell commands
//! (`target`, `soll`) from encoders (`actual`, `ist`). What is not recognised is listed as a comment and passed over.
//!
//! It is a draft: units that no name tells are those of the contract, and are marked. [`crate::log::plausibility`] finds most that are wrong.

use super::columns::{ColumnMap, SCHEMA};
use super::maps;
use super::read::Head;
use super::text::LogText;
use super::write::joint_column;
use crate::error::Result;
use crate::io::bag::TopicChoice;
use crate::io::input::Input;
use crate::robot::{JointKind, Robot};
use std::fmt::Write;

/// A drafted map.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The map as YAML.
    pub text: String,
    /// Our names that were found for columns.
    pub found: Vec<String>,
    /// Our names that a log needs and that no column has.
    pub missing: Vec<String>,
    /// Name of a map that ships with the program and reads this header.
    pub shipped: Option<&'static str>,
}

/// What a word of a name says a unit is: unit of the map.
const UNITS: &[(&str, &str)] = &[
    ("deg", "deg"),
    ("grad", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("°", "deg"),
    ("rad", "rad"),
    ("mrad", "mrad"),
    ("mm", "mm"),
    ("m", "m"),
    ("um", "um"),
    ("µm", "um"),
    ("μm", "um"),
    ("in", "in"),
    ("inch", "in"),
    ("zoll", "in"),
    ("s", "s"),
    ("sec", "s"),
    ("ms", "ms"),
    ("us", "us"),
    ("µs", "us"),
];
const TIMES: &[&str] = &["t", "time", "timestamp", "zeit", "uhrzeit", "zeitstempel", "temps", "tempo"];
const COMMANDS: &[&str] = &[
    "cmd",
    "command",
    "commanded",
    "target",
    "soll",
    "desired",
    "des",
    "setpoint",
    "reference",
    "ref",
    "nominal",
    "nom",
    "vorgabe",
];
const ENCODERS: &[&str] =
    &["enc", "encoder", "actual", "act", "ist", "feedback", "fbk", "measured", "meas", "real", "gemessen"];
/// Words that German joins to the next one: `Istposition`, `Sollwert`.
const JOINED: &[&str] = &["ist", "soll"];
const JOINTS: &[&str] = &["achse", "axis", "axe", "gelenk", "joint", "rax", "j", "a", "q", "ax"];
/// Words after which a column is no position: speeds, torques, currents, Cartesian set points.
const OTHERS: &[&str] = &[
    "qd",
    "vel",
    "velocity",
    "speed",
    "geschwindigkeit",
    "acc",
    "qdd",
    "torque",
    "moment",
    "current",
    "strom",
    "tcp",
    "temp",
    "temperature",
    "rms",
    "status",
    "override",
    "std",
    "sigma",
];

/// A column name, taken apart.
struct Name<'a> {
    whole: &'a str,
    /// In lower case, without unit and brackets.
    words: Vec<String>,
    unit: Option<&'static str>,
    /// Brackets hold something that is no unit of a map.
    foreign: bool,
}

fn unit_of(word: &str) -> Option<&'static str> {
    UNITS.iter().find(|(w, _)| *w == word).map(|(_, u)| *u)
}

fn take_apart(whole: &str) -> Name<'_> {
    let lower = whole.trim().to_lowercase();
    let (mut plain, mut unit, mut foreign) = (lower.clone(), None, false);
    if let Some((before, rest)) = lower.split_once(['[', '(']) {
        let inside = rest.split([']', ')']).next().unwrap_or("").trim();
        unit = unit_of(inside);
        foreign = unit.is_none() && !inside.is_empty();
        plain = before.to_string();
    }
    // numbers are words of their own: `achse1`, `q_0`
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in plain.chars() {
        let new = !c.is_alphanumeric() || c.is_ascii_digit() != last.is_ascii_digit();
        if c.is_alphanumeric() || c == '°' {
            match words.last_mut() {
                Some(word) if !new && last.is_alphanumeric() => word.push(c),
                _ => words.push(c.to_string()),
            }
        }
        last = c;
    }
    if unit.is_none() && words.len() > 1 {
        unit = words.last().and_then(|w| unit_of(w));
        if unit.is_some() {
            words.pop();
        }
    }
    Name { whole: whole.trim(), words, unit, foreign }
}

/// What a column seems to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seems {
    Time,
    Coordinate(usize),
    /// Of an axis: command, encoder, or whatever it is the only one of.
    Joint(usize, Side),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Command,
    Encoder,
    Unsaid,
}

fn says(name: &Name, words: &[&str]) -> bool {
    let joined = |w: &str| JOINED.iter().any(|j| words.contains(j) && w.starts_with(j));
    name.words.iter().any(|w| words.contains(&w.as_str()) || joined(w))
}

/// The number at the end of a name whose word before it is one for joints.
fn numbered(name: &Name) -> Option<usize> {
    let [.., word, number] = name.words.as_slice() else { return None };
    JOINTS.contains(&word.as_str()).then(|| number.parse().ok())?
}

fn seems(name: &Name, robot: &Robot, from_zero: bool) -> Option<Seems> {
    if says(name, OTHERS) {
        return None;
    }
    let side = match (says(name, COMMANDS), says(name, ENCODERS)) {
        (true, false) => Side::Command,
        (false, true) => Side::Encoder,
        _ => Side::Unsaid,
    };
    let letters: Vec<String> = robot.axis_joints().map(|j| take_apart(&j.name).words.concat()).collect();
    let ending = |joint: &str| (0..name.words.len()).any(|k| name.words[k..].concat() == joint);
    if let Some(axis) = letters.iter().position(|l| ending(l)) {
        // X of a gantry is a joint where it says so; else the tracker's coordinate
        let coordinate =
            ["x", "y", "z"].contains(&letters[axis].as_str()) && side == Side::Unsaid && !says(name, JOINTS);
        if !coordinate {
            return Some(Seems::Joint(axis, side));
        }
    }
    if let Some(number) = numbered(name) {
        let axis = if from_zero { Some(number) } else { number.checked_sub(1) };
        return axis.filter(|a| *a < robot.dof()).map(|a| Seems::Joint(a, side));
    }
    let last = name.words.last()?;
    if let Some(k) = ["x", "y", "z"].iter().position(|c| c == last) {
        // where the TCP should be is no measurement of it
        return (side != Side::Command).then_some(Seems::Coordinate(k));
    }
    TIMES.contains(&name.words[0].as_str()).then_some(Seems::Time)
}

/// Drafts a map of a file: CSV, or a workbook.
///
/// # Errors
/// Where the file has no header.
pub fn of_file(input: Input, robot: &Robot) -> Result<Draft> {
    let any = ColumnMap::parse("any", &format!("schema: {SCHEMA}\nseparator: any\ndecimal: any\npartial: true\n"))?;
    let text = LogText::of(input, robot, Some(&any), TopicChoice::Any)?;
    let head = Head::read(&text.input.name, &text.input.bytes, text.separator)?;
    Ok(draft(&head.names, text.separator, text.decimal, robot))
}

/// Drafts a map from a header, cut by `separator`; `decimal` is the sign before decimals.
pub fn draft(header: &[String], separator: u8, decimal: u8, robot: &Robot) -> Draft {
    let names: Vec<Name> = header.iter().map(|h| take_apart(h)).collect();
    let numbers: Vec<usize> = names.iter().filter_map(numbered).collect();
    let from_zero = numbers.contains(&0) && !numbers.contains(&robot.dof());
    let all: Vec<Option<Seems>> = names.iter().map(|n| seems(n, robot, from_zero)).collect();
    let commanded = |axis: usize| all.contains(&Some(Seems::Joint(axis, Side::Command)));
    let mut taken: Vec<String> = Vec::new();
    let mut lines = String::new();
    let mut passed: Vec<&str> = Vec::new();
    for (name, seems) in names.iter().zip(&all) {
        // beside a command, a column that says nothing may be anything
        let seems = seems.filter(|s| !matches!(s, Seems::Joint(axis, Side::Unsaid) if commanded(*axis)));
        let ours = seems.map(|seems| match seems {
            Seems::Time => ("t_s".to_string(), "s"),
            Seems::Coordinate(k) => (format!("{}_mm", ["x", "y", "z"][k]), "mm"),
            Seems::Joint(axis, side) => {
                let joint = robot.axis(axis);
                let unit = if joint.kind == JointKind::Prismatic { "mm" } else { "deg" };
                (joint_column(if side == Side::Encoder { "enc" } else { "cmd" }, joint), unit)
            }
        });
        match ours {
            Some((ours, own)) if !taken.contains(&ours) => {
                let quoted = serde_json::to_string(name.whole).unwrap_or_default();
                let _ = match name.unit {
                    Some(unit) if unit != own => writeln!(lines, "  {quoted}: {{to: {ours}, unit: {unit}}}"),
                    Some(_) => writeln!(lines, "  {quoted}: {ours}"),
                    None if name.foreign => writeln!(lines, "  {quoted}: {ours}   # unit not known; taken as {own}"),
                    None => writeln!(lines, "  {quoted}: {ours}   # no unit in the name: {own}?"),
                };
                taken.push(ours);
            }
            _ => passed.push(name.whole),
        }
    }
    let shown = match separator {
        b'\t' => "tab".to_string(),
        other => char::from(other).to_string(),
    };
    let mut text = format!("schema: {SCHEMA}\n");
    let _ = writeln!(text, "separator: \"{shown}\"\ndecimal: \"{}\"\ncolumns:", char::from(decimal));
    text.push_str(if lines.is_empty() { "  {}\n" } else { &lines });
    if !passed.is_empty() {
        let _ = writeln!(text, "# passed over: {}", passed.join(", "));
    }
    let tracker = ["x_mm", "y_mm", "z_mm"].iter().all(|c| taken.iter().any(|t| t == c));
    let controller = taken.iter().any(|t| t.starts_with("cmd_"));
    let mut needed = vec!["t_s".to_string()];
    if controller || !tracker {
        needed.extend(robot.axis_joints().map(|j| joint_column("cmd", j)));
    }
    let missing = needed.into_iter().filter(|n| !taken.contains(n)).collect();
    Draft { text, found: taken, missing, shipped: shipped(header, robot) }
}

/// The map that ships with the program and finds a time and all commands, or a time and all coordinates, in a header.
pub fn shipped(header: &[String], robot: &Robot) -> Option<&'static str> {
    let reads = |map: &ColumnMap| {
        let has = |ours: &str| header.iter().any(|h| map.of(h.trim()).is_some_and(|m| m.to == Some(ours)));
        let commands = (1..=robot.dof()).all(|n| has(&format!("cmd_#{n}")));
        has("t_s") && (commands || ["x_mm", "y_mm", "z_mm"].iter().all(|c| has(c)))
    };
    maps::MAPS.iter().map(|m| m.0).find(|name| maps::named(name).and_then(Result::ok).is_some_and(|m| reads(&m)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;

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
        let found = draft(&names(header, ';'), b';', b',', &arm());
        assert!(found.missing.is_empty() && found.shipped.is_none(), "{found:?}");
        assert!(found.text.contains("# passed over: Override"), "{}", found.text);
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
        let found = draft(&names(header, ' '), b' ', b'.', &arm());
        assert_eq!(found.shipped, Some("rtde"));
        assert!(found.found.contains(&"cmd_J1_deg".into()) && found.found.contains(&"enc_J3_deg".into()), "{found:?}");
        assert!(found.text.contains("no unit in the name"), "{}", found.text);
        assert!(found.text.contains("# passed over: actual_qd_0"), "{}", found.text);
    }

    #[test]
    fn measured_values_are_no_commands_and_nominal_ones_no_measurements() {
        let header = "Zeit [s];Istposition A1 [Grad];Sollposition A1 [Grad];Nominal X [mm];Measured X [mm];Soll Y [mm];Ist Y [mm];Z [ft]";
        let found = draft(&names(header, ';'), b';', b',', &arm());
        for line in [
            "\"Istposition A1 [Grad]\": enc_J1_deg",
            "\"Sollposition A1 [Grad]\": cmd_J1_deg",
            "\"Measured X [mm]\": x_mm",
            "\"Ist Y [mm]\": y_mm",
            "\"Z [ft]\": z_mm   # unit not known",
            "# passed over: Nominal X [mm], Soll Y [mm]",
        ] {
            assert!(found.text.contains(line), "{line} in\n{}", found.text);
        }
        // an analog input A0 beside joints counted from 1
        let found = draft(&names("Zeit;Achse 1;Achse 2;Achse 3;A0", ';'), b';', b',', &arm());
        assert!(found.text.contains("\"Achse 1\": cmd_J1_deg") && found.missing.is_empty(), "{}", found.text);
    }

    #[test]
    fn what_a_log_needs_and_no_column_has_is_named() {
        let found = draft(&names("Time,J1,J3,Speed", ','), b',', b'.', &arm());
        assert_eq!(found.missing, ["cmd_J2_deg"]);
        let tracker = draft(&names("Time;X;Y;Z", ';'), b';', b',', &arm());
        assert_eq!((tracker.missing.len(), tracker.shipped), (0, Some("tracker")));
    }
}
