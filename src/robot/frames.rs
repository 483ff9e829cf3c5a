//! Frames and tools by the controller's own names and numbers: of the robot file (`frames:`, `tools:`) or of a separate file.
//!
//! ```yaml
//! schema: lostmotion/frames/1
//! frames:
//!   "2": {xyz_mm: [1200, 0, 400], rpy_deg: [0, 0, 90]}     # BASE_DATA[2], user frame 2, ...
//! tools:
//!   tGripper: {xyz_mm: [0, 0, 180], rpy_deg: [0, 0, 0]}    # tooldata tGripper, tool 5, ...
//! ```
//!
//! `posture_deg: [0, -90, 90, -90, -90, 0]` gives joints near which the arm works (mm for a linear axis): they choose between arm
//! configurations where a program does not.
//!
//! A frame is given in the world of the controller, a tool in the flange frame. Case does not count, nor do blanks at the ends.
//! Files of controllers are read, too ([`controller`]).

mod controller;

use super::file::FrameFile;
use crate::error::{Error, Result};
use crate::io::{input, yaml::Document};
use nalgebra::Isometry3;
use robot_programs::bases::CarriedBases;
use robot_programs::fanuc::Registers;
use robot_programs::krl::Machine;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The schema that a frames file names.
pub const SCHEMA: &str = "lostmotion/frames/1";

/// Frames and tools that are known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frames {
    /// World frame to each named frame.
    pub frames: BTreeMap<String, Isometry3<f64>>,
    /// Flange to each named tool.
    pub tools: BTreeMap<String, Isometry3<f64>>,
    /// Joints near which the arm works, deg or mm, one per axis.
    pub posture_deg: Option<Vec<f64>>,
    /// Where the robot stands and how far its axes go, by a `$machine.dat`.
    pub machine: Option<Machine>,
    /// Registers as the controller lists them.
    pub registers: Registers,
    /// Bases that count from another machine than the world, by a `$config.dat`.
    pub carried: CarriedBases,
}

/// The document as it stands in YAML.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FramesFile {
    schema: String,
    #[serde(default)]
    frames: BTreeMap<String, FrameFile>,
    #[serde(default)]
    tools: BTreeMap<String, FrameFile>,
    #[serde(default)]
    posture_deg: Option<Vec<f64>>,
}

/// How a name is looked up.
fn key(name: &str) -> String {
    name.trim().to_ascii_lowercase()
}

impl Frames {
    /// Reads a frames file.
    pub fn load(path: &Path) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text)
    }

    /// Parses the text of a frames file; `name` stands in messages.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        if let Some(read) = controller::read(name, text) {
            return read;
        }
        let doc = Document { name, text };
        let file: FramesFile = doc.parse_schema("a file of frames and tools", SCHEMA)?;
        doc.require_schema(&file.schema, SCHEMA)?;
        if let Some(v) = file.posture_deg.iter().flatten().find(|v| !v.is_finite()) {
            return Err(Error::bad(doc.place(&["posture_deg"]), format!("{v} in `posture_deg`"), "finite numbers"));
        }
        let (frames, tools) = (checked(&file.frames, &doc)?, checked(&file.tools, &doc)?);
        Ok(Self { frames, tools, posture_deg: file.posture_deg, ..Self::default() })
    }

    /// The frame of this name, in any case of letters.
    pub fn frame(&self, name: &str) -> Option<&Isometry3<f64>> {
        self.frames.get(&key(name))
    }

    /// The tool of this name, in any case of letters.
    pub fn tool(&self, name: &str) -> Option<&Isometry3<f64>> {
        self.tools.get(&key(name))
    }

    /// These, and those of `over` in their place where both have a name.
    pub fn with(&self, over: &Self) -> Self {
        let mut out = self.clone();
        out.frames.extend(over.frames.iter().map(|(k, v)| (k.clone(), *v)));
        out.tools.extend(over.tools.iter().map(|(k, v)| (k.clone(), *v)));
        if over.machine.is_some() {
            out.machine.clone_from(&over.machine);
        }
        out.registers.positions.extend(over.registers.positions.clone());
        out.carried.add(&over.carried);
        if over.posture_deg.is_some() {
            out.posture_deg.clone_from(&over.posture_deg);
        }
        out
    }
}

/// Frames of a document by their keys.
pub(super) fn checked(
    frames: &BTreeMap<String, FrameFile>,
    doc: &Document,
) -> Result<BTreeMap<String, Isometry3<f64>>> {
    let mut out = BTreeMap::new();
    for (name, frame) in frames {
        let values = frame.xyz_mm.iter().chain(&frame.rpy_deg);
        if let Some(v) = values.clone().find(|v| !v.is_finite()) {
            return Err(Error::bad(doc.place(&[name]), format!("{v} in the frame `{name}`"), "finite numbers"));
        }
        if out.insert(key(name), frame.to_isometry()).is_some() {
            return Err(Error::bad(
                doc.place(&[name]),
                format!("a second frame `{name}`"),
                "names that differ, case ignored",
            ));
        }
    }
    Ok(out)
}

/// Frames, tools and calls that moves wait for, with the number of these moves, and how many wait for a posture of the arm.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Missing {
    /// Unknown frames, with the number of moves that use each.
    pub frames: BTreeMap<String, u64>,
    /// Unknown tools, with the number of moves that use each.
    pub tools: BTreeMap<String, u64>,
    /// Number of moves whose posture at the start is not known.
    pub posture: u64,
    /// Programs, macros and routines that no file contains, with the number of moves before which each is called: they stay unchanged,
    /// because it may move the robot.
    pub calls: BTreeMap<String, u64>,
}

impl Missing {
    /// Whether nothing is missing.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty() && self.tools.is_empty() && self.posture == 0 && self.calls.is_empty()
    }

    /// Adds what another program waits for.
    pub fn add(&mut self, other: &Self) {
        self.posture += other.posture;
        let Self { frames, tools, calls, .. } = self;
        for (sum, more) in [(frames, &other.frames), (tools, &other.tools), (calls, &other.calls)] {
            for (name, moves) in more {
                *sum.entry(name.clone()).or_default() += moves;
            }
        }
    }

    /// A frames file to fill in: every name with the number of moves that need it.
    pub fn template(&self) -> String {
        let mut out = format!(
            "# Frames and tools that the programs name and that are not known. Enter the values of the controller: a frame in the\n\
             # world, a tool in the flange frame; mm, and fixed-axis X, then Y, then Z in degrees (C, B, A of a KUKA frame; W, P, R\n\
             # of a FANUC frame). Leave out what you do not know: the moves that need it stay as they are.\nschema: {SCHEMA}\n"
        );
        for (what, names) in [("frames", &self.frames), ("tools", &self.tools)] {
            if names.is_empty() {
                let _ = writeln!(out, "{what}: {{}}");
                continue;
            }
            let _ = writeln!(out, "{what}:");
            for (name, moves) in names {
                let word = if *moves == 1 { "move" } else { "moves" };
                // JSON strings are YAML strings
                let quoted = serde_json::Value::from(name.as_str());
                let _ =
                    writeln!(out, "  {quoted}: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}   # needed by {moves} {word}");
            }
        }
        if self.posture > 0 {
            let _ = writeln!(
                out,
                "# Joints near which the arm works, one number per axis, such as [0, -90, 90, -90, -90, 0]: they choose between arm\n\
                 # configurations where a program starts at a Cartesian target and names none. Moves that need them: {}.\n\
                 posture_deg: null",
                self.posture
            );
        }
        self.template_of_calls(&mut out);
        out
    }

    /// Calls, which a robot file or an option declares.
    fn template_of_calls(&self, out: &mut String) {
        if self.calls.is_empty() {
            return;
        }
        out.push_str(
            "# Programs, macros and routines that no file contains. Name those that move nothing and leave frames and tools as they are\n\
             # in the robot file (no_motion: [...]):\n",
        );
        for (name, moves) in &self.calls {
            let word = if *moves == 1 { "move waits" } else { "moves wait" };
            let _ = writeln!(out, "#   {name}: {moves} {word} for it");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_any_case_and_a_file_goes_before_the_robot() {
        let text = "schema: lostmotion/frames/1\nframes:\n  wobjTable: {xyz_mm: [1, 2, 3], rpy_deg: [0, 0, 90]}\n  \"2\": {xyz_mm: [4, 0, 0]}\n";
        let frames = Frames::parse("f.yaml", text).unwrap();
        assert_eq!(frames.frame("WOBJTABLE").unwrap().translation.vector.x, 1e-3);
        assert!(frames.frame("3").is_none() && frames.tool("2").is_none());
        let over =
            Frames::parse("g.yaml", "schema: lostmotion/frames/1\nframes: {\"2\": {xyz_mm: [5, 0, 0]}}\n").unwrap();
        let both = frames.with(&over);
        assert_eq!(both.frame("2").unwrap().translation.vector.x, 5e-3);
        assert!(both.frame("wobjtable").is_some());
    }

    #[test]
    fn the_template_is_a_file_that_is_read_with_every_name() {
        let missing = Missing {
            frames: [("2".to_string(), 12), ("a \"b\": #".to_string(), 1)].into(),
            tools: [("tGripper".to_string(), 3)].into(),
            posture: 5,
            calls: [("CLEAR USER PAGE".to_string(), 2)].into(),
        };
        let text = missing.template();
        assert!(text.contains("needed by 12 moves") && text.contains("needed by 1 move\n"), "{text}");
        let frames = Frames::parse("t.yaml", &text).unwrap();
        assert!(
            frames.frame("2").is_some() && frames.frame("A \"B\": #").is_some() && frames.tool("tgripper").is_some()
        );
        assert!(text.contains("#   CLEAR USER PAGE: 2 moves wait for it\n"), "{text}");
        assert!(text.contains("need them: 5.") && frames.posture_deg.is_none());
        assert!(Frames::parse("t.yaml", &Missing::default().template()).is_ok());
        let given = text.replace("posture_deg: null", "posture_deg: [0, -90, 90.5]");
        assert_eq!(Frames::parse("t.yaml", &given).unwrap().posture_deg, Some(vec![0.0, -90.0, 90.5]));
    }

    #[test]
    fn a_frame_that_is_not_finite_and_another_document_are_refused() {
        for (text, words) in [
            (
                "schema: lostmotion/frames/1\nframes: {B9: {xyz_mm: [.nan, 0, 0]}}\n",
                "f.yaml:2: found NaN in the frame `B9`",
            ),
            ("schema: lostmotion/frames/1\nposture_deg: [.inf]\n", "f.yaml:2: found inf in `posture_deg`"),
            ("schema: lostmotion/robot/1\n", "f.yaml:1: found schema `lostmotion/robot/1`"),
            ("schema: lostmotion/frames/1\nframes: {q9: {}, Q9: {}}\n", "f.yaml:2: found a second frame"),
        ] {
            let e = Frames::parse("f.yaml", text).unwrap_err().to_string();
            assert!(e.starts_with(words), "{e}");
        }
    }
}
