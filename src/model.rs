//! The model file `lostmotion/model/1`: a robot, the tracker's frame, and what is known to be wrong with the machine.

#![warn(missing_docs)]

use crate::effects::{Effect, EffectInstance, Target, entry};
use crate::error::{Error, Result};
use crate::io::{input, yaml, yaml::Document};
use crate::robot::{Robot, file::FrameFile, file::RobotFile};
use indexmap::IndexMap;
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};
use serde_yaml::Value;
use std::path::Path;

/// The schema that a model file names.
pub const SCHEMA: &str = "lostmotion/model/1";

/// A machine: its robot, the transform base frame -> tracker frame, its effects in the order of the file.
#[derive(Debug, Clone)]
pub struct Model {
    /// The nominal robot.
    pub robot: Robot,
    /// World frame of the robot to tracker frame; `None`: not known.
    pub registration: Option<Isometry3<f64>>,
    /// Known effects, in the order of the file.
    pub effects: Vec<EffectInstance>,
    /// Side of the gap on which each axis starts: -1, 0 or +1.
    pub initial_gap_side: Vec<i8>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    schema: String,
    robot: Value,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    registration: Option<FrameFile>,
    #[serde(default, alias = "preload", skip_serializing_if = "IndexMap::is_empty")]
    initial_gap_side: IndexMap<String, i8>,
    #[serde(default)]
    effects: Vec<Value>,
}

impl Model {
    /// A machine without faults.
    pub fn ideal(robot: Robot) -> Self {
        let initial_gap_side = vec![0; robot.dof()];
        Self { robot, registration: None, effects: Vec::new(), initial_gap_side }
    }

    /// Reads and checks a model file; its `robot` is a path relative to it, or the robot inline.
    pub fn load(path: &Path) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&input.name, &text, &|relative| Robot::load(&folder.join(relative)))
    }

    /// Parses and checks the text of a model file; `find` loads a robot that is given by its path.
    pub fn parse(name: &str, text: &str, find: &dyn Fn(&str) -> Result<Robot>) -> Result<Self> {
        let doc = Document { name, text };
        let file: ModelFile = doc.parse_schema("a model file", SCHEMA)?;
        doc.require_schema(&file.schema, SCHEMA)?;
        let robot = match &file.robot {
            Value::String(relative) => find(relative)?,
            inline => {
                let inline: RobotFile = serde_yaml::from_value(inline.clone())
                    .map_err(|e| Error::bad(doc.place(&["robot"]), e.to_string(), "a path, or a robot inline"))?;
                inline.build(&doc)?
            }
        };
        let mut model = Self::ideal(robot);
        if let Some(frame) = &file.registration {
            if frame.xyz_mm.iter().chain(&frame.rpy_deg).any(|v| !v.is_finite()) {
                return Err(Error::bad(doc.place(&["registration"]), "a number that is not finite", "finite numbers"));
            }
            model.registration = Some(frame.to_isometry());
        }
        for (name, &side) in &file.initial_gap_side {
            match model.robot.axis_named(name) {
                Some(axis) if (-1..=1).contains(&side) => model.initial_gap_side[axis] = side,
                _ => {
                    let expected = format!("a joint of {} and -1, 0 or +1", model.robot.axis_names().join(", "));
                    // `preload` is the older name of the key
                    let key = if text.contains("initial_gap_side") { "initial_gap_side" } else { "preload" };
                    return Err(Error::bad(doc.place(&[key]), format!("{key} {name}: {side}"), expected));
                }
            }
        }
        for e in &file.effects {
            model.effects.push(entry::read(e, &model.robot, &doc)?);
        }
        Ok(model)
    }

    /// The document, with `robot` as the given reference (a path relative to where it will stand).
    pub fn to_yaml(&self, robot: &str) -> Result<String> {
        yaml::to_text(&self.to_file(Value::String(robot.into())))
    }

    fn to_file(&self, robot: Value) -> ModelFile {
        let mut initial_gap_side = IndexMap::new();
        for (joint, &side) in self.robot.axis_joints().zip(&self.initial_gap_side) {
            if side != 0 {
                initial_gap_side.insert(joint.name.clone(), side);
            }
        }
        ModelFile {
            schema: SCHEMA.into(),
            robot,
            registration: self.registration.as_ref().map(FrameFile::from_isometry),
            initial_gap_side,
            effects: self.effects.iter().map(|e| entry::write(e, &self.robot)).collect(),
        }
    }

    /// The document with the robot inline, so that it stands by itself.
    pub fn to_yaml_inline(&self) -> Result<String> {
        let mut file = self.to_file(Value::Null);
        file.robot = serde_yaml::to_value(self.robot.to_file())
            .map_err(|e| Error::bad(crate::error::Place::default(), e.to_string(), "a robot that can be written"))?;
        yaml::to_text(&file)
    }

    /// Effects on one axis alone, in the order of the file; a coupling from another axis is none of them.
    pub fn effects_on(&self, axis: usize) -> impl Iterator<Item = &Effect> {
        self.effects.iter().filter(move |e| e.target == Target::Joint(axis)).map(|e| &e.effect)
    }
}
