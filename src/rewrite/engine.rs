//! The engine: pushes of points in, points with offsets out.

use super::{Emitted, Options, Origin, Points};
use crate::compensator::Compensator;
use crate::error::Result;
use crate::robot::Robot;

/// What a rewrite did, for the account that a user reads.
#[derive(Debug, Clone, Default)]
pub struct Account {
    pub points: u64,
    pub inserted: u64,
    /// Reversals per axis.
    pub reversals: Vec<u64>,
    /// Largest offset per axis, rad or m.
    pub largest_offset: Vec<f64>,
    /// Places where a limit would be exceeded after compensation, the first of them in full.
    pub violations: Vec<Violation>,
    pub violations_total: u64,
    /// Duration of the program before and after, s, where it can be told.
    pub duration_s: Option<[f64; 2]>,
    /// Largest TCP change, m.
    pub largest_change_m: f64,
}

/// A limit that would be exceeded.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub origin: Origin,
    pub axis: usize,
    pub what: LimitKind,
    /// Value and limit, SI.
    pub value: f64,
    pub limit: f64,
}

/// Kind of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    Range,
    Speed,
    Acceleration,
}

/// State of a rewrite in progress.
pub struct Engine<'a> {
    robot: &'a Robot,
    compensator: &'a Compensator,
    options: Options,
    account: Account,
}

impl<'a> Engine<'a> {
    /// Prepares a rewrite; fails where an option is missing (a decay in seconds needs times or a TCP speed).
    pub fn new(robot: &'a Robot, compensator: &'a Compensator, options: Options) -> Result<Self> {
        Ok(Self { robot, compensator, options, account: Account::default() })
    }

    /// Takes the next points and appends what is settled to `out`.
    pub fn push(&mut self, block: &Points, out: &mut Emitted) -> Result<()> {
        let _ = (self.robot, self.compensator, &self.options);
        out.axes = block.axes;
        out.q.extend_from_slice(&block.q);
        out.t_s.extend_from_slice(&block.t_s);
        for _ in 0..block.len() {
            out.origin.push(Origin::Point(self.account.points));
            self.account.points += 1;
        }
        Ok(())
    }

    /// Appends what is left and returns the account.
    pub fn finish(self, out: &mut Emitted) -> Result<Account> {
        let _ = out;
        Ok(self.account)
    }
}
