//! A joint with a gap along a recording.

use crate::numerics::series::Series;

/// Where a joint stands after its gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// Position, rad or m.
    pub at: f64,
    /// The side that pushes; 0 before the first contact.
    pub side: i8,
    /// Time at which this side began to push, s.
    pub since_s: f64,
    /// Where the joint stood when it did, rad or m.
    pub from: f64,
}

/// A joint after its gap, on a grid of parts of the intervals.
#[derive(Debug, Clone)]
pub struct Play {
    states: Vec<Stand>,
    half_gap: f64,
    first: f64,
}

/// Parts of an interval in which a joint with a gap is followed; within one it moves in one direction.
const PARTS: usize = 8;

impl Play {
    /// Motion of a joint with a gap that follows a channel: it stands until its command has crossed the gap. `begin`: where it stands
    /// in its gap at first, from the first command.
    pub fn of(series: &Series, channel: usize, half_gap: f64, begin: f64) -> Self {
        let half_gap = half_gap.max(0.0);
        let t_s = series.times();
        let n = t_s.len();
        let first = if n > 1 { series.within(channel, 0, 0.0).0 } else { 0.0 };
        let at = first + begin.clamp(-half_gap, half_gap);
        let mut stand = Stand { at, side: 0, since_s: t_s.first().copied().unwrap_or(0.0), from: at };
        let mut states = Vec::with_capacity(n * PARTS);
        for k in 0..n.saturating_sub(1) {
            for part in 0..PARTS {
                let x = part as f64 / PARTS as f64;
                let t = t_s[k] + x * (t_s[k + 1] - t_s[k]);
                stand = pushed(stand, series.within(channel, k, x).0, t, half_gap);
                states.push(stand);
            }
        }
        Self { states, half_gap, first }
    }

    /// The first command.
    pub fn first(&self) -> f64 {
        self.first
    }

    /// Where the joint stands; `None` outside.
    pub fn at(&self, series: &Series, channel: usize, t: f64) -> Option<Stand> {
        let k = series.before(t)?;
        let x = series.share(k, t);
        let part = ((x * PARTS as f64) as usize).min(PARTS - 1);
        Some(pushed(self.states[k * PARTS + part], series.within(channel, k, x).0, t, self.half_gap))
    }
}

fn pushed(stand: Stand, command: f64, t: f64, half_gap: f64) -> Stand {
    let (at, side) = if command - half_gap > stand.at {
        (command - half_gap, 1)
    } else if command + half_gap < stand.at {
        (command + half_gap, -1)
    } else {
        return stand;
    };
    let (since_s, from) = if side == stand.side { (stand.since_s, stand.from) } else { (t, stand.at) };
    Stand { at, side, since_s, from }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_crossed_before_the_joint_moves_back() {
        // up, a dwell, down
        let t: Vec<f64> = (0..9).map(f64::from).collect();
        let s = Series::new(t, vec![vec![0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 2.0, 1.0, 0.0]], &[1e-9]);
        let play = Play::of(&s, 0, 0.25, 0.0);
        let at = |t: f64| play.at(&s, 0, t).unwrap();
        assert_eq!((at(4.5).at, at(4.5).side), (2.75, 1));
        assert_eq!(at(5.2).at, 2.75);
        assert!((at(7.0).at - 1.25).abs() < 1e-12 && at(7.0).side == -1);
        // the command has fallen by both half gaps
        assert!((at(7.0).since_s - 5.6).abs() < 0.15 && at(7.0).from == 2.75, "{:?}", at(7.0));
    }

    #[test]
    fn a_joint_that_has_not_moved_stands_where_it_stood_in_its_gap() {
        let t: Vec<f64> = (0..5).map(f64::from).collect();
        let s = Series::new(t, vec![vec![0.0, 0.0, 0.0, 1.0, 2.0]], &[1e-9]);
        let play = Play::of(&s, 0, 0.25, -0.25);
        let at = |t: f64| play.at(&s, 0, t).unwrap();
        assert_eq!((at(1.5).at, at(1.5).side), (-0.25, 0));
        assert_eq!((at(4.0).at, at(4.0).side), (1.75, 1));
    }
}
