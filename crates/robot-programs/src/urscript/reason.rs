//! Why a move of a URScript program stays as it is, where only URScript says so.

/// Why a move stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// A pose that is computed.
    #[error("its target is no pose of plain numbers")]
    NoPose,
    /// Joints of a pose that is computed.
    #[error("get_inverse_kin computes the target")]
    InverseKinematics,
    /// The joints near which it looks for a solution.
    #[error("qnear of get_inverse_kin is computed")]
    NearComputed,
    /// A name without a value.
    #[error("`{0}` is not assigned")]
    NotAssigned(Box<str>),
    /// `q =`.
    #[error("`{0}` is assigned nothing")]
    AssignedNothing(Box<str>),
    /// What the caller hands over.
    #[error("`{0}` is a parameter of the function")]
    Parameter(Box<str>),
    /// A name of another file.
    #[error("`{0}` is not assigned in this file")]
    NotInFile(Box<str>),
    /// `q[0] = 1`.
    #[error("an element of `{0}` is assigned")]
    ElementAssigned(Box<str>),
    /// An assignment in a branch or a loop.
    #[error("`{0}` is assigned under a condition")]
    AssignedConditionally(Box<str>),
    /// A method of a list may change it: `q.append(1)`.
    #[error("`{name}.{method}()` changes it")]
    Method {
        /// Of the list.
        name: Box<str>,
        /// What is called.
        method: Box<str>,
    },
    /// Several assignments of a name.
    #[error("`{0}` is assigned more than once")]
    AssignedTwice(Box<str>),
    /// Its target is neither a list nor a pose.
    #[error("it is no list of numbers")]
    NoList,
    /// A value of its list, counted from 1.
    #[error("value {0} of its list is no plain number")]
    ValueComputed(usize),
    /// `d2r()` of a linear axis, by its name.
    #[error("axis {0} is not in degrees")]
    NotInDegrees(Box<str>),
    /// A new point so near that the blend would have to be smaller. Universal Robots, user manual, chapter "Move", "Blend parameters": what
    /// stands after a waypoint with a blend is evaluated as the TCP crosses the blend radius.
    #[error("what follows it is done as the robot enters its blend r=, which a new point would make smaller")]
    ActsInBlend,
    /// The call of a function that leads the robot.
    #[error("{0}() leads the robot away from the target")]
    Led(&'static str),
    /// The goal of `speedj`, `speedl`.
    #[error("a velocity ends where its time ends")]
    VelocityEnds,
    /// No point may come before it.
    #[error("it commands a velocity")]
    Velocity,
    /// `movec(..., mode=1)`.
    #[error("mode: on this arc the tool keeps its turn to the tangent, whatever the pose says")]
    Tangent,
    /// An arc that cannot be written in pieces.
    #[error("it is an arc or a process move")]
    ArcOrProcess,
    /// An arc through a computed point.
    #[error("it is an arc whose points are not all numbers")]
    ArcComputed,
    /// Another statement stands on its line.
    #[error("it shares its line with other code")]
    SharedLine,
    /// Less than two cycles.
    #[error("its time is too short to be shared out over two cycles of the controller")]
    TimeTooShort,
    /// `t=t1`.
    #[error("its time is no plain number, and cannot be shared out")]
    TimeComputed,
    /// `servoj` without `t`.
    #[error("it has no time t= that could be shared out")]
    NoTime,
    /// The pose of the tool on the flange.
    #[error("a TCP that is computed")]
    TcpComputed,
    /// Its function is called more than once, and sets it by what may be another value each time.
    #[error("a TCP that may be another one each time its function is called")]
    TcpDiffers,
}
