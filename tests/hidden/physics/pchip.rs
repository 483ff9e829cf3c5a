//! Monotone cubics through knots: gaps over position, and paths through the rows of a log.

/// Monotone cubic through knots (Fritsch and Carlson 1980, with scipy's end slopes), constant beyond them.
pub struct Pchip {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Pchip {
    pub fn new(knots: &[[f64; 2]]) -> Pchip {
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().map(|k| (k[0], k[1])).unzip();
        let n = x.len();
        let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let m: Vec<f64> = (0..n.saturating_sub(1)).map(|k| (y[k + 1] - y[k]) / h[k]).collect();
        let mut slope = vec![m.first().copied().unwrap_or(0.0); n];
        for k in 1..n.saturating_sub(1) {
            let (w1, w2) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
            slope[k] = if m[k - 1] * m[k] <= 0.0 { 0.0 } else { (w1 + w2) / (w1 / m[k - 1] + w2 / m[k]) };
        }
        if n > 2 {
            let end = |h0: f64, h1: f64, m0: f64, m1: f64| {
                let s = ((2.0 * h0 + h1) * m0 - h0 * m1) / (h0 + h1);
                match () {
                    () if s * m0 <= 0.0 => 0.0,
                    () if m0 * m1 <= 0.0 && s.abs() > 3.0 * m0.abs() => 3.0 * m0,
                    () => s,
                }
            };
            slope[0] = end(h[0], h[1], m[0], m[1]);
            slope[n - 1] = end(h[n - 2], h[n - 3], m[n - 2], m[n - 3]);
        }
        Pchip { x, y, slope }
    }

    /// Through rows of a log: slopes of the parabola through three rows, so that a course turns beyond its rows as the path
    /// did; none where the course rests on one side.
    pub fn through_rows(knots: &[[f64; 2]]) -> Pchip {
        let mut curve = Pchip::new(knots);
        let secant = |k: usize| (curve.y[k + 1] - curve.y[k]) / (curve.x[k + 1] - curve.x[k]);
        for k in 1..curve.x.len() - 1 {
            let (h0, h1) = (curve.x[k] - curve.x[k - 1], curve.x[k + 1] - curve.x[k]);
            let (m0, m1) = (secant(k - 1), secant(k));
            let rests = (m0 * h0).abs() < 3e-8 || (m1 * h1).abs() < 3e-8;
            let mut slope = if rests { 0.0 } else { (m0 * h1 + m1 * h0) / (h0 + h1) };
            // An interval that is run through in one direction must not turn within: that would be a separate reversal.
            for m in [m0, m1] {
                if slope * m > 0.0 {
                    slope = slope.signum() * slope.abs().min(3.0 * m.abs());
                }
            }
            curve.slope[k] = slope;
        }
        curve
    }

    pub fn at(&self, p: f64) -> f64 {
        let n = self.x.len();
        if p <= self.x[0] {
            return self.y[0];
        }
        if p >= self.x[n - 1] {
            return self.y[n - 1];
        }
        let k = self.x.partition_point(|x| *x <= p) - 1;
        let h = self.x[k + 1] - self.x[k];
        let u = (p - self.x[k]) / h;
        let (u2, u3) = (u * u, u * u * u);
        self.y[k] * (2. * u3 - 3. * u2 + 1.)
            + self.slope[k] * h * (u3 - 2. * u2 + u)
            + self.y[k + 1] * (3. * u2 - 2. * u3)
            + self.slope[k + 1] * h * (u3 - u2)
    }
}
