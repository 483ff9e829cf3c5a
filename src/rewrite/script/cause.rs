//! Why a move of a program stays as it is, and why directions are lost at it. Code compares the variants; the words are for readers.

use crate::program::script::{Goal, Move, OtherWay, Reason};

/// Why a move stays as it is, or why directions are lost at it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Cause {
    /// What the reader or the writer of the program's language says of it.
    #[error(transparent)]
    Program(Reason),
    /// A comment `lostmotion: off` stands before it.
    #[error("switched off by a comment")]
    SwitchedOff,
    /// A process such as welding is on, and the user leaves these moves out.
    #[error("a process is on")]
    ProcessOn,
    /// An axis has not been commanded yet.
    #[error("before the position of every axis is known")]
    NotYetKnown,
    /// The robot may come to it from either side of a gap: after a label, a loop, a call or a move that is not known, or where nothing
    /// moves before the next of these.
    #[error(
        "the first target after a label, a loop, a call or an unknown move: from which side its joints reach it is not known"
    )]
    SideUnknown,
    /// Several ways lead to it (passes of a loop, branches, jumps), and on one of them it would need other offsets than on another.
    #[error("several ways lead to it, and it is reached from other sides on its other ways (a loop, branches, jumps)")]
    PassesDiffer,
    /// A move that is not known follows it, and may count from where it ends.
    #[error("before a target that cannot be determined, which may count from this one")]
    BeforeUnknown,
    /// An axis comes to it from a place that is not in the program.
    #[error(
        "from which side an axis reaches it is not known (a work frame, a tool length or a position of the machine before it)"
    )]
    SideLost,
    /// Where an axis stands whose offset depends on it is not known.
    #[error("its work frame or tool length is not the first one, and an offset depends on the position")]
    Displaced,
    /// Its goal is a pose and poses are left as they are.
    #[error("Cartesian target")]
    Cartesian,
    /// The program does not determine frame or tool; what the reader says of it.
    #[error("a Cartesian target whose frame or tool cannot be determined: {0}")]
    NoPlace(Reason),
    /// A frame on the robot's base, and that is carried by an axis.
    #[error("a Cartesian target whose frame or tool cannot be determined: the robot's base moves on an external axis")]
    MovingBase,
    /// An external axis of the robot file has no position here.
    #[error("a Cartesian target at which the position of an external axis is not known")]
    ExternalUnknown,
    /// An external axis has an offset and the target no number for it.
    #[error("a Cartesian target that does not give the external axis whose offset it would need")]
    ExternalUnnamed,
    /// The robot has axes beside those of an arm, and the pose does not tell where they stand.
    #[error(
        "a Cartesian target of a robot whose axes a pose does not determine (external axes must be named E1, ... and come before six joints)"
    )]
    Redundant,
    /// Several frames or tools may be in force.
    #[error("a Cartesian target whose frame or tool is ambiguous")]
    SeveralPlaces,
    /// Frames and tools that the program names and that are not given.
    #[error("a Cartesian target with unknown {}", named(frames, tools))]
    NotGiven {
        /// Names of the frames.
        frames: Vec<String>,
        /// Names of the tools.
        tools: Vec<String>,
    },
    /// The program does not determine the tool that goes straight to joint values; what the reader says of it.
    #[error("a straight move to joint values with a tool that cannot be determined: {0}")]
    NoTool(Reason),
    /// Several tools may be in force on a straight way to joint values.
    #[error("a straight move to joint values whose tool is ambiguous")]
    SeveralTools,
    /// Tools that go straight to joint values and that are not given.
    #[error("a straight move to joint values with unknown {}", named(&[], tools))]
    ToolNotGiven {
        /// Names of the tools.
        tools: Vec<String>,
    },
    /// How the maker's programs count a joint and how the robot file does may differ, so that joint values do not tell where the arm
    /// stands.
    #[error("where its joints stand is not known: {0}")]
    UnknownArm(String),
    /// An arc or spline leads to joint values, and where the joints turn on it is not known.
    #[error("the end of an arc or spline on which the turning points of the joints are not known")]
    CurveToJoints,
    /// Its straight way or its arc is none of the TCP's alone; directions are lost there.
    #[error("{}", words(*.0))]
    OtherWay(OtherWay),
    /// The kinematics do not reach it.
    #[error("a Cartesian target that the robot's kinematics cannot reach")]
    NotReached,
    /// The kinematics reach it, but not along its way.
    #[error("a path that the robot's kinematics cannot follow")]
    NotFollowed,
    /// No joints that reach it have the configuration that it names.
    #[error("a Cartesian target that no joints with its configuration reach")]
    NotConfigured,
    /// Neither the joints before nor a configuration choose between its solutions.
    #[error("a Cartesian target without a known start, and without a configuration")]
    NoStart,
    /// Its configuration fits several solutions.
    #[error("a Cartesian target that several arm configurations reach")]
    SeveralArms,
    /// Two solutions are as near to the joints before.
    #[error("a Cartesian target that two arm configurations reach from the same distance")]
    AsNear,
    /// No solution stands next to the joints that the program names.
    #[error("a Cartesian target without a solution next to the joints that the program names")]
    NotNear,
    /// Its configuration is not that of the solution next to the joints before.
    #[error("a Cartesian target whose arm configuration differs from the one nearest to the joints before")]
    OtherArm,
    /// The same where it is not certain whether the controller looks at it.
    #[error(
        "a Cartesian target whose arm configuration differs from the one nearest to the joints before, and whether the controller follows it there depends on what ran before (ConfJ, ConfL)"
    )]
    PerhapsOtherArm,
    /// A letter alone tells the wrist with which it is reached, and what it means is not known.
    #[error(
        "its offset depends on which wrist the letters F and N (Yaskawa: flip) mean on this robot, which nothing tells (wrist_flip of the robot file)"
    )]
    WristUnknown,
    /// Beyond a joint limit.
    #[error("a Cartesian target outside of the joint limits")]
    Outside,
    /// An arc or spline ends there, and its way is not known.
    #[error("a Cartesian target at the end of an arc or spline")]
    EndOfCurve,
    /// Its numbers are not in the program.
    #[error("a Cartesian target whose numbers are not in the program")]
    NoNumbers,
    /// The offset would change the configuration.
    #[error("its offset would cross a boundary of the target's configuration")]
    Border,
    /// The joints that the program names beside it would choose another solution for the pose with its offset.
    #[error("the joints that the program names for a solution are nearest to another solution there")]
    NamedJoints,
    /// Half a last digit of the pose moves the joints too far.
    #[error("so near to a singularity, the digits of a pose do not determine its joints")]
    Singular,
    /// The offsets at the ends of a small arc would bend it.
    #[error("next to an arc that is so small that offsets at its ends would bend it")]
    BesideArc,
    /// The goal of the move cannot be read; directions are lost there.
    #[error("a target that cannot be determined")]
    Undetermined,
    /// The move names a target that the program does not hold; directions are lost there.
    #[error("a target that is not there")]
    NoTarget,
    /// Directions are lost on the way of an arc or spline.
    #[error("an arc or spline to a Cartesian target")]
    Curve,
}

/// A way that is not the one of its path, in words.
fn words(way: OtherWay) -> &'static str {
    match way {
        OtherWay::Carried => {
            "a straight way or an arc on which an axis that the robot file does not have may turn the part or the robot"
        }
        OtherWay::Wrist => "a straight way or an arc on which the wrist turns joint by joint",
        OtherWay::Orientation => "an arc whose orientation does not go straight from its start to its end",
    }
}

/// ``frame `a` and tool `b` ``.
fn named(frames: &[String], tools: &[String]) -> String {
    let of = |what: &'static str, names: &[String]| -> Vec<String> {
        names.iter().map(|name| format!("{what} `{name}`")).collect()
    };
    [of("frame", frames), of("tool", tools)].concat().join(" and ")
}

impl Cause {
    /// What keeps a move as it is, as far as the program says; `None`: it may be edited.
    pub fn of(m: &Move) -> Option<Self> {
        match (&m.goal, &m.fixed) {
            (Goal::Opaque(why), _) | (_, Some(why)) => Some(Self::Program(why.clone())),
            (Goal::Pose(_), None) => Some(Self::Cartesian),
            (Goal::Joints(_), None) => None,
        }
    }
}

crate::io::in_words!(Cause);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_and_tools_that_nobody_gives_are_named_in_words() {
        let cause = Cause::NotGiven { frames: vec!["wobj1".into()], tools: vec!["tGun".into()] };
        assert_eq!(cause.to_string(), "a Cartesian target with unknown frame `wobj1` and tool `tGun`");
    }
}
