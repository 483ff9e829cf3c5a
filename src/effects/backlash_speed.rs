//! `backlash_speed`: play whose half gap grows, or shrinks, with the TCP speed: `b = half_gap + slope * speed`.
//!
//! The speed is that of the commanded TCP (seed 003 finds such a dependence). The operator is that of [`super::backlash`] with
//! a gap that varies along the way; a gap below 0 is none. Parameters: half gap 0 or more, at most 0.1 rad or 10 mm (more is
//! a broken joint); slope of either sign, at most 0.1 rad or 10 mm per m/s. Action: as for backlash; compensate at the speed at
//! which the program runs.

use super::Track;

/// Half gap at rest (rad or m), and its slope (rad or m per m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BacklashSpeed {
    pub half_gap: f64,
    pub slope: f64,
}

impl BacklashSpeed {
    /// Half gap at a TCP speed in m/s.
    #[inline]
    pub fn half_gap_at(&self, speed_m_s: f64) -> f64 {
        (self.half_gap + self.slope * speed_m_s).max(0.0)
    }

    /// Play on `signal` in place.
    pub fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(&first) = signal.first() else { return };
        let at = |i: usize| self.half_gap_at(track.tcp_speed_m_s.get(i).copied().unwrap_or(0.0));
        let mut out = first - f64::from(track.initial_gap_side) * at(0);
        for (i, s) in signal.iter_mut().enumerate() {
            let b = at(i);
            out = out.clamp(*s - b, *s + b);
            *s = out;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_that_of_the_speed() {
        let p = [0.0, 1.0, 2.0, 1.0, 0.0];
        let t = [0.0, 1.0, 2.0, 3.0, 4.0];
        let speed = [0.0, 1.0, 1.0, 2.0, 2.0];
        let mut track = Track::new(&t, &p, 0.0);
        track.tcp_speed_m_s = &speed;
        let mut s = p.to_vec();
        BacklashSpeed { half_gap: 0.1, slope: 0.05 }.apply(&track, &mut s);
        let want = [0.0, 0.85, 1.85, 1.2, 0.2];
        assert!(s.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{s:?}");
    }
}
