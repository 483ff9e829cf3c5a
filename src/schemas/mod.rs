//! JSON Schemas of the documents, made from the types and tables that read and write them.
//!
//! Most are derived from their types; `model` takes the effects and their keys from the catalogue; `compensator`,
//! `columns` and `gaps` are written beside the code that reads them, as their keys depend on the kind of a joint. The few documents of
//! results that have no schema here are described in the contract of docs/.
//!
//! Tests hold every sample and every robot of the library against its schema, and that a misspelt key is refused by both.

#![warn(missing_docs)]

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
use serde_json::{Value, json};

/// First line of a robot file that is written for a user: editors complete and check by it, once `lostmotion schema robot --output
/// robot.schema.json` has put the schema beside the file.
pub const EDITOR_LINE: &str = "# yaml-language-server: $schema=robot.schema.json\n";

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
        "columns" => (columns::SCHEMA, column_map()),
        "compensator" => (compensator::file::SCHEMA, compensator()),
        "deadzone" => (deadzone::SCHEMA, written::<deadzone::Document>()),
        "diagnosis" => (diagnosis::SCHEMA, written::<diagnosis::Diagnosis>()),
        "frames" => (frames::SCHEMA, derived::<frames::FramesFile>()),
        "gaps" => (gaps::file::SCHEMA, gaps()),
        "join" => (join::SCHEMA, derived::<join::Report>()),
        "kinematics" => (learn::file::SCHEMA, derived::<learn::file::KinematicsFile>()),
        "learning" => (learn::document::SCHEMA, written::<learn::document::Learning>()),
        "model" => (model::SCHEMA, model()),
        "plan" => (plan::SCHEMA, written::<plan::Plan>()),
        "program-assessment" => (program::SCHEMA, written::<program::Document>()),
        "rewrite" => (summary::SCHEMA, written::<summary::Document>()),
        "rewritten" => (guard::SCHEMA, derived::<guard::Note>()),
        "robot" => (robot::file::SCHEMA, derived::<RobotFile>()),
        "tracking" => (track::SCHEMA, written::<track::Tracking>()),
        _ => return None,
    };
    body["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    body["title"] = json!(schema);
    body["properties"]["schema"] = json!({"const": schema});
    if name == "robot" {
        body["$defs"]["JointFile"]["properties"]["kind"] = json!({"enum": ["revolute", "prismatic"]});
        body["properties"]["convention"] = json!({"enum": ["dh-standard", "dh-modified"]});
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
fn frame() -> Value {
    let three = json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3});
    json!({"type": "object", "properties": {"xyz_mm": three, "rpy_deg": three}})
}

fn model() -> Value {
    let mut keys = serde_json::Map::new();
    for effect in catalogue::ALL {
        // a parameter may have several keys: `decay_s or decay_deg`
        let all = effect.parameters.iter().flat_map(|(names, meaning)| {
            names.split(", ").flat_map(|n| n.split(" or ")).map(move |key| (key.trim(), meaning))
        });
        for (key, meaning) in all {
            let unit = |to: &str| key.replace("_deg", to);
            for key in [key.to_string(), unit("_mm")] {
                keys.entry(key).or_insert_with(|| json!({"description": format!("{}: {meaning}", effect.name)}));
            }
        }
    }
    let names: Vec<&str> = catalogue::ALL.iter().map(|e| e.name).collect();
    keys.insert("effect".into(), json!({"enum": names}));
    keys.insert("joint".into(), json!({"type": "string"}));
    keys.insert("target".into(), json!({"type": "string"}));
    json!({
        "type": "object", "required": ["schema", "robot"], "additionalProperties": false,
        "properties": {
            "robot": {"description": "path relative to this file, or the robot inline", "anyOf": [{"type": "string"}, {"type": "object"}]},
            "registration": frame(),
            "initial_gap_side": {"type": "object"},
            "preload": {"type": "object"},
            "effects": {"type": "array", "items": {
                "type": "object", "required": ["effect"], "additionalProperties": false, "properties": keys,
            }},
        },
    })
}

fn schedule() -> Value {
    json!({"type": "object", "required": ["kind"], "properties": {
        "kind": {"enum": ["constant", "pchip", "polynomial"]},
        "knots": {"type": "array", "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}},
        "coefficients": {"type": "array", "items": {"type": "number"}},
    }})
}

fn robot_reference() -> Value {
    json!({"type": "object", "required": ["sha256"], "properties": {"name": {"type": "string"}, "sha256": {"type": "string"}}})
}

fn compensator() -> Value {
    let number = json!({"type": "number"});
    let backlash = json!({"type": "object", "additionalProperties": false, "properties": {
        "half_gap_deg": number, "half_gap_mm": number, "positive_deg": number, "positive_mm": number,
        "negative_deg": number, "negative_mm": number, "schedule": schedule(),
    }});
    json!({
        "type": "object", "required": ["schema", "robot", "joints"], "additionalProperties": false,
        "properties": {
            "robot": robot_reference(),
            "valid_until": {"description": "YYYY-MM-DD", "type": "string"},
            "joints": {"type": "object", "additionalProperties": {
                "type": "object", "properties": {"backlash": backlash, "friction": {"type": "object"}},
            }},
            "evidence": {},
        },
    })
}

fn column_map() -> Value {
    let units: Vec<&str> = columns::unit_names().collect();
    let missing = json!({"description": "what the file writes for a reading that failed"});
    let entry = json!({"type": "object", "required": ["to"], "additionalProperties": false, "properties": {
        "to": {"type": "string"}, "unit": {"enum": units}, "sign": {"enum": [1, -1]}, "scale": {"type": "number"}, "missing": missing,
    }});
    json!({
        "type": "object", "required": ["schema"], "additionalProperties": false,
        "properties": {
            "separator": {"enum": [",", ";", "|", " ", "tab", "\t", "any"]},
            "decimal": {"enum": [".", ",", "any"]},
            "partial": {"type": "boolean"},
            "topic": {"type": "string"},
            "columns": {"type": "object", "additionalProperties": {"anyOf": [{"type": "string"}, entry]}},
        },
    })
}

fn gaps() -> Value {
    let joint = json!({"type": "object", "required": ["joint"], "properties": {"joint": {"type": "string"}}});
    json!({
        "type": "object", "required": ["schema", "robot", "joints"],
        "properties": {
            "robot": robot_reference(),
            "registration": {"anyOf": [frame(), {"type": "null"}]},
            "points": {"type": "array", "items": joint},
            "joints": {"type": "array", "items": joint},
        },
    })
}
