//! The text of pending rows, and the engine's points put into it.
//!
//! The engine settles points some rows after it has taken them; until then their blocks wait in [`Pending`]. Each push of the engine
//! becomes a [`Task`], which ends at the end of a row, so that tasks are printed side by side. Text that stays is copied in runs;
//! what stands between two rows (comments, blank lines) follows the points that are added to the first of them.

use super::super::{Origin, OutputPoints, Refusal};
use crate::error::{Error, Result};
use crate::program::csv::{Clock, Edits, Style, TIME_LEAST};
use crate::program::{Block, Slot};
use crate::robot::Robot;
use std::collections::VecDeque;
use std::sync::Arc;

/// Rows that are written in one go at most.
const MOST_RUN: usize = 256;

/// Rows that wait for the engine.
pub struct Pending {
    edits: Edits,
    slots: Arc<[Slot]>,
    blocks: VecDeque<Arc<Block>>,
    /// Up to here the text of the first pending block has been given away.
    cursor: usize,
    /// The point that comes next.
    next: u64,
    /// The line ending of the first row: for a point after a last row without one.
    ending: Vec<u8>,
    parted: Option<Parted>,
}

/// The way to a row that added points have parted.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Parted {
    /// The row before it.
    after: u64,
    /// Share of its duration that the added points took.
    share: f64,
}

/// Points that are settled, with the text into which they go.
#[derive(Clone)]
pub struct Task {
    edits: Edits,
    slots: Arc<[Slot]>,
    blocks: Vec<Arc<Block>>,
    cursor: usize,
    next: u64,
    ending: Vec<u8>,
    parted: Option<Parted>,
    pub settled: OutputPoints,
    /// Nothing follows.
    whole: bool,
}

impl Pending {
    pub fn new(slots: &[Slot], robot: &Robot, style: &Style) -> Self {
        Self {
            edits: Edits::new(slots, robot.axes(), style),
            slots: slots.into(),
            blocks: VecDeque::new(),
            cursor: 0,
            next: 0,
            ending: Vec::new(),
            parted: None,
        }
    }

    /// A task of which nothing is known yet.
    pub fn task(&self) -> Task {
        Task {
            edits: self.edits.clone(),
            slots: self.slots.clone(),
            blocks: Vec::new(),
            cursor: 0,
            next: 0,
            ending: Vec::new(),
            parted: None,
            settled: OutputPoints::default(),
            whole: false,
        }
    }

    /// Takes the text of the next rows (`None`: there are no more) and gives `task`, in which the points are that are settled by
    /// them, the text that it needs.
    pub fn settle(&mut self, block: Option<Block>, task: &mut Task) {
        task.whole = block.is_none();
        if let Some(block) = block {
            self.edits.begin(&block);
            if self.ending.is_empty()
                && let Some(row) = block.rows.first()
            {
                let text = block.bytes(row.start as usize, row.end as usize);
                let body = text.iter().rev().take_while(|b| matches!(b, b'\r' | b'\n')).count();
                self.ending = text[text.len() - body..].to_vec();
            }
            self.blocks.push_back(Arc::new(block));
        }
        task.edits.resume(&self.edits);
        task.ending.clone_from(&self.ending);
        task.blocks.clear();
        task.blocks.extend(self.blocks.iter().cloned());
        (task.cursor, task.next, task.parted) = (self.cursor, self.next, self.parted);
        self.parted = match task.settled.origin.last() {
            Some(&Origin::Inserted { after, fraction }) => Some(Parted { after, share: fraction }),
            Some(Origin::Point(_)) => None,
            None => self.parted,
        };
        let own = task.settled.origin.iter().rev().find_map(|o| match *o {
            Origin::Point(n) => Some(n),
            Origin::Inserted { .. } => None,
        });
        let Some(last) = own else { return };
        while self.blocks.front().is_some_and(|b| b.first_point + b.rows.len() as u64 <= last) {
            self.blocks.pop_front();
        }
        let row = |b: &Arc<Block>| b.rows.get(last.checked_sub(b.first_point)? as usize).map(|row| row.end as usize);
        // a point that is in no block is found out when it is printed
        self.cursor = self.blocks.front().and_then(row).unwrap_or(0);
        self.next = last + 1;
    }
}

impl Task {
    /// Fewest decimals with which numbers of an axis were written in all tasks that this one has been.
    pub fn written(&self, axis: usize) -> Option<u8> {
        self.edits.written(axis)
    }

    /// Writes the text of the task to `out`; blocks without another holder go to `free`. Gives the place in `out` at which the first
    /// row may begin: what stands before it is the head of the program as it was.
    pub fn print(&mut self, out: &mut Vec<u8>, free: &mut dyn FnMut(Block)) -> Result<usize> {
        let first = self.blocks.first().and_then(|b| b.rows.first()).filter(|_| self.next == 0);
        let head = first.map_or(0, |row| row.start as usize);
        let mut front = 0;
        let timed = !self.settled.t_s.is_empty();
        let mut k = 0;
        while k < self.settled.len() {
            k += self.run(k, &mut front, out)?;
            let Some(&origin) = self.settled.origin.get(k) else { break };
            let t_s = if timed { Some(self.settled.t_s[k]) } else { None };
            if timed && (k > 0 && self.settled.t_s[k] <= self.settled.t_s[k - 1]) {
                return Err(no_time(origin));
            }
            match origin {
                Origin::Point(n) if n == self.next => {
                    self.reach(n, &mut front, out)?;
                    self.next += 1;
                    let duration = self.rest_of_duration(n, front);
                    let block = &self.blocks[front];
                    let i = (n - block.first_point) as usize;
                    let clock = Clock { t_s, duration };
                    self.cursor = self.edits.row(block, i, self.cursor, self.settled.row(k), clock, out);
                }
                Origin::Inserted { after, fraction } if after + 1 == self.next => {
                    let duration = self.part_of_duration(after, fraction, front);
                    let (block, i) = self.row_of(after, front)?;
                    if t_s.is_some_and(|t| block.t_s.get(i).is_some_and(|own| t <= *own)) {
                        return Err(no_time(origin));
                    }
                    self.finish_row(after, front, out)?;
                    // after a last row without a line ending: that of the first row, and none after the added one
                    let block = &self.blocks[front];
                    if !matches!(block.text[..self.cursor].last(), Some(b'\n' | b'\r')) {
                        out.extend_from_slice(if self.ending.is_empty() { b"\n" } else { &self.ending });
                    }
                    self.edits.added(block, i, self.settled.row(k), Clock { t_s, duration }, out);
                }
                Origin::Point(n) | Origin::Inserted { after: n, .. } => return Err(astray(n)),
            }
            k += 1;
        }
        match self.next.checked_sub(1) {
            _ if self.whole => self.rest(front, out)?,
            Some(last) if !self.settled.is_empty() => self.finish_row(last, front, out)?,
            _ => {}
        }
        for block in self.blocks.drain(..) {
            if let Some(block) = Arc::into_inner(block) {
                free(block);
            }
        }
        Ok(head.min(out.len()))
    }

    /// Duration of the way to point `n`, and decimals to which its parts are rounded so that their sum is the whole.
    fn duration(&self, n: u64, front: usize) -> Option<(f64, u8)> {
        let blocks = self.blocks.get(front..)?;
        let block = blocks.iter().find(|b| n < b.first_point + b.rows.len() as u64)?;
        let slot = self.slots.iter().position(|s| *s == Slot::Duration)?;
        let whole = block.durations.get(usize::try_from(n.checked_sub(block.first_point)?).ok()?)?;
        Some((*whole, block.decimals.get(slot)?.max(&TIME_LEAST).to_owned()))
    }

    /// Duration from the point before to one that is added after point `after`, at this share of the way to the next.
    fn part_of_duration(&mut self, after: u64, share: f64, front: usize) -> Option<f64> {
        let (whole, decimals) = self.duration(after + 1, front)?;
        let before = self.parted.filter(|p| p.after == after).map_or(0.0, |p| p.share);
        self.parted = Some(Parted { after, share });
        Some(rounded(share * whole, decimals) - rounded(before * whole, decimals))
    }

    /// Duration that is left of the way to point `n`; `None`: all of it.
    fn rest_of_duration(&mut self, n: u64, front: usize) -> Option<f64> {
        let parted = self.parted.take().filter(|p| p.after + 1 == n)?;
        let (whole, decimals) = self.duration(n, front)?;
        Some(whole - rounded(parted.share * whole, decimals))
    }

    /// The points from place `k` on that are the program's own, one after the other, and whose rows hold plain numbers
    /// alone: most of a program. Gives how many were written.
    #[inline]
    fn run(&mut self, k: usize, front: &mut usize, out: &mut Vec<u8>) -> Result<usize> {
        let settled = &self.settled;
        if settled.origin[k] != Origin::Point(self.next) {
            return Ok(0);
        }
        self.reach(self.next, front, out)?;
        let (block, settled) = (&self.blocks[*front], &self.settled);
        let i = (self.next - block.first_point) as usize;
        let own = settled.origin[k..].iter().zip(self.next..).take(block.pure.saturating_sub(i).min(MOST_RUN));
        let rows = own.take_while(|&(origin, n)| *origin == Origin::Point(n)).count();
        let q = &settled.q[k * settled.axes..(k + rows) * settled.axes];
        let t_s = if settled.t_s.is_empty() { &[] } else { &settled.t_s[k..k + rows] };
        let (done, cursor) = self.edits.pure_rows(block, i, self.cursor, q, settled.axes, t_s, out);
        self.cursor = cursor;
        self.next += done as u64;
        Ok(done)
    }

    /// Makes the block of point `n` the one at `front`; what is left of those before it is written.
    #[inline]
    fn reach(&mut self, n: u64, front: &mut usize, out: &mut Vec<u8>) -> Result<()> {
        while let Some(block) = self.blocks.get(*front) {
            if n < block.first_point + block.rows.len() as u64 {
                return Ok(());
            }
            out.extend_from_slice(&block.text[self.cursor..]);
            self.cursor = 0;
            *front += 1;
        }
        Err(astray(n))
    }

    /// The block at `front`, and which of its rows point `n` is.
    fn row_of(&self, n: u64, front: usize) -> Result<(&Block, usize)> {
        let block = self.blocks.get(front).ok_or_else(|| astray(n))?;
        let i = n.checked_sub(block.first_point).ok_or_else(|| astray(n))? as usize;
        if i < block.rows.len() { Ok((block, i)) } else { Err(astray(n)) }
    }

    /// Writes the text up to the end of the row of point `n`.
    fn finish_row(&mut self, n: u64, front: usize, out: &mut Vec<u8>) -> Result<()> {
        let (block, i) = self.row_of(n, front)?;
        let end = block.rows[i].end as usize;
        if self.cursor < end {
            out.extend_from_slice(&block.text[self.cursor..end]);
            self.cursor = end;
        }
        Ok(())
    }

    /// Writes what is left after the last point.
    fn rest(&mut self, front: usize, out: &mut Vec<u8>) -> Result<()> {
        let left = &self.blocks[front.min(self.blocks.len())..];
        let rows: u64 = left.iter().map(|b| b.rows.len() as u64).sum();
        let first = left.first().map_or(self.next, |b| b.first_point);
        if first + rows != self.next {
            return Err(astray(self.next));
        }
        for block in left {
            out.extend_from_slice(&block.text[self.cursor..]);
            self.cursor = 0;
        }
        Ok(())
    }
}

/// A value with so many decimals.
fn rounded(value: f64, decimals: u8) -> f64 {
    let unit = 10f64.powi(i32::from(decimals));
    (value * unit).round() / unit
}

/// The time of a new point is no other than that of its neighbour.
#[cold]
fn no_time(origin: Origin) -> Error {
    let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = origin;
    Refusal::NoTime { place: format!("point {}", n + 1) }.into()
}

/// The engine broke its contract; better no file than a wrong one.
#[cold]
fn astray(point: u64) -> Error {
    Error::internal("find the place of a point; nothing was written", format!("point {point}"))
}
