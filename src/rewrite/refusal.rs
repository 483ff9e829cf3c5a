//! Why a program that can be read is not rewritten.

use crate::error::Error;

/// The answer is no; nothing was written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error("a robot of {axes} axes; a rewrite handles up to {most}")]
    TooManyAxes { axes: usize, most: usize },
    #[error("a robot with a gap that belongs to a sum of axes (gap_of) takes neither a finer path nor another law")]
    SumOfAxes,
    #[error("the friction offset of {joint} fades in seconds, but the program has no times and no TCP speed is known")]
    NoClock { joint: String },
    /// At 1e15 s a double knows eighths of a second.
    #[error(
        "point {point}: there is no time between two points for a new one; nothing was written (count times from the start of the \
         program)"
    )]
    NoTime { point: u64 },
    #[error(
        "{name}: {editable} of {moves} moves can be edited, {:.1} %; {:.1} % are required; nothing was written{reasons}",
        100.0 * *editable as f64 / (*moves).max(1) as f64, 100.0 * required
    )]
    Coverage { name: String, editable: u64, moves: u64, required: f64, reasons: String },
    #[error("{}", lines(.0))]
    CoarseDigits(Vec<CoarseDigit>),
    #[error(
        "{name}: a position at a limit cannot be written in the format's digits without passing it; nothing was written"
    )]
    AtLimit { name: String },
    #[error("{name}: {with} belongs to another program of the folder, too; nothing was written")]
    Shared { name: String, with: String },
    #[error("{missing} of {programs} programs are in no summary ({first}); nothing was written")]
    Missing { missing: usize, programs: usize, first: String },
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
