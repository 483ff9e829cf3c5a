//! An effect and where it acts: the name of its target, the keys of its parameters, their bounds.
//!
//! Bounds are physical: beyond them the machine is broken, or the fault is another one. Each effect's file says why.

use super::{Decay, DhParameter, Effect, GapCurve, Target};
use crate::robot::{JointKind, Robot};
use std::f64::consts::{PI, TAU};

/// An effect at its place.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectInstance {
    pub target: Target,
    pub effect: Effect,
}

/// Largest lost motion: 0.1 rad, or 10 mm.
fn most_lost(kind: JointKind) -> f64 {
    if kind == JointKind::Revolute { 0.1 } else { 0.01 }
}

impl EffectInstance {
    /// An effect on one axis.
    pub fn on_axis(axis: usize, effect: Effect) -> Self {
        Self { target: Target::Joint(axis), effect }
    }

    /// The axis whose position it changes.
    pub fn axis(&self) -> Option<usize> {
        match self.target {
            Target::Joint(axis) | Target::Coupled { to: axis, .. } => Some(axis),
            _ => None,
        }
    }

    /// As a reader knows it: "A1", "A2.a", "A6<-A5", "tool", "tcp", "log".
    pub fn target_text(&self, robot: &Robot) -> String {
        match self.target {
            Target::Joint(axis) => robot.axis(axis).name.clone(),
            Target::Coupled { to, from } => format!("{}<-{}", robot.axis(to).name, robot.axis(from).name),
            Target::Link { joint, parameter } => format!("{}.{}", robot.joints[joint].name, parameter.text()),
            Target::Tool => "tool".into(),
            Target::Tcp => "tcp".into(),
            Target::Log => "log".into(),
        }
    }

    /// Unit of the joint that it moves; degrees where there is none.
    fn kind(&self, robot: &Robot) -> JointKind {
        match self.target {
            Target::Link { parameter: DhParameter::A | DhParameter::D, .. } => JointKind::Prismatic,
            Target::Link { parameter: DhParameter::Alpha, .. } => JointKind::Revolute,
            _ => self.axis().map_or(JointKind::Revolute, |a| robot.axis(a).kind),
        }
    }

    /// Keys of the parameters in a model file, and the factor from SI to their unit, in the order of [`Effect::values`]. Knots
    /// are `knots[0]`, ...; the coordinates of a vibration's amplitude are `amplitude_um[0]`, ... (in a file they
    /// stand as amplitude and direction).
    pub fn keys(&self, robot: &Robot) -> Vec<(String, f64)> {
        let kind = self.kind(robot);
        let (unit, edge) = (kind.unit(), 1.0 / kind.si());
        let degrees = 180.0 / PI;
        let joint = |name: &str| (format!("{name}_{unit}"), edge);
        let xyz = || ["x_mm", "y_mm", "z_mm"].map(|k| (k.to_string(), 1e3));
        match &self.effect {
            Effect::ServoLag(_) => vec![("lag_s".into(), 1.0)],
            Effect::Stiction(e) => {
                let decay = match e.decay {
                    Decay::Time(_) => ("decay_s".into(), 1.0),
                    Decay::Travel(_) => joint("decay"),
                };
                vec![joint("spike"), decay]
            }
            Effect::EncoderScale(_) => vec![("scale_ppm".into(), 1e6)],
            Effect::TransmissionError(_) => {
                vec![joint("amplitude"), ("cycles_per_rev".into(), 1.0), ("phase_deg".into(), degrees)]
            }
            Effect::Backlash(e) => match &e.half_gap {
                GapCurve::Constant(_) => vec![joint("half_gap")],
                GapCurve::Polynomial { coefficients, .. } => (0..coefficients.len())
                    .map(|k| (format!("coefficients[{k}]"), edge * kind.si().powi(k as i32)))
                    .collect(),
                GapCurve::Pchip(p) => (0..p.knots().len()).map(|k| (format!("knots[{k}]"), edge)).collect(),
            },
            Effect::BacklashSpeed(_) => {
                vec![joint("half_gap"), (format!("slope_{unit}_per_mm_s"), edge * 1e-3)]
            }
            Effect::Hysteresis(_) => vec![joint("half_width"), joint("presliding")],
            Effect::JointZeroOffset(_) => vec![joint("offset")],
            Effect::AxisCoupling(_) => vec![("ratio".into(), self.ratio_to_edge(robot))],
            Effect::GravityCompliance(_) => match kind {
                JointKind::Revolute => vec![("compliance_deg_per_nm".into(), edge)],
                JointKind::Prismatic => vec![("compliance_mm_per_n".into(), edge)],
            },
            Effect::LinkError(_) => vec![joint("delta")],
            Effect::ToolError(_) => xyz().to_vec(),
            Effect::ThermalDrift(_) => {
                let mut keys = xyz().to_vec();
                keys.push(("tau_s".into(), 1.0));
                keys
            }
            Effect::Vibration(_) => {
                let mut keys: Vec<_> = (0..3).map(|k| (format!("amplitude_um[{k}]"), 1e6)).collect();
                keys.push(("frequency_hz".into(), 1.0));
                keys.push(("phase_deg".into(), degrees));
                keys
            }
            Effect::TimeOffset(_) => vec![("offset_s".into(), 1.0)],
        }
    }

    /// A ratio in the units of the two joints: 1 where both turn or both slide.
    fn ratio_to_edge(&self, robot: &Robot) -> f64 {
        match self.target {
            Target::Coupled { to, from } => robot.axis(from).kind.si() / robot.axis(to).kind.si(),
            _ => 1.0,
        }
    }

    /// Least and most of each value, SI, in the order of [`Effect::values`].
    pub fn bounds(&self, robot: &Robot) -> Vec<(f64, f64)> {
        let kind = self.kind(robot);
        let lost = most_lost(kind);
        let revolute = kind == JointKind::Revolute;
        // travel of a decay: from a thousandth of a lost motion to more than a stroke
        let travel = (lost * 1e-5, if revolute { TAU } else { 10.0 });
        let within = |most: f64| (-most, most);
        match &self.effect {
            Effect::ServoLag(_) => vec![(0.0, 1.0)],
            Effect::Stiction(e) => match e.decay {
                Decay::Time(_) => vec![(0.0, lost), (1e-3, 1e3)],
                Decay::Travel(_) => vec![(0.0, lost), travel],
            },
            Effect::EncoderScale(_) => vec![within(0.05)],
            Effect::TransmissionError(e) => {
                let wave = e.cycles_per_rev.max(1e-3) / if revolute { 1.0 } else { self.lead_m(robot) / TAU };
                vec![(0.0, lost.min(1.0 / wave)), (0.05, 1e4), within(PI)]
            }
            Effect::Backlash(e) => match &e.half_gap {
                GapCurve::Polynomial { coefficients, .. } => vec![within(f64::MAX); coefficients.len()],
                _ => vec![(0.0, lost); self.effect.values().len()],
            },
            Effect::BacklashSpeed(_) => vec![(0.0, lost), within(lost)],
            Effect::Hysteresis(_) => vec![(0.0, lost), travel],
            Effect::JointZeroOffset(_) => vec![within(if revolute { 0.2 } else { 0.05 })],
            Effect::AxisCoupling(_) => vec![within(0.5 / self.ratio_to_edge(robot))],
            Effect::GravityCompliance(_) => vec![(0.0, if revolute { 1e-3 } else { 1e-4 })],
            Effect::LinkError(_) => vec![within(if revolute { 0.1 } else { 0.05 })],
            Effect::ToolError(_) => vec![within(0.2); 3],
            Effect::ThermalDrift(_) => vec![within(0.01), within(0.01), within(0.01), (1.0, 1e6)],
            Effect::Vibration(_) => vec![within(5e-3), within(5e-3), within(5e-3), (0.01, 1e3), within(PI)],
            Effect::TimeOffset(_) => vec![within(10.0)],
        }
    }

    fn lead_m(&self, robot: &Robot) -> f64 {
        self.axis().and_then(|a| robot.axis(a).lead_m_per_rev).unwrap_or(1.0)
    }
}
