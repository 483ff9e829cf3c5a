//! The text of pending rows, and the engine's points put into it.
//!
//! The engine settles points some rows behind the text; until then their blocks wait here. Text that stays is copied in
//! runs; what stands between two rows (comments, blank lines) goes behind the points that are added to the first of them.

use super::super::{Origin, OutputPoints};
use crate::error::{Error, Result};
use crate::program::csv::{Edits, Style};
use crate::program::{Block, Slot};
use crate::robot::Robot;
use std::collections::VecDeque;

/// Bytes are handed on in pieces of about this size.
pub const PIECE: usize = 1 << 20;

/// Rows that are written in one go at most.
const MOST_RUN: usize = 256;

/// Rows that wait for the engine, and the output as it grows.
pub struct Render {
    edits: Edits,
    pending: VecDeque<Block>,
    /// Up to here the text of the first pending block has been written.
    cursor: usize,
    /// The point that comes next.
    next: u64,
    out: Vec<u8>,
    spare: Option<Vec<u8>>,
    /// The line ending of the first row: for a point behind a last row without one.
    ending: Vec<u8>,
}

impl Render {
    pub fn new(slots: &[Slot], robot: &Robot, style: &Style) -> Self {
        Self {
            edits: Edits::new(slots, robot.axes(), style),
            pending: VecDeque::new(),
            cursor: 0,
            next: 0,
            out: Vec::with_capacity(PIECE + PIECE / 4),
            spare: None,
            ending: Vec::new(),
        }
    }

    pub fn edits(&self) -> &Edits {
        &self.edits
    }

    /// Takes the text of the next rows and the points that are settled by them; blocks that are done go to `free`.
    pub fn feed(&mut self, block: Option<Block>, settled: &OutputPoints, free: &mut dyn FnMut(Block)) -> Result<()> {
        if let Some(block) = block {
            self.edits.begin(&block);
            if self.ending.is_empty()
                && let Some(row) = block.rows.first()
            {
                let text = block.bytes(row.start as usize, row.end as usize);
                let body = text.iter().rev().take_while(|b| matches!(b, b'\r' | b'\n')).count();
                self.ending = text[text.len() - body..].to_vec();
            }
            self.pending.push_back(block);
        }
        let timed = !settled.t_s.is_empty();
        let mut k = 0;
        while k < settled.len() {
            let run = self.run(settled, k, free)?;
            k += run;
            let Some(origin) = settled.origin.get(k) else { break };
            let t_s = if timed { Some(settled.t_s[k]) } else { None };
            if timed && (k > 0 && settled.t_s[k] <= settled.t_s[k - 1]) {
                return Err(no_time(*origin));
            }
            match *origin {
                Origin::Point(n) if n == self.next => {
                    self.reach(n, free)?;
                    self.next += 1;
                    let Some(block) = self.pending.front() else { return Err(astray(n)) };
                    let i = (n - block.first_point) as usize;
                    self.cursor = self.edits.row(block, i, self.cursor, settled.row(k), t_s, &mut self.out);
                }
                Origin::Inserted { after, .. } if after + 1 == self.next => {
                    let Some(block) = self.pending.front() else { return Err(astray(after)) };
                    let i = (after - block.first_point) as usize;
                    if t_s.is_some_and(|t| block.t_s.get(i).is_some_and(|own| t <= *own)) {
                        return Err(no_time(*origin));
                    }
                    let end = block.rows[i].end as usize;
                    if self.cursor < end {
                        self.out.extend_from_slice(&block.text[self.cursor..end]);
                        self.cursor = end;
                    }
                    // behind a last row without a line ending: that of the first row, and none behind the added one
                    let open = !matches!(block.text[..end].last(), Some(b'\n' | b'\r'));
                    if open {
                        self.out.extend_from_slice(if self.ending.is_empty() { b"\n" } else { &self.ending });
                    }
                    self.edits.added(block, i, settled.row(k), t_s, &mut self.out);
                }
                Origin::Point(n) | Origin::Inserted { after: n, .. } => return Err(astray(n)),
            }
            k += 1;
        }
        Ok(())
    }

    /// The points from place `k` on that are the program's own, one behind the other, and whose rows hold plain numbers
    /// alone: most of a program. Gives how many were written.
    #[inline]
    fn run(&mut self, settled: &OutputPoints, k: usize, free: &mut dyn FnMut(Block)) -> Result<usize> {
        if settled.origin[k] != Origin::Point(self.next) {
            return Ok(0);
        }
        self.reach(self.next, free)?;
        let Some(block) = self.pending.front() else { return Err(astray(self.next)) };
        let i = (self.next - block.first_point) as usize;
        let own = settled.origin[k..].iter().zip(self.next..).take(block.pure.saturating_sub(i).min(MOST_RUN));
        let rows = own.take_while(|&(origin, n)| *origin == Origin::Point(n)).count();
        let q = &settled.q[k * settled.axes..(k + rows) * settled.axes];
        let t_s = if settled.t_s.is_empty() { &[] } else { &settled.t_s[k..k + rows] };
        let (done, cursor) = self.edits.pure_rows(block, i, self.cursor, q, settled.axes, t_s, &mut self.out);
        self.cursor = cursor;
        self.next += done as u64;
        Ok(done)
    }

    /// Makes the block of point `n` the first one; what is left of those before it is written.
    #[inline]
    fn reach(&mut self, n: u64, free: &mut dyn FnMut(Block)) -> Result<()> {
        while let Some(front) = self.pending.front() {
            if n < front.first_point + front.rows.len() as u64 {
                return Ok(());
            }
            self.out.extend_from_slice(&front.text[self.cursor..]);
            self.cursor = 0;
            if let Some(done) = self.pending.pop_front() {
                free(done);
            }
        }
        Err(astray(n))
    }

    /// Writes what is left behind the last point.
    pub fn end(&mut self) -> Result<()> {
        let rows: u64 = self.pending.iter().map(|b| b.rows.len() as u64).sum();
        let first = self.pending.front().map_or(self.next, |b| b.first_point);
        if first + rows != self.next {
            return Err(astray(self.next));
        }
        for block in self.pending.drain(..) {
            self.out.extend_from_slice(&block.text[self.cursor..]);
            self.cursor = 0;
        }
        Ok(())
    }

    /// The output so far, where it is a piece or `all` is wanted.
    pub fn ready(&mut self, all: bool) -> Option<Vec<u8>> {
        if self.out.is_empty() || (!all && self.out.len() < PIECE) {
            return None;
        }
        let next = self.spare.take().unwrap_or_else(|| Vec::with_capacity(PIECE + PIECE / 4));
        Some(std::mem::replace(&mut self.out, next))
    }

    /// Gives a piece's memory back.
    pub fn recycle(&mut self, mut piece: Vec<u8>) {
        piece.clear();
        self.spare = Some(piece);
    }
}

/// The time of a new point is no other than that of its neighbour: at 1e15 s a double knows eighths of a second.
#[cold]
fn no_time(origin: Origin) -> Error {
    let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = origin;
    let why = "there is no time between two points for a new one; nothing was written (count times from the start of the program)";
    Error::Refused(format!("point {}: {why}", n + 1))
}

/// The engine broke its contract; better no file than a wrong one.
#[cold]
fn astray(point: u64) -> Error {
    Error::Refused(format!("internal error: the rewrite lost its place at point {point}; nothing was written"))
}
