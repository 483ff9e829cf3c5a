//! How one clock stands to another.

/// How one clock stands to another: ahead by an offset that grows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Clock {
    /// Offset at the first row, s.
    pub offset_s: f64,
    /// By how much it runs faster, s per s.
    pub drift: f64,
}

impl Clock {
    /// Does it show the same time?
    pub fn is_right(&self) -> bool {
        self.offset_s == 0.0 && self.drift == 0.0
    }

    /// What it shows at `t_s` of a log that begins at `start_s`.
    pub fn at(&self, t_s: f64, start_s: f64) -> f64 {
        t_s + self.offset_s + self.drift * (t_s - start_s)
    }

    /// Both together.
    pub fn plus(&self, other: &Self) -> Self {
        Self { offset_s: self.offset_s + other.offset_s, drift: self.drift + other.drift }
    }

    /// What is between another clock and this one.
    pub fn minus(&self, other: &Self) -> Self {
        Self { offset_s: self.offset_s - other.offset_s, drift: self.drift - other.drift }
    }
}
