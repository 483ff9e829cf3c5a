//! Running medians: of seven values, and of a long window that slides.

/// Rows of a burst window; denser logs are thinned for it.
const BURST_ROWS: usize = 41;

/// Median of the 7 values around each; at the ends of the series the nearest full window.
pub(super) fn median_of_7(r: &[f64]) -> Vec<f64> {
    if r.len() < 7 {
        return r.to_vec();
    }
    let inner: Vec<f64> = r
        .windows(7)
        .map(|w| {
            // a fixed network of minima and maxima that leaves the fourth of seven in place
            let mut v = [w[0], w[1], w[2], w[3], w[4], w[5], w[6]];
            for (a, b) in
                [(0, 5), (0, 3), (1, 6), (2, 4), (0, 1), (3, 5), (2, 6), (2, 3), (3, 6), (4, 5), (1, 4), (1, 3), (3, 4)]
            {
                let (x, y) = (v[a].min(v[b]), v[a].max(v[b]));
                (v[a], v[b]) = (x, y);
            }
            v[3]
        })
        .collect();
    let mut out = vec![inner[0]; 3];
    out.extend_from_slice(&inner);
    out.extend([inner[inner.len() - 1]; 3]);
    out
}

/// Marks values off the median of a long window, except where `quiet`.
pub(super) fn burst(smooth: &[f64], half: usize, limit: f64, off: &mut [bool], quiet: impl Fn(usize) -> bool) {
    let step = (2 * half / BURST_ROWS).max(1);
    let thin: Vec<f64> = smooth.iter().copied().step_by(step).collect();
    let reach = (half / step).max(1);
    let mut window = Sorted(Vec::with_capacity(2 * reach + 2));
    thin.iter().take(reach).for_each(|v| window.put(*v));
    for k in 0..thin.len() {
        // the window slides by one value: it stays sorted
        if let Some(v) = thin.get(k + reach) {
            window.put(*v);
        }
        if k > reach {
            window.take(thin[k - reach - 1]);
        }
        let Some(m) = window.middle() else { continue };
        for i in k * step..((k + 1) * step).min(smooth.len()) {
            if (smooth[i] - m).abs() > limit && !quiet(i) {
                off[i] = true;
            }
        }
    }
}

/// Values in order.
struct Sorted(Vec<f64>);

impl Sorted {
    fn place(&self, v: f64) -> usize {
        self.0.partition_point(|w| w.total_cmp(&v).is_lt())
    }

    fn put(&mut self, v: f64) {
        self.0.insert(self.place(v), v);
    }

    /// Takes out a value that was put in.
    fn take(&mut self, v: f64) {
        self.0.remove(self.place(v));
    }

    fn middle(&self) -> Option<f64> {
        let n = self.0.len();
        match n {
            0 => None,
            _ if n % 2 == 1 => Some(self.0[n / 2]),
            _ => Some(0.5 * (self.0[n / 2 - 1] + self.0[n / 2])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::robust::median_of;

    #[test]
    fn a_sliding_window_has_the_median_of_its_values() {
        let series: Vec<f64> = (0..300).map(|i| f64::from(i * i % 37) - 18.0).collect();
        for half in [1, 2, 7] {
            let mut window = Sorted(Vec::new());
            series.iter().take(half).for_each(|v| window.put(*v));
            for k in 0..series.len() {
                if let Some(v) = series.get(k + half) {
                    window.put(*v);
                }
                if k > half {
                    window.take(series[k - half - 1]);
                }
                let mut all = series[k.saturating_sub(half)..(k + half + 1).min(series.len())].to_vec();
                assert_eq!(window.middle(), median_of(&mut all), "at {k}, {half} on each side");
            }
        }
    }

    #[test]
    fn the_network_finds_the_median_of_seven() {
        let mut x = 12345u64;
        let mut next = || {
            x = x.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (x >> 40) as f64
        };
        let r: Vec<f64> = (0..5000).map(|_| next()).collect();
        let m = median_of_7(&r);
        for (i, w) in r.windows(7).enumerate() {
            let mut s = w.to_vec();
            s.sort_by(f64::total_cmp);
            assert_eq!(m[i + 3], s[3]);
        }
    }
}
