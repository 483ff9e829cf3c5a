//! The time of a move, shared out over its legs.

/// Time of a move shared out over the legs to its new points and to its goal, in proportion to their shares of the way. A leg of
/// next to no length (a new point at the very start) gets a fiftieth of an even part, and none less than `least`; the sum is `total`.
/// `None`: so many legs of `least` do not fit.
pub fn share_out(total: f64, shares: &[f64], least: f64) -> Option<Vec<f64>> {
    const FLOOR: f64 = 0.02;
    let n = shares.len() + 1;
    let ends = shares.iter().copied().chain([1.0]);
    let mut before = 0.0;
    let mut legs: Vec<f64> = ends
        .map(|s| {
            let leg = if s.is_finite() { (s - before).max(0.0) } else { 0.0 };
            before = s.max(before);
            leg.max(FLOOR / n as f64)
        })
        .collect();
    let sum: f64 = legs.iter().sum();
    legs.iter_mut().for_each(|l| *l *= total / sum);
    let spare = total - least * n as f64;
    if spare.is_nan() || spare < 0.0 {
        return None;
    }
    // what short legs lack is taken from the others, in proportion to what these have above the least
    let lack: f64 = legs.iter().map(|l| (least - l).max(0.0)).sum();
    let rich: f64 = legs.iter().map(|l| (l - least).max(0.0)).sum();
    if lack > 0.0 {
        let keep = if rich > 0.0 { 1.0 - lack / rich } else { 0.0 };
        legs.iter_mut().for_each(|l| *l = least + (*l - least).max(0.0) * keep);
    }
    Some(legs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_shared_out_in_proportion_and_its_sum_stays() {
        assert_eq!(share_out(2.0, &[0.25], 0.0).unwrap(), [0.5, 1.5]);
        let legs = share_out(1.0, &[0.0, 0.5], 0.1).unwrap();
        assert!((legs.iter().sum::<f64>() - 1.0).abs() < 1e-12 && legs.iter().all(|l| *l >= 0.1 - 1e-12), "{legs:?}");
        assert_eq!(share_out(0.1, &[0.5], 0.06), None);
    }
}
