//! `backlash`: the play operator (Zhang (2023) equations 6 and 7).
//!
//! The output follows its input at the distance of the half gap `b` and stands still inside the gap. Start: in the middle of
//! the gap, unless the track says on which side.
//!
//! Parameter: a half gap of 0 or more, at most 0.1 rad or 10 mm: more is a broken joint. Action: take up the gap (preload, shim,
//! change the nut); an offset of half a gap in the direction of travel undoes it.

use super::common::*;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "backlash",
    heading: "backlash",
    stage: Stage::Gear,
    family: Family::Gap,
    acts_on: ActsOn::Joint,
    adds: "the joint follows its motor at half the gap and stands still while the gap is crossed",
    equation: "play operator: the output stays within half_gap of its input and moves only when pushed",
    reference: "Zhang (2023) equations 6 and 7; Tao, Kokotovic (1996), Adaptive Control of Systems with Actuator and Sensor Nonlinearities",
    parameters: &[("half_gap_deg", "half of the gap, 0 to 0.1 rad (10 mm); a larger gap means a broken joint")],
    confused_with: &["hysteresis", "backlash_position", "backlash_speed", "stiction"],
    decide_by: "reverse slowly, with rows inside the gap, at several positions and two speeds",
    action: "remove the gap (preload, shim, new nut or pinion); an offset of half a gap in the direction of travel compensates it",
    undone: "an offset of half a gap in the direction of travel",
    special: Special { after_reversal: AfterReversal::Step, needs_motion: true, ..Special::NONE },
    example: ("{effect: backlash, joint: A1, half_gap_deg: 0.003}", View::JointOverCommand),
    read: |f| Ok(Backlash { half_gap: f.length("half_gap", 0.0)? }.into()),
    typical: |size| vec![(size.key("half_gap"), size.gap.into())],
    candidates: |survey, list| {
        let gap = |b: f64| Backlash::constant(b.max(0.0));
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, gap).positive();
        list.extend(survey.moving().map(one));
    },
};

/// Play with half gap `half_gap` (rad or m, 0 or more).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backlash {
    /// Half gap, rad or m, 0 or more.
    pub half_gap: f64,
}

impl Backlash {
    /// A gap that is the same everywhere.
    pub fn constant(half_gap: f64) -> Self {
        Self { half_gap }
    }
}

/// Play on `signal` in place, with the half gap `b(i)` at sample `i`.
pub fn play(track: &Track, signal: &mut [f64], b: impl Fn(usize) -> f64) {
    let Some(&first) = signal.first() else { return };
    let mut out = first - f64::from(track.initial_gap_side) * b(0);
    for (i, s) in signal.iter_mut().enumerate() {
        // a gap that a schedule lets dip below zero by rounding is no gap
        let b = b(i).max(0.0);
        out = if s.is_nan() { *s } else { out.max(*s - b).min(*s + b) };
        *s = out;
    }
}

impl EffectType for Backlash {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Gap
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_gap]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_gap: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![site.length("half_gap", (0.0, site.most_lost()), site.typical(0.003, 0.005))]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        play(track, signal, |_| self.half_gap);
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn is_play(&self) -> bool {
        true
    }

    fn half_gap(&self) -> Option<GapCurve> {
        Some(GapCurve::Constant(self.half_gap))
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::gap(GapCurve::Constant(self.half_gap))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_output_stands_still_inside_the_gap() {
        let p = [0.0, 1.0, 2.0, 1.5, 1.0, 0.0, 0.5];
        let t: Vec<f64> = (0..p.len()).map(|i| i as f64).collect();
        let track = Track::new(&t, &p, 0.0);
        let mut s = p.to_vec();
        Backlash::constant(0.4).apply(&track, &mut s);
        let want = [0.0, 0.6, 1.6, 1.6, 1.4, 0.4, 0.4];
        assert!(s.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{s:?}");
    }
}
