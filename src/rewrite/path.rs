//! The stretch of path on which the engine works: vertices with their nominal and compensated joints, in flat storage
//! whose front is given back as soon as it has been emitted.

use super::Origin;

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

/// Vertices `start()..end()`, numbered over the whole program; a leg carries the number of its first vertex.
#[derive(Debug, Default)]
pub struct Path {
    axes: usize,
    first: usize,
    head: usize,
    q: Vec<f64>,
    c: Vec<f64>,
    origin: Vec<Origin>,
    t_s: Vec<f64>,
    turns: Vec<Turns>,
    knots: Vec<Vec<(usize, Knots)>>,
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
        self.q.extend_from_slice(q);
        self.c.extend_from_slice(q);
        self.t_s.push(t_s);
        self.origin.push(origin);
        self.turns.push(turns);
        self.knots.push(Vec::new());
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

    #[inline]
    pub fn t_s(&self, k: usize) -> f64 {
        self.t_s[self.at(k)]
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
        self.turns[self.at(k)]
    }

    /// Points to insert in the leg behind vertex `k`, per axis.
    pub fn knots(&self, k: usize) -> &[(usize, Knots)] {
        &self.knots[self.at(k)]
    }

    pub fn add_knots(&mut self, k: usize, axis: usize, knots: Knots) {
        let i = self.at(k);
        self.knots[i].push((axis, knots));
    }

    /// Gives back everything before vertex `k`.
    pub fn release(&mut self, k: usize) {
        self.head = k - self.first;
        const KEEP: usize = 4096;
        if self.head >= KEEP && self.head * 2 >= self.origin.len() {
            self.q.drain(..self.head * self.axes);
            self.c.drain(..self.head * self.axes);
            self.origin.drain(..self.head);
            self.t_s.drain(..self.head);
            self.turns.drain(..self.head);
            self.knots.drain(..self.head);
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
