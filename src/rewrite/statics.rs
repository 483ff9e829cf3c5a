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
use crate::compensator::from_model::part_of_geometry;
use crate::effects::{Effect, EffectInstance, Inputs, Site, Stage, Target, UndoContext};
use crate::machine::gravity::{Gravity, Line, levers};
use crate::model::Model;
use crate::robot::{Chain, Robot};
use nalgebra::Vector3;
use std::borrow::Cow;

/// Correction left (rad or m) at which a solution is exact, and steps until then at most.
const EXACT: f64 = 1e-13;
const MOST_STEPS: usize = 30;

/// The static errors of a model.
#[derive(Debug, Clone)]
pub struct Statics {
    /// Effects of the gears by axis, with one turn of each.
    gears: Vec<(f64, Vec<Effect>)>,
    /// Effects of the links.
    links: Vec<EffectInstance>,
    chain: Chain,
    g_m_s2: Vector3<f64>,
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

/// One command vector, as link effects see rows.
struct OneRow<'a> {
    c: &'a [f64],
    torque: &'a [f64],
    statics: &'a Statics,
}

impl Inputs for OneRow<'_> {
    fn command(&self, axis: usize) -> &[f64] {
        &self.c[axis..=axis]
    }

    fn gravity_torque(&self, axis: usize) -> &[f64] {
        &self.torque[axis..=axis]
    }

    fn gravity_levers(&self, axis: usize, joint: usize) -> Cow<'_, [[f64; 2]]> {
        let (chain, g_m_s2) = (&self.statics.chain, &self.statics.g_m_s2);
        vec![levers(chain, g_m_s2, self.c, axis, joint, &mut Vec::new())].into()
    }
}

impl Statics {
    /// Those of a model; `None` where it has none.
    pub fn of_model(model: &Model) -> Option<Self> {
        Self::of_effects(&model.robot, Self::undone(model))
    }

    /// The effects of a model that are undone at every point.
    pub fn undone(model: &Model) -> impl Iterator<Item = &EffectInstance> {
        model.effects.iter().filter(|p| is_static(p, &model.robot) && !part_of_geometry(model, p))
    }

    /// The static errors that some of [`Self::undone`] are.
    pub fn of_effects<'a>(robot: &Robot, effects: impl Iterator<Item = &'a EffectInstance>) -> Option<Self> {
        let site = |placed: &EffectInstance| placed.axis().map(|axis| (axis, placed.site(robot).rev()));
        let mut gears: Vec<(f64, Vec<Effect>)> =
            (0..robot.dof()).map(|axis| (Site { robot, target: Target::Joint(axis) }.rev(), Vec::new())).collect();
        let mut links = Vec::new();
        for placed in effects {
            match (site(placed), placed.effect.stage()) {
                (Some((axis, _)), Stage::Gear) => gears[axis].1.push(placed.effect.clone()),
                (Some(_), _) => links.push(placed.clone()),
                (None, _) => {}
            }
        }
        let any = !links.is_empty() || gears.iter().any(|g| !g.1.is_empty());
        let yields = links.iter().any(|p: &EffectInstance| p.effect.uses_gravity());
        let gravity = yields.then(|| Gravity::new(robot)).filter(Gravity::is_known);
        any.then(|| Self { gears, links, chain: robot.chain().clone(), g_m_s2: robot.gravity_m_s2, gravity })
    }

    /// The axis has an error of this kind.
    pub fn changes(&self, axis: usize) -> bool {
        !self.gears[axis].1.is_empty() || self.links.iter().any(|p| p.axis() == Some(axis))
    }

    /// Joints after gear and link stage for the commands `c`.
    fn out(&self, c: &[f64], scratch: &mut Scratch) {
        if let Some(gravity) = &self.gravity {
            gravity.at(&self.chain, c, 0.0, &mut scratch.lines, &mut scratch.torque);
        }
        for ((&c, (rev, gears)), out) in c.iter().zip(&self.gears).zip(&mut scratch.out) {
            *out = gears.iter().fold(c, |s, gear| s + gear.position_error(s, *rev).unwrap_or(0.0));
        }
        let inputs = OneRow { c, torque: &scratch.torque, statics: self };
        for placed in &self.links {
            if let Some(axis) = placed.axis() {
                placed.effect.add_to_joint(placed.target, &inputs, &mut scratch.out[axis..=axis]);
            }
        }
    }

    /// Commands that bring the joints to the points of a block, by the share `gain` of the correction; `largest` keeps the
    /// largest correction of each axis, rad or m.
    pub fn commands(&self, block: &Points, gain: f64, largest: &mut [f64]) -> Points {
        let n = self.gears.len();
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
fn is_static(placed: &EffectInstance, robot: &Robot) -> bool {
    let context = UndoContext { site: placed.site(robot), tcp_speed_m_s: None, alone: false };
    placed.effect.undo(&context).point_by_point
}
