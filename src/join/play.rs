//! A joint with a gap along a recording.

use crate::numerics::series::Series;

/// A joint after its gap, on a grid of parts of the intervals.
#[derive(Debug, Clone)]
pub struct Play {
    states: Vec<(f64, i8)>,
    half_gap: f64,
}

/// Parts of an interval in which a joint with a gap is followed; within one it moves in one direction.
const PARTS: usize = 8;

impl Play {
    /// Motion of a joint with a gap that follows a channel: it stands until its command has crossed the gap.
    pub fn of(series: &Series, channel: usize, half_gap: f64) -> Self {
        let half_gap = half_gap.max(0.0);
        let n = series.times().len();
        let (mut at, mut side) = (if n > 1 { series.within(channel, 0, 0.0).0 } else { 0.0 }, 0i8);
        let mut states = Vec::with_capacity(n * PARTS);
        for k in 0..n.saturating_sub(1) {
            for part in 0..PARTS {
                let x = part as f64 / PARTS as f64;
                (at, side) = pushed(at, side, series.within(channel, k, x).0, half_gap);
                states.push((at, side));
            }
        }
        Self { states, half_gap }
    }

    /// Position after the gap, and the side that pushes (0 before the first contact, when the position is a guess); `None` outside.
    pub fn at(&self, series: &Series, channel: usize, t: f64) -> Option<(f64, i8)> {
        let k = series.before(t)?;
        let x = series.share(k, t);
        let part = ((x * PARTS as f64) as usize).min(PARTS - 1);
        let (at, side) = self.states[k * PARTS + part];
        Some(pushed(at, side, series.within(channel, k, x).0, self.half_gap))
    }
}

/// Before its first contact a joint stands anywhere within its gap: only a command that has gone all the way across touches it surely.
fn pushed(at: f64, side: i8, command: f64, half_gap: f64) -> (f64, i8) {
    if side == 0 {
        let gone = command - at;
        let sure = gone.abs() > 2.0 * half_gap;
        return if sure { (command - half_gap.copysign(gone), if gone > 0.0 { 1 } else { -1 }) } else { (at, 0) };
    }
    if command - half_gap > at {
        (command - half_gap, 1)
    } else if command + half_gap < at {
        (command + half_gap, -1)
    } else {
        (at, side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_crossed_before_the_joint_moves_back() {
        // up, a dwell, down
        let t: Vec<f64> = (0..9).map(f64::from).collect();
        let s = Series::new(t, vec![vec![0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 2.0, 1.0, 0.0]], &[1e-9]);
        let play = Play::of(&s, 0, 0.25);
        assert_eq!(play.at(&s, 0, 4.5).unwrap(), (2.75, 1));
        assert_eq!(play.at(&s, 0, 5.2).unwrap().0, 2.75);
        let (at, side) = play.at(&s, 0, 7.0).unwrap();
        assert!((at - 1.25).abs() < 1e-12 && side == -1);
    }
}
