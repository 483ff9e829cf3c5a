//! The effect catalogue: every fault of a machine that the tool knows, in one place, for simulating, diagnosing and
//! compensating alike.
//!
//! A joint effect turns the signal that arrives at its place of the chain into the one that leaves it:
//! command -> servo ([`stiction`]) -> gear ([`backlash`]) -> geometry -> TCP -> measurement. The stages are chained (the
//! gear sees what the servo made), not added as in seed 000 equation 10; the two differ only while a gap is crossed.
//!
//! Rooms:
//! - [`track`]: a joint's command with its directions and turning points, which effects look at.
//! - [`curve`]: a half gap as a function of position: constant, polynomial, PCHIP.
//! - [`backlash`], [`stiction`]: one file per effect: equation, parameters, action.
//! - [`entry`]: an effect as it stands in a model file, to and from its type, with every refusal.
//!
//! Adding an effect is a file here, a variant below and its line in [`Effect::stage`], [`Effect::apply`] and [`entry`].

pub mod backlash;
pub mod curve;
pub mod entry;
pub mod stiction;
pub mod track;

pub use backlash::Backlash;
pub use curve::GapCurve;
pub use stiction::{Decay, Stiction};
pub use track::{Track, Turn};

/// Place in the chain; effects act in this order, and within a stage in the order of the model file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    Servo,
    Gear,
}

/// One effect on one joint. Values are SI (rad or m, s).
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// `backlash` and `backlash_position`: the play operator with a half gap that may depend on position.
    Backlash(Backlash),
    Stiction(Stiction),
}

impl Effect {
    /// Name in the catalogue.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Backlash(b) if b.half_gap.constant().is_none() => "backlash_position",
            Self::Backlash(_) => "backlash",
            Self::Stiction(_) => "stiction",
        }
    }

    /// Where it acts.
    pub fn stage(&self) -> Stage {
        match self {
            Self::Backlash(_) => Stage::Gear,
            Self::Stiction(_) => Stage::Servo,
        }
    }

    /// Turns the arriving signal (rad or m, one value per sample of `track`) into the leaving one, in place.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        match self {
            Self::Backlash(b) => b.apply(track, signal),
            Self::Stiction(s) => s.apply(track, signal),
        }
    }
}

/// Output of a joint for its command: all `effects` in the order of their stages (stable within a stage).
pub fn joint_output<'a>(track: &Track, effects: impl IntoIterator<Item = &'a Effect>) -> Vec<f64> {
    let mut signal = track.p.to_vec();
    let mut ordered: Vec<&Effect> = effects.into_iter().collect();
    ordered.sort_by_key(|e| e.stage());
    for e in ordered {
        e.apply(track, &mut signal);
    }
    signal
}
