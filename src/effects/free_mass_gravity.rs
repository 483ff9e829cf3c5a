//! `gravity_compliance` with `moments`: the joint yields to gravity, with the masses estimated instead of taken from `links`.
//!
//! Data sheets give masses roughly and centres not at all. The torque of gravity about joint j is linear in the first moments of the
//! links that it carries: adds `sum over links i of (x_i X_ij + y_i Y_ij)`, where `X_ij = (z_j cross x_i) . g` for the unit vectors
//! `z_j` of the joint's axis, `x_i`, `y_i` of link i's frame and `g` of gravity. `x_i`, `y_i` are compliance times first moment times
//! 9.8 m/s^2: the angle by which the link bends the joint where it lies across gravity. The part along `z_i` is that of the link
//! before, so two numbers a link are all there is. Reference: Khalil, Dombre (2002), Modeling, Identification and Control of Robots,
//! chapter 9 (base inertial parameters).
//!
//! Parameters: either sign, at most 0.01 rad; typical 0.003 to 0.02 deg. A prismatic joint bears weight, not moments: it has none.
//! `rewrite` undoes all of it, point by point.

use super::common::*;
use super::gravity_compliance;
use super::site::within;
use crate::robot::JointKind;
use serde_yaml::{Mapping, Value};

/// How the catalogue describes this form.
pub static FORM: EffectForm = EffectForm {
    of: &gravity_compliance::INFO,
    name: "gravity_moments",
    heading: "with free masses",
    equation: "sum over links i of (x_i X_ij + y_i Y_ij), X_ij = (z_j cross x_i) . g, Y_ij the same with y_i",
    reference: "Khalil, Dombre (2002), Modeling, Identification and Control of Robots, chapter 9",
    typical: "0.003 to 0.02 deg a link",
    example: (
        "{effect: gravity_compliance, joint: A1, moments: [[A1, 0.004, 0.002], [A2, 0.002, 0]]}",
        View::JointOverCommand,
    ),
    diagnosis: "names it of settled poses of an arm, where it explains more than the masses of the robot file",
    undone: "all of it, point by point",
};

/// Links (index of the joint in [`crate::robot::Robot::joints`]) with their x and y, rad.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeMassGravity {
    /// Link and its x and y, rad.
    pub moments: Vec<(usize, [f64; 2])>,
}

/// Links that are tried on a joint: its own and those after it.
const LINKS: [usize; 2] = [1, 3];

pub(super) fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let expected = "`moments: [[JOINT, x_deg, y_deg], ...]` of a revolute joint and of joints after it, each once";
    let own = site.axis().map_or(0, |a| site.robot.axis_index(a));
    let read = |v: Value| -> Option<Vec<(usize, [f64; 2])>> {
        let list: Vec<(String, f64, f64)> = serde_yaml::from_value(v).ok()?;
        let joint = |name: &str| site.robot.joints.iter().position(|j| j.name.eq_ignore_ascii_case(name));
        let one = |(name, x, y): &(String, f64, f64)| Some((joint(name)?, [x.to_radians(), y.to_radians()]));
        list.iter().map(one).collect()
    };
    let found = f.take("moments").and_then(read).filter(|all| {
        let sound = all.iter().all(|m| m.0 >= own && m.1.iter().all(|v| v.is_finite()));
        sound && !all.is_empty() && (1..all.len()).all(|k| all[..k].iter().all(|o| o.0 != all[k].0))
    });
    match found.filter(|_| site.is_revolute()) {
        Some(moments) => Ok(FreeMassGravity { moments }.into()),
        None => Err(f.bad("moments", "moments that are none", expected)),
    }
}

pub(super) fn further(survey: &Survey, list: &mut Vec<Candidate>) {
    let robot = survey.robot;
    for axis in survey.all_axes().filter(|&a| robot.axis(a).kind == JointKind::Revolute) {
        if !survey.axes[axis].loaded && !robot.links.is_empty() {
            continue;
        }
        let own = robot.axis_index(axis);
        let mut tried = 0;
        for links in LINKS {
            let last = (own + links).min(robot.joints.len());
            if last - own == tried {
                continue;
            }
            tried = last - own;
            let make = move |c: &[f64]| FreeMassGravity {
                moments: (own..last).zip(c.chunks_exact(2)).map(|(joint, c)| (joint, [c[0], c[1]])).collect(),
            };
            let trials = vec![1e-6; 2 * tried];
            list.push(Candidate::of_sizes(robot, Target::Joint(axis), &trials, make).with_form("moments"));
        }
    }
}

impl EffectType for FreeMassGravity {
    fn info(&self) -> &'static EffectInfo {
        &gravity_compliance::INFO
    }

    fn values(&self) -> Vec<f64> {
        self.moments.iter().flat_map(|m| m.1).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let moments = self.moments.iter().zip(v.chunks_exact(2)).map(|(m, c)| (m.0, [c[0], c[1]])).collect();
        Self { moments }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let one = |k: usize, c: usize| {
            Parameter::degrees(&format!("moments[{k}][{}]", c + 1), within(0.01), 0.01f64.to_radians())
        };
        (0..self.moments.len()).flat_map(|k| [one(k, 0), one(k, 1)]).collect()
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        let one = |(joint, [x, y]): &(usize, [f64; 2])| {
            let name = site.robot.joints[*joint].name.clone();
            Value::Sequence(vec![name.into(), x.to_degrees().into(), y.to_degrees().into()])
        };
        entry.insert("moments".into(), Value::Sequence(self.moments.iter().map(one).collect()));
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Some(axis) = target.axis() else { return };
        for (link, [x, y]) in &self.moments {
            let levers = inputs.gravity_levers(axis, *link);
            joint.iter_mut().zip(levers.iter()).for_each(|(q, l)| *q += x * l[0] + y * l[1]);
        }
    }

    fn magnitude(&self) -> f64 {
        largest_size(self.values())
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
