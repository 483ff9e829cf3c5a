//! Why a program that can be read is not rewritten.

use crate::error::{Error, counted};

/// The answer is no; nothing was written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The robot has more axes than a rewrite handles.
    #[error("a robot of {axes} axes; a rewrite handles up to {most}")]
    TooManyAxes {
        /// Number of axes of the robot.
        axes: usize,
        /// Number of axes that can be handled.
        most: usize,
    },
    #[error("a robot with a gap that belongs to a sum of axes (gap_of) supports neither a finer path nor another law")]
    /// An axis of the program turns by the sum of two joints, and the offset of one would move the other.
    SumOfAxes,
    /// A friction offset fades in time, and the program has none.
    #[error("the friction offset of {joint} fades in seconds, but the program has no times and no TCP speed is known")]
    NoClock {
        /// Name of the joint.
        joint: String,
    },
    /// At 1e15 s a double knows eighths of a second.
    #[error(
        "{place}: there is no time between two points for a new one; nothing was written (count times from the start of the \
         program)"
    )]
    NoTime {
        /// The program, where it is known, and the number of the point, from 1.
        place: String,
    },
    /// Less of the program can be edited than the user requires.
    #[error(
        "{name}: {editable} of {} can be edited, {:.1} %; {:.1} % are required; nothing was written{reasons}",
        counted(*moves as usize, "move"), 100.0 * *editable as f64 / (*moves).max(1) as f64, 100.0 * required
    )]
    Coverage {
        /// Name of the program.
        name: String,
        /// Number of moves that can be edited.
        editable: u64,
        /// Number of all moves.
        moves: u64,
        /// Share that is required, 0 to 1.
        required: f64,
        /// Why the others stay, a line for each reason.
        reasons: String,
    },
    #[error("{}", lines(.0))]
    /// The last digits of these axes are too coarse for the offset.
    CoarseDigits(Vec<CoarseDigit>),
    /// A number at a joint limit would pass it once it is rounded.
    #[error(
        "{name}: a position at a limit cannot be written with the digits of the format without exceeding the limit; nothing was written"
    )]
    AtLimit {
        /// Name of the program.
        name: String,
    },
    /// A file is declared by two programs of a folder.
    #[error("{name}: {with} also belongs to another program of the folder; nothing was written")]
    Shared {
        /// Name of the program.
        name: String,
        /// The file that two programs use.
        with: String,
    },
    /// A file stands where one of the result goes, and replacing it might lose something.
    #[error("{file}: {why}{REMEDY}")]
    Foreign {
        /// The file.
        file: String,
        /// How it is known.
        why: Foreign,
    },
    /// A merge lacks results of programs.
    #[error("{missing} of {} in no summary ({first}); nothing was written", counted(*programs, "program"))]
    Missing {
        /// Number of programs that no summary holds.
        missing: usize,
        /// Number of programs.
        programs: usize,
        /// The first of those that are missing.
        first: String,
    },
}

/// How the refusal of a file that stands in the way ends.
pub const REMEDY: &str = "; nothing was written (remove the file, or allow its replacement)";

/// What a file is that stands where one of a result goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Foreign {
    /// Its note has the hash of another content.
    #[error("changed since `rewrite` wrote it")]
    Changed,
    /// It has no note.
    #[error("no note shows that it is a result of `rewrite`")]
    NoNote,
    /// It has a note that cannot be read.
    #[error("its note is damaged, so that it is not known as a result of `rewrite`")]
    DamagedNote,
    /// It would belong to the program by its name.
    #[error("no note shows that it belongs to this program")]
    NoCompanion,
}

/// A joint whose gap is below what the format can hold; user's units.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseDigit {
    /// File and line.
    pub place: String,
    pub joint: String,
    pub unit: &'static str,
    pub step: f64,
    pub half_gap: f64,
}

fn lines(coarse: &[CoarseDigit]) -> String {
    let line = |c: &CoarseDigit| {
        format!(
            "{}: the format holds {} in steps of {:.6} {unit}, its half gap is {:.6} {unit}; nothing was written",
            c.place,
            c.joint,
            c.step,
            c.half_gap,
            unit = c.unit
        )
    };
    coarse.iter().map(line).collect::<Vec<_>>().join("\n")
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(Box::new(refusal))
    }
}
