//! The robot file `lostmotion/robot/1`: YAML in degrees and millimetres, checked before anything is computed.
//!
//! Parts:
//! - [`joint`]: the entry of one joint, checked.
//! - [`frame`]: a frame in millimetres and degrees.

mod frame;
mod joint;

use super::frames;
use super::{Convention, Flip, GapOf, Joint, Link, Robot, gap_of};
use crate::error::{Error, Result, counted};
use crate::io::{input, yaml::Document};
pub use frame::FrameFile;
use indexmap::IndexMap;
use joint::{build_joint, finite};
use nalgebra::Vector3;
use robot_programs::control::{Control, WORDS};
use robot_programs::no_motion::NoMotion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The schema that a robot file names.
pub const SCHEMA: &str = "lostmotion/robot/1";

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FollowFile {
    pub(super) joint: String,
    pub(super) ratio: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointFile {
    pub(super) name: String,
    pub(super) kind: String,
    /// Turn about z at command 0, deg.
    #[serde(default)]
    pub(super) theta_deg: f64,
    /// Shift along z at command 0, mm.
    #[serde(default)]
    pub(super) d_mm: f64,
    /// Shift along x, mm.
    #[serde(default)]
    pub(super) a_mm: f64,
    /// Turn about x, deg.
    #[serde(default)]
    pub(super) alpha_deg: f64,
    /// Hayati's turn about y, deg, for nearly parallel axes.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(super) beta_deg: f64,
    /// 1, or -1 where a positive command turns against the axis.
    #[serde(default = "one")]
    pub(super) direction: f64,
    /// Lowest and highest command, deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) limits_deg: Option<[f64; 2]>,
    /// Lowest and highest command, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) limits_mm: Option<[f64; 2]>,
    /// Largest speed, deg/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) max_speed_deg_s: Option<f64>,
    /// Largest speed, mm/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) max_speed_mm_s: Option<f64>,
    /// Largest acceleration, deg/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) max_accel_deg_s2: Option<f64>,
    /// Largest acceleration, mm/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) max_accel_mm_s2: Option<f64>,
    /// Travel of a prismatic joint per turn of its screw, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) lead_mm_per_rev: Option<f64>,
    /// Pulses of the controller per degree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) pulses_per_deg: Option<f64>,
    /// Pulses of the controller per millimetre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) pulses_per_mm: Option<f64>,
    /// The joint that drives this one, which has no command itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) follows: Option<FollowFile>,
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub(super) struct LinkFile {
    pub(super) mass_kg: f64,
    pub(super) com_mm: [f64; 3],
}

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub(super) struct ReflectorFile {
    pub(super) xyz_mm: [f64; 3],
}

/// `tools:`: further reflectors in a list, or tools of the controller by name.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum ToolsFile {
    Reflectors(Vec<ReflectorFile>),
    Named(BTreeMap<String, FrameFile>),
}

impl Default for ToolsFile {
    fn default() -> Self {
        Self::Reflectors(Vec::new())
    }
}

impl ToolsFile {
    fn is_empty(&self) -> bool {
        match self {
            Self::Reflectors(list) => list.is_empty(),
            Self::Named(map) => map.is_empty(),
        }
    }
}

/// The document as it stands in YAML; also an inline `robot:` of a model file.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// Must be [`SCHEMA`].
    pub schema: String,
    #[serde(default)]
    pub(super) name: String,
    #[serde(default = "standard")]
    pub(super) convention: String,
    pub(super) joints: Vec<JointFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) links: Vec<LinkFile>,
    #[serde(default = "still")]
    pub(super) base: FrameFile,
    /// The maker's flange in the frame of the last joint.
    #[serde(default = "still", skip_serializing_if = "FrameFile::is_still")]
    pub(super) flange: FrameFile,
    #[serde(default = "still")]
    pub(super) tool: FrameFile,
    #[serde(default, skip_serializing_if = "ToolsFile::is_empty")]
    pub(super) tools: ToolsFile,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) frames: BTreeMap<String, FrameFile>,
    #[serde(default = "gravity")]
    pub(super) gravity_m_s2: [f64; 3],
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub(super) gap_of: IndexMap<String, String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) control: Vec<String>,
    /// Where the maker calls the wrist flipped: `positive` or `negative` (joint 5 above or below zero), `within-90` or `beyond-90` (joint
    /// 4).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) wrist_flip: Option<String>,
    /// Programs, macros and routines that move nothing and leave frames and tools as they are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) no_motion: Vec<String>,
}

fn standard() -> String {
    "dh-standard".into()
}

fn still() -> FrameFile {
    FrameFile { xyz_mm: [0.0; 3], rpy_deg: [0.0; 3] }
}

fn gravity() -> [f64; 3] {
    [0.0, 0.0, -super::STANDARD_GRAVITY_M_S2]
}

impl Robot {
    /// Reads and checks a robot file.
    pub fn load(path: &Path) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text)
    }

    /// Parses and checks the text of a robot file; `name` stands in messages.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let doc = Document { name, text };
        let file: RobotFile = doc.parse_schema("a robot file", SCHEMA)?;
        file.build(&doc)
    }
}

impl RobotFile {
    /// Checks every number and builds the robot; `doc` finds the line of what is wrong.
    pub fn build(self, doc: &Document) -> Result<Robot> {
        doc.require_schema(&self.schema, SCHEMA)?;
        let convention = match self.convention.as_str() {
            "dh-standard" => Convention::Standard,
            "dh-modified" => Convention::Modified,
            other => {
                let found = format!("convention `{other}`");
                return Err(Error::bad(doc.place(&["convention"]), found, "`dh-standard` or `dh-modified`"));
            }
        };
        let joints = self.build_joints(doc)?;
        let links = self.build_links(joints.len(), doc)?;
        for (key, f) in [("base", &self.base), ("flange", &self.flange), ("tool", &self.tool)] {
            finite(doc, key, "xyz_mm", &f.xyz_mm)?;
            finite(doc, key, "rpy_deg", &f.rpy_deg)?;
        }
        finite(doc, "gravity_m_s2", "gravity_m_s2", &self.gravity_m_s2)?;
        let mut robot = Robot::new(self.name, convention, joints, self.base.to_isometry(), self.tool.to_isometry())
            .with_flange(self.flange.to_isometry());
        robot.links = links;
        match &self.tools {
            ToolsFile::Reflectors(list) => {
                for t in list {
                    finite(doc, "tools", "xyz_mm", &t.xyz_mm)?;
                    robot.reflectors_m.push(Vector3::from(t.xyz_mm) * 1e-3);
                }
            }
            ToolsFile::Named(tools) => robot.frames.tools = frames::checked(tools, doc)?,
        }
        robot.frames.frames = frames::checked(&self.frames, doc)?;
        robot.gravity_m_s2 = Vector3::from(self.gravity_m_s2);
        robot.gap_of = gaps_of(&self.gap_of, &robot, doc)?;
        let control = Control::of_words(self.control.iter().map(String::as_str))
            .map_err(|word| Error::bad(doc.place(&["control"]), format!("control {word}"), WORDS))?;
        robot.assume(control);
        if let Some(bad) = self.no_motion.iter().find(|name| !NoMotion::is_name(name)) {
            let expected = "names of programs, macros or routines, such as `[Clear User Page, GRIP_OPEN]`";
            return Err(Error::bad(doc.place(&["no_motion"]), format!("no_motion `{bad}`"), expected));
        }
        robot.declare_no_motion(self.no_motion.iter().map(String::as_str));
        if let Some(word) = &self.wrist_flip {
            let expected =
                "`positive` or `negative` (joint 5 where the wrist is flipped), `within-90` or `beyond-90` (joint 4)";
            let bad = || Error::bad(doc.place(&["wrist_flip"]), format!("wrist_flip `{word}`"), expected);
            robot.wrist_flip = Some(Flip::of_word(word).ok_or_else(bad)?);
        }
        Ok(robot)
    }

    /// The joints, each checked, with names that differ; at least one has its own command.
    fn build_joints(&self, doc: &Document) -> Result<Vec<Joint>> {
        let none = |found: &str, expected: &str| Err(Error::bad(doc.place(&["joints"]), found, expected));
        if self.joints.is_empty() {
            return none("no joints", "at least one joint");
        }
        let mut joints: Vec<Joint> = Vec::with_capacity(self.joints.len());
        for j in &self.joints {
            let joint = build_joint(j, &self.joints, doc)?;
            if joints.iter().any(|k| k.name.eq_ignore_ascii_case(&joint.name)) {
                let found = format!("a second joint `{}`", j.name);
                return Err(Error::bad(doc.place(&[&j.name]), found, "joint names that differ, case ignored"));
            }
            joints.push(joint);
        }
        if joints.iter().all(|j| j.follows.is_some()) {
            return none("no joint with its own command", "at least one");
        }
        Ok(joints)
    }

    /// Masses: one link per joint, or none.
    fn build_links(&self, joints: usize, doc: &Document) -> Result<Vec<Link>> {
        if !self.links.is_empty() && self.links.len() != joints {
            let found = format!("{} for {}", counted(self.links.len(), "link"), counted(joints, "joint"));
            return Err(Error::bad(doc.place(&["links"]), found, "one link per joint, or none"));
        }
        for l in &self.links {
            finite(doc, "links", "mass_kg", &[l.mass_kg])?;
            finite(doc, "links", "com_mm", &l.com_mm)?;
            if l.mass_kg < 0.0 {
                let found = format!("mass_kg {}", l.mass_kg);
                return Err(Error::bad(doc.place(&["mass_kg"]), found, "a mass of 0 or more"));
            }
        }
        Ok(self.links.iter().map(|l| Link { mass_kg: l.mass_kg, com_m: Vector3::from(l.com_mm) * 1e-3 }).collect())
    }
}

/// The sums of axes to which gaps belong.
fn gaps_of(texts: &IndexMap<String, String>, robot: &Robot, doc: &Document) -> Result<Vec<GapOf>> {
    let bad = |name: &str, found: String| {
        let expected = "a joint and the sum of axes that turns its gear, such as `J3: J2 + J3`";
        Error::bad(doc.place(&["gap_of", name]), format!("gap_of {found}"), expected)
    };
    let mut all: Vec<GapOf> = Vec::new();
    for (name, text) in texts {
        let axis = robot.axis_named(name).ok_or_else(|| bad(name, format!("of `{name}`, no axis of the robot")))?;
        let gear = gap_of::read(robot, axis, text).map_err(|found| bad(name, format!("{name}: {found}")))?;
        if all.iter().any(|g| g.axis == axis) {
            return Err(bad(name, format!("{name} a second time")));
        }
        all.push(gear);
    }
    let sum = |axis: usize| all.iter().any(|g| g.axis == axis && !g.others.is_empty());
    match all.iter().find(|g| g.others.iter().any(|o| sum(o.0))) {
        Some(g) => Err(bad(&robot.axis(g.axis).name, format!("{}: a sum of another sum", robot.axis(g.axis).name))),
        None => Ok(all),
    }
}

fn is_zero(v: &f64) -> bool {
    *v == 0.0
}
