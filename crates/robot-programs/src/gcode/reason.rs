//! Why a block of a G-code program stays as it is. G words are numbers times ten: 431 is G43.1.

use super::arc::NoArc;
use super::codes::code_text;
use crate::script::reason as shared;

/// Why a block stays as it is. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// Something may be on that makes words mean something else.
    #[error(transparent)]
    Doubt(#[from] Doubt),
    /// Its words are no arc.
    #[error(transparent)]
    NoArc(#[from] NoArc),
    /// It leads to a place that the program does not contain.
    #[error(transparent)]
    Elsewhere(#[from] Elsewhere),
    /// Relative words count from its end.
    #[error("a change would stay in all that follows {0}")]
    Stays(After),
    /// An arc that stays may start at its end.
    #[error("an arc that stays may start here, and its centre or radius would not fit")]
    StartOfArc,
    /// The way of a rotary axis from its end is about half a turn.
    #[error(
        "a rotary axis turns by about 180 deg from here: with an offset a control with rollover may turn the other way"
    )]
    StartOfHalfTurn,
    /// `G5 X10`.
    #[error("spline {}", code_text(*.0))]
    Spline(u32),
    /// `G38.2 Z-10`.
    #[error("{} leads to where a probe touches", code_text(*.0))]
    Probe(u32),
    /// `G81 Z-10`.
    #[error("canned cycle {}", code_text(*.0))]
    Canned(u32),
    /// No motion is in force.
    #[error("no G0, G1, G2 or G3 is certain here")]
    NoMotion,
    /// Words may be absolute or relative.
    #[error("neither G90 nor G91 is certain here")]
    NoDistance,
    /// Words may be in inches or millimetres.
    #[error("neither G20 nor G21 is certain here")]
    NoUnit,
    /// After a call or something else that may select a frame.
    #[error("its work frame is not certain: name it again (G54)")]
    NoFrame,
    /// `G1 X10 R2`, as lathes write it: the letter.
    #[error("a word {0} on a straight move: a chamfer or corner")]
    CornerWord(char),
    /// A letter that stands twice.
    #[error("{0} stands twice in the block")]
    Twice(char),
    /// A letter of an axis.
    #[error("a word {0}, and the robot file has no such axis")]
    NoAxis(char),
    /// `X#1`.
    #[error("an expression or a variable")]
    Expression,
    /// `X10` where others are `X10.`.
    #[error("a number without a point where others end in one: it may count increments")]
    NoPoint,
    /// `X500` in a program in which no number of an axis word has a point.
    #[error("a whole number, and no axis word of the program has a point: it may count increments")]
    WholeNumbers,
    /// A relative word of an axis that is lost.
    #[error("a relative word, and the position before it is not known")]
    RelativeToUnknown,
    /// `G91 X10 G90 Y5`.
    #[error("G90 and G91 in one block: which of its words are relative depends on the control")]
    BothDistances,
    /// `/G1 X10`.
    #[error("a block that an operator may switch off")]
    Optional,
    /// `N1 G1 X10*57`.
    #[error("a checksum")]
    Checksum,
    /// `,R2`.
    #[error("a chamfer or corner")]
    Corner,
    /// `@10 ^45`.
    #[error("polar coordinates")]
    Polar,
    /// `G43.1 Z10`.
    #[error("G43.1: its words may be those of the tool")]
    WordsOfTool,
    /// `G4 X10 Y10`.
    #[error("G4 beside positions")]
    DwellBesidePositions,
    /// `T0101` on lathes.
    #[error("a change of tool or offset in the block")]
    ToolOrOffset,
    /// `M6`.
    #[error("a tool change in the block")]
    ToolChange,
    /// An M word of a printer's firmware, with its letters.
    #[error("words that may be those of {0}")]
    WordsOf(Box<str>),
    /// The first number that ends in a point must stay: it says how those without one are to be read.
    #[error("numbers with and without a point stand in the program")]
    Mixed,
    /// No point may come before it in its line.
    #[error("a label or a word to this tool stands before it in its line")]
    SharedLine,
    /// `G81 X10 Y10`.
    #[error("a block of a canned cycle: a point before it would be a hole")]
    WouldDrill,
    /// `A10` after `A350`.
    #[error("a rotary axis turns by 179 deg or more, and a control with rollover takes the shorter way")]
    RollsOver,
    /// G93.
    #[error("inverse time feed G93: its time is that of the whole move")]
    InverseTime,
    /// `F#1`.
    #[error("a computed feed in the block")]
    FeedComputed,
    /// A G word that acts once.
    #[error("another G word in the block")]
    OtherGWord,
    /// Another letter that acts once.
    #[error("a word {0} in the block acts once")]
    ActsOnce(char),
    /// Asked of the writer for a step without numbers.
    #[error("its target is not known")]
    NoTarget,
    /// Asked of the writer for a step that is no move.
    #[error("no move stands there")]
    NoMove,
    /// Asked of the writer for a move to joint values.
    #[error("it is a joint move already")]
    JointMove,
    /// The same for new points: why none may come before it.
    #[error("no point can be added: {0}")]
    Closed(Box<shared::Reason>),
    /// The last relative block before a place that ends what is known.
    #[error("what changes here would stay in all relative words after it")]
    RelativeLeft,
    /// The new goal.
    #[error("a place beyond 10 km")]
    TooFar,
    /// The new point.
    #[error("a new point beyond 10 km")]
    PointTooFar,
    /// How far a new point lies beside its arc, mm.
    #[error("a new point lies {0:.4} mm beside the arc on which it should be")]
    BesideArc(f64),
    /// A piece of an arc would be a full circle.
    #[error("both ends of an arc would stand on one place, as those of a full circle do")]
    ArcCloses,
    /// A whole circle in one block.
    #[error("the offset changes over a whole circle, and no point may stand between")]
    WholeCircle,
    /// Its digits are too coarse.
    #[error("no arc in the format's digits holds what is wanted here")]
    DigitsTooCoarse,
}

impl Reason {
    /// Why a move ends where it always did.
    pub(super) fn kept(why: After) -> Self {
        match why {
            After::Arc => Self::StartOfArc,
            After::HalfTurn => Self::StartOfHalfTurn,
            _ => Self::Stays(why),
        }
    }
}

/// A place that the program does not contain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Elsewhere {
    /// G53.
    #[error("G53: a place of the machine")]
    Machine,
    /// G28, G30, G161, G162.
    #[error("{} goes to a reference point", code_text(*.0))]
    Reference(u32),
    /// `X10` where others are `X10.`.
    #[error("a number without a point where others end in one: it may count increments")]
    NoPoint,
    /// `G91 X10 G90 Y5`.
    #[error("G90 and G91 in one block: which of its words are relative depends on the control")]
    BothDistances,
    /// `X#1`.
    #[error("an expression or a variable")]
    Expression,
    /// `G81 Z-10 R2`: its words of the hole itself.
    #[error("canned cycle {}: words of the hole itself stay", code_text(*.0))]
    Hole(u32),
    /// X of a lathe.
    #[error("X of a lathe may be a diameter or a radius: state it, `--assume diameter` or `control: [diameter]`")]
    Across,
}

/// What may be on that makes words mean something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Doubt {
    /// Somewhere in the program.
    #[error("a line of the program does what is not followed")]
    Unfollowed,
    /// A line, from 1.
    #[error("line {0} assigns, and does what is not followed")]
    LineUnfollowed(u64),
    /// A line, from 1.
    #[error("line {0} assigns what may move or turn a frame")]
    FrameAssigned(u64),
    /// By a G word that nothing here follows.
    #[error("{} is on", code_text(*.0))]
    On(u32),
    /// The same on another way to this place.
    #[error("{} may be on", code_text(*.0))]
    MayBeOn(u32),
    /// G90.1 or G91.1 on another way to this place.
    #[error("{} may be on, by which the centres of arcs count otherwise", code_text(*.0))]
    CentresMayDiffer(u32),
    /// G93 to G95 on another way to this place.
    #[error("{} may be on, by which the feed count otherwise", code_text(*.0))]
    FeedMayDiffer(u32),
    /// After an optional block.
    #[error("the feed's mode is not known")]
    FeedMode,
    /// `G#1`.
    #[error("a computed G word")]
    ComputedGWord,
    /// The M word.
    #[error("M{0} may mirror an axis")]
    MayMirror(u32),
    /// On another way to this place.
    #[error("M21 or M22 may be on, which mirror an axis on older controls")]
    MirrorMayBeOn,
    /// G90, G94.
    #[error("{} may be a turning cycle of a lathe", code_text(*.0))]
    TurningCycle(u32),
    /// `G10 L2 R30`.
    #[error("a G10 that may turn the axes is on")]
    MayTurn,
    /// G66.
    #[error("G66 is on: a block may run a macro")]
    MacroOn,
    /// G66 on another way to this place.
    #[error("G66 may be on: a block may run a macro")]
    MacroMayBeOn,
    /// G41, G42.
    #[error("cutter compensation {} is on", code_text(*.0))]
    Compensation(u32),
    /// On another way to this place.
    #[error("G41 or G42 may be on")]
    CompensationMayBeOn,
    /// No mode is certain, G40 neither: after what.
    #[error("modes after {0} are not known (G40)")]
    Modes(After),
}

impl Doubt {
    /// An axis may be mirrored.
    pub fn mirrors(self) -> bool {
        matches!(self, Self::MayMirror(_) | Self::MirrorMayBeOn)
    }
}

/// What ends the certainty of a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum After {
    /// Of a program.
    #[error("a call")]
    Call,
    /// It may count from where the machine stands.
    #[error("a call of a program that is not in the text")]
    CallAway,
    /// G12, G31, G68.
    #[error("a block that may count from where the machine stands")]
    CountsFromHere,
    /// Control comes from elsewhere.
    #[error("a label, jump or loop")]
    Jump,
    /// They count from the end of this move.
    #[error("where relative words count from here later on")]
    RelativeWords,
    /// Its goal is not known.
    #[error("a block that cannot be determined")]
    Unclear,
    /// From another start it might be one.
    #[error("an arc that is none")]
    NoArc,
    /// Its centre counts from its start, and its radius stands.
    #[error("an arc that stays")]
    Arc,
    /// With an offset it might be one to the other side.
    #[error("a turn by about half a turn, where a control with rollover takes the shorter way")]
    HalfTurn,
    /// A place that the program does not contain.
    #[error(transparent)]
    Elsewhere(#[from] Elsewhere),
    /// A local frame.
    #[error("a G52")]
    G52,
    /// The position is set.
    #[error("a G92")]
    G92,
    /// Offsets are set.
    #[error("a G10")]
    G10,
    /// G43.
    #[error("a tool length")]
    ToolLength,
    /// G54.
    #[error("a work frame")]
    WorkFrame,
    /// G20, G21.
    #[error("a change of units")]
    Units,
    /// G7, DIAMON.
    #[error("a change between diameters and radii")]
    Across,
    /// T on lathes.
    #[error("a change of tool or offset")]
    Tool,
    /// G51.
    #[error("a scaling or a mirror")]
    Scaling,
    /// M21, M22.
    #[error("an M word that may mirror an axis")]
    MayMirror,
    /// Of another maker.
    #[error("an M word that may move the machine")]
    MayMove,
    /// G29 of printers.
    #[error("a probing of the bed")]
    BedProbing,
    /// M2, M30, or the last line.
    #[error("the end of the program")]
    End,
    /// `%`.
    #[error("the tape's end")]
    TapeEnd,
    /// It takes on where the machine stands.
    #[error("a line that may read where the machine stands")]
    ReadsPlace,
    /// `A10` after `A350`.
    #[error("a turn by 179 deg or more, where a control with rollover takes the shorter way")]
    RollOver,
    /// G28.1, G30.1, M428.
    #[error("a word that stores where the machine stands")]
    StoresPlace,
    /// What it does is not known.
    #[error("a line that is not followed")]
    Unfollowed,
    /// Of a variable of the control.
    #[error("an assignment that may move a frame")]
    FrameAssigned,
    /// To the machine.
    #[error("a signal that may move the machine")]
    Signal,
    /// Whether it runs is not known.
    #[error("a block that may be switched off")]
    Optional,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_put_together_of_their_parts() {
        let of = |doubt| Reason::Doubt(doubt).to_string();
        assert_eq!(of(Doubt::Modes(After::Call)), "modes after a call are not known (G40)");
        assert_eq!(of(Doubt::CentresMayDiffer(901)), "G90.1 may be on, by which the centres of arcs count otherwise");
        let stays = Reason::Stays(Elsewhere::Reference(280).into()).to_string();
        assert_eq!(stays, "a change would stay in all that follows G28 goes to a reference point");
        let closed = Reason::Closed(Box::new(Reason::ActsOnce('M').into())).to_string();
        assert_eq!(closed, "no point can be added: a word M in the block acts once");
        assert_eq!(
            Reason::BesideArc(0.12).to_string(),
            "a new point lies 0.1200 mm beside the arc on which it should be"
        );
    }
}
