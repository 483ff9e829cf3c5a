//! `tool_error`: the position of the TCP in the flange frame differs from that in the robot file.
//!
//! Parameter: the three coordinates of the change, at most 200 mm each. It moves the TCP (the first reflector); further
//! reflectors keep the positions of `tools:`. Action: measure the tool again and enter it.

use super::common::*;
use nalgebra::Vector3;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "tool_error",
    heading: "tool error",
    stage: Stage::Geometry,
    family: Family::Geometry,
    acts_on: ActsOn::Tool,
    adds: "the position of the TCP in the flange frame differs from the robot file",
    equation: "tool plus (x, y, z)",
    reference: "Hollerbach, Wampler (1996), Int. J. Robotics Research 15(6)",
    parameters: &[("x_mm, y_mm, z_mm", "either sign, within 200 mm")],
    confused_with: &["joint_zero_offset", "link_error"],
    decide_by: "turn the wrist about the TCP in three or more orientations; measure a second reflector",
    action: "measure the tool again and enter it",
    undone: "nothing: it changes poses, not joint positions",
    special: Special::NONE,
    example: ("{effect: tool_error, x_mm: 0.1, y_mm: 0.05, z_mm: 0}", View::TcpOverTime),
    read: |f| Ok(ToolError { offset_m: f.xyz_m()? }.into()),
    typical: |size| size.xyz_mm(0.05),
    candidates: |survey, list| {
        if survey.points {
            list.push(Candidate::of_vector(survey.robot, Target::Tool, 1e-5, |offset_m| ToolError { offset_m }));
        }
    },
};

/// Change of the TCP in the flange frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolError {
    /// Change of the TCP in the flange frame, m.
    pub offset_m: Vector3<f64>,
}

impl EffectType for ToolError {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        self.offset_m.as_slice().to_vec()
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { offset_m: Vector3::new(v[0], v[1], v[2]) }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        Parameter::xyz_mm(0.2, 0.5e-3).to_vec()
    }

    fn change_geometry(&self, _target: Target, geometry: &mut Geometry) {
        geometry.tool.translation.vector += self.offset_m;
    }

    fn magnitude(&self) -> f64 {
        self.offset_m.amax()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::moves_poses()
    }
}
