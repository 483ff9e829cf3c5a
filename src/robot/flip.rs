//! Which of the two wrists of an arm its maker calls flipped.
//!
//! A pose is reached with two wrists: joint 5 at an angle or at its negative, joints 4 and 6 half a turn further. FANUC (F and N) and
//! Yaskawa (flip, the first number of `RCONF`) name one of them by a letter, and what it means is a property of the model and its
//! controller.

use std::f64::consts::{FRAC_PI_2, TAU};

/// Where the wrist is flipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flip {
    /// Joint 5 above zero.
    Positive,
    /// Joint 5 below zero.
    Negative,
    /// Joint 4 within a quarter turn of zero, by whole turns (Yaskawa NX100, instructions, manipulator types).
    Within,
    /// Joint 4 beyond that.
    Beyond,
}

/// A joint nearer to where the wrist becomes the other one has none for certain: a sine.
const CLEAR_SINE: f64 = 0.02;

impl Flip {
    /// What FANUC's F may mean, the most frequent first.
    pub const OF_FANUC: [Self; 2] = [Self::Positive, Self::Negative];
    /// What Yaskawa's flip may mean.
    pub const OF_YASKAWA: [Self; 4] = [Self::Within, Self::Positive, Self::Negative, Self::Beyond];
    /// All of them.
    const ALL: [Self; 4] = Self::OF_YASKAWA;

    /// The word of a robot file.
    pub fn word(self) -> &'static str {
        match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
            Self::Within => "within-90",
            Self::Beyond => "beyond-90",
        }
    }

    /// By the word of a robot file.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|flip| flip.word() == word)
    }

    /// How far joints of a six-axis arm (rad) are on the flipped side, as a sine; below zero: on the other; `None`: too few joints.
    fn side(self, q: &[f64]) -> Option<f64> {
        let wrist = q.get(4)?.sin();
        let within = |r: f64| (FRAC_PI_2 - (r - (r / TAU).round() * TAU).abs()).sin();
        Some(match self {
            Self::Positive => wrist,
            Self::Negative => -wrist,
            Self::Within => within(*q.get(3)?),
            Self::Beyond => -within(*q.get(3)?),
        })
    }

    /// Whether joints of a six-axis arm (rad) have the flipped wrist; `None`: too few joints.
    pub fn is_flipped(self, q: &[f64]) -> Option<bool> {
        let side = self.side(q)?;
        // each place has one wrist, also where both are the same
        Some(if matches!(self, Self::Negative | Self::Within) { side >= 0.0 } else { side > 0.0 })
    }

    /// The same where it is certain.
    pub fn is_clearly_flipped(self, q: &[f64]) -> Option<bool> {
        self.side(q).filter(|side| side.abs() > CLEAR_SINE).map(|side| side > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_meaning_names_one_of_the_two_wrists_of_a_pose() {
        let of = |q: [f64; 6]| q.map(f64::to_radians);
        let (one, other) = (of([0.0, 0.0, 0.0, 12.0, -65.0, 5.0]), of([0.0, 0.0, 0.0, -168.0, 65.0, -175.0]));
        for (flip, flipped) in
            [(Flip::Positive, false), (Flip::Negative, true), (Flip::Within, true), (Flip::Beyond, false)]
        {
            assert_eq!([flip.is_flipped(&one), flip.is_flipped(&other)], [Some(flipped), Some(!flipped)], "{flip:?}");
            assert_eq!(flip.is_clearly_flipped(&one), Some(flipped));
            assert_eq!(Flip::of_word(flip.word()), Some(flip));
        }
        assert_eq!(Flip::Positive.is_clearly_flipped(&of([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])), None);
        assert_eq!(Flip::Within.is_flipped(&[0.0; 3]), None);
    }
}
