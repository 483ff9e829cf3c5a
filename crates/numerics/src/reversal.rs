//! Reversals of a position that comes sample by sample, with a dead band.
//!
//! Method: the extreme of the present direction is remembered; a movement back from it by more than the dead band is a
//! reversal, and it happened at the last sample that stands on the extreme. A pause keeps the direction. Movement within
//! the dead band neither reverses nor, before the first movement, sets a direction. The first movement is no reversal.

/// State of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReversalDetector {
    deadband: f64,
    direction: i8,
    extreme: f64,
    at: usize,
    started: bool,
}

/// What a sample did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Movement {
    /// No direction yet.
    Rest,
    /// The first movement.
    Start {
        /// The last sample before it.
        since: usize,
    },
    /// The direction goes on, or the joint pauses.
    Same,
    /// Back within the dead band.
    Within,
    /// A reversal.
    Reversed {
        /// The last sample that stands on the extreme.
        at: usize,
        /// Position of the extreme.
        extreme: f64,
    },
}

impl ReversalDetector {
    /// `direction` (-1, +1; 0 where it is not known) is that of the movement before the first sample; `deadband` in the unit
    /// of the positions, 0 or more.
    pub fn new(deadband: f64, direction: i8) -> Self {
        Self { deadband, direction: direction.signum(), extreme: 0.0, at: 0, started: false }
    }

    /// Takes sample number `i` at `position`; numbers rise.
    #[inline]
    pub fn take(&mut self, i: usize, position: f64) -> Movement {
        if !self.started {
            (self.extreme, self.at, self.started) = (position, i, true);
            return if self.direction == 0 { Movement::Rest } else { Movement::Same };
        }
        let step = position - self.extreme;
        if self.direction == 0 {
            if step.abs() > self.deadband {
                let since = self.at;
                self.direction = if step > 0.0 { 1 } else { -1 };
                (self.extreme, self.at) = (position, i);
                return Movement::Start { since };
            }
            if step == 0.0 {
                self.at = i;
            }
            return Movement::Rest;
        }
        if step * f64::from(self.direction) >= 0.0 {
            (self.extreme, self.at) = (position, i);
            return Movement::Same;
        }
        if step.abs() <= self.deadband {
            return Movement::Within;
        }
        let (at, extreme) = (self.at, self.extreme);
        self.direction = -self.direction;
        (self.extreme, self.at) = (position, i);
        Movement::Reversed { at, extreme }
    }

    /// Takes samples that all go on in the present direction, or stay at its extreme; the last of them is number `i` at `position`.
    #[inline]
    pub fn go_on(&mut self, i: usize, position: f64) {
        (self.extreme, self.at) = (position, i);
    }

    /// Position of the last sample on the extreme of the present direction; `None`: no direction yet.
    #[inline]
    pub fn extreme(&self) -> Option<f64> {
        (self.started && self.direction != 0).then_some(self.extreme)
    }

    /// Takes sample `i` as the last on the extreme: a pause with noise that lasts too long to wait for its end.
    pub fn settle(&mut self, i: usize) {
        self.at = i;
    }

    /// Present direction: -1, +1, or 0 before the first movement.
    pub fn direction(&self) -> i8 {
        self.direction
    }

    /// Last sample on the extreme of the present direction.
    pub fn last_on_extreme(&self) -> usize {
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reversals(p: &[f64], deadband: f64, direction: i8) -> Vec<(usize, i8)> {
        let mut detector = ReversalDetector::new(deadband, direction);
        p.iter()
            .enumerate()
            .filter_map(|(i, &p)| match detector.take(i, p) {
                Movement::Reversed { at, .. } => Some((at, detector.direction())),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn a_reversal_stands_where_a_pause_ends() {
        assert_eq!(reversals(&[0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0], 0.0, 0), [(4, -1)]);
    }

    #[test]
    fn samples_that_go_on_may_be_taken_at_once() {
        let (mut one, mut all) = (ReversalDetector::new(0.1, 0), ReversalDetector::new(0.1, 0));
        assert_eq!(all.extreme(), None);
        for (i, p) in [0.0, 1.0, 1.5, 1.5, 2.0].into_iter().enumerate() {
            one.take(i, p);
            if i < 2 {
                all.take(i, p);
            }
        }
        all.go_on(4, 2.0);
        assert_eq!((all, all.extreme()), (one, Some(2.0)));
    }

    #[test]
    fn noise_within_the_dead_band_is_no_reversal() {
        assert_eq!(reversals(&[0.0, 1.0, 0.9999, 1.0, 2.0, 1.9999, 1.0], 0.001, 0), [(4, -1)]);
    }

    #[test]
    fn slow_movement_back_adds_up_to_a_reversal() {
        let p: Vec<f64> = [0.0, 1.0].into_iter().chain((1..=20).map(|k| 1.0 - 1e-4 * f64::from(k))).collect();
        assert_eq!(reversals(&p, 0.001, 0), [(1, -1)]);
    }

    #[test]
    fn the_first_movement_is_a_reversal_only_against_a_known_direction() {
        assert_eq!(reversals(&[0.0, 0.0, -1.0, -2.0], 0.0, 0), []);
        assert_eq!(reversals(&[0.0, 0.0, -1.0, -2.0], 0.0, 1), [(1, -1)]);
    }
}
