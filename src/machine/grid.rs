//! All points of a program and all rows of its log, in the order of time.

/// The merged times of points and rows.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Times of the grid, s, increasing.
    pub t_s: Vec<f64>,
    /// Program point at or before each grid time; its segment.
    segment: Vec<u32>,
    /// Grid index of each row.
    pub keep: Vec<u32>,
    /// Rows of the requested program points, and whether each stands there for its point alone.
    pub points: Vec<(usize, bool)>,
}

impl Grid {
    /// Rows at `rate_hz` from the first point, and at the program points `at` (increasing).
    pub fn new(points_t_s: &[f64], rows: usize, rate_hz: f64, at: &[usize]) -> Self {
        let n = points_t_s.len() + rows;
        let mut grid = Self {
            t_s: Vec::with_capacity(n),
            segment: Vec::with_capacity(n),
            keep: Vec::with_capacity(rows + at.len()),
            points: Vec::with_capacity(at.len()),
        };
        let first = points_t_s[0];
        let row_time = |k: usize| first + k as f64 / rate_hz;
        let mut row = 0;
        for (i, &t) in points_t_s.iter().enumerate() {
            while row < rows && row_time(row) < t {
                grid.keep.push(grid.t_s.len() as u32);
                grid.t_s.push(row_time(row));
                grid.segment.push(i.saturating_sub(1) as u32);
                row += 1;
            }
            while row < rows && row_time(row) == t {
                grid.keep.push(grid.t_s.len() as u32);
                row += 1;
            }
            if at.binary_search(&i).is_ok() {
                let own = grid.keep.last() != Some(&(grid.t_s.len() as u32));
                if own {
                    grid.keep.push(grid.t_s.len() as u32);
                }
                grid.points.push((grid.keep.len() - 1, own));
            }
            grid.t_s.push(t);
            grid.segment.push(i as u32);
        }
        // a last row that rounding puts after the last point stands on it
        while row < rows {
            grid.keep.push(grid.t_s.len() as u32 - 1);
            row += 1;
        }
        grid
    }

    /// A command over the grid, linear between points.
    pub fn interpolate(&self, points_t_s: &[f64], q: &[f64]) -> Vec<f64> {
        let at = |(&t, &segment): (&f64, &u32)| {
            let i = segment as usize;
            let (t0, q0) = (points_t_s[i], q[i]);
            match q.get(i + 1) {
                Some(&q1) if t > t0 => q0 + (q1 - q0) * ((t - t0) / (points_t_s[i + 1] - t0)),
                _ => q0,
            }
        };
        self.t_s.iter().zip(&self.segment).map(at).collect()
    }
}
