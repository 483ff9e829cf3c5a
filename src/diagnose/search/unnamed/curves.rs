//! Which curves are tried: of every joint over position, direction, speed, acceleration and torque, with few knots and with many; of
//! joints and TCP over time where several logs can say that it comes back.

use crate::diagnose::candidates;
use crate::diagnose::candidates::basis::Aspect;
use crate::diagnose::candidates::structure::Ratio;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::recording::Recording;
use crate::effects::candidate::{Candidate, Survey, TRIAL};
use crate::effects::empirical::{Over, Times};
use crate::effects::{Effect, Empirical, Inputs, JointZeroOffset, Target, TimeOffset};
use nalgebra::Vector3;
use std::ops::Range;

/// Counts of knots over position: a notch needs many.
const POSITION: [usize; 5] = [4, 7, 12, 20, 32];
/// Over position times direction, and over torque.
const COARSE: [usize; 2] = [4, 7];
/// Over speed; denser about standstill.
const SPEED: [usize; 3] = [5, 9, 15];
const ACCELERATION: [usize; 2] = [3, 5];
/// Over the time since the start of a log.
const TIME: [usize; 3] = [3, 5, 9];
/// Over position times that of another joint.
const CROSSED: [usize; 2] = [2, 4];
/// How much denser knots of speed are about standstill than at the ends: the argument of a hyperbolic sine.
const DENSER: f64 = 4.0;
/// Values up to which they are tried: they are many.
const FEW_VALUES: usize = 20_000;
/// Trial of a vector at the TCP, m.
const TRIAL_M: f64 = 1e-5;

/// Two parts of the data: ranges of the long vector.
pub type Halves = [Vec<Range<usize>>; 2];

/// A half holds at least one value of so many, or it says nothing.
const LEAST_HALF: usize = 10;

/// The data parted by what holds for a row of a log.
fn halves(problem: &Problem, first: impl Fn(usize, usize) -> bool) -> Halves {
    let mut parts: Halves = [Vec::new(), Vec::new()];
    for g in &problem.groups {
        let n = g.len();
        let mut from = 0;
        for b in 0..n {
            let side = first(g.log, g.middle(b));
            if b + 1 == n || first(g.log, g.middle(b + 1)) != side {
                for c in 0..g.dims {
                    let start = g.offset + c * n;
                    parts[usize::from(!side)].push(start + from..start + b + 1);
                }
                from = b + 1;
            }
        }
    }
    parts
}

/// Every second log in either half.
fn by_log(problem: &Problem) -> Halves {
    halves(problem, |l, _| l % 2 == 0)
}

/// Does a half of the data say enough?
fn says_enough(problem: &Problem, half: &[Range<usize>]) -> bool {
    half.iter().map(ExactSizeIterator::len).sum::<usize>() * LEAST_HALF > problem.n
}

/// Length of the longest log in s, where every half of the logs can say that what follows the time comes back.
fn length_s(problem: &Problem) -> Option<f64> {
    if problem.logs.iter().any(|l| l.log.poses) || !by_log(problem).iter().all(|h| says_enough(problem, h)) {
        return None;
    }
    candidates::clock(problem).map(|(_, length_s)| length_s)
}

/// Curves of one kind on one target, from few knots to many.
pub struct Family {
    pub target: Target,
    pub over: Over,
    times: Times,
    /// Of the TCP: the joint whose position is the argument.
    of: Option<usize>,
    /// Places of the knots, SI.
    grids: Vec<Vec<f64>>,
}

impl Family {
    fn of_joint(axis: usize, over: Over, times: Times, grids: Vec<Vec<f64>>) -> Self {
        Self { target: Target::Joint(axis), over, times, of: None, grids }
    }

    /// Does it depend on what a test without the catalogue found?
    pub fn goes_with(&self, found: &Ratio) -> bool {
        let of = self.target.axis().or(self.of);
        let aspect = match (self.over, self.times) {
            (Over::Position, Times::Direction) | (Over::Direction, _) => {
                matches!(found.aspect, Some(Aspect::Direction | Aspect::SinceReversal))
            }
            (Over::Position, _) => found.aspect == Some(Aspect::Position),
            (Over::Torque, _) => matches!(found.aspect, Some(Aspect::Position | Aspect::Torque)),
            (Over::Speed, _) => found.aspect == Some(Aspect::Speed),
            (Over::Acceleration, _) => found.aspect == Some(Aspect::Acceleration),
            (Over::Time, _) => found.aspect == Some(Aspect::Time),
        };
        aspect && found.axis == of
    }

    /// Halves of the data on which a curve of this kind must be the same: of the time of each log, and of what it does not depend on.
    pub fn halves(&self, problem: &Problem) -> Vec<Halves> {
        if self.over == Over::Time {
            return vec![by_log(problem)];
        }
        let mut all = vec![halves(problem, |l, row| 2 * row < problem.logs[l].trajectory.rows())];
        let Some(axis) = self.target.axis().or(self.of) else { return all };
        let log = |l: usize| &problem.logs[l].trajectory;
        let by_direction =
            matches!((self.over, self.times), (Over::Position | Over::Torque, Times::One | Times::Position(_)));
        if by_direction {
            all.push(halves(problem, |l, row| log(l).direction(axis).get(row).is_some_and(|d| *d > 0.0)));
        } else {
            let mut p: Vec<f64> = (0..problem.logs.len()).flat_map(|l| log(l).command(axis).iter().copied()).collect();
            p.sort_by(f64::total_cmp);
            let middle = p.get(p.len() / 2).copied().unwrap_or(0.0);
            all.push(halves(problem, |l, row| log(l).command(axis)[row] > middle));
        }
        all.retain(|h| h.iter().all(|half| says_enough(problem, half)));
        all
    }

    /// One trial for each number of knots.
    pub fn trials(&self, problem: &Problem) -> Vec<Candidate> {
        let robot = &problem.robot;
        let (over, times, of) = (self.over, self.times, self.of);
        let trial = |x: &Vec<f64>| {
            let places = x.clone();
            if self.target == Target::Tcp {
                let make = move |v: &[f64]| {
                    let vector = |c: &[f64]| Vector3::new(c[0], c[1], c[2]);
                    let knots: Vec<_> = places.iter().zip(v.chunks_exact(3)).map(|(x, c)| (*x, vector(c))).collect();
                    // rising by their making
                    Empirical::of_tcp(over, of, &knots).map_or_else(|| TimeOffset::by(0.0).into(), Effect::new)
                };
                return Candidate::of_sizes(robot, Target::Tcp, &vec![TRIAL_M; 3 * x.len()], make);
            }
            let make = move |v: &[f64]| {
                let knots: Vec<[f64; 2]> = places.iter().zip(v).map(|(x, v)| [*x, *v]).collect();
                Empirical::of_joint(over, times, &knots)
                    .map_or_else(|| JointZeroOffset { offset: 0.0 }.into(), Effect::new)
            };
            Candidate::of_sizes(robot, self.target, &vec![TRIAL; x.len()], make)
        };
        self.grids.iter().map(trial).collect()
    }
}

/// `n` places from `lo` to `hi`.
fn spread(lo: f64, hi: f64, n: usize) -> Vec<f64> {
    (0..n).map(|k| lo + (hi - lo) * k as f64 / (n - 1) as f64).collect()
}

/// `n` places from `-most` to `most`, denser about zero.
fn about_zero(most: f64, n: usize) -> Vec<f64> {
    spread(-DENSER, DENSER, n).into_iter().map(|u| most * u.sinh() / DENSER.sinh()).collect()
}

/// Every kind of curve on every target that moves. What depends on several joints at once, only of poses: a path has too few of
/// their combinations to say what holds on another one.
pub fn families(problem: &Problem) -> Vec<Family> {
    let survey = candidates::survey(problem);
    let poses = problem.recording() == Recording::SettledPoses && problem.n <= FEW_VALUES;
    let mut list = Vec::new();
    let moving: Vec<usize> = survey.moving().collect();
    // runs of one program measured by joint sensors: time is position by another name
    let length_s = length_s(problem).filter(|_| survey.points);
    let over_time = length_s.map(|s| TIME.map(|n| spread(0.0, s, n)).to_vec());
    if let Some(grids) = over_time.clone() {
        list.push(Family { target: Target::Tcp, over: Over::Time, times: Times::One, of: None, grids });
    }
    for &axis in &moving {
        of_axis(problem, &survey, axis, &mut list);
        let grids = over_time.clone();
        list.extend(grids.map(|grids| Family::of_joint(axis, Over::Time, Times::One, grids)));
        let [lo, hi] = survey.axes[axis].range;
        for &other in moving.iter().filter(|&&o| poses && o != axis) {
            let grids = CROSSED.map(|n| spread(lo, hi, n)).to_vec();
            list.push(Family::of_joint(axis, Over::Position, Times::Position(other), grids));
        }
        if survey.points && poses {
            let grids = COARSE.map(|n| spread(lo, hi, n)).to_vec();
            list.push(Family { target: Target::Tcp, over: Over::Position, times: Times::One, of: Some(axis), grids });
        }
    }
    list
}

fn of_axis(problem: &Problem, survey: &Survey, axis: usize, list: &mut Vec<Family>) {
    let a = &survey.axes[axis];
    let [lo, hi] = a.range;
    let mut add = |over, times, grids| list.push(Family::of_joint(axis, over, times, grids));
    add(Over::Position, Times::One, POSITION.map(|n| spread(lo, hi, n)).to_vec());
    add(Over::Position, Times::Direction, COARSE.map(|n| spread(lo, hi, n)).to_vec());
    add(Over::Direction, Times::One, vec![vec![-1.0, 1.0]]);
    if a.torque[1] > a.torque[0] {
        add(Over::Torque, Times::One, COARSE.map(|n| spread(a.torque[0], a.torque[1], n)).to_vec());
    }
    if a.fastest > 0.0 && survey.motion {
        add(Over::Speed, Times::One, SPEED.map(|n| about_zero(a.fastest, n)).to_vec());
        let most = largest_acceleration(problem, axis);
        if most > 0.0 {
            add(Over::Acceleration, Times::One, ACCELERATION.map(|n| spread(-most, most, n)).to_vec());
        }
    }
}

/// Largest acceleration of the commands of an axis between rows, but for the fastest hundredth.
fn largest_acceleration(problem: &Problem, axis: usize) -> f64 {
    let mut all: Vec<f64> = Vec::new();
    for log in problem.motions().filter(|l| l.trajectory.rows() > 2) {
        let t = log.trajectory.t_s();
        let p = log.trajectory.command(axis);
        let of = |k: usize| {
            let (a, b) = ((p[k] - p[k - 1]) / (t[k] - t[k - 1]), (p[k + 1] - p[k]) / (t[k + 1] - t[k]));
            2.0 * (b - a).abs() / (t[k + 1] - t[k - 1])
        };
        all.extend((1..t.len().min(p.len()).saturating_sub(1)).map(of).filter(|v| v.is_finite()));
    }
    all.sort_by(f64::total_cmp);
    all.get(all.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_of_speed_are_denser_about_standstill() {
        let x = about_zero(2.0, 5);
        assert_eq!((x[0], x[2], x[4]), (-2.0, 0.0, 2.0));
        assert!(x[3] - x[2] < 0.2 * (x[4] - x[3]), "{x:?}");
    }
}
