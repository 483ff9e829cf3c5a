//! What an X word of a lathe counts: a diameter, or the place of the axis.

use crate::script::cursor::Cursor;

/// What an X word counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Across {
    /// The place of the axis.
    Radius,
    /// Twice that.
    Diameter,
    /// Twice that in absolute words, and the way of the axis in relative ones.
    AbsoluteDiameter,
}

impl Across {
    pub(super) fn of_control(diameter: bool) -> Self {
        if diameter { Self::Diameter } else { Self::Radius }
    }

    /// The word with which a text begins, and its length.
    ///
    /// `across = "DIAMON" | "DIAMOF" | "DIAM90"`
    pub(super) fn of_word(text: &[u8]) -> Option<(Self, usize)> {
        let mut cursor = Cursor::new(text);
        cursor.while_is(|b| b.is_ascii_alphanumeric() || b == b'_');
        let word = cursor.since(0);
        let known = [
            (&b"DIAMON"[..], Self::Diameter),
            (&b"DIAMOF"[..], Self::Radius),
            (&b"DIAM90"[..], Self::AbsoluteDiameter),
        ];
        let (_, across) = known.into_iter().find(|(name, _)| word.eq_ignore_ascii_case(name))?;
        // `DIAMON[X2]`: of another axis
        (cursor.peek() != Some(b'[')).then_some((across, word.len()))
    }

    /// Way of the axis by one unit of a word; `absolute`: G90.
    pub(super) fn factor(self, absolute: Option<bool>) -> f64 {
        match self {
            Self::Radius => 1.0,
            Self::Diameter => 0.5,
            Self::AbsoluteDiameter => {
                if absolute == Some(false) {
                    1.0
                } else {
                    0.5
                }
            }
        }
    }
}
