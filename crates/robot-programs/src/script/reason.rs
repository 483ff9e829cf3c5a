//! Why a move stays as it is, as data: why its goal or a frame cannot be determined, why its numbers may not be changed, why no point may
//! come before it. Code compares the variants; the words are for readers.
//!
//! What several languages share stands here, what one language alone says in its own folder (`krl/reason.rs`).

// the enums alone: each language is built on this module
use crate::fanuc::reason as fanuc;
use crate::gcode::reason as gcode;
use crate::inform::reason as inform;
use crate::krl::reason as krl;
use crate::rapid::reason as rapid;
use crate::trajectory::reason as trajectory;
use crate::urscript::reason as urscript;

/// Why a move stays as it is. At most 24 bytes, as programs have many moves: what a language says of its own is boxed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// A motion without a goal.
    #[error("the motion has no goal")]
    NoGoal,
    /// The program takes on from there what it goes to later.
    #[error("the program reads where it ends")]
    EndIsRead,
    /// An arc without a point on its way that is known.
    #[error("an arc is given by three points")]
    ThreePoints,
    /// A copy of the statement would not be the same motion.
    #[error("its statement cannot be copied")]
    NoCopy,
    /// A frame or a tool changes on the way, and one of them is computed: no point on it would be right for all of their values.
    #[error("it leads from or to a frame or tool that the program computes, which is not that of the target before it")]
    ComputedPlace,
    /// A call within its arguments.
    #[error("its arguments call a function that may move the robot")]
    CallInArguments,
    /// The target is neither a name nor written in numbers: its text.
    #[error("the target `{0}` is an expression")]
    Expression(Box<str>),
    /// Names and kinds of the robot's axes do not tell the external ones: the names.
    #[error("which axes of the robot file ({0}) are external is not certain: name them E1, E2, ...")]
    UnclearAxes(Box<str>),
    /// The arm has fewer joints than a list of the controller, and their names do not tell their numbers: the names.
    #[error(
        "which of the six numbers of a target the joints of the robot file ({0}) have is not certain: name them J1, J2, ... by these numbers"
    )]
    UnclearNumbers(Box<str>),
    /// A number of the target for which the robot file has no joint changes.
    #[error("axes that the robot file does not have may move along")]
    OtherNumbers,
    /// What holds of a declared target, by its name.
    #[error("`{}`: {}", .0.0, .0.1)]
    Declared(Box<(Box<str>, Reason)>),
    /// A reason of KUKA KRL alone.
    #[error(transparent)]
    Krl(Box<krl::Reason>),
    /// A reason of FANUC TP alone.
    #[error(transparent)]
    Fanuc(Box<fanuc::Reason>),
    /// A reason of Yaskawa INFORM alone.
    #[error(transparent)]
    Inform(Box<inform::Reason>),
    /// A reason of ABB RAPID alone.
    #[error(transparent)]
    Rapid(Box<rapid::Reason>),
    /// A reason of URScript alone.
    #[error(transparent)]
    UrScript(Box<urscript::Reason>),
    /// A reason of G-code alone.
    #[error(transparent)]
    Gcode(Box<gcode::Reason>),
    /// A reason of ROS trajectories alone.
    #[error(transparent)]
    Trajectory(Box<trajectory::Reason>),
}

impl Reason {
    /// Names and kinds of the axes do not tell the external ones.
    pub fn unclear_axes(names: &[&str]) -> Self {
        Self::UnclearAxes(names.join(", ").into())
    }

    /// Names of the joints do not tell their numbers in a target.
    pub fn unclear_numbers(names: &[&str]) -> Self {
        Self::UnclearNumbers(names.join(", ").into())
    }

    /// The same of a declared target of that name.
    #[must_use]
    pub fn of_declared(self, name: &str) -> Self {
        Self::Declared(Box::new((name.into(), self)))
    }
}

/// Boxes what a language says.
macro_rules! of_languages {
    ($($variant:ident: $language:ident),*) => {
        $(impl From<$language::Reason> for Reason {
            fn from(reason: $language::Reason) -> Self {
                Self::$variant(Box::new(reason))
            }
        })*
    };
}

of_languages!(Krl: krl, Fanuc: fanuc, Inform: inform, Rapid: rapid, UrScript: urscript, Gcode: gcode, Trajectory: trajectory);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::Goal;

    #[test]
    fn reasons_and_goals_stay_small() {
        assert_eq!((size_of::<Reason>(), size_of::<Option<Reason>>(), size_of::<Goal>()), (24, 24, 24));
    }

    #[test]
    fn a_reason_of_a_declared_target_names_it() {
        let why = Reason::from(rapid::Reason::ValueComputed).of_declared("j1");
        assert_eq!(why.to_string(), "`j1`: a value of it is computed");
    }
}
