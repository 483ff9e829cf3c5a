//! Steps of a program: motions, and what stands between them.

use super::pose::{Frame, PoseGoal};
use super::reason::Reason;
use super::thin::Few;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A place: text and line, counted from 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct At {
    /// Number of the file, from 0: the order of the texts.
    pub file: usize,
    /// Line, from 1.
    pub line: u64,
}

impl At {
    /// Line `k` of the program's own text, from 0.
    pub fn of_line(k: usize) -> Self {
        Self { file: 0, line: k as u64 + 1 }
    }
}

/// A sentence about a place of the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Line of the program.
    pub place: At,
    /// What to know, in words.
    pub text: String,
}

/// One step.
#[derive(Debug, Clone)]
pub struct Step {
    /// Line at which it stands.
    pub at: At,
    /// What it is.
    pub kind: StepKind,
}

impl Step {
    /// A step that follows `before`: moves that go alike share what they have in common.
    pub fn following(before: Option<&Self>, at: At, mut kind: StepKind) -> Self {
        if let (StepKind::Move(m), Some(Self { kind: StepKind::Move(last), .. })) = (&mut kind, before)
            && !Arc::ptr_eq(&m.how, &last.how)
            && m.how == last.how
        {
            m.how = Arc::clone(&last.how);
        }
        Self { at, kind }
    }
}

/// What a step of a program is.
#[derive(Debug, Clone)]
pub enum StepKind {
    /// A motion.
    Move(Move),
    /// The robot stands; directions stay known. Seconds where they are written.
    Dwell(Option<f64>),
    /// Where the robot comes from is not known after this: directions are unknown, and so is the position unless the move
    /// before it certainly led here.
    Break(Break),
    /// The program sets this name, in lower case, of which frames or tools are made ([`Frame::is_made_of`]): from here on these are others.
    Sets(Box<str>),
    /// A process (welding, dispensing) goes on or off.
    Process(bool),
    /// A comment `lostmotion: off` (`false`: nothing is changed from here) or `lostmotion: on`.
    Pragma(bool),
}

/// Why directions are unknown from here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Break {
    /// Start of a routine.
    Start,
    /// A label, a jump, a branch.
    Jump,
    /// Start or end of a loop.
    Loop,
    /// A call of something that may move the robot.
    Call,
    /// An interrupt or trigger that may move the robot is armed.
    Interrupt,
    /// Tool, frame, unit or position was set in a way that moves the meaning of targets.
    Frame,
    /// The same for these axes alone: where they stand is not known, nor from where their next numbers count.
    Axes(AxisSet),
}

impl Break {
    /// It moves the meaning of targets; control goes on in the order of the text.
    pub fn is_frame(self) -> bool {
        matches!(self, Self::Frame | Self::Axes(_))
    }
}

/// Some of the axes of a robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AxisSet(u64);

impl AxisSet {
    /// Whether an axis is among them.
    pub fn has(self, axis: usize) -> bool {
        axis < 64 && self.0 & (1 << axis) != 0
    }

    /// There are none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those that are in both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Those that are in one or the other.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Those that are not in the other.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The axes in ascending order.
    pub fn axes(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let next = (left != 0).then(|| left.trailing_zeros() as usize);
            left &= left.wrapping_sub(1);
            next
        })
    }
}

impl FromIterator<usize> for AxisSet {
    /// Of axes from 0; a robot with more than 64 is none.
    fn from_iter<I: IntoIterator<Item = usize>>(axes: I) -> Self {
        Self(axes.into_iter().filter(|a| *a < 64).fold(0, |all, a| all | 1 << a))
    }
}

/// A motion instruction. How it goes there is its [`How`], as which it can be read and changed.
#[derive(Debug, Clone)]
pub struct Move {
    /// Where it leads.
    pub goal: Goal,
    /// Turning points on the way that the format knows itself (quadrants of an arc), in order, without the goal.
    pub way: Few<Way>,
    /// Moves that follow each other mostly share it.
    how: Arc<How>,
}

impl Move {
    /// A motion to `goal`.
    pub fn new(how: How, goal: Goal, way: impl Into<Few<Way>>) -> Self {
        Self { goal, way: way.into(), how: Arc::new(how) }
    }

    /// A motion that goes as this one does, straight to another goal.
    pub fn alike(&self, goal: Goal) -> Self {
        Self { goal, way: Few::new(), how: Arc::clone(&self.how) }
    }

    /// Whether both share how they go, as moves that follow each other do where it is the same.
    pub fn shares_how(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.how, &other.how)
    }
}

impl Deref for Move {
    type Target = How;

    fn deref(&self) -> &How {
        &self.how
    }
}

impl DerefMut for Move {
    fn deref_mut(&mut self) -> &mut How {
        Arc::make_mut(&mut self.how)
    }
}

/// How a motion goes to its goal.
#[derive(Debug, Clone, PartialEq)]
pub struct How {
    /// How the TCP or the joints get there.
    pub path: PathKind,
    /// Why the goal's numbers may not be changed, although they are known: a relative motion counts from there. `None`: they may.
    pub fixed: Option<Reason>,
    /// Whether new points may be put on the way to the goal (most arcs given by three points allow none). Why not.
    pub closed: Option<Reason>,
    /// How fast, as far as the program determines it.
    pub speed: Speed,
    /// Radius within which the corner at the goal is cut, m; 0: exact stop; `None`: not known.
    pub blend_m: Option<f64>,
    /// Of a straight motion to joint values: the tool whose TCP goes straight; `None`: the language names none. A Cartesian goal has its
    /// own. Boxed, as it is large beside the others.
    pub tool: Option<Box<Frame>>,
    /// Of a curve to joint values: its turning points on the way are all that there are. Else where its joints turn is not known.
    pub turns_known: bool,
    /// Its goal counts from where the motion before ends: an offset there would be carried along.
    pub relative: bool,
    /// Its goal cannot be determined, but is a whole pose, or joint values of all axes, wherever the robot stands: nothing of where the
    /// motion before ends goes into it.
    pub absolute: bool,
    /// Its goal is one of at least three joint targets through which the TCP goes on arcs: the targets, in the order in which they are
    /// passed. To the first the path is straight; between two others it is the arc through three of them that follow each other and hold
    /// both, which of these, if there are two, the language leaves open.
    pub circle: Option<Arc<[usize]>>,
    /// Axes whose numbers count from an origin that is not in the program (a work frame, a tool length): where the axis stands is not
    /// known, only how far it moves.
    pub unplaced: AxisSet,
    /// Of them those whose origin is not that of the first motion either.
    pub displaced: AxisSet,
    /// Of a goal that cannot be determined: the axes that move; `None`: any.
    pub moves_alone: Option<AxisSet>,
    /// Why the way to the goal may be another one than that of its path; its goal is known all the same.
    pub other_way: Option<OtherWay>,
    /// The axes that it moves to a goal at which the program waits for some time: the robot stops there exactly, and at a new point before
    /// it if the program waits there as well. [`Self::blend_m`] says nothing of it. Empty: the program does not wait.
    pub waits: AxisSet,
    /// What the motion starts before it ends. Boxed, as few have one.
    pub end_trigger: Option<Box<EndTrigger>>,
    /// What comes after it is done as the robot enters its corner, for this reason: were the corner made smaller for a new point, it would
    /// come late. Boxed, as few have one.
    pub acts_in_corner: Option<Box<Reason>>,
}

impl How {
    /// New points may be put anywhere on the way, up to the goal.
    pub fn is_open_to_goal(&self) -> bool {
        self.closed.is_none() && self.end_trigger.is_none()
    }
}

/// Something that a motion starts at a distance or a time before its goal, by the last of its pieces: a new point nearer to the goal would
/// delay it.
#[derive(Debug, Clone, PartialEq)]
pub struct EndTrigger {
    /// Way of the TCP to the goal that no new point may shorten, m.
    pub way_m: f64,
    /// Time to the goal that no new point may shorten, s: the joints must not be able to come from there sooner.
    pub time_s: f64,
    /// Why no point may be there.
    pub why: Reason,
}

/// Why the joints may go to a goal on another way than its path and its orientation alone would lead them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherWay {
    /// An axis that the robot does not have may move along and turn the part or the robot: the way is one as seen from there.
    Carried,
    /// The wrist turns joint by joint: FANUC `Wjnt`, KRL `$ORI_TYPE #JOINT`, RAPID `SingArea \\Wrist`.
    Wrist,
    /// The orientation on an arc does not go straight from its start to its end: RAPID `CirPathMode`.
    Orientation,
}

impl Default for How {
    /// Straight in the joints, and nothing is known.
    fn default() -> Self {
        Self {
            path: PathKind::Joint,
            fixed: None,
            closed: None,
            speed: Speed::Unknown,
            blend_m: None,
            tool: None,
            turns_known: false,
            relative: false,
            absolute: false,
            circle: None,
            unplaced: AxisSet::default(),
            displaced: AxisSet::default(),
            moves_alone: None,
            other_way: None,
            waits: AxisSet::default(),
            end_trigger: None,
            acts_in_corner: None,
        }
    }
}

/// A point on the way to a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Share of the way, above 0 and below 1.
    pub share: f64,
    /// rad or m, one per axis.
    pub q: Vec<f64>,
}

/// How the robot moves between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// Straight in the joints.
    Joint,
    /// The TCP on a straight line.
    Linear,
    /// The TCP on an arc, a spline, or something else.
    Curve,
}

/// Where a move leads.
#[derive(Debug, Clone)]
pub enum Goal {
    /// Index into [`super::Script::targets`].
    Joints(usize),
    /// A Cartesian pose; boxed, as it is large beside the others.
    Pose(Box<PoseGoal>),
    /// Neither can be determined from the text: why.
    Opaque(Reason),
}

impl Goal {
    /// A Cartesian pose.
    pub fn pose(goal: PoseGoal) -> Self {
        Self::Pose(Box::new(goal))
    }

    /// One that cannot be determined.
    pub fn opaque(why: impl Into<Reason>) -> Self {
        Self::Opaque(why.into())
    }

    /// The target whose numbers lead there.
    pub fn target(&self) -> Option<usize> {
        match self {
            Self::Joints(t) => Some(*t),
            Self::Pose(goal) => goal.target,
            Self::Opaque(_) => None,
        }
    }
}

/// Speed of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// Of the TCP, m/s.
    Tcp(f64),
    /// Share of the joints' largest speeds, 0 to 1.
    Share(f64),
    /// Of the leading joint, rad/s or m/s.
    Joint(f64),
    /// Duration of the whole move, s; 0 of a first point at which the robot stands already.
    Seconds(f64),
    /// Not determined by the program.
    Unknown,
}
