//! The stretch of path on which the engine works: vertices with their nominal and compensated joints, in flat storage
//! whose front is given back as soon as it has been emitted.

use super::Origin;
use crate::robot::Robot;
use nalgebra::Vector3;
use std::collections::VecDeque;

/// Knots of one axis inside a leg: `(share of the leg, compensated value)`, shares rising within 0 and 1.
pub type Knots = Vec<(f64, f64)>;

/// Axes that leave a vertex in a new direction: a bit each in `axes`, and in `up` where that direction is +1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Turns {
    pub axes: u64,
    pub up: u64,
}

impl Turns {
    pub fn add(&mut self, axis: usize, dir: i8) {
        self.axes |= 1 << axis;
        if dir > 0 {
            self.up |= 1 << axis;
        }
    }

    /// New direction of an axis, if it turns here.
    #[inline]
    pub fn of(&self, axis: usize) -> Option<i8> {
        if self.axes >> axis & 1 == 0 {
            None
        } else if self.up >> axis & 1 == 1 {
            Some(1)
        } else {
            Some(-1)
        }
    }
}

/// Vertices `start()..end()`, numbered over the whole program; a leg carries the number of its first vertex. Turns and
/// knots are rare, so they stand in separate lists, and long runs without any are moved in one piece.
#[derive(Debug, Default)]
pub struct Path {
    axes: usize,
    first: usize,
    head: usize,
    q: Vec<f64>,
    c: Vec<f64>,
    origin: Vec<Origin>,
    t_s: Vec<f64>,
    /// Nominal TCP where it was asked for; not a number elsewhere, and not there after the last that was.
    tcp_m: Vec<Vector3<f64>>,
    /// Offsets change on the leg that arrives here or on the one after.
    busy: Vec<bool>,
    turns: VecDeque<(usize, Turns)>,
    knots: VecDeque<(usize, usize, Knots)>,
    /// Joints of the given path at vertices that a refinement put in.
    given: VecDeque<(usize, Vec<f64>)>,
}

impl Path {
    pub fn new(axes: usize) -> Self {
        Self { axes, ..Self::default() }
    }

    pub fn start(&self) -> usize {
        self.first + self.head
    }

    pub fn end(&self) -> usize {
        self.first + self.origin.len()
    }

    #[inline]
    fn at(&self, k: usize) -> usize {
        k - self.first
    }

    /// Appends a vertex whose compensated joints are still its nominal ones.
    pub fn push(&mut self, q: &[f64], t_s: f64, origin: Origin, turns: Turns) {
        if turns.axes != 0 {
            self.turns.push_back((self.end(), turns));
        }
        self.extend(q, &[t_s], &[origin]);
    }

    /// Says where the given path stands at vertex `k`, which a refinement put in; `k` rises.
    pub fn set_given(&mut self, k: usize, q: Vec<f64>) {
        self.given.push_back((k, q));
    }

    /// The same, for vertices that have one.
    pub fn given(&self, k: usize) -> Option<&[f64]> {
        let i = self.given.partition_point(|g| g.0 < k);
        self.given.get(i).filter(|g| g.0 == k).map(|g| g.1.as_slice())
    }

    /// Appends vertices at which nothing turns.
    pub fn extend(&mut self, q: &[f64], t_s: &[f64], origin: &[Origin]) {
        self.q.extend_from_slice(q);
        self.c.extend_from_slice(q);
        self.t_s.extend_from_slice(t_s);
        self.origin.extend_from_slice(origin);
        self.busy.resize(self.origin.len(), false);
    }

    #[inline]
    pub fn q(&self, k: usize) -> &[f64] {
        let i = self.at(k) * self.axes;
        &self.q[i..i + self.axes]
    }

    #[inline]
    pub fn c(&self, k: usize) -> &[f64] {
        let i = self.at(k) * self.axes;
        &self.c[i..i + self.axes]
    }

    #[inline]
    pub fn c_mut(&mut self, k: usize) -> &mut [f64] {
        let i = self.at(k) * self.axes;
        &mut self.c[i..i + self.axes]
    }

    /// Adds a constant to one axis of the vertices `from..to`.
    pub fn shift(&mut self, axis: usize, from: usize, to: usize, by: f64) {
        let (a, b) = (self.at(from) * self.axes, self.at(to) * self.axes);
        for (c, q) in self.c[a..b].chunks_exact_mut(self.axes).zip(self.q[a..b].chunks_exact(self.axes)) {
            c[axis] = q[axis] + by;
        }
    }

    /// Compensated joints, times and origins of the vertices `from..to`.
    pub fn run(&self, from: usize, to: usize) -> (&[f64], &[f64], &[Origin]) {
        let (a, b) = (self.at(from), self.at(to));
        (&self.c[a * self.axes..b * self.axes], &self.t_s[a..b], &self.origin[a..b])
    }

    #[inline]
    pub fn t_s(&self, k: usize) -> f64 {
        self.t_s[self.at(k)]
    }

    /// Nominal TCP of a vertex; worked out once.
    pub fn tcp_m(&mut self, robot: &Robot, k: usize) -> Vector3<f64> {
        let at = self.at(k);
        if at >= self.tcp_m.len() {
            self.tcp_m.resize(at + 1, Vector3::repeat(f64::NAN));
        }
        if self.tcp_m[at].x.is_nan() {
            let mut q = self.q(k).to_vec();
            robot.from_gears(&mut q);
            self.tcp_m[at] = robot.tcp_m(&q);
        }
        self.tcp_m[at]
    }

    pub fn origin(&self, k: usize) -> Origin {
        self.origin[self.at(k)]
    }

    /// Place in the program: number of the point before, plus the share of the way to the next one.
    pub fn u(&self, k: usize) -> f64 {
        place(self.origin(k))
    }

    /// Axes that turn, or start to move, at this vertex.
    #[inline]
    pub fn turns(&self, k: usize) -> Turns {
        let i = self.turns.partition_point(|t| t.0 < k);
        self.turns.get(i).filter(|t| t.0 == k).map_or(Turns::default(), |t| t.1)
    }

    /// First vertex from `k` on at which an axis turns.
    pub fn next_turn(&self, k: usize) -> Option<usize> {
        self.turns.get(self.turns.partition_point(|t| t.0 < k)).map(|t| t.0)
    }

    /// Says that offsets change between the vertices `from..=to`.
    pub fn mark_busy(&mut self, from: usize, to: usize) {
        let (a, b) = (self.at(from), self.at(to));
        self.busy[a..=b].fill(true);
    }

    pub fn is_busy(&self, k: usize) -> bool {
        self.busy[self.at(k)]
    }

    /// First busy vertex from `k` on, at most `to`.
    pub fn next_busy(&self, k: usize, to: usize) -> usize {
        let (a, b) = (self.at(k), self.at(to));
        self.busy[a..b].iter().position(|b| *b).map_or(to, |i| k + i)
    }

    /// Points to insert in the leg after vertex `k`: axis and knots.
    pub fn knots(&self, k: usize) -> impl Iterator<Item = (usize, &Knots)> + Clone {
        let from = self.knots.partition_point(|x| x.0 < k);
        self.knots.range(from..).take_while(move |x| x.0 == k).map(|x| (x.1, &x.2))
    }

    pub fn add_knots(&mut self, k: usize, axis: usize, knots: Knots) {
        let i = self.knots.partition_point(|x| x.0 <= k);
        self.knots.insert(i, (k, axis, knots));
    }

    /// Gives back everything before vertex `k`.
    pub fn release(&mut self, k: usize) {
        self.head = k - self.first;
        while self.turns.front().is_some_and(|t| t.0 < k) {
            self.turns.pop_front();
        }
        while self.knots.front().is_some_and(|x| x.0 < k) {
            self.knots.pop_front();
        }
        while self.given.front().is_some_and(|g| g.0 < k) {
            self.given.pop_front();
        }
        const KEEP: usize = 4096;
        if self.head >= KEEP && self.head * 2 >= self.origin.len() {
            self.q.drain(..self.head * self.axes);
            self.c.drain(..self.head * self.axes);
            self.origin.drain(..self.head);
            self.t_s.drain(..self.head);
            self.tcp_m.drain(..self.head.min(self.tcp_m.len()));
            self.busy.drain(..self.head);
            self.first += self.head;
            self.head = 0;
        }
    }
}

/// Number of the point before a place, plus the share of the way to the next one.
pub fn place(origin: Origin) -> f64 {
    match origin {
        Origin::Point(i) => i as f64,
        Origin::Inserted { after, fraction } => after as f64 + fraction,
    }
}

/// Origin of a point at `share` of the leg between two vertices.
pub fn between(a: Origin, b: Origin, share: f64) -> Origin {
    let after = match a {
        Origin::Point(i) | Origin::Inserted { after: i, .. } => i,
    };
    let (u, v) = (place(a), place(b));
    Origin::Inserted { after, fraction: (u + share * (v - u) - after as f64).clamp(0.0, 1.0) }
}
