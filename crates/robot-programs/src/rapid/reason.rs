//! Why a move of a RAPID program stays as it is, where only RAPID says so.

/// Why a move stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// A function gives the target: the call.
    #[error("`{0}` computes the target")]
    Function(Box<str>),
    /// `p{i}`.
    #[error("the index of `{0}` is computed")]
    IndexComputed(Box<str>),
    /// No module of the task at hand declares it.
    #[error("`{0}` is declared in another module")]
    NotDeclared(Box<str>),
    /// Data of another type.
    #[error("`{0}` is no jointtarget")]
    NoJointTarget(Box<str>),
    /// Its declaration has no such numbers.
    #[error("`{0}` is not declared with numbers")]
    NoNumbers(Box<str>),
    /// Four numbers of another length than 1.
    #[error("its orientation is no quaternion")]
    NoQuaternion,
    /// A call in a list of joints.
    #[error("a value of it is computed")]
    ValueComputed,
    /// A name for six axes.
    #[error("its axes are no list of numbers")]
    NoList,
    /// The value of an axis, by its name.
    #[error("axis {0} of it is no plain number")]
    AxisComputed(Box<str>),
    /// Two declarations of one name.
    #[error("`{0}` is declared more than once")]
    Twice(Box<str>),
    /// What the caller hands over.
    #[error("`{0}` is a parameter of the routine")]
    Parameter(Box<str>),
    /// Data that get another value.
    #[error("`{0}` is assigned")]
    Assigned(Box<str>),
    /// Data as an argument of what may change them.
    #[error("`{name}` is passed to `{to}`, which may set it")]
    Passed {
        /// The data.
        name: Box<str>,
        /// The routine or instruction.
        to: Box<str>,
    },
    /// The program sets data by computed names.
    #[error("`{0}` may be set by SetDataVal; a CONST could not")]
    SetDataVal(Box<str>),
    /// A file beside it sets data by computed names.
    #[error("`{name}` may be set at run time: {by}")]
    SetByName {
        /// The data.
        name: Box<str>,
        /// What it does.
        by: Elsewhere,
    },
    /// A global name that a file beside it may give another value.
    #[error("`{name}` is global and not constant: {by}")]
    SetElsewhere {
        /// The data.
        name: Box<str>,
        /// What it does.
        by: Elsewhere,
    },
    /// A global name in a module that is not the program itself.
    #[error("`{0}` is global and not constant: another module may set it (LOCAL or CONST would settle it)")]
    Global(Box<str>),
    /// `SearchL`.
    #[error("a search may end anywhere on its way")]
    Search,
    /// `MoveExtJ`.
    #[error("MoveExtJ moves external axes alone")]
    ExternalAlone,
    /// What leads the arm: an instruction such as `softact`.
    #[error("{0} leads the arm away from its targets")]
    Led(&'static str),
    /// A switch of the move leads it: `\Corr`.
    #[error("a sensor or a pattern leads it off its path (\\{0})")]
    LedBySwitch(&'static str),
    /// `\T:=t`.
    #[error("its time \\T is no plain number, and cannot be shared out")]
    TimeComputed,
    /// `SingArea \Wrist`.
    #[error("SingArea lets the wrist turn otherwise on its way")]
    SingArea,
    /// They cannot be copied.
    #[error("its external axes are no plain numbers")]
    ExternalComputed,
    /// A new point would have to share their way out.
    #[error("its external axes move, too")]
    ExternalMove,
    /// An arc that cannot be written in pieces.
    #[error("it is an arc")]
    Arc,
    /// `IF a MoveL ...`.
    #[error("it is the one statement of an IF")]
    InIf,
    /// `\ID`.
    #[error("it is synchronised with another robot (\\ID)")]
    Synchronised,
    /// A process move.
    #[error("its actions hang on the way to its target")]
    Actions,
    /// A frame on external axes whose place is not known.
    #[error("external axes that are computed, and may carry the robot or the work object")]
    CarrierComputed,
    /// A work object on a unit of another task.
    #[error("a unit of another task may carry the work object `{0}`")]
    OnOtherTask(Box<str>),
    /// A work object that comes along.
    #[error("a conveyor carries the work object `{0}`")]
    OnConveyor(Box<str>),
    /// A work object in the gripper.
    #[error("the robot holds the work object `{0}`")]
    RobotHolds(Box<str>),
    /// A work object on another robot.
    #[error("another robot carries the work object `{0}`")]
    OnOtherRobot(Box<str>),
    /// An interrupt may set it at any time.
    #[error("a TRAP sets `{0}`")]
    SetInTrap(Box<str>),
    /// A move without a tool.
    #[error("it names no tool")]
    NoTool,
    /// A tool that is not on the robot.
    #[error("tool `{0}` stands still, and the robot holds the work object")]
    StandingTool(Box<str>),
}

/// Why a file that is not read with the module leaves a value uncertain; its name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Elsewhere {
    /// It assigns the name.
    #[error("{0} may set it")]
    Sets(Box<str>),
    /// It has the same persistent with another value.
    #[error("{0} declares it with another value")]
    Declares(Box<str>),
    /// What it does is not known.
    #[error("{0} is not read, and may set it")]
    Unread(Box<str>),
    /// It sets data by computed names.
    #[error("{0} sets data by name")]
    ByName(Box<str>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_put_together_of_their_parts() {
        let by = Elsewhere::Declares("m1.mod".into());
        let why = Reason::SetElsewhere { name: "tT".into(), by };
        assert_eq!(why.to_string(), "`tT` is global and not constant: m1.mod declares it with another value");
        let led = Reason::LedBySwitch("corr").to_string();
        assert_eq!(led, "a sensor or a pattern leads it off its path (\\corr)");
    }
}
