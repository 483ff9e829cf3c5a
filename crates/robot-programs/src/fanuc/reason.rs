//! Why a motion of a FANUC TP program stays as it is, where only TP says so.

/// Why a motion stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// The goal is a position register.
    #[error("a position register: its value is not in the program")]
    Register,
    /// The same of one that is not in the listing.
    #[error("a position register: its value is not in the program (PR[{0}])")]
    NotListed(u64),
    /// No frame or tool is certainly selected for its pose.
    #[error("a position register: in which user frame and for which tool PR[{0}] counts is not known")]
    RegisterFrame(u64),
    /// The frame or tool of its pose is set.
    #[error("a position register: the program sets the frame or the tool of PR[{0}]")]
    RegisterFrameSet(u64),
    /// A program gives it another value.
    #[error("a position register: {by} may set PR[{register}]")]
    RegisterSet {
        /// The program.
        by: Box<str>,
        /// The register.
        register: u64,
    },
    /// A program may give any register another value.
    #[error("a position register: PR[{register}] may be set ({program}: {why})")]
    RegisterMayBeSet {
        /// The register.
        register: u64,
        /// The program.
        program: Box<str>,
        /// Why it may.
        why: SetsAny,
    },
    /// The value of a register, which is not written.
    #[error("the value of PR[{0}] is not in the program, but known by the listing")]
    Listed(u64),
    /// No point may come before it.
    #[error("it leads to a position register")]
    ToRegister,
    /// The section has no such position.
    #[error("P[{0}] is not in /POS")]
    NotInPos(u64),
    /// A position that gets another value.
    #[error("the program writes P[{position}] (line {line})")]
    Written {
        /// The position.
        position: u64,
        /// Where.
        line: u64,
    },
    /// A position of other groups alone.
    #[error("P[{0}] has no group 1")]
    NoGroup(u64),
    /// `********`.
    #[error("P[{0}] is not taught")]
    NotTaught(u64),
    /// A pose, and so no joint target.
    #[error("a Cartesian position")]
    Cartesian,
    /// A position with too few numbers.
    #[error("P[{0}] holds neither joints nor a pose")]
    NeitherJointsNorPose(u64),
    /// By a register, along the axes of a frame or a tool.
    #[error("an offset is added to the goal")]
    Offset,
    /// `INC`.
    #[error("an increment: the goal depends on where the robot stands")]
    Increment,
    /// What leads the robot: a weave, a conveyor.
    #[error("{0} leads the robot away from its positions")]
    Led(&'static str),
    /// The leader of a coordinated motion moves.
    #[error("COORD: its way is straight for a part that another group moves")]
    LeaderMoves,
    /// `COORD`: no point may come before it.
    #[error("it is coordinated with another group")]
    Coordinated,
    /// The goal is a word of another kind.
    #[error("the goal is no position")]
    NoPosition,
    /// `PAL_1[A_1]`.
    #[error("a point of palletizing: its place is counted while the program runs")]
    OfPallet,
    /// `P[R[1]]`.
    #[error("the position's index is computed")]
    IndexComputed,
    /// A motion by another letter than J, L, C and A.
    #[error("`{0}` is no motion that is known")]
    UnknownMotion(Box<str>),
    /// An option that is not known.
    #[error("`{0}` is not known: it may move the goal")]
    UnknownOption(Box<str>),
    /// `MROT`.
    #[error("MROT: the wrist takes the shorter turn, whatever the position says")]
    ShorterTurn,
    /// `RTCP`.
    #[error("RTCP: the part moves along a tool that stands still")]
    RemoteTool,
    /// `SEARCH[...]`.
    #[error("a search ends where it touches")]
    Search,
    /// `SKIP`.
    #[error("a skip may end it before its goal")]
    Skip,
    /// `WJNT`.
    #[error("Wjnt: the wrist turns joint by joint on its way")]
    WristByJoint,
    /// A speed in seconds.
    #[error("its duration is written, and a point on the way would have its own duration")]
    Duration,
    /// `TB`, `DB`: the last piece of a motion that is cut would start it.
    #[error("what it starts before its end (TB, DB) would start late")]
    StartsBeforeEnd,
    /// Neither FINE nor CNT.
    #[error("how it ends (FINE, CNT) is not known")]
    UnknownEnd,
    /// What is none of the robot's moves between the positions.
    #[error("another axis or group may move with it")]
    OthersMove,
    /// An axis of the robot file may be an external one.
    #[error("which axes of the robot file are external is not certain")]
    UnclearAxes,
    /// New lines could not be counted.
    #[error("no attribute gives the number of lines, which must grow (LINE_COUNT)")]
    NoLineCount,
    /// An increment follows.
    #[error("a motion after it counts from where it ends (INC)")]
    BeforeIncrement,
    /// `LPOS`, `JPOS` after it.
    #[error("the program reads where it ends (LPOS, JPOS)")]
    EndIsRead,
    /// A frame on an extended axis whose place is not known.
    #[error("an extended axis that is not taught, and may carry the robot")]
    CarrierNotTaught,
    /// `UF`, `UT` without a number: the user frame or the tool.
    #[error("the {0} that is selected")]
    Selected(&'static str),
}

/// Why a program may set any position register.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SetsAny {
    /// What it does is not known.
    #[error("it cannot be read")]
    Unread,
    /// `CALL SR[1]`.
    #[error("it calls a program whose name is computed")]
    CallComputed,
    /// It calls a program that is not there.
    #[error("{0} is called and is not among the files")]
    CallsAbsent(Box<str>),
    /// `MONITOR`.
    #[error("a monitor may run a program")]
    Monitor,
    /// `ERROR_PROG`, `RESUME_PROG`.
    #[error("an error may run a program")]
    ErrorProgram,
    /// An instruction that is not known.
    #[error("`{0}` is not known")]
    Unknown(Box<str>),
    /// A block in a statement.
    #[error("a block within a statement is not read")]
    Nested,
    /// `PR[R[1]]=...`.
    #[error("it sets a register of a computed number")]
    NumberComputed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_put_together_of_their_parts() {
        let why = Reason::RegisterMayBeSet { register: 3, program: "A.LS".into(), why: SetsAny::Unread };
        assert_eq!(why.to_string(), "a position register: PR[3] may be set (A.LS: it cannot be read)");
        assert_eq!(Reason::Selected("user frame").to_string(), "the user frame that is selected");
    }
}
