//! The way of a program through the engine, in constant memory whatever its length.
//!
//! Four stations, each on a thread of its own where asked for: read and parse | engine | write rows | hash and store. They
//! hand over blocks through short queues, in order, so that the output does not depend on the threads; buffers travel back
//! to be filled again. An error travels the same way, behind everything that came before it.
//!
//! Modules:
//! - [`job`]: from file to file.
//! - [`render`]: the text of pending rows, and the engine's points put into it.
//! - [`sink`]: where the bytes go; [`golden`]: against a golden file, with the first difference in words.
//! - [`guard`]: a program that has been rewritten is not rewritten again; [`rewritten`]: how one without its note is known.

pub mod golden;
pub mod guard;
pub mod job;
pub mod render;
pub mod rewritten;
pub mod sink;

use super::{Engine, OutputPoints, Points, RewriteStats};
use crate::error::{Error, Result};
use crate::io::threads;
use crate::program::csv::{Reader, Style};
use crate::program::{Block, Slot, lines::Lines};
use crate::robot::Robot;
use render::Render;
use sink::Sink;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};

/// Threads beside the one of the engine.
const STATIONS: usize = 3;
/// Blocks that wait between two stations.
const QUEUE: usize = 2;

/// What turns points into points: the engine, or a stand-in for it.
pub trait Stage {
    /// Takes the next points and appends what is settled to `out`.
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()>;
    /// Appends what is left and returns the account.
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
    pub has_times: bool,
    /// The targets of the first block, `q[row * axes + axis]`, rad or m.
    pub q: &'a [f64],
}

/// What came of a program.
#[derive(Debug)]
pub struct Done<S> {
    pub account: RewriteStats,
    pub points: u64,
    pub lines: Lines,
    /// Of the bytes read, where wanted; of those written it is the sink's business.
    pub sha256_in: Option<String>,
    /// Fewest decimals with which numbers of each axis were written.
    pub written: Vec<Option<u8>>,
    pub sink: S,
}

/// How a program is to pass.
#[derive(Debug, Clone)]
pub struct Passage {
    pub style: Style,
    /// A thread for each station; else all in turn on this one.
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
    mut sink: S,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Done<S>> {
    let mut reader = if passage.hash { reader.with_hash() } else { reader };
    let mut first = Block::default();
    reader.next(&mut first)?;
    let stage = make(&preview(&reader, &first, robot.dof()))?;
    let mut render = Render::new(reader.slots(), robot, &passage.style);
    let account = if passage.threads && threads::are_there(STATIONS) {
        threaded(&mut reader, first, stage, &mut render, &mut sink, robot.dof(), progress)?
    } else {
        in_turn(&mut reader, first, stage, &mut render, &mut sink, robot.dof(), progress)?
    };
    Ok(Done {
        account,
        points: reader.points(),
        sha256_in: reader.sha256(),
        lines: reader.into_lines(),
        written: (0..robot.dof()).map(|a| render.edits().written(a)).collect(),
        sink,
    })
}

fn preview<'a>(reader: &Reader, first: &'a Block, axes: usize) -> Preview<'a> {
    let mut decimals = vec![0; axes];
    for (slot, &d) in reader.slots().iter().zip(&first.decimals) {
        if let Slot::Axis(a) = *slot {
            decimals[a] = d;
        }
    }
    Preview { decimals, has_times: reader.has_times(), q: &first.q }
}

/// One block through the engine; the block lends its numbers and gets them back.
fn push<E: Stage>(stage: &mut E, block: &mut Block, axes: usize, out: &mut OutputPoints) -> Result<()> {
    out.clear();
    let points = Points { axes, q: std::mem::take(&mut block.q), t_s: std::mem::take(&mut block.t_s) };
    let pushed = stage.push(&points, out);
    (block.q, block.t_s) = (points.q, points.t_s);
    pushed
}

fn in_turn<E: Stage, S: Sink>(
    reader: &mut Reader,
    first: Block,
    mut stage: E,
    render: &mut Render,
    sink: &mut S,
    axes: usize,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RewriteStats> {
    let mut free: Vec<Block> = Vec::new();
    let mut out = OutputPoints { axes, ..OutputPoints::default() };
    let mut next = Some(first);
    let writes = sink.wants_bytes();
    while let Some(mut block) = next.take() {
        push(&mut stage, &mut block, axes, &mut out)?;
        if writes {
            render.feed(Some(block), &out, &mut |b| free.push(b))?;
            store(render, sink, false)?;
        } else {
            free.push(block);
        }
        progress(reader.bytes());
        let mut block = free.pop().unwrap_or_default();
        if reader.next(&mut block)? {
            next = Some(block);
        }
    }
    out.clear();
    let account = stage.finish(&mut out)?;
    if writes {
        render.feed(None, &out, &mut |_| {})?;
        render.end()?;
        store(render, sink, true)?;
    }
    Ok(account)
}

fn store<S: Sink>(render: &mut Render, sink: &mut S, all: bool) -> Result<()> {
    if let Some(bytes) = render.ready(all) {
        sink.take(&bytes)?;
        render.recycle(bytes);
    }
    Ok(())
}

type Parsed = Result<Block>;
type Settled = (Option<Block>, OutputPoints);

fn threaded<E: Stage, S: Sink>(
    reader: &mut Reader,
    first: Block,
    mut stage: E,
    render: &mut Render,
    sink: &mut S,
    axes: usize,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RewriteStats> {
    let writes = sink.wants_bytes();
    let (parsed, blocks) = sync_channel::<Parsed>(QUEUE);
    let (settled, settled_blocks) = sync_channel::<Settled>(QUEUE);
    let (text, texts) = sync_channel::<Vec<u8>>(QUEUE);
    let (free_block, free_blocks) = channel::<Block>();
    let (free_out, free_outs) = channel::<OutputPoints>();
    let (free_text, free_texts) = channel::<Vec<u8>>();
    std::thread::scope(|scope| {
        let spawn = |e| Error::io_of("a thread of the rewrite", "start", e);
        let station = || std::thread::Builder::new();
        let reading = station()
            .spawn_scoped(scope, move || read(reader, first, &parsed, &free_blocks, progress))
            .map_err(spawn)?;
        let rendering = writes.then(|| {
            let free_block = free_block.clone();
            let started = station().spawn_scoped(scope, move || {
                write_rows(render, &settled_blocks, &text, &free_block, &free_out, &free_texts)
            });
            started.map_err(spawn)
        });
        let rendering = rendering.transpose()?;
        let storing = writes.then(|| {
            let storing = move || -> Result<()> {
                for bytes in texts {
                    sink.take(&bytes)?;
                    let _ = free_text.send(bytes);
                }
                Ok(())
            };
            station().spawn_scoped(scope, storing).map_err(spawn)
        });
        let storing = storing.transpose()?;
        let engine = || -> Result<RewriteStats> {
            for block in &blocks {
                let mut block = block?;
                let mut out = free_outs.try_recv().unwrap_or_default();
                push(&mut stage, &mut block, axes, &mut out)?;
                if !writes {
                    let _ = free_block.send(block);
                } else if settled.send((Some(block), out)).is_err() {
                    return Ok(RewriteStats::default()); // the station behind failed and says why
                }
            }
            let mut out = OutputPoints { axes, ..OutputPoints::default() };
            let account = stage.finish(&mut out)?;
            let _ = settled.send((None, out));
            Ok(account)
        };
        let account = engine();
        // closing the queues ends the other stations
        drop(settled);
        drop(blocks);
        let gone = || Error::Refused("a thread of the rewrite stopped unexpectedly".into());
        let read = reading.join().map_err(|_| gone());
        let rendered = rendering.map_or(Ok(Ok(())), |t| t.join().map_err(|_| gone()));
        let stored = storing.map_or(Ok(Ok(())), |t| t.join().map_err(|_| gone()));
        let account = account?;
        read?;
        // a sink that fails closes the queue of the rows: its reason comes first
        stored??;
        rendered??;
        Ok(account)
    })
}

fn read(
    reader: &mut Reader,
    first: Block,
    parsed: &SyncSender<Parsed>,
    free: &Receiver<Block>,
    progress: &(dyn Fn(u64) + Sync),
) {
    if parsed.send(Ok(first)).is_err() {
        return;
    }
    loop {
        let mut block = free.try_recv().unwrap_or_default();
        let next = match reader.next(&mut block) {
            Ok(true) => Ok(block),
            Ok(false) => return,
            Err(e) => Err(e.into()),
        };
        progress(reader.bytes());
        let failed = next.is_err();
        if parsed.send(next).is_err() || failed {
            return;
        }
    }
}

fn write_rows(
    render: &mut Render,
    settled: &Receiver<Settled>,
    text: &SyncSender<Vec<u8>>,
    free_block: &std::sync::mpsc::Sender<Block>,
    free_out: &std::sync::mpsc::Sender<OutputPoints>,
    free_text: &Receiver<Vec<u8>>,
) -> Result<()> {
    let mut whole = false;
    for (block, out) in settled {
        whole = block.is_none();
        render.feed(block, &out, &mut |b| {
            let _ = free_block.send(b);
        })?;
        let _ = free_out.send(out);
        if whole {
            render.end()?;
        }
        if let Some(bytes) = render.ready(whole) {
            if text.send(bytes).is_err() {
                return Ok(()); // the sink says why
            }
            if let Ok(bytes) = free_text.try_recv() {
                render.recycle(bytes);
            }
        }
    }
    debug_assert!(whole || settled.recv().is_err());
    Ok(())
}
