//! What a control takes for granted before a program says otherwise: absolute or relative words, millimetres or inches, whether whole
//! numbers are in these units or count increments, whether X is a diameter, and how rotary axes turn.

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
    /// X words are diameters, as on most lathes: the axis moves by half of their value. Else they are the places of the axis.
    pub diameter: Option<bool>,
    /// Absolute words of rotary axes lead to the angle as it is counted: `A10` after `A350` turns back by 340 deg. Else a control may take
    /// the shorter way (rollover).
    pub no_rollover: bool,
    /// Moves end exactly at their goals (G61), until the program says otherwise.
    pub exact_stop: bool,
}

/// The word for [`Control::whole_units`].
pub const WHOLE_UNITS: &str = "whole-units";
/// The words for [`Control::diameter`].
pub const DIAMETER: &str = "diameter";
/// X words are places of the axis ([`Control::diameter`]).
pub const RADIUS: &str = "radius";
/// The word for [`Control::no_rollover`].
pub const NO_ROLLOVER: &str = "no-rollover";
/// The word for [`Control::exact_stop`].
pub const EXACT_STOP: &str = "G61";
/// The words that there are, for messages.
pub const WORDS: &str = "G90 or G91, G20 or G21, whole-units, diameter or radius, no-rollover, and G61";

/// A word that is none of [`WORDS`], or that contradicts one before it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}`")]
pub struct UnknownWord(pub String);

impl Control {
    /// Reads words such as `G21`, `G90`, `whole-units` and `diameter`, case ignored.
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
    /// assert_eq!(Control::of_words(["diameter"]).unwrap().diameter, Some(true));
    /// assert_eq!(Control::of_words(["diameter", "radius"]).unwrap_err().0, "radius");
    /// ```
    pub fn of_words<'a>(words: impl IntoIterator<Item = &'a str>) -> Result<Self, UnknownWord> {
        let mut control = Self::default();
        for word in words {
            let (slot, value) = match word.trim().to_ascii_lowercase().as_str() {
                WHOLE_UNITS => {
                    control.whole_units = true;
                    continue;
                }
                NO_ROLLOVER => {
                    control.no_rollover = true;
                    continue;
                }
                "g61" => {
                    control.exact_stop = true;
                    continue;
                }
                DIAMETER => (&mut control.diameter, true),
                RADIUS => (&mut control.diameter, false),
                "g90" => (&mut control.absolute, true),
                "g91" => (&mut control.absolute, false),
                "g20" => (&mut control.inch, true),
                "g21" => (&mut control.inch, false),
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
            diameter: self.diameter.or(other.diameter),
            no_rollover: self.no_rollover || other.no_rollover,
            exact_stop: self.exact_stop || other.exact_stop,
        }
    }

    /// The words that say the same.
    pub fn words(self) -> Vec<&'static str> {
        let inch = self.inch.map(|inch| if inch { "G20" } else { "G21" });
        let absolute = self.absolute.map(|absolute| if absolute { "G90" } else { "G91" });
        let whole = self.whole_units.then_some(WHOLE_UNITS);
        let diameter = self.diameter.map(|diameter| if diameter { DIAMETER } else { RADIUS });
        let rollover = self.no_rollover.then_some(NO_ROLLOVER);
        let exact = self.exact_stop.then_some(EXACT_STOP);
        inch.into_iter().chain(absolute).chain(whole).chain(diameter).chain(rollover).chain(exact).collect()
    }

    /// Codes of these words, times ten.
    pub(super) fn codes(self) -> impl Iterator<Item = u32> {
        let inch = self.inch.map(|inch| if inch { 200 } else { 210 });
        let absolute = self.absolute.map(|absolute| if absolute { 900 } else { 910 });
        inch.into_iter().chain(absolute)
    }
}
