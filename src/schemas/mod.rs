//! JSON Schemas of the documents, made from the types and tables that read and write them.
//!
//! Most are derived from their types; `model` takes the effects and their keys from the catalogue; `compensator`,
//! `columns` and `gaps` are written beside the code that reads them, as their keys depend on the kind of a joint. The few documents of
//! results that have no schema here are described in the contract of docs/.
//!
//! `shape` has the words of JSON Schema that are written by hand.
//!
//! Tests hold every sample and every robot of the library against its schema, and that a misspelt key is refused by both.
//!
//! # Example
//!
//! ```
//! use lostmotion::schemas::{NAMES, of};
//!
//! assert!(NAMES.iter().all(|(name, _)| of(name).is_some()));
//! let robot = of("robot").expect("a schema");
//! let required = robot["required"].as_array().expect("keys that a robot file must have");
//! assert!(required.iter().any(|key| key == "joints"));
//! ```

#![warn(missing_docs)]

mod shape;

use crate::assess::{
    bidirectional::document as bidirectional, circle::document as circle, deadzone, program::document as program,
};
use crate::diagnose::result::document as diagnosis;
use crate::effects::catalogue;
use crate::plan::document as plan;
use crate::rewrite::{guard, summary};
use crate::robot::file::RobotFile;
use crate::robot::frames;
use crate::track::document as track;
use crate::{compensator, gaps, join, learn, log::columns, model, robot};
use indexmap::IndexMap;
use serde_json::Value;
use shape::{Shape, list, number, object, one_of, open, text, union};
use std::path::Path;

/// First line of a YAML file that is written for a user: editors complete and check by it. Only where `lostmotion schema` has put the
/// schema beside the file: without a public address there is no other place to name, and editors complain of a schema that they do not
/// find.
pub fn editor_line(output: &Path, document: &str) -> String {
    let schema = format!("{document}.schema.json");
    let there = !crate::error::is_stdio(output) && output.with_file_name(&schema).is_file();
    if there { format!("# yaml-language-server: $schema={schema}\n") } else { String::new() }
}

/// Documents that have a schema, and what each is.
pub const NAMES: [(&str, &str); 18] = [
    ("bidirectional", "what `assess bidirectional` found"),
    ("circle", "what `assess circle` found"),
    ("columns", "column map of a log"),
    ("compensator", "offsets by joint"),
    ("deadzone", "what `assess deadzone` found"),
    ("diagnosis", "what `diagnose` found"),
    ("frames", "frames and tools of a controller"),
    ("gaps", "what an identification found"),
    ("join", "what `join` found"),
    ("kinematics", "learned kinematics"),
    ("learning", "what `learn` reached"),
    ("model", "a robot and what is wrong with it"),
    ("plan", "what `plan-experiment` chose"),
    ("program-assessment", "what `assess program` found"),
    ("rewrite", "what `rewrite` did to a program"),
    ("rewritten", "note beside a rewritten program"),
    ("robot", "robot file"),
    ("tracking", "what `track` reached"),
];

/// The schema of a document by its short name.
pub fn of(name: &str) -> Option<Value> {
    let (schema, mut body) = match name {
        "bidirectional" => (bidirectional::SCHEMA, written::<bidirectional::Document>()),
        "circle" => (circle::SCHEMA, written::<circle::Document>()),
        "columns" => (columns::SCHEMA, column_map().value()),
        "compensator" => (compensator::file::SCHEMA, compensator().value()),
        "deadzone" => (deadzone::SCHEMA, written::<deadzone::Document>()),
        "diagnosis" => (diagnosis::SCHEMA, written::<diagnosis::Diagnosis>()),
        "frames" => (frames::SCHEMA, derived::<frames::FramesFile>()),
        "gaps" => (gaps::file::SCHEMA, gaps().value()),
        "join" => (join::SCHEMA, derived::<join::Report>()),
        "kinematics" => (learn::file::SCHEMA, derived::<learn::file::KinematicsFile>()),
        "learning" => (learn::document::SCHEMA, written::<learn::document::Learning>()),
        "model" => (model::SCHEMA, model().value()),
        "plan" => (plan::SCHEMA, written::<plan::Plan>()),
        "program-assessment" => (program::SCHEMA, written::<program::Document>()),
        "rewrite" => (summary::SCHEMA, written::<summary::Document>()),
        "rewritten" => (guard::SCHEMA, derived::<guard::Note>()),
        "robot" => (robot::file::SCHEMA, derived::<RobotFile>()),
        "tracking" => (track::SCHEMA, written::<track::Tracking>()),
        _ => return None,
    };
    body["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    body["title"] = schema.into();
    body["properties"]["schema"] = Shape::constant(schema).value();
    if name == "robot" {
        body["$defs"]["JointFile"]["properties"]["kind"] = one_of(["revolute", "prismatic"]).value();
        body["properties"]["convention"] = one_of(["dh-standard", "dh-modified"]).value();
    }
    Some(body)
}

fn derived<T: schemars::JsonSchema>() -> Value {
    serde_json::to_value(schemars::schema_for!(T)).unwrap_or_default()
}

/// A document that the program only writes: entries that may be absent are not required.
fn written<T: schemars::JsonSchema>() -> Value {
    let generator = schemars::generate::SchemaSettings::draft2020_12().for_serialize().into_generator();
    serde_json::to_value(generator.into_root_schema_for::<T>()).unwrap_or_default()
}

/// A frame: fixed-axis X, then Y, then Z.
fn frame() -> Shape {
    let three = || list(number()).of_length(3);
    open([("xyz_mm", three()), ("rpy_deg", three())])
}

fn model() -> Shape {
    let mut keys: IndexMap<String, Shape> = IndexMap::new();
    for effect in catalogue::ALL {
        // a parameter may have several keys: `decay_s or decay_deg`
        let all = effect.parameters.iter().flat_map(|(names, meaning)| {
            names.split(", ").flat_map(|n| n.split(" or ")).map(move |key| (key.trim(), meaning))
        });
        for (key, meaning) in all {
            for key in [key.to_string(), key.replace("_deg", "_mm")] {
                let described = || Shape::default().described(format!("{}: {meaning}", effect.name));
                keys.entry(key).or_insert_with(described);
            }
        }
    }
    keys.insert("effect".into(), one_of(catalogue::ALL.iter().map(|e| e.name)));
    keys.insert("joint".into(), text());
    keys.insert("target".into(), text());
    let robot = union([text(), Shape::any_object()]).described("path relative to this file, or the robot inline");
    object([
        ("robot", robot),
        ("registration", frame()),
        ("initial_gap_side", Shape::any_object()),
        ("preload", Shape::any_object()),
        ("effects", list(object(keys).requires(&["effect"]))),
    ])
    .requires(&["schema", "robot"])
}

fn schedule() -> Shape {
    open([
        ("kind", one_of(["constant", "pchip", "polynomial"])),
        ("knots", list(list(number()).of_length(2))),
        ("coefficients", list(number())),
    ])
    .requires(&["kind"])
}

fn robot_reference() -> Shape {
    open([("name", text()), ("sha256", text())]).requires(&["sha256"])
}

fn compensator() -> Shape {
    let sizes = ["half_gap_deg", "half_gap_mm", "positive_deg", "positive_mm", "negative_deg", "negative_mm"];
    let backlash = object(sizes.map(|key| (key, number())).into_iter().chain([("schedule", schedule())]));
    let joint = open([("backlash", backlash), ("friction", Shape::any_object())]);
    object([
        ("robot", robot_reference()),
        ("valid_until", text().described("YYYY-MM-DD")),
        ("joints", Shape::map_of(joint)),
        ("evidence", Shape::default()),
    ])
    .requires(&["schema", "robot", "joints"])
}

fn column_map() -> Shape {
    let entry = object([
        ("to", text()),
        ("unit", one_of(columns::unit_names())),
        ("sign", one_of([1, -1])),
        ("scale", number()),
        ("missing", Shape::default().described("what the file writes for a reading that failed")),
    ])
    .requires(&["to"]);
    object([
        ("separator", one_of([",", ";", "|", " ", "tab", "\t", "any"])),
        ("decimal", one_of([".", ",", "any"])),
        ("partial", Shape::typed("boolean")),
        ("topic", text()),
        ("columns", Shape::map_of(union([text(), entry]))),
    ])
    .requires(&["schema"])
}

fn gaps() -> Shape {
    let joint = || open([("joint", text())]).requires(&["joint"]);
    let pair = || list(number()).of_length(2);
    let agreement = open([
        ("all_logs_deg", number()),
        ("all_logs_mm", number()),
        ("all_logs_ci95", pair()),
        ("single_reversals_deg", number()),
        ("single_reversals_mm", number()),
        ("single_reversals_ci95", pair()),
        ("agree", Shape::typed("boolean")),
        ("used", text()),
        ("reason", text()),
    ])
    .requires(&["agree", "used"])
    .described(
        "lost motion after a reversal by the fit of all logs and by single reversals, and which of them is used",
    );
    open([
        ("robot", robot_reference()),
        ("registration", union([frame(), Shape::typed("null")])),
        ("points", list(joint())),
        ("joints", list(open([("joint", text()), ("agreement", agreement)]).requires(&["joint"]))),
    ])
    .requires(&["schema", "robot", "joints"])
}
