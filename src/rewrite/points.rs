//! Blocks of points, row-major, so that millions pass without an allocation each.

/// Program points that go in: joint vectors (rad or m) one after the other, times where the program has them.
#[derive(Debug, Clone, Default)]
pub struct Points {
    /// Number of axes: values per point.
    pub axes: usize,
    /// `q[row * axes + axis]`.
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
}

impl Points {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.q.len().checked_div(self.axes).unwrap_or(0)
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.q.is_empty()
    }

    /// Values of point `i`, rad or m, one per axis.
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
    Inserted {
        /// Number of the point before it.
        after: u64,
        /// Share of the way to the next point, 0 to 1.
        fraction: f64,
    },
}

impl Origin {
    /// The program point that it is, or after which it stands.
    pub fn point(self) -> u64 {
        match self {
            Self::Point(n) | Self::Inserted { after: n, .. } => n,
        }
    }
}

/// Points that come out. A value that was not touched is the very number that went in.
#[derive(Debug, Clone, Default)]
pub struct OutputPoints {
    /// Number of axes: values per point.
    pub axes: usize,
    /// Values of all points, one after the other, rad or m.
    pub q: Vec<f64>,
    /// Empty, or one per row, s.
    pub t_s: Vec<f64>,
    /// Where each point comes from.
    pub origin: Vec<Origin>,
}

impl OutputPoints {
    /// Room for so many points.
    pub fn reserve(&mut self, points: usize) {
        self.q.reserve(points * self.axes);
        self.t_s.reserve(points);
        self.origin.reserve(points);
    }

    /// Removes all points and keeps the memory.
    pub fn clear(&mut self) {
        self.q.clear();
        self.t_s.clear();
        self.origin.clear();
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.origin.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.origin.is_empty()
    }

    /// Values of point `i`, rad or m, one per axis.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.q[i * self.axes..(i + 1) * self.axes]
    }
}
