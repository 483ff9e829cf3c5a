//! The way of a program through the engine, in constant memory whatever its length.
//!
//! Workers, all alike, take a piece of the program each through every station: read | hash | parse | engine | print | read again |
//! hash | store. The stations that depend on what came before (all but parse, print and read again) are passed in the order of the
//! program, so that neither the output nor the error that is reported depends on the number of threads.
//!
//! Modules, in the order in which to read them:
//! - [`job`]: from file to file.
//! - [`workers`]: the stations; [`turn`]: one after the other.
//! - [`render`]: the text of pending rows, and the engine's points put into it.
//! - [`golden`]: against a golden file, with the first difference in words.

#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod golden;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod job;
pub(crate) mod render;
pub(crate) mod turn;
pub(crate) mod workers;

use super::sink::Sink;
use super::{Engine, OutputPoints, Points, RewriteStats};
use crate::error::Result;
use crate::program::csv::{Piece, Reader, Style};
use crate::program::{Block, Slot, lines::Lines};
use crate::robot::Robot;
use render::Pending;
use workers::{Middle, SharedState};

/// What turns points into points: the engine, or a stand-in for it.
pub trait Stage: Send {
    /// Takes the next points and appends what is settled to `out`.
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()>;
    /// Appends what is left and returns the statistics.
    fn finish(self, out: &mut OutputPoints) -> Result<RewriteStats>;
}

impl Stage for Engine<'_> {
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()> {
        Engine::push(self, block, out)
    }

    fn finish(self, out: &mut OutputPoints) -> Result<RewriteStats> {
        Engine::finish(self, out)
    }
}

/// What the first block shows of a program before the engine is made.
#[derive(Debug, Clone)]
pub struct Preview<'a> {
    /// Most decimals of each axis in the first block, deg or mm.
    pub decimals: Vec<u8>,
    /// Whether the rows carry times.
    pub has_times: bool,
    /// The targets of the first block, `q[row * axes + axis]`, rad or m.
    pub q: &'a [f64],
}

/// What came of a program.
#[derive(Debug)]
pub struct Done<S> {
    /// Points, new points, limits and durations.
    pub stats: RewriteStats,
    /// Number of points that were read.
    pub points: u64,
    /// Lines of the points that violate a limit.
    pub lines: Lines,
    /// Of the bytes read, where wanted; of those written it is the sink's business.
    pub sha256_in: Option<String>,
    /// Fewest decimals with which numbers of each axis were written.
    pub written: Vec<Option<u8>>,
    /// Where the output goes.
    pub sink: S,
}

/// How a program is to pass.
#[derive(Debug, Clone)]
pub struct Passage {
    /// How numbers are written.
    pub style: Style,
    /// A worker for each processor; else this thread alone.
    pub threads: bool,
    /// The SHA-256 of the input is wanted.
    pub hash: bool,
}

/// Takes a program from `reader` through the stage that `make` makes of its first block, into `sink`.
pub fn pass<E: Stage, S: Sink>(
    robot: &Robot,
    reader: Reader,
    passage: &Passage,
    make: impl FnOnce(&Preview) -> Result<E>,
    sink: S,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Done<S>> {
    let (mut source, mut parser, mut placing) = reader.split();
    let mut first = Piece::default();
    if source.next(&mut first)? {
        first.parse(&mut parser);
        placing.place(&mut first)?;
    } else {
        placing.end()?;
    }
    let axes = robot.dof();
    let stage = make(&preview(placing.slots(), &first.block, axes))?;
    let pending = sink.wants_bytes().then(|| Pending::new(placing.slots(), robot, &passage.style));
    let task = pending.as_ref().map(Pending::task);
    let middle = Middle::new(placing, stage, axes, pending);
    let shared = SharedState::new(source, passage.hash, middle, sink, progress);
    let done = shared.run(first, parser, task, passage.threads)?;
    Ok(Done {
        stats: done.middle.stats,
        points: done.middle.placing.points(),
        sha256_in: done.sha256_in,
        lines: done.middle.placing.into_lines(),
        written: done.written,
        sink: done.sink,
    })
}

fn preview<'a>(slots: &[Slot], first: &'a Block, axes: usize) -> Preview<'a> {
    let mut decimals = vec![0; axes];
    for (slot, &d) in slots.iter().zip(&first.decimals) {
        if let Slot::Axis(a) = *slot {
            decimals[a] = d;
        }
    }
    Preview { decimals, has_times: slots.iter().any(|s| matches!(s, Slot::Time(_))), q: &first.q }
}
