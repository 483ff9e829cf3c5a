//! What a motion would show of the whole catalogue: the plan before anything is known to be wrong.
//!
//! Method: for every effect on every joint the minimal detectable bias from the projected sensitivities (chance 0.001, power
//! 0.8; frame, and nothing else, taken off), against the size at which the effect matters ([`super::sizes`]). A motion is
//! scored by its worst effect: the least of size over bias. Effects that no motion of the library shows
//! (the zero offset of the first joint beside a free frame) are left out of that and listed.
//!
//! Linear: one effect at a time, so that it shows what can be seen, not what can be separated.

use super::motions::Motion;
use super::separate::Experiment;
use super::sizes::{self, Scale};
use crate::diagnose::candidates;
use crate::diagnose::candidates::screen::{SWALLOWED, ScreeningContext};
use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::verdict::MDB;
use crate::effects::{EffectInstance, transmission_error};
use crate::io::yaml::Document;
use serde_yaml::Mapping;

/// Ratio below which an effect is not seen: at a million times its typical size its sensitivity is number noise.
const NUMBER_NOISE: f64 = 1e-6;

/// One effect on one target.
#[derive(Debug, Clone)]
pub struct Seen {
    pub effect: &'static str,
    pub target: String,
    /// Size that matters over the smallest that is detected: 1 or more is seen. 0: not at all.
    pub ratio: f64,
    /// The effect at the smallest size that is detected.
    pub detectable: Option<EffectInstance>,
}

/// What a motion shows, in the order of the catalogue's candidates.
pub fn seen(bench: &Experiment, motion: &Motion, scale: &Scale) -> Vec<Seen> {
    let (problem, start, whitening) = bench.problem(motion);
    let state = problem.evaluate(&start);
    let tangent = tangent(&problem, &start, &state, &[], &whitening);
    let context = ScreeningContext::new(&problem, &start, &state, &whitening, tangent);
    let doc = Document { name: "typical sizes", text: "" };
    let mut list: Vec<Seen> = Vec::new();
    let mut candidates = candidates::all(&problem);
    for axis in 0..problem.robot.dof() {
        // two typical ripples: slow, and of a motor turn
        if problem.robot.axis(axis).kind == crate::robot::JointKind::Revolute
            || problem.robot.axis(axis).lead_m_per_rev.is_some()
        {
            candidates.extend([37.0, 101.0].map(|n| transmission_error::ripple(&problem.robot, axis, n)));
        }
    }
    candidates.push(candidates::vibration(&problem.robot, 7.3));
    for (index, c) in candidates.iter().enumerate() {
        let Ok(typical) = sizes::placed(c.effect, &c.target, &Mapping::new(), scale, &doc) else { continue };
        let score = context.score(index, c);
        let visible = score.own >= SWALLOWED && score.sigma.iter().all(|s| s.is_finite() && *s > 0.0);
        let (ratio, detectable) = if visible {
            let size = typical.effect.magnitude();
            // of several coefficients the one that is seen worst; of a gap over speed its slope
            let bias = score.sigma[c.sized_from..].iter().map(|s| MDB * s).fold(0.0, f64::max);
            let smallest: Vec<f64> = score.sigma.iter().map(|s| MDB * s).collect();
            (size / bias, c.at(&smallest).into_iter().next())
        } else {
            (0.0, None)
        };
        // what moves nothing but the last digits of the numbers is not seen at all
        let (ratio, detectable) = if ratio < NUMBER_NOISE { (0.0, None) } else { (ratio, detectable) };
        let new = Seen { effect: c.effect, target: c.target.clone(), ratio, detectable };
        match list.iter_mut().find(|s| s.effect == new.effect && s.target == new.target) {
            Some(old) if old.ratio < new.ratio => *old = new,
            Some(_) => {}
            None => list.push(new),
        }
    }
    list
}
