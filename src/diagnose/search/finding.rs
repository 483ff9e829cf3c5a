//! What the search is made of on its way: refined candidates, alternatives, accepted effects.

use crate::diagnose::search::fit::Fit;
use crate::effects::{BacklashPosition, Effect, EffectInstance};

/// Part of a gap by which it varies over position at least, to get a schedule.
const FLAT: f64 = 0.01;

/// Effects that fit within this much of 2 ln L of the named one belong to its set.
pub const WITHIN: f64 = 4.0;

/// A candidate refitted with everything else.
#[derive(Debug, Clone)]
pub struct Refined {
    pub effect: &'static str,
    pub target: String,
    pub placed: Vec<EffectInstance>,
    /// Gain in 2 ln L over the hypothesis without it.
    pub gain: f64,
    /// Parameters it adds.
    pub parameters: usize,
    pub fit: Fit,
}

impl Refined {
    /// Gain less the price of the parameters (BIC).
    pub fn merit(&self, price: f64) -> f64 {
        self.gain - price * self.parameters as f64
    }

    /// A gap over position that is the same everywhere.
    pub(in crate::diagnose) fn is_flat(&self) -> bool {
        self.placed.first().is_some_and(|p| flat(&p.effect).is_some())
    }
}

/// What could replace a found effect, the found one among them.
#[derive(Debug, Clone)]
pub struct Alternative {
    pub effect: &'static str,
    pub target: String,
    /// Gain in 2 ln L over the hypothesis without it.
    pub gain: f64,
    pub parameters: usize,
}

impl Alternative {
    /// Gain less the price of the parameters (BIC).
    pub fn merit(&self, price: f64) -> f64 {
        self.gain - price * self.parameters as f64
    }
}

impl From<&Refined> for Alternative {
    fn from(r: &Refined) -> Self {
        Self { effect: r.effect, target: r.target.clone(), gain: r.gain, parameters: r.parameters }
    }
}

/// One accepted effect, in the order of acceptance.
#[derive(Debug, Clone)]
pub struct Step {
    pub effect: &'static str,
    pub target: String,
    /// A later step put another effect in its place.
    pub replaced_by: Option<String>,
}

impl Step {
    pub(in crate::diagnose) fn new(effect: &'static str, target: String) -> Self {
        Self { effect, target, replaced_by: None }
    }
}

/// An effect that a further round would name.
#[derive(Debug, Clone)]
pub struct Next {
    pub effect: &'static str,
    pub target: String,
    pub axis: Option<usize>,
    /// Gain in 2 ln L.
    pub gain: f64,
    pub parameters: usize,
    pub p_value: f64,
}

/// The size of a gap over position that hardly varies.
pub(in crate::diagnose) fn flat(effect: &Effect) -> Option<f64> {
    let b = effect.get::<BacklashPosition>()?;
    let (least, most) = (b.half_gap.smallest(), b.half_gap.largest());
    (most - least < FLAT * most).then_some(0.5 * (least + most))
}
