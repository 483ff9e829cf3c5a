//! A robot back to its file: for a model written with its robot inline, and for a robot made by a program.
//!
//! Method: every number is written with the fewest digits that are read back as the same number of the chain, so that
//! `limits_deg: [-185, 185]` stays what it was after degrees became radians. A frame is written from its rotation, whose
//! angles come back within 1e-12 deg.

use super::file::{FollowFile, FrameFile, JointFile, LinkFile, ReflectorFile, RobotFile, SCHEMA, ToolsFile};
use super::{Convention, Joint, JointKind, Robot};
use crate::error::Result;
use crate::io::yaml;
use nalgebra::{Isometry3, Vector3};

impl Robot {
    /// The robot as a document of the schema `lostmotion/robot/1`; serialised it is also a model's inline `robot:`.
    pub fn to_file(&self) -> RobotFile {
        RobotFile {
            schema: SCHEMA.into(),
            name: self.name.clone(),
            convention: match self.convention {
                Convention::Standard => "dh-standard".into(),
                Convention::Modified => "dh-modified".into(),
            },
            joints: self.joints.iter().map(|j| joint(j, self)).collect(),
            links: self.links.iter().map(|l| LinkFile { mass_kg: l.mass_kg, com_mm: point(&l.com_m) }).collect(),
            base: frame(&self.base),
            flange: frame(self.flange()),
            tool: frame(&self.tool),
            tools: match self.frames.tools.is_empty() {
                true => ToolsFile::Reflectors(
                    self.reflectors_m.iter().map(|p| ReflectorFile { xyz_mm: point(p) }).collect(),
                ),
                false => ToolsFile::Named(self.frames.tools.iter().map(|(k, f)| (k.clone(), frame(f))).collect()),
            },
            frames: self.frames.frames.iter().map(|(k, f)| (k.clone(), frame(f))).collect(),
            gravity_m_s2: self.gravity_m_s2.into(),
            gap_of: self.gap_of.iter().map(|g| (self.axis(g.axis).name.clone(), self.sum_text(g))).collect(),
            control: self.axes().control.words().into_iter().map(String::from).collect(),
            wrist_flip: self.wrist_flip.map(|flip| flip.word().into()),
            no_motion: self.axes().no_motion.names().map(String::from).collect(),
        }
    }

    /// The same as YAML text.
    pub fn to_yaml(&self) -> Result<String> {
        yaml::to_text(&self.to_file())
    }
}

fn joint(j: &Joint, robot: &Robot) -> JointFile {
    let revolute = j.kind == JointKind::Revolute;
    let si = |v: f64| shortest(v, |edge| edge * j.kind.si_per_user_unit());
    let range = |wanted: bool| j.limits.filter(|_| wanted).map(|l| l.map(si));
    let one = |v: Option<f64>, wanted: bool| v.filter(|_| wanted).map(si);
    JointFile {
        name: j.name.clone(),
        kind: if revolute { "revolute" } else { "prismatic" }.into(),
        theta_deg: shortest(j.theta_rad, f64::to_radians),
        d_mm: millimetres(j.d_m),
        a_mm: millimetres(j.a_m),
        alpha_deg: shortest(j.alpha_rad, f64::to_radians),
        beta_deg: shortest(j.beta_rad, f64::to_radians),
        direction: j.direction,
        limits_deg: range(revolute),
        limits_mm: range(!revolute),
        max_speed_deg_s: one(j.max_speed, revolute),
        max_speed_mm_s: one(j.max_speed, !revolute),
        max_accel_deg_s2: one(j.max_accel, revolute),
        max_accel_mm_s2: one(j.max_accel, !revolute),
        lead_mm_per_rev: j.lead_m_per_rev.map(millimetres),
        pulses_per_deg: j.pulses.filter(|_| revolute).map(|p| shortest(p, |edge| edge / j.kind.si_per_user_unit())),
        pulses_per_mm: j.pulses.filter(|_| !revolute).map(|p| shortest(p, |edge| edge / j.kind.si_per_user_unit())),
        follows: j.follows.map(|f| FollowFile { joint: robot.joints[f.joint].name.clone(), ratio: f.ratio }),
    }
}

fn frame(f: &Isometry3<f64>) -> FrameFile {
    let exact = FrameFile::from_isometry(f);
    // what is left of a rotation after its quaternion is below 1e-12 deg
    FrameFile {
        xyz_mm: point(&f.translation.vector),
        rpy_deg: exact.rpy_deg.map(|v| (v * 1e12).round() * 1e-12 + 0.0).map(tidy),
    }
}

fn point(p: &Vector3<f64>) -> [f64; 3] {
    [millimetres(p.x), millimetres(p.y), millimetres(p.z)]
}

fn millimetres(m: f64) -> f64 {
    shortest(m, |mm| mm * 1e-3)
}

/// A value rounded to 12 decimals as the decimal number that it is.
fn tidy(v: f64) -> f64 {
    format!("{v:.12}").parse().unwrap_or(v)
}

/// The decimal number with the fewest decimals that `to_si` brings back to `si`; else the nearest one.
fn shortest(si: f64, to_si: impl Fn(f64) -> f64) -> f64 {
    let scale = to_si(1.0);
    let edge = si / scale;
    for places in 0..=15 {
        let Ok(candidate) = format!("{edge:.places$}").parse::<f64>() else { continue };
        if to_si(candidate) == si {
            return candidate + 0.0;
        }
    }
    // one of the neighbours may come back exactly where the quotient does not
    [edge.next_down(), edge, edge.next_up()]
        .into_iter()
        .min_by(|a, b| (to_si(*a) - si).abs().total_cmp(&(to_si(*b) - si).abs()))
        .unwrap_or(edge)
}
