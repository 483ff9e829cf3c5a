//! A clock that steps during the recordings: seen in what the fit leaves, over time.
//!
//! Method: one more unknown is added to the linearised fit, an offset of the clock from some time on; of 64 times the one that explains
//! most of what is left is taken. Each joint may also have its own lag: of joints that move one after another lags would look like
//! steps. Everything else is solved for along with it, so that what a drift or a frame can explain is no step.
//!
//! Readings that the fit left out are looked at as well, as after a late step these are all that follow it; those that no step of a
//! clock explains stay out.
//!
//! How it fails: of a clock that wanders, or steps several times, the best single step is found.

use super::placement::{COMMON, Row};
use nalgebra::{DMatrix, DVector, Vector3};

/// Parts of the recording at whose ends a step is tried.
const PARTS: usize = 64;
/// Longest step, s, whose readings are looked at although the fit left them out.
const LONGEST_S: f64 = 0.5;
/// Those are looked at where they are so many at least, and one of so many readings: fewer are gross errors.
const FEWEST: usize = 50;
/// See [`FEWEST`].
const ONE_OF: usize = 50;
/// Shortest step that is one, s: shorter ones are the business of jitter.
const SHORTEST_S: f64 = 3e-4;
/// Share of what is left that makes a step worth a note, and the share from which on it is certain.
pub const SEEN: f64 = 0.2;
/// See [`SEEN`].
pub const CERTAIN: f64 = 0.5;
/// Columns are kept apart by this share of their length.
const RIDGE: f64 = 1e-9;
/// A step that the other unknowns explain to this share is not determined.
const OPEN: f64 = 1e-4;

/// The step that explains most of what the fit leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Tracker's time at which it happens, s.
    pub at_s: f64,
    /// By how much the offset of the clocks rises there, s.
    pub by_s: f64,
    /// Share of the sum of squares that it explains.
    pub share: f64,
}

/// A linearised reading.
pub(super) struct Reading {
    /// Tracker's time, s.
    pub t_s: f64,
    pub row: Row,
    /// Speed of each joint's command, rad/s or m/s.
    pub rate: Vec<f64>,
    /// The fit used it.
    pub kept: bool,
}

impl Reading {
    /// Whether a step of the clock can explain that the fit left it out.
    fn is_late(&self) -> bool {
        self.row.columns.first().is_some_and(|velocity| self.row.residual.norm() <= LONGEST_S * velocity.norm())
    }

    /// Columns of the fit, and a lag of each joint.
    fn columns(&self) -> Vec<Vector3<f64>> {
        let lags =
            self.rate.iter().enumerate().filter_map(|(axis, rate)| Some(self.row.columns.get(COMMON + axis)? * *rate));
        self.row.columns.iter().copied().chain(lags).collect()
    }
}

/// The step of the clock that explains most, among the readings that the fit used or among all that a step can explain; `None`: none
/// explains a share worth a note.
pub(super) fn find(readings: &[Reading]) -> Option<Step> {
    let used = best(readings.iter().filter(|r| r.kept).collect());
    let late = readings.iter().filter(|r| !r.kept && r.is_late()).count();
    let all = (late >= FEWEST.max(readings.len() / ONE_OF))
        .then(|| best(readings.iter().filter(|r| r.kept || r.is_late()).collect()))
        .flatten();
    let found = used.into_iter().chain(all).max_by(|a, b| a.share.total_cmp(&b.share))?;
    (found.share >= SEEN && found.by_s.abs() >= SHORTEST_S).then_some(found)
}

/// Normal equations of the readings of a part, as far as a step needs them.
struct Part {
    /// Products of the offset's column with all columns and with the residual.
    by_column: DVector<f64>,
    by_residual: f64,
    from_s: f64,
}

fn best(readings: Vec<&Reading>) -> Option<Step> {
    let size = readings.first()?.columns().len();
    let (mut normal, mut right, mut squares) = (DMatrix::zeros(size, size), DVector::zeros(size), 0.0);
    let mut parts: Vec<Part> = Vec::with_capacity(PARTS);
    for part in readings.chunks(readings.len().div_ceil(PARTS)) {
        let mut a = DMatrix::zeros(3 * part.len(), size);
        let mut b = DVector::zeros(3 * part.len());
        for (i, reading) in part.iter().enumerate() {
            for (k, column) in reading.columns().iter().enumerate() {
                a.fixed_view_mut::<3, 1>(3 * i, k).copy_from(column);
            }
            b.fixed_rows_mut::<3>(3 * i).copy_from(&reading.row.residual);
        }
        let own = a.transpose() * &a;
        let own_right = a.transpose() * &b;
        parts.push(Part {
            by_column: own.column(0).into_owned(),
            by_residual: own_right[0],
            from_s: part.first()?.t_s,
        });
        normal += own;
        right += own_right;
        squares += b.norm_squared();
    }
    let scale: Vec<f64> =
        (0..size).map(|k| if normal[(k, k)] > 0.0 { normal[(k, k)].sqrt().recip() } else { 0.0 }).collect();
    let scaled = |v: &DVector<f64>| DVector::from_fn(size, |k, _| v[k] * scale[k]);
    let mut correlation = DMatrix::from_fn(size, size, |i, k| normal[(i, k)] * scale[i] * scale[k]);
    for k in 0..size {
        correlation[(k, k)] += if scale[k] > 0.0 { RIDGE } else { 1.0 };
    }
    let solved = correlation.cholesky()?;
    let right = scaled(&right);
    let of_right = solved.solve(&right);
    let left = squares - right.dot(&of_right);
    let (mut by_column, mut by_residual) = (DVector::zeros(size), 0.0);
    let mut found: Option<Step> = None;
    // the later parts together, from the last one on
    for part in parts.iter().skip(1).rev() {
        by_column += &part.by_column;
        by_residual += part.by_residual;
        let column = scaled(&by_column);
        let own = by_column[0] - column.dot(&solved.solve(&column));
        if own <= OPEN * by_column[0] || left <= 0.0 {
            continue;
        }
        let by_s = (by_residual - column.dot(&of_right)) / own;
        let share = by_s * by_s * own / left;
        if found.is_none_or(|f| share > f.share) {
            found = Some(Step { at_s: part.from_s, by_s, share });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two joints that swing in a plane: offset, drift, shift and a zero offset of each joint; what is left is noise and `late`.
    fn readings(late: impl Fn(f64, usize) -> f64) -> Vec<Reading> {
        let noise = |k: usize| 1e-5 * (((k * 7919) % 1009) as f64 / 504.0 - 1.0);
        let row = |k: usize| {
            let t = 0.02 * k as f64;
            let rate = [0.3 * (0.9 * t).cos(), 0.2 * (0.53 * t).sin()];
            let levers = [Vector3::new(0.0, 1.0, 0.2 * t.sin()), Vector3::new(0.7, 0.0, 0.1)];
            let velocity = levers[0] * rate[0] + levers[1] * rate[1];
            let mut columns = vec![velocity, velocity * (t - 20.0)];
            columns.extend([Vector3::zeros(); 3]);
            columns.extend([Vector3::x(), Vector3::y(), Vector3::z()]);
            columns.extend([Vector3::zeros(); 3]);
            columns.extend(levers);
            let noise = Vector3::new(noise(3 * k), noise(3 * k + 1), noise(3 * k + 2));
            let residual = levers[0] * rate[0] * late(t, 0) + levers[1] * rate[1] * late(t, 1) + noise;
            Reading { t_s: t, row: Row { residual, columns }, rate: rate.into(), kept: true }
        };
        (0..2000).map(row).collect()
    }

    #[test]
    fn a_step_is_found_with_its_time_and_size_and_noise_drift_and_lags_are_none() {
        let found = find(&readings(|t, _| if t > 15.0 { 0.02 } else { 0.0 })).unwrap();
        assert!((found.at_s - 15.0).abs() < 1.0 && (found.by_s - 0.02).abs() < 2e-3, "{found:?}");
        assert!(found.share > CERTAIN, "{found:?}");
        assert_eq!(find(&readings(|_, _| 0.0)), None);
        assert_eq!(find(&readings(|t, _| 0.01 + 1e-4 * t)), None, "drift");
        assert_eq!(find(&readings(|_, axis| [0.02, 0.05][axis])), None, "each joint its own lag");
    }

    #[test]
    fn a_late_step_is_found_though_the_fit_left_its_readings_out() {
        let mut all = readings(|t, _| if t > 36.0 { -0.05 } else { 0.0 });
        all.iter_mut().filter(|r| r.t_s > 36.0).for_each(|r| r.kept = false);
        let found = find(&all).unwrap();
        assert!((found.at_s - 36.0).abs() < 1.0 && (found.by_s + 0.05).abs() < 5e-3, "{found:?}");
    }
}
