//! `base_tilt`: the base, its floor or its column turns under the overturning moment of the arm.
//!
//! The arm turns about the base's origin by `(x_rad_per_nm * M_x, y_rad_per_nm * M_y, 0)`, `M` being the moment of the weights of
//! `links` and payload about that origin, in the axes of the world. Reference: ISO 9283:1998 (static compliance);
//! a lift column turns by up to 4 mrad per metre of reach.
//!
//! Parameters: 0 or more (a floor gives way along its load), at most 1e-4 rad/Nm. Typical: 1e-8 rad/Nm bolted to concrete, 1e-6 on a
//! mobile base. Without `links` it does nothing. Action: stiffen or regrout the base; level it again.

use super::common::*;
use nalgebra::{UnitQuaternion, Vector3};
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "base_tilt",
    heading: "base tilt",
    stage: Stage::Base,
    family: Family::Gravity,
    acts_on: ActsOn::Base,
    adds: "the base tilts under the overturning moment of the arm",
    equation: "rotation about the base's origin by (x_rad_per_nm M_x, y_rad_per_nm M_y, 0), M the moment of the weights about it",
    reference: "ISO 9283:1998 (static compliance)",
    parameters: &[("x_rad_per_nm, y_rad_per_nm", "0 to 1e-4 rad/Nm about the x and y axes of the world")],
    confused_with: &["gravity_compliance", "link_error"],
    decide_by: "put a level or a second reflector on the base and extend the arm to all sides",
    action: "tighten the bolts, regrout or stiffen the base",
    undone: "nothing: it changes poses, not joint positions",
    special: Special::NONE,
    example: ("{effect: base_tilt, x_rad_per_nm: 0, y_rad_per_nm: 1.0e-7}", View::TcpOverTime),
    read: |f| {
        let x = f.number("x_rad_per_nm", 0.0)?;
        let y = f.number("y_rad_per_nm", 0.0)?;
        if x.is_none() && y.is_none() {
            return Err(f.bad("rad_per_nm", "no `x_rad_per_nm`, `y_rad_per_nm`", "at least one of them"));
        }
        Ok(BaseTilt { rad_per_nm: [x.unwrap_or(0.0), y.unwrap_or(0.0)] }.into())
    },
    typical: |_| vec![("x_rad_per_nm".into(), Value::from(1e-8)), ("y_rad_per_nm".into(), Value::from(1e-8))],
    candidates: |survey, list| {
        if survey.points && survey.axes.iter().any(|a| a.loaded) {
            let make = |c: &[f64]| BaseTilt { rad_per_nm: [c[0].max(0.0), c[1].max(0.0)] };
            list.push(Candidate::of_sizes(survey.robot, Target::Base, &[1e-9; 2], make));
        }
    },
};

/// Compliance about the x and y axes of the world, rad/Nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseTilt {
    /// Compliance about the x and the y axis of the world, rad/Nm.
    pub rad_per_nm: [f64; 2],
}

impl EffectType for BaseTilt {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        self.rad_per_nm.to_vec()
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { rad_per_nm: [v[0], v[1]] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        ["x_rad_per_nm", "y_rad_per_nm"].map(|key| Parameter::new(key, 1.0, (0.0, 1e-4), 1e-8)).to_vec()
    }

    fn displacement_m(&self, _target: Target, row: &Row, point_m: &Vector3<f64>) -> Vector3<f64> {
        let (moment, origin) = row.inputs.overturning(row.index);
        let turn = Vector3::new(self.rad_per_nm[0] * moment.x, self.rad_per_nm[1] * moment.y, 0.0);
        let arm = point_m - origin;
        UnitQuaternion::from_scaled_axis(turn) * arm - arm
    }

    fn displaces(&self) -> bool {
        true
    }

    fn magnitude(&self) -> f64 {
        self.rad_per_nm[0].max(self.rad_per_nm[1])
    }

    fn idle(&self, site: &Site, _settled_poses: bool) -> Option<&'static str> {
        site.without_links()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::moves_poses()
    }
}
