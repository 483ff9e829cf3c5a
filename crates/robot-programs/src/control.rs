//! What a control takes for granted before a program says otherwise: absolute or relative words, millimetres or inches, and whether whole
//! numbers are in these units or count increments.

/// Modes in which a control starts a program; `None`: not known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Control {
    /// G90, else G91.
    pub absolute: Option<bool>,
    /// G20, else G21.
    pub inch: Option<bool>,
    /// A number of an axis word without a decimal point is in mm, inches or degrees. Else it may count least input increments, as on
    /// controls with conventional decimal point input (`X500` is 0.5 mm there).
    pub whole_units: bool,
}

/// The word for [`Control::whole_units`].
pub const WHOLE_UNITS: &str = "whole-units";

/// A word that is none of G20, G21, G90, G91 and `whole-units`, or that contradicts one before it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}`")]
pub struct UnknownWord(pub String);

impl Control {
    /// Reads words such as `G21`, `G90` and `whole-units`, case ignored.
    ///
    /// # Errors
    /// The word that is none of them, or the second of two that contradict each other.
    ///
    /// ```
    /// use robot_programs::gcode::Control;
    /// let control = Control::of_words(["G21", "g90"]).unwrap();
    /// assert_eq!((control.absolute, control.inch), (Some(true), Some(false)));
    /// assert!(!control.whole_units && Control::of_words(["whole-units"]).unwrap().whole_units);
    /// assert_eq!(Control::of_words(["G21", "G20"]).unwrap_err().0, "G20");
    /// ```
    pub fn of_words<'a>(words: impl IntoIterator<Item = &'a str>) -> Result<Self, UnknownWord> {
        let mut control = Self::default();
        for word in words {
            if word.trim().eq_ignore_ascii_case(WHOLE_UNITS) {
                control.whole_units = true;
                continue;
            }
            let (slot, value) = match word.trim().to_ascii_uppercase().as_str() {
                "G90" => (&mut control.absolute, true),
                "G91" => (&mut control.absolute, false),
                "G20" => (&mut control.inch, true),
                "G21" => (&mut control.inch, false),
                _ => return Err(UnknownWord(word.trim().into())),
            };
            if slot.is_some_and(|known| known != value) {
                return Err(UnknownWord(word.trim().into()));
            }
            *slot = Some(value);
        }
        Ok(control)
    }

    /// What these words say, and what `other` says where they say nothing.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            absolute: self.absolute.or(other.absolute),
            inch: self.inch.or(other.inch),
            whole_units: self.whole_units || other.whole_units,
        }
    }

    /// The words that say the same.
    pub fn words(self) -> Vec<&'static str> {
        let inch = self.inch.map(|inch| if inch { "G20" } else { "G21" });
        let absolute = self.absolute.map(|absolute| if absolute { "G90" } else { "G91" });
        let whole = self.whole_units.then_some(WHOLE_UNITS);
        inch.into_iter().chain(absolute).chain(whole).collect()
    }

    /// Codes of these words, times ten.
    pub(super) fn codes(self) -> impl Iterator<Item = u32> {
        let inch = self.inch.map(|inch| if inch { 200 } else { 210 });
        let absolute = self.absolute.map(|absolute| if absolute { 900 } else { 910 });
        inch.into_iter().chain(absolute)
    }
}
