//! A column map drafted from the header of a recording: separator, decimal sign, and what each column seems to be.
//!
//! Method: names are cut at everything that is neither letter nor digit; units come from brackets or from the end of a name
//! (`Zeit [ms]`, `j1_rad`). Times and coordinates are recognised by common words in English and German, joints by the names of the robot
//! file or by a number (`Achse 1`, `joint_0`, `A3`), counted from 0 where a 0 occurs. Where several columns show one joint, words tell
//! commands (`target`, `soll`) from encoders (`actual`, `ist`), before the joint's name or after it. Times of day and dates are recognised
//! by the cells of the first rows. What is not recognised becomes a commented entry, to be completed by hand.
//!
//! It is a draft: units that no name tells are those of the contract, and are marked. [`crate::log::plausibility`] finds most that are
//! wrong.

use super::columns::{ColumnMap, SCHEMA};
use super::maps;
use super::read::{Head, reader};
use super::text::LogText;
use super::timestamp::Stamp;
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
const TIMES: &[&str] = &[
    "t",
    "time",
    "timestamp",
    "zeit",
    "uhrzeit",
    "zeitstempel",
    "messzeit",
    "zeitpunkt",
    "laufzeit",
    "temps",
    "tempo",
];
/// Words after the name of a joint or a coordinate that add nothing to it: `X-Koordinate`, `A1 Soll`.
const ENDINGS: &[&str] =
    &["koordinate", "coordinate", "coord", "koord", "pos", "position", "wert", "value", "winkel", "angle", "lage"];
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
    "kraft",
    "force",
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
    let lower = parted(whole.trim()).to_lowercase();
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

/// The name with a blank where a capital follows a small letter: `PosX`, `IstPosition`.
fn parted(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let (mut last, mut inside) = (' ', false);
    for c in name.chars() {
        // units in brackets have capitals of their own
        inside |= matches!(c, '[' | '(');
        if c.is_uppercase() && last.is_lowercase() && !inside {
            out.push(' ');
        }
        out.push(c);
        last = c;
    }
    out
}

/// What a column seems to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Guess {
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

/// The words of a name without those at its end that tell the side, or nothing: `A1 Soll`, `X-Koordinate`.
fn core<'a>(name: &'a Name) -> &'a [String] {
    let adds_nothing = |w: &String| {
        [COMMANDS, ENCODERS, ENDINGS].iter().any(|list| list.contains(&w.as_str()))
            || JOINED.iter().any(|j| w.starts_with(j))
    };
    let kept = name.words.iter().rposition(|w| !adds_nothing(w)).map_or(0, |k| k + 1);
    if kept == 0 { &name.words } else { &name.words[..kept] }
}

/// The number at the end of a name whose word before it is one for joints.
fn numbered(name: &Name) -> Option<usize> {
    let [.., word, number] = core(name) else { return None };
    JOINTS.contains(&word.as_str()).then(|| number.parse().ok())?
}

fn seems(name: &Name, robot: &Robot, from_zero: bool) -> Option<Guess> {
    if says(name, OTHERS) {
        return None;
    }
    let side = match (says(name, COMMANDS), says(name, ENCODERS)) {
        (true, false) => Side::Command,
        (false, true) => Side::Encoder,
        _ => Side::Unsaid,
    };
    let letters: Vec<String> = robot.axis_joints().map(|j| take_apart(&j.name).words.concat()).collect();
    let words = core(name);
    let ending = |joint: &str| (0..words.len()).any(|k| words[k..].concat() == joint);
    if let Some(axis) = letters.iter().position(|l| ending(l)) {
        // X of a gantry is a joint where it says so; else the tracker's coordinate
        let coordinate =
            ["x", "y", "z"].contains(&letters[axis].as_str()) && side == Side::Unsaid && !says(name, JOINTS);
        if !coordinate {
            return Some(Guess::Joint(axis, side));
        }
    }
    if let Some(number) = numbered(name) {
        let axis = if from_zero { Some(number) } else { number.checked_sub(1) };
        return axis.filter(|a| *a < robot.dof()).map(|a| Guess::Joint(a, side));
    }
    let last = words.last()?;
    if let Some(k) = ["x", "y", "z"].iter().position(|c| c == last) {
        // where the TCP should be is no measurement of it
        return (side != Side::Command).then_some(Guess::Coordinate(k));
    }
    TIMES.contains(&name.words[0].as_str()).then_some(Guess::Time)
}

/// The entry of a column that was not recognised, as a comment.
fn commented(name: &Name) -> String {
    let quoted = serde_json::to_string(name.whole).unwrap_or_default();
    let unit = name.unit.map_or(String::new(), |unit| format!(", unit: {unit}"));
    format!("#  {quoted}: {{to: ?{unit}}}\n")
}

/// Drafts a map of a file: CSV, or a workbook.
///
/// # Errors
/// Where the file has no header.
pub fn of_file(input: Input, robot: &Robot) -> Result<Draft> {
    let any = ColumnMap::parse("any", &format!("schema: {SCHEMA}\nseparator: any\ndecimal: any\npartial: true\n"))?;
    let text = LogText::of(input, robot, Some(&any), TopicChoice::Any)?;
    let head = Head::read(&text.input.name, &text.input.bytes, text.separator)?;
    let body = text.input.bytes.get(head.body..).unwrap_or_default();
    let rows: Vec<csv::ByteRecord> =
        reader(body, text.separator).byte_records().map_while(|r| r.ok()).take(LOOKED_AT).collect();
    let stamps: Vec<Option<Stamp>> = (0..head.names.len()).map(|k| stamp_of(&rows, k)).collect();
    Ok(draft(&head.names, &stamps, text.separator, text.decimal, robot))
}

/// Rows whose cells are looked at.
const LOOKED_AT: usize = 200;

/// How a column writes its times, where all its cells are dates or times of day.
fn stamp_of(rows: &[csv::ByteRecord], column: usize) -> Option<Stamp> {
    let cells: Vec<&str> =
        rows.iter().map(|r| r.get(column).and_then(|c| std::str::from_utf8(c).ok())).collect::<Option<_>>()?;
    Stamp::reading(cells.iter().copied()).next()
}

/// Drafts a map from a header, cut by `separator`; `decimal` is the sign before decimals; `stamps`: how columns write dates or times of
/// day, where they do.
pub(crate) fn draft(header: &[String], stamps: &[Option<Stamp>], separator: u8, decimal: u8, robot: &Robot) -> Draft {
    let names: Vec<Name> = header.iter().map(|h| take_apart(h)).collect();
    let numbers: Vec<usize> = names.iter().filter_map(numbered).collect();
    let from_zero = numbers.contains(&0) && !numbers.contains(&robot.dof());
    let all: Vec<Option<Guess>> = names.iter().map(|n| seems(n, robot, from_zero)).collect();
    let stamp = |k: usize| stamps.get(k).copied().flatten();
    // a column of times under another name, where no name is one of a time
    let timed = |k: usize| all[k] == Some(Guess::Time);
    let unnamed = (0..all.len()).find(|&k| stamp(k).is_some()).filter(|_| !(0..all.len()).any(timed));
    let all: Vec<Option<Guess>> =
        all.iter().enumerate().map(|(k, s)| if unnamed == Some(k) { Some(Guess::Time) } else { *s }).collect();
    let commanded = |axis: usize| all.contains(&Some(Guess::Joint(axis, Side::Command)));
    let mut taken: Vec<String> = Vec::new();
    let mut lines = String::new();
    let mut passed: Vec<String> = Vec::new();
    for (k, (name, seems)) in names.iter().zip(&all).enumerate() {
        // beside a command, a column that says nothing may be anything
        let seems = seems.filter(|s| !matches!(s, Guess::Joint(axis, Side::Unsaid) if commanded(*axis)));
        let ours = seems.map(|seems| match seems {
            Guess::Time => ("t_s".to_string(), "s"),
            Guess::Coordinate(k) => (format!("{}_mm", ["x", "y", "z"][k]), "mm"),
            Guess::Joint(axis, side) => {
                let joint = robot.axis(axis);
                let unit = if joint.kind == JointKind::Prismatic { "mm" } else { "deg" };
                (joint_column(if side == Side::Encoder { "enc" } else { "cmd" }, joint), unit)
            }
        });
        match ours {
            Some((ours, own)) if !taken.contains(&ours) => {
                lines.push_str(&entry(name, &ours, own, stamp(k).filter(|_| ours == "t_s")));
                taken.push(ours);
            }
            _ => passed.push(commented(name)),
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
        text.push_str(
            "# Columns that are not used. To use one, remove its `#` and write one of our names for `?` (t_s, ",
        );
        let _ = writeln!(text, "{}, x_mm):\n{}", joint_column("cmd", robot.axis(0)), passed.concat().trim_end());
    }
    let missing = needed(&taken, robot).into_iter().filter(|n| !taken.contains(n)).collect();
    // a map that ships reads numbers of seconds, or dates in its one way
    let reads_times = |map: &&'static str| {
        let map = maps::named(map).and_then(Result::ok);
        (0..all.len()).filter(|&k| all[k] == Some(Guess::Time)).all(|k| {
            let unit = map.as_ref().and_then(|m| m.of(names[k].whole)?.unit.and_then(Stamp::named));
            unit == stamp(k) || stamps.is_empty()
        })
    };
    Draft { text, found: taken, missing, shipped: shipped(header, robot).filter(reads_times) }
}

/// The line of a column in the map: `ours` is our name, whose unit is `own`.
fn entry(name: &Name, ours: &str, own: &str, stamp: Option<Stamp>) -> String {
    let quoted = serde_json::to_string(name.whole).unwrap_or_default();
    let unit = stamp.map(Stamp::unit).or(name.unit.filter(|unit| *unit != own));
    match unit {
        Some(unit) => format!("  {quoted}: {{to: {ours}, unit: {unit}}}\n"),
        None if name.unit.is_some() => format!("  {quoted}: {ours}\n"),
        None if name.foreign => format!("  {quoted}: {ours}   # unit not known; taken as {own}\n"),
        None => format!("  {quoted}: {ours}   # no unit in the name: {own}?\n"),
    }
}

/// Our names of the columns that a file needs: a controller's has joints, a tracker's coordinates; one in which neither is found may be
/// either.
fn needed(found: &[String], robot: &Robot) -> Vec<String> {
    const COORDINATES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
    let tracker = found.iter().any(|t| COORDINATES.contains(&t.as_str()));
    let controller = found.iter().any(|t| t.starts_with("cmd_") || t.starts_with("enc_"));
    let mut needed = vec!["t_s".to_string()];
    if controller || !tracker {
        needed.extend(robot.axis_joints().map(|j| joint_column("cmd", j)));
    }
    if tracker || !controller {
        needed.extend(COORDINATES.map(String::from));
    }
    needed
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
mod tests;
