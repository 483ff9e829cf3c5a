//! A joint's position for its command, by the effects of servo and gear.

use super::{Effect, Stage, Track};

/// Applies the effects of one stage to a signal, in their order.
pub fn apply_stage<'a>(stage: Stage, track: &Track, effects: impl IntoIterator<Item = &'a Effect>, signal: &mut [f64]) {
    for e in effects.into_iter().filter(|e| e.stage() == stage) {
        e.apply(track, signal);
    }
}

/// Output of a joint's gear for its command: servo, then gear, in the order given within each.
pub fn joint_output<'a>(track: &Track, effects: impl IntoIterator<Item = &'a Effect> + Clone) -> Vec<f64> {
    let mut signal = track.p.to_vec();
    apply_stage(Stage::Servo, track, effects.clone(), &mut signal);
    apply_stage(Stage::Gear, track, effects, &mut signal);
    signal
}
