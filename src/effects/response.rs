//! Friction's response after a reversal: it builds up over travel, the servo works it off in time, gear and link wind up.
//!
//! The counterpart of the law that [`crate::identify`] fits to all logs of a machine. Along a stroke in one direction:
//!
//! ```text
//! z   = 1 + (z - 1) exp(-travel of the command / presliding)         -1 at a turn after a long stroke (Dahl 1968)
//! h_k = z filtered by a first-order high-pass of time constant tau_k  what the servo has not yet worked off
//! z_m = the same as z over the travel of the joint, each with its own presliding
//! joint stands back by   sum of windup_m z_m + sum of gain_k h_k      beside its half gap
//! ```

/// Most time constants that a response holds.
pub const MOST_SPIKES: usize = 3;
/// Most parts of a wind-up.
pub const MOST_WINDUPS: usize = 3;

/// Parameters; rad or m, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Travel of the command over which friction in the servo turns over by a factor e.
    pub presliding: f64,
    /// Elastic deflection; unused parts are 0.
    pub windups: [Windup; MOST_WINDUPS],
    /// Half the change of the servo's error and the time in which it is worked off; unused ones have gain 0.
    pub spikes: [Spike; MOST_SPIKES],
}

/// A part of the servo's answer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spike {
    /// Size, rad or m.
    pub gain: f64,
    /// Time over which it decays to 1/e, s.
    pub decay_s: f64,
}

/// A part of the wind-up: half its change, and the travel of the joint over which it turns over by a factor e.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Windup {
    /// Half the change of the wind-up, rad or m.
    pub half: f64,
    /// Travel over which it turns over to a share of 1/e, rad or m.
    pub presliding: f64,
}

/// Where friction stands, in the sense of the present stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Friction as a share of its largest value, -1 to 1.
    pub z: f64,
    /// What is left of each spike, as a share of it.
    pub h: [f64; MOST_SPIKES],
    /// Each part of the wind-up, as a share of its half, -1 to 1.
    pub z_joint: [f64; MOST_WINDUPS],
}

impl State {
    /// After a long stroke against the present one.
    pub const TURNED: Self = Self { z: -1.0, h: [0.0; MOST_SPIKES], z_joint: [-1.0; MOST_WINDUPS] };
    /// After a long stroke along the present one.
    pub const DRAGGED: Self = Self { z: 1.0, h: [0.0; MOST_SPIKES], z_joint: [1.0; MOST_WINDUPS] };

    /// The same, seen from a stroke the other way.
    pub fn reversed(&self) -> Self {
        Self { z: -self.z, h: self.h.map(|h| -h), z_joint: self.z_joint.map(|z| -z) }
    }
}

/// `z` after a travel of `by` in the sense of the stroke.
fn turned(z: f64, by: f64, over: f64) -> f64 {
    1.0 + (z - 1.0) * (-by.max(0.0) / over).exp()
}

impl Spike {
    /// What is left after `dt_s` of what there was, and of a change that was spread evenly over the time.
    pub fn fades(&self, dt_s: f64) -> [f64; 2] {
        let x = dt_s / self.decay_s;
        [(-x).exp(), if x > 1e-9 { -(-x).exp_m1() / x } else { 1.0 }]
    }
}

impl Response {
    /// The state after `command` and `joint` have moved on (rad or m, 0 or more) in `dt_s`.
    pub fn advance(&self, state: &State, command: f64, joint: f64, dt_s: f64) -> State {
        let z = turned(state.z, command, self.presliding);
        let mut z_joint = state.z_joint;
        for (z, w) in z_joint.iter_mut().zip(&self.windups).filter(|(_, w)| w.half != 0.0) {
            *z = turned(*z, joint, w.presliding);
        }
        let mut h = state.h;
        for (h, s) in h.iter_mut().zip(&self.spikes).filter(|(_, s)| s.gain != 0.0) {
            let [fade, share] = s.fades(dt_s.max(0.0));
            *h = *h * fade + (z - state.z) * share;
        }
        State { z, h, z_joint }
    }

    /// Wind-up as it stands.
    fn wound(&self, state: &State) -> f64 {
        self.windups.iter().zip(&state.z_joint).map(|(w, z)| w.half * z).sum()
    }

    /// How far the joint stands back beside its half gap.
    pub fn back(&self, state: &State) -> f64 {
        self.wound(state) + self.spikes.iter().zip(&state.h).map(|(s, h)| s.gain * h).sum::<f64>()
    }

    /// Half the change of the whole elastic deflection.
    pub fn windup(&self) -> f64 {
        self.windups.iter().map(|w| w.half).sum()
    }

    /// Travel over which the slowest part builds up by a factor e, rad or m.
    pub fn longest_presliding(&self) -> f64 {
        let used = self.windups.iter().filter(|w| w.half != 0.0);
        used.map(|w| w.presliding).fold(self.presliding, f64::max)
    }

    /// Sum of the gains: half of the largest change of the servo's error.
    pub fn gain(&self) -> f64 {
        self.spikes.iter().map(|s| s.gain.abs()).sum()
    }

    /// Longest and shortest time constant in use, s.
    pub fn decays_s(&self) -> Option<[f64; 2]> {
        let used = self.spikes.iter().filter(|s| s.gain != 0.0).map(|s| s.decay_s);
        let (lo, hi) = used.fold((f64::INFINITY, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
        (hi > 0.0).then_some([lo, hi])
    }

    /// After `since_s` and `travel` (rad or m) of a stroke, less than `share` of the response is still to come.
    pub fn gone(&self, since_s: f64, travel: f64, share: f64) -> bool {
        let left: f64 = self.spikes.iter().map(|s| 2.0 * s.gain.abs() * (-since_s / s.decay_s.max(1e-9)).exp()).sum();
        let over = |presliding: f64| (-travel.max(0.0) / presliding.max(f64::MIN_POSITIVE)).exp();
        let wound = self.windups.iter().filter(|w| w.half != 0.0);
        let (unbuilt, whole) = wound.fold((self.gain() * over(self.presliding), self.gain()), |(u, all), w| {
            (u + w.half.abs() * over(w.presliding), all + w.half.abs())
        });
        left <= share * 2.0 * self.gain() && unbuilt <= share * whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: Response = Response {
        presliding: 2e-5,
        windups: [
            Windup { half: 1e-5, presliding: 2e-5 },
            Windup { half: 0.0, presliding: 1.0 },
            Windup { half: 0.0, presliding: 1.0 },
        ],
        spikes: [
            Spike { gain: 3e-5, decay_s: 1.0 },
            Spike { gain: 0.0, decay_s: 1.0 },
            Spike { gain: 0.0, decay_s: 1.0 },
        ],
    };

    #[test]
    fn one_long_step_equals_many_short_ones() {
        let mut many = State::TURNED;
        for _ in 0..4000 {
            many = R.advance(&many, 1e-8, 1e-8, 1e-4);
        }
        // dz/dt = (1 - z) v / presliding, h' = z' - h / tau: solved by hand for v = 1e-4
        let (v, t) = (1e-4, 0.4);
        let a = v / R.presliding;
        let z = 1.0 - 2.0 * (-a * t).exp();
        let h = 2.0 * a / (a - 1.0) * ((-t).exp() - (-a * t).exp());
        assert!((many.z - z).abs() < 1e-9 && (many.h[0] - h).abs() < 1e-3, "{many:?} {z} {h}");
    }

    #[test]
    fn a_response_ends_as_wind_up_alone() {
        let moved = R.advance(&State::TURNED, 1e-2, 1e-2, 0.1);
        assert!(R.back(&moved) > R.windup() + 1e-5, "the spike has not decayed");
        let end = R.advance(&moved, 0.0, 0.0, 100.0);
        assert!((R.back(&end) - R.windup()).abs() < 1e-12);
        assert!(R.gone(20.0, 1e-2, 2e-3) && !R.gone(1.0, 1e-2, 2e-3) && !R.gone(20.0, 1e-6, 2e-3));
    }
}
