//! Estimates that a few gross errors cannot move.

use nalgebra::Vector3;

/// Standard deviation of a normal distribution over its median absolute deviation.
pub const SIGMA_PER_MAD: f64 = 1.482_602_218_505_602;

/// Least and largest of values; infinite, the first above the second, of nothing. NaN does not count.
///
/// ```
/// use lostmotion_numerics::robust::range;
/// assert_eq!(range([2.0, -1.0, 5.0]), [-1.0, 5.0]);
/// ```
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
}

/// Distance between the least and the largest of values; 0 of nothing.
pub fn spread(values: impl IntoIterator<Item = f64>) -> f64 {
    let [lo, hi] = range(values);
    if hi > lo { hi - lo } else { 0.0 }
}

/// Largest size of values; 0 of nothing. NaN does not count.
pub fn largest_size(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Median, the middle of two for an even count; `None` of nothing. Sorts in place.
pub fn median_of(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(values[n / 2]),
        _ => Some(0.5 * (values[n / 2 - 1] + values[n / 2])),
    }
}

/// Median of values in their order; 0 of nothing.
pub fn median(values: &[f64]) -> f64 {
    median_of(&mut values.to_vec()).unwrap_or(0.0)
}

/// Quantile `share` (0 to 1) of values in rising order, linear between two neighbours (type 7 of Hyndman and Fan 1996). `None` of nothing.
///
/// ```
/// use lostmotion_numerics::robust::quantile_of_sorted;
/// assert_eq!(quantile_of_sorted(&[1.0, 2.0, 4.0, 8.0], 0.5), Some(3.0));
/// ```
pub fn quantile_of_sorted(sorted: &[f64], share: f64) -> Option<f64> {
    let at = share * (sorted.len().checked_sub(1)?) as f64;
    let (low, high) = (*sorted.get(at.floor() as usize)?, *sorted.get(at.ceil() as usize)?);
    Some(low + (high - low) * at.fract())
}

/// Quantile `share` (0 to 1) of values in any order, the lower of two neighbours (type 1 of Hyndman and Fan 1996, but for its rounding):
/// always one of the values, and linear in time. NaN of nothing.
pub fn lower_quantile(values: &[f64], share: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let mut v = values.to_vec();
    let k = ((v.len() - 1) as f64 * share) as usize;
    *v.select_nth_unstable_by(k, f64::total_cmp).1
}

/// Median of the intervals between instants, s; `None` of fewer than two.
pub fn median_interval(t_s: &[f64]) -> Option<f64> {
    median_of(&mut t_s.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>())
}

/// Mean of points without gross errors, how many were used, and the sum of their squared distances from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMean {
    /// Mean of the points that were used.
    pub mean: Vector3<f64>,
    /// How many points were used.
    pub used: usize,
    /// Sum of their squared distances from the mean.
    pub sum_squares: f64,
}

/// Distances beyond this many standard deviations are gross errors: a normal sample of 1e4 points loses none at 6.
const GROSS: f64 = 6.0;
/// Median of a distance in three dimensions, in standard deviations of one coordinate.
pub const MEDIAN_DISTANCE: f64 = 1.538_172_254_455_05;

/// Mean of the points that lie within six standard deviations of their median, the deviation taken from the median
/// distance and at least `floor_m` (the last digit of the data). Of clean data it is the plain mean: nothing is lost.
pub fn point_mean(points: &[Vector3<f64>], floor_m: f64) -> Option<PointMean> {
    if points.is_empty() {
        return None;
    }
    let mut kept: Vec<Vector3<f64>> = points.to_vec();
    if points.len() > 3 {
        let coordinate = |k: usize| median(&points.iter().map(|p| p[k]).collect::<Vec<_>>());
        let centre = Vector3::new(coordinate(0), coordinate(1), coordinate(2));
        let mut distances: Vec<f64> = points.iter().map(|p| (p - centre).norm()).collect();
        let sigma = median_of(&mut distances).unwrap_or(0.0) / MEDIAN_DISTANCE;
        kept.retain(|p| (p - centre).norm() <= GROSS * sigma.max(floor_m));
        if kept.len() < 2 {
            kept = points.to_vec();
        }
    }
    let mean = kept.iter().sum::<Vector3<f64>>() / kept.len() as f64;
    Some(PointMean { mean, used: kept.len(), sum_squares: kept.iter().map(|p| (p - mean).norm_squared()).sum() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_the_middle_of_two() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&[]), 0.0);
    }

    #[test]
    fn a_reflection_off_a_wall_does_not_move_the_mean_of_a_dwell() {
        let mut points: Vec<Vector3<f64>> =
            (0..20).map(|i| Vector3::new(1e-6 * f64::from(i % 5), -1e-6 * f64::from(i % 3), 0.0)).collect();
        let clean = point_mean(&points, 1e-7).unwrap();
        assert_eq!(clean.used, 20);
        points.push(Vector3::new(3.0, 1.0, -2.0));
        let with = point_mean(&points, 1e-7).unwrap();
        assert_eq!(with.used, 20);
        assert!((with.mean - clean.mean).norm() < 1e-15);
    }
}
