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
        }
    }
}
