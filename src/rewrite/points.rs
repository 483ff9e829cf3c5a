//! Blocks of points, row-major, so that millions pass without an allocation each.

/// Program points that go in: joint vectors (rad or m) one after the other, times where the program has them.
#[derive(Debug, Clone, Default)]
pub struct Points {
    pub axes: usize,
    /// `q[row * axes + axis]`.
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
}

impl Points {
    pub fn len(&self) -> usize {
        self.q.len().checked_div(self.axes).unwrap_or(0)
    }

    pub fn is_empty(&self) -> bool {
        self.q.is_empty()
    }

    pub fn row(&self, i: usize) -> &[f64] {
        &self.q[i * self.axes..(i + 1) * self.axes]
    }
}

/// Where a point that comes out stems from; program points count from 0 over the whole program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// The program's own point, in order.
    Point(u64),
    /// A new point on the segment that starts at program point `after`, at this share of it (0 to 1).
    Inserted { after: u64, fraction: f64 },
}

/// Points that come out. A value that was not touched is the very number that went in.
#[derive(Debug, Clone, Default)]
pub struct OutputPoints {
    pub axes: usize,
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
    pub origin: Vec<Origin>,
}

impl OutputPoints {
    /// Room for so many points.
    pub fn reserve(&mut self, points: usize) {
        self.q.reserve(points * self.axes);
        self.t_s.reserve(points);
        self.origin.reserve(points);
    }

    pub fn clear(&mut self) {
        self.q.clear();
        self.t_s.clear();
        self.origin.clear();
    }

    pub fn len(&self) -> usize {
        self.origin.len()
    }

    pub fn is_empty(&self) -> bool {
        self.origin.is_empty()
    }

    pub fn row(&self, i: usize) -> &[f64] {
        &self.q[i * self.axes..(i + 1) * self.axes]
    }
}
