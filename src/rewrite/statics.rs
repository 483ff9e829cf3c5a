//! Joint errors that depend on the joint vector alone, and the commands that undo them.
//!
//! Encoder scale, transmission error, zero offset, coupling and gravity compliance move a joint by an amount that the commands of
//! that moment fix. The command that brings the joints to a wanted vector solves `out(c) = q`; the errors are small, so
//! `c <- c + (q - out(c))` gains three digits or more a step. It is done to the points of a program before everything
//! else, since a joint that moves by its correction may reverse by it and then needs its gap there.
//!
//! Between points the command is straight: an error with a period shorter than the points are apart is undone at the points
//! only. The payload is not known from a program: gravity is that of the links.

use super::Points;
use crate::effects::{Effect, Stage, Target};
use crate::machine::gravity::{Gravity, Line};
use crate::model::Model;
use crate::robot::{Chain, JointKind};

/// Correction left (rad or m) at which a solution is exact, and steps until then at most.
const EXACT: f64 = 1e-13;
const MOST_STEPS: usize = 30;

/// What a gear adds to the position that arrives.
#[derive(Debug, Clone)]
enum Gear {
    Scale(f64),
    Wave { amplitude: f64, per_unit: f64, phase_rad: f64 },
}

#[derive(Debug, Clone, Default)]
struct Axis {
    gear: Vec<Gear>,
    offset: f64,
    coupled: Vec<(usize, f64)>,
    compliance: f64,
}

/// The static errors of a model.
#[derive(Debug, Clone)]
pub struct Statics {
    axes: Vec<Axis>,
    chain: Chain,
    /// `None`: no joint yields to it.
    gravity: Option<Gravity>,
}

/// Buffers of one run.
#[derive(Debug, Default)]
struct Scratch {
    out: Vec<f64>,
    torque: Vec<f64>,
    lines: Vec<Line>,
}

impl Statics {
    /// Those of a model; `None` where it has none.
    pub fn of_model(model: &Model) -> Option<Self> {
        let robot = &model.robot;
        let mut axes = vec![Axis::default(); robot.dof()];
        let (mut any, mut yields) = (false, false);
        for placed in &model.effects {
            let Some(axis) = placed.axis() else { continue };
            let a = &mut axes[axis];
            any |= is_static(&placed.effect);
            match (&placed.effect, placed.target) {
                (Effect::EncoderScale(e), _) => a.gear.push(Gear::Scale(e.scale)),
                (Effect::TransmissionError(e), _) => {
                    let joint = robot.axis(axis);
                    let rev = match joint.kind {
                        JointKind::Revolute => std::f64::consts::TAU,
                        JointKind::Prismatic => joint.lead_m_per_rev.unwrap_or(1.0),
                    };
                    let per_unit = e.cycles_per_rev * std::f64::consts::TAU / rev;
                    a.gear.push(Gear::Wave { amplitude: e.amplitude, per_unit, phase_rad: e.phase_rad });
                }
                (Effect::JointZeroOffset(e), _) => a.offset += e.offset,
                (Effect::AxisCoupling(e), Target::Coupled { from, .. }) => a.coupled.push((from, e.ratio)),
                (Effect::GravityCompliance(e), _) => {
                    a.compliance += e.compliance;
                    yields = true;
                }
                _ => {}
            }
        }
        let gravity = yields.then(|| Gravity::new(robot)).filter(Gravity::is_known);
        any.then(|| Self { axes, chain: robot.chain().clone(), gravity })
    }

    /// The axis has an error of this kind.
    pub fn changes(&self, axis: usize) -> bool {
        let a = &self.axes[axis];
        !a.gear.is_empty()
            || a.offset != 0.0
            || !a.coupled.is_empty()
            || (a.compliance != 0.0 && self.gravity.is_some())
    }

    /// Joints behind gear and link stage for the commands `c`.
    fn out(&self, c: &[f64], scratch: &mut Scratch) {
        if let Some(gravity) = &self.gravity {
            gravity.at(&self.chain, c, 0.0, &mut scratch.lines, &mut scratch.torque);
        }
        for (i, (axis, out)) in self.axes.iter().zip(&mut scratch.out).enumerate() {
            let mut s = c[i];
            for gear in &axis.gear {
                s += match gear {
                    Gear::Scale(scale) => scale * s,
                    Gear::Wave { amplitude, per_unit, phase_rad } => amplitude * (per_unit * s + phase_rad).sin(),
                };
            }
            s += axis.offset + axis.coupled.iter().map(|(from, ratio)| ratio * c[*from]).sum::<f64>();
            if self.gravity.is_some() {
                s += axis.compliance * scratch.torque[i];
            }
            *out = s;
        }
    }

    /// Commands that bring the joints to the points of a block, by the share `gain` of the correction; `largest` keeps the
    /// largest correction of each axis, rad or m.
    pub fn commands(&self, block: &Points, gain: f64, largest: &mut [f64]) -> Points {
        let n = self.axes.len();
        let mut scratch = Scratch { out: vec![0.0; n], torque: vec![0.0; n], lines: Vec::new() };
        let mut c = vec![0.0; n];
        let mut shifted = block.clone();
        for row in shifted.q.chunks_exact_mut(block.axes) {
            c.copy_from_slice(row);
            for _ in 0..MOST_STEPS {
                self.out(&c, &mut scratch);
                let mut left = 0f64;
                for (v, (q, out)) in c.iter_mut().zip(row.iter().zip(&scratch.out)) {
                    *v += q - out;
                    left = left.max((q - out).abs());
                }
                if left < EXACT {
                    break;
                }
            }
            for ((q, v), most) in row.iter_mut().zip(&c).zip(largest.iter_mut()) {
                let by = gain * (v - *q);
                *most = most.max(by.abs());
                *q += by;
            }
        }
        shifted
    }
}

/// An error that the commands of the moment fix.
pub fn is_static(effect: &Effect) -> bool {
    matches!(effect, Effect::EncoderScale(_) | Effect::TransmissionError(_)) || effect.stage() == Stage::Link
}
