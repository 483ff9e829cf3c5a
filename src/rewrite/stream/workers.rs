//! Workers, all alike, that take pieces of a program through: read | hash | parse | engine | print | read again | hash | write.
//!
//! Parsing, printing and reading again are done side by side, everything else in the order of the program, each at its own [`Turn`], so
//! that one worker reads while another hashes and a third one writes. The calling thread is one of the workers: where no other thread
//! can be had, it does everything.

use super::render::{Pending, Task};
use super::turn::Turn;
use super::{RewriteStats, Stage};
use crate::error::{Error, Result};
use crate::io::input::hex;
use crate::program::Block;
use crate::program::csv::{Again, Meant, Parser, Piece, Placing, Source};
use crate::rewrite::sink::Sink;
use crate::rewrite::{OutputPoints, Points};
use sha2::{Digest, Sha256};
use std::sync::{Mutex, PoisonError};

/// Workers beyond which the stations that take turns are the limit.
const MOST_WORKERS: usize = 8;

/// Where text comes from, and the number of the piece that is read next.
struct Reading {
    source: Source,
    next: u64,
    ended: bool,
}

/// What works on pieces in the order of the program, between parsing and printing.
pub struct Middle<E> {
    pub placing: Placing,
    stage: Option<E>,
    /// `None`: no bytes are needed.
    pending: Option<Pending>,
    pub stats: RewriteStats,
    axes: usize,
}

/// What all workers share.
pub struct SharedState<'a, E, S> {
    reading: Mutex<Reading>,
    /// Of the bytes read, where wanted.
    hash_in: Option<Turn<Sha256>>,
    middle: Turn<Middle<E>>,
    /// Of the bytes written, where wanted.
    hash_out: Option<Turn<Sha256>>,
    sink: Turn<S>,
    /// Memory of blocks that are done.
    free: Mutex<Vec<Block>>,
    failed: Mutex<Option<(u64, Error)>>,
    axes: usize,
    progress: &'a (dyn Fn(u64) + Sync),
}

/// What a worker holds.
struct Worker {
    piece: Piece,
    parser: Parser,
    /// Reads what was printed.
    again: Again,
    task: Option<Task>,
    settled: OutputPoints,
    text: Vec<u8>,
}

/// What a worker found when it wanted to read.
enum Found {
    Piece,
    End,
    Failed(Error),
}

/// What is left when all workers are done.
pub struct Finished<E, S> {
    pub sha256_in: Option<String>,
    pub middle: Middle<E>,
    pub sink: S,
    /// Fewest decimals with which numbers of each axis were written.
    pub written: Vec<Option<u8>>,
}

impl<'a, E: Stage, S: Sink> SharedState<'a, E, S> {
    /// `hash`: that of what is read is wanted.
    pub fn new(source: Source, hash: bool, middle: Middle<E>, mut sink: S, progress: &'a (dyn Fn(u64) + Sync)) -> Self {
        let axes = middle.axes;
        Self {
            reading: Mutex::new(Reading { source, next: 1, ended: false }),
            hash_in: hash.then(|| Turn::new(Sha256::new())),
            middle: Turn::new(middle),
            hash_out: sink.lend_hash().map(Turn::new),
            sink: Turn::new(sink),
            free: Mutex::new(Vec::new()),
            failed: Mutex::new(None),
            axes,
            progress,
        }
    }

    /// Takes the program through, from its `first` piece on, which has been put in its place.
    pub fn run(self, first: Piece, parser: Parser, task: Option<Task>, many: bool) -> Result<Finished<E, S>> {
        let axes = self.axes;
        let ended = self.reading.lock().unwrap_or_else(PoisonError::into_inner).source.is_ended();
        let others = if many && !ended { workers() - 1 } else { 0 };
        let mut written: Vec<Option<u8>> = vec![None; axes];
        let mut note = |worker: &Worker| {
            for (least, own) in written.iter_mut().zip(worker.written(axes)) {
                *least = least.iter().chain(&own).min().copied();
            }
        };
        let panicked = std::thread::scope(|scope| {
            let mut handles = Vec::new();
            for _ in 0..others {
                let worker = Worker::new(Piece::default(), parser.fresh(), task.clone());
                let own = &self;
                // where no thread can be had, those that there are do the work
                let started = std::thread::Builder::new().spawn_scoped(scope, move || own.work(worker, None));
                handles.extend(started);
            }
            note(&self.work(Worker::new(first, parser, task), Some(0)));
            let mut panicked = false;
            for handle in handles {
                match handle.join() {
                    Ok(worker) => note(&worker),
                    Err(_) => panicked = true,
                }
            }
            panicked
        });
        let failed = self.failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        match failed {
            Some((_, error)) => Err(error),
            None if panicked => Err(Error::internal("rewrite", "a thread stopped unexpectedly; nothing was written")),
            None => {
                let mut sink = self.sink.into_inner();
                if let Some(hash) = self.hash_out {
                    sink.return_hash(hash.into_inner());
                }
                let sha256_in = self.hash_in.map(|hash| hex(&hash.into_inner().finalize()));
                Ok(Finished { sha256_in, middle: self.middle.into_inner(), sink, written })
            }
        }
    }

    /// Takes pieces through until there are no more; `number`: that of the piece that the worker holds already.
    fn work(&self, mut worker: Worker, mut number: Option<u64>) -> Worker {
        let guard = Guard(self);
        loop {
            let placed = number.is_some();
            let (number, found) = match number.take() {
                Some(number) => (number, Found::Piece),
                None => match self.read(&mut worker) {
                    Some(read) => read,
                    None => break,
                },
            };
            match self.take_through(&mut worker, number, found, placed) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => {
                    self.fail(number, error);
                    break;
                }
            }
        }
        drop(guard);
        worker
    }

    fn read(&self, worker: &mut Worker) -> Option<(u64, Found)> {
        if worker.piece.block.text.capacity() == 0
            && let Some(block) = self.free.lock().unwrap_or_else(PoisonError::into_inner).pop()
        {
            worker.piece.block = block;
        }
        let mut reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        if reading.ended {
            return None;
        }
        let number = reading.next;
        reading.next += 1;
        let found = match reading.source.next(&mut worker.piece) {
            Ok(true) => Found::Piece,
            Ok(false) => Found::End,
            Err(e) => Found::Failed(e.into()),
        };
        reading.ended = !matches!(found, Found::Piece);
        (self.progress)(reading.source.bytes());
        Some((number, found))
    }

    /// Takes one piece through; `false`: there is nothing more to do.
    fn take_through(&self, worker: &mut Worker, number: u64, found: Found, placed: bool) -> Result<bool> {
        let last = matches!(found, Found::End);
        if matches!(found, Found::Piece) {
            if !hashed(self.hash_in.as_ref(), number, worker.piece.bytes()) {
                return Ok(false);
            }
            if !placed {
                worker.piece.parse(&mut worker.parser);
            }
        }
        let done = self.middle.take(number, |middle| match found {
            Found::Failed(error) => Err(error),
            Found::End => middle.finish(worker),
            Found::Piece => middle.push(worker, placed),
        });
        let Some(done) = done else { return Ok(false) };
        done?;
        let Some(task) = &mut worker.task else { return Ok(!last) };
        worker.text.clear();
        let head = task.print(&mut worker.text, &mut |block| {
            self.free.lock().unwrap_or_else(PoisonError::into_inner).push(block);
        })?;
        let OutputPoints { axes, q, t_s, .. } = &task.settled;
        let meant = Meant { axes: *axes, q, t_s };
        if let Some(row) = worker.again.first_difference(&mut worker.text, head, meant) {
            return Err(other_rows(row, worker.text.get(head..).unwrap_or_default()));
        }
        if !hashed(self.hash_out.as_ref(), number, &worker.text) {
            return Ok(false);
        }
        let Some(taken) = self.sink.take(number, |sink| sink.take(&worker.text)) else { return Ok(false) };
        taken.map(|()| !last)
    }

    fn fail(&self, number: u64, error: Error) {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        if failed.as_ref().is_none_or(|f| number < f.0) {
            *failed = Some((number, error));
        }
        drop(failed);
        self.close_after(number);
    }

    fn close_after(&self, number: u64) {
        self.reading.lock().unwrap_or_else(PoisonError::into_inner).ended = true;
        self.middle.close_after(number);
        self.sink.close_after(number);
        for hash in self.hash_in.iter().chain(&self.hash_out) {
            hash.close_after(number);
        }
    }
}

/// Printed rows are not those that were meant; better no file than a wrong one.
#[cold]
fn other_rows(row: usize, text: &[u8]) -> Error {
    let line = text.split(|b| *b == b'\n').nth(row).unwrap_or_default();
    let line = String::from_utf8_lossy(&line[..line.len().min(200)]).into_owned();
    Error::internal("read the result as it is meant; nothing was written", format!("near `{}`", line.trim_end()))
}

/// Goes on with a hash, if there is one, when it is the turn of `number`; `false`: there is no such turn any more.
fn hashed(hash: Option<&Turn<Sha256>>, number: u64, bytes: &[u8]) -> bool {
    let Some(turn) = hash else { return true };
    let done = turn.take(number, |hash| {
        hash.update(bytes);
        Ok::<(), Error>(())
    });
    done.is_some()
}

/// Sends everybody home if its worker panics.
struct Guard<'a, 'b, E: Stage, S: Sink>(&'a SharedState<'b, E, S>);

impl<E: Stage, S: Sink> Drop for Guard<'_, '_, E, S> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.close_after(0);
        }
    }
}

impl<E: Stage> Middle<E> {
    pub fn new(placing: Placing, stage: E, axes: usize, pending: Option<Pending>) -> Self {
        Self { placing, stage: Some(stage), pending, stats: RewriteStats::default(), axes }
    }

    /// Puts the worker's piece in its place and its points through the engine.
    fn push(&mut self, worker: &mut Worker, placed: bool) -> Result<()> {
        if !placed {
            self.placing.place(&mut worker.piece)?;
        }
        let settled = worker.task.as_mut().map_or(&mut worker.settled, |t| &mut t.settled);
        let block = &mut worker.piece.block;
        if let Some(stage) = &mut self.stage {
            settled.clear();
            // the block lends its numbers and gets them back
            let points =
                Points { axes: self.axes, q: std::mem::take(&mut block.q), t_s: std::mem::take(&mut block.t_s) };
            let pushed = stage.push(&points, settled);
            (block.q, block.t_s) = (points.q, points.t_s);
            pushed?;
        }
        if let (Some(pending), Some(task)) = (&mut self.pending, &mut worker.task) {
            pending.settle(Some(std::mem::take(block)), task);
        }
        Ok(())
    }

    /// What is left of the program.
    fn finish(&mut self, worker: &mut Worker) -> Result<()> {
        self.placing.end()?;
        let settled = worker.task.as_mut().map_or(&mut worker.settled, |t| &mut t.settled);
        settled.clear();
        settled.axes = self.axes;
        if let Some(stage) = self.stage.take() {
            self.stats = stage.finish(settled)?;
        }
        if let (Some(pending), Some(task)) = (&mut self.pending, &mut worker.task) {
            pending.settle(None, task);
        }
        Ok(())
    }
}

impl Worker {
    fn new(piece: Piece, parser: Parser, task: Option<Task>) -> Self {
        let again = Again::new(&parser);
        Self { piece, parser, again, task, settled: OutputPoints::default(), text: Vec::new() }
    }

    fn written(&self, axes: usize) -> Vec<Option<u8>> {
        (0..axes).map(|a| self.task.as_ref().and_then(|t| t.written(a))).collect()
    }
}

/// A worker for each thread that this process may use; one more would only wait for turns (a tenth slower on two processors).
fn workers() -> usize {
    crate::numerics::parallel::threads().clamp(1, MOST_WORKERS)
}
