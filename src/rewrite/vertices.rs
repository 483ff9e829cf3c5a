//! A short memory of path points on their way in: joints, time, origin, numbered over the whole program.

use super::Origin;

/// The last points that came in.
#[derive(Debug, Default)]
pub struct Vertices {
    axes: usize,
    first: usize,
    q: Vec<f64>,
    t_s: Vec<f64>,
    origin: Vec<Origin>,
}

impl Vertices {
    pub fn new(axes: usize) -> Self {
        Self { axes, ..Self::default() }
    }

    pub fn push(&mut self, q: &[f64], t_s: f64, origin: Origin) {
        self.q.extend_from_slice(q);
        self.t_s.push(t_s);
        self.origin.push(origin);
    }

    /// Number behind the last point.
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
        }
    }
}
