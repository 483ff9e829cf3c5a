//! `stiction`: a joint stands still behind a reversal, then the servo works the error off (seed 000 equations 8 and 9).
//!
//! Adds `-dir * min(|p - p_rev|, spike * decay(...))` behind each reversal: the joint does not move until the command has
//! moved that far from its turning point; without the minimum it would leap against its command. Nothing before the first
//! reversal. The spike decays with the time since the reversal, or with the travel.
//!
//! Parameters: spike 0 or more, at most 0.1 rad or 10 mm; decay above 0. Action: friction: grease, preload, integral gain of the
//! servo; a fading offset behind each reversal undoes it.

use super::Track;

/// How the spike decays: `exp(-(t - t_rev) / s)`, or `exp(-|p - p_rev| / travel)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decay {
    /// Time constant, s.
    Time(f64),
    /// Travel constant, rad or m.
    Travel(f64),
}

impl Decay {
    /// Share of the spike that is left `since_s` seconds and `travel` (rad or m) behind the reversal.
    #[inline]
    pub fn left(&self, since_s: f64, travel: f64) -> f64 {
        match self {
            Self::Time(tau) => (-since_s / tau).exp(),
            Self::Travel(lambda) => (-travel.abs() / lambda).exp(),
        }
    }
}

/// Spike in rad or m, and its decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiction {
    pub spike: f64,
    pub decay: Decay,
}

impl Stiction {
    /// Adds the error to `signal` in place.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        for (turn, samples) in track.strokes() {
            let dir = f64::from(turn.dir);
            for i in samples {
                let travel = (track.p[i] - turn.p).abs();
                let spike = self.spike * self.decay.left(track.t_s[i] - turn.t_s, travel);
                signal[i] -= dir * travel.min(spike);
            }
        }
    }
}
