//! Why a point of a trajectory stays as it is.

/// Why a point stays as it is, or none may come before it. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    /// It has velocities or times alone.
    #[error("the point gives no positions")]
    NoPositions,
    /// The first of the file.
    #[error("first point: where the robot comes from is not in the file")]
    First,
    /// A key that is not known.
    #[error("the point has a key `{0}` that a copy would repeat")]
    ForeignKey(Box<str>),
    /// An end of its way has no positions.
    #[error("a point without positions")]
    EndWithoutPositions,
    /// The way between the points is of no degree that is known.
    #[error("velocities or accelerations at one end of the way only")]
    AtOneEnd,
    /// The same.
    #[error("accelerations without velocities")]
    AccelerationsAlone,
}
