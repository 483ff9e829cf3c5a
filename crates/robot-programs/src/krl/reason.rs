//! Why a motion of a KRL program stays as it is, where only KRL says so.

/// Why a motion stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// An expression, a call, a computed index.
    #[error("the goal is computed")]
    Computed,
    /// A variable of the system, `$POS_ACT`.
    #[error("{0} is known on the controller only")]
    OnController(Box<str>),
    /// A point that no file declares.
    #[error("{0} is not declared in the files given")]
    NotDeclared(Box<str>),
    /// The value of a point is not certain.
    #[error("{name}: {why}")]
    Uncertain {
        /// The point.
        name: Box<str>,
        /// Why.
        why: Box<Uncertain>,
    },
    /// The name of a whole array.
    #[error("{0} is an array")]
    Array(Box<str>),
    /// A point that nothing gives a value.
    #[error("{0} has no value in the program")]
    NoValue(Box<str>),
    /// A use may run before the one assignment of a point.
    #[error("{name}: its value is not certain: it is assigned in line {line}, but not always before it is used")]
    AssignedSometimes {
        /// The point.
        name: Box<str>,
        /// Of the assignment.
        line: u64,
    },
    /// A point gets another value.
    #[error("{name} is assigned while the program runs (line {line})")]
    Assigned {
        /// The point.
        name: Box<str>,
        /// Of the first assignment.
        line: u64,
    },
    /// A coordinate that is no plain number.
    #[error("{part} of {} is an expression", whose(.of))]
    PartComputed {
        /// `X`, `Y`, `Z`, `A`, `B` or `C`.
        part: &'static str,
        /// The point; `None`: the goal itself.
        of: Option<Box<str>>,
    },
    /// A coordinate is missing.
    #[error("a part of {} is not given", whose(.0))]
    PartMissing(Option<Box<str>>),
    /// An axis value that is no plain number.
    #[error("{0} is computed")]
    AxisComputed(Box<str>),
    /// `LIN {A1 ...}`.
    #[error("axis values in a motion that takes a Cartesian position")]
    AxesForPose,
    /// An axis of the robot file may be any of KRL's.
    #[error("which of A1 to A6 and E1 to E6 the joints of the robot file are is not certain: name them so")]
    UnclearAxes,
    /// It names other axes alone.
    #[error("it moves none of the robot's axes")]
    OtherAxes,
    /// `CA` moves the end of an arc.
    #[error("an angle CA tells where the arc ends")]
    AngleOfArc,
    /// What leads the robot: a conveyor, a sensor.
    #[error("{0} leads the robot away from its points")]
    Led(&'static str),
    /// A seam of ArcTech with data of which the files do not tell whether it is woven or tracked.
    #[error("{0} is not certain in the files given: on this seam the robot may weave or track")]
    WeldDataUncertain(Box<str>),
    /// By `$ORI_TYPE`.
    #[error("$ORI_TYPE: the tool does not turn to the orientation of the point")]
    TurnsOtherwise,
    /// By `$ORI_TYPE #JOINT`.
    #[error("$ORI_TYPE #JOINT: the wrist turns axis by axis on its way")]
    WristByAxis,
    /// The goal of `LIN_REL`, which is known and not written.
    #[error("a relative motion: it counts from where the motion before ends")]
    Relative,
    /// The goal of a relative motion after an unknown place.
    #[error("a relative motion: the goal depends on where the robot stands")]
    RelativeToUnknown,
    /// A relative motion follows.
    #[error("a relative motion after it would carry its offset along")]
    BeforeRelative,
    /// A goal that lacks parts follows.
    #[error("the goal of a motion after it lacks parts, which stay as they are here")]
    BeforePartial,
    /// The goal lacks parts.
    #[error("its goal lacks parts, which stay as they are at the point before it")]
    Partial,
    /// Within `SPLINE ... ENDSPLINE`.
    #[error("it stands in a spline block, whose curve a further point would change")]
    InSpline,
    /// Something happens at a place of this motion.
    #[error("a TRIGGER before it belongs to this very motion")]
    Trigger,
    /// A fold with more than one motion and its settings.
    #[error("its inline form does more than this motion")]
    FormDoesMore,
    /// An axis that the robot file does not have.
    #[error("an external axis may move with it")]
    ExternalAxis,
    /// A new point would have no axis to name.
    #[error("no motion of the program gives axis values")]
    NoAxisValues,
    /// A frame on an external axis whose place is not known.
    #[error("an external axis that is computed, and may carry the robot or the work piece")]
    CarrierComputed,
    /// Which joints are meant is not known.
    #[error("a status S or turn T that is computed")]
    ConfigurationComputed,
    /// What `WITH` makes a frame cannot be read: `$BASE`, `$TOOL`.
    #[error("WITH {0}")]
    With(&'static str),
    /// What a frame was made of may be one of several.
    #[error("a base or tool of which it is not certain what was assigned last")]
    FrameUncertain,
    /// A base on a conveyor or another robot.
    #[error(
        "base {base} counts from MACHINE_DEF[{machine}] of $config.dat, which is no external axis of this controller"
    )]
    BaseMoves {
        /// Its number in `BASE_DATA`.
        base: u32,
        /// That of the machine.
        machine: u32,
    },
    /// No base means what it did.
    #[error(transparent)]
    MovesBase(#[from] MovesBase),
    /// A point of an inline form whose value the program computes.
    #[error("its inline form names {0}, whose value the program computes: no numbers can take its place there")]
    ComputedInForm(Box<str>),
    /// A point of an inline form, of which the writer needs a clone.
    #[error("its inline form cannot take a clone of {0}, which other uses need as it is")]
    NoClone(Box<str>),
}

/// Whose part: that of a point, or of the goal itself.
fn whose(name: &Option<Box<str>>) -> &str {
    name.as_deref().unwrap_or("its position")
}

/// What makes any base mean something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MovesBase {
    /// The tool stands still, as frame data say.
    #[error("the robot holds the part (IPO_FRAME #TCP)")]
    HoldsPart,
    /// Whether the tool or the part is on the robot.
    #[error("$IPO_MODE is set")]
    IpoMode,
    /// The world in which bases count.
    #[error("$WORLD is set")]
    World,
    /// The robot in the world.
    #[error("$ROBROOT is set")]
    RobRoot,
}

impl MovesBase {
    /// `$WORLD` or `$ROBROOT`, by its name.
    pub(super) fn of_world(word: &str) -> Self {
        if word == "$WORLD" { Self::World } else { Self::RobRoot }
    }
}

/// A line of the program or of another module.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Where {
    /// Of the program, from 1.
    #[error("line {0}")]
    Line(u64),
    /// Of another module.
    #[error("{file}:{line}")]
    File {
        /// Its name.
        file: Box<str>,
        /// From 1.
        line: u64,
    },
}

impl Where {
    /// Line `k`, from 0, of a file.
    pub(super) fn in_file(name: &str, k: usize) -> Self {
        Self::File { file: name.into(), line: k as u64 + 1 }
    }
}

/// Why the value of a declared point is not certain.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Uncertain {
    /// It is declared with an expression.
    #[error("its value is computed")]
    Computed,
    /// The data list gives it no plain value, or two.
    #[error("its value in the data list is not plain")]
    NotPlain,
    /// Several modules declare it for all.
    #[error("it is declared in several modules")]
    SeveralModules,
    /// One of its components gets another value.
    #[error("a part of it is assigned while the program runs ({0})")]
    PartAssigned(Where),
    /// Another module gives it another value.
    #[error("it is assigned while the program runs ({0})")]
    Assigned(Where),
    /// A routine gets it as an argument.
    #[error("it is passed to {to}, which may change it ({at})")]
    Passed {
        /// The routine.
        to: Box<str>,
        /// Where.
        at: Where,
    },
    /// `IMPORT ... IS`.
    #[error("another module has its own name for it ({0})")]
    OtherName(Where),
    /// Its list is public, and this file cannot be read.
    #[error("its value is not certain: its data list is public, and {0} cannot be read")]
    PublicList(Box<str>),
    /// A point of all modules, of which one cannot be read.
    #[error("its value is not certain: it is one of all modules ({at}), and {unread} cannot be read")]
    GlobalUnread {
        /// Its declaration.
        at: Where,
        /// The file.
        unread: Box<str>,
    },
    /// A point of all modules, which are not there.
    #[error(
        "its value is not certain: it is one of all modules ({0}), and no whole project with its $config.dat was found"
    )]
    GlobalAlone(Where),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_put_together_of_their_parts() {
        let of = |why| Reason::Uncertain { name: "XP1".into(), why: Box::new(why) }.to_string();
        let passed = of(Uncertain::Passed { to: "SUB".into(), at: Where::Line(3) });
        assert_eq!(passed, "XP1: it is passed to SUB, which may change it (line 3)");
        let alone = "its value is not certain: it is one of all modules (a.dat:2), and no whole project with its $config.dat was found";
        assert_eq!(Uncertain::GlobalAlone(Where::in_file("a.dat", 1)).to_string(), alone);
        assert_eq!(Reason::PartMissing(None).to_string(), "a part of its position is not given");
        let computed = Reason::PartComputed { part: "Z", of: Some("XP1".into()) };
        assert_eq!(computed.to_string(), "Z of XP1 is an expression");
        assert_eq!(Reason::from(MovesBase::of_world("$ROBROOT")).to_string(), "$ROBROOT is set");
    }
}
