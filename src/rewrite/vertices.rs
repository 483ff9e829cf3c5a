//! A short memory of path points on their way in: joints, time, origin, numbered over the whole program.

use super::Origin;
use std::collections::VecDeque;

/// The last points that came in.
#[derive(Debug, Default)]
pub struct Vertices {
    axes: usize,
    first: usize,
    q: Vec<f64>,
    t_s: Vec<f64>,
    origin: Vec<Origin>,
    /// Where the given path stands at points of a refined one.
    given: VecDeque<(usize, Vec<f64>)>,
}

impl Vertices {
    pub fn new(axes: usize) -> Self {
        Self { axes, ..Self::default() }
    }

    /// Takes a block of the program's own points; `t_s` may be empty.
    pub fn extend(&mut self, q: &[f64], t_s: &[f64], first: u64) {
        let n = q.len() / self.axes.max(1);
        self.q.extend_from_slice(q);
        if t_s.is_empty() {
            self.t_s.resize(self.t_s.len() + n, 0.0);
        } else {
            self.t_s.extend_from_slice(t_s);
        }
        self.origin.extend((first..first + n as u64).map(Origin::Point));
    }

    pub fn push(&mut self, q: &[f64], t_s: f64, origin: Origin) {
        self.q.extend_from_slice(q);
        self.t_s.push(t_s);
        self.origin.push(origin);
    }

    /// Says where the given path stands at the last point, which is one of a refined path.
    pub fn set_given(&mut self, q: Vec<f64>) {
        self.given.push_back((self.end().saturating_sub(1), q));
    }

    /// Joints of the given path at point `i`.
    pub fn given(&self, i: usize) -> &[f64] {
        let k = self.given.partition_point(|g| g.0 < i);
        self.given.get(k).filter(|g| g.0 == i).map_or_else(|| self.q(i), |g| &g.1)
    }

    /// Points of the refined path among `from..to`, with the joints of the given one.
    pub fn given_in(&self, from: usize, to: usize) -> impl Iterator<Item = (usize, &Vec<f64>)> {
        let range = self.given.partition_point(|g| g.0 < from)..self.given.partition_point(|g| g.0 < to);
        self.given.range(range).map(|g| (g.0, &g.1))
    }

    /// Number after the last point.
    #[inline]
    pub fn end(&self) -> usize {
        self.first + self.origin.len()
    }

    #[inline]
    pub fn q(&self, i: usize) -> &[f64] {
        let at = (i - self.first) * self.axes;
        &self.q[at..at + self.axes]
    }

    pub fn t_s(&self, i: usize) -> f64 {
        self.t_s[i - self.first]
    }

    pub fn origin(&self, i: usize) -> Origin {
        self.origin[i - self.first]
    }

    /// Joints, times and origins of the points `from..to`.
    pub fn run(&self, from: usize, to: usize) -> (&[f64], &[f64], &[Origin]) {
        let (a, b) = (from - self.first, to - self.first);
        (&self.q[a * self.axes..b * self.axes], &self.t_s[a..b], &self.origin[a..b])
    }

    /// Number of the oldest point that is still held.
    pub fn start(&self) -> usize {
        self.first
    }

    /// Forgets points before `i`, now and then.
    pub fn forget(&mut self, i: usize) {
        let n = i.saturating_sub(self.first);
        if n >= 4096 {
            self.q.drain(..n * self.axes);
            self.t_s.drain(..n);
            self.origin.drain(..n);
            self.first += n;
            while self.given.front().is_some_and(|g| g.0 < self.first) {
                self.given.pop_front();
            }
        }
    }
}
