//! Frames and tools to which the numbers of a pose belong.

use crate::script::reason::Reason;
use nalgebra::Isometry3;

/// Between the name of a frame and the places of the axes that carry it.
const AT: &str = " at ";

/// A frame: of the numbers in the world, or of the tool on the flange.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Frame {
    /// World, or flange.
    #[default]
    Null,
    /// The robot's base.
    Base,
    /// The text gives it.
    Given(Isometry3<f64>),
    /// The controller has it under this name or number, and it stands fixed there while the program runs.
    Named(String),
    /// The program computes it or may change it while it runs: it is asked for by these words. Only what is written in it again is right
    /// whatever its value is.
    Computed(String),
    /// One of these, and which is not certain: known where all are the same.
    Any(Vec<Frame>),
    /// It cannot be determined: why.
    Unknown(Reason),
}

impl Frame {
    /// One that cannot be determined.
    pub fn unclear(why: impl Into<Reason>) -> Self {
        Self::Unknown(why.into())
    }

    /// Why it cannot be determined, where the reader says so.
    pub fn unknown(&self) -> Option<&Reason> {
        match self {
            Self::Unknown(why) => Some(why),
            Self::Any(all) => all.iter().find_map(Self::unknown),
            _ => None,
        }
    }

    /// Whether its value depends on what the program does while it runs.
    pub fn is_computed(&self) -> bool {
        match self {
            Self::Computed(_) => true,
            Self::Any(all) => all.iter().any(Self::is_computed),
            _ => false,
        }
    }

    /// Whether a name of the program, in lower case, stands among the words that compute it.
    pub fn is_made_of(&self, word: &str) -> bool {
        let inside = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$');
        match self {
            Self::Computed(name) => {
                let name = name.to_lowercase();
                name.match_indices(word).any(|(at, _)| {
                    let before = name[..at].chars().next_back();
                    let after = name[at + word.len()..].chars().next();
                    !(before.is_some_and(inside) || after.is_some_and(inside))
                })
            }
            Self::Any(all) => all.iter().any(|f| f.is_made_of(word)),
            _ => false,
        }
    }

    /// What it is called, whatever external axes carry it and wherever these stand ([`Self::carried`]); empty: it has no name.
    pub fn name_at_rest(&self) -> String {
        match self {
            Self::Named(name) | Self::Computed(name) => match name.split_once(AT).map_or(name.as_str(), |(own, _)| own)
            {
                // the names under which a frame without one is asked for
                "$NULLFRAME" | "wobj0" | "0" => String::new(),
                own => own.to_string(),
            },
            _ => String::new(),
        }
    }

    /// A frame that the program makes of another one: computed, asked for by the name of that and by what is done. `own`: the name where it
    /// has none.
    pub fn made(self, own: &str, how: &str) -> Self {
        match self {
            Self::Unknown(_) => self,
            Self::Any(all) => Self::Any(all.into_iter().map(|f| f.made(own, how)).collect()),
            Self::Named(name) | Self::Computed(name) => Self::Computed(format!("{name} {how}")),
            _ => Self::Computed(format!("{own} {how}")),
        }
    }

    /// The frame where external axes carry the robot or the part: it has to be known for the place where these stand, and so it
    /// is named after both. `axes`: name and value of those that stand elsewhere than at 0; `own`: the frame's own name.
    pub fn carried(self, own: &str, axes: &[(String, f64)]) -> Self {
        if axes.is_empty() {
            return self;
        }
        let name = match &self {
            Self::Unknown(_) => return self,
            Self::Any(all) => return Self::Any(all.iter().map(|f| f.clone().carried(own, axes)).collect()),
            Self::Named(name) | Self::Computed(name) => name.as_str(),
            _ => own,
        };
        let at: Vec<String> = axes.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
        let name = format!("{name}{AT}{}", at.join(", "));
        if self.is_computed() { Self::Computed(name) } else { Self::Named(name) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computed_frame_is_made_of_whole_words() {
        let frame = Frame::Computed("wList{i} displaced by PDispOn at eax_a 30".into());
        assert!(frame.is_made_of("wlist") && frame.is_made_of("i"));
        assert!(!frame.is_made_of("w") && !frame.is_made_of("list") && !frame.is_made_of("a"));
        assert!(!Frame::Named("w".into()).is_made_of("w"));
        let by = Frame::Null.made("0", "with OFFSET,PR[12:UP]");
        assert!(by.is_computed() && by.is_made_of("pr") && by.is_made_of("pr[12") && !by.is_made_of("pr[1"));
        assert!(by.carried("0", &[("E1".into(), 5.0)]).is_computed());
    }
}
