//! `hysteresis`: lost motion that builds up smoothly behind a reversal: adds `-half_width * z`, `dz/dp = (1 - z dir)/presliding`.
//!
//! Dahl's model (P. Dahl, A solid friction model, 1968) over the signal that arrives. Parameters: half width 0 or more, at most
//! 0.1 rad or 10 mm (as a gap); presliding, the travel over which 63 % of the turn-over builds up, above 0. Action: look
//! for wind-up (belt, harmonic drive, cable) rather than for a gap; stiffen, or preload.
//!
//! Method: `z = dir + (z0 - dir) exp(-travel/presliding)` on each monotone piece, exact between samples. Start: `z = 0`, or the
//! initial side of the gap.

use super::Track;

/// Half width in rad or m, and presliding travel in rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysteresis {
    pub half_width: f64,
    pub presliding: f64,
}

impl Hysteresis {
    /// Adds the error to `signal` in place.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(&first) = signal.first() else { return };
        let mut z = f64::from(track.initial_gap_side);
        let mut before = first;
        for s in signal {
            let step = *s - before;
            before = *s;
            if step != 0.0 {
                let side = step.signum();
                z = side + (z - side) * (-step.abs() / self.presliding).exp();
            }
            *s -= self.half_width * z;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_stroke_saturates_and_a_reversal_turns_over_smoothly() {
        let t: Vec<f64> = (0..2001).map(f64::from).collect();
        let p: Vec<f64> = t.iter().map(|&t| if t <= 1000.0 { t * 1e-3 } else { 2.0 - t * 1e-3 }).collect();
        let track = Track::new(&t, &p, 0.0);
        let mut s = p.clone();
        Hysteresis { half_width: 0.01, presliding: 0.05 }.apply(&track, &mut s);
        assert!((s[1000] - (1.0 - 0.01)).abs() < 1e-9);
        // 0.05 behind the turn: z = -1 + 2/e
        let z = -1.0 + 2.0 * (-1.0f64).exp();
        assert!((s[1050] - (0.95 - 0.01 * z)).abs() < 1e-9);
        assert!((s[2000] - 0.01).abs() < 1e-9);
    }

    #[test]
    fn fewer_samples_of_a_monotone_piece_give_the_same() {
        let run = |p: &[f64]| {
            let t: Vec<f64> = (0..p.len()).map(|i| i as f64).collect();
            let mut s = p.to_vec();
            Hysteresis { half_width: 0.01, presliding: 0.05 }.apply(&Track::new(&t, p, 0.0), &mut s);
            *s.last().unwrap()
        };
        assert!((run(&[0.0, 0.1, 0.07]) - run(&[0.0, 0.02, 0.09, 0.1, 0.085, 0.07])).abs() < 1e-15);
    }
}
