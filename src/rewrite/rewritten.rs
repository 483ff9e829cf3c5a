//! A program that was rewritten, known by its numbers alone: for a file whose note is not beside it.
//!
//! Method: two traces that a rewrite with this compensator leaves, and that a program as it was does not.
//!
//! - *Steps.* After a reversal of an axis there is a point on the straight way between two others (its share of the way is the same
//!   in all axes that do not turn there), at which the reversing axis alone stands off that way, by the very step of the
//!   compensator: both half gaps and what friction is left. Where no other axis moves, the share itself must be the one that a
//!   rewrite chooses, and must fit better with the step than without it. Where all axes turn at once, they must agree on the share
//!   with their steps taken off, and not without.
//!   Where points are dense the step is no point more but a leap among small steps.
//! - *Digits.* Where new points had no place, targets carry their offset all the same: less that offset, the numbers become rounder,
//!   all of them; those of a program as it was become longer.
//!
//! A judgement needs at least four reversals, of which four in five must be made so. Neither trace remains where a program was
//! rewritten with another compensator or gain, or with a ramp, and edited or resampled since.

use crate::compensator::{Compensator, JointCompensator};
use crate::numerics::parallel::ParMap;
use crate::rewrite::offset::Offset;
use crate::rewrite::plan::{GENTLE, NEAREST};
use std::collections::HashSet;

/// Fewest reversals that a judgement needs, and the share of them that must look made: by a step, or by a short way alone.
const LEAST_TURNS: usize = 4;
const SHARE: f64 = 0.5;
const SHARE_SHORT: f64 = 0.8;
/// The step may differ by this share from the compensator's: a gap that varies, friction on its way out.
const STEP_TOLERANCE: f64 = 0.1;
/// ... and by this more on a spline.
const SPLINE_TOLERANCE: f64 = 0.05;
/// The point with the step stands at most at this share of its way.
const FARTHEST: f64 = 0.6;
/// A leap is more than this many times the steps before and after it, and goes on by at most this share of the step after it.
const LEAP: f64 = 3.0;
const LEAST_PART: f64 = 0.35;
/// Points after a reversal among which the one with the step is looked for, and those after it that may end its way.
const NEAR: usize = 5;
/// A number is off by rounding by at most so many last digits.
const ROUNDED: f64 = 0.55;
/// An axis tells the share of a way of at least so many last digits.
const TELLING: f64 = 20.0;
/// A way without another axis is short up to this share, and the one after it goes on by at most this many times its length.
const SHORT: f64 = 0.11;
const GROWS: f64 = 2.0;
/// Rounding of two numbers together, as a share of both half gaps (`super::digits` writes no last digit above 5 % of one).
const COARSEST: f64 = 0.025;
/// Fewest numbers whose roundness is a trace, and the share of them that become rounder.
const LEAST_NUMBERS: usize = 6;
const ROUNDER: f64 = 0.8;
/// Different numbers of an axis that are asked for their roundness.
const MOST_SEEN: usize = 4096;
/// So many numbers are looked at on several processors.
const MANY: usize = 1 << 14;
/// Decimals beyond which a number is not asked for its roundness.
const MOST_DECIMALS: i32 = 7;

/// What is judged: rows of joints in the order in which the robot comes to them.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// `q[row * axes + axis]`, rad or m.
    pub q: &'a [f64],
    /// The same rows, each as it would stand if the way between the rows before and after it were straight: points of a spline. Empty: all
    /// ways are straight.
    pub straight: &'a [f64],
    pub axes: usize,
}

/// How the numbers of an axis are written.
#[derive(Debug, Clone, Copy)]
pub struct Digits {
    /// Weight of the last digit, rad or m.
    pub last: f64,
    /// rad or m in one unit of the numbers (a degree, a millimetre, a pulse).
    pub unit: f64,
}

/// Evidence of a program, piece by piece.
#[derive(Debug, Default)]
pub struct Evidence {
    turns: usize,
    made: usize,
    short: usize,
    numbers: usize,
    rounder: usize,
}

impl Evidence {
    /// Adds a stretch in which each row follows the one before it.
    pub fn add(&mut self, rows: Rows, digits: &[Digits], compensator: &Compensator, step_fraction: f64) {
        let mut offsets: Vec<Option<Offset>> = (0..rows.axes).map(|_| None).collect();
        for joint in compensator.joints.iter().filter(|j| has_step(j)) {
            if let Some(place) = offsets.get_mut(joint.axis) {
                *place = Some(Offset::new(joint));
            }
        }
        let of = |axis: usize| {
            let mut own = Self::default();
            if let (Some(Some(offset)), Some(digit)) = (offsets.get(axis), digits.get(axis)) {
                let column = Column { rows, axis, offset, offsets: &offsets, digits, digit: *digit, step_fraction };
                own.steps(&column);
                own.roundness(&column);
            }
            own
        };
        if rows.q.len() < MANY {
            (0..rows.axes).for_each(|axis| self.join(of(axis)));
        } else {
            (0..rows.axes).par_map(of).into_iter().for_each(|own| self.join(own));
        }
    }

    fn join(&mut self, other: Self) {
        let Self { turns, made, short, numbers, rounder } = other;
        self.turns += turns;
        self.made += made;
        self.short += short;
        self.numbers += numbers;
        self.rounder += rounder;
    }

    /// Whether the program looks rewritten.
    pub fn is_rewritten(&self) -> bool {
        let most = |part: usize, whole: usize, share: f64| part as f64 >= share * whole as f64;
        let enough = self.turns >= LEAST_TURNS && self.made + self.short >= LEAST_TURNS - 1;
        let made = most(self.made, self.turns, SHARE) || most(self.made + self.short, self.turns, SHARE_SHORT);
        let steps = enough && made;
        let digits =
            self.turns >= LEAST_TURNS && self.numbers >= LEAST_NUMBERS && most(self.rounder, self.numbers, ROUNDER);
        steps || digits
    }

    fn steps(&mut self, column: &Column) {
        let n = column.len();
        let mut dir = 0.0;
        let mut short: Vec<f64> = Vec::new();
        for i in 0..n.saturating_sub(1) {
            let by = column.p(i + 1) - column.p(i);
            if by.abs() <= column.digit.last * ROUNDED {
                continue;
            }
            if dir * by < 0.0 && i + 2 < n {
                self.turns += 1;
                if column.is_made(i, by.signum()) {
                    self.made += 1;
                } else {
                    short.extend(column.short_way(i, by.signum()));
                }
            }
            dir = by.signum();
        }
        // a program's own short ways are alike, or round
        short.sort_by(f64::total_cmp);
        let alike = |a: f64, other: Option<usize>| {
            other.and_then(|k| short.get(k)).is_some_and(|b| (a - b).abs() <= 2.0 * column.digit.last)
        };
        let own = |(k, a): &(usize, &f64)| !alike(**a, k.checked_sub(1)) && !alike(**a, Some(k + 1));
        self.short += short.iter().enumerate().filter(own).count();
    }

    fn roundness(&mut self, column: &Column) {
        let mut dir = 0.0;
        let mut seen: HashSet<u64> = HashSet::new();
        for i in 1..column.len() {
            if seen.len() > MOST_SEEN {
                break;
            }
            let by = column.p(i) - column.p(i - 1);
            if by.abs() > column.digit.last * ROUNDED {
                dir = by.signum();
            }
            // one number that is written many times is one number
            // (-0.0 is 0.0)
            if dir == 0.0 || !seen.insert((column.p(i) + 0.0).to_bits()) {
                continue;
            }
            let own = column.decimals(column.p(i));
            if own == 0 {
                continue; // nothing can be rounder
            }
            self.numbers += 1;
            let gap = column.offset.gap(dir as i8, column.p(i));
            self.rounder += usize::from(column.decimals(column.p(i) - dir * gap) < own);
        }
    }
}

/// There is a step at reversals; friction that builds up makes none.
fn has_step(joint: &JointCompensator) -> bool {
    let gap = joint.backlash.as_ref().is_some_and(|b| b.positive.smallest() + b.negative.smallest() > 0.0);
    gap && joint.friction.is_none_or(|f| f.gain >= 0.0)
}

/// Axes of nearly every robot.
const FEW: usize = 8;

/// One axis of the rows, with its compensator.
struct Column<'a> {
    rows: Rows<'a>,
    axis: usize,
    offset: &'a Offset,
    /// Of every axis that has a step.
    offsets: &'a [Option<Offset>],
    digits: &'a [Digits],
    digit: Digits,
    step_fraction: f64,
}

impl Column<'_> {
    fn len(&self) -> usize {
        self.rows.q.len().checked_div(self.rows.axes).unwrap_or(0)
    }

    fn at(&self, i: usize, axis: usize) -> f64 {
        self.rows.q[i * self.rows.axes + axis]
    }

    fn p(&self, i: usize) -> f64 {
        self.at(i, self.axis)
    }

    /// A point soon after the reversal at `i`, from which the axis leaves in direction `dir`, carries the step.
    fn is_made(&self, i: usize, dir: f64) -> bool {
        let last = self.len() - 1;
        let steps = |j: usize| (j + 1..=(j + NEAR).min(last)).any(|k| self.carries_step(i, j, k, dir, self.rows.q));
        if i < last && self.of_spline(i, dir) {
            return true;
        }
        (i + 1..=(i + NEAR).min(last)).any(|j| steps(j) || self.leaps(i, j, dir))
    }

    /// Where points are dense, the step goes over one or two of them, and stands out among its neighbours: smooth motion is slow
    /// at a reversal.
    fn leaps(&self, i: usize, j: usize, dir: f64) -> bool {
        if i == 0 || j > i + 2 || j + 1 >= self.len() {
            return false;
        }
        let own = dir * (self.p(j) - self.p(i));
        let (before, after) = ((self.p(i) - self.p(i - 1)).abs(), (self.p(j + 1) - self.p(j)).abs());
        let gaps = self.offset.gap(1, self.p(i)) + self.offset.gap(-1, self.p(i));
        let most = gaps + self.offset.friction().map_or(0.0, |f| f.gain);
        let sized = own >= gaps * (1.0 - STEP_TOLERANCE) && own <= most * (1.0 + STEP_TOLERANCE) + LEAST_PART * after;
        sized && gaps > 4.0 * self.digit.last && own > LEAP * before.max(after)
    }

    /// The same of the next point, where it is one of a spline.
    fn of_spline(&self, i: usize, dir: f64) -> bool {
        let (j, k) = (i + 1, i + 2);
        k < self.len() && !self.rows.straight.is_empty() && self.carries_step(i, j, k, dir, self.rows.straight)
    }

    /// `middle`: the rows of which `j` is one.
    fn carries_step(&self, i: usize, j: usize, k: usize, dir: f64, middle: &[f64]) -> bool {
        let Some(middle) = middle.get(j * self.rows.axes..(j + 1) * self.rows.axes) else { return false };
        let here = self.p(i);
        let gaps = self.offset.gap(1, here) + self.offset.gap(-1, here);
        let friction = self.offset.friction().map_or(0.0, |f| f.gain);
        let (own, whole) = (dir * (middle[self.axis] - here), dir * (self.p(k) - here));
        if own <= 0.0 || gaps <= 2.0 * ROUNDED * self.digit.last {
            return false;
        }
        match self.share(i, middle, k) {
            Share::Bent => false,
            Share::Measured(share, off) => {
                if share > FARTHEST {
                    return false;
                }
                // off the straight way from i to k, on which each end carries its own offset
                let step = own - share * whole;
                let rounding = ROUNDED * self.digit.last * 2.0 + off * whole.abs();
                let [least, most] = [gaps * (1.0 - share), gaps * (1.0 - share) + friction];
                // the step itself goes over a spline, which is off its straight way by a tenth of it
                let of_spline = if self.rows.straight.is_empty() { 0.0 } else { SPLINE_TOLERANCE };
                let slack = (STEP_TOLERANCE + of_spline) * most + rounding;
                rounding < 0.5 * least && step >= least - slack && step <= most + slack
            }
            Share::Unknown => {
                let (travel, way) = (own - gaps, whole - gaps);
                let off = 4.0 * ROUNDED * self.digit.last;
                let chosen =
                    |wanted: f64, plain: f64| (travel - wanted).abs() <= off && (own - plain).abs() > 4.0 * off;
                let shares = [self.step_fraction, NEAREST];
                // where the robot stands, the whole step is done in place
                let in_place = travel.abs() <= off && way > GENTLE * gaps;
                let gentle = || chosen(GENTLE * gaps, GENTLE * gaps);
                let shared = || shares.iter().any(|share| chosen(share * way, share * whole));
                in_place || travel > 0.0 && way > travel && (gentle() || shared())
            }
        }
    }

    /// The length of a short way after the reversal at `i` on which no other axis moves, where it is not round.
    fn short_way(&self, i: usize, dir: f64) -> Option<f64> {
        let (j, k) = (i + 1, i + 2);
        let middle = self.rows.q.get(j * self.rows.axes..k * self.rows.axes)?;
        if k >= self.len() || !matches!(self.share(i, middle, k), Share::Unknown) {
            return None;
        }
        let (own, whole) = (dir * (self.p(j) - self.p(i)), dir * (self.p(k) - self.p(i)));
        let gaps = self.offset.gap(1, self.p(i)) + self.offset.gap(-1, self.p(i));
        let after = if k + 1 < self.len() { dir * (self.p(k + 1) - self.p(k)) } else { 0.0 };
        let written = (self.digit.unit / self.digit.last).log10().round() as i32;
        let fits = own > gaps && own <= SHORT * whole && after <= GROWS * (whole - own) && !self.is_sampled(i, dir);
        (fits && self.decimals(own) + 1 >= written).then_some(own)
    }

    /// The steps around the reversal at `i` are those of a smooth motion in even time: of an oscillation, the step after and the one
    /// before add up to `2 cos(w dt)` times the one between.
    fn is_sampled(&self, i: usize, dir: f64) -> bool {
        let Some(before) = i.checked_sub(1) else { return false };
        let step = |from: usize, to: usize| dir * (self.p(to) - self.p(from));
        let (own, around) = (step(i, i + 1), step(before, i) + step(i + 1, i + 2));
        let slack = 4.0 * ROUNDED * self.digit.last;
        (-slack..=2.0 * own + slack).contains(&around)
    }

    /// The share of the way from row `i` to row `k` at which the row `middle` stands, as the other axes tell it.
    fn share(&self, i: usize, middle: &[f64], k: usize) -> Share {
        let of = |axis: usize| {
            let digit = self.digits.get(axis)?.last;
            let (a, b, c) = (self.at(i, axis), *middle.get(axis)?, self.at(k, axis));
            let whole = c - a;
            let turns = i > 0 && (a - self.at(i - 1, axis)) * whole < 0.0;
            if turns || whole.abs() < TELLING * digit {
                return None;
            }
            let share = (b - a) / whole;
            let off = 2.0 * ROUNDED * digit / whole.abs();
            if share < -off || share > 1.0 + off {
                return None; // it turns on the way
            }
            Some((share, off))
        };
        let found = (0..self.rows.axes).filter(|a| *a != self.axis).filter_map(of);
        // asked for at every reversal: a short list is not allocated
        let (mut few, mut many) = ([(0.0, 0.0); FEW], Vec::new());
        let shares: &[(f64, f64)] = if self.rows.axes <= FEW {
            let mut count = 0;
            for (place, share) in few.iter_mut().zip(found) {
                *place = share;
                count += 1;
            }
            few.get(..count).unwrap_or_default()
        } else {
            many.extend(found);
            &many
        };
        let Some(&(share, off)) = shares.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return self.share_of_turning(i, middle, k);
        };
        // an axis with its own step on this way is off it; most are not
        let straight = shares.iter().filter(|(s, o)| (s - share).abs() <= o + off).count();
        if 2 * straight > shares.len() { Share::Measured(share, off) } else { Share::Bent }
    }

    /// The same where all axes that move turn at `i`: the share on which at least two others agree with their steps taken off, and
    /// do not as they stand.
    fn share_of_turning(&self, i: usize, middle: &[f64], k: usize) -> Share {
        let mut shares: Vec<[f64; 3]> = Vec::new();
        for axis in (0..self.rows.axes).filter(|a| *a != self.axis) {
            let (Some(digit), Some(Some(offset))) = (self.digits.get(axis).map(|d| d.last), self.offsets.get(axis))
            else {
                continue;
            };
            let (a, b, c) = (self.at(i, axis), middle[axis], self.at(k, axis));
            // less the offsets of both ends: on the way that the program had
            let dir = (c - a).signum();
            let plain = |v: f64| v - a - dir * (offset.gap(-dir as i8, a) + offset.gap(dir as i8, v));
            if (c - a).abs() < TELLING * digit || dir * plain(c) < TELLING * digit {
                continue;
            }
            // numbers of a program differ in their digits; none is coarser than this share of a gap
            let gaps = offset.gap(1, a) + offset.gap(-1, a);
            let off = (2.0 * ROUNDED * digit).max(COARSEST * gaps) / plain(c).abs();
            shares.push([plain(b) / plain(c), (b - a) / (c - a), off]);
        }
        let agree = |n: usize| {
            let apart = |[x, y]: [&[f64; 3]; 2]| (x[n] - y[n]).abs() <= x[2] + y[2];
            shares.iter().all(|x| shares.iter().all(|y| apart([x, y])))
        };
        let best = shares.iter().min_by(|a, b| a[2].total_cmp(&b[2]));
        match best {
            Some([share, _, off]) if shares.len() > 1 && agree(0) && !agree(1) && *share > 0.0 => {
                Share::Measured(*share, *off)
            }
            _ => Share::Unknown,
        }
    }

    fn decimals(&self, v: f64) -> i32 {
        decimals(v, self.digit.last, self.digit.unit)
    }
}

/// Decimals that a value needs in its unit, but for rounding to its last digit.
pub fn decimals(v: f64, last: f64, unit: f64) -> i32 {
    /// Of ten, exact.
    const POWERS: [f64; MOST_DECIMALS as usize] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];
    let number = v / unit;
    let slack = ROUNDED * last / unit;
    (0..MOST_DECIMALS)
        .find(|&d| {
            let scale = POWERS[d as usize];
            (number * scale - (number * scale).round()).abs() <= slack * scale
        })
        .unwrap_or(MOST_DECIMALS)
}

/// What the other axes say of a way.
enum Share {
    /// No other axis moves enough.
    Unknown,
    /// The axes differ: the three rows are not on one straight way.
    Bent,
    /// The share, and how far rounding may put it off.
    Measured(f64, f64),
}

#[cfg(test)]
mod tests;
