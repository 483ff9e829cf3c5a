//! `backlash` and `backlash_position`: the play operator (seed 000 equations 6 and 7).
//!
//! The output follows its input at the distance of the half gap `b` and stands still inside the gap. `b` may be a
//! function of the commanded position. Start: in the middle of the gap, unless the track says on which side.
//!
//! Parameter: half gaps of 0 or more, at most 0.1 rad or 10 mm: more is a broken joint. Action: take up the gap (preload, shim,
//! change the nut); an offset of half a gap in the direction of travel undoes it.

use super::{GapCurve, Track};

/// Play with half gap `half_gap` (rad or m, 0 or more).
#[derive(Debug, Clone, PartialEq)]
pub struct Backlash {
    pub half_gap: GapCurve,
}

impl Backlash {
    /// A gap that is the same everywhere.
    pub fn constant(half_gap: f64) -> Self {
        Self { half_gap: GapCurve::Constant(half_gap) }
    }

    /// Play on `signal` in place; the gap is looked up at the command.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(&first) = signal.first() else { return };
        let mut out = first - f64::from(track.initial_gap_side) * self.half_gap.at(track.p[0]);
        let fixed = self.half_gap.constant();
        for (s, &p) in signal.iter_mut().zip(track.p) {
            let b = fixed.unwrap_or_else(|| self.half_gap.at(p));
            out = out.clamp(*s - b, *s + b);
            *s = out;
        }
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
