//! Why a move of an INFORM job stays as it is, where only INFORM says so.

/// Why a move stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// Stations or bases alone.
    #[error("it names no position of the robot")]
    NoPosition,
    /// `C00001 C00002`.
    #[error("it names two positions of one kind")]
    TwoPositions,
    /// The job gives its position variable a value.
    #[error("position variable P{0:03} is set in the job")]
    VariableSet(u32),
    /// Others may give its position variable a value.
    #[error("position variable P{number:03}: its value may be changed at run time ({why})")]
    VariableUncertain {
        /// Of the variable.
        number: u32,
        /// Why.
        why: Box<Uncertain>,
    },
    /// No point may come before it.
    #[error("its target is a position variable")]
    ToVariable,
    /// Its moves want several values of a position variable.
    #[error("position variable P{0:03}: its moves need different values, and it has but one")]
    VariableShared(u32),
    /// A position that only the controller has.
    #[error("{0} is not in the list of the job")]
    NotInList(Box<str>),
    /// A word such as `P[I000]`.
    #[error("{0} is set at run time")]
    SetAtRunTime(Box<str>),
    /// A position before the header that it needs: `///POSTYPE`, `///TOOL`, `///USER`.
    #[error("no {0} before its position")]
    NoHeader(&'static str),
    /// A copy of its position would stand under another header.
    #[error("no {0} before its position, which a copy after the other positions would get")]
    NoHeaderToCopy(&'static str),
    /// A position of fewer numbers than a pose.
    #[error("a Cartesian position of fewer than six numbers")]
    FewNumbers,
    /// Poses among positions of joints.
    #[error("{kind}{number:05} holds no joint values")]
    NoJointValues {
        /// The word of its kind, `EC`.
        kind: &'static str,
        /// Of the position.
        number: u32,
    },
    /// External axes before the arm.
    #[error("the robot file's external axes before the arm are not the base axes of the position")]
    OtherBaseAxes,
    /// Fewer stations than the robot file has axes.
    #[error("it has too few numbers for the robot's external axes")]
    FewExternalAxes,
    /// Numbers beyond the robot's axes change.
    #[error("axes that the robot file does not have may move along")]
    OthersMove,
    /// `+MOVJ`.
    #[error("a second motion group moves along")]
    SecondGroup,
    /// `SMOVL`.
    #[error("synchronised with a station or another robot")]
    Synchronised,
    /// `MOVC`, `MOVS`.
    #[error("an arc or spline is given by its neighbours")]
    ByNeighbours,
    /// `IMOV`.
    #[error("a relative move")]
    Relative,
    /// The word of a move that is not known.
    #[error("{0} is not known")]
    UnknownMove(Box<str>),
    /// `IF` on the line.
    #[error("it is made on a condition alone")]
    Conditional,
    /// `PL=I000`.
    #[error("`{0}`: the size of its corner is computed")]
    CornerComputed(Box<str>),
    /// `NWAIT`, and what follows is no move.
    #[error("what follows runs with its start (NWAIT)")]
    FollowerRunsWithIt,
    /// A tag that is not known.
    #[error("`{0}` on the move is not known")]
    UnknownTag(Box<str>),
    /// The job's control group is none of the robot file's.
    #[error("the job is of group {0}")]
    ForeignGroup(Box<str>),
    /// `UNTIL`.
    #[error("an input may stop it")]
    MayStop,
    /// What is laid over the path: weaving, a shift.
    #[error("{} is on", .0.join(" and "))]
    Overlaid(Box<[&'static str]>),
    /// `STEP#` counts moves, so that none may be added.
    #[error("STEP# in the job counts its moves")]
    StepsCounted,
    /// `STEP#` reads this move.
    #[error("STEP# in the job reads where it leads")]
    StepRead,
    /// A relative move follows.
    #[error("IMOV after it counts from where it ends")]
    BeforeRelative,
    /// `GETPOS`, `$PX000` after it.
    #[error("the job reads where it ends")]
    EndIsRead,
    /// `CALL JOB:A UF#(3)` of a relative job (RJ).
    #[error("the job is a relative one, and another job calls it in another user frame (UF#)")]
    RelativeJob,
    /// A frame on a base that moves.
    #[error("a robot on base axes")]
    OnBase,
    /// `///TFRAME`, `///RECTAN` of a master.
    #[error("a tool frame, or one of another robot")]
    OtherFrame,
}

/// Why a position variable may have another value than the list of the job gives it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Uncertain {
    /// Another job uses it.
    #[error("another job beside this one names it")]
    Named,
    /// A file that cannot be read.
    #[error("{0} is not read")]
    Unread(Box<str>),
    /// An instruction that is not known.
    #[error("{0} is not known")]
    Unknown(Box<str>),
    /// `CLEAR P001 10`.
    #[error("CLEAR sets several")]
    Clear,
    /// A variable by a computed number.
    #[error("`{0}` may be any")]
    Any(Box<str>),
    /// `CALL I000`.
    #[error("a job that is named at run time is called and does not stand beside this one")]
    CallComputed,
    /// A call of a job that is not there.
    #[error("job {0} is called and does not stand beside this one")]
    CallsAbsent(Box<str>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_put_together_of_their_parts() {
        let why = Reason::VariableUncertain { number: 5, why: Box::new(Uncertain::Named) };
        let words =
            "position variable P005: its value may be changed at run time (another job beside this one names it)";
        assert_eq!(why.to_string(), words);
        assert_eq!(Reason::Overlaid(["WVON", "SFTON"].into()).to_string(), "WVON and SFTON is on");
        let other = Reason::NoJointValues { kind: "EC", number: 12 };
        assert_eq!(other.to_string(), "EC00012 holds no joint values");
    }
}
