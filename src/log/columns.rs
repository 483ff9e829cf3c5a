//! Which column of a file is what, and how its numbers become SI.
//!
//! The contract's names carry their unit (`cmd_A1_deg`, `x_mm`). A log with other names, units, a semicolon or a decimal
//! comma is read through a column map:
//!
//! ```yaml
//! schema: lostmotion/columns/1
//! separator: ";"                 # one character or `tab`; a comma where absent
//! decimal: ","                   # a point where absent
//! columns:                       # theirs: ours
//!   Zeit: {to: t_s, unit: ms}
//!   Achse1: {to: cmd_A1_deg, unit: rad, sign: -1}
//!   X: {to: x_mm, unit: m, scale: 1.0000021}
//!   Y: y_mm                      # the unit of our name
//!   Z: {to: z_mm, missing: [nan, 0]}  # such a cell is an empty one
//!   Stamp: {to: t_s, unit: iso8601}  # seconds since the first row; `hms`, `dmy_hms` and `mdy_hms` likewise
//!   cmd_A1_deg: ignore           # theirs, but not what we mean by it
//! ```
//!
//! A map that ships with the program holds for any robot and many files: `cmd_#1` is the command of the first axis, `partial: true`
//! passes over names that a file lacks, `separator: any` takes the one that cuts the header into most fields (a blank only where
//! no other does), `decimal: any` takes a comma where the first row has one between digits and it separates no fields.
//!
//! How it fails: a name that says "command of a joint" for a joint or unit the robot does not have is refused, because
//! dropping it without a message would move the wrong axes; names that say nothing to us are passed over.
//!
//! Parts:
//! - [`mod@resolve`]: header and map joined, so that each column has a meaning and a unit.

mod resolve;

pub use super::meaning::{Meaning, meaning};
use super::timestamp::Stamp;
use crate::error::{Error, Result};
use crate::io::{input, yaml::Document};
use crate::robot::{JointKind, Robot};
use indexmap::IndexMap;
pub(super) use resolve::{Column, resolve};
use serde::Deserialize;
use serde_yaml::{Mapping, Value};
use std::path::Path;

/// The schema that a column map names.
pub const SCHEMA: &str = "lostmotion/columns/1";

/// Units of a column map: name, dimension, SI per unit.
const UNITS: &[(&str, char, f64)] = &[
    ("deg", 'a', std::f64::consts::PI / 180.0),
    ("rad", 'a', 1.0),
    ("mrad", 'a', 1e-3),
    ("mm", 'l', 1e-3),
    ("m", 'l', 1.0),
    ("um", 'l', 1e-6),
    ("in", 'l', 0.0254),
    ("s", 't', 1.0),
    ("ms", 't', 1e-3),
    ("us", 't', 1e-6),
    ("mm_s", 'v', 1e-3),
    ("m_s", 'v', 1.0),
];

/// [`ColumnMap::separator`] of a map for files with any of the known ones.
const ANY_SEPARATOR: u8 = 0;
/// [`ColumnMap::decimal`] of a map for files with either.
const ANY_DECIMAL: u8 = 0;

pub(crate) fn unit_named(name: &str) -> Option<(char, f64)> {
    // values of dates and times are microseconds
    if Stamp::named(name).is_some() {
        return Some(('t', 1e-6));
    }
    UNITS.iter().find(|u| u.0 == name).map(|u| (u.1, u.2))
}

/// Every unit of a column map.
pub fn unit_names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|u| u.0).chain(Stamp::ALL.map(|s| s.1))
}

/// What a file writes instead of an empty cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Missing {
    /// A text, case ignored (`nan`, `n/a`).
    Text(String),
    /// A number, however it is written (`0`, `0.000`).
    Number(f64),
}

impl Missing {
    /// Whether a cell stands for an empty one.
    pub(super) fn is(&self, text: &str, decimal: u8) -> bool {
        match self {
            Self::Text(t) => text.to_lowercase() == *t,
            Self::Number(n) => text.replace(decimal as char, ".").parse::<f64>() == Ok(*n),
        }
    }
}

/// One line of a column map.
#[derive(Debug, Clone, PartialEq)]
struct Entry {
    /// Contract's name; `None`: the column is to be passed over.
    to: Option<String>,
    unit: Option<String>,
    /// Sign times scale.
    factor: f64,
    missing: Vec<Missing>,
}

/// A column map: their names to ours, with unit, sign and scale, and how the file writes separator and decimals.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    name: String,
    /// Byte between fields.
    pub separator: u8,
    /// Byte before the decimals.
    pub decimal: u8,
    /// Names that a file lacks are passed over.
    partial: bool,
    /// Topic of a recording with several.
    pub topic: Option<String>,
    entries: IndexMap<String, Entry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MapFile {
    schema: String,
    #[serde(default)]
    separator: Option<String>,
    #[serde(default)]
    decimal: Option<String>,
    #[serde(default)]
    partial: bool,
    #[serde(default)]
    topic: Option<String>,
    #[serde(default)]
    columns: Mapping,
}

impl ColumnMap {
    /// Reads and checks a column map, or takes one that ships with the program ([`super::maps`]).
    pub fn load(path: &Path) -> Result<Self> {
        if let Some(map) = path.to_str().filter(|_| !path.exists()).and_then(super::maps::named) {
            return map;
        }
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text)
    }

    /// Parses and checks the text of a column map; `name` stands in messages.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let doc = Document { name, text };
        let file: MapFile = doc.parse_schema("a column map", SCHEMA)?;
        doc.require_schema(&file.schema, SCHEMA)?;
        let separator = match file.separator.as_deref() {
            None => b',',
            Some("tab" | "\t") => b'\t',
            Some(",") => b',',
            Some(";") => b';',
            Some("|") => b'|',
            Some(" ") => b' ',
            Some("any") => ANY_SEPARATOR,
            Some(other) => {
                let place = doc.place(&["separator"]);
                return Err(Error::bad(
                    place,
                    format!("separator `{other}`"),
                    "`,`, `;`, `|`, a blank, `tab` or `any`",
                ));
            }
        };
        let decimal = match file.decimal.as_deref() {
            None | Some(".") => b'.',
            Some(",") => b',',
            Some("any") => ANY_DECIMAL,
            Some(other) => {
                return Err(Error::bad(doc.place(&["decimal"]), format!("decimal `{other}`"), "`.`, `,` or `any`"));
            }
        };
        if separator == decimal && separator == b',' {
            let place = doc.place(&["decimal"]);
            return Err(Error::bad(place, "a comma both as separator and as decimal mark", "two different characters"));
        }
        let mut entries = IndexMap::new();
        for (key, value) in &file.columns {
            let Value::String(theirs) = key else {
                let place = doc.place(&["columns"]);
                return Err(Error::bad(place, "a column name that is not text", "`their name: our name`, quoted"));
            };
            entries.insert(theirs.trim().to_string(), entry(theirs, value, &doc)?);
        }
        Ok(Self { name: name.into(), separator, decimal, partial: file.partial, topic: file.topic, entries })
    }

    /// The map of a ROS 2 recording, where none is given: positions of joints with the robot's names are commands.
    pub fn of_recording(robot: &Robot) -> Self {
        let entry = |to: String, unit: Option<&str>| Entry {
            to: Some(to),
            unit: unit.map(String::from),
            factor: 1.0,
            missing: Vec::new(),
        };
        let mut entries = IndexMap::from([("t_s".to_string(), entry("t_s".into(), None))]);
        for joint in robot.axis_joints() {
            let (name, unit) = (&joint.name, joint.kind.unit());
            let si = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
            entries.insert(format!("position.{name}"), entry(format!("cmd_{name}_{unit}"), Some(si)));
            entries.insert(format!("effort.{name}"), entry(format!("torque_{name}_nm"), None));
        }
        for (theirs, ours) in [("x", "x_mm"), ("y", "y_mm"), ("z", "z_mm")] {
            entries.insert(theirs.into(), entry(ours.into(), Some("m")));
        }
        for name in ["qw", "qx", "qy", "qz"] {
            entries.insert(name.into(), entry(name.into(), None));
        }
        let name = "a ROS 2 recording".into();
        Self { name, separator: b',', decimal: b'.', partial: true, topic: None, entries }
    }

    /// Separator of a file: the map's, or the one that cuts the header into most fields.
    pub fn separator_of(&self, bytes: &[u8]) -> u8 {
        if self.separator != ANY_SEPARATOR {
            return self.separator;
        }
        let header = rows_of(bytes).next().unwrap_or_default();
        let fields = |c: u8| memchr::memchr_iter(c, header).count();
        // the first of those that give the same cells; a decimal comma separates nothing, and a blank stands in names, too
        let known = [b',', b';', b'\t', b'|'].into_iter().filter(|c| *c != self.decimal);
        known.rev().filter(|c| fields(*c) > 0).max_by_key(|c| fields(*c)).unwrap_or(b' ')
    }

    /// Byte before the decimals of a file with this separator: the map's, or what the first row of numbers shows.
    pub fn decimal_of(&self, bytes: &[u8], separator: u8) -> u8 {
        let digit = |b: Option<&u8>| b.is_some_and(u8::is_ascii_digit);
        let first = || rows_of(bytes).nth(1).unwrap_or_default();
        let comma = |row: &[u8]| {
            memchr::memchr_iter(b',', row).any(|k| k > 0 && digit(row.get(k - 1)) && digit(row.get(k + 1)))
        };
        match self.decimal {
            ANY_DECIMAL if separator != b',' && comma(first()) => b',',
            ANY_DECIMAL => b'.',
            given => given,
        }
    }
}

/// Rows of a text, comments and empty lines left out.
fn rows_of(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).filter(|l| !l.is_empty() && !l.starts_with(b"#"))
}

/// How a map describes a column, for files that are no logs.
#[derive(Debug, Clone, Copy)]
pub struct Mapped<'a> {
    /// Our name; `None`: the column is to be passed over.
    pub to: Option<&'a str>,
    /// Unit of the column in the file; `None`: the unit of the contract.
    pub unit: Option<&'a str>,
    /// Sign times scale.
    pub factor: f64,
    entry: &'a Entry,
}

impl Mapped<'_> {
    /// Whether a cell counts as empty.
    pub fn is_missing(&self, text: &str, decimal: u8) -> bool {
        self.entry.missing.iter().any(|m| m.is(text, decimal))
    }
}

impl ColumnMap {
    /// How the map describes their column.
    pub fn of(&self, theirs: &str) -> Option<Mapped<'_>> {
        let entry = self.entries.get(theirs)?;
        Some(Mapped { to: entry.to.as_deref(), unit: entry.unit.as_deref(), factor: entry.factor, entry })
    }

    /// Their columns that the map names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// The map's own file name.
    pub fn file(&self) -> &str {
        &self.name
    }
}

/// What stands for a missing cell: a number, a text, or a list of them.
fn listed_missing(value: &Value) -> Option<Vec<Missing>> {
    let listed = match value {
        Value::Sequence(all) => all.as_slice(),
        one => std::slice::from_ref(one),
    };
    let one = |v: &Value| match (v.as_f64(), v.as_str()) {
        (Some(n), _) if !n.is_nan() => Some(Missing::Number(n)),
        (Some(_), _) => Some(Missing::Text("nan".into())), // `.nan` is a number of YAML
        (None, Some(text)) if !text.trim().is_empty() => Some(Missing::Text(text.trim().to_lowercase())),
        _ => None,
    };
    listed.iter().map(one).collect()
}

fn entry(theirs: &str, value: &Value, doc: &Document) -> Result<Entry> {
    let bad = |key: &str, found: String, expected: &str| {
        Error::bad(doc.place(&[theirs, key]), format!("{found} of column `{theirs}`"), expected)
    };
    let to = |name: &str| (name != "ignore").then(|| name.trim().to_string());
    let map = match value {
        Value::String(name) => return Ok(Entry { to: to(name), unit: None, factor: 1.0, missing: Vec::new() }),
        Value::Mapping(map) => map,
        _ => {
            return Err(bad(
                "",
                "no name".into(),
                "our name, `ignore`, or `{to: NAME, unit: UNIT, sign: -1, scale: 1}`",
            ));
        }
    };
    let (mut name, mut unit, mut sign, mut scale) = (None, None, 1.0, 1.0);
    let mut missing = Vec::new();
    for (key, v) in map {
        let key = key.as_str().unwrap_or("");
        match key {
            "to" => match v.as_str() {
                Some(s) => name = Some(s),
                None => return Err(bad(key, "a `to` that is not text".into(), "our name, e.g. `cmd_A1_deg`")),
            },
            "unit" => match v.as_str() {
                Some(s) if unit_named(s).is_some() => unit = Some(s.to_string()),
                _ => {
                    let known: Vec<&str> = unit_names().collect();
                    let found = format!("unit `{}`", v.as_str().unwrap_or("?"));
                    return Err(bad(key, found, &format!("one of {}", known.join(", "))));
                }
            },
            "sign" => match v.as_f64() {
                Some(s) if s == 1.0 || s == -1.0 => sign = s,
                _ => return Err(bad(key, "another sign".into(), "1 or -1")),
            },
            "scale" => match v.as_f64() {
                Some(s) if s.is_finite() && s > 0.0 => scale = s,
                _ => return Err(bad(key, "another scale".into(), "a finite number above 0")),
            },
            "missing" => {
                missing = listed_missing(v)
                    .ok_or_else(|| bad(key, "another `missing`".into(), "a number, a text, or a list of them"))?;
            }
            other => {
                return Err(bad(other, format!("unknown key `{other}`"), "`to`, `unit`, `sign`, `scale`, `missing`"));
            }
        }
    }
    let Some(name) = name else { return Err(bad("", "no `to`".into(), "`to: NAME`")) };
    if let Some(stamp) = unit.as_deref().filter(|u| Stamp::named(u).is_some() && sign * scale != 1.0) {
        return Err(bad(
            "unit",
            format!("a sign or scale with unit `{stamp}`"),
            "dates and times without sign or scale",
        ));
    }
    Ok(Entry { to: to(name), unit, factor: sign * scale, missing })
}

/// Some column names, for messages.
pub(crate) fn listed(header: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = header.iter().take(SHOWN).map(|h| h.trim()).collect::<Vec<_>>().join(", ");
    if header.len() > SHOWN {
        text.push_str(", ...");
    }
    text
}
